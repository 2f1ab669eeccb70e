"""The question of notebook 02 on the objective of the weighted fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.inputs.variants import one_changed
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, relative
from fieldcheck.questions.q01_objective import LARGE, rounding_of_residuals
from fieldcheck.questions.q02_local_fit import (
    TINY,
    affine,
    far_away,
    other_coordinates,
    other_values,
    twice,
)

# 02.5 The objective


def objective_inputs(seed: int) -> tuple[Call, ...]:
    """Return non-optimal coefficients, all doubled, with an affine field added, and in space."""
    random = np.random.default_rng(seed)
    p, v, x, c = (
        random.random((9, 2)),
        random.normal(size=9),
        random.random(2),
        random.normal(size=3),
    )
    slopes = np.array([1.5, -2.0])
    calls = calls_of(
        "objective",
        ((p, v, x, 0.4, c), "nine points in the plane"),
        ((p, 2 * v, x, 0.4, 2 * c), "values and coefficients doubled"),
        (
            (p, v + affine(p, slopes), x, 0.4, c + np.array([0.7, *slopes])),
            "the same affine field added to the values and the coefficients",
        ),
        (
            (
                random.random((6, 3)) - 0.4,
                random.normal(size=6),
                random.random(3) - 0.8,
                0.5,
                random.normal(size=4),
            ),
            "six points in space",
        ),
    )
    return (
        *calls,
        *unusual_objectives(calls[0], calls[3]),
        *(
            other
            for call in (calls[0], calls[3])
            for other in one_changed(
                call,
                other_coordinates(random, *call.arguments[0].shape),
                other_values(random, len(call.arguments[0])),
                ("another evaluation point", random.random(call.arguments[2].shape)),
                ("another ε", 0.7),
                ("other coefficients", random.normal(size=call.arguments[4].shape)),
            )
        ),
        *many_or_far_objectives(random),
    )


def many_or_far_objectives(random: np.random.Generator) -> tuple[Call, ...]:
    """Return many points, other units, points far from x or from the origin, and integers.

    In other units the slopes have other numbers, too.
    """
    calls: list[Call] = []
    far: list[Call] = []
    for n, d, words in ((69, 2, "in the plane"), (43, 3, "in space")):
        p, v, x = random.random((n, d)) - 0.4, random.normal(size=n), random.random(d) - 0.4
        c, few = random.normal(size=d + 1), slice(4 * d)
        number = {69: "sixty-nine", 43: "forty-three"}[n]
        scaled = [
            (
                (unit * p[few], v[few], unit * x, unit * 0.3, np.append(c[:1], c[1:] / unit)),
                f"{4 * d} points {words}, all lengths multiplied by {factor}",
            )
            for unit, factor in ((1e-5, "10⁻⁵"), (1e5, "10⁵"))
        ]
        calls += calls_of(
            "objective",
            ((p, v, x, 0.3, c), f"{number} points {words}"),
            *scaled,
            (
                (p[few], v[few], x + 2, 0.15, c),
                f"{4 * d} points {words}, all far from x in units of ε",
            ),
            (
                (integers(p[few]), integers(v[few]), integers(x), 120, integers(c, 9)),
                f"{4 * d} points {words}, and all numbers integers",
            ),
            ((p[few], v[few], x, 0.3, 0 * c), f"{4 * d} points {words}, all coefficients zero"),
        )
        on_the_plane = np.where(np.arange(4 * d) == 1, c[0] + p[1] @ c[1:], v[few])
        calls += calls_of(
            "objective",
            ((twice(p[few], d), v[: 5 * d], x, 0.3, c), f"{d} of {4 * d} points {words} twice"),
            ((p[few], on_the_plane, p[1].copy(), 0.01, c), f"{4 * d} points {words}, one fitted"),
        )
        distant, y = far_away(random, p[few], x)
        case = f"{4 * d} points {words}, far from the origin"
        far.append(Call("objective", (distant, v[few], y, 0.4, c), case, exact=(0, 2)))
    return (*calls, *far)


def unusual_objectives(plane: Call, space: Call) -> tuple[Call, ...]:
    """Return evaluation points that are points of the data, tiny values, few points, integers."""
    (p, v, x, epsilon, c), (q, data, y, width, k) = plane.arguments, space.arguments
    at_a_point = calls_of(
        "objective",
        ((p, v, p[3].copy(), epsilon, c), "an evaluation point that is one of nine points"),
        ((q, data, q[2].copy(), width, k), "an evaluation point that is one of six in space"),
    )
    return tuple(replace(call, exact=(0, 2)) for call in at_a_point) + calls_of(
        "objective",
        ((p, TINY * v, x, epsilon, TINY * c), "nine points, values of size 10⁻¹⁰"),
        ((q, TINY * data, y, width, TINY * k), "six points in space, values of size 10⁻¹⁰"),
        (
            (p, LARGE + v, x, epsilon, c + LARGE * np.eye(3)[0]),
            "values of about 10⁶, and residuals of about one",
        ),
        (
            (q, data - LARGE, y, width, k - LARGE * np.eye(4)[0]),
            "six values of about −10⁶ in space",
        ),
        ((p[:3], v[:3], x, epsilon, c), "three points in the plane"),
        ((q[:2], data[:2], y, width, k), "two points in space"),
        ((p[:1], v[:1], x, epsilon, c), "one point of the plane"),
        ((p[:, :1], v, x[:1], epsilon, c[:2]), "nine points on the line"),
        ((integers(p), integers(v), integers(x), 120.0, c), "nine points and values, integers"),
        ((integers(q), data, integers(y), 150.0, k), "six points in space, integers"),
        ((q, data, y, width, integers(k, 9)), "coefficients that are integers"),
    )


@law(
    "ψ is a sum of squares, so doubling the values and the coefficients must make it four times "
    "as large."
)
def is_quadratic(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[1][0] - 4 * values[0][0], values[1][0])


@law(
    "Adding the same affine field to Bc and V must not change ψ, which depends on their "
    "difference only."
)
def depends_on_the_residual_only(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[2][0] - values[0][0], values[0][0])


QUESTIONS = (
    Question(
        "02.5",
        "objective",
        2,
        also_at_zero(objective_inputs, points=(0, 2), values=(1,)),
        lambda _: ((),),
        (is_quadratic, depends_on_the_residual_only),
        lambda call: rounding_of_residuals(call.arguments[1]),
    ),
)
