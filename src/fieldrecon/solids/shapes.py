"""Bodies given by formulas, and simulated scans of their surfaces."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon.datasets.synthetic import Seed
from fieldrecon.solids.constructive import Solid

_ORIGIN = (0.0, 0.0, 0.0)
_SHELL = 0.01  # of the box: points are drawn this near to the surface
_MAX_DRAWS = 200
_MAX_STEPS = 64  # of a ray from a point to the scanner


class _Shape(Solid):
    """A body with a centre; F and its gradient in coordinates relative to the centre."""

    def __init__(self, half: ArrayLike, center: ArrayLike) -> None:
        self._center = valid.as_queries(center, 3, "center")
        self.box = self._center + np.outer([-1.0, 1.0], np.broadcast_to(half, 3))

    def _values(self, x: np.ndarray) -> np.ndarray:
        return self._from_center(x - self._center)[0]

    def _gradients(self, x: np.ndarray) -> np.ndarray:
        return self._from_center(x - self._center)[1]

    @abstractmethod
    def _from_center(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values (m,) and gradients (m, 3) at points y (m, 3) relative to the centre."""


class Ball(_Shape):
    """A ball, F = radius - |x - center|.

    Parameters
    ----------
    radius : float
        Positive.
    center : (3,) array_like
        The origin by default.

    Examples
    --------
    >>> float(Ball(2.0)([3.0, 0, 0])), Ball(2.0).gradient([3.0, 0, 0]).tolist()
    (-1.0, [-1.0, -0.0, -0.0])
    """

    def __init__(self, radius: float, center: ArrayLike = _ORIGIN) -> None:
        self.radius = valid.as_length(radius, "radius")
        super().__init__(self.radius, center)

    def _from_center(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        r = np.linalg.norm(y, axis=1)
        return self.radius - r, -_unit(y, r)


class Box(_Shape):
    """A box with edges along the axes; F is the signed distance.

    Parameters
    ----------
    size : (3,) array_like or float
        Positive lengths of the edges.
    center : (3,) array_like
        The origin by default.

    Examples
    --------
    >>> Box([2.0, 2.0, 0.5])([[0, 0, 0], [4, 5, 0]]).tolist()
    [0.25, -5.0]
    """

    def __init__(self, size: ArrayLike, center: ArrayLike = _ORIGIN) -> None:
        if np.ndim(size):
            half = np.broadcast_to(valid.as_numbers(size, "size", complex_allowed=False), 3) / 2
        else:
            half = np.full(3, valid.as_length(size, "size")) / 2  # type: ignore[arg-type]
        if not (half > 0).all():
            raise ValueError(f"size must be positive; got {(2 * half).tolist()}")
        self._half = half
        super().__init__(half, center)

    def _from_center(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        over = np.abs(y) - self._half
        beyond = np.maximum(over, 0.0)
        far = np.linalg.norm(beyond, axis=1)
        inside = np.minimum(over.max(axis=1), 0.0)
        face = np.eye(3)[over.argmax(axis=1)]
        outward = np.where((far > 0)[:, None], _unit(beyond, far), face)
        return -(far + inside), -np.copysign(outward, y)


class Torus(_Shape):
    """A torus about the z axis, F = tube - |(|(x, y)| - radius, z)|.

    Parameters
    ----------
    radius, tube : float
        Radii of the centre circle and of the tube, positive.
    center : (3,) array_like
        The origin by default.

    Examples
    --------
    >>> Torus(1.0, 0.25)([[1.0, 0, 0], [0, 0, 0]]).tolist()
    [0.25, -0.75]
    """

    def __init__(self, radius: float, tube: float, center: ArrayLike = _ORIGIN) -> None:
        self.radius, self.tube = valid.as_length(radius, "radius"), valid.as_length(tube, "tube")
        super().__init__([self.radius + self.tube] * 2 + [self.tube], center)

    def _from_center(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        axial = np.linalg.norm(y[:, :2], axis=1)
        across = np.column_stack([axial - self.radius, y[:, 2]])
        r = np.linalg.norm(across, axis=1)
        along = _unit(across, r)
        outward = np.column_stack([along[:, :1] * _unit(y[:, :2], axial), along[:, 1]])
        return self.tube - r, -outward


class Cylinder(_Shape):
    """A cylinder about the z axis, closed by discs; F is the signed distance.

    Parameters
    ----------
    radius, height : float
        Positive.
    center : (3,) array_like
        The origin by default.

    Examples
    --------
    >>> Cylinder(1.0, 4.0)([[0, 0, 0], [4.0, 0, 6.0]]).tolist()
    [1.0, -5.0]
    """

    def __init__(self, radius: float, height: float, center: ArrayLike = _ORIGIN) -> None:
        self.radius, self.height = (
            valid.as_length(radius, "radius"),
            valid.as_length(height, "height"),
        )
        super().__init__([self.radius, self.radius, self.height / 2], center)

    def _from_center(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        axial = np.linalg.norm(y[:, :2], axis=1)
        over = np.column_stack([axial - self.radius, np.abs(y[:, 2]) - self.height / 2])
        beyond = np.maximum(over, 0.0)
        far = np.linalg.norm(beyond, axis=1)
        nearest = np.eye(2)[over.argmax(axis=1)]
        part = np.where((far > 0)[:, None], _unit(beyond, far), nearest)
        outward = np.column_stack(
            [part[:, :1] * _unit(y[:, :2], axial), np.copysign(part[:, 1], y[:, 2])]
        )
        return -(far + np.minimum(over.max(axis=1), 0.0)), -outward


def sample_surface(solid: Solid, n: int, seed: Seed) -> tuple[np.ndarray, np.ndarray]:
    """Draw points on the surface of a body, about uniformly, with the outward normals.

    Random points of the box near the surface are projected onto it along the gradient.

    Parameters
    ----------
    solid : Solid
        A body whose field is the distance near its surface.
    n : int
        Number of points.
    seed : int or numpy.random.Generator
        Seed of the random numbers.

    Returns
    -------
    points, normals : (n, 3) ndarray

    Raises
    ------
    ValueError
        If the body has no surface in its box.

    Examples
    --------
    >>> points, normals = sample_surface(Ball(2.0), 100, seed=1)
    >>> bool(np.allclose(points, 2 * normals))
    True
    """
    rng = np.random.default_rng(seed)
    size = solid.box[1] - solid.box[0]
    shell = _SHELL * size.max()
    low, span = solid.box[0] - shell, size + 2 * shell
    found, count = [np.empty((0, 3))], 0
    for _ in range(_MAX_DRAWS):
        if count >= n:
            break
        x = low + span * rng.random((min(max(4 * n, 4096), 2**18), 3))
        x = x[np.abs(solid(x)) < shell]
        foot = _projected(solid, x)
        # points beyond an edge would all be projected onto the edge
        along = np.abs(np.einsum("ij,ij->i", x - foot, solid.normals(foot)))
        straight = along > 0.999 * np.linalg.norm(x - foot, axis=1)
        found.append(foot[straight & (np.abs(solid(foot)) < 1e-9 * shell)])
        count += len(found[-1])
    if count < n:
        raise ValueError("the body has no surface in its box, or its field is far from a distance")
    points = np.concatenate(found)[:n]
    return points, solid.normals(points)


def _projected(solid: Solid, x: np.ndarray) -> np.ndarray:
    """Project points onto the surface along the gradient."""
    for _ in range(8):
        g = solid.gradient(x)
        x = x - (solid(x) / np.maximum(np.einsum("ij,ij->i", g, g), 1e-12))[:, None] * g
    return x


def roughened(points: ArrayLike, normals: ArrayLike, noise: float, seed: Seed) -> np.ndarray:
    """Displace points along their normals by normally distributed noise.

    Parameters
    ----------
    points, normals : (n, 3) array_like
        Points on a surface, and its normals.
    noise : float
        Standard deviation, a length.
    seed : int or numpy.random.Generator
        Seed of the random numbers.

    Returns
    -------
    (n, 3) ndarray
    """
    p, outward = valid.as_points(points), valid.as_points(normals, "normals")
    noise = valid.as_length(noise, "noise", zero_allowed=True)
    return p + noise * np.random.default_rng(seed).standard_normal((len(p), 1)) * outward


def scanned(
    solid: Solid, points: ArrayLike, normals: ArrayLike, eyes: ArrayLike, slant: float = 0.2
) -> np.ndarray:
    """Return which points of a surface are visible from a position of a scanner.

    A ray goes from the point to the scanner in steps of the distance to the body.

    Parameters
    ----------
    solid : Solid
        The body.
    points, normals : (n, 3) array_like
        Points on its surface, and its outward normals.
    eyes : (k, 3) array_like
        Positions of the scanner, outside the body.
    slant : float
        Cosine of the largest angle to the normal at which the scanner sees a point.

    Returns
    -------
    (n,) ndarray of bool

    Examples
    --------
    >>> points, normals = sample_surface(Ball(1.0), 1000, seed=1)
    >>> seen = scanned(Ball(1.0), points, normals, [[9.0, 0, 0]])
    >>> bool((points[seen, 0] > 0).all()), bool(seen[points[:, 0] > 0.5].all())
    (True, True)
    """
    p, outward = valid.as_points(points), valid.as_points(normals, "normals")
    seen = np.zeros(len(p), dtype=bool)
    for eye in valid.as_points(eyes, "eyes"):
        toward = eye - p
        length = np.linalg.norm(toward, axis=1)
        toward /= length[:, None]
        facing = np.flatnonzero(np.einsum("ij,ij->i", toward, outward) > slant)
        seen[facing[_reaches(solid, p[facing], toward[facing], length[facing])]] = True
    return seen


def _reaches(solid: Solid, p: np.ndarray, toward: np.ndarray, length: np.ndarray) -> np.ndarray:
    """Whether rays from the surface do not meet the body again."""
    least = 1e-3 * float((solid.box[1] - solid.box[0]).max())
    t, free = np.full(len(p), 4 * least), np.ones(len(p), dtype=bool)
    for _ in range(_MAX_STEPS):
        under_way = np.flatnonzero(free & (t < length))
        if len(under_way) == 0:
            break
        outside = -solid(p[under_way] + t[under_way, None] * toward[under_way])
        free[under_way] = outside > 0
        t[under_way] += np.maximum(outside, least)
    return free


def _unit(vectors: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    return np.divide(
        vectors, lengths[:, None], out=np.zeros_like(vectors), where=lengths[:, None] > 0
    )
