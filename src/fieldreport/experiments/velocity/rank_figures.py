"""The figures of normals that lose rank: their tangent fields, and the ways to them."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fieldrecon.plotting.style import FULL_WIDTH, METHOD_COLORS, figure, line, shades
from fieldrecon.polynomials import monomials
from fieldreport.framework.experiment import Result

SHOWN = {
    "parallel": "all parallel",
    "two": "all but two parallel",
    "three": "all but three, in line",
    "five": "five of six points in line",
    "rotation": "rotation",
    "expansion": "expansion",
    "spiral": "spiral",
    "saddle": "saddle",
    "parabola": "parabolas",
    "hyperbola": "vertices on a hyperbola",
}
COLUMNS = 5
HALF_EDGE = 0.15


def draw_configurations(result: Result) -> Figure:
    """Draw each sample as a short edge, and the stream lines of the tangent field."""
    with figure(FULL_WIDTH, 2.75, rows=2, columns=COLUMNS) as (page, axes):
        for panel, (name, title) in zip(axes.ravel(), SHOWN.items(), strict=True):
            p, n, edges, c = (result.arrays[f"{name}_{k}"] for k in ("p", "n", "edges", "field"))
            along = HALF_EDGE * np.column_stack([-n[:, 1], n[:, 0]])
            edges = edges if len(edges) else np.stack([p - along, p + along], axis=1)
            _draw_field(panel, c)
            for ends in edges:
                panel.plot(*ends.T, color="black", linewidth=1.2)
            panel.plot(*p.T, ".", color="black", markersize=3.5)
            panel.set(xlim=(-1.1, 1.1), ylim=(-1.1, 1.1), aspect="equal", xticks=[], yticks=[])
            panel.set_title(title, fontsize=7.5)
            panel.grid(visible=False)
            panel.spines[:].set_visible(True)
    return page


def _draw_field(axes: Axes, c: np.ndarray) -> None:
    ticks = np.linspace(-1.1, 1.1, 40)
    x, y = np.meshgrid(ticks, ticks)
    u, v = np.moveaxis(monomials(np.stack([x, y], axis=-1), 1) @ c.reshape(3, 2), -1, 0)
    blue = METHOD_COLORS["MLS"]
    axes.streamplot(x, y, u, v, color=blue, linewidth=0.6, arrowsize=0.5, density=0.55)


def draw_approach(result: Result) -> Figure:
    """Draw the smallest singular value against t, in the plane and in space."""
    t, table = result.arrays["t"], result.tables["configurations"]
    rows = list(zip(table.rows, result.arrays["smallest"], strict=True))
    with figure(FULL_WIDTH, 3.5, columns=2, sharey=True) as (page, axes):
        for panel, d, where in zip(axes, (2, 3), ("in the plane", "in space"), strict=True):
            lines = [(row, s) for row, s in rows if row[1] == d]
            looks = [*shades("MLS", len(lines) - 1, markersize=3), line("truth")]
            for (row, s), look in zip(lines, looks, strict=True):
                panel.plot(t, s, **(look | {"label": row[0], "linewidth": 0.9}))
            panel.set(xscale="log", yscale="log", xlabel="$t$", title=where)
            below = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.19), "ncols": 2}
            panel.legend(fontsize=7, labelspacing=0.3, columnspacing=1.0, **below)
        axes[0].set_ylabel("smallest singular value / largest")
    return page
