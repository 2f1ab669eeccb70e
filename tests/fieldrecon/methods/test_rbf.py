"""Radial basis functions: SciPy, the matrix of the slides, energies, and 500 digits."""

from functools import partial
from unittest import mock

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, RBFInterpolator

import high_precision
from cases import CASES, KERNELS, SITES, Case, case
from fieldrecon import reconstruction
from fieldrecon._numerics.far_queries import LOST, error_of_weights
from fieldrecon._numerics.saddle_point import SaddlePoint
from fieldrecon.datasets.synthetic import franke, halton
from fieldrecon.kernels.conditionally_positive_definite import (
    multiquadric,
    polyharmonic,
    thin_plate_spline,
)
from fieldrecon.kernels.positive_definite import gaussian, inverse_multiquadric, wendland
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods import solvability
from fieldrecon.methods.functionals import values_at
from fieldrecon.methods.hermite import HermiteRBF
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.rbf import RBF
from fieldrecon.polynomials import EPS, dimension, monomials
from fieldrecon.selection.leaving_one_out import leave_one_out
from laws import assert_close, assert_obeyed, refused

EXACT = 1e-10
RBFS = [c for c in CASES if isinstance(c.method, RBF)]
POINTS = np.random.default_rng(1).random((40, 2))
VALUES = np.cos(POINTS @ [3.0, 2.0])
QUERIES = np.random.default_rng(2).random((20, 2)) * 1.2 - 0.1


# --- the slides' system ---------------------------------------------------------------------------


def coefficients_solve_the_saddle_point_system(case: Case) -> None:
    """H_RBF (λ, c) = (f, 0) and f(x) = b(x)ᵀc + Σ λ φ(|x - p|), p. 11 to 13."""
    m = case.method
    lam, c = m.coefficients(case.data)
    right = np.concatenate([case.data, np.zeros(len(c))])
    h = m.matrix()
    size = max(1.0, np.abs(lam).max())
    assert_close(h @ np.concatenate([lam, c]) / size, right / size, 1e-9)
    s = m.kernel(distances(case.queries, m.points, m.metric)) @ lam
    s += monomials(case.queries, m.degree) @ c
    assert_close(m.field(case.data)(case.queries), s, 1e-8 * size)


def the_matrix_has_n_positive_and_q_negative_eigenvalues(case: Case) -> None:
    """H_RBF must be symmetric with inertia (N, D + 1, 0). It is indefinite, contrary to p. 12."""
    m = case.method
    h = m.matrix()
    assert_close(h, h.T, 0.0)
    values = np.linalg.eigvalsh(h)
    q = dimension(case.d, m.degree)
    assert ((values > 0).sum(), (values < 0).sum()) == (case.n, q)


def the_energy_equals_that_of_the_data(case: Case) -> None:
    """λᵀAλ = λᵀf - smoothing |λ|² ≥ 0, because λ is orthogonal to the polynomials."""
    m = case.method
    lam, _ = m.coefficients(case.data)
    a = m.kernel(distances(m.points, m.points, m.metric))
    energy = lam @ case.data - m.smoothing * lam @ lam
    assert energy > 0
    assert lam @ a @ lam == pytest.approx(energy, rel=1e-6)


RBF_LAWS = [
    coefficients_solve_the_saddle_point_system,
    the_matrix_has_n_positive_and_q_negative_eigenvalues,
    the_energy_equals_that_of_the_data,
]


def distances(x: np.ndarray, p: np.ndarray, metric: np.ndarray | None = None) -> np.ndarray:
    matrix = np.eye(x.shape[1]) if metric is None else metric
    offset = x[:, None, :] - p
    return np.sqrt(np.einsum("ijk,kl,ijl->ij", offset, matrix, offset))


@pytest.mark.parametrize("case", RBFS, ids=lambda case: case.name)
def test_every_case_obeys_the_formulas_of_the_slides(case):
    """The matrix refers to the original coordinates; the library computes in a local frame."""
    assert_obeyed(RBF_LAWS, case, case.name)


class SmoothingTwice(RBF):
    """Adds the smoothing to a matrix that contains it already."""

    def matrix(self):
        h = super().matrix()
        n = len(self.points)
        h[range(n), range(n)] += 0.1
        return h


class SideConditionsForgotten(RBF):
    """Fits the polynomial first, so λ is not orthogonal to the polynomials."""

    def matrix(self):
        h = super().matrix()
        n = len(self.points)
        h[n:, :n] = 0.0
        return h

    def coefficients(self, values):
        c = LeastSquares(self.points, self.degree).coefficients(values)
        rest = values - monomials(self.points, self.degree) @ c
        return np.linalg.solve(self.kernel(distances(self.points, self.points)), rest), c


@pytest.mark.parametrize(
    ("law", "mutant"),
    [
        (coefficients_solve_the_saddle_point_system, SmoothingTwice),
        (the_matrix_has_n_positive_and_q_negative_eigenvalues, SideConditionsForgotten),
        (the_energy_equals_that_of_the_data, SideConditionsForgotten),
    ],
)
def test_the_law_rejects_the_mutant(law, mutant):
    """A wrong system violates the law that it was written for."""
    wrong = Case(mutant.__name__, lambda p, _: mutant(p, thin_plate_spline()), 2, SITES[2])
    with pytest.raises(AssertionError):
        law(wrong)


def test_the_smallest_example_has_determinant_minus_one():
    """For (0,0), (1,0), (0,1) and r² log r², det H = -1. So H is not positive definite."""
    h = RBF([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], thin_plate_spline()).matrix()
    assert np.linalg.det(h) == pytest.approx(-1.0)


def test_the_kernel_matrix_may_be_zero():
    """On an equilateral triangle of side one r² log r² vanishes.

    With polynomials the system is solvable.
    """
    triangle = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.75**0.5]])
    m = RBF(triangle, thin_plate_spline())
    assert_close(m.matrix()[:3, :3], np.zeros((3, 3)), 1e-15)
    assert_close(m.field([1.0, 2.0, 5.0])(triangle), np.array([1.0, 2.0, 5.0]), 1e-14)


# --- SciPy ----------------------------------------------------------------------------------------

REFERENCES = {
    "thin_plate_spline": (thin_plate_spline(), 1.0, 2.0),
    "linear": (polyharmonic(1), 1.0, 1.0),
    "cubic": (polyharmonic(3), 1.0, 1.0),
    "quintic": (polyharmonic(5), 1.0, 1.0),
    "multiquadric": (multiquadric(0.25), 4.0, 1.0),
    "inverse_multiquadric": (inverse_multiquadric(0.25), 4.0, 1.0),
    "inverse_quadratic": (inverse_square(0.25), 4.0, 16.0),
    "gaussian": (gaussian(0.25), 4.0, 1.0),
}


@pytest.mark.parametrize("smoothing", [0.0, 1e-3, 1.0])
@pytest.mark.parametrize("raised", [0, 1])
@pytest.mark.parametrize("name", REFERENCES)
def test_fields_equal_those_of_scipy(name, raised, smoothing):
    """SciPy's r² log r is half of ours, and its 1/(1 + (4r)²) a sixteenth."""
    kernel, epsilon, factor = REFERENCES[name]
    degree = kernel.order - 1 + raised
    ours = RBF(POINTS, kernel, degree, factor * smoothing).field(VALUES)
    theirs = RBFInterpolator(
        POINTS, VALUES, kernel=name, epsilon=epsilon, degree=degree, smoothing=smoothing
    )
    assert_close(ours(QUERIES), theirs(QUERIES), 1e-8)


@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_cubic_rbf_equals_scipy_s_natural_spline(offset):
    """r³ with linear polynomials in 1-D is the natural cubic spline between the data."""
    x = np.sort(np.random.default_rng(3).random(12))
    y = np.sin(7 * x)
    s = RBF(x[:, None] + offset, polyharmonic(3)).field(y)
    spline = CubicSpline(x, y, bc_type="natural")
    inside = np.linspace(x[0], x[-1], 101)
    tolerance = 1e-11 + 1e-13 * offset
    assert_close(s(inside[:, None] + offset), spline(inside), tolerance)
    assert_close(s.gradient(inside[:, None] + offset)[:, 0], spline(inside, 1), 100 * tolerance)


def test_outside_the_data_the_cubic_rbf_is_linear():
    """A natural spline has no curvature there. SciPy's CubicSpline continues as a cubic instead."""
    x = np.sort(np.random.default_rng(3).random(12))
    s = RBF(x[:, None], polyharmonic(3)).field(np.sin(7 * x))
    far = np.array([[2.0], [3.0], [4.0]])
    assert_close(np.diff(s(far), 2), np.zeros(1), 1e-10)
    assert_close(s.gradient(far), np.tile(s.gradient([[x[-1]]]), (3, 1)), 1e-10)


def test_the_energy_of_the_spline_is_the_integral_of_its_curvature():
    """∫ s''² = 12 λᵀAλ = 12 λᵀf; the integral uses SciPy's piecewise polynomial."""
    x = np.sort(np.random.default_rng(3).random(12))
    y = np.sin(7 * x)
    lam, _ = RBF(x[:, None], polyharmonic(3)).coefficients(y)
    curvature = CubicSpline(x, y, bc_type="natural").derivative(2)
    nodes, weights = np.polynomial.legendre.leggauss(2)  # exact for s''², a parabola on each piece
    left, h = x[:-1, None], np.diff(x)[:, None]
    integral = np.sum(curvature(left + h * (nodes + 1) / 2) ** 2 * weights * h / 2)
    assert 12 * lam @ y == pytest.approx(integral, rel=1e-10)


# --- polynomials, gradients, smoothing ------------------------------------------------------------


@pytest.mark.parametrize("name", KERNELS)
def test_polynomial_data_give_zero_kernel_coefficients(name):
    """λ = 0 and the coefficients c of the polynomial solve the system."""
    kernel = KERNELS[name](1.0)
    m = RBF(POINTS, kernel, max(kernel.order - 1, 1))
    lam, c = m.coefficients(1 + 2 * POINTS[:, 0] - 3 * POINTS[:, 1])
    assert_close(lam / max(1, abs(m.inverse_diagonal()).max()), np.zeros(40), 1e-12)
    assert_close(c[:3], np.array([1.0, 2.0, -3.0]), 1e-8)


def test_the_far_field_grows_no_faster_than_the_polynomial():
    """With side conditions s(R)/R is bounded. r² log r² alone would grow much faster.

    At 1e6 extents rounding has an error of a tenth in a constant: no value is returned; and from
    1e11 on, in the sum of the weights.
    """
    s = RBF(POINTS, thin_plate_spline()).field(VALUES)
    far = 10.0 ** np.arange(2, 5)[:, None] * np.array([0.6, 0.8])
    growth = np.abs(s(far)) / np.linalg.norm(far, axis=1)
    assert growth.max() < 20
    assert growth[-1] < 2 * growth[0]
    m, x = s.method, np.array([0.6, 0.8])
    of_weights = (m.weights, m.gradient_weights, partial(m.adjoint, f=[1.0]))
    units = 1.0, 1e-9, 1e9, [[1e-9, 0.0]]  # of the data, or of each of their components
    of_data = [m.field(unit * VALUES[:, None]) for unit in units]
    for distance, evaluations in ((1e6, (*of_data, s.gradient)), (1e12, of_weights)):
        for evaluate in evaluations:
            with pytest.raises(np.linalg.LinAlgError, match="rounding decides the value"):
                evaluate(distance * x)
    with pytest.raises(np.linalg.LinAlgError, match="rounding decides the value"):
        RBF(POINTS, multiquadric(0.25)).field(VALUES)(1e14 * x)


@pytest.mark.parametrize(("width", "lost"), [(1e-3, False), (1e-6, True)])
def test_values_beside_a_diagonal_strip_are_refused_where_rounding_decides_them(width, lost):
    """Also in the box of the sites: the weights grow like the inverse square of the width."""
    along, across = np.random.default_rng(0).random((2, 60)) - 0.5
    strip = np.stack([along - width * across, along + width * across], axis=1)
    m = RBF(strip, thin_plate_spline(), 2)
    rough, beside = np.random.default_rng(1).choice([-1.0, 1.0], 60), [[0.4, -0.4]]
    if lost:
        with refused("rounding decides the value at", np.linalg.LinAlgError):
            m.field(rough)(beside)
    else:
        increase = m.field(rough + 1)(beside) - m.field(rough)(beside)
        assert_close(increase, np.ones(1), LOST)


def test_rough_data_of_a_flat_kernel_are_refused_at_every_query():
    """Nowhere is a constant more certain than at the sites; distance is named as a cause far away.

    At one site in four rounding is small by chance; alone, they are refused like all together.
    """
    rng = np.random.default_rng(1)
    m = RBF(rng.random((400, 2)), multiquadric(0.25))
    rough, smooth = m.field(rng.normal(size=400)), m.field(m.points.sum(axis=1))
    words = "the value at .* and of .* at the points; the kernel is too flat for points this close"
    for x in (m.points, [0.3, 0.3], *m.points[:100]):
        with refused(words, np.linalg.LinAlgError):
            rough(x)
    with refused("rounding decides the value at .* so far from the points", np.linalg.LinAlgError):
        rough([[1e9, 2.0]])
    assert_close(smooth(m.points), m.points.sum(axis=1), 1e-8)


def test_weights_are_no_better_than_their_own_rounding():
    """They are lost where they are as large as 1e13, though their sum be one by chance."""
    size = np.array([1.0, 1e10, 1e13])
    error = error_of_weights(np.ones(3), size)
    assert_close(error / size, np.full(3, EPS), 1e-30)
    assert (error > LOST).tolist() == [False, False, True]
    assert_close(error_of_weights(np.array([0.5, 1.0, 2.0]), np.ones(3)), [0.5, 0.0, 1.0], 1e-15)


def test_the_gradient_is_continuous_at_the_sites():
    """∇φ = 2y(1 + log|y|²) → 0 for y → 0."""
    s = RBF(POINTS, thin_plate_spline()).field(VALUES)
    direction = np.array([0.6, 0.8])
    for step, change in ((1e-6, 1e-2), (1e-9, 1e-5), (1e-12, 1e-8)):
        assert_close(s.gradient(POINTS[:5] + step * direction), s.gradient(POINTS[:5]), change)


@pytest.mark.parametrize(
    "kernel", [polyharmonic(1), KERNELS["exponential"](1.0), wendland(3, 0, 0.8)], ids=repr
)
def test_a_gradient_that_does_not_exist_is_refused(kernel):
    """At a site -r, e^(-r) and (1 - r)² have no gradient. Near the site they have one."""
    m = RBF(POINTS, kernel)
    s = m.field(VALUES)
    assert np.isfinite(s.gradient(POINTS[:2] + 1e-9)).all()
    words = rf"has no gradient at a site, and the query \({POINTS[1, 0]:.6g}, "
    for evaluate in (s.gradient, m.gradient_weights):
        with refused(words):
            evaluate([[0.5, 0.5], POINTS[1]])
    assert_close(s(POINTS[1]), VALUES[1], 1e-12)


def test_second_derivatives_at_a_site_are_refused_where_they_do_not_exist():
    """r^2 log r^2 has none at a site; those of r^3 are continuous there."""
    s = RBF(POINTS, thin_plate_spline()).field(VALUES)
    assert np.isfinite(s.hessian(POINTS[:2] + 1e-9)).all()
    for ask in (s.hessian, s.laplacian):
        with refused(rf"has no second derivatives at a site, and the query \({POINTS[1, 0]:.6g}, "):
            ask([[0.5, 0.5], POINTS[1]])
    s = RBF(POINTS, polyharmonic(3)).field(VALUES)
    beside = s.hessian(POINTS[:5] + 1e-9)
    assert_close(s.hessian(POINTS[:5]), beside, 1e-5 * np.abs(beside).max())


def test_smoothing_minimizes_misfit_and_energy():
    """The minimum of |s(p) - f|² + smoothing λᵀAλ satisfies f - s(p) = smoothing λ.

    With more smoothing the energy decreases and the misfit increases.
    """
    energies, misfits = [], []
    for smoothing in (0.0, 1e-3, 1e-1, 10.0):
        m = RBF(POINTS, thin_plate_spline(), smoothing=smoothing)
        lam, _ = m.coefficients(VALUES)
        residual = VALUES - m.field(VALUES)(POINTS)
        assert_close(residual, smoothing * lam, 1e-10)
        energies.append(lam @ VALUES - smoothing * lam @ lam)
        misfits.append(residual @ residual)
    assert energies == sorted(energies, reverse=True)
    assert misfits == sorted(misfits)


def test_large_smoothing_gives_the_least_squares_polynomial():
    s = RBF(POINTS, thin_plate_spline(), smoothing=1e12).field(VALUES)
    assert_close(s(QUERIES), LeastSquares(POINTS).field(VALUES)(QUERIES), 1e-9)


def test_with_smoothing_sites_may_coincide():
    """The field is that of the mean values with half the smoothing."""
    twice = np.concatenate([POINTS, POINTS])
    s = RBF(twice, thin_plate_spline(), smoothing=2e-3).field(np.append(VALUES + 1, VALUES - 1))
    once = RBF(POINTS, thin_plate_spline(), smoothing=1e-3).field(VALUES)
    assert_close(s(QUERIES), once(QUERIES), 1e-10)


# --- accuracy against 500 digits ------------------------------------------------------------------

FEW = np.random.default_rng(5).random((14, 2))
IN_DIGITS = {
    "thin plate": (thin_plate_spline(), high_precision.thin_plate),
    "-r": (polyharmonic(1), high_precision.minus_distance),
    "r³": (polyharmonic(3), high_precision.cube),
    "multiquadric": (multiquadric(0.2), high_precision.multiquadric(0.2)),
    "gaussian": (gaussian(0.2), high_precision.gaussian(0.2)),
}


AWAY = 2.0**20
WHERE_AND_HOW_SMOOTH = [
    (0.0, 0.0),
    (AWAY, 1e-3),
    *(pytest.param(*pair, marks=pytest.mark.slow) for pair in [(0.0, 1e-3), (AWAY, 0.0)]),
    *(pytest.param(offset, 1e3, marks=pytest.mark.slow) for offset in (0.0, AWAY)),
]


@pytest.mark.slow
@pytest.mark.parametrize(("offset", "smoothing"), WHERE_AND_HOW_SMOOTH)
@pytest.mark.parametrize("name", IN_DIGITS)
def test_values_and_gradients_are_accurate(name, offset, smoothing):
    """The queries are between sites, at a distance of 1e-9 from a site, and at the site.

    The origin may be a million away.
    """
    kernel, reference = IN_DIGITS[name]
    points, values = FEW + offset, np.cos(FEW @ [3.0, 2.0])
    m = RBF(points, kernel, smoothing=smoothing)
    s = m.field(values)
    solution = high_precision.rbf_coefficients(points, values, reference, m.degree, smoothing)
    for fraction in (0.3, 1e-9, 0.0):
        x = points[4] + fraction * (points[7] - points[4])
        assert_close(
            s(x), float(high_precision.rbf(points, solution, x, reference, m.degree)), 1e-12
        )
        if kernel.differentiable or (x != points[4]).any():
            g = high_precision.gradient(
                lambda y: high_precision.rbf(points, solution, y, reference, m.degree), x
            )
            assert_close(s.gradient(x), g, 1e-11)


# --- orders of convergence ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kernel", "order"),
    [(polyharmonic(1), 1.0), (thin_plate_spline(), 2.0), (polyharmonic(3), 2.5)],
)
def test_errors_converge_with_the_order_of_the_kernel(kernel, order):
    """Franke's function on Halton points, inside the square; the slack is 0.3 (Wendland 11.36)."""
    x = halton(200, 2) * 0.6 + 0.2
    sizes, errors = [], []
    for n in (100, 400, 1600):
        p = halton(n, 2)
        s = RBF(p, kernel).field(franke(p))
        sizes.append(n**-0.5)
        errors.append(np.sqrt(np.mean((s(x) - franke(x)) ** 2)))
    slope = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert slope > order - 0.3


# --- the saddle-point solver ----------------------------------------------------------------------


@pytest.mark.parametrize("q", [0, 1, 3, 6])
@pytest.mark.parametrize("complex_data", [False, True])
def test_the_saddle_point_system_is_solved(q, complex_data):
    """A λ + P c = f and Pᵀ λ = g, for A that is positive definite only on Pᵀλ = 0."""
    rng = np.random.default_rng(7)
    n = 25
    root, p = rng.standard_normal((n, n)), rng.standard_normal((n, q))
    a = root @ root.T / n - 3 * p @ p.T
    f, g = rng.standard_normal((n, 2)), rng.standard_normal((q, 2))
    if complex_data:
        f, g = f + 1j * f[::-1], g - 1j * g[::-1]
    system = SaddlePoint(np.asfortranarray(np.tril(a)), p)
    lam, c = system.solve(f, g)
    assert_close(a @ lam + p @ c, f, 1e-10)
    assert_close(p.T @ lam, g, 1e-10)
    lam, c = system.solve(f)
    assert_close(a @ lam + p @ c, f, 1e-10)
    assert_close(p.T @ lam, np.zeros_like(g), 1e-10)
    whole = np.block([[a, p], [p.T, np.zeros((q, q))]])
    assert_close(system.inverse_diagonal(), np.diagonal(np.linalg.inv(whole))[:n], 1e-8)


def test_a_singular_form_is_refused():
    """Zᵀ A Z = 0."""
    with refused("not positive definite in floating-point numbers", np.linalg.LinAlgError):
        SaddlePoint(np.zeros((5, 5), order="F"), np.ones((5, 1)))


# --- refusals -------------------------------------------------------------------------------------


def test_coincident_sites_are_named():
    """The message has their indices; -0.0 equals 0.0. If they are many, their number is given."""
    p = np.vstack([POINTS, POINTS[3], POINTS[7]])
    with refused("must be distinct to be interpolated; these coincide: 3 and 40, 7 and 41; merge"):
        RBF(p, thin_plate_spline())
    with refused("0 and 1"):
        RBF([[0.0, 1.0], [-0.0, 1.0], [1.0, 0.0], [2.0, 5.0]], thin_plate_spline())
    with refused("and 35 more; merge them, or give smoothing > 0"):
        RBF(np.vstack([POINTS, POINTS]), gaussian(0.1))


@pytest.mark.parametrize(
    ("kernel", "degree", "words"),
    [
        (polyharmonic(3), 0, r"needs polynomials of degree 1 or more \(order 2\); got 0"),
        (thin_plate_spline(), -1, r"needs polynomials of degree 1 or more \(order 2\); got -1"),
        (multiquadric(1.0), -1, r"needs polynomials of degree 0 or more \(order 1\); got -1"),
        (polyharmonic(3), 1.0, "degree must be an integer"),
        (polyharmonic(3), True, "degree must be an integer"),
        (gaussian(1.0), -2, "degree must be an integer, -1 or more; got -2"),
    ],
)
def test_too_low_a_degree_is_refused(kernel, degree, words):
    """The message has the name and the order of the kernel."""
    with refused(words):
        RBF(POINTS, kernel, degree)


def test_higher_degrees_are_accepted():
    """None means the lowest possible degree."""
    assert RBF(POINTS, polyharmonic(3)).degree == 1
    assert RBF(POINTS, polyharmonic(3), np.int64(3)).degree == 3
    assert RBF(POINTS, gaussian(0.1)).degree == -1


@pytest.mark.parametrize("bad", ["thin_plate_spline", thin_plate_spline, None, lambda r: r])
def test_kernels_of_other_types_are_refused(bad):
    """Neither the name of a kernel nor its class is accepted."""
    with refused(r"kernel must be a radial function such as thin_plate_spline\(\); got "):
        RBF(POINTS, bad)


def test_a_kernel_of_too_few_variables_is_refused():
    """(1 - r)₊ is positive definite on the line, but not on a lattice in the plane."""
    lattice = 0.7 * np.stack(np.meshgrid(range(9), range(9)), axis=-1).reshape(-1, 2)
    assert np.linalg.eigvalsh(wendland(1, 0, 1.0)(distances(lattice, lattice))).min() < -0.1
    with refused(r"wendland\(d=1.* is positive definite in at most 1 variables; points have 2"):
        RBF(lattice, wendland(1, 0, 1.0))
    assert RBF(np.random.default_rng(1).random((9, 3)), wendland(2, 1, 1.0)).interpolates


def test_a_kernel_infinite_at_the_origin_is_refused():
    """1/r² cannot interpolate as a kernel."""
    with refused(r"kernel must be finite at r = 0; inverse_square\(epsilon=0\.0\) is not"):
        RBF(POINTS, inverse_square(0.0))


@pytest.mark.parametrize("bad", [-1.0, np.nan, np.inf, "1", None, True])
def test_invalid_smoothing_is_refused(bad):
    """It must be a nonnegative number."""
    with refused("smoothing must be zero or a positive number; got "):
        RBF(POINTS, thin_plate_spline(), smoothing=bad)


def test_points_on_a_line_are_refused():
    """This holds with an offset of 1e6, too."""
    line = np.outer(np.arange(9.0), [1.0, 2.0])
    for offset in (0.0, 1e6):
        with refused("the points do not determine .* rank 2 of 3", np.linalg.LinAlgError):
            RBF(line + offset, thin_plate_spline())


@pytest.mark.parametrize("n", [30, 100, 300])
@pytest.mark.parametrize("scale", [0.1, 0.3, 0.7, 2.0, 10.0])
@pytest.mark.parametrize("rough", [False, True])
def test_an_ill_conditioned_field_has_a_small_error_at_the_data_or_is_refused(n, scale, rough):
    """exp(-(r/10)²) on 300 points is singular up to rounding.

    A field with a large error at its data must not be returned.
    """
    rng = np.random.default_rng(8)
    p = rng.random((n, 2))
    f = rng.standard_normal(n) if rough else np.cos(p @ [3.0, 2.0])
    m = RBF(p, gaussian(scale))
    try:
        s = m.field(f)
    except np.linalg.LinAlgError:
        with refused("would miss its data by about .* too flat", np.linalg.LinAlgError):
            leave_one_out(m, f)
        true_error = np.abs(m._value_rows(p, m._system.solve(f[:, None]))[:, 0] - f).max()
        assert true_error > 1e-3 * np.abs(f).max()
    else:
        assert_close(s(p), f, (1e-6 if m.interpolates else 0.02) * np.abs(f).max())


def test_interpolation_is_lost_to_rounding_and_so_declared():
    """Multiquadrics on 400 sites, ever flatter: rough data are met, then missed, then refused."""
    rng = np.random.default_rng(0)
    p, f = rng.random((400, 2)), rng.standard_normal(400)
    for scale in (0.02, 0.1):
        m = RBF(p, multiquadric(scale))
        assert m.interpolates
        assert_close(m.field(f)(p), f, 1e-6)
    m = RBF(p, multiquadric(0.2))
    assert not m.interpolates
    assert 1e-6 < np.abs(m.field(f)(p) - f).max() < 1e-3
    smooth = np.cos(p @ [3.0, 2.0])
    for scale in (0.32, 0.4):
        m = RBF(p, multiquadric(scale))
        with refused("would miss its data by about .* too flat", np.linalg.LinAlgError):
            m.field(f)
        assert not m.interpolates
        assert_close(m.field(smooth)(p), smooth, 1e-5)


def three_clusters(width: float) -> np.ndarray:
    rng = np.random.default_rng(0)
    return np.concatenate([rng.random((30, 2)) * width + c for c in ([0, 0], [1, 0], [0, 1])])


@pytest.mark.parametrize(
    ("kernel", "width"),
    [(polyharmonic(1), 1e-9), (thin_plate_spline(), 1e-4), (polyharmonic(3), 1e-2)],
)
def test_weights_on_narrow_clusters_are_the_identity(kernel, width):
    """The adjoint does not depend on the order of the sites either."""
    p, load = three_clusters(width), np.cos(np.arange(20))
    m, order = RBF(p, kernel), np.random.default_rng(3).permutation(len(p))
    assert_close(m.weights(p), np.eye(len(p)), 1e-3)
    forces = m.adjoint(QUERIES, load)
    permuted = RBF(p[order], kernel).adjoint(QUERIES, load)
    assert_close(permuted, forces[order], 1e-2 * np.abs(forces).max())


@pytest.mark.parametrize(
    ("kernel", "width"), [(thin_plate_spline(), 1e-6), (polyharmonic(3), 1e-6)]
)
def test_weights_that_rounding_decides_are_refused(kernel, width):
    """Solved weights of r³ deviate from the identity by 60, as the field of random signs does.

    A field of smooth data is still computed, and so are weights with smoothing.
    """
    p, x = three_clusters(width), QUERIES
    m, hermite = RBF(p, kernel), HermiteRBF(values_at(p), kernel)
    assert not hermite.interpolates
    signs = np.random.default_rng(4).choice([-1.0, 1.0], len(p))
    for question in (
        lambda: m.weights(p),
        lambda: m.gradient_weights(x),
        lambda: m.adjoint(x, np.cos(np.arange(20))),
        lambda: hermite.weights(p),
        lambda: hermite.adjoint(x, np.cos(np.arange(20))),
        lambda: hermite.field(signs),
        lambda: m.field(signs),
    ):
        with refused("would miss its data by about .* too flat", np.linalg.LinAlgError):
            question()
    assert_close(m.field(p @ [1.0, 2.0])(x), x @ [1.0, 2.0], 1e-5)
    smoothed = RBF(p, kernel, smoothing=1e-6)
    assert_close(smoothed.weights(x) @ p, x, 1e-5)


def test_a_narrow_kernel_may_be_too_flat_within_clusters():
    """Its values at the distances of the clusters are nothing, those near zero decide."""
    p = three_clusters(0.05)
    m = RBF(p, gaussian(0.1))
    assert not m.interpolates
    for question in (lambda: m.weights(p), lambda: m.field(np.random.default_rng(4).random(90))):
        with refused("would miss its data by about .* too flat", np.linalg.LinAlgError):
            question()


def test_a_fit_that_exceeds_memory_is_refused():
    """The error is raised before allocation; the message has the size and the alternative."""
    p = np.random.default_rng(9).random((1_500_000, 1))
    with refused("a global fit of 1500000 points needs a matrix of 16764 GiB", MemoryError):
        RBF(p, gaussian(0.1))
    with mock.patch.object(solvability, "memory_limit", return_value=8 * 40**2):
        assert RBF(POINTS[:30], gaussian(0.1)).interpolates
        with refused("a global fit of 39 points needs a matrix", MemoryError):
            RBF(POINTS[:39], gaussian(0.1))


def test_the_roughest_data_are_signs():
    """Of size one, the same every time, and as independent as a coin."""
    signs = solvability.random_signs(400, 3)
    assert (np.abs(signs) == 1).all()
    assert np.array_equal(signs, solvability.random_signs(400, 3))
    assert_close(signs.T @ signs / 400, np.eye(3), 0.2)
    assert np.abs(signs.mean(axis=0)).max() < 0.2


def test_dense_weights_beyond_the_limit_are_refused():
    """Fields and adjoints are evaluated in chunks; weights are not."""
    m = RBF(np.random.default_rng(9).random((500, 1)), wendland(1, 1, 0.01))
    x = np.broadcast_to(np.zeros(1), (600_000, 1))
    with refused("dense weights of 600000 queries for 500 sites would take 2.2 GiB", MemoryError):
        m.weights(x)


def test_a_matrix_beyond_the_limit_is_refused():
    """That of 50 sites and 3 polynomials, where 53 rows of 50 numbers are too many."""
    m = RBF(halton(50, 2), thin_plate_spline())
    with mock.patch.object(reconstruction, "DENSE_LIMIT_BYTES", 8 * 53 * 50):
        assert m.matrix().shape == (53, 53)
    with (
        mock.patch.object(reconstruction, "DENSE_LIMIT_BYTES", 8 * 53 * 50 - 1),
        refused("dense weights of 53 queries for 50 sites", MemoryError),
    ):
        m.matrix()


def test_overflow_of_matrix_and_coefficients_is_refused():
    """In units of 1e±150 and 1e±200 the field is accurate; matrix and coefficients overflow."""
    for kernel in (thin_plate_spline(), polyharmonic(1), polyharmonic(3)):
        for unit in (1e-200, 1e-150, 1e150, 1e200):
            m = RBF(POINTS * unit, kernel)
            here = RBF(POINTS, kernel).field(VALUES)(QUERIES)
            assert_close(m.field(VALUES)(QUERIES * unit), here, 1e-9)
            with refused("would leave the range of floating-point numbers", OverflowError):
                m.matrix()
            with refused("would leave the range of floating-point numbers", OverflowError):
                m.coefficients(VALUES)


@pytest.mark.parametrize("unit", [1e-200, 1e-170, 1e-150, 1e150, 1e170, 1e200])
@pytest.mark.parametrize(
    "make", [gaussian, inverse_multiquadric, multiquadric, lambda u: wendland(3, 1, u)]
)
def test_overflow_of_squared_distances_is_refused(make, unit):
    """Otherwise the matrix would consist of zeros and ones. The field is accurate."""
    m = RBF(POINTS * unit, make(0.3 * unit))
    here = RBF(POINTS, make(0.3)).field(VALUES)(QUERIES)
    assert_close(m.field(VALUES)(QUERIES * unit), here, 1e-9)
    with refused("the matrix would leave the range of floating-point numbers", OverflowError):
        m.matrix()
    with refused("the coefficients would leave the range", OverflowError):
        m.coefficients(VALUES)


def test_distant_queries_give_zero_or_are_refused():
    """Decaying kernels vanish there. Other kernels overflow; the message has the query point."""
    for kernel in (wendland(3, 1, 0.5), gaussian(0.2)):
        s = RBF(POINTS, kernel).field(VALUES)
        assert_close(s([[1e200, 0.0]]), np.zeros(1), 0.0)
        assert_close(s.gradient([[1e200, 0.0]]), np.zeros((1, 2)), 0.0)
    with refused(r"the result at \(1e\+200, 0\) exceeds the range", OverflowError):
        RBF(POINTS, thin_plate_spline()).field(VALUES)([1e200, 0.0])


def test_methods_agree_for_linear_data():
    plane = 1 + 2 * POINTS[:, 0] - 3 * POINTS[:, 1]
    expected = 1 + 2 * QUERIES[:, 0] - 3 * QUERIES[:, 1]
    for m in (
        LeastSquares(POINTS),
        MovingLeastSquares(POINTS, inverse_square(0.1)),
        case("RBF thin plate in 2-D").make(POINTS, 1.0),
    ):
        assert_close(m.field(plane)(QUERIES), expected, EXACT)
