"""The fit B'c = V' of the slides, and its rank and null space by singular values.

The library decides by a bound on the weights whether the velocity at a vertex is determined. Here
the rank itself is computed, and the null space a second time from the conics through the vertices.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space

from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.polynomials import monomials

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
