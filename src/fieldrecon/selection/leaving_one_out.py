"""Leave-one-out cross-validation: each datum against the field of all the others."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress
from fieldrecon._numerics.data_units import in_units_of_data
from fieldrecon.reconstruction import Reconstruction


@valid.finite("the residuals")
def leave_one_out(
    method: Reconstruction, values: ArrayLike, *, progress: Progress | None = None
) -> np.ndarray:
    """Leave-one-out residuals f_i - s_(-i)(p_i): each datum against the field of all the others.

    Each method provides its own: least squares, and moving least squares over all sites or a fixed
    radius, r_i / (1 - h_ii), with h_ii the diagonal of H(X); where 1 - h_ii is tiny, and for k
    nearest sites, whose neighbourhoods change, the point is left out of its own fit. Radial basis
    functions: lambda_i / (H^-1)_ii (Rippa 1999); on patches, the mean of these over those that
    contain the point, by their weights there. The patches stay where they are, so these residuals
    estimate the error, and are not those of fits without the point. Hermite data: the formula of
    radial basis functions for functionals. Natural splines: (K f)_i / K_ii with the energy f^T K f.
    Any other method is made again on the other points, n times.

    Parameters
    ----------
    method : Reconstruction
        Method on its sites.
    values : (n, ...) array_like
        Data.
    progress : callable, optional
        Called as progress(done, total) with numbers of sites or patches, by methods that do not
        have all residuals at once.

    Returns
    -------
    (n, ...) ndarray
        Residuals.

    Raises
    ------
    numpy.linalg.LinAlgError
        If the sites without one of them no longer determine the field.
    TypeError
        If the method is not made from points, so that none of them can be left out, or has no
        meaning without one: barycentric coordinates.

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
    if not isinstance(method, Reconstruction):
        raise TypeError(f"method must be a Reconstruction; got {method!r}")
    values = valid.as_values(values, len(method.points))
    columns, units = in_units_of_data(values.reshape(len(values), -1))
    residuals = method._leave_one_out(columns, progress)
    return valid.quiet_evaluate(np.multiply, residuals, units).reshape(values.shape)
