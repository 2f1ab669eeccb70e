"""Vertices in one place: exactly, or within a tolerance.

Triangles that repeat one another, edges and vertices that are one to the eye.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from fieldrecon._core.duplicates import first_of_equal, heights
from fieldrecon.triangles.half_edges import Sheets, labels

_CROWDED = 64  # neighbours of each vertex within the tolerance, on average, that are too many


def welded(points: np.ndarray, tolerance: float = 0.0) -> np.ndarray:
    """For each point (n, 3), the first one in its place.

    Points not farther apart than the tolerance are in one place, and so are chains of them.

    Raises
    ------
    ValueError
        If the tolerance would weld nearly everything.
    """
    first = first_of_equal(points)
    if tolerance == 0:
        return first
    places = np.flatnonzero(first == np.arange(len(points)))
    pairs = _near(points[places], tolerance)
    return first if len(pairs) == 0 else joined(len(points), places[pairs])[first]


def _near(points: np.ndarray, tolerance: float) -> np.ndarray:
    """Pairs (k, 2) of different points not farther apart than the tolerance."""
    height = heights(points)
    order = np.argsort(height)
    reach = 2 * tolerance + 8 * np.finfo(float).eps * np.abs(height).max()
    upto = np.searchsorted(height[order], height[order] + reach, side="right")
    count = upto - np.arange(len(order)) - 1
    if count.sum() > _CROWDED * len(points):  # heights tell little here
        return _near_by_tree(points, tolerance)
    one = np.repeat(np.arange(len(order)), count)
    other = one + 1 + np.arange(len(one)) - np.repeat(np.cumsum(count) - count, count)
    pairs = order[np.column_stack([one, other])]
    apart = points[pairs[:, 0]] - points[pairs[:, 1]]
    return pairs[np.einsum("ki,ki->k", apart, apart) <= tolerance**2]


def _near_by_tree(points: np.ndarray, tolerance: float) -> np.ndarray:
    tree = KDTree(points)
    if tree.count_neighbors(tree, tolerance) > _CROWDED * len(points):
        raise ValueError(
            f"tolerance {tolerance:g} is too large for these points: it would weld most of them"
        )
    return tree.query_pairs(tolerance, output_type="ndarray")


def joined(n: int, links: np.ndarray) -> np.ndarray:
    """For each number below n, the least one that links (l, 2) join it to."""
    label = labels(n, links)
    first = np.full(n, n)
    np.minimum.at(first, label, np.arange(n))
    return first[label]


def three_corners(triangles: np.ndarray) -> np.ndarray:
    """Whether each triangle (m, 3) has three different vertices."""
    a, b, c = triangles.T
    return (a != b) & (b != c) & (c != a)


def first_alike(triangles: np.ndarray, n: int) -> np.ndarray:
    """For each triangle (m, 3) of numbers below n, the first one with the same vertices."""
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
    """Whether each row is among the known ones."""
    _, number = np.unique(np.concatenate([known, rows]), axis=0, return_inverse=True)
    number = number.ravel()
    return np.isin(number[len(known) :], number[: len(known)])


def coincident(sheets: Sheets, place: np.ndarray, used: np.ndarray) -> dict[str, np.ndarray]:
    """Vertices in one place, and seams that are not sewn.

    To weld some of them joins edges that are one to the eye: these are duplicates. Other sheets
    only touch at the vertex, and to weld them would make a bow-tie.

    Parameters
    ----------
    sheets : Sheets
    place : (n,) ndarray of int
        For each vertex the first in its place.
    used : (u,) ndarray of int
        The vertices of the triangles.
    """
    shared = np.bincount(place[used], minlength=len(place)) > 1
    edges = sheets.edges[shared[place[sheets.edges]].any(axis=1)]
    pairs = _edge_pairs(edges, place)
    links = np.concatenate([pairs[:, [0, 2]], pairs[:, [1, 3]]])
    same = joined(len(place), links) if len(links) else np.arange(len(place))
    least = np.full(len(place), len(place))
    np.minimum.at(least, place[used], used)
    again = used[same[used] != used]
    touching = used[(same[used] == used) & (least[place[used]] != used)]
    free = np.column_stack([sheets.start[sheets.free_sides], sheets.end[sheets.free_sides]])
    return {
        "duplicate_vertices": np.column_stack([again, same[again]]),
        "touching_vertices": np.column_stack([touching, least[place[touching]]]),
        "free_edge_pairs": _edge_pairs(free[shared[place[free]].any(axis=1)], place),
    }


def _edge_pairs(edges: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Pairs (k, 4) of edges in one place, the ends in one place in the same order."""
    over = place[edges[:, 0]] > place[edges[:, 1]]
    edges = np.where(over[:, None], edges[:, ::-1], edges)
    ends = place[edges]
    order = np.lexsort((edges[:, 1], edges[:, 0], ends[:, 1], ends[:, 0]))
    edges, ends = edges[order], ends[order]
    same = (ends[1:] == ends[:-1]).all(axis=1)
    return np.column_stack([edges[:-1][same], edges[1:][same]])
