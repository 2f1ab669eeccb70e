"""Barycentric coordinates of Voronoi cells, from the Delaunay cells round a vertex."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, chunked, report_all, rows_of
from fieldrecon.barycentric.coordinates import ConvexCoordinates
from fieldrecon.barycentric.polytope import in_order
from fieldrecon.barycentric.wachspress import ProductForm
from fieldrecon.meshes import simplices
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.polynomials import EPS, power_of_two_above, resolution
from fieldrecon.reconstruction import Reconstruction

# Relative height below which a height counts as one that vanishes at a corner.
_LOW = 1e-6


class VoronoiCell(ConvexCoordinates):
    """Barycentric coordinates of the Voronoi cell of a vertex x_i, whose corners are circumcentres.

    Corner a is the circumcentre of cell a = (i, b_1 ... b_d), face b the bisector of x_i and x_b.
    With l_b = |x_b - x_i| and V_a the volume of cell a, c_a / sum c of

    c_a(x) = V_a prod_{b not in a} h_b(x),   h_b(x) = l_b^2 / 2 - (x_b - x_i)^T (x - x_i):

    the slides' V_a / prod_{b in a} (x_b - x_i)^T (p_a - x) times all heights, since p_a is as far
    from x_b as from x_i. No circumcentre enters, so that flat cells do no harm, and there is no
    division. Cells with one circumcentre (more than d + 1 points on a sphere) are one corner.

    If the cells round the vertex are not Delaunay, the corners may form a polygon that intersects
    itself. Linear fields are still reproduced, and the weights are positive near x_i, but not in
    the whole cell.

    Parameters
    ----------
    mesh : SimplexMesh
        Triangles or tetrahedra.
    vertex : int
        A vertex inside the mesh.
    executor : concurrent.futures.Executor, optional
        Accepted by all methods; this one has nothing to split.
    progress : callable, optional
        Called once, as progress(n, n), when the method is made.

    Attributes
    ----------
    points : (n, d) ndarray
        Corners of the cell.
    cells : tuple of integer arrays
        For each corner, the cells of the mesh with this circumcentre, usually one.

    Raises
    ------
    ValueError
        If the vertex is not in the mesh, or is on its boundary, where the Voronoi cell is open.
    numpy.linalg.LinAlgError
        For a query outside the cell where the weights have a pole.

    References
    ----------
    Erleben, Field Reconstruction, p. 32-37.

    Examples
    --------
    >>> mesh = SimplexMesh.delaunay([[0, 0], [2, 0], [0.5, 2], [-2, 0.5], [0, -2]])
    >>> cell = VoronoiCell(mesh, 0)
    >>> s = cell.field(cell.points.sum(axis=1))
    >>> s([0.25, 0.5]).round(12), s.gradient([0.25, 0.5]).round(12)
    (np.float64(0.75), array([1., 1.]))
    """

    def __init__(
        self,
        mesh: SimplexMesh,
        vertex: int,
        *,
        executor: Executor | None = None,  # noqa: ARG002 - as for all methods
        progress: Progress | None = None,
    ) -> None:
        i = as_inner_vertices(mesh, vertex)
        if i.ndim:
            raise ValueError(f"vertex must be an index of a point, an integer; got {vertex!r}")
        cells = mesh.vertex_cells(int(i))
        star = mesh.cells[cells]
        opposite = star[star != i].reshape(len(cells), -1)
        neighbors, faces = np.unique(opposite, return_inverse=True)
        faces = faces.reshape(opposite.shape)
        own, local = np.unique(star, return_inverse=True)
        # what a file keeps of the mesh: the cells round the vertex, with their numbers
        vertex = int(np.searchsorted(own, i))
        self._star = vertex, mesh.points[own], local.reshape(star.shape), cells
        self._center = mesh.points[i]
        edges = mesh.points[neighbors] - self._center
        self._unit = float(power_of_two_above(np.abs(edges).max()))
        edges /= self._unit
        normals = edges / (edges**2).sum(axis=1)[:, None]
        centers = simplices.circumcenters(mesh.points[star])
        self._nearness = 64 * resolution(mesh.points[np.append(neighbors, i)])
        corner = _merged(centers / self._unit, faces, self._nearness)
        self.cells = tuple(cells[corner == a] for a in range(corner.max() + 1))
        self.points = valid.as_points(centers[np.unique(corner, return_index=True)[1]])
        meeting, real = _meeting(faces, corner)
        normals = normals[real]
        self._form = ProductForm(normals, [in_order(normals, at) for at in meeting])
        self._crowded = [(a, at) for a, at in enumerate(meeting) if len(at) > len(self._center)]
        report_all(progress, len(self.points))

    def _arguments(self) -> dict[str, Any]:
        return dict(zip(self._argument_names(), self._star, strict=True))

    @classmethod
    def _argument_names(cls) -> list[str]:
        return ["vertex", "nodes", "star", "numbers"]

    @classmethod
    def _made(cls, points: np.ndarray, **arguments: Any) -> Reconstruction:  # noqa: ARG003
        vertex, nodes, star, numbers = (arguments.pop(name) for name in cls._argument_names())
        cell = cls(SimplexMesh(nodes, star), vertex, **arguments)
        cell.cells = tuple(np.asarray(numbers)[own] for own in cell.cells)
        cell._star = vertex, nodes, star, numbers
        return cell

    def _heights(self, x: np.ndarray) -> np.ndarray:
        """Heights (f, m) in units of l_b^2, exactly zero at corners of more than d faces."""
        h = 0.5 - self._form.normals @ ((x - self._center) / self._unit).T
        for a, faces in self._crowded:
            near = np.abs(x - self.points[a]).max(axis=1) <= self._nearness * self._unit
            h[np.ix_(faces, near)] = 0.0
        return h


def voronoi_weights(
    mesh: SimplexMesh,
    vertices: ArrayLike,
    x: ArrayLike,
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> sparse.csr_array:
    """Weights of `VoronoiCell` for many pairs of a vertex and a query at once.

    Cells with the same circumcentre share its weight equally; only their sum has a meaning.

    Parameters
    ----------
    mesh : SimplexMesh
        Triangles or tetrahedra.
    vertices : (...) array_like of int
        Vertices inside the mesh: one for each query, or one for all.
    x : (..., d) array_like
        Queries, m of them in all.
    executor : concurrent.futures.Executor, optional
        Runs the chunks; this machine's threads by default.
    progress : callable, optional
        Called as progress(done, total) with numbers of queries.

    Returns
    -------
    (m, c) scipy.sparse.csr_array
        H with s(x) = H f for data f at the circumcentres of the c cells.

    Raises
    ------
    ValueError
        As for `VoronoiCell`, and if there are neither one nor m vertices.
    numpy.linalg.LinAlgError
        For a query outside the Voronoi cell where the weights have a pole.

    References
    ----------
    Erleben, Field Reconstruction, p. 32-37.

    Examples
    --------
    >>> mesh = SimplexMesh.delaunay([[0, 0], [2, 0], [0.5, 2], [-2, 0.5], [0, -2]])
    >>> h = voronoi_weights(mesh, [0, 0], [[0.25, 0.5], [0.0, 0.0]])
    >>> (h @ mesh.circumcenters).round(12) + 0.0
    array([[0.25, 0.5 ],
           [0.  , 0.  ]])
    """
    queries = valid.as_queries(x, mesh.points.shape[1])
    given = as_inner_vertices(mesh, vertices, "vertices")
    if given.shape not in ((), queries.shape[:-1]):
        raise ValueError(
            f"vertices must be one for each query, shape {queries.shape[:-1]}, or one for all; "
            f"got the shape {given.shape}"
        )
    vertex = np.broadcast_to(given, queries.shape[:-1]).ravel()
    rows, (weights, cells, pointer) = queries.reshape(-1, queries.shape[-1]), _empty(mesh, vertex)
    parts = list(_of_equal_valence(pointer))
    work, done = partial(_weights_of_part, mesh, vertex, rows, cells, pointer, parts), 0
    lost = [np.zeros(0, np.intp)]
    for _, (part, entries, found, unreliable) in chunked(work, np.arange(len(parts)), 1, executor):
        weights[entries] = found
        lost.append(part[unreliable])
        done += len(part)
        if progress is not None:
            progress(done, len(rows))
    _weigh_one_by_one(mesh, vertex, rows, np.concatenate(lost), weights, pointer)
    h = sparse.csr_array((weights, cells, pointer), shape=(len(rows), len(mesh.cells)))
    return valid.check_finite(h, rows)


def _weights_of_part(
    mesh: SimplexMesh,
    vertex: np.ndarray,
    x: np.ndarray,
    cells: np.ndarray,
    pointer: np.ndarray,
    parts: list[np.ndarray],
    which: np.ndarray,
) -> tuple[np.ndarray, ...]:
    """Pairs (g,) of a part, their entries (g, k), the weights there, and which are unreliable."""
    part = parts[which[0]]
    entries = pointer[part, None] + np.arange(pointer[part[0] + 1] - pointer[part[0]])
    found = valid.quiet_evaluate(weights_of_cells, mesh, vertex[part], x[part], cells[entries])
    return part, entries, *found


def as_inner_vertices(mesh: SimplexMesh, vertices: ArrayLike, name: str = "vertex") -> np.ndarray:
    """Indices of vertices; those on the boundary or of no cell are refused."""
    given, n = np.asarray(valid.unmasked(vertices, name)), len(mesh.points)
    if given.dtype.kind not in "iu" and given.size:
        raise ValueError(f"{name} must be an index of a point, an integer; got {vertices!r}")
    given = given.astype(np.intp)
    wrong = given[(given < 0) | (given >= n)]
    if wrong.size:
        raise ValueError(f"{name} must be an index of a point, 0 to {n - 1}; got {wrong[0]}")
    for which, why in (
        (mesh.boundary_vertices, "lies on the boundary of the mesh: its Voronoi cell is open"),
        (~mesh.referenced, "belongs to no cell of the mesh"),
    ):
        if which[given].any():
            raise ValueError(f"{name} {np.atleast_1d(given[which[given]])[0]} {why}")
    return given


def weights_of_cells(
    mesh: SimplexMesh, vertices: np.ndarray, x: np.ndarray, cells: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Weights (g, k) of the k cells round each vertex (g,), and where (g,) they are unreliable.

    As in `VoronoiCell`, for all g at once. They are unreliable where the sum vanishes, or more
    heights vanish than belong to one cell, as on edges between cocircular points.
    """
    g, k = cells.shape
    around = mesh.cells.take(cells, axis=0)
    opposite = around[around != vertices[:, None, None]].reshape(g, -1)
    neighbors, present, faces = _ranked(opposite)
    center = mesh.points[vertices]
    edges = mesh.points.take(neighbors, axis=0) - center[:, None]
    unit = power_of_two_above(np.abs(edges).max(axis=(1, 2)))
    edges /= unit[:, None, None]
    normals = edges / np.einsum("gfd,gfd->gf", edges, edges)[..., None]
    y = (x - center) / unit[:, None]
    h = 1.0 - 2.0 * np.einsum("gfd,gd->gf", normals, y)
    faces = faces.reshape(g, k, -1)
    at = np.zeros((g, k, present.shape[1]), dtype=bool)
    np.put_along_axis(at, faces, True, axis=2)
    d = faces.shape[2]
    spanned = np.take_along_axis(normals, faces.reshape(g, -1, 1), axis=1).reshape(-1, d, d)
    volume = np.abs(simplices.determinants(spanned)).reshape(g, k)
    w = volume * np.where(at | ~present[:, None], 1.0, h[:, None]).prod(axis=2)
    total = w.sum(axis=1)
    low = present & (np.abs(h) < _LOW)
    common = (at & low[:, None]).sum(axis=2).max(axis=1)
    lost = (common < low.sum(axis=1)) | ~(np.abs(total) > 64 * EPS * np.abs(w).sum(axis=1))
    return w / np.where(lost, 1.0, total)[:, None], lost


def _merged(centers: np.ndarray, faces: np.ndarray, tolerance: float) -> np.ndarray:
    """Index of the corner of each cell; neighbours with the same circumcentre share one."""
    d = faces.shape[1]
    at = np.zeros((len(faces), faces.max() + 1), dtype=int)
    np.put_along_axis(at, faces, 1, axis=1)
    distance = np.abs(centers[:, None] - centers).max(axis=2)
    one = (at @ at.T >= d - 1) & (distance <= tolerance)
    return connected_components(sparse.csr_array(one), directed=False)[1]


def _meeting(faces: np.ndarray, corner: np.ndarray) -> tuple[list[np.ndarray], np.ndarray]:
    """Faces at each corner, and the indices of real faces: some planes only touch the cell."""
    d = faces.shape[1]
    pairs = np.unique(np.column_stack([np.repeat(corner, d), faces.ravel()]), axis=0)
    real = np.bincount(pairs[:, 1]) >= d
    pairs = pairs[real[pairs[:, 1]]]
    number = np.cumsum(real) - 1
    starts = np.flatnonzero(np.diff(pairs[:, 0])) + 1
    return np.split(number[pairs[:, 1]], starts), np.flatnonzero(real)


def _empty(mesh: SimplexMesh, vertex: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Space for the weights, the cells round the vertices, and the start of each vertex's cells."""
    at = mesh.vertex_cell_incidence
    count = np.diff(at.indptr)[vertex]
    pointer = np.concatenate([[0], np.cumsum(count)])
    shift = np.repeat(at.indptr[vertex] - pointer[:-1], count)
    cells = at.indices[np.arange(pointer[-1]) + shift]
    return np.empty(len(cells)), cells, pointer


def _of_equal_valence(pointer: np.ndarray) -> Iterator[np.ndarray]:
    """Yield chunks of pairs whose vertices have equally many cells."""
    count = np.diff(pointer)
    order = np.argsort(count, kind="stable")
    for same in np.split(order, np.flatnonzero(np.diff(count[order])) + 1):
        if len(same):
            step = rows_of(8 * 3 * int(count[same[0]]) ** 2)
            yield from (same[i : i + step] for i in range(0, len(same), step))


def _weigh_one_by_one(
    mesh: SimplexMesh,
    vertex: np.ndarray,
    x: np.ndarray,
    pairs: np.ndarray,
    weights: np.ndarray,
    pointer: np.ndarray,
) -> None:
    """Set the weights of these pairs, vertex by vertex, with coincident corners merged."""
    for v in np.unique(vertex[pairs]):
        mine = pairs[vertex[pairs] == v]
        cell = VoronoiCell(mesh, v)
        shared = cell.weights(x[mine]) / [len(c) for c in cell.cells]
        order = np.argsort(np.concatenate(cell.cells))  # in ascending order of the cells
        corner = np.repeat(np.arange(len(cell.cells)), [len(c) for c in cell.cells])[order]
        weights[pointer[mine, None] + np.arange(len(corner))] = shared[:, corner]


def _ranked(a: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Distinct entries (g, f) of each row, a mask (g, f) of valid ones, and the ranks of all."""
    order = np.argsort(a, axis=1, kind="stable")
    increasing = np.take_along_axis(a, order, axis=1)
    first = np.ones(a.shape, dtype=bool)
    first[:, 1:] = increasing[:, 1:] != increasing[:, :-1]
    rank = np.cumsum(first, axis=1) - 1
    ranks = np.empty_like(rank)
    np.put_along_axis(ranks, order, rank, axis=1)
    count = rank[:, -1] + 1
    distinct = np.repeat(increasing[:, -1:], int(count.max(initial=1)), axis=1)
    np.put_along_axis(distinct, rank, increasing, axis=1)
    return distinct, np.arange(distinct.shape[1]) < count[:, None], ranks
