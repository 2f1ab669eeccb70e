"""Patches over small holes: of all triangulations of a loop the one of least area.

References
----------
Barequet and Sharir, Filling Gaps in the Boundary of a Polyhedron (1995).
"""

from __future__ import annotations

import numpy as np

LONGEST = 32
"""Edges of the longest loop that is filled; the work grows with the third power."""


def patches(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of least total area over many loops (l, k, 3) of equal length.

    Returns
    -------
    triangles : (l, k - 2, 3) ndarray of int
        By the places of the corners in the loop, in its direction round.
    areas : (l,) ndarray
    """
    loops, k = corners.shape[:2]
    least = np.zeros((loops, k, k))
    choice = np.zeros((loops, k, k), dtype=np.intp)
    for span in range(2, k):
        for i in range(k - span):
            j, between = i + span, np.arange(i + 1, i + span)
            area = _areas(corners[:, i, None], corners[:, between], corners[:, j, None])
            total = area + least[:, i, between] + least[:, between, j]
            best = total.argmin(axis=1)
            choice[:, i, j] = between[best]
            least[:, i, j] = np.take_along_axis(total, best[:, None], axis=1)[:, 0]
    return _chosen(choice), least[:, 0, k - 1]


def _chosen(choice: np.ndarray) -> np.ndarray:
    """Follow the choices (l, k, k): the triangle over a span, then those over its two parts."""
    loops, k = choice.shape[:2]
    triangles = np.empty((loops, k - 2, 3), dtype=np.intp)
    row = np.arange(loops)
    spans = np.tile([0, k - 1], (loops, k, 1))
    waiting = np.ones(loops, dtype=np.intp)  # spans of each loop that still lack their triangle
    for t in range(k - 2):
        waiting -= 1
        i, j = spans[row, waiting].T
        middle = choice[row, i, j]
        triangles[:, t] = np.column_stack([i, middle, j])
        for a, b in ((i, middle), (middle, j)):
            spans[row, waiting] = np.column_stack([a, b])
            waiting += b - a > 1
    return triangles


def _areas(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    normal = np.cross(b - a, c - a)
    return np.sqrt(np.einsum("...i,...i->...", normal, normal)) / 2
