"""Questions of notebook 07 on the hexagon, the circumcentre and the area of a triangle."""

from __future__ import annotations

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
from fieldcheck.inputs.variants import one_changed
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Law, Question, law_of_each, relative

# 07.1 The hexagon


def hexagon_inputs(seed: int) -> tuple[Call, ...]:
    """Return centres, radii and angles; each coordinate and the angle have both signs."""
    random = np.random.default_rng(seed)
    large = random.uniform(-90, 90, 2), random.uniform(20, 40), random.uniform(3.5, 6)
    tiny = 1e-12 * random.uniform(-1, 1, 2), 1e-12 * random.uniform(1, 2), -random.uniform(3.5, 6)
    small, clockwise, another = (
        (random.uniform(1, 2, 2) * signs, random.uniform(*radius), turn)
        for signs, radius, turn in (
            ((1, -1), (0.6, 0.9), random.uniform(0.2, 0.9)),
            ((-1, 1), (1.5, 2.5), -random.uniform(0.2, 0.9)),
            ((-1, -1), (0.9, 1.5), -random.uniform(0.2, 0.9)),
        )
    )
    calls = calls_of(
        "hexagon",
        (small, "a small hexagon"),
        (clockwise, "a large hexagon, turned clockwise"),
        (another, "another hexagon, turned clockwise"),
        (large, "a radius of more than 20, turned by more than 200°"),
        (tiny, "a radius of the size 10⁻¹², turned clockwise by more than 200°"),
        (
            (random.integers(1, 9, 2) * [1, -1], *small[1:]),
            "the first hexagon, a centre of integers",
        ),
        (
            (random.integers(1, 9, 2) * [-1, 1], *clockwise[1:]),
            "the second hexagon, a centre of integers",
        ),
        ((small[0], 3, small[2]), "a radius that is an integer"),
        (
            (random.integers(1, 9, 2) * [-1, 1], int(random.integers(2, 9)), -2),
            "a centre, a radius and an angle that are integers",
        ),
        ((clockwise[0], int(random.integers(2, 9)), 0), "the angle zero"),
    )
    center, radius, turn = another
    return calls + one_changed(
        calls[0],
        ("another centre", center),
        ("another radius", radius),
        ("another angle", turn),
    )


@law_of_each(
    "All sides and spokes of a regular hexagon must be as long as its radius, and its corners must "
    "be spread evenly around its centre."
)
def has_equal_sides(call: Call, values: Values) -> float:
    """Return the deviation of spokes and sides from the radius, and of their sum from zero."""
    (rim,) = values
    center, radius, _ = call.arguments
    lengths = [*np.hypot(*(rim - center).T), *np.hypot(*(rim - np.array([*rim[1:], rim[0]])).T)]
    return max(
        relative(np.array(lengths) - radius, radius), relative(rim.sum(axis=0) - 6 * center, rim)
    )


# 07.2 and 07.3 Circumcentre and area


TINY, SMALL = 2.0**-27, 2.0**-17
SIZES = {TINY: "10⁻⁸", SMALL: "10⁻⁵"}


def beside_the_origin(
    random: np.random.Generator, *parts: np.ndarray, size: float = TINY
) -> tuple[np.ndarray, ...]:
    """Return points shrunk to a size, in a place that is nearer to the origin than to other
    integers.

    They are rounded before, so that their differences are exact.
    """
    signs = random.choice([-1.0, 1.0], parts[0].size)
    place = in_short_binary_numbers(signs * random.uniform(0.3, 0.45, parts[0].size))
    return tuple(place + size * in_short_binary_numbers(part - parts[0]) for part in parts)


def small_simplices(name: str, seed: int, *calls: Call, size: float = TINY) -> tuple[Call, ...]:
    """Return the simplices of calls, much smaller than their distance from the origin."""
    random = np.random.default_rng(seed + 2)
    return tuple(
        Call(
            name,
            beside_the_origin(random, *call.arguments, size=size),
            f"{call.case}, the size {SIZES[size]}, beside the origin",
            exact=tuple(range(len(call.arguments))),
        )
        for call in calls
    )


def triangles(name: str, seed: int) -> tuple[Call, ...]:
    """Return a triangle, the same with two corners exchanged, half of it, and others.

    In two of them the products (b₁ − a₁)(c₂ − a₂) and (b₂ − a₂)(c₁ − a₁) have different signs.
    """
    random = np.random.default_rng(seed)
    a, b, c = (
        np.array([[0.0, 0.0], [2.0, 0.3], [0.7, 1.6]])
        + random.uniform(-0.3, 0.3, (3, 2))
        + [1.5, -2.5]
    )
    far = a + (b - a) * 2.5 + 0.4 * (c - a)
    upwards, sideways = np.array([[0.0, 1.5], [1.2, 0.0]])
    return calls_of(
        name,
        ((a, b, c), "a triangle"),
        ((a, c, b), "the same triangle, listed the other way round"),
        ((a, b, (b + c) / 2), "half of the triangle"),
        ((b, a, far), "an obtuse triangle, clockwise"),
        ((1e-12 * a, 1e-12 * c, 1e-12 * b), "a triangle of the size 10⁻¹²"),
        *(
            (
                tuple(np.roll([a, a + upwards, a + sideways], k, axis=0)),
                f"two sides along the axes, {words}",
            )
            for k, words in enumerate(("from a", "from b", "from c"))
        ),
        (tuple(integers(p) for p in (a, b, c)), "a triangle of integers"),
        (tuple(integers(p) for p in (b, a, far)), "an obtuse triangle of integers"),
        *(
            ((a, *(a + steps + random.uniform(-0.2, 0.2, (2, 2)))), case)
            for steps, case in (
                ([[1.4, 0.6], [-0.7, 1.3]], "a triangle whose lowest corner is a"),
                ([[1.3, 0.6], [0.6, -1.2]], "a triangle whose leftmost corner is a"),
            )
        ),
        ((1e-8 * b, 1e-8 * a, 1e-8 * far), "an obtuse triangle of the size 10⁻⁸"),
        ((1e5 * a, 1e5 * c, 1e5 * b), "a triangle of the size 10⁵"),
        ((1e5 * b, 1e5 * a, 1e5 * far), "an obtuse triangle of the size 10⁵"),
    )


def circumcenter_inputs(seed: int) -> tuple[Call, ...]:
    """Return the triangles, two of them far from the origin, two made thin, and two small."""
    near = triangles("circumcenter", seed)
    flat, narrow = (
        [part * scale for part in near[3].arguments] for scale in ([1, 0.02], [0.02, 1])
    )
    thin = calls_of(
        "circumcenter",
        (tuple(flat), "a flat triangle"),
        (tuple(narrow), "a narrow triangle"),
    )
    cases = ("the first triangle, far from the origin", "an obtuse triangle far from the origin")
    small = small_simplices("circumcenter", seed, near[0], near[3])
    return near + moved_far_away((near[0], near[3]), cases) + thin + small


def area_inputs(seed: int) -> tuple[Call, ...]:
    """Return the triangles, two needles, two of the triangles far from the origin, and two small.

    The coordinates of the last six are rounded, so that their differences are exact.
    """
    near = triangles("area", seed)
    random = np.random.default_rng(seed + 1)
    ends = random.uniform(0.3, 1, (2, 2)) * [[1, 1], [1, -1]]
    needles = [
        in_short_binary_numbers(np.array([[0, 0], end, part * end + 3e-6 * across]))
        for end, part, across in zip(ends, (0.4, 0.7), ends[:, ::-1] * [1, -1], strict=True)
    ]
    moved = [
        in_short_binary_numbers(np.array(call.arguments)) + 2.0**14 * np.array([1, -1])
        for call in (near[0], near[3])
    ]
    cases = (
        "a needle",
        "another needle",
        "the first triangle, 10⁴ away",
        "an obtuse triangle, 10⁴ away",
        "the first triangle, of the size 10⁻³, 10⁶ away",
        "an obtuse triangle, of the size 10⁻³, 10⁶ away",
    )
    for call in (near[0], near[3]):
        small = 2.0**-10 * in_short_binary_numbers(np.array(call.arguments))
        moved.append(small + 2.0**20 * np.array([1, -1]))
    corners = (needles[0], needles[1][[2, 0, 1]], *moved)
    exact = tuple(
        Call("area", tuple(three), case, exact=(0, 1, 2))
        for three, case in zip(corners, cases, strict=True)
    )
    return near + exact + small_simplices("area", seed, near[0], near[3], size=SMALL)


AREA_IS_HALVED = Law(
    "An area must be positive and must not depend on the order of the corners. A line from a "
    "corner to the middle of the opposite side must cut it in half.",
    is_halved,
)


QUESTIONS = (
    Question(
        "07.1",
        "hexagon",
        1,
        hexagon_inputs,
        lambda _: ((6, 2),),
        (has_equal_sides,),
        picture="polygon",
    ),
    Question(
        "07.2",
        "circumcenter",
        2,
        also_at_zero(circumcenter_inputs, points=(0, 1, 2)),
        lambda _: ((2,),),
        (is_equally_far, is_equally_far_from_afar),
        tolerance_far_away,
        relative_to_a_corner,
    ),
    Question(
        "07.3",
        "area",
        1,
        also_at_zero(area_inputs, points=(0, 1, 2)),
        lambda _: ((),),
        (AREA_IS_HALVED,),
    ),
)
