"""Questions of notebook 05 on the velocities at the vertices: rings, systems, and ranks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, in_short_binary_numbers, integers
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative
from fieldcheck.questions.q04_rank_of_normals import along_axes
from fieldcheck.questions.q05_edges import directions, mesh, sides

FITTED = 1e-8
"""Rounding tolerance of systems whose condition number is some hundreds."""


# 05.6 The ring


def ring_inputs(seed: int) -> tuple[Call, ...]:
    """Return rings of a vertex inside and of one with the fewest triangles, and rings in strips."""
    random = np.random.default_rng(seed)
    triangles = mesh(random, 4, 4)[1]
    edges = sides(triangles, random)
    count = np.bincount(triangles.ravel())
    new = neighbour_of_valence_three(triangles)
    lonely = int(count.argmin())
    others = mesh(random, 5, 3)[1]
    inside = neighbour_of_valence_three(others)
    return calls_of(
        "ring",
        ((triangles, edges, new, 1), "one ring of a vertex inside"),
        ((triangles, edges, new, 2), "two rings of a vertex inside"),
        ((triangles, edges, lonely, 1), "one ring of a corner"),
        ((triangles, edges, lonely, 3), "three rings of a corner"),
        ((others, sides(others, random), inside, 1), "one ring in another mesh"),
        *(
            ((cells, sides(cells, random), first, rings), case)
            for numbers, n, rings, case in (
                ((6, 1, 0, 2, 3), 6, 2, "two rings at the end of a strip"),
                ((6, 3, 0, 1, 2), 6, 2, "two rings at the end of another strip"),
                ((6, 2, 0, 3, 1), 8, 3, "three rings at the end of a strip"),
                ((6, 2, 0, 3, 1), 10, 4, "four rings at the end of a strip"),
                ((6, 1, 0, 2, 3), 13, 5, "five rings at the end of a strip"),
                ((0, 4, 2, 3, 1), 6, 2, "two rings of vertex 0"),
                ((4, 113, 1013, 5, 13), 6, 1, "one ring, one vertex number beyond 1000"),
                ((34, 143, 1043, 35, 43), 8, 2, "two rings, one vertex number beyond 1000"),
                ((4, 21, 2, 5, 13), 6, 1, "one ring, eight vertices with numbers up to 90"),
                ((4, 23, 2, 5, 13), 8, 2, "two rings, ten vertices with numbers up to 90"),
            )
            for first, cells in [(numbers[0], strip(random, numbers, n))]
        ),
        *(
            ((cells, sides(cells, random), first, 2), f"two rings, {where} an edge outside")
            for where in ("and", "and again")
            for first, cells in [with_an_edge_outside(random)]
        ),
    )


def with_an_edge_outside(random: np.random.Generator) -> tuple[int, np.ndarray]:
    """Return a vertex and five triangles.

    The last triangle is not in two rings of the vertex, though its corners are in others that are.
    """
    cells = np.array([[0, 1, 2], [1, 2, 3], [1, 3, 4], [1, 4, 5], [3, 4, 5]])
    numbers = random.permutation(6)
    return int(numbers[0]), random.permuted(random.permutation(numbers[cells]), axis=1)


def strip(random: np.random.Generator, numbers: Sequence[int], n: int) -> np.ndarray:
    """Return n triangles in a strip whose first three and last two vertices have these numbers.

    With the numbers (4, 113, 1013, 5, 13) the edges (4, 113) and (4, 1013) at one end have the same
    numbers 100 i + j and 1000 i + j as the edge (5, 13) at the other end. With n + 2 vertices, the
    edges (4, 15 + n) and (5, 13) have the same number (n + 2) i + j.
    """
    between = 50 + random.permutation(40)[: n - 3]
    along = np.concatenate([numbers[:3], between, numbers[3:]])
    cells = along[np.arange(n)[:, None] + np.arange(3)]
    return random.permuted(random.permutation(cells), axis=1)


def neighbour_of_valence_three(triangles: np.ndarray) -> int:
    """Return a neighbour of a vertex with three triangles: two of its neighbours are joined."""
    for t in triangles:
        for middle in t:
            star = np.array([u for u in triangles if middle in u])
            if len(star) == 3 and len(np.unique(star)) == 4:
                return int(min(set(star.ravel().tolist()) - {int(middle)}))
    raise ValueError("no vertex of the mesh has three triangles around it")


@law_of_each(
    "Every edge that ends in the vertex must be in its ring.",
    amount="the number of missing edges at the vertex is {:.0f}",
)
def holds_the_spokes(call: Call, values: Values) -> float:
    """Return the number of edges at the vertex that are not selected."""
    (near,) = values
    _, edges, vertex, _ = call.arguments
    return float(np.count_nonzero(near[(edges == vertex).any(axis=1)] != 1))


@law_of_each(
    "The edges must be those of whole triangles, so each vertex must have none or at least two."
)
def made_of_triangles(call: Call, values: Values) -> float:
    """Return the share of ends of selected edges at which no other selected edge ends."""
    (near,) = values
    ends = np.bincount(call.arguments[1][near > 0.5].ravel())
    return float(np.mean(ends[ends > 0] < 2)) if ends.any() else 1.0


@law("A further ring must keep all edges of the rings before, and add some.")
def grows(calls: Sequence[Call], values: Sequence[Values]) -> float:
    lost = [(values[k][0] > values[k + 1][0]).mean() for k in (0, 2)]
    gained = [(values[k + 1][0] > values[k][0]).mean() for k in (0, 2)]
    return float(max(*lost, *(g == 0 for g in gained)))


# 05.7 and 05.8 The system, and the velocity at one point


def samples(random: np.random.Generator, number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return midpoints around a point, normals in all directions, and the point."""
    angle = 2 * np.pi * (np.arange(number) + random.uniform(-0.2, 0.2, number)) / number
    radius = np.where(np.arange(number) % 2, 1.0, 0.5) + random.uniform(-0.1, 0.1, number)
    turned = angle + 2 * np.pi * np.arange(number) / 3 + random.uniform(-0.2, 0.2, number)
    x = random.uniform(1, 2, 2)
    return x + radius[:, np.newaxis] * directions(angle), directions(turned), x


def system_inputs(seed: int) -> tuple[Call, ...]:
    """Return samples, the same translated together with the point, few samples, and integers."""
    random = np.random.default_rng(seed)
    p, n, x = samples(random, 9)
    few = samples(random, 4)
    near, place = in_short_binary_numbers(few[0]), in_short_binary_numbers(few[2])
    one, normal, at = samples(random, 1)
    level = np.where((np.arange(9) % 3)[:, np.newaxis] == [1, 2], x, p)
    return calls_of(
        "system",
        ((p, n, x), "nine samples"),
        ((p - 5.0, n, x - 5.0), "the same samples and the vertex, moved together"),
        (few, "four samples"),
        ((one, normal, at), "one sample"),
        (
            (one - 3.0, along_axes(random, 1, 2), at),
            "one sample, a normal of integers along the first axis",
        ),
        ((p, along_axes(random, 9, 2), x), "nine samples, normals of integers along the axes"),
        ((few[0], along_axes(random, 4, 2), few[2]), "four samples, normals of integers"),
        ((integers(p), n, integers(x)), "nine samples, midpoints and vertex of integers"),
        (
            (integers(few[0]), few[1], integers(few[2])),
            "four samples, midpoints and vertex of integers",
        ),
        ((level, n, x), "nine samples, some level with the vertex or right above it"),
        ((p * [1, 0], n, x * [1, 0]), "nine samples, all level with the vertex"),
        ((p * [0, 1], n, x * [0, 1]), "nine samples, all above or below the vertex"),
        ((1e-5 * p, n, 1e-5 * x), "nine samples, all lengths of the size 10⁻⁵"),
        ((1e-4 * few[0], few[1], 1e-4 * few[2]), "four samples, all lengths of the size 10⁻⁴"),
        ((1e5 * p, n, 1e5 * x), "nine samples, all lengths of the size 10⁵"),
        (samples(random, 67), "sixty-seven samples"),
        *((samples(random, 6), words) for words in ("six samples", "six other samples")),
        (
            (integers(p), along_axes(random, 9, 2), integers(x)),
            "nine samples, all numbers integers",
        ),
    ) + tuple(
        Call("system", (near + away, few[1], place + away), f"four samples {words}", exact=(0, 2))
        for away, words in ((2.0**26, "far from the origin"), (-(2.0**25), "in another place, far"))
    )


@law_of_each("Bʹ times the coefficients of a field must be its normal velocities at the midpoints.")
def gives_normal_velocities(call: Call, values: Values) -> float:
    """Return the deviation of B' c from the normal velocities of the field (2 + 3 y₂, −1 + y₁ + 4
    y₂).
    """
    (b,) = values
    p, n, x = call.arguments
    first, second = (p - x).T
    told = n[:, 0] * (2 + 3 * second) + n[:, 1] * (first + 4 * second - 1)
    return relative(b @ [2, -1, 0, 1, 3, 4] - told, told)


@law("Moving the edges together with the vertex must change nothing.")
def depends_on_differences_only(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[1][0] - values[0][0], values[0][0])


def linear_flow(p: np.ndarray) -> np.ndarray:
    """Return the velocities of a linear field with rotation, strain and translation."""
    return p @ np.array([[0.5, 2.0], [-1.0, 1.0]]) + np.array([1.0, -3.0])


def velocity_inputs(seed: int) -> tuple[Call, ...]:
    """Return random data, with an affine field added, translated, with other normals and weights,
    in other units of length, and from fewer edges than there are unknowns.
    """
    random = np.random.default_rng(seed)
    p, n, x = samples(random, 12)
    v, w = random.normal(size=12), random.uniform(0.4, 2.5, 12)
    v[[3, 7]] = 0.0  # two edges along a wall: equations like the others
    flips = np.where(np.arange(12) % 3, 1.0, -1.0)
    more = np.einsum("ak,ak->a", linear_flow(p), n)
    shift = np.array([-4.0, 3.0])
    other = samples(random, 10)
    uneven = np.geomspace(0.03, 1, 12) * np.where(np.arange(12) == 6, 100, 1)
    return calls_of(
        "velocity",
        ((p, n, v, x, w), "twelve edges with velocities at random"),
        ((p, n, v + more, x, w), "twelve edges, the velocities of an affine field added"),
        ((p + shift, n, v, x + shift, w), "the same edges, moved with the vertex"),
        ((p, flips[:, np.newaxis] * n, flips * v, x, w), "twelve edges, some normals reversed"),
        ((*other[:2], random.normal(size=10), other[2], np.ones(10)), "ten edges of equal weight"),
        ((1e-3 * p, n, v, 1e-3 * x, w), "the first edges, all lengths a thousandth"),
        ((1e3 * p, n, v, 1e3 * x, w), "the first edges, all lengths times a thousand"),
        ((p, n, v, x, uneven), "the first edges, one weight far above the others"),
        ((p, n, v, x, uneven[::-1]), "the first edges, another weight far above the others"),
        ((p, n, v, x, np.geomspace(1, 3e-4, 12)), "the first edges, weights from 0.0003 to 1"),
        ((p, n, v, x, np.geomspace(3e-4, 1, 12)), "the first edges, weights from 1 to 0.0003"),
        *(
            ((size * p, n, v, size * x, w), f"the first edges, all lengths times {words}")
            for size, words in ((1e-8, "10⁻⁸"), (1e-6, "10⁻⁶"), (1e6, "10⁶"))
        ),
        *(
            ((p, n, random.normal(size=few), x, random.uniform(0.4, 2.5, few)), case)
            for few, case in (
                (5, "five edges"),
                (4, "four edges"),
                (5, "five other edges"),
                (43, "forty-three edges"),
                (67, "sixty-seven edges"),
                (101, "101 edges"),
            )
            for p, n, x in [samples(random, few)]
        ),
        *(
            ((p, n, size * v, x, w), f"the first edges, velocities of the size {words}")
            for size, words in ((1e-5, "10⁻⁵"), (1e-12, "10⁻¹²"), (1e5, "10⁵"), (1e9, "10⁹"))
        ),
        *(
            ((p, n, v, x, size * w), f"the first edges, all weights times {words}")
            for size, words in ((1e-10, "10⁻¹⁰"), (1e-12, "10⁻¹²"), (1e9, "10⁹"))
        ),
        ((integers(p, 10), n, v, integers(x, 10), w), "midpoints and vertex of integers"),
        (
            (p, along_axes(random, 12, 2), integers(v), x, random.integers(1, 5, 12)),
            "normals, velocities and weights of integers",
        ),
        ((p, n, integers(v), x, random.integers(1, 5, 12)), "velocities and weights of integers"),
        ((p, n, 0 * v, x, w), "no flow"),
        *(
            (level_with_the_vertex(random, number), f"{words} edges, all level with the vertex")
            for number, words in ((4, "four"), (8, "eight"), (6, "six"))
        ),
    )


def level_with_the_vertex(random: np.random.Generator, number: int) -> tuple[np.ndarray, ...]:
    """Return edges whose equations do not contain the slopes along the second axis.

    So the matrix of the normal equations has rows of zeros, and is singular without rounding.
    """
    x = random.uniform(1, 2, 2) * [1, 0]
    along = np.linspace(-1, 1, number) + random.uniform(-0.1, 0.1, number)
    p = np.column_stack([x[0] + along, np.zeros(number)])
    angles = np.resize([0.3, 1.9], number) + random.uniform(-0.2, 0.2, number)
    return p, directions(angles), random.normal(size=number), x, random.uniform(0.4, 2.5, number)


@law(
    "Adding the normal velocities of an affine field to the data must add the value of this field "
    "at the vertex.",
    FITTED,
)
def reproduces_affine_fields(calls: Sequence[Call], values: Sequence[Values]) -> float:
    told = linear_flow(calls[0].arguments[3])
    return relative(values[1][0] - values[0][0] - told, np.abs(values[1][0]).max() + 1)


@law("Moving the edges together with the vertex must change nothing.", FITTED)
def moves_along(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[2][0] - values[0][0], np.abs(values[0][0]).max() + 1)


@law(
    "If the six unknowns are determined, another unit of length must not change the velocity.",
    FITTED,
)
def unit_of_length(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return max(
        relative(values[k][0] - values[0][0], np.abs(values[0][0]).max() + 1) for k in (5, 6)
    )


@law("Reversing a normal together with its normal velocity must change nothing.", FITTED)
def side_of_the_normal(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[3][0] - values[0][0], np.abs(values[0][0]).max() + 1)


# 05.9 The ranks


def grid_of_squares(rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points and triangles of a regular grid with alternating diagonals.

    At some vertices more points than six lie on one conic.
    """
    number = np.arange((rows + 1) * (columns + 1)).reshape(rows + 1, columns + 1)
    points = np.stack(np.divmod(number.ravel(), columns + 1), axis=1).astype(float)
    cells = []
    for r, c in np.ndindex(rows, columns):
        a, b, d, e = number[r : r + 2, c : c + 2].ravel()
        cells += [[a, b, d], [e, d, b]] if (r + c) % 2 else [[a, b, e], [a, e, d]]
    return points, np.array(cells)


def nearly(random: np.random.Generator, points: np.ndarray) -> np.ndarray:
    """Return moved points of a grid: the smallest singular values are small, and not zero."""
    return points + 5e-3 * random.uniform(-1, 1, points.shape)


def with_a_tiny_part(random: np.random.Generator, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a mesh in two parts, one of them small."""
    (p, one), (q, two) = mesh(random, 3, 2), mesh(random, 2, 2)
    return np.append(p, size * q + [1.5, -0.5], axis=0), np.append(one, two + len(p), axis=0)


def uneven_strip(random: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a strip of n triangles, whose points are on no conic.

    Three rings of the first vertex have six points; two rings have five, and rank five.
    """
    steps = np.arange(n + 2)
    points = np.column_stack([steps / 2, steps % 2]) + random.uniform(-0.25, 0.25, (n + 2, 2))
    triangles = np.arange(n)[:, None] + np.arange(3)
    return points, random.permuted(random.permutation(triangles), axis=1)


def nearly_on_two_lines(
    random: np.random.Generator, height: float, hub: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return a fan of four triangles about a vertex, whose points are on two lines up to a height.

    Two lines are a conic through all six points, so the smallest singular value of this vertex is
    about 0.4 times the height.
    """
    along = np.array([0, -1, -1, 0, 1, 1]) + random.uniform(-0.1, 0.1, 6)
    axes = directions(random.uniform(0, 2 * np.pi) + np.array([0, np.pi / 2]))
    points = np.column_stack([along, [0, 0, 1, 1 + height, 1, 0]]) @ axes
    return np.roll(points, hub, axis=0), (np.add([[0, k, k + 1] for k in range(1, 5)], hub)) % 6


def ranks_inputs(seed: int) -> tuple[Call, ...]:
    """Return a mesh with one and two rings, far from the origin, in small units; regular grids."""
    random = np.random.default_rng(seed)
    points, triangles = mesh(random, 4, 4)
    regular, squares = grid_of_squares(4, 4)
    longer, oblong = grid_of_squares(3, 5)
    return (
        *calls_of(
            "ranks",
            ((points, triangles, 1), "one ring"),
            ((points, triangles, 2), "two rings"),
            ((points + 1e6, triangles, 1), "the same mesh, 10⁶ away"),
            ((1e-12 * points, triangles, 1), "the same mesh in a square of 10⁻¹²"),
            ((1e-13 * points, triangles, 2), "two rings of the same mesh in a square of 10⁻¹³"),
        ),
        Call("ranks", (regular, squares, 1), "a regular grid of four by four squares", (0,)),
        Call("ranks", (longer - 1e6, oblong, 1), "a regular grid of three by five squares", (0,)),
        Call("ranks", (*grid_of_squares(1, 2), 2), "two rings in a mesh of two squares", (0,)),
        *calls_of(
            "ranks",
            ((nearly(random, regular), squares, 1), "a grid that is nearly regular"),
            ((nearly(random, longer), oblong, 1), "an oblong grid that is nearly regular"),
            ((integers(points, 1e4), triangles, 1), "a mesh of integers"),
            ((1e8 * points, triangles, 1), "the same mesh in a square of 10⁸"),
            ((*mesh(random, 7, 6), 1), "a mesh of eighty-six triangles"),
            ((*with_a_tiny_part(random, 1e-5), 1), "a mesh and a tiny one beside it"),
            ((*with_a_tiny_part(random, 1e-4), 2), "two rings of a mesh and of a tiny one"),
            *(
                ((unit * points, cells, 1), f"a fan of points within {height} of two lines{where}")
                for k, (height, size) in enumerate((("10⁻⁴", 1e-4), ("10⁻⁷", 1e-7), ("10⁻⁸", 1e-8)))
                for n, unit, where in ((0, 1.0, ""), (3, 1e3, ", all lengths times a thousand"))
                for points, cells in [nearly_on_two_lines(random, size, k + n)]
            ),
        ),
        Call("ranks", (regular.astype(int), squares, 1), "a regular grid of integers", (0,)),
        Call(
            "ranks", (np.array([[0, 0], [4, 1], [1, 3]]), np.array([[2, 0, 1]]), 1), "one triangle"
        ),
        *calls_of(
            "ranks",
            ((*uneven_strip(random, 8), 3), "three rings in a strip of eight triangles"),
            ((*uneven_strip(random, 10), 3), "three rings in a strip of ten triangles"),
        ),
    )


@law_of_each(
    "The rank must be between three and six: a ring has at least the three edges of a triangle, "
    "and Bʹ has six columns.",
    amount="a rank is outside of these limits by {:.0f}",
)
def rank_between(_: Call, values: Values) -> float:
    """Return by how much the least or the largest rank is beyond its limit."""
    (r,) = values
    return float(max(3 - r.min(), r.max() - 6, 0))


@law(
    "The rank must depend only on the shape of the mesh, not on its position or the unit of length."
)
def rank_of_the_shape(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return float(max(np.abs(values[k][0] - values[0][0]).max() for k in (2, 3)))


@law("A second ring adds edges, so no rank may decrease, and some must increase.")
def rank_grows(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return float(max(np.any(values[1][0] < values[0][0]), np.all(values[1][0] == values[0][0])))


QUESTIONS = (
    Question(
        "05.6",
        "ring",
        3,
        ring_inputs,
        lambda call: ((len(call.arguments[1]),),),
        (holds_the_spokes, made_of_triangles, grows),
    ),
    Question(
        "05.7",
        "system",
        3,
        also_at_zero(system_inputs, points=(0, 2)),
        lambda call: ((len(call.arguments[0]), 6),),
        (gives_normal_velocities, depends_on_differences_only),
    ),
    Question(
        "05.8",
        "velocity",
        4,
        also_at_zero(velocity_inputs, points=(0, 3), values=(2,)),
        lambda _: ((2,),),
        (reproduces_affine_fields, moves_along, unit_of_length, side_of_the_normal),
        lambda _: FITTED,
    ),
    Question(
        "05.9",
        "ranks",
        3,
        also_at_zero(ranks_inputs, points=(0,)),
        lambda call: ((len(call.arguments[0]),),),
        (rank_between, rank_of_the_shape, rank_grows),
    ),
)
