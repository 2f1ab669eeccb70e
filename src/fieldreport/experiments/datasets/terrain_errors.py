"""Errors of reconstructed terrain: overall, by landform, and by distance from the points."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon.datasets.elevation import Terrain
from fieldrecon.selection.extrapolation import outside_hull
from fieldreport.experiments.datasets.landforms import (
    LANDFORMS,
    SLOPE,
    beyond_band,
    landforms,
    phase,
    relief_told,
)
from fieldreport.experiments.datasets.terrain_methods import Surface
from fieldreport.framework.experiment import Cell

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
