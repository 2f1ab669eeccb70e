"""Radial functions: closed forms, slopes, minimal orders, extreme lengths, and mutants."""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from decimal import Decimal, localcontext

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from scipy.spatial.distance import cdist

from cases import KERNELS, WEIGHTS
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import (
    multiquadric,
    polyharmonic,
    thin_plate_spline,
)
from fieldrecon.kernels.positive_definite import gaussian, inverse_multiquadric, matern, wendland
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.polynomials import dimension
from laws import all_monomials, assert_close, assert_obeyed

EXACT = 1e-13
DIFFERENCE = 1e-8
RADII = np.concatenate([np.linspace(0.01, 1.5, 40), [1e-8, 1e-4, 0.5, 1.0, 3.0, 10.0]])

RADIAL: dict[str, Radial] = {name: k(1.0) for name, k in (KERNELS | WEIGHTS).items()}
RADIAL |= {f"r^{k}": polyharmonic(k) for k in (6, 7, 8)}
RADIAL |= {f"wendland({d}, {k})": wendland(d, k, 1.0) for d in (1, 2, 3, 5) for k in range(4)}
RADIAL |= {f"matern({nu})": matern(nu, 0.5) for nu in (0.3, 0.75, 1.0, 2.0, 3.5, 7.0)}
CONTINUOUS = {name: k for name, k in RADIAL.items() if name != "ε = 0"}


def named(x: object) -> str:
    """The id of a parameter."""
    return getattr(x, "__name__", repr(x))


# --- closed forms -------------------------------------------------------------------------------

CLOSED_FORMS: list[tuple[Radial, Callable[[np.ndarray], np.ndarray]]] = [
    (thin_plate_spline(), lambda r: r**2 * np.log(r**2)),
    (polyharmonic(1), lambda r: -r),
    (polyharmonic(2), lambda r: r**2 * np.log(r)),
    (polyharmonic(3), lambda r: r**3),
    (polyharmonic(4), lambda r: -(r**4) * np.log(r)),
    (polyharmonic(5), lambda r: -(r**5)),
    (polyharmonic(6), lambda r: r**6 * np.log(r)),
    (polyharmonic(7), lambda r: r**7),
    (gaussian(0.5), lambda r: np.exp(-4 * r**2)),
    (multiquadric(0.5), lambda r: -np.sqrt(1 + 4 * r**2)),
    (inverse_multiquadric(0.5), lambda r: 1 / np.sqrt(1 + 4 * r**2)),
    (inverse_square(0.5), lambda r: 1 / (r**2 + 0.25)),
    # Rasmussen and Williams (2006), equations 4.14 and 4.17, with the factors in the scale
    (matern(0.5, 0.5), lambda r: np.exp(-2 * r)),
    (matern(1.5, 0.5), lambda r: (1 + 2 * r) * np.exp(-2 * r)),
    (matern(2.5, 0.5), lambda r: (1 + 2 * r + (2 * r) ** 2 / 3) * np.exp(-2 * r)),
    # Wendland (2005), table 9.1
    (wendland(1, 0, 1.0), lambda r: np.maximum(1 - r, 0)),
    (wendland(1, 1, 1.0), lambda r: np.maximum(1 - r, 0) ** 3 * (3 * r + 1)),
    (wendland(1, 2, 1.0), lambda r: np.maximum(1 - r, 0) ** 5 * (8 * r**2 + 5 * r + 1)),
    (wendland(3, 0, 1.0), lambda r: np.maximum(1 - r, 0) ** 2),
    (wendland(3, 1, 1.0), lambda r: np.maximum(1 - r, 0) ** 4 * (4 * r + 1)),
    (wendland(3, 2, 1.0), lambda r: np.maximum(1 - r, 0) ** 6 * (35 * r**2 + 18 * r + 3) / 3),
    (
        wendland(3, 3, 1.0),
        lambda r: np.maximum(1 - r, 0) ** 8 * (32 * r**3 + 25 * r**2 + 8 * r + 1),
    ),
    (wendland(5, 0, 1.0), lambda r: np.maximum(1 - r, 0) ** 3),
    (wendland(5, 1, 1.0), lambda r: np.maximum(1 - r, 0) ** 5 * (5 * r + 1)),
    (wendland(5, 2, 1.0), lambda r: np.maximum(1 - r, 0) ** 7 * (16 * r**2 + 7 * r + 1)),
]


@pytest.mark.parametrize(("kernel", "closed_form"), CLOSED_FORMS, ids=named)
def test_values_equal_the_published_formulas(kernel, closed_form):
    """Sign and scale are those of the publications."""
    r = np.linspace(0.01, 3.0, 200)
    size = np.abs(closed_form(r)).max()
    assert_close(kernel(r) / size, closed_form(r) / size, EXACT)


def wendland_by_integrals(d: int, k: int) -> Polynomial:
    """φ_(d,k) on [0, 1]: k integrals ∫_r^1 t φ(t) dt of (1 - r)^l (Wendland 2005, def. 9.11)."""
    phi = Polynomial([1, -1]) ** (d // 2 + k + 1)
    for _ in range(k):
        antiderivative = (Polynomial([0, 1]) * phi).integ()
        phi = antiderivative(1) - antiderivative
    return phi / phi(0)


@pytest.mark.parametrize(("d", "k"), [*itertools.product((1, 2, 3, 4, 5, 7), range(4))])
def test_wendland_functions_equal_their_definition_by_integrals(d, k):
    """This covers dimensions beyond those of table 9.1."""
    r = np.linspace(0, 1, 50)
    assert_close(wendland(d, k, 1.0)(r), wendland_by_integrals(d, k)(r), 1e-11)


# --- laws of radial functions ---------------------------------------------------------------------


def the_slope_times_r_is_the_derivative(kernel: Radial) -> None:
    """slope(r) must be φ'(r)/r, compared with central differences of order six."""
    r = RADII[(RADII > 1e-3) & (np.abs(RADII - kernel.support) > 0.02)]
    h = 2e-4 * np.minimum(r, 1)
    by = {k: kernel(r + k * h) - kernel(r - k * h) for k in (1, 2, 3)}
    derivative = (45 * by[1] - 9 * by[2] + by[3]) / (60 * h)
    size = 1 + np.abs(derivative)
    assert_close(kernel.slope(r) * r / size, derivative / size, DIFFERENCE)


def functions_of_the_square_agree_with_those_of_the_distance(kernel: Radial) -> None:
    """of_squared(r²) and slope_of_squared(r²) must equal φ(r) and φ'(r)/r, and keep the shape."""
    for f, g in ((kernel, kernel.of_squared), (kernel.slope, kernel.slope_of_squared)):
        size = 1 + np.abs(f(RADII))
        assert_close(f(RADII) / size, g(RADII**2) / size, EXACT)
        assert f(RADII.reshape(2, -1)).shape == (2, len(RADII) // 2)
        assert np.ndim(f(0.5)) == 0


def the_function_vanishes_exactly_beyond_its_support(kernel: Radial) -> None:
    """Value and slope must be zero for r ≥ support, and the value positive for r < support."""
    outside = kernel.support <= RADII
    assert (kernel(RADII)[outside] == 0).all()
    assert (kernel.slope(RADII)[outside] == 0).all()
    if np.isfinite(kernel.support):
        assert (kernel(RADII)[~outside] > 0).all()
        assert float(kernel(kernel.support)) == 0.0


def the_function_is_differentiable_at_the_origin_if_and_only_if_declared(kernel: Radial) -> None:
    """`differentiable` must be true if and only if φ'(r) → 0 for r → 0.

    The slope at 0 must be finite, and zero where there is no gradient.
    """
    r = np.array([1e-40])
    steep = abs(float((kernel.slope(r) * r)[0])) > 1e-3 * max(1.0, abs(float(kernel(1.0))))
    assert kernel.differentiable != steep
    assert np.isfinite(kernel.slope(0.0))
    assert kernel.differentiable or kernel.slope(0.0) == 0


def a_change_of_unit_multiplies_the_form_by_a_power(kernel: Radial) -> None:
    """φ(r) = h^k φ_h(r/h) must hold on λ that annihilate the polynomials; k is `homogeneity`."""
    x = np.random.default_rng(1).random((12, 2))
    h = 2.0**-3
    z = null_space(x, kernel.order - 1)
    here = z.T @ kernel(cdist(x, x)) @ z
    there = z.T @ kernel.in_units(h)(cdist(x / h, x / h)) @ z
    assert_close(h**kernel.homogeneity * there, here, 1e-11)


def the_function_of_extreme_lengths_is_that_of_their_ratio(kernel: Radial) -> None:
    """φ(r) = φ_h(r/h) must hold also for h = 2^±600, whose square is out of range."""
    if kernel.homogeneity == 0:
        for h in (2.0**600, 2.0**-600):
            assert_close(kernel.in_units(h)(RADII / h), kernel(RADII), EXACT)


def null_space(x: np.ndarray, degree: int) -> np.ndarray:
    """Orthonormal λ with Σ λ_j p(x_j) = 0 for all polynomials p of the degree."""
    b = all_monomials(x, degree) if degree >= 0 else np.zeros((len(x), 0))
    return np.linalg.qr(b, mode="complete")[0][:, b.shape[1] :]


def lowest_eigenvalue(kernel: Radial, d: int, degree: int) -> float:
    """Least eigenvalue of the quadratic form on the orthogonal complement of the polynomials."""
    worst = np.inf
    for seed in range(4):
        x = 3 * np.random.default_rng(seed).random((dimension(d, degree) + 11, d))
        z = null_space(x, degree)
        worst = min(worst, float(np.linalg.eigvalsh(z.T @ kernel(cdist(x, x)) @ z).min()))
    return worst


def the_form_is_positive_definite_with_the_order(kernel: Radial) -> None:
    """λᵀ A λ > 0 must hold for λ orthogonal to the polynomials of degree order - 1."""
    for d in (1, 2, 3):
        if d <= kernel.dimensions:
            assert lowest_eigenvalue(kernel, d, kernel.order - 1) > -1e-11


def the_order_is_minimal(kernel: Radial) -> None:
    """It must not be negative; with one degree less, some λ must make the form negative."""
    assert kernel.order >= 0
    if kernel.order > 0:
        for d in (1, 2, 3):
            assert lowest_eigenvalue(kernel, d, kernel.order - 2) < -1e-3


RADIAL_LAWS = [
    the_slope_times_r_is_the_derivative,
    functions_of_the_square_agree_with_those_of_the_distance,
    the_function_vanishes_exactly_beyond_its_support,
    the_function_is_differentiable_at_the_origin_if_and_only_if_declared,
    a_change_of_unit_multiplies_the_form_by_a_power,
    the_function_of_extreme_lengths_is_that_of_their_ratio,
    the_form_is_positive_definite_with_the_order,
    the_order_is_minimal,
]


@pytest.mark.parametrize("name", CONTINUOUS)
def test_every_radial_function_obeys_the_laws(name):
    assert_obeyed(RADIAL_LAWS, CONTINUOUS[name], name)


# --- mutants --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class wrong_sign(polyharmonic):
    """-r³ instead of r³."""

    def of_distance(self, r):
        return -super().of_distance(r)


@dataclass(frozen=True)
class order_too_low(multiquadric):
    """A multiquadric without the constant polynomial that it needs."""

    order = 0


@dataclass(frozen=True)
class order_too_high(multiquadric):
    """A multiquadric with linear polynomials that it does not need."""

    order = 2


@dataclass(frozen=True)
class derivative_for_slope(gaussian):
    """φ'(r) instead of φ'(r)/r."""

    def slope_of_distance(self, r):
        return super().slope_of_distance(r) * r


@dataclass(frozen=True)
class slope_of_fourth_power(gaussian):
    """A Gaussian whose slope squares r²."""

    def slope_of_squared(self, s):
        return super().slope_of_squared(s**2)

    def slope(self, r):
        return super().slope_of_squared(np.asarray(r) ** 2)


@dataclass(frozen=True)
class unbounded_support(wendland):
    """A Wendland function that does not vanish beyond the radius."""

    def of_distance(self, r):
        return (1 - r) ** 4 * (4 * r + 1)


@dataclass(frozen=True)
class smooth_cone(polyharmonic):
    """-r with the wrong claim that it has a gradient at the origin."""

    differentiable = True


@dataclass(frozen=True)
class unit_forgotten(gaussian):
    """A Gaussian that does not scale its length."""

    def in_units(self, h):  # noqa: ARG002
        return self


@dataclass(frozen=True)
class squared_lengths(multiquadric):
    """Squares r."""

    def of_distance(self, r):
        with np.errstate(over="ignore"):
            return -np.sqrt(1 + r * r / self.scale / self.scale)


RADIAL_MUTANTS = {
    the_slope_times_r_is_the_derivative: derivative_for_slope(0.5),
    functions_of_the_square_agree_with_those_of_the_distance: slope_of_fourth_power(0.5),
    the_function_vanishes_exactly_beyond_its_support: unbounded_support(3, 1, 1.0),
    the_function_is_differentiable_at_the_origin_if_and_only_if_declared: smooth_cone(1),
    a_change_of_unit_multiplies_the_form_by_a_power: unit_forgotten(0.5),
    the_function_of_extreme_lengths_is_that_of_their_ratio: squared_lengths(0.5),
    the_form_is_positive_definite_with_the_order: wrong_sign(3),
    the_order_is_minimal: order_too_high(0.5),
}


@pytest.mark.parametrize(("law", "mutant"), [*RADIAL_MUTANTS.items()], ids=named)
def test_the_law_rejects_the_mutant(law, mutant):
    """A wrong radial function violates the law that it was written for."""
    with pytest.raises(AssertionError):
        law(mutant)


def test_every_law_has_a_mutant():
    """A declared order that is too low is detected as well."""
    assert list(RADIAL_MUTANTS) == RADIAL_LAWS
    with pytest.raises(AssertionError):
        the_form_is_positive_definite_with_the_order(order_too_low(0.5))


# --- extreme distances and lengths ----------------------------------------------------------------


@pytest.mark.parametrize("kernel", [*CONTINUOUS.values()], ids=[*CONTINUOUS])
def test_values_are_finite_and_continuous_for_tiny_distances(kernel):
    """At r = 1e-300, where r² underflows, and at zero the value is the limit."""
    r = np.array([0.0, 1e-300, 1e-200, 1e-100, 1e-20])
    assert np.isfinite(kernel(r)).all()
    assert np.isfinite(kernel.slope(r)).all()
    assert np.isfinite(kernel.slope_of_squared(r * r)).all()
    assert_close(kernel(r) - kernel(1e-20), np.zeros(5), 1e-5)
    at_zero, near, far = kernel.slope(np.array([0.0, 1e-12, 1e-6]))
    if abs(far - near) < 1e-3 * abs(far):  # the slope has a limit
        assert_close(at_zero / near, 1.0, 1e-9)


@pytest.mark.parametrize("kernel", [*CONTINUOUS.values()], ids=[*CONTINUOUS])
def test_a_distance_that_is_no_number_has_no_value(kernel):
    """It is not taken for zero or for infinity."""
    for function in (kernel, kernel.slope, kernel.of_squared, kernel.slope_of_squared):
        assert np.isnan(function(np.array([np.nan, 0.5]))).tolist() == [True, False]


@pytest.mark.parametrize(
    "make",
    [
        gaussian,
        multiquadric,
        inverse_multiquadric,
        lambda s: matern(1.5, s),
        lambda s: wendland(3, 1, s),
        inverse_square,
    ],
)
@pytest.mark.parametrize("scale", [1e-140, 1e140])
def test_lengths_may_be_of_any_size(make, scale):
    """φ depends on r/scale only, up to a power of the scale for 1/(r² + ε²)."""
    r = np.array([0.0, 0.3, 0.9])
    power = scale ** make(1.0).homogeneity
    assert_close(make(scale)(r * scale) / power, make(1.0)(r), 1e-12)


@pytest.mark.parametrize("scale", [1e-300, 1e-200, 1e200, 1e300])
@pytest.mark.parametrize("make", [gaussian, multiquadric, inverse_multiquadric, inverse_square])
def test_extreme_lengths_give_limits(make, scale):
    """Where squares overflow or underflow, values are limits. No OverflowError is raised."""
    with np.errstate(all="ignore"):
        assert not np.isnan(make(scale)(np.array([0.5, 1.0]))).any()
        make(scale).slope(np.array([0.5, 1.0]))


def test_values_whose_squares_are_out_of_range():
    """They are right to the last digits where they are numbers: by closed forms."""
    root = 2.0**-1022
    for value, exact in (
        (multiquadric(0.5)(-1e160), -2e160),
        (inverse_multiquadric(0.5)(1e160), 0.5e-160),
        (multiquadric(0.5).slope(1e160), -2e-160),
        (gaussian(1e-200)(1e-200), np.exp(-1.0)),
        (wendland(3, 0, 1e200)(5e199), 0.25),
        (polyharmonic(1)(1e-200), -1e-200),
        (polyharmonic(1)(root), -root),
        (polyharmonic(1).slope(1e-200), -1e200),
        (polyharmonic(2).slope(1e-200), 1 - 400 * np.log(10)),
        (polyharmonic(3).slope(1e160), 3e160),
        (thin_plate_spline().slope(1e-200), 2 - 800 * np.log(10)),
        (matern(0.5, 1.0).slope(1e-200), -1e200),
    ):
        assert_close(value / exact, 1.0, EXACT)


EXACT_FORMS: dict[Radial, Callable[[Decimal], Decimal]] = {
    thin_plate_spline(): lambda r: 2 * r * r * r.ln(),
    polyharmonic(1): lambda r: -r,
    polyharmonic(2): lambda r: r * r * r.ln(),
    polyharmonic(3): lambda r: r**3,
    polyharmonic(4): lambda r: -(r**4) * r.ln(),
    polyharmonic(5): lambda r: -(r**5),
    gaussian(1.0): lambda r: (-r * r).exp(),
    multiquadric(1.0): lambda r: -(1 + r * r).sqrt(),
    inverse_multiquadric(1.0): lambda r: 1 / (1 + r * r).sqrt(),
    matern(0.5, 1.0): lambda r: (-r).exp(),
    matern(1.5, 1.0): lambda r: (1 + r) * (-r).exp(),
    inverse_square(0.0): lambda r: 1 / (r * r),
    inverse_square(1.0): lambda r: 1 / (1 + r * r),
    inverse_square(2.0**-540): lambda r: 1 / (Decimal(2) ** -1080 + r * r),
}
DISTANCES = 10.0 ** np.concatenate([np.arange(-300, 301, 12), np.arange(-164, 165, 1), [-0.3, 1.3]])
SUBNORMAL = 1e-322
"""Numbers this small have no digits."""


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kernel", EXACT_FORMS, ids=repr)
def test_values_are_right_to_rounding_at_all_distances(kernel):
    """By the closed forms in 700 digits; values out of range are infinite or zero."""
    for r in DISTANCES:
        with localcontext() as context:
            context.prec = 700
            exact = EXACT_FORMS[kernel](Decimal(float(r)))
            in_range = abs(exact) < Decimal("1.797e308")
        with np.errstate(over="warn" if in_range else "ignore"):
            value = kernel(r)
        if in_range:
            assert abs(value - float(exact)) <= EXACT * abs(float(exact)) + SUBNORMAL, r
        else:
            assert value == math.copysign(math.inf, exact), r


def test_compact_functions_vanish_at_huge_distances():
    """Value and slope are zero, also where r² overflows."""
    with np.errstate(over="ignore"):
        assert float(wendland(3, 2, 1.0)(1e200)) == 0.0
        assert float(wendland(3, 2, 1.0).slope(1e200)) == 0.0


# --- refusals -------------------------------------------------------------------------------------

NO_LENGTH = [0, -1, np.nan, np.inf, "0.1", None, True, 1j, np.array([0.1]), 10**400]


@pytest.mark.parametrize("bad", NO_LENGTH, ids=lambda b: repr(b)[:12])
@pytest.mark.parametrize(
    ("make", "name"),
    [
        (gaussian, "scale"),
        (multiquadric, "scale"),
        (inverse_multiquadric, "scale"),
        (lambda b: matern(1.5, b), "scale"),
        (lambda b: matern(b, 1.0), "nu"),
        (lambda b: wendland(3, 1, b), "radius"),
    ],
)
def test_invalid_lengths_are_refused(make, name, bad):
    """The message names the parameter and what came."""
    with pytest.raises(ValueError, match=f"{name} must be a positive number; got "):
        make(bad)


@pytest.mark.parametrize("bad", NO_LENGTH[1:], ids=lambda b: repr(b)[:12])
def test_epsilon_may_be_zero_but_not_negative(bad):
    """ε = 0 makes moving least squares interpolate."""
    assert inverse_square(0).epsilon == 0.0
    with pytest.raises(ValueError, match="epsilon must be zero or a positive number; got "):
        inverse_square(bad)


@pytest.mark.parametrize("bad", [0, -1, 1.5, True, "3", None])
def test_powers_must_be_positive_integers(bad):
    with pytest.raises(ValueError, match=r"k must be an integer, 1 or more; got "):
        polyharmonic(bad)


@pytest.mark.parametrize("bad", [0, -1, 1.5, True, "3", None])
def test_wendland_dimensions_must_be_positive_integers(bad):
    with pytest.raises(ValueError, match=r"d must be an integer, 1 or more; got "):
        wendland(bad, 1)


@pytest.mark.parametrize("bad", [4, -1, 1.0, True, "1", None])
def test_wendland_smoothness_must_be_0_to_3(bad):
    """The functions are C^0, C^2, C^4 or C^6."""
    with pytest.raises(ValueError, match="k must be 0, 1, 2 or 3; got "):
        wendland(3, bad)


def test_numpy_scalars_are_accepted():
    """Lengths in float32 become doubles, so that their squares have all digits."""
    assert type(gaussian(np.float32(0.1)).scale) is float
    assert type(inverse_square(np.int64(2)).epsilon) is float
    assert replace(wendland(np.int64(3), np.int64(1)), radius=2).radius == 2.0
    assert polyharmonic(np.int64(3)).order == 2


def test_matern_with_too_large_nu_is_refused():
    """For ν > 40 the Bessel functions overflow near the origin."""
    assert np.isfinite(matern(40, 1.0)(np.logspace(-12, 3, 100))).all()
    assert_close(matern(40, 1.0)(np.array([1e-9, 1e-8, 1e-7, 1e-6])), np.ones(4), 1e-13)
    with pytest.raises(ValueError, match=r"nu must be at most 40; got 41.*gaussian"):
        matern(41, 1.0)
