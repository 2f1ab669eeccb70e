"""Meshes of the unit square and cube, and reference flows in closed form."""

from __future__ import annotations

import numpy as np

from fieldrecon.datasets.synthetic import uniform
from fieldrecon.meshes.simplex_mesh import SimplexMesh


def random_square(inside: int, side: int, seed: int | tuple[int, ...]) -> SimplexMesh:
    """Delaunay mesh of random points in a square with `side` equal edges along each side.

    No random point is closer to the boundary than a quarter of such an edge.
    """
    ticks = np.arange(side) / side
    one, zero = np.ones(side), np.zeros(side)
    rim = [(ticks, zero), (one, ticks), (1 - ticks, one), (zero, 1 - ticks)]
    margin = 0.25 / side
    points = margin + (1 - 2 * margin) * uniform(inside, 2, np.random.default_rng(seed))
    return SimplexMesh.delaunay(np.vstack([*map(np.column_stack, rim), points]))


def jittered_cube(side: int, d: int, jitter: float, seed: int) -> SimplexMesh:
    """Delaunay mesh of the unit cube in d dimensions, of edges about 1/side.

    The points of a grid are displaced at random by up to half of `jitter` times the spacing,
    boundary points within the boundary: at most d + 1 of them lie on an empty sphere.
    """
    grid = np.indices((side + 1,) * d).reshape(d, -1).T / side
    free = (grid > 0) & (grid < 1)
    offset = jitter * (uniform(len(grid), d, seed) - 0.5) / side
    return SimplexMesh.delaunay(grid + free * offset)


def equilateral_mesh(side: int) -> SimplexMesh:
    """Equilateral triangles of side 1/side, as many as cover the unit square.

    Examples
    --------
    >>> mesh = equilateral_mesh(4)
    >>> bool(abs(mesh.face_measures - 0.25).max() < 1e-12)
    True
    """
    rows = int(np.ceil(side / np.sqrt(0.75)))
    i, j = np.meshgrid(np.arange(side + 2), np.arange(rows + 1), indexing="ij")
    points = np.stack([i - j % 2 / 2, j * np.sqrt(0.75)], axis=-1).reshape(-1, 2) / side
    mesh = SimplexMesh.delaunay(points)
    # remove the longer triangles with which the hull fills notches on the left and right
    longest = mesh.face_measures[mesh.cell_faces].max(axis=1)
    return SimplexMesh(points, mesh.cells[longest < 1.5 / side])


def rotation(x: np.ndarray, about: np.ndarray) -> np.ndarray:
    """The field of the exercise, u = J(x - m); in space, about the axis (1, 1, 1) through m."""
    if x.shape[1] == 2:
        return (x - about) @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    return np.cross(np.ones(3), x - about)


def taylor_green(x: np.ndarray) -> np.ndarray:
    """Vortices (sin a cos b, -cos a sin b) with a, b = 2π(x, y); free of divergence."""
    s, c = np.sin(2 * np.pi * x), np.cos(2 * np.pi * x)
    return np.stack([s[..., 0] * c[..., 1], -c[..., 0] * s[..., 1]], axis=-1)


def abc_flow(x: np.ndarray) -> np.ndarray:
    """The flow of Arnold, Beltrami and Childress, with all three constants one."""
    s, c = np.sin(2 * np.pi * x), np.cos(2 * np.pi * x)
    return s[..., [2, 0, 1]] + c[..., [1, 2, 0]]
