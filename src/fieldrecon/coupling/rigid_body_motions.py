"""Rigid motions of points, and the total force and moment of loads, their work in them."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid


def rigid_motions(points: ArrayLike, about: ArrayLike | None = None) -> np.ndarray:
    """Displacements of points in each infinitesimal rigid motion: translations, then rotations.

    The translations are e_k, the rotations e_i (p - a)_j - e_j (p - a)_i for the planes of two
    axes. In space the rotations are e_k × (p - a), in the plane (-(p - a)_2, (p - a)_1).

    Parameters
    ----------
    points : (n, d) array_like
        The points p.
    about : (d,) array_like, optional
        The centre a of the rotations; the origin by default.

    Returns
    -------
    (n, d, r) ndarray
        The r = d (d + 1) / 2 motions along the last axis.

    Examples
    --------
    >>> rigid_motions([[3.0, 1.0]])[0]
    array([[ 1.,  0., -1.],
           [ 0.,  1.,  3.]])
    """
    p = valid.as_points(points, none_allowed=True)
    d = p.shape[1]
    arm = p if about is None else p - _as_center(about, d)
    motions = np.zeros((*p.shape, d * (d + 1) // 2))
    motions[:, range(d), range(d)] = 1.0
    for column, (i, j) in enumerate(_planes(d), start=d):
        motions[:, j, column] = arm[:, i]
        motions[:, i, column] = -arm[:, j]
    return motions


def net_force_and_moment(
    points: ArrayLike, loads: ArrayLike, about: ArrayLike | None = None
) -> np.ndarray:
    """Total force and total moment of loads: their work in each rigid motion.

    Parameters
    ----------
    points : (n, d) array_like
        The points at which the loads act.
    loads : (n, d, ...) array_like
        The loads.
    about : (d,) array_like, optional
        The point about which moments are taken; the origin by default.

    Returns
    -------
    (r, ...) ndarray
        The d components of the force sum f_i, then the moment; in space sum (p_i - a) × f_i.

    Examples
    --------
    >>> net_force_and_moment([[3.0, 1.0]], [[0.0, 2.0]])  # 2 upwards, on an arm of 3
    array([0., 2., 6.])
    """
    p = valid.as_points(points, none_allowed=True)
    return np.einsum("ndr,nd...->r...", rigid_motions(p, about), as_vectors(loads, p, "loads"))


def as_vectors(values: ArrayLike, points: np.ndarray, name: str) -> np.ndarray:
    """Validate one or several vectors of d components for each of the points: (n, d, ...)."""
    n, d = points.shape
    v = valid.as_values(values, n, name)
    if v.ndim < 2 or v.shape[1] != d:
        raise ValueError(
            f"{name} must be vectors of {d} components, shape ({n}, {d}, ...); got {v.shape}"
        )
    return v


def _planes(d: int) -> list[tuple[int, int]]:
    """Pairs of axes; in space those normal to x, y and z, right-handed."""
    return [(1, 2), (2, 0), (0, 1)] if d == 3 else list(combinations(range(d), 2))


def _as_center(about: ArrayLike, d: int) -> np.ndarray:
    a = valid.as_queries(about, d, "about")
    if a.shape != (d,):
        raise ValueError(f"about must be one point of {d} coordinates; got the shape {a.shape}")
    return a
