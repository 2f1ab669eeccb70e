"""Kirchhoff plates: bending by the finite element of Morley, in terms of face normals."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from fieldrecon._core import validation as valid
from fieldrecon.meshes.simplex_mesh import SimplexMesh


def isotropic_rigidity(rigidity: ArrayLike, poisson: float) -> np.ndarray:
    """Moments per curvature of isotropic plates.

    D ((1 - ν) ∇²w + ν tr(∇²w) I), as a matrix for the curvatures (w_xx, w_yy, 2 w_xy).

    Parameters
    ----------
    rigidity : (...) array_like
        Bending rigidity D, force times length: E t³ / (12 (1 - ν²)) of a plate of thickness t, and
        E t h² / (2 (1 - ν²)) of two skins of thickness t whose middles are a distance h apart.
    poisson : float
        Poisson's ratio ν.

    Returns
    -------
    (..., 3, 3) ndarray

    Examples
    --------
    >>> isotropic_rigidity(2.0, 0.5).tolist()
    [[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 0.5]]
    """
    nu = poisson
    shape = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    return np.asarray(rigidity, dtype=float)[..., None, None] * shape


def hessians(mesh: SimplexMesh) -> sparse.csr_array:
    """Second derivatives in cells, from values at vertices and normal derivatives of faces.

    By the theorem of Gauss, with the mean of the gradient along each side,

        V ∇²w = sum_a l_a (g_a n_a + (w_j - w_i) / l_a e_a) n_a^T,   e_a from vertex i to j,

    which is exact for polynomials of degree two: they are the shape functions of Morley's element.

    Parameters
    ----------
    mesh : SimplexMesh
        A mesh of triangles.

    Returns
    -------
    (3 c, n + f) csr_array
        Takes values w (n,) and derivatives g (f,) along `mesh.face_normals`, one after the other,
        to w_xx, w_yy and 2 w_xy of the first cell, then of the second, and so on.

    References
    ----------
    Morley, The triangular equilibrium element in the solution of plate bending problems (1968).

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> mesh = fr.SimplexMesh([[0, 0], [2, 0], [0, 2]], [[0, 1, 2]])
    >>> x, y = mesh.points.T  # of w = x y, whose gradient is (y, x)
    >>> slopes = (mesh.face_normals * mesh.face_centers[:, ::-1]).sum(axis=1)
    >>> (hessians(mesh) @ np.concatenate([x * y, slopes])).round(12) + 0.0
    array([0., 0., 2.])
    """
    if mesh.points.shape[1] != 2:
        raise ValueError(f"mesh must lie in the plane; got {mesh.points.shape[1]} coordinates")
    n, c = len(mesh.points), len(mesh.cells)
    a = mesh.cell_faces
    outward = (mesh.cell_face_signs / mesh.cell_measures[:, None])[..., None]
    normal, length = mesh.face_normals[a], mesh.face_measures[a][..., None]
    start, end = np.moveaxis(mesh.faces[a], 2, 0)
    along = (mesh.points[end] - mesh.points[start]) / length
    by_slope = outward * length * _products(normal, normal)
    by_rise = outward * _products(along, normal)
    columns = np.stack([n + a, end, start], axis=2)[..., None]
    entries = np.stack([by_slope, by_rise, -by_rise], axis=2)
    rows = 3 * np.arange(c)[:, None, None, None] + np.arange(3)
    where = [np.broadcast_to(k, entries.shape).ravel() for k in (rows, columns)]
    return sparse.csr_array((entries.ravel(), where), shape=(3 * c, n + len(mesh.faces)))


def _products(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Components xx, yy and xy + yx of the matrices a b^T."""
    diagonal = a * b
    mixed = a[..., 0] * b[..., 1] + a[..., 1] * b[..., 0]
    return np.concatenate([diagonal, mixed[..., None]], axis=-1)


class Plate:
    """A Kirchhoff plate, partly clamped, under transverse forces.

    Its deflection minimizes the energy among Morley's shape functions,

        1/2 ∫ κ^T D κ - sum_i f_i w_i,   κ = (w_xx, w_yy, 2 w_xy),

    by Kirchhoff's theory: thin plates, small deflections, normals remain normal. The element is
    nonconforming and slightly too soft; the error of the deflection is of second order in the cell
    size.

    Parameters
    ----------
    mesh : SimplexMesh
        The plate's middle plane, a mesh of triangles.
    rigidity : (3, 3) or (c, 3, 3) array_like
        Moments per curvature D, of all cells or of each, such as `isotropic_rigidity`.
    clamped : (n,) array_like of bool
        Vertices with zero deflection; on faces between them the normal derivative is zero, too.

    Attributes
    ----------
    stiffness : (n + f, n + f) csr_array
        For values at vertices and normal derivatives of faces, before clamping.

    Raises
    ------
    ValueError
        If an argument has the wrong form, a rigidity is not symmetric positive definite, or a
        point belongs to no cell.
    numpy.linalg.LinAlgError
        If a part of the plate has no clamped face, so that its deflection is not determined.

    References
    ----------
    Morley, The triangular equilibrium element in the solution of plate bending problems (1968).

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> x, y = (a.ravel() for a in np.meshgrid(np.linspace(0, 4, 33), np.linspace(0, 1, 9)))
    >>> mesh = fr.SimplexMesh.delaunay(np.column_stack([x, y]))
    >>> plate = Plate(mesh, isotropic_rigidity(1.0, 0.0), clamped=x == 0)
    >>> tip = np.where(x == 4, 1 / 9, 0.0)  # a force of one in all, on the end of a beam
    >>> round(float(tip @ plate.deflections(tip)), 1)  # L^3 / 3 = 21.3
    21.4
    """

    def __init__(self, mesh: SimplexMesh, rigidity: ArrayLike, clamped: ArrayLike) -> None:
        self.mesh = mesh
        n, c = len(mesh.points), len(mesh.cells)
        held = _as_held(clamped, mesh)
        curvature = hessians(mesh)
        weighed = _as_rigidity(rigidity, c) * mesh.cell_measures[:, None, None]
        blocks = sparse.bsr_array((weighed, np.arange(c), np.arange(c + 1)), shape=(3 * c, 3 * c))
        self.stiffness = sparse.csr_array(curvature.T @ blocks @ curvature)
        self._free = np.flatnonzero(~held)
        self._moving = self._free[self._free < n]
        free = self.stiffness[self._free][:, self._free]
        # Deflections are lengths and normal derivatives are not: unit diagonal, in any unit.
        self._scale = 1 / np.sqrt(free.diagonal())
        scaling = sparse.diags_array(self._scale)
        self._factor = splu((scaling @ free @ scaling).tocsc())

    def deflections(self, forces: ArrayLike) -> np.ndarray:
        """Deflections w (n, ...) of the vertices under transverse forces.

        Parameters
        ----------
        forces : (n, ...) array_like
            A force at each vertex, for one or several load cases. Forces on clamped vertices go to
            the supports.

        Returns
        -------
        (n, ...) ndarray
        """
        f = valid.as_values(forces, len(self.mesh.points), "forces")
        given = f.reshape(len(f), -1)
        right = np.zeros((len(self._free), given.shape[1]))
        scale = self._scale[: len(self._moving), None]
        right[: len(self._moving)] = scale * given[self._moving]
        w = np.zeros_like(given)
        w[self._moving] = scale * self._factor.solve(right)[: len(self._moving)]
        return w.reshape(f.shape)


def _as_held(clamped: ArrayLike, mesh: SimplexMesh) -> np.ndarray:
    """Which values and normal derivatives (n + f,) are zero."""
    vertices = np.asarray(clamped)
    if vertices.shape != (len(mesh.points),) or vertices.dtype != bool:
        raise ValueError(
            f"clamped must tell of each of the {len(mesh.points)} points whether it is; got the "
            f"shape {vertices.shape} and the type {vertices.dtype}"
        )
    if not mesh.referenced.all():
        raise ValueError(f"mesh has points that belong to no cell, {np.argmin(mesh.referenced)}")
    faces = vertices[mesh.faces].all(axis=1)
    one, two = mesh.face_cells[mesh.face_cells[:, 1] >= 0].T
    c = len(mesh.cells)
    parts, part = connected_components(sparse.coo_array((np.ones(len(one)), (one, two)), (c, c)))
    loose = np.setdiff1d(np.arange(parts), part[mesh.face_cells[faces, 0]])
    if len(loose):
        cell = int(np.argmax(part == loose[0]))
        raise np.linalg.LinAlgError(
            f"the part of the plate about cell {cell} has no clamped face, and may move as it "
            "likes: clamp both vertices of a face, or more"
        )
    return np.concatenate([vertices, faces])


def _as_rigidity(rigidity: ArrayLike, c: int) -> np.ndarray:
    """Moments per curvature (c, 3, 3)."""
    d = np.asarray(rigidity, dtype=float)
    if d.shape not in ((3, 3), (c, 3, 3)):
        raise ValueError(f"rigidity must have the shape (3, 3) or ({c}, 3, 3); got {d.shape}")
    d = np.broadcast_to(d, (c, 3, 3))
    symmetric = np.isfinite(d).all() and np.allclose(d, d.swapaxes(1, 2), rtol=1e-12, atol=0)
    if not symmetric or not (np.linalg.eigvalsh(d) > 0).all():
        raise ValueError("rigidity must be symmetric and positive definite, and finite")
    return d
