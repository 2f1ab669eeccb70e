"""Questions of notebook 08, the weights in three dimensions.

A star is made from its cell, a truncated pyramid over a convex polygon: the neighbours of a point
are its mirror images in the faces. The circumcentres are therefore known and need not be computed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, in_short_binary_numbers, integers
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, relative
from fieldcheck.questions.q07_coordinates_without_division import (
    has_negative_coordinates_outside,
    is_rotation_invariant,
)
from fieldcheck.questions.q07_triangles import beside_the_origin
from fieldcheck.questions.q07_voronoi_coordinates import balances, sum_to_one
from fieldcheck.questions.q08_tetrahedra import moved

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


def enlarged(center: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return points at one and a half times their distance from the centre."""
    return center + 1.5 * (points - center)


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
    tiny = (2.0**-40 * center, 2.0**-40 * neighbors, cells, 2.0**-40 * corners, 2.0**-40 * x)
    calls.append(Call("weights", tiny, "six neighbours in a cell of the size 10⁻¹²"))
    for n in (4, 5):
        center, neighbors, cells, corners = star(random, n)
        x = point_outside(center, neighbors, cells, corners)
        case = f"a point outside the cell of {n + 2} neighbours"
        calls.append(Call("weights", (center, neighbors, cells, corners, x), case))
    middle, half = random.integers(-9, 10, 3), random.integers(2, 9, 3)
    x = middle + half * random.uniform(-0.7, 0.7, 3)
    whole = (middle.astype(float), *cuboid(middle, half), x)
    return (
        *calls,
        Call("weights", whole, "a cuboid with arrays of integers"),
        *more_weights(random, calls[:2]),
    )


def more_weights(random: np.random.Generator, calls: Sequence[Call]) -> Iterator[Call]:
    """Yield large cells, other points and cells, integers, and many neighbours."""
    for call in calls:
        center, neighbors, cells, corners, x = call.arguments
        huge = tuple(2.0**20 * part for part in (center, neighbors, corners, x))
        larger = tuple(enlarged(center, part) for part in (neighbors, corners))
        (other,) = points_inside(random, center, corners, 1)
        for vertex, tips, ends, at, words in (
            (*huge, "in a cell of the size 10⁶"),
            (center, *larger, x, "the same point in a larger cell"),
            (center, neighbors, corners, other, "another point"),
        ):
            yield Call("weights", (vertex, tips, cells, ends, at), f"{call.case}, {words}")
    for _ in range(2):
        middle, half = random.integers(-9, 10, 3), random.integers(2, 9, 3)
        neighbors, cells, corners = cuboid(1.0 * middle, half)
        x = middle + half * random.uniform(-0.7, 0.7, 3)
        yield Call(
            "weights", (middle, neighbors, cells, corners, x), "a vertex in an array of integers"
        )
    center, neighbors, cells, corners = star(random, 41)
    (x,) = points_inside(random, center, corners, 1)
    yield Call("weights", (center, neighbors, cells, corners, x), "43 neighbours")
    for n, words in ((4, "six"), (5, "seven")):
        cell = star(random, n)
        yield Call("weights", (*cell, cell[0].copy()), f"the vertex among {words} neighbours")
    yield from weights_in_cuboids(random)


def weights_in_cuboids(random: np.random.Generator) -> Iterator[Call]:
    """Yield cuboids far from the origin, and small ones; their corners are exact."""
    for k in range(2):
        middle, half = random.integers(-9, 10, 3), random.integers(2, 9, 3) / 4
        neighbors, cells, corners = cuboid(1.0 * middle, half)
        x = in_short_binary_numbers(middle + half * random.uniform(-0.7, 0.7, 3))
        far = tuple(part + 2.0**18 for part in (middle, neighbors, corners, x))
        small = beside_the_origin(random, 1.0 * middle, neighbors, corners, x)
        for (center, tips, ends, at), words in (
            (far, "10⁵ away"),
            (small, "of the size 10⁻⁸, beside the origin"),
        ):
            case = f"{('a cuboid', 'another cuboid')[k]} {words}"
            yield Call("weights", (center, tips, cells, ends, at), case, exact=(0, 1, 3, 4))
    for words in ("an oblique cuboid", "another oblique cuboid"):
        lengths = np.rint(2.0**14 * random.uniform(0.3, 1, (3, 1))) / 2.0**14
        axes = lengths * random.permutation([[1, 2, 2], [2, 1, -2], [2, -2, 1]])
        tips, cells, ends = cuboid(np.zeros(3), 1)
        vertex = 2.0**27 * random.choice([-1, 1], 3)
        at = np.rint(2.0**16 * random.uniform(-0.7, 0.7, 3)) / 2.0**16 @ axes
        given = vertex, vertex + tips @ axes, cells, vertex + ends @ axes, vertex + at
        yield Call("weights", given, f"{words} 10⁸ away", exact=(0, 1, 3, 4))


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
    calls = calls_of(
        "heights",
        ((center, neighbors, inside), "four points in a cell"),
        ((center, neighbors, np.vstack([center, neighbors])), "the vertex and its neighbours"),
        ((center, neighbors, (center + neighbors) / 2), "the midpoints between them"),
        (small, "four points in a cell of the size 10⁻⁶"),
        (
            (center, integers(neighbors, 9), integers(inside, 9)),
            "neighbours and points in arrays of integers",
        ),
        *more_heights(random, center, neighbors, corners),
    )
    away = tuple(
        Call("heights", tuple(moved(p, 2.0**17) for p in (center, neighbors, x)), case, (0, 1, 2))
        for x, case in ((inside, "four points, 10⁵ away"), (corners, "eight corners, 10⁵ away"))
    )
    beside = tuple(
        Call(
            "heights",
            beside_the_origin(random, center, neighbors, x),
            f"{words} in a cell of the size 10⁻⁸, beside the origin",
            exact=(0, 1, 2),
        )
        for x, words in ((inside, "four points"), (corners, "eight corners"))
    )
    return calls + away + beside


def more_heights(
    random: np.random.Generator, center: np.ndarray, neighbors: np.ndarray, corners: np.ndarray
) -> Iterator[tuple[tuple[np.ndarray, ...], str]]:
    """Yield one point, three points, many points and neighbours, and other units and vertices."""
    inside = points_inside(random, center, corners, 4)
    yield (center, neighbors, inside), "four other points in the first cell"
    yield (center, enlarged(center, neighbors), inside), "the same points in a larger cell"
    yield (center, enlarged(center, neighbors[:5]), inside[:1]), "one point, five neighbours"
    yield (center, neighbors, inside[1:2]), "one point, six neighbours"
    yield (center, neighbors, inside[:3]), "three points"
    yield (center, neighbors[:3], inside[1:]), "three points and three neighbours"
    for size, words in ((2.0**-40, "10⁻¹²"), (1e6, "10⁶"), (2.0**30, "10⁹")):
        scaled = tuple(size * part for part in (center, neighbors, inside))
        yield scaled, f"four points in a cell of the size {words}"
    for k in (9, 20):
        vertex = random.integers(-9, 10, 3)
        yield (vertex, k * neighbors, k * inside), f"a vertex of integers, neighbours {k} away"
    yield (center, neighbors[:2], center + random.normal(size=(69, 3))), "69 points"
    for k in (1, 2):
        vertex = random.integers(-9, 10, 3)
        odd = 2 * k * random.integers(1, 9, (3, 3)) + np.eye(3, dtype=int)
        points = vertex + random.integers(-9, 10, (4, 3))
        yield (
            (vertex, vertex + odd, points),
            f"integers, with squared lengths that are odd, from {4 * k}",
        )
    many = center + random.normal(size=(43, 3))
    yield (center, many, inside[:2]), "43 neighbours"


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
        *beside_the_cube(random, (middle, around, eight), side),
        *more_cells(random, (center, neighbors, cells, corners), x),
    )


def beside_the_cube(
    random: np.random.Generator, cube: tuple[np.ndarray, ...], side: float
) -> Iterator[Call]:
    """Yield points outside a cube, in the plane of a face and on the line through an edge."""
    out = np.array([[1.0, 1.5, 0.25], [-1.25, 0.5, -1.0], [1.0, 1.0, 1.5], [-1.0, 1.75, 1.0]])
    middle, around, eight = cube
    at = middle + side * random.permutation(out)
    for size, words in ((1.0, ""), (2.0**-30, ", the size 10⁻⁹"), (2.0**30, ", the size 10⁹")):
        yield Call(
            "coordinates",
            (size * middle, size * around, eight, size * at),
            f"points in the planes of the faces, outside a cube{words}",
            exact=(0, 1, 3),
        )


def more_cells(random: np.random.Generator, first: Star, x: np.ndarray) -> Iterator[Call]:
    """Yield other points in the first cell and the same ones in others, cells far away, integers,
    and many points and neighbours.
    """
    name = "coordinates"
    center, neighbors, cells, corners = first
    other = points_inside(random, center, corners, len(x))
    once = enlarged(center, neighbors)
    yield Call(name, (center, neighbors, cells, other), "other points in the first cell")
    yield Call(name, (center, once, cells, x), "the first points in a larger cell")
    yield Call(
        name, (center, enlarged(center, once), cells, x), "the first points in a still larger cell"
    )
    yield Call(name, (center, neighbors, cells[::-1], x), "the first cell, tetrahedra reversed")
    yield Call(name, (1e6 * center, 1e6 * neighbors, cells, 1e6 * x), "three points, the size 10⁶")
    for at, words in ((x, "three points"), (other[:2], "two points")):
        far = moved(center), moved(neighbors), cells, moved(at)
        yield Call(name, far, f"{words} in a cell 10⁴ away", exact=(0, 1, 3))
    for _ in range(2):
        middle, half = random.integers(-9, 10, 3), random.integers(2, 9, 3)
        places = middle + half * random.uniform(-0.7, 0.7, (2, 3))
        around, eight, _corners = cuboid(1.0 * middle, half)
        yield Call(name, (middle, around, eight, places), "a vertex in an array of integers")
    for n, m, case in (
        (3, 69, "69 points in a cell of five neighbours"),
        (41, 2, "two points in a cell of 43 neighbours"),
    ):
        center, neighbors, cells, corners = star(random, n)
        inside = points_inside(random, center, corners, m)
        yield Call(name, (center, neighbors, cells, inside), case)
    for n, words in ((4, "six"), (5, "seven")):
        yield from special_cells(random, star(random, n), f"in a cell of {words} neighbours")


def special_cells(random: np.random.Generator, cell: Star, words: str) -> Iterator[Call]:
    """Yield the vertex among the points, integers, and a small cell."""
    name = "coordinates"
    center, neighbors, cells, corners = cell
    x = points_inside(random, center, corners, 3)
    at = np.vstack([x[:1], center, x[1:2]])
    yield Call(name, (center, neighbors, cells, at), f"the vertex and two points {words}")
    yield Call(
        name,
        (300 * center, integers(neighbors), cells, integers(x)),
        f"neighbours and three points in arrays of integers, {words}",
    )
    yield Call(
        name,
        (integers(center), 300 * neighbors, cells, integers(x)),
        f"a vertex and three points in arrays of integers, {words}",
    )
    small, tips, places = beside_the_origin(random, center, neighbors, x)
    case = f"three points {words}, of the size 10⁻⁸, beside the origin"
    yield Call(name, (small, tips, cells, places), case, exact=(0, 1, 3))


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
        "08.7",
        "weights",
        3,
        also_at_zero(weights_inputs, points=(0, 1, 3, 4)),
        lambda call: ((len(call.arguments[2]),),),
        (scales, balances),
        may_call=("08.2", "08.4"),
    ),
    Question(
        "08.8",
        "heights",
        1,
        also_at_zero(heights_inputs, points=(0, 1, 2)),
        lambda call: ((len(call.arguments[1]), len(call.arguments[2])),),
        (vanishes_half_way,),
    ),
    Question(
        "08.10",
        "coordinates",
        3,
        also_at_zero(coordinates_inputs, points=(0, 1, 3)),
        lambda call: ((len(call.arguments[3]), len(call.arguments[2])),),
        (
            sum_to_one,
            is_rotation_invariant,
            is_right_on_the_cube,
            has_negative_coordinates_outside,
        ),
    ),
)
