"""Points off a surface with signed distances, which keep a field from vanishing everywhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon.polynomials import EPS
from fieldrecon.surfaces.normals import as_cloud

_MAX_ROUNDS = 50  # a ball that still shrinks touches a point to rounding
_MARGIN = 0.5  # of the radius of the empty ball
_LEAST = 0.05  # of the requested distance: nearer points are dropped


@dataclass(frozen=True, eq=False)
class OffSurface:
    """Points off a surface.

    Attributes
    ----------
    points : (m, 3) ndarray
    values : (m,) ndarray
        Signed distances from the surface, positive inside.
    sites : (m,) ndarray of int
        The point of the surface from which each was made, which is the nearest.
    """

    points: np.ndarray
    values: np.ndarray
    sites: np.ndarray


def off_surface_points(
    points: ArrayLike, normals: ArrayLike, distance: float | None = None
) -> OffSurface:
    """Points p_j +- d_j n_j along the normals, with the values -d_j outside and +d_j inside.

    p_j must be the nearest site of p_j + d_j n_j; otherwise the point could lie in another part of
    the body, or beyond it. So the ball that touches the surface at p_j from that side is shrunk
    until it contains no other site p_k, to the radius

        min_k |p_k - p_j|^2 / (2 n_j . (p_k - p_j)),   n_j . (p_k - p_j) > 0,

    and d_j is half of the radius, but at most the distance. A side on which d_j would be less than
    a twentieth of the distance gets no point.

    Parameters
    ----------
    points : (n, 3) array_like
        Points on a surface. Each duplicate gets points of its own.
    normals : (n, 3) array_like
        Their outward normals, of any length.
    distance : float, optional
        Largest distance from the surface; by default the spacing of the points by `spacing_of`,
        which needs three of them.

    Returns
    -------
    OffSurface
        The points outside, then those inside.

    Raises
    ------
    ValueError
        If the arguments are not points and normals in space.

    References
    ----------
    Carr, Beatson, Cherrie, Mitchell, Fright, McCallum and Evans, Reconstruction and representation
    of 3D objects with radial basis functions (2001); Ma, Bae and Choi, 3D medial axis point
    approximation using nearest neighbors and the normal field (2012); Wendland (2005), section 1.1.

    Examples
    --------
    >>> sheet = [[0, 0, 0], [0, 0, 0.4]]
    >>> off = off_surface_points(sheet + [[9, 9, 9]], [[0, 0, -1], [0, 0, 1], [1, 0, 0]], 1.0)
    >>> off.points[off.sites == 1, 2].round(12), off.values[off.sites == 1].round(12)
    (array([1.4, 0.3]), array([-1. ,  0.1]))
    """
    p, n = as_oriented(points, normals, least=0)
    if not len(p):
        return OffSurface(p, np.zeros(0), np.zeros(0, dtype=np.intp))
    d = spacing_of(p) if distance is None else valid.as_length(distance, "distance")
    p_local = p - p[0]
    tree = cKDTree(p_local)
    sides = []
    for side in (1.0, -1.0):
        room = _MARGIN * _empty_balls(p_local, side * n, tree, d / _MARGIN)
        sites = np.flatnonzero(room >= _LEAST * d)
        away = side * room[sites]
        sides.append(OffSurface(p[sites] + away[:, None] * n[sites], -away, sites))
    outside, inside = sides
    return OffSurface(
        *(
            np.concatenate([getattr(outside, name), getattr(inside, name)])
            for name in ("points", "values", "sites")
        )
    )


def classified_points(
    points: ArrayLike, normals: ArrayLike, x: ArrayLike, cosine: float = 0.5
) -> OffSurface:
    """Classify points as inside or outside by the nearest site.

    If p_j is the nearest site of x, x is outside if the angle between the ray from p_j to x and the
    normal n_j is less than 90 degrees, and inside if it is more. The value is -n_j . (x - p_j), the
    signed distance from the tangent plane. This is right if the spacing of the sites is small
    compared with the distance of x, and can be wrong near edges.

    Parameters
    ----------
    points, normals : (n, 3) array_like
        Points on a surface, and their outward normals.
    x : (m, 3) array_like
        Points to classify.
    cosine : float
        From 0 to 1: points whose ray has a smaller absolute cosine with the normal are dropped,
        since the side is uncertain.

    Returns
    -------
    OffSurface
        The points of `x` that were classified.

    References
    ----------
    Wendland (2005), section 1.1, where line should read ray; Hoppe et al. (1992).

    Examples
    --------
    >>> ring = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    >>> classified_points(ring, ring, [[0.5, 0.1, 0.0], [0.1, 3.0, 0.0]]).values.tolist()
    [0.5, -2.0]
    """
    p, n = as_oriented(points, normals)
    q = valid.as_points(x, "x", none_allowed=True)
    if q.shape[1] != 3:
        raise ValueError(f"x must have the shape (m, 3); got {q.shape}")
    if not 0 <= cosine <= 1:
        raise ValueError(f"cosine must be from 0 to 1; got {cosine!r}")
    far, site = cKDTree(p - p[0]).query(q - p[0])
    above = np.einsum("ij,ij->i", q - p[site], n[site])
    classified = (np.abs(above) >= cosine * far) & (above != 0)
    return OffSurface(q[classified], -above[classified], site[classified])


def spacing_of(points: ArrayLike, neighbors: int = 9) -> float:
    """Spacing of points on a surface: the edge of the square with the mean area of a point.

    The ball to the k-th neighbour contains k points on a disc of area pi r^2. The spacing is the
    median of r sqrt(pi / k).

    Parameters
    ----------
    points : (n, 3) array_like
        Points on a surface.
    neighbors : int
        k.

    Returns
    -------
    float
    """
    p = as_cloud(points)
    k = min(neighbors, len(p) - 1)
    reach = cKDTree(p - p[0]).query(p - p[0], [k + 1])[0][:, 0]
    return float(np.median(reach) * np.sqrt(np.pi / k))


def as_oriented(
    points: ArrayLike, normals: ArrayLike, least: int = 1
) -> tuple[np.ndarray, np.ndarray]:
    """Validate points (n, 3), n at least `least`, and their normals, which are normalized."""
    p = as_cloud(points, least=least)
    n = valid.as_points(normals, "normals", none_allowed=least == 0)
    if n.shape != p.shape:
        raise ValueError(f"normals must have the shape of the points, {p.shape}; got {n.shape}")
    length = np.linalg.norm(n, axis=1, keepdims=True)
    if not length.all():
        raise ValueError(f"normals[{int(np.argmin(length))}] is zero")
    return p, n / length


def _empty_balls(p: np.ndarray, n: np.ndarray, tree: cKDTree, largest: float) -> np.ndarray:
    """Radii of the largest empty balls that touch the surface at p from the side of n."""
    radius, active = np.full(len(p), largest), np.arange(len(p))
    for _ in range(_MAX_ROUNDS):
        center = p[active] + radius[active, None] * n[active]
        found = tree.query(center, workers=-1)[1]
        e = p[found] - p[active]
        squared, along = np.einsum("ij,ij->i", e, e), np.einsum("ij,ij->i", e, n[active])
        touching = np.divide(squared, 2 * along, out=np.full(len(e), np.inf), where=along > 0)
        smaller = touching < radius[active] * (1 - 64 * EPS)
        active = active[smaller]
        radius[active] = touching[smaller]
        if len(active) == 0:
            break
    return radius
