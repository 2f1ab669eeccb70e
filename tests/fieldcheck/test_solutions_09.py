"""The solutions of notebook 09 agree with the library."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from checkout import ROOT
from fieldcheck.questions.q03_radial_basis_functions import cloud
from fieldcheck.questions.q09_kernels import ring
from fieldgrade.authoring.sources import Source
from fieldrecon import RBF, HermiteRBF, polyharmonic, wendland
from fieldrecon.methods import derivatives_at, values_at
from fieldrecon.polynomials import monomials

NOTEBOOK = Source(ROOT / "solutions/09_kernels.py").functions()
each_power = pytest.mark.parametrize("k", [1, 2, 3, 4, 5])


@pytest.fixture
def random():
    return np.random.default_rng(909)


def least_eigenvalue(points, k, degree):
    """The least eigenvalue of the kernel's quadratic form under the side conditions of a degree."""
    a = NOTEBOOK["kernel"](NOTEBOOK["distances"](points, points), k)
    return NOTEBOOK["least_eigenvalue"](a, NOTEBOOK["monomials"](points, degree))


@each_power
def test_the_kernels_agree_with_the_library(random, k):
    """The signs agree, and the kernels are zero at zero."""
    r = np.append(random.uniform(0, 3, 20), 0.0)
    np.testing.assert_allclose(NOTEBOOK["kernel"](r, k), polyharmonic(k)(r), rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("degree", [0, 1, 2, 3, 4])
def test_the_monomials_agree_with_the_library(random, degree):
    """The order of the columns does not matter."""
    points = random.normal(size=(9, 2))
    theirs = monomials(points, degree).T
    mine = NOTEBOOK["monomials"](points, degree).T
    np.testing.assert_allclose(sorted(mine.tolist()), sorted(theirs.tolist()), rtol=1e-13)


@each_power
def test_the_order_of_conditional_positive_definiteness_is_sharp(random, k):
    """The form is positive with the required degree and not with one less, see (9.7)."""
    points = 3 * cloud(random, 25, 2)
    needed = polyharmonic(k).order - 1
    assert needed == k // 2
    assert least_eigenvalue(points, k, needed) > 0
    assert least_eigenvalue(points, k, needed + 1) > 0
    assert least_eigenvalue(points, k, needed - 1) < -1


@pytest.mark.parametrize(("n", "k", "radius"), [(5, 2, 2.0), (6, 4, 1.5)])
def test_rings_have_a_regular_matrix_for_too_low_a_degree(random, n, k, radius):
    """The inputs of 09.4 have them with the constant only."""
    for _ in range(30):
        points = ring(random, n, radius)
        a = NOTEBOOK["kernel"](NOTEBOOK["distances"](points, points), k)
        matrix = NOTEBOOK["saddle_point_matrix"](a, NOTEBOOK["monomials"](points, 0))
        assert np.linalg.cond(matrix) < 1e4
        assert least_eigenvalue(points, k, 0) < 0


@each_power
def test_the_field_agrees_with_the_library(random, k):
    """The degrees are the least admissible degree and one more."""
    points, values, x = cloud(random, 18, 2), random.normal(size=18), random.uniform(-1, 2, (30, 2))
    for degree in (k // 2, k // 2 + 1):
        theirs = RBF(points, polyharmonic(k), degree=degree).field(values)(x)
        mine = NOTEBOOK["interpolate"](points, values, k, degree, x)
        np.testing.assert_allclose(mine, theirs, atol=1e-8 * np.abs(theirs).max())


def test_the_cubic_kernel_with_constants_is_singular_for_a_triangle():
    """Model answer: the determinant changes its sign at the side lengths 1, 1, 2^(2/3)."""

    def determinant(base):
        sides = np.array([[0, 1, 1], [1, 0, base], [1, base, 0]])
        a = NOTEBOOK["kernel"](sides, 3)
        return np.linalg.det(np.block([[a, np.ones((3, 1))], [np.ones((1, 3)), np.zeros((1, 1))]]))

    singular = 2 ** (2 / 3)
    assert abs(determinant(singular)) < 1e-13
    assert determinant(singular - 0.1) * determinant(singular + 0.1) < -1e-3


def test_the_library_refuses_points_on_which_a_polynomial_vanishes(random):
    """It accepts all other points."""
    turn = np.linalg.qr(random.normal(size=(2, 2)))[0]
    angle = np.linspace(0, 6, 9)
    circle = np.stack([np.cos(angle), 0.5 * np.sin(angle)], axis=1) @ turn
    line = np.outer(cloud(random, 7, 1), turn[0])
    cases = ((circle, 1, 0), (circle, 2, 1), (line, 1, 1), (cloud(random, 9, 2), 2, 0))
    for points, degree, number in cases:
        assert NOTEBOOK["vanishing"](points, degree) == number
        if number:
            with pytest.raises(np.linalg.LinAlgError, match="determine"):
                RBF(points, polyharmonic(3), degree=degree)
        else:
            RBF(points, polyharmonic(3), degree=degree)


@pytest.mark.parametrize("d", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("s", [0, 1])
def test_the_wendland_functions_agree_with_the_library(random, d, s):
    """The book has a table of them, and the library continues it to all dimensions."""
    r = random.uniform(0, 1.5, 30)
    np.testing.assert_allclose(NOTEBOOK["wendland"](r, d, s), wendland(d, s)(r), atol=1e-14)


@pytest.mark.slow
def test_a_wendland_function_for_dimension_one_fails_in_the_plane():
    """Statement of the text on ψ₁₁: a smoothly damped checkerboard on 48² lattice points has a
    negative quadratic form; with the function for three variables the form is positive.
    """
    n, step = 48, 0.28
    hood = np.sin(np.pi * np.arange(1, n + 1) / (n + 1)) * (-1.0) ** np.arange(n)
    waves = np.outer(hood, hood).ravel()
    axis = step * np.arange(n)
    lattice = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    squared = sum(np.subtract.outer(c, c) ** 2 for c in lattice.T)
    r = np.sqrt(squared)
    assert waves @ NOTEBOOK["wendland"](r, 1, 1) @ waves < 0
    assert waves @ NOTEBOOK["wendland"](r, 3, 1) @ waves > 0


def test_the_exchange_time_is_where_the_orientation_changes(random):
    """The orientation of the triangle just before differs from the one just after."""
    for _ in range(20):
        points = random.normal(size=(3, 2))
        t = NOTEBOOK["exchange_time"](points)
        z = points @ [1, 1j]
        middle = (z[0] + z[1]) / 2
        areas = []
        for time in (t - 1e-6, t + 1e-6):
            one, two = middle + np.exp(1j * np.pi * time) * (z[:2] - middle)
            areas.append(((two - one) * np.conj(z[2] - one)).imag)
        assert np.prod(np.sign(areas)) == -1
        assert 0 <= t <= 1


def test_values_and_slopes_give_the_piecewise_cubic(random):
    """The field of (9.12) agrees with SciPy between the points, and with the library everywhere."""
    x = np.sort(cloud(random, 6, 1)[:, 0])
    v, g = random.normal(size=(2, 6))
    found = np.linalg.solve(NOTEBOOK["slope_matrix"](x), np.concatenate([v, g, [0, 0]]))

    def field(t):
        z = np.subtract.outer(t, x)
        terms = np.hstack([np.abs(z) ** 3, -3 * z * np.abs(z)])
        return terms @ found[:12] + found[12] + found[13] * t

    inside, around = np.linspace(x[0], x[-1], 50), np.linspace(-1, 2, 50)
    cubic = CubicHermiteSpline(x, v, g)(inside)
    np.testing.assert_allclose(field(inside), cubic, atol=1e-9 * np.abs(found).max())
    points = x[:, None]
    method = HermiteRBF([values_at(points), derivatives_at(points, np.ones(1))], polyharmonic(3))
    theirs = method.field(np.concatenate([v, g]))(around[:, None])
    np.testing.assert_allclose(field(around), theirs, atol=1e-8 * np.abs(theirs).max())
