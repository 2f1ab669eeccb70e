"""Questions of notebook 03 on the eigenvalues of the matrix, and on the bending energy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.inputs.variants import one_changed
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative
from fieldcheck.questions.q03_radial_basis_functions import (
    TINY,
    at_distance_one,
    cloud,
    extent,
    one_at_the_origin,
    squares,
    with_zeros,
)

# 03.5 The signs of the eigenvalues


def inertia_inputs(seed: int) -> tuple[Call, ...]:
    """Return points in general position, on a line, with a repeated point, in several units."""
    random = np.random.default_rng(seed)
    plane, space, twice = cloud(random, 9, 2), cloud(random, 8, 3), cloud(random, 6, 2)
    turn = random.uniform(0, np.pi)
    line = 10 * np.outer(cloud(random, 25, 1), [np.cos(turn), np.sin(turn)])
    twice = np.concatenate([twice, twice[:1]])
    cases = (
        (plane, "nine points in the plane"),
        (0.2 * space, "eight points in a small cube"),
        (cloud(random, 4, 1), "four points on the line, in one dimension"),
        (1e-3 * cloud(random, 9, 2), "nine points in a square of 0.001"),
        (2e-5 * cloud(random, 8, 2), "eight points in a square of 0.00002"),
        (1.2e-5 * cloud(random, 8, 3), "eight points in a cube of 0.000012"),
        (integers(plane, 12), "nine points in the plane, integers"),
        (integers(space, 12), "eight points in space, integers"),
    )
    exact = (
        (line, "twenty-five points on one line of the plane"),
        (line[:9], "nine points on one line of the plane"),
        (twice, "seven points of which two are the same"),
        (100 * twice, "seven points in a square of 100, of which two are the same"),
    )
    nearly = (
        (cloud(random, 9, 2) * [1, 1e-12], "nine points within 10⁻¹² of a line"),
        (cloud(random, 8, 3) * [1, 1, 1e-12], "eight points within 10⁻¹² of a plane"),
    )
    return (
        *(Call("inertia", (points,), case) for points, case in cases),
        *(Call("inertia", (points,), case, exact=(0,)) for points, case in exact),
        *(Call("inertia", (points,), case) for points, case in nearly),
        *nearly_flat(random),
        *nearly_twice(random),
        *few_or_many(random),
    )


def nearly_flat(random: np.random.Generator) -> tuple[Call, ...]:
    """Return points on both sides of a line or a plane, nearer and farther than `FLAT` allows.

    The least eigenvalue is proportional to the square of the distance: 10⁻¹³ to 4 · 10⁻¹³ times
    the largest one for the nearer points, and 4 · 10⁻¹² to 2 · 10⁻¹¹ times for the others.
    """
    grid = np.argwhere(np.ones((3, 3)))
    line = np.stack([np.arange(9) / 8, (-1.0) ** np.arange(9)], axis=1)
    plane = np.column_stack([grid / 2, (-1.0) ** grid.sum(axis=1)])
    cases = (
        (line, 3e-8, "nine points at 3 · 10⁻⁸ from a line"),
        (line, 2.4e-7, "nine points at 2.4 · 10⁻⁷ from a line"),
        (plane, 1.2e-7, "nine points at 1.2 · 10⁻⁷ from a plane"),
        (plane, 7e-7, "nine points at 7 · 10⁻⁷ from a plane"),
    )
    calls = []
    for points, height, case in cases:
        points = random.permutation(points + random.uniform(-0.05, 0.05, points.shape))
        points[:, -1] *= height
        calls.append(Call("inertia", (points,), case))
    return tuple(calls)


def nearly_twice(random: np.random.Generator) -> tuple[Call, ...]:
    """Return many points and a copy of one of them, closer than the tolerance of the text allows.

    The eigenvalue of the pair is 0.6 · 10⁻¹² times the largest absolute value, which belongs to a
    negative eigenvalue, and 1.9 · 10⁻¹² times the largest eigenvalue.
    """
    calls = []
    for k, words in ((7, "another"), (23, "yet another")):
        points = 0.5 * cloud(random, 100, 2)
        copy = points[k] + 7.5e-7 * np.array([0.6, -0.8])
        case = f"a hundred points, and {words} at 7.5 · 10⁻⁷ from one of them"
        calls.append(Call("inertia", (np.append(points, [copy], axis=0),), case, exact=(0,)))
    return tuple(calls)


def few_or_many(random: np.random.Generator) -> tuple[Call, ...]:
    """Return few points, many, large units, and points for which several eigenvalues are zero.

    One point has the eigenvalues a and −a, and zeros.
    """
    general = (
        (random.random((1, 2)), "one point of the plane"),
        (random.random((1, 3)), "one point of space"),
        (random.random((1, 1)), "one point of the line"),
        (cloud(random, 2, 2), "two points in the plane"),
        (cloud(random, 2, 3), "two points in space"),
        (cloud(random, 3, 3), "three points in space"),
        (cloud(random, 43, 2), "forty-three points in the plane"),
        (cloud(random, 45, 3), "forty-five points in space"),
        (50 * cloud(random, 9, 2), "nine points in a square of 50"),
        (30 * cloud(random, 8, 3), "eight points in a cube of 30"),
        (one_at_the_origin(cloud(random, 7, 2)), "seven points in the plane, one at the origin"),
        (one_at_the_origin(cloud(random, 8, 3)), "eight points in space, one at the origin"),
    )
    plane, direction = cloud(random, 6, 2), random.normal(size=3)
    exact = (
        (
            np.outer(cloud(random, 7, 1), direction / np.linalg.norm(direction)),
            "seven points on one line of space",
        ),
        (plane[[0, 1, 2, 3, 4, 5, 2, 2]], "eight points of which three are the same"),
        (plane[[0, 0, 0]], "three points that are all the same"),
        (np.outer(random.permutation(5), [1, 1]), "five points of the diagonal, integers"),
        (at_distance_one(random, 2), "a point and four neighbours at distance one"),
    )
    return (
        *(Call("inertia", (points,), case) for points, case in general),
        *(Call("inertia", (points,), case, exact=(0,)) for points, case in exact),
    )


@law(
    "The three numbers must add up to the number of rows of H_RBF, which is N + D + 1. Since the "
    "diagonal is zero, the sum of the eigenvalues is zero, so both signs must occur."
)
def counts_all_and_both_signs(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the number of eigenvalues that are not counted, or one if a sign is missing."""
    lacking = (
        abs(sum(c.arguments[0].shape) + 1 - v[0].sum()) + (v[0][:2] < 1).sum()
        for c, v in zip(calls, values, strict=True)
    )
    return float(max(lacking))


FLAT = 6e-7
"""Singular values of points that affect an eigenvalue by more than the tolerance of the text."""


SAME = 1e-5
"""The distance below which two points count as one, in units of the extent of all points."""


@law_of_each(
    "Eigenvalues below 10⁻¹² times the largest count as zero. There must be one for each "
    "independent affine field that vanishes at all points, to rounding, and one for each repeated "
    "point.",
    amount="the number of zeros is off by {:.0f}",
)
def is_singular_where_it_must(call: Call, values: Values) -> float:
    """Return the difference between the number of zeros and the dimension of the null space.

    Eigenvalues that the text counts as zero belong to it. They decrease with the square of the
    distance from a line or a plane, and are far from the tolerance in all cases.
    """
    (counts,) = values
    (points,) = call.arguments
    near = squares(points, points) <= (SAME * extent(points)) ** 2
    repeated = np.count_nonzero(np.tril(near, -1).any(axis=1))
    flat = points.shape[1] - np.linalg.matrix_rank(points - points[0], tol=FLAT)
    return abs(float(counts[2]) - repeated - flat)


# 03.7 The energy


def energy_inputs(seed: int) -> tuple[Call, ...]:
    """Return values, with an affine field added, tripled, and at scaled and rotated points."""
    random = np.random.default_rng(seed)
    points, values = cloud(random, 10, 2), random.normal(size=10)
    tilt = 2 - points[:, 0] + 3 * points[:, 1]
    turned = 2 * np.stack([points[:, 1], -points[:, 0]], axis=1) + 1
    calls = calls_of(
        "energy",
        ((points, values), "ten points with random values"),
        ((points, values + tilt), "ten points with an affine field added to the values"),
        ((points, 3 * values), "values three times as large"),
        ((turned, values), "points twice as far apart, and rotated"),
        ((integers(points, 100), integers(values)), "ten points and values, integers"),
        ((integers(cloud(random, 9, 2), 100), values[:9]), "nine points, integers"),
        ((points, TINY * values), "values of size 10⁻¹⁰"),
        ((cloud(random, 8, 2), TINY * values[:8]), "eight points, values of size 10⁻¹⁰"),
    )
    exact = (
        (at_distance_one(random, 2), "a point and four neighbours at distance one"),
        (at_distance_one(random, 2)[:4], "a point and three neighbours at distance one"),
    )
    return (
        *calls,
        *(
            Call("energy", (points, random.normal(size=len(points))), case, exact=(0,))
            for points, case in exact
        ),
        *(
            other
            for call in (calls[0], calls[5])
            for other in one_changed(
                call,
                ("other coordinates", cloud(random, *call.arguments[0].shape)),
                ("other values", random.normal(size=len(call.arguments[1]))),
            )
        ),
        *affine_or_rescaled(random),
    )


def affine_or_rescaled(random: np.random.Generator) -> tuple[Call, ...]:
    """Return values without energy, other units of length, and many points."""
    points, v = cloud(random, 43, 2), random.normal(size=43)
    triangle = np.eye(3, 2, -1) + random.uniform(-0.1, 0.1, (3, 2))
    few = points[random.permutation(43)[:9]]
    return calls_of(
        "energy",
        ((triangle, v[:3]), "three points"),
        ((2 * triangle, v[3:6]), "three points, farther apart"),
        ((few, np.full(9, v[0])), "nine equal values"),
        ((few, np.full(9, round(9 * v[1]))), "nine equal values that are integers"),
        ((1e-3 * few, v[:9]), "nine points in a square of 0.001"),
        ((2e-4 * few, v[9:18]), "nine points in a square of 0.0002"),
        ((1000 * few, v[:9]), "nine points in a square of 1000"),
        ((5000 * few, v[9:18]), "nine points in a square of 5000"),
        ((points, v), "forty-three points"),
        ((points[:41], v[2:]), "forty-one points"),
        ((few, with_zeros(v[:9], 0, 5)), "nine values, two of them zero"),
        ((few, with_zeros(integers(v[9:18], 9), 7)), "nine integers, one of them zero"),
        ((one_at_the_origin(few), v[:9]), "nine points, one of them the origin"),
    )


def nothing_for_rounding(call: Call, values: Values) -> Values:
    """Return the energy, or zero if it is a rounding error, as for affine values."""
    (e,), (points, wanted) = values, call.arguments
    least = 1e-9 * float(np.abs(wanted).max()) ** 2 / extent(points) ** 2
    return (np.where(np.abs(e) < least, 0.0, e),)


@law(
    "Adding an affine field must not change the energy. Three times the values must have nine "
    "times the energy, and points twice as far apart a quarter of it. It must be positive."
)
def has_the_bending_energy(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the energies from e, e, 9e and e/4."""
    e = np.array([v[0] for v in values[:4]])
    return max(relative(e - e[0] * np.array([1, 1, 9, 0.25]), e), float(e[0] <= 0))


QUESTIONS = (
    Question(
        "03.5",
        "inertia",
        2,
        inertia_inputs,
        lambda _: ((3,),),
        (counts_all_and_both_signs, is_singular_where_it_must),
    ),
    Question(
        "03.7",
        "energy",
        2,
        also_at_zero(energy_inputs, points=(0,), values=(1,)),
        lambda _: ((),),
        (has_the_bending_energy,),
        normal_form=nothing_for_rounding,
    ),
)
