"""Moving least squares of Franke's function: sites, exact and noisy data, and a sweep over ε."""

from __future__ import annotations

from typing import Any

import numpy as np

from fieldrecon.datasets.synthetic import franke, jittered_grid
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldreport.experiments.methods.weight_shapes import count_extrema

CELLS = 16
"""Cells along a side of the square, with a site in each; the spacing h is the side of a cell."""
SIDE = 48
"""Points along a side of the grid on which the page evaluates the field."""
JITTER, NOISE, SEED = 0.6, 0.05, 1
RATIOS = np.geomspace(10**-1.3, 10**0.7, 9)
DIGITS = 5


def data() -> dict[str, Any]:
    """Return sites, data, and error, leave-one-out error and ψ for both degrees against ε/h."""
    sites = np.round(jittered_grid(CELLS, 2, JITTER, SEED), DIGITS)
    exact = np.round(franke(sites), DIGITS)
    noise = NOISE * np.random.default_rng(SEED).standard_normal(len(sites))
    fields = {"exact": exact, "noisy": np.round(exact + noise, DIGITS)}
    return {
        "sites": sites.tolist(),
        "fields": {name: values.tolist() for name, values in fields.items()},
        "side": SIDE,
        "spacing": 1 / CELLS,
        "ratios": [float(f"{ratio:.6g}") for ratio in RATIOS],
        "extrema": count_extrema(franke(grid())),
        "sweeps": [sweep(sites, fields, degree) for degree in (0, 1)],
    }


def grid() -> np.ndarray:
    """Return the centres of the pixels of the relief, shape (SIDE, SIDE, 2)."""
    ticks = (np.arange(SIDE) + 0.5) / SIDE
    return np.stack(np.meshgrid(ticks, ticks), axis=-1)


def measures(
    sites: np.ndarray, values: np.ndarray, degree: int, ratio: float
) -> dict[str, np.ndarray]:
    """Return the root mean square errors and the mean ψ for each column of the values."""
    method = MovingLeastSquares(sites, inverse_square(ratio / CELLS), degree)
    x = grid()
    wrong = method.field(values)(x) - franke(x)[..., None]
    return {
        "error": np.sqrt(np.mean(wrong**2, axis=(0, 1))),
        "leaveOneOut": np.sqrt(np.mean(leave_one_out(method, values) ** 2, axis=0)),
        "psi": method.objective(values, x).mean(axis=(0, 1)),
    }


def sweep(sites: np.ndarray, fields: dict[str, np.ndarray], degree: int) -> dict[str, Any]:
    """Return the curves of the measures, for each set of data."""
    values = np.stack(list(fields.values()), axis=1)
    found = [measures(sites, values, degree, ratio) for ratio in RATIOS]
    return {
        name: {key: [float(f"{at[key][k]:.4g}") for at in found] for key in found[0]}
        for k, name in enumerate(fields)
    }
