"""Constructive solid geometry: bodies as fields, positive inside, and operations on them.

Set operations, blending, morphing and rigid transformations; Wendland (2005), section 1.1.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid


class Solid(ABC):
    """A body {F > 0} in space, given by a field F that approximates the signed distance.

    A solid is called at points and returns F, positive inside. `a | b`, `a & b` and `a - b` are the
    union, the intersection and the difference.

    Attributes
    ----------
    box : (2, 3) ndarray
        Low and high corner of a box that contains the body.
    near : (n, 3) ndarray or None
        Points near every part of the surface, if they are known.
    spacing : float or None
        Resolution of the surface: the spacing of the points from which it was made.
    """

    box: np.ndarray
    near: np.ndarray | None = None
    spacing: float | None = None

    @abstractmethod
    def _values(self, x: np.ndarray) -> np.ndarray:
        """F (m,) at points (m, 3)."""

    @abstractmethod
    def _gradients(self, x: np.ndarray) -> np.ndarray:
        """Gradients (m, 3) at points (m, 3)."""

    def __call__(self, x: ArrayLike) -> np.ndarray:
        """Values of F.

        Parameters
        ----------
        x : (..., 3) array_like
            Points.

        Returns
        -------
        (...) ndarray
            Positive inside, zero on the surface, negative outside.
        """
        q = valid.as_queries(x, 3)
        return self._values(q.reshape(-1, 3)).reshape(q.shape[:-1])[()]

    def gradient(self, x: ArrayLike) -> np.ndarray:
        """Gradients of F at points (..., 3); on an edge between two parts, the gradient of one."""
        q = valid.as_queries(x, 3)
        return self._gradients(q.reshape(-1, 3)).reshape(q.shape)

    def normals(self, x: ArrayLike) -> np.ndarray:
        """Outward unit normals -grad F / |grad F| at points (..., 3); zero where grad F = 0."""
        g = self.gradient(x)
        length = np.linalg.norm(g, axis=-1, keepdims=True)
        return -np.divide(g, length, out=np.zeros_like(g), where=length > 0)

    def __or__(self, other: Solid) -> Solid:
        """Union."""
        return union(self, other)

    def __and__(self, other: Solid) -> Solid:
        """Intersection."""
        return intersection(self, other)

    def __sub__(self, other: Solid) -> Solid:
        """Difference."""
        return difference(self, other)


def union(*solids: Solid) -> Solid:
    """Union of bodies, F = max F_i.

    Parameters
    ----------
    *solids : Solid
        Two or more bodies.

    References
    ----------
    Wendland (2005), section 1.1; Ricci, A constructive geometry for computer graphics (1973).

    Examples
    --------
    >>> from fieldrecon.solids.shapes import Ball
    >>> two = Ball(1.0) | Ball(1.0, center=[1.5, 0, 0])
    >>> two([[0.75, 0, 0], [3.0, 0, 0]]).round(12)
    array([ 0.25, -0.5 ])
    """
    parts = as_solids(solids)
    return _Extreme(parts, np.ones(len(parts)), around([s.box for s in parts]), np.argmax)


def intersection(*solids: Solid) -> Solid:
    """Intersection of bodies, F = min F_i.

    Parameters
    ----------
    *solids : Solid
        Two or more bodies.

    Examples
    --------
    >>> from fieldrecon.solids.shapes import Ball
    >>> lens = Ball(1.0) & Ball(1.0, center=[1.5, 0, 0])
    >>> lens([[0.75, 0, 0], [0.0, 0, 0]]).round(12)
    array([ 0.25, -0.5 ])
    """
    parts = as_solids(solids)
    low = np.max([s.box[0] for s in parts], axis=0)
    high = np.maximum(np.min([s.box[1] for s in parts], axis=0), low)
    return _Extreme(parts, np.ones(len(parts)), np.array([low, high]), np.argmin)


def difference(solid: Solid, other: Solid) -> Solid:
    """Difference of two bodies, F = min(F_1, -F_2).

    Parameters
    ----------
    solid, other : Solid
        The body, and the body to subtract from it.

    Examples
    --------
    >>> from fieldrecon.solids.shapes import Ball
    >>> shell = Ball(1.0) - Ball(0.5)
    >>> shell([[0.0, 0, 0], [0.75, 0, 0]]).round(12)
    array([-0.5 ,  0.25])
    """
    parts = as_solids((solid, other))
    return _Extreme(parts, np.array([1.0, -1.0]), solid.box, np.argmin)


def as_solid(
    field: Callable[[np.ndarray], np.ndarray],
    box: ArrayLike,
    near: ArrayLike | None = None,
    spacing: float | None = None,
) -> Solid:
    """Make a body of a field with a gradient.

    Parameters
    ----------
    field : callable
        A function of points (..., 3), positive inside, with a method `gradient`.
    box : (2, 3) array_like
        Low and high corner of a box that contains the body.
    near : (n, 3) array_like, optional
        Points near every part of its surface.
    spacing : float, optional
        Resolution of the surface, a length.

    Raises
    ------
    ValueError
        If the field has no gradient, or the box is invalid.
    """
    if not callable(field) or not callable(getattr(field, "gradient", None)):
        raise ValueError(f"field must be callable and have a gradient; got {field!r}")
    return _FieldSolid(
        field, as_box(box), None if near is None else valid.as_points(near, "near"), spacing
    )


def as_box(box: ArrayLike) -> np.ndarray:
    """Validate the low and high corner (2, 3) of a box."""
    b = valid.as_queries(box, 3, "box")
    if b.shape != (2, 3) or not (b[0] < b[1]).all():
        raise ValueError(f"box must be a low and a high corner, (2, 3); got {b.tolist()}")
    return b


class _Extreme(Solid):
    """Largest or smallest of sign_i F_i."""

    def __init__(
        self,
        parts: tuple[Solid, ...],
        signs: np.ndarray,
        box: np.ndarray,
        choice: Callable[..., np.ndarray],
    ) -> None:
        self._parts, self._signs, self.box, self._choice = parts, signs, box, choice
        self.near, self.spacing = points_of(parts), finest(parts)

    def _each(self, x: np.ndarray) -> np.ndarray:
        return np.stack([sign * s(x) for s, sign in zip(self._parts, self._signs, strict=True)])

    def _values(self, x: np.ndarray) -> np.ndarray:
        each = self._each(x)
        return np.take_along_axis(each, self._choice(each, axis=0)[None], axis=0)[0]

    def _gradients(self, x: np.ndarray) -> np.ndarray:
        chosen, g = self._choice(self._each(x), axis=0), np.empty_like(x)
        for i, (part, sign) in enumerate(zip(self._parts, self._signs, strict=True)):
            g[chosen == i] = sign * part.gradient(x[chosen == i])
        return g


class _FieldSolid(Solid):
    def __init__(
        self,
        field: Callable[[np.ndarray], np.ndarray],
        box: np.ndarray,
        near: np.ndarray | None,
        spacing: float | None,
    ) -> None:
        self.field, self.box, self.near, self.spacing = field, box, near, spacing

    def _values(self, x: np.ndarray) -> np.ndarray:
        return self.field(x)

    def _gradients(self, x: np.ndarray) -> np.ndarray:
        return self.field.gradient(x)  # type: ignore[attr-defined]


def as_solids(solids: tuple[Solid, ...]) -> tuple[Solid, ...]:
    """Validate one or more bodies."""
    for s in solids:
        if not isinstance(s, Solid):
            raise ValueError(f"a body must be a Solid, such as Ball(1.0) or as_solid; got {s!r}")
    if not solids:
        raise ValueError("at least one body is needed; got none")
    return solids


def around(boxes: list[np.ndarray]) -> np.ndarray:
    """The bounding box of boxes."""
    low, high = np.array(boxes).swapaxes(0, 1)
    return np.array([low.min(axis=0), high.max(axis=0)])


def points_of(parts: tuple[Solid, ...]) -> np.ndarray | None:
    """Points near all surfaces, if they are known for each body."""
    near = [s.near for s in parts if s.near is not None]
    return np.concatenate(near) if len(near) == len(parts) else None


def finest(parts: tuple[Solid, ...]) -> float | None:
    """The smallest known spacing."""
    return min((s.spacing for s in parts if s.spacing is not None), default=None)


def blend(solid: Solid, other: Solid, radius: float) -> Solid:
    """Union with a rounded seam, F = max(F_1, F_2) + r h^2 / 4 with h = (1 - |F_1 - F_2| / r)_+.

    The gradient is continuous. Where the fields differ by r or more, F equals the union.

    Parameters
    ----------
    solid, other : Solid
        The bodies.
    radius : float
        Width r of the rounded seam: a positive length.

    References
    ----------
    Bloomenthal (ed.), Introduction to Implicit Surfaces (1997), chapter 6.

    Examples
    --------
    >>> from fieldrecon.solids.shapes import Ball
    >>> two = blend(Ball(1.0), Ball(1.0, center=[2.0, 0, 0]), radius=1.0)
    >>> float(two([1.0, 0, 0]))  # where the balls touch
    0.25
    """
    return _Blend(as_solids((solid, other)), valid.as_length(radius, "radius"))


def morph(solid: Solid, other: Solid, t: float) -> Solid:
    """Interpolate between two bodies, F = (1 - t) F_1 + t F_2.

    Parameters
    ----------
    solid, other : Solid
        The bodies at t = 0 and at t = 1. The result is connected if they overlap.
    t : float
        From 0 to 1.

    Raises
    ------
    ValueError
        If t is not from 0 to 1.

    Examples
    --------
    >>> from fieldrecon.solids.shapes import Ball
    >>> float(morph(Ball(1.0), Ball(2.0), 0.25)([0.0, 0, 0]))
    1.25
    """
    if not 0 <= t <= 1:
        raise ValueError(f"t must be from 0 to 1; got {t!r}")
    return _Morph(as_solids((solid, other)), float(t))


def transform(
    solid: Solid,
    rotation: ArrayLike | None = None,
    shift: ArrayLike = (0.0, 0.0, 0.0),
    scale: float = 1.0,
) -> Solid:
    """Rotate, scale and translate a body: its points x become scale R x + shift.

    Parameters
    ----------
    solid : Solid
        The body.
    rotation : (3, 3) array_like, optional
        Orthogonal matrix R.
    shift : (3,) array_like
        The image of the origin.
    scale : float
        Positive.

    Raises
    ------
    ValueError
        If the matrix is not orthogonal.

    Examples
    --------
    >>> from fieldrecon.solids.shapes import Ball
    >>> float(transform(Ball(1.0), shift=[5, 0, 0], scale=2.0)([5.0, 0, 0]))
    2.0
    """
    r = np.eye(3) if rotation is None else valid.as_queries(rotation, 3, "rotation")
    if r.shape != (3, 3) or not np.allclose(r @ r.T, np.eye(3), atol=1e-9):
        raise ValueError(f"rotation must be an orthogonal matrix (3, 3); got {r.tolist()}")
    to = valid.as_queries(shift, 3, "shift")
    (body,) = as_solids((solid,))
    return _Transformed(body, r, to, valid.as_length(scale, "scale"))


class _Blend(Solid):
    def __init__(self, parts: tuple[Solid, ...], radius: float) -> None:
        self._parts, self._radius = parts, radius
        # the surface is displaced outward by at most r / 4
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


class _Morph(Solid):
    def __init__(self, parts: tuple[Solid, ...], t: float) -> None:
        self._parts, self._t = parts, t
        self.box = around([s.box for s in parts])
        self.spacing = finest(parts)

    def _values(self, x: np.ndarray) -> np.ndarray:
        return (1 - self._t) * self._parts[0](x) + self._t * self._parts[1](x)

    def _gradients(self, x: np.ndarray) -> np.ndarray:
        a, b = (s.gradient(x) for s in self._parts)
        return (1 - self._t) * a + self._t * b


class _Transformed(Solid):
    def __init__(self, solid: Solid, r: np.ndarray, shift: np.ndarray, scale: float) -> None:
        self._solid, self._r, self._shift, self._scale = solid, r, shift, scale
        corners = np.stack(np.meshgrid(*solid.box.T, indexing="ij"), axis=-1).reshape(-1, 3)
        corners_there = self._to_world(corners)
        self.box = np.array([corners_there.min(axis=0), corners_there.max(axis=0)])
        self.near = None if solid.near is None else self._to_world(solid.near)
        self.spacing = None if solid.spacing is None else scale * solid.spacing

    def _to_world(self, x: np.ndarray) -> np.ndarray:
        return self._scale * x @ self._r.T + self._shift

    def _to_body(self, x: np.ndarray) -> np.ndarray:
        return (x - self._shift) @ self._r / self._scale

    def _values(self, x: np.ndarray) -> np.ndarray:
        return self._scale * self._solid(self._to_body(x))

    def _gradients(self, x: np.ndarray) -> np.ndarray:
        return self._solid.gradient(self._to_body(x)) @ self._r.T
