"""Ray tracing of the zeros of an implicit function: a parallel ray for every pixel."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core.chunks import Progress
from fieldrecon.solids.ray_casting import ray_intersections

LIGHT = (-0.35, 0.5, 0.8)
"""Direction to the light: from the left, from above, and from the side of the viewer."""
OUTSIDE = (0.851, 0.867, 0.890)
_AMBIENT, _DIFFUSE, _SPECULAR, _SHININESS = 0.28, 0.66, 0.16, 24
_INVISIBLE = 1e-3  # of a step


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
            Number of pixels along the longer side.
        up : (3,) array_like
            Direction that points up in the picture.

        Examples
        --------
        >>> View.of_box([[0, 0, 0], [2, 1, 1]], toward=[0, -1, 0], pixels=40).origins.shape
        (20, 40, 3)
        """
        low, high = np.asarray(box, dtype=float)
        axes = _axes(np.asarray(toward, dtype=float), np.asarray(up, dtype=float))
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
    own = color(points) if callable(color) else np.asarray(color, dtype=float)
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
