"""Local least squares where the data determine the value but perhaps not the whole polynomial.

The first coefficients of a fit are *estimable* when every solution of least squares has the same:
when no null vector of the matrix has a part in them. Then the solution of least norm gives them.
"""

from __future__ import annotations

import numpy as np

from fieldrecon._weighted_fits import by_elimination, coefficient_weights
from fieldrecon.polynomials import EPS

LARGEST_WEIGHT = 1e8
"""Weights beyond this turn the rounding of the data into errors of half the digits."""

# C b may differ from the unit matrix by this after elimination; the rest takes a stabler way.
ROUNDING = 1e-13


def estimable_weights(b: np.ndarray, w: np.ndarray, rows: int) -> np.ndarray:
    """First rows of C where they are estimable, for many fits min_c sum_i w_i^2 (b_i^T c - f_i)^2.

    Parameters
    ----------
    b : (m, k, q) ndarray
        Rows of each fit, of size one: its variables in a local frame.
    w : (m, k) ndarray
        Weights, the largest of each fit one; a row of weight zero does not count.
    rows : int
        How many coefficients are wanted.

    Returns
    -------
    (m, rows, k) ndarray
        C, so that C f are the first coefficients; nan where they are not estimable.
    """
    a = w[..., None] * b
    solution, safe = by_elimination(a.mT @ a, rows)
    c = (a @ solution).mT * w[:, None, :]
    # pivots that are small one after the other lose more than each; what C b gives tells how much
    lost = c @ b - np.eye(rows, b.shape[2])
    risky = np.flatnonzero(~safe | (np.einsum("mrq,mrq->m", lost, lost) > ROUNDING**2))
    if len(risky):
        c[risky] = _by_singular_values(np.where(w[risky, :, None] > 0, b[risky], 0), w[risky], rows)
    return c


def _by_singular_values(b: np.ndarray, w: np.ndarray, rows: int) -> np.ndarray:
    """The same by B = U S V^T: with c = V S^-1 y the matrix U of the unknowns y has full rank.

    Which singular values vanish is a matter of the sites, not of the weights.
    """
    m, k, q = b.shape
    b = np.concatenate([b, np.zeros((m, max(q - k, 0), q))], axis=1)
    norms = np.linalg.norm(b, axis=1)
    norms = np.where(norms > 0, norms, 1.0)
    u, s, vt = np.linalg.svd(b / norms[:, None, :], full_matrices=False)
    tolerance = 4 * EPS * max(k, q)
    null = s <= tolerance * s[:, :1]
    leak = np.linalg.norm(np.where(null[..., None], vt[..., :rows], 0.0), axis=1)
    estimable = (leak <= LARGEST_WEIGHT * tolerance).all(axis=1)
    c = np.full((m, rows, k), np.nan)
    rank = (~null).sum(axis=1)
    for r in np.unique(rank[estimable]):
        of = np.flatnonzero(estimable & (rank == r))
        y = coefficient_weights(u[of, :k, :r], w[of], r, np.zeros(len(of)))
        whole = (vt[of, :r].mT / s[of, None, :r]) @ y / norms[of, :, None]
        first = whole[:, :rows]
        # one step of refinement: weights that differ much cost digits of the other coefficients
        c[of] = first + (np.eye(rows, q) - first @ b[of, :k]) @ whole
    return c
