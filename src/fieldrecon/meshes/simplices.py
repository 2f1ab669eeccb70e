"""Volumes, normals and circumcentres of many simplices at once, from differences of corners.

The determinant of d edges that span a simplex does not depend on the edges, up to its sign. The
shortest edges lose the least to cancellation, so slivers are measured along them.
"""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

_FLAT = 32 * np.finfo(float).eps
"""Volume relative to the product of the spanning edges below which rounding decides the sign."""

_SUSPECT = 1e-2  # relative volume above which any spanning edges suffice


def units(edges: np.ndarray) -> np.ndarray:
    """Powers of two (m,) near the size of each simplex; 1 for one that is a point."""
    # simplices last: numpy is slow along a short axis
    size = np.abs(edges).reshape(len(edges), -1).T.copy().max(axis=0, initial=0.0)
    return np.ldexp(1.0, np.frexp(np.where(size > 0, size, 1.0))[1] - 1)


def spanning_edges(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges that span each simplex, the shortest where it is nearly flat.

    Parameters
    ----------
    corners : (m, k + 1, d) ndarray
        Simplices of dimension k, in a unit near their size, one corner at the origin.

    Returns
    -------
    edges : (m, k, d) ndarray
        Differences of corners, in an order with the orientation of the simplex.
    middles : (m, k, d) ndarray
        The middle of each edge.
    """
    edges = corners[:, 1:] - corners[:, :1]
    middles = (corners[:, 1:] + corners[:, :1]) / 2
    closely = ~(volumes(edges) > _SUSPECT * np.prod(lengths(edges), axis=1))
    start, end = _shortest_tree(corners[closely])
    edges[closely], middles[closely] = end - start, (end + start) / 2
    return edges, middles


def _shortest_tree(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Start and end (m, k, d) of k edges that span each simplex and have the least product."""
    trees = _spanning_trees(corners.shape[1])
    with np.errstate(divide="ignore"):
        products = [
            sum(np.log(lengths(corners[:, j] - corners[:, i])) for i, j in tree) for tree in trees
        ]
    shortest = np.array(trees)[np.argmin(products, axis=0)]
    row = np.arange(len(corners))[:, None]
    return corners[row, shortest[..., 0]], corners[row, shortest[..., 1]]


def _spanning_trees(corners: int) -> list[tuple[tuple[int, int], ...]]:
    """Spanning trees of the edges, each in an order of positive orientation."""
    trees = []
    for tree in combinations(combinations(range(corners), 2), corners - 1):
        incidence = np.zeros((corners - 1, corners))
        for row, (i, j) in enumerate(tree):
            incidence[row, [i, j]] = -1, 1
        orientation = round(np.linalg.det(incidence[:, 1:]))
        if orientation:
            trees.append(tree if orientation > 0 else (*tree[1::-1], *tree[2:]))
    return trees


def signed_volumes(
    corners: np.ndarray, rounding: float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Volume of each simplex (m, d + 1, d) with its sign, and whether it is flat.

    Flat means that rounding decides the sign: rounding of the computation and, if given, of the
    coordinates.

    Parameters
    ----------
    corners : (m, d + 1, d) ndarray
    rounding : float
        Largest error of a coordinate.

    Returns
    -------
    volumes : (m,) ndarray
        In the d-th power of the unit.
    unit : (m,) ndarray
        A power of two near the size of each simplex.
    flat : (m,) ndarray of bool
    """
    local, unit = _local(corners)
    edges, _ = spanning_edges(local)
    volume = determinants(edges)
    flat = np.abs(volume) <= _FLAT * np.prod(lengths(edges), axis=1)
    if rounding:
        step = np.minimum(8 * rounding / unit, 1e3)  # inverts any simplex; its cube is a number
        flat |= np.abs(volume) <= _change(edges, step)
    return volume / math.factorial(edges.shape[1]), unit, flat


def _change(edges: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Bound (m,) on the change of each determinant if the edges (m, d, d) change by a step (m,).

    It is the sum of products of d vectors, each an edge or a step, that contain a step. A product
    of two edges is the area that they span: of long edges nearly on one line it is small.
    """
    change = step * lengths(_cofactors(edges)).sum(axis=1)
    if edges.shape[2] == 3:
        change += step**2 * lengths(edges).sum(axis=1)
    return change + step ** edges.shape[2]


def _local(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The simplices with their first corner at the origin, in units of their size; the units."""
    edges = corners - corners[:, :1]
    unit = units(edges)
    return edges / unit[:, None, None], unit


def lengths(edges: np.ndarray) -> np.ndarray:
    """Length of each vector (..., d)."""
    return np.sqrt(np.einsum("...i,...i->...", edges, edges))


def determinants(edges: np.ndarray) -> np.ndarray:
    """Determinant of each square matrix of edges (m, d, d), d = 2 or 3."""
    if edges.shape[2] == 2:
        return edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]
    return np.einsum("mi,mi->m", edges[:, 0], np.cross(edges[:, 1], edges[:, 2]))


def volumes(edges: np.ndarray) -> np.ndarray:
    """Volume (m,) of the parallelepiped over k edges (m, k, d), d = 2 or 3."""
    k, d = edges.shape[1:]
    if k == 1:
        return lengths(edges[:, 0])
    if k == d:
        return np.abs(determinants(edges))
    return lengths(np.cross(edges[:, 0], edges[:, 1]))


def normals(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit normal of each simplex (m, d, d) of dimension d - 1, its measure, and the unit.

    The normal lies to the right of a segment; seen from its tip, the corners of a triangle are
    anticlockwise. The measure is in the (d-1)-th power of the unit.
    """
    local, unit = _local(corners)
    edges, _ = spanning_edges(local)
    if edges.shape[1] == 1:
        vectors = np.stack([edges[:, 0, 1], -edges[:, 0, 0]], axis=1)
    else:
        vectors = np.cross(edges[:, 0], edges[:, 1])
    size = lengths(vectors)
    return vectors / size[:, None], size / math.factorial(edges.shape[1]), unit


def centroids(corners: np.ndarray) -> np.ndarray:
    """Mean (m, d) of the corners of each simplex."""
    return corners[:, 0] + (corners[:, 1:] - corners[:, :1]).sum(axis=1) / corners.shape[1]


def circumcenters(corners: np.ndarray) -> np.ndarray:
    """Circumcentre (m, d) of each simplex, (m, k + 1, d) with k = 1, 2 or 3.

    For each spanning edge t with midpoint q, t · (c - q) = 0, and c lies in the plane of the
    simplex.

    References
    ----------
    Shewchuk, "Lecture Notes on Geometric Robustness" (2013), section 3.11.
    """
    origin = corners[:, 0]
    local, unit = _local(corners)
    if corners.shape[1] == 2:
        return origin + local[:, 1] / 2 * unit[:, None]
    edges, middles = spanning_edges(local)
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
        rotated = np.stack([a[..., 1], -a[..., 0]], axis=-1)
        return np.stack([rotated[:, 1], -rotated[:, 0]], axis=1)
    return np.stack(
        [np.cross(a[:, 1], a[:, 2]), np.cross(a[:, 2], a[:, 0]), np.cross(a[:, 0], a[:, 1])], axis=1
    )
