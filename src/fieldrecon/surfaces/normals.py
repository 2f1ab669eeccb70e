"""Normals of a cloud of points on a surface, by principal components of neighbours."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import chunked
from fieldrecon.polynomials import EPS, Frame, resolution
from fieldrecon.surfaces.principal_axes import principal_axes

ROWS = 2**13
"""Points at once: their neighbourhoods stay in the cache."""


@dataclass(frozen=True)
class PointNormals:
    """Normals of points, up to their sign, and how far they can be trusted.

    Attributes
    ----------
    vectors : (n, 3) ndarray
        Unit normals of the planes of least squares through the neighbours of each point.
    planarity : (n,) ndarray
        1 - l_3 / l_2 of the variances l_1 >= l_2 >= l_3 of the neighbours: one where they lie in a
        plane, zero where no plane is better than another.
    planar : (n,) ndarray of bool
        Whether a plane can be fitted: the variance across it is at most a quarter of either along
        it, and the neighbours lie on no line.
    neighbors : (n, k) ndarray of int
        The points that counted, from near to far.
    """

    vectors: np.ndarray
    planarity: np.ndarray
    planar: np.ndarray
    neighbors: np.ndarray


def estimate_normals(points: ArrayLike, neighbors: int = 16) -> PointNormals:
    """Normals of a surface at points on it, by principal components of their neighbours.

    The normal is the direction of least variance. Only the gap between the two smaller variances
    matters: a disturbance E of the covariance turns the normal by about |E| / (l_2 - l_3).

    Parameters
    ----------
    points : (n, 3) array_like
        Points on a surface, three or more.
    neighbors : int
        Nearest points that count, the point itself among them; 3 or more.

    Returns
    -------
    PointNormals
        Unit normals without orientation, and where they are none.

    Raises
    ------
    ValueError
        If the points are no finite (n, 3) array of three or more, or neighbors is less than 3.

    References
    ----------
    Wendland (2005), section 1.1; Hoppe et al. (1992); Davis and Kahan (1970).

    Examples
    --------
    >>> plane = np.array([[0, 0, 5], [1, 0, 5], [0, 1, 5], [1, 1, 5], [2, 1, 5]])
    >>> estimate = estimate_normals(plane, neighbors=4)
    >>> abs(estimate.vectors[0]), bool(estimate.planar.all())
    (array([0., 0., 1.]), True)
    """
    cloud = as_cloud(points)
    p = Frame.around(cloud).local(cloud)
    index = nearest(p, neighbors)
    normals, variances = np.empty((len(p), 3)), np.empty((len(p), 3))
    work = partial(_principal, np.ascontiguousarray(p.T))
    for some, (axis, variance) in chunked(work, index, ROWS):
        normals[some], variances[some] = axis, variance
    least, middle, largest = np.maximum(variances, 0.0).T
    planarity = 1.0 - np.divide(least, middle, out=np.ones_like(least), where=middle > 0)
    # beyond this the rounding of the covariance turns the normal visibly
    determined = middle - least > 1e3 * EPS * largest
    wide = middle > 16 * index.shape[1] * resolution(cloud) ** 2
    return PointNormals(normals, planarity, determined & wide & (planarity >= 0.75), index)


def _principal(coordinates: np.ndarray, index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions (m, 3) of least variance of the neighbours (m, k), and the variances (m, 3)."""
    offsets = np.take(coordinates, np.ascontiguousarray(index.T), axis=1)
    # differences first: far from the origin squares would keep no digit
    offsets = offsets - offsets[:, :1]
    offsets -= offsets.mean(axis=1, keepdims=True)
    covariance = [[np.einsum("km,km->m", a, b) for b in offsets] for a in offsets]
    variances, axes = principal_axes(np.array(covariance))
    return axes[0].T, variances.T


def as_cloud(points: ArrayLike) -> np.ndarray:
    """Three points or more in space, (n, 3)."""
    p = valid.as_points(points)
    if p.shape[1] != 3 or len(p) < 3:
        raise ValueError(f"points must have the shape (n, 3), n at least 3; got {p.shape}")
    return p


def nearest(p: np.ndarray, k: int) -> np.ndarray:
    """Indices (n, k) of the nearest points, itself first; fewer if there are not so many."""
    valid.as_count(k, "neighbors", 3, wanted="an integer, and 3 points or more")
    tree = cKDTree(p, balanced_tree=False)
    index = np.empty((len(p), min(int(k), len(p))), dtype=np.int64)
    # in the order of the leaves neighbours are found near each other in memory
    index[tree.indices] = tree.query(p[tree.indices], index.shape[1], workers=-1)[1]
    return index


def reach(p: np.ndarray, index: np.ndarray) -> np.ndarray:
    """Distance (n,) of the farthest neighbour."""
    return np.linalg.norm(p[index[:, -1]] - p, axis=1)
