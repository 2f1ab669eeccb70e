"""The weighted fits of moving least squares at a batch of queries, and their derivatives."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fieldrecon._core.validation import format_point
from fieldrecon._numerics.jets import upper_pairs
from fieldrecon._numerics.neighbor_search import Neighborhood, group_rows
from fieldrecon._numerics.weighted_least_squares import (
    Undetermined,
    coefficient_weights,
    residuals,
    weights_of_changing_weights,
)
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.derivatives import log_square_bend, smoothness
from fieldrecon.kernels.weights import log_square_slope, relative_weights
from fieldrecon.polynomials import (
    EPS,
    monomial_hessians,
    monomials,
    power_of_two_above,
    undetermined,
)

if TYPE_CHECKING:
    from fieldrecon.methods.moving_least_squares import MovingLeastSquares

LARGEST_SUM = 1e-5 / EPS
"""Largest sum of absolute weights of a value: rounding then leaves it five digits."""


class LocalFit:
    """The fits at a batch of queries, each in its own frame, with bases and weights of size one."""

    def __init__(
        self,
        method: MovingLeastSquares,
        x: np.ndarray,
        without: np.ndarray | None = None,
    ) -> None:
        self.method = method
        self.x = x
        self.local = local = method.in_units(x)
        self.near = near = method.search(local, without)
        there = np.isfinite(near.distance)
        distance = np.where(there, near.distance, 0.0)
        size = distance.max(axis=1, initial=0.0) if near.reach is None else near.reach
        self.size = power_of_two_above(size)[:, None]
        # Coordinates lie apart in memory: operations run over all neighbours of one coordinate,
        # where they would run over the few coordinates of one neighbour.
        offset = method.sites.T.take(near.index, axis=1)
        offset -= local.T[..., None]
        offset *= there / self.size
        self.offset = np.moveaxis(offset, 0, -1)
        self.basis = monomials(self.offset, method.degree)
        self.scaled_weight, self.r = self._scaled(near, distance)
        self.weight = relative_weights(self.scaled_weight, self.r, there)

    def _scaled(self, near: Neighborhood, distance: np.ndarray) -> tuple[Radial, np.ndarray]:
        """The weight function, and the distances (m, k) in its unit."""
        if near.reach is not None:
            reach = np.where(near.reach > 0, near.reach, 1.0)
            return self.method.weight, distance / reach[:, None]
        return self.method.weight.in_units(self.method.unit), distance

    def coefficient_weights(self, rows: int) -> np.ndarray:
        """C (m, rows, k): C f are the first local coefficients, of which c_0 is the value."""
        try:
            if self.method.coincident:
                return self._shared_weights(rows)
            return self._determined_weights(self.weight, rows)
        except Undetermined as error:
            where = format_point(self.x[error.query])
            counted = int((self.weight[error.query] > 0).sum())
            who = f"the {counted} sites that count at the query ({where}) do"
            d, degree = self.x.shape[1], self.method.degree
            if error.size:
                raise np.linalg.LinAlgError(
                    f"{who} not determine a polynomial of degree {degree} beyond rounding: the "
                    f"absolute weights of their data sum to {error.size:.0e}; lower the degree, or "
                    "choose a weight that decreases more slowly or more neighbors"
                ) from None
            raise undetermined(d, degree, error.rank, who) from None

    def _determined_weights(self, w: np.ndarray, rows: int) -> np.ndarray:
        return coefficient_weights(self.basis, w, rows, self._tolerance(), LARGEST_SUM)

    def _shared_weights(self, rows: int) -> np.ndarray:
        """C where sites coincide: one site of each group enters the fit, and all share its weights.

        Equal rows are redundant, and the rounding in them may outweigh all lighter rows.
        """
        k = self.weight.shape[1]
        nowhere = len(self.method.points) + np.arange(k)
        label = np.where(self.near.missing, nowhere, self.method.labels[self.near.index])
        lead, count = group_rows(label)
        w = np.where(lead == np.arange(k), np.sqrt(count) * self.weight, 0.0)
        c = self._determined_weights(w, rows)
        return np.take_along_axis(c, lead[:, None, :], axis=2) / count[:, None, :]

    def residuals(self, data: np.ndarray) -> np.ndarray:
        """Residuals V - B c (m, k, v) of the data (m, k, v)."""
        c = self.coefficient_weights(self.basis.shape[-1])
        return residuals(c, self.basis, self.weight, data)

    def gradient_weights(self) -> np.ndarray:
        """Weights (m, k, d) of the data in the gradient, per unit of the cloud's size.

        The gradient is (c_1 ... c_d), and the change of c_0 with the weights.
        """
        d = self.offset.shape[-1]
        c = self.coefficient_weights(self.basis.shape[-1])
        change = weights_of_changing_weights(c, self.basis, self.weight, self._log_gradient())
        if self.method.degree == 0:
            return change
        return c[:, 1 : d + 1].mT / self.size[..., None] + change

    def hessians(self, data: np.ndarray) -> np.ndarray:
        """Second derivatives (m, v, d, d) by x, per unit of the cloud's size, for data (m, k, v).

        With c(x) the coefficients of the polynomial about a fixed origin, b the basis there, r the
        residuals, and g = D log w^2, the derivatives of the normal equations are

            D_k c = C (g_k r),
            D_kl c = C ((D_kl log w^2 + g_k g_l) r - g_k B D_l c - g_l B D_k c),

        and those of s = b(x)^T c are D_kl s = c_kl + D_k c_l + D_l c_k + D_kl c_0.
        """
        self._refuse_a_rough_weight()
        d, q = self.offset.shape[-1], self.basis.shape[-1]
        c = self.coefficient_weights(q)
        r = residuals(c, self.basis, self.weight, data)
        g = self._log_gradient()
        moved = [c @ (g[..., k, None] * r) for k in range(d)]  # D_k c, (m, q, v)
        of_origin = monomial_hessians(np.zeros(d), self.method.degree)  # of b, (q, d, d)
        result = np.empty((len(r), data.shape[2], d, d), dtype=data.dtype)
        for k, j in upper_pairs(d):
            change = (self._log_hessian(k, j) + g[..., k] * g[..., j])[..., None] * r
            change -= g[..., k, None] * (self.basis @ moved[j])
            change -= g[..., j, None] * (self.basis @ moved[k])
            second = (c[:, :1] @ change)[:, 0]
            if q > 1:
                second += (moved[k][:, 1 + j] + moved[j][:, 1 + k]) / self.size
            second += (of_origin[:, k, j] @ (c @ data)) / self.size**2
            result[..., k, j] = result[..., j, k] = second
        return result

    def _refuse_a_rough_weight(self) -> None:
        at_site = (self.near.distance == 0).any(axis=1)
        if at_site.any() and smoothness(self.method.weight) < 2:
            where = format_point(self.x[np.argmax(at_site)])
            raise ValueError(
                f"{self.method.weight!r} has no second derivatives at a site, and the query "
                f"({where}) is one"
            )

    def _log_gradient(self) -> np.ndarray:
        """Gradient of log w_i^2 by x, (m, k, d), per unit of the cloud's size."""
        slope = log_square_slope(self.scaled_weight, self.r, self.weight)
        return slope[..., None] / 2 * self._ratio_gradient

    def _log_hessian(self, k: int, j: int) -> np.ndarray:
        """Second derivative (m, k) of log w_i^2 by the variables k and j of x."""
        slope = log_square_slope(self.scaled_weight, self.r, self.weight)
        bend = log_square_bend(self.scaled_weight, self.r, self.weight)
        ratio = self._ratio_gradient
        return slope / 2 * self._ratio_hessian(k, j) + bend / 4 * ratio[..., k] * ratio[..., j]

    # The weight is a function of the squared distance, or of its ratio to rho^2, which moves too.

    @cached_property
    def _ratio_gradient(self) -> np.ndarray:
        """Gradient (m, k, d) by x of the squared distance, or of r^2 / rho^2."""
        offset = self.offset * self.size[..., None]
        if self.near.reach_index is None:
            return -2 * offset
        return 2 * (self.r[..., None] ** 2 * self._to_reach - offset) / self._rho_squared[..., None]

    def _ratio_hessian(self, k: int, j: int) -> np.ndarray | float:
        """Second derivative (m, k) by the variables k and j of what `_ratio_gradient` is of."""
        unit = 2.0 * (k == j)
        if self.near.reach_index is None:
            return unit
        ratio, to = self._ratio_gradient, self._to_reach
        mixed = ratio[..., k] * to[..., j] + ratio[..., j] * to[..., k]
        return (unit * (1 - self.r**2) + 2 * mixed) / self._rho_squared

    @property
    def _to_reach(self) -> np.ndarray:
        """Offsets (m, 1, d) of the sites at the distances rho."""
        return (self.method.sites[self.near.reach_index] - self.local)[:, None, :]

    @property
    def _rho_squared(self) -> np.ndarray:
        """Squared scales (m, 1) of the distances; one where all sites coincide with the query."""
        reach = np.asarray(self.near.reach)
        return np.where(reach > 0, reach, 1.0)[:, None] ** 2

    def _tolerance(self) -> np.ndarray:
        """Rounding (m,) of the offsets relative to their size; smaller singular values are zero."""
        reach = np.abs(self.local).max(axis=1) / self.size[:, 0]
        return 4 * EPS * (max(self.basis.shape[1:]) + max(self.method.degree, 1) * (1 + reach))
