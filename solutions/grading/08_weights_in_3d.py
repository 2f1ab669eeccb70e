"""What only a grader tries in notebook 08."""

import numpy as np

from fieldcheck.calls import Call, integers
from fieldcheck.questions.q07_voronoi_coordinates import mirror_images, octagon
from fieldcheck.questions.q08_weights_in_3d import (
    cuboid,
    point_outside,
    points_inside,
    points_outside,
    star,
)
from fieldgrade.authoring.hidden_cases import hidden


@hidden("08.2", "It must hold far from the origin, and for whole numbers.")
def far_away(seed):
    random = np.random.default_rng(seed + 1)
    corners = random.random((4, 3)) + 2 * np.eye(4, 3) + [200.0, -300.0, 100.0]
    whole = random.integers(-3, 4, (4, 3)) + 9 * np.eye(4, 3, dtype=int)
    return (
        Call("circumcenter", tuple(corners), "a tetrahedron far from the origin"),
        Call("circumcenter", tuple(whole), "a tetrahedron in whole numbers"),
    )


@hidden("08.4", "The edges may lie nearly in one plane, and may have any length.")
def nearly_in_one_plane(seed):
    random = np.random.default_rng(seed + 5)
    center, edges = random.normal(size=3), np.eye(3) + random.uniform(-0.2, 0.2, (3, 3))
    calls = []
    for height, size, case in (
        (6e-2, 1.0, "edges nearly in one plane"),
        (-4e-2, 2.0**-20, "short edges nearly in one plane"),
    ):
        low = edges.copy()
        low[2] = edges[0] + edges[1] + height * edges[2]
        tips = size * (center + low)
        calls.append(Call("volume_of_normals", (size * center, tips), case))
    return tuple(calls)


@hidden("08.7", "It must hold for few neighbours and many, in every unit, and for whole numbers.")
def few_and_many(seed):
    random = np.random.default_rng(seed + 2)
    calls = []
    for n in (3, 9, 45):
        center, neighbors, cells, corners = star(random, n)
        (x,) = points_inside(random, center, corners, 1)
        calls.append(Call("weights", (center, neighbors, cells, corners, x), f"{n + 2} neighbours"))
        x = point_outside(center, neighbors, cells, corners)
        case = f"{n + 2} neighbours, outside"
        calls.append(Call("weights", (center, neighbors, cells, corners, x), case))
    center, neighbors, cells, corners, x = calls[0].arguments
    small = (2.0**-24 * center, 2.0**-24 * neighbors, cells, 2.0**-24 * corners, 2.0**-24 * x)
    middle, half = random.integers(-9, 10, 3), random.integers(3, 9, 3)
    x = middle + random.integers(-2, 3, 3)
    whole = (middle.astype(float), *cuboid(middle, half), x)
    return (
        *calls,
        Call("weights", small, "a small cell"),
        Call("weights", whole, "a cuboid in whole numbers"),
    )


@hidden("08.8", "There may be one point or many, points outside, small cells, and whole numbers.")
def one_place(seed):
    random = np.random.default_rng(seed + 3)
    center, neighbors, _, corners = star(random, 5)
    x = points_inside(random, center, corners, 1)
    return (
        Call("heights", (center, neighbors, x), "one point among seven neighbours"),
        Call("heights", (center, neighbors, 3 * x - 2 * center), "one point outside"),
        Call(
            "heights",
            (2.0**-24 * center, 2.0**-24 * neighbors, 2.0**-24 * np.vstack([x, center])),
            "two points in a small cell",
        ),
        Call("heights", (center, integers(neighbors), integers(x)), "whole numbers"),
        Call("heights", (center, neighbors, center + random.normal(size=(101, 3))), "101 points"),
        Call("heights", (center, center + random.normal(size=(45, 3)), x), "45 neighbours"),
    )


@hidden(
    "08.10", "It must hold on edges and faces of any cell, outside, in every unit, at one point."
)
def on_other_faces(seed):
    random = np.random.default_rng(seed + 4)
    flat = octagon(random)
    middle, half = flat.mean(axis=0), np.array([0, 0, 2.0])
    center = np.append(middle, 0.0)
    low, high = (np.insert(flat, 2, z, axis=1) for z in (-2, 2))
    sides = np.insert(mirror_images(middle, flat), 2, 0.0, axis=1)
    neighbors = np.vstack([sides, center - 2 * half, center + 2 * half])
    cells = np.array([[b, (b + 1) % 8, end] for end in (8, 9) for b in range(8)])
    at = np.vstack([low, high, (low + high) / 2, low.mean(axis=0)])
    prism = (center, neighbors, random.permuted(cells, axis=1), at)
    tiny = (*(2.0**-33 * part for part in prism[:2]), prism[2], 2.0**-33 * at)
    around = (*prism[:3], points_outside(*prism[:3], np.vstack([low, high])))
    whole, side = random.integers(-9, 10, 3), random.integers(3, 9, 3)
    beside = whole + random.integers(-2, 3, (5, 3))
    *four, ends = star(random, 4)
    *large, round_ends = star(random, 43)
    name = "coordinates"
    return (
        Call(name, prism, "corners, edges and a face of a prism", exact=(0, 1, 3)),
        Call(name, tiny, "corners, edges and a face of a tiny prism", exact=(0, 1, 3)),
        Call(name, around, "points outside a prism"),
        Call(name, (*around[:3], around[3][:1]), "one point outside a prism"),
        Call(
            name,
            (whole.astype(float), *cuboid(whole, side)[:2], beside),
            "points in a cuboid, in whole numbers",
        ),
        Call(name, (*four, points_inside(random, four[0], ends, 101)), "101 points"),
        Call(name, (*large, points_inside(random, large[0], round_ends, 2)), "45 neighbours"),
    )
