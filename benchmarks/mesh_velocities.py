"""Velocities and Voronoi weights on a mesh, compared with the triangulation of its points.

Every mesh needs a triangulation, so its time is the unit for the cost of the methods.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np
from scipy import sparse
from scipy.spatial import Delaunay, KDTree

from benchmarks.timing import BenchmarkResult, Comparison, Table, Track, in_turn
from fieldrecon.barycentric.voronoi import voronoi_weights
from fieldrecon.datasets.synthetic import uniform
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.velocity.cells import cell_velocities
from fieldrecon.velocity.vertices import (
    normal_velocities,
    velocity_weights,
    vertex_velocities,
)


@dataclass(frozen=True)
class Size:
    vertices: int = 500_000
    pairs: int = 1_000_000
    repeats: int = 5


FULL = Size()
QUICK = Size(vertices=50_000, pairs=100_000, repeats=3)
TOY = Size(vertices=400, pairs=300, repeats=1)

PEER = "scipy.spatial.Delaunay"
FROM_SCRATCH = ", from the triangles on"
AT_MOST = {
    "velocities of all vertices": 1.0,
    "velocities of all vertices" + FROM_SCRATCH: 1.0,
    "velocities of all cells": 0.1,
}


def run(size: Size, track: Track) -> BenchmarkResult:
    flow = Flow(uniform(size.vertices, 2, seed=1), size.pairs)
    work = flow.work()
    seconds = in_turn(work, size.repeats, track, "velocities on a mesh")
    return BenchmarkResult(
        parameters=asdict(size)
        | {"triangles": len(flow.mesh.cells), "faces": len(flow.mesh.faces), "dimension": 2},
        comparisons=[
            Comparison(what, PEER, seconds[what], seconds[PEER], AT_MOST.get(what))
            for what in work
            if what != PEER
        ],
        tables=[flow.checks()],
        notes=[
            "Not counted, where nothing else is said: the mesh with its faces, normals and "
            "incidences, which is made once, and the data. "
            f'"{FROM_SCRATCH[2:]}" counts all of that but the data, each time anew: the triangles '
            "are checked and oriented, the faces between them found.",
            "A pair of the Voronoi weights is a random point of the plane and the vertex nearest "
            "to it, so the point lies in the Voronoi cell of the vertex and no weight is negative.",
        ],
    )


class Flow:
    """A rotation on a random Delaunay mesh, its normal velocities, and the timed operations."""

    def __init__(self, points: np.ndarray, pairs: int) -> None:
        self.points = points
        self.triangles = Delaunay(points).simplices
        self.mesh = SimplexMesh(points, self.triangles)
        self.v = normal_velocities(self.mesh, rotation(points))
        self.vertex, self.x = pairs_within(self.mesh, pairs)

    def fresh_mesh(self) -> SimplexMesh:
        """A copy of the mesh without cached arrays."""
        return SimplexMesh(self.points, self.triangles)

    def work(self) -> dict[str, Callable[[], object]]:
        mesh, v = self.mesh, self.v
        weights = velocity_weights(mesh)
        return {
            PEER: lambda: Delaunay(self.points),
            "velocities of all vertices": lambda: vertex_velocities(mesh, v),
            "velocities of all cells": lambda: cell_velocities(mesh, v),
            "Voronoi weights of all pairs": lambda: self.voronoi(),
            "the mesh itself" + FROM_SCRATCH: lambda: self.fresh_mesh().face_normals,
            "velocities of all vertices" + FROM_SCRATCH: lambda: vertex_velocities(
                self.fresh_mesh(), v
            ),
            "velocities of all cells" + FROM_SCRATCH: lambda: cell_velocities(self.fresh_mesh(), v),
            "matrices of the velocities of all vertices": lambda: velocity_weights(mesh),
            "velocities of all vertices, by their matrices": lambda: [w @ v for w in weights],
        }

    def voronoi(self) -> sparse.csr_array:
        return voronoi_weights(self.mesh, self.vertex, self.x)

    def checks(self) -> Table:
        """Errors that must be rounding errors."""
        weights, centers = self.voronoi(), self.mesh.circumcenters
        at_vertices = vertex_velocities(self.mesh, self.v).values - rotation(self.points)
        at_centers = cell_velocities(self.mesh, self.v).values - rotation(centers)
        at_centers /= 1 + np.abs(centers)  # far circumcentres have large velocities
        rows = {
            "velocities of vertices, of a rotation": at_vertices,
            "velocities of cells, of a rotation, at the circumcentres, relative": at_centers,
            "Voronoi weights of a pair: their sum less one": weights.sum(axis=1) - 1,
            "Voronoi weights times circumcentres, less the point": weights @ centers - self.x,
            "Voronoi weights: the negative ones": np.minimum(weights.data, 0),
        }
        largest = [(what, float(np.abs(error).max())) for what, error in rows.items()]
        return Table("Largest errors, all of them rounding", ("what", "largest"), largest)


def rotation(x: np.ndarray) -> np.ndarray:
    """Velocity at points (..., 2) of a rotation about the centre of the unit square."""
    return (x - 0.5) @ [[0.0, 1.0], [-1.0, 0.0]]


def pairs_within(mesh: SimplexMesh, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Interior vertices (count,), and a point (count, 2) in the Voronoi cell of each."""
    x = uniform(2 * count, 2, seed=2)
    _, vertex = KDTree(mesh.points).query(x)
    inner = np.flatnonzero(~mesh.boundary_vertices[vertex])[:count]
    return vertex[inner], x[inner]
