"""Questions of notebook 11, surfaces from point clouds: the implicit function of a surface."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative
from fieldcheck.questions.q11_point_clouds import horseshoe, moved_far, outward, oval, torus


def cubes(x: np.ndarray, sites: np.ndarray, weights: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """Return weighted cubed distances from the sites, and a linear polynomial."""
    gaps = x[:, None, :] - sites[None, :, :]
    return (gaps * gaps).sum(axis=2) ** 1.5 @ weights + x @ plane[1:] + plane[0]


# 11.5 The coefficients


def beside(points: np.ndarray, n: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Return sites on a surface and on both sides of it, and their signed distances."""
    zero = np.zeros(len(points))
    return np.vstack([points, points + length * n, points - length * n]), np.concatenate(
        [zero, zero - length, zero + length]
    )


def fit_inputs(seed: int) -> tuple[Call, ...]:
    """Return sites and values in the plane and in space."""
    random = np.random.default_rng(seed)
    bent, ring = horseshoe(random, 14, 0.1), torus(random, 4, 5)
    whole = np.indices((3, 3)).reshape(2, -1).T @ [[4, 1], [-1, 5]] + random.integers(-1, 2, (9, 2))
    near_calls = calls_of(
        "implicit",
        ((whole, random.integers(-9, 10, 9)), "nine sites in whole numbers"),
        (beside(bent, outward(bent), 0.15), "a horseshoe, and points beside it"),
        (beside(ring, outward(ring), 0.2), "a torus in space, and points beside it"),
        ((whole, random.normal(size=9)), "the same nine sites, other values"),
        ((whole, np.zeros(9)), "nine values that are zero"),
        ((4 * whole, random.normal(size=9)), "nine sites about 20 apart"),
        ((2.0**-7 * whole, random.normal(size=9)), "nine sites about 0.04 apart"),
        ((3 * 2.0**6 * whole, random.normal(size=9)), "nine sites about 900 apart"),
        ((2.0**7 * whole, random.normal(size=9)), "nine sites about 600 apart"),
        ((random.normal(size=(3, 2)), random.normal(size=3)), "three sites in the plane"),
        ((random.normal(size=(4, 3)), random.normal(size=4)), "four sites in space"),
    )
    return near_calls + tuple(
        Call("implicit", (sites, random.normal(size=len(sites))), case, exact=(0,))
        for sites, case in (
            (first_in_a_plane(random, 8, 2), "eight sites, the first four on a line"),
            (first_in_a_plane(random, 9, 3), "nine sites in space, the first five in a plane"),
        )
    )


def first_in_a_plane(random: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Return n sites, the first d + 2 of them where the last coordinate is 2."""
    sites = random.uniform(-1, 1, (n, d))
    sites[: d + 2, -1] = 2
    return sites


def fit_shapes(call: Call) -> tuple[tuple[int, ...], ...]:
    n, d = call.arguments[0].shape
    return ((n,), (d + 1,))


def nothing_for_rounding(call: Call, values: Values) -> Values:
    """Return the coefficients, with λ set to zero where its terms are rounding errors of the
    values: D + 1 sites have an affine field.
    """
    (weights, plane) = values
    sites, wanted = call.arguments
    terms = np.abs(weights) * np.ptp(sites, axis=0).max() ** 3
    return np.where(terms > 1e-9 * np.abs(wanted).max(), weights, 0.0), plane


@law_of_each(
    "F must take the given values at the sites, and λ must satisfy the side conditions.", 1e-7
)
def meets_values_and_side_conditions(call: Call, values: Values) -> float:
    """Return the largest difference from the values, and the residual of the side conditions."""
    (weights, plane) = values
    sites, wanted = call.arguments
    missed = relative(cubes(sites, sites, weights, plane) - wanted, wanted)
    (weights, _) = nothing_for_rounding(call, values)
    basis = np.insert(sites, 0, 1.0, axis=1)
    moments = weights @ (basis / np.maximum(np.abs(basis).max(axis=0), 1.0))
    return max(missed, relative(moments, weights) if weights.any() else 0.0)


# 11.6 and 11.7 The field, its gradient, and projection onto its zero level


def body(
    random: np.random.Generator, d: int, sites: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return sites and coefficients of a function that is positive in a body around the origin
    only.
    """
    places = random.uniform(-0.3, 0.3, (sites, d))
    weights = -random.uniform(0.5, 1.5, sites) / sites
    return places, weights, np.append(1.0, random.uniform(-0.1, 0.1, d))


def points_about_origin(random: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Return points around the origin, none of them near it."""
    return round_origin(random, random.normal(size=(n, d)))


def near_diagonals(random: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Return such points near the diagonals, where no partial derivative vanishes. An answer may
    divide the step of a coordinate by its derivative.
    """
    signs = random.choice([-1.0, 1.0], (n, d))
    return round_origin(random, signs * random.uniform(0.7, 1.3, (n, d)))


def round_origin(random: np.random.Generator, x: np.ndarray) -> np.ndarray:
    """Return points in the given directions from the origin, none of them near it."""
    return random.uniform(0.8, 1.1, (len(x), 1)) * x / np.sqrt((x * x).sum(axis=1))[:, None]


def beside_a_site(random: np.random.Generator, d: int) -> np.ndarray:
    """Return offsets of the lengths 10⁻², 10⁻³ and 10⁻⁴."""
    return round_origin(random, random.normal(size=(3, d))) * [[1e-2], [1e-3], [1e-4]]


def field_inputs(seed: int) -> tuple[Call, ...]:
    """Return points and coefficients in the plane and in space; one of the points is a site. At
    last a single point, and a small unit of length.
    """
    random = np.random.default_rng(seed)
    plane, space, single = body(random, 2, 5), body(random, 3, 4), body(random, 2, 1)
    return (
        Call("field", (points_about_origin(random, 7, 2), *plane), "seven points in the plane"),
        Call(
            "field",
            (np.vstack([points_about_origin(random, 5, 3), space[0][:1]]), *space),
            "points in space, one of them a site",
            exact=(0, 1),
        ),
        Call(
            "field", (single[0] + beside_a_site(random, 2), *single), "points beside the only site"
        ),
        Call(
            "field",
            (np.vstack([points_about_origin(random, 4, 2), plane[0][2:3]]), *plane),
            "points in the plane, one of them a site",
            exact=(0, 1),
        ),
        Call("field", (points_about_origin(random, 1, 3), *space), "one point in space"),
        Call(
            "field",
            in_another_unit(2.0**-20, points_about_origin(random, 4, 2), *plane),
            "four points, with lengths of about 10⁻⁶",
        ),
        *more_fields(random, plane, space),
    )


def more_fields(
    random: np.random.Generator, plane: tuple[np.ndarray, ...], space: tuple[np.ndarray, ...]
) -> tuple[Call, ...]:
    """Return large units, other coefficients, many points or sites, whole numbers, far points."""
    x, many = points_about_origin(random, 4, 2), body(random, 2, 43)
    sites, straight = np.array([[0, 1], [2, -1], [-1, -3]]), np.array([1, -2, 3])
    factors = random.integers(1, 9, 3) * [1, -1, 1]
    whole = (sites, factors, straight)
    near_calls = calls_of(
        "field",
        (in_another_unit(2.0**9, x, *plane), "four points, with lengths of about 500"),
        (
            in_another_unit(2.0**12, points_about_origin(random, 3, 3), *space),
            "three points in space, with lengths of about 4000",
        ),
        ((x, plane[0], -0.5 * plane[1], plane[2]), "the same points and sites, λ halved"),
        ((x, plane[0][::-1], *plane[1:]), "the same points, sites in another order"),
        ((x, plane[0], 0 * plane[1], plane[2]), "the same points and sites, λ zero"),
        ((points_about_origin(random, 37, 2), *plane), "37 points in the plane"),
        ((x, *many), "four points and 43 sites"),
        ((x, *whole), "coefficients in whole numbers"),
        ((random.integers(3, 9, (3, 2)), *whole), "points and coefficients in whole numbers"),
    )
    return near_calls + tuple(
        Call("field", far_away(offset, points_about_origin(random, 5, d), *there), case, (0, 1, 3))
        for offset, d, there, case in (
            (3e4, 2, plane, "five points far from the origin"),
            (-2e4, 3, space, "five points in space, far from the origin"),
            (2.0**27, 2, without_slopes(plane), "five points very far from the origin"),
            (-(2.0**27), 3, without_slopes(space), "five points in space, very far away"),
        )
    )


def without_slopes(function: tuple[np.ndarray, ...]) -> tuple[np.ndarray, ...]:
    """Return a function (11.7) whose linear polynomial is constant: slopes lose digits far away."""
    sites, weights, plane = function
    return sites, weights, plane * (np.arange(len(plane)) == 0)


def far_away(offset: float, x: np.ndarray, *function: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return points, one of them a site, and a function (11.7) of the same values, far away."""
    sites, weights, plane = function
    there = moved_far(sites, offset)
    start = np.append(plane[0] - offset * plane[1:].sum(), plane[1:])
    return np.vstack([moved_far(x[:-1], offset), there[:1]]), there, weights, start


def field_shapes(call: Call) -> tuple[tuple[int, ...], ...]:
    x = call.arguments[0]
    return ((len(x),), x.shape)


@law(
    "The values must be those of (11.7), and the gradients must agree with differences of F for "
    "steps far below all distances.",
    1e-6,
)
def gradient_is_that_of_the_values(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the differences of values from (11.7), and of gradients from central differences."""
    worst = 0.0
    for call, (f, gradient) in zip(calls, values, strict=True):
        x, *rest = call.arguments
        worst = max(worst, 1e3 * relative(f - cubes(x, *rest), f))
        h = 1e-5 * np.abs(x[:, None] - rest[0]).max()
        origin, (sites, *factors) = rest[0][0], rest  # far from zero small steps lose digits
        y, near = x - origin, (sites - origin, *factors)
        for d, step in enumerate(h * np.eye(x.shape[1])):
            slope = (cubes(y + step, *near) - cubes(y - step, *near)) / (2 * h)
            worst = max(worst, relative(gradient[:, d] - slope, gradient))
    return worst


def in_another_unit(size: float, x: np.ndarray, *function: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return points and a function (11.7), of the same values, in another unit of length."""
    sites, weights, plane = function
    return size * x, size * sites, weights / size**3, np.append(plane[0], plane[1:] / size)


def of_the_size(size: float, x: np.ndarray, *function: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return points and a function (11.7) whose lengths and values are multiplied by a number.

    The gradients stay the same, as those of a distance do in another unit.
    """
    places, sites, weights, plane = in_another_unit(size, x, *function)
    return places, sites, size * weights, size * plane


def of_small_values(
    sites: np.ndarray, weights: np.ndarray, plane: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Return a function (11.7) with the same zero level, whose values and gradients are small."""
    return sites, 2.0**-100 * weights, 2.0**-100 * plane


def newton_inputs(seed: int) -> tuple[Call, ...]:
    """Return points near a zero level, with no, one, two and enough steps, in two units of length;
    a single point; many points. At last lengths or values are so small that an answer stops too
    early if it compares F, a step or a gradient with a fixed number.
    """
    random = np.random.default_rng(seed)
    plane, space = body(random, 2, 5), body(random, 3, 4)
    x = near_diagonals(random, 6, 2)
    long = of_the_size(2.0**10, 0.6 * x, *plane)
    return calls_of(
        "to_surface",
        ((x, *plane, 5), "five steps in the plane"),
        ((x, *plane, 1), "one step in the plane"),
        ((near_diagonals(random, 5, 3), *space, 2), "two steps in space"),
        (
            (np.rint(long[0]).astype(int), *long[1:], 2),
            "two steps from points of about 1000, in whole numbers",
        ),
        ((*in_another_unit(2.0**-20, x, *plane), 2), "two steps, with lengths of about 10⁻⁶"),
        ((near_diagonals(random, 3, 2), *plane, 0), "no steps in the plane"),
        ((near_diagonals(random, 1, 3), *space, 2), "two steps from one point in space"),
        ((x, plane[0], 1.2 * plane[1], plane[2], 2), "two steps in the plane, λ larger"),
        ((near_diagonals(random, 37, 2), *plane, 1), "one step from 37 points"),
        ((near_diagonals(random, 3, 2), *body(random, 2, 43), 2), "two steps, and 43 sites"),
        (
            (*of_the_size(2.0**-30, x, *plane), 3),
            "three steps, with lengths and values of about 10⁻⁹",
        ),
        (
            (*of_the_size(2.0**-60, near_diagonals(random, 4, 3), *space), 3),
            "three steps in space, with lengths and values of about 10⁻¹⁸",
        ),
        ((x, *of_small_values(*plane), 2), "two steps, values of F of about 10⁻³⁰"),
        (
            (near_diagonals(random, 4, 3), *of_small_values(*space), 1),
            "one step in space, values of F of about 10⁻³⁰",
        ),
    )


@law("One step must lead to the zero of the tangent, and five steps to the zero level.", 1e-8)
def ends_on_the_zero_level(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the residual after five steps, and the deviation of one step from a Newton step."""
    x, sites, weights, plane, _ = calls[0].arguments
    left = float(np.abs(cubes(values[0][0], sites, weights, plane)).max())
    step = values[1][0] - x
    far = 1e-6 * step
    slope = (cubes(x + far, sites, weights, plane) - cubes(x - far, sites, weights, plane)) / 2e-6
    return max(left, 1e-4 * relative(slope + cubes(x, sites, weights, plane), slope))


# 11.8 Marching squares


def pieces_inputs(seed: int) -> tuple[Call, ...]:
    """Return squares with one crossing line, in all twelve cases; first with whole numbers. At last
    a single square.
    """
    random = np.random.default_rng(seed)
    kinds = np.array(
        [[(c >> i) & 1 for i in range(4)] for c in (*range(1, 5), *range(6, 10), *range(11, 15))]
    )
    signs = np.where(kinds == 1, 1, -1)
    distance = oval(random, 12)[:, :1] + np.array([[1.5, 2.0, 2.5, 3.0]])
    different = calls_of(
        "pieces",
        ((signs * random.integers(1, 99, (12, 4)),), "twelve squares with whole numbers"),
        ((2.0**-34 * signs[::-1] * distance,), "twelve squares with values of the size 10⁻¹⁰"),
        ((2.0**-600 * signs * distance,), "twelve squares with values of the size 10⁻¹⁸⁰"),
        ((random.permutation(signs * distance)[:1],), "one square"),
        (
            (2.0 ** np.array([[100], [-500], [0], [-990]] * 3) * signs * distance,),
            "twelve squares, huge and tiny values in turn",
        ),
        (
            (2.0 ** np.array([[-990], [-1], [200]] * 4) * signs[::-1] * distance,),
            "twelve squares, tiny and huge values in turn",
        ),
    )
    return (
        *different,
        Call("pieces", (signs,), "twelve squares with the values 1 and −1"),
        Call("pieces", (-2.5 * signs[::-1],), "twelve squares with the values 2.5 and −2.5", (0,)),
    )


@law(
    "The ends must lie on sides of the square, where the interpolated value is zero, and the "
    "positive values must be on the left."
)
def lie_on_the_border(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of ends from the border and from zeros on it, and of pieces from running
    with the positive side on the left.
    """
    worst = 0.0
    for call, (ends,) in zip(calls, values, strict=True):
        for (a, b, c, d), (start, end) in zip(call.arguments[0], ends, strict=True):
            for x, y in (start, end):
                bilinear = (1 - y) * ((1 - x) * a + x * b) + y * ((1 - x) * d + x * c)
                worst = max(worst, abs(bilinear) / max(abs(a), abs(b), abs(c), abs(d)))
                worst = max(worst, min(abs(x), abs(1 - x), abs(y), abs(1 - y)))
            run = end - start
            for v, corner in zip((a, b, c, d), ((0, 0), (1, 0), (1, 1), (0, 1)), strict=True):
                side = run[0] * (corner[1] - start[1]) - run[1] * (corner[0] - start[0])
                worst = max(worst, float(side * v < 0))
    return worst


QUESTIONS = (
    Question(
        "11.5",
        "implicit",
        3,
        also_at_zero(fit_inputs, points=(0,), values=(1,)),
        fit_shapes,
        (meets_values_and_side_conditions,),
        lambda _: 1e-7,
        nothing_for_rounding,
    ),
    Question(
        "11.6",
        "field",
        3,
        also_at_zero(field_inputs, points=(0, 1)),
        field_shapes,
        (gradient_is_that_of_the_values,),
    ),
    Question(
        "11.7",
        "to_surface",
        2,
        newton_inputs,
        lambda call: (call.arguments[0].shape,),
        (ends_on_the_zero_level,),
    ),
    Question(
        "11.8",
        "pieces",
        3,
        pieces_inputs,
        lambda call: ((len(call.arguments[0]), 2, 2),),
        (lie_on_the_border,),
    ),
)
