"""Hidden cases of notebook 14."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.inputs.surfaces import (
    TRIANGLE,
    alike,
    ball,
    band,
    book,
    bottle,
    flipped,
    fused,
    joined,
    repeated,
    ring,
    sheet,
    shuffled,
    unjoined,
    without,
)
from fieldcheck.questions.q14_mesh_places import copies, crowds, thin
from fieldgrade.authoring.hidden_cases import hidden


@hidden("14.1", "It must hold in the plane, and for a single point.")
def in_the_plane(seed):
    random = np.random.default_rng(seed + 1)
    flat = copies(random, 16, 0.01)[:, :2]
    return (
        Call("weld", (flat, 0.0075), "points in the plane", exact=(0,)),
        Call("weld", (np.array([[7, 1], [1, 9], [5, 12]]), 5.0), "a distance of 5", exact=(0, 1)),
        Call("weld", (random.normal(size=(1, 3)), 0.1), "one point"),
        Call("weld", (crowds(random, 1, 3, 2.0), 2.0), "forty points at one place"),
    )


FEW = np.array([[1, 12, 40], [2, 8, 41], [3, 30, 42], [4, 18, 43]])
"""Triangles without a common edge. Their sides are not determined by 4 i + j or 12 i + j."""

LARGE = np.array([[1, 1500, 3001], [2, 500, 3002], [3, 1200, 3003], [4, 200, 3004]])
"""Triangles without a common edge. Their sides are not determined by 1000 i + j."""


def with_large_numbers(random):
    """Return triangles with vertex numbers above 100 and above 1000."""
    return {
        "two triangles with numbers below 200": alike(random, 100),
        "two triangles with numbers below 200, in another order": alike(random, 100, as_text=True),
        "two triangles with numbers below 1100": alike(random, 1000),
        "two other triangles with numbers below 1100": alike(random, 1000),
    }


def long_strip(random, *joined_ends):
    """Return a strip of a thousand triangles, of which some are inverted.

    A function that calls itself for each triangle or vertex exceeds the recursion limit of Python.
    """
    return shuffled(random, flipped(random, fused(sheet(1, 502), *joined_ends)))


CLOSED, TWISTED = ((0, 502), (503, 1005)), ((0, 1005), (503, 502))
"""How the ends of the strip are joined: to a band, and to a Möbius strip."""


def disc(around):
    """Return a disc of triangles about vertex 0."""
    rim = np.arange(1, around + 1)
    points = np.column_stack([np.cos(rim), np.sin(rim), 0 * rim])
    return np.vstack([0 * points[:1], points]), np.column_stack([0 * rim, rim, np.roll(rim, -1)])


@hidden("14.2", "A mesh may have few triangles, and large vertex numbers.")
def few_and_far(seed):
    random = np.random.default_rng(seed + 2)
    crowd = joined(book(4), ring(3, 3), without(ball(2, 4), 1))
    return (
        Call("triangles_at_sides", (np.array([[4000, 7, 12]]),), "one triangle"),
        Call("triangles_at_sides", (LARGE,), "four triangles with large numbers"),
        Call("triangles_at_sides", (LARGE[:, ::-1],), "four inverted triangles with large numbers"),
        Call("triangles_at_sides", (FEW,), "four triangles"),
        Call(
            "triangles_at_sides", (np.array([[1, 1000, 1023], [65, 1000, 900]]),), "two triangles"
        ),
        Call("triangles_at_sides", (shuffled(random, crowd, 40)[1],), "several surfaces"),
        *(
            Call("triangles_at_sides", (t,), case)
            for case, (_, t) in with_large_numbers(random).items()
        ),
    )


@hidden(
    "14.3", "It must hold for any surface, of one triangle or of many parts, and for large numbers."
)
def other_surfaces(seed):
    random = np.random.default_rng(seed + 3)
    tips = fused(joined(ball(2, 4), ball(2, 4)), (9, 18))
    return (
        Call("euler_characteristic", (np.array([[5, 0, 9]]),), "one triangle"),
        Call("euler_characteristic", (LARGE,), "four triangles with large numbers"),
        Call("euler_characteristic", (FEW,), "four triangles"),
        Call("euler_characteristic", (shuffled(random, book(7))[1],), "seven triangles at an edge"),
        Call("euler_characteristic", (LARGE[[0, 1, 2, 0, 2, 0]],), "triangles listed twice"),
        Call("euler_characteristic", (shuffled(random, tips)[1],), "two spheres at one vertex"),
        Call(
            "euler_characteristic",
            (shuffled(random, without(ring(4, 5), 3, 22))[1],),
            "a torus with holes",
        ),
        *(
            Call("euler_characteristic", (t,), case)
            for case, (_, t) in with_large_numbers(random).items()
        ),
    )


@hidden("14.4", "There may be any number of loops of any length, on any number of parts.")
def many_loops(seed):
    random = np.random.default_rng(seed + 4)
    surface = joined(band(3, 5), without(ring(4, 7), 0, 30), sheet(1, 1), ball(2, 4))
    points, triangles = shuffled(random, flipped(random, surface), 6)
    pillow = TRIANGLE[0], np.array([[0, 1, 2], [0, 2, 1]])
    doubled = repeated(TRIANGLE, 0)
    closed = {
        "a sheet, a triangle and its inverse": shuffled(random, joined(pillow, sheet(2, 2)), 1),
        "two triangles listed twice": shuffled(random, joined(doubled, doubled, TRIANGLE), 1),
    }
    long = {
        "a long strip": long_strip(random),
        "a long Möbius strip": long_strip(random, *TWISTED),
    }
    return (
        Call("boundary_loops", (len(points), triangles), "several surfaces"),
        Call("boundary_loops", (5, np.array([[3, 1, 4]])), "one triangle"),
        *(
            Call("boundary_loops", (len(p), t), case)
            for case, (p, t) in (closed | with_large_numbers(random) | long).items()
        ),
    )


@hidden(
    "14.5",
    "Fans may be open or closed, of any number of triangles, in any order and direction, and "
    "several of both may meet.",
)
def open_and_closed(seed):
    random = np.random.default_rng(seed + 5)
    surface = fused(joined(ball(2, 4), sheet(2, 2), book(3), ball(1, 4)), (0, 14), (0, 19), (0, 27))
    points, triangles = shuffled(random, flipped(random, surface), 3)
    many, two = repeated(disc(35), *40 * [*range(35)]), fused(joined(disc(35), disc(9)), (0, 36))
    crowded = {
        "a disc whose triangles are listed many times": shuffled(random, many),
        "two discs with one centre, one of them listed many times": shuffled(
            random, repeated(two, *40 * [*range(35)])
        ),
    }
    return (
        Call("fans", (len(points), triangles), "four surfaces at one vertex"),
        Call("fans", (4, np.array([[3, 0, 1], [0, 1, 3]])), "a triangle listed twice"),
        Call("fans", (4, np.array([[2, 0, 1], [0, 2, 1]])), "a triangle and its inverse"),
        *(
            Call("fans", (len(p), t), case)
            for case, (p, t) in (crowded | with_large_numbers(random)).items()
        ),
    )


@hidden(
    "14.6",
    "There may be several parts, orientable and not, and triangles may be listed twice.",
)
def bands(seed):
    random = np.random.default_rng(seed + 6)
    surface = flipped(random, joined(band(2, 5), band(3, 5), ring(3, 4), band(1, 4)))
    points, triangles = shuffled(random, surface)
    rough = points + random.uniform(-0.05, 0.05, points.shape)
    three = fused(joined(ring(3, 4), band(1, 5), ball(1, 4)), (0, 12), (0, 27))
    closed = {
        "a Klein bottle": shuffled(random, flipped(random, bottle())),
        "a torus and a Klein bottle": shuffled(
            random, flipped(random, joined(ring(4, 5), bottle(5, 4)))
        ),
    }
    seam = shuffled(random, flipped(random, unjoined(3, 7)))
    touching, both = shuffled(random, flipped(random, three))
    return (
        Call("turns", (rough, triangles), "four surfaces"),
        Call(
            "turns",
            (touching + random.uniform(-0.05, 0.05, touching.shape), both),
            "three surfaces that share a vertex",
        ),
        Call("turns", (random.normal(size=(4, 3)), np.array([[1, 0, 2]])), "one triangle"),
        Call("turns", seam, "a strip with equal points at both ends", exact=(0,)),
        *(
            Call(
                "turns",
                (random.normal(size=(3, 3)), np.array(twice)),
                "two equal triangles",
                exact=(0,),
            )
            for twice in ([[1, 0, 2], [0, 2, 1]], [[1, 0, 2], [1, 2, 0]])
        ),
        *(
            Call("turns", (random.normal(size=p.shape), t), case)
            for case, (p, t) in (closed | with_large_numbers(random)).items()
        ),
    )


@hidden(
    "14.6",
    "A part may have over a thousand triangles; Python ends a recursion after about 1000 calls.",
)
def long_bands(seed):
    random = np.random.default_rng(seed + 16)
    return tuple(
        Call("turns", (random.normal(size=p.shape), t), case)
        for p, t, case in (
            (*long_strip(random, *CLOSED), "a long band"),
            (*long_strip(random, *TWISTED), "a long Möbius strip"),
        )
    )


@hidden("14.7", "The unit of length must not matter, nor where the origin is.")
def in_nanometres(seed):
    random = np.random.default_rng(seed + 7)
    points, triangles = random.normal(size=(12, 3)), random.integers(0, 12, (9, 3))
    heights = [0.8e-3, 1.2e-3, 0.9e-3, 1.1e-3]
    high = np.concatenate([thin(random, 1, heights[k % 4], 0.4, k % 3) for k in range(12)])
    return (
        Call("flat", (1e9 * points, triangles, 1e6), "large numbers"),
        Call("flat", (points, triangles, 0.5), "a large tolerance"),
        Call("flat", (points, triangles[:1], 0.5), "a single triangle"),
        Call(
            "flat",
            (high + 1e6, np.arange(36).reshape(12, 3), 1e-3),
            "triangles very far from the origin",
        ),
    )


@hidden("14.8", "It must hold for any segments and triangles, in every unit.")
def at_random(seed):
    random = np.random.default_rng(seed + 8)
    start, end = random.normal(size=(2, 40, 3))
    corners = random.normal(size=(40, 3, 3))
    return (
        Call("pierced", (start, end, corners), "forty at random"),
        Call("pierced", (start[:1], end[:1], corners[:1]), "one at random"),
        Call("pierced", tuple(2.0**-40 * p for p in (start, end, corners)), "forty small ones"),
    )
