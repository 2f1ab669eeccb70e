"""The symmetric indefinite system of augmented interpolation, factored on the null space of P^T.

    [ A   P ] [lambda]   [f]
    [ P^T 0 ] [  c   ] = [g]

A is positive definite only where P^T lambda = 0. With P = Q_1 R and Q = [Q_1 Z] the block Z^T A Z
is positive definite and has a Cholesky factor: half the work of LU, and a proof of definiteness.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import LinAlgError, lapack, solve_triangular
from scipy.linalg.blas import dsymm, dsyr2k

from fieldrecon._blas import blas_threads_for


class SaddlePoint:
    """Factored system; of `a` (n, n), Fortran-contiguous, the lower triangle is overwritten.

    Raises
    ------
    numpy.linalg.LinAlgError
        If Z^T A Z is singular in floating-point numbers.
    """

    def __init__(self, a: np.ndarray, p: np.ndarray) -> None:
        with blas_threads_for(len(a) ** 3 / 3):
            self._make(a, p)

    def _make(self, a: np.ndarray, p: np.ndarray) -> None:
        q = p.shape[1]
        self._q = q
        self._v, self._t, self._r = _compact_wy(p)
        if q:
            _rotate(a, self._v, self._t)
            # lower triangle of Q^T A Q: the leading block and what couples it to the null space
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
        rotated = self._rotated_back(f, transpose=True)
        head = rotated[:q].copy()
        first = np.zeros_like(head) if g is None else self._triangular(g, "T")
        rotated[:q] = 0.0
        if g is not None and q:
            rotated[q:] -= self._a21 @ first
        y = self._null_space_solve(rotated)
        y[:q] = first
        if not q:
            return y, head
        c = self._triangular(head - self._a11 @ first - self._a21.T @ y[q:])
        return self._rotated_back(y, transpose=False), c

    def __len__(self) -> int:
        return len(self._factor)

    def _triangular(self, g: np.ndarray, trans: str = "N") -> np.ndarray:
        # what is not finite comes out not finite, and is told by the caller
        return solve_triangular(self._r, g, trans=trans, check_finite=False)

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
    """Cholesky factor; where rounding has spoilt definiteness, Bunch and Kaufman's L D L^T."""
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
