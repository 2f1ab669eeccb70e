"""Intersections of triangles beyond the corners they share: crossings, overlaps, T-junctions.

`close_pairs` finds the pairs that may intersect. Two triangles do not if a plane separates them:
one triangle is on one side, and the other, except for shared corners, strictly on the other side.
Three kinds of planes are tried: the planes of the triangles; the planes through an edge of one of
them along the axis nearest to its normal; and a plane across one of them at a shared corner.
`contacts` then decides by exact predicates how the triangles of each pair meet.

References
----------
Möller, A Fast Triangle-Triangle Intersection Test (1997); Guigue and Devillers, Fast and Robust
Triangle-Triangle Overlap Test Using Orientation Predicates (2003).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fieldrecon._core.chunks import Progress
from fieldrecon.triangles.bounding_volumes import BVH, intersecting_pairs
from fieldrecon.triangles.predicates import BOUND_2D, BOUND_3D, collinear, orient2d, orient3d

_NEXT = np.array([1, 2, 0])


def close_pairs(
    points: np.ndarray,
    triangles: np.ndarray,
    tolerance: float = 0.0,
    *,
    progress: Progress | None = None,
) -> np.ndarray:
    """Pairs (k, 2) of triangles that none of the planes separates.

    Parameters
    ----------
    points : (n, 3) ndarray
        The largest coordinate is near 1.
    triangles : (m, 3) ndarray of int
        Without degenerate ones. Points with the same index are the same point.
    tolerance : float
        Pairs are also reported if displacing the points so far could make them intersect.
    progress : callable, optional
        Called as progress(done, total).
    """
    corners = [points.take(triangles[:, c], axis=0) for c in range(3)]
    low = np.minimum(np.minimum(*corners[:2]), corners[2]) - tolerance
    high = np.maximum(np.maximum(*corners[:2]), corners[2]) + tolerance
    tree = BVH(low, high, low.min(axis=0))
    ordered = _Triangles(points, triangles.take(tree.order, axis=0), tolerance)
    pairs = tree.order[intersecting_pairs(tree, ordered.not_separated, progress=progress)]
    pairs.sort(axis=1)
    return pairs[np.lexsort(pairs.T[::-1])]


class _Triangles:
    """Triangles, by the last index, with precomputed normals, sizes and bounds of rounding."""

    def __init__(self, points: np.ndarray, triangles: np.ndarray, tolerance: float) -> None:
        self.tolerance = tolerance
        self.vertices = np.ascontiguousarray(triangles.T)
        self.corners = points.T[:, self.vertices].swapaxes(0, 1).copy()  # corner, axis, triangle
        u, v = self.corners[1] - self.corners[0], self.corners[2] - self.corners[0]
        left, right = u[[1, 2, 0]] * v[[2, 0, 1]], u[[2, 0, 1]] * v[[1, 2, 0]]
        self.normals = left - right
        self.terms = (np.abs(left) + np.abs(right)).sum(axis=0)
        self.sizes = np.maximum(np.abs(u), np.abs(v)).max(axis=0)

    def not_separated(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Return the pairs that no plane separates."""
        for separated in (self.by_plane_of_first, self.by_edge_of_first, self.by_corner_plane):
            for swap in (False, True):
                kept = ~(separated(j, i) if swap else separated(i, j))
                i, j = i[kept], j[kept]
        return np.column_stack([i, j])

    def by_plane_of_first(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
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
            bound += 12 * self.tolerance * (size + reach) ** 2  # exceeds the areas of the faces
            above &= shared | (distance > bound)
            below &= shared | (distance < -bound)
        return above | below

    def by_edge_of_first(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Whether the other corners of j lie strictly outside an edge of i in a projection.

        The projection is along the axis nearest to the normal of i.
        """
        normal = self.normals.take(i, axis=1)
        axis = np.abs(normal).argmax(axis=0)
        area = normal[axis, np.arange(len(i))]
        x, y = _NEXT[axis], _NEXT[_NEXT[axis]]
        ours, theirs = (
            [(self.corners[c, x, t], self.corners[c, y, t]) for c in range(3)] for t in (i, j)
        )
        same, separated = self.same_corners(i, j), np.zeros(len(i), dtype=bool)
        for e, f in ((0, 1), (1, 2), (2, 0)):
            outside = np.ones(len(i), dtype=bool)
            for c in range(3):
                shared = same[c][e] | same[c][f]
                outside &= shared | self._right_of(ours[e], ours[f], theirs[c], area)
            separated |= outside
        return separated & (np.abs(area) > BOUND_2D * self.terms[i])

    def by_corner_plane(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Whether they share one corner, and a plane through it across i separates them.

        The normal of the plane bisects the angle of i. In a flat fan with straight edges through
        the corner, no other plane separates opposite triangles.
        """
        same = self.same_corners(i, j)
        ours, theirs = (
            self._from_corner(np.logical_or.reduce(same, axis=k), t) for k, t in ((0, i), (1, j))
        )
        normal = sum(d / np.sqrt((d * d).sum(axis=0)) for d in ours)
        separated = same.sum(axis=(0, 1)) == 1
        for side, directions in ((1, ours), (-1, theirs)):
            for direction in directions:
                terms = normal * direction
                bound = BOUND_3D * np.abs(terms).sum(axis=0)
                bound += 4 * self.tolerance * np.abs(normal).sum(axis=0)
                separated &= side * terms.sum(axis=0) > bound
        return separated

    def _from_corner(self, chosen: np.ndarray, t: np.ndarray) -> list[np.ndarray]:
        """Edges (3, k) from the first chosen corner of each triangle to its other corners."""
        c = chosen.argmax(axis=0)
        start = self.corners[c, :, t].T
        return [self.corners[(c + step) % 3, :, t].T - start for step in (1, 2)]

    def same_corners(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Whether corners are the same vertex, as an array (corner of j, corner of i, pair)."""
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
_CHUNK = 2**15  # pairs at once; bounds the memory


@dataclass(frozen=True)
class Contacts:
    """How pairs of triangles meet in ways that no mesh may have.

    Parameters
    ----------
    crossing : (k,) ndarray of bool
        The triangles are not coplanar, and share a point inside one of them or inside an edge of
        each.
    overlapping : (k,) ndarray of bool
        The triangles are coplanar and share an area.
    corners_on_edges : (t, 3) ndarray of int
        A corner of one inside an edge of the other: the corner, and the ends of the edge.
    """

    crossing: np.ndarray
    overlapping: np.ndarray
    corners_on_edges: np.ndarray


def contacts(
    points: np.ndarray, triangles: np.ndarray, pairs: np.ndarray, tolerance: float = 0.0
) -> Contacts:
    """Determine how the triangles of each pair (k, 2) meet.

    An intersection that a displacement of the points by the tolerance could undo counts as a
    contact only; with the tolerance 0 the answer is exact. No triangle may be degenerate.
    """
    chunks = [
        _contacts(points, triangles, pairs[i : i + _CHUNK], tolerance)
        for i in range(0, max(len(pairs), 1), _CHUNK)
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
    overlapping = (
        coplanar & distinct & ~one.separated_by_edge(other) & ~other.separated_by_edge(one)
    )
    crossing = one.crossed_by(other, flat_one) | other.crossed_by(one, flat_other)
    on_edges = np.concatenate([one.corners_on_edges(other), other.corners_on_edges(one)])
    return crossing & ~coplanar, overlapping, on_edges


class _Side:
    """The first, or the second, triangles of the pairs."""

    def __init__(self, points: np.ndarray, triangles: np.ndarray, tolerance: float) -> None:
        self.vertices, self.tolerance = triangles, tolerance
        self.corners = points[triangles]
        normal = np.cross(
            self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0]
        )
        axis = np.abs(normal).argmax(axis=1)
        self._axes = np.column_stack([(axis + 1) % 3, (axis + 2) % 3])
        self._turn = orient2d(*(self.projected(self.corners[:, c]) for c in range(3)))

    def projected(self, points: np.ndarray) -> np.ndarray:
        """The two coordinates in which the triangles have the largest projected areas."""
        return np.take_along_axis(points, self._axes, axis=1)

    def shares(self, other: _Side) -> np.ndarray:
        """Whether the corners (k, 3) of the other triangles are corners of these."""
        return (other.vertices[:, :, None] == self.vertices[:, None]).any(axis=2)

    def above(self, other: _Side) -> np.ndarray:
        """Signs (k, 3): the side of these planes on which the corners of the others lie."""
        a, b, c = (self.corners[:, k] for k in range(3))
        signs = [orient3d(a, b, c, other.corners[:, k], tolerance=self.tolerance) for k in range(3)]
        return np.where(self.shares(other), 0, np.stack(signs, axis=1))

    def inside(self, points: np.ndarray) -> np.ndarray:
        """Signs (k, 3) of points in the plane: positive on the inner side of each edge."""
        a, point = self.corners, self.projected(points)
        signs = [
            orient2d(
                self.projected(a[:, e]), self.projected(a[:, f]), point, tolerance=self.tolerance
            )
            for e, f in _EDGES
        ]
        return np.stack(signs, axis=1) * self._turn[:, None]

    def separated_by_edge(self, other: _Side) -> np.ndarray:
        """Whether the others, which are coplanar, lie on or outside the line of an edge."""
        signs = [self._inside_or_shared(other, c) for c in range(3)]
        return (np.maximum(np.maximum(signs[0], signs[1]), signs[2]) <= 0).any(axis=1)

    def crossed_by(self, other: _Side, sides: np.ndarray) -> np.ndarray:
        """Whether an edge or a corner of the others meets the interior of these."""
        shared = self.shares(other)
        signs = [self._inside_or_shared(other, c) for c in range(3)]
        crossed = np.zeros(len(sides), dtype=bool)
        for c in range(3):
            crossed |= (sides[:, c] == 0) & ~shared[:, c] & (signs[c] > 0).all(axis=1)
        for e, f in _EDGES:
            p, q = other.corners[:, e], other.corners[:, f]
            pierced = np.flatnonzero(sides[:, e] * sides[:, f] < 0)
            crossed[pierced] |= self._pierced_by_line(pierced, p, q)
            within = np.flatnonzero(
                (sides[:, e] == 0) & (sides[:, f] == 0) & ~(shared[:, e] & shared[:, f])
            )
            apart = (np.maximum(signs[e], signs[f]) <= 0).any(axis=1)[within]
            crossed[within] |= ~apart & ~self._on_one_side_of_line(within, p, q)
        return crossed

    def corners_on_edges(self, other: _Side) -> np.ndarray:
        """Corners (t, 3) of the others inside edges of these, with the ends of the edges."""
        shared, found = self.shares(other), []
        for c in range(3):
            point = other.corners[:, c]
            for e, f in _EDGES:
                a, b = self.corners[:, e], self.corners[:, f]
                between = ((a < point) & (point < b)) | ((b < point) & (point < a))
                on = np.flatnonzero(~shared[:, c] & between.any(axis=1))
                on = on[collinear(a[on], b[on], point[on], tolerance=self.tolerance)]
                on = on[_within(a[on], b[on], point[on])]
                ends = np.sort(self.vertices[on][:, [e, f]], axis=1)
                found.append(np.column_stack([other.vertices[on, c], ends]))
        return np.concatenate(found)

    def _inside_or_shared(self, other: _Side, c: int) -> np.ndarray:
        """`inside` of a corner of the others; 0 for the edges that end at this corner."""
        signs = self.inside(other.corners[:, c])
        same = self.vertices == other.vertices[:, c, None]
        return np.where(same | np.roll(same, -1, axis=1), 0, signs)

    def _pierced_by_line(self, rows: np.ndarray, p: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Whether a line that crosses the plane does so inside the triangle or inside an edge."""
        p, q, corners = p[rows], q[rows], self.corners[rows]
        signs = np.stack(
            [
                orient3d(p, q, corners[:, e], corners[:, f], tolerance=self.tolerance)
                for e, f in _EDGES
            ]
        )
        one_side = (signs >= 0).all(axis=0) | (signs <= 0).all(axis=0)
        return one_side & ((signs == 0).sum(axis=0) <= 1)

    def _on_one_side_of_line(self, rows: np.ndarray, p: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Whether the triangle lies on one side of a line in its plane, or touches the line."""
        start, end = (np.take_along_axis(x[rows], self._axes[rows], axis=1) for x in (p, q))
        corners = [
            np.take_along_axis(self.corners[rows, c], self._axes[rows], axis=1) for c in range(3)
        ]
        signs = np.stack(
            [orient2d(start, end, corner, tolerance=self.tolerance) for corner in corners]
        )
        return (signs.min(axis=0) >= 0) | (signs.max(axis=0) <= 0)


def _within(a: np.ndarray, b: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Whether points on lines lie between a and b, by the coordinate that differs most."""
    axis = np.abs(b - a).argmax(axis=1)[:, None]
    a, b, point = (np.take_along_axis(x, axis, axis=1)[:, 0] for x in (a, b, point))
    return ((a < point) & (point < b)) | ((b < point) & (point < a))
