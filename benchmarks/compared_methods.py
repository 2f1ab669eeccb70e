"""The methods that the comparison `peers` measures: of this library, and of other libraries.

A method is a function of sites and values that returns a function of queries. Methods of other
libraries import the library when they are called. Settings follow the manuals, with several
variants where a choice matters; for noisy data the settings of other libraries were tuned by hand.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from benchmarks.scattered_data import survey_files
from fieldrecon.fields import Field
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.pipelines.block_averages import block_means
from fieldrecon.polynomials import dimension
from fieldrecon.selection.cross_validation import CrossValidator, best
from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldrecon.selection.models import MODELS, Model

Interpolant = Callable[[np.ndarray], np.ndarray]
Fit = Callable[[np.ndarray, np.ndarray], Interpolant]
CHOICES = ((2, 1, 50), (3, 3, 40), (4, 2, 120), (7, 4, 60))
"""Candidates: power of the kernel (with a logarithm if even), degree and patch size."""
STRENGTHS = 10.0 ** np.arange(-7, 0)
"""Candidates for the smoothing of r⁵, in fifth powers of the extent."""
TRIAL_PATCH, LARGE_PATCH, MOST_AT_ONCE = 100, 300, 1_000


def patches(points: np.ndarray, values: np.ndarray) -> Field:
    """The default: interpolation by r³ and cubic polynomials."""
    return PartitionOfUnityRBF(points).field(values)


def patches_of(power: int, degree: int, patch_size: int) -> Fit:
    def fit(points: np.ndarray, values: np.ndarray) -> Field:
        return _patches(power, degree, patch_size, points).field(values)

    return fit


def patches_by_leave_one_out(points: np.ndarray, values: np.ndarray) -> Field:
    """Kernel, degree and patch size with the least cross-validation error on a few folds."""
    makers = [partial(_patches, *choice) for choice in CHOICES]
    validator = CrossValidator.of(points, values)
    paths = [[maker] for maker in makers]
    score = validator.evaluate(Model("patches", "PU", "patches, blended", lambda _: paths))
    return score.maker(points).field(values)


def chosen(points: np.ndarray, values: np.ndarray) -> Field:
    """The method of least error at left-out samples, the time of the choice included.

    The choice does not know the queries, as the compared methods do not. `fieldrecon reconstruct`
    knows them, and holds samples out at their distances.
    """
    validator = CrossValidator.of(points, values)
    scores = validator.compare([*MODELS.values()])
    return best(scores, lambda score: score.maker(points).field(values))[1]


def _patches(power: int, degree: int, size: int, points: np.ndarray) -> PartitionOfUnityRBF:
    kernel = thin_plate_spline() if power == 2 else polyharmonic(power)
    return PartitionOfUnityRBF(points, kernel, degree, size)


def moving_least_squares(degree: int, neighbors: int | None = None) -> Fit:
    def fit(points: np.ndarray, values: np.ndarray) -> Field:
        k = neighbors or 4 * dimension(points.shape[1], degree)
        return MovingLeastSquares(points, wendland(3, 1), degree, neighbors=k).field(values)

    return fit


def thin_plate(points: np.ndarray, values: np.ndarray) -> Field:
    return RBF(points, thin_plate_spline()).field(values)


def smoothed_means(count: int) -> Fit:
    """r⁵ fitted to block averages, with the smoothing chosen by leave-one-out cross-validation.

    Smoothings are compared on patches. The best is used in a global fit of up to a thousand
    averages, and otherwise on larger patches.
    """
    kernel = polyharmonic(5)

    def fit(points: np.ndarray, values: np.ndarray) -> Field:
        centers, means = block_means(points, values, min(count, len(points)))
        unit = np.ptp(points, axis=0).max() ** 5

        def squared_error(strength: float) -> float:
            patches = PartitionOfUnityRBF(centers, kernel, 3, TRIAL_PATCH, strength * unit)
            return float(np.mean(leave_one_out(patches, means) ** 2))

        smoothing = min(STRENGTHS, key=squared_error) * unit
        if count <= MOST_AT_ONCE:
            return RBF(centers, kernel, 3, smoothing).field(means)
        return PartitionOfUnityRBF(centers, kernel, 3, LARGE_PATCH, smoothing).field(means)

    return fit


AT_A_TIME = 10_000


def scipy_rbf(**settings: Any) -> Fit:
    def fit(points: np.ndarray, values: np.ndarray) -> Interpolant:
        from scipy.interpolate import RBFInterpolator

        return RBFInterpolator(points, values, **settings)

    return fit


def scipy_linear(points: np.ndarray, values: np.ndarray) -> Interpolant:
    from scipy.interpolate import LinearNDInterpolator

    return LinearNDInterpolator(points, values)


def scipy_clough_tocher(points: np.ndarray, values: np.ndarray) -> Interpolant:
    from scipy.interpolate import CloughTocher2DInterpolator

    return CloughTocher2DInterpolator(points, values)


def ferreus(kernel: str, nugget: float = 0.0) -> Fit:
    """ferreus_rbf with linear polynomials and its default accuracy."""

    def fit(points: np.ndarray, values: np.ndarray) -> Interpolant:
        from ferreus_rbf import RBFInterpolator
        from ferreus_rbf.interpolant_config import Drift, InterpolantSettings, RBFKernelType

        kind = getattr(RBFKernelType, kernel)
        settings = InterpolantSettings(kind, drift=Drift.Linear, nugget=nugget)
        fitted = RBFInterpolator(points, values[:, None], settings)
        return lambda x: np.ravel(fitted.evaluate(x))

    return fit


def wlsqm(degree: int, neighbors: int) -> Fit:
    """Fits to the nearest sites of each query, found by SciPy's k-d tree as in the manual."""

    def fit(points: np.ndarray, values: np.ndarray) -> Interpolant:
        import wlsqm as peer
        from scipy.spatial import cKDTree

        tree = cKDTree(points)

        def evaluate(x: np.ndarray) -> np.ndarray:
            near = tree.query(x, neighbors, workers=-1)[1]
            m = len(x)
            result = np.zeros((m, peer.number_of_dofs(2, degree)))
            peer.fit_2D_many_parallel(
                xk=points[near],
                fk=values[near],
                nk=np.full(m, neighbors, np.int32),
                xi=x,
                fi=result,
                sens=None,
                do_sens=False,
                order=np.full(m, degree, np.int32),
                knowns=np.zeros(m, np.int64),
                ntasks=2,
                weighting_method=np.full(m, peer.WEIGHT_CENTER, np.int32),
            )
            return result[:, 0]

        return evaluate

    return fit


def verde(means: int | None = None, damping: float | None = None) -> Fit:
    """A biharmonic spline with a force at each datum, or at the mean of each square block."""

    def fit(points: np.ndarray, values: np.ndarray) -> Interpolant:
        import verde as peer

        coordinates, data = (points[:, 0], points[:, 1]), values
        if means and means < len(points):
            spacing = float(np.sqrt(np.prod(np.ptp(points, axis=0)) / means))
            coordinates, data = peer.BlockReduce(np.mean, spacing).filter(coordinates, data)
        fitted = peer.Spline(damping=damping).fit(coordinates, data)
        return lambda x: fitted.predict((x[:, 0], x[:, 1]))

    return fit


def gaussian_process(noise: bool = False) -> Fit:
    """A Matérn kernel; scale and noise level maximize the likelihood."""

    def fit(points: np.ndarray, values: np.ndarray) -> Interpolant:
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import Matern, WhiteKernel

        kernel = Matern(length_scale=0.3 * float(np.ptp(points)), nu=2.5)
        kernel = kernel + WhiteKernel(1e-3) if noise else kernel
        fitted = GaussianProcessRegressor(kernel, normalize_y=True).fit(points, values)
        return lambda x: np.concatenate(
            [fitted.predict(x[i : i + AT_A_TIME]) for i in range(0, len(x), AT_A_TIME)]
        )

    return fit


FOR_THE_LIKELIHOOD = 500


def kriging(points: np.ndarray, values: np.ndarray) -> Interpolant:
    """Simple kriging with a Matérn covariance and a nugget.

    Sill, range and nugget maximize the likelihood of at most 500 samples.
    """
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

    center, scale = points.mean(axis=0), float(np.ptp(points, axis=0).max())
    x = (points - center) / scale
    some = np.random.default_rng(0).permutation(len(x))[:FOR_THE_LIKELIHOOD]
    covariance = ConstantKernel(1.0) * Matern(0.1, (1e-3, 1e2), nu=1.5) + WhiteKernel(
        0.1, (1e-6, 1e2)
    )
    chosen = GaussianProcessRegressor(covariance, normalize_y=True).fit(x[some], values[some])
    all_of_them = GaussianProcessRegressor(chosen.kernel_, optimizer=None, normalize_y=True)
    fitted = all_of_them.fit(x, values)
    return lambda queries: fitted.predict((queries - center) / scale)


DAMPINGS = (None, 1e-8, 1e-6, 1e-4, 1e-2)


def verde_cross_validated(points: np.ndarray, values: np.ndarray) -> Interpolant:
    """A biharmonic spline of verde; the damping has the least error in three-fold validation."""
    fold = np.random.default_rng(0).permutation(len(points)) % 3

    def error(damping: float | None) -> float:
        residuals = []
        for k in range(3):
            out = fold == k
            field = verde(damping=damping)(points[~out], values[~out])
            residuals.append(field(points[out]) - values[out])
        return float(np.mean(np.concatenate(residuals) ** 2))

    return verde(damping=min(DAMPINGS, key=error))(points, values)


NOISE = ("noisy",)
WITHOUT_NOISE = ("smooth", "front", "clusters", "cube", "terrain")
SURVEYS = tuple(survey_files())
FLAT = (2,)


@dataclass(frozen=True)
class ComparedMethod:
    """A method and the data on which it is measured.

    Parameters
    ----------
    name : str
        Its name in tables and figures.
    fit : callable
        ``fit(points, values)`` returns a function of queries (m, d).
    most : int
        The largest number of sites; with more, memory or time would not suffice.
    dimensions : tuple of int
        The dimensions in which it works.
    data : tuple of str
        The data sets for which its settings are meant.
    """

    name: str
    fit: Callable[[np.ndarray, np.ndarray], Interpolant]
    most: int = 10**9
    dimensions: tuple[int, ...] = (2, 3)
    data: tuple[str, ...] = WITHOUT_NOISE + NOISE + SURVEYS

    def takes(self, data: str, sites: int) -> bool:
        """Whether the method is measured on this number of sites of a data set."""
        d = 3 if data == "cube" else 2
        return sites <= self.most and d in self.dimensions and data in self.data


OURS, SMALL = "fieldrecon patches", "fieldrecon patches of 32"
METHODS = {
    c.name: c
    for c in (
        ComparedMethod(OURS, patches),
        ComparedMethod(SMALL, patches_of(3, 3, 32), dimensions=FLAT, data=WITHOUT_NOISE),
        ComparedMethod("fieldrecon patches, r", patches_of(1, 1, 60), dimensions=FLAT),
        ComparedMethod("fieldrecon, chosen for the data", chosen, dimensions=FLAT, data=SURVEYS),
        ComparedMethod("fieldrecon patches, r⁴ log r", patches_of(4, 2, 120), dimensions=FLAT),
        ComparedMethod(
            "fieldrecon patches, r⁷", patches_of(7, 4, 60), dimensions=FLAT, data=WITHOUT_NOISE
        ),
        ComparedMethod(
            "fieldrecon patches, by leave-one-out",
            patches_by_leave_one_out,
            dimensions=FLAT,
            data=WITHOUT_NOISE,
        ),
        ComparedMethod("fieldrecon MLS, degree 2", moving_least_squares(2)),
        ComparedMethod("fieldrecon RBF", thin_plate, 10**4),
        ComparedMethod(
            "fieldrecon MLS, 200 neighbours",
            moving_least_squares(2, 200),
            dimensions=FLAT,
            data=NOISE,
        ),
        ComparedMethod("fieldrecon RBF, 1000 means", smoothed_means(1000), data=NOISE),
        ComparedMethod("fieldrecon patches, 4000 means", smoothed_means(4000), data=NOISE),
        ComparedMethod("SciPy RBF", scipy_rbf(), 10**4),
        ComparedMethod("SciPy RBF, 30 neighbours", scipy_rbf(neighbors=30)),
        ComparedMethod(
            "SciPy RBF, r, 50 neighbours",
            scipy_rbf(neighbors=50, kernel="linear"),
            dimensions=FLAT,
        ),
        ComparedMethod(
            "SciPy RBF, r³, 40 neighbours",
            scipy_rbf(neighbors=40, kernel="cubic", degree=3),
            dimensions=FLAT,
        ),
        ComparedMethod(
            "SciPy RBF, r³, smoothed",
            scipy_rbf(kernel="cubic", smoothing=1e-3),
            10**4,
            data=NOISE,
        ),
        ComparedMethod(
            "SciPy RBF, 50 neighbours, smoothed",
            scipy_rbf(neighbors=50, smoothing=0.1),
            data=NOISE,
        ),
        ComparedMethod("SciPy LinearND", scipy_linear),
        ComparedMethod("SciPy CloughTocher2D", scipy_clough_tocher, dimensions=FLAT),
        ComparedMethod("ferreus_rbf, thin plate", ferreus("ThinPlateSpline")),
        ComparedMethod("ferreus_rbf, r", ferreus("Linear"), dimensions=FLAT),
        ComparedMethod("ferreus_rbf, r³", ferreus("Cubic")),
        ComparedMethod("ferreus_rbf, r³, smoothed", ferreus("Cubic", 1e-3), data=NOISE),
        ComparedMethod("wlsqm, degree 2", wlsqm(2, 20), dimensions=FLAT),
        ComparedMethod("wlsqm, degree 4", wlsqm(4, 40), dimensions=FLAT),
        ComparedMethod("wlsqm, 200 neighbours", wlsqm(2, 200), dimensions=FLAT, data=NOISE),
        ComparedMethod("verde Spline", verde(), 4_000, dimensions=FLAT),
        ComparedMethod("verde Spline, 2000 means", verde(2000, 1e-8), 10**5, FLAT, WITHOUT_NOISE),
        ComparedMethod("verde Spline, 2000 means, damped", verde(2000, 1e-4), 10**5, FLAT, NOISE),
        ComparedMethod("kriging", kriging, 2_000, FLAT, SURVEYS),
        ComparedMethod(
            "verde Spline, cross-validated", verde_cross_validated, 4_000, FLAT, SURVEYS
        ),
        ComparedMethod("scikit-learn GP", gaussian_process(), 1_000, data=WITHOUT_NOISE),
        ComparedMethod(
            "scikit-learn GP, with noise", gaussian_process(noise=True), 1_000, data=NOISE
        ),
    )
}
