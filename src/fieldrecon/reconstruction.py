"""Reconstructions that are linear in the data, s(x) = sum_i w_i(x) f_i.

A method is determined by its weights w_i(x), which depend on the sites only.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from concurrent.futures import Executor
from functools import cached_property, partial
from inspect import signature
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, chunked, rows_of
from fieldrecon._numerics.far_queries import (
    are_far,
    error_of_weights,
    near_box,
    refuse_lost_constants,
)
from fieldrecon.fields import Field

DENSE_LIMIT_BYTES = 2**31
"""Largest dense weight matrix that is formed, in bytes."""

__all__ = ["Reconstruction", "Weights", "weights_if_they_fit"]

Weights: TypeAlias = np.ndarray | sparse.csr_array


class Reconstruction(ABC):
    """A method on fixed sites that is linear in the data.

    Construct it from the sites, fit data with `field`, and call the field at points.

    Attributes
    ----------
    points : (n, d) ndarray
        The sites.
    degree : int
        Highest total degree of polynomials that are reproduced exactly; -1 for none.
    interpolates : bool
        Whether the field takes the data at the sites.
    """

    points: np.ndarray
    degree: int
    interpolates: bool
    _each_site: ClassVar[tuple[str, ...]] = ()
    """Names of the arguments that may be arrays with an entry for each site."""

    def field(self, values: ArrayLike) -> Field:
        """Field of these data.

        Parameters
        ----------
        values : (n, ...) array_like
            One real or complex scalar, vector or array for each site.

        Returns
        -------
        Field
            Callable at any points, with a gradient.

        Raises
        ------
        ValueError
            If there is not one finite value for each site.
        """
        return Field(self, valid.as_values(values, len(self.points)))

    def weights(
        self, x: ArrayLike, *, executor: Executor | None = None, progress: Progress | None = None
    ) -> Weights:
        """Weights w_i(x) of the data in the value at x.

        Parameters
        ----------
        x : (..., d) array_like
            Queries; m of them in all.
        executor : concurrent.futures.Executor, optional
            Runs the chunks; this machine's threads by default.
        progress : callable, optional
            Called as progress(done, total) with numbers of queries.

        Returns
        -------
        (m, n) ndarray or scipy.sparse.csr_array
            H with s(x) = H f; sparse for local methods.

        Raises
        ------
        MemoryError
            If a dense H would exceed DENSE_LIMIT_BYTES.
        OverflowError
            If a weight exceeds the range of floating-point numbers.
        numpy.linalg.LinAlgError
            If a query is so far outside that rounding decides the weights: if they reproduce
            constants, and rounding makes an error of more than 1e-4 in their sum, which is one.
        """
        return self._in_chunks(self._weight_rows, 1, x, executor, progress)[0]

    def gradient_weights(
        self, x: ArrayLike, *, executor: Executor | None = None, progress: Progress | None = None
    ) -> tuple[Weights, ...]:
        """Weights of the data in each component of the gradient at x.

        Parameters
        ----------
        x : (..., d) array_like
            Queries; m of them in all.
        executor : concurrent.futures.Executor, optional
            Runs the chunks; this machine's threads by default.
        progress : callable, optional
            Called as progress(done, total) with numbers of queries.

        Returns
        -------
        tuple of d matrices (m, n)
            The gradient is (G_1 f, ..., G_d f); sparse for local methods.

        Raises
        ------
        MemoryError
            If the dense matrices would exceed DENSE_LIMIT_BYTES.
        numpy.linalg.LinAlgError
            As for `weights`.
        """
        d = self.points.shape[1]
        return self._in_chunks(self._gradient_weight_rows, d, x, executor, progress)

    def adjoint(
        self,
        x: ArrayLike,
        f: ArrayLike,
        *,
        executor: Executor | None = None,
        progress: Progress | None = None,
    ) -> np.ndarray:
        """Adjoint H^T f of `weights`, without forming H where that can be avoided.

        Parameters
        ----------
        x : (..., d) array_like
            Queries; m of them in all.
        f : (m, ...) array_like
            One value for each query, for instance a load.
        executor : concurrent.futures.Executor, optional
            Runs the chunks; this machine's threads by default.
        progress : callable, optional
            Called as progress(done, total) with numbers of queries.

        Returns
        -------
        (n, ...) ndarray
            One value for each site.

        Raises
        ------
        ValueError
            If there is not one finite value for each query.
        numpy.linalg.LinAlgError
            As for `weights`.
        """
        queries = self._queries(x).reshape(-1, self.points.shape[1])
        f = valid.as_values(f, len(queries), name="f", of="query")
        columns = f.reshape(len(f), math.prod(f.shape[1:]))  # also for no queries
        result = valid.quiet_evaluate(self._adjoint, queries, columns, executor, progress)
        self._refuse_lost_weights(queries, executor)
        return valid.check_finite(result, self.points).reshape((len(self.points), *f.shape[1:]))

    def _queries(self, x: ArrayLike) -> np.ndarray:
        """Queries (..., d)."""
        return valid.as_queries(x, self.points.shape[1])

    def _in_chunks(
        self,
        rows_of_weights: Callable[[np.ndarray], Weights | tuple[Weights, ...]],
        matrices: int,
        x: ArrayLike,
        executor: Executor | None,
        progress: Progress | None,
    ) -> tuple[Weights, ...]:
        """Matrices (m, n) of weights, in chunks of queries that lie together."""
        queries = self._queries(x).reshape(-1, self.points.shape[1])
        result = self._stacked(rows_of_weights, matrices, queries, executor, progress)
        self._refuse_lost_weights(queries, executor)
        return result

    def _stacked(
        self,
        rows_of_weights: Callable[[np.ndarray], Weights | tuple[Weights, ...]],
        matrices: int,
        queries: np.ndarray,
        executor: Executor | None,
        progress: Progress | None,
    ) -> tuple[Weights, ...]:
        """The matrices of queries (m, d), from their chunks."""
        order = self._order(queries)
        work, shape = partial(_checked, rows_of_weights), (len(queries), len(self.points))
        if not self._has_sparse_weights:
            self._refuse_if_too_large(len(queries), matrices)
        parts = chunked(work, queries, self._weight_chunk_rows(), executor, progress, order)
        if self._has_sparse_weights:
            chunks = [rows for _, rows in parts] or [(sparse.csr_array(shape),) * matrices]
            stacked = (sparse.vstack(rows, "csr") for rows in zip(*chunks, strict=True))
            return tuple(h if order is None else h[np.argsort(order)] for h in stacked)
        result: list[np.ndarray] = []
        for part, rows in parts:
            result = result or [np.empty_like(some, shape=shape) for some in rows]
            for whole, some in zip(result, rows, strict=True):
                whole[part if order is None else order[part]] = some
        return tuple(result) or (np.empty(shape),) * matrices

    def _refuse_lost_weights(self, x: np.ndarray, executor: Executor | None) -> None:
        """Refuse queries (m, d) so far outside that rounding decides the weights."""
        far = self._far_among(x)
        work = partial(valid.quiet_evaluate, self._error_of_weights)
        for part, error in chunked(work, far, self._weight_chunk_rows(), executor):
            refuse_lost_constants(far[part], error)

    def _error_of_weights(self, x: np.ndarray) -> np.ndarray:
        """Error (m, 1) of the sums of the weights at queries (m, d)."""
        h, one = self._weight_rows(x), self._data_of_one()
        return error_of_weights(h @ one, abs(h) @ np.abs(one))[:, None]

    def _far_among(self, x: np.ndarray) -> np.ndarray:
        """Those of the queries (m, d) where rounding may decide, if constants are reproduced.

        They are far from the sites, or all of them if the sites themselves are far apart.
        """
        if self.degree < 0 or not len(x):
            return x[:0]
        if self._is_lossy:
            return x
        return x[valid.quiet_evaluate(are_far, self._near_box, x)]

    @property
    def _is_lossy(self) -> bool:
        """Whether rounding may decide values between the sites: that of a global method may."""
        return False

    @cached_property
    def _near_box(self) -> tuple[np.ndarray, np.ndarray]:
        return valid.quiet_evaluate(near_box, self.points)

    def _refuse_if_too_large(self, m: int, matrices: int = 1) -> None:
        size = 8 * m * len(self.points) * matrices
        if size > DENSE_LIMIT_BYTES:
            raise MemoryError(
                f"dense weights of {m} queries for {len(self.points)} sites would take "
                f"{size / 2**30:.1f} GiB; use field(values) or adjoint(x, f), which do not form "
                "them, or a local method, whose weights are sparse"
            )

    # The two abstract methods define a method, and `_has_sparse_weights` says what they return. The
    # others have defaults, which a method overrides where it has a faster route.

    @property
    def _has_sparse_weights(self) -> bool:
        """Whether the matrices of weights are sparse, so that any number of queries is allowed."""
        return False

    @abstractmethod
    def _weight_rows(self, x: np.ndarray) -> Weights:
        """Weights (m, n) at the queries (m, d)."""

    @abstractmethod
    def _gradient_weight_rows(self, x: np.ndarray) -> tuple[Weights, ...]:
        """Gradient weights at the queries, d matrices (m, n)."""

    def _data_of_one(self) -> np.ndarray:
        """Data (n,) of the constant 1: its values at the sites."""
        return np.ones(len(self.points))

    def _prepare(self, values: np.ndarray) -> Any:
        """Coefficients for the data (n, v), from which values follow; by default the data."""
        return values

    def _value_rows(self, x: np.ndarray, prepared: Any) -> np.ndarray:
        """Values (m, v)."""
        return self._weight_rows(x) @ prepared

    def _gradient_rows(self, x: np.ndarray, prepared: Any) -> np.ndarray:
        """Gradients (m, v, d)."""
        return np.stack([g @ prepared for g in self._gradient_weight_rows(x)], axis=-1)

    def _hessian_rows(self, x: np.ndarray, prepared: Any) -> np.ndarray:
        """Second derivatives (m, v, d, d)."""
        raise NotImplementedError(
            f"{type(self).__name__} does not compute second derivatives of its fields"
        )

    def _laplacian_rows(self, x: np.ndarray, prepared: Any) -> np.ndarray:
        """Sums (m, v) of the second derivatives by each variable."""
        return np.trace(self._hessian_rows(x, prepared), axis1=2, axis2=3)

    def _order(self, x: np.ndarray) -> np.ndarray | None:  # noqa: ARG002 - for subclasses
        """Order in which neighbouring queries (m, d) are evaluated together; None for their own."""
        return None

    def _chunk_rows(self, columns: int) -> int:
        """Number of queries of one chunk, for data with this number of columns."""
        return rows_of(8 * (columns + len(self.points)) * (self.points.shape[1] + 1))

    def _weight_chunk_rows(self) -> int:
        """Number of queries of one chunk of weights, which are the values of n unit data."""
        return self._chunk_rows(len(self.points))

    def _leave_one_out(self, values: np.ndarray, progress: Progress | None) -> np.ndarray:
        """Residuals (n, v) of the data (n, v), each against the field of the others: n refits."""
        result = np.empty_like(values)
        for i in range(len(values)):
            result[i] = self._residual_without(i, values)
            if progress is not None:
                progress(i + 1, len(values))
        return result

    def _residual_without(self, i: int, values: np.ndarray) -> np.ndarray:
        """Datum i (v,) less the value there of the field of all others."""
        others = self._without(i)
        prepared = others._prepare(np.delete(values, i, axis=0))
        return values[i] - others._value_rows(self.points[i : i + 1], prepared)[0]

    def _without(self, i: int) -> Reconstruction:
        """The same method on the other sites."""
        arguments = self._arguments()
        for name in self._each_site:
            if np.ndim(arguments[name]):
                arguments[name] = np.delete(arguments[name], i, axis=0)
        reason = "there are none"
        if len(self.points) > 1:
            try:
                return self._made(np.delete(self.points, i, axis=0), **arguments)
            except np.linalg.LinAlgError as error:
                reason = str(error)
        raise np.linalg.LinAlgError(
            f"without point {i}, ({valid.format_point(self.points[i])}), the others do not "
            f"determine the field: {reason}"
        )

    @classmethod
    def _made(cls, points: np.ndarray, **arguments: Any) -> Reconstruction:
        """The method on points (n, d), with all arguments of `_argument_names`."""
        make: Callable[..., Reconstruction] = cls
        return make(points, **arguments)

    @classmethod
    def _argument_names(cls) -> list[str]:
        """Names of the constructor's arguments besides the points.

        Without `executor` and `progress`, which do not change the method.
        """
        parameters = signature(cls).parameters.values()
        named = [p.name for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]
        names = [name for name in named if name not in ("executor", "progress")]
        if names[:1] != ["points"]:
            raise TypeError(f"{cls.__name__} is not made from points: its arguments are {names}")
        return names[1:]

    def _arguments(self) -> dict[str, Any]:
        """Arguments with which this method is made again on points, from attributes so named."""
        names = self._argument_names()
        if missing := [name for name in names if not hasattr(self, name)]:
            raise TypeError(
                f"{type(self).__name__} keeps no attribute {missing[0]!r}, an argument with which "
                "it is made; keep it, or override _arguments"
            )
        return {name: getattr(self, name) for name in names}

    def _adjoint(
        self,
        x: np.ndarray,
        f: np.ndarray,
        executor: Executor | None,
        progress: Progress | None,
    ) -> np.ndarray:
        """H^T f (n, v) of loads f (m, v) at queries (m, d), from the sum of their moments."""
        order = self._order(x)
        every = np.arange(len(x)) if order is None else order
        work = partial(_moments_at, self._moments, x, f)
        total = np.zeros((self._number_of_moments(), f.shape[1]), dtype=f.dtype)
        rows = self._chunk_rows(f.shape[1])
        for _, (own, moments) in chunked(work, every, rows, executor, progress):
            total[own] += moments
        return self._of_moments(total)

    def _moments(self, x: np.ndarray, f: np.ndarray) -> tuple[Any, np.ndarray]:
        """Indices (k,) and terms (k, v) of the sums over queries, here H^T f, for some of them."""
        h = self._weight_rows(x)
        if isinstance(h, np.ndarray):
            return slice(None), h.T @ f
        sites = np.flatnonzero(np.bincount(h.indices))
        return sites, (h.T @ f)[sites]

    def _number_of_moments(self) -> int:
        """Number of the sums."""
        return len(self.points)

    def _of_moments(self, moments: np.ndarray) -> np.ndarray:
        """H^T f (n, v) from the sums over all loads."""
        return moments


def as_maker(
    method: Callable[..., Reconstruction] | Reconstruction,
) -> Callable[..., Reconstruction]:
    """A function of points (n, d): the given one, or one that makes the method again on them."""
    if isinstance(method, Reconstruction):
        return partial(method._made, **method._arguments())
    return method


def given(**arguments: Any) -> dict[str, Any]:
    """The arguments that are not None: not every method takes all of them."""
    return {name: value for name, value in arguments.items() if value is not None}


def weights_if_they_fit(method: Reconstruction, x: np.ndarray) -> Weights | None:
    """The weights at x, or None where they are dense and too large to keep."""
    try:
        return method.weights(x)
    except MemoryError:
        return None


def _checked(
    rows_of_weights: Callable[[np.ndarray], Weights | tuple[Weights, ...]], x: np.ndarray
) -> tuple[Weights, ...]:
    rows = valid.quiet_evaluate(rows_of_weights, x)
    matrices = rows if isinstance(rows, tuple) else (rows,)
    return tuple(valid.check_finite(matrix, x) for matrix in matrices)


def _moments_at(
    moments: Callable[[np.ndarray, np.ndarray], tuple[Any, np.ndarray]],
    x: np.ndarray,
    f: np.ndarray,
    queries: np.ndarray,
) -> tuple[Any, np.ndarray]:
    return valid.quiet_evaluate(moments, x[queries], f[queries])
