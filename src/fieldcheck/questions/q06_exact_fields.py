"""Questions of notebook 06 on an exact field, the errors, and the Raviart-Thomas field."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, in_short_binary_numbers, integers
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, relative
from fieldcheck.questions.q05_edges import AWAY, mesh
from fieldcheck.questions.q06_cell_velocities import (
    closed,
    cross,
    far_away,
    obtuse,
    projections,
    small_at_a_place,
    triangle,
)

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
        ((1e-12 * x, 1e-12 * m, -0.4), "points in a square of 10⁻¹²"),
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
    """Return the deviation of the radial component from s times the squared distance.

    The second call has s = 0, so that a wrong rotation is not taken for a wrong rate.
    """
    x, _, s = calls[0].arguments
    way, change = np.diff(x, axis=0), np.diff(values[0][0] - values[1][0], axis=0)
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
        ((1e-12 * points, triangles, 0.8), "an expansion on a mesh in a square of 10⁻¹²"),
        ((1e6 * points, triangles, 0.8), "an expansion on a mesh in a square of 10⁶"),
        ((*mesh(random, 6, 5), 0.71), "a mesh of sixty-two triangles"),
    )
    rounded = in_short_binary_numbers(points)
    far = tuple(
        Call("errors", (rounded + move, triangles, s), f"a mesh 10⁴ away, s = {s}", exact=(0,))
        for move, s in zip(shift, (0.8, 0.45), strict=True)
    )
    small = small_at_a_place(random, points, 2.0**-14)
    case = "a mesh of the size 0.0001 in the unit square, s = 0.6"
    return (*near, *far, Call("errors", (small, triangles, 0.6), case, exact=(0,)))


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
        ((q, v, 2 * on[0] - q[0]), "a point outside"),
        ((obtuse(random), random.normal(size=3), random.random(2)), "an obtuse triangle"),
        (
            (triangle(random, False, 0.4), random.normal(size=3), random.random(2)),
            "a triangle listed clockwise",
        ),
        *(
            ((obtuse(random) * scale, random.normal(size=3), random.random(2)), case)
            for scale, case in (
                ([1, 1e-5], "a triangle as flat as a needle"),
                ([1e-5, 1], "a triangle as narrow as a needle"),
            )
        ),
        ((1e-15 * q, v, 1e-15 * on[1] + 1e-16), "a triangle of the size 10⁻¹⁵"),
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
        ((q, projections(q), random.random(2)), "a constant flow"),
        ((q, closed(random, 1), random.random(2)), "no flow across one side"),
        ((q, closed(random, 2), random.random(2)), "no flow across two sides"),
        ((q, np.zeros(3), random.random(2)), "no flow"),
    )
    far = []
    for corners, size, case in (
        (triangle(random, True), 1.0, "a triangle 10⁶ away"),
        (triangle(random, False), 1.0, "a triangle 10⁶ away, clockwise"),
        (triangle(random, True), 1e-3, "a triangle of the size 10⁻³, 10⁶ away"),
        (triangle(random, False), 1e-4, "a triangle of the size 10⁻⁴, 10⁶ away, clockwise"),
    ):
        *away, x = far_away(size * np.append(corners, random.random((1, 2)), axis=0))
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
        "06.5",
        "truth",
        2,
        also_at_zero(truth_inputs, points=(0, 1)),
        lambda call: (call.arguments[0].shape,),
        (turns_rigidly, expands, depends_on_the_distance_from_the_centre_only),
    ),
    Question(
        "06.6",
        "errors",
        3,
        also_at_zero(errors_inputs, points=(0,)),
        lambda _: ((3,),),
        (exact_at_the_circumcentre, grows_with_the_mesh),
    ),
    Question(
        "06.8",
        "raviart_thomas",
        3,
        also_at_zero(raviart_thomas_inputs, points=(0, 2), values=(1,)),
        lambda _: ((2,),),
        (crosses_the_side_as_given,),
    ),
)
