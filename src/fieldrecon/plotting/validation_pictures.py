"""Pictures of a validation: the three distributions of distances, and held-out values."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from fieldrecon.plotting.style import figure

if TYPE_CHECKING:
    from fieldrecon.pipelines.validation import Validation

_WIDTH, _HEIGHT = 4.2, 3.3


def plot_distances(validation: Validation) -> Figure:
    """Draw the distribution functions of the distances from the nearest sample."""
    curves = {
        "targets": (validation.targets, "-"),
        "held-out samples": (validation.held_out, "--"),
        "leave-one-out": (validation.leave_one_out, ":"),
    }
    with figure(_WIDTH, _HEIGHT) as (page, axes):
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
    with figure(_WIDTH, _HEIGHT) as (page, axes):
        axes.plot(predicted, validation.values, ".", markersize=2.5)
        axes.plot(ends, ends, "-", linewidth=0.8, color="black")
        axes.set(xlabel=f"{name}, predicted", ylabel=f"{name}, held out")
    return page
