"""Questions of notebook 04, the rank of a velocity system, the edges of a star, and conics."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of
from fieldcheck.question import Question, law, law_of_each, relative
from fieldcheck.questions.q03_radial_basis_functions import cloud

MAP = np.array([1e7, -4e6])
"""A position in metres on a map whose origin is far away."""


def directions(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n unit vectors of the plane, no two of which are nearly parallel."""
    angles = np.pi * (random.permutation(n) + random.uniform(0.2, 0.8, n)) / n
    return random.choice([-1, 1], (n, 1)) * np.column_stack([np.cos(angles), np.sin(angles)])


def sphere(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n random unit vectors of space."""
    v = random.normal(size=(n, 3))
    return v / np.sqrt((v * v).sum(axis=1))[:, None]


def parallel_except(random: np.random.Generator, n: int, others: Sequence[int]) -> np.ndarray:
    """Return normals that are parallel up to the sign, with some exceptions."""
    all_directions = directions(random, n)
    same = random.choice([-1, 1], (n, 1)) * all_directions[0]
    same[list(others)] = all_directions[1 : 1 + len(others)]
    return same


def towards(points: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return unit vectors from a given point to the points."""
    offset = points - place
    return offset / np.hypot(*offset.T)[:, None]


def in_line(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n points on a line across the unit square, and one point off the line."""
    along = (np.arange(n) + random.uniform(0.2, 0.8, n)) / n
    line = np.column_stack([along, 0.1 + 0.4 * along])
    return np.append(line, [[random.uniform(0.1, 0.5), 0.9]], axis=0)


# 04.1 The matrix


def matrix_inputs(seed: int) -> tuple[Call, ...]:
    """Return samples in the plane and in space, also with vectors that are not unit vectors."""
    random = np.random.default_rng(seed)
    plane, space = cloud(random, 7, 2), cloud(random, 5, 3)
    return calls_of(
        "velocity_matrix",
        ((plane, directions(random, 7)), "seven samples in the plane"),
        ((space - 0.3, sphere(random, 5)), "five samples in space"),
        (
            (plane[:3] + 1, random.normal(size=(3, 2))),
            "three samples with other vectors for normals",
        ),
    )


def matrix_shape(call: Call) -> tuple[tuple[int, ...], ...]:
    n, d = call.arguments[0].shape
    return ((n, d + d**2),)


@law_of_each("B' times the coefficients of a flow must be what flows across the samples.")
def gives_the_normal_component(call: Call, values: Values) -> float:
    """Return the deviation of B' c from the normal component of the flow."""
    (b,) = values
    points, normals = call.arguments
    d = points.shape[1]
    c = np.cos(np.arange(d + d * d) + 1.0)
    u = c[:d] + points.dot(c[d:].reshape(d, d))
    wanted = (u * normals).sum(axis=1)
    return relative(b.dot(c) - wanted, wanted)


# 04.2 The rank


def rank_inputs(seed: int) -> tuple[Call, ...]:
    """Return samples of known rank, near and far from the origin, in large and small units."""
    random = np.random.default_rng(seed)
    points, nine = cloud(random, 8, 2), cloud(random, 9, 2)
    flat = sphere(random, 14)
    flat[:, 2] = 0
    space = cloud(random, 14, 3)
    name = "velocity_rank"
    return (
        Call(name, (points, directions(random, 8)), "eight samples in the plane"),
        Call(
            name,
            (points, parallel_except(random, 8, ())),
            "eight samples with parallel normals",
            exact=(0, 1),
        ),
        Call(
            name,
            (points, parallel_except(random, 8, (2, 5))),
            "parallel normals but for two of eight",
            exact=(0, 1),
        ),
        Call(
            name,
            (points, towards(points, np.array([0.47, 0.52]))),
            "eight normals through one place",
            exact=(0, 1),
        ),
        Call(name, (points[:5], directions(random, 5)), "five samples"),
        Call(
            name,
            (1e-6 * nine, directions(random, 9)),
            "nine samples a thousandth of a millimetre apart, in metres",
        ),
        Call(
            name,
            (MAP + 0.01 * nine, directions(random, 9)),
            "nine samples on a map whose origin is far away",
        ),
        Call(name, (space, sphere(random, 14)), "fourteen samples in space"),
        Call(
            name,
            (space, flat / np.sqrt((flat * flat).sum(axis=1))[:, None]),
            "fourteen samples in space with horizontal normals",
            exact=(0, 1),
        ),
    )


RANKS = (6, 3, 5, 5, 5, 6, 6, 12, 8)


@law("Theory knows the rank of each of these cases.")
def has_the_known_rank(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the largest difference from the ranks that are known for these cases."""
    return max(abs(float(v) - r) for (v,), r in zip(values, RANKS, strict=True))


# 04.3 and 04.4 Tangent flows, and the normals perpendicular to them


def flow(random: np.random.Generator) -> np.ndarray:
    """Return the coefficients of a flow that rotates about a point outside the unit square and has
    no other zero.

    Its gradient is far from rank one: normals perpendicular to a flow of rank one are parallel, and
    are perpendicular to other flows, too.
    """
    gradient = random.uniform(-0.9, 0.9, (2, 2)) + 2 * np.array([[0, 1], [-1, 0]])
    return np.concatenate([-np.array([-0.6, 1.7]).dot(gradient), gradient.ravel()])


def perpendicular_vectors(points: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return vectors perpendicular to the flow: its values times the imaginary unit."""
    u = c[:2] + points.dot(c[2:].reshape(2, 2))
    across = 1j * (u[:, 0] + 1j * u[:, 1])
    across /= np.abs(across)
    return np.column_stack([across.real, across.imag])


def tangent_inputs(seed: int) -> tuple[Call, ...]:
    """Return samples of rank five: perpendicular to a flow, at one point, and five samples."""
    random = np.random.default_rng(seed)
    twelve, nine = cloud(random, 12, 2), cloud(random, 9, 2)
    place = 0.5 + random.uniform(-0.02, 0.02, 2)
    return calls_of(
        "tangent_field",
        (
            (twelve, perpendicular_vectors(twelve, flow(random))),
            "twelve samples that do not see some flow",
        ),
        ((nine, towards(nine, place)), "nine normals through one place"),
        ((nine + 1, parallel_except(random, 9, (3, 6))), "parallel normals but for two of nine"),
        ((cloud(random, 5, 2), directions(random, 5)), "five samples"),
    )


@law_of_each("The flow must not be zero, and at each sample it must run along the edge.")
def is_tangent(call: Call, values: Values) -> float:
    """Return the largest normal velocity relative to the size of the coefficients."""
    (c,) = values
    points, normals = call.arguments
    u = c[:2] + points.dot(c[2:].reshape(2, 2))
    return max(float(not c.any()), relative((u * normals).sum(axis=1), c))


def up_to_a_factor(_: Call, values: Values) -> Values:
    """Return coefficients normalised to length one and a fixed sign."""
    (c,) = values
    size = float(np.sqrt(c.dot(c))) or 1.0
    return (c / (size if c.dot(np.sin(np.arange(1.0, 1 + c.size))) >= 0 else -size),)


def normals_inputs(seed: int) -> tuple[Call, ...]:
    """Return flows and points."""
    random = np.random.default_rng(seed)
    seven, five = cloud(random, 7, 2), cloud(random, 5, 2)
    return calls_of(
        "crossing_normals",
        ((seven, flow(random)), "seven points"),
        ((five - 0.5, np.append(random.normal(size=2) + 3, np.zeros(4))), "a constant flow"),
        ((five + 1, 100 * random.normal(size=6)), "a fast flow"),
    )


@law_of_each("Normals have the length one, and stand at right angles to the flow.")
def are_unit_and_perpendicular(call: Call, values: Values) -> float:
    """Return the deviation of the normals from length one and from perpendicular to the flow."""
    (normals,) = values
    points, c = call.arguments
    u = c[:2] + points.dot(c[2:].reshape(2, 2))
    return max(relative((u * normals).sum(axis=1), u), relative(np.hypot(*normals.T) - 1, 1.0))


def with_one_sign(_: Call, values: Values) -> Values:
    """Return the last array with each row oriented to one side."""
    *others, normals = values
    side = np.where(normals.dot(np.array([0.8, 0.6])) < 0, -1.0, 1.0)
    return (*others, side[:, None] * normals)


# 04.5 The obvious conditions


def obvious_inputs(seed: int) -> tuple[Call, ...]:
    """Return samples that satisfy the conditions, and samples that violate them in several ways."""
    random = np.random.default_rng(seed)
    points, line = cloud(random, 7, 2), in_line(random, 5)
    three_in_line = cloud(random, 7, 2)
    three_in_line[2] = 0.3 * three_in_line[0] + 0.7 * three_in_line[1]
    name = "obvious"
    upright = np.where(np.arange(7) % 2, 0, np.pi / 2)
    staggered = np.column_stack([np.cos(upright), np.sin(upright)]).round()
    two_places = np.column_stack(
        [np.sqrt(0.5) * np.ones(7), random.choice([-1, 1], 7) * np.sqrt(0.5)]
    )
    two_places[:5, 1] = two_places[0, 1]
    two_places[5:, 1] = -two_places[0, 1]
    return calls_of(
        name,
        ((points, directions(random, 7)), "seven samples"),
        ((points, parallel_except(random, 7, ())), "parallel normals"),
        ((points, parallel_except(random, 7, (1, 4))), "parallel normals but for two of seven"),
        (
            (in_triangle(points), parallel_except(random, 7, (0, 1, 2))),
            "parallel normals but for three of seven",
        ),
        (
            (three_in_line, parallel_except(random, 7, (0, 1, 2))),
            "parallel normals but for three that are on one line",
        ),
        ((line, directions(random, 6)), "five points on a line and one beside it"),
        ((points, towards(points, np.array([0.47, 0.52]))), "normals through one place"),
        ((in_triangle(points), staggered), "normals along the axes, by turns"),
        ((points, two_places), "diagonal normals, only two of them in one of the directions"),
    )


HOLDS = (1, 0, 0, 1, 0, 0, 1, 1, 0)


def in_triangle(points: np.ndarray) -> np.ndarray:
    """Return points whose even and odd members are each far from collinear."""
    spread = points.copy()
    spread[:3] = points[:3] / 10 + np.array([[0, 0], [0.9, 0.1], [0.2, 0.9]])
    spread[3:6] = points[3:6] / 10 + np.array([[0.1, 0.5], [0.8, 0.8], [0.6, 0.1]])
    return spread


@law("For each of these cases it is known whether (4.5) holds.")
def is_as_constructed(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return one if the judgement on a case differs from its construction."""
    return max(abs(float(v) - h) for (v,), h in zip(values, HOLDS, strict=True))


def number(_: Call) -> tuple[tuple[int, ...], ...]:
    return ((),)


def sizes(call: Call, values: Values) -> Values:
    """Return the absolute values of the coefficients, normalised to length one.

    A misconception may combine entries of several singular vectors, whose signs are arbitrary.
    """
    (c,) = up_to_a_factor(call, values)
    return (np.abs(c),)


def loose(_: Call) -> float:
    """Return the rounding error of null vectors of a matrix whose gap is not small."""
    return 1e-8


# 04.6 and 04.7 Stars and conics


def star_inputs(seed: int) -> tuple[Call, ...]:
    """Return stars of five and three triangles, and a star far from the origin."""
    random = np.random.default_rng(seed)
    calls = []
    for k, center, case in (
        (5, (0.1, -0.2), "five triangles"),
        (3, (0, 0), "three triangles"),
        (6, (4, 7), "six triangles"),
    ):
        angles = 2 * np.pi * (np.arange(k) + random.uniform(-0.2, 0.2, k)) / k
        rays = random.uniform(0.5, 1.5, (k, 1)) * np.column_stack([np.cos(angles), np.sin(angles)])
        calls.append(Call("star_samples", (np.array(center, dtype=float), rays + center), case))
    return tuple(calls)


def star_shapes(call: Call) -> tuple[tuple[int, ...], ...]:
    k = len(call.arguments[1])
    return ((2 * k, 2), (2 * k, 2))


@law_of_each(
    "Points are in the middle of the edges; normals have the length one and stand at "
    "right angles to the edge."
)
def belong_to_the_edges(call: Call, values: Values) -> float:
    """Return the deviation of points from midpoints of edges, and of normals from unit normals."""
    (points, normals) = values
    center, ring = call.arguments
    k = len(ring)
    following = ring[np.r_[1:k, 0]]
    twice = np.append(ring + center, ring + following, axis=0)
    edges = np.append(ring - center, ring - following, axis=0)
    across = relative((edges * normals).sum(axis=1), edges)
    return max(relative(2 * points - twice, twice), across, relative(np.hypot(*normals.T) - 1, 1.0))


def conic_inputs(seed: int) -> tuple[Call, ...]:
    """Return random points, and points on conics and lines, near and far, in several units."""
    random = np.random.default_rng(seed)
    eight, five = cloud(random, 8, 2), cloud(random, 5, 2)
    angles = 2 * np.pi * (np.arange(9) + random.uniform(-0.3, 0.3, 9)) / 9
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    shear = np.array([[2.0, 0.7], [0.3, 1.0]])
    t = np.array([0.3, 0.5, 0.8, 1.3, 2.0, 2.9, 4.1]) * random.uniform(0.95, 1.05, 7)
    cross = np.append(
        np.outer(eight[:, 0] - 0.4, [1, 0.3]), np.outer(eight[:, 1] - 0.6, [-0.2, 1]), axis=0
    )
    name = "conic_rank"
    return (
        Call(name, (eight,), "eight points"),
        Call(name, (five,), "five points"),
        Call(name, (circle,), "nine points on a circle", exact=(0,)),
        Call(name, (circle.dot(shear) + 1,), "nine points on an oblique ellipse", exact=(0,)),
        Call(name, (np.column_stack([t, 1 / t]),), "seven points on a hyperbola", exact=(0,)),
        Call(name, (cross,), "points on two lines", exact=(0,)),
        Call(name, (in_line(random, 7)[:7],), "seven points on one line", exact=(0,)),
        Call(name, (1e-6 * eight,), "eight points a thousandth of a millimetre apart, in metres"),
        Call(name, (MAP + 10 * eight,), "eight points on a map whose origin is far away"),
    )


CONIC_RANKS = (6, 5, 5, 5, 5, 5, 3, 6, 6)


@law("Theory knows the rank of each of these cases.")
def is_the_known_conic_rank(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the largest difference from the ranks that are known for these points."""
    return max(abs(float(v) - r) for (v,), r in zip(values, CONIC_RANKS, strict=True))


QUESTIONS = (
    Question(
        "04.1", "velocity_matrix", 2, matrix_inputs, matrix_shape, (gives_the_normal_component,)
    ),
    Question("04.2", "velocity_rank", 3, rank_inputs, number, (has_the_known_rank,)),
    Question(
        "04.3",
        "tangent_field",
        2,
        tangent_inputs,
        lambda _: ((6,),),
        (is_tangent,),
        loose,
        up_to_a_factor,
        fingerprint=sizes,
    ),
    Question(
        "04.4",
        "crossing_normals",
        2,
        normals_inputs,
        lambda call: (call.arguments[0].shape,),
        (are_unit_and_perpendicular,),
        normal_form=with_one_sign,
    ),
    Question("04.5", "obvious", 3, obvious_inputs, number, (is_as_constructed,)),
    Question(
        "04.6",
        "star_samples",
        2,
        star_inputs,
        star_shapes,
        (belong_to_the_edges,),
        normal_form=with_one_sign,
    ),
    Question("04.7", "conic_rank", 2, conic_inputs, number, (is_the_known_conic_rank,)),
)
