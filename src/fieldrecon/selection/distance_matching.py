"""Folds whose held-out samples are as far from the others as the queries are from the samples.

Leave-one-out residuals estimate the error at a query only if the query is as far from the samples
as these are from each other. Along the tracks of a ship they are not: the next sample is near, and
the next track is far. So each held-out sample takes the distance of a query: all samples within
this distance of it are left out of the fit as well. This is nearest-neighbour distance matching.
Several samples with their neighbourhoods, far enough apart, are held out at once, so that a few
fits suffice for many samples.

References
----------
Milà, Mateu, Pebesma and Meyer, Nearest neighbour distance matching leave-one-out cross-validation
for map validation (2022); Linnenbrink, Milà, Ludwig and Meyer, kNNDM cross-validation: k-fold
nearest-neighbour distance matching cross-validation for map accuracy estimation (2024).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid

EXCLUDED = 0.2
"""Largest fraction of the samples that one fold leaves out."""
VICINITY = 0.05
"""Fraction of the samples, the nearest to a query, from which its held-out sample is drawn."""
_LEAST_VICINITY = 16
_DRAWS = 4  # largest mean number of draws of a sample
_BIASED = 0.1  # tolerated difference of the radii of draws with room from those of all draws
_LEAST_DRAWS = 25  # number that is placed as far as there is room
_FEWER = 0.8  # part of the draws that is kept if the difference is larger
_FEW_DRAWS, _NEARER = 50, 0.98  # number of draws of which the nearer part is kept instead
_APART = 1.5  # no held-out samples of a fold have common neighbours within this many distances
_QUANTILES = np.linspace(0.0, 1.0, 201)


@dataclass(frozen=True, eq=False)
class Fold:
    """Samples that are predicted, and those from which they are predicted, by their indices.

    Parameters
    ----------
    held_out : ndarray of shape (h,)
        Samples that are predicted.
    fitted : ndarray of shape (f,)
        Samples that are fitted: neither held out nor near a held-out one.
    """

    held_out: np.ndarray
    fitted: np.ndarray


def nearest_neighbor_distances(points: ArrayLike, x: ArrayLike | None = None) -> np.ndarray:
    """Distance of each query from its nearest sample; of each sample from the others, without any.

    Parameters
    ----------
    points : (n, d) array_like
        Samples.
    x : (m, d) array_like, optional
        Queries.

    Returns
    -------
    (m,) or (n,) ndarray

    Examples
    --------
    >>> nearest_neighbor_distances([[0.0], [1.0], [4.0]]).tolist()
    [1.0, 1.0, 3.0]
    >>> nearest_neighbor_distances([[0.0], [1.0], [4.0]], [[2.0]]).tolist()
    [1.0]
    """
    points = valid.as_points(points)
    if x is None:
        return cKDTree(points).query(points, [2])[0][:, 0]
    return cKDTree(points).query(valid.as_queries(x, points.shape[1]))[0]


def held_out_distances(points: ArrayLike, folds: Sequence[Fold]) -> np.ndarray:
    """Distance of each held-out sample from the nearest one that is fitted, fold by fold.

    Parameters
    ----------
    points : (n, d) array_like
        All samples.
    folds : sequence of Fold
        Indices of the samples that are held out, and of those that are fitted.

    Returns
    -------
    (h,) ndarray
        For the h held-out samples of all folds; a sample of two folds has two distances.
    """
    points = valid.as_points(points)
    return np.concatenate(
        [nearest_neighbor_distances(points[f.fitted], points[f.held_out]) for f in folds]
    )


def wasserstein_distance(a: ArrayLike, b: ArrayLike) -> float:
    """Mean difference of the quantiles of two sets of numbers, W = int |F^-1(p) - G^-1(p)| dp.

    Examples
    --------
    >>> wasserstein_distance([0.0, 1.0], [2.0, 3.0])
    2.0
    """
    of_a = np.quantile(valid.as_numbers(a, "a", complex_allowed=False), _QUANTILES)
    of_b = np.quantile(valid.as_numbers(b, "b", complex_allowed=False), _QUANTILES)
    difference = of_a - of_b
    return float(np.trapezoid(abs(difference), _QUANTILES))


def distance_matched_folds(
    points: ArrayLike,
    x: ArrayLike | None = None,
    n_folds: int = 5,
    max_held_out: int = 1000,
    *,
    seed: int = 0,
) -> tuple[Fold, ...]:
    """Folds whose held-out samples have the distances of the queries to the nearest sample.

    For a query drawn at random, a sample is drawn from its vicinity, the twentieth of the samples
    that is nearest to it. The sample is held out, and all samples that are nearer to it than the
    distance of a query are excluded from the fit. The distances come from the drawn queries;
    where samples are sparse, they are given the larger ones. A fold excludes at most a fifth of the
    samples; a query too far for that is left out, and the largest of the `held_out_distances` is
    the distance up to which errors are known. If all queries are too far, nothing but the held-out
    samples is excluded.

    Parameters
    ----------
    points : (n, d) array_like
        Samples.
    x : (m, d) array_like, optional
        Queries, or points distributed like them. Without any, nothing but the held-out samples is
        excluded.
    n_folds : int
        Number of folds, and of fits of a method that is evaluated.
    max_held_out : int
        Largest number of held-out samples in all folds; one may occur in several of them.
    seed : int
        Of the draws.

    Returns
    -------
    tuple of Fold
        Without folds that have nothing to hold out.

    Examples
    --------
    >>> import fieldrecon as fr
    >>> along, across = np.meshgrid(np.arange(100.0), np.arange(0.0, 200.0, 20.0))
    >>> tracks = np.column_stack([along.ravel(), across.ravel()])
    >>> x = fr.datasets.uniform(500, 2, seed=0) * [99, 180]
    >>> folds = distance_matched_folds(tracks, x)
    >>> float(np.median(nearest_neighbor_distances(tracks)))
    1.0
    >>> bool(4 <= np.median(held_out_distances(tracks, folds)) <= 6)
    True
    """
    points = valid.as_points(points)
    valid.as_count(n_folds, "n_folds", wanted="a positive integer")
    valid.as_count(max_held_out, "max_held_out", wanted="a positive integer")
    rng = np.random.default_rng(seed)
    tree = cKDTree(points)
    if x is None:
        center = rng.permutation(len(points))[:max_held_out]
        radius = np.zeros(len(center))
    else:
        x = valid.as_queries(x, points.shape[1])
        count = min(max_held_out, _DRAWS * len(points))
        drawn = np.resize(rng.permutation(len(x))[:count], count if len(x) else 0)
        center, radius = _neighborhoods(tree, x[drawn], rng)
    most = max(1, int(EXCLUDED * len(points)))
    reached = tree.query_ball_point(points[center], radius, return_length=True) <= most
    if not reached.any():
        return distance_matched_folds(points, None, n_folds, max_held_out, seed=seed)
    draws = [_Draw.of(tree, i, r) for i, r in zip(center[reached], radius[reached], strict=True)]
    return _packed(draws, len(points), n_folds, most)


def _neighborhoods(
    tree: cKDTree, x: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Samples of the vicinities of queries, and the distances of the queries from the nearest one.

    The distances are given to the samples in the order of their own distances from the others:
    if both have one distribution already, nothing but the sample itself is excluded.
    """
    n = tree.n
    rank = rng.integers(1, max(int(VICINITY * n), min(_LEAST_VICINITY, n)) + 1, len(x))
    center = np.array([tree.query(q, [k])[1][0] for q, k in zip(x, rank, strict=True)], dtype=int)
    own = tree.query(tree.data[center], [2])[0][:, 0]
    radius = np.empty(len(x))
    radius[np.argsort(own, kind="stable")] = np.sort(tree.query(x)[0])
    order = rng.permutation(len(x))  # the radii of equal distances are sorted
    return center[order], radius[order]


@dataclass(frozen=True, eq=False)
class _Draw:
    """A sample to hold out, those excluded with it, and those that no other draw may touch."""

    center: int
    radius: float
    excluded: np.ndarray
    touched: np.ndarray

    @classmethod
    def of(cls, tree: cKDTree, center: int, radius: float) -> _Draw:
        near = np.array(tree.query_ball_point(tree.data[center], _APART * radius), dtype=int)
        distance = np.linalg.norm(tree.data[near] - tree.data[center], axis=1)
        excluded = near[distance < _closest_to(radius, distance)]
        return cls(
            int(center), float(radius), np.union1d(excluded, center), np.union1d(near, center)
        )


def _packed(draws: Sequence[_Draw], n: int, n_folds: int, most: int) -> tuple[Fold, ...]:
    """Folds with as many of the draws as have room, the first ones if too many large ones have not.

    If large neighbourhoods had no room where small ones have, the distances would not match. If
    they leave room for few draws only, the largest are left out instead: an error at few samples
    is known too badly.
    """
    while True:
        wanted = np.array([draw.radius for draw in draws])
        folds = _placed(draws, n, n_folds, most)
        radii = [draw.radius for own in folds for draw in own]
        biased = wasserstein_distance(radii, wanted) > _BIASED * wanted.mean()
        if not biased or len(draws) <= _LEAST_DRAWS:
            return tuple(_fold(own, n) for own in folds if own)
        if len(draws) > _FEW_DRAWS:
            draws = draws[: int(_FEWER * len(draws))]
        else:
            nearer = np.sort(np.argsort(wanted, kind="stable")[: int(_NEARER * len(draws))])
            draws = [draws[k] for k in nearer]


def _placed(draws: Sequence[_Draw], n: int, n_folds: int, most: int) -> list[list[_Draw]]:
    """The draws of each fold: the largest first, each in the emptiest that has room, if any."""
    touched = np.zeros((n_folds, n), dtype=bool)
    folds: list[list[_Draw]] = [[] for _ in range(n_folds)]
    count = np.zeros(n_folds, dtype=int)
    for draw in sorted(draws, key=lambda draw: -draw.radius):
        room = count + len(draw.excluded) <= most
        room &= ~touched[:, draw.touched].any(axis=1)
        if room.any():
            fold = int(np.argmin(np.where(room, count, n)))
            touched[fold, draw.touched] = True
            folds[fold].append(draw)
            count[fold] += len(draw.excluded)
    return folds


def _fold(draws: Sequence[_Draw], n: int) -> Fold:
    excluded = np.concatenate([draw.excluded for draw in draws])
    return Fold(np.array([draw.center for draw in draws]), np.delete(np.arange(n), excluded))


def _closest_to(radius: float, distance: np.ndarray) -> float:
    """The distance of a neighbour that is closest to the radius, if it differs by half of it.

    Otherwise the radius itself. So the nearest sample that is fitted is on the mean neither nearer
    nor farther than the radius, where samples are sparse.
    """
    others = distance[distance > 0]
    if not len(others):
        return radius
    closest = float(others[np.argmin(abs(others - radius))])
    return closest if abs(closest - radius) <= radius / 2 else radius
