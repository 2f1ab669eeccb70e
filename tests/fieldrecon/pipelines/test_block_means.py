"""Block means: affine fields are reproduced, noise is averaged, and every sample counts once."""

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
    """Largest error of the block means of an affine field at the mean points."""
    centers, values = means(points, affine(points), 60)
    return np.abs(values - affine(centers)).max()


@pytest.mark.parametrize("name", CLOUDS)
def test_block_means_reproduce_affine_fields(name):
    """The mean of an affine field over a block is its value at the mean point of the block."""
    assert affine_error(block_means, CLOUDS[name]) < 1e-13


def test_rounded_mean_points_do_not_reproduce_affine_fields():
    """A mutant that rounds the mean points has an error above 1e-3, so the test above can fail."""

    def mutant(points, values, count):
        centers, means = block_means(points, values, count)
        return centers.round(1), means

    assert affine_error(mutant, CLOUDS["even"]) > 1e-3


@pytest.mark.parametrize("count", [1, 7, 60, 999, 1000])
def test_every_sample_belongs_to_exactly_one_block(count):
    """For unit vectors as values, each row of means sums to one.

    The sizes of the blocks differ by at most one.
    """
    points = CLOUDS["even"]
    _, means = block_means(points, np.eye(1000), count)
    assert ((means > 0).sum(axis=0) == 1).all()
    np.testing.assert_allclose(means.sum(axis=1), 1.0, rtol=1e-12)
    sizes = (means > 0).sum(axis=1)
    assert sizes.max() - sizes.min() <= 1
    assert count <= len(means) <= max(1.2 * count + 1, count)


def test_block_means_reduce_noise_by_the_square_root_of_the_block_size():
    """The mean of 25 independent errors has a fifth of their standard deviation."""
    points = uniform(20_000, 2, seed=4)
    noise = np.random.default_rng(5).standard_normal(len(points))
    _, means = block_means(points, noise, 800)
    size = len(points) / len(means)
    assert means.std() * np.sqrt(size) == pytest.approx(1.0, abs=0.1)


def test_one_sample_per_block_reproduces_the_samples():
    """Points and values are those of the samples, in another order."""
    points = CLOUDS["clusters"]
    centers, means = block_means(points, affine(points), len(points))
    np.testing.assert_array_equal(np.sort(means), np.sort(affine(points)))
    np.testing.assert_array_equal(np.unique(centers, axis=0), np.unique(points, axis=0))


@pytest.mark.parametrize("count", [0, -1, 2.5, True])
def test_a_count_that_is_not_a_positive_integer_is_refused(count):
    with pytest.raises(ValueError, match=r"count must be a positive integer; got"):
        block_means(CLOUDS["even"], np.zeros(1000), count)


def test_more_blocks_than_samples_are_refused():
    """A block without samples has no mean."""
    with pytest.raises(ValueError, match="count must be at most 1000, the number of points"):
        block_means(CLOUDS["even"], np.zeros(1000), 1001)
