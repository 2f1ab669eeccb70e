"""Ray casting, and ray tracing: the first intersections of rays with the zeros of a function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress
from fieldrecon.solids.constructive import as_box

LIGHT = (-0.35, 0.5, 0.8)
"""Direction to the light: from the left, from above, and from the side of the viewer."""
OUTSIDE = (0.851, 0.867, 0.890)
_AMBIENT, _DIFFUSE, _SPECULAR, _SHININESS = 0.28, 0.66, 0.16, 24
_INVISIBLE = 1e-3  # of a step

_MAX_REFINEMENTS = 100
_EXACT = 4e-16  # of the distance travelled


def ray_intersections(
    solid: Callable[[np.ndarray], np.ndarray],
    origins: ArrayLike,
    direction: ArrayLike,
    lengths: ArrayLike,
    step: float,
    *,
    near: ArrayLike | None = None,
    slope: float | None = None,
    tol: float = 0.0,
    progress: Progress | None = None,
) -> np.ndarray:
    """Distances along rays to the first zero of a function.

    All rays advance together. When the function changes sign between two points of a ray, the
    Illinois variant of regula falsi finds the zero, with bisection where that is slow.

    Parameters
    ----------
    solid : callable
        Values (k,) at points (k, d), positive inside, and negative at the origins.
    origins : (k, d) array_like
    direction : (d,) array_like
        Direction of all rays, a vector of any length but zero.
    lengths : float or (k,) array_like
        Lengths of the rays.
    step : float
        Distance of the points at which the function is evaluated, beside the end of each ray;
        thinner parts may be missed.
    near : (n, d) array_like, optional
        Points such that the surface is nowhere farther than 2 steps from all of them. Rays skip
        the space between them.
    slope : float, optional
        A Lipschitz constant of the function, positive. With it, rays advance by |F| / slope if
        that is more than a step (sphere tracing).
    tol : float
        Tolerance of the distances; the rounding error by default.
    progress : callable, optional
        Called as progress(done, total) with numbers of rays.

    Returns
    -------
    (k,) ndarray
        Distances; inf for rays without an intersection.

    Raises
    ------
    ValueError
        If an argument has the wrong form, or the function is not finite at a point of a ray.

    References
    ----------
    Hart, Sphere tracing (1996); Dowell and Jarratt, A modified regula falsi method (1971).

    Examples
    --------
    >>> ball = lambda x: 1 - np.linalg.norm(x, axis=-1)
    >>> ray_intersections(ball, [[0, 0, 3], [0, 0.6, 3], [0, 2, 3]], [0, 0, -1], 6.0, 0.1)
    array([2. , 2.2, inf])
    """
    o = valid.as_points(origins, "origins", none_allowed=True)
    ahead = _unit_vector(direction, o.shape[1])
    step = valid.as_length(step, "step")
    slope = None if slope is None else valid.as_length(slope, "slope")
    tol = valid.as_length(tol, "tol", zero_allowed=True)
    tree = None if near is None else cKDTree(valid.as_points(near, "near"))
    lengths = _as_lengths(lengths, len(o))
    t, before = np.zeros(len(o)), np.zeros(len(o))
    bracketed = np.zeros(len(o), dtype=bool)
    ends = np.zeros((2, len(o)))
    active = np.flatnonzero(lengths >= 0)
    while len(active):
        points = o[active] + t[active, None] * ahead
        on = np.full(len(active), step)
        evaluated = np.arange(len(active))
        if tree is not None:
            free = tree.query(points)[0] - 2 * step
            on = np.maximum(free, step)
            evaluated = np.flatnonzero(free <= 0)
        values = _values(solid, points[evaluated])
        found = values >= 0
        ends[1, active[evaluated]] = values
        bracketed[active[evaluated[found]]] = True
        if slope is not None:
            on[evaluated] = np.maximum(on[evaluated], -values / slope)
        on[evaluated[found]] = np.inf
        advancing = np.isfinite(on) & (t[active] < lengths[active])
        active, on = active[advancing], on[advancing]
        before[active] = t[active]
        ends[0, active] = np.minimum(ends[1, active], 0)
        t[active] = np.minimum(t[active] + on, lengths[active])
        if progress is not None:
            progress(len(o) - len(active), len(o))
    distance = np.full(len(o), np.inf)
    hit = np.flatnonzero(bracketed)
    bracket = np.stack([before[hit], t[hit]])
    distance[hit] = _refined(solid, o[hit], ahead, bracket, ends[:, hit], tol)
    return distance


def _unit_vector(direction: ArrayLike, d: int) -> np.ndarray:
    vector = valid.as_numbers(direction, "direction", complex_allowed=False)
    if vector.shape != (d,) or not vector.any():
        raise ValueError(
            f"direction must be one vector of {d} coordinates, not all zero; got {direction!r}"
        )
    vector = vector / np.abs(vector).max()
    return vector / np.linalg.norm(vector)


def _as_lengths(lengths: ArrayLike, n: int) -> np.ndarray:
    """Lengths (n,) of the rays; a ray of negative length has no points."""
    given = valid.as_numbers(lengths, "lengths", complex_allowed=False)
    if given.shape not in ((), (n,)):
        raise ValueError(f"lengths must be one number, or {n}, one for each ray; got {given.shape}")
    return np.broadcast_to(given, n)


def _values(solid: Callable[[np.ndarray], np.ndarray], points: np.ndarray) -> np.ndarray:
    """Values (k,) of the function at the points, refused if one is not finite."""
    if not len(points):
        return np.zeros(0)
    values = np.asarray(valid.unmasked(solid(points), "solid(x)"))
    if values.shape != (len(points),):
        raise ValueError(
            f"solid must have one value at each of {len(points)} points; got the shape "
            f"{values.shape}"
        )
    wrong = np.flatnonzero(~np.isfinite(values))
    if len(wrong):
        where = valid.format_point(points[wrong[0]])
        raise ValueError(f"solid must be finite on the rays; at ({where}) it is {values[wrong[0]]}")
    return values


def _refined(
    solid: Callable[[np.ndarray], np.ndarray],
    origins: np.ndarray,
    ahead: np.ndarray,
    bracket: np.ndarray,
    values: np.ndarray,
    tolerance: float,
) -> np.ndarray:
    """Zeros (k,) in brackets (2, k), whose first end is outside and whose second is inside."""
    (a, b), (fa, fb) = bracket.copy(), values.copy()
    side = np.zeros(len(a))
    active = np.arange(len(a))
    for k in range(_MAX_REFINEMENTS):
        lo, hi, flo, fhi = a[active], b[active], fa[active], fb[active]
        share = np.where(fhi - flo > 0, -flo / np.where(fhi - flo > 0, fhi - flo, 1), 0.5)
        middle = lo + (0.5 if k % 4 == 3 else np.clip(share, 0, 1)) * (hi - lo)
        value = _values(solid, origins[active] + middle[:, None] * ahead)
        outside = value < 0
        again = side[active] == np.where(outside, -1, 1)
        a[active] = np.where(outside, middle, lo)
        b[active] = np.where(outside, hi, middle)
        fa[active] = np.where(outside, value, np.where(again, flo / 2, flo))
        fb[active] = np.where(outside, np.where(again, fhi / 2, fhi), value)
        side[active] = np.where(outside, -1, 1)
        done = (value == 0) | (b[active] - a[active] <= tolerance + _EXACT * b[active])
        b[active[value == 0]] = middle[value == 0]
        active = active[~done]
        if not len(active):
            break
    return b


class Implicit(Protocol):
    """A function that is positive inside a body, with its gradient."""

    def __call__(self, x: np.ndarray, /) -> np.ndarray:
        """Values (...) at points (..., 3)."""

    def gradient(self, x: np.ndarray, /) -> np.ndarray:
        """Gradients (..., 3)."""


@dataclass(frozen=True, eq=False)
class View:
    """Parallel rays, one for each pixel, through a box.

    Parameters
    ----------
    axes : (3, 3) ndarray
        Columns that point right, up, and to the viewer.
    origins : (rows, columns, 3) ndarray
        Points at which the rays enter the box, the lowest row first.
    lengths : (rows, columns) ndarray
        Lengths of the rays in the box; negative for rays that miss it.
    """

    axes: np.ndarray
    origins: np.ndarray
    lengths: np.ndarray

    @classmethod
    def of_box(
        cls, box: ArrayLike, toward: ArrayLike, pixels: int = 400, up: ArrayLike = (0, 0, 1)
    ) -> View:
        """Return the view of a box from a direction.

        Parameters
        ----------
        box : (2, 3) array_like
            Lowest and highest corner.
        toward : (3,) array_like
            Direction to the viewer.
        pixels : int
            Number of pixels along the longer side, two or more.
        up : (3,) array_like
            Direction that points up in the picture.

        Examples
        --------
        >>> View.of_box([[0, 0, 0], [2, 1, 1]], toward=[0, -1, 0], pixels=40).origins.shape
        (20, 40, 3)
        """
        low, high = as_box(box)
        pixels = valid.as_count(pixels, "pixels", 2)
        axes = _axes(valid.as_queries(toward, 3, "toward"), valid.as_queries(up, 3, "up"))
        corners = np.stack(np.meshgrid(*zip(low, high, strict=True), indexing="ij"), axis=-1)
        projected = (corners.reshape(-1, 3) - low) @ axes
        first, last = projected.min(axis=0), projected.max(axis=0)
        size = (last - first)[:2].max() / pixels
        columns, rows = np.ceil((last - first)[:2] / size - 1e-9).astype(int)
        middle = (first + last)[:2] / 2
        right = middle[0] + size * (np.arange(columns) - (columns - 1) / 2)
        up = middle[1] + size * (np.arange(rows) - (rows - 1) / 2)
        plane = np.stack([*np.meshgrid(right, up), np.full((rows, columns), last[2])], axis=-1)
        rays, ahead = low + plane @ axes.T, np.where(axes[:, 2] == 0, 1e-300, -axes[:, 2])
        sides = np.sort((np.stack([low, high])[:, None, None] - rays) / ahead, axis=0)
        enter, leave = sides[0].max(axis=-1), sides[1].min(axis=-1)
        return cls(axes, rays + enter[..., None] * ahead, leave - enter)


def ray_traced(
    solid: Implicit,
    view: View,
    step: float,
    *,
    near: ArrayLike | None = None,
    slope: float | None = None,
    color: ArrayLike | Callable[[np.ndarray], np.ndarray] = OUTSIDE,
    progress: Progress | None = None,
) -> np.ndarray:
    """Picture of the zeros of a function, with Phong shading by its gradient.

    Parameters
    ----------
    solid : callable with a gradient
        Positive inside.
    view : View
    step, near, slope
        As for `ray_intersections`.
    color : (3,) array_like or callable
        Red, green and blue of the surface, from 0 to 1; or a function from points (k, 3) on it to
        colours (k, 3).
    progress : callable, optional
        Called as progress(done, total) with numbers of rays.

    Returns
    -------
    (rows, columns, 4) ndarray
        Colours and opacity, the lowest row first; transparent where no surface is visible.
    """
    rays, lengths = view.origins.reshape(-1, 3), view.lengths.ravel()
    ahead = -view.axes[:, 2]
    distance = ray_intersections(
        solid,
        rays,
        ahead,
        lengths,
        step,
        near=near,
        slope=slope,
        tol=_INVISIBLE * step,
        progress=progress,
    )
    hit = np.isfinite(distance)
    points = rays[hit] + distance[hit, None] * ahead
    image = np.zeros((len(rays), 4))
    own = color(points) if callable(color) else valid.as_numbers(color, "color", False)
    image[hit, :3] = phong(-solid.gradient(points) @ view.axes, own)
    image[hit, 3] = 1
    return image.reshape(*view.origins.shape[:2], 4)


def phong(normals: np.ndarray, color: np.ndarray) -> np.ndarray:
    """Colours (k, 3) of a surface with normals (right, up, to the viewer) of any length."""
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    n = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    lamp = np.array(LIGHT) / np.linalg.norm(LIGHT)
    facing = n @ lamp
    mirrored = np.maximum(2 * facing * n[:, 2] - lamp[2], 0) * (facing > 0)
    light = _AMBIENT + _DIFFUSE * np.maximum(facing, 0)
    return np.clip(light[:, None] * color + _SPECULAR * mirrored[:, None] ** _SHININESS, 0, 1)


def _axes(toward: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Return the matrix whose columns point right, up, and to the viewer."""
    towards = toward / np.linalg.norm(toward)
    right = np.cross(up, towards)
    if np.linalg.norm(right) == 0:
        raise ValueError(f"up must not be parallel to the direction to the viewer; got {up}")
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(towards, right), towards])
