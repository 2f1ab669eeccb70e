"""Error norms and orders of convergence."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def rms(vectors: np.ndarray) -> float:
    """Return the root of the mean squared length of vectors (..., d)."""
    return float(np.sqrt((vectors**2).sum(axis=-1).mean()))


def middle(vectors: np.ndarray) -> float:
    """Return the median length of vectors (..., d), which a few outliers do not change."""
    return float(np.median(np.linalg.norm(vectors, axis=-1)))


def order(sizes: ArrayLike, errors: ArrayLike) -> float:
    """Return the order p of errors that decrease like hᵖ: the slope of log error against log h.

    Examples
    --------
    >>> order([0.1, 0.05, 0.025], [0.04, 0.01, 0.0025])
    2.0
    """
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0].round(12))
