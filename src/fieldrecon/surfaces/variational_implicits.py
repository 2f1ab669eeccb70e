"""Variational implicit functions: shapes of least bending energy, and their transformation.

Turk and O'Brien (1999, 2002); Wendland (2005), section 1.1, for the blending of shapes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon.fields import Field
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.methods.functionals import derivatives_at, values_at
from fieldrecon.methods.hermite import HermiteRBF
from fieldrecon.methods.rbf import RBF

Shape = tuple[ArrayLike, ArrayLike]
"""Points (n, d) on a closed curve or surface, and outward normals."""


def variational_implicit(
    points: ArrayLike,
    normals: ArrayLike,
    kernel: Radial | None = None,
    offset: float | None = None,
) -> Field:
    """Field of least energy that is zero at points and decreases along their normals.

    Parameters
    ----------
    points : (n, d) array_like
        Points on a closed curve (d = 2), surface (d = 3), or hypersurface.
    normals : (n, d) array_like
        Outward, of any length.
    kernel : Radial
        r^3 by default. Without an offset it must be twice differentiable.
    offset : float, optional
        With an offset, F has the value `offset` at the points at this distance inside along the
        normals, as by Turk and O'Brien. Without, grad F . n = -1 at the points.

    Returns
    -------
    Field
        Positive inside, and about the distance near the points.

    Raises
    ------
    ValueError
        If the normals have another shape than the points, or vanish.
    numpy.linalg.LinAlgError
        If the points, with the offset ones, do not determine a linear polynomial.

    References
    ----------
    Turk and O'Brien, Shape transformation using variational implicit functions (1999); Modelling
    with implicit surfaces that interpolate (2002).

    Examples
    --------
    >>> t = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    >>> circle = np.column_stack([np.cos(t), np.sin(t)])
    >>> f = variational_implicit(circle, circle)
    >>> bool(f([0.0, 0.0]) > 0), bool(abs(f([np.cos(0.4), np.sin(0.4)])) < 1e-3)
    (True, True)
    """
    p = valid.as_points(points)
    n = _as_normals(normals, p)
    kernel = polyharmonic(3) if kernel is None else kernel
    zeros = np.zeros(len(p))
    if offset is None:
        method = HermiteRBF([values_at(p), derivatives_at(p, n)], kernel)
        return method.field(np.concatenate([zeros, zeros - 1]))
    offset = valid.as_length(offset, "offset")
    inside = p - offset * n
    return RBF(np.concatenate([p, inside]), kernel).field(np.concatenate([zeros, zeros + offset]))


class ShapeTransformation:
    """Transformation between shapes: slices of one field with time as an additional variable.

    A variational implicit function interpolates the points (p, t) of all shapes, with the normals
    (n, 0). No correspondence between the points of two shapes is needed, and the number of parts or
    holes may change.

    Parameters
    ----------
    shapes : sequence of (points, normals)
        Two or more shapes, each as for `variational_implicit`.
    times : sequence of float
        The time of each shape, as a length: nearer shapes blend less.
    kernel, offset
        As for `variational_implicit`, in d + 1 variables.

    References
    ----------
    Turk and O'Brien, Shape transformation using variational implicit functions (1999).

    Examples
    --------
    >>> t = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    >>> circle = np.column_stack([np.cos(t), np.sin(t)])
    >>> growing = ShapeTransformation([(circle, circle), (2 * circle, circle)], [0.0, 1.0])
    >>> between = growing.at(0.5)
    >>> bool(between([1.3, 0]) > 0 > between([1.7, 0]))
    True
    """

    def __init__(
        self,
        shapes: Sequence[Shape],
        times: Sequence[float],
        kernel: Radial | None = None,
        offset: float | None = None,
    ) -> None:
        self.times = valid.as_line(times, "times")[:, 0]
        if len(shapes) != len(self.times) or len(set(self.times)) < 2:
            raise ValueError(
                "times must be different numbers, one for each of two or more shapes; got "
                f"{len(shapes)} shapes and the times {list(times)}"
            )
        lifted = [_lifted(*shape, t) for shape, t in zip(shapes, self.times, strict=True)]
        points, normals = (np.concatenate(parts) for parts in zip(*lifted, strict=True))
        self.field = variational_implicit(points, normals, kernel, offset)

    def at(self, time: float) -> Slice:
        """Return the implicit function of the shape at a time, positive inside."""
        return Slice(self.field, float(time))


class Slice:
    """A field of d + 1 variables with a fixed last one, as `ShapeTransformation.at` returns it."""

    def __init__(self, field: Field, last: float) -> None:
        self.field, self.last = field, last

    def __call__(self, x: ArrayLike) -> np.ndarray:
        """Values (...) at points (..., d)."""
        return self.field(self._lifted(x))

    def gradient(self, x: ArrayLike) -> np.ndarray:
        """Gradients (..., d)."""
        return self.field.gradient(self._lifted(x))[..., :-1]

    def _lifted(self, x: ArrayLike) -> np.ndarray:
        q = valid.as_queries(x, self.field.method.points.shape[1] - 1)
        return np.concatenate([q, np.full((*q.shape[:-1], 1), self.last)], axis=-1)


def _lifted(points: ArrayLike, normals: ArrayLike, time: float) -> tuple[np.ndarray, np.ndarray]:
    p = valid.as_points(points)
    n = _as_normals(normals, p)
    column = np.zeros((len(p), 1))
    return np.hstack([p, column + time]), np.hstack([n, column])


def _as_normals(normals: ArrayLike, p: np.ndarray) -> np.ndarray:
    """Unit normals (n, d)."""
    n = valid.as_queries(normals, p.shape[1], "normals")
    if n.shape != p.shape:
        raise ValueError(f"normals must have the shape of the points, {p.shape}; got {n.shape}")
    length = np.linalg.norm(n, axis=1, keepdims=True)
    if not length.all():
        raise ValueError(f"normals must not vanish; that of point {int(length.argmin())} does")
    return n / length
