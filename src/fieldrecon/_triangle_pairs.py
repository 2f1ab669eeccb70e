"""Pairs of triangles that may meet beyond the corners they share, out of all pairs.

Two triangles do not if a plane has one of them on its one side and the other, shared corners
excepted, strictly on the other side. Three kinds of planes are tried: those of the triangles; those
through an edge of one of them along the axis nearest to its normal; and those across one of them at
a corner that they share.
"""

from __future__ import annotations

import numpy as np

from fieldrecon._chunks import Progress
from fieldrecon._overlaps import BoxTree, overlapping
from fieldrecon._predicates import BOUND_2D, BOUND_3D

_NEXT = np.array([1, 2, 0])


def close_pairs(
    points: np.ndarray,
    triangles: np.ndarray,
    tolerance: float = 0.0,
    progress: Progress | None = None,
) -> np.ndarray:
    """Pairs (k, 2) of triangles that none of the planes parts.

    Parameters
    ----------
    points : (n, 3) ndarray
        Their largest coordinate is near 1.
    triangles : (m, 3) ndarray of int
        None of them degenerate. Points with the same number are the same point.
    tolerance : float
        Pairs that a plane would not part if points moved so far are kept.
    progress : callable, optional
        Called with what is done and the total.
    """
    corners = [points.take(triangles[:, c], axis=0) for c in range(3)]
    low = np.minimum(np.minimum(*corners[:2]), corners[2]) - tolerance
    high = np.maximum(np.maximum(*corners[:2]), corners[2]) + tolerance
    tree = BoxTree(low, high, low.min(axis=0))
    ordered = _Triangles(points, triangles.take(tree.order, axis=0), tolerance)
    pairs = tree.order[overlapping(tree, ordered.not_parted, progress=progress)]
    pairs.sort(axis=1)
    return pairs[np.lexsort(pairs.T[::-1])]


class _Triangles:
    """Triangles, the last index counting them, with what the planes need."""

    def __init__(self, points: np.ndarray, triangles: np.ndarray, tolerance: float) -> None:
        self.tolerance = tolerance
        self.vertices = np.ascontiguousarray(triangles.T)
        self.corners = points.T[:, self.vertices].swapaxes(0, 1).copy()  # corner, axis, triangle
        u, v = self.corners[1] - self.corners[0], self.corners[2] - self.corners[0]
        left, right = u[[1, 2, 0]] * v[[2, 0, 1]], u[[2, 0, 1]] * v[[1, 2, 0]]
        self.normals = left - right
        self.terms = (np.abs(left) + np.abs(right)).sum(axis=0)
        self.sizes = np.maximum(np.abs(u), np.abs(v)).max(axis=0)

    def not_parted(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Those of the pairs that no plane parts."""
        for parted in (self.by_own_plane, self.beside, self.opposite):
            for swap in (False, True):
                kept = ~(parted(j, i) if swap else parted(i, j))
                i, j = i[kept], j[kept]
        return np.column_stack([i, j])

    def by_own_plane(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Whether the other corners of j lie strictly on one side of the plane of i."""
        normal, first = self.normals.take(i, axis=1), self.corners[0].take(i, axis=1)
        terms, reach = self.terms[i], self.sizes[i]
        same = self.same_corners(i, j)
        above, below = np.ones((2, len(i)), dtype=bool)
        for c in range(3):
            w = self.corners[c].take(j, axis=1) - first
            distance = normal[0] * w[0] + normal[1] * w[1] + normal[2] * w[2]
            size = np.maximum(np.maximum(abs(w[0]), abs(w[1])), abs(w[2]))
            bound, shared = BOUND_3D * terms * size, same[c].any(axis=0)
            bound += 12 * self.tolerance * (size + reach) ** 2  # more than the faces' areas allow
            above &= shared | (distance > bound)
            below &= shared | (distance < -bound)
        return above | below

    def beside(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Whether the other corners of j lie strictly outside of an edge of i, seen along an axis.

        It is the axis nearest to the normal of i.
        """
        normal = self.normals.take(i, axis=1)
        axis = np.abs(normal).argmax(axis=0)
        area = normal[axis, np.arange(len(i))]
        x, y = _NEXT[axis], _NEXT[_NEXT[axis]]
        ours, theirs = (
            [(self.corners[c, x, t], self.corners[c, y, t]) for c in range(3)] for t in (i, j)
        )
        same, parted = self.same_corners(i, j), np.zeros(len(i), dtype=bool)
        for e, f in ((0, 1), (1, 2), (2, 0)):
            outside = np.ones(len(i), dtype=bool)
            for c in range(3):
                shared = same[c][e] | same[c][f]
                outside &= shared | self._right_of(ours[e], ours[f], theirs[c], area)
            parted |= outside
        return parted & (np.abs(area) > BOUND_2D * self.terms[i])

    def opposite(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Whether they share one corner, and lie on either side of a plane across that of i.

        Its normal halves the angle of i there. In a flat fan, where edges go straight on through
        the corner, no other plane parts triangles that face each other.
        """
        same = self.same_corners(i, j)
        ours, theirs = (
            self._from_corner(np.logical_or.reduce(same, axis=k), t) for k, t in ((0, i), (1, j))
        )
        normal = sum(d / np.sqrt((d * d).sum(axis=0)) for d in ours)
        parted = same.sum(axis=(0, 1)) == 1
        for side, directions in ((1, ours), (-1, theirs)):
            for direction in directions:
                terms = normal * direction
                bound = BOUND_3D * np.abs(terms).sum(axis=0)
                bound += 4 * self.tolerance * np.abs(normal).sum(axis=0)
                parted &= side * terms.sum(axis=0) > bound
        return parted

    def _from_corner(self, chosen: np.ndarray, t: np.ndarray) -> list[np.ndarray]:
        """Edges (3, k) from the first chosen corner of each triangle to the two others."""
        c = chosen.argmax(axis=0)
        start = self.corners[c, :, t].T
        return [self.corners[(c + step) % 3, :, t].T - start for step in (1, 2)]

    def same_corners(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Which corner of j is which of i, (corner of j, corner of i, pair)."""
        ours, theirs = self.vertices.take(i, axis=1), self.vertices.take(j, axis=1)
        return theirs[:, None] == ours[None]

    def _right_of(self, a: tuple, b: tuple, c: tuple, area: np.ndarray) -> np.ndarray:
        """Whether points c are on the right of the lines from a to b, if the area is positive."""
        u, v = (b[0] - a[0], b[1] - a[1]), (c[0] - a[0], c[1] - a[1])
        left, right = u[0] * v[1], u[1] * v[0]
        bound = BOUND_2D * (abs(left) + abs(right))
        if self.tolerance:
            bound += 2 * self.tolerance * (abs(u[0]) + abs(u[1]) + abs(v[0]) + abs(v[1]))
        return (right - left) * np.sign(area) > bound
