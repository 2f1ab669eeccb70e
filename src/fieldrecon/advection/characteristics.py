"""Departure points: the characteristics of a flow traced back for one time step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon.fields import Field

Velocity: TypeAlias = Callable[[np.ndarray, float], np.ndarray]
"""Velocities (m, d) at points (m, d) and a time."""

SCHEMES: dict[str, tuple[tuple[tuple[float, ...], ...], tuple[float, ...]]] = {
    "euler": ((), (1,)),
    "midpoint": (((1 / 2,),), (0, 1)),
    "heun": (((1,),), (1 / 2, 1 / 2)),
    "rk4": (((1 / 2,), (0, 1 / 2), (0, 0, 1)), (1 / 6, 1 / 3, 1 / 3, 1 / 6)),
}
"""Explicit Runge-Kutta schemes of order 1, 2, 2, 4: rows of the later stages, and weights."""
BISECTIONS = 52


def departure_points(
    x: ArrayLike,
    velocity: Velocity | Field,
    t: float,
    dt: float,
    scheme: str = "rk4",
) -> np.ndarray:
    """Positions at time t - dt on the characteristics dy/dτ = a(y, τ) with y(t) = x.

    Parameters
    ----------
    x : (m, d) array_like
        Positions at time t.
    velocity : callable or Field
        The velocity a(y, τ): a function of points (m, d) and a time, a steady `Field` of vectors,
        or `Snapshots` of several fields.
    t, dt : float
        The time of arrival, and the time step; a negative dt traces forward.
    scheme : {"rk4", "heun", "midpoint", "euler"}
        One step of this scheme; the error of the positions is O(dt^5), O(dt^3), O(dt^3), O(dt^2).

    Returns
    -------
    (m, d) ndarray
        The departure points.

    Raises
    ------
    ValueError
        If the velocities are not one finite vector for each point, or an argument has the wrong
        form.

    References
    ----------
    Wendland (2005), section 1.3; Staniforth and Côté (1991).

    Examples
    --------
    >>> import numpy as np
    >>> turn = lambda y, _: y[:, ::-1] * [-1, 1]  # a revolution about the origin in 2 π
    >>> departure_points([[0.0, 1.0]], turn, np.pi / 6, np.pi / 6).round(3)
    array([[0.5  , 0.866]])
    """
    x = valid.as_points(x, "x", none_allowed=True)
    if scheme not in SCHEMES:
        raise ValueError(f"scheme must be one of {', '.join(SCHEMES)}; got {scheme!r}")
    stages, weights = SCHEMES[scheme]
    slopes = [velocities(velocity, x, t)]
    for row in stages:
        back = sum(a * s for a, s in zip(row, slopes, strict=True))
        slopes.append(velocities(velocity, x - dt * back, t - dt * sum(row)))
    return x - dt * sum(w * s for w, s in zip(weights, slopes, strict=True))


def velocities(velocity: Velocity | Field, x: np.ndarray, t: float) -> np.ndarray:
    """Validated velocities (m, d) at the points x."""
    a = valid.as_values(
        velocity(x) if isinstance(velocity, Field) else velocity(x, t), len(x), "velocity", "point"
    )
    if a.shape != x.shape:
        raise ValueError(f"velocity must give vectors of the shape {x.shape}; got {a.shape}")
    return a


@dataclass(frozen=True)
class Snapshots:
    """A velocity interpolated linearly in time between fields.

    The error of the interpolation is of second order in the time between snapshots.

    Parameters
    ----------
    times : sequence of float
        Increasing times of the fields.
    fields : sequence of Field
        Fields of vectors, one for each time; their sites may differ.

    Examples
    --------
    >>> import numpy as np, fieldrecon as fr
    >>> grid = np.indices((3, 3)).reshape(2, -1).T / 2
    >>> method = fr.LeastSquares(grid)
    >>> wind = Snapshots([0.0, 2.0], [method.field(0 * grid), method.field(1 + 0 * grid)])
    >>> wind(np.array([[0.5, 0.5]]), 0.5).round(12)
    array([[0.25, 0.25]])
    """

    times: Sequence[float]
    fields: Sequence[Field]

    def __post_init__(self) -> None:
        times = np.asarray(valid.unmasked(self.times, "times"), dtype=float)
        if times.shape != (len(self.fields),) or len(times) < 2 or not (np.diff(times) > 0).all():
            raise ValueError(
                "times must increase, one for each of at least two fields; got "
                f"{len(self.fields)} fields at the times {self.times!r}"
            )

    def __call__(self, x: np.ndarray, t: float) -> np.ndarray:
        """Velocities at the points x and a time between the first and the last snapshot."""
        times = np.asarray(self.times, dtype=float)
        slack = 1e-9 * (times[-1] - times[0])
        if not times[0] - slack <= t <= times[-1] + slack:
            raise ValueError(
                f"the time {t:g} lies outside the snapshots, {times[0]} to {times[-1]}"
            )
        k = int(np.clip(np.searchsorted(times, t) - 1, 0, len(times) - 2))
        part = (t - times[k]) / (times[k + 1] - times[k])
        before, after = self.fields[k](x), self.fields[k + 1](x)
        return (1 - part) * before + part * after


@dataclass(frozen=True)
class Inflow:
    """The domain of a flow, and the values at its inflow boundary.

    Parameters
    ----------
    domain : callable
        A continuous function of points (m, d), positive inside and negative outside, such as a
        signed distance; returns (m,) numbers.
    values : callable
        Takes points (k, d) on the boundary and times (k,), and returns the values (k, ...) there.
    """

    domain: Callable[[np.ndarray], np.ndarray]
    values: Callable[[np.ndarray, np.ndarray], np.ndarray]


class Entries(NamedTuple):
    """Characteristics that entered through the boundary during the step.

    Attributes
    ----------
    which : (k,) ndarray
        Their indices.
    points : (k, d) ndarray
        The points of entry.
    delays : (k,) ndarray
        The times from entry to arrival.
    """

    which: np.ndarray
    points: np.ndarray
    delays: np.ndarray


def entries(
    x: np.ndarray, feet: np.ndarray, velocity: Velocity | Field, t: float, dt: float, flow: Inflow
) -> Entries:
    """Find the characteristics from feet (m, d) to x (m, d) that cross the boundary.

    A characteristic is approximated by the Hermite cubic with the velocities at its ends, whose
    error is of fourth order in dt; the crossing is found by bisection.
    """
    which = np.flatnonzero(flow.domain(feet) < 0)
    near, far = np.zeros(len(which)), np.ones(len(which))
    if not len(which):
        return Entries(which, feet[which], far)
    ends = (x[which], feet[which])
    slopes = [
        -dt * velocities(velocity, end, time) for end, time in zip(ends, (t, t - dt), strict=True)
    ]
    for _ in range(BISECTIONS):
        middle = near / 2 + far / 2
        outside = flow.domain(_cubic(middle, *ends, *slopes)) < 0
        near, far = np.where(outside, near, middle), np.where(outside, middle, far)
    return Entries(which, _cubic(near, *ends, *slopes), near * dt)


def _cubic(
    s: np.ndarray, start: np.ndarray, end: np.ndarray, leaving: np.ndarray, arriving: np.ndarray
) -> np.ndarray:
    """The Hermite cubic at s in [0, 1], with values and slopes at both ends."""
    s = s[:, None]
    return (
        (1 + 2 * s) * (1 - s) ** 2 * start
        + s * (1 - s) ** 2 * leaving
        + s**2 * (3 - 2 * s) * end
        - s**2 * (1 - s) * arriving
    )
