"""Questions of notebook 03, radial basis functions.

The laws need the kernel. They compute it as the derivative of s^t at t = 1, by a complex step.
"""

from __future__ import annotations

from math import ceil

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.inputs.variants import one_changed
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law_of_each, relative

STEP = 1e-30
"""The size of the complex step; its square underflows."""
FAR = 1e4
"""The distance of points from the origin, in units of their size: their squares lose digits."""
TINY = 1e-10
"""A factor of values and coefficients, beside which an absolute tolerance is large."""


def cloud(random: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Return n points of the unit square, or of a cube around the origin.

    Each is in one of n cells of a grid, so that no two are close together.
    """
    side = ceil(n ** (1 / d)) + 1
    cells = random.permutation(side**d)[:n]
    corners = np.stack(np.unravel_index(cells, (side,) * d), axis=1)
    return (corners + random.uniform(0.2, 0.8, (n, d))) / side - (0.4 if d == 3 else 0)


def lattice(random: np.random.Generator, *counts: int) -> np.ndarray:
    """Return the points of a lattice: many of them share a coordinate."""
    axes = (np.cumsum(random.uniform(0.2, 0.6, count)) for count in counts)
    return np.stack([x.ravel() for x in np.meshgrid(*axes)], axis=1)


def squares(x: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the squared distances of evaluation points and sites, coordinate by coordinate."""
    parts = (np.subtract.outer(a, b) ** 2 for a, b in zip(x.T, points.T, strict=True))
    return np.add.reduce(list(parts))


def grown(s: np.ndarray) -> np.ndarray:
    """Return the derivative of s^t with respect to t at t = 1."""
    return np.asarray(np.imag(s ** (1 + 1j * STEP)) / STEP)


def field(points: np.ndarray, lam: np.ndarray, c: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the values of the field with given coefficients."""
    return (
        sum(a * column for a, column in zip(c[1:], x.T, strict=True))
        + c[0]
        + grown(squares(x, points)).dot(lam)
    )


def at_distance_one(random: np.random.Generator, d: int) -> np.ndarray:
    """Return a point of a lattice and its neighbours at distance one, where its kernel is zero.

    So the matrix of the kernels is singular, although the points determine the field.
    """
    around = np.concatenate([np.zeros((1, d)), np.eye(d), -np.eye(d)])
    return around + random.integers(-2, 3, d)


def far_away(random: np.random.Generator, *points: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return points of size one, all moved by the same random vector, far away from the origin."""
    shift = FAR * random.uniform(1, 3, points[0].shape[-1])
    return tuple(p + shift for p in points)


def one_at_the_origin(points: np.ndarray) -> np.ndarray:
    """Return the points with the third one moved to the origin."""
    return np.where(np.arange(len(points))[:, np.newaxis] == 2, 0.0, points)


def with_zeros(values: np.ndarray, *where: int) -> np.ndarray:
    """Return the values with zeros at these positions."""
    return np.where(np.isin(np.arange(len(values)), where), 0, values)


def extent(points: np.ndarray) -> float:
    """Return the largest side of the box of the points, or one if all of them are the same."""
    return float(np.ptp(points, axis=0).max()) or 1.0


# 03.1 The kernel


def kernel_inputs(seed: int) -> tuple[Call, ...]:
    """Return short, long and zero vectors of several dimensions, and an array of vectors."""
    random = np.random.default_rng(seed)
    plane = random.normal(size=(7, 2))
    plane[2] = plane[4, 0] = plane[5, 1] = 0
    table = random.normal(size=(4, 3, 2))
    table[1, 1] = table[3, 0] = table[0, 2, 1] = 0
    space = random.normal(size=(6, 3)) * np.array([[0.01, 0.1, 1, 2, 5, 30]]).T
    space[3, 1] = 0
    return calls_of(
        "kernel",
        ((plane,), "seven vectors of the plane, one zero and two along an axis"),
        ((space,), "six vectors in space, short and long"),
        ((table,), "a table of four times three vectors of the plane"),
        ((1e-5 * random.normal(size=(4, 2)),), "four vectors of the plane of length 10⁻⁵"),
        ((1e-7 * random.normal(size=(3, 3)),), "three vectors in space of length 10⁻⁷"),
        ((1e-11 * random.normal(size=(4, 2)),), "four vectors of the plane of length 10⁻¹¹"),
        ((2e-11 * random.normal(size=(3, 3)),), "three vectors in space of length 2·10⁻¹¹"),
        ((integers(plane, 1000),), "seven vectors of the plane, integers"),
        ((integers(table, 1000),), "a table of four times three vectors, integers"),
        ((random.normal(size=(1, 2)),), "an array of one vector"),
        ((random.normal(size=(3, 1, 3)),), "a table of three times one vectors in space"),
        ((1e5 * random.normal(size=(4, 2)),), "four vectors of the plane of length 10⁵"),
        ((2e5 * random.normal(size=(3, 3)),), "three vectors in space of length 2·10⁵"),
        ((random.normal(size=(69, 2)),), "sixty-nine vectors of the plane"),
        (
            (random.permutation([[1, 0], [0, -1], [1, 1], [-1, 1], [0, 0]]),),
            "five vectors of the numbers −1, 0 and 1",
        ),
        (
            (
                random.permutation(
                    [
                        [1.0, 0.0, 0.0],
                        [0.0, -1.0, 0.0],
                        [1.0, 1.0, 1.0],
                        [-1.0, 0.0, 1.0],
                        [0.0, 0.0, 0.0],
                    ]
                ),
            ),
            "five vectors in space of the numbers −1, 0 and 1",
        ),
        ((random.normal(size=2),), "a single vector of the plane"),
        ((random.normal(size=3),), "a single vector in space"),
    )


@law_of_each("The quotient of w(y) and |y|² must be the logarithm of |y|², and w(0) must be 0.")
def quotient_is_a_logarithm(call: Call, values: Values) -> float:
    """Return the deviation of exp(w / s) from s, and of w from zero where s is zero."""
    (w,) = values
    s = np.linalg.norm(call.arguments[0], axis=-1) ** 2
    there = s > 0
    with np.errstate(over="ignore"):
        quotient = np.exp(w[there] / s[there]) / s[there]
    return max(relative(w[~there], 1.0), relative(quotient - 1, 1.0))


# 03.2 The matrix


def matrix_inputs(seed: int) -> tuple[Call, ...]:
    """Return points in the plane, in space and on the line, and points that occur twice."""
    random = np.random.default_rng(seed)
    sizes = (
        (6, 2, "six points in the plane"),
        (8, 3, "eight points in space"),
        (3, 2, "three points in the plane"),
    )
    lattices = (
        (1e-4 * lattice(random, 3, 2), "six points of a lattice of 10⁻⁴ in the plane"),
        (1e-4 * lattice(random, 2, 2, 2), "eight points of a lattice of 10⁻⁴ in space"),
    )
    general = [Call("system_matrix", (cloud(random, n, d),), case) for n, d, case in sizes]
    return (
        *general,
        *(Call("system_matrix", (points,), case, exact=(0,)) for points, case in lattices),
        *(
            Call("system_matrix", (integers(call.arguments[0], 1000),), f"{call.case}, integers")
            for call in general[:2]
        ),
        Call("system_matrix", (cloud(random, 4, 1),), "four points on the line"),
        *(
            Call("system_matrix", (points[[*range(len(points)), 1]],), case, exact=(0,))
            for points, case in (
                (cloud(random, 5, 2), "six points in the plane, two of them the same"),
                (cloud(random, 6, 3), "seven points in space, two of them the same"),
            )
        ),
        *few_or_far(random),
    )


def few_or_far(random: np.random.Generator) -> tuple[Call, ...]:
    """Return fewer points than coordinates and one more, large units, and points far away."""
    cases = (
        (cloud(random, 2, 2), "two points in the plane"),
        (cloud(random, 3, 3), "three points in space"),
        (random.random((1, 2)), "one point of the plane"),
        (random.random((1, 3)), "one point of space"),
        (1e5 * cloud(random, 5, 2), "five points in a square of 10⁵"),
        (1e5 * cloud(random, 6, 3), "six points in a cube of 10⁵"),
        (one_at_the_origin(cloud(random, 6, 2)), "six points in the plane, one of them the origin"),
        (one_at_the_origin(cloud(random, 7, 3)), "seven points in space, one of them the origin"),
    )
    far = (
        (far_away(random, cloud(random, 5, 2)), "five points in the plane, far from the origin"),
        (far_away(random, cloud(random, 6, 3)), "six points in space, far from the origin"),
    )
    return (
        *(Call("system_matrix", (points,), case) for points, case in cases),
        *(Call("system_matrix", points, case, exact=(0,)) for points, case in far),
    )


def in_units_of_the_kernel(call: Call, values: Values) -> Values:
    """Return H with the block of the kernels, and the coordinates, in units in which they are one.

    Otherwise the ones would hide what is added to the small kernels, such as 10⁻¹⁰ on the diagonal,
    and large coordinates would hide errors of the kernels.
    """
    (h,), (points,) = values, call.arguments
    n, unit = len(points), np.array(h, dtype=float)
    unit[:n, :n] /= min(1.0, extent(points) ** 2)
    largest = max(1.0, float(np.abs(points).max()))
    unit[:n, n + 1 :] /= largest
    unit[n + 1 :, :n] /= largest
    return (unit,)


def matrix_shape(call: Call) -> tuple[tuple[int, ...], ...]:
    rows = sum(call.arguments[0].shape) + 1
    return ((rows, rows),)


def asymmetry(_: Call, values: Values) -> float:
    """Return the largest difference from the transpose."""
    (h,) = values
    return relative(h - h.T, h)


@law_of_each(
    "The matrix times (λ, c) must be the values of the field at the points, and below them the "
    "sums of (3.4)."
)
def maps_coefficients_to_data(call: Call, values: Values) -> float:
    """Return the deviation of H (λ, c) from the values of the field and from the moments of λ."""
    (h,) = values
    (points,) = call.arguments
    n, d = points.shape
    lam, c = np.cos(np.arange(n)), np.sin(1.0 + np.arange(d + 1))
    moments = [lam.sum(), *(points.T * lam).sum(axis=1)]
    wanted = np.append(field(points, lam, c, points), moments)
    return relative(h.dot(np.append(lam, c)) - wanted, wanted)


# 03.3 The coefficients


def coefficients_inputs(seed: int) -> tuple[Call, ...]:
    """Return random values in the plane and in space; an affine field with one value changed."""
    random = np.random.default_rng(seed)
    plane, space, affine = (cloud(random, n, d) for n, d in ((12, 2), (10, 3), (7, 2)))
    almost = 1 - 2 * affine[:, 0] + random.normal() * affine[:, 1]
    almost[0] += 1
    calls = calls_of(
        "coefficients",
        ((plane, random.normal(size=12)), "twelve points in the plane with random values"),
        ((space, random.normal(size=10)), "ten points in space with random values"),
        ((affine, almost), "an affine field with one value changed"),
        (
            (integers(plane, 100), integers(random.normal(size=12))),
            "twelve points in a square of 100, points and values integers",
        ),
        ((integers(space, 100), random.normal(size=10)), "ten points in a cube of 100, integers"),
        ((plane, TINY * random.normal(size=12)), "twelve points, values of size 10⁻¹⁰"),
        ((space, TINY * random.normal(size=10)), "ten points in space, values of size 10⁻¹⁰"),
    )
    exact = (
        (at_distance_one(random, 1), "three whole numbers on the line"),
        (at_distance_one(random, 2), "a point of the plane and four neighbours at distance one"),
    )
    return (
        *calls,
        *(
            Call("coefficients", (points, random.normal(size=len(points))), case, exact=(0,))
            for points, case in exact
        ),
        *(
            other
            for call in calls[:2]
            for other in one_changed(
                call,
                ("other coordinates", cloud(random, *call.arguments[0].shape)),
                ("other values", random.normal(size=len(call.arguments[1]))),
            )
        ),
        *few_or_rescaled(random),
    )


def few_or_rescaled(random: np.random.Generator) -> tuple[Call, ...]:
    """Return as many points as affine functions, other units of length, and many points."""
    plane, space = cloud(random, 12, 2), cloud(random, 10, 3)
    v, data = random.normal(size=43), random.normal(size=10)
    triangle, tetrahedron = (
        np.eye(d + 1, d, -1) + random.uniform(-0.1, 0.1, (d + 1, d)) for d in (2, 3)
    )
    return calls_of(
        "coefficients",
        ((triangle, v[:3]), "three points in the plane"),
        ((tetrahedron, v[:4]), "four points in space"),
        ((0.03 * plane, v[:12]), "twelve points in a square of 0.03"),
        ((0.02 * space, data), "ten points in a cube of 0.02"),
        ((50 * plane, v[:12]), "twelve points in a square of 50"),
        ((30 * space, data), "ten points in a cube of 30"),
        ((cloud(random, 43, 2), v), "forty-three points in the plane"),
        ((plane, np.full(12, v[0])), "twelve equal values in the plane"),
        ((space, np.full(10, v[1])), "ten equal values in space"),
        ((plane, np.full(12, round(9 * v[2]))), "twelve equal values that are integers"),
        ((plane, with_zeros(v[:12], 3, 8)), "twelve values in the plane, two of them zero"),
        ((space, with_zeros(data, 4)), "ten values in space, one of them zero"),
        ((plane, with_zeros(integers(v[:12], 9), 0, 1)), "twelve integers, the first two zero"),
        ((triangle, with_zeros(v[:3], 1)), "three points in the plane, one value zero"),
        ((one_at_the_origin(plane), v[12:24]), "twelve points in the plane, one at the origin"),
    )


def nothing_for_rounding(call: Call, values: Values) -> Values:
    """Return λ and c with zeros for the λ that are rounding errors, as for affine values."""
    (lam, c), (points, wanted) = values, call.arguments
    least = 1e-10 * float(np.abs(wanted).max()) / extent(points) ** 2
    return np.where(np.abs(lam) < least, 0.0, lam), c


def coefficients_shapes(call: Call) -> tuple[tuple[int, ...], ...]:
    n, d = call.arguments[0].shape
    return ((n,), (d + 1,))


@law_of_each("With these coefficients the field must interpolate the values.")
def interpolates_the_values(call: Call, values: Values) -> float:
    """Return the deviation of the field from the values at the points."""
    (lam, c) = values
    points, wanted = call.arguments
    return relative(field(points, lam, c, points) - wanted, wanted)


@law_of_each(
    "The λ must satisfy the orthogonality constraints: their sum must be zero, also when "
    "weighted by a coordinate."
)
def has_no_moments(call: Call, values: Values) -> float:
    """Return the largest sum of the λ_j, unweighted and weighted by a coordinate."""
    (lam, _) = values
    size = max(np.abs(lam).max(), np.abs(call.arguments[1]).max())
    return relative([lam.sum(), *call.arguments[0].T.dot(lam)], size)


QUESTIONS = (
    Question(
        "03.1",
        "kernel",
        2,
        kernel_inputs,
        lambda call: (call.arguments[0].shape[:-1],),
        (quotient_is_a_logarithm,),
    ),
    Question(
        "03.2",
        "system_matrix",
        3,
        also_at_zero(matrix_inputs, points=(0,)),
        matrix_shape,
        (
            law_of_each("The matrix of (3.5) must be its own transpose.")(asymmetry),
            maps_coefficients_to_data,
        ),
        normal_form=in_units_of_the_kernel,
    ),
    Question(
        "03.3",
        "coefficients",
        3,
        also_at_zero(coefficients_inputs, points=(0,), values=(1,)),
        coefficients_shapes,
        (has_no_moments, interpolates_the_values),
        normal_form=nothing_for_rounding,
    ),
)
