"""Questions of notebook 13, departure points, steps, and Burgers' equation."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, in_short_binary_numbers, integers
from fieldcheck.inputs.variants import one_changed
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Law, Question, law, relative

Deviation = Callable[[Sequence[Call], Sequence[Values]], float]
CORNERS = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
FAR = np.array([2.0**16, -(2.0**17)])
VERY_FAR = np.array([2.0**24, -(2.0**25)])
EXACT = 1e-8  # far below the error of one step of any scheme of the notebook


def in_disc(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n points in the unit disc, away from its centre and from each other."""
    turns = np.pi * (1 + np.sqrt(5)) * (np.arange(n) + random.uniform(0.4, 0.6, n))
    radii = np.sqrt((np.arange(n) + random.uniform(0.6, 0.9, n)) / n)
    return np.column_stack([radii * np.cos(turns), radii * np.sin(turns)])


def in_square(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n² points in the square from −1 to 1, each in a cell of its own."""
    cells = np.indices((n, n)).reshape(2, -1).T
    return 2 * (cells + random.uniform(0.3, 0.7, cells.shape)) / n - 1


# 13.1 to 13.3 Departure points


def feet_inputs(name: str, seed: int) -> tuple[Call, ...]:
    """Return points in the three flows, and in the vortex with half the time step.

    Some steps arrive at the time from which a step of other points came.
    """
    random = np.random.default_rng(seed)
    x, dt, t = in_disc(random, 8), random.uniform(0.03, 0.05), random.uniform(0.2, 0.4)
    whole = np.vstack([[[0, 0], [2, 0], [0, -1]], random.integers(-3, 4, (3, 2))])
    turning = ((in_square(random, 2), 0.5, 0.25), (0.7 * x[:4], 1.5, 0.3))
    moving = calls_of(
        name,
        ((x, t, dt, 1), "eight points in the vortex"),
        ((x, t, dt / 2, 1), "eight points in the vortex, half the step"),
        ((x, t, 2 * dt, 0), "eight points in the solid rotation"),
        ((0.9 * in_square(random, 2), t, 3 * dt, 2), "four points in the deformation flow"),
        ((whole, t, dt, 1), "points that are an array of integers, in the vortex"),
        ((whole, t, dt, 0), "points that are an array of integers, in the solid rotation"),
        (
            (CORNERS * random.uniform(0.55, 0.65, (4, 2)), 0.0, 0.9, 2),
            "a long step from the time 0 in the deformation flow",
        ),
        ((0.8 * x[::-1], t, dt, 1), "eight points elsewhere in the vortex"),
        ((x[3:4], -t, dt, 1), "a single point in the vortex, at a negative time"),
        ((0.7 * x[5:6], t, dt, 2), "a single point in the deformation flow"),
        ((in_disc(random, 7), t, dt, 1), "seven points in the vortex"),
        ((in_disc(random, 7), t - dt, dt, 1), "seven points in the vortex, one step earlier"),
        ((in_square(random, 3), t, dt, 2), "nine points in the deformation flow"),
        (
            (in_square(random, 3), t - dt, dt, 2),
            "nine points in the deformation flow, one step earlier",
        ),
        ((in_disc(random, 77), t, dt, 1), "77 points in the vortex"),
        ((in_square(random, 9), t, dt, 2), "81 points in the deformation flow"),
        ((x[:5], 2, 1, 1), "a step from the time 2 to the time 1, both whole numbers"),
        ((0.5 * x[3:], 3, 2, 2), "a step from the time 3 to the time 1, both whole numbers"),
        *(
            ((random.uniform(-0.8, 0.8, (2, 2)), t, 2 * dt, flow), f"two points in the {motion}")
            for flow, motion in ((1, "vortex"), (2, "deformation flow"), (0, "solid rotation"))
        ),
        ((x, t, 1.0, 0), "a step of a whole period in the solid rotation"),
        ((x[:5], t, 2.0, 0), "a step of two whole periods in the solid rotation"),
    )
    return moving + tuple(
        Call(
            name, (p, t, dt, 2), f"a step from the time {t}, when the deformation flow rests", (1,)
        )
        for p, t, dt in turning
    )


def vortex_error(call: Call, feet: np.ndarray) -> float:
    """Return the mean distance of departure points in the vortex from the rotated points."""
    x, t, dt, _ = call.arguments
    angle = np.pi * (2 * dt + t**2 - (t - dt) ** 2) / (1 + 4 * np.hypot(*x.T) ** 2)
    turned = (x[:, 0] + 1j * x[:, 1]) * np.exp(-1j * angle)
    return float(np.sqrt(np.mean(np.abs(feet[:, 0] + 1j * feet[:, 1] - turned) ** 2)))


def falls_with_order(order: int) -> Deviation:
    """Return the deviation of the observed order of the error of one step, minus half an
    order: a long step shows it only roughly.
    """

    def deviation(calls: Sequence[Call], values: Sequence[Values]) -> float:
        whole, half = (vortex_error(c, f) for c, (f,) in zip(calls[:2], values[:2], strict=True))
        if whole < EXACT:  # many short steps: their order is not seen, but the values differ
            return 0.0
        if not 0 < half < np.inf:
            return np.inf
        return max(0.0, abs(float(np.log2(whole / half)) - order) - 0.5)

    return deviation


def grows_by(square: Callable[[float], float]) -> Deviation:
    """Return the deviation of squared radii from those after one step in a rotation."""

    def deviation(calls: Sequence[Call], values: Sequence[Values]) -> float:
        x, _, dt, _ = calls[2].arguments
        before, after = (np.hypot(*p.T) ** 2 for p in (x, values[2][0]))
        return relative(after - square(float(2 * np.pi * dt)) * before, before)

    return deviation


def feet_question(
    number: int, scheme: str, points: int, order: int, square: Callable[[float], float], words: str
) -> Question:
    """Return the question on departure points by a scheme with this order of error per step.

    One step in a solid rotation by the angle a multiplies squared radii by `square(a)`, in words
    `words`.
    """
    return Question(
        f"13.{number}",
        scheme,
        points,
        lambda seed: feet_inputs(scheme, seed),
        lambda call: (call.arguments[0].shape,),
        (
            Law(
                f"In the vortex, halving the step must reduce the error about {2**order} times.",
                falls_with_order(order),
            ),
            Law(
                "In the solid rotation, one step must multiply squared distances from the centre "
                f"by {words}, where a = 2πΔt.",
                grows_by(square),
            ),
        ),
    )


# 13.5 The matrix of a step


def matrix_inputs(seed: int) -> tuple[Call, ...]:
    """Return departure points among few and all sites, at sites, and sites on a line."""
    random = np.random.default_rng(seed)
    sites, few = in_square(random, 5), in_square(random, 3)
    line = np.arange(8)[:, None] / 7 + random.uniform(-0.04, 0.04, (8, 1))
    beside = random.uniform(0.5, 1, (3, 2)) * np.array([[1e-3], [1e-4], [1e-6]])
    name = "step_matrix"
    calls = calls_of(
        name,
        ((sites, random.uniform(-1, 1, (6, 2)), 9), "six feet"),
        ((few, random.uniform(-1.2, 1.2, (4, 2)), 9), "four feet with all nine sites"),
        ((sites, sites[[7, 0, 18]], 8), "three feet that are sites"),
        ((line, random.uniform(-0.1, 1.1, (5, 1)), 4), "five feet on a line, with four sites each"),
        ((sites, sites[[6, 12, 17]] + beside, 8), "feet 10⁻³, 10⁻⁴ and 10⁻⁶ beside sites"),
        ((few, random.uniform(-1, 1, (11, 2)), 6), "more feet than sites"),
        (
            (2.0**-8 * sites, 2.0**-8 * random.uniform(-1, 1, (3, 2)), 9),
            "sites at distances of about 10⁻³",
        ),
        (
            (2.0**20 * sites, 2.0**20 * random.uniform(0, 1, (3, 2)), 9),
            "sites at distances of about 10⁶",
        ),
        ((few, random.uniform(4, 6, (2, 2)), 7), "feet far outside the sites"),
        (
            (random.integers(-200, 201, (12, 2)), random.integers(-200, 201, (3, 2)), 7),
            "sites and feet in whole numbers up to 200",
        ),
        ((200 * sites, random.integers(-200, 201, (3, 2)), 7), "feet that are integers"),
        (
            (integers(sites, 9), random.uniform(-9, 9, (4, 2)), 8),
            "sites that are an array of integers",
        ),
        ((sites, random.uniform(-1, 1, (1, 2)), 7), "a single foot"),
        ((few, random.uniform(-1, 1, (1, 2)), 9), "a single foot with all nine sites"),
        ((few, random.uniform(-1, 1, (2, 2))[[0, 1, 0]], 7), "three feet, two of them equal"),
    )
    return (
        *calls,
        *one_changed(
            calls[0],
            ("other sites", in_square(random, 5)),
            ("other feet", random.uniform(-1, 1, (6, 2))),
            ("seven sites each", 7),
        ),
        *calls_of(
            name,
            ((few[[0, 1, 3, 4, 5, 7, 8]], random.uniform(-1, 1, (71, 2)), 7), "71 feet"),
            ((in_square(random, 7)[:47], random.uniform(-1, 1, (45, 2)), 8), "45 feet, 47 sites"),
            (
                (in_square(random, 7)[:45], random.uniform(-1, 1, (3, 2)), 41),
                "three feet with 41 of 45 sites each",
            ),
            ((CORNERS[:3] * few[0], random.uniform(-1, 1, (4, 2)), 3), "three sites in the plane"),
            ((line, random.uniform(0, 1, (3, 1)), 2), "feet on a line, with two sites each"),
        ),
        *(
            Call(name, (places + away, random.uniform(-1, 1, (3, d)) + away, k), case, (0, 1))
            for places, d, k, away, case in (
                (sites, 2, 8, FAR / 16, "sites and feet far from the origin"),
                (line, 1, 4, FAR[:1] / 8, "sites and feet on a line, far from the origin"),
            )
        ),
        *calls_of(
            name,
            *(
                ((unit * places, unit * random.uniform(0, 1, (3, d)), k), case)
                for unit, places, d, k, case in (
                    (2.0**-24, sites, 2, 9, "sites at distances of about 10⁻⁸"),
                    (2.0**-30, line, 1, 4, "sites on a line, at distances of about 10⁻¹⁰"),
                    (2.0**20, line, 1, 4, "sites on a line, at distances of about 10⁵"),
                )
            ),
            ((sites, random.uniform(-1, 1, (2, 2)), 8), "two feet in the plane"),
            ((few, random.uniform(-1, 1, (9, 2)), 7), "as many feet as sites"),
        ),
        *(
            Call(
                name,
                (*(in_short_binary_numbers(p) + side * VERY_FAR for p in places), 8),
                f"{words} feet and 36 sites very far from the origin",
                (0, 1),
            )
            for side, n, words in ((1, 40, "forty"), (-1, 30, "thirty"))
            for places in ((in_square(random, 6), random.uniform(-1, 1, (n, 2))),)
        ),
    )


@law(
    "Linear fields must be reproduced: each row must sum to 1, with the foot as mean of the sites."
)
def reproduces_linear_fields(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of row sums from one, and of weighted means from departure points.

    Coordinates count from the foot, so that the origin does not matter.
    """
    worst = 0.0
    for call, (h,) in zip(calls, values, strict=True):
        sites, feet, _ = call.arguments
        away = sites - feet[:, None]
        worst = max(worst, float(np.abs(h.sum(axis=1) - 1).max()))
        worst = max(worst, relative(np.einsum("ij,ijk->ik", h, away), away))
    return worst


@law("Only the k sites nearest to a foot may have weights in its row.")
def uses_the_nearest_sites_only(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the largest weight of a site with at least k sites nearer to the departure point."""
    worst = 0.0
    for call, (h,) in zip(calls, values, strict=True):
        sites, feet, k = call.arguments
        for row, foot in zip(h, feet, strict=True):
            away = np.hypot.reduce(sites - foot, axis=1)
            nearer = (away[:, None] > away).sum(axis=1)
            worst = max(worst, float(np.abs(row[nearer >= k]).max(initial=0.0)))
    return worst


@law("If a foot is a site, the weight of this site must be 1, and all others must be 0.")
def is_one_at_its_site(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of rows for departure points at sites from unit vectors."""
    return float(np.abs(values[2][0] - np.eye(25)[[7, 0, 18]]).max())


# 13.6 Many steps


def advect_inputs(seed: int) -> tuple[Call, ...]:
    """Return a rotated affine field, a constant, and fields in the vortex and in the straining
    flow.
    """
    random = np.random.default_rng(seed)
    disc, square, dt = in_disc(random, 24), in_square(random, 4), random.uniform(0.04, 0.06)
    slope = random.normal(size=2)
    name = "advect"
    return calls_of(
        name,
        (
            (disc, 1 + disc @ slope, dt, 3, 0, 8),
            "an affine field in the solid rotation",
        ),
        ((disc, np.full(24, 2.5), dt, 2, 1, 8), "a constant in the vortex"),
        ((disc, random.normal(size=24), 2 * dt, 3, 1, 8), "a field in the vortex"),
        ((square, random.normal(size=16), 3 * dt, 2, 2, 9), "a field in the deformation flow"),
        ((disc, random.integers(-20, 20, 24), dt, 2, 1, 8), "values that are an array of integers"),
        (
            (0.9 * disc[:, ::-1], random.normal(size=24), 2 * dt, 3, 1, 8),
            "a field in the vortex, a smaller disc",
        ),
        (
            (in_square(random, 4), random.normal(size=16), 3 * dt, 2, 2, 9),
            "a field in the deformation flow, at its own sites",
        ),
        ((disc, random.normal(size=24), dt, 0, 1, 8), "no step"),
        (
            (integers(square, 6), random.normal(size=16), dt, 2, 1, 9),
            "sites that are an array of integers",
        ),
        *(
            ((disc, random.normal(size=24), 2 * dt, 3, flow, k), case)
            for flow, k, case in (
                (2, 8, "a field in the deformation flow, at the first sites"),
                (1, 9, "a field in the vortex, with nine sites for each foot"),
                (1, 8, "another field in the vortex"),
            )
        ),
        (
            (in_square(random, 7)[:47], random.normal(size=47), dt, 2, 2, 9),
            "47 sites in the deformation flow",
        ),
        ((in_disc(random, 71), random.normal(size=71), dt, 1, 1, 7), "71 sites in the vortex"),
        ((disc, random.normal(size=24), 1, 1, 1, 8), "a step from the time 1, a whole number"),
        (
            (0.6 * square, random.normal(size=16), 1, 1, 2, 9),
            "a step from the time 1 in the deformation flow, a whole number",
        ),
        *(
            ((*numbers, dt, 2, flow, 8), case)
            for flow, numbers, case in (
                (1, (disc, 1e-9 * random.normal(size=24)), "small values, about 10⁻⁹"),
                (2, (square, 1e-8 * random.normal(size=16)), "small values, about 10⁻⁸"),
                (1, (disc, 1e9 * random.normal(size=24)), "large values, about 10⁹"),
                (2, (square, 1e8 * random.normal(size=16)), "large values, about 10⁸"),
            )
        ),
        *(
            ((places, random.normal(size=len(places)), step, 5, flow, 8), case)
            for flow, places, step, case in (
                (2, square, 0.25, "five steps beyond the time 1 in the deformation flow"),
                (2, in_square(random, 4), 0.2, "five steps to the time 1 in the deformation flow"),
                (0, 0.8 * disc, 0.25, "five steps, more than a whole rotation"),
                (0, disc[:20], 0.2, "five steps, a whole rotation"),
            )
        ),
    )


@law("The first row must be the initial field, and a constant must remain constant.")
def constants_stay(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of a constant from itself, and of the first row from the start."""
    begins = max(
        relative(u[0] - c.arguments[1], u[0]) for c, (u,) in zip(calls, values, strict=True)
    )
    return max(begins, relative(values[1][0] - 2.5, 2.5))


@law(
    "In the solid rotation, each step of Δt must carry an affine field exactly from the departure "
    "points of RK4: the reconstruction has no error."
)
def affine_fields_rotate(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of an affine field from its values at the sites rotated step by step."""
    sites, u, dt, _, _, _ = calls[0].arguments
    w = -2j * np.pi * dt
    turn = 1 + w * (1 + w / 2 * (1 + w / 3 * (1 + w / 4)))
    z = sites[:, 0] + 1j * sites[:, 1]
    rows = [np.stack([z.real**0, (turn**n * z).real, (turn**n * z).imag], axis=1) for n in range(4)]
    c = np.linalg.pinv(rows[0]) @ u
    return relative(values[0][0] - np.array(rows) @ c, u)


# 13.11 Burgers' equation


def burgers_inputs(seed: int) -> tuple[Call, ...]:
    """Return a linear field, the same after one iteration, a wave, and a constant."""
    random = np.random.default_rng(seed)
    x = np.arange(9)[:, None] / 4 - 1 + random.uniform(-0.06, 0.06, (9, 1))
    wave = np.sin(2 * x[:, 0] + random.uniform(0, 1))
    rising = random.uniform(0.5, 0.8) * x[:, 0] + random.uniform(0.3, 0.6)
    dt, name, order = random.uniform(0.4, 0.6), "burgers_feet", random.permutation(9)
    return calls_of(
        name,
        ((x, rising, dt, 1, 4), "a linear field and one round"),
        ((x, rising, dt, 5, 4), "a linear field and five rounds"),
        ((x, wave, dt / 2, 3, 5), "a wave and three rounds"),
        ((x, np.full(9, 0.7), dt, 2, 4), "a constant"),
        (
            (x[order], wave[order], dt / 2, 3, 5),
            "a wave and three rounds, the sites in another order",
        ),
        ((x, 3 * x[:, 0] + 0.1, dt, 7, 4), "a linear field and rounds that diverge"),
        ((x, wave, 3 * dt, 1, 5), "a wave and one long step"),
        (
            (np.cumsum(random.integers(2, 6, 8))[:, None], random.normal(size=8), dt, 2, 4),
            "sites that are an array of integers",
        ),
        ((x, random.integers(-3, 4, 9), dt / 2, 3, 5), "velocities that are an array of integers"),
        ((x, wave, dt, 0, 4), "a wave and no round"),
        ((x, wave[::-1], dt / 2, 3, 5), "a wave of the opposite direction"),
        ((x + 0.2 * wave[:, None], wave, dt / 2, 3, 5), "a wave at uneven sites"),
        *((wave_at(random, random.permutation(n), dt / 2, 2, 5), f"{n} sites") for n in (45, 71)),
        (wave_at(random, random.permutation(7), 1, 2, 4), "a step of length 1, a whole number"),
        *(
            ((length * x, speed * wave, length / speed * dt / 2, 2, 5), case)
            for length, speed, case in (
                (2.0**-30, 2.0**-30, "sites 10⁻⁹ apart, and small velocities"),
                (2.0**-20, 2.0**10, "sites 10⁻⁶ apart, and short steps"),
                (2.0**30, 2.0**30, "sites 10⁹ apart, and large velocities"),
                (2.0**20, 2.0**-10, "sites 10⁶ apart, and long steps"),
            )
        ),
    )


def wave_at(
    random: np.random.Generator, order: np.ndarray, dt: float, rounds: int, k: int
) -> tuple[np.ndarray | float, ...]:
    """Return sites on the line in this order, the velocities of a wave, and the other arguments."""
    x = (order[:, None] + random.uniform(-0.2, 0.2, (len(order), 1))) / 4
    return x, 0.5 * np.sin(2 * x[:, 0]), dt, rounds, k


@law("If the velocity is linear, each round must add a term of a geometric series.")
def converges_as_a_geometric_series(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of departure points in a linear field from partial geometric sums."""
    worst = 0.0
    for call, (y,) in zip(calls[:2], values[:2], strict=True):
        x, u, dt, rounds, _ = call.arguments
        slope = (u[-1] - u[0]) / (x[-1, 0] - x[0, 0])
        series = sum((-slope * dt) ** n for n in range(rounds))
        worst = max(worst, relative(x[:, 0] - y[:, 0] - dt * u * series, x))
    return worst


@law("A constant velocity must shift all points equally.")
def constant_shifts(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of departure points in a constant flow from equally shifted points."""
    x, u, dt, _, _ = calls[3].arguments
    return relative(x - values[3][0] - dt * u[0], x)


QUESTIONS = (
    feet_question(1, "euler", 1, 2, lambda a: 1 + a**2, "1 + a²"),
    feet_question(2, "midpoint", 2, 3, lambda a: 1 + a**4 / 4, "1 + a⁴/4"),
    feet_question(3, "rk4", 2, 5, lambda a: 1 - a**6 / 72 + a**8 / 576, "1 − a⁶/72 + a⁸/576"),
    Question(
        "13.5",
        "step_matrix",
        3,
        also_at_zero(matrix_inputs, points=(0, 1)),
        lambda call: ((len(call.arguments[1]), len(call.arguments[0])),),
        (reproduces_linear_fields, uses_the_nearest_sites_only, is_one_at_its_site),
    ),
    Question(
        "13.6",
        "advect",
        3,
        also_at_zero(advect_inputs, values=(1,)),
        lambda call: ((call.arguments[3] + 1, len(call.arguments[0])),),
        (constants_stay, affine_fields_rotate),
    ),
    Question(
        "13.11",
        "burgers_feet",
        2,
        burgers_inputs,
        lambda call: (call.arguments[0].shape,),
        (constant_shifts, converges_as_a_geometric_series),
    ),
)
