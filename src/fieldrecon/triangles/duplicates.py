"""Duplicate vertices, triangles and edges: equal, or coincident within a tolerance."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from fieldrecon._core.duplicates import first_of_equal, heights
from fieldrecon.triangles.half_edges import HalfEdges, component_labels

_MAX_NEIGHBORS = 64  # within the tolerance of a vertex, on average


def merged_vertices(points: np.ndarray, tolerance: float = 0.0) -> np.ndarray:
    """Return for each point (n, 3) the index of the first point that it is merged with.

    Points no farther apart than the tolerance are merged, and so are chains of such points.

    Raises
    ------
    ValueError
        If the tolerance would merge most of the points.
    """
    first = first_of_equal(points)
    if tolerance == 0:
        return first
    distinct = np.flatnonzero(first == np.arange(len(points)))
    pairs = _near_pairs(points[distinct], tolerance)
    return component_minimum(len(points), distinct[pairs])[first]


def _near_pairs(points: np.ndarray, tolerance: float) -> np.ndarray:
    """Pairs (k, 2) of different points no farther apart than the tolerance."""
    height = heights(points)
    order = np.argsort(height)
    reach = 2 * tolerance + 8 * np.finfo(float).eps * np.abs(height).max(initial=0.0)
    stop = np.searchsorted(height[order], height[order] + reach, side="right")
    count = stop - np.arange(len(order)) - 1
    if count.sum() > _MAX_NEIGHBORS * len(points):  # the projection does not separate these points
        return _near_pairs_by_tree(points, tolerance)
    one = np.repeat(np.arange(len(order)), count)
    other = one + 1 + np.arange(len(one)) - np.repeat(np.cumsum(count) - count, count)
    pairs = order[np.column_stack([one, other])]
    apart = points[pairs[:, 0]] - points[pairs[:, 1]]
    return pairs[np.einsum("ki,ki->k", apart, apart) <= tolerance**2]


def _near_pairs_by_tree(points: np.ndarray, tolerance: float) -> np.ndarray:
    tree = KDTree(points)
    if tree.count_neighbors(tree, tolerance) > _MAX_NEIGHBORS * len(points):
        raise ValueError(
            f"tolerance {tolerance:g} is too large for these points: it would merge most of them"
        )
    return tree.query_pairs(tolerance, output_type="ndarray")


def component_minimum(n: int, links: np.ndarray) -> np.ndarray:
    """Return for each of n nodes the smallest node that links (l, 2) connect it to."""
    label = component_labels(n, links)
    first = np.full(n, n)
    np.minimum.at(first, label, np.arange(n))
    return first[label]


def has_three_corners(triangles: np.ndarray) -> np.ndarray:
    """Return whether each triangle (m, 3) has three different vertices."""
    a, b, c = triangles.T
    return (a != b) & (b != c) & (c != a)


def first_duplicates(triangles: np.ndarray, n: int) -> np.ndarray:
    """Return for each triangle (m, 3) on n vertices the first one with the same vertices."""
    rows = np.sort(triangles, axis=1)
    if n**3 < 2**63:
        key = (rows[:, 0] * n + rows[:, 1]) * n + rows[:, 2]
        order = np.argsort(key)
        again = key[order[1:]] == key[order[:-1]]
    else:
        order = np.lexsort(rows.T)
        again = (rows[order[1:]] == rows[order[:-1]]).all(axis=1)
    first = np.arange(len(rows))
    if again.any():
        starts = np.flatnonzero(np.concatenate([[True], ~again]))
        size = np.diff(starts, append=len(order))
        first[order] = np.repeat(np.minimum.reduceat(order, starts), size)
    return first


def rows_in(rows: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Return whether each row is among the known ones."""
    _, number = np.unique(np.concatenate([known, rows]), axis=0, return_inverse=True)
    number = number.ravel()
    return np.isin(number[len(known) :], number[: len(known)])


def coincident_vertices(
    half_edges: HalfEdges, merged: np.ndarray, used: np.ndarray
) -> dict[str, np.ndarray]:
    """Find coincident vertices, and pairs of boundary edges that coincide.

    Vertices are duplicates if merging them joins coincident edges. At other coincident vertices
    the surface only touches itself, and merging them would make a bow-tie.

    Parameters
    ----------
    sheets : HalfEdges
    merged : (n,) ndarray of int
        For each vertex the first that coincides with it.
    used : (u,) ndarray of int
        The vertices of the triangles.
    """
    shared = np.bincount(merged[used], minlength=len(merged)) > 1
    edges = half_edges.edges[shared[merged[half_edges.edges]].any(axis=1)]
    pairs = _edge_pairs(edges, merged)
    links = np.concatenate([pairs[:, [0, 2]], pairs[:, [1, 3]]])
    same = component_minimum(len(merged), links)
    least = np.full(len(merged), len(merged))
    np.minimum.at(least, merged[used], used)
    again = used[same[used] != used]
    touching = used[(same[used] == used) & (least[merged[used]] != used)]
    free = np.column_stack(
        [half_edges.start[half_edges.free_sides], half_edges.end[half_edges.free_sides]]
    )
    return {
        "duplicate_vertices": np.column_stack([again, same[again]]),
        "touching_vertices": np.column_stack([touching, least[merged[touching]]]),
        "free_edge_pairs": _edge_pairs(free[shared[merged[free]].any(axis=1)], merged),
    }


def _edge_pairs(edges: np.ndarray, merged: np.ndarray) -> np.ndarray:
    """Pairs (k, 4) of coincident edges; their coincident ends are in the same order."""
    over = merged[edges[:, 0]] > merged[edges[:, 1]]
    edges = np.where(over[:, None], edges[:, ::-1], edges)
    ends = merged[edges]
    order = np.lexsort((edges[:, 1], edges[:, 0], ends[:, 1], ends[:, 0]))
    edges, ends = edges[order], ends[order]
    same = (ends[1:] == ends[:-1]).all(axis=1)
    return np.column_stack([edges[:-1][same], edges[1:][same]])
