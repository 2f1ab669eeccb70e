"""Polynomials: monomials, gradients, the local frame, and unisolvent points."""

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.kernels.positive_definite import gaussian
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.rbf import RBF
from fieldrecon.polynomials import (
    Frame,
    dimension,
    exponents,
    monomial_gradients,
    monomials,
    power_of_two_above,
    require_unisolvent,
    resolution,
)
from laws import assert_close, difference_quotient

EXACT = 1e-13
DIFFERENCE = 1e-8
SPACES = [(d, degree) for d in (1, 2, 3, 5) for degree in (-1, 0, 1, 2, 3, 4)]


@pytest.mark.parametrize(("d", "degree"), SPACES)
def test_exponents_are_complete_and_sorted_by_total_degree(d, degree):
    """There are C(degree + d, d) exponents, each once, the constant first; nobody changes them."""
    alpha = [tuple(a) for a in exponents(d, degree)]
    expected = {a for a in product(range(degree + 1), repeat=d) if sum(a) <= degree}
    assert set(alpha) == expected
    assert len(alpha) == len(expected) == dimension(d, degree)
    assert [sum(a) for a in alpha] == sorted(sum(a) for a in alpha)
    assert not exponents(d, degree).flags.writeable


def test_the_linear_basis_is_that_of_the_slides():
    """b(x) = (1, x_1, ..., x_D), p. 3."""
    assert monomials([2.0, 3.0, 5.0], 1).tolist() == [1, 2, 3, 5]


@pytest.mark.parametrize(("d", "degree"), SPACES)
def test_monomials_are_products_of_powers(d, degree):
    """x^alpha, for points of any shape."""
    x = np.random.default_rng(1).standard_normal((2, 3, d))
    alpha = exponents(d, degree)
    assert_close(monomials(x, degree), np.prod(x[..., None, :] ** alpha, axis=-1), EXACT * 1e3)


@pytest.mark.parametrize(("d", "degree"), SPACES)
def test_gradients_of_monomials_equal_difference_quotients(d, degree):
    """The central differences of order six are exact for the degrees tested."""
    x = np.random.default_rng(2).random((4, d))
    quotient = difference_quotient(lambda y: monomials(y, degree), x, step=1e-2)
    assert_close(monomial_gradients(x, degree), quotient, DIFFERENCE)


@pytest.mark.parametrize("offset", [0.0, 1e6, -1e12])
@pytest.mark.parametrize("unit", [1e-150, 1.0, 1e150])
def test_local_coordinates_fill_the_cube(offset, unit):
    """Local coordinates lie in [-1, 1], the largest is at least 1/2.

    The scale is a power of two. The point with these coordinates is the one they are of.
    """
    x = (np.random.default_rng(3).random((20, 3)) * [1.0, 0.1, 0.0] + offset) * unit
    frame = Frame.around(x)
    y = frame.local(x)
    assert np.abs(y).max() <= 1
    assert np.abs(y).max() >= 0.5
    assert math.frexp(frame.scale)[0] == 0.5
    assert_close(frame.point(y[0]) / unit, x[0] / unit, EXACT)


def test_the_frame_of_one_point_has_scale_one():
    """A single point has no extent."""
    assert Frame.around(np.array([[3.0, 4.0]])).scale == 1.0


@pytest.mark.slow
@given(st.floats(min_value=1e-300, max_value=1e300))
def test_the_power_of_two_above_is_the_least(length):
    """2^(k-1) < length <= 2^k."""
    power = power_of_two_above(length)
    assert power / 2 < length <= power
    assert math.frexp(power)[0] == 0.5


def test_the_frame_of_the_largest_coordinates_is_finite():
    """Points at both ends of the floating-point range are scaled."""
    frame = Frame.around(np.array([[-1.7e308], [1.7e308]]))
    assert np.isfinite(frame.scale)


@pytest.mark.parametrize(("d", "degree"), [(1, 3), (2, 2), (3, 1), (2, 0)])
def test_global_coefficients_give_the_same_polynomial(d, degree):
    """B(x) times them equals B(y) times the local coefficients, with y the local coordinates."""
    rng = np.random.default_rng(4)
    frame = Frame(rng.random(d), 0.25)
    c = rng.standard_normal((dimension(d, degree), 2))
    x = rng.random((10, d))
    there = monomials(x, degree) @ frame.global_coefficients(c, degree)
    assert_close(there, monomials(frame.local(x), degree) @ c, 1e-10)


def test_overflowing_coefficients_are_refused():
    """In a unit of 1e-200 coefficients of degree two exceed 1e308."""
    frame = Frame(np.zeros(1), 2.0**-660)
    with pytest.raises(OverflowError, match=r"the coefficients would leave .* choose a unit"):
        frame.global_coefficients(np.ones((3, 1)), 2)
    far = Frame(np.array([1e200]), 1.0)
    with pytest.raises(OverflowError, match="coefficients of degree 2 overflow in this unit"):
        far.global_coefficients(np.ones((3, 1)), 2)


def test_the_resolution_is_rounding_relative_to_the_extent():
    """It is 1e-16 near the origin and 1e-10 at a distance of 1e6 extents.

    Of several axes the worst counts, but none whose extent is rounding itself.
    """
    eps = float(np.finfo(float).eps)

    def is_about(right):
        return pytest.approx(right, rel=1e-5, abs=0.0)

    x = np.linspace(0, 1, 11)[:, None]
    for near in (x, x - 0.5, 1.7e308 * (2 * x - 1), x[:1], np.ones((2, 2))):
        assert resolution(near) == is_about(eps)
    assert resolution(x + 1e6) == resolution(-x - 1e6) == is_about(1e6 * eps)
    assert resolution(np.hstack([x, x + 1e3, x + 1e6, x + 10.0])) == is_about(1e6 * eps)
    for steps, right in ((2, eps), (8, eps / (8 * eps))):
        rounded = 1 + eps * steps * x
        assert resolution(np.hstack([x, rounded])) == is_about(right)


# --- unisolvent points ----------------------------------------------------------------------------


def require(points, degree):
    points = np.asarray(points, dtype=float)
    require_unisolvent(points, monomials(Frame.around(points).local(points), degree), degree)


LINE = np.stack([np.linspace(0, 1, 9), np.linspace(0, 1, 9) / 3], axis=1)
ANGLES = np.linspace(0.1, 6.0, 12)
CIRCLE = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)


@pytest.mark.parametrize("offset", [0.0, 1e6])
@pytest.mark.parametrize("unit", [1e-150, 1.0, 1e150])
@pytest.mark.parametrize(
    ("points", "degree", "rank", "q"),
    [
        (LINE, 1, 2, 3),
        (LINE, 2, 3, 6),
        (CIRCLE, 2, 5, 6),
        (CIRCLE, 3, 7, 10),
        (np.zeros((4, 2)), 1, 1, 3),
        (LINE[:2], 1, 2, 3),
    ],
)
def test_points_on_a_curve_of_the_degree_are_refused(points, degree, rank, q, unit, offset):
    """The points lie on a line or a circle, coincide, or are too few.

    The message has the rank, for any origin.
    """
    words = f"degree {degree} in 2 variables: rank {rank} of {q}"
    with pytest.raises(np.linalg.LinAlgError, match=f"the points do not determine .* {words}"):
        require((points + offset) * unit, degree)


@pytest.mark.parametrize("unit", [1e-150, 1.0, 1e150])
@pytest.mark.parametrize("bend", [1e-3, 1e-6, 1e-9])
def test_nearly_collinear_points_are_accepted(bend, unit):
    """They determine a linear polynomial if their deviation from the line exceeds rounding."""
    require((LINE + bend * np.array([[0, 1]]) * (np.arange(9) % 2)[:, None]) * unit, 1)


@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_points_off_the_curve_are_accepted(offset):
    """Points on a circle and its centre determine a quadratic polynomial."""
    require(np.vstack([CIRCLE, [[0.0, 0.0]]]) + offset, 2)


def test_the_message_for_one_variable_uses_the_singular():
    with pytest.raises(np.linalg.LinAlgError, match=r"degree 1 in 1 variable: rank 1 of 2"):
        require([[1.0], [1.0]], 1)


@pytest.mark.parametrize(
    "make",
    [
        lambda x: LeastSquares(x, 10),
        lambda x: MovingLeastSquares(x, gaussian(1.0), 10),
        lambda x: RBF(x, polyharmonic(3), 10),
    ],
    ids=["LS", "MLS", "RBF"],
)
def test_a_basis_that_exceeds_memory_is_refused(make):
    """The number of coefficients is reported without computing them."""
    words = "degree 10 in 50 variables, which has 75394027566 coefficients; there are 80 points"
    with pytest.raises(np.linalg.LinAlgError, match=words):
        make(np.random.default_rng(1).random((80, 50)))
