"""Questions of notebook 02, moving least squares: weights, fit, objective, gradient, errors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.question import Question, law, law_of_each, relative

EPS = float(np.finfo(float).eps)
LOCAL = 1e-7
"""Rounding tolerance of laws about local fits, whose systems have larger condition numbers."""


def affine(points: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Return the values of an affine field with these slopes and the value 0.7 at the origin."""
    return points @ slopes + 0.7


def rounding(points: np.ndarray, spread: float) -> float:
    """Return the rounding error of the normal equations; `spread` is the ratio of the weights.

    It is eps times the squared condition of WB, which is at most the spread times the condition of
    B. The columns of B have length one here: elimination does not depend on their scale.
    """
    b = np.pad(points, ((0, 0), (1, 0)), constant_values=1)
    scaled = b / np.sqrt((b * b).sum(axis=0))
    return 100 * EPS * float(spread * np.linalg.cond(scaled)) ** 2


def local_rounding(points: np.ndarray, x: np.ndarray, epsilon: float) -> float:
    """Return the same at evaluation points x: the ratio of weights is at most 1 + (R/ε)²."""
    reach = float(np.ptp(np.concatenate([points, np.atleast_2d(x)]), axis=0).max())
    return rounding(points, 1 + (reach / epsilon) ** 2)


# 02.1 The weights


def weights_inputs(seed: int) -> tuple[Call, ...]:
    """Return an evaluation point, the same in another unit, one in space, and one at a site.

    All points lie around the origin. A number added to the squares, such as 10⁻¹², is visible in
    small units only.
    """
    random = np.random.default_rng(seed)
    plane, space = random.random((7, 2)) - 0.4, random.random((5, 3)) - 0.4
    x = random.random(2) - 0.8
    return calls_of(
        "weights",
        ((plane, x, 0.3), "seven points in the plane"),
        ((3 * plane, 3 * x, 0.9), "the same points in another unit of length"),
        ((space, random.normal(size=3), 0.6), "five points in space"),
        ((plane, plane[2].copy(), 0.2), "an evaluation point that is one of the points"),
        ((1e-5 * plane, 1e-5 * x, 3e-8), "seven points in a square of 10⁻⁵ and a small ε"),
        ((1e-5 * space, 1e-4 * random.normal(size=3), 5e-7), "five points in a cube of 10⁻⁵"),
        ((integers(plane), integers(x), 90.0), "seven points in the plane, integers"),
        (
            (integers(space), integers(random.normal(size=3)), 180.0),
            "five points in space, integers",
        ),
    )


@law_of_each(
    "Between two points the reciprocal of the weight must grow by as much as the squared distance."
)
def weights_differ_like_squared_distances(call: Call, values: Values) -> float:
    (w,) = values
    points, x, _ = call.arguments
    left, right = points[:-1], points[1:]
    expected = ((right - left) * (right + left - 2 * x)).sum(axis=-1)
    return relative(w[:-1] - w[1:] - expected * w[:-1] * w[1:], w)


@law("At a point itself r is zero, and the weight must be 1/ε².")
def greatest_at_the_point_itself(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return float(abs(values[3][0][2] * calls[3].arguments[2] ** 2 - 1))


@law("Where all lengths, ε among them, are three times as large, each weight must be a ninth.")
def unit_of_length(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(9 * values[1][0] - values[0][0], values[0][0])


# 02.2 The fit


def fit_inputs(seed: int) -> tuple[Call, ...]:
    """Return points of the plane and of space, each with one weight far above the others, in a
    small unit, and nearly in a line or a layer; and as many points as coefficients.

    Some points are measured twice, with two values and two weights.
    """
    random = np.random.default_rng(seed)
    corner = random.random((3, 2)) + np.array([[0, 0], [2, 0], [0, 2]])
    plane, space = random.random((12, 2)), random.random((20, 3)) - 0.4

    def alike(n: int) -> np.ndarray:
        return random.uniform(0.3, 3, n)

    def spread(n: int) -> np.ndarray:
        return 10 ** random.uniform(-2, 0, n)

    def one_large(n: int) -> np.ndarray:
        return np.where(np.arange(n) == 4, 100, alike(n))

    cases = (
        (twice(plane, 2), one_large, "fourteen measurements at twelve points, one weight large"),
        (twice(space, 3), one_large, "twenty-three measurements in space, one weight large"),
        (corner, alike, "three points in the plane"),
        (1e-6 * twice(plane, 2), alike, "fourteen measurements in a square of 10⁻⁶"),
        (1e-6 * twice(space, 3), alike, "twenty-three measurements in a cube of 10⁻⁶"),
        (
            [1, 1e-3] * twice(plane, 2),
            spread,
            "fourteen measurements nearly in a line, and weights from 0.01 to 1",
        ),
        (
            [1e-3, 1, 1] * twice(space, 3),
            spread,
            "twenty-three measurements nearly in a layer, and weights from 0.01 to 1",
        ),
    )
    given = [((p, random.normal(size=len(p)), weigh(len(p))), case) for p, weigh, case in cases]
    (_, v, w), (_, data, _) = given[0][0], given[1][0]
    given += [
        (
            (integers(twice(plane, 2)), integers(v), w),
            "fourteen measurements in the plane, integers",
        ),
        (
            (integers(twice(space, 3)), data, alike(23)),
            "twenty-three measurements in space, integers",
        ),
    ]
    return tuple(Call("weighted_fit", arguments, case, exact=(0,)) for arguments, case in given)


def twice(points: np.ndarray, k: int) -> np.ndarray:
    """Return points, followed by the first k of them again: they are measured twice."""
    return np.append(points, points[:k], axis=0)


@law_of_each(
    "The residual of the best fit, multiplied by the squared weights, must be "
    "orthogonal to the columns of B."
)
def weighted_residual_is_orthogonal(call: Call, values: Values) -> float:
    (c,) = values
    points, data, w = call.arguments
    pull = w * w * (data - c[0] - sum(c[k + 1] * column for k, column in enumerate(points.T)))
    moments = [pull.sum(), *(pull @ column for column in points.T)]
    return relative(np.array(moments), np.sum(w * w * np.abs(data)))


# 02.4 The field


def field_inputs(seed: int) -> tuple[Call, ...]:
    """Return values, with an affine field added, moved and in a small unit, in space, and with a
    small ε.

    Some points are measured twice. One evaluation point is a point of the data, and another is
    outside.
    """
    random = np.random.default_rng(seed)
    p, v = twice(random.random((15, 2)) - 0.4, 2), random.normal(size=17)
    space, data = twice(random.random((20, 3)) - 0.4, 3), random.normal(size=23)
    x, y = random.random((5, 2)) - 0.4, random.random((3, 3)) - 0.4
    slopes, shift = np.array([1.5, -2.0]), np.array([1.0, -0.5])
    x[1], y[1] = p[4], space[6]
    x[4], y[2] = x[4] + 1.5, y[2] + 1.5  # outside, where values may exceed those given
    cases = (
        ((p, v, x, 0.25), "seventeen measurements at fifteen points in the plane"),
        ((p, v + affine(p, slopes), x, 0.25), "the same values plus those of an affine field"),
        (
            (1e-5 * (p + shift), v, 1e-5 * (x + shift), 1e-5 * 0.25),
            "the same points, moved, and all lengths multiplied by 10⁻⁵",
        ),
        (
            (1e-4 * space, data, 1e-4 * y, 1e-4 * 0.5),
            "twenty-three measurements at twenty points in a cube of 10⁻⁴",
        ),
        ((p, v, x, 0.05), "a small ε"),
        ((integers(p), integers(v), integers(x), 75.0), "points and values in the plane, integers"),
        ((integers(space), data, integers(y), 150.0), "points in space, integers"),
    )
    return tuple(Call("field", given, case, exact=(0, 2)) for given, case in cases)


@law(
    "Adding an affine field to the values must add it to the result, since the fit reproduces it.",
    LOCAL,
)
def reproduces_affine_fields(calls: Sequence[Call], values: Sequence[Values]) -> float:
    x = calls[0].arguments[2]
    gained = values[1][0] - values[0][0]
    return relative(gained - affine(x, np.array([1.5, -2.0])), np.abs(values[1][0]).max() + 1)


@law(
    "The value must stay the same if all points are moved together, or if the unit of length "
    "changes.",
    LOCAL,
)
def only_relative_positions_count(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[2][0] - values[0][0], np.abs(values[0][0]).max() + 1)


# 02.5 The objective


def objective_inputs(seed: int) -> tuple[Call, ...]:
    """Return non-optimal coefficients, all doubled, with an affine field added, and in space."""
    random = np.random.default_rng(seed)
    p, v, x, c = (
        random.random((9, 2)),
        random.normal(size=9),
        random.random(2),
        random.normal(size=3),
    )
    slopes = np.array([1.5, -2.0])
    return calls_of(
        "objective",
        ((p, v, x, 0.4, c), "nine points in the plane"),
        ((p, 2 * v, x, 0.4, 2 * c), "values and coefficients doubled"),
        (
            (p, v + affine(p, slopes), x, 0.4, c + np.array([0.7, *slopes])),
            "the same affine field added to the values and the coefficients",
        ),
        (
            (
                random.random((6, 3)) - 0.4,
                random.normal(size=6),
                random.random(3) - 0.8,
                0.5,
                random.normal(size=4),
            ),
            "six points in space",
        ),
    )


@law(
    "ψ is a sum of squares, so doubling the values and the coefficients must make it four times "
    "as large."
)
def is_quadratic(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[1][0] - 4 * values[0][0], values[1][0])


@law(
    "Adding the same affine field to Bc and V must not change ψ, which depends on their "
    "difference only."
)
def depends_on_the_residual_only(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[2][0] - values[0][0], values[0][0])


# 02.7 The gradient


def gradient_inputs(seed: int) -> tuple[Call, ...]:
    """Return evaluation points on a circle, with an affine field added, in space, and both in
    another unit. Two evaluation points are points of the data, and two points are measured twice.
    """
    random = np.random.default_rng(seed)
    p, v = twice(random.random((18, 2)), 2), random.normal(size=20)
    space, data = twice(random.random((23, 3)) - 0.4, 2), random.normal(size=25)
    y = random.random((3, 3)) - 0.4
    circle = np.exp(2j * np.pi * np.arange(CIRCLE) / CIRCLE)
    x = 0.5 + 0.1 * np.column_stack([circle.real, circle.imag])
    p[7], space[7] = x[5], y[1]
    slopes = np.array([1.5, -2.0])
    cases = (
        ((p, v, x, 0.3), "evaluation points on a circle"),
        ((p, v + affine(p, slopes), x, 0.3), "the same values plus those of an affine field"),
        ((space, data, y, 0.5), "twenty-five points in space"),
        ((UNIT * p, v, UNIT * x, UNIT * 0.3), "the points on a circle, all lengths a thousandth"),
        (
            (UNIT * space, data, UNIT * y, UNIT * 0.5),
            "the points in space, all lengths a thousandth",
        ),
        ((p, v + HIGH, x, 0.3), "the points on a circle, all values larger by 10000"),
        ((space, data + HIGH, y, 0.5), "the points in space, all values larger by 10000"),
        ((integers(p), integers(v), integers(x), 90.0), "the points on a circle, integers"),
        ((integers(space), data, integers(y), 150.0), "the points in space, integers"),
    )
    return tuple(Call("gradient", given, case, exact=(0, 2)) for given, case in cases)


HIGH = 1e4
"""A constant that changes no gradient, and from which difference quotients lose four digits."""
UNIT = 1e-3
CIRCLE = 24
"""The number of points on the circle for which the sum along it equals the integral."""


@law(
    "The gradient must have no circulation: its components along a closed circle must add up to "
    "zero.",
    LOCAL,
)
def has_zero_circulation(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the sum of the slopes along the circle, relative to that of their absolute values."""
    x, (g,) = calls[0].arguments[2], values[0]
    outward = x - 0.5
    along = g[:, 1] * outward[:, 0] - g[:, 0] * outward[:, 1]
    return float(abs(along.sum()) / max(np.abs(g).max() * 0.1 * CIRCLE, EPS))


@law("Where all lengths are a thousandth, the gradient must be a thousand times as large.", LOCAL)
def is_per_unit_of_length(calls: Sequence[Call], values: Sequence[Values]) -> float:
    pairs = ((values[3][0], values[0][0]), (values[4][0], values[2][0]))
    return max(relative(UNIT * small - large, large) for small, large in pairs)


@law("Adding an affine field to the values must add its slopes to the gradient.", LOCAL)
def adds_the_slope_of_affine_fields(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(
        values[1][0] - values[0][0] - np.array([1.5, -2.0]), np.abs(values[1][0]).max() + 1
    )


# 02.8 Least squares against moving least squares


def errors_inputs(seed: int) -> tuple[Call, ...]:
    """Return 100 sites and ten evaluation points, all at twice the distance, other powers and ε."""
    random = np.random.default_rng(seed)
    points, places = random.random((100, 2)), random.random((10, 2))
    return calls_of(
        "errors",
        ((points, places, 2, 0.1), "a hundred points, ten evaluation points and n = 2"),
        ((2 * points, 2 * places, 2, 0.2), "all points twice as far apart"),
        ((points, places, 3, 0.05), "n = 3"),
        (
            (twice(points[:30] - 0.4, 3), random.random((25, 2)) - 0.4, 5, 0.3),
            "thirty points, three of them twice, twenty-five evaluation points and n = 5",
        ),
    )


@law(
    "In a square twice as large (x₁ + x₂)² is four times as large, so both errors must be, too.",
    LOCAL,
)
def grows_with_the_field(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[1][0] - 4 * values[0][0], values[1][0])


def nothing_for_rounding(call: Call, values: Values) -> Values:
    """Return errors in which pure rounding errors are set to zero."""
    return tuple(np.where(np.abs(v) < 1e-9, 0.0, v) for v in values)


# 02.9 Leave-one-out


def leave_one_out_inputs(seed: int) -> tuple[Call, ...]:
    """Return values, the same with one value raised, with an affine field added, and in space."""
    random = np.random.default_rng(seed)
    p, v = random.random((12, 2)), random.normal(size=12)
    raised = v + (np.arange(12) == 4)
    general = calls_of(
        "leave_one_out",
        ((p, v, 0.3), "twelve points in the plane"),
        ((p, raised, 0.3), "the same points, the fifth value raised by one"),
        (
            (p, v + affine(p, np.array([1.5, -2.0])), 0.3),
            "the same values plus those of an affine field",
        ),
        ((random.random((14, 3)) - 0.4, random.normal(size=14), 0.6), "fourteen points in space"),
        ((integers(p), integers(v), 90.0), "twelve points and their values, integers"),
        ((p, integers(raised), 0.3), "twelve points and values that are integers"),
    )
    case = "a grid of four by three points, two of them measured twice, and values that repeat"
    return (*general, Call("leave_one_out", (*measured_twice(random, (4, 3)), 0.3), case, (0, 1)))


def measured_twice(
    random: np.random.Generator, shape: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of a grid, two of them twice, and values that are small whole numbers.

    So neither a coordinate nor a value says which measurement it is, nor even a point.
    """
    grid = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)
    points = grid.reshape(-1, len(shape)) / 4
    twice = np.append(points, points[[1, 6]], axis=0)
    values = random.integers(0, 3, len(twice)).astype(float)
    values[-2:] = values[[1, 6]] + [1.0, 2.0]
    return twice, values


@law(
    "Raising a value by one must raise its own error by one, since the field that predicts it "
    "does not use it.",
    LOCAL,
)
def has_not_seen_the_value(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return float(abs(values[1][0][4] - values[0][0][4] - 1))


@law(
    "Adding an affine field to the values must change no error, since the other points reproduce "
    "it.",
    LOCAL,
)
def affine_fields_leave_no_error(calls: Sequence[Call], values: Sequence[Values]) -> float:
    return relative(values[2][0] - values[0][0], np.abs(values[0][0]).max() + 1)


def without_the_worst(call: Call) -> float:
    """Return the rounding error with one point left out, for the worst choice of the point."""
    points, _, epsilon = call.arguments
    return max(
        local_rounding(np.delete(points, i, axis=0), p, epsilon) for i, p in enumerate(points)
    )


QUESTIONS = (
    Question(
        "02.1",
        "weights",
        2,
        weights_inputs,
        lambda call: ((len(call.arguments[0]),),),
        (weights_differ_like_squared_distances, unit_of_length, greatest_at_the_point_itself),
    ),
    Question(
        "02.2",
        "weighted_fit",
        3,
        fit_inputs,
        lambda call: ((call.arguments[0].shape[1] + 1,),),
        (weighted_residual_is_orthogonal,),
        lambda call: rounding(
            call.arguments[0], float(call.arguments[2].max() / call.arguments[2].min())
        ),
    ),
    Question(
        "02.4",
        "field",
        3,
        field_inputs,
        lambda call: ((len(call.arguments[2]),),),
        (reproduces_affine_fields, only_relative_positions_count),
        lambda call: local_rounding(call.arguments[0], call.arguments[2], call.arguments[3]),
    ),
    Question(
        "02.5",
        "objective",
        2,
        objective_inputs,
        lambda _: ((),),
        (is_quadratic, depends_on_the_residual_only),
    ),
    Question(
        "02.7",
        "gradient",
        4,
        gradient_inputs,
        lambda call: (call.arguments[2].shape,),
        (has_zero_circulation, adds_the_slope_of_affine_fields, is_per_unit_of_length),
        lambda call: 10 * local_rounding(call.arguments[0], call.arguments[2], call.arguments[3]),
    ),
    Question(
        "02.8",
        "errors",
        3,
        errors_inputs,
        lambda _: ((2,),),
        (grows_with_the_field,),
        lambda call: local_rounding(call.arguments[0], call.arguments[1], call.arguments[3]),
        nothing_for_rounding,
    ),
    Question(
        "02.9",
        "leave_one_out",
        3,
        leave_one_out_inputs,
        lambda call: ((len(call.arguments[0]),),),
        (has_not_seen_the_value, affine_fields_leave_no_error),
        without_the_worst,
    ),
)
