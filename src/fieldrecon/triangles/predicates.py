"""Exact geometric predicates: the signs of determinants of many points.

The sign of a determinant is taken from floating-point arithmetic if its value exceeds a bound of
the rounding error. The few others are computed again in integers, since floating-point numbers
are integers times a power of two.

References
----------
Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates (1997).
"""

from __future__ import annotations

import numpy as np

_EPS = np.finfo(float).eps
BOUND_2D = 2 * _EPS
"""Rounding error of a determinant of two differences over the sum of its absolute terms."""
BOUND_3D = 4 * _EPS
"""The same of three differences."""


def orient2d(a: np.ndarray, b: np.ndarray, c: np.ndarray, *, tolerance: float = 0.0) -> np.ndarray:
    """Sign of det(b - a, c - a): 1 where a, b, c (k, 2) turn anticlockwise, -1 clockwise, else 0.

    It is also 0 if a displacement of the points by the tolerance could make it so.
    """
    u, v = b - a, c - a
    left, right = u[:, 0] * v[:, 1], u[:, 1] * v[:, 0]
    bound = BOUND_2D * (np.abs(left) + np.abs(right))
    slack = tolerance * (_length(u) + _length(v) + _length(v - u)) if tolerance else 0.0
    return _signs(left - right, bound, (a, b, c), slack)


def orient3d(
    a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray, *, tolerance: float = 0.0
) -> np.ndarray:
    """Sign of det(b - a, c - a, d - a): 1 where d lies where the normal of a, b, c (k, 3) points.

    It is also the sign of the side on which the line a b passes the line c d. It is also 0 if a
    displacement of the points by the tolerance could make it so: the determinant changes by the
    tolerance times the areas of the faces of the tetrahedron.
    """
    u, v, w = b - a, c - a, d - a
    normal, terms = cross_with_terms(u, v)
    value = np.einsum("ki,ki->k", normal, w)
    bound = BOUND_3D * np.einsum("ki,ki->k", terms, np.abs(w))
    slack: np.ndarray | float = 0.0
    if tolerance:
        sides = (np.cross(u, w), np.cross(v, w), np.cross(v - u, w - u))
        slack = tolerance * sum(map(_length, sides), start=_length(normal))
    return _signs(value, bound, (a, b, c, d), slack)


def collinear(a: np.ndarray, b: np.ndarray, c: np.ndarray, *, tolerance: float = 0.0) -> np.ndarray:
    """Whether points (k, 3) lie on one line, or could if displaced by the tolerance.

    Points are collinear if and only if their projections along all three axes are.
    """
    u, v = b - a, c - a
    normal, terms = cross_with_terms(u, v)
    flat = _length(normal) <= tolerance * (_length(u) + _length(v) + _length(v - u))
    uncertain = np.flatnonzero((np.abs(normal) <= BOUND_2D * terms).all(axis=1))
    on_line = np.ones(len(uncertain), dtype=bool)
    for axes in ([0, 1], [1, 2], [2, 0]):
        x, y, z = (p[uncertain][:, axes] for p in (a, b, c))
        on_line &= orient2d(x, y, z) == 0
    flat[uncertain] = on_line | (flat[uncertain] & (tolerance > 0))
    return flat


def cross_with_terms(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cross product (k, 3), and the sum of the absolute values of its terms."""
    left = u[:, [1, 2, 0]] * v[:, [2, 0, 1]]
    right = u[:, [2, 0, 1]] * v[:, [1, 2, 0]]
    return left - right, np.abs(left) + np.abs(right)


def _length(vectors: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("ki,ki->k", vectors, vectors))


def _signs(
    value: np.ndarray, bound: np.ndarray, points: tuple[np.ndarray, ...], slack: np.ndarray | float
) -> np.ndarray:
    """Signs of determinants, exact where rounding could decide; 0 below the slack."""
    signs = np.sign(value).astype(np.int8)
    uncertain = np.flatnonzero((np.abs(value) <= bound) & (bound > 0))
    signs[uncertain] = _exact_signs(tuple(p[uncertain] for p in points))
    signs[(slack > 0) & (np.abs(value) <= slack)] = 0
    return signs


def _exact_signs(points: tuple[np.ndarray, ...]) -> np.ndarray:
    """Signs of det(b - a, c - a, ...) in integers."""
    first, *others = _as_integers(np.stack(points))
    u, v, *more = (p - first for p in others)
    if not more:
        det = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    else:
        (w,) = more
        det = sum(
            w[:, i] * (u[:, j] * v[:, k] - u[:, k] * v[:, j])
            for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
        )
    return (det > 0).astype(np.int8) - (det < 0).astype(np.int8)


def _as_integers(numbers: np.ndarray) -> np.ndarray:
    """The numbers times a common power of two, as Python integers."""
    mantissa, exponent = np.frexp(numbers)
    digits = np.ldexp(mantissa, 53).astype(np.int64)
    used = digits != 0
    shift = np.where(used, exponent - exponent.min(where=used, initial=1 << 20), 0)
    return np.left_shift(digits.astype(object), shift.astype(object))
