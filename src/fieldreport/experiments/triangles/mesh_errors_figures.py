"""The figures of the errors of meshes: a gallery, a repair, rounded signs, pairs looked at."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fieldrecon.plotting.mesh_pictures import COLORS, MARKERS, Marks, draw
from fieldrecon.plotting.style import figure, shades
from fieldreport.experiments.triangles.planted_errors import TOWARD
from fieldreport.framework.experiment import Result

FROM_THE_SIDE = np.array([0.9, -0.05, 0.65])
"""Whence the errors are seen, so that what sticks out is seen to."""
WHOLE = ("one side", "inside out", "overlap")
"""Errors that are seen in the picture of the whole body only."""
_THREE = ListedColormap(["#0072b2", "#f2f2f2", "#d55e00"])


def draw_gallery(result: Result) -> Figure:
    """Draw each planted error from near, and a key to what concerns what."""
    names = result.arrays["names"].tolist()
    columns = 4
    rows = -(-(len(names) + 1) // columns)
    with figure(height=1.62 * rows, rows=rows, columns=columns) as (page, axes):
        panels = axes.ravel()
        for panel, name in zip(panels, names, strict=False):
            panel.set_title(name, loc="center", fontsize=8)
            toward = TOWARD if name in WHOLE else FROM_THE_SIDE
            _draw(panel, result, name, toward, near=name not in WHOLE)
        _key(panels[len(names)])
        for panel in panels[len(names) + 1 :]:
            panel.remove()
    return page


def plot_repair(result: Result) -> Figure:
    """A body with many errors, before and after its repair."""
    with figure(height=2.75, columns=2) as (page, axes):
        for panel, name in zip(axes, ("before", "after"), strict=True):
            panel.set_title(name, loc="center")
            _draw(panel, result, name, np.array([0.8, -0.7, 0.6]), near=False, pixels=700)
    return page


def plot_signs(result: Result) -> Figure:
    """On which side of the diagonal points are, as rounded arithmetic has it, and exactly."""
    with figure(height=2.6, columns=2, sharey=True) as (page, axes):
        for panel, name in zip(axes, ("rounded", "exact"), strict=True):
            signs = result.arrays[name]
            panel.imshow(signs, cmap=_THREE, vmin=-1, vmax=1)
            panel.plot([-0.5, len(signs) - 0.5], [-0.5, len(signs) - 0.5], "k", linewidth=0.6)
            panel.set_title(f"{name} sign", loc="center")
            panel.set(xlabel="(x − ½) · 2⁵³", aspect="equal")
            panel.grid(visible=False)
        axes[0].set_ylabel("(y − ½) · 2⁵³")
        swatches = [
            Line2D([], [], marker="s", linestyle="", color=_THREE(k), markersize=6, label=label)
            for k, label in enumerate(("right", "on the line", "left"))
        ]
        page.legend(handles=swatches, loc="outside lower center", ncols=3)
    return page


def plot_search(result: Result) -> Figure:
    """How many pairs of triangles are looked at, and how."""
    table = result.tables["search"]
    m = np.array(table.column("triangles"), dtype=float)
    labels = {
        "all pairs": "all pairs",
        "boxes": "pairs whose boxes overlap",
    }
    with figure(height=2.4) as (page, panel):
        for (column, label), look in zip(labels.items(), shades("truth", 2), strict=True):
            panel.loglog(m, np.array(table.column(column), dtype=float), **look, label=label)
        panel.set(xlabel="triangles", ylabel="pairs")
        panel.legend()
    return page


def _draw(
    panel: Axes, result: Result, name: str, toward: np.ndarray, *, near: bool, pixels: int = 330
) -> None:
    key, found = name.replace(" ", "_"), _marks(result, name)
    points, triangles = (result.arrays[f"{key}:{what}"] for what in ("points", "triangles"))
    draw(panel, points, triangles, found, toward, pixels, near=near)


def _marks(result: Result, name: str) -> dict[str, Marks]:
    key = name.replace(" ", "_")
    kinds = {k.split(":")[1] for k in result.arrays if k.startswith(f"{key}:") and k.count(":") > 1}
    return {
        kind: Marks(
            *(result.arrays[f"{key}:{kind}:{what}"] for what in ("triangles", "edges", "vertices"))
        )
        for kind in sorted(kinds)
    }


def _key(panel: Axes) -> None:
    """Draw what the colours mean."""
    handles = [
        Line2D([], [], color=color, marker=MARKERS[concern], markersize=4, label=concern)
        for concern, color in COLORS.items()
    ]
    panel.legend(handles=handles, loc="center", fontsize=7.5, handlelength=2, borderaxespad=0)
    panel.set_axis_off()
