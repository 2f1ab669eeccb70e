"""The question of notebook 11 on the orientation of normals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, integers
from fieldcheck.question import Question, law, relative
from fieldcheck.questions.q11_point_clouds import horseshoe, near, outward, oval, sheet, torus


def ellipsoid(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n points of an ellipsoid in random order, evenly spread along a spiral."""
    height = 1 - (2 * np.arange(n) + random.uniform(0.8, 1.2, n)) / n
    turn = np.pi * (1 + np.sqrt(5)) * np.arange(n)
    width = np.sqrt(1 - height**2)
    points = np.column_stack([width * np.cos(turn), width * np.sin(turn), height])
    return points[random.permutation(n)] * AXES


AXES = np.array([1.3, 1.0, 0.8])


def outward_of_ellipsoid(points: np.ndarray) -> np.ndarray:
    """Return the outward normals of the ellipsoid at points on it."""
    away = points / AXES**2
    return away / np.sqrt((away**2).sum(axis=1))[:, None]


def drop(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n points of a drop, a circle with two tangents that meet in a tip, in random order."""
    flank = np.sqrt(3.0)
    along = (np.arange(n) + 0.5 + random.uniform(-0.1, 0.1, n)) / n * (
        2 * flank + 4 * np.pi / 3
    ) - flank
    turn = np.clip(along, 0, 4 * np.pi / 3) + np.pi / 3
    z = np.exp(1j * turn) * (1 + 1j * (along + np.pi / 3 - turn))
    return turned_tip(z)[random.permutation(n)]


TIP = np.exp(1.2j)
"""The direction of the tip of the drop."""


def turned_tip(z: np.ndarray) -> np.ndarray:
    z = z * TIP
    return np.column_stack([z.real, z.imag])


def outward_of_drop(points: np.ndarray) -> np.ndarray:
    """Return the outward normals of the drop at points on it."""
    angle = np.angle((points[:, 0] + 1j * points[:, 1]) / TIP)
    return turned_tip(
        np.exp(1j * np.where(angle < 0, -1, 1) * np.maximum(np.abs(angle), np.pi / 3))
    )


def outward_of_two(points: np.ndarray) -> np.ndarray:
    """Return the outward normals of a horseshoe and of an oval on its right."""
    away = (points - RIGHT) / [1.44, 0.64]
    return np.where(points[:, :1] > 2.5, away / np.hypot(*away.T)[:, None], outward(points))


RIGHT = np.array([4.0, 1.0])


def below(points: np.ndarray) -> np.ndarray:
    """Return the outward normals of two bodies that were moved down."""
    return outward_of_two(points + DOWN)


DOWN = np.array([0.0, 7.0])


def circles(random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of two circles, each listed from its lowest point round, and the links
    between successive points.

    The first and the last point of each circle are below its centre.
    """
    turn = 2 * np.pi * ((np.arange(8) + random.uniform(-0.2, 0.2, (2, 8))) / 8 - 0.25)
    around = np.stack([np.cos(turn), np.sin(turn)], axis=2)
    chain = np.eye(8, k=1) + np.eye(8, k=-1)
    return (CENTERS[:, None] + around).reshape(16, 2), np.kron(np.eye(2), chain)


CENTERS = np.array([[-2.0, 3.0], [2.0, -3.0]])


def outward_of_circles(points: np.ndarray) -> np.ndarray:
    """Return the outward normals of the two circles at points on them."""
    away = points - np.where(points[:, :1] < 0, *CENTERS)
    return away / np.hypot(*away.T)[:, None]


def outward_of_low_circles(points: np.ndarray) -> np.ndarray:
    """Return the outward normals of the two circles after they were moved down."""
    return outward_of_circles(points + DOWN)


def box(random: np.random.Generator, d: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return three points near each side of a square or of a cube, given normals, and links.

    The links form a tree: one point of each side is linked to the two others, whose normals are
    parallel to its own, and to the next side, whose normal is perpendicular. Its own given normal
    is the outward one, so that the product zero leaves no choice.
    """
    axes = np.roll(np.eye(d), 1, axis=0)
    sides = np.vstack([axes, -axes])
    across = 0.7 * random.uniform(-1, 1, (2 * d, 3, d)) * (sides[:, None] == 0)
    points = (random.uniform(0.9, 1.1, (2 * d, 3, 1)) * sides[:, None] + across).reshape(-1, d)
    given = np.kron(sides, [[1.0], [-1.0], [random.choice([-1.0, 1.0])]])
    first = np.arange(0, 6 * d, 3)
    links = np.zeros((6 * d, 6 * d))
    links[first[:-1], first[1:]] = links[first, first + 1] = links[first, first + 2] = 1
    order = random.permutation(6 * d)
    return points[order], given[order], (links + links.T)[np.ix_(order, order)]


def outward_of_box(points: np.ndarray) -> np.ndarray:
    """Return the outward normals of the sides of the square or cube near the points."""
    size = np.abs(points)
    return np.where(size == size.max(axis=1, keepdims=True), np.sign(points), 0.0)


def upward_of_sheet(points: np.ndarray) -> np.ndarray:
    """Return the upward normals of the tilted plane."""
    return np.tile([0.0, -0.8, 0.6], (len(points), 1))


def random_signs(random: np.random.Generator, normals: np.ndarray) -> np.ndarray:
    """Return normals with random signs, like estimated normals."""
    rough = random.choice([-1.0, 1.0], (len(normals), 1)) * normals + 0.01 * random.normal(
        size=normals.shape
    )
    return rough / np.sqrt((rough**2).sum(axis=1))[:, None]


# 11.3 Orientation


def with_long_links(
    random: np.random.Generator, points: np.ndarray, normals: np.ndarray, k: int
) -> np.ndarray:
    """Return the graph of near points, and half of the links between points whose normals are
    far from parallel.

    Those links are the most expensive ones, so no minimum spanning tree contains them.
    """
    product = normals @ normals.T
    far = (product > -0.6) & (product < -0.1) & (random.uniform(size=product.shape) < 0.3)
    return np.maximum(near(points, k), (far | far.T).astype(float))


def from_below(points: np.ndarray) -> np.ndarray:
    """Return the directions from the origin to points above it."""
    return points / np.sqrt((points**2).sum(axis=1))[:, None]


OUTWARD = {
    "a horseshoe": outward,
    "a torus in space": outward,
    "a drop with a sharp tip": outward_of_drop,
    "two bodies": outward_of_two,
    "two bodies far below": below,
    "an ellipsoid with some long links": outward_of_ellipsoid,
    "a torus with some long links": outward,
    "two circles, each from its lowest point": outward_of_circles,
    "two circles far below": outward_of_low_circles,
    "a square, with equal and perpendicular normals": outward_of_box,
    "a cube, with equal and perpendicular normals": outward_of_box,
    "a tilted sheet": upward_of_sheet,
    "the same horseshoe, other signs": outward,
    "the same torus, other signs": outward,
    "a square, integers": outward_of_box,
    "a cube, integers": outward_of_box,
    "points in the plane without links": from_below,
    "points in space without links": from_below,
}


def orient_inputs(seed: int) -> tuple[Call, ...]:
    """Return normals with random signs, and graphs of near points, some with long links; then small
    graphs with several components, and with costs 0 and 1.
    """
    random = np.random.default_rng(seed)
    two = np.vstack([horseshoe(random, 40, 0.1), oval(random, 20) + RIGHT])[random.permutation(60)]
    clouds = (
        *(horseshoe(random, 44, 0.1), torus(random, 8, 14), drop(random, 30)),
        *(two, two - DOWN),
        *(ellipsoid(random, 90), torus(random, 8, 14)),
    )
    calls = []
    bodies, small = tuple(OUTWARD)[:7], tuple(OUTWARD)[7:12]
    for case, points, k in zip(bodies, clouds, (4, 7, 5, 4, 4, 7, 7), strict=True):
        normals = OUTWARD[case](points)
        long = "long links" in case
        graph = with_long_links(random, points, normals, k) if long else near(points, k)
        calls.append(Call("orient", (points, random_signs(random, normals), graph), case))
    for case, down in zip(small, (0 * DOWN, DOWN), strict=False):
        points, links = circles(random)
        given = random_signs(random, outward_of_circles(points))
        calls.append(Call("orient", (points - down, given, links), case))
    for case, d in zip(small[2:], (2, 3), strict=False):
        calls.append(Call("orient", box(random, d), case, exact=(1,)))
    flat = sheet(random, 16)
    given = random_signs(random, upward_of_sheet(flat))
    calls.append(Call("orient", (flat, given, near(flat, 5)), small[-1]))
    return (*calls, *more_orientations(random, calls))


def more_orientations(random: np.random.Generator, calls: Sequence[Call]) -> tuple[Call, ...]:
    """Return other signs for the same points, normals and links in whole numbers, and no links."""
    again = []
    for call, case in zip(calls, tuple(OUTWARD)[12:14], strict=False):
        points, given, graph = call.arguments
        signs = random.permutation(np.where(np.arange(len(points)) % 2, 1.0, -1.0))
        again.append(Call("orient", (points, signs[:, None] * given, graph), case))
    for case, d in zip(tuple(OUTWARD)[14:16], (2, 3), strict=True):
        points, given, graph = box(random, d)
        whole = integers(points), given.astype(int), graph.astype(int)
        again.append(Call("orient", whole, case, exact=(1,)))
    for case, d in zip(tuple(OUTWARD)[16:], (2, 3), strict=True):
        points = random.uniform(0.5, 1, (5, d))
        given = random_signs(random, from_below(points))
        again.append(Call("orient", (points, given, np.zeros((5, 5))), case))
    return tuple(again)


@law(
    "Each normal must be the given one or its opposite, and must point outward, upward on a sheet."
)
def point_outward(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the number of normals that point inward or are not ± the given ones."""
    wrong = 0.0
    for call, (n,) in zip(calls, values, strict=True):
        points, given, _ = call.arguments
        wrong = max(wrong, relative(np.minimum(np.abs(n - given), np.abs(n + given)), 1.0))
        wrong += float(((n * OUTWARD[call.case](points)).sum(axis=1) < 0).sum())
    return wrong


QUESTIONS = (
    Question(
        "11.3",
        "orient",
        4,
        orient_inputs,
        lambda call: (call.arguments[1].shape,),
        (point_outward,),
    ),
)
