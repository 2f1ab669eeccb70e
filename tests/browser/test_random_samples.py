"""The page's three methods on its random samples against the library's."""

import numpy as np

from fieldrecon.kernels.conditionally_positive_definite import thin_plate_spline
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.rbf import RBF
from living_page import Rounded

NAME = "random_samples"


def library(state, data, numbers):
    sites, queries = np.array(numbers["sites"]), np.array(numbers["places"])
    assert (len(sites), len(queries)) == (state["count"], data["queries"])
    thin_plate = RBF(sites, thin_plate_spline())
    methods = {
        "leastSquares": (LeastSquares(sites), 1.0),
        "moving": (MovingLeastSquares(sites, inverse_square(data["epsilon"])), 1.0),
        "thinPlate": (thin_plate, np.linalg.cond(thin_plate.matrix())),
    }
    n, found = state["power"], {}
    for name, (method, condition) in methods.items():
        wrong = method.field((sites.sum(axis=1)) ** n)(queries) - queries.sum(axis=1) ** n
        if n > 1:
            found[name] = Rounded(np.sqrt(np.mean(wrong**2)), condition)
    return found


def test_the_page_computes_the_numbers_of_the_library(living):
    living.moves_everything(library)


def test_all_methods_reproduce_the_first_power(living):
    living.press(living.controls("input[type=range]")[0], "Home")
    assert max(living.numbers[m] for m in ("leastSquares", "moving", "thinPlate")) < 1e-9


def test_each_draw_has_other_samples_and_a_reload_the_same(living):
    living.reset()
    first = living.numbers["sites"]
    living.press(living.page.get_by_role("button", name="Draw again"), "Enter")
    assert living.numbers["sites"] != first
    assert living.numbers["draws"] > 1
    living.open()
    assert living.numbers["sites"] == first
