"""Graded meshes of the unit square: edge lengths given by a function, for each frame anew.

The edges are shortest at the boundary of the ink and grow with the distance from it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon.datasets.synthetic import halton
from fieldrecon.meshes.simplex_mesh import SimplexMesh

SMOOTHINGS = 3
GROWTH = 0.35
"""Growth of the edge length per distance from where it is smallest."""


def near_rim(wide: float, fine: float, rim: np.ndarray | None, x: np.ndarray) -> np.ndarray:
    """Edge lengths: `fine` at the given points, growing to `wide` away from them."""
    if rim is None or not len(rim):
        return np.full(len(x), wide)
    away = cKDTree(rim).query(x)[0]
    return np.minimum(wide, fine + GROWTH * np.maximum(away - fine, 0))


def box_mesh(lengths: Callable[[np.ndarray], np.ndarray], seed: int) -> SimplexMesh:
    """Delaunay mesh of the unit square with edges of about these lengths.

    Random points are accepted if no other point is too close, and then smoothed by moving them a
    few times to the mean of their neighbours.
    """
    rim = boundary(lengths)
    shortest = float(lengths(halton(4000, 2)).min())
    tried = halton(int(4 / shortest**2), 2, seed=seed)
    points = np.vstack([rim, thinned(rim, tried, lengths)])
    for _ in range(SMOOTHINGS):
        points[len(rim) :] = means_of_neighbours(SimplexMesh.delaunay(points))[len(rim) :]
    return SimplexMesh.delaunay(points)


def boundary(lengths: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Points on the sides, spaced according to the edge lengths."""
    t = np.linspace(0, 1, 401)
    sides = []
    for corner, along in (((0, 0), (1, 0)), ((1, 0), (0, 1)), ((1, 1), (-1, 0)), ((0, 1), (0, -1))):
        x = np.array(corner) + t[:, None] * np.array(along)
        density = 1 / lengths(x)
        count = np.concatenate([[0], np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(t))])
        even = np.arange(round(count[-1])) * (count[-1] / round(count[-1]))
        sides.append(np.array(corner) + np.interp(even, count, t)[:, None] * np.array(along))
    return np.vstack(sides)


def thinned(
    rim: np.ndarray, tried: np.ndarray, lengths: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """Select the candidates far enough from given points and from those selected before."""
    apart = 0.8 * lengths(tried)
    free = cKDTree(rim).query(tried)[0] > 0.75 * apart
    tried, apart = tried[free], apart[free]
    near = cKDTree(tried).query_ball_point(tried, apart)
    stays = np.zeros(len(tried), dtype=bool)
    for k, others in enumerate(near):
        stays[k] = not stays[[j for j in others if j < k]].any()
    return tried[stays]


def means_of_neighbours(mesh: SimplexMesh) -> np.ndarray:
    """Means (n, 2) of the vertices that share an edge with each."""
    start, end = np.concatenate([mesh.edges, mesh.edges[:, ::-1]]).T
    count = np.bincount(start, minlength=len(mesh.points))
    sums = [np.bincount(start, mesh.points[end, k], len(mesh.points)) for k in (0, 1)]
    return np.stack(sums, axis=1) / count[:, None]
