"""Vertex stars: the cells around a vertex, on which Voronoi coordinates are compared.

A star is a Delaunay mesh with one of its vertices, whose Voronoi cell is bounded. The module has
the weights of the slides as well.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fieldrecon.datasets.synthetic import uniform
from fieldrecon.meshes.duals import circumcentric_dual
from fieldrecon.meshes.simplex_mesh import SimplexMesh

GOLDEN = (1 + 5**0.5) / 2


class Star(NamedTuple):
    """The cells of a mesh around one of its vertices."""

    mesh: SimplexMesh
    vertex: int

    @property
    def center(self) -> np.ndarray:
        """The vertex x_i (d,)."""
        return self.mesh.points[self.vertex]

    @property
    def cells(self) -> np.ndarray:
        """Indices of the cells at x_i."""
        return self.mesh.vertex_cells(self.vertex)

    @property
    def spokes(self) -> np.ndarray:
        """Differences x_b − x_i (f, d), one for each face of the Voronoi cell."""
        around = self.mesh.cells[self.cells]
        return self.mesh.points[np.unique(around[around != self.vertex])] - self.center

    @property
    def corners(self) -> np.ndarray:
        """Circumcentres (c, d) of the cells."""
        return self.mesh.circumcenters[self.cells]

    @property
    def dual_edges(self) -> np.ndarray:
        """Edges (e, 2, d) of the Voronoi cell."""
        at = (self.mesh.faces == self.vertex).any(axis=1)
        return circumcentric_dual(self.mesh)[0][at]


def hexagon(turn: float = 0.0, center: tuple[float, ...] = (0.0, 0.0)) -> Star:
    """Return a regular hexagon of radius 1, rotated by an angle in degrees, with its centre.

    Examples
    --------
    >>> len(hexagon().cells), len(icosahedron().cells)
    (6, 20)
    """
    angle = np.deg2rad(turn) + np.arange(6) * np.pi / 3
    rim = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return Star(SimplexMesh.delaunay(np.vstack([np.zeros((1, 2)), rim]) + center), 0)


def icosahedron() -> Star:
    """Return an icosahedron of radius 1 with its centre; its Voronoi cell is a dodecahedron."""
    corners = np.array([[0, s, t * GOLDEN] for s in (-1, 1) for t in (-1, 1)])
    rim = np.vstack([np.roll(corners, k, axis=1) for k in range(3)]) / np.sqrt(1 + GOLDEN**2)
    return Star(SimplexMesh.delaunay(np.vstack([np.zeros((1, 3)), rim])), 0)


def at_random(n: int, d: int, seed: int) -> Star:
    """Return the star of the vertex nearest to the centre, for random points in the unit cube."""
    points = uniform(n, d, np.random.default_rng((seed, d)))
    return Star(SimplexMesh.delaunay(points), int(((points - 0.5) ** 2).sum(axis=1).argmin()))


def spiral(star: Star, steps: int) -> np.ndarray:
    """Return the points x_i + (r/n) e_n, n = 1 ... N, r the distance from x_i to the nearest face.

    In the plane e_n has the angle 2πn/N. In space it also makes one revolution about the axis while
    it moves from one pole to the other.
    """
    r = np.sqrt((star.spokes**2).sum(axis=1).min()) / 2
    n = np.arange(1, steps + 1)
    e = np.stack([np.cos(2 * np.pi * n / steps), np.sin(2 * np.pi * n / steps)], axis=1)
    if len(star.center) == 3:
        height = 1 - (2 * n - 1) / steps
        e = np.column_stack([np.sqrt(1 - height**2)[:, None] * e, height])
    return star.center + (r / n)[:, None] * e


def quotients(star: Star, x: np.ndarray, one_height: bool = False) -> np.ndarray:
    """Return V_a / Π_b h_ab of the slides over their sum, at queries (m, d), for the cells a.

    h_ab = (x_b − x_i)ᵀ(p_a − x) is computed at each corner a; with `one_height`, from the same
    ½ l_b² − (x_b − x_i)ᵀ(x − x_i) at all corners of face b. Where a height is zero there is no
    value, NaN.
    """
    around = star.mesh.cells[star.cells]
    others = around[around != star.vertex].reshape(len(around), -1)
    spokes = star.mesh.points[others] - star.center
    if one_height:
        half = (spokes**2).sum(axis=2) / 2
        heights = half - np.einsum("abk,mk->mab", spokes, x - star.center)
    else:
        heights = np.einsum("abk,mak->mab", spokes, star.corners - x[:, None])
    with np.errstate(divide="ignore", invalid="ignore"):
        w = star.mesh.cell_measures[star.cells] / heights.prod(axis=2)
        return w / w.sum(axis=1, keepdims=True)


def from_areas(corners: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the weights of the corners of a convex polygon from areas of triangles alone.

    w_a = area(p_a−1, p_a, p_a+1) / (area(x, p_a−1, p_a) area(x, p_a, p_a+1)): no mesh, no normals.
    """
    before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
    here = x[:, None]
    w = _area(before, corners, after) / (_area(here, before, corners) * _area(here, corners, after))
    return w / w.sum(axis=1, keepdims=True)


def _area(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    u, v = b - a, c - a
    return (u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]) / 2
