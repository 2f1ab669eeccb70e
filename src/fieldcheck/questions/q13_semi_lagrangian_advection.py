"""Questions of notebook 13, departure points, steps, bounds, mass, and Burgers' equation."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.question import Law, Question, law, law_of_each, relative, scale
from fieldcheck.variants import one_changed

Deviation = Callable[[Sequence[Call], Sequence[Values]], float]


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
    return calls_of(
        name,
        ((x, t, dt, 1), "eight points in the vortex"),
        ((x, t, dt / 2, 1), "the same points with half the step"),
        ((x, t, 2 * dt, 0), "eight points in the solid rotation"),
        ((0.9 * in_square(random, 2), t, 3 * dt, 2), "four points in the deformation flow"),
        ((whole, t, dt, 1), "points that are an array of integers, in the vortex"),
        ((whole, t, dt, 0), "points that are an array of integers, in the solid rotation"),
        (
            (CORNERS * random.uniform(0.55, 0.65, (4, 2)), 0.0, 0.9, 2),
            "a long step from the time 0 in the deformation flow",
        ),
        ((0.8 * x[::-1], t, dt, 1), "eight other points in the vortex, at the same time"),
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
    )


CORNERS = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])


def vortex_error(call: Call, feet: np.ndarray) -> float:
    """Return the mean distance of departure points in the vortex from the rotated points."""
    x, t, dt, _ = call.arguments
    angle = np.pi * (2 * dt + t**2 - (t - dt) ** 2) / (1 + 4 * np.hypot(*x.T) ** 2)
    turned = (x[:, 0] + 1j * x[:, 1]) * np.exp(-1j * angle)
    return float(np.sqrt(np.mean(np.abs(feet[:, 0] + 1j * feet[:, 1] - turned) ** 2)))


def falls_with_order(order: int) -> Deviation:
    """Return the deviation of the observed order of the error of one step, minus a fifth of an
    order.
    """

    def deviation(calls: Sequence[Call], values: Sequence[Values]) -> float:
        whole, half = (vortex_error(c, f) for c, (f,) in zip(calls[:2], values[:2], strict=True))
        if not 0 < half < np.inf:
            return np.inf
        return max(0.0, abs(float(np.log2(whole / half)) - order) - 0.2)

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
                f"In the vortex, half the step must reduce the error about {2**order} times.",
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
        ((sites, random.uniform(-1, 1, (6, 2)), 9), "six feet with nine sites each"),
        ((few, random.uniform(-1.2, 1.2, (4, 2)), 9), "four feet with all nine sites"),
        ((sites, sites[[7, 0, 18]], 8), "three feet that are sites"),
        ((line, random.uniform(-0.1, 1.1, (5, 1)), 4), "five feet on a line, with four sites each"),
        ((sites, sites[[6, 12, 17]] + beside, 8), "feet 10⁻³, 10⁻⁴ and 10⁻⁶ beside sites"),
        ((few, random.uniform(-1, 1, (11, 2)), 6), "more feet than sites"),
        (
            (2.0**-8 * sites, 2.0**-8 * random.uniform(-1, 1, (3, 2)), 9),
            "sites at distances of about 10⁻³",
        ),
        ((few, random.uniform(4, 6, (2, 2)), 7), "feet far outside the sites"),
        (
            (random.integers(-200, 201, (12, 2)), random.integers(-200, 201, (3, 2)), 7),
            "sites and feet that are arrays of integers",
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
                    (2.0**20, sites, 2, 9, "sites at distances of about 10⁶"),
                    (2.0**20, line, 1, 4, "sites on a line, at distances of about 10⁵"),
                )
            ),
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
            "other sites in the vortex",
        ),
        (
            (in_square(random, 4), random.normal(size=16), 3 * dt, 2, 2, 9),
            "other sites in the deformation flow",
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
    )


@law("The first row must be the initial field, and a constant must remain constant.")
def constants_stay(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of a constant from itself, and of the first row from the start."""
    begins = max(
        relative(u[0] - c.arguments[1], u[0]) for c, (u,) in zip(calls, values, strict=True)
    )
    return max(begins, relative(values[1][0] - 2.5, 2.5))


@law(
    "In the solid rotation, an affine field must be carried exactly from the departure points of "
    "RK4: the reconstruction has no error."
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
                (2.0**-30, 1e-9, "sites 10⁻⁹ apart, and values of about 10⁻⁹"),
                (2.0**-20, 1e-12, "sites 10⁻⁶ apart, and values of about 10⁻¹²"),
                (2.0**30, 1e9, "sites 10⁹ apart, and values of about 10⁹"),
                (2.0**20, 1e12, "sites 10⁶ apart, and values of about 10¹²"),
            )
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


FAR = np.array([2.0**16, -(2.0**17)])


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
    whole, areas = random.integers(-20, 21, 7), random.integers(1, 9, 7)
    name = "with_mass"
    return calls_of(
        name,
        ((u, u - 9, u + 9, m, float(m @ u) + 2.0), "bounds that are far away"),
        ((u - 5, low - 5, high - 5, m, more - 5 * float(m.sum())), "a mass that must grow"),
        ((u + 5, low + 5, high + 5, m, less + 5 * float(m.sum())), "a mass that must shrink"),
        ((u, outside - 0.2, outside + 0.2, m, float(m @ outside)), "values beyond their bounds"),
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
        ((x, rising, dt, 5, 4), "a linear field and five rounds"),
        ((x, rising, dt, 1, 4), "a linear field and one round"),
        ((x, wave, dt / 2, 3, 5), "a wave and three rounds"),
        ((x, np.full(9, 0.7), dt, 2, 4), "a constant"),
        ((x[order], wave[order], dt / 2, 3, 5), "the same wave, its sites in another order"),
        ((x, 3 * x[:, 0] + 0.1, dt, 7, 4), "a linear field and rounds that diverge"),
        ((x, wave, 3 * dt, 1, 5), "a wave and one long step"),
        (
            (np.cumsum(random.integers(2, 6, 8))[:, None], random.normal(size=8), dt, 2, 4),
            "sites that are an array of integers",
        ),
        ((x, random.integers(-3, 4, 9), dt / 2, 3, 5), "velocities that are an array of integers"),
        ((x, wave, dt, 0, 4), "a wave and no round"),
        ((x, wave[::-1], dt / 2, 3, 5), "another wave at the same sites"),
        ((x + 0.2 * wave[:, None], wave, dt / 2, 3, 5), "the same velocities at other sites"),
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
        matrix_inputs,
        lambda call: ((len(call.arguments[1]), len(call.arguments[0])),),
        (reproduces_linear_fields, uses_the_nearest_sites_only, is_one_at_its_site),
    ),
    Question(
        "13.6",
        "advect",
        3,
        advect_inputs,
        lambda call: ((call.arguments[3] + 1, len(call.arguments[0])),),
        (constants_stay, affine_fields_rotate),
    ),
    Question(
        "13.8",
        "bounds",
        2,
        bounds_inputs,
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
    Question(
        "13.11",
        "burgers_feet",
        2,
        burgers_inputs,
        lambda call: (call.arguments[0].shape,),
        (constant_shifts, converges_as_a_geometric_series),
    ),
)
