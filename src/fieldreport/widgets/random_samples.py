"""Random samples of a power of x₁ + x₂: the exact error that limits least squares."""

from __future__ import annotations

from typing import Any

from fieldreport.experiments.methods.power_sampling import Params, best_linear_rms

MOST = 8
"""The largest power that the page offers."""


def data() -> dict[str, Any]:
    """Return the exact distance of each power from the affine functions, and the experiment's ε."""
    powers = range(1, MOST + 1)
    return {
        "powers": MOST,
        "epsilon": Params().epsilon,
        "queries": Params().queries,
        "best": [float(f"{best_linear_rms(n):.6g}") for n in powers],
    }
