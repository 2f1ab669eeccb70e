"""Jets: functions at points with their gradients and perhaps their second derivatives.

A jet of functions of d variables is an array (c, ...) whose rows are the values, the d first
derivatives, and the d (d + 1)/2 second derivatives in the order of `upper_pairs`; c is 1, 1 + d, or
1 + d + d (d + 1)/2.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations_with_replacement

import numpy as np


def upper_pairs(d: int) -> list[tuple[int, int]]:
    """Pairs (k, l) of variables with k <= l: the entries of a symmetric matrix.

    >>> upper_pairs(2)
    [(0, 0), (0, 1), (1, 1)]
    """
    return list(combinations_with_replacement(range(d), 2))


def symmetric(entries: Sequence[np.ndarray] | np.ndarray, d: int) -> np.ndarray:
    """Symmetric matrices (..., d, d) from the entries (...) of `upper_pairs`."""
    matrix = np.empty((*entries[0].shape, d, d), dtype=entries[0].dtype)
    for entry, (k, j) in zip(entries, upper_pairs(d), strict=True):
        matrix[..., k, j] = matrix[..., j, k] = entry
    return matrix


def rows_of_jet(d: int, order: int) -> int:
    """Number of rows of a jet of derivatives up to this order, 0 to 2.

    >>> [rows_of_jet(3, order) for order in range(3)]
    [1, 4, 10]
    """
    return (1, 1 + d, 1 + d + d * (d + 1) // 2)[order]


def product(u: np.ndarray, v: np.ndarray, d: int) -> np.ndarray:
    """Jet of u v: u Dv + v Du, and u D^2 v + v D^2 u + Du Dv^T + Dv Du^T."""
    w = u[:1] * v
    w[1:] += v[:1] * u[1:]
    for row, (k, j) in _second(w, d):
        row += u[1 + k] * v[1 + j] + u[1 + j] * v[1 + k]
    return w


def quotient(u: np.ndarray, v: np.ndarray, d: int) -> np.ndarray:
    """Jet w of u / v: (Du - w Dv) / v, and (D^2 u - w D^2 v - Dw Dv^T - Dv Dw^T) / v."""
    w = u / v[:1]
    w[1:] -= w[:1] * v[1:] / v[:1]
    for row, (k, j) in _second(w, d):
        row -= (w[1 + k] * v[1 + j] + w[1 + j] * v[1 + k]) / v[0]
    return w


def composition(f: Sequence[np.ndarray], u: np.ndarray, d: int) -> np.ndarray:
    """Jet of f(u) from f, f' and f'' at u: f' Du, and f' D^2 u + f'' Du Du^T."""
    w = f[1] * u
    w[0] = f[0]
    for row, (k, j) in _second(w, d):
        row += f[2] * u[1 + k] * u[1 + j]
    return w


def _second(jet: np.ndarray, d: int) -> list[tuple[np.ndarray, tuple[int, int]]]:
    """The rows of second derivatives with their variables; none if the jet has none."""
    return list(zip(jet[1 + d :], upper_pairs(d), strict=False))
