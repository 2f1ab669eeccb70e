"""How two triangles meet beyond the corners they share: crossing, overlapping, corner on edge.

References
----------
Möller, A Fast Triangle-Triangle Intersection Test (1997); Guigue and Devillers, Fast and Robust
Triangle-Triangle Overlap Test Using Orientation Predicates (2003).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fieldrecon._predicates import collinear, orient2d, orient3d

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
