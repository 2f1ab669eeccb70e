"""Vertex velocities from cell velocities, by the Voronoi coordinates of the vertices."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from fieldrecon._numerics.weighted_least_squares import estimable_weights
from fieldrecon.barycentric.voronoi import voronoi_weights
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.polynomials import monomials
from fieldrecon.velocity.stencils import (
    LocalWeights,
    MatrixOfWeights,
    Stencils,
    amplification,
    as_vertices,
    fit_on_rings,
    scaled_offsets,
)
from fieldrecon.velocity.vertices import as_velocities


def vertex_velocities_from_cells(
    mesh: SimplexMesh, u: ArrayLike, vertices: ArrayLike | None = None
) -> np.ndarray:
    """Velocities at vertices from those at the circumcentres of the cells.

    The weighted mean by `circumcenter_weights`. Affine fields are reproduced exactly.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh.
    u : (c, ..., d) array_like
        One velocity, or several, for each cell, at its circumcentre.
    vertices : (m,) array_like of int, optional
        Vertices; all points by default.

    Returns
    -------
    (m, ..., d) ndarray
        Velocity at each vertex.

    Raises
    ------
    ValueError
        If there is not a velocity of d components for each cell.
    numpy.linalg.LinAlgError
        If a point belongs to no cell; if all the cells do not determine an affine field at a
        vertex on the boundary.

    References
    ----------
    Erleben, Field Reconstruction, p. 26 and 33-37.

    Examples
    --------
    >>> import fieldrecon as fr
    >>> mesh = fr.SimplexMesh.delaunay(fr.datasets.halton(50, 2))
    >>> u = vertex_velocities_from_cells(mesh, 3 * mesh.circumcenters)
    >>> bool(abs(u - 3 * mesh.points).max() < 1e-12)
    True
    """
    u = as_velocities(u, mesh, len(mesh.cells), "cell")
    values = circumcenter_weights(mesh, vertices) @ u.reshape(len(u), -1)
    return values.reshape(-1, *u.shape[1:])


def circumcenter_weights(mesh: SimplexMesh, vertices: ArrayLike | None = None) -> sparse.csr_array:
    """Weights of data at the circumcentres of the cells in the values at vertices.

    Inside, the Voronoi coordinates of the vertex in its own dual cell: of cell a with the vertices
    x_i and x_b it is proportional to

        V_a / prod_b |x_b - x_i|^2 ,

    which is positive. On the boundary, where the dual cell is open, a moving least squares fit of
    an affine function, with the weight 1/(r^2 + rho^2), to the circumcentres of the cells of one,
    two, ... rings, as many as determine it; rho is the distance of the nearest circumcentre, so
    that the far ones of flat cells on the boundary count little.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh.
    vertices : (m,) array_like of int, optional
        Vertices; all points by default.

    Returns
    -------
    (m, c) csr_array
        Rows that sum to one; times the circumcentres they give the vertices.

    Raises
    ------
    numpy.linalg.LinAlgError
        As `vertex_velocities_from_cells`.

    References
    ----------
    Erleben, Field Reconstruction, p. 36-37 with x = x_i, where the factors of the denominators,
    (x_b - x_i)^T (p_a - x_i), are |x_b - x_i|^2 / 2.

    Examples
    --------
    >>> import fieldrecon as fr
    >>> square = [[0, 0], [2, 0], [2, 2], [0, 2], [1, 1]]
    >>> mesh = fr.SimplexMesh(square, [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    >>> circumcenter_weights(mesh, [4]).toarray()
    array([[0.25, 0.25, 0.25, 0.25]])
    """
    vertices = as_vertices(mesh, vertices)
    open_ = mesh.boundary_vertices[vertices]
    # the vertices with closed cells first, then those with open ones
    closed = voronoi_weights(mesh, vertices[~open_], mesh.points[vertices[~open_]])
    found = MatrixOfWeights(1, (int(open_.sum()), len(mesh.cells)))
    names = ("circumcentres", "an affine field at it")
    fit_on_rings(mesh, None, vertices[open_], _AffineFit(mesh), found, names)
    order = np.argsort(np.concatenate([np.flatnonzero(~open_), np.flatnonzero(open_)]))
    return sparse.csr_array(sparse.vstack([closed, *found.matrices()], format="csr")[order])


class _AffineFit:
    """Fits of affine functions to values at the circumcentres about vertices."""

    def __init__(self, mesh: SimplexMesh) -> None:
        self.mesh = mesh

    def __call__(self, stencils: Stencils) -> LocalWeights:
        """Weights of the cells in the value at each vertex."""
        offset = (
            self.mesh.circumcenters[stencils.index] - self.mesh.points[stencils.vertices][:, None]
        )
        y, _ = scaled_offsets(offset, stencils.there)
        squared = np.einsum("mkd,mkd->mk", y, y)
        nearest = np.where(stencils.there, squared, np.inf).min(axis=1)
        w = np.where(stencils.there, 2 / (1 + squared / nearest[:, None]), 0.0)
        c = estimable_weights(monomials(y, 1), w, 1)
        return LocalWeights(c, amplification(c), np.count_nonzero(w, axis=1))
