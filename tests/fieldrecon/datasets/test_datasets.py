"""Synthetic data: point sets have their stated distributions; functions have exact gradients."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree
from scipy.stats import qmc

from fieldrecon import datasets
from fieldrecon.datasets.synthetic import (
    clustered,
    franke,
    halton,
    jittered_grid,
    power_of_sum,
    uniform,
)

EXACT = 1e-12
# Error of the sixth-order difference quotient below, for derivatives of the size of Franke's.
DIFFERENCE = 1e-8

POINT_SETS = {
    "uniform": lambda seed: uniform(60, 3, seed),
    "scrambled Halton": lambda seed: halton(60, 3, seed),
    "jittered grid": lambda seed: jittered_grid(4, 3, 0.7, seed),
    "clustered": lambda seed: clustered(60, 3, 4, 0.1, seed),
}


def difference_quotient(f, x, step=1e-3):
    """The gradient by central differences of order six."""
    columns = []
    for axis in np.eye(x.shape[-1]):
        by = {k: f(x + k * step * axis) - f(x - k * step * axis) for k in (1, 2, 3)}
        columns.append((45 * by[1] - 9 * by[2] + by[3]) / (60 * step))
    return np.stack(columns, axis=-1)


def radical_inverse(i, base):
    """The number whose digits after the point are those of i in reverse order."""
    mirrored, weight = 0.0, 1.0
    while i:
        i, digit = divmod(i, base)
        weight /= base
        mirrored += digit * weight
    return mirrored


@pytest.mark.parametrize("draw", POINT_SETS.values(), ids=POINT_SETS)
def test_a_seed_determines_the_points(draw):
    """Equal seeds give equal points and other seeds other points, all in the unit cube."""
    points = draw(5)
    assert np.array_equal(points, draw(5))
    assert not np.array_equal(points, draw(6))
    assert np.all((points >= 0) & (points <= 1))
    assert len(np.unique(points, axis=0)) == len(points)


@pytest.mark.parametrize("draw", POINT_SETS.values(), ids=POINT_SETS)
def test_the_seed_may_be_a_generator(draw):
    """A generator made from a seed first draws the same points, and then other points."""
    rng = np.random.default_rng(5)
    first = draw(rng)
    assert np.array_equal(first, draw(5))
    assert not np.array_equal(first, draw(rng))


def test_halton_points_are_radical_inverses():
    """Coordinate k of point i is the radical inverse of i in the k-th prime."""
    literal = [[radical_inverse(i, prime) for prime in (2, 3, 5)] for i in range(200)]
    np.testing.assert_allclose(halton(200, 3), literal, atol=EXACT)


def test_halton_points_have_low_discrepancy():
    """Their centred discrepancy is less than a fifth of that of random points."""
    assert qmc.discrepancy(halton(256, 2)) < 0.2 * qmc.discrepancy(uniform(256, 2, seed=0))


@given(side=st.integers(1, 7), d=st.integers(1, 3), jitter=st.floats(0, 1), seed=st.integers(0, 99))
def test_a_jittered_grid_has_one_point_in_each_cell(side, d, jitter, seed):
    """The distance to the centre of the cell is at most half the jitter in each coordinate."""
    points = jittered_grid(side, d, jitter, seed) * side
    cells = np.floor(points)
    assert len(np.unique(cells, axis=0)) == side**d == len(points)
    assert np.all(np.abs(points - cells - 0.5) <= jitter / 2 + EXACT)


def test_clustered_points_are_closer_than_uniform_points():
    """The median distance to the nearest neighbour is less than 0.3 of that of uniform points."""

    def nearest(points):
        return np.median(cKDTree(points).query(points, k=2)[0][:, 1])

    crowded = clustered(400, 2, clusters=5, spread=0.02, seed=3)
    assert nearest(crowded) < 0.3 * nearest(uniform(400, 2, seed=3))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: uniform(-1, 2, seed=0), "n must be an integer, 0 or more; got -1"),
        (lambda: uniform(3, 2.5, seed=0), "d must be an integer, 1 or more; got 2.5"),
        (lambda: halton(True, 2), "n must be an integer, 0 or more; got True"),
        (lambda: jittered_grid(3, 2, 1.5, seed=0), "jitter must be between 0 and 1; got 1.5"),
        (lambda: clustered(9, 2, 0, 0.1, seed=0), "clusters must be an integer, 1 or more"),
        (lambda: clustered(9, 2, 2, math.nan, seed=0), "spread must be a positive number; got nan"),
        (lambda: power_of_sum(-1), "n must be an integer, 0 or more; got -1"),
        (lambda: franke([1.0, 2.0, 3.0]), "x must have 2 coordinates per point"),
    ],
)
def test_invalid_arguments_are_refused(call, words):
    """The message names the argument, what came and what was wanted."""
    with pytest.raises(ValueError, match=words):
        call()


@pytest.mark.parametrize("field", [franke, *map(power_of_sum, range(9))], ids=lambda f: f.name)
def test_gradients_are_exact(field):
    """The gradient agrees with a difference quotient of order six."""
    x = uniform(40, 2, seed=1)
    gradient = field.gradient(x)
    assert gradient.shape == (40, 2)
    scale = max(1, np.abs(gradient).max())
    np.testing.assert_allclose(gradient, difference_quotient(field, x), atol=DIFFERENCE * scale)


def test_the_difference_quotient_detects_a_wrong_gradient():
    """A relative error of 1e-6 in the gradient exceeds the tolerance of the test above tenfold."""
    x = uniform(40, 2, seed=1)
    wrong = franke.gradient(x) * (1 + 1e-6)
    assert np.abs(wrong - difference_quotient(franke, x)).max() > 10 * DIFFERENCE


def test_fields_take_points_of_any_shape():
    """Points (..., d) give values (...) and gradients (..., d); powers of the sum take any d."""
    x = uniform(24, 2, seed=2).reshape(2, 3, 4, 2)
    assert franke(x).shape == (2, 3, 4)
    assert franke.gradient(x).shape == x.shape
    assert power_of_sum(2)(uniform(7, 5, seed=0)).shape == (7,)
    assert power_of_sum(2).gradient([0.5]).tolist() == [1.0]


def test_the_power_of_the_sum_equals_the_computation_by_hand():
    """(0.25 + 0.5)³ = 27/64, and each derivative is 3 · (3/4)² = 27/16.

    The power 0 is 1 with derivative 0.
    """
    assert power_of_sum(3)([0.25, 0.5]) == 27 / 64
    assert power_of_sum(3).gradient([0.25, 0.5]).tolist() == [27 / 16, 27 / 16]
    assert power_of_sum(0)([0.0, 0.0]) == 1
    assert power_of_sum(0).gradient([0.0, 0.0]).tolist() == [0, 0]


def test_franke_at_the_origin_equals_the_computation_by_hand():
    """At the origin the four exponents are −2, −1/49 − 1/10, −58/4 and −65."""
    by_hand = (
        0.75 * math.exp(-2)
        + 0.75 * math.exp(-1 / 49 - 1 / 10)
        + 0.5 * math.exp(-58 / 4)
        - 0.2 * math.exp(-65)
    )
    assert float(franke([0.0, 0.0])) == pytest.approx(by_hand, abs=EXACT)


def test_franke_has_its_published_integral():
    """The integral over the unit square is published by the authors of Padua2DM.

    Caliari, De Marchi, Sommariva, Vianello, Padua2DM: fast interpolation and cubature at the Padua
    points in Matlab/Octave, Numerical Algorithms 56 (2011): 4.06969589491556e-01.
    """
    nodes, weights = np.polynomial.legendre.leggauss(40)
    x = np.stack(np.meshgrid(nodes, nodes), axis=-1) / 2 + 0.5
    assert weights @ franke(x) @ weights / 4 == pytest.approx(4.06969589491556e-01, abs=1e-14)


def test_all_names_in_all_exist():
    assert all(hasattr(datasets, name) for name in datasets.__all__)
