"""Figures of the experiment `polyhedra`: level sets, solids, split corners, poles."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.ticker import NullLocator
from matplotlib.tri import Triangulation

from fieldrecon.plotting.style import DIVERGING, SEQUENTIAL, figure, shades
from fieldreport.experiments.barycentric.coordinate_formulas import split
from fieldreport.experiments.barycentric.polytopes import POLYHEDRA, Planes
from fieldreport.framework.experiment import Result

LEVELS = np.linspace(0, 1, 11)
FAR = np.array([-10, -5, -2, -1, -0.5, 0, 0.5, 1, 2, 5, 10])
SEEN: dict[str, Any] = {"color": "black", "linewidth": 0.9}
FAINT: dict[str, Any] = {"color": "0.6", "linewidth": 0.5}
HIDDEN: dict[str, Any] = {"color": "0.55", "linewidth": 0.5, "linestyle": (0, (4, 3))}

TOWARD = {"octahedron": (0.88, 0.24, 0.36), "rhombic dodecahedron": (0.85, 0.36, 0.38)}
"""View direction of some polyhedra, from which all four faces at a corner are visible."""
FROM_THE_RIGHT = (0.62, 0.42, 0.46)
"""View direction of the other polyhedra."""


def draw_solids(result: Result) -> Figure:
    """Draw the polyhedra, the simple ones above, and a coordinate on their visible faces."""
    with figure(height=4.35, rows=2, columns=3) as (page, axes):
        for panel, name in zip(axes.ravel(), POLYHEDRA, strict=True):
            bands = _draw_solid(panel, result, name)
            simple = Planes.of(POLYHEDRA[name]).simple
            panel.set_title(name if simple else f"{name}, not simple", loc="center")
        _color_bar(page, bands, axes)
    return page


def plot_polygons(result: Result) -> Figure:
    """The coordinate of one corner in the polygons."""
    names = [name for name in result.arrays["shapes"] if name not in POLYHEDRA]
    with figure(height=1.85, columns=len(names)) as (page, axes):
        for panel, name in zip(axes, names, strict=True):
            mesh = _Mesh(result, name)
            bands = _bands(panel, mesh.points, mesh.triangles, mesh.values)
            panel.add_patch(Polygon(mesh.corners, fill=False, edgecolor="black", linewidth=0.9))
            panel.plot(*mesh.corners[mesh.chosen], "o", color="black")
            _bare(panel)
            panel.set(xlim=(-1.1, 1.1), ylim=(-1.05, 1.05))
            panel.set_title(name, loc="center", fontsize=8)
        _color_bar(page, bands, axes)
    return page


def plot_edge(result: Result) -> Figure:
    """Errors of the quotient and of the products near an edge and near a corner."""
    arrays, (dark, light) = result.arrays, shades("truth", 2, markersize=3, markevery=2)
    with figure(height=2.4, columns=2, sharey=True) as (page, axes):
        for panel, what, errors in zip(
            axes, ("an edge", "a corner"), arrays["beside"], strict=True
        ):
            for error, label, look in zip(
                errors, ("quotient of the slides", "products"), (light, dark), strict=True
            ):
                panel.plot(arrays["distances"], np.maximum(error, 1e-17), **look, label=label)
            panel.set(title=f"beside {what}", xscale="log", yscale="log", ylim=(3e-18, 10))
            panel.set_xlabel("distance from it")
            panel.invert_xaxis()
            panel.xaxis.set_minor_locator(NullLocator())
        axes[0].set_ylabel("largest error of a weight")
        axes[1].legend(loc="center left")
    return page


def plot_splitting(result: Result) -> Figure:
    """Two ways to split the apex of a pyramid, and the difference as the faces come together."""
    arrays, planes = result.arrays, Planes.of(POLYHEDRA["square pyramid"])
    view = _view(FROM_THE_RIGHT)
    with figure(height=2.3, columns=3, width_ratios=(1, 1, 1.9)) as (page, axes):
        for panel, pair, title in zip(
            axes, planes.opposite, ("one way", "the other way"), strict=False
        ):
            shift = np.zeros(len(planes.offsets))
            shift[pair] = 0.22
            _outline(panel, split(planes, shift)[0], view)
            _outline(panel, planes, view, faint=True)
            panel.set(xlim=(-1.75, 1.75), ylim=(-1.3, 2.1))
            panel.set_title(title, loc="center")
        looks = shades("truth", len(arrays["crowded"]), marker="", linewidth=0.7)
        for name, errors, look in zip(arrays["crowded"], arrays["splits"], looks, strict=True):
            for k, row in enumerate(errors):
                axes[2].plot(arrays["shifts"], row, **look, label=None if k else name)
        ends = arrays["shifts"][[0, -1]]
        axes[2].plot(ends, 4 * ends, color="0.8", linewidth=2.5, label="slope 1")
        axes[2].set(xscale="log", yscale="log", xlabel="δ, by which faces are moved")
        axes[2].set_title("difference of the weights")
        axes[2].legend(loc="lower right", fontsize=7)
    return page


def plot_outside(result: Result) -> Figure:
    """One coordinate of polygons inside and outside, and the curve on which it has poles."""
    sizes = sorted({int(key.split("_")[1]) for key in result.arrays if key.startswith("outside_")})
    norm = BoundaryNorm(FAR, 256, extend="both")
    with figure(height=2.75, columns=len(sizes)) as (page, axes):
        for panel, n in zip(axes, sizes, strict=True):
            corners, crossings, grid, weight, denominator = (
                result.arrays[f"outside_{n}_{what}"]
                for what in ("corners", "crossings", "grid", "weight", "denominator")
            )
            x, y = np.moveaxis(grid, -1, 0)
            bands = panel.contourf(
                x, y, weight, levels=FAR, norm=norm, cmap=DIVERGING, extend="both"
            )
            bands.set(edgecolor="face", linewidth=0.3, rasterized=True)
            for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
                panel.axline(a, b, color="0.35", linewidth=0.4)
            panel.contour(x, y, denominator, levels=[0], colors="black", linewidths=1.8)
            panel.add_patch(Polygon(corners, fill=False, edgecolor="black", linewidth=1.0))
            panel.plot(*crossings.T, "o", color="black", markerfacecolor="white", zorder=4)
            panel.plot(*corners[0], "o", color="black", zorder=4)
            _bare(panel)
            panel.set(xlim=(x.min(), x.max()), ylim=(y.min(), y.max()))
            panel.set_title(f"{n} corners, degree {n - 3}", loc="center")
        label = "coordinate of the corner with the dot"
        bar = page.colorbar(bands, ax=axes, location="bottom", shrink=0.6, aspect=42, label=label)
        bar.set_ticks(FAR.tolist(), labels=[f"{level:g}".replace("-", "−") for level in FAR])
    return page


class _Mesh:
    """The data of one shape: a mesh of it or of its faces, and a coordinate there."""

    def __init__(self, result: Result, name: str) -> None:
        key = name.replace(" ", "_")
        self.corners = result.arrays[f"{key}_corners"]
        self.points = result.arrays[f"{key}_points"]
        self.triangles = result.arrays[f"{key}_triangles"]
        self.faces = result.arrays[f"{key}_faces"]
        self.values = result.arrays[f"{key}_values"]
        self.chosen = int(result.arrays[f"{key}_chosen"])


def _draw_solid(panel: Axes, result: Result, name: str) -> ContourSet:
    mesh, planes = _Mesh(result, name), Planes.of(POLYHEDRA[name])
    view = _view(TOWARD.get(name, FROM_THE_RIGHT))
    flat = mesh.points @ view[:, :2]
    for face in np.flatnonzero(planes.normals @ view[:, 2] > 0):
        triangles = mesh.triangles[mesh.faces == face]
        used, local = np.unique(triangles, return_inverse=True)
        bands = _bands(panel, flat[used], local.reshape(triangles.shape), mesh.values[used])
    _outline(panel, planes, view)
    low, high = flat.min(axis=0), flat.max(axis=0)
    pad = 0.04 * (high - low).max()
    panel.set(xlim=(low[0] - pad, high[0] + pad), ylim=(low[1] - pad, high[1] + pad))
    panel.plot(*(mesh.corners[mesh.chosen] @ view[:, :2]), "o", color="black", zorder=4)
    return bands


def _view(toward: tuple[float, float, float]) -> np.ndarray:
    """Return the matrix whose columns point right, up, and to the viewer."""
    towards = np.array(toward) / np.linalg.norm(toward)
    right = np.cross([0, 0, 1], towards) / np.linalg.norm(np.cross([0, 0, 1], towards))
    return np.stack([right, np.cross(towards, right), towards], axis=1)


def _outline(panel: Axes, planes: Planes, view: np.ndarray, *, faint: bool = False) -> None:
    """Draw the edges of a polyhedron, those behind it dashed."""
    edges, flat = planes.edges, planes.corners @ view[:, :2]
    front = planes.normals @ view[:, 2] > 0
    seen = (planes.on[edges[:, 0]] & planes.on[edges[:, 1]] & front).any(axis=1)
    panel.add_collection(LineCollection(flat[edges[~seen]], **(FAINT if faint else HIDDEN)))
    panel.add_collection(LineCollection(flat[edges[seen]], **(FAINT if faint else SEEN)))
    panel.autoscale_view()
    _bare(panel)


def _bands(
    panel: Axes, points: np.ndarray, triangles: np.ndarray, values: np.ndarray
) -> ContourSet:
    """Fill the bands between the levels of a coordinate, and draw the levels."""
    mesh = Triangulation(points[:, 0], points[:, 1], triangles)
    bands = panel.tricontourf(mesh, np.clip(values, 0, 1), levels=LEVELS, cmap=SEQUENTIAL)
    bands.set(edgecolor="face", linewidth=0.3)
    panel.tricontour(mesh, values, levels=LEVELS[1:-1], colors="white", linewidths=0.4)
    return bands


def _color_bar(page: Figure, bands: ContourSet, axes: Any) -> None:
    label = "coordinate of the corner with the dot"
    bar = page.colorbar(bands, ax=axes, location="bottom", shrink=0.5, aspect=35, label=label)
    bar.set_ticks(LEVELS[::2].tolist())


def _bare(panel: Axes) -> None:
    panel.set_aspect("equal")
    panel.set_axis_off()
