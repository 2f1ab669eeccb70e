"""Barycentric coordinates of convex polygons and polyhedra, after Wachspress and Warren."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from concurrent.futures import Executor
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, report_all, rows_of
from fieldrecon._numerics.jets import rows_of_jet, symmetric
from fieldrecon.barycentric.polytope import KIND, ROUNDINGS, Polytope, hanging_vertices
from fieldrecon.barycentric.wachspress import ProductForm
from fieldrecon.polynomials import EPS, Frame, resolution
from fieldrecon.reconstruction import Reconstruction


class ConvexCoordinates(Reconstruction):
    """Coordinates of a convex polytope: weights of its corners from heights below its faces.

    The sites are the corners. The coordinates reproduce linear fields and interpolate at the
    corners. They are positive inside. Outside they may be negative, and they have a pole where
    their common denominator vanishes.

    A subclass sets `points`, `_form` and `_unit`, and measures the heights in that unit.
    """

    degree = 1
    interpolates = True
    _form: ProductForm
    _unit: float
    _nearness = EPS  # distance from a corner, in units, up to which its own weight is one

    @property
    def _corner_points(self) -> np.ndarray:
        """The points to which the weights of the form belong."""
        return self.points

    @abstractmethod
    def _heights(self, x: np.ndarray) -> np.ndarray:
        """Heights (f, m) of queries (m, d) below the faces, times the lengths of the normals."""

    def _weight_rows(self, x: np.ndarray) -> np.ndarray:
        w = np.empty((self._form.n, len(x)))
        for part in self._parts(len(x), 1):
            lost = self._form.weights(self._heights(x[part]), out=w[:, part])
            if lost.any():
                self._decide(x, np.flatnonzero(lost) + part.start, w)
        return w.T

    def _gradient_weight_rows(self, x: np.ndarray) -> tuple[np.ndarray, ...]:
        d = x.shape[1]
        g = np.empty((d, self._form.n, len(x)))
        for part in self._parts(len(x), 1 + d):
            gradients, lost = self._form.derivatives(self._heights(x[part]), 1)
            if lost.any():
                self._decide(x, np.flatnonzero(lost) + part.start)
            g[:, :, part] = gradients / self._unit
        return tuple(matrix.T for matrix in g)

    def _hessian_rows(self, x: np.ndarray, prepared: np.ndarray) -> np.ndarray:
        d = x.shape[1]
        rows = rows_of_jet(d, 2)
        entries = np.empty((rows - 1 - d, len(x), prepared.shape[1]), dtype=prepared.dtype)
        for part in self._parts(len(x), rows):
            derivatives, lost = self._form.derivatives(self._heights(x[part]), 2)
            if lost.any():
                self._decide(x, np.flatnonzero(lost) + part.start)
            entries[:, part] = np.einsum("enm,nv->emv", derivatives[d:], prepared)
        return symmetric(entries, d) / self._unit / self._unit

    def _leave_one_out(self, values: np.ndarray, progress: Progress | None) -> np.ndarray:  # noqa: ARG002
        raise TypeError(
            "coordinates have no leave-one-out residuals: each corner lies outside the polytope of "
            "the other corners, where coordinates may have a pole and predict nothing"
        )

    def _decide(self, x: np.ndarray, queries: np.ndarray, w: np.ndarray | None = None) -> None:
        """Set the weights at corners where more than d faces meet; refuse any other query."""
        for k in queries:
            distance = np.abs(self._corner_points / self._unit - x[k] / self._unit).max(axis=1)
            i = int(distance.argmin())
            at_corner = self._form.crowded[i] and distance[i] <= self._nearness
            where = f"({valid.format_point(x[k])})"
            if at_corner and w is not None:
                w[:, k] = np.arange(len(w)) == i
            elif at_corner:
                raise ValueError(
                    f"the coordinates have no gradient at the corner {where}, where "
                    f"more than {x.shape[1]} faces meet"
                )
            else:
                raise np.linalg.LinAlgError(
                    f"the coordinates have no value at {where}: the weights of the corners "
                    f"cancel there, as they can outside a convex {KIND[x.shape[1]]}"
                )

    def _parts(self, m: int, arrays: int) -> Iterator[slice]:
        rows = rows_of(8 * (self._form.numbers_per_query + self._form.n) * arrays)
        return (slice(start, min(start + rows, m)) for start in range(0, m, rows))

    def _chunk_rows(self, columns: int) -> int:
        d = self.points.shape[1]
        return rows_of(8 * (self._form.numbers_per_query + self._form.n + d * columns))


class BarycentricCoordinates(ConvexCoordinates):
    """Barycentric coordinates of a convex polygon or polyhedron, w_i = c_i / sum_j c_j.

    c_i(x) = vol_i prod_{faces a not at i} h_a(x),   h_a(x) = n_a^T (p_a - x),

    where p_a is a corner on face a, and vol_i = |det(n_a, ...)| over the faces at corner i. That is
    the quotient vol_i / prod_{faces a at i} h_a(x) times the product of all heights. The only
    division is by the sum, so the weights are exact on faces, edges and corners, and accurate
    close to them. Where more than three faces meet, vol_i / prod h_a becomes the volume of the cone
    over the facet of the polar dual, the limit of the coordinates of polyhedra with that corner
    split.

    They are positive inside and reproduce linear fields everywhere. Outside they may be negative,
    and where the sum vanishes (on a curve or surface beyond the polytope) they have a pole.

    A vertex of a polygon inside an edge (a hanging vertex) has the limit of its coordinate as it
    moves onto the edge: on the edge it is linear from vertex to vertex, and elsewhere zero, since
    vol_i vanishes. Linear fields are reproduced, but fields with other values at the vertex are not
    continuous at that edge. On a face of a polyhedron that limit depends on the direction, and such
    a vertex is refused.

    Parameters
    ----------
    vertices : (n, d) array_like
        Corners of the polytope, d = 2 or 3, in any order. Faces with more than three corners must
        be flat up to rounding. In the plane, also vertices inside an edge.
    executor : concurrent.futures.Executor, optional
        Accepted by all methods; this one has nothing to split.
    progress : callable, optional
        Called once, as progress(n, n), when the method is made.

    Raises
    ------
    ValueError
        If a vertex is repeated, or is not a corner of the convex hull; if d is not 2 or 3; for a
        gradient on an edge with inner vertices.
    numpy.linalg.LinAlgError
        If the vertices lie on a line or in a plane; later, for a query at a pole.

    References
    ----------
    Erleben, Field Reconstruction, p. 27-31; Wachspress, A Rational Finite Element Basis (1975);
    Warren, Schaefer, Hirani and Desbrun, Barycentric coordinates for convex sets (2007).

    Examples
    --------
    >>> square = BarycentricCoordinates([[0, 0], [1, 0], [1, 1], [0, 1]])
    >>> square.weights([[0.5, 0.25], [1.0, 0.25]])
    array([[0.375, 0.375, 0.125, 0.125],
           [0.   , 0.75 , 0.25 , 0.   ]])
    >>> square.field([0, 0, 1, 0]).gradient([0.5, 0.25])
    array([0.25, 0.5 ])
    """

    def __init__(
        self,
        vertices: ArrayLike,
        *,
        executor: Executor | None = None,  # noqa: ARG002 - as for all methods
        progress: Progress | None = None,
    ) -> None:
        self.points = valid.as_points(vertices, "vertices")
        n, d = self.points.shape
        if d not in (2, 3):
            raise ValueError(f"vertices must have 2 or 3 coordinates; got the shape {(n, d)}")
        frame = Frame.around(self.points)
        self._unit, self._center = frame.scale, frame.center / frame.scale
        self._rounding = ROUNDINGS * resolution(self.points)
        everything: tuple[np.ndarray, list[np.ndarray]] = np.arange(n), []
        self._vertices, self._edges = hanging_vertices(self.points) if d == 2 else everything
        polytope = Polytope.of(self._corner_points)
        self._corners = polytope.corners
        self._form = ProductForm(polytope.normals, polytope.corner_faces)
        if d == 2:
            self._ends, self._pairs = _edges_by_twos(polytope)
        else:
            self._depth = _depths(polytope)
        report_all(progress, n)

    @classmethod
    def _argument_names(cls) -> list[str]:
        return []

    @classmethod
    def _made(cls, points: np.ndarray, **arguments: Any) -> Reconstruction:
        return cls(points, **arguments)

    @property
    def _corner_points(self) -> np.ndarray:
        return self.points[self._vertices]

    def _weight_rows(self, x: np.ndarray) -> np.ndarray:
        w = super()._weight_rows(x)
        if not self._edges:
            return w
        rows = self._with_hanging(w)
        for edge in self._edges:
            on, t = self._on_edge(x, edge)
            rows[on] = 0.0
            knots = self._along(self.points[edge], edge)
            for i, hat in zip(edge, np.eye(len(edge)), strict=True):
                rows[on, i] = np.interp(t[on], knots, hat)
        return rows

    def _gradient_weight_rows(self, x: np.ndarray) -> tuple[np.ndarray, ...]:
        self._refuse_edges(x)
        g = super()._gradient_weight_rows(x)
        return tuple(map(self._with_hanging, g)) if self._edges else g

    def _hessian_rows(self, x: np.ndarray, prepared: np.ndarray) -> np.ndarray:
        self._refuse_edges(x)
        return super()._hessian_rows(x, prepared[self._vertices])

    def _refuse_edges(self, x: np.ndarray) -> None:
        """Refuse queries on edges with inner vertices, where there are no derivatives."""
        for edge in self._edges:
            on, _ = self._on_edge(x, edge)
            if on.any():
                raise ValueError(
                    f"the coordinates have no gradient at ({valid.format_point(x[on][0])}), on an "
                    f"edge with vertices inside it, such as vertex {edge[1]}"
                )

    def _with_hanging(self, w: np.ndarray) -> np.ndarray:
        """Weights (m, n) from those of the corners, zero for the hanging vertices."""
        rows = np.zeros((len(w), len(self.points)))
        rows[:, self._vertices] = w
        return rows

    def _along(self, x: np.ndarray, edge: np.ndarray) -> np.ndarray:
        """Parameters of points along an edge, exactly 0 and 1 at its ends."""
        a, b = self.points[edge[0]], self.points[edge[-1]]
        along, here = (b - a) / self._unit, (x - a) / self._unit
        return (here @ along) / (along @ along)

    def _on_edge(self, x: np.ndarray, edge: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Whether queries (m, 2) are on an edge within rounding, and their parameters along it."""
        a, b = self.points[edge[0]], self.points[edge[-1]]
        t = self._along(x, edge)
        foot = a + np.clip(t, 0.0, 1.0)[:, None] * (b - a)
        return np.linalg.norm((x - foot) / self._unit, axis=1) <= self._rounding, t

    def _heights(self, x: np.ndarray) -> np.ndarray:
        local = x.T.copy()
        local /= self._unit
        return self._above_edges(local) if len(local) == 2 else self._from_corners(local)

    def _above_edges(self, x: np.ndarray) -> np.ndarray:
        """n^T (p - x), p an end of the edge: exactly zero at the other end too."""
        offset = self._ends[..., None] - x
        h = self._pairs[..., 0, None] * offset[:, None, 0]
        h += self._pairs[..., 1, None] * offset[:, None, 1]
        return h.reshape(-1, x.shape[1])[: len(self._form.normals)]

    def _from_corners(self, x: np.ndarray) -> np.ndarray:
        """n^T (p - x) + depth of p, with p the nearest corner, near which it is most accurate."""
        corners = self._corners - self._center
        score = corners @ (x - self._center[:, None]) - (corners**2).sum(axis=1)[:, None] / 2
        nearest = score.argmax(axis=0)
        return self._form.normals @ (self._corners[nearest].T - x) + self._depth[:, nearest]


def _edges_by_twos(polygon: Polytope) -> tuple[np.ndarray, np.ndarray]:
    """Ends (k, 2) that two edges share, and their normals (k, 2, 2); the last is zero if odd.

    This halves the number of differences p - x, and four array operations give all heights.
    """
    ends = polygon.corners[[edge[1] for edge in polygon.faces[::2]]]
    pairs = np.zeros((len(ends), 2, 2))
    pairs.reshape(-1, 2)[: len(polygon.normals)] = polygon.normals
    return ends, pairs


def _depths(polytope: Polytope) -> np.ndarray:
    """Heights (f, n) of the corners below the faces, exactly zero for corners on a face."""
    on = polytope.corners[[face[0] for face in polytope.faces]]
    below = on[:, None] - polytope.corners
    depth = np.einsum("fd,fnd->fn", polytope.normals, below)
    for i, faces in enumerate(polytope.corner_faces):
        depth[faces, i] = 0.0
    return depth
