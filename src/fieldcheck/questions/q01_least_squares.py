"""Questions of notebook 01, least squares."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from fieldcheck.calls import Call, Values, calls_of
from fieldcheck.inputs.variants import one_changed
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law_of_each, relative, scale

EPS = float(np.finfo(float).eps)


def cloud(random: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Return n random points in the unit square, or in a cube around the origin."""
    return random.random((n, d)) - (0.4 if d == 3 else 0)


def whole(random: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Return n points with integer coordinates, an array of integers: the origin, one on each axis.

    So they are unisolvent, and neither their mean nor a fitted coefficient is an integer.
    """
    axes = np.diag(random.integers(3, 9, d))
    others = random.integers(-9, 10, (n - d - 1, d))
    return np.concatenate([np.zeros((1, d), dtype=int), axes, others])


# 01.1 The matrix B


def matrix_inputs(seed: int) -> tuple[Call, ...]:
    """Return points in the plane, in space and on the line, integers, and a single point."""
    random = np.random.default_rng(seed)
    sizes = (
        (7, 2, "seven points in the plane"),
        (5, 3, "five points in space"),
        (3, 1, "three points on the line"),
        (3, 2, "three points in the plane"),
        (4, 3, "four points in space"),
    )
    general = tuple(Call("basis_matrix", (cloud(random, n, d),), case) for n, d, case in sizes)
    return (
        *general,
        Call("basis_matrix", (whole(random, 6, 2),), "six points of the plane, integers"),
        Call("basis_matrix", (whole(random, 5, 3),), "five points of space, integers"),
        Call("basis_matrix", (cloud(random, 1, 3),), "one point of space"),
        *one_changed(general[0], ("other coordinates", cloud(random, 7, 2))),
        *one_changed(general[1], ("other coordinates", cloud(random, 5, 3))),
        *(
            Call("basis_matrix", (np.repeat(cloud(random, n, d), 2, axis=0),), case, (0,))
            for n, d, case in (
                (3, 2, "three points of the plane, each of them twice"),
                (2, 3, "two points of space, each of them twice"),
            )
        ),
        Call("basis_matrix", (cloud(random, 71, 2),), "71 points in the plane"),
        Call("basis_matrix", (cloud(random, 101, 3),), "101 points in space"),
    )


def in_units_of_the_points(call: Call, values: Values) -> Values:
    """Return B for small points in a unit in which their largest coordinate is one.

    Otherwise the column of ones would hide errors of small coordinates.
    """
    (b,), (points,) = values, call.arguments
    unit = np.append(1.0, np.full(points.shape[1], min(1.0, scale(points))))
    return (b / unit,)


@law_of_each(
    "B times the coefficients must be the values of the field at the points. So the difference "
    "between two rows must be a zero followed by the difference between their points."
)
def spans_affine_fields(call: Call, values: Values) -> float:
    """Return the largest difference between B-differences and coordinate differences of points."""
    (p,), (b,) = call.arguments, values
    sums = np.diff(b, axis=0) @ np.r_[1.0, np.ones(p.shape[1])]
    return relative(sums - np.diff(p.sum(axis=1)), p)


# 01.2 and 01.6 The fit, and the minimized objective


def fit_inputs(seed: int) -> tuple[Call, ...]:
    """Return random values, values of an affine field, and as many points as coefficients.

    In a strip the singular values of B differ by a factor of a thousand, and none is zero. In
    another unit of length they differ by more. One value may be far from the others.
    """
    random = np.random.default_rng(seed)
    scattered, corner = (
        cloud(random, 12, 2),
        cloud(random, 3, 2) + np.array([[0, 0], [2, 0], [0, 2]]),
    )
    space = cloud(random, 20, 3)
    c = random.normal(size=4)
    cases = calls_of(
        "fit",
        ((scattered, random.normal(size=12)), "twelve points in the plane with random values"),
        ((space, c[0] + space @ c[1:]), "an affine field at twenty points in space"),
        ((corner, random.normal(size=3)), "three points in the plane"),
        (
            (cloud(random, 13, 2) * [1, 1e-3], random.normal(size=13)),
            "thirteen points in a strip of width 10⁻³",
        ),
        (
            (cloud(random, 15, 3) * [1e-3, 1, 1], random.normal(size=15)),
            "fifteen points in a layer of thickness 10⁻³",
        ),
    )
    return (
        cases
        + tuple(
            Call("fit", (np.append(p, p[:3], axis=0), random.normal(size=len(p) + 3)), case, (0,))
            for p, case in (
                (scattered, "fifteen measurements at twelve points of the plane"),
                (space, "twenty-three measurements at twenty points in space"),
            )
        )
        + other_units_and_numbers(random)
        + calls_of(
            "fit",
            (
                (cloud(random, 4, 3) + 2 * np.eye(4, 3), random.normal(size=4)),
                "four points in space",
            ),
        )
        + on_the_line_and_constant(random)
        + one_changed(
            cases[0],
            ("other coordinates", cloud(random, 12, 2)),
            ("other values", random.normal(size=12)),
        )
        + one_changed(
            cases[4],
            ("other coordinates", cloud(random, 15, 3) * [1e-3, 1, 1]),
            ("other values", random.normal(size=15)),
        )
        + calls_of(
            "fit",
            ((cloud(random, 71, 2), random.normal(size=71)), "71 points in the plane"),
            ((cloud(random, 101, 3), random.normal(size=101)), "101 points in space"),
        )
    )


def on_the_line_and_constant(random: np.random.Generator) -> tuple[Call, ...]:
    """Return points of the line, as many as coefficients or more, and values that are all equal."""
    ends = np.array([[0.2], [0.9]])
    line = calls_of(
        "fit",
        ((ends, random.normal(size=2)), "two points on the line"),
        ((-3 * ends, random.normal(size=2)), "two other points on the line"),
        ((cloud(random, 6, 1), random.normal(size=6)), "six points on the line"),
    )
    return line + tuple(
        Call("fit", (cloud(random, n, d), np.full(n, random.uniform(1, 3))), case, (1,))
        for n, d, case in (
            (7, 2, "equal values at seven points of the plane"),
            (8, 3, "equal values at eight points of space"),
        )
    )


def other_units_and_numbers(random: np.random.Generator) -> tuple[Call, ...]:
    """Return points in another unit of length, an outlier, and arrays of integers."""
    small, thin = (1e-6 * cloud(random, 14, d) for d in (2, 3))
    plane, space = cloud(random, 18, 2), cloud(random, 16, 3)
    outlier = 100.0 * np.eye(18)[7]
    integers, more = whole(random, 9, 2), whole(random, 10, 3)
    return calls_of(
        "fit",
        ((small, random.normal(size=14)), "fourteen points in a square of 10⁻⁶"),
        ((thin, random.normal(size=14)), "fourteen points in a cube of 10⁻⁶"),
        ((plane, random.normal(size=18) + outlier), "one value far from the others"),
        ((space, random.normal(size=16) + outlier[2:]), "one value far from the others, in space"),
        ((integers, random.normal(size=9)), "nine points of the plane, integers"),
        ((more, random.normal(size=10)), "ten points of space, integers"),
        ((more, random.integers(-9, 10, 10)), "ten points of space and their values, integers"),
        ((plane, 1e-12 * random.normal(size=18)), "eighteen values of about 10⁻¹²"),
        ((space, 1e-12 * random.normal(size=16)), "sixteen values of about 10⁻¹², in space"),
    )


def fit_tolerance(call: Call) -> float:
    """Return eps times the condition of B, and its square for columns of length one.

    Singular values depend on the unit of length, elimination in the normal equations does not.
    """
    points = call.arguments[0]
    b = np.insert(points, 0, 1.0, axis=1)
    squared = np.linalg.cond(b / np.sqrt((b * b).sum(axis=0))) ** 2
    return 100 * EPS * float(squared + np.linalg.cond(b))


@law_of_each(
    "The residual of the best fit must be orthogonal to the columns of B. So its sum must be "
    "zero, also when weighted by a coordinate."
)
def residual_is_orthogonal(call: Call, values: Values) -> float:
    """Return the largest sum of residuals, unweighted and weighted by a coordinate."""
    (c,) = values
    points, data = call.arguments
    residual = c[0] - data + sum(points[:, k] * c[k + 1] for k in range(points.shape[1]))
    moments = [residual.sum(), *(residual * points[:, k] for k in range(points.shape[1]))]
    return max(relative(np.sum(m), np.abs(data).sum()) for m in moments)


# 01.3 and 01.5 The field and its gradient


def field_inputs(name: str, seed: int) -> tuple[Call, ...]:
    """Return coefficients and evaluation points in the plane and in space, and integers."""
    random = np.random.default_rng(seed)
    general = tuple(
        Call(name, (random.normal(size=d + 1), random.normal(size=(m, d))), case)
        for m, d, case in (
            (6, 2, "six evaluation points in the plane"),
            (4, 3, "four evaluation points in space"),
            (2, 2, "two evaluation points in the plane"),
            (3, 3, "three evaluation points in space"),
            (2, 3, "two evaluation points in space"),
            (1, 2, "one evaluation point in the plane"),
            (1, 3, "one evaluation point in space"),
        )
    )
    c, x = random.normal(size=(2, 3)), random.normal(size=(5, 2))
    case = "of the plane, integers, one of them the origin"
    return (
        general
        + calls_of(
            name,
            ((c[0], whole(random, 6, 2)), f"six evaluation points {case}"),
            ((random.normal(size=4), whole(random, 7, 3)), "seven evaluation points, integers"),
            ((random.integers(1, 9, 3), x), "coefficients that are integers"),
            ((c[1], np.diag(x[0])), "evaluation points on the axes"),
        )
        + tuple(
            Call(
                name,
                (np.where(np.arange(d + 1) == k, 0.0, random.normal(size=d + 1)), y),
                case,
                (0,),
            )
            for d, k, case, y in (
                (2, 0, "the first coefficient zero", random.normal(size=(4, 2))),
                (3, 0, "the first coefficient zero, in space", random.normal(size=(5, 3))),
                (2, 2, "the last coefficient zero", random.normal(size=(6, 2))),
            )
        )
        + tuple(
            other
            for call in general[:2]
            for other in one_changed(
                call,
                ("other coefficients", random.normal(size=call.arguments[0].shape)),
                ("other coordinates", random.normal(size=call.arguments[1].shape)),
            )
        )
        + calls_of(
            name,
            (
                (random.normal(size=3), random.normal(size=(77, 2))),
                "77 evaluation points in the plane",
            ),
            (
                (random.normal(size=4), random.normal(size=(71, 3))),
                "71 evaluation points in space",
            ),
            *(
                ((1e-12 * random.normal(size=d + 1), random.normal(size=(3, d))), case)
                for d, case in (
                    (2, "coefficients of about 10⁻¹² in the plane"),
                    (3, "coefficients of about 10⁻¹² in space"),
                )
            ),
            *(
                ((random.normal(size=d + 1), 1e4 * random.normal(size=(3, d))), case)
                for d, case in (
                    (2, "evaluation points in the plane, about 10⁴ away"),
                    (3, "evaluation points in space, about 10⁴ away"),
                )
            ),
        )
    )


@law_of_each(
    "The difference of two values must be the product of the slopes and the difference of points."
)
def moves_by_the_gradient(call: Call, values: Values) -> float:
    """Return the largest error of differences of values, which do not contain the constant."""
    (c, x), (v,) = call.arguments, values
    return relative(np.diff(v) - [(b - a) @ c[1:] for a, b in pairwise(x)], v)


# 01.4 The rank


def from_end_to_end(random: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Return n random points, the first two at the ends of the unit square or cube.

    So it does not matter whether distances from the first point or the extent is the unit.
    """
    ends = np.full((2, d), 0.5)
    ends[:, 0] = 0, 1
    return np.append(ends, random.random((n - 2, d)), axis=0)


def many(random: np.random.Generator, d: int) -> np.ndarray:
    """Return 400 points 2⁻³³ beside a line or plane.

    The least singular value is 2.3·10⁻⁹. The largest is 5 or 6, so it is not the unit.
    """
    points = random.random((400, d))
    points[0], points[1] = 0, 1
    points[:, -1] = np.resize([2.0**-33, -(2.0**-33)], 400)
    return points


def rank_inputs(seed: int) -> tuple[Call, ...]:
    """Return points of each rank, far from the origin, nearly on a line, and in another unit.

    Points exactly on a line or plane come first: for points nearly on one, the tolerance matters.
    """
    random = np.random.default_rng(seed)
    along, line = random.normal(size=(9, 1)), random.normal(size=(2, 2))
    there_and_back = along[[0, 0, 1, 2, 3, 4, 5, 6, 7, 0]]
    plane, space = random.random((8, 2)), random.random((9, 3))
    plane[2] = 0.3 * plane[0] + 0.7 * plane[1]
    space[3] = 0.3 * space[0] + 0.5 * space[1] + 0.2 * space[2]
    layer = random.normal(size=(10, 2)) @ random.normal(size=(2, 3)) + random.normal(size=3)
    cases = (
        (random.random((9, 2)), "nine points in the plane"),
        (random.random((2, 3)), "two points in space"),
        (cloud(random, 3, 2) + np.array([[0, 0], [2, 0], [0, 2]]), "three points in the plane"),
        (cloud(random, 4, 3) + 2 * np.eye(4, 3), "four points in space"),
        (np.array([1e7, -3e6]) + random.random((8, 2)), "eight points of the plane, 10⁷ away"),
        (np.array([2e6, 0, 1e7]) + random.random((9, 3)), "nine points in space, 10⁷ away"),
        (random.random((8, 2)) * [1, 1e-4], "eight points in a strip of width 10⁻⁴"),
        (np.array([1e6, -3e5]) + random.random((8, 2)) * [1e-4, 1], "a strip, 10⁶ away"),
        (random.random((9, 3)) * [1e-4, 1, 1], "nine points in a layer of thickness 10⁻⁴"),
        (random.random((8, 2)) * [1e-8, 1], "eight points in a strip of width 10⁻⁸"),
        (random.random((9, 3)) * [1, 1, 1e-8], "nine points in a layer of thickness 10⁻⁸"),
        (random.random((8, 2)) * [1, 1e-12], "eight points within 10⁻¹² of a line"),
        (random.random((9, 3)) * [1, 1, 1e-12], "nine points within 10⁻¹² of a plane"),
        (random.random((8, 2)) * [1e-12, 1], "eight points within 10⁻¹² of a vertical line"),
        (random.random((9, 3)) * [1e-12, 1, 1], "nine points within 10⁻¹² of a vertical plane"),
        (1e-9 * random.random((7, 2)), "seven points in a square of 10⁻⁹"),
        (1e-9 * random.random((8, 3)), "eight points in a cube of 10⁻⁹"),
        ([2e6, -3e5, 1e6] + random.random((9, 3)) * [1, 1, 1e-5], "a layer, 10⁶ away"),
        (
            (random.random((8, 2)) * [1, 1e-7]) @ [[0.8, 0.6], [-0.6, 0.8]],
            "eight points in an oblique strip of width 10⁻⁷",
        ),
        (from_end_to_end(random, 8, 2) * [1, 3e-10], "eight points within 3·10⁻¹⁰ of a line"),
        (from_end_to_end(random, 9, 3) * [1, 3e-10, 1], "nine points within 3·10⁻¹⁰ of a plane"),
        (1e12 * random.random((7, 2)), "seven points in a square of 10¹²"),
        (1e12 * random.random((8, 3)), "eight points in a cube of 10¹²"),
        (
            (random.random((12, 2)) * [1e3, 2e-4]) @ [[0.28, -0.96], [0.96, 0.28]],
            "twelve points in a long oblique strip",
        ),
        (many(random, 2), "four hundred points beside a line"),
        (many(random, 3), "four hundred points beside a plane"),
    )
    exact = (
        (line[0] + along * line[1], "nine points on one line"),
        (np.tile(random.random((2, 2)), (2, 1)), "two points of the plane, each of them twice"),
        (layer, "ten points in one plane of space"),
        (1000 + line[0] + along * line[1], "nine points on a line, 1000 away"),
        (1000 + layer, "ten points in one plane of space, 1000 away"),
        (1e-9 * (line[0] + along * line[1]), "nine points on a line of length 10⁻⁹"),
        (line[0] + there_and_back * line[1], "ten points on a line, the first three times"),
        (
            layer[[0, *range(10), 0]],
            "ten points in one plane of space, the first three times",
        ),
        (plane, "eight points of the plane, the first three on one line"),
        (space, "nine points in space, the first four in one plane"),
        (plane[:2], "two points of the plane"),
        (np.stack([line[0], -line[0], 0 * line[0]]), "two opposite points, and the origin"),
        (
            np.column_stack([np.cos(along), np.sin(along)]) @ np.linalg.qr(layer[:3].T)[0].T[:2],
            "nine points of space on a circle around the origin",
        ),
        (
            np.append(line[0] + random.normal(size=(40, 1)) * line[1], plane[:1], axis=0),
            "forty points on a line, and one point off the line",
        ),
        (
            np.append(random.random((40, 2)) @ layer[:2], layer[:1] + np.array([0, 0, 2]), axis=0),
            "forty points in one plane of space, and one point off the plane",
        ),
        *(
            (
                size * p[[*first, *range(2, 7), *last]],
                f"nine points in a {box} of {words}, {which} two at one point",
            )
            for first, last, which in (((0, 0), (7, 8), "the first"), ((0, 1), (8, 8), "the last"))
            for size, words in ((1e-12, "10⁻¹²"), (1e12, "10¹²"))
            for p, box in ((layer[1:], "cube"), (random.random((9, 2)), "square"))
        ),
        (plane[:2] * [0, 1] + [0.3, 0], "two points of the plane, one above the other"),
        (space[:3] * [0, 1, 1] + [0.3, 0, 0], "three points of a vertical plane"),
        (whole(random, 7, 2), "seven points of the plane, integers"),
        (
            np.array([3, 1, -2]) + np.outer([0, 2, 3, 7, 9, 13], random.integers(1, 6, 3)),
            "six points of space on one line, integers",
        ),
        (
            np.array([1, 4]) + np.outer([0, 1, 3, 4, 8, 9, 13], [2, random.integers(3, 9)]),
            "seven points of the plane on one line, integers",
        ),
    )
    near = tuple(Call("rank", (points,), case) for points, case in cases)
    on = tuple(Call("rank", (points,), case, exact=(0,)) for points, case in exact)
    return near[:6] + on[:3] + near[6:] + on[3:]


@law_of_each(
    "The rank must be a whole number, at least 2 and at most the number of rows or of columns."
)
def is_a_possible_rank(call: Call, values: Values) -> float:
    """Return how far a rank is from an integer, or above the numbers of rows and columns."""
    n, d = call.arguments[0].shape
    rank = float(values[0])
    return max(abs(rank - round(rank)), 2 - rank, rank - min(n, d + 1))


@law_of_each("An affine field must have the same gradient at every point.")
def is_constant(_: Call, values: Values) -> float:
    """Return how much the gradient differs between evaluation points."""
    (g,) = values
    return relative(np.ptp(g, axis=0), g)


QUESTIONS = (
    Question(
        "01.1",
        "basis_matrix",
        2,
        also_at_zero(matrix_inputs, points=(0,)),
        lambda call: ((call.arguments[0].shape[0], call.arguments[0].shape[1] + 1),),
        (spans_affine_fields,),
        normal_form=in_units_of_the_points,
    ),
    Question(
        "01.2",
        "fit",
        3,
        also_at_zero(fit_inputs, points=(0,), values=(1,)),
        lambda call: ((call.arguments[0].shape[1] + 1,),),
        (residual_is_orthogonal,),
        fit_tolerance,
    ),
    Question(
        "01.3",
        "evaluate",
        1,
        also_at_zero(lambda seed: field_inputs("evaluate", seed), points=(1,), values=(0,)),
        lambda call: ((len(call.arguments[1]),),),
        (moves_by_the_gradient,),
    ),
    Question(
        "01.4",
        "rank",
        2,
        also_at_zero(rank_inputs, points=(0,)),
        lambda _: ((),),
        (is_a_possible_rank,),
        may_call=("01.1",),
    ),
    Question(
        "01.5",
        "gradient",
        1,
        lambda seed: field_inputs("gradient", seed),
        lambda call: (call.arguments[1].shape,),
        (is_constant,),
    ),
)
