"""Prediction bands for a field, from the residuals of samples held out as far as the queries are.

The half-width is t q(r) s(x)^a. The distance r of the query from the nearest sample sets q, the
95 % quantile of the residuals of samples held out at this distance, which does not decrease with r.
The roughness s is the root mean square of the leave-one-out residuals near by, relative to that of
all. Its exponent a is 0, 1/2 or 1, whichever gives the narrowest band on the mean. The factor t is
calibrated such that 95 of 100 held-out samples are within the band, and some more if they are few.
Beyond the largest distance at which samples were held out, q grows in proportion to the distance,
without a guarantee. The band holds for a new measurement, its noise included. This is split
conformal prediction, scaled locally.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, chunked, rows_of
from fieldrecon.selection.distance_matching import Fold, held_out_distances

COVERAGE = 0.95
"""Fraction of the held-out samples whose residuals are within the band."""

_EXPONENTS = (0.0, 0.5, 1.0)
_PER_BIN, _MOST_BINS = 40, 10
_CAUTION = 1.0  # held-out samples of one gap are not independent of each other
_FLOOR = 1e-3  # least roughness, as a fraction of that of all samples


class ErrorBand:
    """Half-width of a band that contains 95 of 100 samples held out as far as the queries are.

    Parameters
    ----------
    points : (n, d) array_like
        Samples.
    folds : sequence of Fold
        Folds, as of `distance_matched_folds`.
    residuals : (m,) array_like
        Residuals of the method at the held-out samples, fold by fold.
    own_residuals : (n,) array_like, optional
        Leave-one-out residuals of all samples, from which the roughness is estimated. Without them
        the band depends on the distance only.

    Attributes
    ----------
    validated : float
        Largest distance of a held-out sample from the fitted ones.
    exponent : float
        Exponent a of the roughness.
    factor : float
        Factor t.
    covered : float
        Fraction of the held-out samples within the band.

    References
    ----------
    Lei, G'Sell, Rinaldo, Tibshirani and Wasserman, Distribution-free predictive inference for
    regression (2018), section 5.2; Barber, Candès, Ramdas and Tibshirani, Predictive inference with
    the jackknife+ (2021).

    Examples
    --------
    >>> import fieldrecon as fr
    >>> points, x = fr.datasets.halton(1000, 2), fr.datasets.uniform(1000, 2, seed=0)
    >>> method, f = lambda points: fr.RBF(points, fr.thin_plate_spline()), fr.datasets.franke
    >>> folds = fr.selection.distance_matched_folds(points, x)
    >>> parts = [(points[fold.fitted], points[fold.held_out]) for fold in folds]
    >>> residuals = [f(out) - method(own).field(f(own))(out) for own, out in parts]
    >>> band = ErrorBand(points, folds, np.concatenate(residuals))
    >>> error = abs(method(points).field(f(points))(x) - f(x))
    >>> bool(np.mean(error <= band(x)) > 0.9)
    True
    """

    def __init__(
        self,
        points: np.ndarray,
        folds: Sequence[Fold],
        residuals: np.ndarray,
        own_residuals: np.ndarray | None = None,
    ) -> None:
        points = valid.as_points(points)
        self._tree = cKDTree(points)
        self.distances = held_out_distances(points, folds)
        self._sizes = abs(valid.as_values(residuals, len(self.distances), name="residuals"))
        self.validated = float(self.distances.max())
        if own_residuals is not None:
            own_residuals = valid.as_values(own_residuals, len(points), name="own_residuals")
        self._roughness = None if own_residuals is None else _Roughness(points, own_residuals)
        found = [self._of_exponent(a, rough) for a, rough in self._candidates(folds)]
        self.exponent, self.factor, self._quantile, self._widths = min(
            found, key=lambda one: one[3].mean()
        )
        self.covered = float(np.mean(self._sizes <= self._widths))

    def _candidates(self, folds: Sequence[Fold]) -> list[tuple[float, np.ndarray]]:
        """Exponents, and the powers of the roughness at the held-out samples."""
        if self._roughness is None:
            return [(0.0, np.ones(len(self._sizes)))]
        rough = np.concatenate([self._roughness.without(fold) for fold in folds])
        return [(a, rough**a) for a in _EXPONENTS]

    def _of_exponent(
        self, exponent: float, rough: np.ndarray
    ) -> tuple[float, float, _QuantileByDistance, np.ndarray]:
        quantile = _QuantileByDistance(self.distances, self._sizes / rough)
        widths = quantile(self.distances) * rough
        ratios = np.divide(self._sizes, widths, out=np.zeros_like(widths), where=widths > 0)
        factor = conformal_quantile(ratios, _CAUTION)
        return exponent, factor, quantile, factor * widths

    def __call__(self, x: np.ndarray, progress: Progress | None = None) -> np.ndarray:
        """Half-widths (m,) at queries (m, d), in the unit of the values."""
        x = valid.as_queries(x, self._tree.m)
        result = np.empty(len(x))
        for part, widths in chunked(self._half_widths, x, rows_of(8 * 64), progress=progress):
            result[part] = widths
        return result

    def _half_widths(self, x: np.ndarray) -> np.ndarray:
        widths = self.factor * self._quantile(self._tree.query(x)[0])
        if self._roughness is not None and self.exponent > 0:
            widths *= self._roughness(x) ** self.exponent
        return widths

    def coverage_by_distance(self) -> list[tuple[float, float, int]]:
        """For bins of held-out samples: the largest distance, the fraction covered, the number."""
        within = self._sizes <= self._widths
        return [
            (float(self.distances[part].max()), float(within[part].mean()), len(part))
            for part in _bins(self.distances)
        ]


def conformal_quantile(ratios: np.ndarray, caution: float = 0.0) -> float:
    """The ratio of least rank k with k / (n + 1) >= 0.95, or the largest.

    A new ratio has every rank with equal probability. With caution, the rank is higher by so many
    standard deviations of the number of n ratios that are below the true quantile.

    Examples
    --------
    >>> conformal_quantile(np.arange(1.0, 100.0))
    95.0
    """
    n = len(ratios)
    spread = caution * np.sqrt(COVERAGE * (1 - COVERAGE) * n)
    rank = min(int(np.ceil(COVERAGE * (n + 1) + spread)), n)
    return float(np.partition(ratios, rank - 1)[rank - 1])


def _bins(distances: np.ndarray) -> list[np.ndarray]:
    """Indices of the held-out samples in bins of equal numbers, by their distance."""
    count = int(np.clip(len(distances) // _PER_BIN, 1, _MOST_BINS))
    return np.array_split(np.argsort(distances, kind="stable"), count)


class _QuantileByDistance:
    """The 95 % quantile of residuals, which does not decrease with the distance (isotonic)."""

    def __init__(self, distances: np.ndarray, sizes: np.ndarray) -> None:
        bins = _bins(distances)
        self._largest = max(float(distances.max()), np.finfo(float).tiny)
        self._at = np.array([np.median(distances[part]) for part in bins])
        self._quantiles = _not_decreasing(
            np.array([conformal_quantile(sizes[part]) for part in bins]),
            np.array([len(part) for part in bins], dtype=float),
        )

    def __call__(self, distances: np.ndarray) -> np.ndarray:
        beyond = np.maximum(distances / self._largest, 1.0)
        return np.interp(distances, self._at, self._quantiles) * beyond


def _not_decreasing(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The nearest sequence in weighted least squares that does not decrease.

    Neighbours in the wrong order are replaced by their mean, until there are none (pool adjacent
    violators).
    """
    means: list[list[float]] = []
    for value, weight in zip(values, weights, strict=True):
        means.append([value, weight, 1])
        while len(means) > 1 and means[-2][0] > means[-1][0]:
            (a, v, m), (b, w, n) = means[-2:]
            means[-2:] = [[(a * v + b * w) / (v + w), v + w, m + n]]
    return np.repeat([mean for mean, _, _ in means], [int(count) for *_, count in means])


class _Roughness:
    """Root mean square of the leave-one-out residuals near a query, relative to that of all.

    The residuals of the k nearest samples are weighted by (1 - (r / R)^2)^2 with the distance R of
    the next sample, so that the roughness is continuous.
    """

    def __init__(
        self, points: np.ndarray, residuals: np.ndarray, mean: float | None = None
    ) -> None:
        n, d = points.shape
        self._points, self._residuals = points, residuals
        self._tree = cKDTree(points)
        self._neighbors = min(8 * (d + 1), n - 1)
        self._squares = abs(residuals) ** 2
        self._mean = (float(self._squares.mean()) or 1.0) if mean is None else mean

    def __call__(self, x: np.ndarray) -> np.ndarray:
        distance, nearest = self._tree.query(x, range(1, self._neighbors + 2))
        reach = distance[:, -1:]
        far = np.divide(distance, reach, out=np.zeros_like(distance), where=reach > 0)[:, :-1]
        weight = (1 - far**2) ** 2 + np.finfo(float).eps
        near = (weight * self._squares[nearest[:, :-1]]).sum(axis=1) / weight.sum(axis=1)
        return np.sqrt(near / self._mean + _FLOOR**2)

    def without(self, fold: Fold) -> np.ndarray:
        """Roughness (h,) at the held-out samples of a fold, from those that are fitted."""
        fitted = _Roughness(self._points[fold.fitted], self._residuals[fold.fitted], self._mean)
        return fitted(self._points[fold.held_out])
