"""Vertices in one place: exactly, or within a tolerance."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from fieldrecon._sheets import labels

_DIRECTION = (0.5773, 0.6217, 0.5293)
"""Along no axis, diagonal or edge that is likely: few points that differ are at one height."""
_CROWDED = 64  # neighbours of each vertex within the tolerance, on average, that are too many


def welded(points: np.ndarray, tolerance: float = 0.0) -> np.ndarray:
    """For each point (n, 3), the first one in its place.

    Points not farther apart than the tolerance are in one place, and so are chains of them.

    Raises
    ------
    ValueError
        If the tolerance would weld nearly everything.
    """
    first = _equal(points)
    if tolerance == 0:
        return first
    places = np.flatnonzero(first == np.arange(len(points)))
    pairs = _near(points[places], tolerance)
    return first if len(pairs) == 0 else joined(len(points), places[pairs])[first]


def _equal(points: np.ndarray) -> np.ndarray:
    """For each point the first one that is equal to it."""
    height = _heights(points)
    order = np.argsort(height, kind="stable")
    level = height[order[1:]] == height[order[:-1]]
    tied = np.concatenate([[False], level]) | np.concatenate([level, [False]])
    some = order[tied]
    some = some[np.lexsort((some, *points[some].T))]
    starts = np.ones(len(some), dtype=bool)
    starts[1:] = (points[some[1:]] != points[some[:-1]]).any(axis=1)
    first = np.arange(len(points))
    first[some] = some[starts][np.cumsum(starts) - 1] if len(some) else some
    return first


def _near(points: np.ndarray, tolerance: float) -> np.ndarray:
    """Pairs (k, 2) of different points not farther apart than the tolerance."""
    height = _heights(points)
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


def _heights(points: np.ndarray) -> np.ndarray:
    x, y, z = (c * a for c, a in zip(points.T, _DIRECTION, strict=True))
    return x + y + z


def joined(n: int, links: np.ndarray) -> np.ndarray:
    """For each number below n, the least one that links (l, 2) join it to."""
    label = labels(n, links)
    first = np.full(n, n)
    np.minimum.at(first, label, np.arange(n))
    return first[label]
