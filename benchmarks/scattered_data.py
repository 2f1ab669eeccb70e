"""Scattered data sets: sites, values, and queries at which the exact value is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

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
    """Elevations in metres: random nodes of a grid are the sites, all other nodes the queries."""
    grid = terrain()
    points, height = grid.points, grid.height.ravel().astype(float)
    chosen = np.zeros(len(points), dtype=bool)
    chosen[np.random.default_rng(1).choice(len(points), n, replace=False)] = True
    return Scattered(points[chosen], height[chosen], points[~chosen], height[~chosen])


DATA: dict[str, Callable[[int], Scattered]] = {
    "smooth": smooth,
    "front": front,
    "noisy": noisy,
    "clusters": clusters,
    "cube": cube,
    "terrain": land,
}


def _sampled(f: Callable[[np.ndarray], np.ndarray], points: np.ndarray, x: np.ndarray) -> Scattered:
    return Scattered(points, f(points), x, f(x))


def _front(x: np.ndarray) -> np.ndarray:
    return np.tanh(25.0 * (np.hypot(*x.T) - 0.7))


def _wave(x: np.ndarray) -> np.ndarray:
    return np.sin(4.0 * x).prod(axis=-1)
