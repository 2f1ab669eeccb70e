"""Questions of notebook 04 on necessary conditions, on the edges of a star, and on conics."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, integers
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative
from fieldcheck.questions.q03_radial_basis_functions import cloud
from fieldcheck.questions.q04_rank_of_normals import (
    MAP,
    directions,
    number,
    parallel_except,
    towards,
    two_directions,
    with_one_sign,
)


def in_line(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n points on a line across the unit square, and one point off the line."""
    along = (np.arange(n) + random.uniform(0.2, 0.8, n)) / n
    line = np.column_stack([along, 0.1 + 0.4 * along])
    return np.append(line, [[random.uniform(0.1, 0.5), 0.9]], axis=0)


# 04.5 The obvious conditions

BEYOND_ZERO = 9e-9
"""An angle whose half is a product n · m above the tolerance of the text, and which is below 10⁻⁸,
the tolerance of ``np.isclose``.
"""
WITHIN_ZERO = 5e-10
"""An angle whose products n · m are below the tolerance of the text, but not a tenth of it."""


def obvious_inputs(seed: int) -> tuple[Call, ...]:
    """Return samples that satisfy the conditions, and samples that violate them in several ways."""
    random = np.random.default_rng(seed)
    points, line = cloud(random, 7, 2), in_line(random, 5)
    three_in_line = cloud(random, 7, 2)
    three_in_line[2] = 0.3 * three_in_line[0] + 0.7 * three_in_line[1]
    spread = in_triangle(points)
    centre = np.array([0.47, 0.52])
    cases = (
        (points, directions(random, 7), "seven samples"),
        (points, parallel_except(random, 7, ()), "parallel normals"),
        (points, parallel_except(random, 7, (1, 4)), "parallel normals but for two of seven"),
        (points, parallel_except(random, 7, (0, 3)), "parallel normals but for two, one the first"),
        (spread, parallel_except(random, 7, (0, 1, 2)), "parallel normals but for three of seven"),
        (
            three_in_line,
            parallel_except(random, 7, (0, 1, 2)),
            "parallel normals but for three that are on one line",
        ),
        (line, directions(random, 6), "five points on a line and one off it"),
        (line[:5], directions(random, 5), "five points on one line"),
        (points, towards(points, centre), "normals through one point"),
        *(
            (samples, two_directions(random, 7, others, angle), f"normals {directed}, {which}")
            for directed, angle, two in (
                ("along the axes", 0, (5, 6)),
                ("in two directions", 0.6, (0, 6)),
            )
            for samples, others, which in (
                (spread, (1, 3, 5), "by turns"),
                (spread, two, "in one direction only two"),
                (three_in_line, (0, 1, 2), "in one direction three on one line"),
            )
        ),
        (points[:4], directions(random, 4), "four samples"),
        (points[:3], directions(random, 3), "three samples"),
        (5 + spread - centre, directions(random, 7), "seven samples, further away"),
        (line - line[0], directions(random, 6), "a line through the origin and a point off it"),
        (
            spread - spread[3],
            parallel_except(random, 7, (3, 4, 5)),
            "three other normals, one at the origin",
        ),
        (spread, slightly_rotated(random, (0, 1, 2), 1e-5), "three normals at an angle of 10⁻⁵"),
        (
            spread,
            slightly_rotated(random, (1, 3, 5), 1e-5),
            "three other normals at an angle of 10⁻⁵",
        ),
        (
            np.append(line[:4], points[:3], axis=0),
            directions(random, 7),
            "the first four on a line",
        ),
        (
            np.append(line[:5], points[:4], axis=0),
            directions(random, 9),
            "the first five on a line",
        ),
        (
            spread,
            two_directions(random, 7, (1, 2, 3, 4, 6), 0),
            "two horizontal normals, five vertical ones",
        ),
        (spread, two_directions(random, 7, (0, 1, 3, 5, 6), 0), "two other horizontal normals"),
        (
            spread,
            mirrored_directions(random, 7, (1, 3, 5), 0.7),
            "two mirrored directions by turns",
        ),
        (spread, mirrored_directions(random, 7, (0, 1, 2), 1.1), "two other mirrored directions"),
        *(
            (spread, nearly_parallel(random, 7, (2, 5), angle), f"{which} normals up to 10⁻¹¹")
            for angle, which in ((0.0, "horizontal"), (0.5 * np.pi, "vertical"), (2.0, "parallel"))
        ),
        (
            two_bow_ties(random),
            two_directions(random, 8, (4, 5, 6, 7), 0.9),
            "four normals in each of two directions, at the corners of two parallelograms",
        ),
        *(
            (spread, slightly_rotated(random, others, BEYOND_ZERO), f"{which} at angles below 10⁻⁸")
            for others, which in (((0, 1, 2), "three normals"), ((3, 4, 5), "three other normals"))
        ),
    )
    upright, level = line * [0, 1] + [0.3, 0], line * [1, 0] - [0, 0.2]
    upright[5], level[5] = line[5], line[5]
    three_upright, three_level, three_at_two = spread.copy(), spread.copy(), spread.copy()
    three_upright[:3, 0], three_level[:3, 1], three_at_two[1] = (
        spread[0, 0],
        spread[0, 1],
        spread[0],
    )
    constructed = (
        (upright, directions(random, 6), "five points on a vertical line and one off it"),
        (level, directions(random, 6), "five points on a horizontal line and one off it"),
        (
            three_upright,
            parallel_except(random, 7, (0, 1, 2)),
            "parallel normals but for three on a vertical line",
        ),
        (
            three_level,
            parallel_except(random, 7, (0, 1, 2)),
            "parallel normals but for three on a horizontal line",
        ),
        (
            points[[0, *range(7)]],
            directions(random, 8),
            "eight samples, the first two at one point",
        ),
        (spread.repeat(2, axis=0), directions(random, 14), "two samples at each of seven points"),
        (
            three_at_two,
            parallel_except(random, 7, (0, 1, 2)),
            "parallel normals but for three, two of these at one point",
        ),
        (
            spread[:3].repeat(2, axis=0),
            directions(random, 6),
            "two samples at each of three points",
        ),
        (
            np.append(spread, spread, axis=0),
            parallel_except(random, 14, range(7, 14)),
            "parallel normals, and other normals at the same points",
        ),
        (
            np.append(spread, spread, axis=0),
            parallel_except(random, 14, range(7)),
            "seven normals, and parallel normals at the same points",
        ),
        (integers(spread, 9), parallel_except(random, 7, (0, 1, 2)), "seven samples, integers"),
        (
            random.integers(-3, 1, 2) + np.outer([0, 1, 2, 3, 5], random.integers(1, 3, 2)),
            directions(random, 5),
            "five points of integers on one line",
        ),
        (
            spread,
            two_directions(random, 7, (1, 3, 5), 0).astype(int),
            "normals of integers along the axes, by turns",
        ),
        (
            spread,
            two_directions(random, 7, (0, 6), 0).astype(int),
            "normals of integers along the axes, only two of them vertical",
        ),
        *(
            (
                np.append(cloud(random, n, 2), spread[:3], axis=0),
                parallel_except(random, n + 3, range(n, n + 3)),
                f"{number} parallel normals and three others",
            )
            for n, number in ((43, "forty-three"), (103, "103"))
        ),
        (beside_a_line(random, 5), directions(random, 5), "five points up to 10⁻¹¹ from a line"),
        (
            np.append(beside_a_line(random, 3), points[:4], axis=0),
            parallel_except(random, 7, (0, 1, 2)),
            "parallel normals but for three up to 10⁻¹¹ from a line",
        ),
        (1e-5 * spread, directions(random, 7), "seven samples in a square of 10⁻⁵"),
        (
            2e-6 * (spread - centre),
            parallel_except(random, 7, (0, 1, 2)),
            "parallel normals but for three in a square of 10⁻⁶",
        ),
        *(
            (spread, slightly_rotated(random, others, WITHIN_ZERO), f"{which} at 5 · 10⁻¹⁰")
            for others, which in (((0, 1, 2), "three normals"), ((3, 4, 5), "three other normals"))
        ),
        *(
            (
                np.append(beside_a_line(random, 3, 1e-5), spread[:n], axis=0),
                slightly_rotated(random, (0, 1, 2), 1e-5)[: n + 3],
                f"{n} parallel normals and three at 10⁻⁵, these 10⁻⁵ from a line",
            )
            for n in (3, 4)
        ),
        (beside_a_line(random, 5, 3e-7), directions(random, 5), "five points 10⁻⁷ from a line"),
        (
            np.append(beside_a_line(random, 3, 3e-7), points[:4], axis=0),
            parallel_except(random, 7, (0, 1, 2)),
            "parallel normals but for three 10⁻⁷ from a line",
        ),
        (
            1e-3 * beside_a_line(random, 5, 1e-8),
            directions(random, 5),
            "five points at distances of 10⁻³, up to 10⁻¹¹ from a line",
        ),
        (
            np.append(1e-4 * beside_a_line(random, 3, 1e-7), points[:4], axis=0),
            parallel_except(random, 7, (0, 1, 2)),
            "parallel normals but for three at distances of 10⁻⁴, up to 10⁻¹¹ from a line",
        ),
    )
    return (
        *(Call("obvious", (p, n), case) for p, n, case in cases),
        *(Call("obvious", (p, n), case, exact=(0,)) for p, n, case in constructed),
    )


HOLDS = (
    *(1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 1, 0, 0, 1),
    *(0, 1, 0, 1, 1, 1, 1, 1, 0, 0, 1, 1, 0, 0, 0, 1, 1, 1),
    *(0, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 0, 1, 1),
    *(0, 0, 1, 1, 0, 0, 1, 1, 1, 1, 0, 0),
)


def beside_a_line(random: np.random.Generator, n: int, most: float = 1e-11) -> np.ndarray:
    """Return points at distances of up to 10⁻¹¹ or more from a line, on both sides."""
    along = directions(random, 1)[0]
    across = most * random.choice([-1, 1], n) * random.uniform(0.5, 1, n)
    return np.outer(np.arange(n) + random.random(n) / 2, along) + np.outer(
        across, [-along[1], along[0]]
    )


def nearly_parallel(
    random: np.random.Generator, n: int, others: Sequence[int], angle: float
) -> np.ndarray:
    """Return normals that are parallel up to the sign and to 10⁻¹¹, with some exceptions."""
    small = 1e-11 * random.choice([-1, 1], n) * random.uniform(0.5, 1, n)
    angles = angle + small + np.isin(np.arange(n), others) * random.uniform(0.5, 1, n)
    return random.choice([-1, 1], (n, 1)) * np.column_stack([np.cos(angles), np.sin(angles)])


def mirrored_directions(
    random: np.random.Generator, n: int, others: Sequence[int], angle: float
) -> np.ndarray:
    """Return normals at an angle to the first axis, the others on its other side."""
    side = np.where(np.isin(np.arange(n), others), -1.0, 1.0)
    normals = np.column_stack([np.full(n, np.cos(angle)), side * np.sin(angle)])
    return random.choice([-1, 1], (n, 1)) * normals


def two_bow_ties(random: np.random.Generator) -> np.ndarray:
    """Return the corners of two parallelograms, in an order in which their sides cross."""
    corners = np.array([[0, 0], [1, 1], [1, 0], [0, 1]])
    one, two = np.eye(2) + random.uniform(-0.3, 0.3, (2, 2, 2))
    return np.append(corners.dot(one), corners.dot(two) + random.uniform(0.3, 0.6, 2), axis=0)


def slightly_rotated(random: np.random.Generator, others: Sequence[int], most: float) -> np.ndarray:
    """Return seven normals of which some differ from the direction of the rest by small angles."""
    small = most * random.uniform(0.5, 1, 7) * np.isin(np.arange(7), others)
    angles = random.uniform(0.2, 1.2) + small
    return np.column_stack([np.cos(angles), np.sin(angles)])


def in_triangle(points: np.ndarray) -> np.ndarray:
    """Return points whose even and odd members are each far from collinear."""
    spread = points.copy()
    spread[:3] = points[:3] / 10 + np.array([[0, 0], [0.9, 0.1], [0.2, 0.9]])
    spread[3:6] = points[3:6] / 10 + np.array([[0.1, 0.5], [0.8, 0.8], [0.6, 0.1]])
    return spread


@law(
    "The answer must be True if and only if (4.5) holds, where products n · m and distances from a "
    "line count as zero if they are below 10⁻⁹."
)
def is_as_constructed(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return one if the judgement on a case differs from its construction."""
    return max(abs(float(v) - h) for (v,), h in zip(values, HOLDS, strict=True))


# 04.6 and 04.7 Stars and conics


def star_inputs(seed: int) -> tuple[Call, ...]:
    """Return stars of three to nine triangles, one of them far from the origin."""
    random = np.random.default_rng(seed)
    calls = []

    def rays(k: int) -> np.ndarray:
        angles = 2 * np.pi * (np.arange(k) + random.uniform(-0.2, 0.2, k)) / k
        return random.uniform(0.5, 1.5, (k, 1)) * np.column_stack([np.cos(angles), np.sin(angles)])

    for k, center, case in (
        (5, (0.1, -0.2), "five triangles"),
        (3, (0, 0), "three triangles around the origin"),
        (6, (4, 7), "six triangles"),
        (7, (-0.3, 0.5), "seven triangles"),
        (9, (1, 2), "nine triangles"),
    ):
        calls.append(Call("star_samples", (np.array(center, dtype=float), rays(k) + center), case))
    vertex, width, height = random.uniform(-2, 2, 2), *random.uniform(0.5, 1.5, 2)
    steps = [[1, 0], [1, 1], [0, 1], [-1, 0], [-1, -1], [0, -1]]
    at_right_angles = vertex + steps * np.array([width, height])
    calls.append(Call("star_samples", (vertex, at_right_angles), "a vertex of a regular grid"))
    tiny = 1e-15 * calls[0].arguments[1]
    calls.append(Call("star_samples", (1e-15 * calls[0].arguments[0], tiny), "a star of 10⁻¹⁵"))
    for call in (*calls[2:4], calls[5]):
        whole = tuple(integers(argument) for argument in call.arguments)
        calls.append(Call("star_samples", whole, f"{call.case}, integers"))
    for call in (calls[0], calls[3]):
        away = tuple(1e4 * np.array([1, -1]) + argument for argument in call.arguments)
        calls.append(Call("star_samples", away, f"{call.case}, 10⁴ away", exact=(0, 1)))
    for size, words in ((1e-7, "10⁻⁷"), (1e6, "10⁶"), (1e8, "10⁸")):
        scaled = tuple(size * argument for argument in calls[3].arguments)
        calls.append(Call("star_samples", scaled, f"a star of {words}"))
    for k, case in ((43, "forty-three triangles"), (67, "sixty-seven triangles")):
        middle = random.uniform(-1, 1, 2)
        calls.append(Call("star_samples", (middle, rays(k) + middle), case))
    return tuple(calls)


def star_shapes(call: Call) -> tuple[tuple[int, ...], ...]:
    k = len(call.arguments[1])
    return ((2 * k, 2), (2 * k, 2))


@law_of_each(
    "Each point must be the midpoint of its edge. Each normal must have length one and be "
    "perpendicular to its edge."
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
    """Return random points, and points on conics and lines, near and far, in several units.

    Points on conics come before those nearly on one, where the tolerance matters.
    """
    random = np.random.default_rng(seed)
    eight, five = cloud(random, 8, 2), cloud(random, 5, 2)
    angles = 2 * np.pi * (np.arange(9) + random.uniform(-0.3, 0.3, 9)) / 9
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    angles[[1, 8]] = angles[[0, 7]] + 1e-5  # so their distance is no measure of the size
    in_pairs = np.column_stack([np.cos(angles), np.sin(angles)])
    shear = np.array([[2.0, 0.7], [0.3, 1.0]])
    t = np.array([0.3, 0.5, 0.8, 1.3, 2.0, 2.9, 4.1]) * random.uniform(0.95, 1.05, 7)
    cross = np.append(
        np.outer(eight[:, 0] - 0.4, [1, 0.3]), np.outer(eight[:, 1] - 0.6, [-0.2, 1]), axis=0
    )
    grid = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1], [-1, 0], [-1, -1], [0, -1]])
    bent = np.column_stack([circle[:, 0], circle[:, 1] + 3e-6 * circle[:, 0] ** 3])
    even = 2 * np.pi * (np.arange(9) + random.uniform(-0.1, 0.1, 9)) / 9
    near = np.column_stack([np.cos(even), np.sin(even) + 1e-7 * np.cos(even) ** 3])
    almost = np.column_stack([np.cos(even), np.sin(even) + 1e-9 * np.cos(even) ** 3])
    oblique = np.column_stack([np.cos(even), np.sin(even) + 2e-9 * np.cos(even) ** 3]).dot(shear)
    general = (
        (eight, "eight points"),
        (five, "five points"),
        (1e-6 * eight, "eight points in a square of 10⁻⁶"),
        (1e-15 * cloud(random, 7, 2), "seven points in a square of 10⁻¹⁵"),
        (1e-15 * cloud(random, 9, 2), "nine points in a square of 10⁻¹⁵"),
        (1e6 * cloud(random, 9, 2), "nine points in a square of 10⁶"),
        (MAP + 10 * eight, "eight points, 10⁷ away"),
        (MAP[::-1] + cloud(random, 9, 2), "nine points, 10⁷ away"),
        (bent, "nine points close to a circle"),
        (bent.dot(shear), "nine points close to an ellipse"),
        (almost, "nine points within 10⁻⁹ of a circle"),
        (oblique, "nine points within 2·10⁻⁹ of an ellipse"),
        (near, "nine points within 10⁻⁷ of a circle"),
        (near.dot(shear), "nine points within 10⁻⁷ of an ellipse"),
    )
    constructed = (
        (in_pairs, "nine points on a circle"),
        (in_pairs.dot(shear) + 1, "nine points on an oblique ellipse"),
        (np.column_stack([t, 1 / t]), "seven points on a hyperbola"),
        (cross, "points on two lines"),
        (in_line(random, 7)[:7], "seven points on one line"),
        (grid, "a vertex of a regular grid with six neighbours"),
        (3 + np.append(grid, [[-1, 1], [1, -1]], axis=0), "a vertex with eight neighbours"),
        (np.append(circle, [[0.2, 0.1], [-0.5, 0.3]], axis=0), "nine points on a circle, two not"),
        (
            np.append(circle, [[0.4, -0.1]], axis=0).dot(shear),
            "nine points on an ellipse, one inside",
        ),
        (in_line(random, 3)[:3], "three points on one line"),
        (cross_along_axes(random, 2), "nine points on a cross along the axes"),
        (3 + cross_along_axes(random, 2), "another cross along the axes"),
        (cross_along_axes(random, 1), "a vertex with four neighbours along the axes"),
        (in_line(random, 4)[:4], "four points on one line"),
        (in_line(random, 5)[:5], "five points on one line"),
        (in_line(random, 4), "four points on a line and one off it"),
        (integers(eight), "eight points, integers"),
        (cross_along_axes(random, 2).astype(int), "a cross of integers along the axes"),
        (on_a_circle_but_the_last(random, 43), "forty-three points, all but the last on a circle"),
        (on_a_circle_but_the_last(random, 101), "101 points, all but the last on a circle"),
        (on_a_circle_but_the_last(random, 9), "nine points, all but the last on a circle"),
    )
    of_points = tuple(Call("conic_rank", (points,), case) for points, case in general)
    on = tuple(Call("conic_rank", (points,), case, exact=(0,)) for points, case in constructed)
    return of_points[:8] + on[:5] + of_points[8:] + on[5:]


CONIC_RANKS = (
    *(6, 5, 6, 6, 6, 6, 6, 6, 5, 5, 5, 5, 3),
    *(6, 6, 5, 5, 6, 6, 6, 6, 6, 6, 3, 5, 5, 5, 3, 3, 4, 6, 5, 6, 6, 6),
)


def on_a_circle_but_the_last(random: np.random.Generator, n: int) -> np.ndarray:
    """Return points on a circle, and as the last one a point inside."""
    angles = 2 * np.pi * random.permutation(n) / n
    radii = np.where(np.arange(n) < n - 1, 1.0, random.uniform(0.3, 0.6))
    return radii[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])


def cross_along_axes(random: np.random.Generator, n: int) -> np.ndarray:
    """Return the origin and 4n points on the axes, whose mean is exactly the origin."""
    along = random.permutation(9)[: 2 * n].reshape(n, 2) + 1.0
    arms = [[[x, 0], [-x, 0], [0, y], [0, -y]] for x, y in along]
    return np.append(np.concatenate(arms), [[0, 0]], axis=0)


@law("The rank must be that of the matrix on the right-hand side of (4.6).")
def is_the_known_conic_rank(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the largest difference from the ranks that are known for these points."""
    return max(abs(float(v) - r) for (v,), r in zip(values, CONIC_RANKS, strict=True))


QUESTIONS = (
    Question("04.5", "obvious", 3, obvious_inputs, number, (is_as_constructed,)),
    Question(
        "04.6",
        "star_samples",
        2,
        also_at_zero(star_inputs, points=(0, 1)),
        star_shapes,
        (belong_to_the_edges,),
        normal_form=with_one_sign,
    ),
    Question("04.7", "conic_rank", 2, conic_inputs, number, (is_the_known_conic_rank,)),
)
