"""Anisotropic distances: a linear map in front of a method, and the chain rule behind it.

With M = L^T L the distance sqrt((x - y)^T M (x - y)) is the Euclidean distance of L x and L y. The
map takes polynomials to polynomials of the same degree. So a method with a metric is the same
method on mapped sites, evaluated at mapped queries, and derivatives are mapped back by L^T.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import reduce
from operator import add

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon.polynomials import EPS, Derivative, Frame, power_of_two_above

ASYMMETRY = 1e-12
"""Difference of the entries (i, j) and (j, i) of a matrix, relative to its size: rounding."""


@dataclass(frozen=True)
class MetricFrame(Frame):
    """Local frame y = L (x - center) / scale, in which a metric is the Euclidean distance.

    Sites are shifted before they are mapped, so that their map is rounded relative to their extent.
    """

    factor: np.ndarray

    is_isotropic = False
    who = "the points, as far apart as the metric says, do"

    def local(self, x: np.ndarray) -> np.ndarray:
        """Coordinates (..., d) in the frame."""
        return (x - self.center) @ self.factor.T / self.scale

    def point(self, y: np.ndarray) -> np.ndarray:
        """The point x (d,) with the coordinates y in the frame."""
        return self.center + self.scale * np.linalg.solve(self.factor, y)

    def scaled(self, x: np.ndarray) -> np.ndarray:
        """Coordinates (..., d) in the frame."""
        return self.local(x)

    def gradient(self, by_y: np.ndarray) -> np.ndarray:
        """Derivatives (..., d) by x from those by y."""
        return super().gradient(by_y) @ self.factor

    def hessian(self, by_y: np.ndarray) -> np.ndarray:
        """Second derivatives (..., d, d) by x from those by y, symmetric to the last bit."""
        by_x = self.factor.T @ super().hessian(by_y) @ self.factor
        return by_x / 2 + by_x.mT / 2

    def partials(self, by_y: Iterable[Derivative]) -> tuple[Derivative, ...]:
        """Derivatives by each of the d variables x from those by y."""
        terms = super().partials(by_y)
        return tuple(
            reduce(add, (entry * term for entry, term in zip(column, terms, strict=True)))
            for column in self.factor.T
        )


def as_metric(metric: ArrayLike | None, d: int) -> np.ndarray | None:
    """Scales (d,) of the coordinates, or a symmetric positive definite matrix (d, d); read-only.

    Raises
    ------
    ValueError
        If it has another shape, scales that are not positive, or is not symmetric.
    numpy.linalg.LinAlgError
        If the matrix is not positive definite.
    """
    if metric is None:
        return None
    m = valid.as_values(metric, d, name="metric", of="coordinate").copy()
    if m.shape not in ((d,), (d, d)) or np.iscomplexobj(m):
        raise ValueError(
            f"metric must be the scales of the coordinates, real numbers of the shape ({d},), or a "
            f"matrix of the shape ({d}, {d}); got the shape {m.shape} and the type {m.dtype}"
        )
    if m.ndim == 1 and not (m > 0).all():
        i = int(np.argmin(m > 0))
        raise ValueError(f"metric must have positive scales; metric[{i}] is {m[i]:g}")
    if m.ndim == 2:
        _require_positive_definite(m)
    m.flags.writeable = False
    return m


def frame_of(points: np.ndarray, metric: np.ndarray | None) -> Frame:
    """The frame of the sites (n, d), in which the distance of the metric is Euclidean."""
    frame = Frame.around(points)
    if metric is None:
        return frame
    factor = np.diag(1 / metric) if metric.ndim == 1 else np.linalg.cholesky(metric).T
    mapped = MetricFrame(frame.center, 1.0, factor)
    extent = float(np.abs(valid.quiet_evaluate(mapped.local, points)).max())
    if not extent < np.inf:
        raise OverflowError(
            "the distances of the metric exceed the range of floating-point numbers; choose units "
            "nearer to the size of the points"
        )
    return replace(mapped, scale=float(power_of_two_above(extent)))


def _require_positive_definite(m: np.ndarray) -> None:
    i, j = np.unravel_index(np.argmax(np.abs(m - m.T)), m.shape)
    if not abs(m[i, j] - m[j, i]) <= ASYMMETRY * np.abs(m).max():
        raise ValueError(
            f"metric must be symmetric; metric[{i}, {j}] is {m[i, j]:g} and metric[{j}, {i}] is "
            f"{m[j, i]:g}"
        )
    # relative to the diagonal, so that the units of the coordinates and their order do not matter
    unit = np.sqrt(np.maximum(np.diagonal(m), 0.0))
    if not unit.all() or np.linalg.eigvalsh(m / unit / unit[:, None])[0] <= 4 * len(m) * EPS:
        least = np.linalg.eigvalsh(m)[0]
        raise np.linalg.LinAlgError(
            f"metric must be positive definite; its least eigenvalue is {least:.3g}, and its "
            f"largest entry {np.abs(m).max():.3g}"
        )
