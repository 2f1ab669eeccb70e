"""Questions of notebook 03, radial basis functions.

The laws need the kernel. They compute it as the derivative of s^t at t = 1, by a complex step.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import numpy as np

from fieldcheck.calls import Call, Values, calls_of, integers
from fieldcheck.question import Law, Question, law, law_of_each, relative

STEP = 1e-30
"""The size of the complex step; its square underflows."""


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
    """Return points in the plane, points in space, and the smallest possible number of points."""
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
    )


def in_units_of_the_kernel(call: Call, values: Values) -> Values:
    """Return H with the block of the kernels in a unit in which the points have size one.

    Otherwise the ones would hide what is added to the small kernels, such as 10⁻¹⁰ on the diagonal.
    """
    (h,), (points,) = values, call.arguments
    n, unit = len(points), np.array(h, dtype=float)
    unit[:n, :n] /= min(1.0, float(np.ptp(points)) ** 2)
    return (unit,)


def matrix_shape(call: Call) -> tuple[tuple[int, ...], ...]:
    rows = sum(call.arguments[0].shape) + 1
    return ((rows, rows),)


def is_symmetric(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the largest difference from the transpose."""
    return max(relative(h - h.T, h) for (h,) in values)


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
    return calls_of(
        "coefficients",
        ((plane, random.normal(size=12)), "twelve points in the plane with random values"),
        ((space, random.normal(size=10)), "ten points in space with random values"),
        ((affine, almost), "an affine field with one value changed"),
        (
            (integers(plane, 100), integers(random.normal(size=12))),
            "twelve points and values, integers",
        ),
        ((integers(space, 100), random.normal(size=10)), "ten points in space, integers"),
    )


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


# 03.4 and 03.6 The field and its gradient


def field_inputs(name: str, seed: int) -> tuple[Call, ...]:
    """Return coefficients and evaluation points, some of which are sites."""
    random = np.random.default_rng(seed)
    cases = (
        (8, 2, 5, "points in the plane, two of them centres"),
        (6, 3, 4, "points in space, two of them centres"),
    )
    calls = []
    for n, d, m, case in cases:
        points = cloud(random, n, d)
        x = np.concatenate([random.uniform(-1, 2, (m, d)), points[1:3]])
        x[0, 0], x[1, -1] = points[0, 0], points[3, -1]
        x[2] *= 10  # a point far from all centres
        calls.append(
            Call(name, (points, random.normal(size=n), random.normal(size=d + 1), x), case, (0, 3))
        )
    for call in tuple(calls):
        points, lam, c, x = call.arguments
        whole = integers(points, 100), lam, c, integers(x, 100)
        calls.append(Call(name, whole, f"{call.case}, integers", (0, 3)))
    return tuple(calls)


@law("The field must be an affine function plus λ_j times the kernel at each centre.")
def is_a_sum_of_basis_functions(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the values from those of the field."""
    return max(relative(v - field(*c.arguments), v) for c, (v,) in zip(calls, values, strict=True))


UNIT = 1e-3


def gradient_inputs(seed: int) -> tuple[Call, ...]:
    """Return the inputs of the field, the same fields with all lengths in another unit, and both
    with a large constant, from which difference quotients lose their digits.
    """
    calls = field_inputs("gradient", seed)
    scaled, raised = [], []
    for call in calls:
        points, lam, c, x = call.arguments
        for unit, name in ((UNIT, "a thousandth"), (UNIT**3, "a billionth")):
            slopes = np.append(c[:1], c[1:] / unit)
            case = f"{call.case}, all lengths {name}"
            scaled.append(
                Call("gradient", (unit * points, lam / unit**2, slopes, unit * x), case, (0, 3))
            )
        high = c + 1e4 * (np.arange(c.size) == 0)
        case = call.case + ", a field larger by 10000"
        raised.append(Call("gradient", (points, lam, high, x), case, (0, 3)))
    return (*calls, *scaled, *raised)


@law("For a small step the change of the field must be the gradient times the step.", 1e-5)
def agrees_with_central_differences(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the largest difference between the gradient and central differences."""
    worst = 0.0
    for call, (g,) in zip(calls, values, strict=True):
        points, lam, c, x = call.arguments
        h = 1e-5 * np.ptp(points)
        for k, e in enumerate(h * np.eye(x.shape[1])):
            change = (field(points, lam, c, x + e) - field(points, lam, c, x - e)) / (2 * h)
            worst = max(worst, relative(g[:, k] - change, g))
    return worst


# 03.5 The signs of the eigenvalues


def inertia_inputs(seed: int) -> tuple[Call, ...]:
    """Return points in general position, on a line, with a repeated point, in several units."""
    random = np.random.default_rng(seed)
    plane, space, twice = cloud(random, 9, 2), cloud(random, 8, 3), cloud(random, 6, 2)
    turn = random.uniform(0, np.pi)
    line = 10 * np.outer(cloud(random, 25, 1), [np.cos(turn), np.sin(turn)])
    twice = np.concatenate([twice, twice[:1]])
    cases = (
        (plane, "nine points in the plane"),
        (0.2 * space, "eight points in a small cube"),
        (cloud(random, 4, 1), "four points on the line, in one dimension"),
        (1e-3 * cloud(random, 9, 2), "nine points in a square of 0.001"),
        (2e-5 * cloud(random, 8, 2), "eight points in a square of 0.00002"),
        (1.2e-5 * cloud(random, 8, 3), "eight points in a cube of 0.000012"),
    )
    exact = (
        (line, "twenty-five points on one line of the plane"),
        (twice, "seven points of which two are the same"),
        (100 * twice, "seven points in a square of 100, of which two are the same"),
    )
    return (
        *(Call("inertia", (points,), case) for points, case in cases),
        *(Call("inertia", (points,), case, exact=(0,)) for points, case in exact),
    )


@law(
    "The three numbers must add up to the number of rows. Since the diagonal is zero, the sum of "
    "the eigenvalues is zero, so both signs must occur."
)
def counts_all_and_both_signs(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the number of eigenvalues that are not counted, or one if a sign is missing."""
    lacking = (
        abs(sum(c.arguments[0].shape) + 1 - v[0].sum()) + (v[0][:2] < 1).sum()
        for c, v in zip(calls, values, strict=True)
    )
    return float(max(lacking))


@law_of_each(
    "There must be one zero eigenvalue for each independent affine field that vanishes at all "
    "points, and one for each point that occurs a second time."
)
def is_singular_where_it_must(call: Call, values: Values) -> float:
    """Return the difference between the number of zeros and the dimension of the null space."""
    (counts,) = values
    (points,) = call.arguments
    repeated = len(points) - len(np.unique(points, axis=0))
    flat = points.shape[1] - np.linalg.matrix_rank(points - points[0], tol=1e-9)
    return abs(float(counts[2]) - repeated - flat)


# 03.7 The energy


def energy_inputs(seed: int) -> tuple[Call, ...]:
    """Return values, with an affine field added, tripled, and at scaled and rotated points."""
    random = np.random.default_rng(seed)
    points, values = cloud(random, 10, 2), random.normal(size=10)
    tilt = 2 - points[:, 0] + 3 * points[:, 1]
    turned = 2 * np.stack([points[:, 1], -points[:, 0]], axis=1) + 1
    return calls_of(
        "energy",
        ((points, values), "ten points with random values"),
        ((points, values + tilt), "the same with an affine field added"),
        ((points, 3 * values), "values three times as large"),
        ((turned, values), "points twice as far apart, and rotated"),
        ((integers(points, 100), integers(values)), "ten points and values, integers"),
        ((integers(cloud(random, 9, 2), 100), values[:9]), "nine points, integers"),
    )


@law(
    "Adding an affine field must not change the energy. Three times the values must have nine "
    "times the energy. Points twice as far apart must have a quarter of it."
)
def has_the_bending_energy(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of the energies from e, e, 9e and e/4."""
    e = np.array([v[0] for v in values[:4]])
    return max(relative(e - e[0] * np.array([1, 1, 9, 0.25]), e), float(e[0] <= 0))


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
        matrix_inputs,
        matrix_shape,
        (
            Law("The matrix of (3.5) must be its own transpose.", is_symmetric),
            maps_coefficients_to_data,
        ),
        normal_form=in_units_of_the_kernel,
    ),
    Question(
        "03.3",
        "coefficients",
        3,
        coefficients_inputs,
        coefficients_shapes,
        (has_no_moments, interpolates_the_values),
    ),
    Question(
        "03.4",
        "evaluate",
        2,
        lambda seed: field_inputs("evaluate", seed),
        lambda call: ((len(call.arguments[3]),),),
        (is_a_sum_of_basis_functions,),
    ),
    Question(
        "03.5",
        "inertia",
        2,
        inertia_inputs,
        lambda _: ((3,),),
        (counts_all_and_both_signs, is_singular_where_it_must),
    ),
    Question(
        "03.6",
        "gradient",
        3,
        gradient_inputs,
        lambda call: (call.arguments[3].shape,),
        (agrees_with_central_differences,),
    ),
    Question("03.7", "energy", 2, energy_inputs, lambda _: ((),), (has_the_bending_energy,)),
)
