"""A reconstructed field: data on a method, called at points."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon import _validation as valid
from fieldrecon._chunks import Progress, chunked

if TYPE_CHECKING:
    from fieldrecon.reconstruction import Reconstruction


class Field:
    """A reconstructed field: call it at points, or ask for its gradient.

    Made by `Reconstruction.field`. Many queries are evaluated in chunks, so that the memory beside
    inputs and outputs stays bounded.

    Parameters
    ----------
    method : Reconstruction
        The method with its sites.
    values : (n, ...) ndarray
        The data.
    prepare : callable, optional
        Takes the data (n, v) and returns what evaluation needs of them; the method's own routine
        by default.

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
        self._prepared = valid.without_warnings(
            prepare or method._prepare, self.values.reshape(len(values), -1)
        )

    def __call__(
        self, x: ArrayLike, *, executor: Executor | None = None, progress: Progress | None = None
    ) -> np.ndarray:
        """Values of the field.

        Parameters
        ----------
        x : (..., d) array_like
            Queries.
        executor : concurrent.futures.Executor, optional
            Where the chunks run; this machine's threads by default.
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
            If the sites about a query do not determine the value (local methods).
        OverflowError
            If a value exceeds the range of floating-point numbers.
        """
        return self._evaluate(self.method._value_rows, x, (), executor, progress)

    def gradient(
        self, x: ArrayLike, *, executor: Executor | None = None, progress: Progress | None = None
    ) -> np.ndarray:
        """Exact gradient of the field as it is.

        Parameters
        ----------
        x : (..., d) array_like
            Queries.
        executor : concurrent.futures.Executor, optional
            Where the chunks run; this machine's threads by default.
        progress : callable, optional
            Called as progress(done, total) with numbers of queries.

        Returns
        -------
        (..., *v, d) ndarray
            The derivative by each variable, last.

        Raises
        ------
        ValueError
            As for the values, and where the field has no gradient (-r or exp(-r) at a site).
        numpy.linalg.LinAlgError
            If the sites about a query do not determine the value (local methods).
        OverflowError
            If a derivative exceeds the range of floating-point numbers.
        """
        d = (self.method.points.shape[1],)
        return self._evaluate(self.method._gradient_rows, x, d, executor, progress)

    def _evaluate(
        self,
        rows_of_result: Callable[[np.ndarray, Any], np.ndarray],
        x: ArrayLike,
        tail: tuple[int, ...],
        executor: Executor | None,
        progress: Progress | None,
    ) -> np.ndarray:
        x = self.method._queries(x)
        queries = x.reshape(-1, x.shape[-1])
        order = self.method._order(queries)
        queries = queries if order is None else queries[order]
        columns = int(np.prod(self._shape, dtype=int))
        result = np.empty((len(queries), columns, *tail), dtype=self._dtype)
        work = partial(_evaluated, rows_of_result, self._prepared)
        rows = self.method._chunk_rows(columns)
        for part, values in chunked(work, queries, rows, executor, progress):
            where = part if order is None else order[part]
            result[where] = valid.finite_rows(values, queries[part])
        return result.reshape((*x.shape[:-1], *self._shape, *tail))[()]


def _evaluated(
    rows_of_result: Callable[[np.ndarray, Any], np.ndarray], prepared: Any, x: np.ndarray
) -> np.ndarray:
    return valid.without_warnings(rows_of_result, x, prepared)
