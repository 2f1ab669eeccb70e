"""Figures of the experiment `elastic_wing`."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from fieldrecon.plotting.style import FULL_WIDTH, SEQUENTIAL, figure, line, shades
from fieldreport.framework.experiment import Result

TURN, RISE = np.radians([155.0, 26.0])  # of the eye, about the vertical and above the horizon


def seen(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places (..., 2) in the picture, and how near the eye, (...), in parallel projection."""
    x, y, z = np.moveaxis(points, -1, 0)
    right = -np.sin(TURN) * x + np.cos(TURN) * y
    toward = np.cos(TURN) * x + np.sin(TURN) * y
    up = np.cos(RISE) * z - np.sin(RISE) * toward
    return np.stack([right, up], axis=-1), np.cos(RISE) * toward + np.sin(RISE) * z


def draw_wing(result: Result) -> Figure:
    """The skin before, by its edges, and after, by how far it has risen."""
    before, after = result.arrays["before"], result.arrays["after"]
    with figure(FULL_WIDTH, height=1.8) as (page, panel):
        surface(panel, after, (after - before)[..., 2])
        for curve in (before[0], before[len(before) // 2], before[:, 0], before[:, -1]):
            panel.plot(*seen(curve)[0].T, color="black", linewidth=0.7, linestyle=(0, (4, 2)))
        panel.set(aspect="equal")
        panel.set_axis_off()
        page.colorbar(panel.collections[0], ax=panel, shrink=0.8, aspect=15, label="rise [m]")
    return page


def surface(panel: Axes, points: np.ndarray, values: np.ndarray) -> None:
    """Pieces of a surface (u, v, 3), the farthest first, coloured by values and shaded."""
    places, near = seen(points)
    corners = [places[:-1, :-1], places[1:, :-1], places[1:, 1:], places[:-1, 1:]]
    pieces = np.stack(corners, axis=2).reshape(-1, 4, 2)
    depth = (near[:-1, :-1] + near[1:, 1:] + near[1:, :-1] + near[:-1, 1:]).ravel()
    mean = (values[:-1, :-1] + values[1:, 1:]).ravel() / 2
    order = np.argsort(depth, kind="stable")
    drawn = PolyCollection(list(pieces[order]), cmap=SEQUENTIAL, array=mean[order])
    drawn.set(edgecolor="white", linewidth=0.15)
    panel.add_collection(drawn)
    panel.autoscale_view()


def plot_section(result: Result) -> Figure:
    """Pressure along the chord of the section, and the section itself, stiff and elastic."""
    pressures, outlines = result.arrays["section"], result.arrays["profile"]
    with figure(FULL_WIDTH, height=2.3, columns=2) as (page, axes):
        part = (np.arange(pressures.shape[1]) + 0.25) / pressures.shape[1]
        for (name, look), pressure, outline in zip(looks(), pressures, outlines, strict=True):
            axes[0].plot(part, pressure, **look | {"label": name, "marker": "."})
            axes[1].plot(*outline.T, **look)
        axes[0].set(xlabel="part of the chord", ylabel="$\\Delta p/q$", xlim=(0, 1))
        axes[0].set_ylim(bottom=0)
        axes[0].legend()
        axes[1].set(xlabel="along the stream [m]", ylabel="up [m]", aspect="equal")
    return page


def plot_span(result: Result) -> Figure:
    """Rise, twist, and lift, along the span."""
    y = result.arrays["y"]
    with figure(FULL_WIDTH, height=2.0, columns=3) as (page, axes):
        elastic = looks()[1][1]
        axes[0].plot(y, result.arrays["rise"], **elastic)
        axes[1].plot(y, result.arrays["twist"], **elastic)
        for (name, look), lift in zip(looks(), result.arrays["lift"], strict=True):
            axes[2].plot((y[1:] + y[:-1]) / 2, lift, **look | {"label": name})
        titles = ("rise [m]", "twist, nose up [°]", "lift per length over $q$ [m]")
        for panel, title in zip(axes, titles, strict=True):
            panel.set(title=title, xlim=(0, 1))
        axes[1].set_xlabel("part of the half span")
        axes[2].set_ylim(bottom=0)
        axes[2].legend()
    return page


def looks() -> tuple[tuple[str, dict[str, Any]], ...]:
    """Of the stiff and of the elastic wing."""
    return (
        ("stiff", line("truth", linestyle=(0, (5, 2)), marker="")),
        ("elastic", line("MLS", marker="")),
    )


def plot_turns(result: Result) -> Figure:
    """Left, the loop at the flight's pressure; right, contraction of plain turns against it."""
    params, rates = result.params, result.arrays["rates"]
    table = result.tables["sweeps"]
    with figure(FULL_WIDTH, height=2.6, columns=2) as (page, axes):
        names = {"plain": "plain", "half": "half steps", "aitken": "Aitken"}
        for look, (key, name) in zip(shades("MLS", 3), names.items(), strict=True):
            size = result.arrays[key]
            axes[0].semilogy(np.arange(len(size)), size, **look | {"label": name, "markersize": 2})
        axes[0].set(xlabel="turns", ylabel="residual, relative")
        axes[0].legend()
        q = np.array(params.pressures) * params.pressure / 1000
        most = 1.25 * q[-1]
        for look, sweep, limit, rate, bound in zip(
            shades("RBF", len(rates)),
            table.column("sweep"),
            table.column("contracts below"),
            rates,
            table.column("diverges at"),
            strict=True,
        ):
            label = f"{sweep:.0f}°".replace("-", "−")
            axes[1].plot([0, most], [0, most / limit], **look | {"marker": ""})
            axes[1].plot(q, rate, **look | {"linestyle": "none", "label": label})
            if bound != "none" and bound < most:
                axes[1].plot(bound, 1, marker="*", markersize=10, color="black", zorder=5)
        axes[1].axhline(1, color="black", linewidth=0.6)
        axes[1].axvline(params.pressure / 1000, color="black", linewidth=0.6, linestyle=":")
        axes[1].set(
            xlabel="dynamic pressure [kPa]", ylabel="factor of a plain turn", xlim=(0, most)
        )
        axes[1].set_ylim(0, 1.5)
        axes[1].legend(title="sweep")
    return page
