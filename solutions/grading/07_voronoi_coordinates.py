"""What only a grader tries in notebook 07."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.questions.q07_coordinates_without_division import beyond_edges, on_edges
from fieldcheck.questions.q07_voronoi_coordinates import (
    mirror_images,
    octagon,
    point_for_weights,
    point_outside,
    points_inside,
    points_outside,
    star,
    uneven_cell,
)
from fieldgrade.authoring.hidden_cases import hidden


@hidden("07.2", "It must hold far from the origin, for flat triangles, and near a right angle.")
def far_and_flat(seed):
    random = np.random.default_rng(seed + 1)
    far = (
        random.random((3, 2)) * [1.0, 0.2] + [300.0, -200.0] + np.array([[0, 0], [2, 0], [1, 0.4]])
    )
    nearly = np.array([[0.3, 0.2], [1.5, 0.2003], [0.3002, 1.1]]) + random.normal(size=2)
    return (
        Call("circumcenter", tuple(far), "a flat triangle far from the origin"),
        Call("circumcenter", tuple(nearly), "nearly a right angle"),
    )


@hidden("07.4", "It must hold for three neighbours, for ten, and for more.")
def few_and_many(seed):
    random = np.random.default_rng(seed + 2)
    calls = []
    for n in (3, 10, 47):
        center, rim, corners = star(random, n, clockwise=n == 10)
        x = point_for_weights(random, center, rim, corners)
        calls.append(Call("weights", (center, rim, corners, x), f"{n} neighbours"))
        x = point_outside(center, rim, corners)
        calls.append(Call("weights", (center, rim, corners, x), f"{n} neighbours, outside"))
    return tuple(calls)


def far_outside(center, rim, corners):
    """Return two points far outside a cell, where the sum of the products (7.10) does not nearly
    vanish.
    """
    tried = np.concatenate([points_outside(center, corners, far) for far in (2.2, 3.1, 4.3)])
    spokes = rim - center
    h = (spokes**2).sum(axis=1) / 2 - (tried - center) @ spokes.T
    ahead = np.roll(spokes, -1, axis=0)
    areas = np.abs(spokes[:, 0] * ahead[:, 1] - spokes[:, 1] * ahead[:, 0])
    c = areas * h.prod(axis=1, keepdims=True) / (h * np.roll(h, -1, axis=1))
    return tried[np.argsort(np.abs(c.sum(axis=1)) / np.abs(c).sum(axis=1))[-2:]]


@hidden("07.5", "There may be one point only, or hundreds.")
def one_place(seed):
    random = np.random.default_rng(seed + 3)
    center, rim, corners = star(random, 5)
    x = points_inside(random, center, corners, 1)
    far = far_outside(center, rim, corners)
    *four, ends = star(random, 4)
    many = points_inside(random, four[0], ends, 101)
    *large, around = star(random, 45)
    return (
        Call("coordinates", (center, rim, corners, x), "one point among five neighbours"),
        Call("coordinates", (center, rim, corners, far), "two points far outside"),
        Call("coordinates", (*four, ends, many), "101 points among four neighbours"),
        Call(
            "coordinates",
            (*large, around, points_inside(random, large[0], around, 2)),
            "45 neighbours",
        ),
    )


@hidden("07.6", "It must hold for other numbers of points.")
def few_points(seed):
    random = np.random.default_rng(seed + 4)
    center, corners = uneven_cell(random, 5, False)
    return tuple(
        Call("spiral", (center, corners, steps), f"{words} among five neighbours")
        for steps, words in (
            (1, "one point"),
            (3, "three points"),
            (197, "197 points"),
            (1000, "a thousand points"),
        )
    )


@hidden(
    "07.8", "The coordinates must be right on edges, in corners, far outside, and in every unit."
)
def on_other_edges(seed):
    random = np.random.default_rng(seed + 5)
    corners = octagon(random)
    center, at = corners.mean(axis=0), np.vstack([on_edges(corners), corners])
    uneven = (center, mirror_images(center, corners), at)
    square = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    at_corners = (np.zeros(2), mirror_images(np.zeros(2), square), square)
    tiny = tuple(2.0**-33 * part for part in uneven)
    *many, ten = star(random, 10)
    beyond = beyond_edges(corners, 1 / 16)
    *four, ends = star(random, 4)
    *large, around = star(random, 45)
    name = "safe_coordinates"
    return (
        Call(name, uneven, "the edges and corners of an uneven cell", exact=(0, 1, 2)),
        Call(name, at_corners, "the corners of a square cell", exact=(0, 1, 2)),
        Call(name, tiny, "the edges and corners of a tiny cell", exact=(0, 1, 2)),
        Call(name, (*uneven[:2], points_outside(center, corners)), "points outside an octagon"),
        Call(name, (*many, points_inside(random, many[0], ten, 5)), "ten neighbours"),
        Call(name, (*many, far_outside(*many, ten)), "points far outside"),
        Call(
            name, (*uneven[:2], far_outside(*uneven[:2], corners)), "points far outside an octagon"
        ),
        Call(name, (*uneven[:2], beyond), "points on extended edges", exact=(0, 1, 2)),
        Call(name, (*four, points_inside(random, four[0], ends, 101)), "101 points"),
        Call(name, (*large, points_inside(random, large[0], around, 2)), "45 neighbours"),
    )
