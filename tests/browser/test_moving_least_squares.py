"""The page's moving least squares against the library's."""

import numpy as np

from fieldrecon.datasets.synthetic import franke
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldreport.experiments.methods.weight_shapes import count_extrema

NAME = "moving_least_squares"


def library(state, data, numbers):  # noqa: ARG001
    sites, values = np.array(data["sites"]), np.array(data["fields"][state["data"]])
    weight = inverse_square(state["ratio"] * data["spacing"])
    method = MovingLeastSquares(sites, weight, state["degree"])
    ticks = (np.arange(data["side"]) + 0.5) / data["side"]
    x = np.stack(np.meshgrid(ticks, ticks), axis=-1)
    found = method.field(values)(x)
    return {
        "extrema": count_extrema(found),
        "error": np.sqrt(np.mean((found - franke(x)) ** 2)),
        "leaveOneOut": np.sqrt(np.mean(leave_one_out(method, values) ** 2)),
        "psi": method.objective(values, x).mean(),
    }


def test_the_page_computes_the_numbers_of_the_library(living):
    living.moves_everything(library)


def test_a_larger_epsilon_removes_extrema(living):
    """At a tenth of the spacing there are several times as many as in the field, at 2 h as many."""
    slider = living.controls("input[type=range]")[0]
    living.press(slider, *["ArrowRight"] * 26)
    assert living.numbers["extrema"] <= living.data["extrema"]
    living.reset()
    assert living.numbers["extrema"] >= 3 * living.data["extrema"]
