"""Questions of notebook 14, mesh errors that depend on the positions of the vertices."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law

# 14.1 Coincident vertices


def copies(random: np.random.Generator, n: int, tolerance: float) -> np.ndarray:
    """Return points in one, two or three copies that differ by less than the tolerance, shuffled.

    Some other points are only slightly farther apart, along a diagonal.
    """
    cells = np.array(np.unravel_index(random.permutation(512)[:n], (8, 8, 8))).T
    off = tolerance * np.array(
        [[0.0, 0, 0], [-0.45, 0.4, 0.35], [-0.2, 0.1, -0.25], [0.7, -0.7, 0.7]]
    )
    used = [((0,), (0, 1), (0, 1, 2), (0, 3))[k % 4] for k in range(n)]
    points = np.vstack(
        [
            10 * tolerance * (cell + 0.03) + off[list(which)]
            for cell, which in zip(cells, used, strict=True)
        ]
    )
    return points[random.permutation(len(points))]


def chain(random: np.random.Generator, n: int, d: int, tolerance: float) -> np.ndarray:
    """Return points along a line, neighbours nearer than the tolerance.

    The first three are in order, so that each of them is near the one before; the others are not.
    """
    along = tolerance * (0.9 * np.arange(n) + random.uniform(-0.04, 0.04, n))
    direction = random.normal(size=d)
    points = np.outer(along, direction / np.sqrt(direction.dot(direction)))
    return points[np.append([0, 1, 2], 3 + random.permutation(n - 3))] + random.normal(size=d)


def crowds(random: np.random.Generator, n: int, d: int, tolerance: float) -> np.ndarray:
    """Return 40 points in n groups, whose points differ by less than the tolerance, shuffled."""
    groups = 3 * np.eye(n, d)[random.permutation(40) % n]
    return tolerance * (groups + random.uniform(-0.25, 0.25, (40, d)))


BESIDE = np.array([[0.0, 0, 0], [3, 4, 0], [9, 0, 0], [9, 3, 4], [20, 0, 0], [20, 0, 6]])
"""Points whose distances are exact: 5 and 6."""


def weld_inputs(seed: int) -> tuple[Call, ...]:
    """Return points with exact copies, near copies, far from the origin, and without copies."""
    random = np.random.default_rng(seed)
    cloud = random.normal(size=(9, 3))
    exact = cloud[np.r_[random.permutation(9), random.permutation(9)[:5], 0, 0]]
    close = np.vstack([cloud, cloud[:4] + 4e-10 * np.eye(4, 3), cloud[4:8]])
    return (
        Call("weld", (copies(random, 12, 1e-3), 1e-3), "points with near copies"),
        Call("weld", (exact, 0.0), "points with exact copies, and the tolerance zero", exact=(0,)),
        Call("weld", (close, 0.0), "points 4·10⁻¹⁰ apart, and the tolerance zero", exact=(0,)),
        Call("weld", (close, 1e-10), "points 4·10⁻¹⁰ apart, and the tolerance 10⁻¹⁰", exact=(0,)),
        Call("weld", (chain(random, 9, 2, 0.1), 0.1), "a chain of nine points in the plane"),
        Call("weld", (chain(random, 12, 3, 2.0), 2.0), "a chain of twelve points in space"),
        Call(
            "weld",
            (copies(random, 8, 0.5) + 1e6, 0.5),
            "points with near copies, far from the origin",
        ),
        Call("weld", (cloud, 1e-6), "nine points without copies"),
        Call("weld", (BESIDE, 5.0), "points whose distance is the tolerance 5", exact=(0, 1)),
        Call("weld", (BESIDE.astype(int), 5), "points that are an array of integers", exact=(0, 1)),
        Call("weld", (2.0**-30 * close, 0.0), "close points, and the tolerance zero", exact=(0,)),
        Call("weld", (copies(random, 60, 1e-3), 1e-3), "many points with near copies"),
        Call("weld", (random.normal(size=(1, 2)), 0.3), "a single point in the plane"),
        *(
            Call("weld", (copies(random, n, size)[:, :d] + away, size), case, exact=(0,))
            for n, d, size, away, case in (
                (33, 3, 0.1, 0, "65 points with near copies"),
                (49, 2, 10.0, 0, "97 points of the plane with near copies"),
                (9, 3, 1e-3, 1e5, "points with near copies, very far from the origin"),
                (11, 2, 1e-3, -1e5, "points of the plane, very far from the origin"),
                (10, 3, 1e-9, 0, "points with near copies, 10⁻⁹ apart"),
                (9, 2, 1e-12, 0, "points of the plane with near copies, 10⁻¹² apart"),
                (9, 3, 1e9, 0, "points with near copies, 10⁹ apart"),
                (10, 2, 1e12, 0, "points of the plane with near copies, 10¹² apart"),
                (132, 3, 0.1, 0, "264 points with near copies"),
            )
        ),
        Call("weld", (crowds(random, 3, 3, 0.1), 0.1), "points with a dozen near copies each"),
        Call("weld", (crowds(random, 2, 2, 1.0), 1.0), "twenty points at each of two places"),
        Call("weld", (random.normal(size=(3, 3)), 0.1), "three points in space"),
        Call("weld", (random.normal(size=(2, 2)), 9.0), "two near points in the plane"),
    )


@law(
    "Each vertex must be replaced by one within the tolerance, and no vertex before that one may "
    "be within the tolerance."
)
def is_the_first_coincident_vertex(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the number of vertices that map to no vertex, a distant one, or not the first one."""
    wrong = 0
    for call, (place,) in zip(calls, values, strict=True):
        points, tolerance = call.arguments
        near = np.sqrt(((points[:, None] - points) ** 2).sum(axis=2)) <= tolerance
        number = np.arange(len(points))
        exists = np.isin(place, number) & (place <= number)
        vertex = np.where(exists, place, 0).astype(int)
        is_first = near[number, vertex] & (near.argmax(axis=1) == vertex)
        wrong += int((~(exists & is_first)).sum())
    return float(wrong)


# 14.7 Degenerate triangles


def thin(
    random: np.random.Generator, base: float, height: float, foot: float, first: int
) -> np.ndarray:
    """Return the corners of a triangle; `foot` is the position of the foot of the height."""
    flat = np.array([[0, 0, 0], [base, 0, 0], [foot * base, height, 0]])
    return np.roll(flat, first, axis=0) @ np.linalg.qr(random.normal(size=(3, 3)))[
        0
    ] + random.normal(size=3)


HEIGHTS = (
    (1, 1, 0.5),
    (1, 1.6e-3, 0.4),
    (1, 5e-4, 0.4),
    (2, 5e-4, 0.0002),
    (2, 5e-4, 0.9),
    (0.004, 0.003, 0.5),
    (30, 1.7e-3, 0.3),
    (30, 7e-4, 0.3),
    (6e-4, 4e-4, 0.5),
    *3 * ((0.003, 9e-4, 0.5),),
    *3 * ((0.003, 1.1e-3, 0.4),),
    *3 * ((1, 8e-4, 0.002),),
    (10, 1e-6, 0.4),
    (0.003, 2.5e-3, 0.5),
    (1, 1.0003e-3, 0.4),
    (1, 0.9997e-3, 0.6),
)
"""Base, height and foot of the triangles that are tested with a tolerance of 0.001."""


LEVEL = np.array([[0.0, 0, 0], [4, 0, 0], [1, 0.5, 0], [2, 0.75, 0], [0, 0, 4], [0, 0.5, 2]])
LEVEL_NAMES = np.array([[0, 1, 2], [3, 0, 1], [4, 5, 0], [1, 2, 0]])
"""Triangles of the height 0.5, and one of the height 0.75, whose numbers are exact."""


def flat_inputs(seed: int) -> tuple[Call, ...]:
    """Return large and small triangles, needles, caps, points, and repeated vertices.

    Caps that are not quite flat come before heights that equal the tolerance: lost digits make both
    wrong.
    """
    random = np.random.default_rng(seed)
    corners = [thin(random, *numbers, k % 3) for k, numbers in enumerate(HEIGHTS)]
    corners += [
        np.repeat(random.normal(size=(1, 3)), 3, axis=0),
        random.normal(size=(2, 3))[[0, 1, 0]],
    ]
    points = np.concatenate(corners)
    named = np.append(np.arange(len(points)).reshape(-1, 3), [[4, 7, 4], [0, 9, 20]], axis=0)
    small = np.arange(3 * len(HEIGHTS)).reshape(-1, 3)
    calls = (
        Call(
            "flat",
            (points, named, 1e-3),
            "triangles in metres, with a tolerance of 1 mm",
            exact=(0,),
        ),
        Call(
            "flat",
            (1e-3 * points[: small.size], small, 1e-6),
            "triangles in kilometres, with a tolerance of 1 mm",
        ),
        Call("flat", (points[: small.size], small, 0.0), "the tolerance zero"),
        *(
            Call("flat", (size * points[: small.size], small, size * 1e-3), case)
            for size, case in ((1e-9, "triangles of the size 10⁻⁸"), (1e-12, "tiny triangles"))
        ),
        Call(
            "flat",
            (points, named[np.r_[0, -4:0]], 0.0),
            "equal corners, and the tolerance zero",
            exact=(0,),
        ),
        Call(
            "flat", (LEVEL, LEVEL_NAMES, 0.5), "heights of exactly 0.5, the tolerance", exact=(0, 2)
        ),
        Call(
            "flat",
            ((4 * LEVEL).astype(int), LEVEL_NAMES, 2),
            "points that are an array of integers, with heights of exactly 2, the tolerance",
            exact=(0, 2),
        ),
        Call(
            "flat",
            (points, named[::-1], 1e-3),
            "the triangles in metres, in the opposite order",
            exact=(0,),
        ),
        Call(
            "flat",
            (points[: small.size] + np.array([1e5, -2e5, 1e5]), small, 1e-3),
            "triangles far from the origin",
        ),
        *(
            Call("flat", (thin(random, *numbers, 1), np.array([[0, 1, 2]]), 1e-3), case)
            for numbers, case in (
                ((1, 5e-4, 0.4), "a single flat triangle"),
                ((1, 3e-3, 0.6), "a single triangle that is not flat"),
            )
        ),
        *(
            Call("flat", (size * thin_ones(random, n), names(n), size * 1e-3), case)
            for n, size, case in (
                (71, 1, "71 triangles in metres"),
                (69, 1e3, "69 triangles in millimetres"),
                (22, 1e9, "triangles in nanometres"),
                (22, 1e12, "huge triangles"),
                (3, 1, "three triangles in metres"),
                (3, 1e3, "three triangles in millimetres"),
                (101, 1, "101 triangles in metres"),
                (97, 1e3, "97 triangles in millimetres"),
            )
        ),
        Call(
            "flat", (BESIDE_LINE, LEVEL_NAMES, 0.25), "corners on a line, as integers", exact=(0, 2)
        ),
        Call(
            "flat",
            (BESIDE_LINE[:, [2, 0, 1]], LEVEL_NAMES[::-1], 1),
            "corners on a vertical line, as integers",
            exact=(0, 2),
        ),
        *(
            Call("flat", (nearly_caps(random, 12), names(12), tolerance), case)
            for tolerance, case in (
                (1e-9, "twelve caps of the height 3·10⁻⁹, with a tolerance of 10⁻⁹"),
                (0.0, "twelve caps of the height 3·10⁻⁹, with the tolerance zero"),
            )
        ),
    )
    return calls[:6] + calls[-2:] + calls[6:-2]


def nearly_caps(random: np.random.Generator, n: int) -> np.ndarray:
    """Return the corners of n caps that are not quite flat."""
    feet = random.uniform(0.3, 0.7, n)
    return np.concatenate([thin(random, 2, 3e-9, foot, k % 3) for k, foot in enumerate(feet)])


def thin_ones(random: np.random.Generator, n: int) -> np.ndarray:
    """Return the corners of n triangles with these heights, again and again."""
    chosen = enumerate(HEIGHTS[k % len(HEIGHTS)] for k in range(n))
    return np.concatenate(
        [thin(random, base, height, foot, k % 3) for k, (base, height, foot) in chosen]
    )


def names(n: int) -> np.ndarray:
    """Return n triangles without common vertices."""
    return np.arange(3 * n).reshape(n, 3)


BESIDE_LINE = np.array([[0, 0, 0], [9, 3, 0], [3, 1, 0], [1, 9, 0], [6, 2, 0], [-3, -1, 0]])
"""Points of a line, except for the fourth."""


FLAT_OF_HEIGHTS = (0, 0, 1, 1, 1, 0, 0, 1, 1, 1, 1, 1, 0, 0, 0, 1, 1, 1, 1, 0, 0, 1)
FLAT = (
    (*FLAT_OF_HEIGHTS, 1, 1, 1, 0),
    FLAT_OF_HEIGHTS,
    len(HEIGHTS) * (0,),
    FLAT_OF_HEIGHTS,
    FLAT_OF_HEIGHTS,
    (0, 1, 1, 1, 0),
    *2 * (12 * (0,),),
    (1, 0, 1, 1),
    (1, 0, 1, 1),
    (*FLAT_OF_HEIGHTS, 1, 1, 1, 0)[::-1],
    FLAT_OF_HEIGHTS,
    (1,),
    (0,),
    *((12 * FLAT_OF_HEIGHTS)[:n] for n in (71, 69, 22, 22, 3, 3, 101, 97)),
    (1, 0, 1, 1),
    (1, 1, 0, 1),
)


@law("A triangle must be flat if and only if its smallest height is at most the tolerance.")
def is_flat_as_made(_: Sequence[Call], values: Sequence[Values]) -> float:
    return max(float(np.abs(v - known).max()) for (v,), known in zip(values, FLAT, strict=True))


# 14.8 Segments that pass through a triangle


THROUGH = (
    (0.3, 0.3, 0.6, -0.5),
    (0.05, 0.9, 0.2, -0.7),
    (0.3, 0.3, 0.9, 0.4),
    (0.3, 0.3, -0.2, -0.8),
    (1.2, 0.3, 0.6, -0.5),
    (-0.3, 0.5, 0.6, -0.5),
    (0.4, -0.2, 0.6, -0.5),
    (0.6, 0.7, 0.8, -0.3),
    (0.2, 0.1, -0.6, 0.5),
    (-0.2, -0.3, 0.4, -0.4),
    (0.0004, 0.5, 0.6, -0.5),
    (-0.0004, 0.5, 0.6, -0.5),
    (0.3, 0.4, 0.6, -3e-7),
    (0.4, 0.3, 0.6, 3e-7),
)
"""Two coordinates in the plane of a triangle, and the heights of both ends."""


def pierced_inputs(seed: int) -> tuple[Call, ...]:
    """Return segments that pass through triangles, pass beside them, or do not reach them."""
    random = np.random.default_rng(seed)
    calls = []
    for case, size, middle in (
        ("fourteen segments and triangles", 1.0, 0.0),
        ("fourteen small segments and triangles away from the origin", 2.0**-18, 5.0),
    ):
        calls.append(
            Call("pierced", tuple(middle + size * p for p in pairs(random, THROUGH)), case)
        )
    for case, axes, offset in (
        ("segments, some of which end in the plane or lie in it", [0, 1, 2], 0.0),
        ("segments and vertical triangles of integers", [2, 0, 1], 3),
    ):
        start, end, triangle = (
            np.array(numbers)[..., axes] + offset for numbers in (FROM, TO, TRIANGLE)
        )
        corners = np.tile(triangle, (len(start), 1, 1))
        calls.append(Call("pierced", (start, end, corners), case, exact=(0, 1, 2)))
    for k, case in ((0, "a single segment"), (4, "a single segment beside its triangle")):
        calls.append(Call("pierced", tuple(a[[k]] for a in calls[0].arguments), case))
    for case, n, size, middle in (
        ("71 segments and triangles", 71, 1.0, 0.0),
        ("69 segments and triangles away from the origin", 69, 1.0, -20.0),
        ("twelve segments and triangles far from the origin", 12, 1.0, 1e5),
        ("twelve segments and triangles very far from the origin", 12, 1.0, -1e6),
        ("fourteen tiny segments and triangles", 14, 2.0**-30, 0.0),
        ("fourteen huge segments and triangles", 14, 2.0**30, 0.0),
        ("fourteen other huge segments and triangles", 14, 2.0**40, 0.0),
        ("fourteen segments and triangles of the size 10⁻⁶⁰", 14, 2.0**-200, 0.0),
        ("twelve segments and triangles of the size 10⁻⁶⁶", 12, 2.0**-220, 0.0),
    ):
        some = pairs(random, (19 * THROUGH)[:n])
        calls.append(Call("pierced", tuple(middle + size * p for p in some), case))
    for chosen, case in (
        ((0, 1, 8), "three segments and triangles"),
        ((10, 2, 12), "three other segments and triangles"),
    ):
        calls.append(Call("pierced", pairs(random, [THROUGH[k] for k in chosen]), case))
    for n, size, away, case in (
        (60, 1, 0, "sixty segments that end in the planes of oblique triangles of integers"),
        (61, 1, 0, "61 segments that end in the planes of oblique triangles of integers"),
        (65, 2.0**-12, 2.0**20, "65 segments that end in oblique planes, 10⁶ away"),
        (67, 2.0**-12, -(2.0**20), "67 segments that end in oblique planes, 10⁶ away"),
    ):
        bound = 10 if away == 0 else 4000
        ends = in_the_plane(random, n, bound)
        moved = tuple(size * p + away * np.array([1, -1, 0.5]) for p in ends) if away else ends
        calls.append(Call("pierced", moved, case, exact=(0, 1, 2)))
    return tuple(calls)


def in_the_plane(
    random: np.random.Generator, n: int, bound: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return integers: starts in the planes of oblique triangles, within them, ends, and corners.

    A start is the mean of the corners with the weights 1/2, 1/4 and 1/4. The largest coordinate
    relative to a corner is a power of two, so division by this size has no rounding errors.
    """
    a, end = random.integers(-bound, bound + 1, (2, n, 3))
    end[:, 0] = a[:, 0] + 2 ** int(np.log2(8 * bound))
    one, other = random.integers(1, bound // 2, (2, n, 3)) * [[[1, -1, 1]], [[1, 1, -1]]]
    return a + one + other, end, np.stack([a, a + 4 * one, a + 4 * other], axis=1)


def pairs(
    random: np.random.Generator, through: Sequence[tuple[float, ...]]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return both ends of segments that meet the planes of triangles there, and the triangles."""
    corners = random.normal(size=(len(through), 3, 3))
    corners[:, 1:] = (
        corners[:, :1] + np.array([[[2.0, 0.3, 0], [0.4, 1.7, 0.2]]]) + 0.2 * corners[:, 1:]
    )
    corners = corners @ np.linalg.qr(random.normal(size=(3, 3)))[0]
    u, v, high, low = np.array(through).T[:, :, None]
    a, b, c = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    slope = np.cross(b, c) + 0.3 * b - 0.2 * c
    place = a + u * b + v * c
    return place + high * slope, place + low * slope, corners


TRIANGLE = ((0, 0, 0), (4, 0, 0), (0, 4, 0))
FROM = ((1, 1, 2), (1, 1, 0), (1, 2, -3), (5, 5, 0), (5, 1, 2), (1, 1, 3), (-3, -1, 0), (2, 1, -1))
TO = ((1, 1, -2), (1, 1, 3), (1, 2, 0), (6, 7, 0), (5, 1, -2), (1, 2, 1), (-1, -2, 0), (1, 1, 1))
"""Ends of segments about this triangle."""
THROUGH_OR_NOT = (1, 1, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 1, 0)
IN_THE_PLANE_OR_NOT = (1, 0, 0, 0, 0, 0, 0, 1)
GOES_THROUGH = (
    *(*2 * (THROUGH_OR_NOT,), *2 * (IN_THE_PLANE_OR_NOT,), (1,), (0,)),
    *((19 * THROUGH_OR_NOT)[:n] for n in (71, 69, 12, 12, 14, 14, 14, 14, 12)),
    *((1, 1, 1), (1, 0, 1)),
    *(n * (0,) for n in (60, 61, 65, 67)),
)


@law(
    "A segment must count as passing through if and only if its ends are strictly on different "
    "sides of the plane and it meets the plane inside the triangle."
)
def goes_through_as_made(_: Sequence[Call], values: Sequence[Values]) -> float:
    known = zip(values, GOES_THROUGH, strict=True)
    return max(float(np.abs(v - np.array(through)).max()) for (v,), through in known)


QUESTIONS = (
    Question(
        "14.1",
        "weld",
        2,
        also_at_zero(weld_inputs, points=(0,)),
        lambda call: ((len(call.arguments[0]),),),
        (is_the_first_coincident_vertex,),
    ),
    Question(
        "14.7",
        "flat",
        2,
        flat_inputs,
        lambda call: ((len(call.arguments[1]),),),
        (is_flat_as_made,),
    ),
    Question(
        "14.8",
        "pierced",
        3,
        pierced_inputs,
        lambda call: ((len(call.arguments[0]),),),
        (goes_through_as_made,),
    ),
)
