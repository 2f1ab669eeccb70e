"""Methods of the terrain experiment: from points with heights to a surface."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from scipy import sparse
from scipy.interpolate import LinearNDInterpolator, RBFInterpolator

from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.rbf import RBF

GUARDED = "MLS guarded"
THIN_PLATE = "thin plate"
TRIANGLES = "triangles"

WEIGHT = wendland(3, 1)
"""The weight of moving least squares: twice differentiable, zero at the first unused point."""


@dataclass(frozen=True)
class Surface:
    """Heights at queries.

    Parameters
    ----------
    heights : ndarray of shape (m,)
        NaN where the method is undefined.
    amplification : ndarray of shape (m,)
        The sum of the absolute weights, by which an error of the data can grow; empty if not
        computed.
    neighbors : int
        The number of points that determine a height; 0 if all do.
    """

    heights: np.ndarray
    amplification: np.ndarray = field(default_factory=lambda: np.empty(0))
    neighbors: int = 0


Method = Callable[[np.ndarray, np.ndarray, np.ndarray], Surface]
"""Takes points (n, 2), their heights (n,) and queries (m, 2)."""


def solved(job: tuple[Method, np.ndarray, np.ndarray, np.ndarray]) -> Surface:
    """Return the surface of a method, given points, heights and queries."""
    method, points, heights, queries = job
    return method(points, heights, queries)


def methods(degrees: tuple[int, ...], per_coefficient: int, bound: float) -> dict[str, Method]:
    """Return all methods by name, simplest first.

    Parameters
    ----------
    degrees : tuple of int
        Of least squares.
    per_coefficient : int
        Points in a neighbourhood, for each coefficient of the local polynomial.
    bound : float
        Largest amplification that the guarded method accepts.
    """
    return {
        **{f"LS {degree}": partial(least_squares, degree) for degree in degrees},
        "MLS 1": partial(moving, 1, per_coefficient),
        "MLS 1 wide": partial(moving, 1, 2 * per_coefficient),
        "MLS 2": partial(moving, 2, per_coefficient),
        "MLS 2 wide": partial(moving, 2, 2 * per_coefficient),
        GUARDED: partial(guarded, bound, per_coefficient),
        "RBF −r": partial(interpolant, polyharmonic(1)),
        THIN_PLATE: partial(interpolant, thin_plate_spline()),
        "RBF r³": partial(interpolant, polyharmonic(3)),
        TRIANGLES: triangles,
    }


def key(name: str) -> str:
    """Return the name of a method in the form of an array name."""
    return name.replace(" ", "_").lower()


def family(name: str) -> str:
    """Return LS, MLS, RBF or truth, by which a method is coloured; SciPy's triangles have none."""
    return {THIN_PLATE: "RBF", TRIANGLES: "truth"}.get(name) or name.split()[0]


def least_squares(
    degree: int, points: np.ndarray, heights: np.ndarray, queries: np.ndarray
) -> Surface:
    """One polynomial for the whole map."""
    return Surface(LeastSquares(points, degree).field(heights)(queries))


def moving(
    degree: int,
    per_coefficient: int,
    points: np.ndarray,
    heights: np.ndarray,
    queries: np.ndarray,
) -> Surface:
    """A polynomial for every query, by its nearest points."""
    weights = local_weights(degree, per_coefficient * coefficients(degree), points, queries)
    return Surface(weights @ heights, amplification(weights), int(np.diff(weights.indptr).max()))


def guarded(
    bound: float,
    per_coefficient: int,
    points: np.ndarray,
    heights: np.ndarray,
    queries: np.ndarray,
) -> Surface:
    """Moving least squares of degree 2; of 1, at last of 0, where the weights grow too large.

    The weights do not depend on the heights: where they are large, the error may be large on any
    terrain. With degree 0 they are positive and sum to one, and the height is a mean.
    """
    result, sizes = np.empty(len(queries)), np.empty(len(queries))
    unsafe = np.arange(len(queries))
    for degree in (2, 1, 0):
        neighbors = per_coefficient * coefficients(degree)
        weights = local_weights(degree, neighbors, points, queries[unsafe])
        result[unsafe], sizes[unsafe] = weights @ heights, amplification(weights)
        unsafe = unsafe[sizes[unsafe] > bound]
    return Surface(result, sizes)


def interpolant(
    kernel: Radial, points: np.ndarray, heights: np.ndarray, queries: np.ndarray
) -> Surface:
    """Radial basis functions through all points."""
    return Surface(RBF(points, kernel).field(heights)(queries))


def triangles(points: np.ndarray, heights: np.ndarray, queries: np.ndarray) -> Surface:
    """Linear interpolation on Delaunay triangles, by SciPy; nothing outside of the hull."""
    return Surface(LinearNDInterpolator(points, heights)(queries))


def scipy_thin_plate(points: np.ndarray, heights: np.ndarray, queries: np.ndarray) -> Surface:
    """The thin-plate spline as SciPy makes it."""
    spline = RBFInterpolator(points, heights, kernel="thin_plate_spline", degree=1)
    return Surface(spline(queries))


def local_weights(
    degree: int, neighbors: int, points: np.ndarray, queries: np.ndarray
) -> sparse.csr_array:
    """Return the weights (m, n) of moving least squares on the nearest points.

    Where these are collinear they do not determine a plane: the number of points is doubled until
    they determine the polynomial at every query.
    """
    try:
        return MovingLeastSquares(points, WEIGHT, degree, neighbors).weights(queries)
    except np.linalg.LinAlgError:
        return local_weights(degree, 2 * neighbors, points, queries)


def amplification(weights: sparse.csr_array) -> np.ndarray:
    """Return the sum of the absolute weights of each query."""
    return abs(weights).sum(axis=1)


def coefficients(degree: int) -> int:
    """Return the number of coefficients of a polynomial in two variables."""
    return (degree + 1) * (degree + 2) // 2
