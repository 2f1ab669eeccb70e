"""Where a field is more than a guess: among the samples, in a gap between them, or outside.

A place lies outside if the convex hull of the samples does not hold it; on the globe, the hull that
great circles bound, if the samples lie within a hemisphere. It lies in a gap if the sample nearest
to it has more than a few samples nearer than the place: in clouds without structure, once in a
million places. Between the tracks of a ship or the isolines of a map nearly all places lie in gaps,
and rightly so: samples along the track tell nothing of what is beside it.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError, cKDTree

from fieldrecon._core.chunks import chunked, rows_of

AMONG, GAP, OUTSIDE = 0, 1, 2
MEANINGS = ("among the samples", "in a gap", "outside")
NEIGHBORS = 16
"""Samples that the nearest one has nearer than a place in a gap."""
_HEMISPHERE = 0.1  # cosine of the angle from the middle within which hulls are drawn


def extrapolated(points: np.ndarray, x: np.ndarray, on_globe: bool = False) -> np.ndarray:
    """Tell of each query (m, d) whether it is AMONG the points (n, d), in a GAP, or OUTSIDE.

    Parameters
    ----------
    points, x : ndarray
        Samples and queries; unit vectors if on the globe.
    on_globe : bool

    Returns
    -------
    ndarray of shape (m,), of small integers

    Examples
    --------
    >>> ring = np.array([[np.cos(t), np.sin(t)] for t in np.linspace(0, 6.28, 100)])
    >>> extrapolated(ring, np.array([[0.99, 0.0], [0.0, 0.0], [2.0, 0.0]])).tolist()
    [0, 1, 2]
    """
    outside = _outside_on_globe(points, x) if on_globe else outside_hull(points, x)
    result = np.where(_in_gap(points, x), GAP, AMONG).astype(np.int8)
    result[outside] = OUTSIDE
    return result


def outside_hull(points: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Tell which queries (m, d) lie outside the convex hull of the points; its edge is inside.

    Raises
    ------
    numpy.linalg.LinAlgError
        If the points have no volume.
    """
    middle, size = points.mean(axis=0), np.ptp(points, axis=0)
    try:
        hull = ConvexHull((points - middle) / np.where(size > 0, size, 1.0))
    except QhullError:
        raise np.linalg.LinAlgError(
            f"{len(points)} points have no hull with an inside: they are too few, or lie on a line "
            "or in a plane"
        ) from None
    normals, offsets = hull.equations[:, :-1], hull.equations[:, -1]

    def outside(part: np.ndarray) -> np.ndarray:
        return ((part - middle) / size @ normals.T + offsets).max(axis=1) > 1e-9

    return _in_parts(outside, x, 8 * len(normals), bool)


def _outside_on_globe(points: np.ndarray, x: np.ndarray) -> np.ndarray:
    """By the projection from the middle of the globe, where great circles are straight lines."""
    pole = points.mean(axis=0)
    pole /= max(np.linalg.norm(pole), np.finfo(float).tiny)
    if (points @ pole).min() < _HEMISPHERE:
        return np.zeros(len(x), dtype=bool)
    basis = np.linalg.svd(pole[None, :])[2][1:]
    ahead = x @ pole > _HEMISPHERE / 2
    flat = (x[ahead] @ basis.T) / (x[ahead] @ pole)[:, None]
    result = np.ones(len(x), dtype=bool)
    result[ahead] = outside_hull((points @ basis.T) / (points @ pole)[:, None], flat)
    return result


def _in_gap(points: np.ndarray, x: np.ndarray) -> np.ndarray:
    if len(points) <= NEIGHBORS:
        return np.zeros(len(x), dtype=bool)
    tree = cKDTree(points)

    def in_gap(part: np.ndarray) -> np.ndarray:
        distance, nearest = tree.query(part)
        sites, back = np.unique(nearest, return_inverse=True)
        reach = tree.query(points[sites], [NEIGHBORS + 1])[0][:, 0]
        return distance > reach[back]

    return _in_parts(in_gap, x, 8 * 32, bool)


def _in_parts(function, x, bytes_per_row, kind):  # type: ignore[no-untyped-def]
    """The function of all queries, a chunk of them at a time."""
    result = np.empty(len(x), dtype=kind)
    for part, values in chunked(function, x, rows_of(bytes_per_row)):
        result[part] = values
    return result
