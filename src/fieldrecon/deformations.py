"""Bodies blended, deformed into each other, and moved."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon import _validation as valid
from fieldrecon.solids import Solid, around, as_solids, finest, points_of

__all__ = ["blend", "deformation", "moved"]


def blend(solid: Solid, other: Solid, radius: float) -> Solid:
    """Union with its seam rounded, F = max(F_1, F_2) + r h^2 / 4, h = (1 - |F_1 - F_2| / r)_+.

    The gradient is continuous; where the fields differ by r or more it is the union.

    Parameters
    ----------
    solid, other : Solid
        The bodies.
    radius : float
        Width r of what is rounded, as a length, positive.

    References
    ----------
    Bloomenthal (ed.), Introduction to Implicit Surfaces (1997), chapter 6.

    Examples
    --------
    >>> from fieldrecon.shapes import Ball
    >>> two = blend(Ball(1.0), Ball(1.0, center=[2.0, 0, 0]), radius=1.0)
    >>> float(two([1.0, 0, 0]))  # where the balls touch
    0.25
    """
    return _Blend(as_solids((solid, other)), valid.as_length(radius, "radius"))


def deformation(solid: Solid, other: Solid, t: float) -> Solid:
    """A body between two, F = (1 - t) F_1 + t F_2: the first at t = 0, the second at t = 1.

    Parameters
    ----------
    solid, other : Solid
        The bodies; what comes of them is whole if they overlap.
    t : float
        Time, from 0 to 1.

    Raises
    ------
    ValueError
        If t is not from 0 to 1.

    Examples
    --------
    >>> from fieldrecon.shapes import Ball
    >>> float(deformation(Ball(1.0), Ball(2.0), 0.25)([0.0, 0, 0]))
    1.25
    """
    if not 0 <= t <= 1:
        raise ValueError(f"t must be from 0 to 1; got {t!r}")
    return _Between(as_solids((solid, other)), float(t))


def moved(
    solid: Solid,
    rotation: ArrayLike | None = None,
    shift: ArrayLike = (0.0, 0.0, 0.0),
    scale: float = 1.0,
) -> Solid:
    """A body turned, made larger and shifted: x -> scale R x + shift of its points.

    Parameters
    ----------
    solid : Solid
        The body.
    rotation : (3, 3) array_like, optional
        Orthogonal matrix R.
    shift : (3,) array_like
        Where the origin comes to lie.
    scale : float
        Positive.

    Raises
    ------
    ValueError
        If the matrix is not orthogonal.

    Examples
    --------
    >>> from fieldrecon.shapes import Ball
    >>> float(moved(Ball(1.0), shift=[5, 0, 0], scale=2.0)([5.0, 0, 0]))
    2.0
    """
    r = np.eye(3) if rotation is None else valid.as_queries(rotation, 3)
    if r.shape != (3, 3) or not np.allclose(r @ r.T, np.eye(3), atol=1e-9):
        raise ValueError(f"rotation must be an orthogonal matrix (3, 3); got {r.tolist()}")
    to = valid.as_queries(shift, 3)
    return _Moved(as_solids((solid,))[0], r, to, valid.as_length(scale, "scale"))


class _Blend(Solid):
    def __init__(self, parts: tuple[Solid, ...], radius: float) -> None:
        self._parts, self._radius = parts, radius
        # the surface moves out by r / 4 at the most
        self.box = around([s.box for s in parts]) + 0.25 * radius * np.array([[-1.0], [1.0]])
        self.near, self.spacing = points_of(parts), finest(parts)

    def _values(self, x: np.ndarray) -> np.ndarray:
        a, b = (s(x) for s in self._parts)
        h = np.maximum(1 - abs(a - b) / self._radius, 0.0)
        return np.maximum(a, b) + self._radius * h**2 / 4

    def _gradients(self, x: np.ndarray) -> np.ndarray:
        a, b = (s(x) for s in self._parts)
        u = np.clip((a - b) / self._radius, -1.0, 1.0)[:, None]
        return ((1 + u) * self._parts[0].gradient(x) + (1 - u) * self._parts[1].gradient(x)) / 2


class _Between(Solid):
    def __init__(self, parts: tuple[Solid, ...], t: float) -> None:
        self._parts, self._t = parts, t
        self.box = around([s.box for s in parts])
        self.spacing = finest(parts)

    def _values(self, x: np.ndarray) -> np.ndarray:
        return (1 - self._t) * self._parts[0](x) + self._t * self._parts[1](x)

    def _gradients(self, x: np.ndarray) -> np.ndarray:
        a, b = (s.gradient(x) for s in self._parts)
        return (1 - self._t) * a + self._t * b


class _Moved(Solid):
    def __init__(self, solid: Solid, r: np.ndarray, shift: np.ndarray, scale: float) -> None:
        self._solid, self._r, self._shift, self._scale = solid, r, shift, scale
        corners = np.stack(np.meshgrid(*solid.box.T, indexing="ij"), axis=-1).reshape(-1, 3)
        there = self._out(corners)
        self.box = np.array([there.min(axis=0), there.max(axis=0)])
        self.near = None if solid.near is None else self._out(solid.near)
        self.spacing = None if solid.spacing is None else scale * solid.spacing

    def _out(self, x: np.ndarray) -> np.ndarray:
        return self._scale * x @ self._r.T + self._shift

    def _back(self, x: np.ndarray) -> np.ndarray:
        return (x - self._shift) @ self._r / self._scale

    def _values(self, x: np.ndarray) -> np.ndarray:
        return self._scale * self._solid(self._back(x))

    def _gradients(self, x: np.ndarray) -> np.ndarray:
        return self._solid.gradient(self._back(x)) @ self._r.T
