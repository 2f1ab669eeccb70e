"""Means of blocks: affine fields pass, noise does not, and no sample counts twice."""

import numpy as np
import pytest

from fieldrecon.datasets.synthetic import clustered, uniform
from fieldrecon.pipelines import block_means

CLOUDS = {
    "even": uniform(1000, 2, seed=1),
    "clusters": clustered(1000, 3, clusters=5, spread=0.01, seed=2),
    "line": np.linspace(0.0, 1.0, 1000)[:, None],
    "plane in space": uniform(1000, 2, seed=3) @ np.array([[1.0, 0.0, 2.0], [0.0, 1.0, -1.0]]),
}


def affine(points):
    return 3.0 + points @ np.arange(1.0, 1.0 + points.shape[1])


def affine_error(means, points):
    """How far the means of an affine field are from the field at the mean points."""
    places, values = means(points, affine(points), 60)
    return np.abs(values - affine(places)).max()


@pytest.mark.parametrize("name", CLOUDS)
def test_affine_fields_pass(name):
    """A mean of an affine field is the field at the mean point."""
    assert affine_error(block_means, CLOUDS[name]) < 1e-13


def test_places_that_are_no_means_would_be_seen():
    """With the middles of boxes in place of the mean points, an affine field does not pass."""

    def mutant(points, values, count):
        places, means = block_means(points, values, count)
        return places.round(1), means

    assert affine_error(mutant, CLOUDS["even"]) > 1e-3


@pytest.mark.parametrize("count", [1, 7, 60, 999, 1000])
def test_every_sample_counts_once(count):
    """Of unit vectors as values, the means have the reciprocals of the blocks' sizes, once each."""
    points = CLOUDS["even"]
    _, means = block_means(points, np.eye(1000), count)
    assert ((means > 0).sum(axis=0) == 1).all()
    np.testing.assert_allclose(means.sum(axis=1), 1.0, rtol=1e-12)
    sizes = (means > 0).sum(axis=1)
    assert sizes.max() - sizes.min() <= 1
    assert count <= len(means) <= max(1.2 * count + 1, count)


def test_noise_shrinks_by_the_root_of_the_block():
    """Means of 25 errors of size one have a fifth of it."""
    points = uniform(20_000, 2, seed=4)
    noise = np.random.default_rng(5).standard_normal(len(points))
    _, means = block_means(points, noise, 800)
    size = len(points) / len(means)
    assert means.std() * np.sqrt(size) == pytest.approx(1.0, abs=0.1)


def test_as_many_blocks_as_samples_change_nothing():
    """Each sample is a block of its own, in another order."""
    points = CLOUDS["clusters"]
    places, means = block_means(points, affine(points), len(points))
    np.testing.assert_array_equal(np.sort(means), np.sort(affine(points)))
    np.testing.assert_array_equal(np.unique(places, axis=0), np.unique(points, axis=0))


@pytest.mark.parametrize("count", [0, -1, 2.5, True])
def test_a_count_that_is_none_is_refused(count):
    """The number of blocks is a positive integer."""
    with pytest.raises(ValueError, match=r"count must be a positive integer; got"):
        block_means(CLOUDS["even"], np.zeros(1000), count)


def test_more_blocks_than_samples_are_refused():
    """A block without samples has no mean."""
    with pytest.raises(ValueError, match="count must be at most 1000, the number of points"):
        block_means(CLOUDS["even"], np.zeros(1000), 1001)
