"""The one idea: a method is its weights, s(x) = sum_i w_i(x) f_i, and they need the sites only."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from fieldrecon import _validation as valid
from fieldrecon._chunks import rows_of
from fieldrecon.fields import Field

DENSE_LIMIT_BYTES = 2**31
"""Largest dense weight matrix that is formed, in bytes."""

__all__ = ["Field", "Reconstruction", "Weights", "weights_if_they_fit"]

Weights: TypeAlias = np.ndarray | sparse.csr_array


class Reconstruction(ABC):
    """A method on fixed sites, linear in the data: sites first, data second, then call.

    Attributes
    ----------
    points : (n, d) ndarray
        The sites.
    degree : int
        Highest total degree of polynomials that come back exactly; -1 for none.
    interpolates : bool
        Whether the data come back at the sites.
    """

    points: np.ndarray
    degree: int
    interpolates: bool

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

    def weights(self, x: ArrayLike) -> Weights:
        """Weights w_i(x) of the data in the value at x.

        Parameters
        ----------
        x : (..., d) array_like
            Queries; m of them in all.

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
        """
        queries = self._queries(x).reshape(-1, self.points.shape[1])
        return valid.finite_rows(valid.without_warnings(self._weight_rows, queries), queries)

    def gradient_weights(self, x: ArrayLike) -> tuple[Weights, ...]:
        """Weights of the data in each component of the gradient at x.

        Parameters
        ----------
        x : (..., d) array_like
            Queries; m of them in all.

        Returns
        -------
        tuple of d matrices (m, n)
            The gradient is (G_1 f, ..., G_d f); sparse for local methods.

        Raises
        ------
        MemoryError
            If the dense matrices would exceed DENSE_LIMIT_BYTES.
        """
        queries = self._queries(x).reshape(-1, self.points.shape[1])
        matrices = valid.without_warnings(self._gradient_weight_rows, queries)
        return tuple(valid.finite_rows(matrix, queries) for matrix in matrices)

    def adjoint(self, x: ArrayLike, f: ArrayLike) -> np.ndarray:
        """Adjoint H^T f of `weights`, without forming H where that can be avoided.

        Parameters
        ----------
        x : (..., d) array_like
            Queries; m of them in all.
        f : (m, ...) array_like
            One value for each query, for instance a load.

        Returns
        -------
        (n, ...) ndarray
            One value for each site.

        Raises
        ------
        ValueError
            If there is not one finite value for each query.
        """
        queries = self._queries(x).reshape(-1, self.points.shape[1])
        f = valid.as_values(f, len(queries), name="f", of="query")
        columns = f.reshape(len(f), math.prod(f.shape[1:]))  # of no queries too
        result = valid.without_warnings(self._adjoint, queries, columns)
        return valid.finite_rows(result, self.points).reshape((len(self.points), *f.shape[1:]))

    def _queries(self, x: ArrayLike) -> np.ndarray:
        """Queries (..., d)."""
        return valid.as_queries(x, self.points.shape[1])

    def _refuse_if_too_large(self, m: int, matrices: int = 1) -> None:
        size = 8 * m * len(self.points) * matrices
        if size > DENSE_LIMIT_BYTES:
            raise MemoryError(
                f"dense weights of {m} queries for {len(self.points)} sites would take "
                f"{size / 2**30:.1f} GiB; use field(values) or adjoint(x, f), which do not form "
                "them, or a local method, whose weights are sparse"
            )

    # A method is its weights: these two make one. The others are its faster routes.

    @abstractmethod
    def _weight_rows(self, x: np.ndarray) -> Weights:
        """Weights (m, n) at the queries (m, d)."""

    @abstractmethod
    def _gradient_weight_rows(self, x: np.ndarray) -> tuple[Weights, ...]:
        """Gradient weights at the queries, d matrices (m, n)."""

    def _prepare(self, values: np.ndarray) -> Any:
        """What evaluation needs of the data (n, v): coefficients, or the data themselves."""
        return values

    def _value_rows(self, x: np.ndarray, prepared: Any) -> np.ndarray:
        """Values (m, v)."""
        return self._weight_rows(x) @ prepared

    def _gradient_rows(self, x: np.ndarray, prepared: Any) -> np.ndarray:
        """Gradients (m, v, d)."""
        return np.stack([g @ prepared for g in self._gradient_weight_rows(x)], axis=-1)

    def _order(self, x: np.ndarray) -> np.ndarray | None:  # noqa: ARG002 - by default as they come
        """Order of the queries (m, d) in which neighbours are evaluated together; None as is."""
        return None

    def _chunk_rows(self, columns: int) -> int:
        """Queries of one chunk, for data of so many columns."""
        return rows_of(8 * (columns + len(self.points)) * (self.points.shape[1] + 1))

    def _adjoint(self, x: np.ndarray, f: np.ndarray) -> np.ndarray:
        rows = max(1, DENSE_LIMIT_BYTES // (64 * 8 * len(self.points)))
        total = np.zeros((len(self.points), f.shape[1]), dtype=f.dtype)
        for start in range(0, len(x), rows):
            part = slice(start, start + rows)
            total += self._weight_rows(x[part]).T @ f[part]
        return total


def weights_if_they_fit(method: Reconstruction, x: np.ndarray) -> Weights | None:
    """The weights at x, or None where they are dense and too large to keep."""
    try:
        return method.weights(x)
    except MemoryError:
        return None
