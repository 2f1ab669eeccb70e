"""Natural cubic splines: the interpolants of least energy, and their radial form with r^3."""

from __future__ import annotations

from concurrent.futures import Executor
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.linalg import cho_solve_banded, cholesky_banded

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, report_all, rows_of
from fieldrecon.fields import Field
from fieldrecon.methods.solvability import refuse_duplicates
from fieldrecon.methods.spline_bases import radial_form
from fieldrecon.polynomials import Frame, powers_of_scale, undetermined
from fieldrecon.reconstruction import Reconstruction


class NaturalCubicSpline(Reconstruction):
    """Natural cubic spline: twice differentiable, cubic between sites, linear beyond the outer two.

    Of all functions through the data it has the least energy, the integral of s''^2. Between two
    sites at the distance h, with u = (x - x_i) / h and the moments M_i = s''(x_i),

        s(x) = (1 - u) f_i + u f_(i+1) + h^2/6 ([(1 - u)^3 - (1 - u)] M_i + [u^3 - u] M_(i+1)),

    where M_1 = M_n = 0 and s' is continuous: a tridiagonal positive definite system. The
    spline takes O(n) for the sites, O(n) for data, and O(log n) for a value. One variable needs no
    axis: sites have the shape (n,), queries any shape, and the gradient is the derivative.

    Parameters
    ----------
    points : (n,) array_like
        Sites in any order, distinct, two or more.
    executor : concurrent.futures.Executor, optional
        Accepted by all methods; this one has nothing to split.
    progress : callable, optional
        Called once, as progress(n, n), when the method is made.

    Raises
    ------
    ValueError
        If sites coincide, or have another shape.
    numpy.linalg.LinAlgError
        If there is only one: any line through it is a natural spline.

    References
    ----------
    Wendland (2005), section 1.4; Golub and van Loan (2013), section 4.3.6.

    Examples
    --------
    >>> method = NaturalCubicSpline([0.0, 1.0, 2.0])
    >>> s = method.field([0.0, 1.0, 0.0])
    >>> s([0.5, 1.0, 3.0]), s.gradient(3.0)
    (array([ 0.6875,  1.    , -1.5   ]), np.float64(-1.5))
    >>> float(method.energy([0.0, 1.0, 0.0]).round(12))
    6.0
    """

    degree = 1
    interpolates = True

    def __init__(
        self,
        points: ArrayLike,
        *,
        executor: Executor | None = None,  # noqa: ARG002 - as for all methods
        progress: Progress | None = None,
    ) -> None:
        self.points = valid.as_line(points)
        if len(self.points) < 2:
            raise undetermined(1, self.degree, 1)
        refuse_duplicates(self.points, "merge them")
        self._sorting = np.argsort(self.points[:, 0])
        self._knots = self.points[self._sorting, 0]
        self._frame = Frame.around(self.points)
        self._h = np.diff(self._knots / self._frame.scale)
        self._factor = cholesky_banded(_moment_matrix(self._h), lower=True)
        report_all(progress, len(self.points))

    def field(self, values: ArrayLike) -> NaturalSpline:
        """Spline of these data.

        Parameters
        ----------
        values : (n, ...) array_like
            One real or complex scalar, vector or array for each site.

        Returns
        -------
        NaturalSpline
            Callable at numbers x of any shape, with the derivative as its gradient.
        """
        return NaturalSpline(self, valid.as_values(values, len(self.points)))

    @valid.finite("the energies")
    def energy(self, values: ArrayLike) -> np.ndarray:
        """Energy, the integral of |s''|^2 over the line: the least of all interpolants.

        Parameters
        ----------
        values : (n, ...) array_like
            Data.

        Returns
        -------
        (...) ndarray
            One number for each component; 12 alpha^T f with the coefficients of r^3.

        Raises
        ------
        OverflowError
            If it does not fit into floating-point numbers in this unit of length.
        """
        values = valid.as_values(values, len(self.points))
        _, moments = self._prepare(values.reshape(len(values), -1))
        a, b = moments[:-1], moments[1:]
        squares = (abs(a) ** 2 + (a * b.conj()).real + abs(b) ** 2) / 3
        unit = powers_of_scale(self._frame.scale, np.array([-3]), "the energy")
        return (unit * (self._h @ squares)).reshape(values.shape[1:])

    @valid.finite("the coefficients")
    def truncated_powers(self, values: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients of s(x) = sum_j alpha_j (x - x_j)_+^3 + beta_0 + beta_1 x.

        Parameters
        ----------
        values : (n, ...) array_like
            Data.

        Returns
        -------
        alpha : (n, ...) ndarray
            A sixth of the jump of s''' at each site; orthogonal to the linear polynomials.
        beta : (2, ...) ndarray
            The line on which the spline begins.

        Raises
        ------
        OverflowError
            If they do not fit into floating-point numbers in this unit of length.

        References
        ----------
        Wendland (2005), equation 1.5.
        """
        values = valid.as_values(values, len(self.points))
        return self._in_own_coordinates(*self._local_form(values), values.shape[1:])

    @valid.finite("the coefficients")
    def coefficients(self, values: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients of s(x) = sum_j alpha_j |x - x_j|^3 + beta_0 + beta_1 x, by `radial_form`.

        They equal the coefficients of `RBF(points[:, None], polyharmonic(3))`, found in O(n).

        Parameters
        ----------
        values : (n, ...) array_like
            Data.

        Returns
        -------
        alpha : (n, ...) ndarray
            Coefficients of r^3, orthogonal to the linear polynomials.
        beta : (2, ...) ndarray
            Coefficients of 1 and x.

        References
        ----------
        Wendland (2005), proposition 1.1.
        """
        values = valid.as_values(values, len(self.points))
        local = radial_form(self._frame.local(self.points[:, 0]), *self._local_form(values))
        return self._in_own_coordinates(*local, values.shape[1:])

    def _local_form(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients alpha (n, v) and beta (2, v) of truncated powers in the frame."""
        f, moments = self._prepare(values.reshape(len(values), -1))
        thirds = np.diff(moments, axis=0) / self._h[:, None]
        alpha = np.empty_like(moments)
        alpha[self._sorting] = np.diff(thirds, axis=0, prepend=0.0, append=0.0) / 6
        slope = (f[1] - f[0]) / self._h[0] - self._h[0] / 6 * moments[1]
        first = self._frame.local(self._knots[0])
        return alpha, np.stack([f[0] - first * slope, slope])

    def _in_own_coordinates(
        self, alpha: np.ndarray, beta: np.ndarray, shape: tuple[int, ...]
    ) -> tuple[np.ndarray, np.ndarray]:
        unit = powers_of_scale(self._frame.scale, np.array([-3]), "the coefficients")
        beta = self._frame.global_coefficients(beta, 1)
        return (unit * alpha).reshape((-1, *shape)), beta.reshape((2, *shape))

    def _leave_one_out(self, values: np.ndarray, progress: Progress | None) -> np.ndarray:  # noqa: ARG002
        """Residuals (K f)_i / K_ii, with the energy f^T K f of the data."""
        if len(self.points) == 2:
            self._without(0)  # which is refused
        alpha, _ = self._local_form(values)
        diagonal = np.empty(len(values))
        diagonal[self._sorting] = self._energy_diagonal()
        return 6 * alpha / diagonal[:, None]

    def _energy_diagonal(self) -> np.ndarray:
        """Diagonal (n,) of K = B^T R^-1 B in the frame, with the second divided differences B.

        R is the tridiagonal matrix of the moments. The diagonal of its inverse follows from the
        pivots of both eliminations, downwards and upwards; its neighbours from the diagonal.
        """
        diagonal, below = _moment_matrix(self._h)
        upside = np.stack([diagonal[::-1], np.append(below[-2::-1], 0.0)])
        down, up = self._factor[0] ** 2, cholesky_banded(upside, lower=True)[0, ::-1] ** 2
        inverse = 1 / (down + up - diagonal)
        inverse[[0, -1]] = 0.0  # the outer moments are zero
        ratio = -below / down
        first = ratio[:-1] * inverse[1:]
        second = ratio[:-2] * ratio[1:-1] * inverse[2:]
        left, right = np.append(0.0, 1 / self._h), np.append(1 / self._h, 0.0)
        middle = left + right
        own = middle**2 * inverse
        own[1:] += left[1:] ** 2 * inverse[:-1] - 2 * left[1:] * middle[1:] * first
        own[:-1] += right[:-1] ** 2 * inverse[1:] - 2 * right[:-1] * middle[:-1] * first
        own[1:-1] += 2 * left[1:-1] * right[1:-1] * second
        return own

    @classmethod
    def _argument_names(cls) -> list[str]:
        return []

    @classmethod
    def _made(cls, points: np.ndarray, **arguments: Any) -> Reconstruction:
        return cls(points[:, 0], **arguments)

    def _queries(self, x: ArrayLike) -> np.ndarray:
        return super()._queries(np.asarray(valid.unmasked(x, "x"))[..., None])

    def _prepare(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Data and moments (n, v) in the order of the knots."""
        f = values[self._sorting]
        bends = np.diff(np.diff(f, axis=0) / self._h[:, None], axis=0)
        return f, self._solve(np.pad(bends, ((1, 1), (0, 0))))

    def _solve(self, right: np.ndarray) -> np.ndarray:
        return cho_solve_banded((self._factor, True), right, check_finite=False)

    def _value_rows(self, x: np.ndarray, prepared: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        of_values, of_moments = self._value_matrices(x)
        return of_values @ prepared[0] + of_moments @ prepared[1]

    def _gradient_rows(self, x: np.ndarray, prepared: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        of_values, of_moments = self._slope_matrices(x)
        return (of_values @ prepared[0] + of_moments @ prepared[1])[..., None]

    def _hessian_rows(self, x: np.ndarray, prepared: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        """Between two sites (1 - u) M_i + u M_(i+1); zero beyond the outer ones, where M = 0."""
        i, _, u = self._intervals(x)
        v = np.clip(u, 0.0, 1.0)
        bend = self._two_columns(i, 1 - v, v) @ prepared[1]
        return (bend / self._frame.scale / self._frame.scale)[..., None, None]

    def _weight_rows(self, x: np.ndarray) -> np.ndarray:
        return self._rows_of(*self._value_matrices(x))

    def _gradient_weight_rows(self, x: np.ndarray) -> tuple[np.ndarray, ...]:
        return (self._rows_of(*self._slope_matrices(x)),)

    def _rows_of(self, of_values: sparse.csr_array, of_moments: sparse.csr_array) -> np.ndarray:
        """Weights (m, n) of the data, from those of data and moments."""
        weights = sparse.hstack([of_values, of_moments]).toarray()
        return self._of_moments(weights.T).T

    def _moments(self, x: np.ndarray, f: np.ndarray) -> tuple[slice, np.ndarray]:
        return slice(None), np.concatenate([h.T @ f for h in self._value_matrices(x)])

    def _number_of_moments(self) -> int:
        return 2 * len(self.points)

    def _of_moments(self, moments: np.ndarray) -> np.ndarray:
        """A^T f + B^T R^-1 C^T f, from A^T f and C^T f, with the moments R^-1 B of the data."""
        of_values, of_moments = np.split(moments, 2)
        bends = self._solve(of_moments)[1:-1]
        total = of_values + _difference_transposed(_difference_transposed(bends) / self._h[:, None])
        result = np.empty_like(total)
        result[self._sorting] = total
        return result

    def _chunk_rows(self, columns: int) -> int:
        return rows_of(8 * (24 + 3 * columns))

    def _value_matrices(self, x: np.ndarray) -> tuple[sparse.csr_array, sparse.csr_array]:
        """Matrices (m, n) of data and moments: s(x) is the sum of their products with f and M."""
        i, h, u = self._intervals(x)
        # beyond the outer sites the cubics continue as their tangents
        v = np.clip(u, 0.0, 1.0)
        a, b = _cubics(v)
        da, db = _slopes_of_cubics(v)
        bent = h * h / 6
        return (
            self._two_columns(i, 1 - u, u),
            self._two_columns(i, bent * (a + (u - v) * da), bent * (b + (u - v) * db)),
        )

    def _slope_matrices(self, x: np.ndarray) -> tuple[sparse.csr_array, sparse.csr_array]:
        i, h, u = self._intervals(x)
        da, db = _slopes_of_cubics(np.clip(u, 0.0, 1.0))
        rise = 1 / (h * self._frame.scale)
        bent = h / (6 * self._frame.scale)
        return self._two_columns(i, -rise, rise), self._two_columns(i, bent * da, bent * db)

    def _intervals(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Left site, length in the frame, and position u in the interval, in [0, 1] if inside."""
        last = len(self._h) - 1
        i = np.clip(np.searchsorted(self._knots, x[:, 0], side="right") - 1, 0, last)
        h = self._h[i]
        return i, h, (x[:, 0] / self._frame.scale - self._knots[i] / self._frame.scale) / h

    def _two_columns(self, i: np.ndarray, left: np.ndarray, right: np.ndarray) -> sparse.csr_array:
        """Matrix (m, n) with two entries in each row, in the columns i and i + 1."""
        m = len(i)
        entries = np.stack([left, right], axis=1).ravel()
        columns = np.stack([i, i + 1], axis=1).ravel()
        ends = np.arange(0, 2 * m + 1, 2)
        return sparse.csr_array((entries, columns, ends), shape=(m, len(self.points)))


class NaturalSpline(Field):
    """A natural cubic spline with its data; made by `NaturalCubicSpline.field`."""

    def gradient(self, x: ArrayLike, **options: object) -> np.ndarray:
        """Derivative s'(x), of the shape of x before that of a datum; options as for values."""
        return super().gradient(x, **options)[..., 0][()]  # type: ignore[arg-type]

    def hessian(self, x: ArrayLike, **options: object) -> np.ndarray:
        """Second derivative s''(x), of the same shape as the derivative."""
        return super().hessian(x, **options)[..., 0, 0][()]  # type: ignore[arg-type]


def _moment_matrix(h: np.ndarray) -> np.ndarray:
    """Diagonal and subdiagonal (2, n): s' is continuous, and the outer moments are zero."""
    diagonal = np.concatenate([[1.0], (h[:-1] + h[1:]) / 3, [1.0]])
    below = np.zeros(len(h) + 1)
    below[1:-2] = h[1:-1] / 6
    return np.stack([diagonal, below])


def _cubics(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return -u * (1 - u) * (2 - u), -u * (1 - u) * (1 + u)


def _slopes_of_cubics(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return 1 - 3 * (1 - u) ** 2, 3 * u * u - 1


def _difference_transposed(g: np.ndarray) -> np.ndarray:
    """Transpose of `numpy.diff` along the first axis."""
    return -np.diff(g, axis=0, prepend=0.0, append=0.0)
