"""The symmetric indefinite system of augmented interpolation, dense or sparse.

    [ A   P ] [lambda]   [f]
    [ P^T 0 ] [  c   ] = [g]

A is positive definite only where P^T lambda = 0. With P = Q_1 R and Q = [Q_1 Z] the block Z^T A Z
is positive definite and has a Cholesky factor: half the work of LU, and a proof of definiteness.

A sparse positive definite A has a factor of its own. With P = Q R, the polynomial then follows from
the small system

    Q^T A^-1 Q (R c) = Q^T A^-1 f - R^-T g,    lambda = A^-1 (f - P c).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg import LinAlgError, cho_factor, cho_solve, lapack, qr, solve_triangular
from scipy.linalg.blas import dsymm, dsyr2k
from scipy.sparse.linalg import splu

from fieldrecon._core.blas_threads import blas_threads_for

_COLUMNS = 64  # right-hand sides of a sparse system that are solved at once


class SaddlePoint:
    """Factored dense system; the lower triangle of `a` (n, n), Fortran-contiguous, is overwritten.

    With factors s (n,) its first n rows and columns are multiplied by them before it is factored.
    The rotation by Q would spread the rounding of a large diagonal entry over the whole matrix.

    Raises
    ------
    numpy.linalg.LinAlgError
        If Z^T A Z is singular in floating-point numbers.
    """

    def __init__(self, a: np.ndarray, p: np.ndarray, factors: np.ndarray | None = None) -> None:
        self._factors = np.ones((len(a), 1)) if factors is None else factors[:, None]
        if factors is not None:
            a *= self._factors
            a *= self._factors.T
        with blas_threads_for(len(a) ** 3 / 3):
            self._make(a, self._factors * p)

    def _make(self, a: np.ndarray, p: np.ndarray) -> None:
        q = p.shape[1]
        self._q = q
        self._v, self._t, self._r = _compact_wy(p)
        if q:
            _rotate(a, self._v, self._t)
            # lower triangle of Q^T A Q: the leading block, and its coupling to the null space
            self._a11 = np.tril(a[:q, :q]) + np.tril(a[:q, :q], -1).T
            self._a21 = a[q:, :q].copy()
            a[:q, :q] = np.eye(q)
            a[q:, :q] = 0.0
        self._factor, self._pivots = _factored(a)

    def solve(self, f: np.ndarray, g: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Solution lambda (n, v), c (q, v) for the right-hand sides f (n, v), g (q, v) or zero."""
        with blas_threads_for(2 * len(self) * f.size):
            return self._solved(f, g)

    def _solved(self, f: np.ndarray, g: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
        q = self._q
        rotated = self._rotated_back(self._factors * f, transpose=True)
        head = rotated[:q].copy()
        first = np.zeros_like(head) if g is None else self._triangular(g, "T")
        rotated[:q] = 0.0
        if g is not None and q:
            rotated[q:] -= self._a21 @ first
        y = self._null_space_solve(rotated)
        y[:q] = first
        if not q:
            return self._factors * y, head
        c = self._triangular(head - self._a11 @ first - self._a21.T @ y[q:])
        return self._factors * self._rotated_back(y, transpose=False), c

    def __len__(self) -> int:
        return len(self._factor)

    def _triangular(self, g: np.ndarray, trans: str = "N") -> np.ndarray:
        # values that are not finite stay so, and the caller reports them
        return solve_triangular(self._r, g, trans=trans, check_finite=False)

    def least_columns(self) -> int:
        """Number of right-hand sides below which reading the factor takes most of the time.

        It is a small part of n, so that their arrays are small beside the factor.
        """
        return len(self) // 64

    def inverse_diagonal(self) -> np.ndarray:
        """Diagonal (n,) of the leading block of the inverse, Z (Z^T A Z)^-1 Z^T."""
        n = len(self)
        diagonal = np.empty(n)
        for start in range(0, n, 512):
            rows = np.arange(start, min(start + 512, n))
            unit = np.zeros((n, len(rows)))
            unit[rows, range(len(rows))] = 1.0
            diagonal[rows] = self.solve(unit)[0][rows, range(len(rows))]
        return diagonal

    def _rotated_back(self, x: np.ndarray, transpose: bool) -> np.ndarray:
        """Q^T x, or Q x, with Q = I - V T V^T."""
        t = self._t.T if transpose else self._t
        return x - self._v @ (t @ (self._v.T @ x))

    def _null_space_solve(self, f: np.ndarray) -> np.ndarray:
        if np.iscomplexobj(f):
            return self._null_space_solve(f.real) + 1j * self._null_space_solve(f.imag)
        if self._pivots is None:
            return lapack.dpotrs(self._factor, f, lower=1)[0]
        return lapack.dsytrs(self._factor, self._pivots, f, lower=1)[0]


class SparseSaddlePoint(SaddlePoint):
    """Factored system of `a` (n, n), sparse and positive definite, bordered by `p` (n, q).

    Raises
    ------
    numpy.linalg.LinAlgError
        If a pivot vanishes.
    """

    def __init__(self, a: sparse.csc_array, p: np.ndarray) -> None:
        self._a, self._p = a, p
        self._factor_all()

    def solve(self, f: np.ndarray, g: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Solution lambda (n, v), c (q, v) for the right-hand sides f (n, v), g (q, v) or zero."""
        y = self._inverse(f)
        right = self._q_of_p.T @ y
        if g is not None:
            right = right - solve_triangular(self._r, g, trans="T", check_finite=False)
        if not self._p.shape[1]:
            return y, right
        rc = cho_solve(self._small, right, check_finite=False)
        return y - self._inverse_q @ rc, solve_triangular(self._r, rc, check_finite=False)

    def least_columns(self) -> int:
        """Number of right-hand sides below which reading the factor takes most of the time."""
        return min(_COLUMNS, super().least_columns())

    def __len__(self) -> int:
        return len(self._p)

    def __getstate__(self) -> dict[str, Any]:
        return {"_a": self._a, "_p": self._p}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._factor_all()

    def _factor_all(self) -> None:
        try:
            # without pivoting, as befits a definite matrix
            self._lu = splu(
                self._a, "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError as error:
            raise LinAlgError(
                "the kernel matrix is singular in floating-point numbers: sites are too close for "
                "this radius; choose a smaller one, a rougher kernel or some smoothing"
            ) from error
        with blas_threads_for(2 * self._p.size * self._p.shape[1]):
            self._q_of_p, self._r = qr(self._p, mode="economic")
        self._inverse_q = self._inverse(self._q_of_p)
        self._small = cho_factor(self._q_of_p.T @ self._inverse_q)

    def _inverse(self, f: np.ndarray) -> np.ndarray:
        if np.iscomplexobj(f):
            return self._inverse(f.real) + 1j * self._inverse(f.imag)
        result = np.empty(f.shape)
        for start in range(0, f.shape[1], _COLUMNS):
            part = slice(start, start + _COLUMNS)
            result[:, part] = self._lu.solve(np.ascontiguousarray(f[:, part]))
        return result


def balancing(diagonal: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Powers of two s (..., n) for which no s_i^2 A_ii exceeds the size of A much.

    The size of A is the largest entry of its first column (..., n - 1) below the diagonal
    (..., n), or the smallest entry of the diagonal. Diagonal entries with a large smoothing are
    scaled to this size; the other rows and columns stay as they are.
    """
    diagonal = np.abs(diagonal)
    size = np.maximum(np.abs(column).max(axis=-1, initial=0.0), diagonal.min(axis=-1))[..., None]
    ratio = diagonal / np.where(size > 0, size, np.inf)
    return np.exp2(-np.ceil(np.log2(np.maximum(ratio, 1.0)) / 2))


def entries_of_factor(entries: int, n: int, d: int) -> float:
    """Estimate of the number of entries in the factors of a sparse matrix of n sites in R^d.

    By nested dissection: n log n in the plane, n^(2 - 2/d) in space, times the neighbours per site.
    """
    return entries * max(math.log2(n + 1), 2 * n ** (1 - 2 / d))


def _compact_wy(p: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Householder factors of P: Q = I - V T V^T and R, with V (n, q) unit lower trapezoidal."""
    n, q = p.shape
    if q == 0:
        return np.zeros((n, 0)), np.zeros((0, 0)), np.zeros((0, 0))
    packed, tau, _, _ = lapack.dgeqrf(p)
    v = np.tril(packed, -1)
    v[range(q), range(q)] = 1.0
    t = np.zeros((q, q))
    for j in range(q):
        t[:j, j] = -tau[j] * (t[:j, :j] @ (v[:, :j].T @ v[:, j]))
        t[j, j] = tau[j]
    return v, t, np.triu(packed[:q])


def _rotate(a: np.ndarray, v: np.ndarray, t: np.ndarray) -> None:
    """Lower triangle of A <- Q^T A Q in place, a symmetric update of rank 2q: A - Y V^T - V Y^T."""
    w = dsymm(1.0, a, np.asfortranarray(v), lower=1) @ t
    y = w - v @ (t.T @ (v.T @ w)) / 2
    dsyr2k(-1.0, np.asfortranarray(y), np.asfortranarray(v), beta=1.0, c=a, lower=1, overwrite_c=1)


def _factored(a: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """Cholesky factor, or Bunch and Kaufman's L D L^T where rounding has spoilt definiteness."""
    scale = np.abs(np.diagonal(a)).max()
    kept = a.copy(order="F") if len(a) <= 4000 else None
    factor, info = lapack.dpotrf(a, lower=1, overwrite_a=1, clean=0)
    if info == 0:
        return factor, None
    if kept is not None:
        factor, pivots, info = lapack.dsytrf(kept, lower=1, overwrite_a=1)
        if info == 0 and np.abs(np.diagonal(factor)).min() > 0:
            return factor, pivots
    raise LinAlgError(
        "the kernel matrix is not positive definite in floating-point numbers (its entries are of "
        f"size {scale:.1e}): the kernel is too flat for sites this close; choose a smaller "
        "scale, a rougher kernel or some smoothing"
    )
