"""Error norms, orders of convergence and orders of magnitude."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fieldreport.framework.orders_of_magnitude import order_of_magnitude as order_of_magnitude

ROUNDING = 1e-13
"""Errors below this, of fields of size one, hold no digit of an order."""


def rms(vectors: np.ndarray) -> float:
    """Return the root of the mean squared length of vectors (..., d)."""
    return float(np.sqrt((vectors**2).sum(axis=-1).mean()))


def middle(vectors: np.ndarray) -> float:
    """Return the median length of vectors (..., d), which a few outliers do not change."""
    return float(np.median(np.linalg.norm(vectors, axis=-1)))


def order(sizes: ArrayLike, errors: ArrayLike) -> float:
    """Return the order p of errors that decrease like hᵖ: the slope of log error against log h.

    Parameters
    ----------
    sizes, errors : array_like
        Positive, in any order; two different sizes or more.

    Raises
    ------
    ValueError
        If fewer than two sizes differ, a size is not positive and finite, or an error is not
        above rounding, of a field of size one.

    Examples
    --------
    >>> order([0.1, 0.05, 0.025], [0.04, 0.01, 0.0025])
    2.0
    >>> order([0.1], [0.04])
    Traceback (most recent call last):
    ...
    ValueError: an order of convergence needs two different sizes or more; got 0.1
    """
    sizes, errors = np.asarray(sizes, dtype=float), np.asarray(errors, dtype=float)
    for name, values, least in (("sizes", sizes, 0.0), ("errors", errors, ROUNDING)):
        if not (np.isfinite(values) & (values > least)).all():
            raise ValueError(
                f"an order of convergence needs {name} above {least:g}; got {_listed(values)}"
            )
    if len(np.unique(sizes)) < 2:
        raise ValueError(
            f"an order of convergence needs two different sizes or more; got {_listed(sizes)}"
        )
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0].round(12)) + 0.0  # never -0.0


def _listed(values: np.ndarray) -> str:
    return ", ".join(f"{x:g}" for x in values)
