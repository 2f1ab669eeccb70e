"""The solutions of notebook 01 agree with the library."""

import numpy as np
import pytest

from checkout import ROOT
from fieldgrade.authoring.sources import Source
from fieldrecon import LeastSquares
from fieldrecon.methods.least_squares import monomial_matrix, normal_equations

NOTEBOOK = Source(ROOT / "solutions/01_least_squares.py").functions()
CLOUDS = [np.random.default_rng(d).random((4 * d + 3, d)) for d in (1, 2, 3, 5)]
ROUNDING = 1e-11
each_cloud = pytest.mark.parametrize("points", CLOUDS, ids=["1-D", "2-D", "3-D", "5-D"])


@each_cloud
def test_the_matrix_agrees_with_the_library(points):
    """B of the notebook is the matrix of the monomials of degree at most one."""
    np.testing.assert_array_equal(NOTEBOOK["basis_matrix"](points), monomial_matrix(points, 1))


@each_cloud
def test_the_fit_agrees_with_the_library(points):
    """The library solves the problem by normal equations and by a factorization."""
    values = np.sin(3 * points).sum(axis=1)
    c = NOTEBOOK["fit"](points, values)
    np.testing.assert_allclose(c, normal_equations(points, values), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(c, LeastSquares(points).coefficients(values), rtol=0, atol=ROUNDING)


@each_cloud
def test_field_gradient_and_objective_agree_with_the_library(points):
    values = np.cos(2 * points).sum(axis=1)
    method = LeastSquares(points)
    field, c, x = method.field(values), method.coefficients(values), points[:3] + 0.1
    np.testing.assert_allclose(NOTEBOOK["evaluate"](c, x), field(x), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(NOTEBOOK["gradient"](c, x), field.gradient(x), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(
        NOTEBOOK["objective"](points, values, c), method.objective(values), rtol=0, atol=ROUNDING
    )


@each_cloud
def test_the_library_accepts_points_of_full_rank_only(points):
    """Points in a hyperplane have a rank of one less."""
    d = points.shape[1]
    assert NOTEBOOK["rank"](points) == d + 1
    flat = points.copy()
    flat[:, -1] = flat[:, :-1].sum(axis=1) + 2
    assert NOTEBOOK["rank"](flat) == d
    with pytest.raises(np.linalg.LinAlgError, match=f"rank {d} of {d + 1}"):
        LeastSquares(flat)
