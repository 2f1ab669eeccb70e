"""The variogram of samples: how much they differ, by their distance, in the words of kriging."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls
from scipy.spatial.distance import cdist

FEWEST = 10
"""Samples of which a variogram says anything."""
_MOST = 2000  # samples whose pairs are compared
_BINS = 20
_REACH = 0.5  # of the largest distance: pairs up to there are compared, and half of them at least
_RANGES = np.geomspace(0.02, 20.0, 60)  # of the reach, that are tried
_LEAST_WHOLE, _LARGEST_WHOLE = 100, 1e7  # numbers that are written without a power of ten
_PRACTICAL = 3.0  # at the range the model has reached 95 % of the sill


@dataclass(frozen=True, eq=False)
class Variogram:
    """Half the mean square of the differences of samples, and an exponential model of it.

    The model is gamma(h) = c_0 + c (1 - exp(-3 h / a)) with the nugget c_0, the sill c_0 + c and
    the range a, fitted by least squares with the weights N / h^2 of N pairs at the distance h.

    Parameters
    ----------
    distances, values : ndarray of shape (b,)
        Mean distance, and semivariance, of the pairs in each bin.
    nugget, sill, range : float
        The range is a length, the others are squares of the unit of the values.
    unit : str
        Unit of the distances, or empty.
    """

    distances: np.ndarray
    values: np.ndarray
    nugget: float
    sill: float
    range: float
    unit: str = ""

    def __call__(self, h: np.ndarray) -> np.ndarray:
        """The model at distances h."""
        return self.nugget + (self.sill - self.nugget) * (1 - np.exp(-_PRACTICAL * h / self.range))

    @property
    def levels_off(self) -> bool:
        """Whether the range is at most the largest distance of samples that are compared."""
        return bool(self.range <= self.distances.max())

    @property
    def range_in_words(self) -> str:
        """The range with its unit, or the distance that it exceeds."""
        if self.levels_off:
            return f"{_figure(self.range)}{self.unit}"
        return f"more than {_figure(self.distances.max())}{self.unit}"

    @property
    def nugget_in_words(self) -> str:
        """The nugget, without a power of ten where it can be."""
        return _figure(self.nugget)

    @property
    def sill_in_words(self) -> str:
        """The sill, if the model levels off."""
        return _figure(self.sill) if self.levels_off else "none"


def _figure(number: float) -> str:
    """A number of three figures, or of all before the point if these are a few more."""
    return f"{number:,.0f}" if _LEAST_WHOLE <= abs(number) < _LARGEST_WHOLE else f"{number:.3g}"


def variogram(points: np.ndarray, values: np.ndarray, unit: str = "") -> Variogram:
    """Compute the variogram of samples at points (n, d) with values (n,), and fit the model.

    Raises
    ------
    ValueError
        If there are fewer than ten samples.

    References
    ----------
    Cressie, Statistics for Spatial Data (1993), sections 2.4 and 2.6; Pebesma, Multivariable
    geostatistics in S: the gstat package (2004), for the weights.

    Examples
    --------
    >>> points = np.random.default_rng(0).random((500, 2))
    >>> noise = np.random.default_rng(1).standard_normal(500)
    >>> bool(0.7 < variogram(points, noise).nugget < 1.2)
    True
    """
    if len(points) < FEWEST:
        raise ValueError(f"a variogram needs at least {FEWEST} samples; got {len(points)}")
    some = np.random.default_rng(0).permutation(len(points))[:_MOST]
    upper = np.triu_indices(len(some), 1)
    distance = cdist(points[some], points[some])[upper]
    reach = max(_REACH * float(distance.max()), float(np.median(distance)))
    near = distance <= reach
    difference = values[some][upper[0][near]] - values[some][upper[1][near]]
    bins = np.minimum((_BINS * distance[near] / reach).astype(int), _BINS - 1)
    count = np.bincount(bins, minlength=_BINS)
    used = count > 0
    mean = np.bincount(bins, distance[near], _BINS)[used] / count[used]
    half = np.bincount(bins, difference**2 / 2, _BINS)[used] / count[used]
    found = [_fit(mean, half, count[used], reach * part) for part in _RANGES]
    _, nugget, sill, length = min(found)
    return Variogram(mean, half, nugget, sill, length, unit)


def _fit(
    h: np.ndarray, values: np.ndarray, count: np.ndarray, length: float
) -> tuple[float, float, float, float]:
    """The residual norm, nugget, sill and range of the best model of this range."""
    scale = float(values.max()) or 1.0
    weight = np.sqrt(count) / h
    basis = np.column_stack([np.ones_like(h), 1 - np.exp(-_PRACTICAL * h / length)])
    (nugget, rise), residual = nnls(weight[:, None] * basis, weight * values / scale)
    return float(residual), float(scale * nugget), float(scale * (nugget + rise)), float(length)
