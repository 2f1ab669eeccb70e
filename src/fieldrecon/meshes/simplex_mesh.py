"""Meshes of triangles and of tetrahedra: cells, faces, their geometry and neighbourhoods."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from operator import index

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from fieldrecon._core import validation as valid
from fieldrecon.meshes import simplices
from fieldrecon.meshes.delaunay import delaunay_cells
from fieldrecon.meshes.topology import Topology, incidence, pattern, topology


@dataclass(frozen=True, eq=False)
class SimplexMesh:
    """Triangles in the plane or tetrahedra in space, in the terms of finite volumes.

    A cell is a triangle or a tetrahedron; a face, an edge or a triangle, lies between two cells
    or on the boundary. Arrays are computed on first access, and are read-only.

    Parameters
    ----------
    points : (n, d) array_like
        The vertices, d = 2 or 3. A point of no cell is kept, but not used.
    cells : (c, d + 1) array_like of int
        Vertices of each cell, in either orientation. The last two are exchanged if the orientation
        is not positive (anticlockwise, right-handed).

    Raises
    ------
    ValueError
        If the cells do not index the points, repeat a vertex, are flat, lie on the same side of a
        common face, or if three of them share a face.
    OverflowError
        If the size of a cell exceeds the range of floating-point numbers.

    Notes
    -----
    A cell is flat if rounding decides its orientation; a merely thin cell is not. Coordinates are
    taken as exact. All quantities are computed from differences to a corner of the cell, so they
    do not depend on the origin.

    References
    ----------
    Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 14-15).

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
        points = as_plane_or_space(self.points)
        cells = positive(points, as_cells(self.cells, *points.shape))
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "cells", _read_only(cells))
        self._topology  # noqa: B018  refuses cells that do not fit together

    def __reduce__(self) -> tuple[type[SimplexMesh], tuple[np.ndarray, np.ndarray]]:
        return type(self), (self.points, self.cells)

    @classmethod
    def delaunay(cls, points: ArrayLike) -> SimplexMesh:
        """Delaunay mesh of points in the plane or in space.

        Its cells fill the convex hull of the points, except cells that are flat within the rounding
        of the coordinates. Every point is a vertex, also of clusters far narrower than the whole:
        where rounding would lose points or make cells overlap, exact signs decide, in some 0.3 ms
        for each point of the plane and 3 ms for each in space. If more than d + 1 points lie on an
        empty circle or sphere, the Delaunay mesh is not unique.

        Parameters
        ----------
        points : (n, d) array_like
            Distinct points, d = 2 or 3.

        Raises
        ------
        ValueError
            If there are too few points, or two coincide.
        numpy.linalg.LinAlgError
            If all points lie on one line or plane within rounding, or rounding decides the sign of
            a cell between others.

        Examples
        --------
        >>> SimplexMesh.delaunay([[0, 0], [2, 0], [0, 2], [3, 3]]).faces.tolist()
        [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]]
        """
        p = as_plane_or_space(points)
        cells = delaunay_cells(p)
        try:
            return cls(p, cells)
        except ValueError:  # Qhull's rounding made them overlap
            cells = delaunay_cells(p, by_exact_signs=True)
        try:
            return cls(p, cells)
        except ValueError as error:
            raise np.linalg.LinAlgError(f"no mesh within rounding: {error}") from None

    # --- topology -------------------------------------------------------------------------------

    @cached_property
    def _topology(self) -> Topology:
        return topology(self.cells, len(self.points))

    @cached_property
    def faces(self) -> np.ndarray:
        """Vertices (f, d) of each face, increasing; the faces in lexicographic order."""
        return _read_only(self._topology.faces)

    @cached_property
    def face_cells(self) -> np.ndarray:
        """The two cells (f, 2) at each face, the lower first; -1 outside."""
        return _read_only(self._topology.face_cells)

    @cached_property
    def cell_faces(self) -> np.ndarray:
        """Faces (c, d + 1) of each cell, the k-th opposite its k-th vertex."""
        return _read_only(self._topology.cell_faces)

    @cached_property
    def cell_face_signs(self) -> np.ndarray:
        """1 where the normal of the k-th face leaves the cell, -1 where it enters, (c, d + 1)."""
        cell = np.arange(len(self.cells))[:, None]
        return _read_only(np.where(self.face_cells[:, 0].take(self.cell_faces) == cell, 1, -1))

    @cached_property
    def boundary_faces(self) -> np.ndarray:
        """Indices of the faces with one cell."""
        return _read_only(np.flatnonzero(self.face_cells[:, 1] < 0))

    @cached_property
    def boundary_vertices(self) -> np.ndarray:
        """Whether each point (n,) is a vertex of a face with one cell."""
        return _read_only(self._marked(self.faces[self.boundary_faces]))

    @cached_property
    def referenced(self) -> np.ndarray:
        """Whether each point (n,) is a vertex of a cell."""
        return _read_only(self._marked(self.cells))

    @cached_property
    def edges(self) -> np.ndarray:
        """Vertices (e, 2) of each edge, increasing, in lexicographic order; in 2-D the faces."""
        if self.points.shape[1] == 2:
            return self.faces
        start, end = self.faces[:, [[0, 1], [0, 2], [1, 2]]].reshape(-1, 2).T
        n = len(self.points)
        return _read_only(np.column_stack(np.divmod(np.unique(start * n + end), n)))

    @cached_property
    def vertex_cell_incidence(self) -> sparse.csr_array:
        """Ones (n, c) where a point is a vertex of a cell."""
        return _read_only_matrix(incidence(self.cells, len(self.points)))

    @cached_property
    def vertex_face_incidence(self) -> sparse.csr_array:
        """Ones (n, f) where a point is a vertex of a face."""
        return _read_only_matrix(incidence(self.faces, len(self.points)))

    @cached_property
    def cell_face_incidence(self) -> sparse.csr_array:
        """Ones (c, f) where a cell has a face."""
        return _read_only_matrix(incidence(self.cell_faces, len(self.faces)).T.tocsr())

    def vertex_cells(self, i: int) -> np.ndarray:
        """Indices of the cells at vertex i, increasing; none for a point of no cell."""
        vertices = as_indices_of_points([index(i)], len(self.points))
        return self.vertex_cell_incidence[vertices].indices.astype(np.intp)

    def cells_around(self, rings: int = 1, vertices: ArrayLike | None = None) -> sparse.csr_array:
        """Cells in the first rings round vertices, as ones (v, c) in a sparse matrix.

        The first ring of a vertex is its cells; each further ring adds the cells of their vertices.

        Parameters
        ----------
        rings : int
            Number of rings, at least one.
        vertices : (v,) array_like of int, optional
            The vertices; all points by default.

        Raises
        ------
        ValueError
            If `rings` is not positive, or a vertex is not an index of a point.

        Examples
        --------
        >>> mesh = SimplexMesh.delaunay([[0, 0], [2, 0], [0, 2], [3, 3]])
        >>> mesh.cells_around(1).sum(axis=1).tolist(), mesh.cells_around(2).sum(axis=1).tolist()
        ([1, 2, 2, 1], [2, 2, 2, 2])
        """
        valid.as_count(rings, "rings")
        at = self.vertex_cell_incidence
        around = at if vertices is None else at[as_indices_of_points(vertices, len(self.points))]
        for _ in range(rings - 1):
            around = pattern(pattern(around @ at.T) @ at)
        return around

    def faces_around(self, rings: int = 1, vertices: ArrayLike | None = None) -> sparse.csr_array:
        """Faces of the cells of `cells_around`, as ones (v, f), outer faces included."""
        return pattern(self.cells_around(rings, vertices) @ self.cell_face_incidence)

    # --- geometry -------------------------------------------------------------------------------

    @cached_property
    def cell_measures(self) -> np.ndarray:
        """Area or volume (c,) of each cell."""
        volume, unit, _ = simplices.signed_volumes(self.points.take(self.cells, axis=0))
        return _read_only(_in_range(volume, unit, self.points.shape[1]))

    @cached_property
    def cell_centers(self) -> np.ndarray:
        """Centroid (c, d) of each cell."""
        return _read_only(simplices.centroids(self.points.take(self.cells, axis=0)))

    @cached_property
    def circumcenters(self) -> np.ndarray:
        """Centre (c, d) of the circle or sphere through the vertices of each cell."""
        return _read_only(simplices.circumcenters(self.points.take(self.cells, axis=0)))

    @cached_property
    def face_centers(self) -> np.ndarray:
        """Centroid (f, d) of each face."""
        return _read_only(simplices.centroids(self.points.take(self.faces, axis=0)))

    @cached_property
    def face_circumcenters(self) -> np.ndarray:
        """Centre (f, d) of the circle through the vertices of each face; its middle in 2-D."""
        return _read_only(simplices.circumcenters(self.points.take(self.faces, axis=0)))

    @cached_property
    def _face_vectors(self) -> tuple[np.ndarray, np.ndarray]:
        normals, areas, unit = simplices.normals(self.points.take(self.faces, axis=0))
        normals *= self._topology.signs[:, None]
        return _read_only(normals), _read_only(_in_range(areas, unit, self.points.shape[1] - 1))

    @property
    def face_normals(self) -> np.ndarray:
        """Unit normals (f, d), from the first to the second cell, outward on the boundary."""
        return self._face_vectors[0]

    @property
    def face_measures(self) -> np.ndarray:
        """Length or area (f,) of each face."""
        return self._face_vectors[1]

    def _marked(self, indices: np.ndarray) -> np.ndarray:
        mask = np.zeros(len(self.points), dtype=bool)
        mask[indices] = True
        return mask


def _in_range(measures: np.ndarray, unit: np.ndarray, power: int) -> np.ndarray:
    with np.errstate(over="ignore", under="ignore"):
        result = measures * unit**power
    if not np.isfinite(result).all() or (result == 0).any():
        raise OverflowError(
            "lengths, areas or volumes exceed the range of floating-point numbers; choose a unit "
            "of length nearer to the size of the mesh"
        )
    return result


def _read_only(array: np.ndarray) -> np.ndarray:
    array.flags.writeable = False
    return array


def _read_only_matrix(matrix: sparse.csr_array) -> sparse.csr_array:
    for part in (matrix.data, matrix.indices, matrix.indptr):
        part.flags.writeable = False
    return matrix


def as_plane_or_space(points: ArrayLike) -> np.ndarray:
    """Require points in two or three dimensions."""
    p = valid.as_points(points)
    if p.shape[1] not in (2, 3):
        raise ValueError(f"points must have the shape (n, 2) or (n, 3); got {p.shape}")
    return p


def as_indices_of_points(vertices: ArrayLike, n: int) -> np.ndarray:
    """Require indices (v,) of n points."""
    indices = np.asarray(valid.unmasked(vertices, "vertices"))
    if indices.ndim != 1 or (indices.size and indices.dtype.kind not in "iu"):
        raise ValueError(
            f"vertices must be indices of points, shape (v,); got the type {indices.dtype} "
            f"and the shape {indices.shape}"
        )
    indices = indices.astype(np.intp)
    wrong = indices[(indices < 0) | (indices >= n)]
    if len(wrong):
        raise ValueError(f"vertices must be indices of points, 0 to {n - 1}; got {wrong[0]}")
    return indices


def as_cells(cells: ArrayLike, n: int, d: int) -> np.ndarray:
    """Require cells of d + 1 distinct indices below n each; a new array."""
    kind = "triangles" if d == 2 else "tetrahedra"
    cells = valid.unmasked(cells, "cells")
    try:
        given = np.asarray(cells)
    except ValueError:
        raise ValueError(f"cells must be {kind}; the rows differ in length") from None
    if given.dtype.kind not in "iu":
        raise ValueError(f"cells must be integers; got the type {given.dtype}")
    if given.ndim != 2 or given.shape[1] != d + 1 or len(given) == 0:
        raise ValueError(f"cells must be {kind}, shape (c, {d + 1}); got {given.shape}")
    outside = (given < 0) | (given >= n)
    if outside.any():
        i, k = map(int, np.argwhere(outside)[0])
        raise ValueError(f"cells must index {n} points; cells[{i}, {k}] is {given[i, k]}")
    ordered = np.sort(given, axis=1)
    repeats = (ordered[:, 1:] == ordered[:, :-1]).any(axis=1)
    if repeats.any():
        i = int(np.argmax(repeats))
        raise ValueError(f"cells must have distinct vertices; cells[{i}] is {given[i].tolist()}")
    return given.astype(np.intp)


def positive(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """The cells, in positive orientation: the last two vertices are exchanged if necessary."""
    with np.errstate(over="ignore", invalid="ignore"):
        volumes, _, flat = simplices.signed_volumes(points.take(cells, axis=0))
    if not np.isfinite(volumes).all():
        i = int(np.argmin(np.isfinite(volumes)))
        raise OverflowError(f"the size of cell {i} exceeds the range of floating-point numbers")
    if flat.any():
        i = int(np.argmax(flat))
        where = "line" if points.shape[1] == 2 else "plane"
        others = f"; so are {flat.sum() - 1} others" if flat.sum() > 1 else ""
        raise ValueError(
            f"cells must not be flat; cell {i} is: its vertices {cells[i].tolist()} lie on one "
            f"{where} within rounding{others}"
        )
    negative = volumes < 0
    cells[negative, -2:] = cells[negative, :-3:-1]
    return cells
