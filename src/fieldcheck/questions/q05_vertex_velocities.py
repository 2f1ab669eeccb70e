"""Questions of notebook 05, a triangle mesh: edges, normals, velocities at the vertices."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.question import Question, law, law_of_each, relative

FITTED = 1e-8
"""Rounding tolerance of systems whose condition number is some hundreds."""

AWAY = 2.0**20
"""A distance of about a million."""


def in_short_binary_numbers(x: np.ndarray) -> np.ndarray:
    """Return numbers rounded to 24 binary digits after the point: they stay exact far away."""
    return np.round(x * 2.0**24) / 2.0**24


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
    )


def part_of_a_mesh(random: np.random.Generator, first: int) -> np.ndarray:
    """Return four triangles whose vertices have larger numbers than there are triangles.

    The edges (5, 9) and (4, 13) have the same number 4 i + j, so it cannot stand for an edge.
    """
    cells = np.array([[5, 9, 13], [4, 13, 9], [5, 13, 7], [4, 9, 1]])
    return first + random.permuted(random.permutation(cells), axis=1)


def number_of_edges(triangles: np.ndarray) -> int:
    """Return the number of different sides of triangles."""
    return len({frozenset((t[k], t[k - 1])) for t in triangles.tolist() for k in range(3)})


def both_ends_known(_: Call, values: Values) -> Values:
    """Return the edges with the smaller number first, in lexicographic order."""
    low, high = values[0].min(axis=1), values[0].max(axis=1)
    order = np.lexsort([high, low])
    return (np.stack([low, high], axis=1)[order],)


@law("Each edge must occur once, also where two triangles share it.")
def no_edge_twice(calls: Sequence[Call], values: Sequence[Values]) -> float:
    repeated = [len(e) - len({frozenset(pair) for pair in e.tolist()}) for (e,) in values]
    return float(max(repeated))


@law_of_each("The two ends of an edge must be different corners of one triangle.")
def ends_share_a_triangle(call: Call, values: Values) -> float:
    """Return the largest share of edges whose ends do not belong to a common triangle."""
    (e,) = values
    corners = [set(t) for t in call.arguments[0].tolist()]
    alone = [len(set(pair)) < 2 or not any(set(pair) <= t for t in corners) for pair in e.tolist()]
    return float(np.mean(alone))


# 05.2 Midpoints and normals


def normals_inputs(seed: int) -> tuple[Call, ...]:
    """Return a mesh, two edges along the axes, and an elongated mesh in small units."""
    random = np.random.default_rng(seed)
    points, triangles = mesh(random, 3, 2)
    more, others = mesh(random, 2, 2)
    a, b = random.uniform(1, 3, 2)
    cross = np.array([[0.0, 0.0], [a, 0.0], [0.0, b]])
    return calls_of(
        "midpoints_and_normals",
        ((points, sides(triangles, random)), "the edges of a mesh"),
        ((1e-9 * cross, np.array([[1, 0], [0, 2]])), "two edges along the axes, of length 10⁻⁹"),
        ((50 * more - 20, sides(others, random)), "a larger mesh"),
        ((integers(points, 1e4), sides(triangles, random)), "a mesh of integers"),
        ((integers(more, 1e4), sides(others, random)), "another mesh of integers"),
    )


def either_side(_: Call, values: Values) -> Values:
    """Return normals oriented to the side of a fixed direction."""
    midpoints, normals = values
    back = (normals @ ACROSS < 0)[:, np.newaxis]
    return midpoints, np.where(back, -normals, normals)


def edge_data(
    calls: Sequence[Call], values: Sequence[Values]
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Yield both ends of the edges of a call, the midpoints and the normals."""
    for call, (midpoints, normals) in zip(calls, values, strict=True):
        points, edges = call.arguments
        one, other = np.moveaxis(np.take(points, edges, axis=0), 1, 0)
        yield one, other, midpoints, normals


@law(
    "The vector from the first end to the midpoint must equal the vector from the midpoint to "
    "the second end."
)
def halfway(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return max(relative((p - a) - (b - p), b - a) for a, b, p, _ in edge_data(calls, values))


@law("A unit normal must have length one.")
def unit_length(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return max(relative(np.hypot(*n.T) - 1, 1) for *_, n in edge_data(calls, values))


@law("A normal must be perpendicular to its edge.")
def across(calls: Sequence[Call], values: Sequence[Values]) -> float:
    found = edge_data(calls, values)
    return max(relative(np.einsum("ek,ek->e", b - a, n), b - a) for a, b, _, n in found)


# 05.3 The rotation


def rotation_inputs(seed: int) -> tuple[Call, ...]:
    """Return points of a mesh, the same translated, and points that are denser on one side."""
    random = np.random.default_rng(seed)
    points = mesh(random, 2, 2)[0]
    cloud = random.random((7, 2)) ** 2
    return calls_of(
        "rotation",
        ((points,), "the vertices of a mesh"),
        ((points + np.array([3.0, -2.0]),), "the same vertices, moved"),
        ((cloud,), "seven points, more of them on one side"),
        ((integers(points),), "the vertices of a mesh, integers"),
        ((integers(cloud),), "seven points, integers"),
    )


@law_of_each(
    "In a rotation distances do not change: the difference of two velocities must be "
    "perpendicular to the line between the points."
)
def stays_rigid(call: Call, values: Values) -> float:
    """Return how fast distances between points change."""
    (u,) = values
    way, change = np.diff(call.arguments[0], axis=0), np.diff(u, axis=0)
    return relative(np.einsum("ek,ek->e", way, change), way**2)


@law("The rotation is about the mean of the points, so the velocities must add up to zero.")
def turns_about_the_mean(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return max(relative(u.mean(axis=0), u) for (u,) in values)


# 05.4 Normal velocities


def normal_velocities_inputs(seed: int) -> tuple[Call, ...]:
    """Return velocities, with reversed normals, with exchanged ends, and a constant velocity."""
    random = np.random.default_rng(seed)
    edges = sides(mesh(random, 2, 2)[1], random)
    normals = directions(random.uniform(0, 2 * np.pi, len(edges)))
    u = random.normal(size=(int(edges.max()) + 1, 2))
    wind = np.tile([1.0, 0.0], (len(u), 1))
    return calls_of(
        "normal_velocities",
        ((edges, normals, u), "velocities at random"),
        ((edges, -normals, u), "the same, the normals reversed"),
        ((edges[:, ::-1].copy(), normals, u), "the same, the ends of each edge exchanged"),
        ((edges, normals, wind), "the velocity (1, 0) at every vertex"),
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


# 05.6 The ring


def ring_inputs(seed: int) -> tuple[Call, ...]:
    """Return one and two rings of the vertex with most edges and of one with the fewest edges."""
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
    )


def neighbour_of_valence_three(triangles: np.ndarray) -> int:
    """Return a neighbour of a vertex with three triangles: two of its neighbours are joined."""
    for t in triangles:
        for middle in t:
            star = np.array([u for u in triangles if middle in u])
            if len(star) == 3 and len(np.unique(star)) == 4:
                return int(min(set(star.ravel().tolist()) - {int(middle)}))
    raise ValueError("no vertex of the mesh has three triangles around it")


@law("Every edge that ends in the vertex must be in its ring.")
def holds_the_spokes(calls: Sequence[Call], values: Sequence[Values]) -> float:
    missed = [
        1 - near[[c.arguments[2] in pair for pair in c.arguments[1]]].min()
        for c, (near,) in zip(calls, values, strict=True)
    ]
    return float(np.abs(missed).max())


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
    """Return samples, the same translated together with the point, and few samples."""
    random = np.random.default_rng(seed)
    p, n, x = samples(random, 9)
    few = samples(random, 4)
    return calls_of(
        "system",
        ((p, n, x), "nine samples"),
        ((p - 5.0, n, x - 5.0), "the same samples and the vertex, moved together"),
        (few, "four samples"),
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
    and in other units of length.
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
        ((p, n, v + more, x, w), "the same plus the normal velocities of an affine field"),
        ((p + shift, n, v, x + shift, w), "the same edges, moved with the vertex"),
        ((p, flips[:, np.newaxis] * n, flips * v, x, w), "the same, some normals reversed"),
        ((*other[:2], random.normal(size=10), other[2], np.ones(10)), "ten edges of equal weight"),
        ((1e-3 * p, n, v, 1e-3 * x, w), "the first edges, all lengths a thousandth"),
        ((1e3 * p, n, v, 1e3 * x, w), "the first edges, all lengths times a thousand"),
        ((p, n, v, x, uneven), "the first edges, one weight far above the others"),
        ((p, n, v, x, uneven[::-1]), "the first edges, another weight far above the others"),
    )


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


@law("Another unit of length must not change the velocity.", FITTED)
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
            ((1e-7 * points, triangles, 1), "the same mesh in a square of 10⁻⁷"),
            ((1e-8 * points, triangles, 2), "two rings of the same mesh in a square of 10⁻⁸"),
        ),
        Call("ranks", (regular, squares, 1), "a regular grid of four by four squares", (0,)),
        Call("ranks", (longer - 1e6, oblong, 1), "a regular grid of three by five squares", (0,)),
        Call("ranks", (*grid_of_squares(1, 2), 2), "two rings in a mesh of two squares", (0,)),
        *calls_of(
            "ranks",
            ((nearly(random, regular), squares, 1), "a grid that is nearly regular"),
            ((nearly(random, longer), oblong, 1), "an oblong grid that is nearly regular"),
        ),
    )


@law(
    "The rank must be between three and six: a ring has at least the three edges of a triangle, "
    "and Bʹ has six columns."
)
def rank_between(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return float(max(np.any((r < 3) | (r > 6)) for (r,) in values))


@law(
    "The rank must depend only on the shape of the mesh, not on its position or the unit of length."
)
def rank_of_the_shape(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return float(max(np.abs(values[k][0] - values[0][0]).max() for k in (2, 3)))


@law("A second ring adds edges, so no rank may decrease, and some must increase.")
def rank_grows(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return float(max(np.any(values[1][0] < values[0][0]), np.all(values[1][0] == values[0][0])))


ACROSS = np.array([0.62, 0.78])
"""A direction to which no edge of a random mesh is parallel."""


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
        normals_inputs,
        lambda call: (call.arguments[1].shape, call.arguments[1].shape),
        (halfway, unit_length, across),
        normal_form=either_side,
    ),
    Question(
        "05.3",
        "rotation",
        2,
        rotation_inputs,
        lambda call: (call.arguments[0].shape,),
        (stays_rigid, turns_about_the_mean),
    ),
    Question(
        "05.4",
        "normal_velocities",
        2,
        normal_velocities_inputs,
        lambda call: ((len(call.arguments[0]),),),
        (ends_are_equal, turns_with_the_normal, wind_along_the_first_axis),
    ),
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
        system_inputs,
        lambda call: ((len(call.arguments[0]), 6),),
        (gives_normal_velocities, depends_on_differences_only),
    ),
    Question(
        "05.8",
        "velocity",
        4,
        velocity_inputs,
        lambda _: ((2,),),
        (reproduces_affine_fields, moves_along, unit_of_length, side_of_the_normal),
        lambda _: FITTED,
    ),
    Question(
        "05.9",
        "ranks",
        3,
        ranks_inputs,
        lambda call: ((len(call.arguments[0]),),),
        (rank_between, rank_of_the_shape, rank_grows),
    ),
)
