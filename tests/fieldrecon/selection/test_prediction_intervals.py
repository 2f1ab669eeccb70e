"""Prediction bands cover 95 of 100 values, at the samples and at held-out points."""

import numpy as np
import pytest

import fieldrecon as fr
from fieldrecon.selection.extrapolation import AMONG, extrapolated
from fieldrecon.selection.prediction_intervals import COVERAGE, ErrorEstimate


def steep(x):
    """A front across the square, ten times as steep as the rest of the field."""
    return np.tanh(20 * (x[..., 0] - 0.5)) + 0.3 * x[..., 1]


CLOUDS = {
    "uniform": lambda n, seed: fr.datasets.uniform(n, 2, seed),
    "clustered": lambda n, seed: fr.datasets.clustered(n, 2, 10, 0.2, seed),
}
FIELDS = {"franke": fr.datasets.franke, "steep": steep}
METHODS = {
    "patches": fr.PartitionOfUnityRBF,
    "cubic": lambda p: fr.RBF(p, fr.polyharmonic(3)),
    "mls": lambda p: fr.MovingLeastSquares(p, fr.wendland(3, 1), 1, 12),
    "ls": lambda p: fr.LeastSquares(p, 4),
}


@pytest.mark.parametrize("noise", [0.0, 0.05])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("cloud", CLOUDS)
def test_the_band_covers_95_percent_of_held_out_samples(cloud, field, method, noise):
    """The coverage of samples that were not fitted is between 0.93 and 0.995, also with noise."""
    points = CLOUDS[cloud](3000, 3)
    rng = np.random.default_rng(4)
    order = rng.permutation(len(points))
    values = FIELDS[field](points) + noise * rng.standard_normal(len(points))
    own, others = order[:1000], order[1000:]
    made = METHODS[method](points[own])
    band = ErrorEstimate(points[own], fr.leave_one_out(made, values[own]))
    true_error = abs(made.field(values[own])(points[others]) - values[others])
    among = extrapolated(points[own], points[others]) == AMONG
    covered = np.mean(true_error[among] <= band(points[others][among]))
    assert 0.93 <= covered <= 0.995
    assert band.covered == pytest.approx(COVERAGE, abs=0.002)


@pytest.mark.parametrize("n", [*range(20, 40), 100, 199])
def test_the_factor_is_the_conformal_quantile(n):
    """The factor has the least rank k with k/(n + 1) ≥ 0.95.

    A new sample has every rank with equal probability.
    """
    points = fr.datasets.uniform(n, 2, seed=n)
    residuals = np.random.default_rng(n).standard_normal(n)
    rank = round(n * ErrorEstimate(points, residuals).covered)
    assert (rank - 1) / (n + 1) < COVERAGE <= rank / (n + 1)


def test_using_the_nearest_neighbours_gives_too_narrow_a_band():
    """Residuals of the nearest neighbours contain the noise of the sample itself.

    If the factor uses them, the coverage falls below 94 %.
    """
    covered = {}
    for passed_over in (0, None):
        held = []
        for seed in range(3):
            points = fr.datasets.uniform(3000, 2, seed)
            values = 0.05 * np.random.default_rng(seed).standard_normal(3000)
            made = fr.RBF(points[:1000], fr.polyharmonic(3))
            residuals = fr.leave_one_out(made, values[:1000])
            band = (
                Nearer(points[:1000], residuals)
                if passed_over == 0
                else ErrorEstimate(points[:1000], residuals)
            )
            true_error = abs(made.field(values[:1000])(points[1000:]) - values[1000:])
            held.append(np.mean(true_error <= band(points[1000:])))
        covered[passed_over] = np.mean(held)
    assert covered[0] < 0.94 < covered[None]


class Nearer(ErrorEstimate):
    """A mutant that uses the nearest neighbours when it chooses the factor."""

    _passed_over = property(lambda _: 0, lambda *_: None)


def test_the_band_is_wide_where_the_error_is_large():
    """On a steep front the band is over 30 times as wide as far from it."""
    points = fr.datasets.uniform(1500, 2, seed=0)
    made = fr.PartitionOfUnityRBF(points)
    band = ErrorEstimate(points, fr.leave_one_out(made, steep(points)))
    front, far = np.array([[0.5, 0.5]]), np.array([[0.1, 0.5]])
    assert band(front) > 30 * band(far)
    x = 0.05 + 0.9 * fr.datasets.uniform(2000, 2, seed=1)
    error = abs(made.field(steep(points))(x) - steep(x))
    wide = band(x) > np.median(band(x))
    assert error[wide].mean() > 20 * error[~wide].mean()


def test_the_band_is_invariant_under_changes_of_unit_and_origin():
    """The width scales with the unit of the values."""
    points = fr.datasets.uniform(300, 2, seed=0)
    residuals = np.random.default_rng(0).standard_normal(300)
    x = fr.datasets.uniform(50, 2, seed=1)
    band = ErrorEstimate(points, residuals)(x)
    transformed = ErrorEstimate(1e3 * points + 64, -1e-3 * residuals)(1e3 * x + 64)
    np.testing.assert_allclose(transformed, 1e-3 * band, rtol=1e-6)


def test_the_band_is_continuous():
    """A step of 5e-5 along a line changes the width by at most 0.2 % of its maximum."""
    points = fr.datasets.uniform(300, 2, seed=0)
    band = ErrorEstimate(points, np.random.default_rng(0).standard_normal(300))
    along = np.column_stack([np.linspace(0, 1, 20_001), np.full(20_001, 0.5)])
    values = band(along)
    assert abs(np.diff(values)).max() < 2e-3 * values.max()
    assert np.ptp(values) > 0.1 * values.max()


def test_zero_residuals_give_a_band_of_width_zero():
    """Residuals are zero if the method reproduces the data."""
    points = fr.datasets.uniform(50, 2, seed=0)
    band = ErrorEstimate(points, np.zeros(50))
    assert band(points).tolist() == [0.0] * 50
    assert band.covered == 1


def test_two_samples_and_coincident_samples_have_a_band():
    """Two samples estimate each other's errors; samples at one point have equal estimates."""
    two = ErrorEstimate(np.array([[0.0], [1.0]]), np.array([1.0, 2.0]))
    assert (two.neighbors, two.factor) == (1, pytest.approx(2.0))
    same = ErrorEstimate(np.zeros((60, 2)), np.ones(60))
    assert same(np.zeros((1, 2))) == pytest.approx(1.0)
    with pytest.raises(
        ValueError, match="2 or more, so that one can be predicted from the others; got 1"
    ):
        ErrorEstimate(np.zeros((1, 2)), np.ones(1))
    with pytest.raises(ValueError, match="residuals must have one entry for each point"):
        ErrorEstimate(np.zeros((2, 2)), np.ones(3))


def test_progress_is_reported():
    """`progress` counts the query points up to the last."""
    points = fr.datasets.uniform(300, 2, seed=0)
    steps = []
    band = ErrorEstimate(points, points[:, 0])
    band(np.tile(points, (20, 1)), lambda *step: steps.append(step))
    assert steps[-1] == (6000, 6000)
