"""Surfaces from point clouds, and Boolean operations and deformations of solids.

A solid is reconstructed from a cloud of a part with sharp edges and a thin fin, without given
normals, and its triangles are audited. A wheel is scanned with noise, with holes, with
self-occlusion, with outliers and duplicates, beside another solid, and far from the origin; each
time the distance of the triangles from the true surface is measured. Convergence is measured in the
number of points and in the size of the cells. Isolines of a terrain become a surface too: the
explicit case.

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
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, to_rgba
from matplotlib.figure import Figure
from scipy.spatial import cKDTree

from fieldrecon.datasets.elevation import terrain
from fieldrecon.kernels.conditionally_positive_definite import thin_plate_spline
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.plotting.mesh_pictures import MeshPicture
from fieldrecon.plotting.style import figure, line, shades
from fieldrecon.solids.constructive import Solid, transform
from fieldrecon.solids.marching_cubes import ExtractedSurface, extract_surface
from fieldrecon.solids.shapes import Ball, Box, Cylinder, Torus, roughened, sample_surface, scanned
from fieldrecon.surfaces.implicit_surfaces import implicit_surface
from fieldrecon.surfaces.off_surface import spacing_of
from fieldreport.experiments.surfaces.solid_operations import (
    TOWARD,
    ball_and_ring,
    combined,
    deformed,
    framed,
    pictured,
)
from fieldreport.experiments.surfaces.solid_operations import plot_bodies as plot_bodies
from fieldreport.framework.error_measures import order
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter, require

EYES = np.array([[4.0, -4.0, 1.5], [-4.0, -3.0, 1.5], [0.0, 4.0, -2.0]])
"""Positions of the scanner: two above and one below, all to the side of the body."""
HOLES = 0.8 * np.array([[0.87, -0.5, 0.25], [0.0, -1.0, 0.25], [-0.87, 0.5, 0.25], [0.5, 0.87, 0]])
"""Positions of the holes in the cloud, on the rim of the wheel, and their radius."""
HOLE = 0.26

FAR = 1e7
"""The distance of the translated wheel from the origin, in its own units, for testing rounding."""
INVENTED = 2.0
"""Vertices farther than this from all points, in spacings, count as invented surface."""
METHODS = ("rbf", "hermite")
COLUMNS = ("scan", "points", "left out", "noise", "rms", "largest", "parts", "errors")


@dataclass(frozen=True)
class Params(Parameters):
    """Numbers of points of the clouds, and resolutions of the surfaces."""

    points: int = parameter(6000, "points of the part", least=300)
    scanned: int = parameter(2000, "points of the wheel in each scan", least=300)
    noise: float = parameter(
        0.3, "standard deviation of the noise, in spacings of the points", least=0, most=10
    )
    sizes: tuple[int, ...] = parameter(
        (75, 150, 300, 600), "points of the ellipsoid", least=20, fewest=2, order="increasing"
    )
    cells: tuple[int, ...] = parameter(
        (4, 8, 16), "cells across the tube of a torus", least=2, fewest=2, order="increasing"
    )
    frame: float = parameter(
        0.09, "edge of the cells for the deformation, as a length", least=0.01, most=0.5
    )
    pixels: int = parameter(
        400, "along the longer side of a picture of a Boolean operation", least=4
    )
    isolines: int = parameter(
        40, "difference of height between isolines, in metres", least=1, most=1000
    )
    window: int = parameter(100, "nodes along each side of the terrain in the figure", least=8)
    seed: int = parameter(4, "seed of the points", least=0)


QUICK = Params(
    points=300, scanned=300, sizes=(40, 80), cells=(3, 6), frame=0.4, pixels=12, window=16
)
DIGITS = {"far_change": 0}


@dataclass(frozen=True)
class Rebuilt:
    """The reconstruction of a scan: points, triangles, and the row of the table."""

    cloud: np.ndarray
    points: np.ndarray
    triangles: np.ndarray
    row: tuple[Cell, ...]


def run(params: Params, each: Map = map) -> Result:
    """Reconstruct all solids, and compare them with the exact ones."""
    land = isolines(params)  # first, since it may refuse
    scans = damaged(params.scanned, params.noise, params.seed)
    scans["part"] = SyntheticScan(
        sample_surface(machine_part(), params.points, params.seed)[0], machine_part()
    )
    scans["far away"] = _far(scans["exact points"])
    rebuilt = dict(zip(scans, each(reconstructed, scans.values()), strict=True))
    errors = np.array(list(each(errors_of, params.sizes)))
    measures = np.array(list(each(torus_errors, params.cells)))
    ball, ring = ball_and_ring(params.scanned // 2, params.seed)
    pictures = list(each(partial(pictured, params.pixels), combined(ball, ring)))
    between = deformed(ball, ring)
    frames = dict(zip(between, each(partial(framed, params.frame), between.values()), strict=True))
    rows = tuple((name, *scan.row) for name, scan in rebuilt.items())
    return Result(
        params=params,
        tables={
            "scans": ResultTable(COLUMNS, rows),
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
        arrays={
            "errors": errors,
            "measures": measures,
            "frames": np.array([*frames]),
            "bodies": np.array(pictures),
        }
        | {
            k: a
            for name, one in rebuilt.items()
            if name != "far away"
            for k, a in _drawn(name, one.points, one.triangles, one.cloud).items()
        }
        | {k: a for name, s in frames.items() for k, a in _drawn(name, *s).items()}
        | land,
    )


def reconstructed(scan: SyntheticScan) -> Rebuilt:
    """Reconstruct a solid from a scan, and its triangles where there are points."""
    body = implicit_surface(scan.points)
    surface = extract_surface(body)
    off = np.abs(scan.body(surface.points)) / body.spacing
    known = ~np.isin(np.arange(len(off)), _invented(surface, body.spacing))
    row = (
        len(scan.points),
        len(body.left_out),
        round(body.noise / body.spacing, 4),
        float(np.sqrt(np.mean(off[known] ** 2))),
        float(off[known].max()),
        surface.audit.parts,
        sum(surface.audit.found.values()),
    )
    return Rebuilt(scan.points, surface.points, surface.triangles, row)


def errors_of(n: int) -> tuple[float, ...]:
    """Return the rms distance of an ellipsoid from the surface through n points, by each method."""
    points, normals = ellipsoid(n)
    queries, _ = ellipsoid(1234)
    bodies = [implicit_surface(points, normals, method=m, smoothing=0.0) for m in METHODS]
    return tuple(float(np.sqrt(np.mean(body.distances(queries) ** 2))) for body in bodies)


def torus_errors(cells: int) -> tuple[float, float]:
    """Return the relative errors of volume and area of a torus, by cells across its tube."""
    tube = 0.4
    surface = extract_surface(Torus(1.0, tube), 2 * tube / cells)
    volume, area = 2 * np.pi**2 * tube**2, 4 * np.pi**2 * tube
    return abs(surface.volume / volume - 1), abs(surface.area / area - 1)


def isolines(params: Params) -> dict[str, np.ndarray]:
    """Return points on isolines of a part of the terrain, and the thin-plate surface there."""
    whole, side = terrain(), params.window
    row, column = np.array(whole.height.shape) // 2 - side // 2
    x, y = whole.x[column : column + side], whole.y[row : row + side]
    height = whole.height[row : row + side, column : column + side]
    window = type(whole)(x, y, height)
    sites, levels = window.isolines(params.isolines, apart=150.0)
    wanted = f"a difference that leaves isolines on the terrain of {side} nodes a side"
    require(len(sites) > 0, "isolines", wanted, params.isolines)
    s = PartitionOfUnityRBF(sites, thin_plate_spline(), degree=1).field(levels)
    return {
        "land:sites": np.column_stack([sites, levels]),
        "land:x": x,
        "land:y": y,
        "land:heights": s(window.points).reshape(height.shape),
    }


def _far(scan: SyntheticScan) -> SyntheticScan:
    shift = np.array([FAR, -FAR, FAR])
    return SyntheticScan(scan.points + shift, transform(scan.body, shift=shift))


def _invented(surface: ExtractedSurface, spacing: float) -> np.ndarray:
    """Select vertices that are far from all points."""
    near = surface.solid.near
    found = cKDTree(near).query(surface.points, distance_upper_bound=INVENTED * spacing)
    return np.flatnonzero(np.isinf(found[0]))


def _table(
    first: str, columns: tuple[str, ...], sizes: tuple[int, ...], values: np.ndarray
) -> ResultTable:
    return ResultTable(
        (first, *columns), tuple((n, *v) for n, v in zip(sizes, values, strict=True))
    )


def _orders(names: tuple[str, ...], steps: list[float], errors: np.ndarray) -> dict[str, Cell]:
    return {f"order_{name}": order(steps, e) for name, e in zip(names, errors.T, strict=True)}


def _facts(rebuilt: Mapping[str, Rebuilt]) -> dict[str, Cell]:
    """Return the facts about the scans."""
    told = {name: dict(zip(COLUMNS[1:], one.row, strict=True)) for name, one in rebuilt.items()}
    near, far = (float(told[name]["rms"]) for name in ("exact points", "far away"))
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


@dataclass(frozen=True, eq=False)
class SyntheticScan:
    """Points (n, 3) of a solid, and the exact solid."""

    points: np.ndarray
    body: Solid


def machine_part() -> Solid:
    """Return a plate with a hole, a pin with a collar, and a thin fin."""
    plate = Box([2.0, 1.4, 0.3]) - Cylinder(0.3, 1.0, [-0.6, 0.0, 0.0])
    pin = Cylinder(0.2, 1.0, [0.5, 0.0, 0.4]) | Torus(0.2, 0.13, [0.5, 0.0, 0.6])
    fin = Box([0.1, 1.1, 0.8], [-0.1, 0.0, 0.4])
    return plate | pin | fin


def wheel() -> Solid:
    """Return a ring with a hub and a bar through it."""
    return Torus(0.8, 0.22) | Cylinder(0.25, 0.5) | Box([1.5, 0.2, 0.2])


def damaged(count: int, noise: float, seed: int) -> dict[str, SyntheticScan]:
    """Return point clouds of a wheel by the name of their defect.

    Parameters
    ----------
    count : int
        Number of points of the whole wheel.
    noise : float
        Standard deviation, in units of the spacing of the points.
    seed : int
        Seed of the random numbers.
    """
    body = wheel()
    points, normals = sample_surface(body, count, seed)
    spacing = spacing_of(points)
    rng = np.random.default_rng(seed)
    rough = roughened(points, normals, noise * spacing, rng)
    missing = np.linalg.norm(points[:, None] - HOLES, axis=2).min(axis=1) < HOLE
    low, high = 1.3 * body.box
    outliers = low + (high - low) * rng.random((count // 50, 3))
    outliers = outliers[-body(outliers) > 5 * spacing]
    other = Ball(0.4, [0.0, 0.0, 0.9])
    more, _ = sample_surface(other, count // 5, seed)
    sheet = Box([1.4, 1.4, 2.2 * np.sqrt(2 * 1.4**2 / count)])
    return {
        "exact points": SyntheticScan(points, body),
        "with noise": SyntheticScan(rough, body),
        "with holes": SyntheticScan(points[~missing], body),
        "in shadow": SyntheticScan(points[scanned(body, points, normals, EYES)], body),
        "with outliers and duplicates": SyntheticScan(
            np.vstack([points, outliers, points[: count // 10]]), body
        ),
        "two bodies": SyntheticScan(np.vstack([points, more]), body | other),
        "thin sheet": SyntheticScan(sample_surface(sheet, count, seed)[0], sheet),
    }


def ellipsoid(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) evenly distributed on an ellipsoid, and its normals."""
    z = 1 - (2 * np.arange(n) + 1) / n
    angle = np.pi * (1 + 5**0.5) * np.arange(n)
    ball = np.column_stack([np.cos(angle), np.sin(angle), z])
    ball[:, :2] *= np.sqrt(1 - z**2)[:, None]
    half = np.array([1.0, 0.8, 0.6])
    normals = ball / half
    return ball * half, normals / np.linalg.norm(normals, axis=1, keepdims=True)


SHOWN = ("with noise", "with holes", "in shadow", "with outliers and duplicates")
FROM_ABOVE = np.array([0.35, -0.75, 0.8])
_HEIGHTS = 3.0  # vertical exaggeration: the relief is flat
_FAINTER = LinearSegmentedColormap.from_list(
    "fainter", [to_rgba("#2a78bb"), to_rgba("#2a78bb", 0.3)]
)
"""A colour that is visible on a white and on a dark page, from opaque to faint."""


def plot(result: Result) -> Figure:
    """Draw the cloud of the part beside its surface."""
    with figure(height=2.35, columns=2) as (page, (left, right)):
        _cloud(left, result, "part", size=1.2)
        _surface(right, result, "part", 640, edges=True)
    return page


def plot_scans(result: Result) -> Figure:
    """Clouds with defects, above, and their reconstructions, below."""
    with figure(height=2.7, rows=2, columns=len(SHOWN)) as (page, axes):
        for name, (above, below) in zip(SHOWN, axes.T, strict=True):
            above.set_title(name, loc="center", fontsize=8)
            _cloud(above, result, name, size=0.5)
            _surface(below, result, name, 320)
        for row in axes:
            _alike(row)
    return page


def plot_deformation(result: Result) -> Figure:
    """The deformation of a ball into a ring."""
    frames = tuple(str(n) for n in result.arrays["frames"] if str(n).startswith("t ="))
    return _strip(result, frames, height=1.35)


def plot_isolines(result: Result) -> Figure:
    """Points on isolines, and the surface through them, both seen obliquely from above."""
    sites, x, y, z = (result.arrays[f"land:{k}"] for k in ("sites", "x", "y", "heights"))
    columns, rows = np.meshgrid(x, y)
    points = np.column_stack([columns.ravel(), rows.ravel(), _HEIGHTS * z.ravel()])
    picture = MeshPicture(points, _triangulated(z.shape), FROM_ABOVE, 640)
    raised = sites * [1, 1, _HEIGHTS]
    places = (raised - points.min(axis=0)) / np.ptp(points, axis=0).max() @ picture.axes
    with figure(height=2.1, columns=2) as (page, (left, right)):
        left.scatter(
            *places[:, :2].T, c=sites[:, 2], cmap="viridis", s=0.7, linewidths=0, rasterized=True
        )
        left.set(aspect="equal")
        left.set_axis_off()
        _draw(right, picture, edges=False)
    return page


def plot_convergence(result: Result) -> Figure:
    """Errors against the number of points, and against the number of cells."""
    with figure(height=2.3, columns=2) as (page, (left, right)):
        table = result.tables["convergence"]
        n = np.array(table.column("points"), dtype=float)
        looks = (line("RBF"), line("MLS"))
        for name, label, look in zip(
            ("rbf", "hermite"), ("points off the surface", "normals"), looks, strict=True
        ):
            left.loglog(n, np.array(table.column(name), dtype=float), **look | {"label": label})
        left.set(xlabel="points", ylabel="rms distance")
        _ticks(left, n)
        left.legend()
        table = result.tables["cells"]
        n = np.array(table.column("cells"), dtype=float)
        for name, look in zip(("volume", "area"), shades("truth", 2), strict=True):
            right.loglog(n, np.array(table.column(name), dtype=float), **look | {"label": name})
        right.set(xlabel="cells across the tube", ylabel="relative error")
        _ticks(right, n)
        right.legend()
    return page


def _ticks(panel: Axes, n: np.ndarray) -> None:
    panel.set_xticks(n, [f"{k:g}" for k in n])
    panel.set_xticks([], minor=True)


def _strip(result: Result, names: tuple[str, ...], height: float) -> Figure:
    with figure(height=height, columns=len(names)) as (page, axes):
        for name, panel in zip(names, axes, strict=True):
            panel.set_title(name, loc="center", fontsize=8)
            _surface(panel, result, name, 320)
        _alike(axes)
    return page


def _surface(panel: Axes, result: Result, name: str, pixels: int, *, edges: bool = False) -> None:
    points, triangles = (result.arrays[f"{name}:{what}"] for what in ("points", "triangles"))
    _draw(panel, MeshPicture(points, triangles, TOWARD, pixels), edges=edges)


def _draw(panel: Axes, picture: MeshPicture, *, edges: bool) -> None:
    picture.near_edge &= edges
    panel.imshow(picture.image(), interpolation="antialiased")
    panel.set_axis_off()


def _alike(panels: np.ndarray) -> None:
    """Give panels axis limits of one aspect ratio, so that their titles are aligned."""
    sizes = [np.ptp([panel.get_xlim(), panel.get_ylim()], axis=1) for panel in panels]
    shape = max(height / width for width, height in sizes)
    for panel, (width, height) in zip(panels, sizes, strict=True):
        more = (shape * width - height) / 2
        low, high = panel.get_ylim()
        panel.set_ylim(low - more, high + more)


def _cloud(panel: Axes, result: Result, name: str, size: float) -> None:
    """Draw points; points at the back are fainter."""
    points, triangles = (result.arrays[f"{name}:{what}"] for what in ("points", "triangles"))
    picture = MeshPicture(points, triangles, TOWARD, 40)
    x, y, depth = (result.arrays[f"{name}:cloud"] @ picture.axes).T
    order = np.argsort(depth)
    panel.scatter(
        x[order],
        y[order],
        c=-depth[order],
        cmap=_FAINTER,
        s=size,
        linewidths=0,
        rasterized=True,
    )
    panel.set(aspect="equal")
    panel.set_axis_off()


def _triangulated(shape: tuple[int, ...]) -> np.ndarray:
    """Two triangles for each square of a grid."""
    index = np.arange(shape[0] * shape[1]).reshape(shape)
    a, b, c, d = (
        index[s].ravel() for s in (np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, :-1], np.s_[1:, 1:])
    )
    return np.concatenate([np.column_stack([a, b, d]), np.column_stack([a, d, c])])
