"""The command ``fieldrecon audit``: the errors of a mesh of triangles, and its repair."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fieldrecon._core.atomic_files import check_writable
from fieldrecon._core.extras import require
from fieldrecon.cli.console import (
    as_parameters,
    print_files,
    print_json,
    print_missing_pictures,
    print_table,
    say,
)
from fieldrecon.cli.progress import stages
from fieldrecon.io.meshes import packages_to_write
from fieldrecon.pages.audit_files import write_audit
from fieldrecon.pipelines.mesh_audits import audit as audit_of
from fieldrecon.triangles.audit import MeshAudit, in_words

_MAX_FINDINGS = 3
_MAX_INDICES = 6


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("mesh", type=Path, metavar="MESH", help=".stl, .ply, .obj or .off")
    parser.add_argument(
        "--tolerance",
        type=float,
        metavar="LENGTH",
        help="vertices at most this far apart coincide, 0 for none (four roundings of the "
        "coordinates)",
    )
    parser.add_argument(
        "--open", action="store_true", help="do not count a boundary of the surface as an error"
    )
    parser.add_argument(
        "--triangulate", action="store_true", help="divide quads and polygons into triangles"
    )
    parser.add_argument(
        "--repair",
        type=Path,
        metavar="FILE",
        help="write a repaired mesh; the suffix names the format",
    )
    parser.add_argument(
        "--largest-hole",
        type=float,
        default=0.1,
        metavar="SHARE",
        help="holes up to this share of the area around them are filled (0.1)",
    )
    parser.add_argument("--json", action="store_true", help="print the findings as JSON only")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("audit"),
        metavar="DIR",
        help="folder of the findings, the page and the pictures (audit)",
    )
    parser.set_defaults(command=audit)


def audit(options: argparse.Namespace) -> int:
    """Print the errors of a mesh, and write them and the repaired mesh; return 1 if any remain."""
    check_writable(options.out / "audit.json")
    if options.repair:
        check_writable(options.repair)
        require(*packages_to_write(options.repair))
    with stages() as stage:
        result = audit_of(
            options.mesh,
            tolerance=options.tolerance,
            triangulate=options.triangulate,
            repair=options.repair is not None,
            largest_hole=options.largest_hole,
            stages=stage,
        )
        if result.repair:
            result.write(options.repair)
    page = result.report(options.out / "audit.html", as_parameters(options, omit="mesh"))
    written = [page, *write_audit(options.out, result.audit, result.points, result.triangles)]
    if options.json:
        left = result.final.as_dict()
        print_json({"done": result.repair.done, "left": left} if result.repair else left)
    else:
        print_audit(options.mesh, result.audit)
        if result.repair:
            print_audit(options.repair, result.repair.after, result.repair.done)
            for remark in result.remarks:
                say(remark)
            written.append(options.repair)
        print_files(written)
    print_missing_pictures()
    return int(not result.sound(open_allowed=options.open))


def print_audit(path: Path, audit: MeshAudit, done: dict[str, int] | None = None) -> None:
    """Print the errors of a mesh and, for a repaired mesh, the repairs."""
    parts = "1 part" if audit.parts == 1 else f"{audit.parts:,} parts"
    say(
        f"{path}: {audit.triangles:,} triangles in {parts}, {audit.vertices:,} "
        f"vertices; tolerance {audit.tolerance:.3g}."
    )
    if audit.soup:
        say("Each triangle has vertices of its own, as in STL; equal vertices count as one.")
    if done is not None:
        repairs = ", ".join(in_words(what, n) for what, n in done.items())
        say(f"Repaired: {repairs or 'nothing'}.")
    if audit.clean:
        say("Nothing is wrong: closed, oriented, without self-intersections.")
    else:
        columns = ("concerns", "found", "where, by index from 0")
        print_table(columns, _findings(audit))


def _findings(audit: MeshAudit) -> list[tuple[str, str, str]]:
    """Return a row for each kind of error that was found: concern, number, indices."""
    return [
        (concern, in_words(kind, n), _shown(getattr(audit, kind)))
        for concern, kinds in audit.counts.items()
        for kind, n in kinds.items()
        if n
    ]


def _shown(found: Sequence[np.ndarray]) -> str:
    """Return the indices of the first few errors."""
    few = [_joined(np.atleast_1d(indices)) for indices in found[:_MAX_FINDINGS]]
    return ", ".join([*few, "…"] if len(found) > _MAX_FINDINGS else few)


def _joined(indices: np.ndarray) -> str:
    few = "-".join(map(str, indices[:_MAX_INDICES]))
    return f"{few}-…" if len(indices) > _MAX_INDICES else few
