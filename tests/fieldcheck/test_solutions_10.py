"""The solutions of notebook 10 agree with the library."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from checkout import ROOT
from fieldcheck.questions.q10_natural_splines import line
from fieldgrade.authoring.sources import Source
from fieldrecon import RBF, NaturalCubicSpline, polyharmonic
from fieldrecon.methods import b_splines as recursion
from fieldrecon.methods.spline_bases import b_splines_by_divided_differences, radial_form

NOTEBOOK = Source(ROOT / "solutions/10_natural_splines.py").functions()
each_number = pytest.mark.parametrize("n", [2, 3, 8, 20])


@pytest.fixture
def random():
    return np.random.default_rng(1010)


@each_number
def test_the_coefficients_of_cubed_distances_agree_with_the_library(random, n):
    """The library has two routes: the tridiagonal system, and the general RBF method."""
    sites, values = line(random, n), random.normal(size=n)
    a, b = NOTEBOOK["radial_spline"](sites, values)
    method = NaturalCubicSpline(sites)
    for alpha, beta in (
        method.coefficients(values),
        RBF(sites[:, None], polyharmonic(3)).coefficients(values),
    ):
        np.testing.assert_allclose(a, alpha, atol=1e-9 * max(1, np.abs(alpha).max()))
        np.testing.assert_allclose(b, beta, atol=1e-9 * np.abs(beta).max())


@each_number
def test_the_conversion_to_cubed_distances_agrees_with_the_library(random, n):
    """Truncated powers are converted, and the route by moments gives the direct solution."""
    sites, values = line(random, n), random.normal(size=n)
    alpha, beta = NaturalCubicSpline(sites).truncated_powers(values)
    mine = NOTEBOOK["from_truncated"](sites, alpha, beta)
    theirs = radial_form(sites, alpha, beta)
    way = NOTEBOOK["truncated"](sites, values, NOTEBOOK["moments"](sites, values))
    for one, other in zip((*mine, *way), (*theirs, alpha, beta), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9 * max(1, np.abs(other).max()))


@each_number
def test_the_piecewise_spline_agrees_with_the_library(random, n):
    """They agree inside, outside and at the sites; SciPy's second derivatives are the moments."""
    sites, values = line(random, n), random.normal(size=n)
    bends = NOTEBOOK["moments"](sites, values)
    x = np.append(random.uniform(sites[0] - 3, sites[-1] + 3, 50), sites)
    mine = NOTEBOOK["piecewise"](sites, values, bends, x)
    np.testing.assert_allclose(mine, NaturalCubicSpline(sites).field(values)(x), atol=1e-11)
    if n > 2:
        theirs = CubicSpline(sites, values, bc_type="natural")(sites, 2)
        np.testing.assert_allclose(bends, theirs, atol=1e-11 * np.abs(theirs).max())


def test_the_spline_is_linear_outside_and_scipys_is_not(random):
    """The text warns of programs that only require s'' = 0 at the ends."""
    sites, values = line(random, 7), random.normal(size=7)
    bends = NOTEBOOK["moments"](sites, values)
    x = sites[-1] + np.arange(1.0, 5.0)
    mine = NOTEBOOK["piecewise"](sites, values, bends, x)
    theirs = CubicSpline(sites, values, bc_type="natural")(x)
    np.testing.assert_allclose(np.diff(mine, 2), 0, atol=1e-11)
    assert np.abs(np.diff(theirs, 2)).min() > 0.1


@each_number
def test_the_energy_agrees_with_the_library_and_is_minimal(random, n):
    """Three routes agree; the energy of another interpolant is larger by that of the difference."""
    sites, values = line(random, n), random.normal(size=n)
    mine = NOTEBOOK["energy"](sites, NOTEBOOK["moments"](sites, values))
    a, _ = NOTEBOOK["radial_spline"](sites, values)
    theirs = NaturalCubicSpline(sites).energy(values)
    assert mine == pytest.approx(theirs, rel=1e-9, abs=1e-12)
    assert mine == pytest.approx(12 * a @ values, rel=1e-7, abs=1e-9)
    clamped = CubicSpline(sites, values, bc_type="clamped")
    of_other = NOTEBOOK["energy"](sites, clamped(sites, 2))
    wave = NOTEBOOK["energy"](sites, clamped(sites, 2) - NOTEBOOK["moments"](sites, values))
    assert of_other == pytest.approx(mine + wave, rel=1e-9)
    assert wave > 0


@pytest.mark.parametrize("degree", [0, 1, 2, 3, 4])
def test_the_b_splines_agree_with_the_library(random, degree):
    """The library uses recursion or divided differences of truncated powers; one knot is double."""
    knots = line(random, 12)
    knots[5] = knots[6]
    x = np.append(random.uniform(knots[0] - 1, knots[-1] + 1, 60), knots[:-1])
    mine = NOTEBOOK["b_splines"](knots, degree, x)
    np.testing.assert_allclose(mine, recursion(knots, degree, x), atol=1e-13)
    theirs = b_splines_by_divided_differences(knots, degree, x)
    np.testing.assert_allclose(mine, theirs, atol=1e-8)


def test_the_influence_of_a_value_decays_by_two_minus_root_three():
    """The factor per interval of equal length is −(2 − √3), a root of the recurrence."""
    sites = np.arange(41.0)
    one = (sites == 20).astype(float)
    at = NOTEBOOK["piecewise"](sites, one, NOTEBOOK["moments"](sites, one), 24.5 + np.arange(4))
    np.testing.assert_allclose(at[1:] / at[:-1], -(2 - np.sqrt(3)), rtol=1e-6)
