"""Pairs of triangles that may meet beyond the corners they share, out of all pairs.

Two triangles do not if a plane has one of them on its one side and the other, shared corners
excepted, strictly on the other side. Three kinds of planes are tried: those of the triangles; those
through an edge of one of them along the axis nearest to its normal; and those across one of them at
a corner that they share.

How two triangles meet beyond the corners they share: crossing, overlapping, corner on edge.

References
----------
Möller, A Fast Triangle-Triangle Intersection Test (1997); Guigue and Devillers, Fast and Robust
Triangle-Triangle Overlap Test Using Orientation Predicates (2003).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fieldrecon._core.chunks import Progress
from fieldrecon.triangles.bounding_volumes import BoxTree, overlapping
from fieldrecon.triangles.predicates import BOUND_2D, BOUND_3D, collinear, orient2d, orient3d

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


_EDGES = ((0, 1), (1, 2), (2, 0))
_AT_ONCE = 2**15  # pairs; bounds the memory


@dataclass(frozen=True)
class Contacts:
    """What pairs of triangles have in common that no mesh may have.

    Parameters
    ----------
    crossing : (k,) ndarray of bool
        They share a point inside one of them, or inside an edge of each, and lie in two planes.
    overlapping : (k,) ndarray of bool
        They lie in one plane and share an area.
    corners_on_edges : (t, 3) ndarray of int
        A corner of one inside an edge of the other: the corner, and the ends of the edge.
    """

    crossing: np.ndarray
    overlapping: np.ndarray
    corners_on_edges: np.ndarray


def contacts(
    points: np.ndarray, triangles: np.ndarray, pairs: np.ndarray, tolerance: float = 0.0
) -> Contacts:
    """How the triangles of each pair (k, 2) meet.

    What moving points by the tolerance could undo counts as touching; with the tolerance 0 the
    answer is exact. No triangle is degenerate.
    """
    chunks = [
        _contacts(points, triangles, pairs[i : i + _AT_ONCE], tolerance)
        for i in range(0, max(len(pairs), 1), _AT_ONCE)
    ]
    crossing, overlapping, on_edges = (np.concatenate(part) for part in zip(*chunks, strict=True))
    return Contacts(crossing, overlapping, np.unique(on_edges, axis=0))


def _contacts(
    points: np.ndarray, triangles: np.ndarray, pairs: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    one, other = (_Side(points, triangles[pairs[:, s]], tolerance) for s in (0, 1))
    flat_one, flat_other = one.above(other), other.above(one)
    coplanar = (flat_one == 0).all(axis=1) | (flat_other == 0).all(axis=1)
    distinct = ~one.shares(other).all(axis=1)
    overlapping = coplanar & distinct & ~one.beside(other) & ~other.beside(one)
    crossing = one.crossed_by(other, flat_one) | other.crossed_by(one, flat_other)
    on_edges = np.concatenate([one.corners_on_edges(other), other.corners_on_edges(one)])
    return crossing & ~coplanar, overlapping, on_edges


class _Side:
    """The triangles on one side of the pairs."""

    def __init__(self, points: np.ndarray, triangles: np.ndarray, tolerance: float) -> None:
        self.vertices, self.tolerance = triangles, tolerance
        self.corners = points[triangles]
        normal = np.cross(
            self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0]
        )
        axis = np.abs(normal).argmax(axis=1)
        self._seen = np.column_stack([(axis + 1) % 3, (axis + 2) % 3])
        self._turn = orient2d(*(self.seen(self.corners[:, c]) for c in range(3)))

    def seen(self, places: np.ndarray) -> np.ndarray:
        """The two coordinates in which the triangles have the largest areas."""
        return np.take_along_axis(places, self._seen, axis=1)

    def shares(self, other: _Side) -> np.ndarray:
        """Whether the corners (k, 3) of the others are corners of these."""
        return (other.vertices[:, :, None] == self.vertices[:, None]).any(axis=2)

    def above(self, other: _Side) -> np.ndarray:
        """Signs (k, 3): on which side of these planes the corners of the others lie."""
        a, b, c = (self.corners[:, k] for k in range(3))
        signs = [orient3d(a, b, c, other.corners[:, k], tolerance=self.tolerance) for k in range(3)]
        return np.where(self.shares(other), 0, np.stack(signs, axis=1))

    def inside(self, places: np.ndarray) -> np.ndarray:
        """Signs (k, 3) of places in the plane: positive to the inner side of each edge."""
        a, place = self.corners, self.seen(places)
        signs = [
            orient2d(self.seen(a[:, e]), self.seen(a[:, f]), place, tolerance=self.tolerance)
            for e, f in _EDGES
        ]
        return np.stack(signs, axis=1) * self._turn[:, None]

    def beside(self, other: _Side) -> np.ndarray:
        """Whether an edge has the others, which lie in these planes, on its outer side or on it."""
        signs = [self._inside_or_shared(other, c) for c in range(3)]
        return (np.maximum(np.maximum(signs[0], signs[1]), signs[2]) <= 0).any(axis=1)

    def crossed_by(self, other: _Side, sides: np.ndarray) -> np.ndarray:
        """Whether an edge or a corner of the others meets the inside of these."""
        shared = self.shares(other)
        signs = [self._inside_or_shared(other, c) for c in range(3)]
        crossed = np.zeros(len(sides), dtype=bool)
        for c in range(3):
            crossed |= (sides[:, c] == 0) & ~shared[:, c] & (signs[c] > 0).all(axis=1)
        for e, f in _EDGES:
            p, q = other.corners[:, e], other.corners[:, f]
            pierced = np.flatnonzero(sides[:, e] * sides[:, f] < 0)
            crossed[pierced] |= self._met_by_line(pierced, p, q)
            within = np.flatnonzero(
                (sides[:, e] == 0) & (sides[:, f] == 0) & ~(shared[:, e] & shared[:, f])
            )
            apart = (np.maximum(signs[e], signs[f]) <= 0).any(axis=1)[within]
            crossed[within] |= ~apart & ~self._beside_line(within, p, q)
        return crossed

    def corners_on_edges(self, other: _Side) -> np.ndarray:
        """Corners (t, 3) of the others inside edges of these, with the ends of the edges."""
        shared, found = self.shares(other), []
        for c in range(3):
            place = other.corners[:, c]
            for e, f in _EDGES:
                a, b = self.corners[:, e], self.corners[:, f]
                between = ((a < place) & (place < b)) | ((b < place) & (place < a))
                on = np.flatnonzero(~shared[:, c] & between.any(axis=1))
                on = on[collinear(a[on], b[on], place[on], tolerance=self.tolerance)]
                on = on[_within(a[on], b[on], place[on])]
                ends = np.sort(self.vertices[on][:, [e, f]], axis=1)
                found.append(np.column_stack([other.vertices[on, c], ends]))
        return np.concatenate(found)

    def _inside_or_shared(self, other: _Side, c: int) -> np.ndarray:
        """Like `inside`, of a corner of the others; exactly on the edges that end there."""
        signs = self.inside(other.corners[:, c])
        same = self.vertices == other.vertices[:, c, None]
        return np.where(same | np.roll(same, -1, axis=1), 0, signs)

    def _met_by_line(self, rows: np.ndarray, p: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Whether a line that crosses the plane does so inside, or inside an edge."""
        p, q, corners = p[rows], q[rows], self.corners[rows]
        signs = np.stack(
            [
                orient3d(p, q, corners[:, e], corners[:, f], tolerance=self.tolerance)
                for e, f in _EDGES
            ]
        )
        one_side = (signs >= 0).all(axis=0) | (signs <= 0).all(axis=0)
        return one_side & ((signs == 0).sum(axis=0) <= 1)

    def _beside_line(self, rows: np.ndarray, p: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Whether a line in the plane has the triangle on one side, edges and corners on it."""
        start, end = (np.take_along_axis(x[rows], self._seen[rows], axis=1) for x in (p, q))
        corners = [
            np.take_along_axis(self.corners[rows, c], self._seen[rows], axis=1) for c in range(3)
        ]
        signs = np.stack(
            [orient2d(start, end, corner, tolerance=self.tolerance) for corner in corners]
        )
        return (signs.min(axis=0) >= 0) | (signs.max(axis=0) <= 0)


def _within(a: np.ndarray, b: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Whether places on lines lie between a and b, by the coordinate that differs most."""
    axis = np.abs(b - a).argmax(axis=1)[:, None]
    a, b, place = (np.take_along_axis(x, axis, axis=1)[:, 0] for x in (a, b, place))
    return ((a < place) & (place < b)) | ((b < place) & (place < a))
