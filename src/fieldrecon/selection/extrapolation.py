"""Extrapolation: whether a query lies among the samples, in a gap between them, or outside.

A query lies outside if it is not in the convex hull of the samples; on the globe, the hull is
bounded by great circles, and exists if the samples lie within a hemisphere. A query lies in a gap
if its nearest sample has at least 16 other samples closer to it than the query. In clouds without
structure this happens once in a million queries. Between the tracks of a ship or the isolines of a
map nearly all queries lie in gaps: samples along a track do not determine the field beside it.
Where the error is validated by samples that are held out, up to a distance from the others, only
queries beyond this distance are extrapolated.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError, cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import chunked, rows_of
from fieldrecon.selection.distance_matching import nearest_neighbor_distances

AMONG, GAP, OUTSIDE = 0, 1, 2
MEANINGS = ("among the samples", "in a gap", "outside")
NEIGHBORS = 16
"""Number of samples that are closer to the nearest sample than a query in a gap is."""
_HEMISPHERE = 0.1  # least cosine of the angle between the samples and their mean direction


def extrapolated(
    points: np.ndarray, x: np.ndarray, on_globe: bool = False, validated: float | None = None
) -> np.ndarray:
    """Classify queries (m, d): AMONG the points (n, d), in a GAP, or OUTSIDE.

    Parameters
    ----------
    points, x : ndarray
        Samples and queries; unit vectors if on the globe.
    on_globe : bool
    validated : float, optional
        Distance from the nearest sample up to which a query is AMONG the points, and beyond which
        it is in a GAP or OUTSIDE. By default the samples near by decide.

    Returns
    -------
    ndarray of shape (m,), of small integers

    Examples
    --------
    >>> ring = np.array([[np.cos(t), np.sin(t)] for t in np.linspace(0, 6.28, 100)])
    >>> extrapolated(ring, np.array([[0.99, 0.0], [0.0, 0.0], [2.0, 0.0]])).tolist()
    [0, 1, 2]
    """
    points = valid.as_points(points)
    x = valid.as_queries(x, points.shape[1])
    outside = _outside_on_globe(points, x) if on_globe else outside_hull(points, x)
    if validated is None:
        result = np.where(_in_gap(points, x), GAP, AMONG).astype(np.int8)
        result[outside] = OUTSIDE
        return result
    far = nearest_neighbor_distances(points, x) > validated
    return np.where(far, np.where(outside, OUTSIDE, GAP), AMONG).astype(np.int8)


def outside_hull(points: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Whether queries (m, d) lie outside the convex hull of the points; its boundary is inside.

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
    """By central projection, under which great circles are straight lines."""
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
    """The function of all queries, in chunks."""
    result = np.empty(len(x), dtype=kind)
    for part, values in chunked(function, x, rows_of(bytes_per_row)):
        result[part] = values
    return result
