"""Time and memory of the methods on meshes, against the number of vertices.

Each number comes from a separate process, which reads points and triangles, creates the mesh and
performs one operation. Its peak memory includes the mesh and the interpreter.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import Delaunay

from benchmarks.memory import largest_memory
from benchmarks.mesh_velocities import pairs_within, rotation
from benchmarks.timing import BenchmarkResult, Chart, Table, Track
from fieldrecon.barycentric.voronoi import voronoi_weights
from fieldrecon.datasets.synthetic import uniform
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.velocity.cells import cell_velocities
from fieldrecon.velocity.vertices import (
    normal_velocities,
    velocity_weights,
    vertex_velocities,
)

Work = Callable[[], object]


def triangulation(points: np.ndarray, triangles: np.ndarray) -> Work:  # noqa: ARG001
    return lambda: Delaunay(points)


def mesh(points: np.ndarray, triangles: np.ndarray) -> Work:
    return lambda: SimplexMesh(points, triangles).face_normals


def velocities_of_vertices(points: np.ndarray, triangles: np.ndarray) -> Work:
    on, v = rotating(points, triangles)
    return lambda: vertex_velocities(on, v)


def velocities_of_cells(points: np.ndarray, triangles: np.ndarray) -> Work:
    on, v = rotating(points, triangles)
    return lambda: cell_velocities(on, v)


def matrices_of_velocities(points: np.ndarray, triangles: np.ndarray) -> Work:
    on = SimplexMesh(points, triangles)
    return lambda: velocity_weights(on)


def voronoi_pairs(points: np.ndarray, triangles: np.ndarray) -> Work:
    on = SimplexMesh(points, triangles)
    vertex, x = pairs_within(on, len(points))
    return lambda: voronoi_weights(on, vertex, x)


def rotating(points: np.ndarray, triangles: np.ndarray) -> tuple[SimplexMesh, np.ndarray]:
    """The mesh and the normal velocities of a rotation."""
    on = SimplexMesh(points, triangles)
    return on, normal_velocities(on, rotation(points))


WORK = {
    "scipy.spatial.Delaunay": triangulation,
    "mesh: faces and normals": mesh,
    "velocities of vertices": velocities_of_vertices,
    "velocities of cells": velocities_of_cells,
    "matrices of vertex velocities": matrices_of_velocities,
    "Voronoi weights, a pair for each vertex": voronoi_pairs,
}


@dataclass(frozen=True)
class Size:
    vertices: tuple[int, ...] = (
        *(10_000, 20_000, 50_000, 100_000),
        *(200_000, 500_000, 1_000_000, 2_000_000),
    )
    works: tuple[str, ...] = tuple(WORK)
    runs: int = 2


FULL = Size()
QUICK = Size(vertices=(10_000, 20_000, 50_000))
TOY = Size(vertices=(100, 200), works=("velocities of vertices",))


@dataclass(frozen=True)
class Cost:
    seconds: float
    gigabytes: float


def run(size: Size, track: Track) -> BenchmarkResult:
    costs: dict[str, list[Cost]] = {what: [] for what in size.works}
    with tempfile.TemporaryDirectory() as folder:
        for n in size.vertices:
            points = uniform(n, 2, seed=1)
            file = Path(folder) / "triangulation.npz"
            np.savez(file, points=points, triangles=Delaunay(points).simplices)
            for what in track(size.works, f"meshes of {n} vertices"):
                costs[what].append(cost(what, file, size.runs))
    return BenchmarkResult(
        parameters={"vertices": size.vertices, "runs": size.runs, "dimension": 2},
        tables=tables(size.vertices, costs),
        charts=charts(size.vertices, costs),
        notes=[
            "p: exponent of the power law s = C n^p fitted, in logarithms, to the larger half of "
            "the sizes, where starting threads no longer counts. Times are the least of the "
            "runs, so those of velocities and weights are of a mesh that knows its faces, normals "
            "and incidences.",
            "The memory is that of a process that reads points and triangles, makes the mesh and "
            "does this: 1 GB = 10^9 bytes. Bytes a vertex: what the largest mesh takes more than "
            "the smallest, for each vertex that it has more.",
        ],
    )


def tables(vertices: tuple[int, ...], costs: dict[str, list[Cost]]) -> list[Table]:
    columns = ("vertices", *costs)
    each = [[of[i] for of in costs.values()] for i in range(len(vertices))]
    sizes = list(zip(vertices, each, strict=True))
    seconds = [(n, *(c.seconds for c in row)) for n, row in sizes]
    memory = [(n, *(c.gigabytes for c in row)) for n, row in sizes]
    growth = ("p", *(exponent(vertices, of) for of in costs.values()))
    more = ("bytes a vertex", *(bytes_of_a_vertex(vertices, of) for of in costs.values()))
    return [
        Table("Seconds", columns, [*seconds, growth]),
        Table("Largest memory of the whole process in GB", columns, [*memory, more]),
    ]


def charts(vertices: tuple[int, ...], costs: dict[str, list[Cost]]) -> list[Chart]:
    seconds, memory = {}, {}
    for what, of in costs.items():
        name = f"{what}: p = {exponent(vertices, of):.2f}"
        seconds[name], memory[name] = [c.seconds for c in of], [c.gigabytes for c in of]
    return [
        Chart("Time, and exponents p of its growth", "vertices n", "seconds", vertices, seconds),
        Chart("Largest memory of the process", "vertices n", "gigabytes", vertices, memory),
    ]


def exponent(vertices: tuple[int, ...], costs: list[Cost]) -> float:
    """The exponent p of the power law fitted to the times of the larger meshes."""
    half = (len(vertices) - 1) // 2
    times = [math.log(c.seconds) for c in costs[half:]]
    slope, _ = np.polyfit(np.log(vertices[half:]), times, 1)
    return float(slope)


def bytes_of_a_vertex(vertices: tuple[int, ...], costs: list[Cost]) -> int:
    grown = 1e9 * (costs[-1].gigabytes - costs[0].gigabytes)
    return round(grown / (vertices[-1] - vertices[0]))


def cost(what: str, file: Path, runs: int) -> Cost:
    """Seconds and memory of a separate process."""
    command = [sys.executable, "-m", "benchmarks.mesh_scaling", what, str(file), str(runs)]
    root = Path(__file__).parents[1]
    done = subprocess.run(command, cwd=root, stdout=subprocess.PIPE, check=True)
    return Cost(**json.loads(done.stdout))


def measured(what: str, file: str, runs: str) -> Cost:
    """The work of the separate process; the first run fills the caches of the mesh."""
    with np.load(file) as stored:
        work = WORK[what](stored["points"], stored["triangles"])
    seconds = []
    for _ in range(int(runs)):
        start = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - start)
    return Cost(min(seconds), largest_memory() / 1e9)


if __name__ == "__main__":
    print(json.dumps(asdict(measured(*sys.argv[1:]))))
