"""The body where a scalar that is known at scattered points exceeds a level, or is below it."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.solids.constructive import Solid

_NEIGHBORS = 8  # of each sample, between which and the sample the scalar may cross the level
_LAYER = 0.02  # of the box: samples that are its outermost
_MARGIN = 1.0  # spacings around the samples


class LevelSet(Solid):
    """The body on one side of the level of a scalar, such as signed distances or a grade.

    The scalar is interpolated in patches. The body is on the side that fewer of the outermost
    samples have, since a body is bounded.

    Parameters
    ----------
    points : (n, 3) ndarray
        Samples, near the origin: far from it, coordinates lose digits.
    values : (n,) ndarray
    level : float

    Attributes
    ----------
    points : (k, 3) ndarray
        Points between neighbouring samples on two sides of the level, by linear interpolation.
    samples : int
        Number of samples.
    warnings : tuple of str

    Raises
    ------
    ValueError
        If the level is not between the least and the greatest value.

    Examples
    --------
    >>> import fieldrecon as fr
    >>> x = 2 * fr.datasets.halton(2000, 3) - 1
    >>> ball = LevelSet(x, np.linalg.norm(x, axis=1), 0.6)
    >>> bool(abs(fr.extract_surface(ball).volume / (4 / 3 * np.pi * 0.6**3) - 1) < 0.02)
    True
    """

    spacing: float

    def __init__(self, points: np.ndarray, values: np.ndarray, level: float) -> None:
        points, values = valid.as_points(points), valid.as_values(values, len(points))
        if not values.min() < level < values.max():
            raise ValueError(
                f"level must lie between the values, {values.min():.6g} to {values.max():.6g}; got "
                f"{level:.6g}"
            )
        low, high = points.min(axis=0), points.max(axis=0)
        outermost = (abs(points - (low + high) / 2) >= (0.5 - _LAYER) * (high - low)).any(axis=1)
        above, below = ((side[outermost]).sum() for side in (values > level, values < level))
        self.sign = -1.0 if above > below else 1.0
        self.samples = len(points)
        distance, neighbor = cKDTree(points).query(points, range(2, _NEIGHBORS + 2))
        self.spacing = float(np.median(distance[:, 0]))
        self.box = np.array([low - _MARGIN * self.spacing, high + _MARGIN * self.spacing])
        heights = self.sign * (values - level)
        self.points = self.near = _crossings(points, heights, neighbor)
        self._field = PartitionOfUnityRBF(points).field(heights)
        side = "greater" if self.sign > 0 else "less"
        self.warnings = (
            f"The body is where the value is {side} than {level:g}: at most of the outermost "
            "samples it is not.",
        )

    def _values(self, x: np.ndarray) -> np.ndarray:
        return self._field(x)

    def _gradients(self, x: np.ndarray) -> np.ndarray:
        return self._field.gradient(x)


def _crossings(points: np.ndarray, heights: np.ndarray, neighbor: np.ndarray) -> np.ndarray:
    """Zeros (k, 3) of the linear interpolant between samples (n,) and their neighbours (n, m)."""
    one = np.repeat(np.arange(len(points)), neighbor.shape[1])
    other = neighbor.ravel()
    crosses = (heights[one] > 0) & (heights[other] <= 0)
    one, other = one[crosses], other[crosses]
    share = (heights[one] / (heights[one] - heights[other]))[:, None]
    return np.unique((1 - share) * points[one] + share * points[other], axis=0)
