"""Audit of a triangle mesh, compared with PyMeshLab's measures.

PyMeshLab computes its topological measures and its selection of intersecting faces. The audit
searches for all its kinds of errors, and must agree with PyMeshLab on those that both find.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.peer_environments import Peer
from benchmarks.timing import BenchmarkResult, Comparison, Table, Track, in_turn
from fieldrecon.triangles.audit import MeshAudit, audit_mesh
from fieldreport.experiments.triangles.triangle_shapes import Surface, bumpy, sphere, together

PYMESHLAB = "pymeshlab==2025.7.post1"


@dataclass(frozen=True)
class Size:
    level: int = 8
    repeats: int = 3
    peer: bool = True


FULL = Size()
QUICK = Size(level=6)
TOY = Size(level=2, repeats=1, peer=False)

AT_MOST = 2.0


def run(size: Size, track: Track) -> BenchmarkResult:
    surfaces = bodies(size.level)
    audits: dict[str, MeshAudit] = {}
    theirs: dict[str, dict[str, int]] = {}

    def ours(name: str) -> None:
        audits[name] = audit_mesh(*surfaces[name])

    candidates: dict[str, Callable[[], object]] = {
        f"ours, {name}": lambda name=name: ours(name) for name in surfaces
    }
    with TemporaryDirectory() as folder:
        peer = _peer(surfaces, Path(folder)) if size.peer else None
        if peer:

            def ask(name: str) -> None:
                theirs[name] = peer.ask(str(Path(folder) / f"{name}.npz"))

            candidates |= {f"theirs, {name}": lambda name=name: ask(name) for name in surfaces}
        seconds = in_turn(_in_pairs(candidates), size.repeats, track, "audits of meshes")
        if peer:
            peer.close()
    return BenchmarkResult(
        parameters={k: v for k, v in asdict(size).items() if k != "peer"}
        | {"triangles": len(surfaces["hills and saddles"][1])},
        comparisons=[
            Comparison(
                name, "PyMeshLab", seconds[f"ours, {name}"], seconds[f"theirs, {name}"], AT_MOST
            )
            for name in theirs
        ],
        tables=[_findings(audits, theirs), _times(seconds)],
        notes=[
            "PyMeshLab has its mesh in memory, with what it keeps from one run to the next; "
            "fieldrecon begins with two arrays each time. PyMeshLab computes in C++ on one core, "
            "fieldrecon in NumPy on those there are.",
            "The audit finds more than is compared: copies, triangles without area, orientation, "
            "T-junctions, seams; with exact signs where rounding could decide."
            if peer
            else "PyMeshLab could not be had.",
        ],
    )


def bodies(level: int) -> dict[str, Surface]:
    """Closed meshes: one with hills, a sphere, and four bodies that run into one another."""
    small, triangles = bumpy(level - 1)
    row = [(np.add(small, [1.31 * k, 0.17 * k, 0.23 * k]), triangles) for k in range(4)]
    return {
        "hills and saddles": bumpy(level),
        "sphere": sphere(level),
        "four bodies that cross": together(*row),
    }


def comparable_findings(audit: MeshAudit) -> dict[str, int]:
    """The findings of the audit that PyMeshLab also reports."""
    crossing = np.concatenate([audit.crossings.ravel(), audit.overlaps.ravel()])
    return {
        "free edges": sum(map(len, audit.boundary_loops)),
        "edges of more than two triangles": len(audit.nonmanifold_edges),
        "bow-tie vertices": len(audit.bow_tie_vertices),
        "unreferenced vertices": len(audit.unreferenced_vertices),
        "parts": audit.parts,
        "triangles that cross others": len(np.unique(crossing)),
    }


def _findings(audits: dict[str, MeshAudit], theirs: dict[str, dict[str, int]]) -> Table:
    rows = [
        (name, what, n, theirs[name][what] if name in theirs else "–")
        for name, audit in audits.items()
        for what, n in comparable_findings(audit).items()
    ]
    return Table("Findings", ("mesh", "what", "fieldrecon", "PyMeshLab"), rows)


def _times(seconds: dict[str, list[float]]) -> Table:
    rows = [(name, float(np.median(times))) for name, times in seconds.items()]
    return Table("Times", ("what", "seconds"), rows)


def _in_pairs(candidates: dict[str, Callable[[], object]]) -> dict[str, Callable[[], object]]:
    """The candidates sorted by mesh, so that both programs run under the same load."""
    return dict(sorted(candidates.items(), key=lambda item: item[0].partition(", ")[2]))


def _peer(surfaces: dict[str, Surface], folder: Path) -> Peer | None:
    paths = []
    for name, (points, triangles) in surfaces.items():
        paths.append(folder / f"{name}.npz")
        np.savez(paths[-1], points=points, triangles=triangles)
    worker = Path(__file__).with_name("mesh_audit_pymeshlab.py")
    peer = Peer(worker, (PYMESHLAB, "numpy"), *map(str, paths))
    return peer if peer.ready else None
