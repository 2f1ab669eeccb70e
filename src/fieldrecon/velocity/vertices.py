"""Velocities on meshes: from vertices to the normal velocities of faces, and back anywhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._numerics.weighted_least_squares import estimable_weights
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.weights import as_weight
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.polynomials import Frame
from fieldrecon.velocity.stencils import (
    Accumulate,
    LocalWeights,
    MatrixOfWeights,
    Stencils,
    ValuesOfWeights,
    amplification,
    as_vertices,
    fit_on_rings,
    number_that_count,
    scaled_offsets,
    weights_at,
)


def normal_velocities(mesh: SimplexMesh, u: ArrayLike) -> np.ndarray:
    """Normal velocities of the faces, v_a = n_a . (mean of u at the vertices of face a).

    Of an affine field these are its normal components at the centroids of the faces.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh.
    u : (n, ..., d) array_like
        One velocity, or several, for each vertex.

    Returns
    -------
    (f, ...) ndarray
        In the direction of `mesh.face_normals`.

    Raises
    ------
    ValueError
        If there is not a velocity of d components for each point.

    References
    ----------
    Erleben, Field Reconstruction, p. 14 and 43.

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> mesh = fr.SimplexMesh([[0, 0], [2, 0], [0, 2]], [[0, 1, 2]])
    >>> normal_velocities(mesh, [[1, 3], [1, 3], [1, 3]]) * mesh.face_measures
    array([-6., -2.,  8.])
    """
    u = as_velocities(u, mesh, len(mesh.points), "point")
    columns = u.reshape(len(u), -1, u.shape[-1])
    mean = columns[mesh.faces].mean(axis=1)
    v = np.einsum("fd,fvd->fv", mesh.face_normals, mean)
    return v.reshape(len(v), *u.shape[1:-1])


def divergence(mesh: SimplexMesh, v: ArrayLike) -> np.ndarray:
    """Discrete divergence of the cells, the outflow per volume: sum_a l_a v_a / V.

    Of an affine field this is its divergence.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh.
    v : (f, ...) array_like
        Normal velocity of each face, in the direction of `mesh.face_normals`.

    Returns
    -------
    (c, ...) ndarray
        For each cell, per unit of length.

    Examples
    --------
    >>> import fieldrecon as fr
    >>> mesh = fr.SimplexMesh([[0, 0], [2, 0], [0, 2]], [[0, 1, 2]])
    >>> divergence(mesh, normal_velocities(mesh, 3 * mesh.points)).round(12)
    array([6.])
    """
    v = as_normal_velocities(v, mesh)
    columns = v.reshape(len(v), -1)
    # l_a / V first, face by face: no product of measures leaves the range of numbers
    size = mesh.face_measures[mesh.cell_faces] / mesh.cell_measures[:, None]
    flux = mesh.cell_face_signs * size
    return np.einsum("ca,cav->cv", flux, columns[mesh.cell_faces]).reshape(-1, *v.shape[1:])


@dataclass(frozen=True)
class VertexVelocities:
    """Velocities at vertices or at other points, and the number of rings that each needed.

    Attributes
    ----------
    values : (m, ..., d) ndarray
        Velocity at each vertex or point.
    rings : (m,) ndarray of int
        Number of rings of cells whose faces entered the fit: the fewest that determine it.
    """

    values: np.ndarray
    rings: np.ndarray


def vertex_velocities(
    mesh: SimplexMesh,
    v: ArrayLike,
    weight: Radial | None = None,
    vertices: ArrayLike | None = None,
) -> VertexVelocities:
    """Velocities at vertices from the normal velocities of the faces around.

    About each vertex x_i the affine field u(x) = c_0 + sum_k (x - x_i)_k c_k that minimizes
    sum_a w_a^2 (n_a . u(p_a) - v_a)^2, with p_a the centroids of the faces of the cells round it;
    its value is u(x_i) = c_0. If those faces do not determine it, as at a vertex with three or
    four triangles, the faces of the next ring of cells are added, and so on. Only c_0 has to be
    determined, not the whole field. An affine field is reproduced exactly.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh.
    v : (f, ...) array_like
        Normal velocity, or several, of each face, in the direction of `mesh.face_normals`.
    weight : Radial, optional
        Weight w(r) of a face at the distance r of p_a, such as `inverse_square(epsilon)`; it
        enters squared, as on the slides. Without one, all faces count alike.
    vertices : (m,) array_like of int, optional
        Vertices; all points by default.

    Returns
    -------
    VertexVelocities
        `values` (m, ..., d) and `rings` (m,).

    Raises
    ------
    ValueError
        If there is not a finite normal velocity for each face.
    numpy.linalg.LinAlgError
        If all faces with a weight do not determine the velocity at a vertex; if a point belongs to
        no cell.

    References
    ----------
    Erleben, Field Reconstruction, p. 18-22. There one ring is said to suffice always; but in the
    plane its faces determine the affine field if and only if its vertices lie on no common conic.

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> mesh = fr.SimplexMesh.delaunay(fr.datasets.halton(50, 2))
    >>> rotation = mesh.points @ [[0, 1], [-1, 0]]
    >>> u = vertex_velocities(mesh, normal_velocities(mesh, rotation))
    >>> bool(abs(u.values - rotation).max() < 1e-12), u.rings.max()
    (True, np.int64(2))
    """
    v = as_normal_velocities(v, mesh)
    vertices = as_vertices(mesh, vertices)
    d = mesh.points.shape[1]
    found = ValuesOfWeights(d, len(vertices), v.reshape(len(v), -1))
    rings = _AffineVelocity(mesh, weight).at(vertices, found)
    return VertexVelocities(found.values.reshape(len(vertices), *v.shape[1:], d), rings)


def velocity_weights(
    mesh: SimplexMesh, weight: Radial | None = None, vertices: ArrayLike | None = None
) -> tuple[sparse.csr_array, ...]:
    """Weights of the normal velocities in each component of `vertex_velocities`.

    They depend only on the mesh; for a fixed mesh, compute them once.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh.
    weight : Radial, optional
        As for `vertex_velocities`.
    vertices : (m,) array_like of int, optional
        Vertices; all points by default.

    Returns
    -------
    tuple of d csr_arrays (m, f)
        The velocity is (W_1 v, ..., W_d v).

    Examples
    --------
    >>> import fieldrecon as fr
    >>> mesh = fr.SimplexMesh.delaunay(fr.datasets.halton(50, 2))
    >>> weights = velocity_weights(mesh)
    >>> v = normal_velocities(mesh, [[3.0, 4.0]] * 50)
    >>> weights[0].shape == (50, len(v)), (weights[1] @ v)[:3].round(12)
    (True, array([4., 4., 4.]))
    """
    vertices = as_vertices(mesh, vertices)
    found = MatrixOfWeights(mesh.points.shape[1], (len(vertices), len(mesh.faces)))
    _AffineVelocity(mesh, weight).at(vertices, found)
    return found.matrices()


def point_velocities(
    mesh: SimplexMesh, v: ArrayLike, x: ArrayLike, weight: Radial | None = None
) -> VertexVelocities:
    """Velocities at any points from the normal velocities of the faces around.

    The fit is the same as in `vertex_velocities`, but centred at x:
    u(y) = c_0 + sum_k (y - x)_k c_k with the weights w(|p_a - x|); the velocity at x is c_0. The
    faces belong to the first rings of cells around the nearest vertex that determine the fit.
    At a vertex the result equals `vertex_velocities`. Between vertices the velocity jumps where
    another vertex becomes the nearest, unless the weights vanish at the faces that change. An
    affine field is reproduced exactly, also outside the mesh.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh.
    v : (f, ...) array_like
        Normal velocity, or several, of each face, in the direction of `mesh.face_normals`.
    x : (m, d) array_like
        The points.
    weight : Radial, optional
        As for `vertex_velocities`.

    Returns
    -------
    VertexVelocities
        `values` (m, ..., d) and `rings` (m,).

    Raises
    ------
    ValueError
        If there is not a finite normal velocity for each face.
    numpy.linalg.LinAlgError
        If all faces with a weight do not determine the velocity at a point.

    References
    ----------
    Erleben, Field Reconstruction, p. 8-10 and 18-22.

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> mesh = fr.SimplexMesh.delaunay(fr.datasets.halton(50, 2))
    >>> rotation = mesh.points @ [[0, 1], [-1, 0]]
    >>> v = normal_velocities(mesh, rotation)
    >>> point_velocities(mesh, v, [[0.3, 0.6]]).values.round(12)
    array([[-0.6,  0.3]])
    """
    v = as_normal_velocities(v, mesh)
    x = _as_points_of(mesh, x)
    found = ValuesOfWeights(x.shape[1], len(x), v.reshape(len(v), -1))
    rings = _AffineVelocity(mesh, weight, x).at(_nearest_vertices(mesh, x), found)
    return VertexVelocities(found.values.reshape(len(x), *v.shape[1:], x.shape[1]), rings)


def point_velocity_weights(
    mesh: SimplexMesh, x: ArrayLike, weight: Radial | None = None
) -> tuple[sparse.csr_array, ...]:
    """Weights of the normal velocities in each component of `point_velocities`.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh.
    x : (m, d) array_like
        The points.
    weight : Radial, optional
        As for `vertex_velocities`.

    Returns
    -------
    tuple of d csr_arrays (m, f)
        The velocity is (W_1 v, ..., W_d v).

    Examples
    --------
    >>> import fieldrecon as fr
    >>> mesh = fr.SimplexMesh.delaunay(fr.datasets.halton(50, 2))
    >>> weights = point_velocity_weights(mesh, [[0.3, 0.6]])
    >>> v = normal_velocities(mesh, [[3.0, 4.0]] * 50)
    >>> [(w @ v).round(12).item() for w in weights]
    [3.0, 4.0]
    """
    x = _as_points_of(mesh, x)
    found = MatrixOfWeights(x.shape[1], (len(x), len(mesh.faces)))
    _AffineVelocity(mesh, weight, x).at(_nearest_vertices(mesh, x), found)
    return found.matrices()


def _as_points_of(mesh: SimplexMesh, x: ArrayLike) -> np.ndarray:
    """Points (m, d) in the space of a mesh."""
    d = mesh.points.shape[1]
    points = valid.as_queries(x, d)
    if points.ndim != 2:
        raise ValueError(f"x must have the shape (m, {d}); got {points.shape}")
    return points


def _nearest_vertices(mesh: SimplexMesh, x: np.ndarray) -> np.ndarray:
    """The vertex of a cell nearest to each point; in a tie, any of them."""
    vertices = np.flatnonzero(mesh.referenced)
    frame = Frame.around(mesh.points)
    tree = cKDTree(frame.local(mesh.points[vertices]))
    return vertices[tree.query(frame.local(x), workers=-1)[1]]


class _AffineVelocity:
    """The fits B'c = V' of affine velocity fields about vertices to the normal velocities.

    With points x, the fits are about these, on the stencils of the vertices.
    """

    def __init__(
        self, mesh: SimplexMesh, weight: Radial | None, x: np.ndarray | None = None
    ) -> None:
        self.mesh, self.x = mesh, x
        self.weight = None if weight is None else as_weight(weight)
        self.unit = Frame.around(mesh.points).scale
        first, *others = (mesh.points.take(corner, axis=0) for corner in mesh.faces.T)
        to_center = sum(other - first for other in others) / len(mesh.faces.T)
        # in one array, so that one `take` fetches all data of a face
        self.faces = np.stack([first, to_center, mesh.face_normals], axis=1)

    def at(self, vertices: np.ndarray, accumulate: Accumulate) -> np.ndarray:
        """Give the weights at vertices to `accumulate`; return the rings."""
        names = ("faces", "its velocity")
        return fit_on_rings(
            self.mesh, self.mesh.cell_face_incidence, vertices, self, accumulate, names
        )

    def __call__(self, stencils: Stencils) -> LocalWeights:
        """Weights of the faces in the velocity at each vertex."""
        corner, to_center, normals = np.moveaxis(self.faces.take(stencils.index, axis=0), 2, 0)
        # by differences of points, not of centroids, which are rounded far from the origin
        center = (
            self.mesh.points[stencils.vertices] if self.x is None else self.x[stencils.positions]
        )
        offset = corner - center[:, None] + to_center
        y, _ = scaled_offsets(offset, stencils.there)
        w = weights_at(self.weight, self.unit, offset, stencils.there)
        m, k, d = normals.shape
        b = np.empty((m, k, 1 + d, d))  # rows n, y_1 n, ..., y_d n
        b[:, :, 0] = normals
        for i, j in np.ndindex(d, d):  # numpy's loop over an axis of two or three is slow
            np.multiply(y[..., i], normals[..., j], out=b[:, :, 1 + i, j])
        c = estimable_weights(b.reshape(m, k, d + d * d), w, d)
        return LocalWeights(c, amplification(c), number_that_count(w))


def as_normal_velocities(v: ArrayLike, mesh: SimplexMesh) -> np.ndarray:
    """Data (f, ...), one entry for each face."""
    return valid.as_values(v, len(mesh.faces), "v", "face")


def as_velocities(u: ArrayLike, mesh: SimplexMesh, n: int, of: str) -> np.ndarray:
    """Velocities (n, ..., d), one for each point or cell."""
    u = valid.as_values(u, n, "u", of)
    d = mesh.points.shape[1]
    if u.ndim < 2 or u.shape[-1] != d:
        raise ValueError(
            f"u must have {d} components for each {of}, shape ({n}, ..., {d}); got {u.shape}"
        )
    return u
