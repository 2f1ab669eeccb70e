"""Rasterization: pictures of triangles, with lighting by the normals at their vertices."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core.geometry import triangle_normals
from fieldrecon.solids.ray_casting import OUTSIDE, View, phong

_ROUNDING = 1e-9  # by which a pixel may lie outside of a triangle, so that none falls between two


def rasterized(
    points: np.ndarray, triangles: np.ndarray, view: View, color: ArrayLike = OUTSIDE
) -> np.ndarray:
    """Picture of triangles, with Phong shading by the normals at their vertices.

    The normal at a vertex is the sum of those of its triangles, weighted by their areas. Of the
    triangles at a pixel the nearest to the viewer is visible.

    Parameters
    ----------
    points : (n, 3) ndarray
    triangles : (m, 3) ndarray of int
        Counter-clockwise when seen from outside.
    view : View
    color : (3,) or (m, 3) array_like
        Red, green and blue, from 0 to 1, of all triangles or of each.

    Returns
    -------
    (rows, columns, 4) ndarray
        Colours and opacity, the lowest row first; transparent where there is no triangle.
    """
    rows, columns = view.lengths.shape
    seen = points @ view.axes  # to the right, up, and to the viewer
    triangle, pixel, share = _covered(_in_pixels(seen, view)[triangles], (columns, rows))
    corners = triangles[triangle]
    flat = pixel[:, 1] * columns + pixel[:, 0]
    order = np.lexsort((np.einsum("pc,pc->p", share, seen[corners, 2]), flat))
    nearest = order[np.diff(flat[order], append=-1) != 0]
    normals = _vertex_normals(seen, triangles)[corners[nearest]]
    own = np.broadcast_to(color, triangles.shape)[triangle[nearest]]
    image = np.zeros((rows * columns, 4))
    image[flat[nearest], :3] = phong(np.einsum("pc,pcd->pd", share[nearest], normals), own)
    image[flat[nearest], 3] = 1
    return image.reshape(rows, columns, 4)


def _in_pixels(seen: np.ndarray, view: View) -> np.ndarray:
    """Columns and rows (n, 2), not rounded, of points given to the right and up."""
    middles = view.origins @ view.axes[:, :2]
    first, last = middles[0, 0], middles[-1, -1]
    size = (last - first).max() / max(1, *(n - 1 for n in view.lengths.shape))
    return (seen[:, :2] - first) / size


def _covered(
    corners: np.ndarray, shape: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangles (p,), the pixels (p, 2) that they cover, and the shares (p, 3) of their corners."""
    low = np.maximum(np.ceil(corners.min(axis=1)), 0).astype(np.intp)
    high = np.minimum(np.floor(corners.max(axis=1)), np.array(shape) - 1).astype(np.intp)
    extent = np.maximum(high - low + 1, 0)
    count = extent.prod(axis=1)
    triangle = np.repeat(np.arange(len(corners)), count)
    each = np.arange(len(triangle)) - np.repeat(np.cumsum(count) - count, count)
    width = extent[triangle, 0]
    pixel = low[triangle] + np.column_stack([each % width, each // width])
    a, b, c = np.moveaxis(corners[triangle], 1, 0)
    doubled = _cross(b - a, c - a)
    parts = np.column_stack([_cross(q - pixel, r - pixel) for q, r in ((b, c), (c, a), (a, b))])
    share = np.divide(
        parts, doubled[:, None], out=np.full_like(parts, -1.0), where=doubled[:, None] != 0
    )
    inside = (share >= -_ROUNDING).all(axis=1)
    return triangle[inside], pixel[inside], share[inside]


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


def _vertex_normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Sums (n, 3) of the normals of the triangles at each vertex, which have twice their areas."""
    a, b, c = points[triangles].swapaxes(0, 1)
    normals = np.repeat(triangle_normals(a, b, c), 3, axis=0)
    corners = triangles.ravel()
    return np.column_stack([np.bincount(corners, n, len(points)) for n in normals.T])
