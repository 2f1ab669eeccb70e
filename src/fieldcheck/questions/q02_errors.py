"""Questions 02.8 and 02.9, what moving least squares errs, and what leaving out tells of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.question import Question, law, relative
from fieldcheck.questions.q02_moving_least_squares import LOCAL, affine, local_rounding

# 02.8 Least squares against moving least squares


def errors_inputs(seed: int) -> tuple[Call, ...]:
    """Return a hundred points and ten places; all twice as far apart; other powers and ε."""
    random = np.random.default_rng(seed)
    points, places = random.random((100, 2)), random.random((10, 2))
    return (
        Call("errors", (points, places, 2, 0.1), "a hundred points, ten places and n = 2"),
        Call("errors", (2 * points, 2 * places, 2, 0.2), "points and places twice as far apart"),
        Call("errors", (points, places, 3, 0.05), "n = 3"),
        Call(
            "errors",
            (points[:30], random.random((25, 2)), 5, 0.3),
            "thirty points, twenty-five places and n = 5",
        ),
    )


@law(
    "In a square twice as large (x₁ + x₂)² is four times as large, and so must both errors be.",
    LOCAL,
)
def grows_with_the_field(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[1][0] - 4 * values[0][0], values[1][0])


def nothing_for_rounding(call: Call, values: Values) -> Values:
    """Return errors with those that are nothing but rounding set to zero."""
    return tuple(np.where(np.abs(v) < 1e-9, 0.0, v) for v in values)


# 02.9 Leaving one out


def leave_one_out_inputs(seed: int) -> tuple[Call, ...]:
    """Return values; one of them raised; an affine field on top; space."""
    random = np.random.default_rng(seed)
    p, v = random.random((12, 2)), random.normal(size=12)
    raised = v + (np.arange(12) == 4)
    return (
        Call("leave_one_out", (p, v, 0.3), "twelve points in the plane"),
        Call("leave_one_out", (p, raised, 0.3), "the same points, the fifth value raised by one"),
        Call(
            "leave_one_out",
            (p, v + affine(p, np.array([1.5, -2.0])), 0.3),
            "the same values plus those of an affine field",
        ),
        Call(
            "leave_one_out",
            (random.random((14, 3)), random.normal(size=14), 0.6),
            "fourteen points in space",
        ),
    )


@law(
    "Raising a value by one must raise its own error by one: the field that it is "
    "compared with has not seen it.",
    LOCAL,
)
def has_not_seen_the_value(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return float(abs(values[1][0][4] - values[0][0][4] - 1))


@law(
    "An affine field is reproduced by any of the others, so adding it must change no error.", LOCAL
)
def affine_fields_leave_no_error(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[2][0] - values[0][0], np.abs(values[0][0]).max() + 1)


def without_the_worst(call: Call) -> float:
    """Return the rounding when a point is left out: that of the worst choice."""
    points, _, epsilon = call.arguments
    return max(
        local_rounding(np.delete(points, i, axis=0), p, epsilon) for i, p in enumerate(points)
    )


QUESTIONS = (
    Question(
        "02.8",
        "errors",
        3,
        errors_inputs,
        lambda _: ((2,),),
        (grows_with_the_field,),
        lambda call: local_rounding(call.arguments[0], call.arguments[1], call.arguments[3]),
        nothing_for_rounding,
    ),
    Question(
        "02.9",
        "leave_one_out",
        3,
        leave_one_out_inputs,
        lambda call: ((len(call.arguments[0]),),),
        (has_not_seen_the_value, affine_fields_leave_no_error),
        without_the_worst,
    ),
)
