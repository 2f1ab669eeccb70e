"""Drawings of the experiment on high dimensions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fieldrecon.plotting.style import figure, line, shades
from fieldreport.framework.experiment import Result

TITLES = (
    "step across the diagonal",
    "function of two variables",
    "sum of functions of one",
    "distance from the middle",
    "products of all pairs",
    "wave across the diagonal",
)
LEAST, MOST = 8e-4, 12
"""What is drawn, in standard deviations."""


def _looks() -> dict[str, dict[str, Any]]:
    """Label and look of each method, in the order of the arrays."""
    straight, curved = shades("LS", 2)
    near, wide = shades("MLS", 2)
    cone, cubic = shades("RBF", 2)
    return {
        "nearest": line("truth", marker="x", linestyle=":", label="nearest datum"),
        "linear": straight | {"label": "LS, linear"},
        "quadratic": curved | {"label": "LS, quadratic"},
        "near": near | {"label": "MLS, near sites"},
        "wide": wide | {"label": "MLS, all sites"},
        "cone": cone | {"label": "RBF, r"},
        "cubic": cubic | {"label": "RBF, r³"},
        "patches": line("PU", label="patches, r³"),
    }


def plot_sites(result: Result) -> Figure:
    """Error against the number of sites."""
    return errors_drawn(result.params.more, result.arrays["by_sites"], "sites")


def errors_drawn(numbers: Sequence[int], found: np.ndarray, what: str) -> Figure:
    """Draw errors (numbers, methods, functions) against the number of variables or of sites."""
    with figure(height=5.2, rows=2, columns=3, sharex=True, sharey=True) as (page, panels):
        for k, (panel, title) in enumerate(zip(panels.flat, TITLES, strict=True)):
            panel.axhline(1, **line("truth", marker="", label="mean of the data"))
            for i, look in enumerate(_looks().values()):
                error = found[:, i, k]
                there = error > 0
                panel.plot(np.array(numbers)[there], error[there], **look)
            panel.set(title=title, xscale="log", yscale="log", ylim=(LEAST, MOST))
            panel.set_xticks(numbers, [str(n) for n in numbers])
            panel.minorticks_off()
        for panel in panels[1]:
            panel.set_xlabel(f"number of {what}")
        for panel in panels[:, 0]:
            panel.set_ylabel("rms error / deviation")
        handles, labels = panels[0, 0].get_legend_handles_labels()
        page.legend(handles, labels, loc="outside lower center", ncols=3)
    return page


def plot_distances(result: Result) -> Figure:
    """Distances concentrate; and the last two coordinates of Halton's points."""
    variables, distances = result.params.variables, result.arrays["distances"]
    with figure(height=2.6, columns=3, width_ratios=(1.6, 1, 1)) as (page, panels):
        middles = (np.arange(distances.shape[1]) + 0.5) * 2.5 / distances.shape[1]
        looks = shades("truth", len(variables), marker="")
        for d, density, look in zip(variables, distances, looks, strict=True):
            panels[0].plot(middles, density, **look, label=str(d))
        panels[0].set(title="distances of two sites", xlabel="distance / mean")
        panels[0].set(xlim=(0, 2.2), ylim=(0, None))
        panels[0].set_yticks([])
        panels[0].legend(title="variables")
        last = variables[-1]
        for panel, name, title in (
            (panels[1], "last_columns", "Halton"),
            (panels[2], "scrambled", "scrambled"),
        ):
            _cloud(panel, result.arrays[name], title, f"$x_{{{last - 1}}}$", f"$x_{{{last}}}$")
    return page


def _cloud(panel: Axes, points: np.ndarray, title: str, across: str, up: str) -> None:
    panel.plot(*points.T, **line("data", markersize=1.2))
    panel.set(title=title, xlabel=across, ylabel=up, aspect="equal", xlim=(0, 1), ylim=(0, 1))
    panel.set_xticks([0, 1])
    panel.set_yticks([0, 1])
