"""Radial basis functions: SciPy as witness, the slides' matrix, energies, and 500 digits."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, RBFInterpolator

import high_precision
from cases import CASES, KERNELS, SITES, Case, case
from fieldrecon._numerics.saddle_point import SaddlePoint
from fieldrecon.datasets.synthetic import franke, halton
from fieldrecon.kernels.conditionally_positive_definite import (
    multiquadric,
    polyharmonic,
    thin_plate_spline,
)
from fieldrecon.kernels.positive_definite import gaussian, inverse_multiquadric, wendland
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.rbf import RBF
from fieldrecon.polynomials import dimension, monomials
from fieldrecon.selection.leaving_one_out import leave_one_out
from laws import assert_close, assert_obeyed, refused

EXACT = 1e-10
RBFS = [c for c in CASES if isinstance(c.method, RBF)]
POINTS = np.random.default_rng(1).random((40, 2))
VALUES = np.cos(POINTS @ [3.0, 2.0])
QUERIES = np.random.default_rng(2).random((20, 2)) * 1.2 - 0.1


# --- the slides' system ---------------------------------------------------------------------------


def it_solves_the_bordered_system(case: Case) -> None:
    """H_RBF (λ, c) = (f, 0) and f(x) = b(x)ᵀc + Σ λ φ(|x - p|), p. 11 to 13."""
    m = case.method
    lam, c = m.coefficients(case.data)
    right = np.concatenate([case.data, np.zeros(len(c))])
    h = m.matrix()
    size = max(1.0, np.abs(lam).max())
    assert_close(h @ np.concatenate([lam, c]) / size, right / size, 1e-9)
    s = m.kernel(distances(case.queries, m.points)) @ lam
    s += monomials(case.queries, m.degree) @ c
    assert_close(m.field(case.data)(case.queries), s, 1e-8 * size)


def it_is_symmetric_with_n_positive_and_q_negative_eigenvalues(case: Case) -> None:
    """Inertia (N, D + 1, 0): indefinite, whatever p. 12 says."""
    m = case.method
    h = m.matrix()
    assert_close(h, h.T, 0.0)
    values = np.linalg.eigvalsh(h)
    q = dimension(case.d, m.degree)
    assert ((values > 0).sum(), (values < 0).sum()) == (case.n, q)


def its_energy_is_that_of_the_data(case: Case) -> None:
    """λᵀAλ = λᵀf - smoothing |λ|² ≥ 0, since λ is orthogonal to the polynomials."""
    m = case.method
    lam, _ = m.coefficients(case.data)
    a = m.kernel(distances(m.points, m.points))
    energy = lam @ case.data - m.smoothing * lam @ lam
    assert energy > 0
    assert lam @ a @ lam == pytest.approx(energy, rel=1e-6)


RBF_LAWS = [
    it_solves_the_bordered_system,
    it_is_symmetric_with_n_positive_and_q_negative_eigenvalues,
    its_energy_is_that_of_the_data,
]


def distances(x: np.ndarray, p: np.ndarray) -> np.ndarray:
    return np.linalg.norm(x[:, None, :] - p, axis=-1)


@pytest.mark.parametrize("case", RBFS, ids=lambda case: case.name)
def test_every_case_is_what_the_slides_say(case):
    """With the matrix in the points' own coordinates, which the library does not compute with."""
    assert_obeyed(RBF_LAWS, case, case.name)


class SmoothingTwice(RBF):
    """Adds the smoothing to a matrix that has it already."""

    def matrix(self):
        h = super().matrix()
        n = len(self.points)
        h[range(n), range(n)] += 0.1
        return h


class SideConditionsForgotten(RBF):
    """The polynomial is fitted first, the kernels take the rest: λ is orthogonal to nothing."""

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
        (it_solves_the_bordered_system, SmoothingTwice),
        (it_is_symmetric_with_n_positive_and_q_negative_eigenvalues, SideConditionsForgotten),
        (its_energy_is_that_of_the_data, SideConditionsForgotten),
    ],
)
def test_the_law_catches_the_mutant(law, mutant):
    """A wrong system breaks the law that is about its mistake."""
    wrong = Case(mutant.__name__, lambda p, _: mutant(p, thin_plate_spline()), 2, SITES[2])
    with pytest.raises(AssertionError):
        law(wrong)


def test_the_smallest_example_has_determinant_minus_one():
    """(0,0), (1,0), (0,1) with r² log r²: by hand, det H = -1, so H is not positive definite."""
    h = RBF([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], thin_plate_spline()).matrix()
    assert np.linalg.det(h) == pytest.approx(-1.0)


def test_the_kernel_alone_may_be_the_zero_matrix():
    """On an equilateral triangle of side one r² log r² vanishes; with polynomials it is solved."""
    triangle = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.75**0.5]])
    m = RBF(triangle, thin_plate_spline())
    assert_close(m.matrix()[:3, :3], np.zeros((3, 3)), 1e-15)
    assert_close(m.field([1.0, 2.0, 5.0])(triangle), np.array([1.0, 2.0, 5.0]), 1e-14)


# --- SciPy ----------------------------------------------------------------------------------------

WITNESSES = {
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
@pytest.mark.parametrize("name", WITNESSES)
def test_scipy_agrees(name, raised, smoothing):
    """RBFInterpolator on the same system: its r² log r is half of ours, 1/(1 + (4r)²) a 16th."""
    kernel, epsilon, factor = WITNESSES[name]
    degree = kernel.order - 1 + raised
    ours = RBF(POINTS, kernel, degree, factor * smoothing).field(VALUES)
    theirs = RBFInterpolator(
        POINTS, VALUES, kernel=name, epsilon=epsilon, degree=degree, smoothing=smoothing
    )
    assert_close(ours(QUERIES), theirs(QUERIES), 1e-8)


@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_scipy_s_natural_spline_agrees(offset):
    """r³ and linear polynomials in 1-D are the natural cubic spline, between the data."""
    x = np.sort(np.random.default_rng(3).random(12))
    y = np.sin(7 * x)
    s = RBF(x[:, None] + offset, polyharmonic(3)).field(y)
    spline = CubicSpline(x, y, bc_type="natural")
    inside = np.linspace(x[0], x[-1], 101)
    tolerance = 1e-11 + 1e-13 * offset
    assert_close(s(inside[:, None] + offset), spline(inside), tolerance)
    assert_close(s.gradient(inside[:, None] + offset)[:, 0], spline(inside, 1), 100 * tolerance)


def test_outside_the_data_the_spline_is_a_line():
    """Natural means: no curvature beyond the ends (SciPy's CubicSpline goes on as a cubic)."""
    x = np.sort(np.random.default_rng(3).random(12))
    s = RBF(x[:, None], polyharmonic(3)).field(np.sin(7 * x))
    far = np.array([[2.0], [3.0], [4.0]])
    assert_close(np.diff(s(far), 2), np.zeros(1), 1e-10)
    assert_close(s.gradient(far), np.tile(s.gradient([[x[-1]]]), (3, 1)), 1e-10)


def test_the_energy_of_the_spline_is_the_integral_of_its_curvature():
    """∫ s''² = 12 λᵀAλ = 12 λᵀf, the integral by SciPy's piecewise polynomial."""
    x = np.sort(np.random.default_rng(3).random(12))
    y = np.sin(7 * x)
    lam, _ = RBF(x[:, None], polyharmonic(3)).coefficients(y)
    curvature = CubicSpline(x, y, bc_type="natural").derivative(2)
    nodes, weights = np.polynomial.legendre.leggauss(2)  # exact for s''², a parabola on each piece
    left, h = x[:-1, None], np.diff(x)[:, None]
    integral = np.sum(curvature(left + h * (nodes + 1) / 2) ** 2 * weights * h / 2)
    assert 12 * lam @ y == pytest.approx(integral, rel=1e-10)


# --- what the polynomial is for -------------------------------------------------------------------


@pytest.mark.parametrize("name", KERNELS)
def test_polynomial_data_need_no_kernels(name):
    """Σ λ b(p) = 0 makes λ = 0 the solution, and c the polynomial."""
    kernel = KERNELS[name](1.0)
    m = RBF(POINTS, kernel, max(kernel.order - 1, 1))
    lam, c = m.coefficients(1 + 2 * POINTS[:, 0] - 3 * POINTS[:, 1])
    assert_close(lam / max(1, abs(m.inverse_diagonal()).max()), np.zeros(40), 1e-12)
    assert_close(c[:3], np.array([1.0, 2.0, -3.0]), 1e-8)


def test_the_far_field_grows_no_faster_than_the_polynomial():
    """With side conditions s(R)/R is bounded; r² log r² alone would grow a thousandfold more."""
    s = RBF(POINTS, thin_plate_spline()).field(VALUES)
    far = 10.0 ** np.arange(2, 7)[:, None] * np.array([0.6, 0.8])
    growth = np.abs(s(far)) / np.linalg.norm(far, axis=1)
    assert growth.max() < 20
    assert growth[-1] < 2 * growth[0]


def test_the_gradient_at_a_centre_is_the_limit():
    """∇φ = 2y(1 + log|y|²) → 0 at its centre: the gradient there is continuous."""
    s = RBF(POINTS, thin_plate_spline()).field(VALUES)
    direction = np.array([0.6, 0.8])
    for step, change in ((1e-6, 1e-2), (1e-9, 1e-5), (1e-12, 1e-8)):
        assert_close(s.gradient(POINTS[:5] + step * direction), s.gradient(POINTS[:5]), change)


@pytest.mark.parametrize(
    "kernel", [polyharmonic(1), KERNELS["exponential"](1.0), wendland(3, 0, 0.8)], ids=repr
)
def test_where_there_is_no_gradient_it_is_refused(kernel):
    """At a site of -r, e^(-r) or (1 - r)²; not beside it."""
    m = RBF(POINTS, kernel)
    s = m.field(VALUES)
    assert np.isfinite(s.gradient(POINTS[:2] + 1e-9)).all()
    words = rf"has no gradient at a site, and the query \({POINTS[1, 0]:.6g}, "
    for ask in (s.gradient, m.gradient_weights):
        with refused(words):
            ask([[0.5, 0.5], POINTS[1]])
    assert_close(s(POINTS[1]), VALUES[1], 1e-12)


def test_smoothing_minimises_misfit_and_energy():
    """|s(p) - f|² + smoothing λᵀAλ is stationary: f - s(p) = smoothing λ; more is smoother."""
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


def test_infinite_smoothing_is_the_least_squares_polynomial():
    """The kernels are too dear to use."""
    s = RBF(POINTS, thin_plate_spline(), smoothing=1e12).field(VALUES)
    assert_close(s(QUERIES), LeastSquares(POINTS).field(VALUES)(QUERIES), 1e-9)


def test_with_smoothing_sites_may_coincide():
    """Their mean is what is smoothed."""
    twice = np.concatenate([POINTS, POINTS])
    s = RBF(twice, thin_plate_spline(), smoothing=2e-3).field(np.append(VALUES + 1, VALUES - 1))
    once = RBF(POINTS, thin_plate_spline(), smoothing=1e-3).field(VALUES)
    assert_close(s(QUERIES), once(QUERIES), 1e-10)


# --- digits ---------------------------------------------------------------------------------------

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


@pytest.mark.parametrize(("offset", "smoothing"), WHERE_AND_HOW_SMOOTH)
@pytest.mark.parametrize("name", IN_DIGITS)
def test_values_and_gradients_have_all_their_digits(name, offset, smoothing):
    """Between sites, 1e-9 from one and at it, near the origin and a million away."""
    kernel, witness = IN_DIGITS[name]
    points, values = FEW + offset, np.cos(FEW @ [3.0, 2.0])
    m = RBF(points, kernel, smoothing=smoothing)
    s = m.field(values)
    solution = high_precision.rbf_coefficients(points, values, witness, m.degree, smoothing)
    for fraction in (0.3, 1e-9, 0.0):
        x = points[4] + fraction * (points[7] - points[4])
        assert_close(s(x), float(high_precision.rbf(points, solution, x, witness, m.degree)), 1e-12)
        if kernel.differentiable or (x != points[4]).any():
            g = high_precision.gradient(
                lambda y: high_precision.rbf(points, solution, y, witness, m.degree), x
            )
            assert_close(s.gradient(x), g, 1e-11)


# --- orders of convergence ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kernel", "order"),
    [(polyharmonic(1), 1.0), (thin_plate_spline(), 2.0), (polyharmonic(3), 2.5)],
)
def test_errors_fall_with_the_order_of_the_kernel(kernel, order):
    """Inside the square, on Halton's points, for Franke's function; slack 0.3 (Wendland 11.36)."""
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
    """A λ + P c = f and Pᵀ λ = g, for A that is definite only where Pᵀλ = 0."""
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
    """Z^T A Z = 0: in the words of the kernel that is too flat."""
    with refused("not positive definite in floating-point numbers", np.linalg.LinAlgError):
        SaddlePoint(np.zeros((5, 5), order="F"), np.ones((5, 1)))


# --- refusals -------------------------------------------------------------------------------------


def test_coincident_sites_are_named():
    """With their indices, -0.0 and 0.0 alike; many of them are counted."""
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
    """By the kernel's name and order."""
    with refused(words):
        RBF(POINTS, kernel, degree)


def test_a_higher_degree_is_welcome():
    """And None is the lowest."""
    assert RBF(POINTS, polyharmonic(3)).degree == 1
    assert RBF(POINTS, polyharmonic(3), np.int64(3)).degree == 3
    assert RBF(POINTS, gaussian(0.1)).degree == -1


@pytest.mark.parametrize("bad", ["thin_plate_spline", thin_plate_spline, None, lambda r: r])
def test_a_kernel_is_a_radial_function(bad):
    """Not its name, and not the function that makes it."""
    with refused(r"kernel must be a radial function such as thin_plate_spline\(\); got "):
        RBF(POINTS, bad)


def test_a_kernel_of_too_few_variables_is_refused():
    """(1 - r)₊ is positive definite on the line only: on a lattice of the plane it is not."""
    lattice = 0.7 * np.stack(np.meshgrid(range(9), range(9)), axis=-1).reshape(-1, 2)
    assert np.linalg.eigvalsh(wendland(1, 0, 1.0)(distances(lattice, lattice))).min() < -0.1
    with refused(r"wendland\(d=1.* is positive definite in at most 1 variables; points have 2"):
        RBF(lattice, wendland(1, 0, 1.0))
    assert RBF(np.random.default_rng(1).random((9, 3)), wendland(2, 1, 1.0)).interpolates


def test_a_kernel_infinite_at_the_origin_is_refused():
    """1/r² interpolates nothing as a kernel."""
    with refused(r"kernel must be finite at r = 0; inverse_square\(epsilon=0\.0\) is not"):
        RBF(POINTS, inverse_square(0.0))


@pytest.mark.parametrize("bad", [-1.0, np.nan, np.inf, "1", None, True])
def test_smoothing_is_no_less_than_zero(bad):
    """And a number."""
    with refused("smoothing must be zero or a positive number; got "):
        RBF(POINTS, thin_plate_spline(), smoothing=bad)


def test_points_on_a_line_are_refused():
    """Also with an offset of a million."""
    line = np.outer(np.arange(9.0), [1.0, 2.0])
    for offset in (0.0, 1e6):
        with refused("the points do not determine .* rank 2 of 3", np.linalg.LinAlgError):
            RBF(line + offset, thin_plate_spline())


@pytest.mark.parametrize("n", [30, 100, 300])
@pytest.mark.parametrize("scale", [0.1, 0.3, 0.7, 2.0, 10.0])
@pytest.mark.parametrize("rough", [False, True])
def test_a_field_comes_near_its_data_or_is_refused(n, scale, rough):
    """exp(-(r/10)²) on 300 points is singular to rounding: never a field that misses its data."""
    rng = np.random.default_rng(8)
    p = rng.random((n, 2))
    f = rng.standard_normal(n) if rough else np.cos(p @ [3.0, 2.0])
    m = RBF(p, gaussian(scale))
    try:
        s = m.field(f)
    except np.linalg.LinAlgError:
        with refused("would miss its data by about .* too flat", np.linalg.LinAlgError):
            leave_one_out(m, f)
        true_miss = np.abs(m._value_rows(p, m._system.solve(f[:, None]))[:, 0] - f).max()
        assert true_miss > 1e-3 * np.abs(f).max()
    else:
        assert_close(s(p), f, 0.05 * np.abs(f).max())


def test_a_fit_beyond_this_machine_is_refused_at_once():
    """With the size of its matrix and what to use instead; before anything is allocated."""
    p = np.random.default_rng(9).random((1_500_000, 1))
    with refused("a global fit of 1500000 points needs a matrix of 16764 GiB", MemoryError):
        RBF(p, gaussian(0.1))


def test_dense_weights_beyond_the_limit_are_refused():
    """Fields and adjoints stream, weights do not."""
    m = RBF(np.random.default_rng(9).random((500, 1)), wendland(1, 1, 0.01))
    x = np.broadcast_to(np.zeros(1), (600_000, 1))
    with refused("dense weights of 600000 queries for 500 sites would take 2.2 GiB", MemoryError):
        m.weights(x)


def test_what_does_not_fit_into_the_unit_is_refused():
    """The matrix and the coefficients in units of 1e±150 and 1e±200; the field is no trouble."""
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
def test_squares_of_distances_must_be_numbers(make, unit):
    """Or a matrix of zeros and ones would come out; the field is no trouble here either."""
    m = RBF(POINTS * unit, make(0.3 * unit))
    here = RBF(POINTS, make(0.3)).field(VALUES)(QUERIES)
    assert_close(m.field(VALUES)(QUERIES * unit), here, 1e-9)
    with refused("the matrix would leave the range of floating-point numbers", OverflowError):
        m.matrix()
    with refused("the coefficients would leave the range", OverflowError):
        m.coefficients(VALUES)


def test_a_far_query_is_answered_or_refused_with_its_place():
    """Compact and decaying kernels vanish there; the others exceed the range of numbers."""
    for kernel in (wendland(3, 1, 0.5), gaussian(0.2)):
        s = RBF(POINTS, kernel).field(VALUES)
        assert_close(s([[1e200, 0.0]]), np.zeros(1), 0.0)
        assert_close(s.gradient([[1e200, 0.0]]), np.zeros((1, 2)), 0.0)
    with refused(r"the result at \(1e\+200, 0\) exceeds the range", OverflowError):
        RBF(POINTS, thin_plate_spline()).field(VALUES)([1e200, 0.0])


def test_methods_agree_where_they_should():
    """On linear data all reconstruct the same plane."""
    plane = 1 + 2 * POINTS[:, 0] - 3 * POINTS[:, 1]
    expected = 1 + 2 * QUERIES[:, 0] - 3 * QUERIES[:, 1]
    for m in (
        LeastSquares(POINTS),
        MovingLeastSquares(POINTS, inverse_square(0.1)),
        case("RBF thin plate in 2-D").make(POINTS, 1.0),
    ):
        assert_close(m.field(plane)(QUERIES), expected, EXACT)
