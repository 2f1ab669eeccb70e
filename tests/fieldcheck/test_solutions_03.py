"""The solutions of notebook 03 agree with the library."""

import numpy as np
import pytest

from checkout import ROOT
from fieldcheck.notebook import try_public
from fieldcheck.questions import get
from fieldcheck.questions.q03_radial_basis_functions import cloud
from fieldgrade.authoring.sources import Source
from fieldrecon import RBF, thin_plate_spline

NOTEBOOK = Source(ROOT / "solutions/03_radial_basis_functions.py").functions()
each_dimension = pytest.mark.parametrize("d", [1, 2, 3])
PLATE = thin_plate_spline()


@pytest.fixture
def random():
    return np.random.default_rng(303)


@each_dimension
def test_kernel_and_matrix_agree_with_the_library(random, d):
    """The notebook's kernel takes a vector; both matrices have the same order of the borders."""
    points = cloud(random, 12, d)
    y = points - points[3]
    np.testing.assert_allclose(NOTEBOOK["kernel"](y), PLATE(np.linalg.norm(y, axis=1)), atol=1e-13)
    mine, theirs = NOTEBOOK["system_matrix"](points), RBF(points, PLATE).matrix()
    np.testing.assert_allclose(mine, theirs, atol=1e-13)


@each_dimension
def test_coefficients_agree_with_the_library(random, d):
    """The library solves by Cholesky on the null space of the constraints."""
    points, values = cloud(random, 15, d), random.normal(size=15)
    lam, c = NOTEBOOK["coefficients"](points, values)
    theirs, polynomial = RBF(points, PLATE).coefficients(values)
    np.testing.assert_allclose(lam, theirs, atol=1e-10 * np.abs(theirs).max())
    np.testing.assert_allclose(c, polynomial, atol=1e-10 * np.abs(theirs).max())


@each_dimension
def test_field_and_gradient_agree_with_the_library(random, d):
    """They agree at arbitrary points and at the sites, where the logarithm has no value."""
    points, values = cloud(random, 15, d), random.normal(size=15)
    x = np.concatenate([random.normal(size=(20, d)), points])
    given = points, *NOTEBOOK["coefficients"](points, values), x
    field = RBF(points, PLATE).field(values)
    np.testing.assert_allclose(NOTEBOOK["evaluate"](*given), field(x), atol=1e-9)
    np.testing.assert_allclose(NOTEBOOK["gradient"](*given), field.gradient(x), atol=1e-8)


@each_dimension
def test_the_matrix_has_the_inertia_of_the_theorem(random, d):
    """N positive and d + 1 negative eigenvalues, unless the points lie in a hyperplane."""
    points = cloud(random, 11, d)
    assert NOTEBOOK["inertia"](points) == (11, d + 1, 0)
    raised = np.column_stack([points, np.ones(11)])
    assert NOTEBOOK["inertia"](raised) == (11, d + 1, 1)


def test_the_energy_is_the_integral_of_the_squared_second_derivatives(random):
    """Differences of the library's gradient on a grid, with an extrapolation of the far field."""
    points, values = cloud(random, 6, 2), random.normal(size=6)
    field, h = RBF(points, PLATE).field(values), 1e-4

    def integral(reach: float) -> float:
        """The integral over the square |x - 1/2| < reach, by the midpoint rule."""
        cell = 2 * reach / 240
        side = 0.5 - reach + cell * (np.arange(240) + 0.5)
        x = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
        second = [field.gradient(x + e) - field.gradient(x - e) for e in h * np.eye(2)]
        return float(np.sum(np.square(second)) / (2 * h) ** 2 * cell**2)

    # The part outside falls like 1 / reach²: one step of Richardson extrapolation.
    extrapolated = integral(6.0) + (integral(6.0) - integral(3.0)) / 3
    assert NOTEBOOK["energy"](points, values) == pytest.approx(extrapolated, rel=0.03)


def test_the_error_of_a_small_kernel_is_reported_as_it_is():
    """Small kernels are compared in a unit in which they are one; the sentence has no such unit."""

    def disturbed(points):
        h = NOTEBOOK["system_matrix"](points)
        h[3, 2] += 1e-8 * (np.ptp(points) < 0.01)
        return h

    verdict = try_public(get("03.2"), {"system_matrix": disturbed})
    assert "entry [3, 2] is off by 1e-08" in verdict.sentence
