"""What only a grader tries in notebook 08."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.questions.q07_voronoi_coordinates import mirror_images, octagon
from fieldcheck.questions.q08_weights_in_3d import points_inside, star
from fieldgrade.authoring.hidden_cases import hidden


@hidden("08.2", "It must hold far from the origin.")
def far_away(seed):
    random = np.random.default_rng(seed + 1)
    corners = random.random((4, 3)) + 2 * np.eye(4, 3) + [200.0, -300.0, 100.0]
    return (Call("circumcenter", tuple(corners), "a tetrahedron far from the origin"),)


@hidden("08.7", "It must hold for few neighbours and for many.")
def few_and_many(seed):
    random = np.random.default_rng(seed + 2)
    calls = []
    for n in (3, 9):
        center, neighbors, cells, corners = star(random, n)
        (x,) = points_inside(random, center, corners, 1)
        calls.append(Call("weights", (center, neighbors, cells, corners, x), f"{n + 2} neighbours"))
    return tuple(calls)


@hidden("08.8", "A single place must do.")
def one_place(seed):
    random = np.random.default_rng(seed + 3)
    center, neighbors, _, corners = star(random, 5)
    x = points_inside(random, center, corners, 1)
    return (Call("heights", (center, neighbors, x), "one place among seven neighbours"),)


@hidden("08.10", "The edges and faces of any cell count, not of a cube only.")
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
    return (Call("coordinates", prism, "corners, edges and a face of a prism", exact=(0, 1, 3)),)
