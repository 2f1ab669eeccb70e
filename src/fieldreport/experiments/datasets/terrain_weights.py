"""Weights of moving least squares as predictors of its errors, from the points alone."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial import cKDTree

from fieldreport.experiments.datasets.terrain_errors import TerrainProblem, rms_or_none
from fieldreport.experiments.datasets.terrain_methods import WEIGHT, Surface
from fieldreport.framework.experiment import Cell


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
