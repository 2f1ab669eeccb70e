"""The command that turns a scan into a closed mesh, for engineers."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path
from time import perf_counter
from typing import TypeAlias

import numpy as np

from fieldrecon._core.atomic_files import whole_file, write_atomically
from fieldrecon._core.chunks import Progress
from fieldrecon._core.extras import PICTURES, absent, require
from fieldrecon._core.memory import memory_used, peak_memory
from fieldrecon._core.validation import as_length
from fieldrecon.io.clouds import read_cloud
from fieldrecon.io.triangles import packages_to_write, write_triangles
from fieldrecon.pipelines.scan import Scan, surface_of, surface_of_soup

Stage: TypeAlias = Callable[[str], Progress]

FORMATS = (".ply", ".stl", ".obj", ".off")
UP = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
_COARSE = 1e-3  # of the spacing: rounding that is told


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add = parser.add_argument
    add("cloud", type=Path, metavar="CLOUD", help=".ply, .obj, .stl, or a table: .xyz, .csv, .npz")
    add(
        "--out",
        type=Path,
        default=Path("surface.ply"),
        metavar="MESH",
        help=f"{', '.join(FORMATS)}; beside it come a page, .html, and a picture, .png",
    )
    add(
        "--normals",
        choices=("file", "estimate"),
        default="file",
        help="those of the file or of its triangles, where there are some (the default), or from "
        "the points alone",
    )
    add(
        "--smoothing",
        type=float,
        metavar="LENGTH",
        help="smooth waves of the surface away that are shorter; 0 for none (by the noise)",
    )
    add(
        "--polygons",
        type=float,
        metavar="LENGTH",
        help="take the triangles of the file as loose polygons with their outsides: 0 for a "
        "surface through them, else around them and smoothed below this length (some thousands "
        "at most: the time grows with their number times that of the mesh's triangles)",
    )
    add("--edge", type=float, metavar="LENGTH", help="of the triangles (that between points)")
    add(
        "--open",
        type=float,
        metavar="LENGTH",
        help="leave the surface out where it is farther from all points, instead of closing it",
    )
    add("--up", choices=UP, default="z", help="what points up in the picture (z)")
    parser.set_defaults(command=surface)


def surface(options: argparse.Namespace) -> int:
    """Read, fit, mesh, draw, write and tell."""
    from fieldrecon.cli.terminal import print_files, print_missing_pictures, print_scan, stages

    if options.out.suffix.lower() not in FORMATS:
        raise ValueError(f"--out {options.out} must end with {', '.join(FORMATS)}")
    if options.out.resolve() == options.cloud.resolve():
        raise ValueError(f"{options.out} is read, and would be overwritten; choose another name")
    require("skimage", *packages_to_write(options.out))
    began = perf_counter()
    with stages() as stage:
        scan = _scan(options, stage)
        written = list(_written(scan, options, stage, began))
    remarks = [*scan.remarks, *_of_file(scan, options.out)]
    print_scan(options.cloud, scan, remarks, _cost(began))
    print_files(written)
    print_missing_pictures()
    return int(not scan.sound(rim=options.open is not None))


def _scan(options: argparse.Namespace, stage: Stage) -> Scan:
    stage("reading")
    cloud = read_cloud(options.cloud)
    if options.polygons is not None:
        if options.smoothing is not None:
            raise ValueError("--smoothing is for points; --polygons says how smooth polygons are")
        epsilon = as_length(options.polygons, "--polygons", zero_allowed=True)
        return surface_of_soup(cloud, stage, epsilon, spacing=options.edge, within=options.open)
    return surface_of(
        cloud,
        stage,
        own_normals=options.normals == "file",
        smoothing=options.smoothing,
        spacing=options.edge,
        within=options.open,
    )


def _written(scan: Scan, options: argparse.Namespace, stage: Stage, began: float) -> Iterator[Path]:
    """Write the mesh, the picture and the page; yield the files."""
    from fieldrecon.pages.surface_page import surface_page

    picture = _picture(scan, options, stage)
    stage("writing")
    with whole_file(options.out) as temporary:
        write_triangles(temporary, scan.points, scan.mesh.triangles)
    yield options.out
    if picture:
        yield write_atomically(options.out.with_suffix(".png"), picture)
    asked = {
        f"--{key}": str(value) if isinstance(value, Path) else value
        for key, value in vars(options).items()
        if key not in ("command", "traceback", "cloud") and value is not None
    }
    remarks = [*scan.remarks, *_of_file(scan, options.out)]
    made = asked | {"time and memory": _cost(began)}
    text = surface_page(options.cloud.name, scan, picture, remarks, made)
    yield write_atomically(options.out.with_suffix(".html"), text.encode())


def _picture(scan: Scan, options: argparse.Namespace, stage: Stage) -> bytes:
    """Draw the surface, as PNG; nothing without the packages that draw."""
    if absent(*PICTURES):
        return b""
    from fieldrecon.plotting.figure_files import figure_bytes
    from fieldrecon.plotting.surface_picture import plot

    return figure_bytes(plot(scan, UP[options.up], stage("drawing")), "png")


def _of_file(scan: Scan, path: Path) -> Iterator[str]:
    """Tell by how much a file of single precision moves the vertices, where that shows."""
    if path.suffix.lower() == ".stl":
        moved = float(np.abs(scan.points - scan.points.astype(np.float32)).max())
        if moved > _COARSE * scan.body.spacing:
            yield (
                f"An STL keeps single precision, so far from the origin vertices move by up to "
                f"{moved:.2g}; .ply keeps them."
            )


def _cost(began: float) -> str:
    return f"{perf_counter() - began:.1f} s{memory_used(peak_memory(), ' of memory')}"
