"""Semi-Lagrangian advection: a step in time is H at the feet of the characteristics.

One step of semi-Lagrangian advection, and what is kept in it.
"""

from __future__ import annotations

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
from fieldrecon.advection.mass_fixer import within
from fieldrecon.reconstruction import Field, Reconstruction, Weights, weights_if_they_fit


class State(NamedTuple):
    """A field in time.

    Attributes
    ----------
    time : float
        When.
    method : Reconstruction
        The method on the sites of that time.
    values : (n, ...) ndarray
        The values there; `method.field(values)` is the field.
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
    """Solve u_t + a · ∇u = 0: the value at a site is the field a step ago at its foot.

    u(x, t) = s_{u(t - dt)}(y), with y the `departure_points` of x. The step is not limited by the
    spacing of the sites. It is linear in the values, with the matrix H = `method.weights(y)`, and
    it stays bounded over many steps if the powers of H do. Where feet leave the sites and there is
    no inflow, the field is continued as the method does.

    Parameters
    ----------
    method : Reconstruction
        A method on the sites at the first time.
    values : (n, ...) array_like
        The values there at that time: scalars, vectors or arrays, each component carried alone.
    velocity : callable, Field or None
        As for `departure_points`. None if the values are the velocity, u_t + u · ∇u = 0 (Burgers);
        within a step it is then extrapolated from the last two, of second order.
    times : (k,) array_like
        The times, increasing; the first is that of the values.
    scheme : {"rk4", "heun", "midpoint", "euler"}
        How characteristics are traced.
    steady : bool
        Whether the velocity does not depend on time; then, as for a Field, feet and weights are
        made once for all steps of one length.
    inflow : Inflow, optional
        The domain, and the values that come in through its boundary.
    sites : callable, optional
        Takes the last state and the next time, and gives the method on the sites of the next;
        by default they stay.
    bounded : bool
        Whether a new value must lie between the values at the 2^d sites nearest to its foot.
    masses : (n,) array_like or callable, optional
        Positive masses m of the sites, or a function from methods to these: sum m u then stays as
        it is, each time by the smallest change that does it, sum m (change)^2. In a flow without
        divergence or flux through the boundary that total is the mass.

    Yields
    ------
    State
        The first, then that of each time.

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
    >>> times = np.linspace(0, np.pi / 2, 11)  # a quarter of a turn
    >>> *_, last = semi_lagrangian(method, hill(*points.T), turn, times, steady=True)
    >>> bool(np.abs(last.values - hill(points[:, 1], -points[:, 0])).max() < 0.01)
    True
    """
    times = _as_times(times)
    state = State(times[0], method, valid.as_values(values, len(method.points)))
    _refuse_contradictions(state, velocity, inflow, bounded, masses)
    keep = Kept(bounded, masses, _total(state, masses))
    steady = steady or isinstance(velocity, Field)
    return _march(state, times[1:], velocity, scheme, steady, inflow, sites, keep)


def _march(
    state: State,
    times: list[float],
    velocity: Velocity | Field | None,
    scheme: str,
    steady: bool,
    inflow: Inflow | None,
    sites: Callable[[State, float], Reconstruction] | None,
    keep: Kept,
) -> Iterator[State]:
    before: State | None = None
    step: Step | None = None
    yield state
    for t in times:
        following = state.method if sites is None else sites(state, t)
        if step is None or not (steady and step.serves(state.method, following, t - state.time)):
            along = carried_along(state, before) if velocity is None else velocity
            step = Step.back(
                state.method, following, along, t, t - state.time, scheme, inflow, kept=steady
            )
        flat = state.values.reshape(len(state.values), -1)
        fixed = step.incoming(inflow, t, state.values.shape[1:])
        moved = keep.kept(step, flat, step.moved(flat, fixed), fixed)
        before, state = state, State(t, following, moved.reshape(-1, *state.values.shape[1:]))
        yield state


def carried_along(now: State, before: State | None) -> Velocity:
    """The velocity of values that carry themselves, extrapolated from the last two states."""
    here = now.method.field(now.values)
    if before is None:
        return lambda x, _: here(x)
    there = before.method.field(before.values)

    def velocity(x: np.ndarray, t: float) -> np.ndarray:
        u = here(x)
        return u + (t - now.time) / (now.time - before.time) * (u - there(x))

    return velocity


def _as_times(times: ArrayLike) -> list[float]:
    t = np.asarray(times, dtype=float)
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
        """Trace the characteristics back from the sites that are to have values."""
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
    """Return the positive mass of each site."""
    m = valid.as_values(
        masses(method) if callable(masses) else masses, len(method.points), "masses"
    )
    if m.ndim != 1 or not (m > 0).all():
        raise ValueError(f"masses must be positive, one for each site; got the shape {m.shape}")
    return m
