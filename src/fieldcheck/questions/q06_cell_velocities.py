"""Questions of notebook 06, velocities of the cells of a triangle mesh."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, in_short_binary_numbers, integers
from fieldcheck.inputs.simplices import (
    DIGITS_FAR_AWAY,
    FAR,
    is_equally_far,
    is_equally_far_from_afar,
    relative_to_a_corner,
    tolerance_far_away,
)
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative
from fieldcheck.questions.q05_edges import AWAY, directions

LEAST_DEFECT = 0.01
"""For normal velocities of size one; a smaller defect would have fewer than twelve digits."""

SMALL, TINY = 2.0**-17, 2.0**-25
"""Sizes of triangles: squares of their coordinates, at an ordinary place, have few digits."""


def triangle(random: np.random.Generator, counter_clockwise: bool, size: float = 1.0) -> np.ndarray:
    """Return the corners of a triangle with three different sides, none of them short."""
    angle = np.array([0.0, 1.7, 3.9]) + random.uniform(-0.25, 0.25, 3) + random.uniform(0, 6.28)
    corners = size * random.uniform(0.75, 1.0, (3, 1)) * directions(angle)
    return random.uniform(-1, 1, 2) + (corners if counter_clockwise else corners[::-1])


def obtuse(random: np.random.Generator) -> np.ndarray:
    """Return a triangle whose circumcentre lies outside."""
    corners = np.array([[-1.0, 0.0], [1.2, 0.1], [0.1, 0.5]]) + random.uniform(-0.1, 0.1, (3, 2))
    return 0.6 * corners


def along_the_axes(random: np.random.Generator, first: int = 0) -> np.ndarray:
    """Return a triangle with a horizontal and a vertical side, listed clockwise.

    `first` is the position of the corner with the right angle.
    """
    corner, width, height = random.normal(size=2), *random.uniform(0.5, 1.5, 2)
    corners = np.array([[0.0, 0.0], [0.0, height], [width, 0.0]])
    return np.roll(corner + corners, first, axis=0)


def far_away(q: np.ndarray, distance: float = AWAY) -> np.ndarray:
    """Return a triangle moved far from the origin, without rounding errors."""
    return in_short_binary_numbers(q) + distance * np.array([1, -1])


def small_at_a_place(random: np.random.Generator, points: np.ndarray, size: float) -> np.ndarray:
    """Return points made small, at a place of the unit square, without rounding errors.

    In units of their size they are far from the origin, and from all whole numbers.
    """
    return in_short_binary_numbers(random.uniform(0.4, 0.7, 2)) + size * in_short_binary_numbers(
        points
    )


def cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the signed areas of parallelograms."""
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]


# 06.1 Outward normals


def normals_inputs(seed: int) -> tuple[Call, ...]:
    """Return triangles of both orientations, an obtuse one, and small ones."""
    random = np.random.default_rng(seed)
    near = calls_of(
        "outward_normals",
        ((triangle(random, True, 3.0) + 5,), "a triangle, counter-clockwise"),
        ((triangle(random, False, 0.5),), "a smaller triangle, clockwise"),
        ((obtuse(random),), "an obtuse triangle"),
        ((along_the_axes(random),), "a triangle with two sides along the axes"),
        ((1e-15 * triangle(random, False),), "a triangle of the size 10⁻¹⁵, clockwise"),
        ((1e-15 * triangle(random, True),), "a triangle of the size 10⁻¹⁵, counter-clockwise"),
        ((integers(triangle(random, True), 1e4),), "a triangle of integers, counter-clockwise"),
        ((integers(triangle(random, False), 1e4),), "a triangle of integers, clockwise"),
        ((1e8 * triangle(random, True),), "a triangle of the size 10⁸, counter-clockwise"),
        ((1e8 * triangle(random, False),), "a triangle of the size 10⁸, clockwise"),
        ((flat_and_oblique(random, 1e-3),), "a flat triangle"),
        ((flat_and_oblique(random, 1e-3)[::-1].copy(),), "a flat triangle, clockwise"),
        ((flat_and_oblique(random, 1e-4),), "heights of about 2 · 10⁻⁵ of the sides"),
        (
            (flat_and_oblique(random, 1e-4)[::-1].copy(),),
            "heights of about 2 · 10⁻⁵ of the sides, clockwise",
        ),
    )
    far = tuple(
        Call(
            "outward_normals",
            (far_away(triangle(random, counter_clockwise, size)),),
            f"a triangle of the size {words} far away, {order}",
            exact=(0,),
        )
        for counter_clockwise, order in ((True, "counter-clockwise"), (False, "clockwise"))
        for size, words in ((1.0, "1"), (1e-3, "10⁻³"), (1e-4, "10⁻⁴"))
    )
    small = tuple(
        Call(
            "outward_normals",
            (small_at_a_place(random, triangle(random, counter_clockwise), TINY),),
            f"a triangle of the size 10⁻⁸ in the unit square, {order}",
            exact=(0,),
        )
        for counter_clockwise, order in ((True, "counter-clockwise"), (False, "clockwise"))
    )
    return near + far + small


def flat_and_oblique(random: np.random.Generator, height: float) -> np.ndarray:
    """Return a flat triangle, listed counter-clockwise, with no side along an axis."""
    (turn,) = directions(random.uniform(0.3, 1.2, 1))
    return obtuse(random) @ (np.array([[1], [height]]) * [turn, across(turn)])


def across(vector: np.ndarray) -> np.ndarray:
    """Return a vector rotated by a right angle."""
    return vector[::-1] * [-1, 1]


@law_of_each("A unit normal must have length one.")
def of_unit_length(_: Call, values: Values) -> float:
    return relative(np.hypot(*values[0].T) - 1, 1)


@law_of_each("The normal in row a must be perpendicular to the side opposite to corner a.")
def across_the_sides(call: Call, values: Values) -> float:
    """Return the largest deviation from perpendicular."""
    (q,), (n,) = call.arguments, values
    sides = np.roll(q, -2, axis=0) - np.roll(q, -1, axis=0)
    return max(relative(n[a] @ sides[a], sides[a]) for a in range(3))


@law_of_each(
    "An outward normal must point away from the opposite corner, for corners listed clockwise "
    "and counter-clockwise."
)
def leave_the_triangle(call: Call, values: Values) -> float:
    """Return 1 if a normal points towards the opposite corner."""
    (q,), (n,) = call.arguments, values
    return float(np.any(np.sum(n * (q - q.mean(axis=0)), axis=1) > 0))


# 06.2 and 06.3 The velocity of a cell, and its defect


def normal_velocities(random: np.random.Generator, q: np.ndarray) -> np.ndarray:
    """Return normal velocities far from those of any constant velocity."""
    lengths = np.hypot(*(np.roll(q, -1, axis=0) - np.roll(q, 1, axis=0)).T)
    while True:
        v = random.normal(size=3)
        if abs(lengths @ v) > LEAST_DEFECT * np.sqrt(lengths @ lengths):
            return v


def velocity_inputs(name: str, seed: int) -> tuple[Call, ...]:
    """Return random data, with a constant velocity added, doubled; obtuse and small triangles."""
    random = np.random.default_rng(seed)
    q = triangle(random, True)
    v = normal_velocities(random, q)
    small, wide, flat = triangle(random, False, 0.2), obtuse(random), obtuse(random) * [1, 0.05]
    quarter_turn = wide[:, ::-1] * [-1, 1]
    near = calls_of(
        name,
        ((q, v), "normal velocities at random"),
        ((q, v + projections(q)), "the same data plus those of the velocity (2, −1)"),
        ((q, -2 * v), "minus two times the first data"),
        ((wide, normal_velocities(random, wide)), "an obtuse triangle"),
        ((small, normal_velocities(random, small)), "a small triangle, clockwise"),
        ((1e-12 * small, normal_velocities(random, small)), "a triangle of the size 10⁻¹²"),
        ((flat, normal_velocities(random, flat)), "a flat triangle"),
        ((wide, 1e-9 * normal_velocities(random, wide)), "a very slow flow"),
        ((integers(q), normal_velocities(random, q)), "a triangle of integers"),
        (
            (integers(wide), integers(normal_velocities(random, wide))),
            "an obtuse triangle and velocities, integers",
        ),
        (
            (flat * [1, 2e-3], normal_velocities(random, flat)),
            "a triangle flatter than a thousandth",
        ),
        ((quarter_turn, normal_velocities(random, wide)), "the obtuse triangle, rotated"),
        ((wide[:, ::-1].copy(), normal_velocities(random, wide)), "the obtuse triangle, mirrored"),
        ((q[:, ::-1] * [-1, 1], v), "the first triangle, rotated"),
        ((-q, v), "the first triangle, turned upside down"),
        ((q, 1e-6 * v), "velocities of the size 10⁻⁶"),
        ((small, 1e-12 * normal_velocities(random, small)), "velocities of the size 10⁻¹²"),
        ((small, 1e6 * normal_velocities(random, small)), "velocities of the size 10⁶"),
        ((q, 1e9 * v), "velocities of the size 10⁹"),
        ((1e-6 * q, v), "a triangle of the size 10⁻⁶"),
        ((1e8 * wide, normal_velocities(random, wide)), "a triangle of the size 10⁸"),
        ((1e5 * q, v), "a triangle of the size 10⁵"),
        ((wide, np.zeros(3)), "no flow"),
        ((q, integers(v)), "velocities of integers"),
    )
    far = tuple(
        Call(name, (p, normal_velocities(random, p)), case, exact=(0,))
        for p, case in (
            (far_away(triangle(random, False), AWAY / 16), "a triangle 10⁵ away, clockwise"),
            (far_away(obtuse(random), AWAY / 16), "an obtuse triangle, 10⁵ away"),
            (
                small_at_a_place(random, triangle(random, False), SMALL),
                "a triangle of the size 10⁻⁵ in the unit square",
            ),
            (
                small_at_a_place(random, obtuse(random), SMALL),
                "an obtuse triangle of the size 10⁻⁵ in the unit square",
            ),
        )
    )
    return (*near, *far, *closed_or_consistent(name, random))


def closed_or_consistent(name: str, random: np.random.Generator) -> tuple[Call, ...]:
    """Return velocities of which one or two are zero, and velocities without net outflow."""
    q, wide = triangle(random, True), obtuse(random)
    small, whole = triangle(random, False, 0.2), integers(triangle(random, False))
    return calls_of(
        name,
        ((q, closed(random, 1)), "no flow across one side"),
        ((wide, closed(random, 2)), "no flow across two sides"),
        ((q, random.uniform(1, 2) * projections(q)), "a constant flow"),
        ((wide, random.uniform(1, 2) * projections(wide)), "a constant flow, obtuse triangle"),
        ((small, 1e3 * projections(small)), "a constant flow of the size 10³"),
        ((whole, random.uniform(1, 2) * projections(whole)), "a constant flow, integer corners"),
    )


def closed(random: np.random.Generator, sides: int) -> np.ndarray:
    """Return normal velocities, all outwards, but zero at one or two sides."""
    return random.permutation(random.uniform(0.5, 1.5, 3) * (np.arange(3) >= sides))


def zero_without_outflow(call: Call, values: Values) -> Values:
    """Return the defect, or zero if it is a rounding error of the velocities."""
    (d,) = values
    return (np.where(np.abs(d) < 1e-12 * np.abs(call.arguments[1]).max(), 0.0, d),)


WIND = np.array([2.0, -1.0])


def projections(q: np.ndarray) -> np.ndarray:
    """Return the components of the constant velocity normal to the sides of a triangle."""
    along = np.array([q[2] - q[1], q[0] - q[2], q[1] - q[0]])
    return cross(WIND, along) / np.hypot(*along.T)


@law(
    "Adding the normal velocities of a constant velocity to the data must add this velocity to "
    "the result."
)
def constant_velocity_is_reproduced(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[1][0] - values[0][0] - WIND, np.abs(values[1][0]).max() + 2)


@law("Minus two times the data must give minus two times the velocity.")
def is_linear(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[2][0] + 2 * values[0][0], values[2][0])


@law("Adding the normal velocities of a constant velocity to the data must not change the defect.")
def constant_velocity_has_no_defect(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return float(abs(values[1][0] - values[0][0]))


@law("Minus two times the data must have twice the defect, since the defect is a length.")
def grows_with_the_data(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[2][0] - 2 * values[0][0], values[2][0])


# 06.4 The circumcentre


def circumcentre_inputs(seed: int) -> tuple[Call, ...]:
    """Return triangles near the origin and far away, among them obtuse and small ones."""
    random = np.random.default_rng(seed)
    q = triangle(random, True)
    near = calls_of(
        "circumcenter",
        ((q,), "a triangle"),
        ((obtuse(random),), "an obtuse triangle"),
        ((q + FAR,), "the first triangle, far from the origin"),
        ((obtuse(random) - FAR,), "an obtuse triangle, far from the origin"),
        ((triangle(random, False, 1e-3),), "a small triangle, clockwise"),
        ((1e-12 * triangle(random, False),), "a triangle of the size 10⁻¹²"),
        *(
            ((along_the_axes(random, k),), f"two sides along the axes, from the {which} corner")
            for k, which in enumerate(("first", "second", "third"))
        ),
        ((obtuse(random) * [1, 0.02],), "a flat triangle"),
        ((obtuse(random) * [0.02, 1] + 2,), "a narrow triangle"),
        ((obtuse(random) * [1, 2e-3],), "a triangle as flat as a needle"),
        ((obtuse(random) * [2e-3, 1],), "a triangle as narrow as a needle"),
        ((integers(triangle(random, True)),), "a triangle of integers"),
        ((integers(obtuse(random)),), "an obtuse triangle of integers"),
        ((1e-6 * triangle(random, True),), "a triangle of the size 10⁻⁶"),
        ((1e5 * triangle(random, True),), "a triangle of the size 10⁵"),
        ((1e5 * obtuse(random),), "an obtuse triangle of the size 10⁵"),
        ((1e12 * triangle(random, False),), "a triangle of the size 10¹²"),
        ((1e12 * obtuse(random),), "an obtuse triangle of the size 10¹²"),
    )
    small = tuple(
        Call("circumcenter", (small_at_a_place(random, p, TINY),), case, exact=(0,))
        for p, case in (
            (triangle(random, False), "a triangle of the size 10⁻⁸ in the unit square"),
            (obtuse(random), "an obtuse triangle of the size 10⁻⁸ in the unit square"),
        )
    )
    return near + small


@law("Moving the triangle must move its circumcentre by as much.", DIGITS_FAR_AWAY)
def moves_along(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[2][0] - values[0][0] - FAR, 1)


QUESTIONS = (
    Question(
        "06.1",
        "outward_normals",
        3,
        also_at_zero(normals_inputs, points=(0,)),
        lambda _: ((3, 2),),
        (of_unit_length, across_the_sides, leave_the_triangle),
        picture="sides",
    ),
    Question(
        "06.2",
        "cell_velocity",
        3,
        also_at_zero(lambda seed: velocity_inputs("cell_velocity", seed), points=(0,), values=(1,)),
        lambda _: ((2,),),
        (constant_velocity_is_reproduced, is_linear),
    ),
    Question(
        "06.3",
        "defect",
        2,
        also_at_zero(lambda seed: velocity_inputs("defect", seed), points=(0,), values=(1,)),
        lambda _: ((),),
        (constant_velocity_has_no_defect, grows_with_the_data),
        normal_form=zero_without_outflow,
    ),
    Question(
        "06.4",
        "circumcenter",
        3,
        also_at_zero(circumcentre_inputs, points=(0,)),
        lambda _: ((2,),),
        (is_equally_far, is_equally_far_from_afar, moves_along),
        tolerance_far_away,
        relative_to_a_corner,
    ),
)
