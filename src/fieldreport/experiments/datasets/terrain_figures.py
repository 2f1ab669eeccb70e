"""Figures of the experiment `terrain`: reliefs, maps of errors, profiles, terraces."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from fieldrecon.plotting.maps import SHADE, hillshade, map_axes
from fieldrecon.plotting.style import DIVERGING, FULL_WIDTH, figure, line, shades
from fieldreport.experiments.datasets.terrain_methods import GUARDED, THIN_PLATE, family, key
from fieldreport.framework.experiment import Result

EXAGGERATION = 2.0
"""Of the heights, in shaded reliefs."""

TINTS = LinearSegmentedColormap.from_list("tints", ["#3d6b5c", "#8fa678", "#dccd96", "#f7f3ea"])
"""Colours of heights on reliefs: lighter is higher, in grey too."""

ERRORS = colormaps[DIVERGING].resampled(11)
ERROR_LIMIT = 110.0
"""Metres at which the classes of errors end, each 20 m wide."""

LARGEST_AMPLIFICATION = 30.0
AMPLIFICATIONS = colormaps["Greys"].with_extremes(over="#010101")
"""Its last colour is not black itself, which is white on a dark page."""

PLACES = {"MLS 2": "MLS 2", THIN_PLATE: "the thin plate"}
"""Methods with profiles through the points of their largest error."""

PROFILE = 5000.0
"""Half the length of a profile, in metres."""

BESIDE = 150.0
"""Points within this distance of a profile, in metres, are drawn in it."""


def draw_points_surface_land(result: Result) -> Figure:
    """Draw the points, the thin-plate spline through them, and the terrain."""
    arrays = result.arrays
    height = _height_of_maps(result, 3) + 0.6
    with figure(height=height, columns=3) as (page, (given, made, land)):
        low, high = arrays["truth"].min(), arrays["truth"].max()
        points = given.scatter(
            *arrays["points"].T, c=arrays["heights"], vmin=low, vmax=high, **_DOTS
        )
        given.set_facecolor("#2b2b2b")
        _frame(given, result, f"{len(arrays['points']):,} points on isolines")
        _tinted(made, result, arrays[key(THIN_PLATE)])
        _frame(made, result, "the thin plate through them")
        _tinted(land, result, arrays["truth"])
        _frame(land, result, "the land")
        page.colorbar(
            points, ax=[given, made, land], label="height, m", format="{x:,.0f}", **_BELOW
        )
    return page


def plot_errors(result: Result) -> Figure:
    """Errors of the methods on one scale, and the absolute weights of one of them."""
    arrays = result.arrays
    height = 2 * _height_of_maps(result, 3) + 0.65
    with figure(height=height, rows=2, columns=3) as (page, axes):
        *maps, last = axes.ravel()
        for panel, name in zip(maps, result.params.shown, strict=True):
            errors = arrays[key(name)] - arrays["truth"]
            limits = {"vmin": -ERROR_LIMIT, "vmax": ERROR_LIMIT}
            picture = panel.imshow(errors, cmap=ERRORS, extent=_edges_of(result), **limits)
            _frame(panel, result, name)
        weights = last.imshow(
            arrays["amplification"],
            cmap=AMPLIFICATIONS,
            norm=LogNorm(1, LARGEST_AMPLIFICATION),
            extent=_edges_of(result),
        )
        _frame(last, result, "MLS 2")
        bar = page.colorbar(picture, ax=axes[1, :2], label="error, m", extend="both", **_BELOW)
        bar.set_ticks(range(-90, 91, 20))
        bar = page.colorbar(weights, ax=last, label="sum of |weights|", extend="max", **_SHORT)
        bar.set_ticks([1, 3, 10, 30], labels=["1", "3", "10", "30"])
        bar.minorticks_off()
    return page


_DOTS: dict[str, Any] = {"s": 1.2, "cmap": TINTS, "linewidths": 0}
_BELOW: dict[str, Any] = {"orientation": "horizontal", "fraction": 0.05, "aspect": 40, "pad": 0.02}
_SHORT = _BELOW | {"aspect": 19}


def plot_profiles(result: Result) -> Figure:
    """Profiles through the points of largest error of two methods, and the data beside them."""
    with figure(height=4.6, rows=2) as (page, axes):
        for panel, (name, called) in zip(axes, PLACES.items(), strict=True):
            _profile(panel, result, name)
            panel.set_title(f"through the largest error of {called}")
        axes[-1].set_xlabel("kilometres east of the western edge")
        page.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return page


def plot_spacing(result: Result) -> Figure:
    """Error against the spacing of the isolines, and against the degree of least squares."""
    params, methods = result.params, result.tables["methods"]
    with figure(height=2.9, columns=2) as (page, (spacing, degree)):
        told = {name: told for told, name in params.quoted.items()}
        for name, errors in zip(params.shown, result.arrays["window_rms"], strict=True):
            power = result.facts[f"window_{told[name]}_power"]
            spacing.plot(params.spacings, errors, **_look(name, label=f"{name}: {power:.2f}"))
        spacing.set(xscale="log", yscale="log", xlabel="spacing of the isolines, m")
        spacing.set(ylabel="error, m", title="rms error in the window")
        spacing.set_xticks(params.spacings, [str(s) for s in params.spacings])
        spacing.set_yticks([5, 10, 20, 50, 100], ["5", "10", "20", "50", "100"])
        spacing.minorticks_off()
        spacing.legend(loc="center left", bbox_to_anchor=(0, 0.66), labelspacing=0.25)
        row = methods.column("method").index
        for measure, look in zip(("largest", "rms", "median"), shades("LS", 3), strict=True):
            errors = [methods.column(measure)[row(f"LS {d}")] for d in params.degrees]
            degree.plot(params.degrees, errors, **(look | {"label": measure}))
        degree.set(yscale="log", xlabel="degree of least squares", title="errors on the whole map")
        degree.set_xticks(params.degrees)
        degree.legend(loc="upper left")
    return page


def plot_terraces(result: Result) -> Figure:
    """Reliefs of the window, and how often each height between two isolines occurs."""
    arrays = result.arrays
    drawn = ("the land", "MLS 1", GUARDED, THIN_PLATE)
    surfaces = ("truth", *map(key, drawn[1:]))
    with figure(height=3.9, rows=2, columns=4, height_ratios=[1, 1.1]) as (page, axes):
        for panel, title, surface in zip(axes[0], drawn, surfaces, strict=True):
            _relief(panel, result, surface)
            map_axes(panel, title)
        below = axes[1, 0]
        below.set_subplotspec(below.get_gridspec()[1, :])
        for panel in axes[1, 1:]:
            panel.remove()
        evenly = arrays["phase_shares"] * (len(arrays["phase_edges"]) - 1)
        for name, shares in zip(("the land", *result.params.shown), evenly, strict=True):
            if name in drawn:
                look = _look(name, linewidth=1.2)
                del look["marker"]
                below.stairs(shares, arrays["phase_edges"], baseline=None, **look)
        below.set(xlabel="height above the nearest isoline, in spacings", xlim=(-0.5, 0.5))
        below.set(ylabel="density / uniform density", ylim=(0, None))
        below.legend(loc="upper right")
    return page


def _look(name: str, **changes: Any) -> dict[str, Any]:
    """Return the line style of a method; basic variants of a method are lighter."""
    variants = dict(zip((GUARDED, "MLS 2", "MLS 1"), shades("MLS", 3), strict=True))
    look = variants.get(name) or line("truth" if name == "the land" else family(name))
    return look | {"label": name} | changes


def _relief(axes: Axes, result: Result, surface: str) -> None:
    """Draw the relief of the window, with a contrast that depends on the window only."""
    x, y = result.arrays["x"], result.arrays["y"]
    west, south, side = result.params.window
    columns, rows = (x >= west) & (x <= west + side), (y >= south) & (y <= south + side)
    heights = result.arrays[surface][rows][:, columns]
    shade = _shade(x, y, heights)
    axes.imshow(shade, cmap=SHADE, vmin=0, vmax=1, extent=_edges(x[columns], y[rows]))


def _tinted(axes: Axes, result: Result, heights: np.ndarray) -> None:
    """Draw a relief in the colours of the heights."""
    truth = result.arrays["truth"]
    tint = TINTS(Normalize(truth.min(), truth.max())(heights))[..., :3]
    x, y = result.arrays["x"], result.arrays["y"]
    lit = tint * (0.3 + 0.8 * _shade(x, y, heights))[..., None]
    axes.imshow(np.clip(lit, 0, 1), extent=_edges(x, y))


def _shade(x: np.ndarray, y: np.ndarray, heights: np.ndarray) -> np.ndarray:
    return hillshade(heights.astype(float), x[1] - x[0], y[1] - y[0], EXAGGERATION)


def _frame(axes: Axes, result: Result, title: str) -> None:
    """Make axes a map of the whole land."""
    west, east, south, north = _edges_of(result)
    axes.set(xlim=(west, east), ylim=(south, north))
    map_axes(axes, title)


def _profile(axes: Axes, result: Result, worst_of: str) -> None:
    """Draw heights from west to east through the point of largest error of a method."""
    arrays = result.arrays
    x, y, truth = arrays["x"], arrays["y"], arrays["truth"]
    row, column = np.unravel_index(np.abs(arrays[key(worst_of)] - truth).argmax(), truth.shape)
    near = np.abs(x - x[column]) <= PROFILE
    for name in result.params.shown:
        axes.plot(x[near] / 1000, arrays[key(name)][row, near], **_look(name, marker=""))
    axes.plot(x[near] / 1000, truth[row, near], **_look("the land"))
    beside = np.abs(arrays["points"][:, 1] - y[row]) <= BESIDE
    axes.plot(
        arrays["points"][beside, 0] / 1000,
        arrays["heights"][beside],
        **line("data", label="points"),
    )
    axes.axvline(float(x[column]) / 1000, color="0.6", linewidth=0.8, linestyle=":", zorder=0)
    low, high = truth[row, near].min(), truth[row, near].max()
    axes.set(xlim=(x[near][0] / 1000, x[near][-1] / 1000), ylim=(low - 120, high + 120))
    axes.yaxis.set_major_locator(MultipleLocator(result.params.spacing))
    axes.set(
        ylabel="height, m",
        title=f"through the largest error of the {worst_of}".replace("the MLS", "MLS"),
    )


def _edges(x: np.ndarray, y: np.ndarray) -> tuple[float, float, float, float]:
    """Return west, east, south and north edge of the cells, whose middles are the nodes."""
    across, along = (x[1] - x[0]) / 2, (y[1] - y[0]) / 2
    return x[0] - across, x[-1] + across, y[0] - along, y[-1] + along


def _edges_of(result: Result) -> tuple[float, float, float, float]:
    return _edges(result.arrays["x"], result.arrays["y"])


def _height_of_maps(result: Result, columns: int) -> float:
    """Return the height in inches of maps side by side, with their titles."""
    west, east, south, north = _edges_of(result)
    return (FULL_WIDTH / columns - 0.1) * (north - south) / (east - west) + 0.25
