"""Surfaces from scans: time and error, compared with Open3D's Poisson reconstruction.

fieldrecon reads the points, reconstructs the surface, measures the distances of the points and
looks for errors of the mesh. Open3D estimates and orients normals, and reconstructs.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

import numpy as np

import fieldrecon as fr
from benchmarks.normals import OPEN3D
from benchmarks.peer_environments import Peer
from benchmarks.timing import BenchmarkResult, Comparison, Table, Track, in_turn
from fieldrecon.solids.constructive import Solid
from fieldrecon.solids.shapes import Box, Cylinder, Torus, sample_surface
from fieldrecon.surfaces.off_surface import spacing_of
from fieldrecon.triangles.distances import distances_to_triangles

DEPTH, NEIGHBORS = 8, 16
NOISE = 0.002
"""Standard deviation of the noise in each coordinate, relative to the diagonal of the box."""
EDGES = (1.0, 2.0)
"""Edges of our triangles, in spacings of the points; the first is the default of the command."""
OURS, THEIRS = "fieldrecon, edges of {:g} spacings", f"Open3D, depth {DEPTH}"


@dataclass(frozen=True)
class Size:
    points: int = 20_000
    repeats: int = 1
    peer: bool = True


FULL = Size()
QUICK = Size(points=4_000)
TOY = Size(points=800, peer=False)

Mesh = tuple[np.ndarray, np.ndarray]
"""Points and triangles."""
BODIES: dict[str, Solid] = {
    "ring": Torus(1.0, 0.4),
    "plate with a hole": Box([2.0, 1.4, 0.5]) - Cylinder(0.4, 1.0),
}


def run(size: Size, track: Track) -> BenchmarkResult:
    clouds = {
        f"{body}{', noise' if noise else ''}": (BODIES[body], _scan(BODIES[body], noise, size))
        for body in BODIES
        for noise in (0.0, NOISE)
    }
    meshes: dict[tuple[str, str], Mesh] = {}
    processor: dict[tuple[str, str], list[float]] = {}

    def ours(name: str, edges: float) -> None:
        points = clouds[name][1]
        start = time.process_time()
        scan = fr.pipelines.surface(points, edge=edges * spacing_of(points))
        key = name, OURS.format(edges)
        processor.setdefault(key, []).append(time.process_time() - start)
        meshes[key] = scan.points, scan.triangles

    candidates: dict[str, Callable[[], object]] = {}
    with TemporaryDirectory() as folder:
        peer = _peer(clouds, Path(folder)) if size.peer else None

        def theirs(name: str) -> None:
            key = name, THEIRS
            processor.setdefault(key, []).append(peer.ask(name)["processor"])
            found = np.load(Path(folder) / f"surface of {name}.npz")
            meshes[key] = found["points"], found["triangles"]

        for name in clouds:
            for edges in EDGES:
                candidates[f"ours, {name}, {edges}"] = partial(ours, name, edges)
            if peer:
                candidates[f"theirs, {name}"] = partial(theirs, name)
        in_turn(candidates, size.repeats, track, "surfaces")
        if peer:
            peer.close()
    rows = [
        (name, who, median(times[1:]), *_errors(clouds[name][0], *meshes[name, who]))
        for (name, who), times in sorted(processor.items())
    ]
    columns = ("points", "who", "processor, s", "root mean square", "largest", "triangles")
    return BenchmarkResult(
        parameters={k: v for k, v in asdict(size).items() if k != "peer"}
        | {"depth": DEPTH, "noise, of the diagonal": str(NOISE)},
        comparisons=[
            Comparison(
                f"{name}: processor time, edges of {edges:g} spacings",
                "Open3D",
                processor[name, OURS.format(edges)][1:],
                processor[name, THEIRS][1:],
            )
            for name in clouds
            for edges in EDGES
            if peer
        ],
        tables=[
            Table("Processor time, and errors in thousandths of the diagonal", columns, rows),
        ],
        notes=[
            "The ratios are of processor time, which other work on the machine lengthens little.",
            "The errors are distances between the mesh and the body, in both directions: of random "
            "points of the body from the mesh, and of triangles from the body, by their area.",
            "Edges of the triangles are the option `--edge`. The time of fieldrecon includes the "
            "distances of all points from the mesh and the search for its errors.",
        ],
    )


def _scan(body: Solid, noise: float, size: Size) -> np.ndarray:
    points, _ = sample_surface(body, size.points, seed=1)
    deviation = noise * _diagonal(body)
    return points + deviation * np.random.default_rng(2).standard_normal(points.shape)


def _diagonal(body: Solid) -> float:
    return float(np.linalg.norm(body.box[1] - body.box[0]))


def _errors(body: Solid, points: np.ndarray, triangles: np.ndarray) -> tuple[float, float, int]:
    """Root mean square and largest distance, in thousandths of the diagonal; the triangles."""
    of_body = distances_to_triangles(sample_surface(body, 20_000, seed=3)[0], points, triangles)
    a, b, c = points[triangles].swapaxes(0, 1)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    of_mesh = np.abs(body((a + b + c) / 3))
    square = (np.mean(of_body**2) + np.average(of_mesh**2, weights=areas)) / 2
    unit = _diagonal(body) / 1000
    return float(np.sqrt(square) / unit), float(max(of_body.max(), of_mesh.max()) / unit), len(a)


def _peer(clouds: dict[str, tuple[Solid, np.ndarray]], folder: Path) -> Peer | None:
    for name, (_, points) in clouds.items():
        np.save(folder / f"{name}.npy", points)
    worker = Path(__file__).with_name("surfaces_open3d.py")
    peer = Peer(worker, (OPEN3D, "numpy"), str(folder), str(DEPTH), str(NEIGHBORS))
    return peer if peer.ready else None
