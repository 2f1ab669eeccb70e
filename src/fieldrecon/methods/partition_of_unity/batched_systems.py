"""Stacks of small symmetric systems, solved by elimination or, if singular, by eigenvectors."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fieldrecon.methods.solvability import within_range
from fieldrecon.polynomials import EPS

COLUMNS = 16
"""Maximum number of right-hand sides solved at once with one factored matrix."""
FLAT = 1e14
"""Condition number from which on elimination returns only rounding."""
BALANCING = 10
"""Number of balancing steps; each halves the order of magnitude by which rows differ."""


def solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solutions (p, s, v) of symmetric systems (p, s, s), of least norm where one is singular.

    A further right-hand side of size one shows which systems are singular to rounding. They are
    solved by eigenvectors, without the small eigenvalues, which would only amplify rounding.
    """
    size = np.sqrt(np.einsum("pij,pij->p", matrix, matrix))
    within_range(size, "values of the kernel in a patch")
    probe = np.cos(np.arange(matrix.shape[1]))[None, :, None]
    probes = np.broadcast_to(probe, (len(matrix), *probe.shape[1:]))
    try:
        found = np.linalg.solve(matrix, np.concatenate([right, probes], axis=2))
    except np.linalg.LinAlgError:  # one is exactly singular, and NumPy solves all or none
        return _by_eigenvectors(matrix, right)
    flat = ~(np.abs(found[..., -1]).max(axis=1) * size <= FLAT)
    found = found[..., :-1]
    if flat.any():
        found[flat] = _by_eigenvectors(matrix[flat], right[flat])
    return found


def _by_eigenvectors(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    scale = _balance(matrix)
    balanced = scale[:, :, None] * matrix * scale[:, None, :]
    sigma, u = np.linalg.eigh(balanced)
    size = np.abs(sigma)
    kept = size > EPS * matrix.shape[1] / 4 * size.max(axis=1, keepdims=True)
    inverse = np.where(kept, 1.0, 0.0) / np.where(kept, sigma, 1.0)
    solution: np.ndarray = u @ (inverse[..., None] * (u.mT @ (scale[..., None] * right)))
    return scale[..., None] * solution


def _balance(matrix: np.ndarray) -> np.ndarray:
    """Factors (p, s) of rows and columns, after which the largest entry of each is about one.

    Kernels may be far larger than polynomials, which must not be mistaken for rounding (Ruiz 2001).
    """
    scale = np.ones(matrix.shape[:2])
    for _ in range(BALANCING):
        largest = np.abs(scale[:, :, None] * matrix * scale[:, None, :]).max(axis=2)
        scale /= np.sqrt(np.where(largest > 0, largest, 1.0))
    return scale


def batched_solve_grouped(
    solve: Callable[[np.ndarray, np.ndarray], np.ndarray],
    system: np.ndarray,
    right: np.ndarray,
    size: int,
    rows: int,
) -> np.ndarray:
    """Solutions (m, size) for the right-hand sides (m, s) of the systems with the indices (m,).

    `solve` takes systems (p,) and right-hand sides (p, s, COLUMNS) for them, `rows` systems at a
    time. Right-hand sides of one system are grouped, so that its matrix is factored once for many.
    """
    order = np.argsort(system, kind="stable")
    first = np.searchsorted(system[order], system[order])
    column = (np.arange(len(order)) - first) % COLUMNS
    stack = np.cumsum(column == 0) - 1
    begin = np.append(np.flatnonzero(column == 0), len(order))

    found = np.empty((len(right), size))
    for start in range(0, len(begin) - 1, rows):
        stacks = slice(start, min(start + rows, len(begin) - 1))
        part = slice(begin[stacks.start], begin[stacks.stop])
        columns = np.zeros((stacks.stop - start, right.shape[1], COLUMNS))
        entry = stack[part] - start, slice(None), column[part]
        columns[entry] = right[order[part]]
        found[order[part]] = solve(system[order[begin[stacks]]], columns)[entry]
    return found
