"""Questions of notebook 07 on Voronoi coordinates, which divide by distances to the edges.

A star is made from its cell: the neighbours of a point are its mirror images in the edges of a
convex polygon around it. The circumcentres are therefore known and need not be computed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of
from fieldcheck.inputs.variants import one_changed
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative

Star = tuple[np.ndarray, np.ndarray, np.ndarray]
SLOPES = np.array([2.0, -1.0])
LEAST_COSINE = 1e-3


def star(random: np.random.Generator, n: int, clockwise: bool = False) -> Star:
    """Return a vertex, its n neighbours in order, and the corners of its Voronoi cell."""
    angle = (np.arange(n) + random.uniform(0.1, 0.9, n)) * (-1 if clockwise else 1) * 2 * np.pi / n
    tilt = random.uniform(0, np.pi)
    turned = np.array([[np.cos(tilt), -np.sin(tilt)], [np.sin(tilt), np.cos(tilt)]])
    corners = np.column_stack([1.3 * np.cos(angle), np.sin(angle)]) @ turned + random.normal(size=2)
    center = corners.mean(axis=0) + random.uniform(-0.1, 0.1, 2)
    return center, mirror_images(center, corners), corners


def mirror_images(center: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the mirror images of a point in the lines from each corner of a polygon to the
    previous corner.
    """
    back = np.array([corners[-1], *corners[:-1]]) - corners
    across = back @ [[0, -1], [1, 0]]
    part = np.einsum("ak,ak->a", corners - center, across) / np.einsum("ak,ak->a", across, across)
    return center + 2 * part[:, None] * across


def points_inside(
    random: np.random.Generator, center: np.ndarray, corners: np.ndarray, m: int
) -> np.ndarray:
    """Return m points well inside a cell."""
    return center + 0.8 * (random.dirichlet(np.ones(len(corners)), m) @ corners - center)


def point_for_weights(
    random: np.random.Generator, center: np.ndarray, rim: np.ndarray, corners: np.ndarray
) -> np.ndarray:
    """Return a point well inside a cell, from which no direction to a corner is perpendicular to a
    spoke. An answer that multiplies the two would otherwise divide by a rounding error.
    """
    while True:
        (x,) = points_inside(random, center, corners, 1)
        if least_cosine(x, center, rim, corners) > LEAST_COSINE:
            return x


def points_outside(center: np.ndarray, corners: np.ndarray, far: float = 1.15) -> np.ndarray:
    """Return one point just outside each edge of a cell, beyond the middle of the edge."""
    middles = 0.5 * corners + 0.5 * np.array([*corners[1:], corners[0]])
    return center + far * (middles - center)


def point_outside(center: np.ndarray, rim: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return a point just outside a cell, from which no direction to a corner is perpendicular to a
    spoke; see `point_for_weights`.
    """
    tried = np.concatenate([points_outside(center, corners, far) for far in (1.12, 1.15, 1.18)])
    return max(tried, key=lambda x: least_cosine(x, center, rim, corners))


def least_cosine(x: np.ndarray, center: np.ndarray, rim: np.ndarray, corners: np.ndarray) -> float:
    """Return the least absolute cosine of the angles between spokes and directions to corners."""
    spokes = (rim - center) / np.linalg.norm(rim - center, axis=1, keepdims=True)
    ways = (corners - x) / np.linalg.norm(corners - x, axis=1, keepdims=True)
    return float(np.abs(ways @ spokes.T).min())


def octagon(random: np.random.Generator) -> np.ndarray:
    """Return the corners of an irregular octagon.

    It and the mirror images of its mean are exact in floating-point numbers: each side is parallel
    to an axis or a diagonal, with a power of two as length.
    """
    sides = [[8, 0], [1, 1], [0, 2], [-4, 4], [-4, 0], [-2, -2], [0, -4], [1, -1]]
    whole = np.roll(sides, random.integers(8), axis=0).cumsum(axis=0)
    return 2.0 ** int(random.integers(-2, 3)) * (whole + random.integers(-9, 9, 2))


INTEGERS = (
    "three points in a cell of eight neighbours, integers",
    "one point in a cell of four neighbours, integers",
)
"""The cases of `cells_of_integers`."""


def cells_of_integers(random: np.random.Generator) -> tuple[tuple[Star, np.ndarray], ...]:
    """Return a cell of eight corners with three points inside, and one of four with one point.

    Corners and points are arrays of integers. Vertices and neighbours have the type float, since a
    right answer may normalize their differences in place.
    """
    large = 32 * octagon(random)  # multiples of eight, so that their mean is an integer
    middle, half = random.integers(-90, 90, 2), random.integers(20, 90, 2)
    small = 1.0 * middle + half * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    cells = []
    for corners, m in ((large, 3), (small, 1)):
        center = corners.mean(axis=0)
        cell = center, mirror_images(center, corners), corners.astype(int)
        tried = np.rint(points_inside(random, center, corners, 50)).astype(int)
        seen = [x for x in tried if least_cosine(x, *cell) > LEAST_COSINE]
        cells.append((cell, np.array(seen[:m])))
    return tuple(cells)


def cells_with_integer_vertices(
    random: np.random.Generator,
) -> Iterator[tuple[Star, np.ndarray, str]]:
    """Yield cells of integers, points inside, and words: the neighbours are integers too, or the
    vertex is, but not both.
    """
    cells = cells_of_integers(random)
    for ((center, rim, corners), inside), n in zip(cells, ("eight", "four"), strict=True):
        yield (center, np.rint(rim).astype(int), corners), inside, f"{n} neighbours in integers"
        yield (center.astype(int), rim, corners), inside, f"{n} neighbours, a vertex in integers"


def enlarged(cell: Star) -> Star:
    """Return the cell of the same vertex with neighbours at one and a half times the distance."""
    center, *others = cell
    rim, corners = (center + 1.5 * (part - center) for part in others)
    return center, rim, corners


def with_a_vertex_in_view(random: np.random.Generator, n: int) -> Star:
    """Return a star whose vertex has no direction to a corner that is perpendicular to a spoke; see
    `point_for_weights`.
    """
    while True:
        cell = star(random, n)
        if least_cosine(cell[0], *cell) > LEAST_COSINE:
            return cell


def reproduction_error(omega: np.ndarray, corners: np.ndarray, x: np.ndarray) -> float:
    """Return the difference between the weighted mean of the corners and the evaluation point."""
    return relative(omega @ corners - x, corners - x.mean(axis=0))


# 07.4 Weights


def weights_inputs(seed: int) -> tuple[Call, ...]:
    """Return points in stars of six and five neighbours, of three sizes, outside, and integers."""
    random = np.random.default_rng(seed)
    calls = []
    for n, clockwise, case in (
        (6, False, "six neighbours"),
        (5, True, "five neighbours, listed clockwise"),
    ):
        center, rim, corners = star(random, n, clockwise)
        x = point_for_weights(random, center, rim, corners)
        calls.append(Call("weights", (center, rim, corners, x), case))
    double = tuple(2 * part for part in calls[0].arguments)
    calls.append(Call("weights", double, "six neighbours, everything twice as large"))
    for n, clockwise in ((5, False), (6, True)):
        center, rim, corners = star(random, n, clockwise)
        x = point_outside(center, rim, corners)
        case = f"a point outside the cell of {n} neighbours"
        calls.append(Call("weights", (center, rim, corners, x), case))
    for call in calls[:2]:
        tiny = tuple(1e-12 * part for part in call.arguments)
        calls.append(Call("weights", tiny, f"{call.case}, everything of the size 10⁻¹²"))
    cases = ("eight neighbours, integers", "four neighbours, integers")
    for (cell, inside), case in zip(cells_of_integers(random), cases, strict=True):
        calls.append(Call("weights", (*cell, inside[0]), case))
    for cell, inside, case in cells_with_integer_vertices(random):
        calls.append(Call("weights", (*cell, inside[0]), case))
    for call in calls[:2]:
        huge = tuple(1e9 * part for part in call.arguments)
        calls.append(Call("weights", huge, f"{call.case}, everything of the size 10⁹"))
        center, rim, corners, x = call.arguments
        other = point_for_weights(random, center, rim, corners)
        calls.append(Call("weights", (center, rim, corners, other), f"{call.case}, another point"))
        larger = (*enlarged((center, rim, corners)), x)
        calls.append(Call("weights", larger, f"{call.case}, the same point in a larger cell"))
    many = star(random, 43)
    calls.append(Call("weights", (*many, point_for_weights(random, *many)), "43 neighbours"))
    for n, words in ((6, "six"), (5, "five")):
        cell = with_a_vertex_in_view(random, n)
        calls.append(
            Call("weights", (*cell, cell[0].copy()), f"the vertex among {words} neighbours")
        )
    return tuple(calls)


@law_of_each(
    "The vectors from the point to the corners, multiplied by the weights, must sum to zero."
)
def balances(call: Call, values: Values) -> float:
    """Return the weighted sum of the vectors to the corners, which must vanish."""
    (w,) = values
    *_, corners, x = call.arguments
    pulls = w[:, None] * (corners - x)
    return relative(pulls.sum(axis=0), pulls)


@law(
    "If everything is twice as large, each weight must be a quarter: (7.5) has four times the area "
    "above and sixteen times as much below."
)
def scales(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the weights from a quarter at twice the size."""
    (here,), _other, (double,) = values[:3]
    return relative(4 * double - here, here)


# 07.5 Coordinates


def coordinates_inputs(seed: int) -> tuple[Call, ...]:
    """Return evaluation points in stars of six, three and seven neighbours, and outside."""
    random = np.random.default_rng(seed)
    calls = []
    for n, m, clockwise, case in (
        (6, 4, False, "four points in a cell of six neighbours"),
        (3, 8, False, "eight points in a cell of three neighbours"),
        (7, 5, True, "five points in a cell of seven neighbours, listed clockwise"),
        (4, 4, True, "four points in a cell of four neighbours"),
        (5, 5, False, "five points in a cell of five neighbours"),
    ):
        center, rim, corners = star(random, n, clockwise)
        calls.append(
            Call(
                "coordinates",
                (center, rim, corners, points_inside(random, center, corners, m)),
                case,
            )
        )
    for n, case in ((5, "points outside a cell"), (6, "points outside another cell")):
        center, rim, corners = star(random, n)
        near = points_outside(center, corners, 1.002)[0]
        x = [point_outside(center, rim, corners), *points_inside(random, center, corners, 2), near]
        calls.append(Call("coordinates", (center, rim, corners, np.array(x)), case))
    for call in (calls[0], calls[4]):
        for size, words in ((1e6, "10⁶"), (1e-6, "10⁻⁶")):
            scaled = tuple(size * part for part in call.arguments)
            calls.append(Call("coordinates", scaled, f"{call.case}, of the size {words}"))
    for (cell, inside), case in zip(cells_of_integers(random), INTEGERS, strict=True):
        calls.append(Call("coordinates", (*cell, inside), case))
    for cell, inside, case in cells_with_integer_vertices(random):
        calls.append(Call("coordinates", (*cell, inside), case))
    for call in (calls[0], calls[4]):
        center, rim, corners, x = call.arguments
        other = points_inside(random, center, corners, len(x))
        calls.append(
            Call("coordinates", (center, rim, corners, other), f"{call.case}, other points")
        )
        larger = (*enlarged((center, rim, corners)), x)
        calls.append(Call("coordinates", larger, f"{call.case}, the same points in a larger cell"))
    for n, m, case in (
        (5, 69, "69 points in a cell of five neighbours"),
        (43, 2, "two points in a cell of 43 neighbours"),
    ):
        center, rim, corners = star(random, n)
        inside = points_inside(random, center, corners, m)
        calls.append(Call("coordinates", (center, rim, corners, inside), case))
    for call in (calls[0], calls[4]):
        for size, words in ((1e-12, "10⁻¹²"), (2.0**30, "10⁹")):
            scaled = tuple(size * part for part in call.arguments)
            calls.append(Call("coordinates", scaled, f"{call.case}, of the size {words}"))
    for cell, inside, words in with_their_vertices(random):
        calls.append(Call("coordinates", (*cell, inside), words))
    return tuple(calls)


def with_their_vertices(random: np.random.Generator) -> Iterator[tuple[Star, np.ndarray, str]]:
    """Yield cells, points inside, of which one is the vertex, and words."""
    for n, k, words in ((6, 0, "six"), (5, 2, "five")):
        cell = with_a_vertex_in_view(random, n)
        x = points_inside(random, cell[0], cell[2], 3)
        x[k] = cell[0]
        yield cell, x, f"the vertex and two points in a cell of {words} neighbours"


@law_of_each("The coordinates of a point must sum to one, so that a constant is reproduced.")
def sum_to_one(_: Call, values: Values) -> float:
    """Return the deviation of row sums from one."""
    return float(np.abs(values[0].sum(axis=1) - 1).max())


@law_of_each("The mean of the corners with these weights must be the point itself.")
def reproduces_positions(call: Call, values: Values) -> float:
    """Return the deviation of the weighted means of the corners from the evaluation points."""
    return reproduction_error(values[0], call.arguments[2], call.arguments[3])


# 07.6 The spiral


def uneven_cell(
    random: np.random.Generator, n: int, clockwise: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return a vertex and the corners of its cell, the first edge neither nearest nor farthest."""
    center, _, corners = star(random, n, clockwise)
    middles = corners + np.array([*corners[1:], corners[0]]) - 2 * center
    first = int(np.argsort(np.hypot(*middles.T))[n // 2])
    return center, np.roll(corners, -first, axis=0)


def odd_rectangle(random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return the midpoint and the corners of a rectangle; the corners are integers.

    The midpoint of the first two is none, since the width is odd.
    """
    sides = 2 * random.integers(20, 90, 2) + np.array([1, 0])
    corners = random.integers(-90, 90, 2) + sides * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    return corners.mean(axis=0), corners


def spiral_inputs(seed: int) -> tuple[Call, ...]:
    """Return an irregular cell, a hexagon, an irregular pentagon, listed clockwise, and cells of
    integers.
    """
    random = np.random.default_rng(seed)
    center, corners = uneven_cell(random, 6, False)
    other, five = uneven_cell(random, 5, True)
    turns = np.exp(1j * (random.uniform(0, 1) + np.pi * np.arange(6) / 3))
    middle = random.normal(size=2)
    regular = middle + 0.7 * np.column_stack([turns.real, turns.imag])
    eight, four = ((cell[0].astype(int), cell[2]) for cell, _ in cells_of_integers(random))
    wide, high = odd_rectangle(random), odd_rectangle(random)
    calls = calls_of(
        "spiral",
        ((center, corners, 12), "twelve points in an uneven cell"),
        ((middle, regular, 50), "fifty points in a regular hexagon"),
        ((other, five, 7), "seven points in an uneven pentagon"),
        ((other, five, 170), "170 points"),
        ((other, five, 1), "one point"),
        ((*eight, 12), "twelve points in a cell of integers"),
        ((*four, 7), "seven points in a cell of integers"),
        ((*wide, 9), "nine points in a rectangle of odd width, integers"),
        (
            (high[0][::-1], high[1][:, ::-1], 5),
            "five points in a rectangle of odd height, integers",
        ),
        ((other, five, 61), "61 points"),
        ((middle, regular, 122), "122 points in a regular hexagon"),
        *(
            ((size * center, size * corners, 12), f"twelve points in a cell of the size {words}")
            for size, words in ((1e-9, "10⁻⁹"), (1e6, "10⁶"))
        ),
        *(
            ((size * other, size * five, 7), f"seven points in a cell of the size {words}")
            for size, words in ((1e-9, "10⁻⁹"), (1e6, "10⁶"))
        ),
    )
    return calls + tuple(
        changed
        for call, inner in ((calls[0], center), (calls[2], other))
        for changed in one_changed(
            call,
            ("another vertex", inner + random.uniform(-0.1, 0.1, 2)),
            ("a larger cell", inner + 1.5 * (call.arguments[1] - inner)),
        )
    )


@law_of_each(
    "The vectors from the centre to the points, the nth multiplied by n, must have one length. "
    "Each must be turned counter-clockwise from the one before by 2π/S, and the last must point "
    "to the right."
)
def winds_inwards(call: Call, values: Values) -> float:
    """Return the deviation of n (s_n − x_i) from one revolution of constant radius that ends on the
    right.
    """
    (s,) = values
    center, _, steps = call.arguments
    away = (s - center) @ [1, 1j] * (1 + np.arange(steps))
    with np.errstate(all="ignore"):
        turn = away / np.array([away[-1], *away[:-1]])
    return max(relative(turn - np.exp(2j * np.pi / steps), 1.0), relative(np.angle(away[-1]), 1.0))


# 07.7 The field


def interpolate_inputs(seed: int) -> tuple[Call, ...]:
    """Return a constant field, a linear field, and random values; also points outside of a cell."""
    random = np.random.default_rng(seed)
    calls = []
    for n, values, case in (
        (6, lambda p: np.full(len(p), 3.0), "the constant 3"),
        (6, lambda p: 1.0 + p @ SLOPES, "a linear field"),
        (5, lambda p: random.normal(size=len(p)), "values at random"),
    ):
        center, rim, corners = star(random, n)
        x = points_inside(random, center, corners, 4)
        calls.append(Call("interpolate", (center, rim, corners, values(corners), x), case))
    for n in (5, 6):
        center, rim, corners = star(random, n)
        first_edge = np.where(np.arange(n) < 2, 1.0, 0.25)
        x = points_outside(center, corners)
        case = f"points outside a cell of {n} neighbours, where values may exceed those given"
        calls.append(Call("interpolate", (center, rim, corners, first_edge, x), case))
    for n, m, clockwise, case in (
        (4, 4, True, "four points and four values, listed clockwise"),
        (8, 1, False, "one point and eight values"),
        (3, 7, True, "seven points and three values, listed clockwise"),
    ):
        center, rim, corners = star(random, n, clockwise)
        whole = random.permutation(n) + 1
        x = points_inside(random, center, corners, m)
        calls.append(Call("interpolate", (center, rim, corners, whole, x), case))
    for (cell, inside), case in zip(cells_of_integers(random), INTEGERS, strict=True):
        calls.append(Call("interpolate", (*cell, random.normal(size=len(cell[1])), inside), case))
    for cell, inside, case in cells_with_integer_vertices(random):
        calls.append(Call("interpolate", (*cell, random.normal(size=len(cell[1])), inside), case))
    for call in (calls[1], calls[2]):
        center, rim, corners, phi, x = call.arguments
        same = center, rim, corners
        for given, at, words in (
            ((*same, random.normal(size=len(phi))), x, "other values"),
            ((*same, phi), points_inside(random, center, corners, len(x)), "other points"),
            ((*enlarged(same), phi), x, "the same points in a larger cell"),
        ):
            calls.append(Call("interpolate", (*given, at), f"{call.case}, {words}"))
        for size, words in ((1e6, "10⁶"), (1e-9, "10⁻⁹")):
            scaled = (*(size * part for part in same), phi, size * x)
            calls.append(Call("interpolate", scaled, f"{call.case}, a cell of the size {words}"))
        calls.append(Call("interpolate", (*same, 1e-12 * phi, x), f"{call.case} times 10⁻¹²"))
    for n, m, case in (
        (3, 69, "69 points and three values"),
        (4, 101, "101 points and four values"),
        (43, 3, "three points and 43 values"),
    ):
        center, rim, corners = star(random, n)
        x = points_inside(random, center, corners, m)
        calls.append(Call("interpolate", (center, rim, corners, random.normal(size=n), x), case))
    for cell, x, case in with_their_vertices(random):
        calls.append(Call("interpolate", (*cell, random.normal(size=len(cell[1])), x), case))
    return tuple(calls)


@law("A constant field must be reproduced.")
def reproduces_constants(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the first field from three."""
    return relative(values[0][0] - 3.0, 3.0)


@law("A linear field must be reproduced.")
def reproduces_linear_fields(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the second field from the linear field."""
    return relative(values[1][0] - 1.0 - calls[1].arguments[4] @ SLOPES, calls[1].arguments[3])


def per_point(call: Call, x: int) -> tuple[tuple[int, ...], ...]:
    return ((len(call.arguments[x]), len(call.arguments[1])),)


QUESTIONS = (
    Question(
        "07.4",
        "weights",
        3,
        also_at_zero(weights_inputs, points=(0, 1, 2, 3)),
        lambda call: ((len(call.arguments[1]),),),
        (scales, balances),
    ),
    Question(
        "07.5",
        "coordinates",
        2,
        also_at_zero(coordinates_inputs, points=(0, 1, 2, 3)),
        lambda call: per_point(call, 3),
        (sum_to_one, reproduces_positions),
    ),
    Question(
        "07.6",
        "spiral",
        2,
        also_at_zero(spiral_inputs, points=(0, 1)),
        lambda call: ((call.arguments[2], 2),),
        (winds_inwards,),
    ),
    Question(
        "07.7",
        "interpolate",
        1,
        also_at_zero(interpolate_inputs, points=(0, 1, 2, 4), values=(3,)),
        lambda call: ((len(call.arguments[4]),),),
        (reproduces_constants, reproduces_linear_fields),
    ),
)
