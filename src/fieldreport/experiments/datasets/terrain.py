"""Reconstruction of a real terrain from points on its isolines.

A topographic map gives heights along isolines. Here the isolines are computed from a known
elevation model, so that the error of a reconstructed surface is known at every cell. Least squares,
moving least squares and radial basis functions use the same points.

References
----------
Wendland, Scattered Data Approximation (2005), section 1.1.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial import cKDTree

from fieldrecon.datasets.elevation import Terrain, terrain
from fieldreport.experiments.datasets.terrain_errors import (
    LANDFORMS,
    NEAR,
    TerrainProblem,
    by_distance,
    by_landform,
    correlation,
    measured,
    part,
    phase,
    rms,
    rms_or_none,
    terrace_percent,
    windowed,
    worst_place,
)
from fieldreport.experiments.datasets.terrain_figures import draw_points_surface_land
from fieldreport.experiments.datasets.terrain_figures import plot_errors as plot_errors
from fieldreport.experiments.datasets.terrain_figures import plot_profiles as plot_profiles
from fieldreport.experiments.datasets.terrain_figures import plot_spacing as plot_spacing
from fieldreport.experiments.datasets.terrain_figures import plot_terraces as plot_terraces
from fieldreport.experiments.datasets.terrain_methods import (
    GUARDED,
    THIN_PLATE,
    TRIANGLES,
    WEIGHT,
    Method,
    Surface,
    coefficients,
    key,
    methods,
    scipy_thin_plate,
    solved,
)
from fieldreport.framework.error_measures import ROUNDING, order
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter, require

PUBLISHED_SUMMIT = 1077
"""Height of Cross Mountain in metres, from the gazetteer of the U.S. Geological Survey."""

PHASES = np.linspace(-0.5, 0.5, 26)
DISTANCES = (0.0, 0.25, 0.5, 1.0, 2.0, np.inf)
"""Classes of distance to the nearest point, in units of the points' distance on an isoline."""

QUOTED = ("inside", "outside", "median", "largest", "top_told_percent", "terrace_percent")
SCIPY_QUERIES = 2000


@dataclass(frozen=True)
class Params(Parameters):
    """The isolines, the methods, and the window in which the isolines' spacing is varied."""

    spacing: int = parameter(100, "difference of height between isolines, m", least=1, most=1000)
    apart: float = parameter(
        300.0, "smallest distance of points on isolines of one height, m", least=1, most=1e5
    )
    every: int = parameter(1, "stride of rows and columns of the elevation model", least=1)
    degrees: tuple[int, ...] = parameter(
        (1, 2, 4, 8, 12, 16, 20), "degrees of least squares", least=0, most=40, order="increasing"
    )
    shown_degree: int = parameter(
        12, "degree of least squares in maps, profiles and the window", least=0
    )
    per_coefficient: int = parameter(4, "points per coefficient in a neighbourhood of MLS", least=2)
    bound: float = parameter(
        3.0, "largest sum of |weights| that the guarded MLS accepts", least=1, most=1e6
    )
    window: tuple[float, ...] = parameter(
        (8000.0, 4000.0, 10000.0), "west, south edge, side, m", least=0, most=1e5, entries=3
    )
    spacings: tuple[int, ...] = parameter(
        (10, 20, 40, 80, 160),
        "spacings tried in the window, m",
        least=1,
        fewest=2,
        order="increasing",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        require(
            self.shown_degree in self.degrees, "shown_degree", "one of degrees", self.shown_degree
        )

    @property
    def shown(self) -> tuple[str, ...]:
        """The methods in maps, profiles and the window."""
        return (f"LS {self.shown_degree}", "MLS 1", "MLS 2", GUARDED, THIN_PLATE)

    @property
    def quoted(self) -> dict[str, str]:
        """The methods with facts, by the prefix of the names of the facts."""
        told = ("ls", "mls_1", "mls_2", "mls_guarded", "thin_plate")
        return dict(zip(told, self.shown, strict=True)) | {
            "ls_highest": f"LS {max(self.degrees)}",
            "cone": "RBF −r",
            "cubic": "RBF r³",
            "triangles": TRIANGLES,
        }


QUICK = Params(apart=600.0, every=5, degrees=(1, 4), shown_degree=4, spacings=(60, 120))
DIGITS = {"cubic_top_told_percent": 5, "thin_plate_behind_percent": 4, "difference_from_scipy": 0}


def run(params: Params, each: Map = map) -> Result:
    """Reconstruct the elevation model from its isolines, and compare."""
    return study(params, part(terrain(), np.s_[:: params.every], np.s_[:: params.every]), each)


def study(params: Params, land: Terrain, each: Map = map) -> Result:
    """Reconstruct a terrain from its isolines, and compare."""
    whole = TerrainProblem(land, params.spacing, params.apart)
    window = windowed(land, params.window)
    windows = [TerrainProblem(window, spacing, params.apart) for spacing in params.spacings]
    _require_points(whole, max(params.degrees), 2 * params.per_coefficient)
    for problem in windows:
        _require_points(problem, params.shown_degree, params.per_coefficient)
    tried = methods(params.degrees, params.per_coefficient, params.bound)
    step = max(1, len(whole.truth) // SCIPY_QUERIES)
    jobs = [
        *(_job(method, whole) for method in tried.values()),
        *(_job(tried[name], problem) for problem in windows for name in params.shown),
        _job(scipy_thin_plate, whole, step),
    ]
    *surfaces, by_scipy = each(solved, jobs)
    found = dict(zip(tried, surfaces, strict=False))
    in_window = _rms_in_window(params, windows, surfaces[len(tried) :])
    difference = by_scipy.heights - found[THIN_PLATE].heights[::step]
    return Result(
        params=params,
        tables={
            "methods": _table_of(measured, whole, found),
            "landforms": _table_of(by_landform, whole, found),
            "distances": _distances_table(params, whole, found),
            "spacings": _spacings_table(params, windows, in_window),
        },
        facts=_facts_of_land(whole)
        | _facts_of_methods(params, whole, found)
        | facts_of_weights(params.bound, whole, found)
        | _facts_of_window(params, windows, in_window)
        | {"difference_from_scipy": np.abs(difference).max()},
        arrays=_arrays(params, whole, found, in_window),
    )


def _require_points(problem: TerrainProblem, degree: int, per_coefficient: int) -> None:
    """Refuse isolines with fewer points than least squares and the neighbourhoods of MLS need."""
    wanted = max(coefficients(degree), per_coefficient * coefficients(2) + 1)
    given = len(problem.isolines[0])
    if given < wanted:
        raise ValueError(
            f"the isolines every {problem.spacing:g} m must hold {wanted} points or more; they "
            f"hold {given} (smaller spacings, a smaller apart, a larger window or lower degrees "
            "help)"
        )


def _job(
    method: Method, problem: TerrainProblem, step: int = 1
) -> tuple[Method, np.ndarray, np.ndarray, np.ndarray]:
    return method, *problem.isolines, problem.land.points[::step]


def _table_of(
    judge: Callable[[TerrainProblem, Surface], dict[str, Cell]],
    problem: TerrainProblem,
    found: Mapping[str, Surface],
) -> ResultTable:
    rows = {name: judge(problem, surface) for name, surface in found.items()}
    columns = ("method", *next(iter(rows.values())))
    return ResultTable(columns, tuple((name, *row.values()) for name, row in rows.items()))


def _distances_table(
    params: Params, problem: TerrainProblem, found: Mapping[str, Surface]
) -> ResultTable:
    edges = np.array(DISTANCES) * problem.apart
    share = 100 * np.histogram(problem.distance, edges)[0] / problem.distance.size
    columns = (by_distance(problem, found[name], edges) for name in params.shown)
    rows = zip(edges[:-1], share, *columns, strict=True)
    return ResultTable(("from", "cells percent", *params.shown), tuple(rows))


def _rms_in_window(
    params: Params, windows: list[TerrainProblem], surfaces: Iterable[Surface]
) -> dict[str, np.ndarray]:
    """Return the rms error for each spacing, by the method."""
    left = iter(surfaces)
    errors = [[rms(next(left).heights - w.truth) for _ in params.shown] for w in windows]
    return dict(zip(params.shown, np.transpose(errors), strict=True))


def _spacings_table(
    params: Params, windows: list[TerrainProblem], in_window: Mapping[str, np.ndarray]
) -> ResultTable:
    points = [len(problem.isolines[0]) for problem in windows]
    rows = zip(params.spacings, points, *in_window.values(), strict=True)
    return ResultTable(("spacing", "points", *in_window), tuple(rows))


def _facts_of_land(problem: TerrainProblem) -> dict[str, Cell]:
    land = problem.land
    return {
        "rows": len(land.y),
        "columns": len(land.x),
        "cells": land.height.size,
        "width_km": land.x[-1] / 1000,
        "length_km": land.y[-1] / 1000,
        "lowest": int(land.height.min()),
        "highest": int(land.height.max()),
        "mean_height": land.height.mean(),
        "published_summit": PUBLISHED_SUMMIT,
        "points": len(problem.isolines[0]),
        "levels": len(np.unique(problem.isolines[1])),
        "outside_percent": 100 * problem.outside.mean(),
        "near_percent": 100 * NEAR,
        "truth_terrace_percent": terrace_percent(problem.truth, problem.spacing),
    } | {f"{name}_percent": 100 * np.mean(problem.form == f) for name, f in LANDFORMS.items()}


def _facts_of_methods(
    params: Params, problem: TerrainProblem, found: Mapping[str, Surface]
) -> dict[str, Cell]:
    """Return the facts from the tables, and which method is best inside the hull."""
    facts: dict[str, Cell] = {}
    for told, name in params.quoted.items():
        judged = measured(problem, found[name]) | by_landform(problem, found[name])
        facts |= {f"{told}_{measure}": judged[measure] for measure in QUOTED}
    inside = {name: float(facts[f"{told}_inside"]) for told, name in params.quoted.items()}
    best = min(inside, key=inside.__getitem__)
    return (
        facts
        | {
            f"{told}_correlation": correlation(problem, found[name])
            for told, name in params.quoted.items()
            if name != TRIANGLES
        }
        | {
            f"thin_plate_worst_{k}": value
            for k, value in worst_place(problem, found[THIN_PLATE]).items()
        }
        | {
            "best": best,
            "thin_plate_behind_percent": 100 * (inside[THIN_PLATE] / inside[best] - 1),
            "highest_degree": max(params.degrees),
        }
    )


def _facts_of_window(
    params: Params, windows: list[TerrainProblem], in_window: Mapping[str, np.ndarray]
) -> dict[str, Cell]:
    """Return the power of the spacing with which each error decreases, and its end values."""
    finest, coarsest = np.argmin(params.spacings), np.argmax(params.spacings)
    facts: dict[str, Cell] = {
        "window_finest_points": len(windows[finest].isolines[0]),
        "window_coarsest_points": len(windows[coarsest].isolines[0]),
    }
    for told, name in params.quoted.items():
        if name in in_window:
            errors = in_window[name]
            facts |= {
                f"window_{told}_finest": errors[finest],
                f"window_{told}_coarsest": errors[coarsest],
            }
            if errors.min() > ROUNDING:  # a method may reproduce the land
                facts[f"window_{told}_power"] = order(params.spacings, errors)
    return facts


def _arrays(
    params: Params,
    problem: TerrainProblem,
    found: Mapping[str, Surface],
    in_window: Mapping[str, np.ndarray],
) -> dict[str, np.ndarray]:
    land, shape = problem.land, problem.land.height.shape
    heights = [problem.truth, *(found[name].heights for name in params.shown)]
    shares = [np.histogram(phase(h, params.spacing), PHASES)[0] / h.size for h in heights]
    return {
        "x": land.x,
        "y": land.y,
        "truth": land.height,
        "points": problem.isolines[0],
        "heights": problem.isolines[1],
        "amplification": found["MLS 2"].amplification.reshape(shape).astype(np.float32),
        "phase_edges": PHASES,
        "phase_shares": np.array(shares),
        "window_rms": np.array(list(in_window.values())),
    } | {key(name): found[name].heights.reshape(shape).astype(np.float32) for name in params.shown}


def facts_of_weights(
    bound: float, problem: TerrainProblem, found: Mapping[str, Surface]
) -> dict[str, Cell]:
    """Return the relation of errors to neighbourhoods of one height, and to large weights.

    Parameters
    ----------
    bound : float
        Sum of the absolute weights above which a point counts as unsafe.
    problem : TerrainProblem
    found : mapping of str to Surface
        Must contain those of moving least squares of degree 1 and 2.
    """
    linear, quadratic = found["MLS 1"], found["MLS 2"]
    errors = linear.heights - problem.truth
    flat = on_one_isoline(problem, linear.neighbors)
    square = (quadratic.heights - problem.truth) ** 2
    unsafe, worst = quadratic.amplification > bound, square.argmax()
    away, spread = standoff(problem.isolines[0], problem.land.points[worst], quadratic.neighbors)
    return {
        "neighbors_1": linear.neighbors,
        "neighbors_2": quadratic.neighbors,
        "one_isoline_percent": 100 * flat.mean(),
        "one_isoline_rms": rms_or_none(errors[flat]),
        "other_rms": rms_or_none(errors[~flat]),
        "median_amplification": np.median(quadratic.amplification),
        "mls_2_worst_amplification": quadratic.amplification[worst],
        "mls_2_worst_away": away,
        "mls_2_worst_spread": spread,
        "unsafe_percent": 100 * unsafe.mean(),
        "unsafe_share_percent": 100 * square[unsafe].sum() / square.sum(),
        "safe_rms": rms_or_none(np.sqrt(square[~unsafe])),
        "mean_percent": 100 * np.mean(unsafe & (linear.amplification > bound)),
    }


def on_one_isoline(problem: TerrainProblem, neighbors: int) -> np.ndarray:
    """Whether the nearest points of a cell all have the same height."""
    points, heights = problem.isolines
    nearest = cKDTree(points).query(problem.land.points, neighbors)[1]
    return np.ptp(heights[nearest], axis=1) == 0


def standoff(points: np.ndarray, x: np.ndarray, neighbors: int) -> tuple[float, float]:
    """Return the distance of a point from the mean of its neighbours, and their smallest spread.

    Mean and spread have the weights of moving least squares; the spread is that in the direction in
    which it is smallest. Far from a narrow row of points, a fit is an extrapolation.

    Parameters
    ----------
    points : ndarray of shape (n, 2)
    x : ndarray of shape (2,)
    neighbors : int

    Examples
    --------
    >>> row = np.array([[-1.0, 0.0], [0.0, 0.0], [1.0, 0.0], [9.0, 0.0]])
    >>> standoff(row, np.array([0.0, 5.0]), 3)
    (5.0, 0.0)
    """
    distance, index = cKDTree(points).query(x, neighbors + 1)
    weight = WEIGHT(distance[:-1] / distance[-1]) ** 2
    weight /= weight.sum()
    near = points[index[:-1]]
    mean = weight @ near
    covariance = (weight[:, None] * (near - mean)).T @ (near - mean)
    least = np.linalg.eigvalsh(covariance)[0]
    return float(np.linalg.norm(x - mean)), float(np.sqrt(max(least, 0.0)))


def plot(result: Result) -> Figure:
    """The points, the reconstructed surface, and the terrain."""
    return draw_points_surface_land(result)
