"""Points that coincide: rows of an array that are equal in every coordinate; points in order."""

from __future__ import annotations

import numpy as np


def first_of_equal(points: np.ndarray) -> np.ndarray:
    """For each point (n, d), the index of the first point that is equal to it.

    >>> first_of_equal(np.array([[0.0, 1.0], [2.0, 3.0], [0.0, 1.0]])).tolist()
    [0, 1, 0]
    """
    height = heights(points)
    order = np.argsort(height)
    tied = order[_beside_equal(height[order])]
    first = np.arange(len(points))
    if len(tied):
        tied = tied[np.lexsort((tied, *points[tied].T))]
        new = np.append(True, (points[tied[1:]] != points[tied[:-1]]).any(axis=1))
        first[tied] = tied[new][np.cumsum(new) - 1]
    return first


def coincidence_labels(points: np.ndarray) -> np.ndarray:
    """Labels 0, 1, ... of the distinct points, in order of appearance, for each point (n, d).

    >>> coincidence_labels(np.array([[0.0, 1.0], [2.0, 3.0], [0.0, 1.0], [4.0, 5.0]])).tolist()
    [0, 1, 0, 2]
    """
    first = first_of_equal(points)
    return (np.cumsum(first == np.arange(len(first))) - 1)[first]


def by_position(points: np.ndarray) -> np.ndarray:
    """Indices that sort points (n, d) by the first coordinate, then by the second, and so on.

    That is `np.lexsort(points.T[::-1])`, in a fraction of its time: few coordinates are equal.

    >>> by_position(np.array([[1.0, 2.0], [0.0, 3.0], [1.0, 0.0]])).tolist()
    [1, 2, 0]
    """
    order = np.argsort(points[:, 0])
    beside = _beside_equal(points[order, 0])
    tied = order[beside]
    order[beside] = tied[np.lexsort((tied, *points[tied].T[::-1]))]
    return order


def _beside_equal(ordered: np.ndarray) -> np.ndarray:
    """Whether each of the sorted numbers (n,) is equal to the one before it or after it."""
    equal = ordered[1:] == ordered[:-1]
    beside = np.zeros(len(ordered), dtype=bool)
    beside[1:] |= equal
    beside[:-1] |= equal
    return beside


def heights(points: np.ndarray) -> np.ndarray:
    """Heights (n,) of points (n, d) along a line that few pairs of different points are normal to.

    Points at the same height are nearly always equal, so sorting by height finds the equal ones.
    """
    direction = np.cos(np.arange(points.shape[1]) + 0.9)  # no likely axis, diagonal or edge
    direction /= np.linalg.norm(direction)
    height = np.zeros(len(points))
    with np.errstate(over="ignore"):
        for axis, column in zip(direction, points.T, strict=True):
            height += axis * column  # BLAS might round the heights of equal points differently
    return height


def refuse_coincident(points: np.ndarray, message: str, some: np.ndarray | None = None) -> None:
    """Refuse coincident points; `{pairs}` in the message becomes the indices of some of them.

    With indices `some` in ascending order, only these points are compared.
    """
    some = np.arange(len(points)) if some is None else some
    first = first_of_equal(points[some])
    later = np.flatnonzero(first != np.arange(len(some)))
    if len(later):
        pairs = ", ".join(f"{some[first[j]]} and {some[j]}" for j in later[:5])
        more = f" and {len(later) - 5} more" if len(later) > 5 else ""
        raise ValueError(message.format(pairs=pairs + more))
