"""Least squares: one polynomial for all sites."""

from __future__ import annotations

from concurrent.futures import Executor

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.blas_threads import blas_threads_for
from fieldrecon._core.chunks import Progress, report_all, rows_of
from fieldrecon._numerics.far_queries import refuse_lost_constants
from fieldrecon._numerics.orthonormal_polynomials import OrthonormalPolynomials
from fieldrecon.polynomials import (
    EPS,
    Frame,
    dimension,
    exponents,
    monomials,
    powers_of_scale,
    refuse_too_few,
    undetermined,
)
from fieldrecon.reconstruction import Reconstruction

# Below this 1 - h_ii the closed form of leave-one-out residuals has lost four digits and more.
ACCURATE = 1e-4
# Error of a field by its coefficients in monomials, as a part of the data, that is tolerated.
DIGITS_LOST = 1e-6


class LeastSquares(Reconstruction):
    """Polynomial of least squares, c = argmin 1/2 |B c - V|^2 and f(x) = b(x)^T c.

    Computed with polynomials that are orthonormal on the sites, in a local frame, so that neither
    the origin, nor the unit of length, nor a high degree costs digits. The degree itself may: on n
    equidistant sites, degrees far beyond 2 sqrt(n) amplify the errors of the data. Far from the
    sites, beside a thin strip of them, and between clusters or between them and an outlier, errors
    and rounding are multiplied by the sum of the absolute weights, which grows like a power of the
    distance, the degree. Where a constant is lost, values are refused. Interpolates only if there
    are as many sites as coefficients.

    Parameters
    ----------
    points : (n, d) array_like
        Sites.
    degree : int
        Total degree of the polynomial, 0 or more.
    executor : concurrent.futures.Executor, optional
        Accepted by all methods; this one has nothing to split.
    progress : callable, optional
        Called once, as progress(n, n), when the method is made.

    Raises
    ------
    ValueError
        If the points are not a finite (n, d) array, or the degree is not an integer >= 0.
    numpy.linalg.LinAlgError
        If the points do not determine a polynomial of this degree, or the rounding of their
        coordinates decides its values: on 200 equidistant points from degree 113 on.

    References
    ----------
    Erleben, Field Reconstruction, p. 3-7; Brubeck, Nakatsukasa and Trefethen, Vandermonde with
    Arnoldi (2021).

    Examples
    --------
    >>> import numpy as np
    >>> points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    >>> method = LeastSquares(points)
    >>> method.coefficients([0.0, 1.0, 1.0, 4.0]).round(12)
    array([-0.5,  2. ,  2. ])
    >>> round(float(method.objective([0.0, 1.0, 1.0, 4.0])), 12)
    0.5
    """

    def __init__(
        self,
        points: ArrayLike,
        degree: int = 1,
        *,
        executor: Executor | None = None,  # noqa: ARG002 - as for all methods
        progress: Progress | None = None,
    ) -> None:
        self.points = valid.as_points(points)
        self.degree = valid.as_degree(degree)
        self._frame = Frame.around(self.points)
        refuse_too_few(self.points, self.degree)
        y = self._frame.local(self.points)
        rounding = EPS * np.abs(self.points).max(axis=0) / self._frame.scale
        q = dimension(y.shape[1], self.degree)
        with blas_threads_for(2 * len(y) * q * q):
            self._basis = OrthonormalPolynomials(y, self.degree, rounding)
        self._q = self._basis.at_sites
        if self._basis.is_steep:
            raise _too_steep(len(y), self.degree, self._basis.last_degree)
        if self._q.shape[1] < q:
            raise undetermined(y.shape[1], self.degree, self._q.shape[1])
        self.interpolates = len(y) == q
        report_all(progress, len(y))

    @valid.finite("the coefficients")
    def coefficients(self, values: ArrayLike) -> np.ndarray:
        """Coefficients c in the basis 1, x_1 ... x_d, then by total degree.

        Parameters
        ----------
        values : (n, ...) array_like
            Data.

        Returns
        -------
        (q, ...) ndarray
            Coefficients in the coordinates of the points themselves, not of the local frame.

        Raises
        ------
        OverflowError
            If they do not fit into floating-point numbers in this unit of length.
        numpy.linalg.LinAlgError
            If they cancel so much, at high degrees, that they would miss the field at the points by
            more than 1e-6 of the data's size.
        """
        values = valid.as_values(values, len(self.points))
        fitted = self._q.T @ values.reshape(len(values), -1)
        d = self.points.shape[1]
        local = self._basis.in_monomials(d) @ fitted
        back = monomials(self._frame.local(self.points), self.degree) @ local
        lost = np.abs(back - self._q @ fitted).max(axis=0)
        if (lost > DIGITS_LOST * np.abs(values).max(initial=0.0)).any():
            raise np.linalg.LinAlgError(
                f"the coefficients of the monomials of degree {self.degree} are so large that they "
                f"cancel: by them the field would have errors of {lost.max():.0e} at the points; "
                "field(values) uses polynomials that are orthonormal on the points"
            )
        c = self._frame.global_coefficients(local, self.degree)
        return c.reshape((len(c), *values.shape[1:]))

    @valid.finite("the objective's squares")
    def objective(self, values: ArrayLike) -> np.ndarray:
        """Objective psi_LS = 1/2 |B c - V|^2 at its minimum.

        Parameters
        ----------
        values : (n, ...) array_like
            Data.

        Returns
        -------
        (...) ndarray
            One number for each component of the data.

        Raises
        ------
        OverflowError
            If the squares overflow.
        """
        residual = self.residuals(values)
        return half_sum_of_squares(residual)

    @valid.finite("the residuals")
    def residuals(self, values: ArrayLike) -> np.ndarray:
        """Residuals V - B c at the sites, (n, ...)."""
        values = valid.as_values(values, len(self.points))
        columns = values.reshape(len(values), -1)
        return (columns - self._q @ (self._q.T @ columns)).reshape(values.shape)

    @valid.finite("the entries of H_LS")
    def matrix(self) -> np.ndarray:
        """Matrix H_LS = B^T B of the notes, in the coordinates of the points; for inspection.

        Returns
        -------
        (q, q) ndarray
            Symmetric; its condition number is the square of that of B.

        Raises
        ------
        OverflowError
            If its entries do not fit into floating-point numbers in this unit of length.
        """
        b = monomial_matrix(self.points, self.degree)
        return b.T @ b

    def leverages(self) -> np.ndarray:
        """Leverages: the diagonal (n,) of the hat matrix H(X)."""
        return np.einsum("ij,ij->i", self._q, self._q)

    def _leave_one_out(self, values: np.ndarray, progress: Progress | None) -> np.ndarray:  # noqa: ARG002
        """Residuals r_i / (1 - h_ii), by a refit where the leverage h_ii is nearly one."""
        rest = 1.0 - self.leverages()
        result = self.residuals(values) / np.where(rest > ACCURATE, rest, 1.0)[:, None]
        # no more of them than coefficients, since the leverages sum to that number
        for i in np.flatnonzero(rest <= ACCURATE).tolist():
            result[i] = self._residual_without(i, values)
        return result

    def refuse_indispensable(self) -> None:
        """Refuse points without one of which the others do not determine the polynomial."""
        for i in np.flatnonzero(1.0 - self.leverages() <= ACCURATE).tolist():
            self._without(i)

    def _prepare(self, values: np.ndarray) -> np.ndarray:
        return self._q.T @ values

    def _basis_at(self, x: np.ndarray) -> np.ndarray:
        """Orthonormal polynomials (m, q) at queries (m, d), refused where rounding decides values.

        The weights are a product with orthonormal columns, so they have the norm of a row.
        """
        basis = self._basis.values(self._frame.local(x))
        norm = np.linalg.norm(basis, axis=1, keepdims=True)
        refuse_lost_constants(x, EPS * np.sqrt(len(self.points)) * norm)
        return basis

    def _value_rows(self, x: np.ndarray, prepared: np.ndarray) -> np.ndarray:
        return self._basis_at(x) @ prepared

    def _gradient_rows(self, x: np.ndarray, prepared: np.ndarray) -> np.ndarray:
        self._basis_at(x)
        slopes = self._basis.gradients(self._frame.local(x)) @ prepared
        return np.moveaxis(slopes, 0, -1) / self._frame.scale

    def _hessian_rows(self, x: np.ndarray, prepared: np.ndarray) -> np.ndarray:
        self._basis_at(x)
        bends = self._basis.hessians(self._frame.local(x)) @ prepared
        return np.moveaxis(bends, (0, 1), (-2, -1)) / self._frame.scale / self._frame.scale

    def _weight_rows(self, x: np.ndarray) -> np.ndarray:
        return self._basis_at(x) @ self._q.T

    def _gradient_weight_rows(self, x: np.ndarray) -> tuple[np.ndarray, ...]:
        self._basis_at(x)
        slopes = self._basis.gradients(self._frame.local(x)) / self._frame.scale
        return tuple(slopes @ self._q.T)

    def _moments(self, x: np.ndarray, f: np.ndarray) -> tuple[slice, np.ndarray]:
        return slice(None), self._basis_at(x).T @ f

    def _number_of_moments(self) -> int:
        return self._q.shape[1]

    def _of_moments(self, moments: np.ndarray) -> np.ndarray:
        return self._q @ moments

    def _chunk_rows(self, columns: int) -> int:
        q, d = dimension(self.points.shape[1], self.degree), self.points.shape[1]
        return rows_of(8 * (q * (d + 2) + columns * (d + 1)))


def _too_steep(n: int, degree: int, last_degree: int) -> np.linalg.LinAlgError:
    return np.linalg.LinAlgError(
        f"degree {degree} is too high for these {n} points in floating-point numbers, and the "
        f"highest degree for them is {last_degree}: between the points, polynomials of higher "
        "degrees are so steep that the rounding of the coordinates decides their values; more "
        "points, denser towards the ends, allow higher degrees"
    )


@valid.finite("the normal equations")
def normal_equations(points: ArrayLike, values: ArrayLike, degree: int = 1) -> np.ndarray:
    """Coefficients c of B^T B c = B^T V: the textbook form of least squares, for comparison.

    It works in the monomials of the coordinates as they are, and squares the condition number of B:
    at an offset of 1e6 no digit is left. Use `LeastSquares`.

    Parameters
    ----------
    points : (n, d) array_like
        Sites.
    values : (n, ...) array_like
        Data.
    degree : int
        Total degree of the polynomial.

    Returns
    -------
    (q, ...) ndarray
        Coefficients in the basis 1, x_1 ... x_d, then by total degree.

    Raises
    ------
    numpy.linalg.LinAlgError
        If B^T B is singular in floating-point numbers.
    OverflowError
        If the matrix does not fit into floating-point numbers in this unit of length.

    References
    ----------
    Erleben, Field Reconstruction, p. 5 (H_LS c = B^T V).

    Examples
    --------
    >>> normal_equations([[0.0], [1.0], [2.0]], [1.0, 3.0, 5.0]).round(12)
    array([1., 2.])
    """
    points = valid.as_points(points)
    values = valid.as_values(values, len(points))
    b = monomial_matrix(points, valid.as_degree(degree))
    try:
        c = np.linalg.solve(b.T @ b, b.T @ values.reshape(len(values), -1))
    except np.linalg.LinAlgError:
        raise np.linalg.LinAlgError(
            "BᵀB is singular in floating-point numbers: the points do not determine the "
            "polynomial, or lie too far from the origin; LeastSquares shows which"
        ) from None
    return c.reshape((len(c), *values.shape[1:]))


def monomial_matrix(points: np.ndarray, degree: int) -> np.ndarray:
    """Matrix B with the rows b(p_i)^T in the points' own coordinates, (n, q).

    Raises
    ------
    OverflowError
        If squares of its entries would not fit into floating-point numbers.
    """
    d = points.shape[1]
    size = float(np.abs(points).max()) or 1.0
    # entries are multiplied in pairs, hence the square
    powers_of_scale(
        2.0 ** np.floor(np.log2(size)), 2 * exponents(d, degree).sum(axis=1), "the matrix"
    )
    return monomials(points, degree)


def half_sum_of_squares(weighted_residual: np.ndarray, axis: int = 0) -> np.ndarray:
    """1/2 sum |r|^2 over one axis, refused where the squares overflow or vanish."""
    size = np.abs(weighted_residual)
    largest = float(size.max(initial=0.0))
    if largest > 1e150 or 0 < largest < 1e-150:
        raise OverflowError(
            f"the squares of residuals of size {largest:.1e} do not fit into floating-point "
            "numbers; choose a unit nearer to the data"
        )
    return 0.5 * np.sum(size**2, axis=axis)
