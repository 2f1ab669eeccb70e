"""Principal axes of many matrices at once, against a decomposition one by one."""

import numpy as np
import pytest

from fieldrecon.surfaces import principal_axes as _principal_axes
from fieldrecon.surfaces.principal_axes import principal_axes
from laws import assert_close


def covariances(scales, count=500, seed=1):
    """Matrices (3, 3, m) of random neighbourhoods that extend so far along turned axes."""
    rng = np.random.default_rng(seed)
    turned = np.linalg.qr(rng.standard_normal((count, 3, 3)))[0]
    x = rng.standard_normal((count, 12, 3)) * scales @ turned
    return np.einsum("mki,mkj->ijm", x, x)


def product(matrices, axes):
    return np.einsum("ijm,kjm->kim", matrices, axes)


SCALES = {
    "a ball": (1, 1, 1),
    "a plane": (1, 1, 1e-3),
    "a needle": (1, 1e-4, 1e-6),
    "far smaller": (1e-9, 1e-9, 1e-12),
    "on a plane": (1, 1, 0),
    "on a line": (1, 0, 0),
    "a point": (0, 0, 0),
}


@pytest.mark.parametrize("name", SCALES)
def test_axes_are_orthonormal_and_diagonal(name):
    """A v = lambda v to rounding, for neighbourhoods of full rank and of none."""
    a = covariances(SCALES[name])
    values, axes = principal_axes(a)
    size = max(np.abs(a).max(), np.finfo(float).tiny)
    assert_close(np.einsum("ijm,kjm->mik", axes, axes), np.tile(np.eye(3), (500, 1, 1)), 1e-14)
    assert np.abs(product(a, axes) - values[:, None] * axes).max() < 1e-14 * size
    assert (np.diff(values, axis=0) >= 0).all()
    assert_close(values.T, np.linalg.eigvalsh(a.transpose(2, 0, 1)), 1e-13 * size)


def test_small_variances_keep_their_digits():
    """Along the axes themselves, where sizes differ by 1e16, each is right in all digits."""
    rng = np.random.default_rng(2)
    x = rng.standard_normal((3, 6, 100)) * np.array([1, 1e-4, 1e-8])[:, None, None]
    values, _ = principal_axes(np.einsum("ikm,jkm->ijm", x, x))
    scaled = np.einsum("ikm,jkm->mij", x, x) / np.multiply.outer([1, 1e-4, 1e-8], [1, 1e-4, 1e-8])
    exact = 1 / np.linalg.inv(scaled)[:, 2, 2] * 1e-16  # of the least: a complement of Schur
    assert_close(values[0] / exact, np.ones(100), 1e-6)


@pytest.mark.parametrize("rounds", [1, 2])
def test_one_or_two_rounds_are_too_few(monkeypatch, rounds):
    """What the loop is for."""
    a = covariances((1, 1, 1e-3))
    monkeypatch.setattr(_principal_axes, "_ROUNDS", rounds)
    values, axes = principal_axes(a)
    assert np.abs(product(a, axes) - values[:, None] * axes).max() > 1e-12


def test_diagonal_matrices_are_done_at_once():
    """Equal entries, zeros, and an order that is not that of the axes."""
    a = np.zeros((3, 3, 4))
    a[range(3), range(3)] = np.array([[3, 1, 2], [1, 1, 1], [0, 0, 5], [0, 0, 0]]).T
    values, axes = principal_axes(a)
    assert values.T.tolist() == [[1, 2, 3], [1, 1, 1], [0, 0, 5], [0, 0, 0]]
    assert np.abs(axes).sum() == 12
