"""The figures of velocities at vertices: marked meshes, flows that no edge sees, errors."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fieldrecon.plotting.style import FULL_WIDTH, METHOD_COLORS, figure, line
from fieldrecon.polynomials import monomials
from fieldreport.experiments.velocity.normal_matrix import field_along
from fieldreport.framework.experiment import Result

EDGES: dict[str, Any] = {"color": "0.72", "linewidth": 0.5, "zorder": 1}
WRONG = METHOD_COLORS["RBF"]
ARROWS: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "pivot": "tail", "zorder": 3}

KINDS = {
    "three": "inside, three triangles",
    "four": "inside, four triangles",
    "fan": "boundary, three triangles",
    "cross": "four, on two lines",
}
"""Stars drawn with a field that none of their edges sees."""


def draw_mesh(result: Result) -> Figure:
    """The mesh with the vertices that one ring does not determine, and what it gives there."""
    a = result.arrays
    left, inside, cells = ~a["determined"], a["inside"], a["triangles"]
    kinds = (
        (left & inside & (cells == 3), "^", "inside, 3 triangles"),
        (left & inside & (cells == 4), "s", "inside, 4 triangles"),
        (left & ~inside, "o", "boundary, 1 to 3 triangles"),
    )
    with figure(FULL_WIDTH, 3.45, columns=2) as (page, (marked, arrows)):
        for axes in (marked, arrows):
            axes.triplot(*a["points"].T, a["cells"], **EDGES)
            _bare(axes)
        for mask, marker, label in kinds:
            marked.plot(*a["points"][mask].T, marker, color=WRONG, markersize=4, label=label)
        marked.plot(*a["points"][~left].T, ".", color="0.35", markersize=2.5)
        scale = 7 * np.abs(a["truth"]).max()
        given = {"color": WRONG, "width": 0.009, "label": "one ring there"}
        _arrows(arrows, a["points"][left], a["one_ring"][left], scale, **given)
        truth = {"color": "black", "width": 0.004, "label": "truth"}
        _arrows(arrows, a["points"][left], a["truth"][left], scale, **truth)
        arrows.margins(0.12)
        marked.set(xlim=arrows.get_xlim(), ylim=arrows.get_ylim())
        marked.set_title("vertices that one ring does not determine")
        arrows.set_title("the velocities that it gives them")
        page.legend(loc="outside lower center", ncols=5, handlelength=1.2, columnspacing=1.2)
    return page


def _arrows(axes: Axes, start: np.ndarray, u: np.ndarray, scale: float, **look: Any) -> None:
    axes.quiver(*start.T, *u.T, scale=scale, **ARROWS, **look)


def plot_unseen(result: Result) -> Figure:
    """Conics through the vertices of four stars, and the flows along their level lines."""
    kinds = [kind for kind in KINDS if f"{kind}_points" in result.arrays]
    with figure(FULL_WIDTH, 1.68, columns=len(kinds), squeeze=False) as (page, axes):
        for panel, kind in zip(axes[0], kinds, strict=True):
            y, conic = result.arrays[f"{kind}_points"], result.arrays[f"{kind}_conic"]
            draw_flow_along(panel, y, conic)
            _draw_star(panel, y, boundary=kind == "fan")
            velocity = field_along(conic)[:2]
            if np.linalg.norm(velocity) > 1e-6:
                tip = 0.55 * velocity / np.linalg.norm(velocity)
                panel.quiver(0, 0, *tip, color=WRONG, scale=1, width=0.02, **ARROWS)
            panel.set_title(KINDS[kind])
            _bare(panel)
    return page


def draw_flow_along(axes: Axes, y: np.ndarray, conic: np.ndarray) -> None:
    """Draw the level lines of a conic round points, the conic itself thick."""
    reach = 1.25 * np.abs(y).max()
    ticks = np.linspace(-reach, reach, 161)
    grid = np.stack(np.meshgrid(ticks, ticks), axis=-1)
    psi = monomials(grid, 2) @ conic
    levels = np.linspace(-1, 1, 14) * np.abs(psi).max() * 0.7
    axes.contour(
        ticks,
        ticks,
        psi,
        levels=levels,
        colors=[METHOD_COLORS["MLS"]],
        linewidths=0.5,
        linestyles="solid",
        alpha=0.75,
    )
    axes.contour(ticks, ticks, psi, levels=[0.0], colors=[METHOD_COLORS["MLS"]], linewidths=1.6)


def _draw_star(axes: Axes, y: np.ndarray, boundary: bool) -> None:
    """Draw the triangles round the first vertex, in the order of the angles of the others."""
    angle = np.arctan2(*y[1:].T[::-1])
    order = np.argsort(angle)
    if boundary:  # begin after the widest gap, which is outside
        turn = np.argmax(np.diff(angle[order], append=angle[order[0]] + 2 * np.pi))
        order = np.roll(order, -turn - 1)
    rim = y[1:][order]
    rim = rim if boundary else np.vstack([rim, rim[:1]])
    look: dict[str, Any] = {"color": "black", "linewidth": 0.8, "zorder": 2}
    axes.plot(*rim.T, **look)
    for corner in y[1:]:
        axes.plot(*np.stack([y[0], corner]).T, **look)
    axes.plot(*y.T, "o", color="black", markersize=3, zorder=4)


def _bare(axes: Axes) -> None:
    axes.set(aspect="equal", xticks=[], yticks=[])
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)


def plot_convergence(result: Result) -> Figure:
    """Errors of smooth flows against the length of the edges, in the plane and in space."""
    table = result.tables["convergence"]
    rows = np.array(table.rows, dtype=float)
    column = {name: k for k, name in enumerate(table.columns)}
    looks: dict[str, dict[str, Any]] = {
        "one ring max": line("truth", linestyle=":", marker="v", label="one ring, largest"),
        "one ring rms": line("truth", marker="v", label="one ring, rms"),
        "LS rms": line("LS", label="rings as needed, LS, rms"),
        "MLS rms": line("MLS", label="rings as needed, MLS, rms"),
    }
    with figure(FULL_WIDTH, 2.9, columns=2) as (page, axes):
        for panel, d, flow in zip(axes, (2, 3), ("Taylor-Green", "ABC flow"), strict=True):
            chosen = rows[rows[:, column["D"]] == d]
            h = chosen[:, column["h"]]
            for name, look in looks.items():
                panel.plot(h, chosen[:, column[name]], **look)
            second = 0.6 * chosen[0, column["LS rms"]] * (h / h[0]) ** 2
            panel.plot(h, second, color="0.6", linewidth=0.8, zorder=0)
            at = (np.sqrt(h[0] * h[1]), np.sqrt(second[0] * second[1]))
            panel.annotate("$h^2$", at, (3, -3), textcoords="offset points", va="top", color="0.4")
            panel.set(xscale="log", yscale="log", xlabel="$h$", title=f"{flow}, D = {d}")
            sides = chosen[:, column["side"]].astype(int)
            panel.set_xticks(h, [f"1/{side}" for side in sides])
            panel.minorticks_off()
        axes[0].set_ylabel("error of the velocity")
        page.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return page
