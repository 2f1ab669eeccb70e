"""Where rays first meet the zeros of a function: all march at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress

_REFINEMENTS = 100
_EXACT = 4e-16  # of the distance travelled


def ray_intersections(
    solid: Callable[[np.ndarray], np.ndarray],
    origins: ArrayLike,
    direction: ArrayLike,
    lengths: ArrayLike,
    step: float,
    near: ArrayLike | None = None,
    slope: float | None = None,
    tolerance: float = 0.0,
    progress: Progress | None = None,
) -> np.ndarray:
    """How far rays go until the function becomes positive.

    All rays march at once. Where the function changes sign between two places of a ray, regula
    falsi after Illinois finds the zero, with bisection where that is slow.

    Parameters
    ----------
    solid : callable
        Values (k,) at places (k, d), positive inside; negative where rays begin.
    origins : (k, d) array_like
    direction : (d,) array_like
        Unit vector.
    lengths : float or (k,) array_like
        How far rays go at most.
    step : float
        Distance of the places that are looked at: what is thinner may be missed.
    near : (n, d) array_like, optional
        Places within 2 steps of which the surface lies everywhere: rays go on to them at once.
    slope : float, optional
        Most by which the function changes in a unit of length; with it rays go on by |F| / slope
        where that is more than a step (sphere tracing).
    tolerance : float
        By how much a distance may be off; to rounding by default.
    progress : callable, optional
        Called as progress(done, total) with numbers of rays.

    Returns
    -------
    (k,) ndarray
        Distances; inf where a ray meets nothing.

    References
    ----------
    Hart, Sphere tracing (1996); Dowell and Jarratt, A modified regula falsi method (1971).

    Examples
    --------
    >>> ball = lambda x: 1 - np.linalg.norm(x, axis=-1)
    >>> ray_intersections(ball, [[0, 0, 3], [0, 0.6, 3], [0, 2, 3]], [0, 0, -1], 6.0, 0.1)
    array([2. , 2.2, inf])
    """
    o = np.asarray(valid.as_points(origins, "origins"))
    ahead = valid.as_queries(direction, o.shape[1])
    step = valid.as_length(step, "step")
    tree = None if near is None else cKDTree(valid.as_points(near, "near"))
    lengths = np.broadcast_to(np.asarray(lengths, dtype=float), len(o))
    t, before = np.zeros(len(o)), np.zeros(len(o))
    bracketed = np.zeros(len(o), dtype=bool)
    ends = np.zeros((2, len(o)))
    going = np.flatnonzero(lengths >= 0)
    while len(going):
        places = o[going] + t[going, None] * ahead
        on = np.full(len(going), step)
        looked = np.arange(len(going))
        if tree is not None:
            free = tree.query(places)[0] - 2 * step
            on = np.maximum(free, step)
            looked = np.flatnonzero(free <= 0)
        values = solid(places[looked])
        found = values >= 0
        ends[1, going[looked]] = values
        bracketed[going[looked[found]]] = True
        if slope is not None:
            on[looked] = np.maximum(on[looked], -values / slope)
        on[looked[found]] = np.inf
        still = np.isfinite(on)
        before[going[still]] = t[going[still]]
        ends[0, going[still]] = np.minimum(ends[1, going[still]], 0)
        t[going[still]] += on[still]
        going = going[still]
        going = going[t[going] <= lengths[going]]
        if progress is not None:
            progress(len(o) - len(going), len(o))
    distance = np.full(len(o), np.inf)
    hit = np.flatnonzero(bracketed)
    bracket = np.stack([before[hit], t[hit]])
    distance[hit] = _refined(solid, o[hit], ahead, bracket, ends[:, hit], tolerance)
    return distance


def _refined(
    solid: Callable[[np.ndarray], np.ndarray],
    origins: np.ndarray,
    ahead: np.ndarray,
    bracket: np.ndarray,
    values: np.ndarray,
    tolerance: float,
) -> np.ndarray:
    """Zeros (k,) between the ends (2, k), the first outside and the second inside."""
    (a, b), (fa, fb) = bracket.copy(), values.copy()
    side = np.zeros(len(a))
    going = np.arange(len(a))
    for k in range(_REFINEMENTS):
        lo, hi, flo, fhi = a[going], b[going], fa[going], fb[going]
        share = np.where(fhi - flo > 0, -flo / np.where(fhi - flo > 0, fhi - flo, 1), 0.5)
        middle = lo + (0.5 if k % 4 == 3 else np.clip(share, 0, 1)) * (hi - lo)
        value = solid(origins[going] + middle[:, None] * ahead)
        outside = value < 0
        again = side[going] == np.where(outside, -1, 1)
        a[going] = np.where(outside, middle, lo)
        b[going] = np.where(outside, hi, middle)
        fa[going] = np.where(outside, value, np.where(again, flo / 2, flo))
        fb[going] = np.where(outside, np.where(again, fhi / 2, fhi), value)
        side[going] = np.where(outside, -1, 1)
        done = (value == 0) | (b[going] - a[going] <= tolerance + _EXACT * b[going])
        b[going[value == 0]] = middle[value == 0]
        going = going[~done]
        if not len(going):
            break
    return b
