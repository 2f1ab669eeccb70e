"""The noise gain is the standard deviation of the field of noise, and depends on no values."""

import numpy as np
import pytest

import fieldrecon as fr
from fieldrecon.selection.noise_gain import noise_gain


def test_the_gain_of_known_weights():
    """A mean, an interpolant at its sites, and a straight line beyond its two samples."""
    points = fr.datasets.uniform(100, 2, seed=0)
    x = fr.datasets.uniform(9, 2, seed=1)
    np.testing.assert_allclose(noise_gain(fr.LeastSquares(points, 0), x), 0.1)
    np.testing.assert_allclose(noise_gain(fr.PartitionOfUnityRBF(points), points), 1.0, rtol=1e-9)
    line, t = fr.LeastSquares([[0.0], [1.0]], 1), np.array([0.5, 1.0, 4.0])
    np.testing.assert_allclose(noise_gain(line, t[:, None]), np.hypot(t, 1 - t))


def test_the_gain_is_the_standard_deviation_of_fields_of_noise():
    """Of 4000 fields of noise, up to the error of such a standard deviation (1 %)."""
    points, x = fr.datasets.uniform(60, 2, seed=0), fr.datasets.uniform(9, 2, seed=1)
    noise = np.random.default_rng(0).standard_normal((60, 4000))
    for method in (
        fr.LeastSquares(points, 2),
        fr.RBF(points, fr.thin_plate_spline(), smoothing=0.1),
        fr.MovingLeastSquares(points, fr.inverse_square(0.1), 1),
        fr.PartitionOfUnityRBF(points, fr.polyharmonic(1), 1, 20),
    ):
        spread = method.field(noise)(x).std(axis=1)
        assert spread == pytest.approx(noise_gain(method, x), rel=0.06)
