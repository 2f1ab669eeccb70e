"""How far a field may be off at a place, from how far it misses samples near by that are left out.

The estimate is t r(x), with r(x) the root mean square of the leave-one-out residuals of the k
samples nearest to x, weighted by (1 - (distance / that of the next one)^2)^2, so that it is
continuous. The factor t is such that 95 of 100 samples, when left out, are missed by no
more than t times the r of the others about them, the few nearest passed over, whose residuals bear
the noise of the one that was left out; a new place has lent its noise to none. So it holds for the
samples by construction, and for a place among them as far as it is like them. It is a band for what
would be measured there, its noise included; where the samples are sparser than anywhere among them,
in gaps and outside, it promises nothing. The idea is that of conformal prediction, scaled locally,
with residuals from leaving one out.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, chunked, rows_of

COVERAGE = 0.95
"""Part of the samples that are missed by no more than the estimate."""
_CALIBRATED_AT = 100_000  # samples, which fix the factor to a thousandth and less
_FLOOR = 1e-6  # of the root mean square of all residuals


class ErrorEstimate:
    """Band t r(x) that holds 95 of 100 samples when they are left out.

    Parameters
    ----------
    points : (n, d) array_like
        Samples, or those at which there are residuals; n is 2 or more.
    residuals : (n,) array_like
        What `leave_one_out` tells of the method there.

    Attributes
    ----------
    neighbors : int
        Number k of samples whose residuals count at a place: 8 (d + 1), if there are as many.
    factor : float
        Number t.
    covered : float
        Part of the samples within the band.

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
            raise ValueError("points must be 2 or more, to judge one by the others; got 1")
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
        """Estimate at places (m, d), in the unit of the values: (m,)."""
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
        """The same at sites, of the others near to them but for the nearest."""
        first = 2 + self._passed_over
        ranks = range(first, first + self.neighbors + 1)
        return self._mean(*self._tree.query(self.points[sites], ranks))

    def _mean(self, distance: np.ndarray, nearest: np.ndarray) -> np.ndarray:
        """Of the residuals of all but the last of the nearest, whose distance sets the scale.

        Where there are too few points, distances are infinite and residuals beyond the end.
        """
        reach = np.where(np.isfinite(distance[:, -1:]), distance[:, -1:], 0.0)
        far = np.divide(distance, reach, out=np.zeros_like(distance), where=reach > 0)[:, :-1]
        weight = (1 - np.minimum(far, 1.0) ** 2) ** 2 + np.finfo(float).eps
        squares = np.append(self._squares, 0.0)[np.minimum(nearest[:, :-1], len(self._squares))]
        weight[nearest[:, :-1] == len(self._squares)] = 0.0
        return np.sqrt((weight * squares).sum(axis=1) / weight.sum(axis=1) + self._floor)
