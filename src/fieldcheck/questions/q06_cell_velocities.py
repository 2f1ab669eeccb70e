"""Questions of notebook 06, velocities of the cells of a triangle mesh."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.question import Question, law, relative
from fieldcheck.questions.q05_edges import AWAY, directions, in_short_binary_numbers, mesh
from fieldcheck.simplices import (
    DIGITS_FAR_AWAY,
    FAR,
    is_equally_far,
    relative_to_a_corner,
    tolerance_far_away,
)

LEAST_DEFECT = 0.01
"""For normal velocities of size one; a smaller defect would have fewer than twelve digits."""


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


def far_away(q: np.ndarray) -> np.ndarray:
    """Return a triangle moved far from the origin, without rounding errors."""
    return in_short_binary_numbers(q) + AWAY * np.array([1, -1])


def cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the signed areas of parallelograms."""
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]


# 06.1 Outward normals


def normals_inputs(seed: int) -> tuple[Call, ...]:
    """Return triangles of both orientations, an obtuse one, and small ones."""
    random = np.random.default_rng(seed)
    near = calls_of(
        "outward_normals",
        ((triangle(random, True, 3.0),), "a triangle, counter-clockwise"),
        ((triangle(random, False, 0.5),), "a smaller triangle, clockwise"),
        ((obtuse(random),), "an obtuse triangle"),
        ((along_the_axes(random),), "a triangle with two sides along the axes"),
        ((1e-12 * triangle(random, False),), "a triangle of the size 10⁻¹², clockwise"),
        ((1e-12 * triangle(random, True),), "a triangle of the size 10⁻¹², counter-clockwise"),
        ((integers(triangle(random, True), 1e4),), "a triangle of integers, counter-clockwise"),
        ((integers(triangle(random, False), 1e4),), "a triangle of integers, clockwise"),
        ((1e8 * triangle(random, True),), "a triangle of the size 10⁸, counter-clockwise"),
        ((1e8 * triangle(random, False),), "a triangle of the size 10⁸, clockwise"),
        ((flat_and_oblique(random, 1e-3),), "a flat triangle"),
        ((flat_and_oblique(random, 1e-3)[::-1].copy(),), "a flat triangle, clockwise"),
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
    return near + far


def flat_and_oblique(random: np.random.Generator, height: float) -> np.ndarray:
    """Return a flat triangle, listed counter-clockwise, with no side along an axis."""
    (turn,) = directions(random.uniform(0.3, 1.2, 1))
    return obtuse(random) @ (np.array([[1], [height]]) * [turn, across(turn)])


def across(vector: np.ndarray) -> np.ndarray:
    """Return a vector rotated by a right angle."""
    return vector[::-1] * [-1, 1]


@law("A unit normal must have length one.")
def of_unit_length(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return max(relative(np.hypot(*n.T) - 1, 1) for (n,) in values)


@law("The normal in row a must be perpendicular to the side opposite to corner a.")
def across_the_sides(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the sum of the normals times the opposite side lengths, and the deviation from
    perpendicular.
    """
    worst = 0.0
    for call, (n,) in zip(calls, values, strict=True):
        for a in (0, 1, 2):
            start, end = np.delete(call.arguments[0], a, axis=0)
            worst = max(worst, relative(n[a] @ (end - start), end - start))
    return worst


@law(
    "An outward normal must point away from the opposite corner, for corners listed clockwise "
    "and counter-clockwise."
)
def leave_the_triangle(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return 1 if a normal points towards the opposite corner."""
    inwards = [
        np.any(np.sum(n * (q - q.mean(axis=0)), axis=1) > 0)
        for (q,), (n,) in ((c.arguments, v) for c, v in zip(calls, values, strict=True))
    ]
    return float(max(inwards))


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
        ((1e-9 * small, normal_velocities(random, small)), "a triangle of the size 10⁻⁹"),
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
            (far_away(triangle(random, False)), "a triangle 10⁶ away, clockwise"),
            (far_away(obtuse(random)), "an obtuse triangle, 10⁶ away"),
        )
    )
    return near + far


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
    return calls_of(
        "circumcenter",
        ((q,), "a triangle"),
        ((obtuse(random),), "an obtuse triangle"),
        ((q + FAR,), "the first triangle, far from the origin"),
        ((obtuse(random) - FAR,), "an obtuse triangle, far from the origin"),
        ((triangle(random, False, 1e-3),), "a small triangle, clockwise"),
        ((1e-9 * triangle(random, False),), "a triangle of the size 10⁻⁹"),
        *(
            ((along_the_axes(random, k),), f"two sides along the axes, from the {which} corner")
            for k, which in enumerate(("first", "second", "third"))
        ),
        ((obtuse(random) * [1, 0.02],), "a flat triangle"),
        ((obtuse(random) * [0.02, 1] + 2,), "a narrow triangle"),
        ((integers(triangle(random, True)),), "a triangle of integers"),
        ((integers(obtuse(random)),), "an obtuse triangle of integers"),
        ((1e-6 * triangle(random, True),), "a triangle of the size 10⁻⁶"),
        ((1e5 * triangle(random, True),), "a triangle of the size 10⁵"),
        ((1e5 * obtuse(random),), "an obtuse triangle of the size 10⁵"),
    )


@law("Moving the triangle must move its circumcentre by as much.", DIGITS_FAR_AWAY)
def moves_along(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[2][0] - values[0][0] - FAR, 1)


# 06.5 The exact velocity


def truth_inputs(seed: int) -> tuple[Call, ...]:
    """Return points with and without contraction, all translated, the centre, and expansion."""
    random = np.random.default_rng(seed)
    x, m, shift = random.uniform(-1, 2, (6, 2)), random.random(2), np.array([3.0, -5.0])
    return calls_of(
        "truth",
        ((x, m, -0.7), "six points, s = −0.7"),
        ((x, m, 0.0), "the same points, s = 0"),
        ((x + shift, m + shift, -0.7), "points and centre moved, s = −0.7"),
        ((m + 0 * x[:2], m, 1.3), "the centre itself"),
        ((x[:4], m, 0.8642), "four points, s = 0.8642"),
        ((x[4:], m, 26.73), "two points, s = 26.73"),
        ((x[1:], m, -31.05), "five points, s = −31.05"),
        ((integers(x), m, 0.5314), "six points, integers, and s = 0.5314"),
        ((integers(x[2:]), integers(m), -0.271), "points and centre, integers"),
        ((x, m, 2), "six points, s = 2, an integer"),
        ((integers(x), integers(m), -3), "points, centre and s = −3, integers"),
        ((x, integers(m), 0.618), "a centre of integers"),
        ((1e-6 * x, 1e-6 * m, 0.4), "points in a square of 10⁻⁶"),
        ((1e-9 * x, 1e-9 * m, -0.4), "points in a square of 10⁻⁹"),
        ((1e6 * x, 1e6 * m, 0.4), "points in a square of 10⁶"),
        ((random.uniform(-1, 2, (67, 2)), m, 0.357), "sixty-seven points"),
        (
            (np.add(m, [[0, 1], [2, 0], [-1, 0]]), m, 0.9),
            "three points level with the centre or above it",
        ),
        ((m + 0 * x[:1], m, 0.7), "one point, the centre"),
    )


@law(
    "For s = 0 the difference of two velocities must be perpendicular to the line between the two "
    "points, since distances do not change."
)
def turns_rigidly(calls: Sequence[Call], values: Sequence[Values]) -> float:
    way, change = np.diff(calls[1].arguments[0], axis=0), np.diff(values[1][0], axis=0)
    return relative(np.einsum("xk,xk->x", way, change), way**2)


@law("The distance between two points must grow at the rate s, and shrink if s is negative.")
def expands(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the radial component from s times the squared distance."""
    x, _, s = calls[0].arguments
    way, change = np.diff(x, axis=0), np.diff(values[0][0], axis=0)
    return relative(np.einsum("xk,xk->x", way, change - s * way), way**2)


@law("Moving the points and the centre together must not change the velocities.")
def depends_on_the_distance_from_the_centre_only(
    calls: Sequence[Call], values: Sequence[Values]
) -> float:
    return relative(values[2][0] - values[0][0], values[0][0])


# 06.6 The errors


def errors_inputs(seed: int) -> tuple[Call, ...]:
    """Return a mesh with a rotation, the same mesh at twice the size, and with expansion."""
    random = np.random.default_rng(seed)
    points, triangles = mesh(random, 3, 3)
    shift = AWAY * np.array([[1, -1], [-1, 1]]) / 64
    near = calls_of(
        "errors",
        ((points, triangles, 0.0), "a rotation, s = 0"),
        ((2 * points, triangles, 0.0), "the same rotation on a mesh twice as large"),
        ((points, triangles, 0.8), "an expansion, s = 0.8"),
        ((triangle(random, True), np.array([[2, 0, 1]]), -0.537), "a single triangle, s = −0.537"),
        ((points, triangles, 1), "an expansion, s = 1, an integer"),
        ((integers(points), triangles, -2), "points and s = −2, integers"),
        ((integers(points), triangles, 0.37), "a mesh of integers"),
        ((1e-6 * points, triangles, 0.8), "an expansion on a mesh in a square of 10⁻⁶"),
        ((1e-9 * points, triangles, 0.8), "an expansion on a mesh in a square of 10⁻⁹"),
        ((1e6 * points, triangles, 0.8), "an expansion on a mesh in a square of 10⁶"),
        ((*mesh(random, 6, 5), 0.71), "a mesh of sixty-two triangles"),
    )
    rounded = in_short_binary_numbers(points)
    far = tuple(
        Call("errors", (rounded + move, triangles, s), f"a mesh 10⁴ away, s = {s}", exact=(0,))
        for move, s in zip(shift, (0.8, 0.45), strict=True)
    )
    return near + far


@law("For a rotation the error at the circumcentres must be zero.")
def exact_at_the_circumcentre(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[0][0][0], values[0][0][1:])


@law("On a mesh twice as large the errors must be twice as large, as all velocities are.")
def grows_with_the_mesh(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[1][0] - 2 * values[0][0], values[1][0])


# 06.8 The Raviart-Thomas field


def raviart_thomas_inputs(seed: int) -> tuple[Call, ...]:
    """Return two points on one side, a point inside, and an obtuse clockwise triangle."""
    random = np.random.default_rng(seed)
    q, v = triangle(random, True), random.normal(size=3)
    part = random.uniform(0.1, 0.9, 2)
    on = [q[1] + t * (q[2] - q[1]) for t in part]
    name = "raviart_thomas"
    near = calls_of(
        name,
        ((q, v, on[0]), "a point on the first side"),
        ((q, v, on[1]), "another point on the same side"),
        ((q, v, random.dirichlet((3, 3, 3)) @ q), "a point inside"),
        ((obtuse(random), random.normal(size=3), random.random(2)), "an obtuse triangle"),
        (
            (triangle(random, False, 0.4), random.normal(size=3), random.random(2)),
            "a triangle listed clockwise",
        ),
        ((1e-9 * q, v, 1e-9 * on[1] + 1e-10), "a triangle of the size 10⁻⁹"),
        ((integers(q), v, integers(random.random(2))), "a triangle and a point, integers"),
        ((integers(q), integers(v), random.random(2)), "a triangle and velocities, integers"),
        ((q, v, np.array([1, 2])), "a point of integers"),
        ((q, 1e-6 * v, random.random(2)), "velocities of the size 10⁻⁶"),
        ((q, 1e-12 * v, random.random(2)), "velocities of the size 10⁻¹²"),
        ((q, 1e6 * v, random.random(2)), "velocities of the size 10⁶"),
        ((1e-6 * q, v, 1e-6 * random.random(2)), "a triangle of the size 10⁻⁶"),
        ((1e5 * q, v, 1e5 * random.random(2)), "a triangle of the size 10⁵"),
        ((1e8 * q, v, 1e8 * random.random(2)), "a triangle of the size 10⁸"),
        ((q[:, ::-1] * [-1, 1], v, random.random(2)), "the first triangle, rotated"),
        ((-q, v, random.random(2)), "the first triangle, turned upside down"),
    )
    far = []
    for corners, case in (
        (triangle(random, True), "a triangle 10⁶ away"),
        (triangle(random, False), "a triangle 10⁶ away, clockwise"),
    ):
        *away, x = far_away(np.append(corners, random.random((1, 2)), axis=0))
        far.append(Call(name, (np.array(away), v, x), case, exact=(0, 2)))
    return (*near, *far)


@law("At every point of a side the normal velocity must be the given one.")
def crosses_the_side_as_given(calls: Sequence[Call], values: Sequence[Values]) -> float:
    q, v, _ = calls[0].arguments
    along = q[2] - q[1]
    found = [cross(w, along) / np.hypot(*along) for (w,) in values[:2]]
    return relative(np.array(found) - v[0], v)


QUESTIONS = (
    Question(
        "06.1",
        "outward_normals",
        3,
        normals_inputs,
        lambda _: ((3, 2),),
        (of_unit_length, across_the_sides, leave_the_triangle),
        picture="sides",
    ),
    Question(
        "06.2",
        "cell_velocity",
        3,
        lambda seed: velocity_inputs("cell_velocity", seed),
        lambda _: ((2,),),
        (constant_velocity_is_reproduced, is_linear),
    ),
    Question(
        "06.3",
        "defect",
        2,
        lambda seed: velocity_inputs("defect", seed),
        lambda _: ((),),
        (constant_velocity_has_no_defect, grows_with_the_data),
    ),
    Question(
        "06.4",
        "circumcenter",
        3,
        circumcentre_inputs,
        lambda _: ((2,),),
        (is_equally_far, moves_along),
        tolerance_far_away,
        relative_to_a_corner,
    ),
    Question(
        "06.5",
        "truth",
        2,
        truth_inputs,
        lambda call: (call.arguments[0].shape,),
        (turns_rigidly, expands, depends_on_the_distance_from_the_centre_only),
    ),
    Question(
        "06.6",
        "errors",
        3,
        errors_inputs,
        lambda _: ((3,),),
        (exact_at_the_circumcentre, grows_with_the_mesh),
    ),
    Question(
        "06.8",
        "raviart_thomas",
        3,
        raviart_thomas_inputs,
        lambda _: ((2,),),
        (crosses_the_side_as_given,),
    ),
)
