"""Rigid motions of points, and what loads do to them: total force and total moment."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid


def rigid_motions(points: ArrayLike, about: ArrayLike | None = None) -> np.ndarray:
    """Displacements of points in each small rigid motion: d translations, then the rotations.

    e_k, and e_i (p - a)_j - e_j (p - a)_i for the planes of the axes; in space these are
    e_k and e_k × (p - a), in the plane the third is the quarter turn (-(p - a)_2, (p - a)_1).

    Parameters
    ----------
    points : (n, d) array_like
        The points p.
    about : (d,) array_like, optional
        The centre a of the rotations; the origin by default.

    Returns
    -------
    (n, d, r) ndarray
        The r = d (d + 1) / 2 motions last.

    Examples
    --------
    >>> rigid_motions([[3.0, 1.0]])[0]
    array([[ 1.,  0., -1.],
           [ 0.,  1.,  3.]])
    """
    p = valid.as_points(points)
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
        Where the loads act.
    loads : (n, d, ...) array_like
        The loads.
    about : (d,) array_like, optional
        The point about which moments are taken; the origin by default.

    Returns
    -------
    (r, ...) ndarray
        The d components of sum f_i, then the moments; in space those of sum (p_i - a) × f_i.

    Examples
    --------
    >>> net_force_and_moment([[3.0, 1.0]], [[0.0, 2.0]])  # 2 upwards, on an arm of 3
    array([0., 2., 6.])
    """
    p = valid.as_points(points)
    return np.einsum("ndr,nd...->r...", rigid_motions(p, about), as_vectors(loads, p, "loads"))


def as_vectors(values: ArrayLike, points: np.ndarray, name: str) -> np.ndarray:
    """One vector of d components, or several, for each of the points (n, d): (n, d, ...)."""
    n, d = points.shape
    v = valid.as_values(values, n, name)
    if v.ndim < 2 or v.shape[1] != d:
        raise ValueError(
            f"{name} must be vectors of {d} components, shape ({n}, {d}, ...); got {v.shape}"
        )
    return v


def _planes(d: int) -> list[tuple[int, int]]:
    """Pairs of axes; in space those across x, y and z, in the sense of the right hand."""
    return [(1, 2), (2, 0), (0, 1)] if d == 3 else list(combinations(range(d), 2))


def _as_center(about: ArrayLike, d: int) -> np.ndarray:
    a = valid.as_queries(about, d)
    if a.shape != (d,):
        raise ValueError(f"about must be one point of {d} coordinates; got the shape {a.shape}")
    return a
