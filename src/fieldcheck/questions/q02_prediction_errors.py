"""Questions of notebook 02 on prediction errors, with and without leaving a point out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.inputs.variants import one_changed
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, relative
from fieldcheck.questions.q02_local_fit import (
    TINY,
    affine,
    corners,
    other_coordinates,
    other_values,
    rounding,
    twice,
)
from fieldcheck.questions.q02_moving_least_squares import (
    LOCAL,
    NEAR,
    local_rounding,
    near_and_far,
    spread_of_weights,
)

# 02.8 Least squares against moving least squares


def errors_inputs(seed: int) -> tuple[Call, ...]:
    """Return 100 sites and ten evaluation points, all at twice the distance, other powers and ε."""
    random = np.random.default_rng(seed)
    points, queries = random.random((100, 2)), random.random((10, 2))
    calls = calls_of(
        "errors",
        ((points, queries, 2, 0.1), "a hundred points, ten evaluation points and n = 2"),
        ((2 * points, 2 * queries, 2, 0.2), "all points twice as far apart"),
        ((points, queries, 3, 0.05), "n = 3"),
        (
            (twice(points[:30] - 0.4, 3), random.random((25, 2)) - 0.4, 5, 0.3),
            "thirty points around the origin, three of them twice, and n = 5",
        ),
        ((points[:15], queries[:1], 3, 0.2), "fifteen points, one evaluation point and n = 3"),
        ((integers(points[:30], 6), 6 * queries, 2, 1.2), "thirty points, integers, and n = 2"),
        ((6 * points[30:50], integers(queries, 6), 3, 1.8), "evaluation points that are integers"),
    )
    return (
        calls
        + tuple(
            other
            for call in calls[4:6]
            for other in one_changed(
                call,
                other_coordinates(random, *call.arguments[0].shape),
                ("other evaluation points", random.random(call.arguments[1].shape)),
                ("another n", 4),
                ("another ε", 0.4),
            )
        )
        + many_or_rescaled_errors(random)
    )


def many_or_rescaled_errors(random: np.random.Generator) -> tuple[Call, ...]:
    """Return many evaluation points, other units of length, and ε that are integers."""
    points, queries = random.random((43, 2)) - 0.4, random.random((71, 2)) - 0.4
    few, some = points[:15], queries[:4]
    return calls_of(
        "errors",
        (
            (points, queries[:69], 2, 0.2),
            "forty-three points, sixty-nine evaluation points and n = 2",
        ),
        (
            (points[:9], queries, 3, 0.4),
            "nine points, seventy-one evaluation points and n = 3",
        ),
        ((1e-5 * few, 1e-5 * some, 2, 3e-6), "fifteen points in a square of 10⁻⁵ and n = 2"),
        ((1e-4 * few, 1e-4 * some, 3, 3e-5), "fifteen points in a square of 10⁻⁴ and n = 3"),
        ((1e4 * few, 1e4 * some, 2, 3e3), "fifteen points in a square of 10⁴ and n = 2"),
        ((1e3 * few, 1e3 * some, 3, 300.0), "fifteen points in a square of 1000 and n = 3"),
        ((integers(few, 30), integers(some, 30), 2, 9), "points and ε, all integers, and n = 2"),
        ((integers(few, 20), integers(some, 20), 3, 7), "points and ε, all integers, and n = 3"),
    )


@law(
    "In a square twice as large, with twice the ε, (x₁ + x₂)² is four times as large, so both "
    "errors must be, too.",
    LOCAL,
)
def grows_with_the_field(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[1][0] - 4 * values[0][0], values[1][0])


def nothing_for_rounding(call: Call, values: Values) -> Values:
    """Return errors in which pure rounding errors are set to zero."""
    points, _, n, _ = call.arguments
    least = 1e-9 * float(np.abs(points).max()) ** n
    return tuple(np.where(np.abs(v) < least, 0.0, v) for v in values)


# 02.9 Leave-one-out


def leave_one_out_inputs(seed: int) -> tuple[Call, ...]:
    """Return values, the same with one value raised, with an affine field added, and in space."""
    random = np.random.default_rng(seed)
    p, v = random.random((12, 2)), random.normal(size=12)
    raised = v + (np.arange(12) == 4)
    general = calls_of(
        "leave_one_out",
        ((p, v, 0.3), "twelve points in the plane"),
        ((p, raised, 0.3), "the same points, the fifth value raised by one"),
        (
            (p, v + affine(p, np.array([1.5, -2.0])), 0.3),
            "the same values plus those of an affine field",
        ),
        ((random.random((14, 3)) - 0.4, random.normal(size=14), 0.6), "fourteen points in space"),
        ((integers(p), integers(v), 90.0), "twelve points and their values, integers"),
        ((p, integers(raised), 0.3), "twelve points and values that are integers"),
    )
    case = "a grid of 4 × 3 points, two measured twice, and values that repeat"
    return (
        *general,
        Call("leave_one_out", (*measured_twice(random, (4, 3)), 0.3), case, (0, 1)),
        *few_or_tiny(random),
        *(
            other
            for call in (general[0], general[3])
            for other in one_changed(
                call,
                other_coordinates(random, *call.arguments[0].shape),
                other_values(random, len(call.arguments[0])),
                ("another ε", 0.8),
            )
        ),
        *many_or_small_epsilon(random),
        *(
            Call("leave_one_out", (points, random.normal(size=len(points)), NEAR), case)
            for points, case in (
                (near_and_far(random, 2), "four points close together near a line, eight others"),
                (near_and_far(random, 3), "five points close together near a plane, twelve others"),
            )
        ),
    )


def many_or_small_epsilon(random: np.random.Generator) -> tuple[Call, ...]:
    """Return many points, an ε far below their spacing, other units, and ε that are integers."""
    calls: list[Call] = []
    for n, d, words in ((43, 2, "in the plane"), (45, 3, "in space")):
        p, v, few = random.random((n, d)) - 0.4, random.normal(size=n), slice(5 * d)
        number = {43: "forty-three", 45: "forty-five"}[n]
        scaled = [
            (
                (unit * p[few], v[few], unit * 0.5),
                f"{5 * d} points {words}, all lengths multiplied by {factor}",
            )
            for unit, factor in ((1e-5, "10⁻⁵"), (1e4, "10⁴"))
        ]
        calls += calls_of(
            "leave_one_out",
            ((p, v, 0.3), f"{number} points {words}"),
            ((p[few], v[few], 3e-4), f"{5 * d} points {words} and a small ε"),
            *scaled,
            (
                (integers(p[few]), integers(v[few]), 120),
                f"{5 * d} points {words}, values and ε, all of them integers",
            ),
        )
    return tuple(calls)


def few_or_tiny(random: np.random.Generator) -> tuple[Call, ...]:
    """Return as many points as coefficients and one more, and tiny values.

    Without any one of the few points the others are still the corners of a triangle or tetrahedron.
    """
    plane, space = (np.append(corners(random, d), np.ones((1, d)), axis=0) for d in (2, 3))
    v, data = random.normal(size=4), random.normal(size=5)
    return calls_of(
        "leave_one_out",
        ((plane, v, 0.9), "four points in the plane"),
        ((space, data, 0.9), "five points in space"),
        ((plane, TINY * v, 0.9), "four points, values of size 10⁻¹⁰"),
        ((space, TINY * data, 0.9), "five points in space, values of size 10⁻¹⁰"),
    )


def measured_twice(
    random: np.random.Generator, shape: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of a grid, two of them twice, and values that are small whole numbers.

    So neither a coordinate nor a value says which measurement it is, nor even a point.
    """
    grid = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)
    points = grid.reshape(-1, len(shape)) / 4
    twice = np.append(points, points[[1, 6]], axis=0)
    values = random.integers(0, 3, len(twice)).astype(float)
    values[-2:] = values[[1, 6]] + [1.0, 2.0]
    return twice, values


@law(
    "Raising a value by one must raise its own error by one, since the field that predicts it "
    "does not use it.",
    LOCAL,
)
def has_not_seen_the_value(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return float(abs(values[1][0][4] - values[0][0][4] - 1))


@law(
    "Adding an affine field to the values must change no error, since the other points reproduce "
    "it.",
    LOCAL,
)
def affine_fields_leave_no_error(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[2][0] - values[0][0], np.abs(values[0][0]).max() + 1)


def without_the_worst(call: Call) -> float:
    """Return the rounding error with one point left out, for the worst choice of the point."""
    points, _, epsilon = call.arguments
    others = np.stack([np.delete(points, i, axis=0) for i in range(len(points))])
    pairs = zip(others, points, strict=True)
    return rounding(others, np.array([spread_of_weights_around(*pair, epsilon) for pair in pairs]))


def spread_of_weights_around(points: np.ndarray, x: np.ndarray, epsilon: float) -> float:
    """Return a bound of the ratio of weights at x: that of the squared distances, or 1 + (R/ε)².

    The first one is smaller if ε is small and no point is at x.
    """
    distances = np.linalg.norm(points - x, axis=1)
    nearest, farthest = float(distances.min()), float(distances.max())
    bound = spread_of_weights(points, x, epsilon)
    return bound if nearest == 0 else min(bound, (farthest / nearest) ** 2)


QUESTIONS = (
    Question(
        "02.8",
        "errors",
        3,
        also_at_zero(errors_inputs, points=(0, 1)),
        lambda _: ((2,),),
        (grows_with_the_field,),
        lambda call: local_rounding(call.arguments[0], call.arguments[1], call.arguments[3]),
        nothing_for_rounding,
    ),
    Question(
        "02.9",
        "leave_one_out",
        3,
        also_at_zero(leave_one_out_inputs, points=(0,), values=(1,)),
        lambda call: ((len(call.arguments[0]),),),
        (has_not_seen_the_value, affine_fields_leave_no_error),
        without_the_worst,
    ),
)
