"""What only a grader tries in notebook 08."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.questions.q07_voronoi_coordinates import mirror_images, octagon
from fieldcheck.questions.q08_weights_in_3d import (
    point_outside,
    points_inside,
    points_outside,
    star,
)
from fieldgrade.authoring.hidden_cases import hidden


@hidden("08.2", "It must hold far from the origin.")
def far_away(seed):
    random = np.random.default_rng(seed + 1)
    corners = random.random((4, 3)) + 2 * np.eye(4, 3) + [200.0, -300.0, 100.0]
    return (Call("circumcenter", tuple(corners), "a tetrahedron far from the origin"),)


@hidden("08.7", "It must hold for few neighbours and for many, and in every unit.")
def few_and_many(seed):
    random = np.random.default_rng(seed + 2)
    calls = []
    for n in (3, 9):
        center, neighbors, cells, corners = star(random, n)
        (x,) = points_inside(random, center, corners, 1)
        calls.append(Call("weights", (center, neighbors, cells, corners, x), f"{n + 2} neighbours"))
        x = point_outside(center, neighbors, cells, corners)
        case = f"{n + 2} neighbours, outside"
        calls.append(Call("weights", (center, neighbors, cells, corners, x), case))
    center, neighbors, cells, corners, x = calls[0].arguments
    small = (2.0**-24 * center, 2.0**-24 * neighbors, cells, 2.0**-24 * corners, 2.0**-24 * x)
    return (*calls, Call("weights", small, "a small cell"))


@hidden("08.8", "There may be one point only.")
def one_place(seed):
    random = np.random.default_rng(seed + 3)
    center, neighbors, _, corners = star(random, 5)
    x = points_inside(random, center, corners, 1)
    return (Call("heights", (center, neighbors, x), "one point among seven neighbours"),)


@hidden("08.10", "It must hold on edges and faces of any cell, outside, and in every unit.")
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
    name = "coordinates"
    return (
        Call(name, prism, "corners, edges and a face of a prism", exact=(0, 1, 3)),
        Call(name, tiny, "corners, edges and a face of a tiny prism", exact=(0, 1, 3)),
        Call(name, around, "points outside a prism"),
    )
