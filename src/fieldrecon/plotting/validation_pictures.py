"""Pictures of a validation: the three distributions of distances, and held-out values."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from fieldrecon.plotting.style import PLAIN_NUMBERS, figure

if TYPE_CHECKING:
    from fieldrecon.pipelines.validation import Validation
    from fieldrecon.pipelines.variograms import Variogram

_WIDTH, _HEIGHT = 4.2, 3.3


def plot_distances(validation: Validation) -> Figure:
    """Draw the distribution functions of the distances from the nearest sample."""
    curves = {
        "targets": (validation.targets, "-"),
        "held-out samples": (validation.held_out, "--"),
        "leave-one-out": (validation.leave_one_out, ":"),
    }
    with figure(_WIDTH, _HEIGHT, settings=PLAIN_NUMBERS) as (page, axes):
        for label, (distances, style) in curves.items():
            fraction = np.arange(1, len(distances) + 1) / len(distances)
            axes.plot(np.sort(distances), fraction, style, label=label)
        positive = validation.held_out[validation.held_out > 0]
        if len(positive) and positive.max() > 30 * positive.min():
            axes.set_xscale("log")
        axes.set(
            xlabel="distance from the nearest sample" + validation.unit.replace(" ", ", "),
            ylabel="fraction of points",
        )
        axes.legend()
    return page


def plot_held_out(validation: Validation, name: str) -> Figure:
    """Draw the values at the held-out samples against the predicted ones."""
    predicted = validation.values - validation.residuals
    ends = np.array([validation.values.min(), validation.values.max()])
    with figure(_WIDTH, _HEIGHT, settings=PLAIN_NUMBERS) as (page, axes):
        axes.plot(predicted, validation.values, ".", markersize=2.5)
        axes.plot(ends, ends, "-", linewidth=0.8, color="black")
        axes.set(xlabel=f"{name}, predicted", ylabel=f"{name}, held out")
    return page


def plot_variogram(variogram: Variogram, name: str) -> Figure:
    """Draw the variogram of the samples, its model, the nugget, and the range if there is one."""
    h = np.linspace(0.0, variogram.distances.max(), 200)
    with figure(_WIDTH, _HEIGHT, settings=PLAIN_NUMBERS) as (page, axes):
        axes.plot(variogram.distances, variogram.values, "o", markersize=3, label="samples")
        axes.plot(h, variogram(h), "-", color="black", label="exponential model")
        axes.axhline(variogram.nugget, linestyle=":", color="black", linewidth=0.9, label="nugget")
        if variogram.levels_off:
            style = {"linestyle": "--", "color": "black", "linewidth": 0.9}
            axes.axvline(variogram.range, label="range", **style)
        axes.set(
            xlabel="distance" + variogram.unit.replace(" ", ", "),
            ylabel=f"semivariance of {name}",
            xlim=(0, h[-1]),
            ylim=(0, None),
        )
        axes.locator_params(axis="x", nbins=5)
        axes.legend(loc="lower right")
    return page
