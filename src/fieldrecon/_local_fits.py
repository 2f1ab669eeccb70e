"""The fits of moving least squares at a batch of queries, each in its own frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fieldrecon._neighborhoods import Neighborhood, gathered
from fieldrecon._validation import place
from fieldrecon._weighted_fits import Undetermined, coefficient_weights
from fieldrecon.polynomials import EPS, monomials, undetermined
from fieldrecon.radial import Radial

if TYPE_CHECKING:
    from fieldrecon.moving_least_squares import MovingLeastSquares


# A weight this much above those at the size of the cloud stands for infinity: the difference is far
# below rounding, and its square and the inverse of that are still numbers.
_INFINITE = 1e120


class LocalFit:
    """The fits at a batch of queries: neighbourhoods, frames, bases and weights, of size one."""

    def __init__(
        self,
        method: MovingLeastSquares,
        x: np.ndarray,
        without: np.ndarray | None = None,
    ) -> None:
        self.method = method
        self.x = x
        local = method.in_units(x)
        self.near = near = method.search(local, without)
        there = np.isfinite(near.distance)
        distance = np.where(there, near.distance, 0.0)
        size = distance.max(axis=1, initial=0.0) if near.reach is None else near.reach
        # a power of two, so that scaling rounds nothing
        self.size = np.exp2(np.ceil(np.log2(np.where(size > 0, size, 1.0))))[:, None]
        offset = method.sites.take(near.index, axis=0)  # in half the time of sites[index]
        offset -= local[:, None, :]
        offset *= (there / self.size)[..., None]
        self.offset = offset
        self.basis = monomials(self.offset, method.degree)
        self.scaled_weight, self.r = self._scaled(near, distance)
        w = np.where(there, np.minimum(self.scaled_weight(self.r), _INFINITE), 0.0)
        top = w.max(axis=1, initial=0.0)
        self.weight = w / np.where(top > 0, top, 1.0)[:, None]

    def _scaled(self, near: Neighborhood, distance: np.ndarray) -> tuple[Radial, np.ndarray]:
        """The weight, and the distances as it sees them."""
        if near.reach is not None:
            reach = np.where(near.reach > 0, near.reach, 1.0)
            return self.method.weight, distance / reach[:, None]
        return self.method.weight.in_units(self.method.unit), distance

    def coefficient_weights(self, rows: int) -> np.ndarray:
        """C (m, rows, k): C f are the first local coefficients, and the very first is the value."""
        try:
            if self.method.coincident:
                return self._shared_weights(rows)
            return coefficient_weights(self.basis, self.weight, rows, self._tolerance())
        except Undetermined as error:
            where = place(self.x[error.query])
            counted = int((self.weight[error.query] > 0).sum())
            who = f"the {counted} sites that count at the query ({where}) do"
            d, degree = self.x.shape[1], self.method.degree
            raise undetermined(d, degree, error.rank, who) from None

    def _shared_weights(self, rows: int) -> np.ndarray:
        """C where sites coincide: one counts for all in the fit, and all share its weights.

        Alike rows are redundant, and the rounding in them may outweigh all lighter rows.
        """
        k = self.weight.shape[1]
        nowhere = len(self.method.points) + np.arange(k)
        place = np.where(self.near.missing, nowhere, self.method.place[self.near.index])
        lead, count = gathered(place)
        w = np.where(lead == np.arange(k), np.sqrt(count) * self.weight, 0.0)
        c = coefficient_weights(self.basis, w, rows, self._tolerance())
        return np.take_along_axis(c, lead[:, None, :], axis=2) / count[:, None, :]

    def residuals(self, data: np.ndarray) -> np.ndarray:
        """Residuals V - B c (m, k, v) of the data (m, k, v).

        Sum_i w_i^2 r_i = 0: the residual of the heaviest site, which rounding spoils and its weight
        magnifies, is found from those of the others.
        """
        c = self.coefficient_weights(self.basis.shape[-1])
        r = data - self.basis @ (c @ data)
        np.put_along_axis(r, self._heaviest, 0.0, axis=1)
        rest = (self.weight[..., None] ** 2 * r).sum(axis=1, keepdims=True)
        np.put_along_axis(r, self._heaviest, -rest, axis=1)
        return r

    @property
    def _heaviest(self) -> np.ndarray:
        return np.argmax(self.weight, axis=1)[:, None, None]

    def gradient_weights(self) -> np.ndarray:
        """Weights (m, k, d) of the data in the gradient, per unit of the cloud's size.

        grad f = (c_1 ... c_d) + sum_i a_i (grad w_i^2 / w_i^2) r_i, with r = V - B c
        and a the first row of C.
        """
        d = self.offset.shape[-1]
        c = self.coefficient_weights(self.basis.shape[-1])
        a = c[:, 0]
        u = a[..., None] * self._log_gradient()
        # the residual of the heaviest site by those of the others, as in `residuals`
        u = u - self.weight[..., None] ** 2 * np.take_along_axis(u, self._heaviest, axis=1)
        change = u - (c.mT @ (self.basis.mT @ u))
        if self.method.degree == 0:
            return change
        return c[:, 1 : d + 1].mT / self.size[..., None] + change

    def _log_gradient(self) -> np.ndarray:
        """Gradient of log w_i^2 by x, (m, k, d), per unit of the cloud's size."""
        steepness = 2 * self.scaled_weight.slope(self.r) / self.scaled_weight(self.r)
        # a site without weight has no part in it, nor one of infinite weight, where x - p = 0
        known = (self.weight > 0) & np.isfinite(steepness)
        steepness = np.where(known, steepness, 0.0)[..., None]
        offset = self.offset * self.size[..., None]
        if self.near.reach is None or self.near.reach_index is None:
            return -steepness * offset
        # w(r / rho): rho moves with x as well
        rho = np.where(self.near.reach > 0, self.near.reach, 1.0)[:, None, None]
        local = self.x / self.method.unit
        to_reach = (self.method.sites[self.near.reach_index] - local)[:, None, :]
        return -steepness * (offset - self.r[..., None] ** 2 * to_reach) / rho**2

    def _tolerance(self) -> np.ndarray:
        """Rounding of the offsets relative to their size, (m,): below it a rank means nothing."""
        reach = np.abs(self.x).max(axis=1) / (self.size[:, 0] * self.method.unit)
        return 4 * EPS * (max(self.basis.shape[1:]) + max(self.method.degree, 1) * (1 + reach))
