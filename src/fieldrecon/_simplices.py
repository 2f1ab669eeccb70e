"""Many simplices at once: volume, normal and circumcentre from differences, whatever the unit.

The determinant of d edges that span a simplex is the same, but for its sign, whichever d they are.
The shortest lose the least to cancellation, so slivers are measured along them.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

FLAT = 32 * np.finfo(float).eps
"""Volume over product of the spanning edges below which rounding decides about the sign."""

_SUSPECT = 1e-2  # above it any spanning edges will do


def units(edges: np.ndarray) -> np.ndarray:
    """Powers of two (m,) near the size of each simplex; 1 for one that is a point."""
    size = np.abs(edges).max(axis=(1, 2), initial=0.0)
    return np.ldexp(1.0, np.frexp(np.where(size > 0, size, 1.0))[1] - 1)


def spanning_edges(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges that span each simplex, the shortest where it is nearly flat.

    Parameters
    ----------
    corners : (m, k + 1, d) ndarray
        Simplices of dimension k, in a unit near their size, one corner at the origin.

    Returns
    -------
    edges : (m, k, d) ndarray
        Differences of corners, so ordered that their orientation is that of the simplex.
    middles : (m, k, d) ndarray
        The middle of each edge.
    suspect : (m,) ndarray of bool
        Whether the simplex was looked at closely.
    """
    edges = corners[:, 1:] - corners[:, :1]
    middles = (corners[:, 1:] + corners[:, :1]) / 2
    suspect = ~(volumes(edges) > _SUSPECT * np.prod(np.linalg.norm(edges, axis=2), axis=1))
    closely = corners[suspect]
    pairs = list(combinations(range(corners.shape[1]), 2))
    lengths = np.stack([np.linalg.norm(closely[:, j] - closely[:, i], axis=1) for i, j in pairs], 1)
    trees = _spanning_trees(corners.shape[1])
    with np.errstate(divide="ignore"):
        logs = np.log(lengths)
    total = np.stack([logs[:, [pairs.index(p) for p in tree]].sum(axis=1) for tree in trees], 1)
    shortest = np.array(trees)[np.argmin(total, axis=1)]
    row = np.arange(len(closely))[:, None]
    start, end = closely[row, shortest[..., 0]], closely[row, shortest[..., 1]]
    edges[suspect], middles[suspect] = end - start, (end + start) / 2
    return edges, middles, suspect


def _spanning_trees(corners: int) -> list[tuple[tuple[int, int], ...]]:
    """Sets of edges that connect all corners, each in an order of positive orientation."""
    trees = []
    for tree in combinations(combinations(range(corners), 2), corners - 1):
        incidence = np.zeros((corners - 1, corners))
        for row, (i, j) in enumerate(tree):
            incidence[row, [i, j]] = -1, 1
        orientation = round(np.linalg.det(incidence[:, 1:]))
        if orientation:
            trees.append(tree if orientation > 0 else (*tree[1::-1], *tree[2:]))
    return trees


def determinants(edges: np.ndarray) -> np.ndarray:
    """Determinant of each square matrix of edges (m, d, d), d = 2 or 3."""
    if edges.shape[2] == 2:
        return edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]
    return np.einsum("mi,mi->m", edges[:, 0], np.cross(edges[:, 1], edges[:, 2]))


def volumes(edges: np.ndarray) -> np.ndarray:
    """Volume (m,) of the parallelepiped over k edges (m, k, d), d = 2 or 3."""
    k, d = edges.shape[1:]
    if k == 1:
        return np.linalg.norm(edges[:, 0], axis=1)
    if k == d:
        return np.abs(determinants(edges))
    return np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)


def circumcenters(corners: np.ndarray) -> np.ndarray:
    """Circumcentre (m, d) of each simplex, (m, k + 1, d) with k = 1, 2 or 3.

    For each spanning edge t with middle q, t · (c - q) = 0; and c lies in the simplex's plane.

    References
    ----------
    Shewchuk, "Lecture Notes on Geometric Robustness" (2013), section 3.11.
    """
    origin = corners[:, 0]
    unit = units(corners[:, 1:] - corners[:, :1])
    local = (corners - origin[:, None]) / unit[:, None, None]
    if corners.shape[1] == 2:
        return origin + local[:, 1] / 2 * unit[:, None]
    edges, middles, _ = spanning_edges(local)
    right = np.einsum("mki,mki->mk", edges, middles)
    if edges.shape[1] < edges.shape[2]:
        normal = np.cross(edges[:, 0], edges[:, 1])
        edges = np.concatenate([edges, normal[:, None]], axis=1)
        right = np.concatenate([right, np.zeros((len(right), 1))], axis=1)
    center = np.einsum("mk,mki->mi", right, _cofactors(edges)) / determinants(edges)[:, None]
    return origin + center * unit[:, None]


def _cofactors(a: np.ndarray) -> np.ndarray:
    """Cofactors of each matrix (m, d, d): Σ_k a_k · c_k = d det a, and a_j · c_k = 0, j ≠ k."""
    if a.shape[2] == 2:
        turned = np.stack([a[..., 1], -a[..., 0]], axis=-1)
        return np.stack([turned[:, 1], -turned[:, 0]], axis=1)
    return np.stack(
        [np.cross(a[:, 1], a[:, 2]), np.cross(a[:, 2], a[:, 0]), np.cross(a[:, 0], a[:, 1])], axis=1
    )
