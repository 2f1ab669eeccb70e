"""Normals of a cloud of points on a surface, by principal component analysis of neighbours."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import chunked
from fieldrecon.polynomials import EPS, Frame, resolution

ROWS = 2**13
"""Points of a chunk, whose neighbourhoods fit in the cache."""


@dataclass(frozen=True)
class PointNormals:
    """Normals of points, up to their sign, and their reliability.

    Attributes
    ----------
    vectors : (n, 3) ndarray
        Unit normals of the least-squares planes through the neighbours of each point.
    planarity : (n,) ndarray
        1 - l_3 / l_2 of the variances l_1 >= l_2 >= l_3 of the neighbours: one if they lie in a
        plane, zero if no plane fits better than another.
    planar : (n,) ndarray of bool
        Whether a plane can be fitted: the variance across it is at most a quarter of both along
        it, and the neighbours do not lie on a line.
    neighbors : (n, k) ndarray of int
        The neighbours of each point, from near to far.
    """

    vectors: np.ndarray
    planarity: np.ndarray
    planar: np.ndarray
    neighbors: np.ndarray


def estimate_normals(points: ArrayLike, neighbors: int = 16) -> PointNormals:
    """Estimate the normals of a surface at points on it.

    The normal is the direction of least variance of the neighbours. A perturbation E of the
    covariance rotates the normal by about |E| / (l_2 - l_3), so only the gap between the two
    smaller variances matters.

    Parameters
    ----------
    points : (n, 3) array_like
        Points on a surface, three or more.
    neighbors : int
        Number of neighbours, the point itself included; 3 or more.

    Returns
    -------
    PointNormals
        Unit normals without orientation, and whether a plane fits.

    Raises
    ------
    ValueError
        If the points are not a finite (n, 3) array with n >= 3, or `neighbors` is less than 3.

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
    for rows, (axis, variance) in chunked(work, index, ROWS):
        normals[rows], variances[rows] = axis, variance
    least, middle, largest = np.maximum(variances, 0.0).T
    planarity = 1.0 - np.divide(least, middle, out=np.ones_like(least), where=middle > 0)
    # otherwise the rounding of the covariance rotates the normal visibly
    determined = middle - least > 1e3 * EPS * largest
    wide = middle > 16 * index.shape[1] * resolution(cloud) ** 2
    return PointNormals(normals, planarity, determined & wide & (planarity >= 0.75), index)


def _principal(coordinates: np.ndarray, index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions (m, 3) of least variance of the neighbours (m, k), and the variances (m, 3)."""
    offsets = np.take(coordinates, np.ascontiguousarray(index.T), axis=1)
    # differences first: far from the origin, squares would lose all digits
    offsets = offsets - offsets[:, :1]
    offsets -= offsets.mean(axis=1, keepdims=True)
    covariance = np.empty((len(index), 3, 3))
    for i in range(3):
        for j in range(i + 1):  # eigh reads the lower triangle
            covariance[:, i, j] = np.einsum("km,km->m", offsets[i], offsets[j])
    variances, axes = np.linalg.eigh(covariance)
    return axes[:, :, 0], variances


def as_cloud(points: ArrayLike) -> np.ndarray:
    """Validate three or more points in space, (n, 3)."""
    p = valid.as_points(points)
    if p.shape[1] != 3 or len(p) < 3:
        raise ValueError(f"points must have the shape (n, 3), n at least 3; got {p.shape}")
    return p


def nearest(p: np.ndarray, k: int) -> np.ndarray:
    """Indices (n, k) of the nearest points, the point itself first; k is at most n."""
    valid.as_count(k, "neighbors", 3, wanted="an integer, and 3 points or more")
    tree = cKDTree(p, balanced_tree=False)
    index = np.empty((len(p), min(int(k), len(p))), dtype=np.int64)
    # in the order of the leaves, neighbours are near each other in memory
    index[tree.indices] = tree.query(p[tree.indices], index.shape[1], workers=-1)[1]
    return index


def reach(p: np.ndarray, index: np.ndarray) -> np.ndarray:
    """Distance (n,) to the farthest neighbour."""
    return np.linalg.norm(p[index[:, -1]] - p, axis=1)
