"""Questions 05.1 to 05.4, edges of a triangle mesh, their normals and normal velocities."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.question import Question, law, relative

ACROSS = np.array([0.62, 0.78])
"""A direction that no edge of a mesh at random runs along."""


def mesh(random: np.random.Generator, columns: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points and triangles of squares, pushed about, cut one way or the other.

    One triangle has a point more inside. Points are numbered, and triangles turned, at random.
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
    """Return the pairs of corners that occur, each once, in any order and direction."""
    pairs = {frozenset((t[k], t[k - 1])) for t in triangles.tolist() for k in range(3)}
    listed = np.array(sorted(tuple(pair) for pair in pairs))
    return random.permuted(listed, axis=1)[random.permutation(len(listed))]


def directions(angle: np.ndarray) -> np.ndarray:
    """Return unit vectors."""
    turned = np.exp(1j * angle)
    return np.column_stack([turned.real, turned.imag])


# 05.1 The edges


def edges_inputs(seed: int) -> tuple[Call, ...]:
    """Return two meshes, and a single triangle."""
    random = np.random.default_rng(seed)
    return (
        Call("edges_of", (mesh(random, 3, 3)[1],), "a mesh of twenty triangles"),
        Call("edges_of", (mesh(random, 4, 2)[1],), "a longer mesh"),
        Call("edges_of", (random.permutation(3)[np.newaxis],), "one triangle"),
    )


def number_of_edges(triangles: np.ndarray) -> int:
    """Return it by Euler's formula: as many as vertices and triangles, less one."""
    return int(triangles.max()) + len(triangles)


def both_ends_known(_: Call, values: Values) -> Values:
    """Return the edges with the lower end first, in lexicographic order."""
    low, high = values[0].min(axis=1), values[0].max(axis=1)
    order = np.lexsort([high, low])
    return (np.stack([low, high], axis=1)[order],)


@law("Each edge must occur once, also where two triangles share it.")
def no_edge_twice(calls: Sequence[Call], values: Sequence[Values]) -> float:
    repeated = [len(e) - len({frozenset(pair) for pair in e.tolist()}) for (e,) in values]
    return float(max(repeated))


@law("The two ends of an edge must be different corners of one triangle.")
def ends_share_a_triangle(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the largest part of the edges whose two ends are not corners of one triangle."""
    worst = 0.0
    for call, (e,) in zip(calls, values, strict=True):
        corners = [set(t) for t in call.arguments[0].tolist()]
        alone = [
            len(set(pair)) < 2 or not any(set(pair) <= t for t in corners) for pair in e.tolist()
        ]
        worst = max(worst, float(np.mean(alone)))
    return worst


# 05.2 Midpoints and normals


def normals_inputs(seed: int) -> tuple[Call, ...]:
    """Return a mesh, two edges along the axes, and a long mesh in small units."""
    random = np.random.default_rng(seed)
    points, triangles = mesh(random, 3, 2)
    more, others = mesh(random, 2, 2)
    a, b = random.uniform(1, 3, 2)
    cross = np.array([[0.0, 0.0], [a, 0.0], [0.0, b]])
    return (
        Call("midpoints_and_normals", (points, sides(triangles, random)), "the edges of a mesh"),
        Call(
            "midpoints_and_normals", (cross, np.array([[1, 0], [0, 2]])), "two edges along the axes"
        ),
        Call("midpoints_and_normals", (50 * more - 20, sides(others, random)), "a larger mesh"),
    )


def either_side(_: Call, values: Values) -> Values:
    """Return normals that point to the side of a fixed direction."""
    midpoints, normals = values
    back = (normals @ ACROSS < 0)[:, np.newaxis]
    return midpoints, np.where(back, -normals, normals)


def of_the_edges(
    calls: Sequence[Call], values: Sequence[Values]
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Yield both ends of the edges of a call, the midpoints and the normals."""
    for call, (midpoints, normals) in zip(calls, values, strict=True):
        points, edges = call.arguments
        one, other = np.moveaxis(np.take(points, edges, axis=0), 1, 0)
        yield one, other, midpoints, normals


@law(
    "From the one end to the midpoint it must be as far, and the same way, as from "
    "there to the other end."
)
def halfway(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return max(relative((p - a) - (b - p), b - a) for a, b, p, _ in of_the_edges(calls, values))


@law("A unit normal must have length one.")
def unit_length(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return max(relative(np.hypot(*n.T) - 1, 1) for *_, n in of_the_edges(calls, values))


@law("A normal must be perpendicular to its edge.")
def across(calls: Sequence[Call], values: Sequence[Values]) -> float:
    found = of_the_edges(calls, values)
    return max(relative(np.einsum("ek,ek->e", b - a, n), b - a) for a, b, _, n in found)


# 05.3 The rotation


def rotation_inputs(seed: int) -> tuple[Call, ...]:
    """Return points of a mesh, the same moved, and a cloud that is denser on one side."""
    random = np.random.default_rng(seed)
    points = mesh(random, 2, 2)[0]
    cloud = random.random((7, 2)) ** 2
    return (
        Call("rotation", (points,), "the vertices of a mesh"),
        Call("rotation", (points + np.array([3.0, -2.0]),), "the same vertices, moved"),
        Call("rotation", (cloud,), "seven points, more of them on one side"),
    )


@law(
    "In a rotation the distance of two points must not change: the difference of their "
    "velocities is perpendicular to the line between them."
)
def stays_rigid(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how fast distances between points change."""
    worst = 0.0
    for call, (u,) in zip(calls, values, strict=True):
        way, change = np.diff(call.arguments[0], axis=0), np.diff(u, axis=0)
        worst = max(worst, relative(np.einsum("ek,ek->e", way, change), way**2))
    return worst


@law("The rotation is about the mean of the points, so the velocities must add up to zero.")
def turns_about_the_mean(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return max(relative(u.mean(axis=0), u) for (u,) in values)


# 05.4 Normal velocities


def normal_velocities_inputs(seed: int) -> tuple[Call, ...]:
    """Return velocities; normals reversed; ends exchanged; the same velocity everywhere."""
    random = np.random.default_rng(seed)
    edges = sides(mesh(random, 2, 2)[1], random)
    normals = directions(random.uniform(0, 2 * np.pi, len(edges)))
    u = random.normal(size=(int(edges.max()) + 1, 2))
    wind = np.tile([1.0, 0.0], (len(u), 1))
    return (
        Call("normal_velocities", (edges, normals, u), "velocities at random"),
        Call("normal_velocities", (edges, -normals, u), "the same, the normals reversed"),
        Call(
            "normal_velocities",
            (edges[:, ::-1].copy(), normals, u),
            "the same, the ends of each edge exchanged",
        ),
        Call("normal_velocities", (edges, normals, wind), "the velocity (1, 0) at every vertex"),
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
)
