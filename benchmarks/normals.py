"""Normals of a cloud and their orientation, against Open3D.

Both estimate normals by principal components of as many neighbours, and make them agree along a
spanning tree. Open3D is told a global sign; ours point outward of themselves.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.measure import Comparison, Outcome, Table, Track, in_turn
from benchmarks.other_environment import Peer
from fieldrecon.normal_orientation import orient_normals
from fieldrecon.normals import estimate_normals

OPEN3D = "open3d-cpu==0.20.0"
NEIGHBORS, JOINED = 16, 9
AT_MOST = 1 / 30


@dataclass(frozen=True)
class Size:
    points: int = 100_000
    repeats: int = 2
    peer: bool = True


FULL = Size()
QUICK = Size(points=10_000)
TOY = Size(points=300, repeats=1, peer=False)


def run(size: Size, track: Track) -> Outcome:
    points, truth = hills(size.points)
    found: dict[str, np.ndarray] = {}

    def ours() -> None:
        estimate = estimate_normals(points, NEIGHBORS)
        joined = estimate.neighbors[:, :JOINED]
        found["fieldrecon"] = orient_normals(points, estimate.vectors, joined)

    candidates: dict[str, Callable[[], object]] = {"ours": ours}
    stages: list[dict[str, float]] = []
    with TemporaryDirectory() as folder:
        peer = _peer(points, Path(folder)) if size.peer else None
        if peer:
            candidates["theirs"] = lambda: stages.append(peer.ask("normals"))
        seconds = in_turn(candidates, size.repeats, track, "normals")
        if peer:
            peer.close()
            found["Open3D"] = np.load(Path(folder) / "normals.npy")
    return Outcome(
        parameters={k: v for k, v in asdict(size).items() if k != "peer"}
        | {"neighbours": NEIGHBORS, "neighbours joined": JOINED},
        comparisons=[
            Comparison(f"normals and orientation of {size.points} points", "Open3D",
                       seconds["ours"], seconds["theirs"], AT_MOST)
        ] if peer else [],
        tables=[
            Table("How right they are", ("who", "wrong side, %", "median angle, degrees",
                                         "95 of 100 below"),
                  [(who, *judged(n, truth)) for who, n in found.items()]),
            Table("Open3D's stages, in seconds", ("estimate_normals", "orientation"),
                  [(s["estimate"], s["orient"]) for s in stages[1:]]),
        ],
        notes=[
            "A closed surface with hills and saddles, whose normals are known; its points are "
            "random. Open3D leaves the sign of all normals together open, and is given the better.",
            "Open3D has its cloud in memory, in C++; fieldrecon begins with an array."
            if peer
            else "Open3D could not be had.",
        ],
    )  # fmt: skip


def hills(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) at r = 1 + q(u) in the directions u, and the normals of that surface."""
    u = np.random.default_rng(1).standard_normal((n, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    a, b, c = (u * [9, 8, 7]).T
    q = 0.1 * np.sin(a) * np.sin(b) * np.cos(c)
    slope = 0.1 * np.column_stack([
        9 * np.cos(a) * np.sin(b) * np.cos(c),
        8 * np.sin(a) * np.cos(b) * np.cos(c),
        -7 * np.sin(a) * np.sin(b) * np.sin(c),
    ])  # fmt: skip
    tangential = slope - np.einsum("ij,ij->i", slope, u)[:, None] * u
    normals = u - tangential / (1 + q)[:, None]
    return (1 + q)[:, None] * u, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def judged(normals: np.ndarray, truth: np.ndarray) -> tuple[float, float, float]:
    """Percentage on the wrong side, and angles in degrees whatever the side."""
    cosine = np.einsum("ij,ij->i", normals, truth)
    wrong = float(np.mean(cosine < 0))
    angle = np.degrees(np.arccos(np.clip(np.abs(cosine), 0, 1)))
    return (
        100 * min(wrong, 1 - wrong), float(np.median(angle)), float(np.quantile(angle, 0.95))
    )  # fmt: skip


def _peer(points: np.ndarray, folder: Path) -> Peer | None:
    np.save(folder / "points.npy", points)
    worker = Path(__file__).with_name("normals_peer.py")
    peer = Peer(worker, (OPEN3D, "numpy"), str(folder), str(NEIGHBORS), str(JOINED))
    return peer if peer.ready else None
