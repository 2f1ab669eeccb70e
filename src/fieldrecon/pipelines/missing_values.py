"""Numbers that mark missing values, such as -9999: extreme, repeated, and far from all others."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from fieldrecon._core import validation as valid

_FAR, _APART, _BESIDE = 3.0, 1.0, 0.1
"""Distances from the other values, in ranges of these: of any number that is repeated, of a usual
mark that occurs once, and of one that is repeated."""
_USUAL = {float(f"{'9' * k}") for k in range(2, 8)} | {32767.0, 32768.0, 1e20, 1e30}
"""Absolute values of usual marks."""
_LEAST_OTHERS = 3


class Suspect(NamedTuple):
    """A number that may mark missing values, how often it occurs, and the range of the others."""

    value: float
    times: int
    others: tuple[float, float]


def as_missing(missing: Any) -> tuple[float, ...]:
    """The numbers that mark missing values: none, one, or several.

    Raises
    ------
    ValueError
        If one is not a number.
    """
    if missing is None:
        return ()
    numbers = valid.as_numbers(np.atleast_1d(missing), "missing", complex_allowed=False)
    return tuple(numbers.ravel().tolist())


def suspects(values: np.ndarray) -> list[Suspect]:
    """Numbers at the ends of the values (n,) that may mark missing values.

    Examples
    --------
    >>> suspects(np.array([0.5, -9999, 0.7, -9999, 0.9, 1.0]))
    [Suspect(value=-9999.0, times=2, others=(0.5, 1.0))]
    >>> suspects(np.array([0.0, 0.0, 0.5, 0.7, 1.0, 1.0]))
    []

    The nodes of a lattice are equally far apart, so 99 is no mark here:

    >>> suspects(np.tile([0.0, 33.0, 66.0, 99.0], 4))
    []
    """
    distinct, counts = np.unique(values, return_counts=True)
    found: list[tuple[float, int]] = []
    low, high = 0, len(distinct) - 1
    while high - low >= _LEAST_OTHERS:
        inner = distinct[high - 1] - distinct[low + 1]
        step = np.median(np.diff(distinct[low + 1 : high]))
        gaps = {low: distinct[low + 1] - distinct[low], high: distinct[high] - distinct[high - 1]}
        end = max(gaps, key=lambda k: gaps[k])
        usual, repeated = abs(distinct[end]) in _USUAL, counts[end] > 1
        far = (_BESIDE if repeated else _APART) if usual else _FAR
        if not gaps[end] > max(far * inner, 2 * step) or not (usual or repeated):
            break
        found.append((float(distinct[end]), int(counts[end])))
        low, high = (low + 1, high) if end == low else (low, high - 1)
    others = float(distinct[low]), float(distinct[high])
    return [Suspect(value, times, others) for value, times in found]
