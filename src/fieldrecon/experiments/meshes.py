"""Meshes of the unit square and cube on which fields are reconstructed, and orders of errors."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon.mesh import SimplexMesh


def jittered_mesh(side: int, d: int, jitter: float, seed: int) -> SimplexMesh:
    """Delaunay mesh of the points of a grid, each moved at random; it fills the unit cube.

    Points on the boundary stay on it.

    Parameters
    ----------
    side : int
        Steps of the grid along each side.
    d : int
        Dimension, 2 or 3.
    jitter : float
        How far a point is moved in each coordinate at most, in steps; below a half.
    seed : int
        Seed of the moves.

    Examples
    --------
    >>> mesh = jittered_mesh(4, 2, 0.3, seed=0)
    >>> len(mesh.points), round(float(mesh.cell_measures.sum()), 12)
    (25, 1.0)
    """
    axes = np.meshgrid(*[np.arange(side + 1.0)] * d, indexing="ij")
    points = np.stack(axes, axis=-1).reshape(-1, d)
    inside = (points > 0) & (points < side)
    moves = np.random.default_rng((seed, side, d)).uniform(-jitter, jitter, points.shape)
    return SimplexMesh.delaunay((points + inside * moves) / side)


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
    # the hull closes the notches of its left and right side with triangles that are longer
    longest = mesh.face_measures[mesh.cell_faces].max(axis=1)
    return SimplexMesh(points, mesh.cells[longest < 1.5 / side])


def rms(vectors: np.ndarray) -> float:
    """Return the root of the mean squared length of vectors (..., d)."""
    return float(np.sqrt((vectors**2).sum(axis=-1).mean()))


def order(sizes: ArrayLike, errors: ArrayLike) -> float:
    """Return the order p of errors that fall like hᵖ: the slope of log error against log h.

    Examples
    --------
    >>> order([0.1, 0.05, 0.025], [0.04, 0.01, 0.0025])
    2.0
    """
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0].round(12))
