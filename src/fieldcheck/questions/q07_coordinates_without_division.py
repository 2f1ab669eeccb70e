"""The question of notebook 07 on coordinates that are finite on edges, too."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fieldcheck.calls import Call, Values, in_short_binary_numbers, integers
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, relative
from fieldcheck.questions.q07_triangles import SMALL, beside_the_origin
from fieldcheck.questions.q07_voronoi_coordinates import (
    INTEGERS,
    Star,
    cells_of_integers,
    cells_with_integer_vertices,
    enlarged,
    mirror_images,
    per_point,
    points_inside,
    points_outside,
    star,
    sum_to_one,
    with_their_vertices,
)


def on_edges(corners: np.ndarray) -> np.ndarray:
    """Return one point on each edge, a quarter of the way from each corner to the next."""
    return 0.75 * corners + 0.25 * np.array([*corners[1:], corners[0]])


# 07.8 Coordinates without division


def safe_inputs(seed: int) -> tuple[Call, ...]:
    """Return points inside, the same after a quarter turn, on edges and corners, outside, and far
    from the origin.

    The square has sides and corners that are exact in floating-point numbers, so that a quotient is
    zero by zero there on every machine, in every unit that is a power of two.
    """
    random = np.random.default_rng(seed)
    center, rim, corners = star(random, 6)
    x = points_inside(random, center, corners, 4)
    quarter = np.array([[0.0, 1.0], [-1.0, 0.0]])
    other, other_rim, other_corners = star(random, 5, clockwise=True)
    side = 2.0 ** int(random.integers(-2, 3))
    middle = side * random.integers(-9, 9, 2).astype(float)
    square = middle + side * np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    on_square = (middle, mirror_images(middle, square), np.concatenate([on_edges(square), square]))
    tiny = tuple(2.0**-30 * part for part in on_square)
    *few, few_corners = star(random, 3)
    few_at = points_inside(random, few[0], few_corners, 1)
    beyond = (*on_square[:2], beyond_edges(square, 0.25))
    name = "safe_coordinates"
    return (
        Call(name, (center, rim, x), "four points inside a cell"),
        Call(
            name,
            (center @ quarter, rim @ quarter, x @ quarter),
            "the first cell after a quarter turn",
        ),
        Call(
            name,
            (other, other_rim, points_inside(random, other, other_corners, 3)),
            "five neighbours, listed clockwise",
        ),
        Call(name, on_square, "the edges and corners of a square cell", exact=(0, 1, 2)),
        Call(name, tiny, "the edges and corners of a square of the size 10⁻⁹", exact=(0, 1, 2)),
        Call(name, (center, rim, points_outside(center, corners)), "points outside the cell"),
        Call(
            name,
            (other, other_rim, points_outside(other, other_corners)),
            "points outside, five neighbours listed clockwise",
        ),
        *(
            Call(name, (*cell[:2], whole), case)
            for (cell, whole), case in zip(cells_of_integers(random), INTEGERS, strict=True)
        ),
        Call(name, (center, rim, x[:1]), "one point in the first cell"),
        Call(name, (*few, few_at), "one point in a cell of three neighbours"),
        *far_from_the_origin(random),
        Call(name, beyond, "points on the extended edges of a square cell", exact=(0, 1, 2)),
        Call(
            name,
            tuple(2.0**-30 * part for part in beyond),
            "points on the extended edges of a square of the size 10⁻⁹",
            exact=(0, 1, 2),
        ),
        Call(
            name,
            tuple(2.0**30 * part for part in on_square),
            "the edges and corners of a square of the size 10⁹",
            exact=(0, 1, 2),
        ),
        Call(
            name, (1e3 * center, 1e3 * rim, 1e3 * x), "four points inside a cell of the size 1000"
        ),
        *more_cells(random, (center, rim, corners), x),
        *special_cells(random),
    )


def beyond_edges(corners: np.ndarray, part: float) -> np.ndarray:
    """Return two points on the extension of each edge of a polygon, beyond either end."""
    after = np.array([*corners[1:], corners[0]])
    return np.concatenate(
        [corners + part * (corners - after), after + part * (after - corners)],
    )


def more_cells(random: np.random.Generator, first: Star, x: np.ndarray) -> Iterator[Call]:
    """Yield integers, other points in the first cell, the same ones in others, and many."""
    name = "safe_coordinates"
    for cell, inside, case in cells_with_integer_vertices(random):
        yield Call(name, (*cell[:2], inside), case)
    other = points_inside(random, first[0], first[2], len(x))
    yield Call(name, (*first[:2], other), "other points in the first cell")
    once = enlarged(first)
    yield Call(name, (*once[:2], x), "the first points in a larger cell")
    yield Call(name, (*enlarged(once)[:2], x), "the first points in a still larger cell")
    for n, m, case in (
        (3, 69, "69 points in a cell of three neighbours"),
        (43, 2, "two points in a cell of 43 neighbours"),
    ):
        center, rim, corners = star(random, n)
        yield Call(name, (center, rim, points_inside(random, center, corners, m)), case)


def special_cells(random: np.random.Generator) -> Iterator[Call]:
    """Yield vertices among the points, cells of odd integers, and small cells."""
    name = "safe_coordinates"
    for (center, rim, _), x, case in with_their_vertices(random):
        yield Call(name, (center, rim, x), case)
    for n in (6, 5):
        center, rim, corners = star(random, n)
        x = integers(points_inside(random, center, corners, 3))
        middle, whole = (300 * center, integers(rim)) if n == 6 else (integers(center), 300 * rim)
        parts = "neighbours" if n == 6 else "a vertex"
        yield Call(name, (middle, whole, x), f"{parts} and three points in arrays of integers")
    for words in ("a cell", "another cell"):
        center, rim, corners = star(random, 3)
        small = beside_the_origin(
            random, center, rim, points_inside(random, center, corners, 3), size=SMALL
        )
        case = f"{words} of three neighbours, of the size 10⁻⁵, beside the origin"
        yield Call(name, small, case, exact=(0, 1, 2))


def far_from_the_origin(random: np.random.Generator) -> Iterator[Call]:
    """Yield points inside and outside a cell, at a distance whose square leaves few digits.

    All are rounded first, so that their differences are exact.
    """
    for where, far in (("inside", 0.4), ("outside", 1.15)):
        center, rim, corners = star(random, 3, clockwise=far > 1)
        x = points_outside(center, corners, far)
        moved = tuple(in_short_binary_numbers(points) + 2.0**17 for points in (center, rim, x))
        case = f"points {where} a cell of three neighbours, 10⁵ away"
        yield Call("safe_coordinates", moved, case, exact=(0, 1, 2))


@law("Rotating the cell and the points must not change the coordinates.")
def is_rotation_invariant(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the change of the coordinates under a rotation."""
    return relative(values[1][0] - values[0][0], values[0][0])


@law(
    "On an edge only its two corners may have a weight, each in proportion to the distance from "
    "the other corner, and in a corner only this corner."
)
def is_linear_on_edges(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the weights from three quarters and one quarter, a quarter of the way
    along an edge, and from one in a corner.
    """
    wanted = np.concatenate([0.75 * np.eye(4) + 0.25 * np.eye(4)[[1, 2, 3, 0]], np.eye(4)])
    return max(relative(omega - wanted, 1.0) for (omega,) in values[3:5])


@law("Outside the cell some coordinates must be negative.")
def has_negative_coordinates_outside(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return one if the coordinates of a point outside are all positive or zero."""
    return float(max((omega.min(axis=1) > -1e-6).any() for (omega,) in values[5:7]))


QUESTIONS = (
    Question(
        "07.8",
        "safe_coordinates",
        3,
        also_at_zero(safe_inputs, points=(0, 1, 2)),
        lambda call: per_point(call, 2),
        (sum_to_one, is_rotation_invariant, is_linear_on_edges, has_negative_coordinates_outside),
    ),
)
