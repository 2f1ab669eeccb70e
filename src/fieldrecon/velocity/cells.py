"""Velocities of cells from the normal velocities of their faces."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import chunked, rows_of
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.velocity.vertices import as_normal_velocities


@dataclass(frozen=True)
class CellVelocities:
    """Constant velocities of cells, and the residual of the data.

    Attributes
    ----------
    values : (c, ..., d) ndarray
        Velocity of each cell.
    defect : (c, ...) ndarray
        |l . v| / |l|, with l the measures of the faces and v the velocities out of the cell: the
        norm of the residual, which is the divergence of the data. It is zero for a divergence-free
        field, even one that is far from constant.
    """

    values: np.ndarray
    defect: np.ndarray


def cell_velocities(mesh: SimplexMesh, v: ArrayLike) -> CellVelocities:
    """Constant velocity of each cell by least squares on n_a . u = v_a, its d + 1 faces.

    In closed form, in the plane and in space: with h_a the height of the cell over face a and q_a
    the vertex opposite,

        u = sum_a (K - q_a) v_a / h_a ,  K = sum_a h_a^-2 q_a / sum_a h_a^-2 ,

    the field of Raviart and Thomas at the symmedian point K. For a rigid rotation in the plane it
    is the value at the circumcentre, and for an expansion the value at K. In general it differs
    from these by at most the size of the cell times the gradient.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh.
    v : (f, ...) array_like
        Normal velocity, or several, of each face, in the direction of `mesh.face_normals`.

    Returns
    -------
    CellVelocities
        `values` (c, ..., d) and `defect` (c, ...).

    References
    ----------
    Erleben, Field Reconstruction, p. 24-25 and 44; Raviart and Thomas (1977).

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> mesh = fr.SimplexMesh([[0, 0], [2, 0], [0, 2]], [[0, 1, 2]])
    >>> u = cell_velocities(mesh, fr.normal_velocities(mesh, [[1, 3]] * 3))
    >>> u.values.round(12), u.defect.round(12)
    (array([[1., 3.]]), array([0.]))
    """
    v = as_normal_velocities(v, mesh)
    cells = _Cells(mesh, v)
    values, defect = cells.vectors(), cells.scalars()

    def work(some: np.ndarray) -> np.ndarray:
        corners, height, out = cells.fluxes(some)
        least = height.min(axis=0)
        measure = least / height  # of the faces, in units of the largest
        squared = measure * measure
        size = squared.sum(axis=0)
        symmedian = (squared * corners).sum(axis=1) / size
        values[some] = _raviart_thomas(symmedian, corners, height, out)
        defect[some] = (np.abs((measure * out).sum(axis=1)) / np.sqrt(size)).T
        return some

    cells.all(work)
    return CellVelocities(cells.shaped(values), cells.shaped(defect))


def raviart_thomas(mesh: SimplexMesh, v: ArrayLike, x: ArrayLike | None = None) -> np.ndarray:
    """Field of Raviart and Thomas of lowest order, at one point for each cell.

    u(x) = sum_a (x - q_a) v_a / h_a: in each cell the field a + b x with these normal velocities.
    At the circumcentres, in the plane, expansions and rotations are reproduced exactly.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh.
    v : (f, ...) array_like
        Normal velocity, or several, of each face, in the direction of `mesh.face_normals`.
    x : (c, d) array_like, optional
        A point for each cell, inside it or not; the circumcentres by default.

    Returns
    -------
    (c, ..., d) ndarray
        Velocity at each point.

    References
    ----------
    Raviart and Thomas (1977).

    Examples
    --------
    >>> import fieldrecon as fr
    >>> mesh = fr.SimplexMesh([[0, 0], [4, 0], [0, 2]], [[0, 1, 2]])
    >>> raviart_thomas(mesh, fr.normal_velocities(mesh, 3 * mesh.points))
    array([[6., 3.]])
    """
    v = as_normal_velocities(v, mesh)
    cells = _Cells(mesh, v)
    values = cells.vectors()
    x = mesh.circumcenters if x is None else valid.as_queries(x, mesh.points.shape[1])
    if x.shape != (len(mesh.cells), mesh.points.shape[1]):
        wanted = (len(mesh.cells), mesh.points.shape[1])
        raise ValueError(f"x must be one point for each cell, shape {wanted}; got {x.shape}")

    def work(some: np.ndarray) -> np.ndarray:
        at = (x[some] - mesh.points[mesh.cells[some, 0]]).T
        values[some] = _raviart_thomas(at, *cells.fluxes(some))
        return some

    cells.all(work)
    return cells.shaped(values)


class _Cells:
    """The cells with their data; in all arrays, cells are the last axis, which is contiguous."""

    def __init__(self, mesh: SimplexMesh, v: np.ndarray) -> None:
        self.mesh = mesh
        self.shape = v.shape[1:]
        self.columns = np.ascontiguousarray(v.reshape(len(v), -1).T)
        self.points = np.ascontiguousarray(mesh.points.T)
        self.normals = np.ascontiguousarray(mesh.face_normals.T)

    def scalars(self) -> np.ndarray:
        """Empty array of a real number for each cell and column."""
        return np.empty((len(self.mesh.cells), len(self.columns)))

    def vectors(self) -> np.ndarray:
        """Empty array of a vector for each cell and column."""
        shape = (len(self.mesh.cells), len(self.columns), len(self.points))
        return np.empty(shape, dtype=self.columns.dtype)

    def shaped(self, result: np.ndarray) -> np.ndarray:
        """The result, reshaped to the axes of the data."""
        return result.reshape(len(result), *self.shape, *result.shape[2:])

    def all(self, work: Callable[[np.ndarray], np.ndarray]) -> None:
        """Call `work` for all cells, in chunks on threads."""
        d = len(self.points)
        rows = rows_of(8 * (d + 1) * (3 * d + 2 * len(self.columns) * d))
        for _ in chunked(work, np.arange(len(self.mesh.cells)), rows):
            pass

    def fluxes(self, some: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Vertices (d, a, m) from the first one, heights (a, m), outward fluxes (columns, a, m)."""
        vertices = np.ascontiguousarray(self.mesh.cells[some].T)
        faces = np.ascontiguousarray(self.mesh.cell_faces[some].T)
        corners = self.points.take(vertices, axis=1)
        corners -= corners[:, :1].copy()
        # from the vertex opposite to another one, which lies on the face
        across = np.roll(corners, -1, axis=1) - corners
        height = np.abs((self.normals.take(faces, axis=1) * across).sum(axis=0))
        signs = self.mesh.cell_face_signs[some].T
        return corners, height, self.columns.take(faces, axis=1) * signs


def _raviart_thomas(
    x: np.ndarray, corners: np.ndarray, height: np.ndarray, out: np.ndarray
) -> np.ndarray:
    """The field (m, columns, d) at one point (d, m) for each cell."""
    flux = (out / height)[:, None]
    return ((x[:, None] - corners) * flux).sum(axis=2).transpose(2, 0, 1)
