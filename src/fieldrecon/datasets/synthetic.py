"""Sets of points in [0, 1]^d, and test functions with their gradients."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core.validation import as_count, as_queries

Seed = int | np.random.Generator


def uniform(n: int, d: int, seed: Seed) -> np.ndarray:
    """Draw n independent points, uniformly distributed in [0, 1]^d.

    Parameters
    ----------
    n, d : int
        Number of points and of coordinates.
    seed : int or numpy.random.Generator
        Source of the random numbers; the same seed gives the same points.

    Returns
    -------
    ndarray of shape (n, d)
    """
    return np.random.default_rng(seed).random((as_count(n, "n", 0), as_count(d, "d")))


def halton(n: int, d: int, seed: Seed | None = None) -> np.ndarray:
    """Return the first n points of the Halton sequence in [0, 1]^d.

    Coordinate k of point i is the radical inverse of i in the k-th prime: its digits are mirrored
    at the radix point. The first point is the origin.

    Parameters
    ----------
    n, d : int
        Number of points and of coordinates.
    seed : int or numpy.random.Generator, optional
        If given, the digits are permuted at random (Owen's scrambling).

    Returns
    -------
    ndarray of shape (n, d)

    References
    ----------
    J. H. Halton, On the efficiency of certain quasi-random sequences of points in evaluating
    multi-dimensional integrals, Numerische Mathematik 2 (1960).

    Examples
    --------
    >>> halton(5, 2)[:, 0].tolist()
    [0.0, 0.5, 0.25, 0.75, 0.125]
    """
    # scipy.stats takes longer to import than all the rest of this package
    from scipy.stats import qmc

    sequence = qmc.Halton(as_count(d, "d"), scramble=seed is not None, rng=seed)
    return sequence.random(as_count(n, "n", 0))


def jittered_grid(side: int, d: int, jitter: float, seed: Seed) -> np.ndarray:
    """Return one random point in each of side^d equal cells of [0, 1]^d.

    Parameters
    ----------
    side, d : int
        Cells along each axis, and number of axes.
    jitter : float
        Relative size, from 0 to 1, of the part of its cell in which a point lies: 0 gives the
        centres of the cells, 1 any point in them.
    seed : int or numpy.random.Generator
        Source of the random numbers.

    Returns
    -------
    ndarray of shape (side**d, d)

    Examples
    --------
    >>> jittered_grid(2, 2, 0, seed=0).tolist()
    [[0.25, 0.25], [0.25, 0.75], [0.75, 0.25], [0.75, 0.75]]
    """
    if not 0 <= jitter <= 1:
        raise ValueError(f"jitter must be between 0 and 1; got {jitter!r}")
    cells = np.indices((as_count(side, "side"),) * as_count(d, "d")).reshape(d, -1).T
    offsets = jitter * (uniform(len(cells), d, seed) - 0.5)
    return (cells + 0.5 + offsets) / side


def clustered(n: int, d: int, clusters: int, spread: float, seed: Seed) -> np.ndarray:
    """Draw n points of [0, 1]^d that cluster around a few centres.

    Each point is normally distributed about a centre chosen at random; points outside are
    reflected at the faces of the cube, so that they do not coincide there.

    Parameters
    ----------
    n, d, clusters : int
        Number of points, of coordinates and of centres.
    spread : float
        Standard deviation of each coordinate about its centre, positive.
    seed : int or numpy.random.Generator
        Source of the random numbers.

    Returns
    -------
    ndarray of shape (n, d)
    """
    if not (np.isfinite(spread) and spread > 0):
        raise ValueError(f"spread must be a positive number; got {spread!r}")
    rng = np.random.default_rng(seed)
    centres = uniform(as_count(clusters, "clusters"), d, rng)
    own = centres[rng.integers(clusters, size=as_count(n, "n", 0))]
    x = own + spread * rng.standard_normal((n, d))
    return 1 - np.abs(1 - x % 2)


@dataclass(frozen=True)
class AnalyticField:
    """A function given by its formula, with its exact gradient, called as a ``Field`` is.

    Parameters
    ----------
    name : str
        Name of the function.
    values : callable
        Takes points (..., d) to values (...).
    gradient : callable
        Takes points (..., d) to gradients (..., d).

    Examples
    --------
    >>> f = power_of_sum(3)
    >>> float(f([1.0, 1.0])), f.gradient([1.0, 1.0]).tolist()
    (8.0, [12.0, 12.0])
    """

    name: str
    values: Callable[[ArrayLike], np.ndarray]
    gradient: Callable[[ArrayLike], np.ndarray]

    def __call__(self, x: ArrayLike) -> np.ndarray:
        """Return the values (...) at points (..., d)."""
        return self.values(x)


def power_of_sum(n: int) -> AnalyticField:
    """Return (x₁ + … + x_d)ⁿ, the test function of the lecture slides, in any dimension.

    Parameters
    ----------
    n : int
        The power, zero or more.

    References
    ----------
    Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 40).
    """
    n = as_count(n, "n", 0)

    def values(x: ArrayLike) -> np.ndarray:
        return _points(x).sum(axis=-1) ** n

    def gradient(x: ArrayLike) -> np.ndarray:
        x = _points(x)
        slope = n * x.sum(axis=-1, keepdims=True) ** max(n - 1, 0)
        return np.broadcast_to(slope, x.shape).copy()

    return AnalyticField(f"(x₁ + … + x_d)^{n}", values, gradient)


_FRANKE_AMPLITUDES = np.array([3 / 4, 3 / 4, 1 / 2, -1 / 5])


def _franke_values(x: ArrayLike) -> np.ndarray:
    return _franke_terms(as_queries(x, 2)).sum(axis=-1)


def _franke_gradient(x: ArrayLike) -> np.ndarray:
    """Sum the terms a·exp(q), each times ∇q."""
    x = as_queries(x, 2)
    u, v = 9 * x[..., 0], 9 * x[..., 1]
    q_u = np.stack([-(u - 2) / 2, -2 * (u + 1) / 49, -(u - 7) / 2, -2 * (u - 4)], axis=-1)
    q_v = np.stack([-(v - 2) / 2, np.full_like(v, -1 / 10), -(v - 3) / 2, -2 * (v - 7)], axis=-1)
    terms = _franke_terms(x)
    return 9 * np.stack([(terms * q_u).sum(axis=-1), (terms * q_v).sum(axis=-1)], axis=-1)


def _franke_terms(x: np.ndarray) -> np.ndarray:
    u, v = 9 * x[..., 0], 9 * x[..., 1]
    exponents = [
        -((u - 2) ** 2 + (v - 2) ** 2) / 4,
        -((u + 1) ** 2) / 49 - (v + 1) / 10,
        -((u - 7) ** 2 + (v - 3) ** 2) / 4,
        -((u - 4) ** 2) - (v - 7) ** 2,
    ]
    return _FRANKE_AMPLITUDES * np.exp(np.stack(exponents, axis=-1))


franke = AnalyticField("Franke's function", _franke_values, _franke_gradient)
"""Two hills, a slope and a hollow over the unit square: the field's common test function.

R. Franke, Scattered data interpolation: tests of some methods, Mathematics of Computation 38
(1982).
"""


def _points(x: ArrayLike) -> np.ndarray:
    return as_queries(x, np.shape(x)[-1] if np.ndim(x) else 1)
