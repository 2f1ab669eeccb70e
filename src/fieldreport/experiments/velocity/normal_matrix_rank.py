"""The fit B'c = V' of the slides, and its rank and null space by singular values.

The library decides by a bound on the weights whether the velocity at a vertex is determined. Here
the rank itself is computed, and the null space a second time from the conics through the vertices.
The vertices of a mesh that one ring determines are counted by their number of cells.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space

from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.polynomials import monomials
from fieldrecon.velocity.vertices import normal_velocities, vertex_velocities
from fieldreport.experiments.meshes.reference_flows import rotation
from fieldreport.framework.error_measures import order_of_magnitude
from fieldreport.framework.experiment import Cell

MOST = {False: 8, True: 5}
"""Numbers of triangles at interior and boundary vertices from which on rows are merged."""

VALENCES = (
    "where",
    "triangles",
    "vertices",
    "lowest rank",
    "highest rank",
    "determined by one ring",
    "took a second ring",
    "largest error, one ring",
    "largest error, rings as needed",
)

VANISHES = 1e-9
"""Singular values below this fraction of the largest count as zero, in a frame of size one."""

_CURL = np.array(
    [
        [0, 0, 1, 0, 0, 0],
        [0, -1, 0, 0, 0, 0],
        [0, 0, 0, 0, 1, 0],
        [0, 0, 0, -2, 0, 0],
        [0, 0, 0, 0, 0, 2],
        [0, 0, 0, 0, -1, 0],
    ]
)
"""From the coefficients of psi to those of its field (d psi/dy_2, -d psi/dy_1)."""


def normal_matrix(p: np.ndarray, n: np.ndarray) -> np.ndarray:
    """B' (..., k, d + d²) with the rows (n, p_1 n, …, p_d n) of samples p, n (..., k, d)."""
    b = monomials(p, 1)[..., :, None] * n[..., None, :]
    return b.reshape(*b.shape[:-2], -1)


def rank(b: np.ndarray) -> int:
    """The number of nonzero singular values of a matrix."""
    s = np.linalg.svd(b, compute_uv=False)
    return int((s > VANISHES * s[0]).sum())


@dataclass(frozen=True)
class OneRing:
    """The slides' fit at every vertex of a mesh.

    Attributes
    ----------
    values : (n, d) ndarray
        Velocity at the vertex, of the minimum-norm solution.
    rank : (n,) ndarray of int
        Rank of B'.
    determined : (n,) ndarray of bool
        Whether all solutions have that value.
    """

    values: np.ndarray
    rank: np.ndarray
    determined: np.ndarray


def one_ring(mesh: SimplexMesh, v: np.ndarray) -> OneRing:
    """Fit an affine velocity to the faces of the cells around each vertex, for any rank."""
    n, d = mesh.points.shape
    fit = OneRing(np.empty((n, d)), np.empty(n, dtype=int), np.empty(n, dtype=bool))
    for vertices, faces in _grouped(mesh):
        y = mesh.face_centers[faces] - mesh.points[vertices][:, None]
        y /= np.abs(y).max(axis=(1, 2), keepdims=True)
        u, s, vt = np.linalg.svd(normal_matrix(y, mesh.face_normals[faces]), full_matrices=False)
        kept = s > VANISHES * s[:, :1]
        s_inverse = np.where(kept, 1 / np.where(kept, s, 1.0), 0.0)
        rows = vt * kept[..., None]
        fit.values[vertices] = np.einsum(
            "mrd,mr,mkr,mk->md", rows[..., :d], s_inverse, u, v[faces], optimize=True
        )
        fit.rank[vertices] = kept.sum(axis=1)
        # components of the unit vectors of the value outside the row space
        left = np.eye(d, vt.shape[2]) - rows[..., :d].mT @ rows
        fit.determined[vertices] = np.abs(left).max(axis=(1, 2)) < 1e-7
    return fit


def _grouped(mesh: SimplexMesh) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Vertices (m,) with equal numbers of faces around them, and those faces (m, k)."""
    around = mesh.faces_around(1)
    counts = np.diff(around.indptr)
    for k in np.unique(counts):
        vertices = np.flatnonzero(counts == k)
        yield vertices, around[vertices].indices.reshape(-1, k)


def vertices_around(mesh: SimplexMesh, i: int) -> np.ndarray:
    """Offsets of the vertices of the cells at vertex i, itself first, and their size."""
    around = np.unique(mesh.cells[mesh.vertex_cells(i)])
    return mesh.points[np.concatenate([[i], around[around != i]])] - mesh.points[i]


def conics_through(y: np.ndarray) -> np.ndarray:
    """Coefficients (6, k) of the conics through points (m, 2), an orthonormal basis of them."""
    return null_space(monomials(y, 2), rcond=VANISHES)


def field_along(conic: np.ndarray) -> np.ndarray:
    """Coefficients (6, ...) of the affine field along the level lines of a conic (6, ...)."""
    return np.tensordot(_CURL, conic, axes=1)


def error_by_conics(mesh: SimplexMesh, i: int, u: np.ndarray, g: np.ndarray) -> np.ndarray:
    """Error of the minimum-norm solution at vertex i for the affine field u + g y, from conics.

    The fit loses the component of the field in the span of the fields along the conics through all
    vertices around i; the normals are not needed.
    """
    y = vertices_around(mesh, i)
    faces = mesh.faces_around(1, [i]).indices
    size = np.abs(mesh.face_centers[faces] - mesh.points[i]).max()
    unseen = np.linalg.qr(field_along(conics_through(y / size)))[0]
    c = np.concatenate([u, (size * g.T).ravel()])
    return -(unseen @ (unseen.T @ c))[:2]


def counts_of_mesh(mesh: SimplexMesh) -> np.ndarray:
    """For each vertex of a mesh and a rotation, the columns that `valences` summarizes."""
    u = rotation(mesh.points, mesh.points.mean(axis=0))
    v = normal_velocities(mesh, u)
    first, all_rings = one_ring(mesh, v), vertex_velocities(mesh, v)
    found = first.values - u
    turn = rotation(np.eye(2), np.zeros(2)).T
    by_conics = [error_by_conics(mesh, i, u[i], turn) for i in range(len(u))]
    around = [vertices_around(mesh, i) for i in range(len(u))]
    return np.column_stack(
        [
            mesh.boundary_vertices,
            np.diff(mesh.vertex_cell_incidence.indptr),
            first.rank,
            first.determined,
            all_rings.rings,
            np.linalg.norm(found, axis=1),
            np.linalg.norm(all_rings.values - u, axis=1),
            [6 - conics_through(y / np.abs(y).max()).shape[1] for y in around],
            np.abs(found - by_conics).max(axis=1),
        ]
    )


def valences(counted: np.ndarray) -> Iterator[tuple[Cell, ...]]:
    """Return table rows for interior and boundary vertices, by their number of triangles."""
    for boundary, most in MOST.items():
        for n in range(1, most + 1):
            there = np.minimum(counted[:, 1], most) == n
            rows = counted[(counted[:, 0] == boundary) & there]
            if len(rows):
                _, _, rank, determined, rings, error, error_rings, *_ = rows.T
                yield (
                    "boundary" if boundary else "inside",
                    n if n < most else f"{n} and more",
                    len(rows),
                    int(rank.min()),
                    int(rank.max()),
                    int(determined.sum()),
                    int((rings > 1).sum()),
                    float(error.max()) if error.max() > VANISHES else 0.0,
                    order_of_magnitude(error_rings.max()),
                )


def facts_of_counts(counted: np.ndarray) -> dict[str, Cell]:
    """Compare ranks and errors with those predicted by the conics through the vertices."""
    determined = counted[:, 3] > 0
    return {
        "counted": len(counted),
        "rank_mismatches": (counted[:, 2] != counted[:, 7]).sum(),
        "undetermined_percent": 100 * (~determined).mean(),
        "determined_but_widened_percent": 100 * (determined & (counted[:, 4] > 1)).mean(),
        "difference_from_conics": order_of_magnitude(counted[:, 8].max()),
    }


SPACE = (
    "vertices",
    "undetermined by one ring",
    "undetermined inside",
    "one ring",
    "two rings",
    "more rings",
    "rank at its bound, %",
    "largest error, one ring",
    "largest error",
)


def rotation_in_space(mesh: SimplexMesh) -> tuple[Cell, ...]:
    """Count the rings that vertices of a mesh in space need; measure the errors of a rotation."""
    u = rotation(mesh.points, mesh.points.mean(axis=0))
    v = normal_velocities(mesh, u)
    first, all_rings = one_ring(mesh, v), vertex_velocities(mesh, v)
    faces, cells = (np.diff(x.indptr) for x in (mesh.faces_around(), mesh.vertex_cell_incidence))
    bound = np.minimum(12, faces - cells + 1)
    return (
        len(u),
        int((~first.determined).sum()),
        int((~first.determined & ~mesh.boundary_vertices).sum()),
        *(int((all_rings.rings == r).sum()) for r in (1, 2)),
        int((all_rings.rings > 2).sum()),
        float(100 * (first.rank == bound).mean()),
        float(np.linalg.norm(first.values - u, axis=1).max()),
        order_of_magnitude(np.abs(all_rings.values - u).max()),
    )
