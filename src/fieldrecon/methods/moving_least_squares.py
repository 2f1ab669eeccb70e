"""Moving least squares: a polynomial for each query, its weights falling with the distance."""

from __future__ import annotations

import math
from concurrent.futures import Executor
from functools import partial

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, chunked, report_all, rows_of
from fieldrecon._core.duplicates import coincidence_labels
from fieldrecon._numerics.neighbor_search import (
    AllSites,
    Nearest,
    Neighborhood,
    Search,
    WithinRadius,
    as_neighbors,
    by_cells,
)
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.weights import as_weight, inverse_square
from fieldrecon.methods.least_squares import ACCURATE, half_sum_of_squares, monomial_matrix
from fieldrecon.methods.local_fits import LocalFit
from fieldrecon.methods.metric import as_metric, frame_of
from fieldrecon.polynomials import (
    dimension,
    monomials,
    refuse_too_few,
    require_unisolvent,
)
from fieldrecon.reconstruction import Reconstruction, Weights


class MovingLeastSquares(Reconstruction):
    """Moving least squares, c(x) = argmin 1/2 |W(x) (B c - V)|^2 and f(x) = b(x)^T c(x).

    The weights enter squared, as on the slides: a squared residual has the weight w^2, for instance
    with w = 1/(r^2 + epsilon^2).
    Each query is solved in its own frame, shifted to x and scaled to the neighbourhood. The
    gradient is exact: it includes the derivative of the weights. The rounding errors of gradients
    are in the root mean square at most about four times those of QR of each fit.

    Parameters
    ----------
    points : (n, d) array_like
        Sites.
    weight : Radial
        Weight function w(r) >= 0: `inverse_square`, `gaussian`, `wendland`, ...
    degree : int
        Total degree of the local polynomials, 0 or more.
    neighbors : int, optional
        With k given, only the k sites nearest to the query count, a site at the query included, and
        the weight sees r/rho, rho the distance of the (k + 1)-th site. So the k-th still counts,
        unless it is as far away: a weight that vanishes at 1 does not count it then. On a lattice
        few neighbors can be too few because of such ties; in the plane six are enough for degree 1
        at queries inside it, and outside more are needed. Of equally distant sites their positions
        decide, not their order, unless sites coincide. With a `wendland` weight of radius 1 the
        field is continuous and piecewise smooth: its gradient jumps where another site becomes the
        (k + 1)-th. A weight that does not vanish at 1 makes the field jump there. Without it, all
        sites within the weight's support count, and the field is as smooth as the weight.
    metric : (d,) or (d, d) array_like, optional
        Distances other than the Euclidean one: scales of the coordinates, for which it is
        sqrt(sum_k ((x_k - y_k) / scale_k)^2), or a symmetric positive definite matrix M, for which
        it is sqrt((x - y)^T M (x - y)). Lengths of the weight are such distances.
    executor : concurrent.futures.Executor, optional
        Accepted by all methods; this one has nothing to split.
    progress : callable, optional
        Called once, as progress(n, n), when the method is made.

    Raises
    ------
    ValueError
        If an argument has the wrong form; if `neighbors` is not less than the number of sites.
    numpy.linalg.LinAlgError
        If the points, or later those about a query, do not determine a polynomial of this degree,
        or leave it fewer than five digits: far from sites near one conic, for instance, if the
        weight decreases so fast that all other sites are negligible.

    References
    ----------
    Erleben, Field Reconstruction, p. 8-10; Lancaster and Salkauskas (1981); Levin (1998).

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> points = fr.datasets.halton(50, 2)
    >>> method = MovingLeastSquares(points, fr.inverse_square(0.1))
    >>> s = method.field(points[:, 0] + 2 * points[:, 1])
    >>> s([0.5, 0.25]).round(12), s.gradient([0.5, 0.25]).round(12)
    (np.float64(1.0), array([1., 2.]))
    """

    def __init__(
        self,
        points: ArrayLike,
        weight: Radial,
        degree: int = 1,
        neighbors: int | None = None,
        *,
        metric: ArrayLike | None = None,
        executor: Executor | None = None,  # noqa: ARG002 - as for all methods
        progress: Progress | None = None,
    ) -> None:
        self.points = valid.as_points(points)
        self.degree = valid.as_degree(degree)
        self.weight = as_weight(weight)
        self.neighbors = as_neighbors(neighbors, len(self.points))
        refuse_too_few(self.points, self.degree)
        self.metric = as_metric(metric, self.points.shape[1])
        self._frame = frame = frame_of(self.points, self.metric)
        require_unisolvent(
            self.points, monomials(frame.local(self.points), self.degree), self.degree, frame.who
        )
        # Lengths in a unit of the cloud's size: no square of a distance overflows. Coordinates are
        # not shifted, which would round close points together; differences are local anyway.
        self.unit = frame.scale
        self.sites = np.asfortranarray(frame.scaled(self.points))
        self.search = self._searched()
        self.labels = coincidence_labels(self.points)
        self.coincident = int(self.labels.max()) + 1 < len(self.points)
        self.interpolates = self._interpolates()
        report_all(progress, len(self.points))

    def _interpolates(self) -> bool:
        n, d = self.points.shape
        infinite = isinstance(self.weight, inverse_square) and self.weight.epsilon == 0
        exact = (self.neighbors or n) == dimension(d, self.degree)
        # the data of coincident sites cannot all be interpolated
        return (infinite or exact) and not self.coincident

    def _searched(self) -> Search:
        if self.neighbors is not None:
            return Nearest(self.sites, self.neighbors)
        if math.isfinite(self.weight.support):
            return WithinRadius(self.sites, self.weight.support / self.unit)
        return AllSites(self.sites)

    @valid.finite("the weights in H_MLS")
    def matrix(self, x: ArrayLike) -> np.ndarray:
        """Matrix H_MLS(x) = B^T W(x)^2 B of the notes, in the points' coordinates; for inspection.

        Parameters
        ----------
        x : (..., d) array_like
            Queries.

        Returns
        -------
        (..., q, q) ndarray
            One symmetric matrix for each query.

        Raises
        ------
        OverflowError
            If its entries do not fit into floating-point numbers in this unit of length.
        """
        x = valid.as_queries(x, self.points.shape[1])
        b = monomial_matrix(self.points, self.degree)
        near = self.search(self.in_units(x.reshape(-1, x.shape[-1])))
        a = self._true_weights(near)[..., None] * b[near.index]
        return (a.mT @ a).reshape((*x.shape[:-1], b.shape[1], b.shape[1]))

    @valid.finite("the objective's squares")
    def objective(self, values: ArrayLike, x: ArrayLike, normalized: bool = False) -> np.ndarray:
        """Objective psi_MLS(x) = 1/2 sum_i w_i(x)^2 (b(p_i)^T c(x) - f_i)^2 at its minimum.

        It is the weighted residual of the local fit, not the error at x: as epsilon grows it falls,
        whatever the data. Normalized, it is divided by sum_i w_i^2.

        Parameters
        ----------
        values : (n, ...) array_like
            Data.
        x : (..., d) array_like
            Queries.
        normalized : bool
            Whether to divide by the sum of the squared weights.

        Returns
        -------
        (..., *v) ndarray
            One number for each query and component of the data.

        Raises
        ------
        OverflowError
            If the squares do not fit into floating-point numbers in this unit.
        """
        values = valid.as_values(values, len(self.points))
        queries = valid.as_queries(x, self.points.shape[1])
        flat = queries.reshape(-1, queries.shape[-1])
        columns = values.reshape(len(values), -1)
        psi = np.empty((len(flat), columns.shape[1]))
        rows = self._chunk_rows(columns.shape[1])
        for start in range(0, len(flat), rows):
            part = slice(start, start + rows)
            psi[part] = self._objective_rows(flat[part], columns, normalized)
        return psi.reshape((*queries.shape[:-1], *values.shape[1:]))

    def _objective_rows(self, x: np.ndarray, values: np.ndarray, normalized: bool) -> np.ndarray:
        fit = LocalFit(self, x)
        residual = fit.residuals(values[fit.near.index])
        w = fit.weight if normalized else self._true_weights(fit.near)
        # an infinite weight has a residual of zero, and w^2 r^2 has the limit zero
        w = np.where(np.isfinite(w), w, 0.0)
        psi = half_sum_of_squares(w[..., None] * residual, axis=1)
        return psi / (fit.weight**2).sum(axis=1)[:, None] if normalized else psi

    def in_units(self, x: np.ndarray) -> np.ndarray:
        """Queries (m, d) in units of the cloud's size, refused if squares of distances overflow."""
        local = self._frame.scaled(x)
        far = np.flatnonzero(~(np.abs(local).max(axis=1) < 1e150))
        if len(far):
            where = valid.format_point(x[far[0]])
            raise OverflowError(
                f"the query ({where}) is too far away: the square of its distance from the sites "
                "exceeds the range of floating-point numbers"
            )
        return local

    def _true_weights(self, near: Neighborhood) -> np.ndarray:
        """Weights w(r) in the points' own unit of length."""
        if near.reach is not None:
            # the scale is zero if all of them coincide with the query
            return self.weight(near.distance / np.where(near.reach > 0, near.reach, 1.0)[:, None])
        r = np.where(near.missing, 0.0, near.distance) * self.unit
        return np.where(near.missing, 0.0, self.weight(r))

    def _leave_one_out(self, values: np.ndarray, progress: Progress | None) -> np.ndarray:
        """Residuals r_i / (1 - h_ii); by a refit where h_ii is nearly one, or neighbours change."""
        every = np.arange(len(self.points))
        if self.neighbors is not None:
            return values - self.predictions_from_others(values, every, progress)
        rest = 1.0 - self.own_weights()
        accurate = rest > ACCURATE
        result = (values - self.field(values)(self.points)) / np.where(accurate, rest, 1.0)[:, None]
        dropped = every[~accurate]
        if len(dropped):
            result[dropped] = values[dropped] - self.predictions_from_others(values, dropped)
        return result

    def predictions_from_others(
        self, values: np.ndarray, sites: np.ndarray, progress: Progress | None = None
    ) -> np.ndarray:
        """Values (m, v) at sites (m,), each reconstructed from the data (n, v) of the others."""
        n, k = len(self.points), self.neighbors
        if k is not None and k + 2 > n:
            raise ValueError(
                f"to leave one point out, neighbors={k} needs {k + 2} points: {k}, the next one, "
                f"which sets the scale, and the one left out; got {n}"
            )
        result = np.empty_like(values[sites])
        work = partial(self._predicted_from_others, values)
        rows = self._chunk_rows(values.shape[1])
        for part, predictions in chunked(work, sites, rows, progress=progress):
            result[part] = predictions
        return result

    def _predicted_from_others(self, values: np.ndarray, sites: np.ndarray) -> np.ndarray:
        fit = LocalFit(self, self.points[sites], without=sites)
        weights = fit.coefficient_weights(1)[:, 0]
        return np.einsum("mk,mkv->mv", weights, values[fit.near.index])

    def own_weights(self) -> np.ndarray:
        """Diagonal (n,) of H(X): the weight of each datum in the value at its own site."""
        result = np.empty(len(self.points))
        rows = self._chunk_rows(1)
        for start in range(0, len(result), rows):
            part = np.arange(start, min(start + rows, len(result)))
            fit = LocalFit(self, self.points[part])
            own = (fit.near.index == part[:, None]) & ~fit.near.missing
            result[part] = np.where(own, fit.coefficient_weights(1)[:, 0], 0.0).sum(axis=1)
        return result

    def _value_rows(self, x: np.ndarray, prepared: np.ndarray) -> np.ndarray:
        fit = LocalFit(self, x)
        data = prepared.take(fit.near.index, axis=0)
        return np.einsum("mk,mkv->mv", fit.coefficient_weights(1)[:, 0], data)

    def _gradient_rows(self, x: np.ndarray, prepared: np.ndarray) -> np.ndarray:
        fit = LocalFit(self, x)
        data = prepared.take(fit.near.index, axis=0)
        return self._frame.gradient(np.einsum("mkd,mkv->mvd", fit.gradient_weights(), data))

    def _hessian_rows(self, x: np.ndarray, prepared: np.ndarray) -> np.ndarray:
        fit = LocalFit(self, x)
        data = prepared.take(fit.near.index, axis=0)
        return self._frame.hessian(fit.hessians(data))

    @property
    def _has_sparse_weights(self) -> bool:
        return self.search.local

    def _weight_rows(self, x: np.ndarray) -> Weights:
        fit = LocalFit(self, x)
        return self._matrix_of(fit.near, fit.coefficient_weights(1)[:, 0])

    def _gradient_weight_rows(self, x: np.ndarray) -> tuple[Weights, ...]:
        fit = LocalFit(self, x)
        gradients = self._frame.gradient(fit.gradient_weights())
        return tuple(self._matrix_of(fit.near, g) for g in np.moveaxis(gradients, -1, 0))

    def _weight_chunk_rows(self) -> int:
        return self._chunk_rows(1)

    def _matrix_of(self, near: Neighborhood, a: np.ndarray) -> Weights:
        if not self.search.local:
            return a
        keep = ~near.missing
        pointer = np.concatenate([[0], np.cumsum(keep.sum(axis=1))])
        shape = (len(a), len(self.points))
        matrix = sparse.csr_array((a[keep], near.index[keep], pointer), shape=shape)
        matrix.sort_indices()
        return matrix

    def _order(self, x: np.ndarray) -> np.ndarray | None:
        return by_cells(x) if self.search.local else None

    def _chunk_rows(self, columns: int) -> int:
        q = dimension(self.points.shape[1], self.degree)
        k = self.search.typical_size()
        numbers = k * (2 * q + 4 * self.points.shape[1] + columns + 6) + 2 * q * q
        # Half a chunk of memory stays with the process. More is given back to the system after each
        # chunk, and taken again for the next, which takes as long as the fits.
        return rows_of(2 * 8 * numbers)
