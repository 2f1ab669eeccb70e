"""Questions of notebook 03 on the values of the field and its gradient."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, in_short_binary_numbers, integers
from fieldcheck.inputs.variants import one_changed
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative
from fieldcheck.questions.q03_radial_basis_functions import (
    TINY,
    cloud,
    extent,
    far_away,
    field,
    one_at_the_origin,
    with_zeros,
)

# 03.4 and 03.6 The field and its gradient


def field_inputs(name: str, seed: int) -> tuple[Call, ...]:
    """Return coefficients and evaluation points, some of which are sites."""
    random = np.random.default_rng(seed)
    cases = (
        (8, 2, 5, "points in the plane, two of them centres"),
        (6, 3, 4, "points in space, two of them centres"),
    )
    calls = []
    for n, d, m, case in cases:
        points = cloud(random, n, d)
        x = np.concatenate([random.uniform(-1, 2, (m, d)), points[1:3]])
        x[0, 0], x[1, -1] = points[0, 0], points[3, -1]
        x[2] *= 10  # a point far from all centres
        calls.append(
            Call(name, (points, random.normal(size=n), random.normal(size=d + 1), x), case, (0, 3))
        )
    for call in tuple(calls):
        points, lam, c, x = call.arguments
        whole = integers(points, 100), lam, c, integers(x, 100)
        calls.append(Call(name, whole, f"{call.case}, integers", (0, 3)))
    return tuple(calls)


def single_evaluations(name: str, seed: int) -> tuple[Call, ...]:
    """Return one evaluation point on the line, in the plane and in space, the same with one
    argument changed, and with a tiny field.
    """
    random = np.random.default_rng(seed + 1)
    calls: list[Call] = []
    for n, d, words in ((5, 1, "on the line"), (7, 2, "in the plane"), (6, 3, "in space")):
        points, lam, c = cloud(random, n, d), random.normal(size=n), random.normal(size=d + 1)
        one = Call(name, (points, lam, c, random.random((1, d))), f"one evaluation point {words}")
        tiny = points, TINY * lam, TINY * c, random.random((3, d))
        others = one_changed(
            one,
            ("other centres", cloud(random, n, d)),
            ("other λ", random.normal(size=n)),
            ("another c", random.normal(size=d + 1)),
            ("another evaluation point", random.random((1, d))),
        )
        calls += [one, Call(name, tiny, f"coefficients of size 10⁻¹⁰ {words}"), *others]
    return tuple(calls)


def many_or_far(name: str, seed: int) -> tuple[Call, ...]:
    """Return many centres and evaluation points, one centre, other units, points far from the
    origin, zero coefficients, and coefficients that are integers.
    """
    random = np.random.default_rng(seed + 2)
    calls: list[Call] = []
    for n, d, words in ((43, 2, "in the plane"), (45, 3, "in space")):
        points, x = cloud(random, n, d), random.random((3, d))
        lam, c, few = random.normal(size=n), random.normal(size=d + 1), slice(3 * d)
        number = {43: "forty-three", 45: "forty-five"}[n]
        calls += calls_of(
            name,
            ((points, lam, c, x), f"{number} centres {words}"),
            ((points[:1], lam[:1], c, x), f"one centre {words}"),
            ((points[:2], lam[:2], c, x), f"two centres {words}"),
            *(
                (
                    (
                        unit * points[few],
                        lam[few] / unit**2,
                        np.append(c[:1], c[1:] / unit),
                        unit * x,
                    ),
                    f"{3 * d} centres {words}, all lengths multiplied by {factor}",
                )
                for unit, factor in ((1e-5, "10⁻⁵"), (1e5, "10⁵"))
            ),
            ((points[few], 0 * lam[few], c, x), f"{3 * d} centres {words}, all λ zero"),
            (
                (integers(points[few]), integers(lam[few], 9), integers(c, 9), integers(x)),
                f"{3 * d} centres {words}, all numbers integers",
            ),
            (
                (points[few], with_zeros(lam[few], 1, 4), with_zeros(c, d), x),
                f"{3 * d} centres {words}, two λ and the last entry of c zero",
            ),
            (
                (one_at_the_origin(points[few]), lam[few], c, one_at_the_origin(x)),
                f"{3 * d} centres {words}, one centre and one evaluation point at the origin",
            ),
        )
        far = calls_of(
            name,
            ((points[few], lam[few], 0 * c, x), f"{3 * d} centres {words}, far away and c zero"),
        )
        calls += [
            replace(call, arguments=(p, *call.arguments[1:3], y), exact=(0, 3))
            for call in far
            for p, y in (far_away(random, call.arguments[0], call.arguments[3]),)
        ]
    line = cloud(random, 9, 1), random.normal(size=9), random.normal(size=2)
    case = "sixty-nine evaluation points on the line"
    return (*calls, Call(name, (*line, random.random((69, 1))), case))


@law_of_each(
    "The field must be the affine function with the coefficients c, at the evaluation point "
    "itself, plus λ_j times the kernel at each centre."
)
def is_a_sum_of_basis_functions(call: Call, values: Values) -> float:
    """Return the deviation of the values from those of the field."""
    (v,) = values
    return relative(v - field(*call.arguments), v)


def evaluate_inputs(seed: int) -> tuple[Call, ...]:
    """Return several evaluation points, one of them, and many of them."""
    return tuple(
        call
        for inputs in (field_inputs, single_evaluations, many_or_far)
        for call in inputs("evaluate", seed)
    )


LENGTHS = ((1e-3, "a thousandth", "a tenth"), (1e-9, "a billionth", "a ten-millionth"))
"""A factor of all lengths in words, for points of size one and of size a hundred."""


def gradient_inputs(seed: int) -> tuple[Call, ...]:
    """Return the inputs of the field, the same fields with all lengths in another unit, and both
    with a large constant, from which difference quotients lose their digits.
    """
    calls = field_inputs("gradient", seed)
    scaled, raised = [], []
    for call in calls:
        points, lam, c, x = call.arguments
        for unit, of_one, of_hundred in LENGTHS:
            slopes = np.append(c[:1], c[1:] / unit)
            plain, comma, _ = call.case.partition(", integers")
            case = f"{plain}, all lengths about {of_hundred if comma else of_one}"
            scaled.append(
                Call("gradient", (unit * points, lam / unit**2, slopes, unit * x), case, (0, 3))
            )
        high = c + 1e4 * (np.arange(c.size) == 0)
        case = call.case + ", a field larger by 10000"
        raised.append(Call("gradient", (points, lam, high, x), case, (0, 3)))
    return (
        *calls,
        *scaled,
        *raised,
        *single_evaluations("gradient", seed),
        *many_or_far("gradient", seed),
        *small_and_far(seed),
        *one_unit_apart(seed),
    )


def one_unit_apart(seed: int) -> tuple[Call, ...]:
    """Return evaluation points at a distance of exactly one from centres, where the logarithm is
    zero, but its derivative is not.
    """
    random = np.random.default_rng(seed + 4)
    calls = []
    for n, d, words in ((6, 2, "in the plane"), (7, 3, "in space")):
        points = in_short_binary_numbers(cloud(random, n, d))
        x = points[:d] + np.eye(d)
        given = points, random.normal(size=n), random.normal(size=d + 1), x
        calls.append(Call("gradient", given, f"points {words} one unit from centres", exact=(0, 3)))
    return tuple(calls)


def small_and_far(seed: int) -> tuple[Call, ...]:
    """Return centres of extent 0.01 at a distance of four million, all in short binary numbers.

    Differences of points are exact, but a sum over the centres alone loses their digits.
    """
    random = np.random.default_rng(seed + 3)
    calls = []
    for n, d, words in ((7, 2, "in the plane"), (8, 3, "in space")):
        away = 2.0**22 * random.choice([-1, 1], d)
        points, x = (
            in_short_binary_numbers(0.01 * p) + away
            for p in (cloud(random, n, d), random.random((4, d)))
        )
        given = points, random.normal(size=n), random.normal(size=d + 1), x
        case = f"{n} centres {words}, within 0.01 of each other and four million away"
        calls.append(Call("gradient", given, case, exact=(0, 3)))
    return tuple(calls)


@law("For a small step the change of the field must be the gradient times the step.", 1e-5)
def agrees_with_central_differences(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the largest difference between the gradient and central differences.

    Coordinates count from the first centre, since far from the origin a small step loses digits.
    """
    worst = 0.0
    for call, (g,) in zip(calls, values, strict=True):
        points, lam, c, x = call.arguments
        n, d = x.shape
        h = 1e-5 * extent(points if len(points) > 1 else x)
        steps = h * np.stack([np.eye(d), -np.eye(d)])[:, :, None]
        y = (x - points[0] + steps).reshape(-1, d)
        ahead, behind = field(points - points[0], lam, c, y).reshape(2, d, n)
        worst = max(worst, relative(g.T - (ahead - behind) / (2 * h), g))
    return worst


QUESTIONS = (
    Question(
        "03.4",
        "evaluate",
        2,
        also_at_zero(evaluate_inputs, points=(0, 3)),
        lambda call: ((len(call.arguments[3]),),),
        (is_a_sum_of_basis_functions,),
    ),
    Question(
        "03.6",
        "gradient",
        3,
        also_at_zero(gradient_inputs, points=(0, 3)),
        lambda call: (call.arguments[3].shape,),
        (agrees_with_central_differences,),
    ),
)
