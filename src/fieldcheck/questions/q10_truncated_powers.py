"""Questions of notebook 10 on truncated powers and B-splines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative
from fieldcheck.questions.q10_natural_splines import (
    coefficients_shape,
    cubes,
    half_cubes,
    lacks_moments,
    line,
    natural_data,
    whole_line,
    whole_moments,
    whole_values,
)


def around(sites: np.ndarray) -> np.ndarray:
    """Return evaluation points inside and outside the interval of the sites."""
    wide = sites.max() - sites.min()
    return np.linspace(sites.min() - 0.4 * wide, sites.max() + 0.5 * wide, 40)


# 10.1 From truncated powers to cubed distances


def conversion_inputs(seed: int) -> tuple[Call, ...]:
    """Return sites and coefficients without moments: many, some far from the origin, three in
    arrays of integers, and a line alone in one.
    """
    random = np.random.default_rng(seed)
    calls = []
    for n, shift, case in (
        (6, -2, "six sites"),
        (5, 4, "five sites away from the origin"),
    ):
        sites = line(random, n) + shift
        alpha = without_moments(random, sites)
        calls.append(Call("from_truncated", (sites, alpha, random.normal(size=2)), case))
    sites = random.integers(-3, 0) + np.cumsum([0, random.choice([1, 3]), 2])
    alpha = np.roll(sites, -2) - np.roll(sites, -1)
    few = Call(
        "from_truncated", (sites, alpha, random.integers(1, 9, 2)), "three sites in whole numbers"
    )
    other = line(random, 5) - 1
    line_alone = other, without_moments(random, other), random.integers(1, 9, 2)
    return (
        *calls,
        few,
        Call("from_truncated", line_alone, "five sites, and a line in whole numbers"),
        *more_conversions(random, calls[0].arguments[0]),
    )


def more_conversions(random: np.random.Generator, sites: np.ndarray) -> tuple[Call, ...]:
    """Return other coefficients for the same sites, other units, many sites, and straight lines."""
    alpha, many = without_moments(random, sites), random.permutation(line(random, 43)) / 8
    two = line(random, 2)
    return calls_of(
        "from_truncated",
        ((sites, alpha, random.normal(size=2)), "the same six sites, other coefficients"),
        *(
            ((size * sites, alpha / size**3, random.normal(size=2) / [1, size]), case)
            for size, case in (
                (2.0**9, "six sites about 400 apart"),
                (2.0**12, "six sites about 3000 apart"),
            )
        ),
        *(
            ((sites, small * alpha, small * random.normal(size=2)), case)
            for small, case in (
                (2.0**-30, "six sites, and coefficients of about 10⁻⁹"),
                (2.0**-40, "six sites, and coefficients of about 10⁻¹²"),
            )
        ),
        ((many, without_moments(random, many), random.normal(size=2)), "43 sites in any order"),
        ((two, np.zeros(2), random.normal(size=2)), "two sites, and coefficients that are zero"),
        ((sites, np.zeros(6), random.normal(size=2)), "six sites, and coefficients that are zero"),
    )


def without_moments(random: np.random.Generator, sites: np.ndarray) -> np.ndarray:
    """Return coefficients that satisfy the side conditions."""
    free = random.normal(size=len(sites))
    q = np.linalg.qr(np.vander(sites, 2))[0]
    return free - q.dot(q.T.dot(free))


@law_of_each(
    "With the new coefficients (10.4) must be the same curve as (10.1), inside and outside."
)
def is_the_same_curve(call: Call, values: Values) -> float:
    (a, b) = values
    sites, alpha, beta = call.arguments
    wanted = half_cubes(sites, alpha, beta, around(sites))
    return relative(cubes(sites, a, b, around(sites)) - wanted, wanted)


# 10.5 Back to truncated powers


def back_inputs(seed: int) -> tuple[Call, ...]:
    random = np.random.default_rng(seed)
    calls = []
    for n, case in ((6, "six sites"), (4, "four sites")):
        calls.append(Call("truncated", natural_data(random, n), case))
    whole = "three sites with values in whole numbers"
    bent = whole_moments(random, line(random, 5) - 1)
    return (
        *calls,
        Call("truncated", whole_values(random), whole),
        Call("truncated", bent, "five sites with moments in whole numbers"),
        Call(
            "truncated",
            whole_moments(random, whole_line(random, 4)),
            "four sites and their moments in whole numbers",
        ),
        *more_backward(random, *calls[0].arguments),
    )


def more_backward(
    random: np.random.Generator, sites: np.ndarray, heights: np.ndarray, bends: np.ndarray
) -> tuple[Call, ...]:
    """Return two sites, other values at the same sites, straight lines, and 43 sites."""
    pair, other = line(random, 2) + 2, line(random, 2) - 5
    ends = random.uniform(1, 2, 2) * [1, -1]
    return calls_of(
        "truncated",
        ((pair, ends, np.zeros(2)), "two sites"),
        ((other, random.permutation(9)[:2], np.zeros(2, dtype=int)), "two other sites"),
        ((sites, 3 - heights, -bends), "the same six sites, other values and moments"),
        ((sites, 3 - 2 * heights, -2 * bends), "the same six sites, values doubled"),
        ((sites, 1 - 2 * sites, np.zeros(6)), "six values on a straight line"),
        (natural_data(random, 43), "43 sites"),
    )


@law_of_each(
    "The curve (10.1) must have the given values and second derivatives at the sites, and must "
    "satisfy (10.2)."
)
def is_made_of_half_cubes(call: Call, values: Values) -> float:
    """Return the deviation of values, second derivatives and moments from the given ones."""
    (alpha, beta) = values
    sites, heights, bends = call.arguments
    second = 6 * np.subtract.outer(sites, sites).clip(min=0).dot(alpha)
    missed = half_cubes(sites, alpha, beta, sites) - heights
    return max(
        relative(missed, heights), relative(second - bends, bends), lacks_moments(sites, alpha)
    )


# 10.7 B-splines


def b_spline_inputs(seed: int) -> tuple[Call, ...]:
    """Return knots, some of them multiple, degrees 0 to 3, and evaluation points with knots among
    them, the last one included. Very close knots are not the same. At last all are integers.
    """
    random = np.random.default_rng(seed)
    simple, double = line(random, 8), line(random, 10)
    double[5] = double[4]
    clamped = np.concatenate([simple[[0, 0]], simple[:3], simple[[2, 2]]])
    cases = (
        (simple, 2, "eight knots and the degree 2"),
        (double, 3, "ten knots, two of them the same, and the degree 3"),
        (simple[:5], 0, "five knots and the degree 0"),
        (double[3:8], 1, "five knots, two of them the same, and the degree 1"),
        (
            simple[:7],
            2,
            "seven knots, the degree 2, and points in whole numbers, none of them a knot",
        ),
        (clamped, 2, "seven knots, with triple ends, and the degree 2"),
    )
    calls = []
    for t, k, case in cases:
        x = np.concatenate([random.uniform(t[0] - 0.5, t[-1] + 0.5, 9), t[[1, -3, -1]]])
        x = np.rint(x).astype(int) if "whole" in case else x
        calls.append(Call("b_splines", (t, k, x), case, exact=(0, 2)))
    t, k, x = calls[1].arguments
    fine = 2.0**-44 * t, k, 2.0**-44 * x
    calls.append(
        Call("b_splines", fine, "ten knots 10⁻¹³ apart, two of them the same", exact=(0, 2))
    )
    whole = whole_line(random, 7)
    numbers = whole, 1, np.append(random.integers(whole[0] - 2, whole[-1] + 3, 9), whole[[2, -1]])
    away = double + 2e6, 2, calls[1].arguments[2] + 2e6
    return (
        *calls,
        Call("b_splines", numbers, "seven knots and points, integers, and the degree 1"),
        Call("b_splines", away, "ten knots far from the origin", exact=(0, 2)),
        *(
            Call("b_splines", (0.01 * t + 2.0**24, k, 0.01 * x + 2.0**24), case, exact=(0, 2))
            for (t, k, x), case in (
                (calls[0].arguments, "eight knots 0.01 apart, very far from the origin"),
                (calls[5].arguments, "seven knots 0.01 apart, very far from the origin"),
            )
        ),
    )


def b_spline_shape(call: Call) -> tuple[tuple[int, ...], ...]:
    t, k, x = call.arguments
    return ((len(x), len(t) - k - 1),)


@law_of_each(
    "A B-spline must not be negative, and must be zero outside the k + 1 intervals from its first "
    "knot to its last."
)
def has_its_support_and_sign(call: Call, values: Values) -> float:
    """Return the largest absolute value outside the support, and the most negative value."""
    (b,) = values
    t, k, x = call.arguments
    outside = (x[:, None] < t[: -k - 1]) | (x[:, None] > t[k + 1 :])
    return max(relative(b[outside], 1.0), relative(b.clip(max=0), 1.0))


@law(
    "Where k + 1 B-splines overlap, they must sum to one, and Marsden's identity must hold: "
    "(y − x)ᵏ is the sum of Bᵢ(x) (y − tᵢ₊₁)…(y − tᵢ₊ₖ)."
)
def satisfies_marsdens_identity(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of (y - x)^k from its B-splines by Marsden's identity, for several y."""
    worst = 0.0
    for call, (b,) in zip(calls, values, strict=True):
        t, k, x = call.arguments
        full = np.logical_and(x >= t[k], x < t[len(t) - k - 1])
        windows = np.lib.stride_tricks.sliding_window_view(t, k + 2)[:, 1:-1]
        for y in t[0] + np.arange(k + 1) / (k + 1):
            wanted = (y - x[full]) ** k
            worst = max(worst, relative(b[full].dot((y - windows).prod(axis=1)) - wanted, wanted))
    return worst


QUESTIONS = (
    Question(
        "10.1",
        "from_truncated",
        3,
        also_at_zero(conversion_inputs, numbers=(0,)),
        coefficients_shape,
        (is_the_same_curve,),
    ),
    Question("10.5", "truncated", 3, back_inputs, coefficients_shape, (is_made_of_half_cubes,)),
    Question(
        "10.7",
        "b_splines",
        4,
        also_at_zero(b_spline_inputs, numbers=(0, 2)),
        b_spline_shape,
        (has_its_support_and_sign, satisfies_marsdens_identity),
    ),
)
