"""Questions of notebook 04 on the rank of a velocity system."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.inputs.zeros import also_at_zero
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


def along_axes(random: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Return n unit vectors of integers along the axes, each axis in turn, in random order."""
    return random.choice([-1, 1], (n, 1)) * np.eye(d, dtype=int)[random.permutation(n) % d]


def two_directions(
    random: np.random.Generator, n: int, others: Sequence[int], angle: float
) -> np.ndarray:
    """Return normals along the axes, turned by an angle; the others along the second axis."""
    frame = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    second = np.isin(np.arange(n), others).astype(int)
    return random.choice([-1, 1], (n, 1)) * frame[second]


def towards(points: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return unit vectors from a given point to the points."""
    offset = points - place
    return offset / np.hypot(*offset.T)[:, None]


# 04.1 The matrix


def matrix_inputs(seed: int) -> tuple[Call, ...]:
    """Return samples in the plane and in space, also with vectors that are not unit vectors."""
    random = np.random.default_rng(seed)
    plane, space = cloud(random, 7, 2), cloud(random, 5, 3)
    on_the_axes = plane * np.where(np.arange(7)[:, None] == [1, 4], 0, 1)
    at_the_origin = space * np.where(np.arange(5) == 2, 0, 1)[:, None]
    again = [3, 0, 5, 0, 2, 5]
    return calls_of(
        "velocity_matrix",
        ((plane, directions(random, 7)), "seven samples in the plane"),
        ((space - 0.3, sphere(random, 5)), "five samples in space"),
        (
            (plane[:3] + 1, random.normal(size=(3, 2))),
            "three samples with other vectors for normals",
        ),
        ((1e4 * plane - 3e3, directions(random, 7)), "seven samples in a square of 10⁴"),
        ((1e-6 * space, sphere(random, 5)), "five samples in a cube of 10⁻⁶"),
        ((integers(plane), directions(random, 7)), "seven samples in the plane, integers"),
        ((integers(space), sphere(random, 5)), "five samples in space, integers"),
        ((plane, along_axes(random, 7, 2)), "seven samples, normals of integers along the axes"),
        (
            (space, along_axes(random, 5, 3)),
            "five samples in space, normals of integers along the axes",
        ),
        ((space[:1], sphere(random, 1)), "one sample in space"),
        ((on_the_axes, directions(random, 7)), "seven samples, one on each axis"),
        ((at_the_origin, sphere(random, 5)), "five samples in space, one at the origin"),
        ((cloud(random, 67, 2), directions(random, 67)), "sixty-seven samples in the plane"),
        ((integers(plane), along_axes(random, 7, 2)), "seven samples, points and normals integers"),
        ((plane[again], directions(random, 7)[again]), "four samples, two of them twice"),
        ((space[[1, 0, 1]], sphere(random, 3)[[1, 0, 1]]), "two samples in space, one twice"),
    )


def matrix_shape(call: Call) -> tuple[tuple[int, ...], ...]:
    n, d = call.arguments[0].shape
    return ((n, d + d**2),)


@law_of_each("B' times the coefficients of a flow must be its normal velocity at each sample.")
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


def number(_: Call) -> tuple[tuple[int, ...], ...]:
    return ((),)


def nearly_towards(random: np.random.Generator, points: np.ndarray, angle: float) -> np.ndarray:
    """Return normals that miss one point by small angles."""
    n = towards(points, np.array([0.47, 0.52]))
    return n + angle * random.uniform(0.5, 1, (len(n), 1)) * n[:, ::-1] * [-1, 1]


def rank_inputs(seed: int) -> tuple[Call, ...]:
    """Return samples of known rank, near and far from the origin, in large and small units.

    Normals that meet in a point come before those that nearly do, where the tolerance matters.
    """
    random = np.random.default_rng(seed)
    points, nine = cloud(random, 8, 2), cloud(random, 9, 2)
    points[0] = points[1:].mean(axis=0)  # so its distance from the mean is no measure of the size
    flat = sphere(random, 14)
    flat[:, 2] = 0
    space = cloud(random, 14, 3)
    general = (
        (points, directions(random, 8), "eight samples in the plane"),
        (points[:5], directions(random, 5), "five samples"),
        (1e-15 * nine, directions(random, 9), "nine samples in a square of 10⁻¹⁵"),
        (1e10 * nine, directions(random, 9), "nine samples in a square of 10¹⁰"),
        (MAP + 0.01 * nine, directions(random, 9), "nine samples, 10⁷ away"),
        (space, sphere(random, 14), "fourteen samples in space"),
        (
            np.append(MAP, 2e6) + 0.01 * space,
            sphere(random, 14),
            "fourteen samples in space, 10⁷ away",
        ),
        (points, nearly_towards(random, points, 3e-6), "normals that nearly meet in a point"),
        (nine, nearly_towards(random, nine, 2e-6), "normals that very nearly meet in a point"),
        (1e-15 * space, sphere(random, 14), "fourteen samples in a cube of 10⁻¹⁵"),
        (points, nearly_towards(random, points, 1e-10), "normals within 10⁻¹⁰ of meeting"),
        (
            1e5 * nine,
            nearly_towards(random, nine, 1e-10),
            "nine normals within 10⁻¹⁰ of meeting, in a square of 10⁵",
        ),
        (
            points * [1, 1e-12],
            directions(random, 8),
            "eight samples within 10⁻¹² of a horizontal line",
        ),
        (
            1e3 * points * [1e-12, 1],
            directions(random, 8),
            "eight samples, very nearly on a vertical line",
        ),
        (
            cloud(random, 12, 2),
            parallel_except(random, 12, range(6, 12)),
            "twelve samples, the first six with parallel normals",
        ),
        (
            np.append(points * [0, 1], nine, axis=0),
            directions(random, 17),
            "seventeen samples, the first eight on a line",
        ),
        (points, nearly_towards(random, points, 4e-7), "normals within 10⁻⁶ of meeting"),
        (nine, nearly_towards(random, nine, 4e-7), "nine normals within 10⁻⁶ of meeting"),
    )
    constructed = (
        (points * [0, 1] + [0.3, 0], directions(random, 8), "eight samples on a vertical line"),
        (points * [1, 0] - [0, 0.2], directions(random, 8), "eight samples on a horizontal line"),
        (points, parallel_except(random, 8, ()), "eight samples with parallel normals"),
        (points, parallel_except(random, 8, (2, 5)), "parallel normals but for two of eight"),
        (points, towards(points, np.array([0.47, 0.52])), "eight normals through one point"),
        (
            space,
            flat / np.sqrt((flat * flat).sum(axis=1))[:, None],
            "fourteen samples in space with horizontal normals",
        ),
        (points[:3], parallel_except(random, 3, ()), "three samples with parallel normals"),
        (points[:5], parallel_except(random, 5, ()), "five samples with parallel normals"),
        (points[:4] * [0, 1], directions(random, 4), "four samples on a vertical line"),
        (points.repeat(2, axis=0)[:8], directions(random, 8), "two samples at each of four points"),
        (
            nine[[0, 0, 0, 1, 2, 3, 4]],
            directions(random, 7),
            "seven samples, the first three at one point",
        ),
        (nine, along_axes(random, 9, 2), "nine samples, normals of integers along the axes"),
        (
            space,
            along_axes(random, 14, 3),
            "fourteen samples in space, normals of integers along the axes",
        ),
        (integers(nine), directions(random, 9), "nine samples, integers"),
        (integers(space), sphere(random, 14), "fourteen samples in space, integers"),
        *(
            (cloud(random, n, 2), parallel_except(random, n, range(n - 3, n)), case)
            for n, case in (
                (43, "forty-three samples, parallel normals but for the last three"),
                (101, "101 samples, parallel normals but for the last three"),
            )
        ),
        (nine[[*range(8), 0]], directions(random, 9), "nine samples, first and last at one point"),
        (
            space[[*range(13), 0]],
            sphere(random, 14),
            "fourteen samples in space, first and last at one point",
        ),
        *(
            (
                size * nine[[*first, 2, 3, 4, 5, 6, *last]],
                normals if full else parallel_except(random, 9, (2, 5)),
                f"nine samples in a square of {words}, {which} two at one point",
            )
            for normals in (directions(random, 9),)
            for size, words, full in ((1e-10, "10⁻¹⁰", True), (1e10, "10¹⁰", False))
            for first, last, which in (((0, 0), (7, 8), "the first"), ((0, 1), (8, 8), "the last"))
        ),
    )
    near = tuple(Call("velocity_rank", (p, n), case) for p, n, case in general)
    made = tuple(Call("velocity_rank", (p, n), case, exact=(0, 1)) for p, n, case in constructed)
    return near[:7] + made[:5] + near[7:] + made[5:]


RANKS = (
    *(6, 5, 6, 6, 6, 12, 12, 4, 4, 3, 5, 5),
    *(6, 6, 12, 5, 5, 4, 4, 6, 6, 6, 6, 8, 3, 3, 4, 6, 6, 6, 12),
    *(6, 12, 6, 6, 6, 12, 6, 6, 5, 5),
)


@law("The rank must be the number of linearly independent equations.")
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
        ((nine, towards(nine, place)), "nine normals through one point"),
        ((nine + 1, parallel_except(random, 9, (3, 6))), "parallel normals but for two of nine"),
        ((cloud(random, 5, 2), directions(random, 5)), "five samples"),
        ((cloud(random, 5, 2) - 2, directions(random, 5)), "five samples elsewhere"),
        (
            (nine, across(towards(nine, np.array([0.0, random.uniform(1.2, 1.5)])))),
            "an expansion from a point of the second axis",
        ),
        (
            (nine, towards(nine, np.array([0.0, random.uniform(-0.5, -0.2)]))),
            "a rotation about a point of the second axis",
        ),
        (
            (nine, across(towards(nine, np.array([random.uniform(1.2, 1.5), 0.0])))),
            "an expansion from a point of the first axis",
        ),
        *(
            ((nine, towards(nine, random.uniform(*part) * np.ones(2))), f"a rotation about {where}")
            for part, where in (
                ((1.2, 1.5), "a point of the diagonal"),
                ((-0.5, -0.2), "another point of the diagonal"),
            )
        ),
        (
            (nine, two_directions(random, 9, (2, 6), 0).astype(int)),
            "horizontal normals of integers but for two of nine",
        ),
        (
            (twelve, two_directions(random, 12, (4, 7), 0)[:, ::-1].astype(int)),
            "vertical normals of integers but for two of twelve",
        ),
        ((integers(nine[:5], 30), directions(random, 5)), "five samples, integers"),
        ((integers(twelve[:5], 30), directions(random, 5)), "five other samples, integers"),
        *(
            (
                (cloud(random, n, 2), parallel_except(random, n, (n - 2, n - 1))),
                f"{number} samples, parallel normals but for the last two",
            )
            for n, number in ((43, "forty-three"), (67, "sixty-seven"))
        ),
        ((nine + 1e3, towards(nine, place)), "nine normals through one point, 10³ away"),
        ((twelve - 1e3, towards(twelve, place)), "twelve normals through one point, 10³ away"),
    )


def across(vectors: np.ndarray) -> np.ndarray:
    """Return vectors rotated by a right angle."""
    return vectors[:, ::-1] * [-1, 1]


@law_of_each(
    "The flow must not be zero, and its normal velocity must be zero at each sample.",
    amount="B'c has an entry of {:.2g} times the largest coefficient",
)
def is_tangent(call: Call, values: Values) -> float:
    """Return the largest normal velocity relative to the size of the coefficients."""
    (c,) = values
    points, normals = call.arguments
    u = c[:2] + points.dot(c[2:].reshape(2, 2))
    return max(float(not c.any()), relative((u * normals).sum(axis=1), c))


def up_to_a_factor(_: Call, values: Values) -> Values:
    """Return coefficients normalized to length one and a fixed sign."""
    (c,) = values
    size = float(np.sqrt(c.dot(c))) or 1.0
    return (c / (size if c.dot(np.sin(np.arange(1.0, 1 + c.size))) >= 0 else -size),)


def normals_inputs(seed: int) -> tuple[Call, ...]:
    """Return flows and points.

    The coordinates and the components of the flows have both signs.
    """
    random = np.random.default_rng(seed)
    seven, five = cloud(random, 7, 2), cloud(random, 5, 2)
    down, up = random.uniform(1, 4, (2, 2)) * [[1, -1], [-1, 1]]
    uneven = np.array([1, 1e-9, 1, 1e-12, 1e3])
    return calls_of(
        "crossing_normals",
        ((seven - [1.1, 0.0], flow(random)), "seven points"),
        ((five - 0.5, np.append(down, np.zeros(4))), "a constant flow"),
        ((five - 0.5, np.append(up, np.zeros(4))), "another constant flow"),
        ((five - [1.1, 3.0], 100 * flow(random)), "a fast flow"),
        ((seven - [1.1, 0.0], 1e-18 * flow(random)), "a very slow flow"),
        ((five - 0.5, 1e-8 * np.append(up, np.zeros(4))), "a slow constant flow"),
        ((five, np.array([1e-12, 0, 0, 0, 0, 0])), "a very slow flow along the first axis"),
        ((five, np.array([0, -1e-13, 0, 0, 0, 0])), "a very slow flow along the second axis"),
        ((five, np.array([2.0, 0, 0, 0, 0, 0])), "a constant flow along the first axis"),
        ((seven, np.array([-0.5, 0, 0, 0, -1.5, 0])), "a shear flow along the first axis"),
        ((five, np.array([0, -3.0, 0, 0, 0, 0])), "a constant flow along the second axis"),
        ((seven, np.array([0, 0.4, 0, 2.0, 0, 0])), "a shear flow along the second axis"),
        ((seven - [1.1, 0.0], np.array([0, 0, 2.0, 0, 0, 2.0])), "an expansion from the origin"),
        ((five - 0.5, np.array([0, 0, -0.5, 0, 0, -0.5])), "a contraction to the origin"),
        ((integers(seven - [1.1, 0.0]), flow(random)), "seven points, integers"),
        ((integers(five - 0.5), random.integers(1, 9, 6)), "points and coefficients, integers"),
        ((five - [1.1, 3.0], 1e-15 * flow(random)), "another very slow flow"),
        ((seven[:1] - [1.1, 0.0], flow(random)), "one point"),
        ((integers(five[:1] - 0.5), flow(random)), "one point, integers"),
        ((seven, random.integers(1, 9, 6)), "seven points, coefficients of integers"),
        ((cloud(random, 67, 2) - [1.1, 0.0], flow(random)), "sixty-seven points"),
        (
            (
                uneven[:, None] * five,
                np.append(np.zeros(2), random.uniform(1, 2, 4) * [0, 1, -1, 0]),
            ),
            "points near the centre of a vortex",
        ),
        (
            (uneven[:, None] * seven[:5], np.append(np.zeros(2), random.uniform(-2, -1, 4))),
            "points near a point at rest",
        ),
    )


@law_of_each("Each normal must have length one and be perpendicular to the flow.")
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


def sizes(call: Call, values: Values) -> Values:
    """Return the absolute values of the coefficients, normalized to length one.

    A misconception may combine entries of several singular vectors, whose signs are arbitrary.
    """
    (c,) = up_to_a_factor(call, values)
    return (np.abs(c),)


def loose(_: Call) -> float:
    """Return the rounding error of null vectors of a matrix whose gap is not small."""
    return 1e-8


QUESTIONS = (
    Question(
        "04.1",
        "velocity_matrix",
        2,
        also_at_zero(matrix_inputs, points=(0,)),
        matrix_shape,
        (gives_the_normal_component,),
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
        also_at_zero(normals_inputs, points=(0,)),
        lambda call: (call.arguments[0].shape,),
        (are_unit_and_perpendicular,),
        normal_form=with_one_sign,
    ),
)
