"""The page's interpolation with kernels against the library's."""

import numpy as np

from fieldreport.widgets.kernel_scale import REFUSED, error_and_condition
from living_page import Rounded

NAME = "kernel_scale"


def library(state, data, numbers):  # noqa: ARG001
    sites = np.array(data["sites"])[:, None]
    error, condition = error_and_condition(sites, state["kernel"], state["scale"])
    found = {"condition": Rounded(condition, condition)}
    if error is not REFUSED:
        # the values of the field are of size one, and their digits are those of the error too
        found["error"] = Rounded(error, condition / error)
    return found


def test_the_page_computes_the_numbers_of_the_library(living):
    for kernel in living.controls("input[type=radio]"):
        if not kernel.is_checked():
            living.press(kernel, "Space")
        living.agrees_with(library)
    living.reset()
    living.moves_everything(library)


def test_a_larger_scale_reduces_the_error_until_the_system_is_lost(living):
    """For the Gaussian: a smaller error at a hundred times the condition number, then no digit."""
    living.reset()
    before = living.numbers
    assert not living.controls(".results .warn")
    slider = living.controls("input[type=range]")[0]
    living.press(slider, *["ArrowRight"] * 7)
    assert living.numbers["error"] < before["error"] / 3
    assert living.numbers["condition"] > 100 * before["condition"]
    living.press(slider, "End")
    assert living.numbers["condition"] > 1e13
    assert len(living.controls(".results .warn")) == 1
    assert living.controls(".results dd")[3].inner_text().startswith("too ill-conditioned")
