"""The band holds what it promises, at the samples by construction and at places held out."""

import numpy as np
import pytest

import fieldrecon as fr
from fieldrecon.selection.extrapolation import AMONG, extrapolated
from fieldrecon.selection.prediction_intervals import COVERAGE, ErrorEstimate


def steep(x):
    """A front across the square, ten times as steep as the rest."""
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
def test_the_band_holds_at_held_out_samples(cloud, field, method, noise):
    """Of samples the method never saw, 95 of 100 and few more lie within it, noise and all."""
    points = CLOUDS[cloud](3000, 3)
    rng = np.random.default_rng(4)
    order = rng.permutation(len(points))
    values = FIELDS[field](points) + noise * rng.standard_normal(len(points))
    own, others = order[:1000], order[1000:]
    made = METHODS[method](points[own])
    band = ErrorEstimate(points[own], fr.leave_one_out(made, values[own]))
    missed = abs(made.field(values[own])(points[others]) - values[others])
    among = extrapolated(points[own], points[others]) == AMONG
    covered = np.mean(missed[among] <= band(points[others][among]))
    assert 0.93 <= covered <= 0.995
    assert band.covered == pytest.approx(COVERAGE, abs=0.002)


@pytest.mark.parametrize("n", [*range(20, 40), 100, 199])
def test_the_factor_has_the_rank_of_a_sample_to_come(n):
    """The least rank k of n with k/(n + 1) ≥ 0.95: the next sample is as likely of any rank."""
    points = fr.datasets.uniform(n, 2, seed=n)
    residuals = np.random.default_rng(n).standard_normal(n)
    rank = round(n * ErrorEstimate(points, residuals).covered)
    assert (rank - 1) / (n + 1) < COVERAGE <= rank / (n + 1)


def test_neighbours_that_bear_a_sample_s_own_noise_would_narrow_the_band():
    """Without passing over the nearest, fewer than 94 of 100 noisy samples lie within."""
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
            missed = abs(made.field(values[:1000])(points[1000:]) - values[1000:])
            held.append(np.mean(missed <= band(points[1000:])))
        covered[passed_over] = np.mean(held)
    assert covered[0] < 0.94 < covered[None]


class Nearer(ErrorEstimate):
    """A mutant that lets the nearest count when the factor is chosen."""

    _passed_over = property(lambda _: 0, lambda *_: None)


def test_the_band_is_wide_where_the_field_is_hard():
    """It is an estimate at each place: large errors stand where it is large."""
    points = fr.datasets.uniform(1500, 2, seed=0)
    made = fr.PartitionOfUnityRBF(points)
    band = ErrorEstimate(points, fr.leave_one_out(made, steep(points)))
    front, far = np.array([[0.5, 0.5]]), np.array([[0.1, 0.5]])
    assert band(front) > 30 * band(far)
    x = 0.05 + 0.9 * fr.datasets.uniform(2000, 2, seed=1)
    error = abs(made.field(steep(points))(x) - steep(x))
    wide = band(x) > np.median(band(x))
    assert error[wide].mean() > 20 * error[~wide].mean()


def test_the_band_moves_with_points_and_values():
    """Another unit, another place: the same estimate in the unit of the values."""
    points = fr.datasets.uniform(300, 2, seed=0)
    residuals = np.random.default_rng(0).standard_normal(300)
    x = fr.datasets.uniform(50, 2, seed=1)
    band = ErrorEstimate(points, residuals)(x)
    moved = ErrorEstimate(1e3 * points + 64, -1e-3 * residuals)(1e3 * x + 64)
    np.testing.assert_allclose(moved, 1e-3 * band, rtol=1e-6)


def test_the_band_is_continuous():
    """A step of a millionth changes it by a thousandth at the most."""
    points = fr.datasets.uniform(300, 2, seed=0)
    band = ErrorEstimate(points, np.random.default_rng(0).standard_normal(300))
    along = np.column_stack([np.linspace(0, 1, 20_001), np.full(20_001, 0.5)])
    values = band(along)
    assert abs(np.diff(values)).max() < 2e-3 * values.max()
    assert np.ptp(values) > 0.1 * values.max()


def test_a_field_without_error_has_a_band_of_nothing():
    """Data that the method reproduces."""
    points = fr.datasets.uniform(50, 2, seed=0)
    band = ErrorEstimate(points, np.zeros(50))
    assert band(points).tolist() == [0.0] * 50
    assert band.covered == 1


def test_few_and_coincident_points():
    """Two samples judge each other; samples at one place share what they miss."""
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


def test_progress_is_told():
    """In places, to the last."""
    points = fr.datasets.uniform(300, 2, seed=0)
    told = []
    band = ErrorEstimate(points, points[:, 0])
    band(np.tile(points, (20, 1)), lambda *step: told.append(step))
    assert told[-1] == (6000, 6000)
