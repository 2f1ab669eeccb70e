"""The theorem of Mairhuber and Curtis: fixed functions cannot interpolate at all sites.

In two or more dimensions two sites can change places without meeting each other or another site.
This exchanges two rows of the matrix of the functions at the sites, so its determinant changes the
sign, and vanishes on the way. Kernels avoid this, because their centres move with the sites.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.spatial.distance import cdist

from fieldrecon._core import validation as valid

_HEIGHTS = (1.0, 0.5, 0.7, 0.3, 0.85, 0.4, 0.6, 0.2)
_TIMES = np.linspace(0.0, 1.0, 201)


@dataclass(frozen=True, eq=False)
class SingularExchange:
    """A path on which two sites change places, and a time at which interpolation fails.

    Attributes
    ----------
    start : (n, d) ndarray
        The sites at time 0.
    pair : tuple of int
        The two sites that change places by time 1.
    across : (d,) ndarray
        The second semi-axis of their half ellipses.
    time : float
        A time at which the determinant vanishes.
    """

    start: np.ndarray
    pair: tuple[int, int]
    across: np.ndarray
    time: float

    def at(self, t: float) -> np.ndarray:
        """Sites (n, d) at a time from 0 to 1."""
        return _moved(self.start, self.pair, self.across, t)

    @property
    def sites(self) -> np.ndarray:
        """Sites (n, d) at which the functions cannot interpolate."""
        return self.at(self.time)


def singular_exchange(
    functions: Callable[[np.ndarray], np.ndarray],
    points: ArrayLike,
    pair: tuple[int, int] = (0, 1),
) -> SingularExchange:
    """Distinct sites at which n fixed functions cannot interpolate, by the exchange of two sites.

    The sites p, q of the pair move on the halves of an ellipse about their middle,

        m + (p - m) cos(pi t) + w sin(pi t)  and  m - (p - m) cos(pi t) - w sin(pi t),

    with w normal to p - m and as long that no other site is met. The zero of the determinant is
    found by Brent's method.

    Parameters
    ----------
    functions : callable
        Takes sites (n, d) to the values (n, n) of n continuous functions that do not depend on the
        sites: entry (i, j) is function j at site i.
    points : (n, d) array_like
        Distinct sites at which interpolation is possible, d at least 2.
    pair : tuple of int
        Indices of the two sites that change places.

    Returns
    -------
    SingularExchange
        The path, and the sites at a time at which the determinant vanishes.

    Raises
    ------
    ValueError
        If an argument has the wrong form, or the functions depend on the sites, so that the
        determinant does not change its sign.
    numpy.linalg.LinAlgError
        If the functions are dependent at the points already.

    References
    ----------
    Mairhuber, On Haar's theorem (1956); Curtis, n-parameter families and best approximation (1959);
    Wendland (2005), theorem 2.3.

    Examples
    --------
    Linear polynomials fail where three sites lie on a line:

    >>> linear = lambda x: np.column_stack([np.ones(len(x)), x])
    >>> found = singular_exchange(linear, [[0, 0], [2, 0], [1, 2]])
    >>> round(found.time, 12), found.sites[:, 0].round(12).tolist()
    (0.5, [1.0, 1.0, 1.0])
    """
    p = valid.as_points(points)
    n, d = p.shape
    if d < 2:
        raise ValueError("points must have 2 coordinates or more: on a line two sites would meet")
    i, j = (valid.as_count(k, "pair", 0, n - 1, f"two indices of {n} points") for k in pair)
    if not (p[i] != p[j]).any():
        raise ValueError(f"pair must be two distinct sites; got {pair!r}")
    across = _free_axis(p, (i, j))
    log_size = np.linalg.slogdet(_values(functions, p))[1]
    if not np.isfinite(log_size):
        raise np.linalg.LinAlgError("the functions are dependent at the points already")

    def determinant(t: float) -> float:
        sign, log = np.linalg.slogdet(_values(functions, _moved(p, (i, j), across, t)))
        return float(sign * np.exp(log - log_size))

    start, end = determinant(0.0), determinant(1.0)
    if not abs(start + end) < 1e-6 * abs(start):
        raise ValueError(
            "functions must not depend on the sites: where two sites change places, two rows of "
            f"values do, and the determinant its sign; it changes by the factor {end / start:.3g}"
        )
    return SingularExchange(p, (i, j), across, float(brentq(determinant, 0.0, 1.0, xtol=1e-15)))


def _values(functions: Callable[[np.ndarray], np.ndarray], p: np.ndarray) -> np.ndarray:
    values = valid.as_values(functions(p), len(p), "functions(points)")
    if values.shape != (len(p), len(p)) or np.iscomplexobj(values):
        raise ValueError(
            f"functions must have {len(p)} real values at each of as many points; got the type "
            f"{values.dtype} and the shape {values.shape}"
        )
    return values


def _moved(p: np.ndarray, pair: tuple[int, int], across: np.ndarray, t: float) -> np.ndarray:
    i, j = pair
    away = (p[i] - p[j]) / 2 * np.cos(np.pi * t) + across * np.sin(np.pi * t)
    middle = p[i] / 2 + p[j] / 2
    moved = np.array(p)
    if 0 < t < 1:
        moved[i], moved[j] = middle + away, middle - away
    elif t == 1:
        moved[i], moved[j] = p[j], p[i]
    return moved


def _free_axis(p: np.ndarray, pair: tuple[int, int]) -> np.ndarray:
    """A vector normal to the pair, with which the path is farthest from the other sites."""
    i, j = pair
    half = (p[i] - p[j]) / 2
    along = half / np.linalg.norm(half)
    axis = int(np.argmin(np.abs(along)))
    normal = np.eye(len(half))[axis] - along[axis] * along
    size = np.linalg.norm(half) / np.linalg.norm(normal)
    heights = [h * size * normal for h in _HEIGHTS]
    others = np.delete(p, [i, j], axis=0)
    if not len(others):
        return heights[0]

    def clearance(across: np.ndarray) -> float:
        path = np.concatenate([_moved(p, pair, across, t)[[i, j]] for t in _TIMES])
        return float(cdist(path, others).min())

    return max(heights, key=clearance)
