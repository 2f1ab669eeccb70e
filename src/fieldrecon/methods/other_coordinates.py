"""Methods that work in other coordinates than those of their sites: s(x) = t(g(x)).

The derivatives of s are those of t by the chain rule,

    ds/dx_k = sum_i dt/dg_i dg_i/dx_k,
    d2s/dx_k dx_l = sum_ij d2t/dg_i dg_j dg_i/dx_k dg_j/dx_l + sum_i dt/dg_i d2g_i/dx_k dx_l.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from concurrent.futures import Executor
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress
from fieldrecon.fields import Field
from fieldrecon.reconstruction import Reconstruction, Weights, as_maker, given


class OtherCoordinates(Reconstruction):
    """A method `method` on the transformed sites; a subclass has g and its derivatives."""

    method: Reconstruction

    def _make(
        self,
        method: Callable[..., Reconstruction] | Reconstruction,
        executor: Executor | None,
        progress: Progress | None,
    ) -> None:
        """Make the method on the transformed sites; of the polynomials of x constants are left."""
        how = given(executor=executor, progress=progress)
        self.method = as_maker(method)(self._transformed(self.points), **how)
        self.degree = min(self.method.degree, 0)

    @cached_property
    def interpolates(self) -> bool:  # type: ignore[override]
        """Whether the method on the transformed sites interpolates."""
        return self.method.interpolates

    @abstractmethod
    def _transformed(self, x: np.ndarray) -> np.ndarray:
        """Coordinates g(x), (m, i), of the queries (m, k)."""

    @abstractmethod
    def _slopes(self, x: np.ndarray) -> np.ndarray:
        """Derivatives dg_i/dx_k, (m, i, k)."""

    @abstractmethod
    def _curvatures(self, x: np.ndarray) -> np.ndarray:
        """Second derivatives d2g_i/dx_k dx_l, (m, i, k, l)."""

    def field(self, values: ArrayLike, **how: Any) -> Field:
        """Field of these data, as the inner method makes it.

        Parameters
        ----------
        values : (n, ...) array_like
            One real or complex scalar, vector or array for each site.
        **how
            Further arguments of the method's own `field`, such as `executor` and `progress`.

        Returns
        -------
        Field
            Callable at coordinates of the sites' kind, with a gradient.
        """
        values = valid.as_values(values, len(self.points))
        return Field(self, values, lambda columns: self.method.field(columns, **how)._prepared)

    def _leave_one_out(self, values: np.ndarray, progress: Progress | None) -> np.ndarray:
        return self.method._leave_one_out(values, progress)

    @property
    def _has_sparse_weights(self) -> bool:
        return self.method._has_sparse_weights

    def _weight_rows(self, x: np.ndarray) -> Weights:
        return self.method._weight_rows(self._transformed(x))

    def _gradient_weight_rows(self, x: np.ndarray) -> tuple[Weights, ...]:
        inner = self.method._gradient_weight_rows(self._transformed(x))
        return tuple(_combined(inner, slope) for slope in np.moveaxis(self._slopes(x), 2, 0))

    def _prepare(self, values: np.ndarray) -> object:
        return self.method._prepare(values)

    def _value_rows(self, x: np.ndarray, prepared: object) -> np.ndarray:
        return self.method._value_rows(self._transformed(x), prepared)

    def _gradient_rows(self, x: np.ndarray, prepared: object) -> np.ndarray:
        gradients = self.method._gradient_rows(self._transformed(x), prepared)
        return np.einsum("mvi,mik->mvk", gradients, self._slopes(x))

    def _hessian_rows(self, x: np.ndarray, prepared: object) -> np.ndarray:
        there, slopes = self._transformed(x), self._slopes(x)
        gradients = self.method._gradient_rows(there, prepared)
        hessians = self.method._hessian_rows(there, prepared)
        bent = np.einsum("mik,mvij,mjl->mvkl", slopes, hessians, slopes)
        return bent + np.einsum("mvi,mikl->mvkl", gradients, self._curvatures(x))

    def _adjoint(
        self,
        x: np.ndarray,
        f: np.ndarray,
        executor: Executor | None,
        progress: Progress | None,
    ) -> np.ndarray:
        return self.method._adjoint(self._transformed(x), f, executor, progress)

    def _order(self, x: np.ndarray) -> np.ndarray | None:
        return self.method._order(self._transformed(x))

    def _chunk_rows(self, columns: int) -> int:
        return self.method._chunk_rows(columns)

    def _weight_chunk_rows(self) -> int:
        return self.method._weight_chunk_rows()


def _combined(inner: tuple[Weights, ...], slope: np.ndarray) -> Weights:
    """Weights (m, n) of the derivative along the directions dg/dx_k, (m, i)."""
    first, *others = (sparse.diags_array(s) @ w for w, s in zip(inner, slope.T, strict=True))
    return sum(others, first)
