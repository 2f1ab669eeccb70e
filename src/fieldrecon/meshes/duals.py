"""Two duals of a mesh, which join circumcentres or centroids across the faces."""

from __future__ import annotations

import numpy as np

from fieldrecon.meshes.simplex_mesh import SimplexMesh


def circumcentric_dual(mesh: SimplexMesh) -> tuple[np.ndarray, np.ndarray]:
    """Dual edges between the circumcentres of the cells at each face.

    On the boundary they end at the circumcentre of the face. Each is perpendicular to its face. In
    a Delaunay mesh they are the edges of the Voronoi cells of the vertices; otherwise some run
    backwards, from the second cell to the first, and cross others.

    Parameters
    ----------
    mesh : SimplexMesh

    Returns
    -------
    segments : (f, 2, d) ndarray
        Start, in the first cell of the face, and end. Cells with the same circumcentre have a dual
        edge of length zero.
    faces : (f,) ndarray
        Face of each segment: all faces, in order.

    References
    ----------
    Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 32).

    Examples
    --------
    >>> mesh = SimplexMesh([[0, 0], [2, 0], [2, 2], [0, 2]], [[0, 1, 2], [0, 2, 3]])
    >>> segments, faces = circumcentric_dual(mesh)
    >>> mesh.faces[faces[0]].tolist(), segments[0].tolist()
    ([0, 1], [[1.0, 1.0], [1.0, 0.0]])
    >>> mesh.faces[faces[1]].tolist(), segments[1].tolist()
    ([0, 2], [[1.0, 1.0], [1.0, 1.0]])
    """
    one, two = mesh.face_cells.T
    inside = (two >= 0)[:, None]
    ends = np.where(inside, mesh.circumcenters[two], mesh.face_circumcenters)
    return np.stack([mesh.circumcenters[one], ends], axis=1), np.arange(len(mesh.faces))


def barycentric_dual(mesh: SimplexMesh) -> tuple[np.ndarray, np.ndarray]:
    """Dual edges from the centroid of each cell to the centroids of its faces.

    They stay inside the cells and never cross, in any mesh, but are in general not perpendicular
    to the faces, and have a bend at each.

    Parameters
    ----------
    mesh : SimplexMesh

    Returns
    -------
    segments : ((d + 1) c, 2, d) ndarray
        Start, at the centroid of a cell, and end.
    faces : ((d + 1) c,) ndarray
        Face at the end of each segment.

    Examples
    --------
    >>> mesh = SimplexMesh([[0, 0], [6, 0], [0, 6]], [[0, 1, 2]])
    >>> barycentric_dual(mesh)[0].tolist()
    [[[2.0, 2.0], [3.0, 3.0]], [[2.0, 2.0], [0.0, 3.0]], [[2.0, 2.0], [3.0, 0.0]]]
    """
    faces = mesh.cell_faces.ravel()
    starts = np.repeat(mesh.cell_centers, mesh.cell_faces.shape[1], axis=0)
    return np.stack([starts, mesh.face_centers[faces]], axis=1), faces
