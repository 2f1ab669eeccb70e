"""Questions of notebook 10, natural splines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of
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


def around(sites: np.ndarray) -> np.ndarray:
    """Return evaluation points inside and outside the interval of the sites."""
    wide = sites.max() - sites.min()
    return np.linspace(sites.min() - 0.4 * wide, sites.max() + 0.5 * wide, 40)


def lacks_moments(sites: np.ndarray, factors: np.ndarray) -> float:
    """Return the sums of the coefficients, unweighted and weighted by the sites.

    They are zero for a straight line, whose coefficients are rounding errors.
    """
    if abs(factors).max() < 1e-9:
        return 0.0
    return relative(
        [factors.sum(), factors.dot(sites)], abs(factors).max() * (1 + abs(sites).max())
    )


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


def coefficients_shape(call: Call) -> tuple[tuple[int, ...], ...]:
    return (call.arguments[0].shape, (2,))


@law_of_each(
    "With the new coefficients (10.4) must be the same curve as (10.1), inside and outside."
)
def is_the_same_curve(call: Call, values: Values) -> float:
    (a, b) = values
    sites, alpha, beta = call.arguments
    wanted = half_cubes(sites, alpha, beta, around(sites))
    return relative(cubes(sites, a, b, around(sites)) - wanted, wanted)


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
        ((sites, random.normal(size=8)), "the same eight sites with other values"),
        ((few, random.normal(size=5)), "the same five sites with other values"),
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
        ((sites, random.normal(size=5)), "the same five sites with other values"),
        ((sites[::-1] * -1.0, random.normal(size=5)), "their mirror images with other values"),
        ((2.0**20 * sites, random.normal(size=5)), "five sites 10⁶ apart"),
        ((2.0**24 * sites[:4], random.normal(size=4)), "four sites 10⁷ apart"),
        ((line(random, 43), random.normal(size=43)), "43 sites"),
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
    "a straight line with the slope that it has at the end."
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


def _free_powers(
    sites: np.ndarray, bends: np.ndarray, straight: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return a line and coefficients of truncated cubes with these second derivatives."""
    apart = np.subtract.outer(sites[1:], sites[:-1]).clip(min=0)
    factors = np.linalg.solve(6 * apart, bends[1:])
    return np.append(factors, -factors.sum()), straight


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
    return (
        *(Call("energy", (x, m), case) for x, m, case in cases),
        Call("energy", away, FAR, exact=(0,)),
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
        (simple[:7], 2, "seven knots, points in whole numbers, and the degree 2"),
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
        "10.1", "from_truncated", 3, conversion_inputs, coefficients_shape, (is_the_same_curve,)
    ),
    Question(
        "10.2",
        "radial_spline",
        3,
        radial_inputs,
        coefficients_shape,
        (is_natural_and_interpolates,),
        tolerance=lambda _: 1e-8,
        normal_form=nothing_for_rounding,
    ),
    Question(
        "10.3",
        "moments",
        4,
        moments_inputs,
        lambda call: (call.arguments[0].shape,),
        (has_no_kink,),
    ),
    Question(
        "10.4",
        "piecewise",
        3,
        pieces_inputs,
        lambda call: (call.arguments[3].shape,),
        (is_cubic_inside_and_linear_outside,),
    ),
    Question("10.5", "truncated", 3, back_inputs, coefficients_shape, (is_made_of_half_cubes,)),
    Question(
        "10.6",
        "energy",
        2,
        energy_inputs,
        lambda _: ((),),
        (
            is_four_times_the_length,
            is_quadratic,
            does_not_depend_on_cuts,
            is_that_of_the_mirror_image,
        ),
    ),
    Question(
        "10.7",
        "b_splines",
        4,
        b_spline_inputs,
        b_spline_shape,
        (has_its_support_and_sign, satisfies_marsdens_identity),
    ),
)
