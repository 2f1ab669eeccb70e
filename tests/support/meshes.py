"""Meshes and fields for tests of properties that hold on all meshes."""

import numpy as np

from fieldrecon.meshes.simplex_mesh import SimplexMesh


def random_mesh(n: int, d: int, seed: int) -> SimplexMesh:
    """Delaunay mesh of random points: cells of every shape, almost flat ones on the boundary."""
    return SimplexMesh.delaunay(np.random.default_rng(seed).random((n, d)))


def jittered_mesh(side: int, d: int, seed: int) -> SimplexMesh:
    """Delaunay mesh of a grid in the unit cube with randomly displaced interior points."""
    axes = np.meshgrid(*[np.arange(side + 1.0)] * d, indexing="ij")
    p = np.stack(axes, axis=-1).reshape(-1, d)
    inside = (p > 0) & (p < side)
    jittered = p + inside * np.random.default_rng(seed).uniform(-0.3, 0.3, p.shape)
    return SimplexMesh.delaunay(jittered / side)


def star(valence: int, seed: int) -> SimplexMesh:
    """Triangles around vertex 0, with random angles and edge lengths."""
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(valence) + rng.uniform(-0.3, 0.3, valence)) / valence
    ring = rng.uniform(0.8, 1.2, valence)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    cells = [[0, 1 + k, 1 + (k + 1) % valence] for k in range(valence)]
    return SimplexMesh(np.vstack([np.zeros((1, 2)), ring]), cells)


def affine(mesh: SimplexMesh, seed: int):
    """A random affine velocity field of size one on the mesh, as a function."""
    d = mesh.points.shape[1]
    rng = np.random.default_rng(seed)
    g, c = rng.uniform(-1, 1, (d, d)), rng.uniform(-1, 1, d)
    middle = mesh.points.mean(axis=0)
    size = np.abs(mesh.points - middle).max()
    return lambda x: ((x - middle) / size) @ g.T + c


def taylor_green(x: np.ndarray) -> np.ndarray:
    """Vortices (sin a cos b, -cos a sin b) with a, b = 2π (x, y); the divergence is zero."""
    s, c = np.sin(2 * np.pi * x), np.cos(2 * np.pi * x)
    return np.stack([s[..., 0] * c[..., 1], -c[..., 0] * s[..., 1]], axis=-1)


def abc_flow(x: np.ndarray) -> np.ndarray:
    """The Arnold-Beltrami-Childress flow; its divergence is zero."""
    s, c = np.sin(2 * np.pi * x), np.cos(2 * np.pi * x)
    return s[..., [2, 0, 1]] + c[..., [1, 2, 0]]


def order(coarse: float, fine: float, refinement: float) -> float:
    """The order p of an error proportional to h^p."""
    return float(np.log(coarse / fine) / np.log(refinement))


def rms(vectors: np.ndarray) -> float:
    """Root mean square length of the vectors."""
    return float(np.sqrt((vectors**2).sum(axis=-1).mean()))


# Meshes on which every law for fields on meshes is tested.
MESHES = {
    "random 2-D": random_mesh(400, 2, 1),
    "random 3-D": random_mesh(150, 3, 2),
    "jittered 2-D": jittered_mesh(10, 2, 3),
    "jittered 3-D": jittered_mesh(4, 3, 4),
}
