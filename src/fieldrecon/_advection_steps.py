"""One step of semi-Lagrangian advection, and what is kept in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from fieldrecon import _validation as valid
from fieldrecon._keeping import within
from fieldrecon.characteristics import Entries, Inflow, Velocity, departure_points, entries
from fieldrecon.reconstruction import Field, Reconstruction, Weights, weights_if_they_fit

Masses: TypeAlias = ArrayLike | Callable[[Reconstruction], ArrayLike]
"""Masses (n,) of the sites, or what gives them for the sites of a method."""


@dataclass(frozen=True)
class Step:
    """One step: from which field, to which sites, by which feet."""

    method: Reconstruction
    following: Reconstruction
    dt: float
    feet: np.ndarray
    came_in: Entries | None
    weights: Weights | None

    @classmethod
    def back(
        cls,
        method: Reconstruction,
        following: Reconstruction,
        velocity: Velocity | Field,
        t: float,
        dt: float,
        scheme: str,
        inflow: Inflow | None,
        kept: bool,
    ) -> Step:
        x = following.points
        feet = departure_points(x, velocity, t, dt, scheme)
        came_in = None
        if inflow is not None:
            came_in = entries(x, feet, velocity, t, dt, inflow)
            feet[came_in.which] = came_in.places
        weights = weights_if_they_fit(method, feet) if kept else None
        return cls(method, following, dt, feet, came_in, weights)

    def serves(self, method: Reconstruction, following: Reconstruction, dt: float) -> bool:
        """Whether another step, too, has these feet, on these sites."""
        same = self.method is method and self.following is following
        return same and abs(dt - self.dt) <= 1e-9 * self.dt

    def incoming(self, inflow: Inflow | None, t: float, tail: tuple[int, ...]) -> np.ndarray | None:
        """Values (k, v) of the characteristics that came in through the boundary."""
        if inflow is None or self.came_in is None:
            return None
        _, places, delays = self.came_in
        found = valid.as_values(inflow.values(places, t - delays), len(places), "inflow.values")
        if found.shape[1:] != tail:
            raise ValueError(
                f"inflow.values must give values of the shape {(len(places), *tail)}; "
                f"got {found.shape}"
            )
        return found.reshape(len(places), int(np.prod(tail, dtype=int)))

    def moved(self, values: np.ndarray, fixed: np.ndarray | None) -> np.ndarray:
        """Values (m, v) after the step."""
        if self.weights is None:
            result = self.method.field(values)(self.feet)
        else:
            result = self.weights @ values
        return self._with(result, fixed)

    def bounds(self, values: np.ndarray, fixed: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
        """The least and the greatest values (m, v) at the sites nearest to each foot."""
        n, d = self.method.points.shape
        _, near = cKDTree(self.method.points).query(self.feet, min(2**d, n))
        around = values[near.reshape(len(self.feet), -1)]
        low, high = around.min(axis=1), around.max(axis=1)
        return self._with(low, fixed), self._with(high, fixed)

    def _with(self, result: np.ndarray, fixed: np.ndarray | None) -> np.ndarray:
        if self.came_in is not None and fixed is not None:
            result[self.came_in.which] = fixed
        return result


@dataclass(frozen=True)
class Kept:
    """What is kept beside: bounds, and a total."""

    bounded: bool
    masses: Masses | None
    total: np.ndarray | None

    def kept(
        self, step: Step, values: np.ndarray, moved: np.ndarray, fixed: np.ndarray | None
    ) -> np.ndarray:
        """The moved values (m, v), changed as little as needed."""
        if not self.bounded and self.total is None:
            return moved
        low, high = (
            step.bounds(values, fixed)
            if self.bounded
            else (np.full_like(moved, -np.inf), np.full_like(moved, np.inf))
        )
        if self.masses is None or self.total is None:
            return np.clip(moved, low, high)
        return within(moved, low, high, as_masses(self.masses, step.following), self.total)


def as_masses(masses: Masses, method: Reconstruction) -> np.ndarray:
    m = valid.as_values(
        masses(method) if callable(masses) else masses, len(method.points), "masses"
    )
    if m.ndim != 1 or not (m > 0).all():
        raise ValueError(f"masses must be positive, one for each site; got the shape {m.shape}")
    return m
