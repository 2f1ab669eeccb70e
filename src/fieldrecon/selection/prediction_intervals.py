"""Prediction intervals for a field, from the residuals of left-out samples near by.

The half-width is t r(x), with r(x) the root mean square of the leave-one-out residuals of the k
samples nearest to x, weighted by (1 - (distance / that of the next one)^2)^2, so that it is
continuous. The factor t is calibrated on the samples: 95 of 100 of them have a residual of at most
t times the r of the other samples near by. The few nearest ones are passed over, since their
residuals contain the noise of the sample that was left out; a new point has affected none. So the
coverage holds for the samples by construction, and for a new point as far as it resembles them. The
interval is one for a new measurement, its noise included. Where the samples are sparser than
anywhere among them, in gaps and outside, there is no guarantee. This is conformal prediction,
scaled locally, with leave-one-out residuals.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, chunked, rows_of

COVERAGE = 0.95
"""Fraction of the samples whose residuals are within the estimate."""
_CALIBRATED_AT = 100_000  # samples, which determine the factor to a thousandth or better
_FLOOR = 1e-6  # fraction of the root mean square of all residuals


class ErrorEstimate:
    """Half-width t r(x) of a band that contains 95 of 100 samples when they are left out.

    Parameters
    ----------
    points : (n, d) array_like
        Samples, or those at which there are residuals; n is 2 or more.
    residuals : (n,) array_like
        Residuals of the method there by `leave_one_out`.

    Attributes
    ----------
    neighbors : int
        Number k of samples whose residuals count at a query: 8 (d + 1), if there are as many.
    factor : float
        Factor t.
    covered : float
        Fraction of the samples within the band.

    References
    ----------
    Lei, G'Sell, Rinaldo, Tibshirani and Wasserman, Distribution-free predictive inference for
    regression (2018), section 5.2; Barber, Candès, Ramdas and Tibshirani, Predictive inference with
    the jackknife+ (2021).

    Examples
    --------
    >>> import fieldrecon as fr
    >>> points = fr.datasets.halton(1000, 2)
    >>> method, values = fr.RBF(points, fr.polyharmonic(3)), fr.datasets.franke(points)
    >>> band = ErrorEstimate(points, fr.leave_one_out(method, values))
    >>> x = fr.datasets.uniform(1000, 2, seed=0) * 0.9 + 0.05
    >>> error = abs(method.field(values)(x) - fr.datasets.franke(x))
    >>> bool(np.mean(error <= band(x)) > 0.95)
    True
    """

    def __init__(self, points: np.ndarray, residuals: np.ndarray) -> None:
        self.points = valid.as_points(points)
        n, d = self.points.shape
        if n < 2:
            raise ValueError(
                "points must be 2 or more, so that one can be predicted from the others; got 1"
            )
        self._squares = abs(valid.as_values(residuals, n, name="residuals")) ** 2
        self._floor = _FLOOR**2 * self._squares.mean()
        self._tree = cKDTree(self.points)
        self._passed_over = min(2 * (d + 1), (n - 1) // 4)
        self.neighbors = min(8 * (d + 1), n - 1 - self._passed_over)
        some = np.arange(0, n, -(-n // _CALIBRATED_AT))
        own = np.sqrt(self._squares[some])
        near = np.concatenate([r for _, r in self._chunks(self._of_others, some)])
        ratios = np.divide(own, near, out=np.zeros_like(own), where=near > 0)
        rank = min(int(np.ceil(COVERAGE * (len(some) + 1))), len(some))
        self.factor = float(np.partition(ratios, rank - 1)[rank - 1])
        self.covered = float(np.mean(ratios <= self.factor))

    def __call__(self, x: np.ndarray, progress: Progress | None = None) -> np.ndarray:
        """Estimates (m,) at queries (m, d), in the unit of the values."""
        x = valid.as_queries(x, self.points.shape[1])
        result = np.empty(len(x))
        for part, near in self._chunks(self._near, x, progress):
            result[part] = self.factor * near
        return result

    def _chunks(self, work, x, progress=None):  # type: ignore[no-untyped-def]
        return chunked(work, x, rows_of(8 * 8 * (self.neighbors + 2)), progress=progress)

    def _near(self, x: np.ndarray) -> np.ndarray:
        """Weighted root mean square of the residuals nearest to x."""
        distance, nearest = self._tree.query(x, range(1, self.neighbors + 2))
        return self._mean(distance, nearest)

    def _of_others(self, sites: np.ndarray) -> np.ndarray:
        """The same at sites, from the other samples near by without the nearest ones."""
        first = 2 + self._passed_over
        ranks = range(first, first + self.neighbors + 1)
        return self._mean(*self._tree.query(self.points[sites], ranks))

    def _mean(self, distance: np.ndarray, nearest: np.ndarray) -> np.ndarray:
        """Weighted mean over all but the last of the nearest, whose distance sets the scale.

        If there are too few points, distances are infinite and indices point beyond the end.
        """
        reach = np.where(np.isfinite(distance[:, -1:]), distance[:, -1:], 0.0)
        far = np.divide(distance, reach, out=np.zeros_like(distance), where=reach > 0)[:, :-1]
        weight = (1 - np.minimum(far, 1.0) ** 2) ** 2 + np.finfo(float).eps
        squares = np.append(self._squares, 0.0)[np.minimum(nearest[:, :-1], len(self._squares))]
        weight[nearest[:, :-1] == len(self._squares)] = 0.0
        return np.sqrt((weight * squares).sum(axis=1) / weight.sum(axis=1) + self._floor)
