"""From samples to a grid: which method fits them, and where the grid is more than a guess."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
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

_NO_FIELD = (ValueError, np.linalg.LinAlgError, MemoryError, OverflowError)
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
    most : float
        Most samples on which it is tried unasked: global kernels cost as n³.
    """

    name: str
    family: str
    meaning: str
    at_sites: Callable[[np.ndarray, np.ndarray], Reconstruction]
    most: float = np.inf


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
            Candidate("tps", "RBF", "thin-plate spline", partial(_interpolant, 2), 5000),
            Candidate("cubic", "RBF", "cubic spline r³", partial(_interpolant, 3), 5000),
            Candidate("smooth", "RBF", "thin plate, smoothed", _smoothed, 2000),
        )
    }
)


@dataclass(frozen=True, eq=False)
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
    candidate: Candidate, points: np.ndarray, values: np.ndarray, asked_for: bool = False
) -> Trial:
    """Leave each sample out in turn and see how far the others miss it.

    A method that cannot be had on these points, or would take too long, says why.
    """
    if len(points) > candidate.most and not asked_for:
        return Trial(candidate, None, f"not tried on more than {candidate.most:g} samples unasked")
    try:
        return Trial(candidate, leave_one_out(candidate.at_sites(points, values), values))
    except _NO_FIELD as error:
        return Trial(candidate, None, str(error))


def best_field(
    trials: Sequence[Trial], points: np.ndarray, values: np.ndarray, x: np.ndarray
) -> tuple[Trial, np.ndarray]:
    """Return the trial of least rms whose field exists at all the queries, and its values there.

    Raises
    ------
    numpy.linalg.LinAlgError
        If there is none; the reason is that of the first, the simplest method.
    """
    reasons = [f"{trial.candidate.name}: {trial.reason}" for trial in trials if trial.reason]
    for trial in sorted(trials, key=lambda trial: trial.rms)[: len(trials) - len(reasons)]:
        try:
            return trial, trial.candidate.at_sites(points, values).field(values)(x)
        except _NO_FIELD as error:
            reasons.append(f"{trial.candidate.name}: {error}")
    raise np.linalg.LinAlgError(f"no field from these samples by {reasons[0]}")


@dataclass(frozen=True)
class Grid:
    """A field at the nodes of a regular grid.

    Parameters
    ----------
    x, y : ndarray of shape (columns,) and (rows,)
    values : ndarray of shape (rows, columns)
        ``values[i, j]`` belongs to ``(x[j], y[i])``.
    points : ndarray of shape (n, 2)
        Where the samples lie.
    """

    x: np.ndarray
    y: np.ndarray
    values: np.ndarray
    points: np.ndarray

    @cached_property
    def nodes(self) -> np.ndarray:
        """The nodes (rows * columns, 2), in the order of ``values.ravel()``."""
        return nodes_of(self.x, self.y)

    @cached_property
    def extrapolated(self) -> np.ndarray:
        """Whether each node lies outside the convex hull of the samples: (rows, columns)."""
        return outside_hull(self.points, self.nodes).reshape(self.values.shape)


def nodes_of(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the points (rows * columns, 2) of the grid over x and y, row by row."""
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def grid_over(
    points: np.ndarray, columns: int, rows: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lay a grid over the points, as wide and as high as they are; return x, y and the nodes.

    Examples
    --------
    >>> x, y, nodes = grid_over(np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]]), 3, 2)
    >>> x.tolist(), y.tolist(), nodes.shape
    ([0.0, 1.0, 2.0], [0.0, 1.0], (6, 2))
    """
    low, high = points.min(axis=0), points.max(axis=0)
    x, y = np.linspace(low[0], high[0], columns), np.linspace(low[1], high[1], rows)
    return x, y, nodes_of(x, y)


def outside_hull(points: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Tell which queries (m, 2) lie outside the convex hull of the points; its edge is inside."""
    middle, size = points.mean(axis=0), np.ptp(points, axis=0)
    hull = ConvexHull((points - middle) / size)
    normals, offsets = hull.equations[:, :-1], hull.equations[:, -1]
    return ((x - middle) / size @ normals.T + offsets).max(axis=1) > 1e-9
