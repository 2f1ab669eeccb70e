"""The figures of the flow past a cylinder."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from matplotlib.tri import Triangulation

from fieldrecon.plotting.style import FULL_WIDTH, METHOD_COLORS, figure, line

SPEED = LinearSegmentedColormap.from_list("speed", colormaps["YlGnBu"](np.linspace(0, 0.85, 64)))
"""From light for slow to dark for fast, in grey too, and light enough for black lines."""

WINDOW = (-3.1, 3.1, -2.15, 2.15)
CLOSE = (-1.75, -0.25, 0.15, 1.65)


def draw_flow(arrays: Mapping[str, np.ndarray]) -> Figure:
    """Speed and streamlines above the axis, mesh and velocities below."""
    points, u = arrays["points"], arrays["velocities"]
    triangles = Triangulation(points[:, 0], points[:, 1], arrays["cells"])
    speed = np.linalg.norm(u, axis=1)
    with figure(FULL_WIDTH, height=4.0) as (page, panel):
        levels = np.linspace(0, 2.1, 43)
        colors = panel.tricontourf(triangles, speed, levels=levels, cmap=SPEED, extend="max")
        colors.set_edgecolor("face")
        left, right, bottom, _ = WINDOW
        half = Rectangle((left, bottom), right - left, -bottom, transform=panel.transData)
        panel.add_patch(Rectangle((-9, -9), 18, 9, facecolor="white", alpha=0.55, zorder=2))
        for lines in panel.triplot(triangles, color="#3c4650", linewidth=0.3, zorder=2.5):
            lines.set(clip_path=half, in_layout=False)
        below = _inside(points, (*WINDOW[:2], WINDOW[2], -0.02))
        panel.quiver(
            *points[below].T,
            *u[below].T,
            angles="xy",
            scale_units="xy",
            scale=5.5,
            width=0.0021,
            color=METHOD_COLORS["RBF"],
            zorder=3,
        )
        for y in arrays["exact"]:
            panel.plot(*y.T, color="white", linewidth=2.4, zorder=3)
        upper = arrays["traced"][: len(arrays["exact"])]
        for y in upper:
            panel.plot(*y.T, color="black", linewidth=0.8, zorder=3.1)
        panel.add_patch(Circle((0, 0), 1, facecolor="#e9e9e9", edgecolor="black", zorder=4))
        panel.set(xlim=WINDOW[:2], ylim=WINDOW[2:], aspect="equal", xlabel="$x$", ylabel="$y$")
        panel.grid(visible=False)
        panel.set_yticks([-2, -1, 0, 1, 2])
        bar = page.colorbar(colors, ax=panel, shrink=0.85, pad=0.02, ticks=[0, 0.5, 1, 1.5, 2])
        bar.set_label("speed $|u|$")
        bar.outline.set_linewidth(0.6)
    return page


def draw_data(arrays: Mapping[str, np.ndarray]) -> Figure:
    """Normal velocities of faces; velocities of cells; velocities of vertices."""
    triangles = Triangulation(arrays["points"][:, 0], arrays["points"][:, 1], arrays["cells"])
    panels = {
        "in: normal velocities of faces": ("middles", "normal_velocities", METHOD_COLORS["LS"]),
        "out: velocities of cells": ("circumcenters", "cell_velocities", METHOD_COLORS["MLS"]),
        "out: velocities of vertices": ("points", "velocities", METHOD_COLORS["RBF"]),
    }
    with figure(FULL_WIDTH, height=2.25, columns=3) as (page, axes):
        for panel, (title, (where, what, color)) in zip(axes, panels.items(), strict=True):
            panel.triplot(triangles, color="#bcbcbc", linewidth=0.5)
            at, arrows = arrays[where], arrays[what]
            near = _inside(at, CLOSE)
            panel.quiver(
                *at[near].T,
                *arrows[near].T,
                angles="xy",
                scale_units="xy",
                scale=9.0,
                width=0.008,
                color=color,
                zorder=3,
                pivot="mid" if where == "middles" else "tail",
            )
            panel.add_patch(Circle((0, 0), 1, facecolor="#e9e9e9", edgecolor="black", zorder=2))
            panel.set(xlim=CLOSE[:2], ylim=CLOSE[2:], aspect="equal", xticks=[], yticks=[])
            panel.set_title(title)
            panel.grid(visible=False)
            panel.spines[:].set_visible(True)
    return page


def draw_surface(arrays: Mapping[str, np.ndarray], measures: tuple[str, ...]) -> Figure:
    """Pressure coefficient on the cylinder, and errors against the step."""
    with figure(FULL_WIDTH, height=2.9, columns=2) as (page, (left, right)):
        theta = np.linspace(0, 360, 361)
        closed = 1 - 4 * np.sin(np.radians(theta)) ** 2
        left.plot(theta, closed, **line("truth", label=r"$1 - 4\,\sin^2\theta$"))
        for name, look in (
            ("coarse", line("MLS", markerfacecolor="white")),
            ("fine", line("RBF", marker=".", markersize=2.5)),
        ):
            angle, found, _ = arrays[f"surface_{name}"]
            label = f"{len(angle)} vertices"
            left.plot(np.degrees(angle), found, **look | {"linestyle": "none", "label": label})
        left.set(xlabel=r"angle $\theta$ in degrees", title="pressure coefficient on the cylinder")
        left.set_xticks([0, 90, 180, 270, 360])
        left.set_ylim(-3.3, 3.6)
        left.set_yticks([-3, -2, -1, 0, 1])
        left.legend(loc="upper center", ncols=1)
        looks = [
            line("MLS"),
            line("RBF"),
            line("RBF", markerfacecolor="white", linewidth=0.7),
            line("LS"),
            line("PU"),
        ]
        for k, look in enumerate(looks):
            right.plot(arrays["steps"], arrays["errors"][:, k], **look | {"label": measures[k]})
        right.set(xscale="log", yscale="log", xlabel="step on the cylinder, in radii")
        right.set_title("error of the velocity")
        h = arrays["steps"]
        lowest = arrays["errors"][-1, 0]
        right.plot(h, 0.5 * lowest * (h / h[-1]) ** 2, **line("truth", label=None))
        right.annotate("$h^2$", (h[-1], 0.5 * lowest), (6, -5), textcoords="offset points")
        right.set_xticks(h, [f"2π/{round(2 * np.pi / step)}" for step in h])
        right.minorticks_off()
        right.set_ylim(top=200 * arrays["errors"][0, 1])
        right.legend(loc="upper left", ncols=2, columnspacing=1.0)
    return page


def _inside(x: np.ndarray, window: tuple[float, float, float, float]) -> np.ndarray:
    left, right, bottom, top = window
    return (x[:, 0] > left) & (x[:, 0] < right) & (x[:, 1] > bottom) & (x[:, 1] < top)
