"""The system of augmented interpolation with a sparse positive definite kernel matrix.

A has a sparse factor of its own, and with P = Q R the polynomial follows from the small system

    Q^T A^-1 Q (R c) = Q^T A^-1 f - R^-T g,    lambda = A^-1 (f - P c).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg import LinAlgError, cho_factor, cho_solve, qr, solve_triangular
from scipy.sparse.linalg import splu

from fieldrecon._blas import blas_threads_for
from fieldrecon._saddle import SaddlePoint

_COLUMNS = 64  # right-hand sides at once


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


def entries_of_factor(entries: int, n: int, d: int) -> float:
    """About how many numbers the factors of a sparse matrix of n sites in d variables hold.

    By dissection: n log n in the plane, n^(2 - 2/d) in space, times the neighbours of a site.
    """
    return entries * max(math.log2(n + 1), 2 * n ** (1 - 2 / d))
