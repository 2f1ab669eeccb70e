"""Least squares: normal equations of the slides, NumPy, rational arithmetic and refusals."""

import re
from fractions import Fraction

import numpy as np
import pytest
from numpy.polynomial import Chebyshev

from cases import CASES, Case, case
from fieldrecon.datasets.synthetic import halton
from fieldrecon.methods.least_squares import LeastSquares, normal_equations
from fieldrecon.polynomials import EPS, dimension, exponents, monomials
from fieldrecon.selection.leaving_one_out import leave_one_out
from laws import assert_close, refused

EXACT = 1e-10
POINTS = np.random.default_rng(1).random((30, 2))
VALUES = np.exp(POINTS[:, 0]) * np.cos(3 * POINTS[:, 1])
POLYNOMIALS = [c for c in CASES if isinstance(c.method, LeastSquares)]


@pytest.mark.parametrize("case", POLYNOMIALS, ids=lambda case: case.name)
def test_coefficients_equal_the_least_squares_solution_of_numpy(case: Case):
    """c = argmin |Bc - V|² in monomials of the coordinates, by numpy.linalg.lstsq."""
    b = monomials(case.sites, case.method.degree)
    c = np.linalg.lstsq(b, case.data, rcond=None)[0]
    assert_close(case.method.coefficients(case.data) / abs(c).max(), c / abs(c).max(), 1e-8)
    s = case.method.field(case.data)
    assert_close(s(case.queries), monomials(case.queries, case.method.degree) @ c, 1e-8)


def test_the_basis_is_orthonormal_with_an_outlier():
    """Beside a point at 1e5 spacings the others are narrow: what is left of 1 in x must be small.

    Between them the absolute weights sum to 2e5, and constants keep the digits that this leaves.
    """
    points = np.vstack([halton(60, 2), [[3e4, 9e4]]])
    method, x = LeastSquares(points), np.array([[7.5e4, 2e4], [-4e4, 3e4]])
    assert_close(method.field(np.ones(61))(x), np.ones(2), EXACT)
    assert_close(method.weights(x).sum(axis=1), np.ones(2), EXACT)
    assert_close(method.weights(points).sum(axis=1), np.ones(61), 1e-14)


def test_values_beside_a_strip_are_refused_from_where_rounding_decides_them():
    """That is where the absolute weights sum to 1e-4 of what rounds to all; they grow like y^2."""
    strip = np.random.default_rng(5).random((1000, 2)) * [1.0, 1e-6]
    method, beside = LeastSquares(strip, 2), np.array([[0.5, 1e-3]])
    total = np.abs(method.weights(beside)).sum()
    kept, lost = (beside * [1.0, np.sqrt(part / EPS / total)] for part in (2e-5, 5e-4))
    s = method.field(np.ones(1000))
    for values in (s, method.weights):
        assert_close(values(kept).sum(), 1.0, 1e-4)
    for evaluate in (s, s.gradient, s.hessian, method.weights, method.gradient_weights):
        assert np.isfinite(evaluate(kept)).all()
        with refused("rounding decides the value at", np.linalg.LinAlgError):
            evaluate(lost)


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_the_normal_equations_agree_near_the_origin(degree):
    """H_LS c = BᵀV with H_LS = BᵀB, p. 5."""
    method = LeastSquares(POINTS, degree)
    b = monomials(POINTS, degree)
    assert_close(method.matrix(), b.T @ b, 1e-12)
    c = normal_equations(POINTS, VALUES, degree)
    assert_close(method.matrix() @ c, b.T @ VALUES, EXACT)
    assert_close(method.coefficients(VALUES), c, 1e-6)
    arrays = normal_equations(POINTS, np.multiply.outer(VALUES, np.eye(2)), degree)
    assert_close(arrays, np.multiply.outer(c, np.eye(2)), EXACT)


def test_the_matrix_is_formed_wherever_its_entries_are_numbers():
    """In units of 2^-110 the smallest entries, of x^4 times x^4, are of the size 2^-880."""
    unit = 2.0**-110
    h = LeastSquares(POINTS * unit, 4).matrix()
    powers = unit ** exponents(2, 4).sum(axis=1)
    there = LeastSquares(POINTS, 4).matrix()
    assert_close(h / powers / powers[:, None], there, 1e-12)
    with refused("the matrix would leave the range", OverflowError):  # entries of B would not
        LeastSquares(POINTS * 2.0**-130, 4).matrix()


def test_data_that_are_zero_have_coefficients_and_an_objective_of_zero():
    """Neither loses digits, nor has squares too small for numbers."""
    method = LeastSquares(POINTS, 3)
    assert not method.coefficients(np.zeros((30, 2))).any()
    assert not method.objective(np.zeros((30, 2))).any()


def test_the_matrix_has_the_squared_condition_number():
    """cond(BᵀB) = cond(B)²."""
    h = LeastSquares(POINTS, 2).matrix()
    b = monomials(POINTS, 2)
    assert np.linalg.cond(h) == pytest.approx(np.linalg.cond(b) ** 2, rel=1e-8)


def test_far_from_the_origin_only_the_textbook_form_fails():
    """At an offset of 1e6 normal equations have no correct digit.

    The local frame only loses the digits of the points.
    """
    far = POINTS + 1e6
    values = 1 + 2 * POINTS[:, 0] - 3 * POINTS[:, 1] + POINTS[:, 0] ** 2
    exact = values[:5]
    assert_close(LeastSquares(far, 2).field(values)(far[:5]), exact, 1e-9)
    b = monomials(far[:5], 2)
    assert np.abs(b @ normal_equations(far, values, 2) - exact).max() > 1e-2


def test_the_objective_is_half_the_squared_residual():
    """ψ_LS = ½ |Bc - V|², one number per component."""
    method = LeastSquares(POINTS, 2)
    values = np.stack([VALUES, 2 * VALUES], axis=1)
    residual = values - method.field(values)(POINTS)
    assert_close(method.residuals(values), residual, EXACT)
    assert_close(method.objective(values), 0.5 * (residual**2).sum(axis=0), EXACT)
    assert method.objective(VALUES).shape == ()
    assert_close(method.objective(1j * VALUES), method.objective(VALUES), EXACT)


def test_the_residual_is_orthogonal_to_the_polynomials():
    """Bᵀ(V - Bc) = 0: the gradient of ψ_LS vanishes.

    Any other polynomial has a larger objective.
    """
    method = LeastSquares(POINTS, 2)
    b = monomials(POINTS, 2)
    assert_close(b.T @ method.residuals(VALUES), np.zeros(6), EXACT)
    best = method.objective(VALUES)
    for change in np.random.default_rng(2).standard_normal((20, 6)):
        other = VALUES - b @ (method.coefficients(VALUES) + 1e-3 * change)
        assert 0.5 * other @ other > best


def test_leverages_are_the_diagonal_of_the_hat_matrix():
    """They lie between 0 and 1, and their sum is the number of coefficients."""
    method = LeastSquares(POINTS, 2)
    h = method.leverages()
    assert_close(h, np.diagonal(method.weights(POINTS)), EXACT)
    assert h.sum() == pytest.approx(dimension(2, 2))
    assert ((h > 0) & (h < 1)).all()


def test_the_gradient_of_a_linear_fit_is_its_coefficients():
    """∇f_LS = (c₁, ..., c_D) everywhere."""
    method = LeastSquares(POINTS)
    g = method.field(VALUES).gradient(POINTS[:4])
    assert_close(g, np.tile(method.coefficients(VALUES)[1:], (4, 1)), EXACT)


def line_through(x: list[Fraction], y: list[Fraction]) -> tuple[Fraction, Fraction]:
    """Intercept and slope of the least-squares line in rational arithmetic."""
    n, sx, sy = len(x), sum(x), sum(y)
    sxx, sxy = sum(a * a for a in x), sum(a * b for a, b in zip(x, y, strict=True))
    slope = (n * sxy - sx * sy) / (n * sxx - sx * sx)
    return (sy - slope * sx) / n, slope


@pytest.mark.parametrize("offset", [0.0, 1e6, 1e12])
@pytest.mark.parametrize("unit", [1e-150, 1.0, 1e150])
def test_a_line_equals_rational_arithmetic(unit, offset):
    """The relative error is below 1e-13 for any origin and unit."""
    x = (np.array([0.0, 1.0, 2.5, 3.0, 7.0, 11.0]) + offset) * unit
    y = np.array([1.0, -2.0, 0.5, 4.0, 3.0, 8.0])
    intercept, slope = line_through([*map(Fraction, x)], [*map(Fraction, y)])
    s = LeastSquares(x[:, None]).field(y)
    query = x[1] + 3 * (x[2] - x[1])
    expected = float(intercept + slope * Fraction(query))
    assert float(s([query])) == pytest.approx(expected, rel=1e-13)
    assert float(s.gradient([query])[0]) == pytest.approx(float(slope), rel=1e-13)


def test_nearly_collinear_points_reproduce_their_plane():
    """Points within 1e-9 of a line determine a linear polynomial, which is reproduced."""
    rng = np.random.default_rng(3)
    along = rng.random(20)
    p = np.stack([along, 1e-9 * rng.random(20)], axis=1)
    plane = 1 + 2 * p[:, 0] - 3e8 * p[:, 1]
    s = LeastSquares(p).field(plane)
    assert_close(s(p), plane, 1e-12)
    assert_close(s.gradient(p[0]), np.array([2.0, -3e8]), 1e-5)


def test_a_high_degree_in_one_variable_is_accurate():
    """Degree 12 on 50 points."""
    x = np.linspace(0, 1, 50)[:, None]
    s = LeastSquares(x, 12).field(x[:, 0] ** 12)
    assert_close(s([[0.33]]), np.array([0.33**12]), 1e-9)


# --- refusals -------------------------------------------------------------------------------------


def high_degrees():
    """Points and degrees at which the monomials are dependent up to rounding."""
    line = np.linspace(-1, 1, 200)[:, None]
    disc = 2 * halton(700, 2) - 1
    disc = disc[np.linalg.norm(disc, axis=1) < 1]
    ribbon = disc @ [[1.0, 1.0], [1e-3, -1e-3]]
    return [(line, 40), (disc, 16), (ribbon + 100, 8), (2 * halton(300, 3) - 1, 7)]


def test_high_degrees_are_no_trouble():
    """T_k of the degree is reproduced with its slope, T_k of the next is not; nothing is lost."""
    for points, degree in high_degrees():
        m, x = LeastSquares(points, degree), points[::7]
        local = (points[:, 0] - points[:, 0].mean()) / np.abs(np.ptp(points[:, 0]))
        here, slope = Chebyshev.basis(degree), Chebyshev.basis(degree).deriv()
        s = m.field(here(2 * local))
        assert_close(s(x), here(2 * local[::7]), 1e-9)
        expected = np.zeros_like(x)
        expected[:, 0] = slope(2 * local[::7]) * 2 / np.ptp(points[:, 0])
        assert_close(s.gradient(x) / degree**2, expected / degree**2, 1e-7)
        beyond = Chebyshev.basis(degree + 1)(2 * local)
        assert np.abs(m.field(beyond)(points) - beyond).max() > 0.01
        assert_close(m.leverages().sum(), dimension(points.shape[1], degree), 1e-9)


def test_a_high_degree_agrees_with_chebyshev_polynomials():
    """Rough data, by NumPy's least squares in the Chebyshev basis; and each datum left out."""
    points, degree = high_degrees()[0]
    f = np.random.default_rng(3).standard_normal(len(points))
    m, x = LeastSquares(points, degree), np.linspace(-1, 1, 333)
    assert_close(m.field(f)(x[:, None]), Chebyshev.fit(points[:, 0], f, degree)(x), 1e-9)
    residuals = leave_one_out(m, f)
    for i in (0, 1, 99):
        others = np.arange(200) != i
        without = Chebyshev.fit(points[others, 0], f[others], degree, domain=[-1, 1])
        assert_close(residuals[i] / (f[i] - without(points[i, 0])), 1.0, 1e-6)


def test_coefficients_that_cancel_are_refused():
    """At degree 15 they are right, at 40 no digit of the field would be."""
    points, degree = high_degrees()[0]
    f = Chebyshev.basis(degree)(points[:, 0])
    m = LeastSquares(points, 15)
    assert_close(monomials(points, 15) @ m.coefficients(f), m.field(f)(points), 1e-9)
    for unit in (1.0, 1e-30):
        with refused("degree 40 are so large that they cancel: .* field", np.linalg.LinAlgError):
            LeastSquares(points, degree).coefficients(unit * f)


def test_a_degree_that_is_too_high_is_refused_and_the_highest_is_named():
    """A hundred distinct points determine degree 99; the slopes between them are the limit.

    Chebyshev points, where slopes are moderate, take any degree; points too few are to blame.
    """
    line, above = np.linspace(-1, 1, 100), np.cos(np.pi * (np.arange(100) + 0.5) / 100)
    assert LeastSquares(above[:, None], 99).interpolates
    for points in (line[:, None], line[:, None] + 1e6):
        with pytest.raises(np.linalg.LinAlgError, match="degree 95 is too high") as refusal:
            LeastSquares(points, 95)
        last = int(re.search(r"highest degree for them is (\d+)", str(refusal.value))[1])
        assert 2 * np.sqrt(100) < last < 95
        assert_close(LeastSquares(points, last).weights(points).sum(axis=1), np.ones(100), 1e-9)
        with refused(f"degree {last + 1} is too high", np.linalg.LinAlgError):
            LeastSquares(points, last + 1)
    with refused("the points do not determine .* rank 20 of 31", np.linalg.LinAlgError):
        LeastSquares(np.repeat(line[:20, None], 10, axis=0), 30)


def test_the_rank_is_that_of_the_geometry():
    """Of exact curves, by the dimension of the polynomials on them: Hilbert's function."""
    t = np.arange(60.0)
    circle = np.column_stack([np.cos(t), np.sin(t)])
    for points, ranks in (
        (circle, (3, 5, 7, 9, 11)),
        (circle * [1.0, 1e-6] + 1e3, (3, 5)),
        (np.column_stack([t, t % 2]), (3, 5, 7, 9, 11)),
        (np.column_stack([t, t % 3]), (3, 6, 9, 12, 15)),
        (np.outer(t, [1.0, 2.0]) + 1e6, (2, 3, 4, 5, 6)),
    ):
        for degree, rank in enumerate(ranks, 1):
            if rank == dimension(2, degree):
                LeastSquares(points, degree)
                continue
            with refused(rf"degree {degree} in 2 variables: rank {rank} of", np.linalg.LinAlgError):
                LeastSquares(points, degree)


@pytest.mark.parametrize("bad", [-1, 1.0, True, "1", None])
def test_invalid_degrees_are_refused(bad):
    """The degree must be a nonnegative integer."""
    with refused("degree must be an integer, 0 or more; got "):
        LeastSquares(POINTS, bad)


@pytest.mark.parametrize("degree", [1, 2])
def test_too_few_points_are_refused(degree):
    """With fewer points than coefficients the message has the rank."""
    n = dimension(2, degree) - 1
    words = f"the points do not determine a polynomial of degree {degree} in 2 variables"
    with refused(f"{words}: rank {n} of {n + 1}", np.linalg.LinAlgError):
        LeastSquares(POINTS[:n], degree)


def test_one_point_determines_a_constant():
    """It does not determine a linear polynomial."""
    s = LeastSquares([[2.0, 3.0]], 0).field([5.0])
    assert s([[1.0, 1.0]]).tolist() == [5.0]
    assert s.gradient([1.0, 1.0]).tolist() == [0.0, 0.0]
    with refused("rank 1 of 3", np.linalg.LinAlgError):
        LeastSquares([[2.0, 3.0]], 1)


@pytest.mark.parametrize("unit", [1e-200, 1e200])
def test_overflow_of_coefficients_and_matrix_is_refused(unit):
    """In extreme units values and gradients are accurate, but coefficients overflow."""
    method = LeastSquares(POINTS * unit, 2)
    here = LeastSquares(POINTS, 2).field(VALUES)(POINTS)
    assert_close(method.field(VALUES)(POINTS * unit), here, EXACT)
    with refused("the matrix would leave the range of floating-point numbers", OverflowError):
        method.matrix()
    with refused("the coefficients would leave the range of floating-point", OverflowError):
        method.coefficients(VALUES)
    with refused("the matrix would leave the range", OverflowError):
        normal_equations(POINTS * unit, VALUES, 2)


@pytest.mark.parametrize("size", [1e-200, 1e200])
def test_overflow_of_the_objective_is_refused(size):
    """The squares of residuals of size 1e200 or 1e-200 overflow or underflow.

    Zero residuals give zero.
    """
    with refused("the squares of residuals of size .* do not fit", OverflowError):
        LeastSquares(POINTS).objective(size * VALUES)
    assert float(LeastSquares(POINTS).objective(np.zeros(30))) == 0.0


def test_singular_normal_equations_are_refused():
    """BᵀB is singular for points on a line."""
    line = np.outer(np.arange(5.0), [1.0, 2.0])
    with refused("BᵀB is singular", np.linalg.LinAlgError):
        normal_equations(line, np.ones(5))


def test_dense_weights_beyond_the_limit_are_refused():
    """The message has their size and names the alternative."""
    method = LeastSquares(np.random.default_rng(4).random((20_000, 2)))
    x = np.broadcast_to(np.zeros(2), (20_000, 2))
    with refused(r"would take 3\.0 GiB; use field\(values\) or adjoint", MemoryError):
        method.weights(x)
    with refused(r"would take 6\.0 GiB", MemoryError):
        method.gradient_weights(x)
    assert method.field(np.ones(20_000))(x).shape == (20_000,)


def test_an_overflowing_result_is_refused():
    """The message has the query point."""
    s = LeastSquares(POINTS, 2).field(VALUES)
    with refused(r"the result at \(1e\+200, 0\) exceeds the range", OverflowError):
        s([[0.5, 0.5], [1e200, 0.0]])


@pytest.mark.parametrize(
    ("points", "words"),
    [
        (np.zeros((0, 2)), r"at least one point; got the shape \(0, 2\)"),
        (np.zeros((3, 0)), r"must have the shape \(n, d\); got \(3, 0\)"),
        ([0.0, 1.0, 2.0], r"got \(3,\); for one variable write points\[:, None\]"),
        ([[1, 2], [3]], "points must be an array of numbers; its rows differ in length"),
        ([["a", "b"]], "points must be an array of real numbers; got the type <U1"),
        ([[1j, 2]], "points must be an array of real numbers; got the type complex128"),
        ([[None, 2]], "points must be an array of real numbers; got the type object"),
    ],
)
def test_invalid_points_are_refused(points, words):
    """The message says what came and what was wanted."""
    with refused(words):
        LeastSquares(points)


def test_a_scalar_query_is_refused():
    """In one variable queries keep their axis; the message shows how to add it."""
    s = LeastSquares([[0.0], [1.0]]).field([1.0, 2.0])
    with refused(r"x must have 1 coordinate per point.*; got \(\); .* write x\[..., None\]"):
        s(0.5)


def test_as_many_sites_as_coefficients_interpolate():
    assert case("LS as many sites as coefficients, degree 2 in 2-D").method.interpolates
