"""What interpolates scattered data, from sites and values to a function; each imports its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Interpolant = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Contestant:
    """A method, and up to how many sites it is asked.

    Parameters
    ----------
    name : str
        As it stands in tables and pictures.
    fit : callable
        ``fit(points, values)`` returns a function of queries (m, d).
    most : int
        Beyond so many sites it would not fit into memory, or not end.
    dimensions : tuple of int
        In which it works.
    """

    name: str
    fit: Callable[[np.ndarray, np.ndarray], Interpolant]
    most: int = 10**9
    dimensions: tuple[int, ...] = (1, 2, 3)


def partition_of_unity(points: np.ndarray, values: np.ndarray) -> Interpolant:
    from fieldrecon.partition_of_unity import PartitionOfUnityRBF

    return PartitionOfUnityRBF(points).field(values)


def partition_of_unity_cubic(points: np.ndarray, values: np.ndarray) -> Interpolant:
    from fieldrecon.partition_of_unity import PartitionOfUnityRBF
    from fieldrecon.radial import polyharmonic

    return PartitionOfUnityRBF(points, polyharmonic(3)).field(values)


def moving_least_squares(points: np.ndarray, values: np.ndarray) -> Interpolant:
    from fieldrecon.moving_least_squares import MovingLeastSquares
    from fieldrecon.positive_definite import wendland

    d = points.shape[1]
    weight = wendland(d, 1)
    return MovingLeastSquares(points, weight, 2, neighbors=20 if d == 2 else 40).field(values)


def thin_plate(points: np.ndarray, values: np.ndarray) -> Interpolant:
    from fieldrecon.radial import thin_plate_spline
    from fieldrecon.rbf import RBF

    return RBF(points, thin_plate_spline()).field(values)


def scipy_global(points: np.ndarray, values: np.ndarray) -> Interpolant:
    from scipy.interpolate import RBFInterpolator

    return RBFInterpolator(points, values)


def scipy_neighbors(points: np.ndarray, values: np.ndarray) -> Interpolant:
    from scipy.interpolate import RBFInterpolator

    return RBFInterpolator(points, values, neighbors=30)


def scipy_linear(points: np.ndarray, values: np.ndarray) -> Interpolant:
    from scipy.interpolate import LinearNDInterpolator

    return LinearNDInterpolator(points, values)


def scipy_clough_tocher(points: np.ndarray, values: np.ndarray) -> Interpolant:
    from scipy.interpolate import CloughTocher2DInterpolator

    return CloughTocher2DInterpolator(points, values)


def ferreus(kernel: str) -> Callable[[np.ndarray, np.ndarray], Interpolant]:
    def fit(points: np.ndarray, values: np.ndarray) -> Interpolant:
        from ferreus_rbf import RBFInterpolator
        from ferreus_rbf.interpolant_config import Drift, InterpolantSettings, RBFKernelType

        settings = InterpolantSettings(getattr(RBFKernelType, kernel), drift=Drift.Linear)
        fitted = RBFInterpolator(points, values[:, None], settings)
        return lambda x: np.ravel(fitted.evaluate(x))

    return fit


def wlsqm(points: np.ndarray, values: np.ndarray) -> Interpolant:
    """Fits of degree 2 to the 20 nearest sites of each query, as its manual has it."""
    import wlsqm as peer
    from scipy.spatial import cKDTree

    tree = cKDTree(points)

    def evaluate(x: np.ndarray) -> np.ndarray:
        near = tree.query(x, 20, workers=-1)[1]
        sites, data = points[near], values[near]
        m = len(x)
        result = np.zeros((m, peer.number_of_dofs(2, 2)))
        peer.fit_2D_many_parallel(
            xk=sites, fk=data, nk=np.full(m, 20, np.int32), xi=x, fi=result, sens=None,
            do_sens=False, order=np.full(m, 2, np.int32), knowns=np.zeros(m, np.int64),
            weighting_method=np.full(m, peer.WEIGHT_CENTER, np.int32), ntasks=2,
        )  # fmt: skip
        return result[:, 0]

    return evaluate


def verde(points: np.ndarray, values: np.ndarray) -> Interpolant:
    """A biharmonic spline with a force under each datum."""
    import verde as peer

    fitted = peer.Spline().fit((points[:, 0], points[:, 1]), values)
    return lambda x: fitted.predict((x[:, 0], x[:, 1]))


def gaussian_process(points: np.ndarray, values: np.ndarray) -> Interpolant:
    """A Matérn kernel whose scale is found by likelihood."""
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import Matern

    kernel = Matern(length_scale=0.3 * float(np.ptp(points)), nu=2.5)
    fitted = GaussianProcessRegressor(kernel, normalize_y=True).fit(points, values)
    return lambda x: np.concatenate(
        [fitted.predict(x[i : i + 10_000]) for i in range(0, len(x), 10_000)]
    )


OURS = "fieldrecon PartitionOfUnityRBF"
CONTESTANTS = {
    c.name: c
    for c in (
        Contestant(OURS, partition_of_unity),
        Contestant("fieldrecon PartitionOfUnityRBF, r³", partition_of_unity_cubic),
        Contestant("fieldrecon MovingLeastSquares", moving_least_squares),
        Contestant("fieldrecon RBF", thin_plate, 10**4),
        Contestant("SciPy RBFInterpolator", scipy_global, 10**4),
        Contestant("SciPy RBFInterpolator, 30 neighbours", scipy_neighbors, 10**5),
        Contestant("SciPy LinearND", scipy_linear, dimensions=(2, 3)),
        Contestant("SciPy CloughTocher2D", scipy_clough_tocher, dimensions=(2,)),
        Contestant("ferreus_rbf, thin plate", ferreus("ThinPlateSpline"), dimensions=(2, 3)),
        Contestant("ferreus_rbf, r³", ferreus("Cubic"), dimensions=(2, 3)),
        Contestant("wlsqm, degree 2", wlsqm, dimensions=(2,)),
        Contestant("verde Spline", verde, 4_000, dimensions=(2,)),
        Contestant("scikit-learn Gaussian process", gaussian_process, 1_000),
    )
}
