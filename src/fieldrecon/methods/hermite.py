"""Hermite interpolation by radial basis functions: values, derivatives and Laplacians as data."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, chunked, report_all, rows_of, split_progress
from fieldrecon._core.duplicates import coincidence_labels
from fieldrecon._numerics.jets import symmetric
from fieldrecon._numerics.saddle_point import SaddlePoint
from fieldrecon.fields import Field, evaluated
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.derivatives import smoothness
from fieldrecon.methods.functionals import (
    Functionals,
    derivatives_at,
    laplacians_at,
    together,
    values_at,
)
from fieldrecon.methods.least_squares import ACCURATE
from fieldrecon.methods.solvability import (
    INTERPOLATED,
    as_augmentation,
    as_finite,
    as_kernel,
    miss_of_rough_data,
    refuse_a_miss,
    refuse_beyond_memory,
    refuse_lost_weights,
    within_range,
)
from fieldrecon.polynomials import Frame, dimension, monomial_hessians, require_unisolvent
from fieldrecon.reconstruction import Reconstruction


class HermiteRBF(Reconstruction):
    """Generalized interpolation, f(x) = b(x)^T c + sum_j lambda_j M_j phi(|x - .|).

    M_j is the j-th functional of the data, applied to the second argument of the kernel. The
    conditions M_i f = f_i, with sum_j lambda_j M_j p = 0 for the polynomials p, give a symmetric
    system like that of `RBF`, regular if the functionals are independent and determine the
    polynomial. Of all functions with these data the field has the least energy of the kernel. With
    Laplacians inside and values on the boundary it solves Poisson's equation by collocation.

    Parameters
    ----------
    functionals : Functionals or sequence of them
        From `values_at`, `derivatives_at` and `laplacians_at`. The data follow this order.
    kernel : Radial
        With twice as many continuous derivatives as the functionals have.
    degree : int, optional
        Degree of the polynomial; `kernel.order - 1` by default, and no less. -1 for none.
    executor : concurrent.futures.Executor, optional
        Computes the entries of the system in chunks; this machine's threads by default.
    progress : callable, optional
        Called as progress(done, total) with numbers of functionals; the factorization is the second
        half.

    Attributes
    ----------
    functionals : Functionals
        All functionals; `points` are their points.
    interpolates : bool
        False where the kernel is so flat that rounding makes the fields of some data miss them by
        more than 1e-6 of their size.

    Raises
    ------
    ValueError
        If the kernel is not smooth enough, or functionals at one point depend on each other.
    numpy.linalg.LinAlgError
        If the data do not determine the polynomial, or the kernel is too flat for them. Weights
        are refused if the field of independent random signs would miss them.

    Notes
    -----
    There is no metric: in its distances a Laplacian is another operator of second order, which
    `Functionals` do not hold. For values and derivatives along b, map points and directions, x to
    L x and b to L b with M = L^T L.

    References
    ----------
    Wendland (2005), section 1.3 and chapter 16; Wu (1992); Fasshauer (1997).

    Examples
    --------
    >>> from fieldrecon.kernels import polyharmonic
    >>> method = HermiteRBF(
    ...     [values_at([[0, 0]]), derivatives_at([[0, 0], [1, 0]], [[1, 0], [0, 1]])],
    ...     polyharmonic(3),
    ... )
    >>> s = method.field([1.0, 2.0, 3.0])  # f(0, 0), df/dx(0, 0), df/dy(1, 0)
    >>> s([1.0, 1.0]).round(12), s.gradient([5.0, 5.0]).round(12)
    (np.float64(6.0), array([2., 3.]))
    """

    def __init__(
        self,
        functionals: Functionals | Sequence[Functionals],
        kernel: Radial,
        degree: int | None = None,
        *,
        executor: Executor | None = None,
        progress: Progress | None = None,
    ) -> None:
        self.functionals = together(functionals)
        self.points = valid.as_points(self.functionals.points)
        self.kernel = as_kernel(kernel, self.points.shape[1])
        self.degree = as_augmentation(degree, kernel)
        _refuse_a_rough_kernel(kernel, self.functionals.order)
        self._frame = Frame.around(self.points)
        self._local, self._size = self.functionals.in_frame(self._frame)
        _refuse_dependent(self._local)
        p = self._local.of_monomials(self.degree)
        require_unisolvent(self.points, p, self.degree, "the data do")
        refuse_beyond_memory(
            len(self.points), remedy="MovingLeastSquares with neighbors is local, for values alone"
        )
        self._unit_kernel = as_finite(kernel.in_units(self._frame.scale))
        a = np.empty((len(p), len(p)), order="F")
        every, entries = np.arange(len(p)), next(split_progress(progress, len(p), 2))
        for part, rows in chunked(self._rows, every, self._chunk_rows(0), executor, entries):
            a[part] = rows
        self._largest = abs(within_range(a, f"derivatives of {kernel!r}")).max()
        self._system = valid.quiet_evaluate(SaddlePoint, a, p)
        self._rough_miss = miss_of_rough_data(self._system, np.array(self._largest))
        self.interpolates = self._rough_miss <= INTERPOLATED
        report_all(progress, len(p))

    def field(self, values: ArrayLike) -> HermiteField:
        """Field of these data.

        Parameters
        ----------
        values : (n, ...) array_like
            One real or complex scalar, vector or array for each functional.

        Returns
        -------
        HermiteField
            Callable at any points, with a gradient and other functionals.
        """
        return HermiteField(self, valid.as_values(values, len(self.points)))

    def weights_of(self, functionals: Functionals | Sequence[Functionals]) -> np.ndarray:
        """Weights of the data in functionals of the field.

        Parameters
        ----------
        functionals : Functionals or sequence of them
            m functionals.

        Returns
        -------
        (m, n) ndarray
            The functionals of the field are these weights times the data.

        Raises
        ------
        MemoryError
            If the matrix would exceed DENSE_LIMIT_BYTES.
        ValueError
            If the field does not have the derivatives.
        """
        asked = self._as_asked(functionals)
        self._refuse_if_too_large(len(asked))
        return valid.check_finite(valid.quiet_evaluate(self._weights_of, asked), asked.points)

    def _as_asked(self, functionals: Functionals | Sequence[Functionals]) -> Functionals:
        asked = together(functionals)
        if asked.points.shape[1] != self.points.shape[1]:
            raise ValueError("functionals must be of functions of as many variables as the points")
        self._require_derivatives(asked.order)
        return asked

    def _require_derivatives(self, order: int) -> None:
        reach = smoothness(self.kernel) - self.functionals.order
        if order > reach:
            raise ValueError(
                f"a field of {self.kernel!r} and these data has {reach} continuous derivatives; "
                f"asked for order {order}"
            )

    def _leave_one_out(self, values: np.ndarray, progress: Progress | None) -> np.ndarray:  # noqa: ARG002
        """Residuals lambda_i / (H^-1)_ii, each in the unit of its datum."""
        self._refuse_indispensable()
        residuals = self._prepare(values)[0] / self._system.inverse_diagonal()[:, None]
        return residuals * self._size[:, None]

    def _refuse_indispensable(self) -> None:
        p = self._local.of_monomials(self.degree)
        leverages = (np.linalg.qr(p)[0] ** 2).sum(axis=1)
        for i in np.flatnonzero(1.0 - leverages <= ACCURATE).tolist():
            others = np.delete(np.arange(len(p)), i)
            try:
                require_unisolvent(self.points[others], p[others], self.degree, "the data do")
            except (np.linalg.LinAlgError, ValueError) as error:
                raise np.linalg.LinAlgError(
                    f"without point {i}, ({valid.format_point(self.points[i])}), the others do not "
                    f"determine the field: {error}"
                ) from None

    @classmethod
    def _argument_names(cls) -> list[str]:
        return ["kernel", "degree", "value", "gradient", "laplacian"]

    def _arguments(self) -> dict[str, Any]:
        parts = {
            name: getattr(self.functionals, name) for name in ("value", "gradient", "laplacian")
        }
        return {"kernel": self.kernel, "degree": self.degree} | parts

    @classmethod
    def _made(cls, points: np.ndarray, **arguments: Any) -> Reconstruction:
        p = valid.as_points(points)
        parts = {"value": p.shape[:1], "gradient": p.shape, "laplacian": p.shape[:1]}
        for name, shape in parts.items():
            part = valid.as_values(arguments[name], len(p), name)
            if part.shape != shape:
                raise ValueError(f"{name} must have the shape {shape}; got {part.shape}")
        functionals = Functionals(p, *(np.asarray(arguments.pop(name)) for name in parts))
        return cls(functionals, **arguments)

    def _rows(self, rows: np.ndarray) -> np.ndarray:
        """Rows (m, n) of the matrix of the kernel."""
        return self._of_kernel(self._local[rows])

    def _of_kernel(self, local: Functionals) -> np.ndarray:
        return valid.quiet_evaluate(local.of_kernel, self._local, self._unit_kernel)

    def _weights_of(self, asked: Functionals) -> np.ndarray:
        refuse_lost_weights(self._rough_miss)
        local, size = asked.in_frame(self._frame)
        right = self._of_kernel(local).T
        weights = self._system.solve(right, local.of_monomials(self.degree).T)[0].T
        return weights * size[:, None] / self._size

    def _weight_rows(self, x: np.ndarray) -> np.ndarray:
        return self._weights_of(values_at(x))

    def _gradient_weight_rows(self, x: np.ndarray) -> tuple[np.ndarray, ...]:
        self._require_derivatives(1)
        return tuple(self._weights_of(derivatives_at(x, axis)) for axis in np.eye(x.shape[1]))

    def _weight_chunk_rows(self) -> int:
        return max(super()._weight_chunk_rows(), self._system.least_columns())

    def _data_of_one(self) -> np.ndarray:
        return self.functionals.value

    def _prepare(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        values = values / self._size[:, None]
        lam, c = self._system.solve(values)
        refuse_a_miss(lam, np.array(self._largest), values)
        return lam, c

    def _applied(self, asked: Functionals, prepared: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        lam, c = prepared
        local, size = asked.in_frame(self._frame)
        result = self._of_kernel(local) @ lam + local.of_monomials(self.degree) @ c
        return size[:, None] * result

    def _value_rows(self, x: np.ndarray, prepared: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        return self._applied(values_at(x), prepared)

    def _gradient_rows(self, x: np.ndarray, prepared: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        self._require_derivatives(1)
        axes = np.eye(x.shape[1])
        columns = [self._applied(derivatives_at(x, axis), prepared) for axis in axes]
        return np.stack(columns, axis=-1)

    def _hessian_rows(self, x: np.ndarray, prepared: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        self._require_derivatives(2)
        lam, c = prepared
        local = self._frame.local(x)
        entries = self._local.kernel_hessians(local, self._unit_kernel)
        total = symmetric([entry @ lam for entry in entries], x.shape[1])
        total += np.einsum("mqkl,qv->mvkl", monomial_hessians(local, self.degree), c)
        return total / self._frame.scale / self._frame.scale

    def _laplacian_rows(self, x: np.ndarray, prepared: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        self._require_derivatives(2)
        return self._applied(laplacians_at(x), prepared)

    def _moments(self, x: np.ndarray, f: np.ndarray) -> tuple[slice, np.ndarray]:
        local, _ = values_at(x).in_frame(self._frame)
        bases = self._of_kernel(local), local.of_monomials(self.degree)
        return slice(None), np.concatenate([basis.T @ f for basis in bases])

    def _number_of_moments(self) -> int:
        return len(self.points) + dimension(self.points.shape[1], self.degree)

    def _of_moments(self, moments: np.ndarray) -> np.ndarray:
        refuse_lost_weights(self._rough_miss)
        solution, _ = self._system.solve(*np.split(moments, [len(self.points)]))
        return solution / self._size[:, None]

    def _chunk_rows(self, columns: int) -> int:
        return rows_of(8 * (12 * len(self.points) + columns * self.points.shape[1]))


class HermiteField(Field):
    """A field of Hermite data; made by `HermiteRBF.field`."""

    method: HermiteRBF

    def apply(self, functionals: Functionals | Sequence[Functionals]) -> np.ndarray:
        """Functionals of the field, for instance its Laplacians or normal components.

        Parameters
        ----------
        functionals : Functionals or sequence of them
            m functionals, of no higher order than the field has derivatives.

        Returns
        -------
        (m, *v) ndarray
            One value for each functional.

        Raises
        ------
        ValueError
            If the field does not have the derivatives.
        """
        asked = self.method._as_asked(functionals)
        result = np.empty((len(asked), *self._shape), dtype=self._dtype)
        rows = self.method._chunk_rows(int(np.prod(self._shape, dtype=int)))
        for start in range(0, len(asked), rows):
            part = asked[start : start + rows]
            values = evaluated(self.method._applied, self._prepared, self._units, part)
            values = valid.check_finite(values, part.points)
            result[start : start + rows] = values.reshape((len(part), *self._shape))
        self._refuse_lost_constants(asked.points, None)
        return result


def _refuse_a_rough_kernel(kernel: Radial, order: int) -> None:
    if smoothness(kernel) < 2 * order:
        raise ValueError(
            f"{kernel!r} has {smoothness(kernel)} continuous derivatives; data of order {order} "
            f"need {2 * order}"
        )


def _refuse_dependent(local: Functionals) -> None:
    """Refuse linearly dependent functionals at one point."""
    rows = np.column_stack([local.value, local.gradient, local.laplacian])
    group = coincidence_labels(local.points)
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    for members in np.split(order, starts[1:]):
        if len(members) > 1 and np.linalg.matrix_rank(rows[members]) < len(members):
            which = ", ".join(str(i) for i in members[:5])
            raise ValueError(
                f"functionals must be independent; those at one point are not: {which}"
            )
