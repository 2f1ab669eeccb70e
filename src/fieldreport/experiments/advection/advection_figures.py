"""Figures of the experiment `advection`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fieldrecon.plotting.style import FULL_WIDTH, SEQUENTIAL, figure, line
from fieldreport.framework.experiment import Result

VARIANT_STYLES = ("RBF", "LS", "MLS")
VARIANT_NAMES = ("free", "bounded", "bounded, with its mass")


def draw_turn(result: Result) -> Figure:
    """The shapes at the beginning, and after one turn without and with bounds and mass."""
    free, kept = result.arrays["turn_0_frames"], result.arrays["turn_2_frames"]
    return _maps(
        result, (free[0], free[-1], kept[-1]), ("beginning", "one turn, free", "one turn, kept")
    )


def plot_deformation(result: Result) -> Figure:
    """The shapes in the flow that reverses: beginning, half way, and back."""
    frames = result.arrays["deformation_2_frames"]
    return _maps(result, frames, ("beginning", "half way", "back"))


def _maps(
    result: Result, frames: np.ndarray | Sequence[np.ndarray], titles: tuple[str, ...]
) -> Figure:
    x = result.arrays["x"]
    levels = np.arange(0.1, 1.0, 0.2)
    with figure(FULL_WIDTH, height=2.25, columns=3, sharey=True) as (page, axes):
        for panel, frame, title in zip(axes, frames, titles, strict=True):
            _shaded(panel, x, frame)
            panel.contour(x, x, frame, levels, colors="black", linewidths=0.4)
            panel.set(title=title, aspect="equal", xticks=[0, 0.5, 1], yticks=[0, 0.5, 1])
            panel.grid(visible=False)
        bar = page.colorbar(axes[0].images[0], ax=axes, shrink=0.85, aspect=30)
        bar.set_ticks([-0.2, 0, 0.5, 1, 1.2])
    return page


def _shaded(panel: Axes, x: np.ndarray, frame: np.ndarray) -> None:
    panel.imshow(
        frame,
        cmap=SEQUENTIAL,
        vmin=-0.2,
        vmax=1.2,
        origin="lower",
        extent=(0, 1, 0, 1),
        interpolation="nearest",
    )
    panel.set(xlim=(x[0], x[-1]), ylim=(x[0], x[-1]))


def plot_history(result: Result) -> Figure:
    """Extrema and mass of the slotted disc over one turn."""
    with figure(FULL_WIDTH, height=2.6, columns=2) as (page, axes):
        for k, (name, style) in enumerate(zip(VARIANT_NAMES, VARIANT_STYLES, strict=True)):
            history = result.arrays[f"turn_{k}_history"][:, 0]
            turn = np.linspace(0, 1, len(history))
            look = line(style, label=name, marker="")
            axes[0].plot(turn, history[:, 3], **look)
            axes[0].plot(turn, history[:, 2], **look | {"label": None})
            axes[1].plot(turn, history[:, 4], **look)
        axes[0].set(xlabel="turns", title="least and greatest value")
        axes[1].set(xlabel="turns", title="mass, relative")
        axes[1].ticklabel_format(useOffset=False)
        page.legend(*axes[1].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return page


def plot_orders(result: Result) -> Figure:
    """Errors of the feet against the step, of a hill against the spacing, and norms of powers."""
    p = result.params
    styles = ("LS", "MLS", "PU", "RBF")
    with figure(FULL_WIDTH, height=2.7, columns=3) as (page, axes):
        for name, style, row in zip(
            ("Euler", "midpoint", "Heun", "RK4"), styles, result.arrays["in_time"], strict=True
        ):
            axes[0].plot(1 / np.array(p.divisions), row, **line(style, label=name))
        axes[0].set(xlabel="step, in turns", title="feet", xscale="log", yscale="log")
        axes[0].set_xticks(1 / np.array(p.divisions), [f"1/{k}" for k in p.divisions])
        h = np.array(p.counts) ** -0.5
        axes[1].plot(h, result.arrays["in_space"], **line("PU", label=None))
        axes[1].set(xlabel="spacing $n^{-1/2}$", title="a smooth hill", xscale="log", yscale="log")
        axes[1].set_xticks(h, [f"{x:.3f}" for x in h], rotation=45)
        k = 2.0 ** np.arange(result.arrays["norms"].shape[1])
        for name, style, row in zip(
            ("disc", "square"), ("MLS", "LS"), result.arrays["norms"], strict=True
        ):
            axes[2].plot(k, row, **line(style, label=name))
        axes[2].set(xlabel="power $k$", title=r"$\|H^k\|$", xscale="log", yscale="log")
        axes[2].set_ylim(1, 1e7)
        axes[2].legend()
        for panel in axes[:2]:
            panel.minorticks_off()
        axes[0].set_ylim(1e-10, None)
        axes[0].legend(loc="lower right")
    return page
