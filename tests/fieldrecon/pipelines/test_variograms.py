"""The variogram: its bins are semivariances, and its model finds nugget, sill and range."""

import numpy as np
import pytest

from fieldrecon.datasets.synthetic import uniform
from fieldrecon.pipelines.variograms import variogram

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


def test_units_change_nothing_but_units():
    one = variogram(POINTS, np.sin(9 * POINTS[:, 0]))
    other = variogram(1e6 * POINTS, 1e3 * np.sin(9 * POINTS[:, 0]))
    np.testing.assert_allclose(other.sill, 1e6 * one.sill, rtol=1e-6)
    np.testing.assert_allclose(other.range, 1e6 * one.range, rtol=1e-6)


def test_samples_that_are_all_far_apart_have_pairs():
    """Corners of an icosahedron, none of which is within half its diameter of another."""
    golden = (1 + np.sqrt(5)) / 2
    corners = np.array([[0, a, b] for a in (-1, 1) for b in (-golden, golden)])
    corners = np.concatenate([np.roll(corners, k, axis=1) for k in range(3)])
    found = variogram(corners, corners[:, 0])
    assert np.isfinite([found.nugget, found.sill, found.range]).all()


def test_few_samples_have_no_variogram():
    with pytest.raises(ValueError, match="at least 10 samples; got 9"):
        variogram(POINTS[:9], POINTS[:9, 0])
