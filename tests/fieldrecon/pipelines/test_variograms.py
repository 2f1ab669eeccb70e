"""The variogram: its bins are semivariances, and its model finds nugget, sill and range."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from fieldrecon.datasets.synthetic import uniform
from fieldrecon.pipelines.variograms import Variogram, variogram

POINTS = uniform(400, 2, seed=0)
DISTANCE = np.linalg.norm(POINTS[:, None] - POINTS, axis=-1)


def random_fields(count, nugget):
    """Fields of the exponential model with the sill 1 and the range 0.3, and noise."""
    rng = np.random.default_rng(1)
    factor = np.linalg.cholesky(np.exp(-DISTANCE / 0.1) + 1e-9 * np.eye(len(POINTS)))
    noise = np.sqrt(nugget) * rng.standard_normal((len(POINTS), count))
    return factor @ rng.standard_normal((len(POINTS), count)) + noise


@pytest.mark.slow
def test_nugget_sill_and_range_are_those_of_random_fields():
    """In the median over fields, to a quarter."""
    found = [variogram(POINTS, z) for z in random_fields(40, nugget=0.3).T]
    median = np.median([(v.nugget, v.sill, v.range) for v in found], axis=0)
    np.testing.assert_allclose(median, [0.3, 1.3, 0.3], rtol=0.25)


def test_a_plane_has_neither_nugget_nor_range():
    """Its semivariance grows without bound: that of x is a quarter of h^2 on the mean."""
    found = variogram(POINTS, POINTS[:, 0])
    assert found.nugget < 1e-3
    assert not found.levels_off
    assert found.range_in_words.startswith("more than 0.6")
    np.testing.assert_allclose(found.values[:5], found.distances[:5] ** 2 / 4, rtol=0.2)
    line = np.linspace(0, 3, 400)[:, None]  # distances of up to 1.5 are compared
    assert variogram(line, line[:, 0]).range == pytest.approx(20 * 1.5)


def literal_bins(points, values):
    """Mean distance, half the mean square of the differences, and number of the pairs of a bin."""
    n = len(points)
    pairs = [(i, j) for i in range(n) for j in range(i)]
    h = np.array([np.linalg.norm(points[i] - points[j]) for i, j in pairs])
    squares = np.array([(values[i] - values[j]) ** 2 for i, j in pairs])
    edges = np.linspace(0, max(h.max() / 2, np.median(h)), 21)
    edges[-1] *= 1 + 1e-12
    found = [(h >= low) & (h < high) for low, high in pairwise(edges)]
    return np.array([(h[b].mean(), squares[b].mean() / 2, b.sum()) for b in found if b.any()]).T


@pytest.mark.parametrize(
    ("n", "squeezed", "apart"), [(90, 1.0, 0.0), (12, 1e-3, 0.0), (11, 1.0, 30.0)]
)
def test_the_bins_are_those_of_all_pairs_and_the_model_is_their_least_squares(n, squeezed, apart):
    """With the weights N / h^2 no model near by, with other numbers, is closer to the bins.

    In two clusters the median distance is the largest that is compared.
    """
    points = POINTS[:n] * [1.0, squeezed] + np.outer(np.arange(n) % 2, [apart, 0.0])
    values = np.sin(9 * POINTS[:n, 0]) + np.random.default_rng(0).standard_normal(n) / 3
    h, half, count = literal_bins(points, values)
    found = variogram(points, values)
    np.testing.assert_allclose(found.distances, h)
    np.testing.assert_allclose(found.values, half)

    def misfit(**changed):
        model = replace(found, **changed)(h)
        return np.sum(count / h**2 * (model - half) ** 2)

    for name in ("nugget", "sill", "range"):
        for factor in (0.9, 1.13):
            assert misfit(**{name: factor * getattr(found, name)}) >= misfit()


def test_the_model_rises_from_the_nugget_to_95_percent_at_the_range():
    model = Variogram(np.array([5.0]), np.array([1.0]), nugget=2.0, sill=7.0, range=4.0)
    h = np.array([0.0, 4.0, 1e3])
    np.testing.assert_allclose((model(h) - 2.0) / 5.0, [0.0, 1 - np.exp(-3), 1.0])
    assert model.levels_off
    assert not replace(model, range=5.1).levels_off


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (0.01234, "0.0123"),
        (99.44, "99.4"),
        (100.4, "100"),
        (9999999.4, "9,999,999"),
        (1e7, "1e+07"),
    ],
)
def test_numbers_are_written_without_a_power_of_ten_where_they_can_be(number, words):
    model = Variogram(np.array([1e9]), np.array([1.0]), nugget=number, sill=number, range=number)
    assert (model.nugget_in_words, model.sill_in_words, model.range_in_words) == (words,) * 3


def test_units_change_nothing_but_units():
    one = variogram(POINTS, np.sin(9 * POINTS[:, 0]))
    for length, size in ((1e6, 1e3), (1e-6, 1e-12)):
        other = variogram(length * POINTS, size * np.sin(9 * POINTS[:, 0]))
        np.testing.assert_allclose(other.sill, size**2 * one.sill, rtol=1e-6)
        np.testing.assert_allclose(other.range, length * one.range, rtol=1e-6)


def test_a_constant_does_not_vary():
    found = variogram(POINTS, np.full(400, 7.0))
    assert (found.nugget, found.sill) == (0.0, 0.0)
    assert not found.values.any()


def test_samples_that_are_all_far_apart_have_pairs():
    """Corners of an icosahedron, none of which is within half its diameter of another."""
    golden = (1 + np.sqrt(5)) / 2
    corners = np.array([[0, a, b] for a in (-1, 1) for b in (-golden, golden)])
    corners = np.concatenate([np.roll(corners, k, axis=1) for k in range(3)])
    found = variogram(corners, corners[:, 0])
    assert np.isfinite([found.nugget, found.sill, found.range]).all()
    equally_far = variogram(np.eye(10), np.arange(10.0))
    np.testing.assert_allclose(equally_far.distances, [np.sqrt(2)])
    np.testing.assert_allclose(equally_far.values, np.arange(10.0).var(ddof=1))


def test_few_samples_have_no_variogram():
    with pytest.raises(ValueError, match="at least 10 samples; got 9"):
        variogram(POINTS[:9], POINTS[:9, 0])
