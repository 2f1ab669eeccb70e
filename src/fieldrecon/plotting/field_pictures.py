"""Pictures of a reconstructed field and of how far it may be off."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from fieldrecon.io.netcdf import Result
from fieldrecon.io.targets import Places
from fieldrecon.pipelines.survey import Outcome
from fieldrecon.plotting.style import figure
from fieldrecon.selection.extrapolation import AMONG, OUTSIDE

_SIDE = 400
"""Nodes along each side that are drawn; finer than a screen shows."""
_SAMPLES = 5000
"""Samples up to which they are drawn: more would hide the field."""
_PLACES = 20_000
_WIDTH, _HEIGHT = 4.2, 3.3


def plot(outcome: Outcome) -> Figure:
    """Draw the field and the samples, pale where extrapolated and hatched outside their hull."""
    result = _drawn(outcome.result)
    among = result.values[result.extrapolated == AMONG]
    return _picture(outcome, result, result.values, _colors(among), result.names[-1])


def plot_error(outcome: Outcome) -> Figure:
    """Draw how far the field may be off."""
    result = _drawn(outcome.result)
    among = result.error[result.extrapolated == AMONG]
    colors = _colors(among)
    if among.size and 0 < among.min() < among.max() / 30:
        low = max(among.min(), among.max() / 1e4)
        colors = {"norm": LogNorm(low, among.max())}
    return _picture(outcome, result, result.error, colors, f"error of {result.names[-1]}")


def _colors(among: np.ndarray) -> dict[str, Any]:
    """Wild values where nothing was measured do not take the colours from where something was."""
    seen = among[np.isfinite(among)]
    return {"vmin": seen.min(), "vmax": seen.max()} if len(seen) else {}


def _drawn(result: Result) -> Result:
    """The part that a picture can hold: a slice of a grid in space, and not every node."""
    places = result.places
    data = [result.values, result.error, result.extrapolated]
    if places.axes:
        data = [array.reshape(places.shape) for array in data]
        if len(places.axes) == 3:
            data = [array[len(array) // 2] for array in data]
        rows, columns = (slice(None, None, -(-n // _SIDE)) for n in data[0].shape)
        data = [array[rows, columns].ravel() for array in data]
        x, y = places.axes[0][columns], places.axes[1][rows]
        drawn = Places(np.empty((0, 2)), (x, y))
    else:
        some = slice(None, None, -(-len(places.points) // _PLACES) if places.cells is None else 1)
        data = [array[some] for array in data]
        drawn = replace(places, points=places.points[some])
    values, error, flags = data
    return replace(result, places=drawn, values=values, error=error, extrapolated=flags)


def _picture(
    outcome: Outcome, result: Result, values: np.ndarray, colors: dict[str, Any], label: str
) -> Figure:
    with figure(_WIDTH, _HEIGHT) as (page, axes):
        draw = _draw_grid if result.places.axes else _draw_scattered
        picture = draw(axes, result, values, colors)
        if outcome.result.places.points.shape[1] == 2 and len(outcome.samples.points) <= _SAMPLES:
            _draw_samples(axes, outcome)
        _set_axes(axes, outcome.result)
        page.colorbar(picture, ax=axes, label=label, extend="both", shrink=0.85)
    return page


def _draw_grid(axes: Axes, result: Result, values: np.ndarray, colors: dict[str, Any]) -> Any:
    x, y = result.places.axes
    edges = (*_outer(x), *_outer(y))
    values, flags = values.reshape(len(y), len(x)), result.extrapolated.reshape(len(y), len(x))
    picture = axes.imshow(values, extent=edges, aspect="auto", interpolation="bilinear", **colors)
    pale = np.where(flags[..., None] == AMONG, [1.0, 1.0, 1.0, 0.0], [1.0, 1.0, 1.0, 0.45])
    axes.imshow(pale, extent=edges, aspect="auto")
    if len(x) > 1 < len(y) and (outside := (flags == OUTSIDE).astype(float)).any():
        axes.contourf(x, y, outside, [0.5, 1.5], colors=["#ffffff00"], hatches=["////"])
        axes.contour(x, y, outside, [0.5], colors="black", linewidths=0.7)
    axes.set(xlim=edges[:2], ylim=edges[2:])
    return picture


def _draw_scattered(axes: Axes, result: Result, values: np.ndarray, colors: dict[str, Any]) -> Any:
    points, cells = result.places.points, result.places.cells
    if cells is not None and cells.shape[1] == 3 and points.shape[1] == 2:
        triangulation = Triangulation(points[:, 0], points[:, 1], cells)
        return axes.tripcolor(triangulation, values, shading="gouraud", **colors)
    order = np.lexsort(points.T)  # in space the highest last, so that one looks from above
    size = float(np.clip(2000 / len(points), 1.0, 30.0))
    faint: Any = np.where(result.extrapolated == AMONG, 1.0, 0.45)
    x, y = points[order, :2].T
    return axes.scatter(x, y, size, values[order], linewidths=0, alpha=faint[order], **colors)


def _draw_samples(axes: Axes, outcome: Outcome) -> None:
    x, y = outcome.samples.points.T
    if outcome.result.lonlat:
        start = outcome.result.places.points[:, 0].min()
        x = start + (x - start) % 360
    size = float(np.clip(40 / np.sqrt(len(x)), 0.4, 3.0))
    axes.plot(x, y, ".", markersize=size, markeredgewidth=0, color="black")


def _set_axes(axes: Axes, result: Result) -> None:
    places, names = result.places, result.names
    axes.set(xlabel=names[0], ylabel=names[1])
    if len(places.axes) == 3:
        middle = places.axes[2][len(places.axes[2]) // 2]
        axes.set_title(f"{names[2]} = {middle:.6g}")
    middle_y = places.points[:, 1].min() / 2 + places.points[:, 1].max() / 2
    stretch = 1 / max(np.cos(np.radians(middle_y)), 0.1) if result.lonlat else 1.0
    width, height = np.ptp(places.points[:, :2], axis=0)
    if width > 0 and 0.3 < stretch * height / width < 3:
        axes.set_aspect(stretch)
    axes.ticklabel_format(useOffset=False, style="plain")  # as on a map, every metre told
    axes.locator_params(nbins=5)
    axes.grid(visible=False)


def _outer(ticks: np.ndarray) -> tuple[float, float]:
    """Return the outer edges of cells of which the ticks are the middles."""
    half = (ticks[1] - ticks[0]) / 2 or 0.5
    return ticks[0] - half, ticks[-1] + half
