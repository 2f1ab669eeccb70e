"""What the coordinates of convex polytopes have in common: heights in, weights of corners out."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator

import numpy as np

from fieldrecon._chunks import rows_of
from fieldrecon._polytope import KIND
from fieldrecon._product_form import ProductForm
from fieldrecon.polynomials import EPS
from fieldrecon.reconstruction import Reconstruction


class ConvexCoordinates(Reconstruction):
    """Coordinates of a convex polytope whose corners are the sites, given heights below its faces.

    They reproduce linear fields and interpolate at the corners. Inside they are positive. Outside
    they may be negative, and have a pole where their common denominator vanishes.

    A subclass sets `points`, `_form` and `_unit`, and measures the heights in that unit.
    """

    degree = 1
    interpolates = True
    _form: ProductForm
    _unit: float
    _nearness = EPS  # of a corner, in units: its own weight is one

    @abstractmethod
    def _heights(self, x: np.ndarray) -> np.ndarray:
        """Heights (f, m) of the queries (m, d) below the faces, to the length of their normals."""

    def _weight_rows(self, x: np.ndarray) -> np.ndarray:
        self._refuse_if_too_large(len(x))
        w = np.empty((self._form.n, len(x)))
        for part in self._parts(len(x), 1):
            lost = self._form.weights(self._heights(x[part]), out=w[:, part])
            if lost.any():
                self._decide(x, np.flatnonzero(lost) + part.start, w)
        return w.T

    def _gradient_weight_rows(self, x: np.ndarray) -> tuple[np.ndarray, ...]:
        d = x.shape[1]
        self._refuse_if_too_large(len(x), d)
        g = np.empty((d, self._form.n, len(x)))
        for part in self._parts(len(x), 1 + d):
            gradients, lost = self._form.gradients(self._heights(x[part]))
            if lost.any():
                self._decide(x, np.flatnonzero(lost) + part.start)
            g[:, :, part] = gradients.swapaxes(0, 1) / self._unit
        return tuple(matrix.T for matrix in g)

    def _decide(self, x: np.ndarray, queries: np.ndarray, w: np.ndarray | None = None) -> None:
        """One at corners where more than d faces meet and all products vanish; else no value."""
        for k in queries:
            distance = np.abs(self.points / self._unit - x[k] / self._unit).max(axis=1)
            i = int(distance.argmin())
            at_corner = self._form.crowded[i] and distance[i] <= self._nearness
            where = f"({', '.join(f'{c:.6g}' for c in x[k])})"
            if at_corner and w is not None:
                w[:, k] = np.arange(len(w)) == i
            elif at_corner:
                raise ValueError(
                    f"the coordinates have no gradient at the corner {where}, where "
                    f"more than {x.shape[1]} faces meet"
                )
            else:
                raise np.linalg.LinAlgError(
                    f"the coordinates have no value at {where}: the weights of the corners "
                    f"cancel there, as they can outside a convex {KIND[x.shape[1]]}"
                )

    def _parts(self, m: int, arrays: int) -> Iterator[slice]:
        rows = rows_of(8 * (self._form.numbers_per_query + self._form.n) * arrays)
        return (slice(start, min(start + rows, m)) for start in range(0, m, rows))

    def _chunk_rows(self, columns: int) -> int:
        d = self.points.shape[1]
        return rows_of(8 * (self._form.numbers_per_query + self._form.n + d * columns))
