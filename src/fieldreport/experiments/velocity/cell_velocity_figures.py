"""The figures of the velocities of cells."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from matplotlib.tri import Triangulation

from fieldrecon.plotting.style import FULL_WIDTH, METHOD_COLORS, figure, line

TRUE, FOUND = "#b4b4b4", METHOD_COLORS["RBF"]


def draw_fields(arrays: Mapping[str, np.ndarray], names: tuple[str, ...]) -> Figure:
    """The velocities found, thin, over the true ones at the circumcentres, thick."""
    triangles = Triangulation(arrays["points"][:, 0], arrays["points"][:, 1], arrays["cells"])
    with figure(FULL_WIDTH, height=2.35, columns=len(names)) as (page, axes):
        for panel, name, found, true in zip(
            axes, names, arrays["found"], arrays["truth"], strict=True
        ):
            panel.triplot(triangles, color="#d2d2d2", linewidth=0.6)
            look = {"angles": "xy", "scale_units": "xy", "scale": 4.2, "zorder": 3}
            at = arrays["circumcenters"].T
            thick = {"width": 0.021, "headwidth": 2.2, "headlength": 2.6, "headaxislength": 2.4}
            panel.quiver(*at, *true.T, color=TRUE, label="true", **thick, **look)
            panel.quiver(*at, *found.T, color=FOUND, width=0.006, label="found", **look)
            panel.set_title(name)
            _bare(panel)
        axes[1].legend(loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=2)
    return page


def draw_places(arrays: Mapping[str, np.ndarray]) -> Figure:
    """A triangle with its centres, its nine-point circle and the places found."""
    corners, places = arrays["corners"], arrays["places"]
    center, nine = arrays["center"], arrays["nine_point_center"]
    with figure(FULL_WIDTH * 0.62, height=3.0) as (page, panel):
        panel.add_patch(Polygon(corners, facecolor="#f1f1f1", edgecolor="black", linewidth=0.9))
        radius = float(np.linalg.norm(corners[0] - center))
        circle = {"fill": False, "edgecolor": "#8a8a8a", "linewidth": 0.7}
        panel.add_patch(Circle(tuple(center), radius, linestyle=(0, (4, 2)), **circle))
        panel.add_patch(Circle(tuple(nine), float(arrays["nine_point_radius"]), **circle))
        small = {"linestyle": "none", "zorder": 4, "clip_on": False}
        panel.plot(*places[2:].T, "o", color=METHOD_COLORS["LS"], label="strains", **small)
        panel.plot(*places[1], "s", color=METHOD_COLORS["MLS"], label="expansion", **small)
        panel.plot(*places[0], "^", color=METHOD_COLORS["RBF"], label="rotation", **small)
        named = {"$O$": center, "$K$": arrays["symmedian"], "$M$": arrays["centroid"]}
        panel.plot(
            *arrays["centroid"], "x", color="black", markersize=4, label="(centroid)", **small
        )
        for name, at in named.items():
            panel.annotate(name, at, (5, 3), textcoords="offset points")
        _bare(panel)
        panel.set(xlim=center[0] + np.array([-1.04, 1.04]) * radius)
        panel.set(ylim=center[1] + np.array([-1.04, 1.04]) * radius)
        panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return page


def draw_orders(arrays: Mapping[str, np.ndarray], params: Any) -> Figure:
    """Errors of the curved flows, left in the plane, right in space."""
    looks = {
        "at the vertices": line("LS"),
        "at the circumcentre": line("RBF"),
        "at the centroid": line("MLS"),
        "back at inner vertices": line("PU"),
    }
    shown = [2, 0, 1, 4]
    with figure(FULL_WIDTH, height=2.7, columns=2) as (page, axes):
        for panel, d, sides in zip(axes, (2, 3), (params.sides, params.sides_3d), strict=True):
            h = 1 / np.array(sides)
            errors = arrays[f"vortices_{d}d"][:, shown]
            for error, (label, look) in zip(errors.T, looks.items(), strict=True):
                panel.plot(h, error, **look | {"label": label})
            reach = h[[0, -1]]
            panel.plot(reach, 0.6 * errors[-1].min() * reach / h[-1], **line("truth", label=None))
            panel.annotate(
                "$h$", (h[-1], 0.6 * errors[-1].min()), (4, -6), textcoords="offset points"
            )
            panel.set(xscale="log", yscale="log", xlabel="step $h$")
            panel.set_title("vortices in the plane" if d == 2 else "ABC flow in space")
            panel.set_xticks(h, [f"1/{side}" for side in sides], minor=False)
            panel.minorticks_off()
        axes[0].set_ylabel("median error")
        handles, labels = axes[0].get_legend_handles_labels()
        page.legend(handles, labels, loc="outside upper center", ncols=len(looks))
    return page


def _bare(panel: Axes) -> None:
    panel.set_aspect("equal")
    panel.set_axis_off()
