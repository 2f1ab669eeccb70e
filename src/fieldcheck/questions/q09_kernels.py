"""Questions of notebook 09 on kernels: definite forms, interpolation, Wendland, slopes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fieldcheck.calls import Call, Values
from fieldcheck.inputs.zeros import also_at_zero
from fieldcheck.question import Question, law, law_of_each, relative
from fieldcheck.questions.q03_radial_basis_functions import asymmetry, cloud, squares


def powers(s: np.ndarray, k: int) -> np.ndarray:
    """Return r^k, or r^k log r for even k, from squared distances, without the sign."""
    root = s ** (k / 2)
    return root if k % 2 else root * np.log(s + (s == 0)) / 2


def ridges(points: np.ndarray, degree: int) -> np.ndarray:
    """Return a basis of polynomials without monomials: powers of 1 + a·p, with a on a spiral."""
    j = np.arange((degree + 1) * (degree + 2) // 2)
    spiral = np.sqrt(j) / 2 * np.array([np.cos(2.4 * j), np.sin(2.4 * j)])
    return (1 + points.dot(spiral)) ** degree


# 09.2 The least eigenvalue


def eigenvalue_inputs(seed: int) -> tuple[Call, ...]:
    """Return forms with sufficient, too few, no, linearly dependent, and scaled side conditions.

    The dependent ones are as many as points, or one is zero: for an answer that counts columns, the
    vectors that are left must not depend on rounding.
    """
    random = np.random.default_rng(seed)
    plane, other, few = (3 * cloud(random, n, 2) for n in (9, 8, 6))
    turn = random.uniform(0.2, 1.3)
    line = 3 * np.outer(cloud(random, 3, 1), [np.cos(turn), np.sin(turn)])
    cube, root, plate = (
        powers(squares(plane, plane), 3),
        -powers(squares(other, other), 1),
        powers(squares(line, line), 2),
    )
    uneven = np.array([1.0, 3e-3, 1.0])
    apart = np.zeros((9, 2))
    apart[:4, 0], apart[4:, 1] = random.uniform(1, 2, 4), 2.0**-32 * random.uniform(1, 2, 5)
    whole, sides = random.integers(-9, 10, (6, 6)), random.integers(1, 10, (6, 2))
    turned = np.linalg.qr(random.normal(size=(7, 7)))[0]
    # its rows have one or two entries, so an elimination has no rounding errors
    alike = np.eye(5)[:, :4]
    alike[0, 1], alike[1, 1] = 1.0, 2.0**-35
    form = random.normal(size=(5, 5))
    large = (turned * np.linspace(2e6, 9e6, 7)).dot(turned.T)
    cases = (
        (cube, ridges(plane, 1), "the cubes of nine distances, and linear conditions"),
        (cube, ridges(plane, 0), "the cubes of nine distances, and the constant alone"),
        (root, ridges(other, 0), "minus the distances of eight points, and the constant"),
        (np.exp(-squares(few, few)), np.zeros((6, 0)), "Gaussians, and no conditions"),
        (
            plate,
            ridges(line, 1),
            "thin plates on a line, where the three conditions depend on each other",
        ),
        (cube, ridges(plane, 1) * uneven, "the cubes, with linear conditions in different units"),
        (cube, 1e-9 * ridges(plane, 1), "the cubes, with linear conditions of the size 10⁻⁹"),
        (root, 1e-12 * ridges(other, 0), "minus the distances, with a constant of the size 10⁻¹²"),
        (cube, 1e-12 * ridges(plane, 1), "the cubes, with linear conditions of the size 10⁻¹²"),
        (
            cube,
            apart,
            "the cubes, with conditions of the sizes 1 and 3 · 10⁻¹⁰ on different points",
        ),
        (whole + whole.T, sides, "a symmetric matrix and two conditions, in arrays of integers"),
        (form + form.T, alike, "a symmetric matrix, and two of four conditions 10⁻¹¹ apart"),
        (
            form + form.T,
            np.eye(5)[:, :3] * [1, 1, 2.0**-32],
            "a symmetric matrix, and three conditions, the last of the size 2 · 10⁻¹⁰",
        ),
        (
            cube,
            ridges(plane, 1) * [0, 1, 1],
            "the cubes, with three conditions, the first one zero",
        ),
        (large + large.T, ridges(plane[:7], 1), "a matrix with eigenvalues beyond 10⁶"),
        *more_forms(random, cube, root, plane, other),
    )
    return tuple(Call("least_eigenvalue", (a, p), case) for a, p, case in cases)


def more_forms(
    random: np.random.Generator,
    cube: np.ndarray,
    root: np.ndarray,
    plane: np.ndarray,
    other: np.ndarray,
) -> Iterator[tuple[np.ndarray, np.ndarray, str]]:
    """Yield forms whose least value is zero, other sizes, other types, and small and large ones."""
    for points, words in ((plane, "nine"), (other, "eight")):
        case = f"minus the squares of the distances of {words} points, and the constant"
        yield -squares(points, points), ridges(points, 0), case
    yield symmetric(random, 9), ridges(plane, 1), "another matrix, and the first conditions"
    yield symmetric(random, 8), ridges(other, 0), "a symmetric matrix, and the constant"
    for size, words in ((1e-6, "10⁻⁶"), (1e6, "10⁶")):
        yield size * cube, ridges(plane, 1), f"the cubes in a matrix of the size {words}"
        yield size * root, ridges(other, 0), f"minus the distances in a matrix of the size {words}"
    for n in (6, 7):
        whole = random.integers(-9, 10, (n, n))
        sides = random.integers(1, 10, (n, 2))
        yield whole + whole.T, 0.1 * sides, f"a matrix of {n} rows of integers, and two conditions"
        yield symmetric(random, n), sides, f"a matrix of {n} rows, and two conditions in integers"
    yield cube, np.zeros((9, 2)), "the cubes of nine distances, and two conditions that are zero"
    yield np.array([[-random.uniform(2, 3)]]), np.zeros((1, 0)), "one point, and no conditions"
    yield np.array([[random.uniform(2, 3)]]), np.zeros((1, 0)), "another point, and no conditions"
    yield symmetric(random, 2), np.ones((2, 1)), "two points, and the constant"
    yield symmetric(random, 3), random.normal(size=(3, 2)), "three points, and two conditions"
    for n, m in ((43, 3), (45, 0)):
        yield symmetric(random, n), random.normal(size=(n, m)), f"{n} points, and {m} conditions"


def symmetric(random: np.random.Generator, n: int) -> np.ndarray:
    half = random.normal(size=(n, n))
    return half + half.T


def zero_if_rounding(call: Call, values: Values) -> Values:
    """Return an eigenvalue, or zero if it is far less than the entries of the matrix."""
    (least,) = values
    return (np.where(np.abs(least) < 1e-10 * np.abs(call.arguments[0]).max(), 0.0, least),)


@law(
    "Your number must be the least value of λᵀAλ over all vectors λ of length one that satisfy the "
    "side conditions. Singular values of P of at most 10⁻¹⁰ times the largest one count as zero."
)
def is_where_the_signs_change(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return one if the form minus the number is not positive just below it, or is positive just
    above.
    """
    missed = 0
    for call, (least,) in zip(calls, values, strict=True):
        a, p = call.arguments
        size = np.sqrt((p**2).sum(axis=0))
        p = p / np.where(size > 0, size, 1)
        conditions = int(np.linalg.matrix_rank(p, tol=1e-8)) if p.size else 0
        largest = np.abs(a).max()
        a, least = a / largest, least / largest
        for shift, more in ((least - 1e-7, False), (least + 1e-7, True)):
            corner = np.zeros((p.shape[1],) * 2)
            bordered = np.vstack(
                [np.hstack([a - shift * np.eye(len(a)), p]), np.hstack([p.T, corner])]
            )
            spectrum = np.linalg.eigvalsh(bordered)
            negative = int((spectrum < -1e-12 * np.abs(spectrum).max()).sum())
            missed += (negative > conditions) != more
    return float(missed)


# 09.4 The field


def ring(random: np.random.Generator, n: int, radius: float) -> np.ndarray:
    """Return n points on a circle, nearly evenly spaced.

    Their saddle-point matrix is regular also for a degree that is too low.
    """
    angle = 2 * np.pi * (np.arange(n) + random.uniform(-0.1, 0.1, n)) / n
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


UNISOLVENT = np.array([[0, 0], [1, 0], [0, 1], [1, 1], [0.5, -0.6], [-0.6, 0.5]])
"""The first one, three and six of these points are unisolvent for the degrees 0, 1 and 2."""


def field_inputs(seed: int) -> tuple[Call, ...]:
    """Return values for several powers and degrees, also too low ones, and integers; the last
    evaluation points are the sites.
    """
    random = np.random.default_rng(seed)
    cases = (
        (12, 3, 1, "twelve points, cubes and the degree 1"),
        (10, 2, 2, "ten points, thin plates and the degree 2"),
        (9, 1, 0, "nine points, k = 1 and the degree 0"),
        (14, 5, 2, "fourteen points, k = 5 and the degree 2"),
        (8, 2, 1, "values of a linear function"),
        (16, 3, 3, "sixteen points, cubes and the degree 3"),
        (18, 4, 3, "eighteen points, k = 4 and the degree 3"),
    )
    calls = []
    for n, k, degree, case in cases:
        shift = 0.4 if k == 5 else 0
        points = cloud(random, n, 2) - shift
        values = (
            random.normal(size=n)
            if n > 8
            else 1 - 2 * points[:, 0] + random.normal() * points[:, 1]
        )
        x = np.concatenate([random.uniform(-0.3, 1.3, (24, 2)) - shift, points])
        calls.append(Call("interpolate", (points, values, k, degree, x), case))
    lattice = random.permutation(np.argwhere(np.ones((9, 9), dtype=bool)))
    sites, heights = lattice[:10], random.integers(-9, 10, 10)
    x = np.concatenate([lattice[10:34] * 2 - 4, sites])
    few, five = cloud(random, 11, 2), ring(random, 5, 2.0)
    for points, k, degree, case in (
        (few, 1, -1, "eleven points, k = 1 and no polynomial"),
        (five, 2, 0, "five points, k = 2 and the degree 0"),
    ):
        away = np.concatenate([2 * random.uniform(-1, 1, (24, 2)), points])
        values = random.normal(size=len(points))
        calls.append(Call("interpolate", (points, values, k, degree, away), case))
    return (
        *calls,
        Call("interpolate", (sites, heights, 3, 1, x), "ten points of integers"),
        *more_fields(random, calls[0], calls[1]),
        *stars(random),
    )


def more_fields(random: np.random.Generator, *calls: Call) -> Iterator[Call]:
    """Yield variants of calls, and few, many, equal and integer values, in several units."""
    name = "interpolate"
    for call in calls:
        points, values, k, degree, x = call.arguments
        n = len(points)
        elsewhere = np.concatenate([random.uniform(-0.3, 1.3, (24, 2)), points])
        moved = points + random.uniform(-0.02, 0.02, (n, 2))
        for sites, given, at, words in (
            (points, random.normal(size=n), x, "other values"),
            (points, values, elsewhere, "other evaluation points"),
            (moved, values, np.concatenate([x[:-n], moved]), "other points"),
            (points, np.full(n, random.uniform(1, 3)), x, "equal values"),
            (points, random.permutation(n) - 3, x, "values in an array of integers"),
        ):
            yield Call(name, (sites, given, k, degree, at), f"{call.case}, {words}")
        yield Call(name, (points, values, 1, degree, x), f"{call.case}, k = 1 instead")
        other = 3 - degree
        yield Call(name, (points, values, k, other, x), f"{call.case}, the degree {other} instead")
    for n, k, degree in ((1, 1, 0), (4, 3, 0), (3, 2, 1), (3, 3, 1), (6, 3, 2)):
        points = 2 * UNISOLVENT[:n] + random.uniform(-0.2, 0.2, (n, 2))
        x = np.concatenate([random.uniform(-1, 3, (24, 2)), points])
        case = f"k = {k}, the degree {degree}, number of points: {n}"
        yield Call(name, (points, random.normal(size=n), k, degree, x), case)
    for size, n, k, degree in (
        *((0.05, 11, 3, 1), (0.05, 12, 2, 1), (100, 11, 3, 1)),
        *((300, 12, 3, 1), (300, 12, 5, 2)),  # a default tolerance would cut singular values
    ):
        points = cloud(random, n, 2)
        x = np.concatenate([random.uniform(-0.3, 1.3, (24, 2)), points])
        case = f"{n} points in a box of {size}, k = {k} and the degree {degree}"
        yield Call(name, (size * points, random.normal(size=n), k, degree, size * x), case)
    for k, degree in ((3, 1), (5, 2)):
        points = cloud(random, 12, 2)
        x = np.concatenate([random.uniform(-0.3, 1.3, (24, 2)), points])
        case = f"values of the size 10⁻¹⁵, k = {k} and the degree {degree}"
        yield Call(name, (points, 1e-15 * random.normal(size=12), k, degree, x), case)
    for n, m, case in ((43, 24, "43 points"), (12, 69, "69 evaluation points")):
        points = cloud(random, n, 2)
        x = np.concatenate([random.uniform(-0.3, 1.3, (m - n * (m > 99), 2)), points])
        yield Call(
            name, (points, random.normal(size=n), 1, 0, x), f"{case}, k = 1 and the degree 0"
        )


def stars(random: np.random.Generator) -> Iterator[Call]:
    """Yield points around another one, whose row of A is zero because log 1 is.

    The matrix of the whole system is regular, also for the least degree that the order of k allows:
    a wrong degree leads to wrong values. With a sixth point there is one other entry in the row.
    """
    star = np.array([[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1], [1, 1]], dtype=float)
    for n, k, degree, words in (
        (3, 2, 0, "two points at distance 1 from another one"),
        (4, 2, 1, "three points at distance 1 from another one"),
        (5, 2, 1, "four points at distance 1 from another one"),
        (6, 4, 1, "four of five points at distance 1 from another one"),
    ):
        points = random.permutation(star[:n]) + random.integers(-3, 4, 2)
        x = np.concatenate([points[0] + random.uniform(-2, 2, (24, 2)), points])
        case = f"{words}, k = {k}, degree {degree}"
        yield Call("interpolate", (points, random.normal(size=n), k, degree, x), case, exact=(0,))


# a solution that is cut off misses the values a little, and the side conditions by much more
@law_of_each("The field must go through the values.", 1e-6)
def interpolates_the_values(call: Call, values: Values) -> float:
    (points, wanted, *_), (f,) = call.arguments, values
    return relative(f[-len(points) :] - wanted, wanted)


@law_of_each(
    "The field must be a sum of kernels at the points and a polynomial of the given degree. The "
    "coefficients of the kernels must satisfy the side conditions.",
    1e-6,
)
def is_kernels_and_a_polynomial(call: Call, values: Values) -> float:
    """Return the deviation of the field from its form, and of the coefficients from the side
    conditions.
    """
    (f,) = values
    points, wanted, k, degree, place = call.arguments
    columns = np.column_stack([powers(squares(place, points), k), ridges(place, degree)])
    size = np.linalg.norm(columns, axis=0)
    size = np.where(size > 0, size, 1)
    found = np.linalg.lstsq(columns / size, f)[0] / size
    moments = ridges(points, degree).T.dot(found[: len(points)])
    largest = max(np.abs(found[: len(points)]).max(), np.abs(wanted).max())
    return max(relative(columns.dot(found) - f, f), relative(moments, largest))


# 09.5 Wendland's functions


def wendland_inputs(seed: int) -> tuple[Call, ...]:
    """Return distances beyond the support, with 0 and 1 among them, for several dimensions."""
    random = np.random.default_rng(seed)
    cases = ((3, 0), (3, 1), (1, 0), (2, 1), (5, 1), (4, 0))
    calls = []
    for d, s in cases:
        r = np.concatenate([[0, 1], random.random(6), 1 + random.random(2) * [1, 30]])
        shaped, words = (r.reshape(2, 5), "a matrix of distances, ") if d == 5 else (r, "")
        calls.append(Call("wendland", (shaped, d, s), f"{words}D = {d} and s = {s}"))
    r = calls[0].arguments[0]
    shapes = ((69,), (9, 31), (2, 3, 4))
    many = (np.append(0.0, random.uniform(0, 1.2, np.prod(n) - 1)).reshape(n) for n in shapes)
    for distances, d, s, words in (
        (r, 1, 0, "the first distances"),
        (r, 3, 1, "the first distances"),
        (r[::-1], 3, 0, "the first distances in reverse order"),
        (r[::-1], 3, 1, "the first distances in reverse order"),
        (random.permutation(4), 2, 1, "distances in an array of integers"),
        (random.permutation(5), 3, 0, "distances in an array of integers"),
        (random.uniform(0, 1, 1), 3, 1, "one distance"),
        (random.uniform(0, 1, (1, 1)), 2, 0, "one distance in a matrix"),
        (next(many), 3, 1, "69 distances"),
        (next(many), 1, 0, "a matrix of 9 times 31 distances"),
        (next(many), 5, 1, "distances of the shape (2, 3, 4)"),
    ):
        calls.append(Call("wendland", (distances, d, s), f"{words}, D = {d} and s = {s}"))
    return tuple(calls)


@law_of_each("The function for s = 0 must be the power of 1 − r in (9.8), and zero beyond 1.")
def is_a_power(call: Call, values: Values) -> float:
    """Return the deviation from the power for s = 0."""
    (r, d, s), (f,) = call.arguments, values
    return 0.0 if s else relative(f - (1 - np.minimum(r, 1)) ** (d // 2 + 1), 1.0)


@law_of_each(
    "The function for s = 1 must be the integral (9.9) of that for s = 0 in D + 2 variables, and 1 "
    "at zero."
)
def is_an_integral(call: Call, values: Values) -> float:
    """Return the deviation for s = 1 from the integral by Gauss quadrature."""
    (r, d, s), (f,) = call.arguments, values
    wanted = _area_beyond(np.minimum(r, 1), d) / _area_beyond(np.array(0.0), d)
    return relative(f - wanted, 1.0) if s else 0.0


def _area_beyond(start: np.ndarray, d: int) -> np.ndarray:
    """Return twice the integral (9.9) without its factor, by Gauss quadrature."""
    node, weight = np.polynomial.legendre.leggauss(8)
    t = start[..., None] + (1 - start[..., None]) * (1 + node) / 2
    return (t * (1 - t) ** (d // 2 + 2)).dot(weight) * (1 - start)


# 09.7 Values and slopes


def slope_inputs(seed: int) -> tuple[Call, ...]:
    random = np.random.default_rng(seed)
    cases = ((4, "four points"), (3, "three points"), (2, "two points"))
    calls = tuple(
        Call("slope_matrix", (3 * random.permutation(cloud(random, n, 1)[:, 0]) - 1,), case)
        for n, case in cases
    )
    return (
        *calls,
        Call("slope_matrix", (random.permutation(np.arange(4)) ** 2 - 5,), "four integers"),
        Call("slope_matrix", (random.permutation(np.arange(5)) * 3 - 7,), "five integers"),
        Call("slope_matrix", (random.normal(size=1),), "one point"),
        Call("slope_matrix", (np.array([-random.uniform(2, 3)]),), "another point"),
        Call("slope_matrix", (3 * cloud(random, 4, 1)[:, 0],), "four other points"),
        Call("slope_matrix", (1e-3 * cloud(random, 4, 1)[:, 0],), "four points 10⁻³ apart"),
        Call("slope_matrix", (1e3 * cloud(random, 4, 1)[:, 0],), "four points 10³ apart"),
        Call("slope_matrix", (1e3 * cloud(random, 3, 1)[:, 0],), "three points 10³ apart"),
        Call(
            "slope_matrix", (9 * random.permutation(cloud(random, 11, 1)[:, 0]),), "eleven points"
        ),
    )


def slope_shape(call: Call) -> tuple[tuple[int, ...], ...]:
    rows = 2 * len(call.arguments[0]) + 2
    return ((rows, rows),)


@law_of_each(
    "Every number on the diagonal must be zero: φ(0), φ″(0), and the last two by (9.12).", 1e-12
)
def has_a_zero_diagonal(_: Call, values: Values) -> float:
    (matrix,) = values
    return relative(np.diag(matrix), 1.0)


@law(
    "The matrix times the unknowns must be the values of the field (9.11) at the "
    "points, its slopes there, and the two side conditions.",
    1e-6,
)
def maps_to_values_and_slopes(calls: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of H times unknowns from values, central differences and moments."""
    worst, h = 0.0, 1e-7
    for call, (matrix,) in zip(calls, values, strict=True):
        (x,) = call.arguments
        n = len(x)
        lam, mu, c = np.cos(np.arange(n)), np.sin(1.0 + np.arange(n)), np.array([0.7, -1.3])

        def field(t: np.ndarray, x=x, lam=lam, mu=mu, c=c) -> np.ndarray:  # type: ignore[no-untyped-def]
            z = np.subtract.outer(t, x)
            return (
                powers(z**2, 3).dot(lam) - (3 * z**2 * np.sign(z)).dot(mu) + np.polyval(c[::-1], t)
            )

        slopes = (field(x + h) - field(x - h)) / (2 * h)
        wanted = np.concatenate([field(x), slopes, [lam.sum(), (lam * x + mu).sum()]])
        worst = max(worst, relative(matrix.dot(np.concatenate([lam, mu, c])) - wanted, wanted))
    return worst


QUESTIONS = (
    Question(
        "09.2",
        "least_eigenvalue",
        3,
        eigenvalue_inputs,
        lambda _: ((),),
        (is_where_the_signs_change,),
        tolerance=lambda _: 1e-8,
        normal_form=zero_if_rounding,
    ),
    Question(
        "09.4",
        "interpolate",
        4,
        also_at_zero(field_inputs, points=(0, 4), values=(1,)),
        lambda call: ((len(call.arguments[4]),),),
        (interpolates_the_values, is_kernels_and_a_polynomial),
        tolerance=lambda _: 1e-8,
    ),
    Question(
        "09.5",
        "wendland",
        2,
        wendland_inputs,
        lambda call: (call.arguments[0].shape,),
        (is_a_power, is_an_integral),
    ),
    Question(
        "09.7",
        "slope_matrix",
        3,
        also_at_zero(slope_inputs, numbers=(0,)),
        slope_shape,
        (
            law_of_each("The matrix must be symmetric.")(asymmetry),
            has_a_zero_diagonal,
            maps_to_values_and_slopes,
        ),
    ),
)
