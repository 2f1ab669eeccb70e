"""Radial basis functions augmented by polynomials."""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import Executor
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, report_all, rows_of, split_progress
from fieldrecon._numerics.far_queries import loses_constants
from fieldrecon._numerics.jets import symmetric, upper_pairs
from fieldrecon.kernels.base import Radial
from fieldrecon.methods.kernel_matrices import Block, dense, pairs_of
from fieldrecon.methods.least_squares import LeastSquares, monomial_matrix
from fieldrecon.methods.metric import as_metric, frame_of
from fieldrecon.methods.solvability import (
    INTERPOLATED,
    as_augmentation,
    as_finite,
    as_kernel,
    as_smoothing,
    miss_of_rough_data,
    refuse_a_miss,
    refuse_duplicates,
    refuse_lost_weights,
    refuse_no_hessian,
    refuse_sites,
    unit_smoothing,
)
from fieldrecon.polynomials import (
    dimension,
    monomial_gradients,
    monomial_hessians,
    monomial_laplacians,
    monomials,
    powers_of_scale,
    refuse_too_few,
    require_unisolvent,
)
from fieldrecon.reconstruction import Reconstruction


class RBF(Reconstruction):
    """Augmented radial basis functions, f(x) = b(x)^T c + sum_j lambda_j phi(|x - p_j|).

    Interpolation f(p_i) = f_i with the side conditions sum_j lambda_j b(p_j) = 0 gives a symmetric
    indefinite system. It has a unique solution if the points are distinct and no polynomial of the
    degree vanishes on them; it is factored by Cholesky on the null space of the side conditions.

    Parameters
    ----------
    points : (n, d) array_like
        Sites, distinct unless there is smoothing.
    kernel : Radial
        Kernel phi, for instance `thin_plate_spline()`.
    degree : int, optional
        Degree of the polynomial; `kernel.order - 1` by default, and no less. -1 for none.
    smoothing : float or (n,) array_like
        Added to the diagonal, all of it or datum by datum: the field minimizes
        sum_i (f(p_i) - f_i)^2 / smoothing_i + energy. See the notes for the unit.
    metric : (d,) or (d, d) array_like, optional
        Distances other than the Euclidean one: scales of the coordinates, for which it is
        sqrt(sum_k ((x_k - y_k) / scale_k)^2), or a symmetric positive definite matrix M, for which
        it is sqrt((x - y)^T M (x - y)). Lengths of the kernel are such distances.
    executor : concurrent.futures.Executor, optional
        Computes the entries of the system in chunks; this machine's threads by default.
    progress : callable, optional
        Called as progress(done, total) with numbers of sites; the factorization is the second half.

    Attributes
    ----------
    interpolates : bool
        False with smoothing, and where the kernel is so flat for sites this close that rounding
        makes the fields of some data miss them by more than 1e-6 of their size. Smooth data are
        met more closely than rough ones.

    Raises
    ------
    ValueError
        If points coincide, or an argument has the wrong form.
    numpy.linalg.LinAlgError
        If the points do not determine the polynomial, the kernel is too flat for them, or the
        metric is not positive definite; later, if the kernel is too flat for the data, so that
        rounding would make the field miss them. Weights, gradient weights and the adjoint do not
        know the data, and are refused if the field of independent random signs would miss them.
    MemoryError
        If the system would not fit into this machine's memory.

    Notes
    -----
    The smoothing of a datum is its variance, in units of the kernel: for data with independent
    errors of variance tau_i^2 and a random field with the covariance sigma^2 phi, the field with
    smoothing_i = tau_i^2 / sigma^2 is the mean of the Gaussian process given the data, or universal
    kriging if there is a polynomial. Like phi it has the dimension of a length to the power of
    `kernel.homogeneity`: length^3 for r^3, none for a kernel with a scale. A datum with zero is
    interpolated, one with a large number has no influence. Of sites that coincide, at most one may
    have zero.

    References
    ----------
    Erleben, Field Reconstruction, p. 11-13 (whose matrix is indefinite, not positive definite);
    Wendland (2005), theorem 8.21; Rasmussen and Williams, Gaussian Processes for Machine Learning
    (2006), sections 2.2 and 2.7.

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> points = fr.datasets.halton(200, 2)
    >>> s = RBF(points, fr.thin_plate_spline()).field(fr.datasets.franke(points))
    >>> bool(abs(s([0.5, 0.5]) - fr.datasets.franke([0.5, 0.5])) < 1e-3)
    True
    """

    _each_site = ("smoothing",)

    def __init__(
        self,
        points: ArrayLike,
        kernel: Radial,
        degree: int | None = None,
        smoothing: ArrayLike = 0.0,
        *,
        metric: ArrayLike | None = None,
        executor: Executor | None = None,
        progress: Progress | None = None,
    ) -> None:
        self.points = valid.as_points(points)
        self.kernel = as_kernel(kernel, self.points.shape[1])
        self.degree = as_augmentation(degree, kernel)
        self.smoothing = as_smoothing(smoothing, len(self.points))
        self.metric = as_metric(metric, self.points.shape[1])
        self._frame = frame_of(self.points, self.metric)
        refuse_too_few(self.points, self.degree)
        p = self._basis(self.points)
        require_unisolvent(self.points, p, self.degree, self._frame.who)
        sites = self._frame.scaled(self.points)
        refuse_duplicates(sites, smoothing=self.smoothing)
        self._pairs = pairs_of(sites, as_finite(kernel.in_units(self._frame.scale)))
        each = unit_smoothing(self.smoothing, len(sites), kernel, self._frame.scale)
        entries = next(split_progress(progress, len(sites), 2))
        self._system = self._pairs.system(p, each, executor, entries)
        self._rough_miss = miss_of_rough_data(self._system, self._phi())
        self.interpolates = not np.any(self.smoothing) and self._rough_miss <= INTERPOLATED
        report_all(progress, len(sites))

    @valid.finite("the entries of H_RBF")
    def matrix(self) -> np.ndarray:
        """Matrix H_RBF of the notes, kernel bordered by polynomials, in the points' coordinates.

        Returns
        -------
        (n + q, n + q) ndarray
            Symmetric and indefinite: n positive and q negative eigenvalues.

        Raises
        ------
        OverflowError
            If its entries do not fit into floating-point numbers in this unit of length.
        """
        p = monomial_matrix(self.points, self.degree)
        n, q = p.shape
        self._refuse_if_too_large(n + q)
        self._require_squares("the matrix")
        h = np.zeros((n + q, n + q))
        sites = self._pairs.sites * self._frame.scale
        h[:n, :n] = self.kernel.of_squared(cdist(sites, sites, "sqeuclidean"))
        h[range(n), range(n)] += self.smoothing
        h[:n, n:], h[n:, :n] = p, p.T
        return h

    @valid.finite("the coefficients")
    def coefficients(self, values: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients (lambda, c) in the points' own coordinates.

        Parameters
        ----------
        values : (n, ...) array_like
            Data.

        Returns
        -------
        lambda : (n, ...) ndarray
            Coefficients of the kernels; orthogonal to the polynomials.
        c : (q, ...) ndarray
            Coefficients of the polynomial in the basis 1, x_1 ... x_d, then by total degree.

        Raises
        ------
        OverflowError
            If they do not fit into floating-point numbers in this unit of length.
        """
        values = valid.as_values(values, len(self.points))
        columns = values.reshape(len(values), -1)
        self._require_squares("the coefficients")
        power = np.array([-self.kernel.homogeneity])
        lam = self._prepare(columns)[0]
        lam = lam * powers_of_scale(self._frame.scale, power, "the coefficients")
        shape = values.shape[1:]
        if self.degree < 0:
            return lam.reshape((len(lam), *shape)), np.zeros((0, *shape))
        # The data minus the kernels is the polynomial; a change of unit of r^2 log r adds
        # to it, so it is computed here again.
        rest = columns - self._kernel_sum(lam) - (self.smoothing * lam.T).T
        c = LeastSquares(self.points, self.degree).coefficients(rest)
        return lam.reshape((len(lam), *shape)), c.reshape((len(c), *shape))

    def _leave_one_out(self, values: np.ndarray, progress: Progress | None) -> np.ndarray:  # noqa: ARG002
        """Residuals lambda_i / (H^-1)_ii (Rippa 1999)."""
        if self.degree >= 0:
            LeastSquares(self.points, self.degree).refuse_indispensable()
        return self._prepare(values)[0] / self.inverse_diagonal()[:, None]

    def inverse_diagonal(self) -> np.ndarray:
        """Diagonal (n,) of the inverse of H_RBF, up to the kernel's unit, for leave-one-out."""
        return self._system.inverse_diagonal()

    def _require_squares(self, what: str) -> None:
        powers_of_scale(self._frame.scale, np.array([2, self.kernel.homogeneity]), what)

    @cached_property
    def _site_tree(self) -> cKDTree:
        return cKDTree(self.points)

    @cached_property
    def _is_lossy(self) -> bool:
        return bool(valid.quiet_evaluate(loses_constants, self, self._system.solve))

    def _kernel_sum(self, lam: np.ndarray) -> np.ndarray:
        total, sites = np.zeros_like(lam), self._pairs.sites * self._frame.scale
        for part, values in type(self._pairs)(sites, self.kernel).values(sites):
            total += values @ lam[part]
        return total

    def _basis(self, x: np.ndarray) -> np.ndarray:
        return monomials(self._frame.local(x), self.degree)

    def _prepare(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        lam, c = self._system.solve(values)
        refuse_a_miss(lam, self._phi(), values)
        return lam, c

    def _phi(self) -> np.ndarray:
        """Values of the kernel in the unit frame at the smallest and the largest distance."""
        farthest = 2.0 * math.sqrt(self.points.shape[1])
        return self._pairs.kernel(np.array([0.0, farthest]))

    def _value_rows(self, x: np.ndarray, prepared: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        lam, c = prepared
        total = self._basis(x) @ c
        for part, values in self._pairs.values(self._frame.scaled(x)):
            total += values @ lam[part]
        return total

    def _gradient_rows(self, x: np.ndarray, prepared: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        lam, c = prepared
        total = np.einsum("mqd,qv->mvd", monomial_gradients(self._frame.local(x), self.degree), c)
        for part, slopes in self._gradients(x):
            for k, slope in enumerate(slopes):
                total[..., k] += slope @ lam[part]
        return self._frame.gradient(total)

    def _hessian_rows(self, x: np.ndarray, prepared: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        lam, c = prepared
        refuse_no_hessian(self.kernel, x, self._site_tree)
        entries = [
            np.zeros((len(x), lam.shape[1]), dtype=lam.dtype) for _ in upper_pairs(x.shape[1])
        ]
        for part, blocks in self._pairs.hessians(self._frame.scaled(x)):
            for entry, block in zip(entries, blocks, strict=True):
                entry += block @ lam[part]
        of_basis = monomial_hessians(self._frame.local(x), self.degree)
        total = symmetric(entries, x.shape[1]) + np.einsum("mqkl,qv->mvkl", of_basis, c)
        return self._frame.hessian(total)

    def _laplacian_rows(self, x: np.ndarray, prepared: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        if not self._frame.is_isotropic:
            return super()._laplacian_rows(x, prepared)
        lam, c = prepared
        refuse_no_hessian(self.kernel, x, self._site_tree)
        total = monomial_laplacians(self._frame.local(x), self.degree) @ c
        for part, values in self._pairs.laplacians(self._frame.scaled(x)):
            total += values @ lam[part]
        return total / self._frame.scale / self._frame.scale

    def _gradients(self, x: np.ndarray) -> Iterator[tuple[slice, tuple[Block, ...]]]:
        if not self.kernel.differentiable:
            refuse_sites(self.kernel, x, self._site_tree)
        return self._pairs.gradients(self._frame.scaled(x))

    def _weight_rows(self, x: np.ndarray) -> np.ndarray:
        right = np.empty((len(self.points), len(x)))
        for part, values in self._pairs.values(self._frame.scaled(x)):
            right[part] = dense(values).T
        return self._solved_rows(right, self._basis(x))

    def _gradient_weight_rows(self, x: np.ndarray) -> tuple[np.ndarray, ...]:
        right = np.empty((x.shape[1], len(self.points), len(x)))
        for part, slopes in self._gradients(x):
            for of_axis, slope in zip(right, slopes, strict=True):
                of_axis[part] = dense(slope).T
        of_basis = np.moveaxis(monomial_gradients(self._frame.local(x), self.degree), -1, 0)
        return self._frame.partials(
            tuple(self._solved_rows(f, g) for f, g in zip(right, of_basis, strict=True))
        )

    def _solved_rows(self, right: np.ndarray, of_basis: np.ndarray) -> np.ndarray:
        """Weights (m, n), contiguous for each query, from kernels (n, m) and basis (m, q)."""
        refuse_lost_weights(self._rough_miss)
        return np.ascontiguousarray(self._system.solve(right, of_basis.T)[0].T)

    def _weight_chunk_rows(self) -> int:
        return max(super()._weight_chunk_rows(), self._system.least_columns())

    def _moments(self, x: np.ndarray, f: np.ndarray) -> tuple[slice, np.ndarray]:
        moments = np.empty((self._number_of_moments(), f.shape[1]), dtype=f.dtype)
        n = len(self.points)
        for part, values in self._pairs.values(self._frame.scaled(x)):
            moments[:n][part] = values.T @ f
        moments[n:] = self._basis(x).T @ f
        return slice(None), moments

    def _number_of_moments(self) -> int:
        return len(self.points) + dimension(self.points.shape[1], self.degree)

    def _of_moments(self, moments: np.ndarray) -> np.ndarray:
        refuse_lost_weights(self._rough_miss)
        return self._system.solve(*np.split(moments, [len(self.points)]))[0]

    def _chunk_rows(self, columns: int) -> int:
        q = dimension(self.points.shape[1], self.degree)
        return rows_of(
            self._pairs.bytes_per_query() + 8 * (q + columns) * (self.points.shape[1] + 2)
        )
