"""Surfaces from points: a cloud becomes a body, and bodies are put together and deformed.

The cloud of a part with sharp edges and a thin fin is made a body, without any normals given, and
its triangles are audited. A wheel is scanned with noise, with holes, in the shadow of itself, with
stray points and copies, beside another body, and far from the origin; each time the distance of the
triangles from the true surface is taken. Errors fall with the number of points and with the cells.
Isolines of a terrain become a surface too, the explicit case.

References
----------
Wendland, Scattered Data Approximation (2005), section 1.1.
Carr et al., Reconstruction and representation of 3D objects with radial basis functions (2001).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial import cKDTree

from fieldrecon.datasets.synthetic import terrain
from fieldrecon.kernels.radial import thin_plate_spline
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.solids.constructive import Solid, blend, morph, transform
from fieldrecon.solids.marching_cubes import ExtractedSurface, extract_surface
from fieldrecon.solids.shapes import Ball, Box, Torus, sample_surface
from fieldrecon.surfaces.implicit_surfaces import implicit_surface
from fieldreport.experiments.methods.convergence import order
from fieldreport.experiments.surfaces.synthetic_scans import Scan, damaged, machine_part, spheroid
from fieldreport.experiments.surfaces.surface_figures import (
    draw_cloud_and_surface,
    plot_bodies,
    plot_convergence,
    plot_deformation,
    plot_isolines,
    plot_scans,
)
from fieldreport.framework.experiment import Cell, Map, Result, Table, parameter, require_at_least

__all__ = [
    "QUICK",
    "Params",
    "plot",
    "plot_bodies",
    "plot_convergence",
    "plot_deformation",
    "plot_isolines",
    "plot_scans",
    "run",
]

FAR = 1e7
"""Where the wheel is carried, in its own units, to see what rounding does."""
INVENTED = 2.0
"""Spacings from the points beyond which nobody knows where the surface is."""
TIMES = (0.25, 0.5, 0.75)
"""Of the frames between two bodies."""
METHODS = ("rbf", "hermite")
COLUMNS = ("scan", "points", "left out", "noise", "rms", "largest", "parts", "errors")


@dataclass(frozen=True)
class Params:
    """How many points the clouds have, and how fine the surfaces are."""

    points: int = parameter(6000, "points of the part that becomes a body")
    scanned: int = parameter(2000, "points of the wheel in each of its states")
    noise: float = parameter(0.3, "standard deviation of the noise, in distances of the points")
    sizes: tuple[int, ...] = parameter((75, 150, 300, 600), "points of the flattened ball")
    cells: tuple[int, ...] = parameter((4, 8, 16), "cells across the tube of a torus")
    frame: float = parameter(0.09, "edge of the cells of bodies put together, in lengths")
    isolines: int = parameter(40, "difference of height between isolines, in metres")
    window: int = parameter(100, "nodes along each side of the terrain that is shown")
    seed: int = parameter(4, "seed of the points")

    def __post_init__(self) -> None:
        require_at_least(
            self,
            points=300,
            scanned=300,
            noise=0.0,
            sizes=20,
            cells=2,
            frame=0.01,
            isolines=1,
            window=8,
            seed=0,
        )


QUICK = Params(points=300, scanned=300, sizes=(40, 80), cells=(3, 6), frame=0.4, window=16)
DIGITS = {"far_change": 0}


@dataclass(frozen=True)
class Rebuilt:
    """What came of a scan: its points, triangles, and numbers for the table."""

    cloud: np.ndarray
    points: np.ndarray
    triangles: np.ndarray
    row: tuple[Cell, ...]


def run(params: Params, each: Map = map) -> Result:
    """Reconstruct all bodies, and compare them with what they should be."""
    scans = damaged(params.scanned, params.noise, params.seed)
    scans["part"] = Scan(
        sample_surface(machine_part(), params.points, params.seed)[0], machine_part()
    )
    scans["far away"] = _far(scans["as drawn"])
    rebuilt = dict(zip(scans, each(reconstructed, scans.values()), strict=True))
    errors = np.array(list(each(errors_of, params.sizes)))
    measures = np.array(list(each(torus_errors, params.cells)))
    bodies = together(params)
    frames = dict(zip(bodies, each(partial(framed, params.frame), bodies.values()), strict=True))
    rows = tuple((name, *scan.row) for name, scan in rebuilt.items())
    land = isolines(params)
    return Result(
        params=params,
        tables={
            "scans": Table(COLUMNS, rows),
            "convergence": _table("points", METHODS, params.sizes, errors),
            "cells": _table("cells", ("volume", "area"), params.cells, measures),
        },
        facts={
            "isoline_points": len(land["land:sites"]),
            "triangles": len(rebuilt["part"].triangles),
        }
        | _facts(rebuilt)
        | _orders(METHODS, [n**-0.5 for n in params.sizes], errors)
        | _orders(("volume", "area"), [1 / n for n in params.cells], measures),
        arrays={"errors": errors, "measures": measures, "frames": np.array([*frames])}
        | {
            k: a
            for name, one in rebuilt.items()
            if name != "far away"
            for k, a in _drawn(name, one.points, one.triangles, one.cloud).items()
        }
        | {k: a for name, s in frames.items() for k, a in _drawn(name, *s).items()}
        | land,
    )


def reconstructed(scan: Scan) -> Rebuilt:
    """Make a body of a scan, and triangles of the body where there are points."""
    body = implicit_surface(scan.points)
    surface = extract_surface(body)
    off = np.abs(scan.body(surface.points)) / surface.spacing
    known = ~np.isin(np.arange(len(off)), _invented(surface))
    row = (
        len(scan.points),
        len(body.left_out),
        round(body.noise / surface.spacing, 4),
        float(np.sqrt(np.mean(off[known] ** 2))),
        float(off[known].max()),
        surface.audit.parts,
        sum(surface.audit.found.values()),
    )
    return Rebuilt(scan.points, surface.points, surface.triangles, row)


def errors_of(n: int) -> tuple[float, ...]:
    """Return the rms distances of a flattened ball from its n points' surface, by each method."""
    points, normals = spheroid(n)
    queries, _ = spheroid(1234)
    bodies = [implicit_surface(points, normals, method=m, smoothing=0.0) for m in METHODS]
    return tuple(float(np.sqrt(np.mean(body.distances(queries) ** 2))) for body in bodies)


def torus_errors(cells: int) -> tuple[float, float]:
    """Return the relative errors of volume and area of a torus, its tube so many cells wide."""
    tube = 0.4
    surface = extract_surface(Torus(1.0, tube), 2 * tube / cells)
    volume, area = 2 * np.pi**2 * tube**2, 4 * np.pi**2 * tube
    return abs(surface.volume / volume - 1), abs(surface.area / area - 1)


def together(params: Params) -> dict[str, Solid]:
    """Return two bodies made from points, put together in each way, and frames between two."""
    n = params.scanned // 2
    ring, block, ball = (
        implicit_surface(sample_surface(s, n, params.seed)[0])
        for s in (Torus(0.8, 0.3), Box([1.1, 1.1, 0.9]), Ball(0.9))
    )
    apart = transform(ring, shift=[0.45, 0.0, 0.25])
    between = {f"t = {t:g}": morph(ball, ring, t) for t in TIMES}
    return {
        "union": block | apart,
        "intersection": block & apart,
        "difference": block - apart,
        "blend": blend(block, apart, 0.3),
        "t = 0": ball,
        **between,
        "t = 1": ring,
    }


def framed(spacing: float, solid: Solid) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles of a body."""
    surface = extract_surface(solid, spacing)
    return surface.points, surface.triangles


def isolines(params: Params) -> dict[str, np.ndarray]:
    """Return points on isolines of a piece of terrain, and the surface of thin plates there."""
    whole, side = terrain(), params.window
    row, column = np.array(whole.height.shape) // 2 - side // 2
    x, y = whole.x[column : column + side], whole.y[row : row + side]
    height = whole.height[row : row + side, column : column + side]
    window = type(whole)(x, y, height)
    sites, levels = window.isolines(params.isolines, apart=150.0)
    s = PartitionOfUnityRBF(sites, thin_plate_spline(), degree=1).field(levels)
    return {
        "land:sites": np.column_stack([sites, levels]),
        "land:x": x,
        "land:y": y,
        "land:heights": s(window.points).reshape(height.shape),
    }


def _far(scan: Scan) -> Scan:
    shift = np.array([FAR, -FAR, FAR])
    return Scan(scan.points + shift, transform(scan.body, shift=shift))


def _invented(surface: ExtractedSurface) -> np.ndarray:
    """Vertices that are far from all points."""
    near = surface.solid.near
    found = cKDTree(near).query(surface.points, distance_upper_bound=INVENTED * surface.spacing)
    return np.flatnonzero(np.isinf(found[0]))


def _table(
    first: str, columns: tuple[str, ...], sizes: tuple[int, ...], values: np.ndarray
) -> Table:
    return Table((first, *columns), tuple((n, *v) for n, v in zip(sizes, values, strict=True)))


def _orders(names: tuple[str, ...], steps: list[float], errors: np.ndarray) -> dict[str, Cell]:
    return {f"order_{name}": order(steps, e) for name, e in zip(names, errors.T, strict=True)}


def _facts(rebuilt: Mapping[str, Rebuilt]) -> dict[str, Cell]:
    """Return what the text says of the scans."""
    told = {name: dict(zip(COLUMNS[1:], one.row, strict=True)) for name, one in rebuilt.items()}
    near, far = (float(told[name]["rms"]) for name in ("as drawn", "far away"))
    return {
        "part_rms": told["part"]["rms"],
        "part_largest": told["part"]["largest"],
        "noise_seen": told["with noise"]["noise"],
        "noise_left": told["with noise"]["rms"],
        "far_change": far / near - 1,
        "audit_errors": sum(int(row["errors"]) for row in told.values()),
    }


def _drawn(name: str, *arrays: np.ndarray) -> dict[str, np.ndarray]:
    return {
        f"{name}:{what}": a
        for what, a in zip(("points", "triangles", "cloud"), arrays, strict=False)
    }


def plot(result: Result) -> Figure:
    """The cloud of a part, and the surface made from it."""
    return draw_cloud_and_surface(result)
