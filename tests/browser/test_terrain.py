"""The page's terrain against the library's moving least squares and thin plates."""

from base64 import b64decode
from functools import cache

import numpy as np

from fieldrecon.kernels.conditionally_positive_definite import thin_plate_spline
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.rbf import RBF
from fieldreport.experiments.datasets.terrain_methods import WEIGHT
from fieldreport.widgets.terrain import cells

NAME = "terrain"
METHODS = ("moving1", "moving2", "thinPlate")


def method_of(name, data):
    points = np.array(data["points"])
    if name == "thinPlate":
        return RBF(points, thin_plate_spline())
    degree = METHODS.index(name) + 1
    return MovingLeastSquares(points, WEIGHT, degree, data["neighbors"][str(degree)])


def library_of(living):
    data = living.data
    values = np.array(data["values"])
    methods = {name: method_of(name, data) for name in METHODS}

    @cache
    def rms_of(name, heights):
        truth = np.array(heights).ravel()
        shape = (len(truth) // data["columns"], data["columns"])
        return np.sqrt(
            np.mean((methods[name].field(values)(cells(shape, data["steps"])) - truth) ** 2)
        )

    truth = tuple(map(int, np.frombuffer(b64decode(data["heights"]), "<u2")))

    def library(state, data, numbers):  # noqa: ARG001
        method, x = methods[state["method"]], np.array([state["cell"]])
        found = {
            "value": method.field(values)(x)[0],
            "rms": rms_of(state["method"], truth),
        }
        if state["method"] != "thinPlate":
            row = np.asarray(method.weights(x).todense()).ravel()
            assert set(np.flatnonzero(row)) <= set(numbers["neighbors"])
            found["weights"] = row[numbers["neighbors"]].tolist()
            found["amplification"] = np.abs(row).sum()
        return found

    return library


def test_the_page_computes_the_numbers_of_the_library(living):
    living.moves_everything(library_of(living))


def test_a_click_asks_for_another_point(living):
    living.reset()
    before = living.numbers["neighbors"]
    living.page.locator(".widget svg").first.click(position={"x": 60, "y": 60})
    assert living.numbers["neighbors"] != before
    living.agrees_with(library_of(living))
