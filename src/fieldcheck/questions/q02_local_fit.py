"""Questions of notebook 02 on the fit at one point: weights, coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.inputs.variants import one_changed
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative

EPS = float(np.finfo(float).eps)
TINY = 1e-10
"""A factor of values, beside which an added constant or an absolute tolerance is large."""
FAR = 1e4
"""The distance of points from the origin, in units of their size: their squares lose digits."""


def affine(points: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Return the values of an affine field with these slopes and the value 0.7 at the origin."""
    return points @ slopes + 0.7


def condition(points: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
    """Return the condition number of B, or of WB, with columns of length one, also for stacked
    sets of points.

    Elimination does not depend on the scale of the columns.
    """
    b = np.concatenate([np.ones_like(points[..., :1]), points], axis=-1)
    if weights is not None:
        b = b * weights[..., np.newaxis]
    return np.asarray(np.linalg.cond(b / np.sqrt((b * b).sum(axis=-2, keepdims=True))))


def rounding(points: np.ndarray, spread: float | np.ndarray) -> float:
    """Return the rounding error of the normal equations; `spread` is the ratio of the weights.

    It is eps times the squared condition of WB, which is at most the spread times the condition of
    B. For stacked sets of points it returns the largest error; each set may have its own spread.
    """
    return 100 * EPS * float(np.max(spread * condition(points))) ** 2


def corners(random: np.random.Generator, d: int) -> np.ndarray:
    """Return D + 1 points near the corners of a triangle, or of a tetrahedron."""
    return random.random((d + 1, d)) + 2 * np.eye(d + 1, d, -1)


def other_coordinates(random: np.random.Generator, n: int, d: int) -> tuple[str, np.ndarray]:
    """Return words and random points that replace those of a call."""
    return "other coordinates", random.random((n, d)) - 0.4


def other_values(random: np.random.Generator, n: int) -> tuple[str, np.ndarray]:
    """Return words and random values that replace those of a call."""
    return "other values", random.normal(size=n)


def twice(points: np.ndarray, k: int) -> np.ndarray:
    """Return points, followed by the first k of them again: they are measured twice."""
    return np.append(points, points[:k], axis=0)


def far_away(random: np.random.Generator, *points: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return points of size one, all moved by the same random vector, far away from the origin."""
    shift = FAR * random.uniform(1, 3, points[0].shape[-1])
    return tuple(p + shift for p in points)


def flat(points: np.ndarray) -> np.ndarray:
    """Return points of the plane moved close to a line, or points of space close to a plane."""
    others, last = points[:, :-1], points[:, -1]
    slopes = np.array([0.6, -0.4])[: others.shape[1]]
    return np.column_stack([others, 0.3 + others @ slopes + last / 100])


def two_groups(points: np.ndarray, first: int) -> np.ndarray:
    """Return points of size one, those after the first few far away from the others."""
    return points + np.where(np.arange(len(points)) < first, 0.0, FAR)[:, None]


# 02.1 The weights


def weights_inputs(seed: int) -> tuple[Call, ...]:
    """Return an evaluation point, the same in another unit, one in space, and one at a site.

    All points lie around the origin. A number added to the squares, such as 10⁻¹², is visible in
    small units only.
    """
    random = np.random.default_rng(seed)
    plane, space = random.random((7, 2)) - 0.4, random.random((5, 3)) - 0.4
    x = random.random(2) - 0.8
    calls = calls_of(
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
        ((space, space[3].copy(), 0.25), "an evaluation point in space that is one of the points"),
        ((random.random((1, 2)), random.random(2), 0.3), "one point of the plane"),
        ((random.random((1, 3)), random.random(3), 0.4), "one point of space"),
    )
    return (
        calls
        + tuple(
            other
            for call in (calls[0], calls[2])
            for other in one_changed(
                call,
                other_coordinates(random, *call.arguments[0].shape),
                ("another evaluation point", random.normal(size=call.arguments[1].shape)),
                ("another ε", 0.45),
            )
        )
        + many_or_far(random)
    )


def many_or_far(random: np.random.Generator) -> tuple[Call, ...]:
    """Return many points, large units, points far from the origin, and ε that are integers."""
    plane, space = random.random((69, 2)) - 0.4, random.random((43, 3)) - 0.4
    x, y = random.random(2), random.random(3)
    far = calls_of(
        "weights",
        ((*far_away(random, plane[:7], x), 0.3), "seven points in the plane, far from the origin"),
        ((*far_away(random, space[:5], y), 0.4), "five points in space, far from the origin"),
        ((two_groups(plane[:7] + x, 4), x, 0.3), "two groups of points, far from each other"),
        ((two_groups(space[:5] + y, 2), y, 0.4), "two groups of points in space"),
    )
    return calls_of(
        "weights",
        ((plane, x, 0.3), "sixty-nine points in the plane"),
        ((space, y, 0.3), "forty-three points in space"),
        ((1e5 * plane[:7], 1e5 * x, 2e4), "seven points in a square of 10⁵"),
        ((1e5 * space[:5], 1e5 * y, 3e4), "five points in a cube of 10⁵"),
        ((integers(plane[:7]), integers(x), 90), "seven points and ε, all of them integers"),
        ((integers(space[:5]), integers(y), 180), "five points in space and ε, all integers"),
        ((integers(plane[:7]), 100 * x, 90.0), "seven points of integers and another point"),
        ((integers(space[:5]), 100 * y, 180.0), "five points of integers and another point"),
    ) + tuple(replace(call, exact=(0, 1)) for call in far)


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
        (1e-8 * twice(plane, 2), alike, "fourteen measurements in a square of 10⁻⁸"),
        (1e-8 * twice(space, 3), alike, "twenty-three measurements in a cube of 10⁻⁸"),
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
        ((corners(random, 3), random.normal(size=4), alike(4)), "four points in space"),
        ((plane, TINY * v[:12], alike(12)), "twelve points in the plane, values of size 10⁻¹⁰"),
        ((space, TINY * data[:20], alike(20)), "twenty points in space, values of size 10⁻¹⁰"),
    ]
    calls = tuple(Call("weighted_fit", arguments, case, exact=(0,)) for arguments, case in given)
    return (
        calls
        + tuple(
            other
            for call in calls[:2]
            for other in one_changed(
                call,
                other_coordinates(random, *call.arguments[0].shape),
                other_values(random, len(call.arguments[0])),
                ("other weights", alike(len(call.arguments[0]))),
            )
        )
        + many_or_rescaled_fits(random)
        + fits_by_small_weights(random)
    )


def fits_by_small_weights(random: np.random.Generator) -> tuple[Call, ...]:
    """Return points of large weight on an axis or in a plane of axes, and others of small weight.

    The small weights alone determine the slope across.
    """
    calls = []
    for n, d, beside, words in (
        (9, 2, 3, "nine points on an axis, three beside it with weights of 10⁻⁵"),
        (12, 3, 4, "twelve points in a plane of axes, four beside it with weights of 10⁻⁵"),
    ):
        level = random.uniform(-1, 1, (n, d)) * np.append(np.ones(d - 1), 0)
        points = np.vstack([level, random.uniform(0.5, 1, (beside, d))])
        w = np.append(random.uniform(0.5, 2, n), 1e-5 * random.uniform(0.5, 2, beside))
        calls.append(Call("weighted_fit", (points, random.normal(size=n + beside), w), words, (0,)))
    return tuple(calls)


def many_or_rescaled_fits(random: np.random.Generator) -> tuple[Call, ...]:
    """Return many points, other units of length, weights that are integers, and equal values.

    The weights have the unit of (2.3).
    """
    plane, space = random.random((43, 2)) - 0.4, random.random((69, 3)) - 0.4
    v, data = random.normal(size=43), random.normal(size=69)
    w, u = random.uniform(0.3, 3, 43), random.uniform(0.3, 3, 69)
    few, other = slice(12), slice(15)
    return calls_of(
        "weighted_fit",
        ((plane, v, w), "forty-three points in the plane"),
        ((space, data, u), "sixty-nine points in space"),
        *(
            given
            for unit, words in ((1e-5, "10⁻⁵"), (1e3, "1000"))
            for given in (
                (
                    (unit * plane[few], v[few], w[few] / unit**2),
                    f"twelve points and weights, all lengths in a square of {words}",
                ),
                (
                    (unit * space[other], data[other], u[other] / unit**2),
                    f"fifteen points and weights, all lengths in a cube of {words}",
                ),
            )
        ),
        ((plane[few], v[few], random.integers(1, 9, 12)), "twelve weights that are integers"),
        (
            (integers(space[other]), integers(data[other]), random.integers(1, 9, 15)),
            "fifteen points, values and weights, all of them integers",
        ),
        ((plane[few], np.full(12, v[0]), w[few]), "twelve points of equal values"),
        ((space[other], np.full(15, data[0]), u[other]), "fifteen points of equal values"),
        *(
            ((p, data[: len(p)], np.where(np.arange(len(p)) == 2, 3000, 1 + p[:, 0] / 2)), case)
            for p, case in (
                (plane[few], "twelve points, one weight two thousand times the others"),
                (space[other], "fifteen points, one weight two thousand times the others"),
            )
        ),
        *(
            (
                (
                    np.append(flat(p[: d + 2]), p[d + 2 :], axis=0),
                    random.normal(size=len(p)),
                    np.where(np.arange(len(p)) < d + 2, 1, light) * random.uniform(0.5, 1, len(p)),
                ),
                case,
            )
            for d, p, light, case in (
                (2, plane[few], 4e-4, "four large weights near a line, eight small ones"),
                (3, space[other], 4e-4, "five large weights near a plane, ten small ones"),
                (2, plane[12:24], 2e-4, "four large weights near a line, eight smaller ones"),
                (3, space[15:30], 2e-4, "five large weights near a plane, ten smaller ones"),
            )
        ),
    )


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


QUESTIONS = (
    Question(
        "02.1",
        "weights",
        2,
        also_at_zero(weights_inputs, points=(0, 1)),
        lambda call: ((len(call.arguments[0]),),),
        (weights_differ_like_squared_distances, unit_of_length, greatest_at_the_point_itself),
    ),
    Question(
        "02.2",
        "weighted_fit",
        3,
        also_at_zero(fit_inputs, points=(0,), values=(1,)),
        lambda call: ((call.arguments[0].shape[1] + 1,),),
        (weighted_residual_is_orthogonal,),
        lambda call: rounding(
            call.arguments[0], float(call.arguments[2].max() / call.arguments[2].min())
        ),
    ),
)
