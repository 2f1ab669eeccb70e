"""Ray casting: the first intersections of rays with the zeros of a function."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress

_MAX_REFINEMENTS = 100
_EXACT = 4e-16  # of the distance travelled


def ray_intersections(
    solid: Callable[[np.ndarray], np.ndarray],
    origins: ArrayLike,
    direction: ArrayLike,
    lengths: ArrayLike,
    step: float,
    *,
    near: ArrayLike | None = None,
    slope: float | None = None,
    tol: float = 0.0,
    progress: Progress | None = None,
) -> np.ndarray:
    """Distances along rays to the first zero of a function.

    All rays advance together. When the function changes sign between two points of a ray, the
    Illinois variant of regula falsi finds the zero, with bisection where that is slow.

    Parameters
    ----------
    solid : callable
        Values (k,) at points (k, d), positive inside, and negative at the origins.
    origins : (k, d) array_like
    direction : (d,) array_like
        Unit vector.
    lengths : float or (k,) array_like
        Lengths of the rays.
    step : float
        Distance of the points at which the function is evaluated; thinner parts may be missed.
    near : (n, d) array_like, optional
        Points such that the surface is nowhere farther than 2 steps from all of them. Rays skip
        the space between them.
    slope : float, optional
        A Lipschitz constant of the function. With it, rays advance by |F| / slope if that is more
        than a step (sphere tracing).
    tol : float
        Tolerance of the distances; the rounding error by default.
    progress : callable, optional
        Called as progress(done, total) with numbers of rays.

    Returns
    -------
    (k,) ndarray
        Distances; inf for rays without an intersection.

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
    active = np.flatnonzero(lengths >= 0)
    while len(active):
        points = o[active] + t[active, None] * ahead
        on = np.full(len(active), step)
        evaluated = np.arange(len(active))
        if tree is not None:
            free = tree.query(points)[0] - 2 * step
            on = np.maximum(free, step)
            evaluated = np.flatnonzero(free <= 0)
        values = solid(points[evaluated])
        found = values >= 0
        ends[1, active[evaluated]] = values
        bracketed[active[evaluated[found]]] = True
        if slope is not None:
            on[evaluated] = np.maximum(on[evaluated], -values / slope)
        on[evaluated[found]] = np.inf
        advancing = np.isfinite(on)
        before[active[advancing]] = t[active[advancing]]
        ends[0, active[advancing]] = np.minimum(ends[1, active[advancing]], 0)
        t[active[advancing]] += on[advancing]
        active = active[advancing]
        active = active[t[active] <= lengths[active]]
        if progress is not None:
            progress(len(o) - len(active), len(o))
    distance = np.full(len(o), np.inf)
    hit = np.flatnonzero(bracketed)
    bracket = np.stack([before[hit], t[hit]])
    distance[hit] = _refined(solid, o[hit], ahead, bracket, ends[:, hit], tol)
    return distance


def _refined(
    solid: Callable[[np.ndarray], np.ndarray],
    origins: np.ndarray,
    ahead: np.ndarray,
    bracket: np.ndarray,
    values: np.ndarray,
    tolerance: float,
) -> np.ndarray:
    """Zeros (k,) in brackets (2, k), whose first end is outside and whose second is inside."""
    (a, b), (fa, fb) = bracket.copy(), values.copy()
    side = np.zeros(len(a))
    active = np.arange(len(a))
    for k in range(_MAX_REFINEMENTS):
        lo, hi, flo, fhi = a[active], b[active], fa[active], fb[active]
        share = np.where(fhi - flo > 0, -flo / np.where(fhi - flo > 0, fhi - flo, 1), 0.5)
        middle = lo + (0.5 if k % 4 == 3 else np.clip(share, 0, 1)) * (hi - lo)
        value = solid(origins[active] + middle[:, None] * ahead)
        outside = value < 0
        again = side[active] == np.where(outside, -1, 1)
        a[active] = np.where(outside, middle, lo)
        b[active] = np.where(outside, hi, middle)
        fa[active] = np.where(outside, value, np.where(again, flo / 2, flo))
        fb[active] = np.where(outside, np.where(again, fhi / 2, fhi), value)
        side[active] = np.where(outside, -1, 1)
        done = (value == 0) | (b[active] - a[active] <= tolerance + _EXACT * b[active])
        b[active[value == 0]] = middle[value == 0]
        active = active[~done]
        if not len(active):
            break
    return b
