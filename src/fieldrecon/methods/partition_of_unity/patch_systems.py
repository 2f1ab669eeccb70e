"""The interpolation problems of many patches at once, each in its own frame.

    [ A + diag(smoothing)   P ] [lambda]   [f]
    [ P^T                   0 ] [  c   ] = [0]

In its frame, the sites of a patch lie within distance one of its centre. If they do not determine
its polynomials, or barely do, P is an orthonormal basis of those that they determine: of each
degree modulo the lower ones, so that a lower degree stays whole. For sites in a plane these are the
polynomials in the plane, constant along its normal.
"""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import cached_property, partial, reduce
from operator import iadd

import numpy as np

from fieldrecon._core.chunks import Progress, chunked, rows_of
from fieldrecon._core.validation import format_point, quiet_evaluate
from fieldrecon._numerics.jets import upper_pairs
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.derivatives import second_derivatives, smoothness
from fieldrecon.methods.partition_of_unity.ball_weights import COVERED, weights_of_balls
from fieldrecon.methods.partition_of_unity.batched_systems import (
    COLUMNS,
    batched_solve_grouped,
    solved,
)
from fieldrecon.methods.partition_of_unity.polynomial_rank import whole_degrees
from fieldrecon.methods.solvability import TOLERATED_MISS, too_flat
from fieldrecon.polynomials import (
    Frame,
    dimension,
    monomial_gradients,
    monomial_hessians,
    monomials,
)

MOST_LEVERAGE = 1 - 1e-4
"""Leverage of a site up to which the other sites of its patch determine the polynomial."""


@dataclass(frozen=True)
class Problem:
    """An interpolation problem, in units of the cloud's size.

    Attributes
    ----------
    kernel : Radial
        Kernel.
    degree : int
        Degree of the polynomials.
    smoothing : (n,) ndarray
        Added to the diagonal: that of each site.
    rounding : float
        Rounding of the coordinates of the sites.
    frame : Frame
        The frame of the sites, in which errors do not name points.
    """

    kernel: Radial
    degree: int
    smoothing: np.ndarray
    rounding: float
    frame: Frame


@dataclass(frozen=True)
class PatchSystems:
    """Interpolation systems of patches with k sites each.

    Attributes
    ----------
    points : (n, d) ndarray
        All sites.
    sites : (p, k) ndarray
        The sites of each patch.
    problem : Problem
        Kernel, degree and smoothing.
    origin : (p, d) ndarray
        Centre of the monomials of each patch: the mean of its sites.
    radius : (p,) ndarray
        Unit of length of each patch.
    centers, radii : (p, d) and (p,) ndarray
        The balls of the patches.
    bases : dict
        For patches that do not determine their polynomials, or barely do, the `orthonormal_basis`
        (q, q) of those that they determine.
    """

    points: np.ndarray
    sites: np.ndarray
    problem: Problem
    origin: np.ndarray
    radius: np.ndarray
    centers: np.ndarray
    radii: np.ndarray
    bases: dict[int, np.ndarray] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.sites)

    @property
    def degree(self) -> int:
        """Degree of the polynomials."""
        return self.problem.degree

    def rows(self, columns: int = 0) -> int:
        """Number of patches of one chunk."""
        return rows_of(8 * self.size * (3 * self.size + 2 * columns))

    @property
    def size(self) -> int:
        """Number of coefficients, k + q."""
        return self.sites.shape[1] + dimension(self.points.shape[1], self.degree)

    def frames(self, patch: np.ndarray) -> np.ndarray:
        """Sites (p, k, d) of patches (p,) in their frames."""
        return self._offsets(patch[:, None], self.points[self.sites[patch]])

    def _offsets(self, patch: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Points x (..., d) in the frames of patches (...)."""
        return (x - self.origin[patch]) / self.radius[patch][..., None]

    def matrices(self, patch: np.ndarray) -> np.ndarray:
        """Matrices (p, k + q, k + q) of the patches."""
        k = self.sites.shape[1]
        q = self.size - k
        matrix = np.zeros((len(patch), k + q, k + q))
        y = self._coordinates[:, patch]
        matrix[:, :k, :k] = self._kernel(patch, (a[..., None] - a[:, None] for a in y))
        matrix[:, range(k), range(k)] += self._smoothing(patch)
        basis = monomials(self.frames(patch), self.degree)
        for i, own in self._bases_among(patch):
            basis[i] = basis[i] @ own
            matrix[i, range(k, k + q), range(k, k + q)] = ~own.any(axis=0)
        matrix[:, :k, k:] = basis
        matrix[:, k:, :k] = basis.mT
        return matrix

    def fitted(
        self,
        values: np.ndarray,
        finest: bool,
        executor: Executor | None,
        progress: Progress | None,
    ) -> np.ndarray:
        """Coefficients (p, k + q, v) of all patches for the data (n, v) of all sites.

        Patches of the finest level must take their data; the share of the other levels is zero at
        each site.
        """
        found = np.empty((len(self), self.size, values.shape[1]), dtype=values.dtype)
        work = partial(quiet_evaluate, self.coefficients, values, finest)
        rows = self.rows(values.shape[1])
        for part, some in chunked(work, np.arange(len(self)), rows, executor, progress):
            found[part] = some
        return found

    def coefficients(self, values: np.ndarray, finest: bool, patch: np.ndarray) -> np.ndarray:
        """Coefficients (p, k + q, v) of patches (p,) for the data (n, v) of all sites."""
        found, miss = self._interpolants(values, patch)
        if finest:
            self._refuse_a_miss(patch, miss)
        k = self.sites.shape[1]
        for i, own in self._bases_among(patch):
            found[i, k:] = own @ found[i, k:]
        return found

    def _interpolants(self, values: np.ndarray, patch: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients (p, k + q, v) in the bases of patches (p,), and their relative errors."""
        matrix = self.matrices(patch)
        data = values[self.sites[patch]]
        k = data.shape[1]
        right = np.zeros((len(patch), self.size, data.shape[2]), dtype=data.dtype)
        right[:, :k] = data
        found = solved(matrix, right, k)
        if np.isinf(self.radii[patch]).any():
            # Far away, what is left of P^T lambda would be multiplied by large kernels.
            found += solved(matrix, right - matrix @ found, k)
        return found, relative_miss(matrix, found, right)[:, :k]

    def rough_miss(self, signs: np.ndarray) -> float:
        """Largest error by rounding of the blended fields of signs (n, v) at their data."""
        work = partial(quiet_evaluate, self._rough_misses, signs)
        parts = chunked(work, np.arange(len(self)), self.rows(signs.shape[1]))
        return max((float(misses.max()) for _, misses in parts), default=0.0)

    def _rough_misses(self, signs: np.ndarray, patch: np.ndarray) -> np.ndarray:
        """Errors (p, k, v) at the data of patches (p,), as far as the blended fields have them."""
        _, miss = self._interpolants(signs, patch)
        return self._largest_shares(patch)[..., None] * miss

    def values(self, patch: np.ndarray, x: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        """Values (p, v) at points x (p, d), for the coefficients of all patches."""
        return np.einsum("ps,psv->pv", self.basis(patch, x), coefficients[patch])

    def gradients(self, patch: np.ndarray, x: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        """Gradients (p, v, d) at points x (p, d)."""
        return np.einsum("psd,psv->pvd", self.basis_gradient(patch, x), coefficients[patch])

    def second_derivatives(
        self, patch: np.ndarray, x: np.ndarray, coefficients: np.ndarray
    ) -> np.ndarray:
        """Second derivatives (d (d + 1)/2, p, v) at points x (p, d), in the order of a jet."""
        k, d = self.sites.shape[1], x.shape[1]
        unit = self._unit(patch)[:, None]
        y = self._from_sites(patch, x) * unit
        self._refuse_sites(np.einsum("apk,apk->pk", y, y), 2)
        of_kernels = second_derivatives(self.problem.kernel, list(y))
        of_basis = monomial_hessians(self._offsets(patch, x), self.degree)
        lam, c = coefficients[patch, :k], coefficients[patch, k:]
        return np.stack(
            [
                (
                    np.einsum("pk,pkv->pv", entry * unit**2, lam)
                    + np.einsum("pq,pqv->pv", of_basis[..., i, j], c)
                )
                / self.radius[patch, None] ** 2
                for entry, (i, j) in zip(of_kernels, upper_pairs(d), strict=True)
            ]
        )

    def of_data(self, patch: np.ndarray, terms: np.ndarray) -> np.ndarray:
        """Sums t^T c of coefficients, t (p, k + q), as weights (p, k) of their data.

        Since the systems are symmetric, the weights solve S w = t. This is more accurate than
        t^T S^-1, whose rows are large where sites are close.
        """
        k, rows = self.sites.shape[1], self.rows(COLUMNS)
        return batched_solve_grouped(self._solved_for_data, patch, terms, k, rows)

    def adjoint(
        self, moments: np.ndarray, executor: Executor | None, progress: Progress | None
    ) -> np.ndarray:
        """C^T m (p, k, v) of moments (p, k + q, v), without forming C."""
        result = np.empty((len(self), self.sites.shape[1], moments.shape[2]), dtype=moments.dtype)
        work = partial(quiet_evaluate, self._adjoint, moments)
        rows = self.rows(moments.shape[2])
        for part, some in chunked(work, np.arange(len(self)), rows, executor, progress):
            result[part] = some
        return result

    def _adjoint(self, moments: np.ndarray, patch: np.ndarray) -> np.ndarray:
        return self._solved_for_data(patch, moments[patch])

    def _solved_for_data(self, patch: np.ndarray, right: np.ndarray) -> np.ndarray:
        """The first k rows (p, k, v) of the solutions of the transposed systems."""
        k = self.sites.shape[1]
        for i, own in self._bases_among(patch):
            right[i, k:] = own.T @ right[i, k:]
        return solved(self.matrices(patch), right, k)[:, :k]

    def basis(self, patch: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Kernels and monomials (p, k + q) of the patches (p,) at points x (p, d)."""
        b = np.empty((len(patch), self.size))
        k = self.sites.shape[1]
        b[:, :k] = self._kernel(patch, self._from_sites(patch, x))
        b[:, k:] = monomials(self._offsets(patch, x), self.degree)
        return b

    def basis_gradient(self, patch: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Gradients (p, k + q, d) of kernels and monomials by x."""
        g = np.empty((len(patch), self.size, x.shape[1]))
        k, unit = self.sites.shape[1], self._unit(patch)[:, None]
        y = self._from_sites(patch, x)
        squared = np.einsum("apk,apk->pk", y, y) * unit**2
        self._refuse_sites(squared, 1)
        slope = self.problem.kernel.slope_of_squared(squared) * unit**2
        g[:, :k] = np.moveaxis(slope * y, 0, 2)
        g[:, k:] = monomial_gradients(self._offsets(patch, x), self.degree)
        return g / self.radius[patch, None, None]

    def _refuse_sites(self, squared: np.ndarray, order: int) -> None:
        """Refuse points at distances of zero, where the kernel has no derivatives of the order."""
        kernel = self.problem.kernel
        smooth = kernel.differentiable if order == 1 else smoothness(kernel) >= order
        if not smooth and (squared == 0).any():
            what = "gradient" if order == 1 else "second derivatives"
            raise ValueError(
                f"{kernel!r} has no {what} at a site, and some of the queries are sites"
            )

    def least_degree(self) -> int:
        """Highest degree up to which every patch reproduces all polynomials."""
        if not self.bases:
            return self.degree
        return whole_degrees(np.stack([*self.bases.values()]), self.points.shape[1], self.degree)

    @property
    def reduced(self) -> int:
        """Number of patches that do not determine all of their polynomials."""
        return sum(not own.any(axis=0).all() for own in self.bases.values())

    def _bases_among(self, patch: np.ndarray) -> list[tuple[int, np.ndarray]]:
        if not self.bases:
            return []
        return [(i, self.bases[j]) for i, j in enumerate(patch.tolist()) if j in self.bases]

    def _from_sites(self, patch: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Vectors (d, p, k), by axis, from the sites of patches (p,) to points x (p, d)."""
        y = self._coordinates[:, patch]
        return np.subtract(self._offsets(patch, x).T[:, :, None], y, out=y)

    def _kernel(self, patch: np.ndarray, y: Iterable[np.ndarray]) -> np.ndarray:
        """Kernel (p, ...) of the differences y (p, ...) of each axis, which are overwritten.

        The axes come one by one: in many variables, all together would not fit into memory.
        """
        unit = None if self._is_homogeneous else self.radius[patch]
        return self.problem.kernel.of_squared(reduce(iadd, (_squared(a, unit) for a in y)))

    @cached_property
    def _coordinates(self) -> np.ndarray:
        """Sites of all patches in their frames, by axis (d, p, k), contiguous for each patch."""
        local = self.frames(np.arange(len(self)))
        return np.ascontiguousarray(np.moveaxis(local, 2, 0))

    def _smoothing(self, patch: np.ndarray) -> np.ndarray:
        """Smoothing (p, k) of the sites of patches (p,), in the unit of their kernel."""
        unit = (self._unit(patch) / self.radius[patch]) ** self.problem.kernel.homogeneity
        return self.problem.smoothing[self.sites[patch]] * unit[:, None]

    def _unit(self, patch: np.ndarray) -> np.ndarray:
        """Unit of length of the kernel in each patch."""
        return np.ones(len(patch)) if self._is_homogeneous else self.radius[patch]

    @cached_property
    def _is_homogeneous(self) -> bool:
        """Whether a change of unit only multiplies the kernel by a factor, up to polynomials."""
        return self.problem.kernel.in_units(2.0) is self.problem.kernel

    def _refuse_a_miss(self, patch: np.ndarray, relative: np.ndarray) -> None:
        """Refuse errors (p, k, v) at the data of patches (p,) that the blended field would have."""
        wrong = np.flatnonzero((relative > TOLERATED_MISS).any(axis=(1, 2)))
        if not len(wrong):
            return
        error = (self._largest_shares(patch[wrong]) * relative[wrong].max(axis=2)).max(axis=1)
        if error.max() > TOLERATED_MISS:
            origin = self.origin[patch[wrong[np.argmax(error)]]]
            where = format_point(self.problem.frame.point(origin))
            raise too_flat(f"the field of the patch about ({where})", error.max())

    def _largest_shares(self, patch: np.ndarray) -> np.ndarray:
        """Bounds (p, k) of the shares of patches (p,) in the blended field at their sites."""
        x = self.points[self.sites[patch]]
        weight = weights_of_balls(self.centers[patch], self.radii[patch], x)
        return np.minimum(weight / COVERED, 1.0)


def relative_miss(matrix: np.ndarray, found: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Residuals (p, s, v) of solutions, relative to the right-hand sides of their systems.

    Raises
    ------
    OverflowError
        If they are not finite.
    """
    size = np.abs(right).max(axis=1, keepdims=True)
    relative = np.abs(matrix @ found - right) / np.where(size > 0, size, 1.0)
    if not np.isfinite(relative).all():
        raise OverflowError(
            "the coefficients of a patch exceed the range of floating-point numbers; choose a unit "
            f"nearer to the size of the data, {size.max():.0e}"
        )
    return relative


def _squared(y: np.ndarray, unit: np.ndarray | None) -> np.ndarray:
    if unit is not None:
        y *= _per_patch(unit, y)
    y *= y
    return y


def _per_patch(factor: np.ndarray, like: np.ndarray) -> np.ndarray:
    """Factors (p,) as an array that multiplies one of shape (p, ...)."""
    return factor.reshape(len(factor), *(1 for _ in like.shape[1:]))
