"""Questions of notebook 14, mesh errors that the list of triangles alone determines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.inputs.surfaces import (
    TRIANGLE,
    Surface,
    ball,
    band,
    book,
    few,
    flipped,
    fused,
    hundreds,
    joined,
    large_numbers,
    larger_numbers,
    numbers_on_both_sides,
    repeated,
    ring,
    sheet,
    shuffled,
    sides_by_name,
    thousands,
    walled,
    without,
)
from fieldcheck.question import Question, law

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
        "a sphere that uses 114 of 204 vertices": shuffled(random, ball(8, 14), 90),
        "a torus that uses 128 of 198 vertices": shuffled(random, ring(8, 16), 70),
        "a sphere with a triangle listed twice": shuffled(random, repeated(ball(), 4)),
        "a torus with a triangle listed twice": shuffled(random, repeated(ring(3, 4), 5)),
        **large_numbers(random),
        **hundreds(random),
        **larger_numbers(random),
        **few(random),
        "triangles like three pages of a book": shuffled(random, book(3)),
        **thousands(random),
        **numbers_on_both_sides(random),
        "triangles like 300 pages of a book": shuffled(random, book(300)),
        "triangles like 513 pages of a book": shuffled(random, book(513)),
    }


TIMES = (
    *((0, 108), (14, 58), (22, 6, 3, 0, 5), (0, 60), (0, 672), (0, 768)),
    *((0, 102, 9), (0, 66, 9), (6,), (6,), (3, 204), (3, 204), (6,), (6,), (5, 4), (6, 0, 3)),
    *4 * ((6,),),
    *((2 * pages, *(pages - 2) * (0,), pages) for pages in (300, 513)),
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
