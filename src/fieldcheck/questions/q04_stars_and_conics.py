"""Questions 04.6 and 04.7, the edges of a star, and points on a conic."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.question import Question, law, relative
from fieldcheck.questions.q03_radial_basis_functions import cloud
from fieldcheck.questions.q04_rank_of_normals import MAP, in_line, number, with_one_sign

# 04.6 and 04.7 Stars and conics


def star_inputs(seed: int) -> tuple[Call, ...]:
    """Return stars of five and of three triangles, and one far from the origin."""
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


@law(
    "Points are in the middle of the edges; normals have the length one and stand at "
    "right angles to the edge."
)
def belong_to_the_edges(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how far points are from the middle of the edges, and normals from unit ones across."""
    worst = 0.0
    for call, (points, normals) in zip(calls, values, strict=True):
        center, ring = call.arguments
        k = len(ring)
        following = ring[np.r_[1:k, 0]]
        twice = np.append(ring + center, ring + following, axis=0)
        edges = np.append(ring - center, ring - following, axis=0)
        across = relative((edges * normals).sum(axis=1), edges)
        worst = max(
            worst,
            relative(2 * points - twice, twice),
            across,
            relative(np.hypot(*normals.T) - 1, 1.0),
        )
    return worst


def conic_inputs(seed: int) -> tuple[Call, ...]:
    """Return points at random, on conics and on lines, near and far, in several units."""
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
    """Return the largest difference from the ranks that theory gives for these points."""
    return max(abs(float(v) - r) for (v,), r in zip(values, CONIC_RANKS, strict=True))


QUESTIONS = (
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
