"""Hidden cases of notebook 11."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.questions.q11_orientation import (
    circles,
    drop,
    outward_of_circles,
    outward_of_drop,
    random_signs,
    upward_of_sheet,
)
from fieldcheck.questions.q11_point_clouds import horseshoe, moved_far, near, outward, sheet, torus
from fieldcheck.questions.q11_zero_levels import (
    beside_a_site,
    body,
    first_in_a_plane,
    in_another_unit,
    near_diagonals,
    of_the_size,
    points_about_origin,
)
from fieldgrade.authoring.hidden_cases import hidden


@hidden("11.1", "It must hold for any number of neighbours, in the plane, in space, in any unit.")
def other_numbers(seed):
    random = np.random.default_rng(seed + 1)
    return (
        Call("normals", (random.normal(size=(20, 3)), 6), "points anywhere in space"),
        Call("normals", (random.normal(size=(9, 2)), 9), "all points"),
        Call("normals", (horseshoe(random, 25), 3), "three neighbours"),
        Call("normals", (2.0**-24 * torus(random, 4, 7), 6), "close points"),
        Call("normals", (horseshoe(random, 67), 5), "67 points"),
        Call("normals", (torus(random, 7, 15), 7), "105 points"),
        Call("normals", (sheet(random, 43), 6), "43 points in a plane", exact=(0,)),
    )


@hidden("11.2", "It must hold for any number of neighbours, in every unit, and far away.")
def two_neighbours(seed):
    random = np.random.default_rng(seed + 2)
    return (
        Call("linked", (random.normal(size=(15, 2)), 2), "one neighbour each"),
        Call("linked", (random.normal(size=(7, 3)), 7), "all of them"),
        Call("linked", (2.0**-40 * random.normal(size=(9, 3)), 3), "close points"),
        Call("linked", (random.normal(size=(12, 2)) + 3e7, 3), "points far away"),
        Call("linked", (random.normal(size=(67, 2)), 4), "67 points"),
        Call("linked", (random.normal(size=(101, 3)), 3), "101 points"),
    )


@hidden("11.3", "There may be several bodies.")
def three_bodies(seed):
    random = np.random.default_rng(seed + 3)
    one, two, three = horseshoe(random, 50, 0.1), drop(random, 34), horseshoe(random, 46, 0.1)
    points = np.vstack([one, two + [5, -3], three + [-5, 2]])
    n = np.vstack([outward(one), outward_of_drop(two), outward(three)])
    order = random.permutation(len(points))
    given = random_signs(random, n[order])
    return (Call("orient", (points[order], given, near(points[order], 4)), "three bodies"),)


@hidden("11.3", "It must hold for a surface with a boundary: the height is the last coordinate.")
def sheet_in_space(seed):
    random = np.random.default_rng(seed + 9)
    points = sheet(random, 20)
    given = random_signs(random, upward_of_sheet(points))
    return (Call("orient", (points, given, near(points, 5)), "a sheet in space"),)


@hidden("11.3", "Lengths may be large or small, and a component may be a single point.")
def other_units(seed):
    random = np.random.default_rng(seed + 12)
    points = horseshoe(random, 43, 0.1)
    normals, links = outward(points), near(points, 4)
    ring, around = circles(random)
    return (
        *(
            Call("orient", (size * points, random_signs(random, normals), links), case)
            for size, case in ((2.0**-34, "close points"), (2.0**30, "points far apart"))
        ),
        Call(
            "orient",
            (2.0**-40 * ring, random_signs(random, outward_of_circles(ring)), around),
            "two circles of close points",
        ),
        Call("orient", (points[:1], normals[:1], np.zeros((1, 1))), "one point"),
    )


@hidden("11.3", "A normal may be nearly perpendicular to that of its neighbour in the tree.")
def nearly_perpendicular(seed):
    random = np.random.default_rng(seed + 10)
    calls = []
    for n, case in ((20, "a chain of twenty points"), (40, "a chain of forty points")):
        tilts = random.choice([-1, 1], n) * 10.0 ** random.uniform(-7, -1.5, n)
        turn = random.uniform(0.3, 1.2) + np.cumsum(np.pi / 2 + tilts)
        points = np.column_stack([random.uniform(-1, 1, n), -np.arange(n)])
        chain = np.eye(n, k=1, dtype=int) + np.eye(n, k=-1, dtype=int)
        signs = random.choice([-1.0, 1.0], (n, 1))
        given = signs * np.column_stack([np.cos(turn), np.sin(turn)])
        calls.append(Call("orient", (points, given, chain), case))
    return tuple(calls)


@hidden("11.3", "The cost (11.4) of a link does not depend on its length.")
def long_way_round(seed):
    random = np.random.default_rng(seed + 11)
    calls = []
    for n, case in ((6, "a way round of six points"), (7, "a way round of seven points")):
        turn = np.linspace(np.pi / 2, np.pi / 2 - random.uniform(2.3, 2.5), n)
        out = np.column_stack([np.cos(turn), np.sin(turn)])
        points = np.array([[0.0, 3.0]]) + 3 * out
        points[-1] = points[0] - [0, 0.05]
        links = np.eye(n, k=1, dtype=int) + np.eye(n, k=-1, dtype=int)
        links[0, -1] = links[-1, 0] = 1
        calls.append(Call("orient", (points, random_signs(random, out), links), case))
    return tuple(calls)


@hidden("11.4", "Lengths may be large or small, points far from the origin or in whole numbers.")
def far_away(seed):
    random = np.random.default_rng(seed + 4)
    points = torus(random, 6, 9)
    axes = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    cross = axes * random.permutation([[2], [3], [4], [5]])
    return (
        Call("off_surface", (points + 100, outward(points), 40.0), "a large distance"),
        Call("off_surface", (points, -outward(points), 0.5), "normals that point inward"),
        Call(
            "off_surface",
            (2.0**-14 * points, -outward(points), 2.0),
            "close points, and a very large distance",
        ),
        Call("off_surface", (2.0**-14 * points, outward(points), 0.7), "close points"),
        Call("off_surface", (cross, axes, 4.9), "four points in whole numbers"),
        Call(
            "off_surface",
            (moved_far(points, 2e7), outward(points), 0.7),
            "points very far away",
            exact=(0,),
        ),
        *(
            Call("off_surface", (many, outward(many), 0.9), f"{len(many)} points")
            for many in (torus(random, 7, 37), horseshoe(random, 67))
        ),
    )


@hidden(
    "11.5", "Sites may be few or many, in any dimension, in whole numbers, and only 0.01 apart."
)
def other_dimensions(seed):
    random = np.random.default_rng(seed + 5)
    return (
        Call("implicit", (random.normal(size=(12, 4)), random.normal(size=12)), "four dimensions"),
        Call(
            "implicit",
            (np.sort(random.uniform(0, 9, (6, 1)), axis=0), random.normal(size=6)),
            "a line",
        ),
        Call(
            "implicit",
            (
                np.argwhere(np.ones((3, 3, 2))) * [4, 3, 5] + random.integers(0, 2, (18, 3)),
                random.normal(size=18),
            ),
            "sites in whole numbers, in space",
        ),
        Call(
            "implicit",
            (first_in_a_plane(random, 11, 3), random.normal(size=11)),
            "the first sites in a plane",
            exact=(0,),
        ),
        *(
            Call("implicit", (size * random.normal(size=(7, d)), random.normal(size=7)), case)
            for size, d, case in ((2.0**4, 2, "large lengths"), (2.0**-6, 3, "small lengths"))
        ),
        Call("implicit", (random.normal(size=(61, 2)), random.normal(size=61)), "61 sites"),
        Call("implicit", (random.normal(size=(7, 3)), np.zeros(7, dtype=int)), "zeros"),
    )


@hidden(
    "11.6",
    "It must hold in every dimension and every unit, beside the sites, for one point, and for "
    "whole numbers.",
)
def in_four_dimensions(seed):
    random = np.random.default_rng(seed + 6)
    space = sites, *_ = body(random, 3, 4)
    return (
        Call(
            "field",
            (random.integers(-3, 4, (4, 4)), *body(random, 4, 6)),
            "points in whole numbers, in four dimensions",
        ),
        Call("field", (sites[:3] + beside_a_site(random, 3), *space), "points beside sites"),
        Call("field", (points_about_origin(random, 1, 2), *body(random, 2, 5)), "one point"),
        Call(
            "field",
            in_another_unit(2.0**-12, points_about_origin(random, 5, 3), *space),
            "close points",
        ),
        *(
            Call("field", (points_about_origin(random, n, d), *body(random, d, k)), f"{n} points")
            for n, d, k in ((67, 2, 5), (101, 3, 4), (7, 3, 61))
        ),
    )


@hidden(
    "11.7",
    "Each point must make all its steps, wherever the others are, in every dimension and unit. "
    "There may be one point, or no steps at all.",
)
def no_steps(seed):
    random = np.random.default_rng(seed + 7)
    x, coefficients = near_diagonals(random, 4, 3), body(random, 3, 5)
    large, *others = in_another_unit(2.0**10, 0.6 * x, *coefficients)
    return (
        Call("to_surface", (x, *coefficients, 0), "no steps"),
        Call("to_surface", (x, *coefficients, 4), "four steps"),
        Call("to_surface", (*in_another_unit(2.0**12, x, *coefficients), 3), "large steps"),
        Call("to_surface", (*of_the_size(2.0**-50, x, *coefficients), 3), "small steps and values"),
        Call("to_surface", (x[:1], *coefficients, 3), "one point"),
        Call("to_surface", (np.rint(large).astype(int), *others, 3), "whole numbers"),
        *(
            Call("to_surface", (near_diagonals(random, n, 3), *coefficients, 2), f"{n} points")
            for n in (67, 101)
        ),
    )


@hidden("11.8", "The values may be large or tiny, and differ much; there may be one square only.")
def steep(seed):
    random = np.random.default_rng(seed + 8)
    signs = np.array([[1, -1, -1, -1], [1, 1, -1, -1], [-1, 1, 1, -1], [1, 1, -1, 1]])
    sizes = np.exp(random.normal(0, 3, (4, 4)))
    return (
        Call(
            "pieces", (signs * np.ceil(97 * sizes).astype(int),), "four squares with whole numbers"
        ),
        Call("pieces", (2.0**-40 * signs * sizes,), "four squares with small values"),
        Call("pieces", (2.0**-600 * signs * sizes,), "four squares with tiny values"),
        Call("pieces", ((signs * sizes)[1:2],), "a single square"),
        *(
            Call(
                "pieces", (random.choice(signs, n) * random.uniform(1, 9, (n, 4)),), f"{n} squares"
            )
            for n in (67, 101)
        ),
    )
