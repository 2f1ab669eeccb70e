"""Questions of notebook 05 on the edges of a triangle mesh and the velocities across them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, in_short_binary_numbers, integers
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative
from fieldcheck.questions.q04_rank_of_normals import along_axes

AWAY = 2.0**20
"""A distance of about a million."""

ACROSS = np.array([0.62, 0.78])
"""A direction to which no edge of a random mesh is parallel."""


def mesh(random: np.random.Generator, columns: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points and triangles of a jittered grid of squares, cut along either diagonal.

    One triangle is split by an additional inner point. Numbering and orientation are random.
    """
    steps = np.stack(np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0)), axis=-1)
    points = (steps + random.uniform(-0.22, 0.22, steps.shape)).reshape(-1, 2) / max(columns, rows)
    number = np.arange(len(points)).reshape(rows + 1, columns + 1)
    cells = []
    for r, c in np.ndindex(rows, columns):
        around = [number[r, c], number[r, c + 1], number[r + 1, c + 1], number[r + 1, c]]
        k = random.integers(2)
        cells += [
            [around[k], around[k + 1], around[k + 2]],
            [around[k + 2], around[k - 1], around[k]],
        ]
    middle = 2 * (columns * (rows // 2) + columns // 2)
    old, new = cells.pop(middle), len(points)
    points = np.vstack([points, random.dirichlet((8, 8, 8)) @ points[old]])
    cells += [[old[k - 1], old[k], new] for k in range(3)]
    place = random.permutation(new + 1)
    turned = np.array(
        [np.roll(cell[:: random.choice((-1, 1))], random.integers(3)) for cell in cells]
    )
    return points[np.argsort(place)], place[random.permutation(turned)]


def sides(triangles: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Return the pairs of vertices that are edges, each once, in random order and direction."""
    pairs = {frozenset((t[k], t[k - 1])) for t in triangles.tolist() for k in range(3)}
    listed = np.array(sorted(tuple(pair) for pair in pairs))
    return random.permuted(listed, axis=1)[random.permutation(len(listed))]


def directions(angle: np.ndarray) -> np.ndarray:
    """Return unit vectors with these angles."""
    turned = np.exp(1j * angle)
    return np.column_stack([turned.real, turned.imag])


# 05.1 The edges


def edges_inputs(seed: int) -> tuple[Call, ...]:
    """Return two meshes, a single triangle, and a part of a mesh."""
    random = np.random.default_rng(seed)
    return calls_of(
        "edges_of",
        ((mesh(random, 3, 3)[1],), "a mesh of twenty triangles"),
        ((mesh(random, 4, 2)[1],), "a longer mesh"),
        ((random.permutation(3)[np.newaxis],), "one triangle"),
        ((part_of_a_mesh(random, 0),), "four triangles of a larger mesh"),
        ((part_of_a_mesh(random, 0, 1000),), "four triangles, one vertex number beyond 1000"),
        (
            (part_of_a_mesh(random, int(random.integers(1000, 1400))),),
            "four triangles, all vertex numbers beyond 1000",
        ),
        ((part_of_a_mesh(random, 0, 100),), "four triangles, one vertex number beyond 100"),
        ((random.permutation(RING),), "six triangles around a hole"),
        ((with_a_hole(mesh(random, 4, 3)[1]),), "a mesh with a hole"),
        ((np.array([[2, 0, 4], [1, 5, 3]]),), "two separate triangles"),
    )


RING = np.array([[0, 1, 3], [4, 3, 1], [1, 2, 4], [5, 4, 2], [2, 0, 5], [3, 5, 0]])


def with_a_hole(triangles: np.ndarray) -> np.ndarray:
    """Return a mesh without one of the triangles that have no side on the boundary."""
    sides_of = [[frozenset((t[k], t[k - 1])) for k in range(3)] for t in triangles.tolist()]
    count = Counter(side for three in sides_of for side in three)
    inner = [all(count[side] == 2 for side in three) for three in sides_of]
    return np.delete(triangles, inner.index(True), axis=0)


def part_of_a_mesh(random: np.random.Generator, first: int, base: int = 4) -> np.ndarray:
    """Return four triangles whose vertices have larger numbers than there are triangles.

    The edges (5, 9) and (4, 9 + b) have the same number b i + j for the base b, so it cannot stand
    for an edge.
    """
    far = 9 + base
    cells = np.array([[5, 9, far], [4, far, 9], [5, far, 7], [4, 9, 1]])
    return first + random.permuted(random.permutation(cells), axis=1)


def number_of_edges(triangles: np.ndarray) -> int:
    """Return the number of different sides of triangles."""
    return len({frozenset((t[k], t[k - 1])) for t in triangles.tolist() for k in range(3)})


def both_ends_known(_: Call, values: Values) -> Values:
    """Return the edges with the smaller number first, in lexicographic order."""
    low, high = values[0].min(axis=1), values[0].max(axis=1)
    order = np.lexsort([high, low])
    return (np.stack([low, high], axis=1)[order],)


@law_of_each("Each edge must occur once, also where two triangles share it.")
def no_edge_twice(_: Call, values: Values) -> float:
    (e,) = values
    return float(len(e) - len({frozenset(pair) for pair in e.tolist()}))


@law_of_each("The two ends of an edge must be different corners of one triangle.")
def ends_share_a_triangle(call: Call, values: Values) -> float:
    """Return the largest share of edges whose ends do not belong to a common triangle."""
    (e,) = values
    corners = [set(t) for t in call.arguments[0].tolist()]
    alone = [len(set(pair)) < 2 or not any(set(pair) <= t for t in corners) for pair in e.tolist()]
    return float(np.mean(alone))


# 05.2 Midpoints and normals


def normals_inputs(seed: int) -> tuple[Call, ...]:
    """Return a mesh, two edges parallel to the axes, and an elongated mesh in small units."""
    random = np.random.default_rng(seed)
    points, triangles = mesh(random, 3, 2)
    more, others = mesh(random, 2, 2)
    a, b = random.uniform(1, 3, 2)
    cross = np.array([[0.0, 0.0], [a, 0.0], [0.0, b]])
    square = np.array([[0, 0], [1, 1], [1, 0], [0, 1]])
    pairs = random.permutation([[0, 1], [3, 2], [2, 0], [1, 3]])
    corner, side = random.integers(-9, 9, 2), random.integers(3, 9)
    name, away = "midpoints_and_normals", AWAY * np.array([1, -1])
    near = calls_of(
        name,
        ((points, sides(triangles, random)), "the edges of a mesh"),
        (
            (1e-12 * (cross + np.array([5, -3])), np.array([[1, 0], [0, 2]])),
            "two edges parallel to the axes, of length 10⁻¹²",
        ),
        ((50 * more - 20, sides(others, random)), "a larger mesh"),
        ((integers(points, 1e4), sides(triangles, random)), "a mesh of integers"),
        ((integers(more, 1e4), sides(others, random)), "another mesh of integers"),
        (
            (integers(cross) + np.array([5, -3]), np.array([[0, 1], [2, 0]])),
            "two edges parallel to the axes, integers",
        ),
        ((points, sides(triangles, random)[:1]), "one edge of a mesh"),
        ((integers(more, 1e4), sides(others, random)[:1]), "one edge of a mesh of integers"),
        ((1e-12 * more, sides(others, random)), "a mesh in a square of 10⁻¹²"),
        ((1e6 * more, sides(others, random)), "a mesh in a square of 10⁶"),
        ((1e9 * points, sides(triangles, random)), "a mesh in a square of 10⁹"),
    )
    edges, fewer = sides(triangles, random), sides(others, random)
    constructed = (
        (a * square, pairs, "two sides and the diagonals of a square"),
        (corner + side * square, pairs, "two sides and the diagonals of a square, integers"),
        (in_short_binary_numbers(points) + away, edges, "a mesh 10⁶ away"),
        (in_short_binary_numbers(more) - away, fewer, "another mesh 10⁶ away"),
    )
    return (*near, *(Call(name, (p, e), case, exact=(0,)) for p, e, case in constructed))


def either_side(_: Call, values: Values) -> Values:
    """Return normals oriented to the side of a fixed direction."""
    midpoints, normals = values
    back = (normals @ ACROSS < 0)[:, np.newaxis]
    return midpoints, np.where(back, -normals, normals)


def ends_of(call: Call) -> tuple[np.ndarray, np.ndarray]:
    """Return both ends of the edges of a call."""
    points, edges = call.arguments
    one, other = np.moveaxis(np.take(points, edges, axis=0), 1, 0)
    return one, other


@law_of_each(
    "The vector from the first end to the midpoint must equal the vector from the midpoint to "
    "the second end."
)
def halfway(call: Call, values: Values) -> float:
    (a, b), (p, _) = ends_of(call), values
    return relative((p - a) - (b - p), b - a)


@law_of_each("A unit normal must have length one.")
def unit_length(_: Call, values: Values) -> float:
    return relative(np.hypot(*values[1].T) - 1, 1)


@law_of_each("A normal must be perpendicular to its edge.")
def across(call: Call, values: Values) -> float:
    (a, b), (_, n) = ends_of(call), values
    return relative(np.einsum("ek,ek->e", b - a, n), b - a)


# 05.3 The rotation


def rotation_inputs(seed: int) -> tuple[Call, ...]:
    """Return points of a mesh, the same translated, and points that are denser on one side."""
    random = np.random.default_rng(seed)
    points = mesh(random, 2, 2)[0]
    cloud = random.random((7, 2)) ** 2
    two = random.random((2, 2))
    return calls_of(
        "rotation",
        ((points,), "the vertices of a mesh"),
        ((points + np.array([3.0, -2.0]),), "the same vertices, moved"),
        ((cloud,), "seven points, more of them on one side"),
        ((integers(points),), "the vertices of a mesh, integers"),
        ((integers(cloud),), "seven points, integers"),
        ((cloud[:1],), "one point"),
        ((integers(cloud[1:2]),), "one point, integers"),
        ((crossing_lines(random, 3),), "five points on a horizontal and a vertical line"),
        ((crossing_lines(random, 4),), "seven points on a horizontal and a vertical line"),
        ((two,), "two points"),
        ((integers(two),), "two points, integers"),
        *(
            ((size * points,), f"the vertices of a mesh in a square of {words}")
            for size, words in ((1e-9, "10⁻⁹"), (1e-5, "10⁻⁵"), (1e5, "10⁵"), (1e9, "10⁹"))
        ),
        ((random.random((67, 2)),), "sixty-seven points"),
        *(
            ((cloud[[0, 1, 2, 3, *twice]],), f"{words} points, the last of them at one point")
            for twice, words in (((4, 4), "six"), ((5, 5, 5), "seven"))
        ),
    )


def crossing_lines(random: np.random.Generator, n: int) -> np.ndarray:
    """Return 2 n - 1 points on two lines parallel to the axes, the first one at the crossing."""
    along = random.permutation(n) + random.uniform(0, 0.5, n)
    level, upright = np.outer(along, [1, 0]), np.outer(np.roll(along, 1), [0, 1])
    return np.append(level - along[0] * np.array([1, 0]), (upright - upright[0])[1:], axis=0) + 0.3


@law_of_each(
    "In a rotation distances do not change: the difference of two velocities must be "
    "perpendicular to the line between the points."
)
def stays_rigid(call: Call, values: Values) -> float:
    """Return how fast distances between points change."""
    (u,) = values
    way, change = np.diff(call.arguments[0], axis=0), np.diff(u, axis=0)
    return relative(np.einsum("ek,ek->e", way, change), way**2)


@law_of_each("The rotation is about the mean of the points, so the velocities must add up to zero.")
def turns_about_the_mean(_: Call, values: Values) -> float:
    (u,) = values
    return relative(u.mean(axis=0), u)


# 05.4 Normal velocities


def normal_velocities_inputs(seed: int) -> tuple[Call, ...]:
    """Return velocities, with reversed normals, with exchanged ends, and a constant velocity;
    velocities and normals of integers, and one edge.
    """
    random = np.random.default_rng(seed)
    edges = sides(mesh(random, 2, 2)[1], random)
    normals = directions(random.uniform(0, 2 * np.pi, len(edges)))
    u = random.normal(size=(int(edges.max()) + 1, 2))
    wind = np.tile([1.0, 0.0], (len(u), 1))
    uneven = np.geomspace(1e-6, 1, len(u))[:, np.newaxis]
    more = sides(mesh(random, 4, 5)[1], random)[:67]
    level_or_upright = along_axes(random, len(edges), 2)
    return calls_of(
        "normal_velocities",
        ((edges, normals, u), "velocities at random"),
        ((edges, -normals, u), "velocities at random, the normals reversed"),
        (
            (edges[:, ::-1].copy(), normals, u),
            "velocities at random, the ends of each edge exchanged",
        ),
        ((edges, normals, wind), "the velocity (1, 0) at every vertex"),
        ((edges, normals, integers(u)), "velocities at random, integers"),
        ((edges, normals, random.permutation(integers(u))), "other velocities, integers"),
        ((edges, level_or_upright, u), "normals of integers along the axes"),
        ((edges, -level_or_upright, u[::-1].copy()), "other normals of integers along the axes"),
        ((np.array([[1, 0]]), normals[:1], u[:2]), "one edge between two vertices"),
        *(
            ((edges, normals, size * u), f"velocities of the size {words}")
            for size, words in ((1e-5, "10⁻⁵"), (1e-12, "10⁻¹²"), (1e5, "10⁵"), (1e9, "10⁹"))
        ),
        ((edges + 3, normals, u[np.arange(-3, len(u))]), "no edge of the first three vertices"),
        ((edges + 1, normals, u[np.arange(-1, len(u))]), "no edge of the first vertex"),
        ((edges, normals, uneven * u), "velocities of sizes from 10⁻⁶ to 1"),
        ((edges, normals, uneven[::-1] * u), "other velocities of sizes from 10⁻⁶ to 1"),
        (
            (
                more,
                directions(random.uniform(0, 2 * np.pi, len(more))),
                random.normal(size=(int(more.max()) + 1, 2)),
            ),
            "sixty-seven edges",
        ),
        ((edges, level_or_upright, integers(u)), "normals and velocities of integers"),
    )


@law("An edge has no first and no second end: exchanging them must change nothing.")
def ends_are_equal(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[2][0] - values[0][0], values[0][0])


@law("Reversing a normal must reverse the sign of its normal velocity.")
def turns_with_the_normal(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[1][0] + values[0][0], values[0][0])


@law(
    "Where every velocity is (1, 0), the normal velocity must be the first component of the normal."
)
def wind_along_the_first_axis(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[3][0] - calls[3].arguments[1][:, 0], 1)


QUESTIONS = (
    Question(
        "05.1",
        "edges_of",
        2,
        edges_inputs,
        lambda call: ((number_of_edges(call.arguments[0]), 2),),
        (ends_share_a_triangle, no_edge_twice),
        normal_form=both_ends_known,
    ),
    Question(
        "05.2",
        "midpoints_and_normals",
        2,
        also_at_zero(normals_inputs, points=(0,)),
        lambda call: (call.arguments[1].shape, call.arguments[1].shape),
        (halfway, unit_length, across),
        normal_form=either_side,
    ),
    Question(
        "05.3",
        "rotation",
        2,
        also_at_zero(rotation_inputs, points=(0,)),
        lambda call: (call.arguments[0].shape,),
        (stays_rigid, turns_about_the_mean),
    ),
    Question(
        "05.4",
        "normal_velocities",
        2,
        also_at_zero(normal_velocities_inputs, values=(2,)),
        lambda call: ((len(call.arguments[0]),),),
        (ends_are_equal, turns_with_the_normal, wind_along_the_first_axis),
    ),
)
