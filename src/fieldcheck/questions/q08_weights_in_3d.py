"""Questions of notebook 08, the weights in three dimensions.

A star is made from its cell, a truncated pyramid over a convex polygon: the neighbours of a point
are its mirror images in the faces. The circumcentres are therefore known and need not be computed.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.question import Law, Question, law, relative
from fieldcheck.questions.q07_voronoi_coordinates import (
    ONE,
    balances,
    has_negative_coordinates_outside,
    is_rotation_invariant,
)
from fieldcheck.simplices import (
    is_equally_far,
    is_halved,
    moved_far_away,
    relative_to_a_corner,
    tolerance_far_away,
)

Star = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def star(random: np.random.Generator, n: int) -> Star:
    """Return a vertex, its n + 2 neighbours, the tetrahedra by vertex numbers, and the
    circumcentres.

    The orientation of the tetrahedra is arbitrary, as in most meshes.
    """
    turns = np.exp(2j * np.pi * (np.arange(n) + random.uniform(0.1, 0.7, n)) / n)
    base = np.column_stack([1.3 * turns.real, turns.imag, np.full(n, -0.8)])
    top = np.array([0.2, -0.1, 2.5]) + random.uniform(-0.2, 0.2, 3)
    corners = np.vstack([base, top + random.uniform(0.4, 0.6) * (base - top)])
    corners = corners @ np.linalg.qr(random.normal(size=(3, 3)))[0] + random.normal(size=3)
    center = corners.mean(axis=0) + random.uniform(-0.1, 0.1, 3)
    sides = [corners[[b - 1, b, n + b]] for b in range(n)]
    faces = [*sides, corners[:3], corners[n : n + 3]]
    cells = np.array(
        [random.permutation([a % n, (a % n + 1) % n, n + a // n]) for a in range(2 * n)]
    )
    return center, np.array([mirror_image(center, face) for face in faces]), cells, corners


def mirror_image(place: np.ndarray, face: np.ndarray) -> np.ndarray:
    """Return the mirror image of a point in the plane through three points."""
    across = np.cross(face[1] - face[0], face[2] - face[0])
    return place + 2 * ((face[0] - place) @ across) / (across @ across) * across


def points_inside(
    random: np.random.Generator, center: np.ndarray, corners: np.ndarray, m: int
) -> np.ndarray:
    """Return m points well inside a cell."""
    return center + 0.7 * (random.dirichlet(np.ones(len(corners)), m) @ corners - center)


def points_outside(
    center: np.ndarray, neighbors: np.ndarray, cells: np.ndarray, corners: np.ndarray
) -> np.ndarray:
    """Return one point just outside each face of a cell, beyond the mean of its corners."""
    faces = [corners[np.any(cells == b, axis=1)].mean(axis=0) for b in range(len(neighbors))]
    return center + 1.15 * (np.array(faces) - center)


def cuboid(
    middle: np.ndarray, half: np.ndarray | float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the neighbours of a point whose cell is a cuboid, the tetrahedra by vertex numbers,
    and the corners.
    """
    signs = np.array(list(product((-1, 1), repeat=3)))
    axes = np.eye(3, dtype=int)
    cells = np.array([[k if s > 0 else 3 + k for k, s in enumerate(row)] for row in signs])
    return middle + 2 * half * np.vstack([axes, -axes]), cells, middle + half * signs


# 08.1 and 08.2 Tetrahedra


def tetrahedra(name: str, seed: int) -> tuple[Call, ...]:
    """Return a tetrahedron, the same in another order, half of it, a flat and two small ones."""
    random = np.random.default_rng(seed)
    corner = np.array(
        [[0.0, 0, 0], [2, 0.3, 0.1], [0.7, 1.6, -0.2], [0.6, 0.5, 1.9]]
    ) + random.uniform(-0.3, 0.3, (4, 3))
    a, b, c, d = corner + np.array([1.5, -2.5, 0.8])
    low = (a + 2 * b + 2 * c) / 5 + 0.25 * (d - a)
    return calls_of(
        name,
        ((a, b, c, d), "a tetrahedron"),
        ((a, c, b, d), "the same tetrahedron, listed the other way round"),
        ((a, b, c, (c + d) / 2), "half of the tetrahedron"),
        ((b, a, c, low), "a flat tetrahedron, listed the other way round"),
        (tuple(1e-4 * p for p in (a, c, b, d)), "a tetrahedron of the size 10⁻⁴"),
        (tuple(integers(p) for p in (a, b, c, d)), "a tetrahedron of integers"),
        (tuple(integers(p, 200) for p in (a, c, b, d)), "another tetrahedron of integers"),
        (tuple(2.0**-34 * p for p in (a, b, c, d)), "a tetrahedron of the size 10⁻¹⁰"),
    )


VOLUME_IS_HALVED = Law(
    "A volume must be positive and must not depend on the order of the corners. A plane through "
    "one edge and the middle of the opposite edge must cut it in half.",
    is_halved,
)


def circumcenter_inputs(seed: int) -> tuple[Call, ...]:
    """Return the tetrahedra, and two of them far from the origin."""
    near = tetrahedra("circumcenter", seed)
    cases = ("the first tetrahedron, far from the origin", "a flat tetrahedron, far away")
    layers = calls_of(
        "circumcenter",
        *(
            (tuple(p * scale for p in near[0].arguments), f"a tetrahedron in a thin layer, {words}")
            for scale, words in (([1, 1, 0.02], "lying"), ([0.02, 1, 1], "upright"))
        ),
    )
    return near + moved_far_away((near[0], near[3]), cases) + layers


# 08.4 The volume of the normals


def normals_inputs(seed: int) -> tuple[Call, ...]:
    """Return three edges, the same longer and in another order, perpendicular edges, tips in arrays
    of integers, and short edges.
    """
    random = np.random.default_rng(seed)
    center = random.normal(size=3)
    edges = np.array([[1.4, 0.2, 0.1], [0.3, 0.9, -0.2], [0.2, 0.4, 1.7]]) + random.uniform(
        -0.15, 0.15, (3, 3)
    )
    frame = np.linalg.qr(random.normal(size=(3, 3)))[0]
    frame = -np.sign(np.linalg.det(frame)) * frame
    name = "volume_of_normals"
    return calls_of(
        name,
        ((center, center + edges), "a tetrahedron"),
        (
            (-center, np.array([[2.0], [0.5], [1.5]]) * edges - center),
            "the same directions elsewhere, other lengths",
        ),
        ((center, center + edges[[1, 0, 2]]), "the same tips in another order"),
        (
            (-center, random.uniform(1, 2, (3, 1)) * frame - center),
            "perpendicular edges, left-handed",
        ),
        ((center, integers(edges)), "tips in an array of integers"),
        ((-center, integers(edges[[2, 0, 1]], 7)), "tips in an array of small integers"),
        ((2.0**-34 * center, 2.0**-34 * (center + edges)), "a tetrahedron of the size 10⁻¹⁰"),
    )


@law(
    "The volume must not depend on the lengths of the edges nor on their order, and perpendicular "
    "normals must span the volume one."
)
def depends_on_directions(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the effect of lengths and order, and the deviation from one if perpendicular."""
    here, longer, turned, one = (float(v) for (v,) in values[:4])
    return max(relative(longer - here, here), relative(turned - here, here), abs(one - 1))


# 08.7 Weights


def weights_inputs(seed: int) -> tuple[Call, ...]:
    """Return stars of six and seven neighbours, the first at other sizes, points outside, and a
    cuboid of integers.
    """
    random = np.random.default_rng(seed)
    calls = []
    for n, case in ((4, "six neighbours"), (5, "seven neighbours")):
        center, neighbors, cells, corners = star(random, n)
        (x,) = points_inside(random, center, corners, 1)
        calls.append(Call("weights", (center, neighbors, cells, corners, x), case))
    center, neighbors, cells, corners, x = calls[0].arguments
    double = (2 * center, 2 * neighbors, cells, 2 * corners, 2 * x)
    calls.append(Call("weights", double, "six neighbours, everything twice as large"))
    tiny = (2.0**-20 * center, 2.0**-20 * neighbors, cells, 2.0**-20 * corners, 2.0**-20 * x)
    calls.append(Call("weights", tiny, "six neighbours in a cell of the size 10⁻⁶"))
    for n in (4, 5):
        center, neighbors, cells, corners = star(random, n)
        x = point_outside(center, neighbors, cells, corners)
        case = f"a point outside the cell of {n + 2} neighbours"
        calls.append(Call("weights", (center, neighbors, cells, corners, x), case))
    middle, half = random.integers(-9, 10, 3), random.integers(2, 9, 3)
    x = middle + half * random.uniform(-0.7, 0.7, 3)
    whole = (middle.astype(float), *cuboid(middle, half), x)
    return (*calls, Call("weights", whole, "a cuboid with arrays of integers"))


def point_outside(
    center: np.ndarray, neighbors: np.ndarray, cells: np.ndarray, corners: np.ndarray
) -> np.ndarray:
    """Return a point just outside a cell, from which no direction to a corner is perpendicular to a
    spoke: an answer that multiplies the two would otherwise divide by a rounding error.
    """
    spokes = neighbors - center

    def least(x: np.ndarray) -> float:
        return float(np.abs((corners - x) @ spokes.T).min())

    return max(points_outside(center, neighbors, cells, corners), key=least)


@law(
    "If everything is twice as large, each weight must be an eighth: (8.2) has eight times the "
    "volume above and 64 times as much below."
)
def scales(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the weights from an eighth at twice the size."""
    return relative(8 * values[2][0] - values[0][0], values[0][0])


# 08.8 Heights


def heights_inputs(seed: int) -> tuple[Call, ...]:
    """Return points inside, the vertex with its neighbours, the midpoints between them, a small
    cell, and integers.
    """
    random = np.random.default_rng(seed)
    center, neighbors, _, corners = star(random, 4)
    inside = points_inside(random, center, corners, 4)
    small = tuple(2.0**-20 * part for part in (center, neighbors, inside))
    return calls_of(
        "heights",
        ((center, neighbors, inside), "four points in a cell"),
        ((center, neighbors, np.vstack([center, neighbors])), "the vertex and its neighbours"),
        ((center, neighbors, (center + neighbors) / 2), "the midpoints between them"),
        (small, "four points in a cell of the size 10⁻⁶"),
        (
            (center, integers(neighbors, 9), integers(inside, 9)),
            "neighbours and points in arrays of integers",
        ),
    )


@law(
    "The height of a neighbour must be zero half-way to it, and must have opposite values at the "
    "vertex and at the neighbour."
)
def vanishes_half_way(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of h from zero at midpoints, and from opposite values at both ends."""
    ends, middles = values[1][0], values[2][0]
    return max(relative(np.diag(middles), ends), relative(ends[:, 0] + np.diag(ends[:, 1:]), ends))


# 08.10 Coordinates


def coordinates_inputs(seed: int) -> tuple[Call, ...]:
    """Return points inside, the same rotated, outside, corners and edges of a cubic cell, a single
    point, and integers.

    The cube has corners that are exact in floating-point numbers, so that a quotient is zero by
    zero there on every machine.
    """
    random = np.random.default_rng(seed)
    center, neighbors, cells, corners = star(random, 4)
    x = points_inside(random, center, corners, 3)
    over = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])
    other, tips, more, ends = star(random, 5)
    side = 2.0 ** int(random.integers(-2, 3))
    middle = side * random.integers(-9, 9, 3).astype(float)
    around, eight, cube = cuboid(middle, side)
    at, tiny = np.vstack([cube, (cube[:4] + cube[4:]) / 2]), 2.0**-30
    whole, half = random.integers(-9, 10, 3), random.integers(3, 9, 3)
    integer = (
        whole.astype(float),
        *cuboid(whole, half)[:2],
        whole + random.integers(-2, 3, (4, 3)),
    )
    name = "coordinates"
    return (
        Call(name, (center, neighbors, cells, x), "three points in a cell"),
        Call(name, (center @ over, neighbors @ over, cells, x @ over), "the first cell, rotated"),
        Call(
            name,
            (other, tips, more, points_inside(random, other, ends, 2)),
            "two points in a cell of seven neighbours",
        ),
        Call(
            name, (middle, around, eight, at), "corners and edges of a cubic cell", exact=(0, 1, 3)
        ),
        Call(
            name,
            (tiny * middle, tiny * around, eight, tiny * at),
            "corners and edges of a cube of the size 10⁻⁹",
            exact=(0, 1, 3),
        ),
        Call(
            name,
            (center, neighbors, cells, points_outside(center, neighbors, cells, corners)),
            "points outside the cell",
        ),
        Call(
            name,
            (other, tips, more, points_outside(other, tips, more, ends)),
            "points outside the cell of seven neighbours",
        ),
        Call(name, (center, neighbors, cells, x[:1]), "one point in a cell"),
        Call(name, integer, "points in a cuboid, in arrays of integers"),
    )


@law(
    "In a corner the coordinate of this corner must be one and all others zero. In the middle of "
    "an edge those of its two ends must be one half."
)
def is_right_on_the_cube(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation from one weight at corners, and from two halves at edge midpoints."""
    wanted = np.vstack([np.eye(8), (np.eye(8)[:4] + np.eye(8)[4:]) / 2])
    return max(relative(omega - wanted, 1.0) for (omega,) in values[3:5])


QUESTIONS = (
    Question(
        "08.1",
        "volume",
        1,
        lambda seed: tetrahedra("volume", seed),
        lambda _: ((),),
        (VOLUME_IS_HALVED,),
    ),
    Question(
        "08.2",
        "circumcenter",
        2,
        circumcenter_inputs,
        lambda _: ((3,),),
        (is_equally_far,),
        tolerance_far_away,
        relative_to_a_corner,
    ),
    Question(
        "08.4",
        "volume_of_normals",
        2,
        normals_inputs,
        lambda _: ((),),
        (depends_on_directions,),
        may_call=("08.1", "08.2"),
    ),
    Question(
        "08.7",
        "weights",
        3,
        weights_inputs,
        lambda call: ((len(call.arguments[2]),),),
        (scales, balances),
        may_call=("08.2", "08.4"),
    ),
    Question(
        "08.8",
        "heights",
        1,
        heights_inputs,
        lambda call: ((len(call.arguments[1]), len(call.arguments[2])),),
        (vanishes_half_way,),
    ),
    Question(
        "08.10",
        "coordinates",
        3,
        coordinates_inputs,
        lambda call: ((len(call.arguments[3]), len(call.arguments[2])),),
        (
            ONE,
            is_rotation_invariant,
            is_right_on_the_cube,
            has_negative_coordinates_outside,
        ),
    ),
)
