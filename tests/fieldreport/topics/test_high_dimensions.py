"""High dimensions: the claims of the experiment, compared with independent computations."""

import math
from itertools import combinations_with_replacement

import numpy as np
import pytest

from fieldrecon.datasets.synthetic import uniform
from fieldrecon.kernels.positive_definite import wendland
from fieldreport.experiments.methods.high_dimensions import (
    FIELDS,
    METHODS,
    QUICK,
    Geometry,
    additive,
    counting,
    errors,
    largest_correlation,
    pairs,
    sites,
)

VARIABLES = (3, 10, 40)


@pytest.fixture(scope="module", params=VARIABLES)
def geometry(request):
    return Geometry.of(400, 40, 1, request.param)


def told(geometry, what):
    return dict(zip(Geometry.COLUMNS, geometry.row(), strict=True))[what]


def test_distances_spread_as_the_central_limit_says(geometry):
    """The squares have mean D/6 and variance 7 D/180, so distances spread by 0.59 / sqrt(D)."""
    d = geometry.variables
    expected = math.sqrt(7 / 180 * d) / (2 * d / 6)
    assert geometry.spread == pytest.approx(expected, rel=0.12)


def test_polynomials_are_as_many_as_can_be_listed(geometry):
    """Of degree 2: one for each multiset of at most two variables."""
    d = geometry.variables
    listed = sum(1 for m in range(3) for _ in combinations_with_replacement(range(d), m))
    assert told(geometry, "of degree 2") == listed


@pytest.mark.parametrize("d", [3, 6, 10])
def test_the_degree_of_wendland_s_function_is_told(d):
    """Its interpolant of that degree is the function on its support, that of one less is not."""
    degree = told(Geometry.of(30, 5, 1, d), "degree of Wendland's function")
    interpolant = np.polynomial.chebyshev.Chebyshev.interpolate
    phi, r = wendland(d, 1), np.linspace(0, 1, 50)
    same, other = (
        np.abs(interpolant(phi, m, domain=[0, 1])(r) - phi(r)).max() for m in (degree, degree - 1)
    )
    assert same < 1e-12
    assert other > 1e-6


def test_wendland_s_function_is_at_half_its_height_where_it_is_said(geometry):
    """As a part of its radius."""
    half = told(geometry, "its width at half height / radius")
    assert wendland(geometry.variables, 1)(np.array(half)) == pytest.approx(0.5)


def test_the_sites_that_count_are_known_for_equal_weights(monkeypatch):
    """All of them; and one, if the others weigh nothing."""
    x, q = uniform(200, 3, seed=1), uniform(10, 3, seed=2)
    module = "fieldreport.experiments.methods.high_dimensions.wendland"
    monkeypatch.setattr(module, lambda *_: np.ones_like)
    assert counting(x, q) == pytest.approx(16)
    monkeypatch.setattr(module, lambda *_: lambda r: (r == r[:, :1]).astype(float))
    assert counting(x, q) == pytest.approx(1)


def test_halton_s_last_columns_climb_together_and_scrambled_ones_do_not():
    """A thousand points in a hundred variables."""
    kinds = "halton", "scrambled"
    plain, scrambled = (largest_correlation(sites(1000, 100, kind, 1)) for kind in kinds)
    assert plain > 0.95
    assert scrambled < 0.2


def test_functions_are_what_they_are_called():
    """A sum of functions of one variable has no mixed differences; the pairs only mixed ones."""
    x = uniform(50, 6, seed=3)
    step = np.zeros((2, 6))
    step[0, 1], step[1, 4] = 0.1, 0.2
    for f, mixed in ((additive, False), (pairs, True)):
        difference = f(x + step.sum(axis=0)) - f(x + step[0]) - f(x + step[1]) + f(x)
        assert (np.abs(difference).max() > 1e-3) == mixed
    twice = pairs(x + step[0]) - 2 * pairs(x) + pairs(x - step[0])
    assert np.abs(twice).max() < 1e-10


def test_what_polynomials_know_is_exact_and_the_right_variables_are_worth_all():
    """Quadratics reproduce products of pairs; the cubic on two variables beats that on ten."""
    found = errors(QUICK, (10, 150, "random"))
    names = [f.__name__ for f in FIELDS]
    assert found[METHODS.index("quadratic"), names.index("pairs")] < 1e-10
    assert found[METHODS.index("linear"), names.index("pairs")] > 0.5
    assert found[-1, names.index("few")] < 0.1 * found[METHODS.index("cubic"), names.index("few")]
