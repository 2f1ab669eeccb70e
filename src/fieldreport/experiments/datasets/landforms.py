"""Landforms that isolines do not determine: summits and hollows, height bands, and terraces."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

TOP, SLOPE, HOLLOW = 1, 0, -1
LANDFORMS = {"top": TOP, "slope": SLOPE, "hollow": HOLLOW}

_WEST, _EAST = np.s_[:, :-1], np.s_[:, 1:]
_SOUTH, _NORTH = np.s_[:-1], np.s_[1:]
_NEIGHBORS = ((_WEST, _EAST), (_EAST, _WEST), (_SOUTH, _NORTH), (_NORTH, _SOUTH))


def level_below(height: np.ndarray, spacing: int) -> np.ndarray:
    """Return the level of the isoline next below each height; levels are k·spacing + ½ m.

    Examples
    --------
    >>> level_below(np.array([99.0, 101.0]), 50).tolist()
    [50.5, 100.5]
    """
    return np.floor((height - 0.5) / spacing) * spacing + 0.5


def landforms(height: np.ndarray, spacing: int) -> np.ndarray:
    """Classify cells: inside a last isoline (summit or hollow), or between two isolines.

    Isolines divide the map into pieces. A piece is a top if all its neighbours are lower, a hollow
    if all are higher, and otherwise a slope, where isolines on both sides bound the height. A piece
    at the edge is classified by its neighbours on the map.

    Parameters
    ----------
    height : ndarray of shape (rows, columns)
        Heights of a terrain.
    spacing : int
        Difference of height between isolines.

    Returns
    -------
    ndarray of int, shape (rows, columns)
        ``TOP``, ``SLOPE`` or ``HOLLOW``.

    Examples
    --------
    >>> landforms(np.array([[1.0, 9.0, 12.0, 9.0, 11.0, 21.0]]), 10).tolist()
    [[-1, -1, 1, -1, 0, 1]]
    """
    level = level_below(height, spacing)
    piece = _pieces(level)
    has_higher, has_lower = (np.zeros(piece.max() + 1, dtype=bool) for _ in range(2))
    for here, there in _NEIGHBORS:
        has_higher[piece[here][level[there] > level[here]]] = True
        has_lower[piece[here][level[there] < level[here]]] = True
    form = np.where(has_higher == has_lower, SLOPE, np.where(has_lower, TOP, HOLLOW))
    return form[piece]


def _pieces(level: np.ndarray) -> np.ndarray:
    """Number the connected pieces of equal level from 0."""
    piece = np.zeros(level.shape, dtype=int)
    for value in np.unique(level):
        numbered, _ = ndimage.label(level == value)
        piece[numbered > 0] = numbered[numbered > 0] + piece.max()
    return piece - 1


def relief_told(surface: np.ndarray, truth: np.ndarray, spacing: int, form: int) -> float:
    """Return the fraction of the relief beyond the last isolines that a surface reproduces.

    Parameters
    ----------
    surface, truth : ndarray
        Heights at cells of that form.
    spacing : int
        Difference of height between isolines.
    form : int
        ``TOP`` or ``HOLLOW``: relief is counted from the isoline below, or down from that above.
    """
    last = level_below(truth, spacing) + (spacing if form == HOLLOW else 0)
    return float(np.sum(surface - last) / np.sum(truth - last))


def beyond_band(surface: np.ndarray, truth: np.ndarray, spacing: int) -> np.ndarray:
    """Whether a surface leaves the band between two isolines that contains the true height."""
    above_level = surface - level_below(truth, spacing)
    return (above_level < 0) | (above_level > spacing)


def phase(height: np.ndarray, spacing: int) -> np.ndarray:
    """Return the position of a height between two isolines, from -½ to ½; 0 is on an isoline.

    Terraces show as a concentration of heights at 0.

    Examples
    --------
    >>> phase(np.array([50.5, 63.0, 88.0]), 50).tolist()
    [0.0, 0.25, -0.25]
    """
    z = (height - 0.5) / spacing
    return z - np.round(z)
