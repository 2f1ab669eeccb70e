"""The command ``fieldrecon surface``: from a scan to a closed mesh."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from time import perf_counter

import numpy as np

from fieldrecon._core.atomic_files import check_writable, write_atomically
from fieldrecon._core.chunks import Stages
from fieldrecon._core.extras import PICTURES, absent, require
from fieldrecon._core.memory import memory_used, peak_memory
from fieldrecon.cli.console import (
    as_parameters,
    print_files,
    print_missing_pictures,
    print_table,
    say,
)
from fieldrecon.cli.progress import stages
from fieldrecon.io.meshes import packages_to_write
from fieldrecon.pages.surface_page import UP, picture, surface_page
from fieldrecon.pipelines.scans import ScanResult
from fieldrecon.pipelines.scans import surface as surface_of
from fieldrecon.plotting.figure_files import figure_bytes

FORMATS = (".ply", ".stl", ".obj", ".off")
_COARSE = 1e-3  # roundings beyond this share of the spacing are reported


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add = parser.add_argument
    add("cloud", type=Path, metavar="CLOUD", help=".ply, .obj, .stl, or a table: .xyz, .csv, .npz")
    add(
        "--out",
        type=Path,
        default=Path("surface.ply"),
        metavar="MESH",
        help=f"{', '.join(FORMATS)}; a page, .html, and a picture, .png, are written beside it",
    )
    add(
        "--normals",
        choices=("file", "estimate"),
        default="file",
        help="those of the file or of its triangles, if there are any (the default), or from "
        "the points alone",
    )
    add(
        "--smoothing",
        type=float,
        metavar="LENGTH",
        help="smooth away waves of the surface that are shorter; 0 for none (by the noise)",
    )
    add(
        "--polygons",
        type=float,
        metavar="LENGTH",
        help="take the triangles of the file for loose oriented polygons: 0 for a surface through "
        "them, else around them and smoothed below this length (at most some thousands: the time "
        "grows with their number times the number of triangles of the mesh)",
    )
    add(
        "--level",
        type=float,
        metavar="NUMBER",
        help="take the file for a table of x, y, z and a scalar, such as signed distances: the "
        "surface is where the scalar has this value",
    )
    add("--value", metavar="COLUMN", help="with --level, the column that holds the scalar")
    add(
        "--edge",
        type=float,
        metavar="LENGTH",
        help="of the triangles (the spacing of the points, less where they are few)",
    )
    add(
        "--open",
        type=float,
        metavar="LENGTH",
        help="leave out the surface farther than this from all points, instead of closing it",
    )
    add("--up", choices=UP, default="z", help="the axis that points up in the picture (z)")
    parser.set_defaults(command=surface)


def surface(options: argparse.Namespace) -> int:
    """Reconstruct the surface of a scan; print and write it; return 1 if it is not sound."""
    if options.out.suffix.lower() not in FORMATS:
        raise ValueError(f"--out {options.out} must end with {', '.join(FORMATS)}")
    if options.out.resolve() == options.cloud.resolve():
        raise ValueError(f"{options.out} is read, and would be overwritten; choose another name")
    check_writable(options.out)
    require("skimage", *packages_to_write(options.out))
    began = perf_counter()
    with stages() as stage:
        scan = surface_of(
            options.cloud,
            level=options.level,
            value=options.value,
            normals=options.normals,
            smoothing=options.smoothing,
            polygons=options.polygons,
            edge=options.edge,
            open=options.open,
            stages=stage,
        )
        warnings = [*scan.warnings, *_precision_warning(scan, options.out)]
        written = list(_written(scan, warnings, options, stage, began))
    print_scan(options.cloud, scan, warnings, _cost(began))
    print_files(written)
    print_missing_pictures()
    return int(not scan.sound(open_allowed=options.open is not None))


def print_scan(path: Path, scan: ScanResult, warnings: Sequence[str], cost: str) -> None:
    """Print the distances of the points of a scan from its surface, and the warnings."""
    title = f"{path.name}: distances of {scan.sources} from the mesh"
    print_table(("points", "distance"), tuple(scan.quality.items()), title=title)
    for warning in warnings:
        say(warning)
    say(f"{cost}.")


def _written(
    scan: ScanResult,
    warnings: Sequence[str],
    options: argparse.Namespace,
    stage: Stages,
    began: float,
) -> Iterator[Path]:
    """Write the mesh, the picture and the page; yield the files."""
    drawn = _picture(scan, options.up, stage)
    stage("writing")
    yield scan.write(options.out)
    if drawn:
        yield write_atomically(options.out.with_suffix(".png"), drawn)
    parameters = as_parameters(options, omit="cloud") | {"time and memory": _cost(began)}
    page = surface_page(scan, warnings, parameters, drawn)
    yield write_atomically(options.out.with_suffix(".html"), page.encode())


def _picture(scan: ScanResult, up: str, stage: Stages) -> bytes:
    """Draw the surface, as PNG; empty without the packages that draw."""
    if absent(*PICTURES):
        return b""
    stage("drawing")
    return figure_bytes(picture(scan, up), "png")


def _precision_warning(scan: ScanResult, path: Path) -> Iterator[str]:
    """Yield a warning if a file of single precision displaces the vertices visibly."""
    if path.suffix.lower() == ".stl":
        error = float(np.abs(scan.points - scan.points.astype(np.float32)).max())
        if error > _COARSE * scan.body.spacing:
            yield (
                f"An STL file has single precision, which displaces vertices far from the origin "
                f"by up to {error:.2g}; .ply has double precision."
            )


def _cost(began: float) -> str:
    return f"{perf_counter() - began:.1f} s{memory_used(peak_memory(), ' of memory')}"
