"""Principal axes of many symmetric 3 x 3 matrices at once, by rotations of Jacobi.

A rotation in the plane of two axes makes the entry between them zero. After a few rounds of the
three planes all three are zero to rounding; small eigenvalues beside large ones keep their digits.
"""

from __future__ import annotations

import numpy as np

from fieldrecon.polynomials import EPS

_PLANES = ((0, 1), (0, 2), (1, 2))
_ROUNDS = 12  # three or four do for covariances of neighbours


def principal_axes(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues (3, m), from small to large, and unit eigenvectors (3, 3, m), the k-th at [k].

    Of positive semidefinite matrices (3, 3, m). Each entry is a contiguous array, and each step is
    made for all matrices at once.

    References
    ----------
    Golub and Van Loan (2013), section 8.5; Demmel and Veselic (1992).
    """
    a = matrices.copy()
    axes = np.zeros_like(a)
    axes[range(3), range(3)] = 1.0
    for _ in range(_ROUNDS):
        for i, j in _PLANES:
            _rotate(a, axes, i, j)
        if all(_is_zero(a, i, j) for i, j in _PLANES):
            break
    values = a[range(3), range(3)]
    order = values.argsort(axis=0)
    return (
        np.take_along_axis(values, order, axis=0),
        np.take_along_axis(axes, order[:, None], axis=0),
    )


def _rotate(a: np.ndarray, axes: np.ndarray, i: int, j: int) -> None:
    """Make a_ij zero, in place, by the smaller of the two angles that do."""
    k, double = 3 - i - j, 2 * a[i, j]
    gap = a[j, j] - a[i, i]
    size = np.abs(gap) + np.hypot(gap, double)
    tangent = np.where(gap < 0, -double, double)
    tangent /= np.where(size > 0, size, 1.0)
    cosine = 1 / np.sqrt(1 + tangent**2)
    sine = tangent * cosine
    a[i, i] -= tangent * a[i, j]
    a[j, j] += tangent * a[i, j]
    a[i, j] = a[j, i] = 0.0
    a[i, k], a[j, k] = _turned(a[i, k], a[j, k], cosine, sine)
    a[k, i], a[k, j] = a[i, k], a[j, k]
    axes[i], axes[j] = _turned(axes[i], axes[j], cosine, sine)


def _turned(
    x: np.ndarray, y: np.ndarray, cosine: np.ndarray, sine: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    return cosine * x - sine * y, sine * x + cosine * y


def _is_zero(a: np.ndarray, i: int, j: int) -> bool:
    return bool((a[i, j] ** 2 <= EPS**2 * np.abs(a[i, i] * a[j, j])).all())
