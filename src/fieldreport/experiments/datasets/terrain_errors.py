"""Errors of reconstructed terrain: overall, by landform, and by distance from the points."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from fieldrecon.datasets.elevation import Terrain
from fieldrecon.selection.extrapolation import outside_hull
from fieldreport.experiments.datasets.terrain_methods import Surface
from fieldreport.framework.experiment import Cell

TOP, SLOPE, HOLLOW = 1, 0, -1
LANDFORMS = {"top": TOP, "slope": SLOPE, "hollow": HOLLOW}

_WEST, _EAST = np.s_[:, :-1], np.s_[:, 1:]
_SOUTH, _NORTH = np.s_[:-1], np.s_[1:]
_NEIGHBORS = ((_WEST, _EAST), (_EAST, _WEST), (_SOUTH, _NORTH), (_NORTH, _SOUTH))

NEAR = 0.05
"""A height is on a terrace if it is within this fraction of the spacing from that of an isoline."""


@dataclass(frozen=True, eq=False)
class TerrainProblem:
    """A terrain to be reconstructed from points on its isolines.

    Parameters
    ----------
    land : Terrain
    spacing : int
        Difference of height between isolines, metres.
    apart : float
        Smallest distance of points on isolines of one height, metres.
    """

    land: Terrain
    spacing: int
    apart: float

    @cached_property
    def isolines(self) -> tuple[np.ndarray, np.ndarray]:
        """The points (n, 2) and their heights (n,)."""
        return self.land.isolines(self.spacing, self.apart)

    @cached_property
    def truth(self) -> np.ndarray:
        """The heights of all cells (m,)."""
        return self.land.height.ravel()

    @cached_property
    def outside(self) -> np.ndarray:
        """Whether each cell lies outside the convex hull of the points."""
        return outside_hull(self.isolines[0], self.land.points)

    @cached_property
    def distance(self) -> np.ndarray:
        """Distance of each cell from the nearest point, metres."""
        return cKDTree(self.isolines[0]).query(self.land.points)[0]

    @cached_property
    def form(self) -> np.ndarray:
        """The landform of each cell."""
        return landforms(self.land.height, self.spacing).ravel()


def part(land: Terrain, rows: slice | np.ndarray, columns: slice | np.ndarray) -> Terrain:
    """Return rows and columns of a land."""
    return Terrain(land.x[columns], land.y[rows], land.height[rows][:, columns])


def windowed(land: Terrain, window: tuple[float, ...]) -> Terrain:
    """Return the square of a land with a given western edge, southern edge and side."""
    west, south, side = window
    columns = (land.x >= west) & (land.x <= west + side)
    rows = (land.y >= south) & (land.y <= south + side)
    if min(columns.sum(), rows.sum()) < 3:
        raise ValueError(f"parameter window must hold 3 or more rows and columns; got {window}")
    return part(land, rows, columns)


def rms(errors: np.ndarray) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(errors**2)))


MEASURES: Mapping[str, Callable[[np.ndarray], float]] = {
    "rms": rms,
    "median": lambda errors: float(np.median(np.abs(errors))),
    "percentile_95": lambda errors: float(np.percentile(np.abs(errors), 95)),
    "largest": lambda errors: float(np.abs(errors).max()),
    "bias": lambda errors: float(errors.mean()),
}

NONE = "none"
"""The value that is reported for an empty set of cells."""


def rms_or_none(errors: np.ndarray) -> Cell:
    """Return the root of the mean square, or `NONE` for an empty set."""
    return rms(errors) if errors.size else NONE


def measured(problem: TerrainProblem, surface: Surface) -> dict[str, Cell]:
    """Return the errors of a surface in metres, inside and outside the hull of the points."""
    known = np.isfinite(surface.heights)
    errors = surface.heights - problem.truth
    beyond = beyond_band(surface.heights[known], problem.truth[known], problem.spacing)
    return {name: measure(errors[known]) for name, measure in MEASURES.items()} | {
        "inside": rms(errors[known & ~problem.outside]),
        "outside": rms_or_none(errors[known & problem.outside]),
        "beyond_band_percent": 100 * float(beyond.mean()),
    }


def by_landform(problem: TerrainProblem, surface: Surface) -> dict[str, Cell]:
    """Return errors on tops, slopes and hollows, and the fraction of relief that is reproduced."""
    known = np.isfinite(surface.heights)
    result: dict[str, Cell] = {}
    for name, form in LANDFORMS.items():
        here = known & (problem.form == form)
        heights, truth = surface.heights[here], problem.truth[here]
        result[f"{name}_rms"] = rms_or_none(heights - truth)
        result[f"{name}_bias"] = float(np.mean(heights - truth)) if here.any() else NONE
        if form != SLOPE:
            told = f"{name}_told_percent"
            result[told] = NONE
            if here.any():
                result[told] = 100 * relief_told(heights, truth, problem.spacing, form)
    return result | {"terrace_percent": terrace_percent(surface.heights[known], problem.spacing)}


def by_distance(problem: TerrainProblem, surface: Surface, edges: np.ndarray) -> list[Cell]:
    """Return the rms error of cells by their distance from the nearest point."""
    errors = surface.heights - problem.truth
    place = np.digitize(problem.distance, edges) - 1
    return [rms_or_none(errors[place == k]) for k in range(len(edges) - 1)]


def terrace_percent(heights: np.ndarray, spacing: int) -> float:
    """Return the percentage of heights close to that of an isoline."""
    return 100 * float(np.mean(np.abs(phase(heights, spacing)) < NEAR))


def correlation(problem: TerrainProblem, surface: Surface) -> float:
    """Return the correlation of the absolute error with the distance from the nearest point."""
    sizes = np.abs(surface.heights - problem.truth)
    return float(np.corrcoef(sizes, problem.distance)[0, 1])


def worst_place(problem: TerrainProblem, surface: Surface) -> dict[str, float]:
    """Return the heights where the error is largest, and the distance of the nearest point."""
    worst = np.abs(surface.heights - problem.truth).argmax()
    return {
        "distance": float(problem.distance[worst]),
        "height": float(surface.heights[worst]),
        "truth": float(problem.truth[worst]),
    }


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
