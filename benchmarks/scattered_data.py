"""Scattered data sets: sites, values, and queries at which the exact value is known."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from fieldrecon.datasets.elevation import terrain
from fieldrecon.datasets.synthetic import clustered, franke, uniform


@dataclass(frozen=True)
class Scattered:
    """Samples (n, d) with values (n,), and queries (m, d) with the exact values (m,)."""

    points: np.ndarray
    values: np.ndarray
    x: np.ndarray
    truth: np.ndarray


def smooth(n: int) -> Scattered:
    """Franke's function at uniformly distributed points."""
    return _sampled(franke, uniform(n, 2, seed=1), uniform(n, 2, seed=2))


def front(n: int) -> Scattered:
    """A step of width 1/25 along a quarter of a circle."""
    return _sampled(_front, uniform(n, 2, seed=1), uniform(n, 2, seed=2))


def noisy(n: int) -> Scattered:
    """Franke's function with noise of standard deviation 0.01.

    Errors refer to the exact function.
    """
    exact = smooth(n)
    errors = 0.01 * np.random.default_rng(3).standard_normal(n)
    return Scattered(exact.points, exact.values + errors, exact.x, exact.truth)


def clusters(n: int) -> Scattered:
    """Franke's function with half of the sites in twelve clusters."""
    crowd = clustered(n - n // 2, 2, clusters=12, spread=0.01, seed=1)
    return _sampled(
        franke, np.concatenate([crowd, uniform(n // 2, 2, seed=4)]), uniform(n, 2, seed=2)
    )


def cube(n: int) -> Scattered:
    """A product of sines in three variables."""
    return _sampled(_wave, uniform(n, 3, seed=1), uniform(n, 3, seed=2))


def land(n: int) -> Scattered:
    """Elevations in metres at the nodes of a grid; the sites are random nodes."""
    grid = terrain()
    return _some(grid.points, grid.height.ravel().astype(float), n)


def survey_files() -> dict[str, Path]:
    """Tables x, y, value of surveys by name, in the folder that FIELDRECON_SURVEYS names."""
    folder = os.environ.get("FIELDRECON_SURVEYS")
    return {path.stem: path for path in sorted(Path(folder).glob("*.csv"))} if folder else {}


def survey_samples(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Samples (n, 2) and values (n,) of a table."""
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    return table[:, :2], table[:, 2]


def survey(path: Path, n: int) -> Scattered:
    """A table; the sites are random samples."""
    return _some(*survey_samples(path), n)


DATA: dict[str, Callable[[int], Scattered]] = {
    "smooth": smooth,
    "front": front,
    "noisy": noisy,
    "clusters": clusters,
    "cube": cube,
    "terrain": land,
} | {name: partial(survey, path) for name, path in survey_files().items()}


def _some(points: np.ndarray, values: np.ndarray, n: int) -> Scattered:
    """Random samples are the sites, and all others the queries."""
    chosen = np.zeros(len(points), dtype=bool)
    chosen[np.random.default_rng(1).choice(len(points), n, replace=False)] = True
    return Scattered(points[chosen], values[chosen], points[~chosen], values[~chosen])


def _sampled(f: Callable[[np.ndarray], np.ndarray], points: np.ndarray, x: np.ndarray) -> Scattered:
    return Scattered(points, f(points), x, f(x))


def _front(x: np.ndarray) -> np.ndarray:
    return np.tanh(25.0 * (np.hypot(*x.T) - 0.7))


def _wave(x: np.ndarray) -> np.ndarray:
    return np.sin(4.0 * x).prod(axis=-1)
