"""Questions of notebook 02, moving least squares: the field and its gradient."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.inputs.variants import one_changed
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, relative
from fieldcheck.questions.q02_local_fit import (
    EPS,
    TINY,
    affine,
    condition,
    corners,
    flat,
    other_coordinates,
    other_values,
    rounding,
    twice,
)

LOCAL = 1e-7
"""Rounding tolerance of laws about local fits, whose systems have larger condition numbers."""


def spread_of_weights(points: np.ndarray, x: np.ndarray, epsilon: float) -> float:
    """Return a bound of the ratio of weights at evaluation points x: 1 + (R/ε)²."""
    reach = float(np.ptp(np.concatenate([points, np.atleast_2d(x)]), axis=0).max())
    return 1 + (reach / epsilon) ** 2


def local_rounding(points: np.ndarray, x: np.ndarray, epsilon: float) -> float:
    """Return the rounding error of the normal equations at evaluation points x."""
    return rounding(points, spread_of_weights(points, x, epsilon))


def field_rounding(points: np.ndarray, x: np.ndarray, epsilon: float) -> float:
    """Return the rounding error of the normal equations, from the condition numbers of WB at x.

    A basis with the origin at x is right, too. The bound of ``local_rounding`` exceeds every
    mistake where one weight is a million times the others.
    """
    around = points - x[:, np.newaxis]
    w = np.linalg.norm(np.insert(around, 0, epsilon, axis=-1), axis=-1) ** -2.0
    worst = max(condition(origin + around, w).max() for origin in (0, x[:, np.newaxis]))
    return 100 * EPS * float(worst) ** 2


# 02.4 The field


def field_inputs(seed: int) -> tuple[Call, ...]:
    """Return values, with an affine field added, moved and in a small unit, in space, and with a
    small ε.

    Some points are measured twice. One evaluation point is a point of the data, and another is
    outside.
    """
    random = np.random.default_rng(seed)
    p, v = twice(random.random((15, 2)) - 0.4, 2), random.normal(size=17)
    space, data = twice(random.random((20, 3)) - 0.4, 3), random.normal(size=23)
    x, y = random.random((5, 2)) - 0.4, random.random((3, 3)) - 0.4
    slopes, shift = np.array([1.5, -2.0]), np.array([1.0, -0.5])
    x[1], y[1] = p[4], space[6]
    x[4], y[2] = x[4] + 1.5, y[2] + 1.5  # outside, where values may exceed those given
    cases = (
        ((p, v, x, 0.25), "seventeen measurements at fifteen points in the plane"),
        ((p, v + affine(p, slopes), x, 0.25), "the same values plus those of an affine field"),
        (
            (1e-5 * (p + shift), v, 1e-5 * (x + shift), 1e-5 * 0.25),
            "the same points, moved, and all lengths multiplied by 10⁻⁵",
        ),
        (
            (1e-4 * space, data, 1e-4 * y, 1e-4 * 0.5),
            "twenty-three measurements at twenty points in a cube of 10⁻⁴",
        ),
        (
            (1e-8 * p, v, 1e-8 * x, 1e-8 * 0.25),
            "seventeen measurements at fifteen points in a square of 10⁻⁸",
        ),
        (
            (1e-8 * space, data, 1e-8 * y, 1e-8 * 0.5),
            "twenty-three measurements at twenty points in a cube of 10⁻⁸",
        ),
        ((p, v, x, 0.05), "a small ε"),
        ((integers(p), integers(v), integers(x), 75.0), "points and values in the plane, integers"),
        ((integers(space), data, integers(y), 150.0), "points in space, integers"),
    )
    return (
        *(Call("field", given, case, exact=(0, 2)) for given, case in cases),
        *single_evaluations("field", random),
        *far_evaluations("field", random),
        *near_one_point(random),
        *many_or_rescaled("field", random),
        Call(
            "field",
            (p[:9], v[:9], random.random((69, 2)) - 0.4, 0.3),
            "sixty-nine evaluation points in the plane",
        ),
        *evaluations_near_a_group("field", random),
    )


def single_evaluations(name: str, random: np.random.Generator) -> tuple[Call, ...]:
    """Return one evaluation point of the plane and one of space, the same with one argument changed
    and with tiny values, and as many points as coefficients.
    """
    calls: list[Call] = []
    for n, d, words in ((9, 2, "in the plane"), (11, 3, "in space")):
        points, v, x = random.random((n, d)), random.normal(size=n), random.random((1, d))
        one = Call(name, (points, v, x, 0.4), f"one evaluation point {words}")
        tiny = Call(name, (points, TINY * v, x, 0.4), f"{one.case}, values of size 10⁻¹⁰")
        few = corners(random, d), random.normal(size=d + 1), random.random((2, d)), 0.6
        others = one_changed(
            one,
            other_coordinates(random, n, d),
            other_values(random, n),
            ("another evaluation point", random.random((1, d))),
            ("another ε", 0.7),
        )
        calls += [one, tiny, Call(name, few, f"{d + 1} measurements {words}"), *others]
    return tuple(calls)


def far_evaluations(name: str, random: np.random.Generator) -> tuple[Call, ...]:
    """Return evaluation points that are more than 60 ε away from all points."""
    plane, space = random.random((9, 2)) - 0.4, random.random((11, 3)) - 0.4
    away = np.sign(random.normal(size=(4, 3))) * random.uniform(1.9, 2.2, (4, 3))
    return calls_of(
        name,
        (
            (plane, random.normal(size=9), away[:, :2], 0.02),
            "evaluation points in the plane, far away in units of ε",
        ),
        (
            (space, random.normal(size=11), away, 0.02),
            "evaluation points in space, far away in units of ε",
        ),
    )


def near_one_point(random: np.random.Generator) -> tuple[Call, ...]:
    """Return evaluation points close to one point, whose weight is a million times the others.

    The others still determine the slopes. This point is the origin, so the normal equations lose
    few digits.
    """
    calls: list[Call] = []
    for n, d, words in ((11, 2, "in the plane"), (14, 3, "in space")):
        points = random.uniform(0.6, 0.9, (n, 1)) * unit_vectors(random, n, d)
        points[4] = 0
        x = random.uniform(3e-4, 4e-4, (3, 1)) * unit_vectors(random, 3, d)
        calls.append(
            Call(
                "field",
                (points, random.normal(size=n), x, 1e-4),
                f"evaluation points {words} within 0.0004 of one point, and ε = 0.0001",
            )
        )
    return tuple(calls)


NEAR = 0.02
"""The size of a group of points whose weights are a thousand times those of the others."""


def near_and_far(random: np.random.Generator, d: int) -> np.ndarray:
    """Return a few points close to the origin, near a line or a plane, and others far away.

    The far points have small weights at the origin, but only they determine one of the slopes.
    """
    near = NEAR * flat(random.uniform(-1, 1, (d + 2, d)))
    far = random.uniform(0.8, 1, (4 * d, 1)) * unit_vectors(random, 4 * d, d)
    return np.append(near, far, axis=0)


def evaluations_near_a_group(name: str, random: np.random.Generator) -> tuple[Call, ...]:
    """Return evaluation points beside a group of points near a line or a plane."""
    calls: list[Call] = []
    for d, words in ((2, "four points near a line"), (3, "five points near a plane")):
        points, x = near_and_far(random, d), NEAR * random.uniform(-1, 1, (3, d))
        x[:, -1] -= NEAR
        given = points, random.normal(size=len(points)), x, NEAR
        calls.append(Call(name, given, f"evaluation points close to {words}, and ε = {NEAR}"))
    return tuple(calls)


def unit_vectors(random: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Return n random unit vectors."""
    v = random.normal(size=(n, d))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def many_or_rescaled(name: str, random: np.random.Generator) -> tuple[Call, ...]:
    """Return many points, a large unit, and ε that are integers, in the plane and in space."""
    calls: list[Call] = []
    for n, d, words in ((43, 2, "in the plane"), (51, 3, "in space")):
        p, v, x = random.random((n, d)) - 0.4, random.normal(size=n), random.random((3, d)) - 0.4
        few = slice(4 * d)
        number = {43: "forty-three", 51: "fifty-one"}[n]
        calls += calls_of(
            name,
            ((p, v, x, 0.3), f"{number} points {words}"),
            (
                (1e4 * p[few], v[few], 1e4 * x, 4e3),
                f"{4 * d} points {words}, all lengths ten thousand times as large",
            ),
            (
                (integers(p[few]), integers(v[few]), integers(x), 120),
                f"{4 * d} points {words}, values and ε, all of them integers",
            ),
        )
    return tuple(calls)


@law(
    "Adding an affine field to the values must add it to the result, since the fit reproduces it.",
    LOCAL,
)
def reproduces_affine_fields(calls: Sequence[Call], values: Sequence[Values]) -> float:
    x = calls[0].arguments[2]
    gained = values[1][0] - values[0][0]
    return relative(gained - affine(x, np.array([1.5, -2.0])), np.abs(values[1][0]).max() + 1)


@law(
    "The value must stay the same if all points are moved together, or if the unit of length "
    "changes.",
    LOCAL,
)
def only_relative_positions_count(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[2][0] - values[0][0], np.abs(values[0][0]).max() + 1)


# 02.7 The gradient


def gradient_inputs(seed: int) -> tuple[Call, ...]:
    """Return evaluation points on a circle, with an affine field added, in space, and both in
    another unit. Two evaluation points are points of the data, and two points are measured twice.
    """
    random = np.random.default_rng(seed)
    p, v = twice(random.random((18, 2)), 2), random.normal(size=20)
    space, data = twice(random.random((23, 3)) - 0.4, 2), random.normal(size=25)
    y = random.random((3, 3)) - 0.4
    circle = np.exp(2j * np.pi * np.arange(CIRCLE) / CIRCLE)
    x = 0.5 + 0.1 * np.column_stack([circle.real, circle.imag])
    p[7], space[7] = x[5], y[1]
    slopes = np.array([1.5, -2.0])
    cases = (
        ((p, v, x, 0.3), "evaluation points on a circle"),
        ((p, v + affine(p, slopes), x, 0.3), "the same values plus those of an affine field"),
        ((space, data, y, 0.5), "twenty-five points in space"),
        ((UNIT * p, v, UNIT * x, UNIT * 0.3), "the points on a circle, all lengths a thousandth"),
        (
            (UNIT * space, data, UNIT * y, UNIT * 0.5),
            "the points in space, all lengths a thousandth",
        ),
        ((p, v + HIGH, x, 0.3), "the points on a circle, all values larger by 10000"),
        ((space, data + HIGH, y, 0.5), "the points in space, all values larger by 10000"),
        ((integers(p), integers(v), integers(x), 90.0), "the points on a circle, integers"),
        ((integers(space), data, integers(y), 150.0), "the points in space, integers"),
    )
    return (
        *(Call("gradient", given, case, exact=(0, 2)) for given, case in cases),
        *single_evaluations("gradient", random),
        *many_or_rescaled("gradient", random),
        Call(
            "gradient",
            (random.random((12, 1)), v[:12], random.random((69, 1)), 0.4),
            "sixty-nine evaluation points on a line",
        ),
        *evaluations_near_a_group("gradient", random),
    )


HIGH = 1e4
"""A constant that changes no gradient, and from which difference quotients lose four digits."""
UNIT = 1e-3
CIRCLE = 24
"""The number of points on the circle for which the sum along it equals the integral."""


@law(
    "The gradient must have no circulation: its components along a closed circle must add up to "
    "zero.",
    LOCAL,
)
def has_zero_circulation(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the sum of the slopes along the circle, relative to that of their absolute values."""
    x, (g,) = calls[0].arguments[2], values[0]
    outward = x - 0.5
    along = g[:, 1] * outward[:, 0] - g[:, 0] * outward[:, 1]
    return float(abs(along.sum()) / max(np.abs(g).max() * 0.1 * CIRCLE, EPS))


@law("Where all lengths are a thousandth, the gradient must be a thousand times as large.", LOCAL)
def is_per_unit_of_length(calls: Sequence[Call], values: Sequence[Values]) -> float:
    pairs = ((values[3][0], values[0][0]), (values[4][0], values[2][0]))
    return max(relative(UNIT * small - large, large) for small, large in pairs)


@law("Adding an affine field to the values must add its slopes to the gradient.", LOCAL)
def adds_the_slope_of_affine_fields(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(
        values[1][0] - values[0][0] - np.array([1.5, -2.0]), np.abs(values[1][0]).max() + 1
    )


QUESTIONS = (
    Question(
        "02.4",
        "field",
        3,
        also_at_zero(field_inputs, points=(0, 2), values=(1,)),
        lambda call: ((len(call.arguments[2]),),),
        (reproduces_affine_fields, only_relative_positions_count),
        lambda call: field_rounding(call.arguments[0], call.arguments[2], call.arguments[3]),
    ),
    Question(
        "02.7",
        "gradient",
        4,
        also_at_zero(gradient_inputs, points=(0, 2), values=(1,)),
        lambda call: (call.arguments[2].shape,),
        (has_zero_circulation, adds_the_slope_of_affine_fields, is_per_unit_of_length),
        lambda call: 10 * local_rounding(call.arguments[0], call.arguments[2], call.arguments[3]),
    ),
)
