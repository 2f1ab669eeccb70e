"""Judging a method by its own data: leave one out."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon import _validation as valid
from fieldrecon.least_squares import LeastSquares
from fieldrecon.moving_least_squares import MovingLeastSquares
from fieldrecon.rbf import RBF
from fieldrecon.reconstruction import Reconstruction

# Below this 1 - h_ii the closed form has lost four digits and more: the point is dropped instead.
_ACCURATE = 1e-4


def leave_one_out(method: Reconstruction, values: ArrayLike) -> np.ndarray:
    """Leave-one-out residuals f_i - s_(-i)(p_i): each datum against the field of all the others.

    Least squares, and moving least squares over all sites or a fixed radius: r_i / (1 - h_ii), with
    h_ii the diagonal of H(X); where 1 - h_ii is tiny, and for k nearest sites, whose neighbourhoods
    change, the point is left out of its own fit. Radial basis functions: lambda_i / (H^-1)_ii
    (Rippa 1999).

    Parameters
    ----------
    method : Reconstruction
        Method on its sites.
    values : (n, ...) array_like
        Data.

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
    return _residuals(method, columns).reshape(values.shape)


def _residuals(method: Reconstruction, values: np.ndarray) -> np.ndarray:
    if isinstance(method, LeastSquares):
        rest = _without_own(method.leverages(), method.points, floor=1e-12)
        return method.residuals(values) / rest[:, None]
    if isinstance(method, MovingLeastSquares):
        return _moving_residuals(method, values)
    if isinstance(method, RBF):
        inverse = method.inverse_diagonal()
        _refuse_indispensable(inverse <= 1e-14 * inverse.max(), method.points)
        return method._prepare(values)[0] / inverse[:, None]
    raise TypeError(f"leave_one_out does not know {type(method).__name__}")


def _moving_residuals(method: MovingLeastSquares, values: np.ndarray) -> np.ndarray:
    if method.neighbors is not None:
        return values - method.left_out(values)
    rest = 1.0 - method.own_weights()
    residual = values - method.field(values)(method.points)
    accurate = rest > _ACCURATE
    result = residual / np.where(accurate, rest, 1.0)[:, None]
    dropped = np.flatnonzero(~accurate)
    if len(dropped):
        result[dropped] = values[dropped] - method.left_out(values, dropped)
    return result


def _without_own(own: np.ndarray, points: np.ndarray, floor: float) -> np.ndarray:
    rest = 1.0 - own
    _refuse_indispensable(rest <= floor, points)
    return rest


def _refuse_indispensable(needed: np.ndarray, points: np.ndarray) -> None:
    if needed.any():
        i = int(np.argmax(needed))
        where = ", ".join(f"{c:.6g}" for c in points[i])
        raise np.linalg.LinAlgError(
            f"without point {i}, ({where}), the others do not determine the polynomial: "
            "it cannot be left out"
        )
