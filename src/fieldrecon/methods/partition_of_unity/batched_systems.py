"""Stacks of small saddle-point systems, solved by elimination or, if singular, by eigenvectors.

    [ A    P ]
    [ P^T  D ]

with A (k, k) symmetric, and D diagonal: one for each column of zeros of P, and zero otherwise.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fieldrecon._numerics.saddle_point import balancing
from fieldrecon.methods.solvability import within_range
from fieldrecon.polynomials import EPS

COLUMNS = 16
"""Maximum number of right-hand sides solved at once with one factored matrix."""
SMALL = 1e3 * EPS
"""Eigenvalue, relative to the size of the kernel's matrix, up to which it is only rounding."""
LARGE = 1e3
"""Ratio of kernels to polynomials at a query beyond which one step of refinement is needed."""
FLAT = 1e14
"""Condition number from which on elimination returns only rounding."""


def solved(matrix: np.ndarray, right: np.ndarray, k: int) -> np.ndarray:
    """Solutions (p, s, v) of saddle-point systems (p, s, s) whose first k rows are kernels.

    A further right-hand side of size one shows which systems are singular to rounding. It has all
    frequencies: along a line of sites, flat kernels are singular for the high ones only. Singular
    systems are solved by eigenvectors, without the small eigenvalues, which would only amplify
    rounding. Before, the rows and columns of an uneven diagonal are multiplied by the factors of
    `balancing`.
    """
    diagonal = matrix[:, range(k), range(k)]
    if np.ptp(diagonal, axis=1).any():  # as for data with smoothing of their own
        factors = np.ones((*matrix.shape[:2], 1))
        factors[:, :k, 0] = balancing(diagonal, matrix[:, 1:k, 0])
        return factors * _solved(factors * matrix * factors.mT, factors * right, k)
    return _solved(matrix, right, k)


def _solved(matrix: np.ndarray, right: np.ndarray, k: int) -> np.ndarray:
    size = np.sqrt(np.einsum("pij,pij->p", matrix, matrix))
    within_range(size, "values of the kernel in a patch")
    probe = np.cos(np.arange(matrix.shape[1]) ** 2)[None, :, None]
    probes = np.broadcast_to(probe, (len(matrix), *probe.shape[1:]))
    try:
        found = np.linalg.solve(matrix, np.concatenate([right, probes], axis=2))
    except np.linalg.LinAlgError:  # one is exactly singular, and NumPy solves all or none
        return _by_eigenvectors(matrix, right, k)
    flat = ~(np.abs(found[..., -1]).max(axis=1) * size <= FLAT)
    found = found[..., :-1]
    far = ~flat & _has_far_query(right, k)
    if far.any():
        found[far] += np.linalg.solve(matrix[far], right[far] - matrix[far] @ found[far])
    if flat.any():
        found[flat] = _by_eigenvectors(matrix[flat], right[flat], k)
    return found


def _has_far_query(right: np.ndarray, k: int) -> np.ndarray:
    """Systems (p,) whose kernels at a query are so large that rounding drowns the polynomials."""
    kernels, polynomials = (
        np.abs(part).max(axis=(1, 2), initial=0.0) for part in (right[:, :k], right[:, k:])
    )
    return (polynomials > 0) & (kernels > LARGE * polynomials)


def _by_eigenvectors(matrix: np.ndarray, right: np.ndarray, k: int) -> np.ndarray:
    """Solutions with P = Q R: the polynomials exactly, and kernels orthogonal to them by A.

    From P^T l = g and A l + P c = f follow, with N = I - Q Q^T and l_0 = Q R^-T g,

        l = l_0 + (N A N)^+ (f - A l_0),   R c = Q^T (f - A l).

    So polynomials are reproduced, and the constraints satisfied, however flat the kernel is, and
    however large beside the polynomials.
    """
    a, (q, r) = matrix[:, :k, :k], _factored(matrix, k)
    projected = _orthogonal(q, _orthogonal(q, a).mT)
    sigma, u = np.linalg.eigh(projected)
    # rounding is as large as that of A, of which the polynomials may take up nearly all
    kept = np.abs(sigma) > SMALL * np.linalg.norm(a, axis=(1, 2))[:, None]
    inverse = np.where(kept, 1.0, 0.0) / np.where(kept, sigma, 1.0)
    f, g = right[:, :k], right[:, k:]
    particular = q @ np.linalg.solve(r.mT, g)
    rest = _orthogonal(q, f - a @ particular)
    kernels = particular + _orthogonal(q, u @ (inverse[..., None] * (u.mT @ rest)))
    polynomials = np.linalg.solve(r, q.mT @ (f - a @ kernels))
    return np.concatenate([kernels, polynomials], axis=1)


def _factored(matrix: np.ndarray, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Factors Q (p, k, q) and R (p, q, q) of P; columns of zeros stay, and have R = 1 or -1."""
    q, r = np.linalg.qr(matrix[:, :, k:])
    return q[:, :k], r


def _orthogonal(q: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Columns of x less their parts in the columns of Q."""
    x = x - q @ (q.mT @ x)
    return x - q @ (q.mT @ x)


def leverages(matrix: np.ndarray, k: int) -> np.ndarray:
    """Leverages (p, k) of the sites in the least-squares polynomial of each patch."""
    return (_factored(matrix, k)[0] ** 2).sum(axis=2)


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
