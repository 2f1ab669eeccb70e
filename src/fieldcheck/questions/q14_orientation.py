"""The question of notebook 14 on orientation: which triangles must be turned over."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.inputs.surfaces import (
    Surface,
    ball,
    band,
    few,
    flipped,
    fused,
    halves,
    joined,
    large_numbers,
    larger_numbers,
    numbers_on_both_sides,
    ring,
    sheet,
    shuffled,
    sides_by_name,
    unjoined,
    without,
)
from fieldcheck.question import Question, law


def folded(random: np.random.Generator) -> Surface:
    """Return a sheet with sharp folds."""
    points, triangles = sheet(2, 4)
    points = points.copy()
    points[:, 2] = 3 * np.abs(points[:, 0] % 2 - 1) + random.uniform(0, 0.1, len(points))
    return points, triangles


def turn_inputs(seed: int) -> tuple[Call, ...]:
    """Return surfaces with some reversed triangles, and some that no reversal makes consistent."""
    random = np.random.default_rng(seed)
    surfaces = {
        "a sphere": flipped(random, ball(2, 5)),
        "a torus": flipped(random, ring()),
        "a sheet with sharp folds": flipped(random, folded(random)),
        "a sheet without inverted triangles": sheet(2, 2),
        "a Möbius strip and a sphere": flipped(random, joined(band(1, 6), ball(2, 4))),
        "three spheres": flipped(random, joined(ball(1, 4), ball(2, 3), ball(1, 5))),
        "a Möbius strip and a sphere that share a vertex": flipped(
            random, fused(joined(band(1, 6), ball(2, 4)), (2, 20))
        ),
        "two spheres that share a vertex": flipped(
            random, fused(joined(ball(2, 3), ball(2, 4)), (1, 10))
        ),
    }
    calls = []
    for case, surface in surfaces.items():
        points, triangles = shuffled(random, surface)
        calls.append(
            Call("turns", (points + random.uniform(-0.05, 0.05, points.shape), triangles), case)
        )
    single = random.normal(size=(5, 3)), np.array([random.permutation(5)[:3]])
    calls.append(Call("turns", single, "a single triangle"))
    calls += [Call("turns", surface, case) for case, surface in large_numbers(random).items()]
    many = {
        "a sphere of 69 triangles with a hole": without(ball(5, 7), 0),
        "a Möbius strip of 67 triangles": without(band(1, 17), 5),
    }
    for case, surface in many.items():
        points, triangles = shuffled(random, flipped(random, surface))
        rough = points + random.uniform(-0.05, 0.05, points.shape)
        calls.append(Call("turns", (rough, triangles), case))
    strip = shuffled(random, flipped(random, unjoined(1, 6)))
    seams = {
        "a strip with a half twist, whose ends meet without common vertices": strip,
        "halves of a sphere that meet without common vertices": shuffled(random, halves(1, 5)),
    }
    made = larger_numbers(random) | few(random) | seams | long_ones(random)
    made |= tails(random) | numbers_on_both_sides(random)
    alone = np.eye(3), np.array([[0, 1, 2], [1, 2, 0]])
    for case, other in (("a sphere", ball(2, 4)), ("a strip", sheet(1, 4))):
        made[f"a triangle listed twice, and {case}"] = shuffled(random, joined(alone, other))
    return (*calls, *(Call("turns", surface, case, exact=(0,)) for case, surface in made.items()))


def long_ones(random: np.random.Generator) -> dict[str, Surface]:
    """Return strips so long that fifty rounds from neighbour to neighbour are too few.

    Their vertices lie anywhere, so that few normals are nearly perpendicular to each other.
    """
    strips = {
        "a strip of 420 triangles": sheet(1, 210),
        "a closed strip of 480 triangles": fused(sheet(1, 240), (0, 240), (241, 481)),
    }
    made = {case: shuffled(random, flipped(random, strip)) for case, strip in strips.items()}
    return {case: (random.normal(size=p.shape), t) for case, (p, t) in made.items()}


def tails(random: np.random.Generator) -> dict[str, Surface]:
    """Return Möbius strips with three long tails, of which no reversal makes a part consistent.

    A walk that stops at the first contradiction does not reach the ends of the tails.
    """
    made = {}
    for long in (20, 25):
        tail = sheet(1, long)
        n, m = 18, len(tail[0])
        ends = [n + k * m + end for k in range(3) for end in (0, long + 1)]
        strip = fused(joined(band(1, 6), tail, tail, tail), *zip(range(6), ends, strict=True))
        points, triangles = shuffled(random, flipped(random, strip))
        case = f"a Möbius strip with three tails of {2 * long} triangles"
        made[case] = random.normal(size=points.shape), triangles
    return made


ONE_SIDED = (
    *(0, 0, 0, 0, 24, 0, 24, 0, 0, 0, 0, 0, 67, 0, 0, 0, 0, 0, 0, 0),
    *(144, 174, 0, 0, 0, 0),
)
"""The number of triangles of these surfaces that belong to a one-sided part."""


def firsts(triangles: np.ndarray) -> list[int]:
    """Return the first triangle of each part that is connected across edges."""
    at: dict[frozenset[int], list[int]] = {}
    for k, side in enumerate(sides_by_name(triangles)):
        at.setdefault(frozenset(side), []).append(k // 3)
    first, groups = list(range(len(triangles))), [*at.values()]
    while any(first[t] != first[g[0]] for g in groups for t in g):
        for group in groups:
            lowest = min(first[t] for t in group)
            for t in group:
                first[t] = lowest
    return sorted(set(first))


@law("The first triangle of each orientable part must stay: its sign must be +1.")
def first_triangles_stay(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the number of parts whose first triangle was inverted."""
    pairs = zip(calls, values, strict=True)
    return float(sum((turn[firsts(call.arguments[1])] < 0).sum() for call, (turn,) in pairs))


@law(
    "With these signs no two triangles may run along an edge in the same direction. Parts that "
    "are not orientable, and no others, must have zeros."
)
def makes_them_agree(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the number of sides with the direction of another one after the reversals."""
    wrong = 0
    for call, (turn,), one_sided in zip(calls, values, ONE_SIDED, strict=True):
        triangles = call.arguments[1]
        wrong += abs(int((turn == 0).sum()) - one_sided) + int((np.abs(turn) > 1).sum())
        sides = sides_by_name(np.where(turn[:, None] < 0, triangles[:, ::-1], triangles)[turn != 0])
        wrong += len(sides) - len(set(sides))
    return float(wrong)


QUESTIONS = (
    Question(
        "14.6",
        "turns",
        4,
        turn_inputs,
        lambda call: ((len(call.arguments[1]),),),
        (makes_them_agree, first_triangles_stay),
    ),
)
