"""The question of notebook 01 on the objective of least squares."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of
from fieldcheck.inputs.variants import one_changed
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import LEAST_TOLERANCE, Question, law, relative
from fieldcheck.questions.q01_least_squares import cloud, whole

LARGE = 1e6
"""The size of values whose squares lose the digits of residuals of size one."""


def rounding_of_residuals(values: np.ndarray) -> float:
    """Return the relative rounding error of ψ, if large values have residuals of size one."""
    return max(LEAST_TOLERANCE, 1000 * float(np.finfo(float).eps * np.abs(values).max()))


# 01.6 The objective


def objective_inputs(seed: int) -> tuple[Call, ...]:
    """Return coefficients that are not optimal, the same with other data, and an exact fit."""
    random = np.random.default_rng(seed)
    plane, space = cloud(random, 9, 2), cloud(random, 6, 3)
    c, data = random.normal(size=3), random.normal(size=9)
    d, offset = random.normal(size=4), LARGE * np.eye(4)[0]
    exact = c[0] + plane @ c[1:]
    general = calls_of(
        "objective",
        ((plane, data, c), "nine points in the plane"),
        ((plane, 2 * exact - data, c), "nine points with the opposite residual"),
        ((plane, exact + 3 * (data - exact), c), "nine points with three times the residual"),
        ((space, random.normal(size=6), d), "six points in space"),
    )
    large = calls_of(
        "objective",
        ((plane, LARGE + data, c + offset[:3]), "values of about 10⁶, and residuals of about one"),
        ((space, data[:6] - LARGE, d - offset), "six values of about −10⁶ in space"),
    )
    return (
        *general,
        *unusual_data(random),
        *few_points(random),
        *large,
        *one_changed(
            general[0],
            ("other coordinates", cloud(random, 9, 2)),
            ("other values", random.normal(size=9)),
            ("other coefficients", random.normal(size=3)),
        ),
        *one_changed(
            general[3],
            ("other coordinates", cloud(random, 6, 3)),
            ("other values", random.normal(size=6)),
            ("other coefficients", random.normal(size=4)),
        ),
        *calls_of(
            "objective",
            (
                (cloud(random, 71, 2), random.normal(size=71), random.normal(size=3)),
                "71 points in the plane",
            ),
            (
                (cloud(random, 101, 3), random.normal(size=101), random.normal(size=4)),
                "101 points in space",
            ),
        ),
    )


def few_points(random: np.random.Generator) -> tuple[Call, ...]:
    """Return points through which a plane passes, and coefficients of another plane."""
    sizes = (
        (3, 2, "three points in the plane"),
        (4, 3, "four points in space"),
        (2, 3, "two points in space"),
        (1, 2, "one point of the plane"),
    )
    return tuple(
        Call(
            "objective",
            (cloud(random, n, d), random.normal(size=n), random.normal(size=d + 1)),
            case,
        )
        for n, d, case in sizes
    )


def unusual_data(random: np.random.Generator) -> tuple[Call, ...]:
    """Return repeated points, an outlier, and arrays of integers."""
    plane, space = cloud(random, 7, 2), cloud(random, 8, 3)
    c, d = random.normal(size=3), random.normal(size=4)
    data = random.normal(size=8)
    plane[4], space[5] = plane[1], space[2]
    return (
        Call("objective", (plane, data[:7], c), "seven points, two of them the same", (0,)),
        Call("objective", (space, data, d), "eight points in space, two of them the same", (0,)),
        *calls_of(
            "objective",
            ((plane[:4], data[:4] + 700.0 * np.eye(4)[1], c), "one value far from the others"),
            ((space[:5], data[:5] - 900.0 * np.eye(5)[0], d), "one value far below the others"),
            ((whole(random, 5, 2), data[:5], c), "five points, integers"),
            ((whole(random, 6, 3), random.integers(-9, 10, 6), d), "points and values, integers"),
            ((plane[2:], 1e-9 * data[:5], 1e-9 * c), "small values, at most 10⁻⁸"),
            ((space[3:], 1e-9 * data[:5], 1e-9 * d), "small values in space, at most 10⁻⁸"),
        ),
    )


@law(
    "ψ must depend on the residuals only: it must be the same for opposite ones, and nine times as "
    "large for three times the residuals."
)
def is_a_square(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of ψ from an even and quadratic function of the residual."""
    once, turned, thrice = (float(v) for (v,) in values[:3])
    return max(relative(turned - once, once), relative(thrice - 9 * once, thrice))


QUESTIONS = (
    Question(
        "01.6",
        "objective",
        1,
        also_at_zero(objective_inputs, points=(0,), values=(1,)),
        lambda _: ((),),
        (is_a_square,),
        lambda call: rounding_of_residuals(call.arguments[1]),
        may_call=("01.3",),
    ),
)
