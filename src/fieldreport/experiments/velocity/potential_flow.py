"""Potential flow past the unit disc and the unit ball, and meshes of the exterior.

With e the direction of the stream, of speed 1, and r = |x|, in d = 2 or 3 dimensions,

    u = e (1 + r^-d / (d-1)) - d / (d-1) x (e · x) r^-(d+2) = curl A ,
    A = (1 - r^-d) / (d-1) e ∧ x ,

where in the plane A is the stream function ψ = y (1 - r^-2). On the surface the pressure
coefficient is 1 - (d / (d-1))² sin²θ.

References
----------
Milne-Thomson, Theoretical Hydrodynamics (1968), chapters 6 and 16.
"""

from __future__ import annotations

import numpy as np

from fieldrecon._core.geometry import triangle_normals
from fieldrecon.datasets.synthetic import halton
from fieldrecon.meshes.simplex_mesh import SimplexMesh

SPREAD, PULL = 1.2, 0.2
"""Springs of the mesh: rest length over typical length, and step size."""


def velocity(x: np.ndarray) -> np.ndarray:
    """Return the velocity at x (..., d), along the first axis far away.

    Examples
    --------
    >>> velocity(np.array([[0.0, 1.0], [1.0, 0.0]])).tolist()
    [[2.0, 0.0], [0.0, 0.0]]
    """
    d = x.shape[-1]
    r = np.linalg.norm(x, axis=-1, keepdims=True)
    e = np.eye(d)[0]
    return e * (1 + r**-d / (d - 1)) - d / (d - 1) * x * x[..., :1] * r ** -(d + 2.0)


def stream_function(x: np.ndarray) -> np.ndarray:
    """Return ψ = y (1 − 1/r²) at x (..., 2); its difference is the flux between two points."""
    return x[..., 1] * (1 - 1 / (x**2).sum(axis=-1))


def vector_potential(x: np.ndarray) -> np.ndarray:
    """Return A = ½ (1 − r⁻³) e × x at x (..., 3)."""
    factor = (1 - np.linalg.norm(x, axis=-1, keepdims=True) ** -3) / 2
    return factor * np.stack([0 * x[..., 0], -x[..., 2], x[..., 1]], axis=-1)


def pressure_coefficient(cosine: np.ndarray, d: int) -> np.ndarray:
    """Return 1 − (d/(d−1))² sin²θ on the surface."""
    return 1 - (d / (d - 1)) ** 2 * (1 - cosine**2)


def mean_normal_velocities(mesh: SimplexMesh) -> np.ndarray:
    """Return the flux through each face over its measure, by Stokes' theorem along its edges.

    The divergence of every cell is therefore zero to rounding.
    """
    corners = mesh.points[mesh.faces]
    if mesh.points.shape[1] == 2:
        flux = np.subtract(*stream_function(corners).T[::-1])
        right = (corners[:, 1] - corners[:, 0]) @ np.array([[0.0, -1.0], [1.0, 0.0]])
    else:
        ends = np.roll(corners, -1, axis=1)
        flux = _along(corners.reshape(-1, 3), ends.reshape(-1, 3)).reshape(-1, 3).sum(axis=1)
        right = triangle_normals(*corners.swapaxes(0, 1))
    side = np.sign(np.einsum("fd,fd->f", right, mesh.face_normals))
    return side * flux / mesh.face_measures


def _along(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Integrate A from start to end (m, 3), the lower end first so that both ways cancel."""
    swapped = np.array([tuple(a) > tuple(b) for a, b in zip(start, end, strict=True)])
    a, b = np.where(swapped[:, None], end, start), np.where(swapped[:, None], start, end)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    total = sum(
        w / 2 * vector_potential(a + (1 + node) / 2 * (b - a))
        for node, w in zip(nodes, weights, strict=True)
    )
    return np.where(swapped, -1, 1) * np.einsum("md,md->m", total, b - a)


def disc_mesh(around: int, outer: float, relaxations: int, seed: int) -> SimplexMesh:
    """Triangles between the unit circle and one of radius `outer`, growing with the distance.

    Random points in the plane of log z are pushed apart by springs. The map is conformal, so
    triangles that are nearly equilateral there are so here.

    Parameters
    ----------
    around : int
        Points on each circle.
    outer : float
        Radius of the outer circle.
    relaxations : int
        Number of relaxation steps of the springs.
    seed : int
        Seed of the points.
    """
    step, depth = 2 * np.pi / around, np.log(outer)
    turn = 1j * step * np.arange(around)
    inside = round(2 * np.pi * (depth - step) / (np.sqrt(0.75) * step**2))
    start = halton(inside, 2, seed) * [depth - step, 2 * np.pi] + [step / 2, 0]
    z = np.exp(np.concatenate([turn, depth + turn, start @ [1, 1j]]))
    for _ in range(relaxations):
        i, j = _without_the_ball(_points(z)).edges.T
        apart = np.log(z[j] / z[i])
        push = PULL * np.maximum(SPREAD * step / np.abs(apart) - 1, 0) * apart
        moves = np.zeros_like(z)
        np.add.at(moves, i, -push)
        np.add.at(moves, j, push)
        w = np.log(z) + moves
        w.real = np.clip(w.real, step / 2, depth - step / 2)
        z[2 * around :] = np.exp(w[2 * around :])
    return _without_the_ball(_points(z))


def ball_mesh(step: float, outer: float, seed: int) -> SimplexMesh:
    """Tetrahedra between the unit sphere and one of radius `outer`, growing with the distance.

    The points lie on spheres, along a randomly rotated spiral on each.

    Parameters
    ----------
    step : float
        Distance of neighbouring points, in radii.
    outer : float
        Radius of the outer sphere.
    seed : int
        Seed of the rotations.
    """
    shells = np.exp(np.linspace(0, np.log(outer), 1 + round(np.log(outer) / (0.8 * step))))
    count = round(4 * np.pi / (np.sqrt(0.75) * step**2))
    k = np.arange(count) + 0.5
    height, angle = 1 - 2 * k / count, np.pi * (1 + np.sqrt(5)) * k
    radius = np.sqrt(1 - height**2)
    spiral = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)
    rng = np.random.default_rng(seed)
    turns = [np.linalg.qr(rng.standard_normal((3, 3)))[0] for _ in shells]
    points = [r * spiral @ q for r, q in zip(shells, turns, strict=True)]
    return _without_the_ball(np.concatenate(points))


def _points(z: np.ndarray) -> np.ndarray:
    return np.column_stack([z.real, z.imag])


def _without_the_ball(points: np.ndarray) -> SimplexMesh:
    mesh = SimplexMesh.delaunay(points)
    on_it = np.linalg.norm(points, axis=1) < 1 + 1e-9
    return SimplexMesh(points, mesh.cells[~on_it[mesh.cells].all(axis=1)])
