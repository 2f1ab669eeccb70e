"""The body that loose triangles of a file bound, ready to be meshed."""

from __future__ import annotations

import numpy as np

from fieldrecon.polygon_soup import PolygonSoup
from fieldrecon.solids import Solid

CELLS = 80
"""Triangles of the mesh along the longest side, where nobody says how fine."""
_TOLERANCE = 1e-4
_MARGIN = 4.0  # edges or epsilons that the box keeps from the triangles


class SoupBody(Solid):
    """The body of a `PolygonSoup` of triangles, through them or, if epsilon is positive, around.

    Parameters
    ----------
    points : (n, 3) ndarray
    triangles : (m, 3) ndarray of int
    epsilon : float
    spacing : float, optional
        How fine it is to be known.

    Attributes
    ----------
    points : (k, 3) ndarray
        Places on the triangles, `spacing` apart or less.
    remarks : tuple of str
        What is to be known, in sentences.
    """

    spacing: float

    def __init__(
        self,
        points: np.ndarray,
        triangles: np.ndarray,
        epsilon: float,
        spacing: float | None = None,
    ) -> None:
        soup = PolygonSoup(points, triangles, epsilon, tolerance=_TOLERANCE)
        self.soup = soup.enclosing() if epsilon else soup
        corners = points[triangles]
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        self.spacing = float((high - low).max() / CELLS) if spacing is None else spacing
        self.points = self.near = places_on(corners, self.spacing)
        margin = _MARGIN * max(self.spacing, epsilon)
        self.box = np.array([low - margin, high + margin])
        where = f"around them, smoothed below {epsilon:.3g}" if epsilon else "through them"
        self.remarks = (f"The {len(triangles):,} triangles are loose; the surface goes {where}.",)

    def _values(self, x: np.ndarray) -> np.ndarray:
        return self.soup(x)

    def _gradients(self, x: np.ndarray) -> np.ndarray:
        return self.soup.gradient(x)


def places_on(corners: np.ndarray, spacing: float) -> np.ndarray:
    """Places (k, 3) on triangles (m, 3, 3), their corners among them, not farther apart.

    Examples
    --------
    >>> len(places_on(np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]]), 0.5))
    10
    """
    sides = corners - np.roll(corners, 1, axis=1)
    cuts = np.ceil(np.linalg.norm(sides, axis=2).max(axis=1) / spacing).astype(int)
    parts = []
    for n in np.unique(np.maximum(cuts, 1)):
        i, j = np.nonzero(np.add.outer(np.arange(n + 1), np.arange(n + 1)) <= n)
        shares = np.stack([n - i - j, i, j], axis=1) / n
        own = corners[np.maximum(cuts, 1) == n]
        parts.append(np.einsum("sc,mcd->msd", shares, own).reshape(-1, 3))
    return np.unique(np.concatenate(parts), axis=0)
