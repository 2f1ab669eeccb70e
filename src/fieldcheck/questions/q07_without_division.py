"""Question 07.8, Voronoi coordinates without a division that fails on edges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.question import Question, law, relative
from fieldcheck.questions.q07_voronoi_coordinates import (
    ONE,
    mirror_images,
    on_edges,
    per_place,
    places_inside,
    star,
)

# 07.8 Coordinates without division


def octagon(random: np.random.Generator) -> np.ndarray:
    """Return the corners of an uneven octagon.

    Floating-point numbers hold them, and the mirror images of their mean, exactly: each side has a
    length of a power of two, along an axis or a diagonal.
    """
    sides = [[8, 0], [1, 1], [0, 2], [-4, 4], [-4, 0], [-2, -2], [0, -4], [1, -1]]
    whole = np.roll(sides, random.integers(8), axis=0).cumsum(axis=0)
    return 2.0 ** int(random.integers(-2, 3)) * (whole + random.integers(-9, 9, 2))


def safe_inputs(seed: int) -> tuple[Call, ...]:
    """Return places inside, the same after a quarter turn, and places on the edges of a square
    cell.

    The square has sides and corners that floating-point numbers hold exactly, so that a quotient
    is zero by zero there, on every machine.
    """
    random = np.random.default_rng(seed)
    center, rim, corners = star(random, 6)
    x = places_inside(random, center, corners, 4)
    quarter = np.array([[0.0, 1.0], [-1.0, 0.0]])
    other, other_rim, other_corners = star(random, 5, clockwise=True)
    side = 2.0 ** int(random.integers(-2, 3))
    middle = side * random.integers(-9, 9, 2).astype(float)
    square = middle + side * np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    name = "safe_coordinates"
    return (
        Call(name, (center, rim, x), "four places inside a cell"),
        Call(name, (center @ quarter, rim @ quarter, x @ quarter), "the same after a quarter turn"),
        Call(
            name,
            (other, other_rim, places_inside(random, other, other_corners, 3)),
            "neighbours listed clockwise",
        ),
        Call(
            name,
            (middle, mirror_images(middle, square), on_edges(square)),
            "places on the edges of a square cell",
            exact=(0, 1, 2),
        ),
    )


@law("Turning everything changes nothing.")
def turns_along(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how much a quarter turn changes the coordinates."""
    return relative(values[1][0] - values[0][0], values[0][0])


@law("On an edge only its two corners have a weight, in the ratio of the distances.")
def is_linear_on_edges(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how far a quarter of the way along an edge the weights are from three quarters and
    one.
    """
    wanted = 0.75 * np.eye(4) + 0.25 * np.eye(4)[[1, 2, 3, 0]]
    return relative(values[3][0] - wanted, 1.0)


QUESTIONS = (
    Question(
        "07.8",
        "safe_coordinates",
        3,
        safe_inputs,
        lambda call: per_place(call, 2),
        (ONE, turns_along, is_linear_on_edges),
    ),
)
