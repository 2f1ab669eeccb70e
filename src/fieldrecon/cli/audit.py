"""The command that reports what is wrong with a mesh of triangles, and repairs it."""

from __future__ import annotations

import argparse
from pathlib import Path

from fieldrecon._core.extras import require
from fieldrecon.cli.terminal import (
    print_audit,
    print_files,
    print_json,
    print_missing_pictures,
    stages,
)
from fieldrecon.io.triangles import packages_to_write, read_triangles, write_triangles
from fieldrecon.pages.audit_files import write_audit
from fieldrecon.triangles.audit import audit_mesh
from fieldrecon.triangles.repair import repair_mesh


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("mesh", type=Path, metavar="MESH", help=".stl, .ply, .obj or .off")
    parser.add_argument(
        "--tolerance",
        type=float,
        metavar="LENGTH",
        help="by how much vertices may be off, 0 for none (four roundings of the coordinates)",
    )
    parser.add_argument(
        "--open", action="store_true", help="the surface may have a boundary: that is no error"
    )
    parser.add_argument(
        "--repair", type=Path, metavar="FILE", help="write a repaired mesh; its name tells how"
    )
    parser.add_argument(
        "--largest-hole",
        type=float,
        default=0.1,
        metavar="SHARE",
        help="holes up to this share of the area around are filled (0.1)",
    )
    parser.add_argument("--json", action="store_true", help="print the findings as JSON only")
    parser.add_argument("--out", type=Path, default=Path("audit"), metavar="DIR")
    parser.set_defaults(command=audit)


def audit(options: argparse.Namespace) -> int:
    """Report the errors of a mesh and write its repair; return 1 if there is an error."""
    if options.repair:
        require(*packages_to_write(options.repair))
    points, triangles = read_triangles(options.mesh)
    with stages() as stage:
        progress = stage("looking for self-intersections")
        if options.repair is None:
            found = audit_mesh(points, triangles, options.tolerance, progress)
            done = None
        else:
            repaired = repair_mesh(
                points, triangles, options.tolerance, options.largest_hole, progress
            )
            write_triangles(options.repair, repaired.points, repaired.triangles)
            found, done = repaired.before, repaired.done
    written = write_audit(options.out, found, points, triangles)
    last = found if done is None else repaired.after
    if options.json:
        print_json(last.as_dict() if done is None else {"done": done, "left": last.as_dict()})
    else:
        print_audit(options.mesh, found)
        if done is not None:
            print_audit(options.repair, last, done)
        print_files(written if done is None else [*written, options.repair])
    print_missing_pictures()
    boundary = {"boundary_loops"} if options.open else set()
    return int(bool({*last.found} - boundary))
