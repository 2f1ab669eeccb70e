"""Adaptation of sites to a field: refinement where it is rough, coarsening where it is smooth."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull, cKDTree

from fieldrecon._core import validation as valid


def adapted_points(
    points: ArrayLike,
    indicator: ArrayLike,
    *,
    refine: float,
    coarsen: float,
    spacing: float,
    widest: float = np.inf,
) -> np.ndarray:
    """Refine points where an indicator of the error is large, and coarsen where it is small.

    Where the indicator exceeds `refine`, the midpoints between a point and its 2 d nearest
    neighbours are added, except those nearer than `spacing` to another point. Where it is below
    `coarsen`, points are removed in the order of the indicator, except neighbours of removed
    points and corners of the convex hull.

    Parameters
    ----------
    points : (n, d) array_like
        Distinct points.
    indicator : (n,) array_like
        An estimate of the error near each point, such as the absolute residuals of
        `leave_one_out`.
    refine, coarsen : float
        Bounds of the indicator, coarsen <= refine.
    spacing : float
        The smallest distance of new points from others: a positive length.
    widest : float
        Points farther than this length from their nearest neighbour are not removed.

    Returns
    -------
    (m, d) ndarray
        The remaining points in their order, then the new ones.

    Raises
    ------
    ValueError
        If an argument has the wrong form.

    References
    ----------
    Behrens and Iske, Grid-free adaptive semi-Lagrangian advection using radial basis functions
    (2002); Wendland (2005), section 1.3.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.arange(6.0)[:, None]
    >>> np.sort(adapted_points(x, [0, 0, 0, 0, 9, 0], refine=1, coarsen=0.1, spacing=0.3).ravel())
    array([0. , 2. , 3.5, 4. , 4.5, 5. ])
    """
    x = valid.as_points(points)
    eta = valid.as_values(indicator, len(x), "indicator")
    if eta.ndim != 1 or not coarsen <= refine:
        raise ValueError(
            "indicator must hold one number for each point, and coarsen be at most refine; got the "
            f"shape {eta.shape}, {coarsen!r} and {refine!r}"
        )
    spacing = valid.as_length(spacing, "spacing")
    near = _neighbors(x)
    fresh = _apart(x, _midpoints(x, near, eta > refine), spacing)
    removable = (eta < coarsen) & (_distances(x, near) <= widest)
    return np.vstack([x[_remaining(x, near, eta, removable)], fresh])


def _neighbors(x: np.ndarray) -> np.ndarray:
    """The 2 d nearest neighbours (n, 2 d) of each point, or all other points."""
    n, d = x.shape
    k = min(2 * d, n - 1)
    return cKDTree(x).query(x, k + 1)[1].reshape(n, k + 1)[:, 1:]


def _midpoints(x: np.ndarray, near: np.ndarray, where: np.ndarray) -> np.ndarray:
    """Midpoints (m, d) between the points of a mask and their neighbours."""
    ends = np.broadcast_to(x[where][:, None], (*near[where].shape, x.shape[1]))
    middle = ends / 2 + x[near[where]] / 2
    return middle.reshape(-1, x.shape[1])


def _apart(x: np.ndarray, fresh: np.ndarray, spacing: float) -> np.ndarray:
    """Keep the new points at least `spacing` from the old ones and from those kept before."""
    if not len(fresh):
        return fresh
    fresh = fresh[cKDTree(x).query(fresh)[0] >= spacing]
    open_ = np.ones(len(fresh), dtype=bool)
    near = cKDTree(fresh).query_ball_point(fresh, spacing * (1 - 1e-12)) if len(fresh) else []
    for i, others in enumerate(near):
        if open_[i]:
            open_[[j for j in others if j > i]] = False
    return fresh[open_]


def _distances(x: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Distance of each point from its nearest neighbour."""
    return np.linalg.norm(x[:, None] - x[near], axis=2).min(axis=1, initial=np.inf)


def _remaining(
    x: np.ndarray, near: np.ndarray, eta: np.ndarray, removable: np.ndarray
) -> np.ndarray:
    """Mask of the remaining points; removable points are tried in the order of the indicator."""
    remains = np.ones(len(x), dtype=bool)
    removable[_corners(x)] = False
    for i in np.argsort(eta, kind="stable"):
        if removable[i] and remains[near[i]].all():
            remains[i] = False
            removable[near[i]] = False
    return remains


def _corners(x: np.ndarray) -> np.ndarray:
    """Corners of the convex hull."""
    if x.shape[1] == 1:
        return np.array([x.argmin(), x.argmax()])
    return ConvexHull(x).vertices
