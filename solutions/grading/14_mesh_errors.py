"""Hidden cases of notebook 14."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.questions.q14_mesh_errors import (
    ball,
    band,
    book,
    flipped,
    fused,
    joined,
    ring,
    sheet,
    shuffled,
    without,
)
from fieldcheck.questions.q14_mesh_places import copies
from fieldgrade.authoring.hidden_cases import hidden


@hidden("14.1", "It must hold in the plane, and for a single point.")
def in_the_plane(seed):
    random = np.random.default_rng(seed + 1)
    flat = copies(random, 16, 0.01)[:, :2]
    return (
        Call("weld", (flat, 0.0075), "points in the plane", exact=(0,)),
        Call("weld", (random.normal(size=(1, 3)), 0.1), "one point"),
    )


@hidden("14.2", "A mesh may have few triangles, and large vertex numbers.")
def few_and_far(seed):
    random = np.random.default_rng(seed + 2)
    crowd = joined(book(4), ring(3, 3), without(ball(2, 4), 1))
    return (
        Call("triangles_at_sides", (np.array([[4000, 7, 12]]),), "one triangle"),
        Call("triangles_at_sides", (shuffled(random, crowd, 40)[1],), "several surfaces"),
    )


@hidden("14.3", "It must hold for any surface, of one triangle or of many parts.")
def other_surfaces(seed):
    random = np.random.default_rng(seed + 3)
    tips = fused(joined(ball(2, 4), ball(2, 4)), (9, 18))
    return (
        Call("euler_characteristic", (np.array([[5, 0, 9]]),), "one triangle"),
        Call("euler_characteristic", (shuffled(random, tips)[1],), "two spheres at one vertex"),
        Call(
            "euler_characteristic",
            (shuffled(random, without(ring(4, 5), 3, 22))[1],),
            "a torus with holes",
        ),
    )


@hidden("14.4", "There may be any number of loops, on any number of parts.")
def many_loops(seed):
    random = np.random.default_rng(seed + 4)
    surface = joined(band(3, 5), without(ring(4, 7), 0, 30), sheet(1, 1), ball(2, 4))
    points, triangles = shuffled(random, flipped(random, surface), 6)
    return (
        Call("boundary_loops", (len(points), triangles), "several surfaces"),
        Call("boundary_loops", (5, np.array([[3, 1, 4]])), "one triangle"),
    )


@hidden("14.5", "Fans may be open or closed, and several of both may meet.")
def open_and_closed(seed):
    random = np.random.default_rng(seed + 5)
    surface = fused(joined(ball(2, 4), sheet(2, 2), book(3), ball(1, 4)), (0, 14), (0, 19), (0, 27))
    points, triangles = shuffled(random, flipped(random, surface), 3)
    return (Call("fans", (len(points), triangles), "four surfaces at one vertex"),)


@hidden("14.6", "There may be several parts, orientable and not.")
def bands(seed):
    random = np.random.default_rng(seed + 6)
    surface = flipped(random, joined(band(2, 5), band(3, 5), ring(3, 4), band(1, 4)))
    points, triangles = shuffled(random, surface)
    rough = points + random.uniform(-0.05, 0.05, points.shape)
    return (
        Call("turns", (rough, triangles), "four surfaces"),
        Call("turns", (random.normal(size=(3, 3)), np.array([[1, 0, 2]])), "one triangle"),
    )


@hidden("14.7", "The unit of length must not matter, nor where the origin is.")
def in_nanometres(seed):
    random = np.random.default_rng(seed + 7)
    points, triangles = random.normal(size=(12, 3)), random.integers(0, 12, (9, 3))
    return (
        Call("flat", (1e9 * points, triangles, 1e6), "large numbers"),
        Call("flat", (points, triangles, 0.5), "a large tolerance"),
    )


@hidden("14.8", "It must hold for any segments and triangles.")
def at_random(seed):
    random = np.random.default_rng(seed + 8)
    start, end = random.normal(size=(2, 40, 3))
    return (Call("pierced", (start, end, random.normal(size=(40, 3, 3))), "forty at random"),)
