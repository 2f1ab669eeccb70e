"""Questions of notebook 11, surfaces from point clouds: normals, orientation, off-surface points.

The points lie at a fixed distance from an arc, on a horseshoe in the plane and on a torus in space.
Their normals are therefore known: they point away from the nearest point of the arc.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
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


def sheet(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n points of a tilted plane in space."""
    return random.uniform(-1, 1, (n, 2)) @ [[1, 0, 0], [0, 0.6, 0.8]]


def upward_of_sheet(points: np.ndarray) -> np.ndarray:
    """Return the upward normals of the tilted plane."""
    return np.tile([0.0, -0.8, 0.6], (len(points), 1))


def random_signs(random: np.random.Generator, normals: np.ndarray) -> np.ndarray:
    """Return normals with random signs, like estimated normals."""
    rough = random.choice([-1.0, 1.0], (len(normals), 1)) * normals + 0.01 * random.normal(
        size=normals.shape
    )
    return rough / np.sqrt((rough**2).sum(axis=1))[:, None]


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
        (random.uniform(-1, 1, (11, 3)) * [1, 1, 0] + [0, 0, 3], 5, "points of a level plane"),
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
        ((first[::-1] * [1.0, -1.0], 4), "its mirror image, four neighbours"),
        ((2.0**20 * oval(random, 13), 5), "an oval of the size 10⁶"),
    ) + tuple(Call(name, (points, k), case, exact=(0,)) for points, k, case in exactly_flat)


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
        for p, normal in zip(points, n, strict=True):
            near = points[((points - p) ** 2).sum(axis=1).argsort()[:k]] - p
            near = near - near.mean(axis=0)
            least = ((near @ normal) ** 2).sum()
            for d in range(len(p)):
                beside = normal + 1e-2 * np.eye(len(p))[d]
                worst = max(worst, float(least - ((near @ beside) ** 2).sum() / (beside @ beside)))
    return worst


def with_one_sign(_: Call, values: Values) -> Values:
    """Return normals oriented to one side of space."""
    n, *others = values
    side = np.where(n @ np.array([0.61, 0.79, 0.33])[: n.shape[1]] < 0, -1.0, 1.0)
    return (side[:, None] * n, *others)


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
        ((1 - square[::-1], 4), "their mirror images"),
        ((integers(square, 1e4), 4), "points in a square, integers"),
        ((integers(space, 1e4), 3), "points in space, integers"),
        ((2.0**-40 * space, 4), "points in space of the size 10⁻¹²"),
        ((2.0**30 * space, 4), "points in space of the size 10⁹"),
        ((random.normal(size=(2, 2)), 2), "two points"),
        ((random.uniform(size=(31, 2)), 4), "31 points in a square"),
    )


@law(
    "Links must go both ways, no point may be linked to itself, and each point must be linked to "
    "its K − 1 nearest others."
)
def links_both_ways(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the number of points linked to themselves, in one direction only, or to no nearest
    point.
    """
    wrong = 0
    for call, (graph,) in zip(calls, values, strict=True):
        points, k = call.arguments
        wrong += int((graph != graph.T).sum() + np.trace(graph)) + int(
            not np.isin(graph, (0, 1)).all()
        )
        for p, row in zip(points, graph, strict=True):
            gaps = np.sqrt(((points - p) ** 2).sum(axis=1))
            order = gaps.argsort()
            wrong += k - 1 - int(row[order[1:k]].sum())
        wrong += max(0, int(graph.sum()) - 2 * (k - 1) * len(points))
    return float(abs(wrong))


# 11.3 Orientation


def near(points: np.ndarray, k: int) -> np.ndarray:
    """Return the given graph as ones and zeros: the points that are near each other."""
    square = (points**2).sum(axis=1)
    gaps = square[:, None] + square - 2 * points @ points.T
    np.fill_diagonal(gaps, np.inf)
    rank = gaps.argsort(axis=1).argsort(axis=1) < k - 1
    return (rank | rank.T).astype(float)


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


@law("Each normal must be the given one or its opposite, and must point outward.")
def point_outward(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the number of normals that point inward or are not ± the given ones."""
    wrong = 0.0
    for call, (n,) in zip(calls, values, strict=True):
        points, given, _ = call.arguments
        wrong = max(wrong, relative(np.minimum(np.abs(n - given), np.abs(n + given)), 1.0))
        wrong += float(((n * OUTWARD[call.case](points)).sum(axis=1) < 0).sum())
    return wrong


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
        ((2.0**-36 * thin, thin_normals, 2.0**-30), "a flat oval of the size 10⁻¹¹"),
        ((2.0**30 * bent, outward(bent), 2.0**30 * 0.9), "a horseshoe of the size 10⁹"),
        ((bent, -outward(bent), 1.7), "the same horseshoe, normals that point inward"),
        ((axes * random.permutation([[2], [3], [4], [5]]), axes, 3.3), "four points, integers"),
        ((bent[:2], outward(bent[:2]), 3), "two points, and Δ = 3"),
    )
    return (*near_origin, far, *small)


@law(
    "The point itself must be nearest to its off-surface point; at twice the length, if that is at "
    "most Δ, another point must be nearest."
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
        for i, (p, normal) in enumerate(zip(points, n, strict=True)):
            for side, length in zip((normal, -normal), lengths[i], strict=True):
                wrong += int(((points - p - length * side) ** 2).sum(axis=1).argmin() != i)
                if length < 0.7 * distance:
                    wrong += int(((points - p - 2 * length * side) ** 2).sum(axis=1).argmin() == i)
    return float(wrong)


QUESTIONS = (
    Question(
        "11.1",
        "normals",
        3,
        normals_inputs,
        normals_shapes,
        (have_the_least_variance,),
        coordinate_tolerance,
        with_one_sign,
    ),
    Question(
        "11.2",
        "linked",
        2,
        graph_inputs,
        lambda call: (2 * (len(call.arguments[0]),),),
        (links_both_ways,),
        coordinate_tolerance,
    ),
    Question(
        "11.3",
        "orient",
        4,
        orient_inputs,
        lambda call: (call.arguments[1].shape,),
        (point_outward,),
    ),
    Question(
        "11.4",
        "off_surface",
        3,
        beside_inputs,
        lambda call: ((len(call.arguments[0]), 2),),
        (belong_to_their_sites,),
        coordinate_tolerance,
    ),
)
