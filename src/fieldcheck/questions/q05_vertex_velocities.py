"""Questions 05.6 to 05.9, velocities at the vertices of a triangle mesh."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.question import Question, law, relative
from fieldcheck.questions.q05_edges import directions, mesh, sides

FITTED = 1e-8
"""What rounding explains where a system with a condition of some hundreds is solved."""

# 05.6 The ring


def ring_inputs(seed: int) -> tuple[Call, ...]:
    """Return one and two rings of the vertex with the most edges, and of one with the fewest."""
    random = np.random.default_rng(seed)
    triangles = mesh(random, 4, 4)[1]
    edges = sides(triangles, random)
    count = np.bincount(triangles.ravel())
    new = neighbours_of_three(triangles)
    lonely = int(count.argmin())
    return (
        Call("ring", (triangles, edges, new, 1), "one ring of a vertex inside"),
        Call("ring", (triangles, edges, new, 2), "two rings of a vertex inside"),
        Call("ring", (triangles, edges, lonely, 1), "one ring of a corner"),
        Call("ring", (triangles, edges, lonely, 3), "three rings of a corner"),
    )


def neighbours_of_three(triangles: np.ndarray) -> int:
    """Return a vertex beside one that has three triangles inside: two of its neighbours are
    joined.
    """
    for t in triangles:
        for middle in t:
            star = np.array([u for u in triangles if middle in u])
            if len(star) == 3 and len(np.unique(star)) == 4:
                return int(min(set(star.ravel().tolist()) - {int(middle)}))
    raise ValueError("no vertex of the mesh has three triangles around it")


@law("Every edge that ends in the vertex must be in its ring.")
def holds_the_spokes(calls: Sequence[Call], values: Sequence[Values]) -> float:
    missed = [
        1 - near[[c.arguments[2] in pair for pair in c.arguments[1]]].min()
        for c, (near,) in zip(calls, values, strict=True)
    ]
    return float(np.abs(missed).max())


@law("The edges are those of whole triangles, so at each end of one of them another must end.")
def made_of_triangles(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the part of the ends of chosen edges at which no other chosen edge ends."""
    worst = 0.0
    for call, (near,) in zip(calls, values, strict=True):
        ends = np.bincount(call.arguments[1][near > 0.5].ravel())
        worst = max(worst, float(np.mean(ends[ends > 0] < 2)) if ends.any() else 1.0)
    return worst


@law("More rings must keep all edges of fewer, and add some.")
def grows(calls: Sequence[Call], values: Sequence[Values]) -> float:
    lost = [(values[k][0] > values[k + 1][0]).mean() for k in (0, 2)]
    gained = [(values[k + 1][0] > values[k][0]).mean() for k in (0, 2)]
    return float(max(*lost, *(g == 0 for g in gained)))


# 05.7 and 05.8 The system, and the velocity at one place


def samples(random: np.random.Generator, number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return midpoints around a place, normals in all directions, and the place."""
    angle = 2 * np.pi * (np.arange(number) + random.uniform(-0.2, 0.2, number)) / number
    radius = np.where(np.arange(number) % 2, 1.0, 0.5) + random.uniform(-0.1, 0.1, number)
    turned = angle + 2 * np.pi * np.arange(number) / 3 + random.uniform(-0.2, 0.2, number)
    x = random.uniform(1, 2, 2)
    return x + radius[:, np.newaxis] * directions(angle), directions(turned), x


def system_inputs(seed: int) -> tuple[Call, ...]:
    """Return samples, the same moved together with the place, and few samples."""
    random = np.random.default_rng(seed)
    p, n, x = samples(random, 9)
    few = samples(random, 4)
    return (
        Call("system", (p, n, x), "nine samples"),
        Call("system", (p + 5.0, n, x + 5.0), "the same samples and the vertex, moved together"),
        Call("system", few, "four samples"),
    )


@law("Bʹ times the coefficients of a field must be its normal velocities at the midpoints.")
def gives_normal_velocities(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how far Bʹ of a field is from its normal velocities: the field (2 + 3 y₂, −1 + y₁ +
    4 y₂).
    """
    worst = 0.0
    for call, (b,) in zip(calls, values, strict=True):
        p, n, x = call.arguments
        first, second = (p - x).T
        told = n[:, 0] * (2 + 3 * second) + n[:, 1] * (first + 4 * second - 1)
        worst = max(worst, relative(b @ [2, -1, 0, 1, 3, 4] - told, told))
    return worst


@law("Moving the edges together with the vertex must change nothing.")
def sees_only_differences(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[1][0] - values[0][0], values[0][0])


def linear_flow(p: np.ndarray) -> np.ndarray:
    """Return the velocities of a field that turns, stretches and drifts."""
    return p @ np.array([[0.5, 2.0], [-1.0, 1.0]]) + np.array([1.0, -3.0])


def velocity_inputs(seed: int) -> tuple[Call, ...]:
    """Return data at random; with an affine field on top; moved; other normals and weights."""
    random = np.random.default_rng(seed)
    p, n, x = samples(random, 12)
    v, w = random.normal(size=12), random.uniform(0.4, 2.5, 12)
    flips = np.where(np.arange(12) % 3, 1.0, -1.0)
    more = np.einsum("ak,ak->a", linear_flow(p), n)
    shift = np.array([-4.0, 3.0])
    other = samples(random, 10)
    return (
        Call("velocity", (p, n, v, x, w), "twelve edges with velocities at random"),
        Call(
            "velocity",
            (p, n, v + more, x, w),
            "the same plus the normal velocities of an affine field",
        ),
        Call("velocity", (p + shift, n, v, x + shift, w), "the same edges, moved with the vertex"),
        Call(
            "velocity",
            (p, flips[:, np.newaxis] * n, flips * v, x, w),
            "the same, some normals reversed",
        ),
        Call(
            "velocity",
            (*other[:2], random.normal(size=10), other[2], np.ones(10)),
            "ten edges of equal weight",
        ),
    )


@law(
    "An affine field is one of those that are fitted: adding its normal velocities to "
    "the data must add its value at the vertex.",
    FITTED,
)
def returns_affine_fields(calls: Sequence[Call], values: Sequence[Values]) -> float:
    told = linear_flow(calls[0].arguments[3])
    return relative(values[1][0] - values[0][0] - told, np.abs(values[1][0]).max() + 1)


@law("Moving the edges together with the vertex must change nothing.", FITTED)
def moves_along(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[2][0] - values[0][0], np.abs(values[0][0]).max() + 1)


@law("Reversing a normal together with its normal velocity must change nothing.", FITTED)
def side_of_the_normal(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[3][0] - values[0][0], np.abs(values[0][0]).max() + 1)


# 05.9 The ranks


def ranks_inputs(seed: int) -> tuple[Call, ...]:
    """Return a mesh with one ring and with two, far from the origin, and in small units."""
    random = np.random.default_rng(seed)
    points, triangles = mesh(random, 4, 4)
    return (
        Call("ranks", (points, triangles, 1), "one ring"),
        Call("ranks", (points, triangles, 2), "two rings"),
        Call("ranks", (points + 1000.0, triangles, 1), "the same mesh far from the origin"),
        Call("ranks", (1e-7 * points, triangles, 1), "the same mesh in another unit of length"),
    )


@law(
    "A ring has three edges at least, of one triangle, and Bʹ has six columns: the "
    "rank must lie between three and six."
)
def rank_between(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return float(max(np.any((r < 3) | (r > 6)) for (r,) in values))


@law(
    "A rank must depend on the shape of the mesh only, not on where it lies nor on "
    "the unit of length."
)
def rank_of_the_shape(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return float(max(np.abs(values[k][0] - values[0][0]).max() for k in (2, 3)))


@law("A second ring only adds edges: no rank may fall, and some must grow.")
def rank_grows(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return float(max(np.any(values[1][0] < values[0][0]), np.all(values[1][0] == values[0][0])))


QUESTIONS = (
    Question(
        "05.6",
        "ring",
        3,
        ring_inputs,
        lambda call: ((len(call.arguments[1]),),),
        (holds_the_spokes, made_of_triangles, grows),
    ),
    Question(
        "05.7",
        "system",
        3,
        system_inputs,
        lambda call: ((len(call.arguments[0]), 6),),
        (gives_normal_velocities, sees_only_differences),
    ),
    Question(
        "05.8",
        "velocity",
        4,
        velocity_inputs,
        lambda _: ((2,),),
        (returns_affine_fields, moves_along, side_of_the_normal),
        lambda _: FITTED,
    ),
    Question(
        "05.9",
        "ranks",
        3,
        ranks_inputs,
        lambda call: ((len(call.arguments[0]),),),
        (rank_between, rank_of_the_shape, rank_grows),
    ),
)
