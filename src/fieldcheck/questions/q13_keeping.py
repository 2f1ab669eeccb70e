"""Questions of notebook 13, bounds and mass, and the flow that carries itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.question import Question, law, relative
from fieldcheck.questions.q13_semi_lagrangian_advection import in_disc, in_square

# 13.8 Bounds


def bounds_inputs(seed: int) -> tuple[Call, ...]:
    """Return feet among scattered sites, the same with the opposite field, and feet that are
    sites.
    """
    random = np.random.default_rng(seed)
    sites, u = in_square(random, 4), random.normal(size=16)
    feet = random.uniform(-1, 1, (7, 2))
    return (
        Call("bounds", (sites, u, feet), "seven feet among sixteen sites"),
        Call("bounds", (sites, -u, feet), "the same with the opposite field"),
        Call("bounds", (sites, u, sites + 0.0), "feet that are the sites"),
        Call(
            "bounds",
            (in_disc(random, 20), random.normal(size=20), 0.5 * in_disc(random, 3)),
            "three feet in the disc",
        ),
    )


@law("If the field changes its sign, the bounds do, and exchange their places.")
def turns_over(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how far the bounds of the opposite field are from the opposite bounds, exchanged."""
    (low, high), (below, above) = values[:2]
    return max(relative(below + high, high), relative(above + low, low))


@law("A foot that is a site has the value there between its bounds.")
def holds_the_nearest(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return by how much a value at a site lies outside of the bounds there."""
    u, (low, high) = calls[2].arguments[1], values[2]
    return max(0.0, float((low - u).max()), float((u - high).max()))


@law("Four sites are asked, so that four values at least lie between the bounds.")
def hold_four(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how many of four different values are missing between bounds."""
    between = (
        (np.abs(c.arguments[1] - (low + high)[:, None] / 2) <= (high - low)[:, None] / 2 + 1e-9)
        .sum(axis=1)
        .min()
        for c, (low, high) in zip(calls, values, strict=True)
    )
    return float(max(0, 4 - min(between)))


@law("Bounds are values of the field.")
def are_values(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how far the bounds are from the nearest values of the field."""
    return max(
        float(np.abs(bound[:, None] - call.arguments[1]).min(axis=1).max())
        for call, both in zip(calls, values, strict=True)
        for bound in both
    )


# 13.9 Mass


def mass_inputs(seed: int) -> tuple[Call, ...]:
    """Return values that are free, values at their bounds, and a mass that is right already."""
    random = np.random.default_rng(seed)
    u, m = random.normal(size=8), random.uniform(0.5, 2, 8)
    low, high = u - random.uniform(0.1, 0.4, 8), u + random.uniform(0.1, 0.4, 8)
    more, less = float(m @ (0.3 * u + 0.7 * high)), float(m @ (0.25 * u + 0.75 * low))
    outside = np.clip(u, -0.5, 0.5)
    name = "with_mass"
    return (
        Call(name, (u, u - 9, u + 9, m, float(m @ u) + 2.0), "bounds that are far away"),
        Call(
            name, (u - 5, low - 5, high - 5, m, more - 5 * float(m.sum())), "a mass that is to grow"
        ),
        Call(
            name,
            (u + 5, low + 5, high + 5, m, less + 5 * float(m.sum())),
            "a mass that is to shrink",
        ),
        Call(
            name,
            (u, outside - 0.2, outside + 0.2, m, float(m @ outside)),
            "values beyond their bounds",
        ),
        Call(name, (u, low, high, m, float(m @ u)), "a mass that is right already"),
    )


@law("The values must have the mass that is asked for, and lie within their bounds.")
def has_the_mass(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how far the mass is from the wanted one, and values from their bounds."""
    worst = 0.0
    for call, (v,) in zip(calls, values, strict=True):
        _, low, high, m, total = call.arguments
        worst = max(worst, relative(np.sum(v * m) - total, m))
        worst = max(worst, float((low - v).max()), float((v - high).max()))
    return worst


@law("All values that are at neither bound are changed by the same number.")
def changes_alike(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how much the changes differ among values that are between their bounds."""
    worst = 0.0
    for call, (v,) in zip(calls, values, strict=True):
        u, low, high, _, _ = call.arguments
        free = (v > low + 1e-6) & (v < high - 1e-6)
        worst = max(worst, float(np.ptp((v - u)[free])) if free.any() else 0.0)
    return worst


# 13.11 Burgers


def burgers_inputs(seed: int) -> tuple[Call, ...]:
    """Return a linear field, the same after one round, a wave, and a constant."""
    random = np.random.default_rng(seed)
    x = np.arange(9)[:, None] / 4 - 1 + random.uniform(-0.06, 0.06, (9, 1))
    wave = np.sin(2 * x[:, 0] + random.uniform(0, 1))
    rising = random.uniform(0.5, 0.8) * x[:, 0] + random.uniform(0.3, 0.6)
    dt, name = random.uniform(0.4, 0.6), "burgers_feet"
    return (
        Call(name, (x, rising, dt, 5, 4), "a linear field and five rounds"),
        Call(name, (x, rising, dt, 1, 4), "a linear field and one round"),
        Call(name, (x, wave, dt / 2, 3, 5), "a wave and three rounds"),
        Call(name, (x, np.full(9, 0.7), dt, 2, 4), "a constant"),
    )


@law("If the velocity is linear, each round adds a term of a geometric series.")
def closes_in(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how far feet of a linear field are from the sums of a geometric series."""
    worst = 0.0
    for call, (y,) in zip(calls[:2], values[:2], strict=True):
        x, u, dt, rounds, _ = call.arguments
        slope = (u[-1] - u[0]) / (x[-1, 0] - x[0, 0])
        series = sum((-slope * dt) ** n for n in range(rounds))
        worst = max(worst, relative(x[:, 0] - y[:, 0] - dt * u * series, x))
    return worst


@law("A constant velocity shifts all places alike.")
def constant_shifts(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return how far feet in a constant flow are from places shifted alike."""
    x, u, dt, _, _ = calls[3].arguments
    return relative(x - values[3][0] - dt * u[0], x)


QUESTIONS = (
    Question(
        "13.8",
        "bounds",
        2,
        bounds_inputs,
        lambda call: ((len(call.arguments[2]),),) * 2,
        (are_values, turns_over, hold_four, holds_the_nearest),
    ),
    Question(
        "13.9",
        "with_mass",
        3,
        mass_inputs,
        lambda call: (call.arguments[0].shape,),
        (has_the_mass, changes_alike),
    ),
    Question(
        "13.11",
        "burgers_feet",
        2,
        burgers_inputs,
        lambda call: (call.arguments[0].shape,),
        (constant_shifts, closes_in),
    ),
)
