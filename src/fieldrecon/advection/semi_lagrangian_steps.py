"""Semi-Lagrangian advection: a time step is H at the feet of the characteristics.

After each step the values may be limited to bounds and to a conserved total mass.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon.advection.characteristics import (
    Entries,
    Inflow,
    Velocity,
    departure_points,
    entries,
)
from fieldrecon.advection.mass_fixer import project_to_bounds_and_mass
from fieldrecon.fields import Field
from fieldrecon.reconstruction import Reconstruction, Weights, weights_if_they_fit

Masses: TypeAlias = ArrayLike | Callable[[Reconstruction], ArrayLike]
"""Masses (n,) of the sites, or a function that returns them for the sites of a method."""


class State(NamedTuple):
    """A field in time.

    Attributes
    ----------
    time : float
    method : Reconstruction
        The method on the sites of that time.
    values : (n, ...) ndarray
        The values at the sites; `method.field(values)` is the field.
    """

    time: float
    method: Reconstruction
    values: np.ndarray


def semi_lagrangian(
    method: Reconstruction,
    values: ArrayLike,
    velocity: Velocity | Field | None,
    times: ArrayLike,
    *,
    scheme: str = "rk4",
    steady: bool = False,
    inflow: Inflow | None = None,
    sites: Callable[[State, float], Reconstruction] | None = None,
    bounded: bool = False,
    masses: Masses | None = None,
) -> Iterator[State]:
    """Solve u_t + a · ∇u = 0 by tracing the characteristics back for each time step.

    A step is u(x, t) = s_{u(t - dt)}(y), with the departure points y of x. There is no CFL limit.
    The step is linear in the values, with the matrix H = `method.weights(y)`, and many steps are
    stable if the powers of H are bounded. If a departure point is outside the sites and there is
    no inflow, the method extrapolates.

    Parameters
    ----------
    method : Reconstruction
        A method on the sites at the first time.
    values : (n, ...) array_like
        The values at that time: scalars, vectors or arrays; each component is advected separately.
    velocity : callable, Field or None
        As for `departure_points`. None if the values are the velocity, u_t + u · ∇u = 0 (Burgers);
        it is then extrapolated from the last two steps, to second order.
    times : (k,) array_like
        Increasing times; the first is the time of the values.
    scheme : {"rk4", "heun", "midpoint", "euler"}
        The Runge-Kutta scheme for the characteristics.
    steady : bool
        Whether the velocity does not depend on time. Then, as for a Field, the departure points
        and weights are computed once for all steps of the same length.
    inflow : Inflow, optional
        The domain, and the values at its inflow boundary.
    sites : callable, optional
        Takes the last state and the next time, and returns the method on the sites of the next
        state; by default the sites do not change.
    bounded : bool
        Whether to limit each new value to the range of the values at the 2^d sites nearest to its
        departure point.
    masses : (n,) array_like or callable, optional
        Positive masses m of the sites, or a function that returns them for a method. The total
        sum m u is then conserved, by the correction with the smallest sum m (correction)^2. In a
        divergence-free flow without flux through the boundary this total is the mass.

    Yields
    ------
    State
        The first state, then the state at each time.

    Raises
    ------
    ValueError
        If an argument has the wrong form, or no values within bounds have that mass.

    References
    ----------
    Wendland (2005), section 1.3; Staniforth and Côté (1991); Bermejo and Staniforth (1992) for the
    bounds, Bermejo and Conde (2002) for the mass.

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> points = fr.datasets.halton(500, 2) * 2 - 1
    >>> points = points[np.linalg.norm(points, axis=1) < 1]
    >>> turn = lambda y, _: y[:, ::-1] * [-1, 1]
    >>> hill = lambda x, y: np.exp(-8 * ((x - 0.4) ** 2 + y**2))
    >>> method = fr.RBF(points, fr.polyharmonic(3))
    >>> times = np.linspace(0, np.pi / 2, 11)  # a quarter of a revolution
    >>> *_, last = semi_lagrangian(method, hill(*points.T), turn, times, steady=True)
    >>> bool(np.abs(last.values - hill(points[:, 1], -points[:, 0])).max() < 0.01)
    True
    """
    times = _as_times(times)
    state = State(times[0], method, valid.as_values(values, len(method.points)))
    _refuse_contradictions(state, velocity, inflow, bounded, masses)
    limiter = Limiter(bounded, masses, _total(state, masses))
    steady = steady or isinstance(velocity, Field)
    return _march(state, times[1:], velocity, scheme, steady, inflow, sites, limiter)


def _march(
    state: State,
    times: list[float],
    velocity: Velocity | Field | None,
    scheme: str,
    steady: bool,
    inflow: Inflow | None,
    sites: Callable[[State, float], Reconstruction] | None,
    limiter: Limiter,
) -> Iterator[State]:
    before: State | None = None
    step: Step | None = None
    yield state
    for t in times:
        following = state.method if sites is None else sites(state, t)
        if step is None or not (
            steady and step.applies_to(state.method, following, t - state.time)
        ):
            along = self_advecting(state, before) if velocity is None else velocity
            step = Step.traced(
                state.method,
                following,
                along,
                t,
                t - state.time,
                scheme,
                inflow,
                store_weights=steady,
            )
        flat = state.values.reshape(len(state.values), math.prod(state.values.shape[1:]))
        fixed = step.inflow_values(inflow, t, state.values.shape[1:])
        advected = limiter.apply(step, flat, step.advect(flat, fixed), fixed)
        before, state = (
            state,
            State(t, following, advected.reshape(len(advected), *state.values.shape[1:])),
        )
        yield state


def self_advecting(now: State, before: State | None) -> Velocity:
    """Return the velocity of self-advecting values, extrapolated from the last two states."""
    here = now.method.field(now.values)
    if before is None:
        return lambda x, _: here(x)
    there = before.method.field(before.values)

    def velocity(x: np.ndarray, t: float) -> np.ndarray:
        u = here(x)
        return u + (t - now.time) / (now.time - before.time) * (u - there(x))

    return velocity


def _as_times(times: ArrayLike) -> list[float]:
    t = np.asarray(valid.unmasked(times, "times"), dtype=float)
    if t.ndim != 1 or len(t) < 1 or not np.isfinite(t).all() or not (np.diff(t) > 0).all():
        raise ValueError(f"times must be increasing finite numbers (k,); got {times!r:.80}")
    return [float(s) for s in t]


def _refuse_contradictions(
    state: State, velocity: object, inflow: Inflow | None, bounded: bool, masses: object
) -> None:
    if velocity is None and state.values.shape != state.method.points.shape:
        raise ValueError(
            f"values that are the velocity must have the shape {state.method.points.shape}; "
            f"got {state.values.shape}"
        )
    if np.iscomplexobj(state.values) and (bounded or masses is not None):
        raise ValueError("bounds and masses are kept of real values; give real and imaginary parts")
    if inflow is not None and masses is not None:
        raise ValueError("masses cannot be kept where there is inflow: it brings some in")


def _total(state: State, masses: Masses | None) -> np.ndarray | None:
    if masses is None:
        return None
    return as_masses(masses, state.method) @ state.values.reshape(len(state.values), -1)


@dataclass(frozen=True)
class Step:
    """One time step: the methods before and after, and the departure points."""

    method: Reconstruction
    following: Reconstruction
    dt: float
    feet: np.ndarray
    entered: Entries | None
    weights: Weights | None

    @classmethod
    def traced(
        cls,
        method: Reconstruction,
        following: Reconstruction,
        velocity: Velocity | Field,
        t: float,
        dt: float,
        scheme: str,
        inflow: Inflow | None,
        store_weights: bool,
    ) -> Step:
        """Trace the characteristics back from the sites of the following method."""
        x = following.points
        feet = departure_points(x, velocity, t, dt, scheme)
        entered = None
        if inflow is not None:
            entered = entries(x, feet, velocity, t, dt, inflow)
            feet[entered.which] = entered.points
        weights = weights_if_they_fit(method, feet) if store_weights else None
        return cls(method, following, dt, feet, entered, weights)

    def applies_to(self, method: Reconstruction, following: Reconstruction, dt: float) -> bool:
        """Whether a step of these methods and this length has the same departure points."""
        same = self.method is method and self.following is following
        return same and abs(dt - self.dt) <= 1e-9 * self.dt

    def inflow_values(
        self, inflow: Inflow | None, t: float, tail: tuple[int, ...]
    ) -> np.ndarray | None:
        """Values (k, v) of the characteristics that entered through the boundary."""
        if inflow is None or self.entered is None:
            return None
        _, points, delays = self.entered
        found = valid.as_values(inflow.values(points, t - delays), len(points), "inflow.values")
        if found.shape[1:] != tail:
            raise ValueError(
                f"inflow.values must give values of the shape {(len(points), *tail)}; "
                f"got {found.shape}"
            )
        return found.reshape(len(points), int(np.prod(tail, dtype=int)))

    def advect(self, values: np.ndarray, fixed: np.ndarray | None) -> np.ndarray:
        """Values (m, v) after the step."""
        if self.weights is None:
            result = self.method.field(values)(self.feet)
        else:
            result = self.weights @ values
        return self._with(result, fixed)

    def bounds(self, values: np.ndarray, fixed: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
        """Minimum and maximum (m, v) of the values at the sites nearest to each departure point."""
        n, d = self.method.points.shape
        _, near = cKDTree(self.method.points).query(self.feet, min(2**d, n))
        around = values[near.reshape(len(self.feet), -1)]
        low, high = around.min(axis=1), around.max(axis=1)
        return self._with(low, fixed), self._with(high, fixed)

    def _with(self, result: np.ndarray, fixed: np.ndarray | None) -> np.ndarray:
        if self.entered is not None and fixed is not None:
            result[self.entered.which] = fixed
        return result


@dataclass(frozen=True)
class Limiter:
    """Limits values to bounds, and corrects their total mass."""

    bounded: bool
    masses: Masses | None
    total: np.ndarray | None

    def apply(
        self, step: Step, values: np.ndarray, advected: np.ndarray, fixed: np.ndarray | None
    ) -> np.ndarray:
        """Return the nearest values (m, v) to the advected ones that satisfy the constraints."""
        if not self.bounded and self.total is None:
            return advected
        low, high = (
            step.bounds(values, fixed)
            if self.bounded
            else (np.full_like(advected, -np.inf), np.full_like(advected, np.inf))
        )
        if self.masses is None or self.total is None:
            return np.clip(advected, low, high)
        return project_to_bounds_and_mass(
            advected, low, high, as_masses(self.masses, step.following), self.total
        )


def as_masses(masses: Masses, method: Reconstruction) -> np.ndarray:
    """Return the positive mass of each site."""
    m = valid.as_values(
        masses(method) if callable(masses) else masses, len(method.points), "masses"
    )
    if m.ndim != 1 or not (m > 0).all():
        raise ValueError(f"masses must be positive, one for each site; got the shape {m.shape}")
    return m
