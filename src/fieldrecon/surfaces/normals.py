"""Normals of points on a surface or on a plane curve, by principal component analysis."""

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

_NEIGHBORS = {2: 7, 3: 16}  # to which a line or a plane is fitted, by dimension


@dataclass(frozen=True)
class PointNormals:
    """Normals of points, up to their sign, and their reliability.

    Attributes
    ----------
    vectors : (n, d) ndarray
        Unit normals of the least-squares planes through the neighbours of each point; of lines in
        the plane.
    deviations : (n, d) ndarray
        Standard deviations of the neighbours along their principal axes, decreasing: lengths. Their
        squares are the variances l_1 >= ... >= l_d; the last is the one across the plane.
    planarity : (n,) ndarray
        1 - l_d / l_(d-1): one if the neighbours lie in a plane (on a line), zero if no plane fits
        better than another.
    planar : (n,) ndarray of bool
        Whether a plane can be fitted: the variance across it is at most a quarter of those along
        it, and the neighbours do not lie on a line in space, or at one point.
    neighbors : (n, k) ndarray of int
        The neighbours of each point, from near to far.
    """

    vectors: np.ndarray
    deviations: np.ndarray
    planarity: np.ndarray
    planar: np.ndarray
    neighbors: np.ndarray


def estimate_normals(points: ArrayLike, neighbors: int | None = None) -> PointNormals:
    """Estimate the normals of a surface, or of a curve in the plane, at points on it.

    The normal is the direction of least variance of the neighbours. A perturbation E of the
    covariance rotates the normal by about |E| / (l_(d-1) - l_d), so only the gap between the two
    smallest variances matters.

    Parameters
    ----------
    points : (n, d) array_like
        Points on a surface (d = 3) or a plane curve (d = 2), three or more.
    neighbors : int, optional
        Number of neighbours, the point itself included; 3 or more. By default 16 on a surface and
        7 on a curve.

    Returns
    -------
    PointNormals
        Unit normals without orientation, and whether a plane fits.

    Raises
    ------
    ValueError
        If the points are not a finite (n, 2) or (n, 3) array with n >= 3, or `neighbors` is less
        than 3.

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
    cloud = as_cloud(points, (2, 3))
    frame = Frame.around(cloud)
    p = frame.local(cloud)
    index = nearest(p, _NEIGHBORS[p.shape[1]] if neighbors is None else neighbors)
    normals, variances = np.empty(p.shape), np.empty(p.shape)
    work = partial(_principal, np.ascontiguousarray(p.T))
    for rows, (axis, variance) in chunked(work, index, ROWS):
        normals[rows], variances[rows] = axis, variance
    variances = np.maximum(variances, 0.0)
    least, middle, largest = variances[:, 0], variances[:, 1], variances[:, -1]
    deviations = np.sqrt(variances[:, ::-1] / index.shape[1]) * frame.scale
    planarity = 1.0 - np.divide(least, middle, out=np.ones_like(least), where=middle > 0)
    # otherwise the rounding of the covariance rotates the normal visibly
    determined = middle - least > 1e3 * EPS * largest
    wide = middle > 16 * index.shape[1] * resolution(cloud) ** 2
    planar = determined & wide & (planarity >= 0.75)
    return PointNormals(normals, deviations, planarity, planar, index)


def _principal(coordinates: np.ndarray, index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions (m, d) of least variance of the neighbours (m, k), and the variances (m, d)."""
    offsets = np.take(coordinates, np.ascontiguousarray(index.T), axis=1)
    # differences first: far from the origin, squares would lose all digits
    offsets = offsets - offsets[:, :1]
    offsets -= offsets.mean(axis=1, keepdims=True)
    d = len(offsets)
    covariance = np.empty((len(index), d, d))
    for i in range(d):
        for j in range(i + 1):  # eigh reads the lower triangle
            covariance[:, i, j] = np.einsum("km,km->m", offsets[i], offsets[j])
    variances, axes = np.linalg.eigh(covariance)
    return axes[:, :, 0], variances


def as_cloud(points: ArrayLike, dimensions: tuple[int, ...] = (3,), least: int = 3) -> np.ndarray:
    """Validate three or more points in space, or of another dimension or least number."""
    p = valid.as_points(points, none_allowed=least == 0)
    if p.shape[1] not in dimensions or len(p) < least:
        shapes = " or ".join(f"(n, {d})" for d in dimensions)
        raise ValueError(f"points must have the shape {shapes}, n at least {least}; got {p.shape}")
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
