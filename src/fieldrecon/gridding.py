"""From samples to a grid: which method fits them, and where the grid is more than a guess."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

import numpy as np
from scipy.spatial import ConvexHull

from fieldrecon.least_squares import LeastSquares
from fieldrecon.model_selection import leave_one_out
from fieldrecon.moving_least_squares import MovingLeastSquares
from fieldrecon.positive_definite import wendland
from fieldrecon.radial import polyharmonic, thin_plate_spline
from fieldrecon.rbf import RBF
from fieldrecon.reconstruction import Reconstruction

GLOBAL_LIMIT = 5000
"""Most samples for which radial basis functions are tried unasked: their cost grows as n³."""

_NEIGHBORS_PER_COEFFICIENT = 4
_SMOOTHINGS = tuple(10.0**k for k in range(-6, 1))


@dataclass(frozen=True)
class Candidate:
    """A method that may be tried on samples.

    Parameters
    ----------
    name : str
        As it is typed.
    family : str
        LS, MLS or RBF.
    meaning : str
        What it is, in a few words.
    at_sites : callable
        Takes points (n, 2) and values (n,) to the method on these points.
    """

    name: str
    family: str
    meaning: str
    at_sites: Callable[[np.ndarray, np.ndarray], Reconstruction]


def _least_squares(degree: int, points: np.ndarray, _: np.ndarray) -> LeastSquares:
    return LeastSquares(points, degree)


def _moving(degree: int, points: np.ndarray, _: np.ndarray) -> MovingLeastSquares:
    coefficients = (degree + 1) * (degree + 2) // 2
    neighbors = min(_NEIGHBORS_PER_COEFFICIENT * coefficients, len(points) - 1)
    return MovingLeastSquares(points, wendland(3, 1), degree, neighbors)


def _interpolant(power: int, points: np.ndarray, _: np.ndarray) -> RBF:
    return RBF(points, thin_plate_spline() if power == 2 else polyharmonic(power))


def _smoothed(points: np.ndarray, values: np.ndarray) -> RBF:
    """Return the thin plate whose smoothing, in squares of the extent, leaves one out best."""
    unit = np.ptp(points, axis=0).max() ** 2
    plates = (RBF(points, thin_plate_spline(), smoothing=unit * s) for s in _SMOOTHINGS)
    return min(plates, key=lambda plate: np.mean(leave_one_out(plate, values) ** 2))


CANDIDATES: Mapping[str, Candidate] = MappingProxyType(
    {
        candidate.name: candidate
        for candidate in (
            Candidate("ls1", "LS", "least squares, plane", partial(_least_squares, 1)),
            Candidate("ls2", "LS", "least squares, degree 2", partial(_least_squares, 2)),
            Candidate("ls4", "LS", "least squares, degree 4", partial(_least_squares, 4)),
            Candidate("mls1", "MLS", "moving least squares, degree 1", partial(_moving, 1)),
            Candidate("mls2", "MLS", "moving least squares, degree 2", partial(_moving, 2)),
            Candidate("tps", "RBF", "thin-plate spline", partial(_interpolant, 2)),
            Candidate("cubic", "RBF", "cubic spline r³", partial(_interpolant, 3)),
            Candidate("smooth", "RBF", "thin plate, smoothed", _smoothed),
        )
    }
)


@dataclass(frozen=True)
class Trial:
    """What came of a method on the samples: residuals when each is left out, or why there are none.

    Parameters
    ----------
    candidate : Candidate
    residuals : ndarray of shape (n,), optional
        Each value less the field of all the others there.
    reason : str
        Why the method was not tried or does not exist, otherwise empty.
    """

    candidate: Candidate
    residuals: np.ndarray | None
    reason: str = ""

    @property
    def rms(self) -> float:
        """Root mean square of the residuals, in the unit of the values; infinite without any."""
        return np.inf if self.residuals is None else float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def largest(self) -> float:
        """Largest residual in size."""
        return np.inf if self.residuals is None else float(np.abs(self.residuals).max())


def cross_validate(
    candidate: Candidate, points: np.ndarray, values: np.ndarray, limit: int = GLOBAL_LIMIT
) -> Trial:
    """Leave each sample out in turn and see how far the others miss it.

    A method that cannot be had on these points, or would take too long, says why.
    """
    if candidate.family == "RBF" and len(points) > limit:
        return Trial(candidate, None, f"not tried on more than {limit} samples unless asked for")
    try:
        return Trial(candidate, leave_one_out(candidate.at_sites(points, values), values))
    except (ValueError, np.linalg.LinAlgError, MemoryError, OverflowError) as error:
        return Trial(candidate, None, str(error))


def best(trials: list[Trial]) -> Trial:
    """Return the trial of least rms.

    Raises
    ------
    numpy.linalg.LinAlgError
        If none succeeded; the reason is that of the first, the simplest method.
    """
    winner = min(trials, key=lambda trial: trial.rms)
    if winner.residuals is None:
        raise np.linalg.LinAlgError(f"no method fits these samples: {trials[0].reason}")
    return winner


@dataclass(frozen=True)
class Grid:
    """A field at the nodes of a regular grid.

    Parameters
    ----------
    x, y : ndarray of shape (columns,) and (rows,)
    values : ndarray of shape (rows, columns)
        ``values[i, j]`` belongs to ``(x[j], y[i])``.
    extrapolated : ndarray of bool, of the same shape
        Whether the node lies outside of the convex hull of the samples.
    """

    x: np.ndarray
    y: np.ndarray
    values: np.ndarray
    extrapolated: np.ndarray


def nodes_of(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the points (rows * columns, 2) of the grid over x and y, row by row."""
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def grid_over(
    points: np.ndarray, columns: int, rows: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lay a grid over the points; return x, y and which nodes (rows, columns) lie outside.

    Examples
    --------
    >>> x, y, outside = grid_over(np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]]), 3, 2)
    >>> x.tolist(), y.tolist(), outside.tolist()
    ([0.0, 1.0, 2.0], [0.0, 1.0], [[False, False, False], [False, True, True]])
    """
    low, high = points.min(axis=0), points.max(axis=0)
    x, y = np.linspace(low[0], high[0], columns), np.linspace(low[1], high[1], rows)
    return x, y, outside_hull(points, nodes_of(x, y)).reshape(rows, columns)


def outside_hull(points: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Tell which queries (m, 2) lie outside the convex hull of the points; its edge is inside."""
    middle, size = points.mean(axis=0), np.ptp(points, axis=0)
    hull = ConvexHull((points - middle) / size)
    normals, offsets = hull.equations[:, :-1], hull.equations[:, -1]
    return ((x - middle) / size @ normals.T + offsets).max(axis=1) > 1e-9
