"""Questions of notebook 08 on one tetrahedron: its volume, circumcentre and normals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, in_short_binary_numbers, integers
from fieldcheck.inputs.simplices import (
    is_equally_far,
    is_equally_far_from_afar,
    is_halved,
    moved_far_away,
    relative_to_a_corner,
    tolerance_far_away,
)
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Law, Question, law, relative
from fieldcheck.questions.q07_triangles import SMALL, small_simplices


def moved(points: np.ndarray, distance: float = 2.0**14) -> np.ndarray:
    """Return rounded points 10⁴ away, or as far as given: their differences are exact."""
    return in_short_binary_numbers(points) + distance * np.array([1, -1, 1])


# 08.1 and 08.2 Tetrahedra


def tetrahedra(name: str, seed: int) -> tuple[Call, ...]:
    """Return a tetrahedron, the same in another order, half of it, a flat and two small ones."""
    random = np.random.default_rng(seed)
    corner = np.array(
        [[0.0, 0, 0], [2, 0.3, 0.1], [0.7, 1.6, -0.2], [0.6, 0.5, 1.9]]
    ) + random.uniform(-0.3, 0.3, (4, 3))
    a, b, c, d = corner + np.array([1.5, -2.5, 0.8])
    low = (a + 2 * b + 2 * c) / 5 + 0.25 * (d - a)
    return calls_of(
        name,
        ((a, b, c, d), "a tetrahedron"),
        ((a, c, b, d), "the same tetrahedron, listed the other way round"),
        ((a, b, c, (c + d) / 2), "half of the tetrahedron"),
        ((b, a, c, low), "a flat tetrahedron, listed the other way round"),
        (tuple(1e-4 * p for p in (a, c, b, d)), "a tetrahedron of the size 10⁻⁴"),
        (tuple(integers(p) for p in (a, b, c, d)), "a tetrahedron of integers"),
        (tuple(integers(p, 200) for p in (a, c, b, d)), "another tetrahedron of integers"),
        (tuple(2.0**-34 * p for p in (a, b, c, d)), "a tetrahedron of the size 10⁻¹⁰"),
        (tuple(1e5 * p for p in (a, b, c, d)), "a tetrahedron of the size 10⁵"),
        (tuple(1e5 * p for p in (b, a, c, low)), "a flat tetrahedron of the size 10⁵"),
        ((a, b, 1.2 * a - 0.2 * b + 0.3 * (c - a), d), "an obtuse angle at a"),
        ((a, 1.3 * a - 0.3 * d + 0.4 * (b - a), c, d), "another obtuse angle at a"),
    )


def volume_inputs(seed: int) -> tuple[Call, ...]:
    """Return the tetrahedra, two slivers, two with a needle as a face, two of the tetrahedra far
    from the origin, and two small ones.
    """
    near = tetrahedra("volume", seed)
    random = np.random.default_rng(seed + 1)
    calls = []
    for order, case in (((0, 1, 2, 3), "a sliver"), ((3, 1, 0, 2), "another sliver")):
        three = np.array([[0, 0, 0], [1, 0, 0.4], [0.3, 1, 0]]) + random.uniform(0, 0.3, (3, 3))
        above = 1e-5 * random.uniform(1, 2, 3) * [-1, -1, 1]
        four = in_short_binary_numbers(np.vstack([three, random.dirichlet([9, 9, 9]) @ three]))
        four[3] += in_short_binary_numbers(above)
        calls.append(Call("volume", tuple(four[list(order)]), case, exact=(0, 1, 2, 3)))
        ends = in_short_binary_numbers(three[1:])
        beside = in_short_binary_numbers((ends[0] + ends[1]) / 2 + above)
        thin = np.vstack([ends, beside, four[0] + np.array([0, 0, 1])])[list(order)]
        words = f"{case} with three corners nearly on a line"
        calls.append(Call("volume", tuple(thin), words, exact=(0, 1, 2, 3)))
        for vertices, name in ((four[list(order)], case), (thin, words)):
            moved_on = tuple(vertices + 2.0**20 * np.array([1, -1, 1]))
            calls.append(Call("volume", moved_on, f"{name}, 10⁶ away", exact=(0, 1, 2, 3)))
    for call, case in (
        (near[0], "the first tetrahedron, 10⁴ away"),
        (near[3], "a flat tetrahedron, 10⁴ away"),
    ):
        far = tuple(moved(corner) for corner in call.arguments)
        calls.append(Call("volume", far, case, exact=(0, 1, 2, 3)))
    for call, case in (
        (near[0], "a corner at the origin"),
        (near[3], "a flat one, its corner at the origin"),
    ):
        corners = tuple(corner - call.arguments[0] for corner in call.arguments)
        calls.append(Call("volume", corners, case))
    small = small_simplices("volume", seed, near[0], near[3], size=SMALL)
    return near + tuple(calls) + small + low(random)


def low(random: np.random.Generator) -> tuple[Call, ...]:
    """Return tetrahedra of the height 10⁻⁸ on a face that is parallel to two axes."""
    face = np.array([[0, 0, 2], [11, 1, 2], [3, 12, 2]]) + random.integers(-2, 3, (1, 3))
    tip = face.mean(axis=0) + np.array([0, 0, 2.0**-27])
    corners = np.vstack([face, tip])
    return tuple(
        Call("volume", tuple(four), case, exact=(0, 1, 2, 3))
        for four, case in (
            (corners, "a tetrahedron of the height 10⁻⁸"),
            (corners[[3, 1, 0, 2]][:, [2, 0, 1]], "another tetrahedron of the height 10⁻⁸"),
        )
    )


def tolerance_of_flatness(call: Call) -> float:
    """Return the error of a factorization, whose rounding errors are those of the longest side."""
    sides = np.ptp(np.stack(call.arguments), axis=0)
    return float(1e-9 + 1e-14 * sides.max() / sides.min())


VOLUME_IS_HALVED = Law(
    "A volume must be positive and must not depend on the order of the corners. A plane through "
    "one edge and the middle of the opposite edge must cut it in half.",
    is_halved,
)


def circumcenter_inputs(seed: int) -> tuple[Call, ...]:
    """Return the tetrahedra, two of them far from the origin, two in layers, and two small ones."""
    near = tetrahedra("circumcenter", seed)
    cases = ("the first tetrahedron, far from the origin", "a flat tetrahedron, far away")
    layers = calls_of(
        "circumcenter",
        *(
            (tuple(p * scale for p in near[0].arguments), f"a tetrahedron in a thin layer, {words}")
            for scale, words in (
                ([1, 1, 0.02], "lying"),
                ([0.02, 1, 1], "upright"),
                ([1, 3e-3, 1], "three thousandths thick"),
                ([3e-3, 1, 1], "upright, three thousandths thick"),
                ([1, 1, 5e-4], "half a thousandth thick"),
                ([1, 5e-4, 1], "upright, half a thousandth thick"),
            )
        ),
    )
    small = small_simplices("circumcenter", seed, near[0], near[3])
    return near + moved_far_away((near[0], near[3]), cases) + layers + small


# 08.4 The volume of the normals


def normals_inputs(seed: int) -> tuple[Call, ...]:
    """Return three edges, the same longer and in another order, perpendicular edges, tips in arrays
    of integers, and short edges.
    """
    random = np.random.default_rng(seed)
    center = random.normal(size=3)
    edges = np.array([[1.4, 0.2, 0.1], [0.3, 0.9, -0.2], [0.2, 0.4, 1.7]]) + random.uniform(
        -0.15, 0.15, (3, 3)
    )
    frame = np.linalg.qr(random.normal(size=(3, 3)))[0]
    frame = -np.sign(np.linalg.det(frame)) * frame
    name = "volume_of_normals"
    obtuse = edges * [[1], [1], [-1]]
    nearly_in_one_plane = np.array([[1, 0, 0], [0, 1, 0], [0.4, -0.7, 0.01]]).dot(edges)
    calls = calls_of(
        name,
        ((center, center + edges), "a tetrahedron"),
        (
            (-center, np.array([[2.0], [0.5], [1.5]]) * edges - center),
            "the same directions elsewhere, other lengths",
        ),
        ((center, center + edges[[1, 0, 2]]), "the same tips in another order"),
        (
            (-center, random.uniform(1, 2, (3, 1)) * frame - center),
            "perpendicular edges",
        ),
        ((center, integers(edges)), "tips in an array of integers"),
        ((-center, integers(edges[[2, 0, 1]], 7)), "tips in an array of small integers"),
        ((2.0**-50 * center, 2.0**-50 * (center + edges)), "a tetrahedron of the size 10⁻¹⁵"),
        ((center, center + obtuse), "obtuse angles"),
        ((-center, obtuse[[2, 0, 1]] - center), "obtuse angles elsewhere"),
        ((2.0**-50 * center, 2.0**-50 * (center + obtuse)), "obtuse angles, the size 10⁻¹⁵"),
        ((2.0**30 * center, 2.0**30 * (center + edges)), "a tetrahedron of the size 10⁹"),
        ((1e6 * center, 1e6 * (center + obtuse)), "obtuse angles, the size 10⁶"),
        (
            (np.array([2, -1, 1]), np.array([2, -1, 1]) + integers(edges)),
            "a vertex and tips in arrays of integers",
        ),
        (
            (np.array([1, 3, -2]), np.array([1, 3, -2]) + integers(obtuse)),
            "a vertex and other tips in arrays of integers",
        ),
        ((center, center + nearly_in_one_plane), "edges nearly in one plane"),
        ((-center, 2 * nearly_in_one_plane[::-1] - center), "other edges nearly in one plane"),
        ((random.integers(-9, 10, 3), 20 * edges), "a vertex in an array of integers"),
        ((random.integers(-9, 10, 3), 30 * obtuse), "a vertex of integers, obtuse angles"),
    )
    away = tuple(
        Call(name, (moved(center), moved(center + part)), f"{words}, 10⁴ away", exact=(0, 1))
        for part, words in ((edges, "a tetrahedron"), (obtuse, "obtuse angles"))
    )
    small = small_simplices(name, seed, calls[0], calls[7])
    return calls + away + small


@law("The volume must not depend on the lengths of the edges nor on their order.")
def depends_on_directions(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the effect of lengths and order."""
    here, longer, turned = (float(v) for (v,) in values[:3])
    return max(relative(longer - here, here), relative(turned - here, here))


@law("Perpendicular normals must span the volume one.")
def is_one_if_perpendicular(_: Sequence[Call], values: Sequence[Values]) -> float:
    return abs(float(values[3][0]) - 1)


QUESTIONS = (
    Question(
        "08.1",
        "volume",
        1,
        also_at_zero(volume_inputs, points=(0, 1, 2, 3)),
        lambda _: ((),),
        (VOLUME_IS_HALVED,),
        tolerance_of_flatness,
    ),
    Question(
        "08.2",
        "circumcenter",
        2,
        also_at_zero(circumcenter_inputs, points=(0, 1, 2, 3)),
        lambda _: ((3,),),
        (is_equally_far, is_equally_far_from_afar),
        tolerance_far_away,
        relative_to_a_corner,
    ),
    Question(
        "08.4",
        "volume_of_normals",
        2,
        also_at_zero(normals_inputs, points=(0, 1)),
        lambda _: ((),),
        (depends_on_directions, is_one_if_perpendicular),
        may_call=("08.1", "08.2"),
    ),
)
