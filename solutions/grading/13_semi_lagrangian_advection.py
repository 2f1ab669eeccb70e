"""Hidden cases of notebook 13."""

import numpy as np

from fieldcheck.calls import Call, integers
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
        Call(name, (0.7 * x[3:], t, 0.08, 1), "two points"),
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


@hidden("13.5", "It must hold for feet outside the sites, and for feet that are integers.")
def outside_the_sites(seed):
    random = np.random.default_rng(seed + 5)
    return (
        Call(
            "step_matrix",
            (in_square(random, 4), random.uniform(1, 1.3, (3, 2)), 7),
            "feet outside the sites",
        ),
        Call(
            "step_matrix",
            (9 * in_square(random, 4), random.integers(-9, 10, (3, 2)), 8),
            "feet that are integers",
        ),
    )


@hidden("13.5", "It must hold in space, also for equal feet and for a single foot.")
def in_space(seed):
    random = np.random.default_rng(seed + 4)
    sites = np.indices((3, 3, 2)).reshape(3, -1).T + random.uniform(-0.2, 0.2, (18, 3))
    return (
        Call("step_matrix", (sites, random.uniform(0, 1.5, (4, 3)), 10), "feet in space"),
        Call("step_matrix", (sites, sites[[3, 8]] + [[1e-4], [-1e-6]], 9), "feet beside sites"),
        Call("step_matrix", (sites, random.uniform(0, 1, (1, 3)), 18), "a foot with all sites"),
        Call(
            "step_matrix",
            (integers(sites, 9), random.uniform(0, 9, (2, 3))[[0, 1, 1]], 9),
            "sites that are integers, and two equal feet",
        ),
    )


@hidden("13.6", "It must hold for any number of steps, including none, and for integers.")
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
        Call(
            "advect",
            (integers(in_square(random, 4), 6), random.integers(-9, 10, 16), 0.1, 3, 1, 9),
            "sites and values that are integers",
        ),
    )


@hidden(
    "13.8",
    "It must hold for a single foot, outside the sites, for few sites, and for equal values.",
)
def outside(seed):
    random = np.random.default_rng(seed + 6)
    return (
        Call(
            "bounds",
            (in_disc(random, 15), random.normal(size=15), np.array([[1.5, -1.2]])),
            "a foot outside the sites",
        ),
        Call(
            "bounds",
            (in_disc(random, 4), random.normal(size=4), random.uniform(-1, 1, (3, 2))),
            "four sites in the disc",
        ),
        Call(
            "bounds",
            (
                np.array([[0, 0], [6, 2], [4, 8], [-2, 6], [9, -8]]),
                np.array([2, 3, 3, 1, 7]),
                np.array([[2, 4]]),
            ),
            "a foot in the centre of four sites that are integers",
            exact=(0, 2),
        ),
        Call(
            "bounds",
            (
                integers(in_square(random, 4), 5),
                random.integers(0, 3, 16),
                random.uniform(-5, 5, (7, 2)),
            ),
            "sites and values that are integers",
        ),
        Call(
            "bounds",
            (5 * in_square(random, 4), random.normal(size=16), random.integers(-5, 6, (7, 2))),
            "feet that are integers",
        ),
    )


@hidden(
    "13.9", "It must hold if all values end at a bound, if bounds are equal, and for a single site."
)
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
        Call(
            "with_mass",
            (u[3:4], low[3:4], high[3:4], m[3:4], float(m[3] * (0.3 * low[3] + 0.7 * u[3]))),
            "a site alone",
        ),
    )


@hidden(
    "13.11",
    "It must hold for any number of rounds, including none, for any order of sites, for integers.",
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
        Call(
            "burgers_feet",
            (np.cumsum(random.integers(2, 5, 7))[:, None], random.integers(-2, 3, 7), 0.3, 2, 5),
            "sites and velocities that are integers",
        ),
    )
