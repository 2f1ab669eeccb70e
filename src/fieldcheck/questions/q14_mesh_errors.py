"""Questions of notebook 14, mesh errors that the list of triangles alone determines.

Surfaces are built from rectangular arrays of vertex numbers, so that their edges, loops and fans
are known in advance.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.question import Question, law

Surface = tuple[np.ndarray, np.ndarray]


# Surfaces


def net(numbers: np.ndarray) -> np.ndarray:
    """Return the triangles of an array of vertex numbers, two for each of its squares."""
    a, b, c, d = numbers[:-1, :-1], numbers[:-1, 1:], numbers[1:, 1:], numbers[1:, :-1]
    return np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)


def sheet(rows: int = 3, columns: int = 4) -> Surface:
    """Return a rectangular, slightly bent sheet."""
    y, x = (axis.ravel() for axis in np.mgrid[: rows + 1, : columns + 1])
    return np.column_stack([x, y, 0.1 * x * y]), net(
        np.arange(x.size).reshape(rows + 1, columns + 1)
    )


def ball(rings: int = 3, around: int = 6) -> Surface:
    """Return a sphere, oriented outward: rings of vertices about the axis, and two poles."""
    up, turn = np.pi * np.arange(1, rings + 1) / (rings + 1), 2 * np.pi * np.arange(around) / around
    height, angle = (axis.ravel() for axis in np.meshgrid(up, turn, indexing="ij"))
    points = np.column_stack(
        [np.sin(height) * np.cos(angle), np.sin(height) * np.sin(angle), np.cos(height)]
    )
    numbers = np.pad(
        np.arange(rings * around).reshape(rings, around), ((0, 0), (0, 1)), mode="wrap"
    )
    first, last, n = numbers[0], numbers[-1], len(points)
    caps = [[n, i, j] for i, j in pairwise(first)]
    caps += [[n + 1, j, i] for i, j in pairwise(last)]
    return np.vstack([points, [[0, 0, 1], [0, 0, -1]]]), np.vstack([net(numbers)[:, ::-1], caps])


def ring(rows: int = 4, columns: int = 6) -> Surface:
    """Return a torus."""
    small, large = np.meshgrid(
        2 * np.pi * np.arange(rows) / rows, 2 * np.pi * np.arange(columns) / columns, indexing="ij"
    )
    wide = (2 + 0.8 * np.cos(small)).ravel()
    points = np.column_stack(
        [wide * np.cos(large.ravel()), wide * np.sin(large.ravel()), 0.8 * np.sin(small.ravel())]
    )
    return points, net(
        np.pad(np.arange(rows * columns).reshape(rows, columns), ((0, 1), (0, 1)), mode="wrap")
    )


def bottle(rows: int = 4, columns: int = 6) -> Surface:
    """Return a Klein bottle: a closed surface without an inside, with crossings in space."""
    numbers = np.arange(rows * columns).reshape(rows, columns)
    closed = np.vstack([numbers, numbers[:1]])
    return ring(rows, columns)[0], net(np.hstack([closed, closed[::-1, :1]]))


def band(twists: int, columns: int = 12) -> Surface:
    """Return a closed strip with half twists; one half twist gives the Möbius strip."""
    grid = np.meshgrid(
        np.linspace(-0.5, 0.5, 3), 2 * np.pi * np.arange(columns) / columns, indexing="ij"
    )
    across, along = (axis.ravel() for axis in grid)
    wide = 1.2 + across * np.cos(twists * along / 2)
    points = np.column_stack(
        [wide * np.cos(along), wide * np.sin(along), across * np.sin(twists * along / 2)]
    )
    numbers = np.arange(3 * columns).reshape(3, columns)
    first = numbers[:, :1] if twists % 2 == 0 else numbers[::-1, :1]
    return points, net(np.hstack([numbers, first]))


def unjoined(twists: int, columns: int) -> Surface:
    """Return a strip with half twists whose ends meet, but have no common vertices."""
    points = band(twists, columns)[0].reshape(3, columns, 3)
    first = points[::-1, :1] if twists % 2 else points[:, :1]
    return np.hstack([points, first]).reshape(-1, 3), sheet(2, columns)[1]


def halves(rings: int, around: int) -> Surface:
    """Return a sphere cut along a ring into an outward and an inward half."""
    points, triangles = ball(2 * rings + 1, around)
    upper = points[triangles].mean(axis=1)[:, 2] > 0
    lower = triangles[~upper][:, ::-1] + len(points)
    return np.vstack([points, points]), np.vstack([triangles[upper], lower])


def book(pages: int) -> Surface:
    """Return triangles that share one edge, as the pages of a book share its spine."""
    angle = 2 * np.pi * np.arange(pages) / pages
    points = np.vstack(
        [[[0, 0, 0], [0, 0, 1]], np.column_stack([np.cos(angle), np.sin(angle), 0.5 + 0 * angle])]
    )
    return points, np.array([[0, 1, 2 + k] if k % 2 else [1, 0, 2 + k] for k in range(pages)])


def joined(*surfaces: Surface) -> Surface:
    """Return several surfaces as one list of triangles, side by side."""
    points, triangles, n = [], [], 0
    for k, (p, t) in enumerate(surfaces):
        points.append(p + np.array([5.0 * k, 0, 0]))
        triangles.append(t + n)
        n += len(p)
    return np.vstack(points), np.vstack(triangles)


def walled() -> Surface:
    """Return a sphere with a wall across its middle: three triangles meet along the rim of it."""
    points, triangles = ball(3, 6)
    middle, n = np.arange(6, 12), len(points)
    wall = np.column_stack([np.full(6, n), middle, np.roll(middle, -1)])
    return np.vstack([points, [[0, 0, 0]]]), np.vstack([triangles, wall])


def repeated(surface: Surface, *twice: int) -> Surface:
    """Return a surface with some triangles listed twice."""
    return surface[0], np.vstack([surface[1], surface[1][list(twice)]])


def fused(surface: Surface, *pairs: tuple[int, int]) -> Surface:
    """Return a surface in which some vertices are replaced by others."""
    points, triangles = surface
    name = np.arange(len(points))
    for kept, gone in pairs:
        name[gone] = kept
    return points, name[triangles]


def without(surface: Surface, *left_out: int) -> Surface:
    """Return a surface without some of its triangles."""
    return surface[0], np.delete(surface[1], left_out, axis=0)


def flipped(random: np.random.Generator, surface: Surface, share: float = 0.4) -> Surface:
    """Return a surface in which some triangles, including the last, have reversed orientation."""
    points, triangles = surface[0], surface[1].copy()
    chosen = random.random(len(triangles)) < share
    chosen[-1] = True
    triangles[chosen] = triangles[chosen][:, [0, 2, 1]]
    return points, triangles


def shuffled(random: np.random.Generator, surface: Surface, spare: int = 0) -> Surface:
    """Return a surface in random order, with some unused vertices."""
    points, triangles = surface
    n = len(points) + spare
    name = random.permutation(n)
    moved = random.normal(size=(n, 3))
    moved[name[: len(points)]] = points
    rolled = [np.roll(t, random.integers(3)) for t in name[triangles]]
    return moved, np.array(rolled)[random.permutation(len(rolled))]


TRIANGLE = np.eye(3), np.array([[0, 1, 2]])
"""A single triangle."""


def alike(random: np.random.Generator, base: int, as_text: bool = False) -> Surface:
    """Return two triangles without a common vertex that a key of two vertices may confuse.

    For vertices i < j, two edges of one triangle have the values base i + j of two edges of the
    other, or the same digits if i and j are written one after the other.
    """
    i, (j, k) = random.integers(1, 5), np.sort(50 + random.permutation(50)[:2])
    other = 10 * i + 1 if as_text else i + 1
    triangles = np.array([[i, base + j, base + k], [other, j, k]])
    return random.normal(size=(base + 100, 3)), triangles


def large_numbers(random: np.random.Generator) -> dict[str, Surface]:
    """Return triangles with vertex numbers below and above 100."""
    return {
        "two triangles with large numbers": alike(random, 100),
        "two other triangles with large numbers": alike(random, 100, as_text=True),
    }


def numbers_on_both_sides(random: np.random.Generator) -> dict[str, Surface]:
    """Return triangles that a key of two vertices, i + 100 j or i + 1000 j for i < j, confuses."""
    made = {}
    for base in (100, 1000):
        i, (j, k) = random.integers(1, 5), np.sort(base + 50 + 2 * random.permutation(20)[:2])
        triangles = np.array([[base + i, j, k], [i, j + 1, k + 1]])
        points = random.normal(size=(base + 100, 3))
        made[f"two triangles with numbers below and above {base}"] = points, triangles
    return made


def larger_numbers(random: np.random.Generator) -> dict[str, Surface]:
    """Return triangles whose vertex numbers differ by 256 or 512, which a byte cannot show."""
    points, triangles = alike(random, 256)
    return {
        "two triangles with numbers below and above 512": alike(random, 512),
        "two triangles with numbers above 260": (
            np.vstack([points, points[:260]]),
            triangles + 260,
        ),
    }


def thousands(random: np.random.Generator) -> dict[str, Surface]:
    """Return triangles with vertex numbers below and above 1000."""
    return {
        "two triangles with numbers up to 1100": alike(random, 1000),
        "two other triangles with numbers up to 1100": alike(random, 1000),
    }


def few(random: np.random.Generator) -> dict[str, Surface]:
    """Return a strip of three triangles, as many as a triangle has vertices."""
    return {"a strip of three triangles": shuffled(random, without(sheet(1, 2), 1))}


def hundreds(random: np.random.Generator) -> dict[str, Surface]:
    """Return surfaces of some hundred triangles, each with one hole of three edges."""
    return {
        "a sphere of 69 triangles with a hole": shuffled(random, without(ball(5, 7), 0)),
        "a torus of 69 triangles with a hole": shuffled(random, without(ring(5, 7), 5)),
    }


def sides_by_name(triangles: np.ndarray) -> list[tuple[int, int]]:
    """Return the ends of each side, in the direction of its triangle."""
    return [(int(t[k]), int(t[k - 2])) for t in triangles for k in range(3)]


# 14.2 and 14.3 Edges


def edge_surfaces(seed: int) -> dict[str, Surface]:
    """Return surfaces that are closed, have a boundary, or have edges of many triangles."""
    random = np.random.default_rng(seed)
    crowd = joined(book(3), book(5), sheet(1, 2))
    return {
        "a sphere": shuffled(random, ball()),
        "a sheet": shuffled(random, sheet()),
        "triangles like the pages of two books, and a sheet": shuffled(random, crowd),
        "a sphere with some inverted triangles": shuffled(random, flipped(random, ball(2, 5))),
        "a sphere of 114 vertices": shuffled(random, ball(8, 14), 90),
        "a torus of 128 vertices": shuffled(random, ring(8, 16), 70),
        "a sphere with a triangle listed twice": shuffled(random, repeated(ball(), 4)),
        "a torus with a triangle listed twice": shuffled(random, repeated(ring(3, 4), 5)),
        **large_numbers(random),
        **hundreds(random),
        **larger_numbers(random),
        **few(random),
        "triangles like three pages of a book": shuffled(random, book(3)),
        **thousands(random),
        **numbers_on_both_sides(random),
    }


TIMES = (
    *((0, 108), (14, 58), (22, 6, 3, 0, 5), (0, 60), (0, 672), (0, 768)),
    *((0, 102, 9), (0, 66, 9), (6,), (6,), (3, 204), (3, 204), (6,), (6,), (5, 4), (6, 0, 3)),
    *4 * ((6,),),
)
"""The number of sides of these surfaces that belong to an edge of one, two, … triangles."""


def count_inputs(seed: int) -> tuple[Call, ...]:
    return tuple(
        Call("triangles_at_sides", (t,), case) for case, (_, t) in edge_surfaces(seed).items()
    )


@law(
    "All sides of an edge must have the same count, and the numbers of sides with the count 1, "
    "2, 3 and so on must be those of the surface."
)
def counts_are_as_constructed(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the counts from the known ones, and from each other along an edge."""
    wrong = 0
    for call, (count,), times in zip(calls, values, TIMES, strict=True):
        wrong += sum(abs(int((count == k).sum()) - n) for k, n in enumerate(times, start=1))
        seen: dict[frozenset[int], float] = {}
        for side, k in zip(sides_by_name(call.arguments[0]), count.tolist(), strict=True):
            wrong += seen.setdefault(frozenset(side), k) != k
    return float(wrong)


def euler_inputs(seed: int) -> tuple[Call, ...]:
    """Return surfaces of known Euler characteristic."""
    random = np.random.default_rng(seed)
    whole = ball()
    soup = whole[0][whole[1]].reshape(-1, 3), np.arange(whole[1].size).reshape(-1, 3)
    surfaces = {
        "a sphere": whole,
        "a torus": ring(),
        "a sheet": sheet(),
        "a Möbius strip": band(1, 6),
        "a sphere and two tori": joined(ball(2, 5), ring(3, 4), ring(3, 5)),
        "a polygon soup of a sphere": soup,
        "three triangles at one edge": book(3),
        "five triangles at one edge": book(5),
        "four triangles at one edge": book(4),
        "a sheet with a triangle listed twice": repeated(sheet(2, 2), 3),
        "a sphere with two triangles listed twice": repeated(ball(2, 4), 2, 7),
    }
    calls = [
        Call("euler_characteristic", (shuffled(random, s)[1],), case)
        for case, s in surfaces.items()
    ]
    spare = shuffled(random, without(ball(2, 6), 0, 8), 5)
    return (
        *calls,
        Call(
            "euler_characteristic",
            (spare[1],),
            "a sphere with two holes, and vertices that no triangle has",
        ),
        *(
            Call("euler_characteristic", (triangles,), case)
            for surfaces in (
                *(large_numbers, hundreds, larger_numbers, few, thousands),
                numbers_on_both_sides,
            )
            for case, (_, triangles) in surfaces(random).items()
        ),
    )


CHARACTERISTICS = (2, 0, 1, 0, 2, 36, 1, 1, 1, 2, 4, 0, 2, 2, 1, -1, 2, 2, 1, 2, 2, 2, 2)


@law(
    "χ must be that of the surface: 2 for a sphere, 0 for a torus, 1 for a sheet; parts add up, "
    "and a triangle listed twice counts twice."
)
def is_the_known_characteristic(_: Sequence[Call], values: Sequence[Values]) -> float:
    return max(abs(float(v) - known) for (v,), known in zip(values, CHARACTERISTICS, strict=True))


# 14.4 and 14.5 Loops and fans


def loop_inputs(seed: int) -> tuple[Call, ...]:
    """Return surfaces with zero, one, two and four boundary loops."""
    random = np.random.default_rng(seed)
    surfaces = {
        "a sheet": sheet(),
        "a sphere with two holes": without(ball(3, 6), 0, 1, 30),
        "a strip of paper": band(0, 6),
        "a Möbius strip": band(1, 6),
        "a torus": ring(3, 4),
        "two sheets with some inverted triangles": flipped(
            random, joined(sheet(2, 2), sheet(1, 3))
        ),
        "a sphere with a wall inside": walled(),
        "a sphere with a wall inside and a hole": without(walled(), 24),
        "two spheres that share an edge": fused(joined(*2 * [ball(2, 5)]), (0, 12), (1, 13)),
        "a sheet with a long boundary": sheet(9, 11),
        "a sphere with a wall inside, and a hole that meets its edge": without(walled(), 0),
        "a sheet, and a triangle listed twice": joined(sheet(1, 2), repeated(TRIANGLE, 0)),
        "a sheet with all triangles listed twice, and a sphere with a hole": joined(
            repeated(sheet(1, 2), *range(4)), without(ball(2, 4), 0)
        ),
    }
    made = {case: shuffled(random, surface, 3) for case, surface in surfaces.items()}
    made |= large_numbers(random)
    made |= {
        case: shuffled(random, surface, 2)
        for case, surface in {
            "a sphere of 74 vertices with two holes": without(ball(8, 9), 0, 140),
            "a torus of 75 vertices with two holes": without(ring(5, 15), 0, 70),
        }.items()
    }
    made |= larger_numbers(random) | few(random) | numbers_on_both_sides(random)
    return tuple(Call("boundary_loops", (len(p), t), case) for case, (p, t) in made.items())


LENGTHS = (
    *((14,), (3, 4), (6, 6), (12,), (), (8, 8), (), (3,), (), (40,), (3,)),
    *((6,), (3,), *6 * ((3, 3),), (5,), *2 * ((3, 3),)),
)


@law(
    "The loops must be those of the boundary, and the name of a loop must be its smallest vertex; "
    "other vertices must have −1."
)
def loops_have_the_known_lengths(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return one if a loop has a wrong length or is not named by its smallest vertex."""
    for (loop,), lengths in zip(values, LENGTHS, strict=True):
        names, times = np.unique(loop[loop != -1], return_counts=True)
        least = [float(np.flatnonzero(loop == name).min()) for name in names]
        if tuple(np.sort(times).tolist()) != lengths or least != names.tolist():
            return 1.0
    return 0.0


def fan_inputs(seed: int) -> tuple[Call, ...]:
    """Return surfaces with vertices of zero, one and several fans."""
    random = np.random.default_rng(seed)
    n, m = len(ball()[0]), len(ball(2, 5)[0])
    surfaces = {
        "a sheet": sheet(),
        "three spheres that share one vertex": fused(
            joined(*3 * [ball(2, 5)]), (3, m + 4), (3, 2 * m + 1)
        ),
        "a sphere with two of its vertices merged": fused(ball(), (1, n - 3)),
        "a torus that touches itself in a vertex": fused(ring(6, 8), (0, 28)),
        "two sheets with some inverted triangles that share a corner": flipped(
            random, fused(joined(sheet(2, 2), sheet(1, 3)), (8, 9))
        ),
        "the pages of a book": book(4),
        "a sphere with merged poles": fused(ball(2, 5), (10, 11)),
        "a ring of three triangles": (
            random.normal(size=(6, 3)),
            np.array([[0, 1, 2], [2, 3, 4], [4, 5, 0]]),
        ),
    }
    made = {case: shuffled(random, surface, 2) for case, surface in surfaces.items()}
    made |= large_numbers(random)
    made |= {
        case: shuffled(random, surface, 2)
        for case, surface in {
            "a sphere of 37 vertices, two of them merged": fused(ball(5, 7), (1, 30)),
            "a torus with some inverted triangles that touches itself": flipped(
                random, fused(ring(5, 7), (0, 17))
            ),
        }.items()
    }
    made |= larger_numbers(random) | few(random)
    made |= {
        case: shuffled(random, surface)
        for case, surface in {
            "a sphere with 23 triangles at each pole": ball(1, 23),
            "a sphere with merged poles of 21 triangles each": fused(ball(2, 21), (42, 43)),
        }.items()
    }
    return tuple(Call("fans", (len(p), t), case) for case, (p, t) in made.items())


FANS = (
    *((2, 20), (4, 33, 0, 1), (3, 18, 1), (3, 46, 1), (3, 15, 1), (2, 6)),
    *((3, 10, 1), (2, 3, 3), (194, 6), (194, 6), (3, 35, 1), (3, 33, 1)),
    *((606, 6), (610, 6), (1, 5), (0, 25), (1, 42, 1)),
)
"""The number of vertices of these surfaces with zero fans, one fan, and so on."""


@law("Each vertex must have as many fans as the surface has there, and none without triangles.")
def fans_are_as_constructed(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the numbers from the known ones, and violations of the bound given by
    the boundary.
    """
    wrong = 0
    for call, (fans,), times in zip(calls, values, FANS, strict=True):
        triangles = call.arguments[1]
        wrong += sum(abs(int((fans == k).sum()) - number) for k, number in enumerate(times))
        wrong += int((fans[np.unique(triangles)] < 1).sum())
    return float(wrong)


QUESTIONS = (
    Question(
        "14.2",
        "triangles_at_sides",
        2,
        count_inputs,
        lambda call: ((call.arguments[0].size,),),
        (counts_are_as_constructed,),
    ),
    Question(
        "14.3",
        "euler_characteristic",
        2,
        euler_inputs,
        lambda _: ((),),
        (is_the_known_characteristic,),
        may_call=("14.2",),
    ),
    Question(
        "14.4",
        "boundary_loops",
        3,
        loop_inputs,
        lambda call: ((call.arguments[0],),),
        (loops_have_the_known_lengths,),
    ),
    Question(
        "14.5",
        "fans",
        3,
        fan_inputs,
        lambda call: ((call.arguments[0],),),
        (fans_are_as_constructed,),
    ),
)
