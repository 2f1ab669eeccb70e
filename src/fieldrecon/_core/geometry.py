"""Normals of triangles in space."""

from __future__ import annotations

import numpy as np


def triangle_normals(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return (b - a) x (c - a) (..., 3): normals whose length is twice the area.

    Seen from the side to which the normal points, a, b, c run counter-clockwise.
    """
    return np.cross(b - a, c - a)
