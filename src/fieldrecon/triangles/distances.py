"""Distances of points to triangles in space."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, chunked
from fieldrecon._core.geometry import triangle_normals
from fieldrecon.triangles.audit import as_surface

_ROWS = 4096
_VERTICES = 6


def distances_to_triangles(
    x: ArrayLike, points: ArrayLike, triangles: ArrayLike, *, progress: Progress | None = None
) -> np.ndarray:
    """Distances of points to the triangles around their nearest vertices.

    They are the distances to the surface where its triangles are about as long as they are wide,
    and upper bounds elsewhere.

    Parameters
    ----------
    x : (k, 3) array_like
    points : (n, 3) array_like
        Vertices.
    triangles : (m, 3) array_like of int
    progress : callable, optional
        Called as progress(done, total) with numbers of points.

    Returns
    -------
    (k,) ndarray
        Infinite if there are no triangles.

    References
    ----------
    Ericson, Real-time collision detection (2005), section 5.1.5.

    Examples
    --------
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    >>> queries = np.array([[0.2, 0.2, 3.0], [-1, 0, 0], [1, 1, 0]])
    >>> distances_to_triangles(queries, corners, np.array([[0, 1, 2]])).round(6)
    array([3.      , 1.      , 0.707107])
    """
    x = valid.as_points(x, "x", none_allowed=True)
    points, triangles = as_surface(points, triangles)
    if not len(triangles):
        return np.full(len(x), np.inf)
    middle = points.mean(axis=0)
    p = points - middle
    used = np.unique(triangles)
    tree = cKDTree(p[used])
    rows, corners = np.repeat(np.arange(len(triangles)), 3), triangles.ravel()
    incidence = sparse.csr_array(
        (np.ones(len(rows), dtype=np.int8), (corners, rows)), shape=(len(p), len(triangles))
    )

    def work(queries: np.ndarray) -> np.ndarray:
        nearest = tree.query(queries, range(1, min(_VERTICES, len(used)) + 1))[1]
        incident = incidence[used[nearest.ravel()]]
        row = np.repeat(np.arange(nearest.size) // nearest.shape[1], np.diff(incident.indptr))
        squared = _squared(queries[row], p[triangles[incident.indices]])
        least = np.full(len(queries), np.inf)
        np.minimum.at(least, row, squared)
        return np.sqrt(least)

    result = np.empty(len(x))
    for part, found in chunked(work, x - middle, _ROWS, progress=progress):
        result[part] = found
    return result


def _squared(x: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Squared distance (k,) of each point (k, 3) to its triangle (k, 3, 3)."""
    a, b, c = corners.swapaxes(0, 1)
    normal = triangle_normals(a, b, c)
    inside = np.ones(len(x), dtype=bool)
    least = np.full(len(x), np.inf)
    for p, q in ((a, b), (b, c), (c, a)):
        along, to = q - p, x - p
        inside &= np.einsum("kd,kd->k", np.cross(normal, along), to) >= 0
        length = np.einsum("kd,kd->k", along, along)
        share = np.clip(np.einsum("kd,kd->k", to, along) / np.where(length > 0, length, 1), 0, 1)
        least = np.minimum(least, ((to - share[:, None] * along) ** 2).sum(axis=1))
    size = np.einsum("kd,kd->k", normal, normal)
    height = np.einsum("kd,kd->k", normal, x - a) ** 2 / np.where(size > 0, size, 1)
    return np.where(inside & (size > 0), height, least)
