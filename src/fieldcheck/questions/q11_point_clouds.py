"""Questions of notebook 11, surfaces from point clouds: normals, graph, off-surface points.

The points lie at a fixed distance from an arc, on a horseshoe in the plane and on a torus in space.
Their normals are therefore known: they point away from the nearest point of the arc.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, in_short_binary_numbers, integers
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, relative

THICK = 0.4
"""Half the thickness of horseshoe and torus; the radius of the arc is one."""
END = 2.2
"""The angle at which the arc of the horseshoe ends, on both sides of the axis."""


def horseshoe(random: np.random.Generator, n: int, jitter: float = 0.3) -> np.ndarray:
    """Return n points of a horseshoe in random order."""
    along = (np.arange(n) + random.uniform(-jitter, jitter, n)) / n * (4 * END + 2 * np.pi * THICK)
    outer, cap = 2 * END * (1 + THICK), np.pi * THICK
    points = []
    for s in along % (2 * outer / (1 + THICK) + 2 * cap):
        if s < outer:
            angle, away = s / (1 + THICK) - END, 0.0
        elif s < outer + cap:
            angle, away = END, (s - outer) / THICK
        elif s < 2 * outer / (1 + THICK) + cap:
            angle, away = END - (s - outer - cap) / (1 - THICK), np.pi
        else:
            angle, away = -END, np.pi + (s - 2 * outer / (1 + THICK) - cap) / THICK
        points.append(np.exp(1j * angle) * (1 + THICK * np.exp(1j * away)))
    z = 1j * np.array(points)
    return np.column_stack([z.real, z.imag])[random.permutation(n)]


def torus(random: np.random.Generator, rows: int, columns: int) -> np.ndarray:
    """Return rows × columns points of a torus with an oblique axis, in random order."""
    i, j = (k.ravel() for k in np.mgrid[:rows, :columns])
    turn = 2 * np.pi * (i + random.uniform(-0.2, 0.2, i.size)) / rows
    round_axis = 2 * np.pi * (j + i % 2 / 2 + random.uniform(-0.2, 0.2, i.size)) / columns
    wide = 1 + THICK * np.cos(turn)
    points = np.column_stack(
        [wide * np.cos(round_axis), wide * np.sin(round_axis), THICK * np.sin(turn)]
    )
    return points[random.permutation(i.size)] @ OBLIQUE


OBLIQUE = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])


def outward(points: np.ndarray) -> np.ndarray:
    """Return the outward normals of horseshoe and torus at points on them."""
    if points.shape[1] == 2:
        angle = np.clip(np.arctan2(-points[:, 0], points[:, 1]), -END, END)
        foot = np.column_stack([-np.sin(angle), np.cos(angle)])
    else:
        straight = points @ OBLIQUE.T
        straight[:, 2] = 0
        foot = straight / np.sqrt((straight**2).sum(axis=1))[:, None] @ OBLIQUE
    return (points - foot) / np.sqrt(((points - foot) ** 2).sum(axis=1))[:, None]


def oval(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n points of an oval in order."""
    z = np.exp(2j * np.pi * (np.arange(n) + random.uniform(-0.25, 0.25, n)) / n)
    return np.column_stack([1.2 * z.real, 0.8 * z.imag])


def sheet(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n points of a tilted plane in space."""
    return random.uniform(-1, 1, (n, 2)) @ [[1, 0, 0], [0, 0.6, 0.8]]


def near(points: np.ndarray, k: int) -> np.ndarray:
    """Return the given graph as ones and zeros: the points that are near each other."""
    square = (points**2).sum(axis=1)
    gaps = square[:, None] + square - 2 * points @ points.T
    np.fill_diagonal(gaps, np.inf)
    rank = gaps.argsort(axis=1).argsort(axis=1) < k - 1
    return (rank | rank.T).astype(float)


# 11.1 Normals


def normals_inputs(seed: int) -> tuple[Call, ...]:
    """Return point clouds in the plane and in space, also far from the origin, small, and
    integers.
    """
    random = np.random.default_rng(seed)
    flat = (
        np.column_stack([random.uniform(-1, 1, (14, 2)), 0.05 * random.normal(size=14)]) @ OBLIQUE
    )
    name = "normals"
    first = oval(random, 16)
    near_line, far_line = random.uniform(-3, 3, (2, 9, 1))
    exactly_flat = (
        (near_line * [0.6, -0.8] + [1, 2], 4, "points on an oblique line"),
        (far_line * [0, 1] + [2, 0], 3, "points on a line parallel to an axis"),
        (sheet(random, 12), 6, "points of a tilted plane in space"),
        (random.uniform(-1, 1, (11, 3)) * [1, 1, 0] + [0, 0, 3], 5, "points of a horizontal plane"),
        (oval(random, 12), 2, "an oval, two neighbours"),
        (torus(random, 4, 7), 3, "a torus, three neighbours"),
    )
    return calls_of(
        name,
        ((first, 4), "an oval, four neighbours"),
        ((horseshoe(random, 30), 5), "a horseshoe, five neighbours"),
        ((torus(random, 5, 9), 7), "a torus in space"),
        ((flat, 14), "a rough plane of fourteen points, all of them neighbours"),
        ((oval(random, 12) + np.array([4e4, -2e4]), 4), "an oval far from the origin"),
        ((oval(random, 15) + np.array([-3e4, 5e4]), 5), "another oval far from the origin"),
        ((integers(oval(random, 14), 1e4), 4), "an oval, integers"),
        ((integers(torus(random, 4, 8), 1e4), 6), "a torus in space, integers"),
        ((2.0**-20 * oval(random, 13), 5), "an oval of the size 10⁻⁶"),
        ((first, 6), "the same oval, six neighbours"),
        ((first[::-1] * [1.0, -1.0], 4), "the mirror image of the oval, four neighbours"),
        ((2.0**20 * oval(random, 13), 5), "an oval of the size 10⁶"),
    ) + tuple(
        Call(name, (points, k), case, exact=(0,))
        for points, k, case in (
            *exactly_flat,
            *(
                (in_short_binary_numbers(oval(random, n)) + 2.0**26 * np.array(side), k, words)
                for n, k, side, words in (
                    (14, 4, (1, -1), "an oval very far from the origin"),
                    (17, 5, (-1, 1), "another oval very far from the origin"),
                )
            ),
        )
    )


def normals_shapes(call: Call) -> tuple[tuple[int, ...], ...]:
    return (call.arguments[0].shape, (len(call.arguments[0]),))


def coordinate_tolerance(call: Call) -> float:
    """Return the error of normals, distances or lengths that is caused by rounded coordinates."""
    points = call.arguments[0]
    return float(1e-8 + 1e-13 * np.abs(points).max() / np.ptp(points, axis=0).max())


@law(
    "Normals must have length 1, the variance of the neighbours along them must be the smallest, "
    "and q must be between 0 and 1.",
    1e-6,
)
def have_the_least_variance(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the excess of the variance over that of a nearby direction, and the deviation from
    length one.
    """
    worst = 0.0
    for call, (n, planarity) in zip(calls, values, strict=True):
        points, k = call.arguments
        worst = max(
            worst,
            relative((n * n).sum(axis=1) - 1, 1.0),
            float((-planarity).max()),
            float(planarity.max() - 1),
        )
        near = points[_squared_distances(points, points).argsort(axis=1)[:, :k]] - points[:, None]
        near = near - near.mean(axis=1, keepdims=True)
        least = _sums_of_squares(near, n)
        for axis in np.eye(points.shape[1]):
            beside = n + 1e-2 * axis
            rayleigh = _sums_of_squares(near, beside) / (beside * beside).sum(axis=1)
            worst = max(worst, float((least - rayleigh).max()))
    return worst


def _squared_distances(points: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return a row for each place."""
    return ((points - places[:, None]) ** 2).sum(axis=2)


def _sums_of_squares(near: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Sum the squares of the components of the vectors at each point in its direction."""
    return (np.matmul(near, directions[:, :, None]) ** 2).sum(axis=(1, 2))


def with_one_sign(_: Call, values: Values) -> Values:
    """Return normals oriented to one side of space."""
    n, *others = values
    side = np.where(n @ np.array([0.61, 0.79, 0.33])[: n.shape[1]] < 0, -1.0, 1.0)
    return (side[:, None] * n, *others)


def without_quotients_of_rounding_errors(call: Call, values: Values) -> Values:
    """Return normals with one sign, and the planarity unless it is 1 everywhere.

    If neighbours lie exactly on a line or plane, which holds for the calls with exact points, the
    smallest variance is a rounding error. Divided by it, any number may result.
    """
    n, planarity = with_one_sign(call, values)
    return n, 0 * np.isnan(planarity) if call.exact else planarity


# 11.2 The graph


def graph_inputs(seed: int) -> tuple[Call, ...]:
    """Return point clouds of uniform and of varying density, small and far from the origin."""
    random = np.random.default_rng(seed)
    uneven = np.column_stack([np.cumsum(1.3 ** np.arange(12.0)), random.uniform(0, 0.3, 12)])[
        random.permutation(12)
    ]
    square, space = random.uniform(size=(14, 2)), random.normal(size=(11, 3))
    return calls_of(
        "linked",
        ((square, 4), "points in a square"),
        ((2.0**-34 * square, 4), "points in a square of the size 10⁻¹⁰"),
        ((uneven, 3), "points that are dense at one end of a line"),
        ((random.normal(size=(11, 3)), 3), "points in space"),
        ((np.vstack([oval(random, 8), oval(random, 6) + 9]), 3), "two ovals"),
        ((square + np.array([3e7, -2e7]), 4), "points in a square far from the origin"),
        ((random.normal(size=(10, 3)) - 4e7, 3), "points in space, far from the origin"),
        ((random.normal(size=(6, 2)), 6), "six points, all of them neighbours"),
        ((square, 3), "the same points in a square, K = 3"),
        ((1 - square[::-1], 4), "the mirror images of the points in a square"),
        ((integers(square, 1e4), 4), "points in a square, integers"),
        ((integers(space, 1e4), 3), "points in space, integers"),
        ((2.0**-40 * space, 4), "points in space of the size 10⁻¹²"),
        ((2.0**30 * space, 4), "points in space of the size 10⁹"),
        ((random.normal(size=(2, 2)), 2), "two points"),
        ((random.uniform(size=(31, 2)), 4), "31 points in a square"),
    )


@law(
    "Links must go both ways, no point may be linked to itself, and each point must be linked to "
    "its K − 1 nearest others. There must be no other links."
)
def links_both_ways(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the number of points linked to themselves or in one direction only, and of missing and
    superfluous links.
    """
    wrong = 0
    for call, (graph,) in zip(calls, values, strict=True):
        points, k = call.arguments
        wrong += int((graph != graph.T).sum() + np.trace(graph)) + int(
            not np.isin(graph, (0, 1)).all()
        )
        nearest = np.zeros(graph.shape, dtype=bool)
        np.put_along_axis(
            nearest, _squared_distances(points, points).argsort(axis=1)[:, 1:k], True, axis=1
        )
        wrong += int((nearest & (graph == 0)).sum())
        wrong += int((~(nearest | nearest.T) & (graph != 0)).sum())
    return float(wrong)


# 11.4 Off-surface points


def moved_far(points: np.ndarray, offset: np.ndarray | float) -> np.ndarray:
    """Return points in another place, rounded so that their differences are exact.

    A relative change of 1e-14 would be large there: declare such points exact.
    """
    return np.rint(2.0**20 * points) / 2.0**20 + offset


def beside_inputs(seed: int) -> tuple[Call, ...]:
    """Return point clouds with much and little space: a horseshoe, also far from the origin, thin
    parts, a torus.
    """
    random = np.random.default_rng(seed)
    thin = oval(random, 24) * [1.0, 0.3]
    away = thin / [1.44, 0.64 * 0.09]
    thin_normals = away / np.hypot(*away.T)[:, None]
    bent, ring = horseshoe(random, 36), torus(random, 6, 10)
    name = "off_surface"
    moved = moved_far(bent, np.array([3e7, -2e7]))
    near_origin = calls_of(
        name,
        ((bent, outward(bent), 0.1), "a horseshoe with room on both sides"),
        ((bent, outward(bent), 1.7), "a horseshoe and points as far away as it is wide"),
        ((thin, thin_normals, 0.9), "a flat oval"),
        ((ring, outward(ring), 1.1), "a torus in space"),
        ((10 * bent, outward(bent), 9), "a horseshoe, and Δ = 9"),
        ((10 * ring, outward(ring), 7), "a torus in space, and Δ = 7"),
    )
    far = Call(name, (moved, outward(bent), 0.9), "a horseshoe far from the origin", exact=(0,))
    axes = np.array([[0, -1], [1, 0], [0, 1], [-1, 0]])
    small = calls_of(
        name,
        ((2.0**-34 * bent, outward(bent), 2.0**-34 * 1.7), "a horseshoe of the size 10⁻¹⁰"),
        ((2.0**-40 * ring, outward(ring), 2.0**-40 * 1.1), "a torus of the size 10⁻¹²"),
        (
            (2.0**-36 * thin, thin_normals, 2.0**-30),
            "a flat oval of the size 10⁻¹¹, and Δ of about 10⁻⁹",
        ),
        ((2.0**30 * bent, outward(bent), 2.0**30 * 0.9), "a horseshoe of the size 10⁹"),
        ((bent, -outward(bent), 1.7), "the same horseshoe, normals that point inward"),
        ((axes * random.permutation([[2], [3], [4], [5]]), axes, 3.3), "four points, integers"),
        ((bent[:2], outward(bent[:2]), 3), "two points, and Δ = 3"),
        *(
            ((points, directions, 0.9 * 2.0**40), case)
            for points, directions, case in (
                (*oval_and_tangents(random, 8), "eight points of an oval, and Δ = 10¹²"),
                (*six_on_axes(random), "six points on the axes of space, and Δ = 10¹²"),
            )
        ),
    )
    return (*near_origin, far, *small)


def oval_and_tangents(random: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return n points of an oval, and unit vectors along it.

    Far away along a tangent, on either side, another point is clearly nearer. So a very large Δ is
    halved for all lengths, and no length is so large that the others are rounding errors beside it.
    """
    points = oval(random, n)
    along = points[:, ::-1] * [-1.2 / 0.8, 0.8 / 1.2]
    return points, along / np.hypot(*along.T)[:, None]


def six_on_axes(random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return points on both sides of the origin on each axis, and directions of another axis."""
    axes = np.vstack([np.eye(3), -np.eye(3)])
    return random.uniform(1.5, 2.5, (6, 1)) * axes, np.roll(axes, 1, axis=1)


@law(
    "Each length must be Δ divided by a power of two. The point itself must be nearest to its "
    "off-surface point; at twice the length, if that is at most Δ, another point must be nearest."
)
def belong_to_their_sites(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the number of lengths that are not a power of 1/2, lead to another site, or could be
    doubled.
    """
    wrong = 0
    for call, (lengths,) in zip(calls, values, strict=True):
        points, n, distance = call.arguments
        halves = np.log2(distance / np.maximum(lengths, 1e-30 * distance))
        wrong += int((np.abs(halves - np.round(halves)) > 1e-6).sum()) + int((halves < -0.5).sum())
        for side, length in zip((n, -n), lengths.T, strict=True):
            wrong += int((~_are_nearest(points, points + length[:, None] * side)).sum())
            doubled = _are_nearest(points, points + 2 * length[:, None] * side)
            wrong += int((doubled & (length < 0.7 * distance)).sum())
    return float(wrong)


def _are_nearest(points: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Whether the nearest point to each place is the one with the same number."""
    return _squared_distances(points, places).argmin(axis=1) == np.arange(len(points))


QUESTIONS = (
    Question(
        "11.1",
        "normals",
        3,
        also_at_zero(normals_inputs, points=(0,)),
        normals_shapes,
        (have_the_least_variance,),
        coordinate_tolerance,
        with_one_sign,
        without_quotients_of_rounding_errors,
    ),
    Question(
        "11.2",
        "linked",
        2,
        also_at_zero(graph_inputs, points=(0,)),
        lambda call: (2 * (len(call.arguments[0]),),),
        (links_both_ways,),
        coordinate_tolerance,
    ),
    Question(
        "11.4",
        "off_surface",
        3,
        also_at_zero(beside_inputs, points=(0,)),
        lambda call: ((len(call.arguments[0]), 2),),
        (belong_to_their_sites,),
        coordinate_tolerance,
    ),
)
