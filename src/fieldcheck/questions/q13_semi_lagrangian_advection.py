"""Questions of notebook 13, feet of characteristics and steps; what is kept has a module of its
own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.question import Law, Question, law, relative

Deviation = Callable[[Sequence[Call], Sequence[Values]], float]


def in_disc(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n places in the unit disc, away from its middle and from each other."""
    turns = np.pi * (1 + np.sqrt(5)) * (np.arange(n) + random.uniform(0.4, 0.6, n))
    radii = np.sqrt((np.arange(n) + random.uniform(0.6, 0.9, n)) / n)
    return np.column_stack([radii * np.cos(turns), radii * np.sin(turns)])


def in_square(random: np.random.Generator, n: int) -> np.ndarray:
    """Return n² places in the square from −1 to 1, each in a cell of its own."""
    cells = np.indices((n, n)).reshape(2, -1).T
    return 2 * (cells + random.uniform(0.3, 0.7, cells.shape)) / n - 1


# 13.1 to 13.3 Feet


def feet_inputs(name: str, seed: int) -> tuple[Call, ...]:
    """Return places in the three flows, and in the vortex with half the step."""
    random = np.random.default_rng(seed)
    x, dt, t = in_disc(random, 8), random.uniform(0.03, 0.05), random.uniform(0.2, 0.4)
    return (
        Call(name, (x, t, dt, 1), "eight places in the vortex"),
        Call(name, (x, t, dt / 2, 1), "the same with half the step"),
        Call(name, (x, t, 2 * dt, 0), "eight places in the flow that turns as a whole"),
        Call(
            name,
            (0.9 * in_square(random, 2), t, 3 * dt, 2),
            "four places in the flow that stretches",
        ),
    )


def vortex_error(call: Call, feet: np.ndarray) -> float:
    """Return how far feet in the vortex are from the turned places, in the mean."""
    x, t, dt, _ = call.arguments
    angle = np.pi * (2 * dt + t**2 - (t - dt) ** 2) / (1 + 4 * np.hypot(*x.T) ** 2)
    turned = (x[:, 0] + 1j * x[:, 1]) * np.exp(-1j * angle)
    return float(np.sqrt(np.mean(np.abs(feet[:, 0] + 1j * feet[:, 1] - turned) ** 2)))


def falls_with_order(order: int) -> Deviation:
    """Return by how much the observed order of the error of one step is off, but for a fifth of
    an order.
    """

    def deviation(calls: Sequence[Call], values: Sequence[Values]) -> float:
        whole, half = (vortex_error(c, f) for c, (f,) in zip(calls[:2], values[:2], strict=True))
        if not 0 < half < np.inf:
            return np.inf
        return max(0.0, abs(float(np.log2(whole / half)) - order) - 0.2)

    return deviation


def grows_by(square: Callable[[float], float]) -> Deviation:
    """Return how far the squares of radii are from what a step of this scheme makes of them in a
    solid rotation.
    """

    def deviation(calls: Sequence[Call], values: Sequence[Values]) -> float:
        x, _, dt, _ = calls[2].arguments
        before, after = (np.hypot(*p.T) ** 2 for p in (x, values[2][0]))
        return relative(after - square(float(2 * np.pi * dt)) * before, before)

    return deviation


def feet_question(
    number: int, scheme: str, points: int, order: int, square: Callable[[float], float]
) -> Question:
    """Return the question for the feet by a scheme whose step has an error of that order."""
    return Question(
        f"13.{number}",
        scheme,
        points,
        lambda seed: feet_inputs(scheme, seed),
        lambda call: (call.arguments[0].shape,),
        (
            Law(
                f"In the vortex half the step must make the error 2^{order} times smaller.",
                falls_with_order(order),
            ),
            Law(
                "In a solid rotation the distance from the middle changes by a factor that is "
                "known for this scheme.",
                grows_by(square),
            ),
        ),
    )


# 13.5 The matrix of a step


def matrix_inputs(seed: int) -> tuple[Call, ...]:
    """Return feet among few and among all sites, feet that are sites, and sites on a line."""
    random = np.random.default_rng(seed)
    sites, few = in_square(random, 5), in_square(random, 3)
    line = np.arange(8)[:, None] / 7 + random.uniform(-0.04, 0.04, (8, 1))
    name = "step_matrix"
    return (
        Call(name, (sites, random.uniform(-1, 1, (6, 2)), 9), "six feet with nine sites each"),
        Call(name, (few, random.uniform(-1.2, 1.2, (4, 2)), 9), "four feet with all nine sites"),
        Call(name, (sites, sites[[7, 0, 18]], 8), "three feet that are sites"),
        Call(
            name,
            (line, random.uniform(-0.1, 1.1, (5, 1)), 4),
            "five feet on a line, with four sites each",
        ),
    )


@law("Linear fields come back: rows sum to one, and the weighted mean of the sites is the foot.")
def brings_linear_fields_back(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how far rows are from the sum one, and weighted means of sites from the feet."""
    worst = 0.0
    for call, (h,) in zip(calls, values, strict=True):
        sites, feet, _ = call.arguments
        worst = max(worst, float(np.abs(h.sum(axis=1) - 1).max()))
        worst = max(worst, float(np.abs(np.einsum("ij,jk->ik", h, sites) - feet).max()))
    return worst


@law("Only the k sites nearest to its foot have weights in a row.")
def counts_the_nearest(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the largest weight of a site that has k sites nearer to the foot."""
    worst = 0.0
    for call, (h,) in zip(calls, values, strict=True):
        sites, feet, k = call.arguments
        for row, foot in zip(h, feet, strict=True):
            away = np.hypot.reduce(sites - foot, axis=1)
            nearer = (away[:, None] > away).sum(axis=1)
            worst = max(worst, float(np.abs(row[nearer >= k]).max(initial=0.0)))
    return worst


@law("At a site its own value counts, and no other.")
def is_one_at_its_site(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how far the rows of feet that are sites are from one and zeros."""
    return float(np.abs(values[2][0] - np.eye(25)[[7, 0, 18]]).max())


# 13.6 Many steps


def advect_inputs(seed: int) -> tuple[Call, ...]:
    """Return an affine field that turns, a constant, and fields in the vortex and in the flow
    that stretches.
    """
    random = np.random.default_rng(seed)
    disc, square, dt = in_disc(random, 24), in_square(random, 4), random.uniform(0.04, 0.06)
    slope = random.normal(size=2)
    name = "advect"
    return (
        Call(
            name,
            (disc, 1 + disc @ slope, dt, 3, 0, 8),
            "an affine field in the flow that turns as a whole",
        ),
        Call(name, (disc, np.full(24, 2.5), dt, 2, 1, 8), "a constant in the vortex"),
        Call(name, (disc, random.normal(size=24), 2 * dt, 3, 1, 8), "a field in the vortex"),
        Call(
            name,
            (square, random.normal(size=16), 3 * dt, 2, 2, 9),
            "a field in the flow that stretches",
        ),
    )


@law("The first row is the field at the beginning, and a constant stays what it is.")
def constants_stay(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how far a constant is from itself, and the first row from the field at the
    beginning.
    """
    begins = max(
        relative(u[0] - c.arguments[1], u[0]) for c, (u,) in zip(calls, values, strict=True)
    )
    return max(begins, relative(values[1][0] - 2.5, 2.5))


@law(
    "An affine field in a solid rotation only turns: there is no error in space, and "
    "in time that of the feet."
)
def affine_fields_turn(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how far an affine field is from the one at the sites turned back step by step."""
    sites, u, dt, _, _, _ = calls[0].arguments
    w = -2j * np.pi * dt
    turn = 1 + w * (1 + w / 2 * (1 + w / 3 * (1 + w / 4)))
    z = sites[:, 0] + 1j * sites[:, 1]
    rows = [np.stack([z.real**0, (turn**n * z).real, (turn**n * z).imag], axis=1) for n in range(4)]
    c = np.linalg.pinv(rows[0]) @ u
    return relative(values[0][0] - np.array(rows) @ c, u)


QUESTIONS = (
    feet_question(1, "euler", 1, 2, lambda a: 1 + a**2),
    feet_question(2, "midpoint", 2, 3, lambda a: 1 + a**4 / 4),
    feet_question(3, "rk4", 2, 5, lambda a: 1 - a**6 / 72 + a**8 / 576),
    Question(
        "13.5",
        "step_matrix",
        3,
        matrix_inputs,
        lambda call: ((len(call.arguments[1]), len(call.arguments[0])),),
        (brings_linear_fields_back, counts_the_nearest, is_one_at_its_site),
    ),
    Question(
        "13.6",
        "advect",
        3,
        advect_inputs,
        lambda call: ((call.arguments[3] + 1, len(call.arguments[0])),),
        (constants_stay, affine_fields_turn),
    ),
)
