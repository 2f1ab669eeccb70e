"""Hidden cases of notebook 13."""

import numpy as np

from fieldcheck.calls import Call
from fieldcheck.questions.q13_semi_lagrangian_advection import in_disc, in_square
from fieldgrade.authoring.hidden_cases import hidden


def other_steps(name, seed):
    """Return a single point, a step forward, a long step, and other times."""
    random = np.random.default_rng(seed)
    x, t = in_disc(random, 5), random.uniform(0.5, 1)
    return (
        Call(name, (x[:1], t, 0.1, 1), "a single point"),
        Call(name, (x, t, -0.07, 2), "a step forward in time"),
        Call(name, (x, 0.0, 0.4, 0), "a long step"),
        Call(name, (x, 1.4, -0.06, 1), "a step forward after the time 1"),
        Call(name, (0.5 * x, -0.3, 0.06, 2), "a negative time"),
    )


@hidden(
    "13.1",
    "It must hold for a single point, at every time, for steps of either sign, and for long ones.",
)
def other_steps_of_euler(seed):
    return other_steps("euler", seed + 1)


@hidden(
    "13.2",
    "It must hold for a single point, at every time, for steps of either sign, and for long ones.",
)
def other_steps_of_the_midpoint(seed):
    return other_steps("midpoint", seed + 2)


@hidden(
    "13.3",
    "It must hold for a single point, at every time, for steps of either sign, and for long ones.",
)
def other_steps_of_runge_and_kutta(seed):
    return other_steps("rk4", seed + 3)


@hidden("13.5", "It must hold in space, and for feet outside the sites.")
def in_space(seed):
    random = np.random.default_rng(seed + 4)
    sites = np.indices((3, 3, 2)).reshape(3, -1).T + random.uniform(-0.2, 0.2, (18, 3))
    return (
        Call("step_matrix", (sites, random.uniform(0, 1.5, (4, 3)), 10), "feet in space"),
        Call(
            "step_matrix",
            (in_square(random, 4), random.uniform(1, 1.3, (3, 2)), 7),
            "feet outside the sites",
        ),
        Call("step_matrix", (sites, sites[[3, 8]] + [[1e-4], [-1e-6]], 9), "feet beside sites"),
    )


@hidden("13.6", "It must hold for any number of steps, including none.")
def longer_and_shorter(seed):
    random = np.random.default_rng(seed + 5)
    sites = in_disc(random, 20)
    return (
        Call("advect", (sites, random.normal(size=20), 0.1, 6, 1, 15), "six steps"),
        Call("advect", (sites, random.normal(size=20), 0.1, 0, 1, 7), "no step"),
        Call(
            "advect",
            (in_square(random, 4), random.integers(-9, 10, 16), 0.2, 4, 2, 9),
            "late steps",
        ),
    )


@hidden("13.8", "It must hold for a single foot, and for feet outside the sites.")
def outside(seed):
    random = np.random.default_rng(seed + 6)
    return (
        Call(
            "bounds",
            (in_disc(random, 15), random.normal(size=15), np.array([[1.5, -1.2]])),
            "a foot outside the sites",
        ),
    )


@hidden("13.9", "It must hold if all values end at a bound, and if bounds are equal.")
def at_the_bounds(seed):
    random = np.random.default_rng(seed + 7)
    u, m = random.normal(size=6), random.uniform(1, 2, 6)
    low, high = u - random.uniform(0.1, 1, 6), u + random.uniform(0.1, 1, 6)
    high[2] = low[2]
    beyond = u + np.array([0, 0, 1.5, 0, -1.5, 0]) / m
    return (
        Call("with_mass", (u, low, high, m, float(m @ high)), "the largest mass"),
        Call(
            "with_mass",
            (u, low, high, m, float(m @ (0.6 * low + 0.4 * high))),
            "equal bounds of one value",
        ),
        Call("with_mass", (beyond, u - 0.4, u + 0.4, m, float(m @ u)), "one value beyond"),
    )


@hidden(
    "13.11", "It must hold for any number of rounds, including none, and for sites in any order."
)
def more_rounds(seed):
    random = np.random.default_rng(seed + 8)
    x = np.arange(7)[:, None] / 3 - 1 + random.uniform(-0.05, 0.05, (7, 1))
    mixed = x[random.permutation(7)]
    return (
        Call("burgers_feet", (x, np.cos(x[:, 0]), 0.3, 12, 5), "twelve rounds"),
        Call("burgers_feet", (x, np.cos(x[:, 0]), 0.3, 0, 5), "no round"),
        Call("burgers_feet", (mixed, np.cos(mixed[:, 0]), 0.3, 2, 5), "sites in any order"),
        Call("burgers_feet", (x, 0.8 * x[:, 0] + 0.05, 1.0, 40, 5), "forty rounds"),
    )
