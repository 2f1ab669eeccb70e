"""Fields: a method with data, called at points."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, chunked
from fieldrecon._numerics.data_units import in_units_of_data
from fieldrecon._numerics.far_queries import CONSTANTS, error_of_increase, refuse_lost_constants

if TYPE_CHECKING:
    from fieldrecon.reconstruction import Reconstruction


class Field:
    """A reconstructed field: callable at points, with first and second derivatives.

    Made by `Reconstruction.field`. Many queries are evaluated in chunks, so that the memory beyond
    inputs and outputs stays bounded.

    Parameters
    ----------
    method : Reconstruction
        The method with its sites.
    values : (n, ...) ndarray
        The data.
    prepare : callable, optional
        Takes the data (n, v) to the coefficients for evaluation; the method's own routine by
        default.

    Attributes
    ----------
    method : Reconstruction
        The method with its sites.
    values : (n, ...) ndarray
        The data; they do not change when the caller's array does.

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    >>> s = fr.RBF(points, fr.thin_plate_spline()).field([1.0, 3.0, 4.0])  # 1 + 2x + 3y
    >>> s([[0.5, 0.5], [2.0, 0.0]]).round(12)
    array([3.5, 5. ])
    >>> s.gradient([0.25, 0.25]).round(12)
    array([2., 3.])
    """

    def __init__(
        self,
        method: Reconstruction,
        values: np.ndarray,
        prepare: Callable[[np.ndarray], Any] | None = None,
    ) -> None:
        self.method = method
        self.values = values.copy()
        self.values.flags.writeable = False
        self._shape = values.shape[1:]
        self._dtype = values.dtype
        columns, self._units = in_units_of_data(self.values.reshape(len(values), -1))
        self._prepared = valid.quiet_evaluate(prepare or method._prepare, columns)

    def __call__(
        self, x: ArrayLike, *, executor: Executor | None = None, progress: Progress | None = None
    ) -> np.ndarray:
        """Values of the field.

        Parameters
        ----------
        x : (..., d) array_like
            Queries.
        executor : concurrent.futures.Executor, optional
            Runs the chunks; this machine's threads by default.
        progress : callable, optional
            Called as progress(done, total) with numbers of queries.

        Returns
        -------
        (..., *v) ndarray
            A value of the data's shape for each query.

        Raises
        ------
        ValueError
            If x is not finite or has the wrong number of coordinates.
        numpy.linalg.LinAlgError
            If the sites about a query do not determine the value (local methods), or if rounding
            decides it: if the method reproduces constants, and one of the data's size, added to
            them, is reproduced with an error of more than 1e-4. That is so far outside the sites,
            and everywhere if the kernel is too flat for the data.
        OverflowError
            If a value exceeds the range of floating-point numbers.
        """
        return self._evaluate(self.method._value_rows, x, (), executor, progress)

    def gradient(
        self, x: ArrayLike, *, executor: Executor | None = None, progress: Progress | None = None
    ) -> np.ndarray:
        """Exact gradient of the field.

        Parameters
        ----------
        x : (..., d) array_like
            Queries.
        executor : concurrent.futures.Executor, optional
            Runs the chunks; this machine's threads by default.
        progress : callable, optional
            Called as progress(done, total) with numbers of queries.

        Returns
        -------
        (..., *v, d) ndarray
            The derivatives by each variable on the last axis.

        Raises
        ------
        ValueError
            As for the values, and where the field has no gradient (-r or exp(-r) at a site).
        numpy.linalg.LinAlgError
            As for the values.
        OverflowError
            If a derivative exceeds the range of floating-point numbers.
        """
        d = (self.method.points.shape[1],)
        return self._evaluate(self.method._gradient_rows, x, d, executor, progress)

    def hessian(
        self, x: ArrayLike, *, executor: Executor | None = None, progress: Progress | None = None
    ) -> np.ndarray:
        """Exact second derivatives of the field, where it has them.

        Parameters
        ----------
        x : (..., d) array_like
            Queries.
        executor : concurrent.futures.Executor, optional
            Runs the chunks; this machine's threads by default.
        progress : callable, optional
            Called as progress(done, total) with numbers of queries.

        Returns
        -------
        (..., *v, d, d) ndarray
            The symmetric matrix of second derivatives on the last two axes.

        Raises
        ------
        ValueError
            As for the values, and where the field has no second derivatives (r^2 log r^2 at a
            site).
        numpy.linalg.LinAlgError
            As for the values.
        OverflowError
            If a derivative exceeds the range of floating-point numbers.
        """
        d = self.method.points.shape[1]
        return self._evaluate(self.method._hessian_rows, x, (d, d), executor, progress, memory=d)

    def laplacian(
        self, x: ArrayLike, *, executor: Executor | None = None, progress: Progress | None = None
    ) -> np.ndarray:
        """Laplacian of the field, the sum of its second derivatives by each variable.

        Parameters
        ----------
        x : (..., d) array_like
            Queries.
        executor : concurrent.futures.Executor, optional
            Runs the chunks; this machine's threads by default.
        progress : callable, optional
            Called as progress(done, total) with numbers of queries.

        Returns
        -------
        (..., *v) ndarray
            The trace of the Hessian.

        Raises
        ------
        ValueError, numpy.linalg.LinAlgError, OverflowError
            As for `hessian`.
        """
        d = self.method.points.shape[1]
        return self._evaluate(self.method._laplacian_rows, x, (), executor, progress, memory=d)

    def _evaluate(
        self,
        rows_of_result: Callable[[np.ndarray, Any], np.ndarray],
        x: ArrayLike,
        tail: tuple[int, ...],
        executor: Executor | None,
        progress: Progress | None,
        memory: int = 1,
    ) -> np.ndarray:
        """Evaluate in chunks; a query takes `memory` times as much memory as for a gradient."""
        x = self.method._queries(x)
        queries = x.reshape(-1, x.shape[-1])
        order = self.method._order(queries)
        columns = int(np.prod(self._shape, dtype=int))
        result = np.empty((len(queries), columns, *tail), dtype=self._dtype)
        units = self._units.reshape(-1, *(1 for _ in tail))
        work = partial(evaluated, rows_of_result, self._prepared, units)
        rows = max(1, self.method._chunk_rows(columns) // memory)
        for part, values in chunked(work, queries, rows, executor, progress, order):
            where = part if order is None else order[part]
            result[where] = valid.check_finite(values, queries[where])
        self._refuse_lost_constants(queries, executor)
        return result.reshape((*x.shape[:-1], *self._shape, *tail))[()]

    def _refuse_lost_constants(self, x: np.ndarray, executor: Executor | None) -> None:
        """Refuse queries (m, d) at which a constant added to the data is lost."""
        far = self.method._far_among(x)
        if len(far):
            for part, error in self._errors_of_constants(far, executor):
                refuse_lost_constants(far[part], error, self._error_at_sites)

    def _errors_of_constants(
        self, x: np.ndarray, executor: Executor | None
    ) -> Iterator[tuple[slice, np.ndarray]]:
        """Parts of the queries (m, d), and the relative errors of constants added to the data."""
        work = partial(_error_of_increase, self.method, self._prepared, *self._raised)
        return chunked(work, x, self.method._chunk_rows(self._raised[1].size), executor)

    @cached_property
    def _error_at_sites(self) -> float:
        """Largest error of a constant at the sites, zero if only distance can be its cause."""
        if not self.method._is_lossy:
            return 0.0
        parts = self._errors_of_constants(self.method.points, None)
        return max(float(error.max(initial=0.0)) for _, error in parts)

    @cached_property
    def _raised(self) -> tuple[Any, np.ndarray]:
        """Coefficients for the data plus constants (k, v) of their size, and the constants."""
        columns, _ = in_units_of_data(self.values.reshape(len(self.values), -1))
        size = np.abs(columns).max(axis=0)
        constants = CONSTANTS[:, None] * np.where(size > 0, size, 1.0)
        more = columns[:, None] + self.method._data_of_one()[:, None, None] * constants
        flat = more.reshape(len(more), constants.size)
        return valid.quiet_evaluate(self.method._prepare, flat), constants


def evaluated(
    rows_of_result: Callable[[Any, Any], np.ndarray], prepared: Any, units: np.ndarray, x: Any
) -> np.ndarray:
    """Rows of a field at queries, whose coefficients are those of the data in these units."""
    rows = valid.quiet_evaluate(rows_of_result, x, prepared)
    return valid.quiet_evaluate(np.multiply, rows, units)


def _error_of_increase(
    method: Reconstruction, prepared: Any, raised: Any, constants: np.ndarray, x: np.ndarray
) -> np.ndarray:
    value, more = (valid.quiet_evaluate(method._value_rows, x, p) for p in (prepared, raised))
    return valid.quiet_evaluate(error_of_increase, value, more, constants)
