"""B-splines: three definitions of one function, SciPy, and the partition of unity."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import BSpline

from fieldrecon.methods.spline_bases import (
    b_splines,
    b_splines_by_divided_differences,
    cardinal_b_spline,
)
from laws import assert_close

KNOTS = np.array([0.0, 0.7, 1.0, 2.5, 3.0, 3.2, 4.0, 5.5])
DOUBLED = np.array([0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 3.0, 4.0, 4.0, 4.0])
CLAMPED = np.array([0.0] * 5 + [0.7, 1.0, 2.5, 2.5, 3.2] + [4.0] * 5)
X = np.concatenate([np.linspace(-0.5, 6.0, 131), KNOTS])


@pytest.mark.parametrize("knots", [KNOTS, DOUBLED], ids=["simple", "multiple"])
@pytest.mark.parametrize("degree", range(5))
def test_recursion_and_divided_differences_agree(knots, degree):
    """At multiple knots a divided difference is a derivative."""
    recursive = b_splines(knots, degree, X)
    assert_close(b_splines_by_divided_differences(knots, degree, X), recursive, 1e-10)


@pytest.mark.parametrize("degree", range(7))
def test_all_three_definitions_agree_on_integer_knots(degree):
    """Convolution powers of the indicator function of [0, 1) are B-splines of knots 0 to k + 1."""
    knots = np.arange(degree + 2.0)
    x = np.linspace(-1.0, degree + 2.0, 97)
    x = x[x != degree + 1]  # among all integers it is not the last knot
    convolved = cardinal_b_spline(degree, x)
    assert_close(b_splines(knots, degree, x)[:, 0], convolved, 1e-13)
    assert_close(b_splines_by_divided_differences(knots, degree, x)[:, 0], convolved, 1e-10)


@pytest.mark.parametrize("knots", [KNOTS, DOUBLED], ids=["simple", "multiple"])
@pytest.mark.parametrize("degree", range(1, 5))
def test_b_splines_equal_those_of_scipy(knots, degree):
    """BSpline.basis_element on each window of knots; the last knot is in a test of its own."""
    x = X[knots[-1] != X]
    ours = b_splines(knots, degree, x)
    for i in range(len(knots) - degree - 1):
        window = knots[i : i + degree + 2]
        if window[0] < window[-1]:
            inside = (window[0] <= x) & (window[-1] > x)
            theirs = BSpline.basis_element(window, extrapolate=False)(x[inside])
            assert_close(ours[inside, i], theirs, 1e-13)
            assert (ours[~inside, i] == 0).all()


@pytest.mark.parametrize("degree", range(4))
def test_b_splines_are_a_partition_of_unity(degree):
    """They are nonnegative, and their sum is one between knot k and knot n - k - 1."""
    b = b_splines(KNOTS, degree, X)
    assert (b >= 0).all()
    full = (KNOTS[degree] <= X) & (KNOTS[len(KNOTS) - degree - 1] > X)
    assert full.sum() > 0
    assert_close(b[full].sum(axis=1), np.ones(full.sum()), 1e-14)


@pytest.mark.parametrize("degree", range(5))
def test_the_last_interval_is_closed(degree):
    """As SciPy's: on clamped knots the sum is one at both ends, and the last spline one."""
    knots = CLAMPED[4 - degree : len(CLAMPED) - 4 + degree]
    x = np.linspace(0.0, 4.0, 81)
    theirs = BSpline.design_matrix(x, knots, degree).toarray()
    for made in (b_splines, b_splines_by_divided_differences):
        assert_close(made(knots, degree, x), theirs, 1e-10)
    assert b_splines(knots, degree, 4.0)[-1] == 1.0
    assert (b_splines(knots, degree, np.nextafter(4.0, 5.0)) == 0).all()


def test_cardinal_b_splines_are_integrals():
    """N_k(x) = ∫ N_(k-1) over [x - 1, x], by quadrature. At its knots N₃ is (1, 4, 1)/6."""
    for degree in (1, 2, 3):
        for x in (0.3, 1.0, 1.9, 2.6):
            integral = quad(
                lambda t, k=degree: float(cardinal_b_spline(k - 1, t)),
                x - 1,
                x,
                points=[math.floor(x)],
                epsabs=1e-12,
            )[0]
            assert float(cardinal_b_spline(degree, x)) == pytest.approx(integral, abs=1e-10)
    assert_close(6 * cardinal_b_spline(3, [0, 1, 2, 3, 4]), [0, 1, 4, 1, 0], 1e-14)


@pytest.mark.parametrize(
    ("knots", "degree", "words"),
    [
        ([0.0, 1.0], 1, "B-splines of degree 1 need 3 knots; got 2"),
        ([0.0, 2.0, 1.0], 1, r"knots must ascend; knots\[1\] is larger than the next"),
        ([[0.0, 1.0]], 0, r"knots must have the shape \(n,\)"),
        ([0.0, 1.0], -1, "degree must be an integer, 0 or more"),
    ],
)
def test_invalid_knots_are_refused(knots, degree, words):
    """Both functions refuse them."""
    for made in (b_splines, b_splines_by_divided_differences):
        with pytest.raises(ValueError, match=words):
            made(knots, degree, 0.5)
