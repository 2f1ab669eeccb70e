"""Normals of a point cloud and their orientation, compared with Open3D.

Both estimate normals by principal components of the same number of neighbours and orient them along
a spanning tree. Open3D leaves the global sign open; fieldrecon chooses the outward direction.
Open3D triangulates the cloud first, which takes long if many points lie in a plane, and is then
stopped.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.peer_environments import Peer
from benchmarks.timing import BenchmarkResult, Comparison, Table, Track, in_turn
from fieldrecon.solids.shapes import Ball, Cylinder, Torus, sample_surface
from fieldrecon.surfaces.normal_orientation import orient_normals
from fieldrecon.surfaces.normals import estimate_normals

OPEN3D = "open3d-cpu==0.20.0"
NEIGHBORS, JOINED = 16, 16
AT_MOST = 1 / 30
PATIENCE = 60.0
"""Time in seconds after which Open3D is stopped."""


@dataclass(frozen=True)
class Size:
    points: int = 100_000
    repeats: int = 2
    peer: bool = True


FULL = Size()
QUICK = Size(points=10_000)
TOY = Size(points=300, repeats=1, peer=False)

Cloud = tuple[np.ndarray, np.ndarray]
"""Points and exact normals."""


def run(size: Size, track: Track) -> BenchmarkResult:
    clouds = {name: make(size.points) for name, make in CLOUDS.items()}
    found: dict[tuple[str, str], np.ndarray] = {}
    processor: list[tuple[str, str, float]] = []
    alone: dict[str, float] = {}
    stopped: set[str] = set()

    def ours(name: str) -> None:
        start = time.process_time()
        estimate = estimate_normals(clouds[name][0], NEIGHBORS)
        joined = estimate.neighbors[:, :JOINED]
        found[name, "fieldrecon"] = orient_normals(clouds[name][0], estimate.vectors, joined)
        processor.append((name, "fieldrecon", time.process_time() - start))

    candidates: dict[str, Callable[[], object]] = {}
    with TemporaryDirectory() as folder:
        peer = _peer(clouds, Path(folder)) if size.peer else None

        def theirs(name: str) -> None:
            answer = peer.ask(name, PATIENCE)
            if answer is None:
                stopped.add(name)
            else:
                processor.append((name, "Open3D", answer["processor"]))
                alone[name] = answer["normals"]

        for name in clouds:
            candidates[f"ours, {name}"] = partial(ours, name)
            if peer:
                candidates[f"theirs, {name}"] = partial(theirs, name)
        seconds = in_turn(candidates, size.repeats, track, "normals")
        if peer:
            peer.close()
            for name in clouds.keys() - stopped:
                found[name, "Open3D"] = np.load(Path(folder) / f"normals of {name}.npy")
    rows = [(name, who, *accuracy(n, clouds[name][1])) for (name, who), n in sorted(found.items())]
    columns = ("cloud", "who", "wrong side, %", "median angle, degrees", "95 of 100 below")
    return BenchmarkResult(
        parameters={k: v for k, v in asdict(size).items() if k != "peer"}
        | {"neighbours": NEIGHBORS, "neighbours joined": JOINED},
        comparisons=[
            Comparison(
                f"{name}: normals and orientation",
                "Open3D",
                seconds[f"ours, {name}"],
                seconds[f"theirs, {name}"],
                AT_MOST,
            )
            for name in clouds
            if peer
        ],
        tables=[
            Table("How right they are", columns, rows),
            Table(
                "Processor time, which other work on the machine does not lengthen",
                ("cloud", "who", "seconds"),
                processor,
            ),
            Table(
                "Open3D: the normals alone, without orientation, by the clock",
                ("cloud", "seconds"),
                [*alone.items()],
            ),
        ],
        notes=[
            "Random points on closed surfaces whose normals are known, but for those near edges. "
            "Open3D leaves the sign of all normals together open, and is given the better.",
            "Open3D has its clouds in memory, in C++; fieldrecon begins with arrays. Open3D joins "
            "points by their Delaunay tetrahedra too, whose number depends on the shape.",
            *(f"Open3D was stopped after {PATIENCE:.0f} s: {name}." for name in sorted(stopped)),
        ]
        if peer
        else ["Open3D could not be had."],
    )


def ball(n: int) -> Cloud:
    """Points on the unit ball."""
    return sample_surface(Ball(1.0), n, seed=1)


def ring(n: int) -> Cloud:
    """Points on a torus."""
    return sample_surface(Torus(1.0, 0.4), n, seed=1)


def can(n: int) -> Cloud:
    """Points on a cylinder with its bottom and its lid."""
    return sample_surface(Cylinder(0.7, 1.6), n, seed=1)


def hills(n: int) -> Cloud:
    """Points (n, 3) on r = 1 + q(u) for directions u, and the normals of this surface."""
    u = np.random.default_rng(1).standard_normal((n, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    a, b, c = (u * [9, 8, 7]).T
    q = 0.1 * np.sin(a) * np.sin(b) * np.cos(c)
    slope = 0.1 * np.column_stack(
        [
            9 * np.cos(a) * np.sin(b) * np.cos(c),
            8 * np.sin(a) * np.cos(b) * np.cos(c),
            -7 * np.sin(a) * np.sin(b) * np.sin(c),
        ]
    )
    tangential = slope - np.einsum("ij,ij->i", slope, u)[:, None] * u
    normals = u - tangential / (1 + q)[:, None]
    return (1 + q)[:, None] * u, normals / np.linalg.norm(normals, axis=1, keepdims=True)


CLOUDS: dict[str, Callable[[int], Cloud]] = {
    "ball": ball,
    "ring": ring,
    "can": can,
    "hills and saddles": hills,
}


def accuracy(normals: np.ndarray, truth: np.ndarray) -> tuple[float, float, float]:
    """Percentage of normals on the wrong side, and angles in degrees up to the sign."""
    cosine = np.einsum("ij,ij->i", normals, truth)
    wrong = float(np.mean(cosine < 0))
    angle = np.degrees(np.arccos(np.clip(np.abs(cosine), 0, 1)))
    return (100 * min(wrong, 1 - wrong), float(np.median(angle)), float(np.quantile(angle, 0.95)))


def _peer(clouds: dict[str, Cloud], folder: Path) -> Peer | None:
    for name, (points, _) in clouds.items():
        np.save(folder / f"{name}.npy", points)
    worker = Path(__file__).with_name("normals_open3d.py")
    peer = Peer(worker, (OPEN3D, "numpy"), str(folder), str(NEIGHBORS), str(JOINED))
    return peer if peer.ready else None
