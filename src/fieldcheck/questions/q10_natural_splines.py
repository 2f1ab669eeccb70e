"""Questions of notebook 10, natural splines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative


def line(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n ascending sites with steps between 0.4 and 1."""
    return random.uniform(-1, 1) + np.cumsum(random.uniform(0.4, 1, n))


def whole_line(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n ascending sites in an array of integers."""
    return np.cumsum(random.integers(1, 4, n)) - random.integers(1, 9)


def cubes(
    sites: np.ndarray, factors: np.ndarray, straight: np.ndarray, x: np.ndarray
) -> np.ndarray:
    """Return the sum of cubed distances with their coefficients, and a straight line."""
    apart = np.subtract.outer(x, sites)
    return np.polyval(straight[::-1], x) + (apart**2 * abs(apart)).dot(factors)


def half_cubes(
    sites: np.ndarray, factors: np.ndarray, straight: np.ndarray, x: np.ndarray
) -> np.ndarray:
    """Return the sum of truncated cubes with their coefficients, and a straight line."""
    apart = np.subtract.outer(x, sites).clip(min=0)
    return np.polyval(straight[::-1], x) + (apart**3).dot(factors)


def lacks_moments(sites: np.ndarray, factors: np.ndarray) -> float:
    """Return the sums of the coefficients, unweighted and weighted by the sites.

    They are zero for a straight line, whose coefficients are rounding errors.
    """
    if abs(factors).max() < 1e-9:
        return 0.0
    return relative(
        [factors.sum(), factors.dot(sites)], abs(factors).max() * (1 + abs(sites).max())
    )


def coefficients_shape(call: Call) -> tuple[tuple[int, ...], ...]:
    return (call.arguments[0].shape, (2,))


# 10.2 The spline as cubed distances


def radial_inputs(seed: int) -> tuple[Call, ...]:
    random = np.random.default_rng(seed)
    sites, few = random.permutation(line(random, 8)), line(random, 5) - 1
    bent = 2 - 3 * few + (few == few[2])
    return calls_of(
        "radial_spline",
        ((sites, random.integers(-9, 10, 8)), "eight sites in any order, values in whole numbers"),
        ((few, bent), "five values, all but one on a straight line"),
        ((few[:2], random.integers(1, 9, 2)), "two sites"),
        (
            (random.permutation(whole_line(random, 6)), random.normal(size=6)),
            "six sites in whole numbers",
        ),
        ((sites, random.normal(size=8)), "eight sites with other values"),
        ((few, random.normal(size=5)), "five sites with other values"),
        *(
            ((size * where, random.normal(size=len(where))), case)
            for size, where, case in (
                (2.0**4, sites, "eight sites about 10 apart"),
                (2.0**4, few, "five sites about 10 apart"),
                (2.0**-7, sites, "eight sites about 0.005 apart"),
                (2.0**-8, few, "five sites about 0.003 apart"),
            )
        ),
        ((sites, np.zeros(8)), "eight values that are zero"),
        ((few[:4], np.zeros(4, dtype=int)), "four values that are zero"),
        ((few, np.full(5, random.uniform(1, 2))), "five equal values"),
        ((random.permutation(line(random, 43)) / 3, random.normal(size=43)), "43 sites"),
        ((few[1::-1], random.normal(size=2)), "two sites, the right one first"),
        ((few[[3, 2]], random.integers(1, 9, 2)), "two other sites, the right one first"),
    )


def nothing_for_rounding(call: Call, values: Values) -> Values:
    """Return the coefficients, with pure rounding errors set to zero: two sites have a line."""
    a, b = values
    return np.where(np.abs(a) > 1e-12 * np.abs(call.arguments[1]).max(), a, 0.0), b


@law_of_each(
    "The curve (10.4) must go through the values. Its coefficients a must sum to zero, and so must "
    "their products with the sites.",
    1e-8,
)
def is_natural_and_interpolates(call: Call, values: Values) -> float:
    (a, b) = values
    sites, wanted = call.arguments
    return max(
        relative(cubes(sites, a, b, sites) - wanted, wanted),
        lacks_moments(sites, a),
    )


# 10.3 The moments


def moments_inputs(seed: int) -> tuple[Call, ...]:
    random = np.random.default_rng(seed)
    cases = (
        (7, 0, "seven sites"),
        (3, 1, "three sites"),
        (2, 0, "two sites"),
    )
    whole = line(random, 5) - 1, random.integers(1, 99, 5)
    calls = [
        Call("moments", (line(random, n) - shift, random.normal(size=n)), case)
        for n, shift, case in cases
    ]
    calls.append(Call("moments", whole, "five sites with values in whole numbers"))
    sites, heights = whole
    close = 2.0**-30 * sites, 2.0**-80 * heights
    numbers = whole_line(random, 6), random.normal(size=6)
    return (
        *calls,
        Call("moments", close, "five sites 10⁻⁹ apart"),
        Call("moments", numbers, "six sites in whole numbers"),
        *more_moments(random, sites),
    )


def more_moments(random: np.random.Generator, sites: np.ndarray) -> tuple[Call, ...]:
    """Return other values at the same sites, sites in large units, far away and many, and lines."""
    whole = whole_line(random, 5)
    near_calls = calls_of(
        "moments",
        ((sites, random.normal(size=5)), "five sites with other values"),
        ((sites[::-1] * -1.0, random.normal(size=5)), "mirror images of five sites"),
        ((2.0**20 * sites, random.normal(size=5)), "five sites 10⁶ apart"),
        ((2.0**24 * sites[:4], random.normal(size=4)), "four sites 10⁷ apart"),
        ((line(random, 43), random.normal(size=43)), "43 sites"),
        ((line(random, 250), random.normal(size=250)), "250 sites"),
        ((line(random, 300), random.normal(size=300)), "300 sites"),
        ((sites, np.full(5, 3)), "five equal values"),
    )
    straight = whole, 2 - random.integers(2, 5) * whole
    return (
        *near_calls,
        Call("moments", straight, "five values on a straight line", exact=(0, 1)),
        Call("moments", (line(random, 6) - 2e4, random.normal(size=6)), FAR, exact=(0,)),
    )


FAR = "six sites far from the origin"


def slopes(sites: np.ndarray, values: np.ndarray, m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the slopes of each piece at its left and right end."""
    width = sites[1:] - sites[:-1]
    secant = (values[1:] - values[:-1]) / width
    mean, jump = (m[1:] + m[:-1]) / 2, m[1:] - m[:-1]
    return secant - width * (mean / 2 - jump / 12), secant + width * (mean / 2 + jump / 12)


@law_of_each(
    "Neighbouring pieces must have the same slope where they meet, and the moments at both ends "
    "must be zero."
)
def has_no_kink(call: Call, values: Values) -> float:
    """Return the largest jump of the slope, and the moments at the two ends."""
    (bends,) = values
    at_left, at_right = slopes(call.arguments[0], call.arguments[1], bends)
    size = np.append(at_left, call.arguments[1][1:] / np.diff(call.arguments[0]))
    return max(relative(at_left[1:] - at_right[:-1], size), relative(bends[[0, -1]], 1.0))


# 10.4 The pieces


def natural_data(random: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return sites, values, and the moments of the natural spline through them."""
    bends = random.normal(size=n)
    bends[[0, -1]] = 0
    sites = line(random, n) - 1
    heights = half_cubes(sites, *_free_powers(sites, bends, random.normal(size=2)), sites)
    return sites, heights, bends


def whole_values(random: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return three sites, values in an array of integers, and the moments."""
    sites, bent = line(random, 3) - 1, np.array([0.0, 1.0, 0.0])
    factors, _ = _free_powers(sites, bent, bent[:2])
    shapes = [half_cubes(sites, factors, bent[[0, 2]], sites), sites**0, sites]
    heights = random.integers(1, 99, 3) * [1, -1, 1]
    return sites, heights, np.linalg.solve(np.transpose(shapes), heights)[0] * bent


def whole_moments(
    random: np.random.Generator, sites: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return sites, values, and the moments in an array of integers."""
    bends = random.integers(1, 9, len(sites)) * random.choice([-1, 1], len(sites))
    bends[[0, -1]] = 0
    heights = half_cubes(sites, *_free_powers(sites, bends, random.normal(size=2)), sites)
    return sites, heights, bends


def pieces_inputs(seed: int) -> tuple[Call, ...]:
    """Return points in any order: three on the left, 4 in each interval with its ends, or 55, three
    on the right. The moments belong to the natural spline through the values.
    """
    random = np.random.default_rng(seed)
    calls = []
    six, away = natural_data(random, 6), natural_data(random, 6)
    for (sites, heights, bends), in_each, case in (
        (six, 4, "six sites"),
        (whole_values(random), 4, "three sites with values in whole numbers"),
        (whole_moments(random, line(random, 5)), 4, "five sites with moments in whole numbers"),
        ((six[0], 2 - six[1], -six[2]), 4, "the same six sites, other values and moments"),
        (natural_data(random, 6), 16, "six sites and 86 points"),
        ((away[0] + 3e4, *away[1:]), 4, FAR),
    ):
        inside = np.linspace(sites[:-1], sites[1:], in_each, axis=1).ravel()
        ends = [
            sites[0] + np.array([-1.5, -1.0, -0.5]),
            inside,
            sites[-1] + np.array([0.5, 1.0, 1.5]),
        ]
        calls.append(
            Call(
                "piecewise",
                (sites, heights, bends, random.permutation(np.concatenate(ends))),
                case,
                exact=(0, 3),
            )
        )
    return tuple(calls)


@law_of_each(
    "Each piece must have the given values and moments at its two ends. Outside the curve must be "
    "a straight line with the value and the slope that it has at the end."
)
def is_cubic_inside_and_linear_outside(call: Call, values: Values) -> float:
    """Return the deviation of ends, second derivatives and outer lines from the given ones."""
    (s,) = values
    sites, heights, m, x = call.arguments
    s = s[np.argsort(x, kind="stable")]
    inside, step = s[3:-3].reshape(len(sites) - 1, -1), (sites[1:] - sites[:-1])[:, None] / 3
    four = inside[:, :: inside.shape[1] // 3]
    ends = four[:, [0, 3]] - np.stack([heights[:-1], heights[1:]], axis=1)
    second = four.dot([[2, -1], [-5, 4], [4, -5], [-1, 2]]) / step**2 - np.stack(
        [m[:-1], m[1:]], axis=1
    )
    at_left, at_right = slopes(sites, heights, m)
    outer = [
        s[:3] - heights[0] + at_left[0] * np.array([1.5, 1.0, 0.5]),
        s[-3:] - heights[-1] - at_right[-1] * np.array([0.5, 1.0, 1.5]),
    ]
    return max(relative(ends, heights), relative(second, 100.0), relative(outer, s))


def _free_powers(
    sites: np.ndarray, bends: np.ndarray, straight: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return a line and coefficients of truncated cubes with these second derivatives."""
    apart = np.subtract.outer(sites[1:], sites[:-1]).clip(min=0)
    factors = np.linalg.solve(6 * apart, bends[1:])
    return np.append(factors, -factors.sum()), straight


# 10.6 The energy


def energy_inputs(seed: int) -> tuple[Call, ...]:
    """Return moments, tripled, on bisected intervals, in reversed order, constant moments, and
    integers.
    """
    random = np.random.default_rng(seed)
    sites, bends = line(random, 6), random.normal(size=6)
    bends[[0, -1]] = 0
    finer = np.sort(np.append(sites, (sites[1:] + sites[:-1]) / 2))
    cases = (
        (sites, bends, "six sites"),
        (sites, 3 * bends, "moments three times as large"),
        (finer, np.interp(finer, sites, bends), "the same curve, each interval cut in two"),
        (-sites[::-1], bends[::-1], "the mirror image of the curve"),
        (sites[:2], np.array([2, 2]), "one interval on which s'' is 2"),
        (whole_line(random, 5), random.integers(-9, 10, 5), "five sites and moments, integers"),
        (sites, random.normal(size=6), "the same six sites with other moments"),
        (2.0**-30 * sites, bends, "six sites 10⁻⁹ apart"),
        (sites, 2.0**-30 * bends, "moments of about 10⁻⁹"),
        (2.0**20 * sites, 2.0**-25 * bends, "six sites 10⁶ apart"),
        (line(random, 43), random.normal(size=43), "43 sites"),
        (sites, np.zeros(6), "six moments that are zero"),
        (sites[:2], np.zeros(2, dtype=int), "two moments that are zero"),
    )
    away = line(random, 6) - 3e4, random.normal(size=6)
    level, two = 3 + 1e-10 * random.normal(size=6), random.uniform(1, 2) + np.array([0, 3e-10])
    return (
        *(Call("energy", (x, m), case) for x, m, case in cases),
        Call("energy", away, FAR, exact=(0,)),
        Call("energy", (sites, level), "six moments that are nearly equal"),
        Call("energy", (sites[2:4], two), "two moments that are nearly equal"),
    )


@law("Where s'' is 2, the energy must be four times the length of the interval.")
def is_four_times_the_length(calls: Sequence[Call], values: Sequence[Values]) -> float:
    first, last = calls[4].arguments[0]
    return relative(values[4][0] - 4 * (last - first), last - first)


@law("Moments three times as large must have nine times the energy.")
def is_quadratic(_: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[1][0] - 9 * values[0][0], values[0][0])


@law("Additional sites on the same curve must not change the energy.")
def does_not_depend_on_cuts(_: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[2][0] - values[0][0], values[0][0])


@law("The mirror image of a curve must have the same energy.")
def is_that_of_the_mirror_image(_: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[3][0] - values[0][0], values[0][0])


QUESTIONS = (
    Question(
        "10.2",
        "radial_spline",
        3,
        also_at_zero(radial_inputs, numbers=(0,), values=(1,)),
        coefficients_shape,
        (is_natural_and_interpolates,),
        tolerance=lambda _: 1e-8,
        normal_form=nothing_for_rounding,
    ),
    Question(
        "10.3",
        "moments",
        4,
        also_at_zero(moments_inputs, numbers=(0,), values=(1,)),
        lambda call: (call.arguments[0].shape,),
        (has_no_kink,),
    ),
    Question(
        "10.4",
        "piecewise",
        3,
        also_at_zero(pieces_inputs, numbers=(0, 3)),
        lambda call: (call.arguments[3].shape,),
        (is_cubic_inside_and_linear_outside,),
    ),
    Question(
        "10.6",
        "energy",
        2,
        also_at_zero(energy_inputs, numbers=(0,), values=(1,)),
        lambda _: ((),),
        (
            is_four_times_the_length,
            is_quadratic,
            does_not_depend_on_cuts,
            is_that_of_the_mirror_image,
        ),
    ),
)
