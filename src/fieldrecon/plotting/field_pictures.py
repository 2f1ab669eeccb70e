"""Pictures of a reconstructed field and of its error."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation
from scipy.spatial import cKDTree

from fieldrecon.io.targets import Targets, TargetValues
from fieldrecon.methods.globe import to_unit
from fieldrecon.plotting.style import PLAIN_NUMBERS, SEQUENTIAL, figure
from fieldrecon.selection.extrapolation import AMONG, OUTSIDE

if TYPE_CHECKING:
    from fieldrecon.pipelines.survey_results import SurveyResult

_SIDE = 400
"""Largest number of nodes along each side that are drawn: as many as a screen can show."""
_SAMPLES = 5000
"""Largest number of samples that are drawn; more would hide the field."""
_TARGETS = 20_000
_UNEVEN = 1e-3  # difference of the steps of an axis, as a fraction of the largest
_WIDTH, _HEIGHT = 4.2, 3.3


def color_map(name: str) -> str:
    """The name of a colour map of Matplotlib, checked.

    Raises
    ------
    ValueError
        If there is no such colour map.
    """
    if name not in colormaps:
        raise ValueError(
            f"there is no colour map {name!r}; there are viridis, cividis, magma, RdBu_r and the "
            "others of Matplotlib"
        )
    return name


def plot(survey: SurveyResult, k: int = 0, cmap: str = SEQUENTIAL) -> Figure:
    """Draw the value of index k and the samples: pale where extrapolated, hatched outside."""
    result = _drawn(survey.result.single(k))
    among = result.values[result.extrapolated == AMONG]
    colors = _colors(among) | {"cmap": cmap}
    return _picture(survey, result, result.values, colors, result.labels[-1])


def plot_error(survey: SurveyResult, k: int = 0, cmap: str = SEQUENTIAL) -> Figure:
    """Draw the error of the value of index k."""
    result = _drawn(survey.result.single(k))
    among = result.error[result.extrapolated == AMONG]
    colors = _colors(among)
    if among.size and 0 < among.min() < among.max() / 30:
        low = max(among.min(), among.max() / 1e4)
        colors = {"norm": LogNorm(low, among.max())}
    label = f"error of {result.labels[-1]}"
    return _picture(survey, result, result.error, colors | {"cmap": cmap}, label)


def plot_nearest(survey: SurveyResult, k: int = 0, cmap: str = SEQUENTIAL) -> Figure:
    """Draw the distance of each target from the nearest sample, on the globe in degrees."""
    result = survey.result.single(k)
    drawn = _drawn(replace(result, values=np.arange(len(result.values))))
    sites, x = survey.samples.points, result.targets.points[drawn.values]
    if result.lonlat:
        sites, x = to_unit(sites), to_unit(x)
    distance = cKDTree(sites).query(x)[0]
    if result.lonlat:
        distance = np.degrees(2 * np.arcsin(np.minimum(distance / 2, 1.0)))
    label = "distance from the nearest sample" + (", degrees" if result.lonlat else "")
    return _picture(survey, drawn, distance, {"vmin": 0.0, "cmap": cmap}, label)


def _colors(among: np.ndarray) -> dict[str, Any]:
    """Return the range of colours, which extrapolated values do not affect."""
    seen = among[np.isfinite(among)]
    return {"vmin": seen.min(), "vmax": seen.max()} if len(seen) else {}


def _drawn(result: TargetValues) -> TargetValues:
    """Return the part that is drawn: the middle slice of a grid in space, and not every node.

    The axes of a grid increase. A grid whose nodes are not equally spaced is drawn as points.
    """
    targets = result.targets
    data = [result.values, result.error, result.extrapolated]
    if targets.axes and all(map(_is_regular, targets.axes[:2])):
        data = [array.reshape(targets.shape) for array in data]
        if len(targets.axes) == 3:
            data = [array[len(array) // 2] for array in data]
        columns, rows = (_shown_nodes(axis) for axis in targets.axes[:2])
        data = [array[rows, columns].ravel() for array in data]
        x, y = targets.axes[0][columns], targets.axes[1][rows]
        drawn = Targets(np.empty((0, 2)), (x, y))
    else:
        some = slice(
            None, None, -(-len(targets.points) // _TARGETS) if targets.cells is None else 1
        )
        data = [array[some] for array in data]
        drawn = replace(targets, points=targets.points[some], axes=())
    values, error, flags = data
    return replace(result, targets=drawn, values=values, error=error, extrapolated=flags)


def _is_regular(axis: np.ndarray) -> bool:
    steps = np.diff(axis)
    return len(steps) > 0 and bool(np.ptp(steps) <= _UNEVEN * abs(steps).max())


def _shown_nodes(axis: np.ndarray) -> slice:
    """Nodes of an axis in increasing order, at most as many as are drawn."""
    step = -(-len(axis) // _SIDE)
    return slice(None, None, step if axis[0] <= axis[-1] else -step)


def _picture(
    survey: SurveyResult,
    result: TargetValues,
    values: np.ndarray,
    colors: dict[str, Any],
    label: str,
) -> Figure:
    with figure(_WIDTH, _HEIGHT, settings=PLAIN_NUMBERS) as (page, axes):
        page.set_layout_engine("compressed")  # a map of equal scales may be narrow
        draw = _draw_grid if result.targets.axes else _draw_scattered
        picture = draw(axes, result, values, colors)
        if survey.result.targets.points.shape[1] == 2 and len(survey.samples.points) <= _SAMPLES:
            _draw_samples(axes, survey)
        _set_axes(axes, survey.result)
        page.colorbar(picture, ax=axes, label=label, extend="both", shrink=0.85)
    return page


def _draw_grid(axes: Axes, result: TargetValues, values: np.ndarray, colors: dict[str, Any]) -> Any:
    x, y = result.targets.axes
    edges = (*_outer(x), *_outer(y))
    values, flags = values.reshape(len(y), len(x)), result.extrapolated.reshape(len(y), len(x))
    picture = axes.imshow(values, extent=edges, aspect="auto", interpolation="bilinear", **colors)
    pale = np.where(flags[..., None] == AMONG, [1.0, 1.0, 1.0, 0.0], [1.0, 1.0, 1.0, 0.45])
    axes.imshow(pale, extent=edges, aspect="auto")
    if (outside := (flags == OUTSIDE).astype(float)).any():
        axes.contourf(x, y, outside, [0.5, 1.5], colors=["#ffffff00"], hatches=["////"])
        axes.contour(x, y, outside, [0.5], colors="black", linewidths=0.7)
    axes.set(xlim=edges[:2], ylim=edges[2:])
    return picture


def _draw_scattered(
    axes: Axes, result: TargetValues, values: np.ndarray, colors: dict[str, Any]
) -> Any:
    points, cells = result.targets.points, result.targets.cells
    if cells is not None and cells.shape[1] == 3 and points.shape[1] == 2:
        triangulation = Triangulation(points[:, 0], points[:, 1], cells)
        return axes.tripcolor(triangulation, values, shading="gouraud", **colors)
    order = np.lexsort(points.T)  # in space the highest last: a view from above
    size = float(np.clip(2000 / len(points), 1.0, 30.0))
    faint: Any = np.where(result.extrapolated == AMONG, 1.0, 0.45)
    x, y = points[order, :2].T
    return axes.scatter(x, y, size, values[order], linewidths=0, alpha=faint[order], **colors)


def _draw_samples(axes: Axes, survey: SurveyResult) -> None:
    x, y = survey.samples.points.T
    if survey.result.lonlat:
        start = survey.result.targets.points[:, 0].min()
        x = start + (x - start) % 360
    size = float(np.clip(40 / np.sqrt(len(x)), 0.4, 3.0))
    axes.plot(x, y, ".", markersize=size, markeredgewidth=0, color="black")


def _set_axes(axes: Axes, result: TargetValues) -> None:
    targets, names = result.targets, result.labels
    axes.set(xlabel=names[0], ylabel=names[1])
    if len(targets.axes) == 3:
        middle = targets.axes[2][len(targets.axes[2]) // 2]
        axes.set_title(f"{names[2]} = {middle:.6g}")
    middle_y = targets.points[:, 1].min() / 2 + targets.points[:, 1].max() / 2
    stretch = 1 / max(np.cos(np.radians(middle_y)), 0.1) if result.lonlat else 1.0
    width, height = np.ptp(targets.points[:, :2], axis=0)
    slimness = stretch * height / width if width > 0 else np.inf
    axes.ticklabel_format(useOffset=False, style="plain")  # all digits, as on a map
    axes.locator_params(nbins=5)
    if 0.3 < slimness < 3:
        axes.set_aspect(stretch)
        axes.locator_params("x", nbins=int(np.ceil(5 / max(slimness, 1.0))))
    axes.grid(visible=False)


def _outer(ticks: np.ndarray) -> tuple[float, float]:
    """Return the outer edges of the first and last cell, which are centred at the ticks."""
    half = (ticks[1] - ticks[0]) / 2 or 0.5
    return ticks[0] - half, ticks[-1] + half
