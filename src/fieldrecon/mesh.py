"""Meshes of triangles and of tetrahedra: cells, the faces between them, and what lies around."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.spatial import Delaunay

from fieldrecon import _simplices as simplices
from fieldrecon import _validation as valid

_OUTWARD = {
    2: np.array([[1, 2], [2, 0], [0, 1]]),
    3: np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]),
}
"""Corners of the face opposite each corner of a positive simplex, seen from outside."""


def _read_only(array: np.ndarray) -> np.ndarray:
    array.flags.writeable = False
    return array


@dataclass(frozen=True, eq=False)
class SimplexMesh:
    """Triangles in the plane or tetrahedra in space, in the words of finite volumes.

    A *cell* is a triangle or a tetrahedron, a *face* an edge or a triangle between two cells or on
    the boundary. All arrays are read-only, and computed when first asked for.

    Parameters
    ----------
    points : (n, d) array_like
        The vertices, d = 2 or 3. One that no cell has stays, and nothing uses it.
    cells : (c, d + 1) array_like of int
        Vertices of each cell, in either orientation. Kept as given where the orientation is
        positive; otherwise the last two are exchanged.

    Raises
    ------
    ValueError
        If the cells do not index the points, repeat a vertex, are flat, overlap at a face, or if
        three or more of them share a face.

    Examples
    --------
    >>> mesh = SimplexMesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 3, 2]])
    >>> mesh.cells.tolist()
    [[0, 1, 2], [0, 2, 3]]
    >>> mesh.faces.tolist()
    [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]
    >>> mesh.face_cells.tolist()
    [[0, -1], [0, 1], [1, -1], [0, -1], [1, -1]]
    >>> mesh.cell_measures
    array([0.5, 0.5])
    """

    points: np.ndarray
    cells: np.ndarray

    def __post_init__(self) -> None:
        points = valid.as_points(self.points)
        if points.shape[1] not in (2, 3):
            raise ValueError(
                f"points must lie in the plane or in space, shape (n, 2) or (n, 3); "
                f"got {points.shape}"
            )
        cells = _as_cells(self.cells, *points.shape)
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "cells", _read_only(_positive(points, cells)))
        self.faces  # noqa: B018  (cells that do not fit together are refused now)

    @classmethod
    def delaunay(cls, points: ArrayLike) -> SimplexMesh:
        """Delaunay mesh of points in the plane or in space."""
        points = valid.as_points(points)
        middle = points.mean(axis=0)
        triangulation = Delaunay((points - middle) / np.abs(points - middle).max())
        return cls(points, triangulation.simplices)

    # --- topology -------------------------------------------------------------------------------

    @cached_property
    def _topology(self) -> _Topology:
        return _topology(self.cells, len(self.points))

    @property
    def faces(self) -> np.ndarray:
        """Vertices (f, d) of each face, increasing; the faces in lexicographic order."""
        return self._topology.faces

    @property
    def face_cells(self) -> np.ndarray:
        """The two cells (f, 2) of each face, the lower first; -1 outside."""
        return self._topology.face_cells

    @property
    def cell_faces(self) -> np.ndarray:
        """Faces (c, d + 1) of each cell, the k-th opposite the k-th vertex."""
        return self._topology.cell_faces

    @cached_property
    def cell_face_signs(self) -> np.ndarray:
        """1 where the face's normal leaves the cell, -1 where it enters: (c, d + 1)."""
        cell = np.arange(len(self.cells))[:, None]
        return _read_only(np.where(self.face_cells[self.cell_faces, 0] == cell, 1, -1))

    @cached_property
    def boundary_faces(self) -> np.ndarray:
        """Indices of the faces with one cell."""
        return _read_only(np.flatnonzero(self.face_cells[:, 1] < 0))

    @cached_property
    def boundary_vertices(self) -> np.ndarray:
        """Whether each vertex (n,) lies on a face with one cell."""
        return _read_only(_marked(self.faces[self.boundary_faces], len(self.points)))

    @cached_property
    def referenced(self) -> np.ndarray:
        """Whether each point (n,) is a vertex of some cell."""
        return _read_only(_marked(self.cells, len(self.points)))

    @cached_property
    def edges(self) -> np.ndarray:
        """Vertices (e, 2) of each edge, increasing; in the plane the faces."""
        if self.points.shape[1] == 2:
            return self.faces
        pairs = self.faces[:, [[0, 1], [0, 2], [1, 2]]].reshape(-1, 2)
        n = len(self.points)
        return _read_only(np.column_stack(np.divmod(np.unique(pairs[:, 0] * n + pairs[:, 1]), n)))

    @cached_property
    def vertex_cell_incidence(self) -> sparse.csr_array:
        """Ones (n, c) where a vertex belongs to a cell."""
        return _incidence(self.cells, len(self.points))

    @cached_property
    def vertex_face_incidence(self) -> sparse.csr_array:
        """Ones (n, f) where a vertex belongs to a face."""
        return _incidence(self.faces, len(self.points))

    @cached_property
    def cell_face_incidence(self) -> sparse.csr_array:
        """Ones (c, f) where a cell has a face."""
        return _incidence(self.cell_faces, len(self.faces)).T.tocsr()

    def vertex_cells(self, i: int) -> np.ndarray:
        """Indices of the cells round vertex i, increasing."""
        a = self.vertex_cell_incidence
        if not 0 <= i < a.shape[0]:
            raise ValueError(f"i must be a vertex, 0 to {a.shape[0] - 1}; got {i}")
        return a.indices[a.indptr[i] : a.indptr[i + 1]].copy()

    def cells_around(
        self, rings: int = 1, vertices: ArrayLike | None = None
    ) -> sparse.csr_array:
        """Cells in the first rings round vertices, as a matrix (v, c) of ones.

        The first ring of a vertex is its cells; each further one, the cells of their vertices.

        Parameters
        ----------
        rings : int
            How many, at least one.
        vertices : (v,) array_like of int, optional
            All by default.
        """
        incidence = self.vertex_cell_incidence
        around = incidence if vertices is None else incidence[np.asarray(vertices)]
        for _ in range(rings - 1):
            around = _pattern(around @ incidence.T @ incidence)
        return around

    def faces_around(
        self, rings: int = 1, vertices: ArrayLike | None = None
    ) -> sparse.csr_array:
        """Faces of `cells_around`, as a matrix (v, f) of ones; the outermost are among them."""
        return _pattern(self.cells_around(rings, vertices) @ self.cell_face_incidence)

    # --- geometry -------------------------------------------------------------------------------

    @cached_property
    def cell_measures(self) -> np.ndarray:
        """Area or volume (c,) of each cell."""
        measure, unit, _ = _volumes(self.points[self.cells])
        d = self.points.shape[1]
        return _read_only(np.abs(measure) / math.factorial(d) * unit**d)

    @cached_property
    def cell_centers(self) -> np.ndarray:
        """Centroid (c, d) of each cell."""
        return _read_only(self.points[self.cells].mean(axis=1))

    @cached_property
    def circumcenters(self) -> np.ndarray:
        """Centre (c, d) of the circle or sphere through the vertices of each cell."""
        return _read_only(simplices.circumcenters(self.points[self.cells]))

    @cached_property
    def face_centers(self) -> np.ndarray:
        """Centroid (f, d) of each face."""
        return _read_only(self.points[self.faces].mean(axis=1))

    @cached_property
    def face_circumcenters(self) -> np.ndarray:
        """Centre (f, d) of the circle through the vertices of each face; its middle in the plane."""
        return _read_only(simplices.circumcenters(self.points[self.faces]))

    @cached_property
    def face_normals(self) -> np.ndarray:
        """Unit normals (f, d), from the first to the second cell, outward on the boundary."""
        normals, _, _ = self._face_vectors
        size = np.linalg.norm(normals, axis=1)
        return _read_only(normals / (self._topology.signs * size)[:, None])

    @cached_property
    def face_measures(self) -> np.ndarray:
        """Length or area (f,) of each face."""
        normals, unit, k = self._face_vectors
        return _read_only(np.linalg.norm(normals, axis=1) / math.factorial(k) * unit**k)

    @property
    def _face_vectors(self) -> tuple[np.ndarray, np.ndarray, int]:
        """Normals of the faces as their vertices are ordered, in units^k."""
        corners = self.points[self.faces]
        unit = simplices.units(corners[:, 1:] - corners[:, :1])
        local = (corners - corners[:, :1]) / unit[:, None, None]
        edges, _, _ = simplices.spanning_edges(local)
        if edges.shape[1] == 1:
            return np.stack([edges[:, 0, 1], -edges[:, 0, 0]], axis=1), unit, 1
        return np.cross(edges[:, 0], edges[:, 1]), unit, 2


@dataclass(frozen=True)
class _Topology:
    faces: np.ndarray
    face_cells: np.ndarray
    cell_faces: np.ndarray
    signs: np.ndarray  # of each face: whether its increasing order is outward of the first cell


def _as_cells(cells: ArrayLike, n: int, d: int) -> np.ndarray:
    kind = "triangles" if d == 2 else "tetrahedra"
    given = np.asarray(cells)
    if given.dtype.kind not in "iu":
        raise ValueError(f"cells must be an array of integers; got the type {given.dtype}")
    if given.ndim != 2 or given.shape[1] != d + 1 or len(given) == 0:
        raise ValueError(f"cells must be {kind}, shape (c, {d + 1}); got {given.shape}")
    wrong = np.argwhere((given < 0) | (given >= n))
    if len(wrong):
        i, k = map(int, wrong[0])
        raise ValueError(
            f"cells must index the {n} points, 0 to {n - 1}; cells[{i}, {k}] is {given[i, k]}"
        )
    array = given.astype(np.intp)
    ordered = np.sort(array, axis=1)
    repeated = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
    if len(repeated):
        i = int(repeated[0])
        raise ValueError(f"cell {i} repeats a vertex: {array[i].tolist()}")
    return array


def _volumes(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Signed volume in units^d, the unit, and whether the simplex is flat."""
    unit = simplices.units(corners[:, 1:] - corners[:, :1])
    edges, _, _ = simplices.spanning_edges((corners - corners[:, :1]) / unit[:, None, None])
    volume = simplices.determinants(edges)
    largest = np.prod(np.linalg.norm(edges, axis=2), axis=1)
    return volume, unit, np.abs(volume) <= simplices.FLAT * largest


def _positive(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Cells with two vertices exchanged where the orientation is negative; flat ones refused."""
    volume, _, flat = _volumes(points[cells])
    if flat.any():
        i = int(np.flatnonzero(flat)[0])
        kind, where = ("triangle", "line") if points.shape[1] == 2 else ("tetrahedron", "plane")
        more = f"; {flat.sum() - 1} more are flat" if flat.sum() > 1 else ""
        raise ValueError(
            f"cell {i} is flat: the vertices {cells[i].tolist()} of this {kind} lie on one "
            f"{where} within rounding{more}"
        )
    cells[volume < 0, -2:] = cells[volume < 0, :-3:-1]
    return cells


def _topology(cells: np.ndarray, n: int) -> _Topology:
    d = cells.shape[1] - 1
    sides = cells[:, _OUTWARD[d]].reshape(-1, d)
    positive = _even(sides)
    sides = np.sort(sides, axis=1)
    order = _lexicographic(sides, n)
    ordered = sides[order]
    first = np.ones(len(order), dtype=bool)
    first[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    start = np.flatnonzero(first)
    count = np.diff(start, append=len(order))
    if count.max() > 2:
        f = int(np.argmax(count))
        shared = sorted((order[start[f] : start[f] + count[f]] // (d + 1)).tolist())
        raise ValueError(
            f"face {ordered[start[f]].tolist()} belongs to {count[f]} cells, {shared}; at most two "
            "cells meet at a face"
        )
    cell_faces = np.empty(len(order), dtype=np.intp)
    cell_faces[order] = np.cumsum(first) - 1
    double = count == 2
    one = order[start]
    two = np.where(double, order[np.minimum(start + 1, len(order) - 1)], -1)
    folded = double & (positive[one] == positive[two])
    if folded.any():
        f = int(np.argmax(folded))
        i, j = sorted((int(one[f]) // (d + 1), int(two[f]) // (d + 1)))
        raise ValueError(
            f"cells {i} and {j} overlap: both lie on the same side of their common face "
            f"{ordered[start[f]].tolist()}"
        )
    swap = double & (two < one)
    one, two = np.where(swap, two, one), np.where(swap, one, two)
    face_cells = np.column_stack([one // (d + 1), np.where(double, two // (d + 1), -1)])
    return _Topology(
        _read_only(ordered[start]),
        _read_only(face_cells),
        _read_only(cell_faces.reshape(-1, d + 1)),
        _read_only(np.where(positive[one], 1, -1)),
    )


def _even(rows: np.ndarray) -> np.ndarray:
    """Whether sorting each row of two or three numbers is an even permutation."""
    odd = rows[:, 0] > rows[:, 1]
    if rows.shape[1] == 3:
        odd = odd ^ (rows[:, 0] > rows[:, 2]) ^ (rows[:, 1] > rows[:, 2])
    return ~odd


def _lexicographic(rows: np.ndarray, n: int) -> np.ndarray:
    """Order of the rows of indices below n, by first, second, ... column."""
    if n ** rows.shape[1] >= 2**63:
        return np.lexsort(rows.T[::-1])
    key = rows[:, 0]
    for column in rows.T[1:]:
        key = key * n + column
    return np.argsort(key)


def _marked(indices: np.ndarray, n: int) -> np.ndarray:
    mask = np.zeros(n, dtype=bool)
    mask[indices] = True
    return mask


def _incidence(groups: np.ndarray, n: int) -> sparse.csr_array:
    """Ones (n, m) where an index occurs in a group, (m, k)."""
    m, k = groups.shape
    pointer = np.arange(0, m * k + 1, k)
    ones = np.ones(m * k, dtype=np.int32)
    return sparse.csr_array(sparse.csc_array((ones, groups.ravel(), pointer), shape=(n, m)))


def _pattern(matrix: sparse.csr_array) -> sparse.csr_array:
    """The same matrix with ones for its entries, columns in order."""
    matrix.data[:] = 1
    matrix.sort_indices()
    return matrix
