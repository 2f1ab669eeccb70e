"""On which side many points lie: signs of determinants, exact where rounding could decide.

A sign is taken from floating-point arithmetic where it exceeds a bound of its rounding error; the
few others are computed again in integers, which is what floating-point numbers are but for a
power of two.

References
----------
Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates (1997);
Ericson, Real-Time Collision Detection (2005), for determinants as distances.
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

    Points c not farther than the tolerance from the line through a and b count as on it.
    """
    u, v = b - a, c - a
    left, right = u[:, 0] * v[:, 1], u[:, 1] * v[:, 0]
    size = np.sqrt(u[:, 0] ** 2 + u[:, 1] ** 2)
    return _signs(
        left - right, BOUND_2D * (np.abs(left) + np.abs(right)), (a, b, c), tolerance * size
    )


def orient3d(
    a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray, *, tolerance: float = 0.0
) -> np.ndarray:
    """Sign of det(b - a, c - a, d - a): 1 where d lies where the normal of a, b, c (k, 3) points.

    Points d not farther than the tolerance from the plane count as in it.
    """
    u, v, w = b - a, c - a, d - a
    normal, terms = cross_with_terms(u, v)
    scale = tolerance * np.sqrt(np.einsum("ki,ki->k", normal, normal))
    return _signs(*_determinant(normal, terms, w), (a, b, c, d), scale)


def crossing_side(
    p: np.ndarray, q: np.ndarray, a: np.ndarray, b: np.ndarray, *, tolerance: float = 0.0
) -> np.ndarray:
    """Sign of det(q - p, a - p, b - p): on which side the line p q passes the line a b.

    Lines not farther apart than the tolerance count as meeting.
    """
    normal, terms = cross_with_terms(q - p, b - a)
    scale = tolerance * np.sqrt(np.einsum("ki,ki->k", normal, normal))
    determinant, bound = _determinant(normal, terms, a - p)
    return _signs(-determinant, bound, (p, q, a, b), scale)


def collinear(a: np.ndarray, b: np.ndarray, c: np.ndarray, *, tolerance: float = 0.0) -> np.ndarray:
    """Whether points (k, 3) lie on one line, or not farther than the tolerance from their longest.

    Points do so if and only if their projections along all three axes do.
    """
    sides = np.stack([b - a, c - b, a - c])
    longest = np.sqrt(np.einsum("eki,eki->ek", sides, sides).max(axis=0))
    normal, terms = cross_with_terms(sides[0], -sides[2])
    area = np.sqrt(np.einsum("ki,ki->k", normal, normal))
    flat = area <= tolerance * longest
    doubtful = np.flatnonzero(~flat & (np.abs(normal) <= BOUND_2D * terms).all(axis=1))
    on_line = np.ones(len(doubtful), dtype=bool)
    for axes in ([0, 1], [1, 2], [2, 0]):
        on_line &= orient2d(*(p[doubtful][:, axes] for p in (a, b, c))) == 0
    flat[doubtful] = on_line
    return flat


def cross_with_terms(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cross product (k, 3), and the sum of the absolute values of its terms."""
    left = u[:, [1, 2, 0]] * v[:, [2, 0, 1]]
    right = u[:, [2, 0, 1]] * v[:, [1, 2, 0]]
    return left - right, np.abs(left) + np.abs(right)


def _determinant(
    normal: np.ndarray, terms: np.ndarray, w: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Product of normal and w, and the bound of its rounding error."""
    value = np.einsum("ki,ki->k", normal, w)
    return value, BOUND_3D * np.einsum("ki,ki->k", terms, np.abs(w))


def _signs(
    value: np.ndarray, bound: np.ndarray, points: tuple[np.ndarray, ...], scale: np.ndarray
) -> np.ndarray:
    """Signs of determinants: of the value, or exact; 0 where it does not exceed the scale."""
    signs = np.sign(value).astype(np.int8)
    doubtful = np.flatnonzero((np.abs(value) <= bound) & (bound > 0))
    signs[doubtful] = _exact_signs(tuple(p[doubtful] for p in points))
    signs[(scale > 0) & (np.abs(value) <= scale)] = 0
    return signs


def _exact_signs(points: tuple[np.ndarray, ...]) -> np.ndarray:
    """Signs of det(b - a, c - a, ...) in integers."""
    if len(points[0]) == 0:
        return np.zeros(0, dtype=np.int8)
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
    """The numbers, all times the same power of two, as Python's integers."""
    mantissa, exponent = np.frexp(numbers)
    digits = np.ldexp(mantissa, 53).astype(np.int64)
    used = digits != 0
    shift = np.where(used, exponent - exponent.min(where=used, initial=1 << 20), 0)
    return np.left_shift(digits.astype(object), shift.astype(object))
