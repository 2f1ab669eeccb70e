"""Judging a method by its own data: leave one out."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress
from fieldrecon.methods.globe import OnGlobe
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.reconstruction import Reconstruction

# Below this 1 - h_ii the closed form has lost four digits and more: the point is dropped instead.
_ACCURATE = 1e-4


@valid.finite("the residuals")
def leave_one_out(
    method: Reconstruction, values: ArrayLike, *, progress: Progress | None = None
) -> np.ndarray:
    """Leave-one-out residuals f_i - s_(-i)(p_i): each datum against the field of all the others.

    Least squares, and moving least squares over all sites or a fixed radius: r_i / (1 - h_ii), with
    h_ii the diagonal of H(X); where 1 - h_ii is tiny, and for k nearest sites, whose neighbourhoods
    change, the point is left out of its own fit. Radial basis functions: lambda_i / (H^-1)_ii
    (Rippa 1999); on patches, the mean of these over those that contain the point, by their weights
    there: the patches stay where they are.

    Parameters
    ----------
    method : Reconstruction
        Method on its sites.
    values : (n, ...) array_like
        Data.
    progress : callable, optional
        Called as progress(done, total) by methods that go through many sites or patches: blended
        patches, and moving least squares on nearest sites.

    Returns
    -------
    (n, ...) ndarray
        Residuals.

    Raises
    ------
    numpy.linalg.LinAlgError
        If the sites without one of them no longer determine the field.
    TypeError
        If the method is not one of those named above.

    References
    ----------
    Rippa, An algorithm for selecting a good value for the parameter c in radial basis function
    interpolation (1999); Golub, Heath and Wahba (1979).

    Examples
    --------
    >>> import fieldrecon as fr
    >>> points = fr.datasets.halton(40, 2)
    >>> e = leave_one_out(fr.LeastSquares(points), points.sum(axis=1))
    >>> bool(abs(e).max() < 1e-12)
    True
    """
    values = valid.as_values(values, len(method.points))
    columns = values.reshape(len(values), -1)
    return _residuals(method, columns, progress).reshape(values.shape)


def _residuals(method: Reconstruction, values: np.ndarray, progress: Progress | None) -> np.ndarray:
    if isinstance(method, LeastSquares):
        return _polynomial_residuals(method, values)
    if isinstance(method, MovingLeastSquares):
        return _moving_residuals(method, values, progress)
    if isinstance(method, OnGlobe):
        return _residuals(method.method, values, progress)
    if isinstance(method, PartitionOfUnityRBF):
        return method.left_out(values, progress)
    if isinstance(method, RBF):
        for i in _indispensable(method.points, method.degree):
            _without(i, method.points, method.degree)
        return method._prepare(values)[0] / method.inverse_diagonal()[:, None]
    raise TypeError(f"leave_one_out does not know {type(method).__name__}")


def _polynomial_residuals(method: LeastSquares, values: np.ndarray) -> np.ndarray:
    rest = 1.0 - method.leverages()
    result = method.residuals(values) / np.where(rest > _ACCURATE, rest, 1.0)[:, None]
    # no more of them than coefficients, since the leverages sum to that number
    for i in np.flatnonzero(rest <= _ACCURATE).tolist():
        others = _without(i, method.points, method.degree).field(np.delete(values, i, axis=0))
        result[i] = values[i] - others(method.points[i])
    return result


def _moving_residuals(
    method: MovingLeastSquares, values: np.ndarray, progress: Progress | None
) -> np.ndarray:
    if method.neighbors is not None:
        return values - method.left_out(values, progress=progress)
    rest = 1.0 - method.own_weights()
    residual = values - method.field(values)(method.points)
    accurate = rest > _ACCURATE
    result = residual / np.where(accurate, rest, 1.0)[:, None]
    dropped = np.flatnonzero(~accurate)
    if len(dropped):
        result[dropped] = values[dropped] - method.left_out(values, dropped)
    return result


def _indispensable(points: np.ndarray, degree: int) -> list[int]:
    """Points without which the others may not determine the polynomial."""
    if degree < 0:
        return []
    rest = 1.0 - LeastSquares(points, degree).leverages()
    return np.flatnonzero(rest <= _ACCURATE).tolist()


def _without(i: int, points: np.ndarray, degree: int) -> LeastSquares:
    """The polynomial on the other points, refused in words where they do not determine it."""
    try:
        if len(points) > 1:
            return LeastSquares(np.delete(points, i, axis=0), degree)
    except np.linalg.LinAlgError:
        pass
    where = valid.place(points[i])
    raise np.linalg.LinAlgError(
        f"without point {i}, ({where}), the others do not determine the polynomial: "
        "it cannot be left out"
    )
