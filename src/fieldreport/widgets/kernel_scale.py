"""Kernel and scale on points of a line: error and condition number against the scale."""

from __future__ import annotations

from typing import Any

import numpy as np

from fieldrecon.datasets.synthetic import jittered_grid
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import multiquadric, polyharmonic
from fieldrecon.kernels.positive_definite import gaussian, matern, wendland
from fieldrecon.methods.rbf import RBF

SITES, JITTER, SEED, DIGITS = 14, 0.5, 3, 4
QUERIES = 201
SCALES = np.geomspace(0.01, 10, 31)
REFUSED = None
"""What a curve contains where the library refuses the system as too ill-conditioned."""


def kernel(name: str, scale: float) -> Radial:
    """Return a kernel by the name that the page uses; r³ has no scale."""
    made: dict[str, Radial] = {
        "gaussian": gaussian(scale),
        "multiquadric": multiquadric(scale),
        "matern": matern(2.5, scale),
        "wendland": wendland(3, 1, scale),
        "cubic": polyharmonic(3),
    }
    return made[name]


NAMES = ("gaussian", "multiquadric", "matern", "wendland", "cubic")


def truth(x: np.ndarray) -> np.ndarray:
    """Return the function that is sampled, sin 5x + exp(−((x − 0.6)/0.12)²)."""
    t = x[..., 0]
    return np.sin(5 * t) + np.exp(-(((t - 0.6) / 0.12) ** 2))


def data() -> dict[str, Any]:
    """Return the sites, and the curves of error and condition number for each kernel."""
    sites = np.round(jittered_grid(SITES, 1, JITTER, SEED), DIGITS)
    return {
        "sites": sites[:, 0].tolist(),
        "queries": QUERIES,
        "scales": [float(f"{s:.4g}") for s in SCALES],
        "curves": {name: _curves(sites, name) for name in NAMES},
    }


def error_and_condition(sites: np.ndarray, name: str, scale: float) -> tuple[float | None, float]:
    """Return the root mean square error, None where refused, and the condition number."""
    method = RBF(sites, kernel(name, scale))
    size = np.abs(np.linalg.eigvalsh(method.matrix()))
    condition = float(size.max() / max(size.min(), np.finfo(float).tiny))
    x = np.linspace(0, 1, QUERIES)[:, None]
    try:
        wrong = method.field(truth(sites))(x) - truth(x)
    except np.linalg.LinAlgError:
        return REFUSED, condition
    return float(np.sqrt(np.mean(wrong**2))), condition


def _curves(sites: np.ndarray, name: str) -> dict[str, list[float | None]]:
    found = [error_and_condition(sites, name, scale) for scale in SCALES]
    return {
        "error": [None if e is REFUSED else float(f"{e:.3g}") for e, _ in found],
        # beyond 10^17 a computed condition number is rounding
        "condition": [min(float(f"{c:.3g}"), 1e17) for _, c in found],
    }
