"""The figures of surfaces from points: clouds, surfaces, bodies put together, isolines."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fieldrecon.plotting.mesh_pictures import Picture
from fieldrecon.plotting.style import figure, line, shades
from fieldreport.framework.experiment import Result

TOWARD = np.array([0.55, -0.7, 0.55])
"""Whence bodies are seen."""
SHOWN = ("with noise", "with holes", "in shadow", "with strays and copies")
BODIES = ("union", "intersection", "difference", "blend")
FROM_ABOVE = np.array([0.35, -0.75, 0.8])
_HEIGHTS = 3.0  # times higher than true: the relief is flat


def draw_cloud_and_surface(result: Result) -> Figure:
    """Draw the cloud of the part beside its surface."""
    with figure(height=2.35, columns=2) as (page, (left, right)):
        _cloud(left, result, "part", size=1.2)
        _surface(right, result, "part", 640, edges=True)
    return page


def plot_scans(result: Result) -> Figure:
    """Clouds with something wrong, above, and what was made of them, below."""
    with figure(height=2.7, rows=2, columns=len(SHOWN)) as (page, axes):
        for name, (above, below) in zip(SHOWN, axes.T, strict=True):
            above.set_title(name, loc="center", fontsize=8)
            _cloud(above, result, name, size=0.5)
            _surface(below, result, name, 320)
        for row in axes:
            _alike(row)
    return page


def plot_bodies(result: Result) -> Figure:
    """Two bodies made from points, put together in four ways."""
    return _strip(result, BODIES, height=1.6)


def plot_deformation(result: Result) -> Figure:
    """A ball that becomes a ring."""
    frames = tuple(str(n) for n in result.arrays["frames"] if str(n).startswith("t ="))
    return _strip(result, frames, height=1.35)


def plot_isolines(result: Result) -> Figure:
    """Points on isolines, and the surface through them, both seen from above and aside."""
    sites, x, y, z = (result.arrays[f"land:{k}"] for k in ("sites", "x", "y", "heights"))
    columns, rows = np.meshgrid(x, y)
    points = np.column_stack([columns.ravel(), rows.ravel(), _HEIGHTS * z.ravel()])
    picture = Picture(points, _triangulated(z.shape), FROM_ABOVE, 640)
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
    """Errors against the number of points, and against the cells."""
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
    _draw(panel, Picture(points, triangles, TOWARD, pixels), edges=edges)


def _draw(panel: Axes, picture: Picture, *, edges: bool) -> None:
    picture.near_edge &= edges
    panel.imshow(picture.image(), interpolation="antialiased")
    panel.set_axis_off()


def _alike(panels: np.ndarray) -> None:
    """Give panels windows of one shape, so that their titles are level."""
    sizes = [np.ptp([panel.get_xlim(), panel.get_ylim()], axis=1) for panel in panels]
    shape = max(height / width for width, height in sizes)
    for panel, (width, height) in zip(panels, sizes, strict=True):
        more = (shape * width - height) / 2
        low, high = panel.get_ylim()
        panel.set_ylim(low - more, high + more)


def _cloud(panel: Axes, result: Result, name: str, size: float) -> None:
    """Draw points, those behind lighter."""
    points, triangles = (result.arrays[f"{name}:{what}"] for what in ("points", "triangles"))
    picture = Picture(points, triangles, TOWARD, 40)
    x, y, depth = (result.arrays[f"{name}:cloud"] @ picture.axes).T
    order = np.argsort(depth)
    panel.scatter(
        x[order],
        y[order],
        c=-depth[order],
        cmap="Greys_r",
        s=size,
        linewidths=0,
        vmin=-depth.max(),
        vmax=-2.2 * depth.min(),
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
