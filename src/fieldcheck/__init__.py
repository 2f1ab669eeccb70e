"""Checks that tell a student whether an answer is right and, if not, what kind of mistake it is.

The package needs NumPy and matplotlib, and contains no solutions.
"""

from fieldcheck.datasets import terrain
from fieldcheck.drag import drag
from fieldcheck.figures import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    Picture,
    Slider,
    draw,
    figure,
    svg,
)
from fieldcheck.notebook import Progress, case, check, data, progress, start_over
from fieldcheck.verdict import Verdict

__all__ = [
    "BLUE",
    "GREEN",
    "GREY",
    "ORANGE",
    "PURPLE",
    "Picture",
    "Progress",
    "Slider",
    "Verdict",
    "case",
    "check",
    "data",
    "drag",
    "draw",
    "figure",
    "progress",
    "start_over",
    "svg",
    "terrain",
]
