"""Integrals of 1 / (|x - p|^2 + epsilon^2)^2 over segments and triangles, and their gradients.

In the plane of a triangle, with the height h of x above it and eta^2 = h^2 + epsilon^2, the
integrand is 1 / (rho^2 + eta^2)^2. In polar coordinates about the foot of x each edge contributes

    d E / (2 eta^2),    E = int ds / (s^2 + g^2) = [atan(s / g) / g],    g^2 = d^2 + eta^2,

with the distance d of its line from the foot, positive on the inner side, and s along it. All
functions take one point and one simplex in every row; without `slopes` the gradients are zero.
"""

from __future__ import annotations

import numpy as np

_SLENDER = 0.02
"""Ratio of g to the distance along a line below which series are more accurate."""
_BESIDE = 0.1
"""In eta: distance from an edge below which nothing cancels, and the side of x is uncertain."""


def over_segments(
    x: np.ndarray, corners: np.ndarray, normals: np.ndarray, epsilon: float, slopes: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Integrals (k,) over segments (k, 2, 2) with unit normals (k, 2), and gradients (k, 2)."""
    along, length = _edge(corners[:, 0], corners[:, 1])
    s = _dot(corners[:, 0] - x, along)
    t = s + length
    h = _dot(x - corners[:, 0], normals)
    squared = h**2 + epsilon**2
    if not slopes:
        return _second(s, t, squared), np.zeros_like(x)
    ends = 1 / (s**2 + squared) ** 2 - 1 / (t**2 + squared) ** 2
    across = -4 * h * _third(s, t, squared)
    return _second(s, t, squared), ends[:, None] * along + across[:, None] * normals


def over_triangles(
    x: np.ndarray, corners: np.ndarray, normals: np.ndarray, epsilon: float, slopes: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Integrals (k,) over triangles (k, 3, 3) with unit normals (k, 3), and gradients (k, 3)."""
    h = _dot(x - corners[:, 0], normals)
    squared = h**2 + epsilon**2
    within, beyond, moment = np.zeros((3, len(x)))
    outside = np.zeros(len(x), dtype=bool)
    gradient = np.zeros((len(x), 3))
    for k in range(3):
        a = corners[:, k] - x
        along, length = _edge(corners[:, k], corners[:, (k + 1) % 3])
        inward = np.cross(normals, along)
        d, s = -_dot(a, inward), _dot(a, along)
        t, g = s + length, np.sqrt(d**2 + squared)
        angle = _angle(s, t, g)
        outside |= d < -_BESIDE * np.sqrt(squared)
        within += d * angle / g
        beyond -= _beyond(d, s, t, g, squared, angle)
        if slopes:
            second = _second(s, t, g**2)
            moment += d * second
            gradient += second[:, None] * inward
    # outside the triangle the angles sum to zero, and are omitted so that nothing cancels
    integral = np.where(outside, beyond, within / squared) / 2
    if slopes:
        gradient -= (2 * h / squared * (integral + moment / 2))[:, None] * normals
    return integral, gradient


def by_rule(
    x: np.ndarray, nodes: np.ndarray, shares: np.ndarray, epsilon: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the same by quadrature with nodes (k, q, d) and weights (k, q), for comparison."""
    offset = x[:, None] - nodes
    weight = 1 / ((offset**2).sum(axis=2) + epsilon**2)
    slope = np.einsum("kq,kqd->kd", -4 * shares * weight**3, offset)
    return np.einsum("kq,kq->k", shares, weight**2), slope


def _beyond(
    d: np.ndarray,
    s: np.ndarray,
    t: np.ndarray,
    g: np.ndarray,
    squared: np.ndarray,
    angle: np.ndarray,
) -> np.ndarray:
    """(sign(d) times the angle of the edge at the foot - d E) / eta^2, without cancellation."""
    distance = np.abs(d)
    low, high = (
        np.arctan2(u * squared, (g + distance) * (distance * g + u**2)) / squared for u in (s, t)
    )
    return np.sign(d) * (high - low + angle / (g * (g + distance)))


def _edge(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors (k, d) from a to b, and the distances (k,)."""
    length = np.linalg.norm(b - a, axis=1)
    return (b - a) / length[:, None], length


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("kd,kd->k", a, b)


def _angle(s: np.ndarray, t: np.ndarray, g: np.ndarray) -> np.ndarray:
    """atan(t / g) - atan(s / g), as one angle between 0 and pi."""
    return np.arctan2((t - s) * g, g**2 + s * t)


def _second(s: np.ndarray, t: np.ndarray, squared: np.ndarray) -> np.ndarray:
    """Integral of 1 / (u^2 + g^2)^2 from s to t, g^2 = squared."""
    g = np.sqrt(squared)
    rational = t / (t**2 + squared) - s / (s**2 + squared)
    closed = (rational + _angle(s, t, g) / g) / (2 * squared)
    return _unless_slender(closed, s, t, squared, 3, (1.0, -2.0, 3.0, -4.0))


def _third(s: np.ndarray, t: np.ndarray, squared: np.ndarray) -> np.ndarray:
    """Integral of 1 / (u^2 + g^2)^3 from s to t."""
    rational = t / (t**2 + squared) ** 2 - s / (s**2 + squared) ** 2
    closed = (rational + 3 * _second(s, t, squared)) / (4 * squared)
    return _unless_slender(closed, s, t, squared, 5, (1.0, -3.0, 6.0, -10.0))


def _unless_slender(
    closed: np.ndarray,
    s: np.ndarray,
    t: np.ndarray,
    squared: np.ndarray,
    power: int,
    binomial: tuple[float, ...],
) -> np.ndarray:
    """The closed form, or the series where s and t lie far on one side of the foot."""
    nearest = np.where(s * t > 0, np.minimum(np.abs(s), np.abs(t)), 0)
    slender = squared < (_SLENDER * nearest) ** 2
    low, high, g2 = (a[slender] for a in (s, t, squared))
    result = closed.copy()
    result[slender] = sum(
        coefficient * g2**j / (power + 2 * j) * (low ** -(power + 2 * j) - high ** -(power + 2 * j))
        for j, coefficient in enumerate(binomial)
    )
    return result
