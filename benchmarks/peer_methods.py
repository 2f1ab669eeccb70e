"""Other libraries as the comparison takes them: sites and values to a function.

Each imports its own. Settings are those of the manuals where these say any, and several where a
choice matters; what fits noise has been tried by hand, for the peers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

Interpolant = Callable[[np.ndarray], np.ndarray]
Fit = Callable[[np.ndarray, np.ndarray], Interpolant]
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
    """With linear polynomials, to its own default accuracy."""

    def fit(points: np.ndarray, values: np.ndarray) -> Interpolant:
        from ferreus_rbf import RBFInterpolator
        from ferreus_rbf.interpolant_config import Drift, InterpolantSettings, RBFKernelType

        kind = getattr(RBFKernelType, kernel)
        settings = InterpolantSettings(kind, drift=Drift.Linear, nugget=nugget)
        fitted = RBFInterpolator(points, values[:, None], settings)
        return lambda x: np.ravel(fitted.evaluate(x))

    return fit


def wlsqm(degree: int, neighbors: int) -> Fit:
    """Fits to the nearest sites of each query, found by SciPy's tree, as its manual has it."""

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
    """A biharmonic spline with a force under each datum, or under each mean of a square block."""

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
    """A Matérn kernel whose scale, and the noise where there is some, are found by likelihood."""

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
