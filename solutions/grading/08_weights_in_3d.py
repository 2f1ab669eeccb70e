"""What only a grader tries in notebook 08."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.questions.q08_weights_in_3d import places_inside, star
from fieldrecon.course.hidden import hidden


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
        (x,) = places_inside(random, center, corners, 1)
        calls.append(Call("weights", (center, neighbors, cells, corners, x), f"{n + 2} neighbours"))
    return tuple(calls)


@hidden("08.8", "A single place must do.")
def one_place(seed):
    random = np.random.default_rng(seed + 3)
    center, neighbors, _, corners = star(random, 5)
    x = places_inside(random, center, corners, 1)
    return (Call("heights", (center, neighbors, x), "one place among seven neighbours"),)


@hidden("08.10", "The edges and faces of any cell count, not of a cube only.")
def on_other_faces(seed):
    random = np.random.default_rng(seed + 4)
    center, neighbors, cells, corners = star(random, 6)
    at = np.vstack([corners, (corners[:6] + corners[6:]) / 2, corners[:6].mean(axis=0)])
    return (Call("coordinates", (center, neighbors, cells, at), "corners, edges and a face"),)
