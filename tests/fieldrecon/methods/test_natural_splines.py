"""Natural cubic splines: SciPy, r³, and the defining properties."""

from fractions import Fraction as F

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.methods.natural_splines import NaturalCubicSpline
from fieldrecon.methods.rbf import RBF
from fieldrecon.methods.spline_bases import radial_form
from laws import assert_close
from rational import rank

EXACT = 1e-11
RNG = np.random.default_rng(3)
SITES = RNG.permutation((np.arange(30) + 0.1 + 0.8 * RNG.random(30)) / 30)
VALUES = np.cos(7 * SITES) + SITES**2
METHOD = NaturalCubicSpline(SITES)
INSIDE = np.linspace(SITES.min(), SITES.max(), 301)
OUTSIDE = np.array([-3.0, SITES.min() - 0.01, SITES.max() + 0.01, 5.0])
NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)


# --- the laws of a natural spline -----------------------------------------------------------------


def the_spline_equals_scipy_s_inside(method) -> None:
    """Values and derivatives must equal those of CubicSpline with s'' = 0 at both ends."""
    knots = np.sort(SITES)
    reference = CubicSpline(knots, VALUES[np.argsort(SITES)], bc_type="natural")
    s = method.field(VALUES)
    assert_close(s(INSIDE), reference(INSIDE), EXACT)
    assert_close(s.gradient(INSIDE), reference(INSIDE, 1), 100 * EXACT)
    assert_close(s.hessian(INSIDE), reference(INSIDE, 2), 1e4 * EXACT)


def the_spline_is_linear_outside(method) -> None:
    """It must be the tangent at the outer site. SciPy's spline continues as a cubic instead."""
    s = method.field(VALUES)
    for end, x in ((SITES.min(), OUTSIDE[:2]), (SITES.max(), OUTSIDE[2:])):
        assert_close(s(x), s(end) + s.gradient(end) * (x - end), EXACT * 100)
        assert_close(s.gradient(x), np.full(2, s.gradient(end)), EXACT * 100)
        assert_close(s.hessian(x), np.zeros(2), 0.0)


def the_spline_is_twice_differentiable(method) -> None:
    """s' must have the same one-sided differences on both sides of every site."""
    s, h = method.field(VALUES), 1e-5
    right = (s.gradient(SITES + h) - s.gradient(SITES)) / h
    left = (s.gradient(SITES) - s.gradient(SITES - h)) / h
    assert_close(left, right, 0.3)


def the_second_derivative_is_orthogonal_to_the_difference(method) -> None:
    """(f'' - s'', s'') = 0 must hold for every interpolant f; here f is a polynomial."""
    x, w = _gauss(np.sort(SITES))
    c = np.polynomial.Polynomial.fit(SITES, VALUES, 29, domain=[0, 1])
    curvature = c.deriv(2)(x)
    of_spline = _second(method, x)
    assert abs((w * (curvature - of_spline)) @ of_spline) < 1e-6 * (w @ curvature**2)
    assert w @ curvature**2 == pytest.approx(
        w @ of_spline**2 + w @ (curvature - of_spline) ** 2, rel=1e-6
    )


def the_energy_is_the_integral(method) -> None:
    """∫ s''² by Gauss quadrature, which is exact on each interval."""
    x, w = _gauss(np.sort(SITES))
    assert float(method.energy(VALUES)) == pytest.approx(w @ _second(method, x) ** 2, rel=1e-6)


def coefficients_equal_those_of_r_cubed(method) -> None:
    """They must equal the solution of the saddle-point system of RBF, although computed in O(n)."""
    alpha, beta = method.coefficients(VALUES)
    lam, c = RBF(SITES[:, None], polyharmonic(3)).coefficients(VALUES)
    assert_close(alpha / np.abs(lam).max(), lam / np.abs(lam).max(), 1e-9)
    assert_close(beta / np.abs(c).max(), c / np.abs(c).max(), 1e-9)
    assert float(method.energy(VALUES)) == pytest.approx(12 * alpha @ VALUES, rel=1e-8)


SPLINE_LAWS = [
    the_spline_equals_scipy_s_inside,
    the_spline_is_linear_outside,
    the_spline_is_twice_differentiable,
    the_second_derivative_is_orthogonal_to_the_difference,
    the_energy_is_the_integral,
    coefficients_equal_those_of_r_cubed,
]


def _gauss(knots):
    h = np.diff(knots)[:, None]
    x = knots[:-1, None] + h * (NODES + 1) / 2
    return x.ravel(), (h / 2 * WEIGHTS).ravel()


def _second(method, x):
    """s'' by central differences of s', which are exact up to rounding because s' is quadratic."""
    s, h = method.field(VALUES), 1e-6
    return (s.gradient(x + h) - s.gradient(x - h)) / (2 * h)


@pytest.mark.parametrize("law", SPLINE_LAWS, ids=lambda law: law.__name__)
def test_the_natural_spline_obeys_the_law(law):
    """The sites are not sorted."""
    law(METHOD)


class WithoutMoments(NaturalCubicSpline):
    """The polygon through the data."""

    def _solve(self, right):
        return 0 * super()._solve(right)


class CubicOutside(NaturalCubicSpline):
    """The outer cubics are continued, as in SciPy."""

    def _value_rows(self, x, prepared):
        knots = np.sort(self.points[:, 0])
        spline = CubicSpline(knots, prepared[0], bc_type="natural")
        return spline(x[:, 0])


class Clamped(NaturalCubicSpline):
    """s' = 0 at the ends instead of s'' = 0."""

    def _prepare(self, values):
        f, moments = super()._prepare(values)
        knots = np.sort(self.points[:, 0])
        moments = CubicSpline(knots, f, bc_type="clamped")(knots, 2)
        return f, moments * self._frame.scale**2


class Halved(NaturalCubicSpline):
    """Half of the energy, and coefficients of truncated powers instead of r³."""

    def energy(self, values):
        return super().energy(values) / 2

    def coefficients(self, values):
        return self.truncated_powers(values)


@pytest.mark.parametrize(
    ("law", "mutant"),
    [
        (the_spline_equals_scipy_s_inside, WithoutMoments),
        (the_spline_equals_scipy_s_inside, Clamped),
        (the_spline_is_linear_outside, CubicOutside),
        (the_spline_is_twice_differentiable, WithoutMoments),
        (the_second_derivative_is_orthogonal_to_the_difference, Clamped),
        (the_energy_is_the_integral, Halved),
        (coefficients_equal_those_of_r_cubed, Halved),
    ],
)
def test_the_law_rejects_the_mutant(law, mutant):
    """Another spline violates the law that it was written for."""
    with pytest.raises(AssertionError):
        law(mutant(SITES))


# --- the space of natural splines -----------------------------------------------------------------


def _truncated_basis(knots, x):
    """(x - x_j)₊³ and 1, x, x², x³ at x, in integers."""
    return [[max(v - k, 0) ** 3 for k in knots] + [v**p for p in range(4)] for v in x]


@pytest.mark.parametrize("n", [2, 3, 6])
def test_cubic_splines_have_n_plus_four_dimensions_and_natural_ones_n(n):
    """In rational arithmetic: dim S₃ = n + 4, and the end conditions leave n (Wendland p. 8).

    Linear before the first site: no x², x³. Linear after the last site: (1.6).
    """
    knots = [F(k * k + 1) for k in range(n)]
    x = [F(k, 3) - 2 for k in range(12 * n * n)]
    basis = _truncated_basis(knots, x)
    assert rank(basis) == n + 4
    conditions = [[F(0)] * n + [F(0), F(0), F(1), F(0)], [F(0)] * n + [F(0), F(0), F(0), F(1)]]
    conditions += [[F(1)] * n + [F(0)] * 4, [F(k) for k in knots] + [F(0)] * 4]
    assert n + 4 - rank(conditions) == n


def test_cardinal_splines_are_linearly_independent():
    """They span n dimensions, as many as there are data."""
    assert np.linalg.matrix_rank(METHOD.weights(np.linspace(-1, 2, 200))) == len(SITES)


def test_one_site_does_not_determine_a_spline():
    """All lines through one point are natural splines. For n = 1 their space has dimension two."""
    with pytest.raises(np.linalg.LinAlgError, match="degree 1 in 1 variable: rank 1 of 2"):
        NaturalCubicSpline([3.0])


def test_the_third_derivative_jumps_at_the_ends():
    """s''' is zero outside but not inside: Wendland's condition is one-sided (p. 8)."""
    s, first = METHOD.field(VALUES), SITES.min()
    h = 1e-4
    third = [
        (s.gradient(x + h) - 2 * s.gradient(x) + s.gradient(x - h)) / h**2
        for x in (first - 2 * h, first + 2 * h)
    ]
    assert abs(third[0]) < 1e-4
    assert abs(third[1]) > 10


def test_truncated_powers_give_the_same_spline():
    """(1.5) is zero before its site and a cubic after it.

    (1.6) makes the spline linear after the last site.
    """
    alpha, beta = METHOD.truncated_powers(VALUES)
    for x in (INSIDE, OUTSIDE):
        powers = np.maximum(x[:, None] - SITES, 0) ** 3
        assert_close(powers @ alpha + beta[0] + beta[1] * x, METHOD.field(VALUES)(x), 1e-8)
    size = np.abs(alpha).max()
    assert_close([alpha.sum() / size, SITES @ alpha / size], [0, 0], 1e-12)


def test_the_conversion_of_the_book_is_an_identity():
    """(1.4) to (1.7) in rational arithmetic, for α that satisfy (1.6) and any β."""
    x = [F(0), F(1), F(3), F(7)]
    alpha = [F(2), F(-3), F(1), F(0)]
    assert sum(alpha) == sum(a * b for a, b in zip(alpha, x, strict=True)) == 0
    beta = [F(2), F(-3)]
    new_alpha, new_beta = radial_form(x, alpha, beta)
    for q in (F(-5), F(1, 2), F(2), F(11, 2), F(20)):
        old = sum(a * max(q - p, 0) ** 3 for a, p in zip(alpha, x, strict=True))
        new = sum(a * abs(q - p) ** 3 for a, p in zip(new_alpha, x, strict=True))
        line, new_line = beta[0] + beta[1] * q, new_beta[0] + new_beta[1] * q
        assert abs(float(new + new_line - old - line)) < 1e-12


@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_the_spline_equals_rbf_everywhere(offset):
    """RBF uses r³ with linear polynomials. Values and gradients agree inside and outside."""
    radial = RBF(SITES[:, None] + offset, polyharmonic(3)).field(VALUES)
    s = NaturalCubicSpline(SITES + offset).field(VALUES)
    for x in (INSIDE + offset, OUTSIDE + offset):
        assert_close(s(x), radial(x[:, None]), 1e-7)
        assert_close(s.gradient(x), radial.gradient(x[:, None])[:, 0], 1e-5)


# --- input and refusals ---------------------------------------------------------------------------


def test_sites_and_queries_have_no_coordinate_axis():
    """x (...) and data (n, *v) give (..., *v), and so does the derivative."""
    s = METHOD.field(np.stack([VALUES, -VALUES], axis=1))
    assert s(0.5).shape == s.gradient(0.5).shape == (2,)
    assert s(np.zeros((3, 4))).shape == s.gradient(np.zeros((3, 4))).shape == (3, 4, 2)
    assert s.hessian(0.5).shape == s.laplacian(0.5).shape == (2,)
    assert METHOD.weights([0.1, 0.2]).shape == (2, len(SITES))
    assert METHOD.adjoint([0.1, 0.2], [1.0, 2.0]).shape == (len(SITES),)
    assert METHOD.energy(np.stack([VALUES, 2j * VALUES], axis=1)).shape == (2,)
    complex_energy = METHOD.energy(np.stack([VALUES, 2j * VALUES], axis=1))
    assert complex_energy[1] == pytest.approx(4 * complex_energy[0])


@pytest.mark.parametrize(
    ("sites", "words"),
    [
        (np.zeros((4, 1)), r"points must have the shape \(n,\), without an axis; got \(4, 1\)"),
        ([], r"points must have the shape \(n,\), without an axis; got \(0,\)"),
        ([0.0, 1.0, np.nan], r"points must be finite; points\[2\] is nan"),
        ([0.0, 1.0, -0.0], "these coincide: 0 and 2; merge them$"),
    ],
)
def test_invalid_sites_are_refused(sites, words):
    with pytest.raises(ValueError, match=words):
        NaturalCubicSpline(sites)


def test_the_spline_through_two_sites_is_a_line():
    """Its energy is zero."""
    method = NaturalCubicSpline([3.0, 1.0])
    assert_close(method.field([7.0, 3.0])([0.0, 2.0, 9.0]), [1.0, 5.0, 19.0], 1e-13)
    assert float(method.energy([7.0, 3.0])) == 0.0
    assert_close(method.coefficients([7.0, 3.0])[1], [1.0, 2.0], 1e-13)


@pytest.mark.slow
def test_a_million_sites_are_interpolated():
    """The banded system has linear cost. The r³ form would need 8 TB."""
    sites = np.arange(1_000_000) / 1e6
    s = NaturalCubicSpline(sites).field(np.sin(20 * sites))
    x = np.linspace(0.1, 0.9, 1001) + 3e-7
    assert_close(s(x), np.sin(20 * x), 1e-12)


def test_sites_may_have_tiny_gaps():
    """Two sites have a distance of 1e-250."""
    s = NaturalCubicSpline([0.0, 1e-250, 1.0]).field([0.0, 0.0, 1.0])
    assert float(s(1.0)) == 1.0
    assert np.isfinite(s([0.5e-250, 0.5, 2.0])).all()
