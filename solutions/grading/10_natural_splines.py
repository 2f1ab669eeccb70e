"""What only a grader tries in notebook 10."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.questions.q10_natural_splines import line, natural_data, whole_line, whole_moments
from fieldcheck.questions.q10_truncated_powers import without_moments
from fieldgrade.authoring.hidden_cases import hidden


@hidden("10.1", "It must hold for any number of sites, in any order, and for whole numbers.")
def many_sites(seed):
    random = np.random.default_rng(seed + 1)
    sites = random.permutation(line(random, 12)) / 3
    alpha = without_moments(random, sites)
    return (
        Call("from_truncated", (sites, alpha, random.normal(size=2)), "twelve sites"),
        Call("from_truncated", (sites, alpha, random.integers(1, 9, 2)), "a whole-number line"),
        *(
            Call("from_truncated", (where, without_moments(random, where), sites[:2]), case)
            for where, case in (
                (random.permutation(line(random, 61)) / 10, "61 sites"),
                (sites, "twelve sites, other coefficients"),
            )
        ),
    )


@hidden("10.2", "It must hold for any number of sites, and for whole numbers.")
def other_numbers(seed):
    random = np.random.default_rng(seed + 2)
    many = random.permutation(line(random, 16))
    return (
        Call("radial_spline", (many, random.normal(size=16)), "sixteen sites"),
        Call("radial_spline", (many[:3], random.normal(size=3)), "three sites"),
        Call(
            "radial_spline",
            (random.permutation(whole_line(random, 9)), random.integers(-9, 10, 9)),
            "nine sites in whole numbers",
        ),
        Call("radial_spline", (many, 3 + 0 * many), "sixteen equal values"),
        Call("radial_spline", (line(random, 47) / 3, random.normal(size=47)), "47 sites"),
    )


@hidden(
    "10.3",
    "It must hold for steps of very different lengths, for many sites, far away, and for whole "
    "numbers.",
)
def uneven_steps(seed):
    random = np.random.default_rng(seed + 3)
    sites = np.cumsum(10 ** random.uniform(-1, 1, 9))
    return (
        Call("moments", (sites, random.normal(size=9)), "uneven steps"),
        Call("moments", (line(random, 40), random.integers(-9, 10, 40)), "forty sites"),
        Call("moments", (2.0**-40 * sites, 2.0**-110 * random.normal(size=9)), "close sites"),
        Call("moments", (whole_line(random, 8), random.normal(size=8)), "whole-number sites"),
        Call("moments", (whole_line(random, 47), random.normal(size=47)), "47 sites"),
        Call("moments", (line(random, 7) + 3e4, sites[:7]), "sites far away", exact=(0,)),
    )


@hidden(
    "10.4",
    "The points may come in any order, near the sites, in any unit. The other arguments may be "
    "whole numbers. There may be two sites only.",
)
def points_in_any_order(seed):
    random = np.random.default_rng(seed + 4)
    sites, heights, M = natural_data(random, 9)
    x = random.uniform(sites[0] - 3, sites[-1] + 3, 30)
    apart = np.array([2.0**-9, 2.0**-12, 2.0**-15, 2.0**-18, 2.0**-21])
    beside = np.add.outer(sites, np.append(apart, -apart)).ravel()
    two = line(random, 2)
    whole = whole_moments(random, whole_line(random, 6))
    return (
        Call("piecewise", (sites, heights, M, x), "points in any order"),
        Call("piecewise", (sites, heights, M, x[:1]), "one point"),
        Call("piecewise", (*whole, x[1:2]), "one point, and moments in whole numbers"),
        Call("piecewise", (*whole, x), "sites and moments in whole numbers"),
        Call("piecewise", (sites, heights, M, beside), "points beside the sites"),
        Call(
            "piecewise",
            (2.0**-18 * sites, 2.0**-36 * heights, M, 2.0**-18 * beside),
            "points beside close sites",
        ),
        Call(
            "piecewise",
            (
                two,
                random.integers(1, 9, 2),
                np.zeros(2, dtype=int),
                x,
            ),
            "two sites",
        ),
        Call(
            "piecewise",
            (sites, heights, M, random.uniform(sites[0] - 3, sites[-1] + 3, 331)),
            "331 points",
        ),
        Call("piecewise", (*natural_data(random, 43), np.append(x, 9 * x)), "43 sites"),
        *(
            Call("piecewise", (size * sites, heights, M / size**2, size * x), case)
            for size, case in ((2.0**20, "sites far apart"), (2.0**-40, "very close sites"))
        ),
        Call("piecewise", (sites, 0 * heights, 0 * M, x), "values that are zero"),
        Call("piecewise", (sites - 2e4, heights, M, x - 2e4), "sites far away", exact=(0, 3)),
    )


@hidden("10.4", "The points may be an array of integers; the values have decimals.")
def points_in_whole_numbers(seed):
    random = np.random.default_rng(seed + 14)
    calls = []
    for n, words in ((9, "nine"), (4, "four")):
        sites, heights, M = natural_data(random, n)
        numbers = random.permutation(np.arange(int(sites[0]) - 3, int(sites[-1]) + 4))
        case = f"{words} sites, points in whole numbers"
        calls.append(Call("piecewise", (sites, heights, M, numbers), case))
    return tuple(calls)


@hidden("10.5", "There may be two sites only, or many, in any unit.")
def two_sites_or_many(seed):
    random = np.random.default_rng(seed + 5)
    two = line(random, 2)
    sites, heights, M = natural_data(random, 5)
    return (
        Call(
            "truncated",
            (two, random.permutation(9)[:2], np.zeros(2, dtype=int)),
            "two sites",
        ),
        Call("truncated", natural_data(random, 10), "ten sites"),
        Call("truncated", whole_moments(random, line(random, 7)), "moments in whole numbers"),
        *(
            Call("truncated", (width * sites, width**2 * height * heights, height * M), case)
            for width, height, case in (
                (2.0**-30, 1.0, "close sites"),
                (1.0, 2.0**-30, "small values"),
                (2.0**-40, 2.0**-40, "close sites with small values"),
                (2.0**20, 2.0**-40, "sites far apart with small moments"),
                (2.0**10, 1.0, "sites far apart"),
            )
        ),
        Call("truncated", natural_data(random, 61), "61 sites"),
    )


@hidden("10.6", "The second derivative need not vanish at the ends, and there may be one interval.")
def any_broken_line(seed):
    random = np.random.default_rng(seed + 6)
    return (
        Call("energy", (line(random, 15), random.normal(size=15)), "fifteen sites"),
        Call("energy", (line(random, 2), random.normal(size=2)), "one interval"),
        Call("energy", (line(random, 9), random.integers(-9, 10, 9)), "moments in whole numbers"),
        Call("energy", (line(random, 67), random.normal(size=67)), "67 sites"),
        Call("energy", (line(random, 9), 2.0**-40 * random.normal(size=9)), "small moments"),
        Call("energy", (2.0**30 * line(random, 7), random.normal(size=7)), "sites far apart"),
        Call("energy", (line(random, 8) + 2e4, random.normal(size=8)), "far away", exact=(0,)),
    )


@hidden("10.7", "Knots may be multiple, points may lie far outside, and the degree may be higher.")
def knots_of_any_kind(seed):
    random = np.random.default_rng(seed + 7)
    t = line(random, 12)
    t[3:5] = t[5]
    ends = np.repeat(t[5:8], (4, 1, 4))
    x = np.append(random.uniform(t[0] - 5, t[-1] + 5, 20), t)
    return (
        Call("b_splines", (t, 3, x), "a triple knot", exact=(0, 2)),
        Call("b_splines", (t, 5, x), "the degree 5", exact=(0, 2)),
        Call("b_splines", (t[5:8], 1, x), "one hat", exact=(0, 2)),
        Call("b_splines", (ends, 3, np.append(x, ends)), "fourfold ends", exact=(0, 2)),
        Call("b_splines", (2.0**-44 * t, 3, 2.0**-44 * x), "close knots", exact=(0, 2)),
        Call("b_splines", (t, 2, x[:1]), "one point", exact=(0, 2)),
        *(
            Call("b_splines", (t, k, random.uniform(t[0] - 1, t[-1] + 1, n)), f"{n} points", (0,))
            for k, n in ((3, 67), (1, 101))
        ),
        Call("b_splines", (t - 3e6, 3, x - 3e6), "knots far away", exact=(0, 2)),
    )
