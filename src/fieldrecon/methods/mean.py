"""The mean of several methods on the same sites: s(x) = (s_1(x) + ... + s_k(x)) / k.

Where two methods of different kinds are about equally good, their errors differ, and partly cancel
in the mean.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from functools import cached_property, reduce
from operator import add
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, split_progress
from fieldrecon.fields import Field
from fieldrecon.reconstruction import Reconstruction, Weights, as_maker, given


class Mean(Reconstruction):
    """The mean of the fields of several methods, s(x) = (1/k) sum_j s_j(x).

    Its weights are the means of theirs. It reproduces the polynomials that all of them reproduce.

    Parameters
    ----------
    points : (n, d) array_like
        The sites.
    methods : sequence of callable or Reconstruction
        Each takes points (n, d) to a method on them; or such methods, which are made again.
    executor : concurrent.futures.Executor, optional
        Passed on to the methods, all of which must take it.
    progress : callable, optional
        Passed on to the methods, all of which must take it; a part of the work to each.

    Attributes
    ----------
    methods : tuple of Reconstruction
        The methods on the sites.

    Raises
    ------
    ValueError
        If there are no methods, or one has other sites.

    References
    ----------
    Bates and Granger, The combination of forecasts (1969).

    Examples
    --------
    >>> import fieldrecon as fr
    >>> mean = Mean([[0.0], [1.0], [2.0]], [fr.LeastSquares, lambda p: fr.LeastSquares(p, 2)])
    >>> float(mean.field([0.0, 0.0, 3.0])([2.0]).round(9))
    2.75
    """

    def __init__(
        self,
        points: ArrayLike,
        methods: Sequence[Callable[..., Reconstruction] | Reconstruction],
        progress: Progress | None = None,
        *,
        executor: Executor | None = None,
    ) -> None:
        self.points = valid.as_points(points)
        if isinstance(methods, Reconstruction) or callable(methods):
            raise ValueError("methods must be a sequence: one method is given as [method]")
        if not len(methods):
            raise ValueError("methods must be one or more: there is no mean of none")
        parts = split_progress(progress, len(self.points), len(methods))
        made = zip(map(as_maker, methods), parts, strict=True)
        self.methods = tuple(
            make(self.points, **given(executor=executor, progress=part)) for make, part in made
        )
        for method in self.methods:
            if not np.array_equal(method.points.ravel(), self.points.ravel()):
                raise ValueError(
                    "each of the methods must be made on all given points, in their order; "
                    f"{type(method).__name__} has {len(method.points)} of {len(self.points)} points"
                )
        self.degree = min(method.degree for method in self.methods)

    @cached_property
    def interpolates(self) -> bool:  # type: ignore[override]
        """Whether all of the methods interpolate."""
        return all(method.interpolates for method in self.methods)

    def field(self, values: ArrayLike, *, progress: Progress | None = None, **how: Any) -> Field:
        """Field of these data.

        Parameters
        ----------
        values : (n, ...) array_like
            One real or complex scalar, vector or array for each site.
        progress : callable, optional
            Passed on to the `field` of each method, all of which must take it; a part of the work
            to each.
        **how
            Further arguments of the methods' own `field`, such as `executor`.

        Returns
        -------
        Field
            Callable at any points, with a gradient.
        """

        def prepared(columns: np.ndarray) -> list[Any]:
            parts = split_progress(progress, 100 * len(self.methods), len(self.methods))
            both = zip(self.methods, parts, strict=True)
            return [m.field(columns, **how, **given(progress=p))._prepared for m, p in both]

        return Field(self, valid.as_values(values, len(self.points)), prepared)

    def _leave_one_out(self, values: np.ndarray, progress: Progress | None) -> np.ndarray:
        parts = split_progress(progress, len(values), len(self.methods))
        both = zip(self.methods, parts, strict=True)
        return _mean(method._leave_one_out(values, part) for method, part in both)

    @property
    def _has_sparse_weights(self) -> bool:
        return all(method._has_sparse_weights for method in self.methods)

    def _weight_rows(self, x: np.ndarray) -> Weights:
        return _mean(method._weight_rows(x) for method in self.methods)

    def _gradient_weight_rows(self, x: np.ndarray) -> tuple[Weights, ...]:
        rows = [method._gradient_weight_rows(x) for method in self.methods]
        return tuple(map(_mean, zip(*rows, strict=True)))

    def _prepare(self, values: np.ndarray) -> list[Any]:
        return [method._prepare(values) for method in self.methods]

    def _value_rows(self, x: np.ndarray, prepared: list[Any]) -> np.ndarray:
        return _mean(m._value_rows(x, p) for m, p in self._with(prepared))

    def _gradient_rows(self, x: np.ndarray, prepared: list[Any]) -> np.ndarray:
        return _mean(m._gradient_rows(x, p) for m, p in self._with(prepared))

    def _hessian_rows(self, x: np.ndarray, prepared: list[Any]) -> np.ndarray:
        return _mean(m._hessian_rows(x, p) for m, p in self._with(prepared))

    def _laplacian_rows(self, x: np.ndarray, prepared: list[Any]) -> np.ndarray:
        return _mean(m._laplacian_rows(x, p) for m, p in self._with(prepared))

    def _with(self, prepared: list[Any]) -> Iterator[tuple[Reconstruction, Any]]:
        return zip(self.methods, prepared, strict=True)

    def _adjoint(
        self,
        x: np.ndarray,
        f: np.ndarray,
        executor: Executor | None,
        progress: Progress | None,
    ) -> np.ndarray:
        parts = split_progress(progress, len(x), len(self.methods))
        both = zip(self.methods, parts, strict=True)
        return _mean(method._adjoint(x, f, executor, part) for method, part in both)

    def _order(self, x: np.ndarray) -> np.ndarray | None:
        orders = (method._order(x) for method in self.methods)
        return next((order for order in orders if order is not None), None)

    def _chunk_rows(self, columns: int) -> int:
        return min(method._chunk_rows(columns) for method in self.methods)

    def _weight_chunk_rows(self) -> int:
        return min(method._weight_chunk_rows() for method in self.methods)


def _mean(terms: Iterable[Any]) -> Any:
    every = list(terms)
    return reduce(add, every) / len(every)
