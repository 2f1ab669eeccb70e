"""Voronoi weights of many vertices at once: vertices with equally many cells in one batch."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon import _simplices as simplices
from fieldrecon.mesh import SimplexMesh
from fieldrecon.polynomials import EPS

# A height this small beside its largest in the cell counts as one of those that vanish at a corner.
_LOW = 1e-6


def as_inner_vertices(mesh: SimplexMesh, vertices: ArrayLike, name: str = "vertex") -> np.ndarray:
    """Indices of vertices, refused where the Voronoi cell is open or there is none."""
    given, n = np.asarray(vertices), len(mesh.points)
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
    """Weights (g, k) of the k cells round each vertex (g,), and where (g,) these cannot be trusted.

    As in `VoronoiCell`, for all g at once. They cannot where more heights vanish than belong to one
    cell, as on the edges of a Voronoi cell between cocircular points, or where the sum does.
    """
    g, k = cells.shape
    around = mesh.cells.take(cells, axis=0)
    opposite = around[around != vertices[:, None, None]].reshape(g, -1)
    neighbors, present, faces = _ranked(opposite)
    center = mesh.points[vertices]
    edges = mesh.points.take(neighbors, axis=0) - center[:, None]
    unit = np.exp2(np.frexp(np.abs(edges).max(axis=(1, 2)))[1])
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


def _ranked(a: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Distinct entries (g, f) of each row, which of these (g, f) there are, and ranks of all."""
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
