"""Questions of notebook 13 on bounds and mass of an advected field."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative, scale
from fieldcheck.questions.q13_semi_lagrangian_advection import CORNERS, FAR, in_disc, in_square

# 13.8 Bounds


def bounds_inputs(seed: int) -> tuple[Call, ...]:
    """Return departure points among scattered sites, with changed fields, at sites, and among four.

    Zero is between the bounds of most random fields, but not of the raised and the lowered one.
    """
    random = np.random.default_rng(seed)
    sites, u = in_square(random, 4), random.normal(size=16)
    feet = random.uniform(-1, 1, (7, 2))
    centre = Call(
        "bounds",
        (CORNERS, random.normal(size=4), np.zeros((1, 2), dtype=int)),
        "a foot in the centre of four sites",
        exact=(0, 2),
    )
    calls = calls_of(
        "bounds",
        ((sites, u, feet), "seven feet among sixteen sites"),
        ((sites, -u, feet), "the same points with the opposite field"),
        ((sites, u, sites + 0.0), "feet that are the sites"),
        (
            (in_disc(random, 20), random.normal(size=20), 0.5 * in_disc(random, 3)),
            "three feet in the disc",
        ),
        ((sites, u + 5, feet), "the first points with a field that is larger by five"),
        ((sites, u - 5, feet), "the first points with a field that is smaller by five"),
        (
            (
                random.integers(-999, 1000, (11, 2)),
                *(random.normal(size=11), random.integers(-999, 1000, (5, 2))),
            ),
            "sites and feet that are arrays of integers",
        ),
        (
            (0.1 * sites + FAR, u, 0.1 * feet + FAR),
            "sites and feet far from the origin",
        ),
        ((sites[[0, 5, 10, 13]], u[:4], feet), "seven feet and four sites"),
        ((sites[[1, 6, 8, 12]], u[4:8], feet[2:3]), "a single foot and four sites"),
        ((sites, u[::-1], feet[4:5]), "a single foot"),
        ((integers(sites, 5), u, 5 * feet), "sites that are an array of integers"),
        ((5 * sites, u, integers(feet, 5)), "feet that are an array of integers"),
        ((sites, random.permutation(16) // 4, feet), "a field of four different values"),
    )
    return (*calls, centre, *bounds_in_other_units(random))


def bounds_in_other_units(random: np.random.Generator) -> tuple[Call, ...]:
    """Return many points, equal values, points far from the origin, and tiny and huge numbers."""
    many = calls_of(
        "bounds",
        (
            (in_square(random, 7)[:47], random.normal(size=47), random.uniform(-1, 1, (71, 2))),
            "71 feet and 47 sites",
        ),
        (
            (in_disc(random, 43), random.normal(size=43), random.uniform(-1, 1, (45, 2))),
            "45 feet and 43 sites",
        ),
        (
            (in_disc(random, 11), np.full(11, -0.75), random.uniform(-1, 1, (3, 2))),
            "a constant field",
        ),
        *(
            (
                (
                    length * in_square(random, 4),
                    size * random.normal(size=16),
                    length * random.uniform(-1, 1, (5, 2)),
                ),
                case,
            )
            for length, size, case in (
                (2.0**-43, 1e-9, "sites 10⁻¹³ apart, and values of about 10⁻⁹"),
                (2.0**-50, 1, "sites 10⁻¹⁵ apart"),
                (2.0**-20, 1e-12, "sites 10⁻⁶ apart, and values of about 10⁻¹²"),
                (2.0**30, 1e9, "sites 10⁹ apart, and values of about 10⁹"),
                (2.0**20, 1e12, "sites 10⁶ apart, and values of about 10¹²"),
            )
        ),
        *(
            ((in_square(random, 4), random.normal(size=16), random.uniform(-1, 1, (n, 2))), case)
            for n, case in ((2, "two feet"), (4, "four feet"), (16, "as many feet as sites"))
        ),
    )
    far = (
        Call("bounds", (2.0**-8 * p + away, u, 2.0**-8 * y + away), case, exact=(0, 2))
        for p, u, y, away, case in (
            (*_field(random, 4), FAR, "sites and feet very far from the origin"),
            (*_field(random, 5), -FAR[::-1], "other sites and feet very far from the origin"),
        )
    )
    return (*many, *far)


def _field(random: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return n² sites in the square, values there, and nine feet."""
    return in_square(random, n), random.normal(size=n * n), random.uniform(-1, 1, (9, 2))


@law("Adding a number to the field must add it to both bounds.")
def rise_with_the_field(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the bounds of the raised and the lowered field from l ± 5, h ± 5."""
    first, raised, lowered = np.array(values[0]), np.array(values[4]), np.array(values[5])
    return max(relative(raised - first - 5, raised), relative(lowered - first + 5, lowered))


@law("If the field is multiplied by −1, the bounds must be exchanged and multiplied by −1.")
def changes_sign_with_the_field(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the negative field's bounds from the exchanged negative bounds."""
    (low, high), (below, above) = values[:2]
    return max(relative(below + high, high), relative(above + low, low))


@law("If a foot is a site, the value there must lie between its bounds.")
def contains_the_nearest_value(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the distance of the value at a site from the bounds there."""
    u, (low, high) = calls[2].arguments[1], values[2]
    return max(0.0, float((low - u).max()), float((u - high).max()))


@law("At least four values of the field must lie between the bounds of each foot.")
def contain_four_values(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the number of four different values that lie outside the bounds."""
    between = (
        (np.abs(u - (low + high)[:, None] / 2) <= (high - low)[:, None] / 2 + 1e-9 * scale(u))
        .sum(axis=1)
        .min()
        for (_, u, _), (low, high) in ((c.arguments, v) for c, v in zip(calls, values, strict=True))
    )
    return float(max(0, 4 - min(between)))


@law("The bounds must be values of the field.")
def are_values(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the distance of the bounds from the nearest values of the field."""
    return max(
        relative(np.abs(bound[:, None] - call.arguments[1]).min(axis=1), call.arguments[1])
        for call, both in zip(calls, values, strict=True)
        for bound in both
    )


# 13.9 Mass


def mass_inputs(seed: int) -> tuple[Call, ...]:
    """Return values between their bounds, values at their bounds, and a mass already right."""
    random = np.random.default_rng(seed)
    u, m = random.normal(size=8), random.uniform(0.5, 2, 8)
    low, high = u - random.uniform(0.1, 0.4, 8), u + random.uniform(0.1, 0.4, 8)
    more, less = float(m @ (0.3 * u + 0.7 * high)), float(m @ (0.25 * u + 0.75 * low))
    outside = np.clip(u, -0.5, 0.5)
    beyond = u + np.array([1.0, -1, 0, 0, 0, 0, 0, 0]) / m
    apart = u[:3] + np.array([0.0, 10, 0])
    near, far = apart - np.array([1.0, 30, 40]), apart + np.array([40.0, -9, 50])
    whole, areas = random.integers(-20, 21, 7), random.integers(1, 9, 7)
    name = "with_mass"
    return calls_of(
        name,
        ((u, u - 9, u + 9, m, float(m @ u) + 2.0), "bounds that are far away"),
        ((u - 5, low - 5, high - 5, m, more - 5 * float(m.sum())), "a mass that must grow"),
        ((u + 5, low + 5, high + 5, m, less + 5 * float(m.sum())), "a mass that must shrink"),
        ((u, outside - 0.2, outside + 0.2, m, float(m @ outside)), "values beyond their bounds"),
        (
            (apart, near, far, m[:3], float(m[:3] @ apart - 8.9 * m[1])),
            "one value far above its bounds, two far from theirs",
        ),
        ((u, low, high, m, float(m @ u)), "a mass that is right already"),
        (
            (beyond, u - 0.3, u + 0.3, m, float(m @ beyond)),
            "values beyond bounds, of the right mass",
        ),
        ((u, u - 900, u + 900, m, float(m @ u + 300 * m.sum())), "a mass that must grow a lot"),
        ((u, u - 90, u + 90, m, float(m @ u - 50 * m.sum())), "a mass that must shrink a lot"),
        ((u + 50, low, high, m, more), "values far above their bounds"),
        ((u - 40, low, high, m, less), "values far below their bounds"),
        (
            (u, u - 9000, u + 9000, m, float(m @ u + 3500 * m.sum())),
            "values that must grow by thousands",
        ),
        ((u, low, high, m, float(m @ u) + 1e-4), "a mass that must grow a little"),
        (
            (whole, whole - 4, whole + 5, areas, int(whole @ areas) + 11),
            "values, bounds and areas that are arrays of integers",
        ),
        (
            (whole[:5], whole[:5] - 3, whole[:5] + 2, areas[:5], int(whole[:5] @ areas[:5]) - 7),
            "a mass that must shrink, and arrays of integers",
        ),
        ((u[:1], low[:1], high[:1], m[:1], float(m[0] * (u[0] + 0.05))), "a single site"),
        *(
            (correction(random, n, size, area, part), case)
            for n, size, area, part, case in (
                (45, 1, 1, 0.7, "45 sites"),
                (71, 1, 1, 0.2, "71 sites"),
                (7, 1e-9, 1, 0.8, "values of about 10⁻⁹"),
                (6, 1, 1e-9, 0.3, "areas of about 10⁻⁹"),
                (5, 1e9, 1, 0.6, "values of about 10⁹"),
                (8, 1, 1e9, 0.1, "areas of about 10⁹"),
                (2, 1, 1, 0.6, "two sites"),
                (9, 1e13, 1, 0.7, "values of about 10¹³"),
                (6, 1e16, 1, 0.2, "values of about 10¹⁶"),
            )
        ),
    )


def correction(
    random: np.random.Generator, n: int, size: float, area: float, part: float
) -> tuple[np.ndarray | float, ...]:
    """Return values, some of them outside their bounds, bounds, areas, and a mass between."""
    u, m = size * random.normal(size=n), area * random.uniform(0.5, 2, n)
    low = u - size * random.uniform(-0.1, 0.4, n)
    high = low + size * random.uniform(0.3, 0.8, n)
    return u, low, high, m, float((1 - part) * (m @ low) + part * (m @ high))


@law("The values must have the required mass, and lie within their bounds.")
def has_the_mass(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the mass from the given mass, and of values from their bounds."""
    worst = 0.0
    for call, (v,) in zip(calls, values, strict=True):
        _, low, high, m, total = call.arguments
        size = scale(low, high)
        worst = max(worst, relative((np.sum(v * m) - total) / size, m))
        worst = max(worst, float((low - v).max()) / size, float((v - high).max()) / size)
    return worst


@law_of_each("All values that are at neither bound must be changed by the same number.")
def changes_by_a_constant(call: Call, values: Values) -> float:
    """Return the variation of the changes among values strictly between their bounds."""
    (v,) = values
    u, low, high, _, _ = call.arguments
    size = scale(low, high)
    free = (v > low + 1e-6 * size) & (v < high - 1e-6 * size)
    return float(np.ptp((v - u)[free])) / size if free.any() else 0.0


QUESTIONS = (
    Question(
        "13.8",
        "bounds",
        2,
        also_at_zero(bounds_inputs, points=(0, 2), values=(1,)),
        lambda call: ((len(call.arguments[2]),),) * 2,
        (
            are_values,
            changes_sign_with_the_field,
            rise_with_the_field,
            contain_four_values,
            contains_the_nearest_value,
        ),
    ),
    Question(
        "13.9",
        "with_mass",
        3,
        mass_inputs,
        lambda call: (call.arguments[0].shape,),
        (has_the_mass, changes_by_a_constant),
    ),
)
