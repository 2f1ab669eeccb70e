"""What only a grader tries in notebook 01."""

import numpy as np

from fieldcheck.calls import Call
from fieldgrade.authoring.hidden_cases import hidden


@hidden("01.2", "It must hold in every dimension, and for other numbers of points than the shown.")
def in_four_dimensions(seed):
    random = np.random.default_rng(seed + 1)
    points = random.random((40, 4))
    return (Call("fit", (points, random.normal(size=40)), "forty points in four dimensions"),)


@hidden("01.4", "The rank must not depend on the unit of length.")
def tiny_and_huge(seed):
    random = np.random.default_rng(seed + 2)
    line = random.normal(size=2) + random.normal(size=(7, 1)) * random.normal(size=2)
    return (
        Call("rank", (1e-3 * random.random((6, 2)),), "points in millimetres"),
        Call("rank", (1e5 * line,), "points on a line of many kilometres", exact=(0,)),
    )
