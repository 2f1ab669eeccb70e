"""Folds whose held-out samples are as far from the others as the queries are from the samples.

Leave-one-out residuals estimate the error at a query only if the query is as far from the samples
as these are from each other. Along the tracks of a ship they are not: the next sample is near, and
the next track is far. So each held-out sample takes the distance of a query: all samples within
this distance of it are left out of the fit as well. This is nearest-neighbour distance matching.

Between tracks this is not enough. A hole along a track has samples on both sides that show the
slope across it, up to its edges; the tracks beside a query do not. And a query near a track has the
next samples beyond the whole gap. So each held-out sample takes the width of the gap, too: on the
side opposite to the nearest sample that is fitted, the next one is as far as for the query.
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
_NEAREST, _FARTHEST = 32, 2048  # neighbours among which one on the other side is sought, at most
_PAIRS = 2**17  # of a query and a sample, at the same time
_DRAWS = 4  # largest mean number of draws of a sample
_BIASED = 0.1  # tolerated difference of the radii of draws with room from those of all draws
_LEAST_DRAWS = 25  # number that is placed as far as there is room
_FEWER = 0.8  # part of the draws that is kept if the difference is larger
_FEW_DRAWS, _NEARER = 50, 0.98  # number of draws of which the nearer part is kept instead
_APART = 1.5  # no held-out samples of a fold have common neighbours within this many distances
_WIDER = 1.5  # mean width of gaps at queries, by that at samples, from which it is matched, too
_OPPOSITE = -0.5  # cosine of the angle to the nearest sample below which one is on the other side
_GAPS_OF = 1000  # samples whose gaps are measured
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
    distance of a query are excluded from the fit. If the gaps about queries are on the mean 1.5
    times as wide as those about samples, so are samples on the other side, up to the width of the
    gap of the query: the distance from its nearest sample, plus that from the nearest one on the
    other side. The distances come from the drawn queries; where samples are sparse, they are given
    the larger ones. A fold excludes at most a fifth of the samples; a query too far for that is
    left out, and the largest of the `held_out_distances` is the distance up to which errors are
    known. If all queries are too far, nothing but the held-out samples is excluded.

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
        radius = gap = np.zeros(len(center))
    else:
        x = valid.as_queries(x, points.shape[1])
        count = min(max_held_out, _DRAWS * len(points))
        drawn = np.resize(rng.permutation(len(x))[:count], count if len(x) else 0)
        center, radius, gap = _neighborhoods(tree, x[drawn], rng)
    most = max(1, int(EXCLUDED * len(points)))
    reached = tree.query_ball_point(points[center], radius, return_length=True) <= most
    triples = zip(center[reached], radius[reached], gap[reached], strict=True)
    draws = [_Draw.of(tree, *triple) for triple in triples]
    draws = [draw for draw in draws if len(draw.excluded) <= most]
    if not draws:
        return distance_matched_folds(points, None, n_folds, max_held_out, seed=seed)
    return _packed(draws, len(points), n_folds, most)


def gap_widths(points: np.ndarray, x: np.ndarray, skipped: int = 0) -> np.ndarray:
    """Widths (m,) of the gaps about queries (m, d).

    That is the distance from the nearest sample, plus that from the nearest one on the other side.
    If none of the 2048 nearest ones is there, it is twice the distance from the nearest one.

    Parameters
    ----------
    points : (n, d) ndarray
        Samples.
    x : (m, d) ndarray
        Queries.
    skipped : int
        1 if the queries are samples, of which each is not its own neighbour.

    Examples
    --------
    >>> gap_widths(np.array([[0.0], [4.0]]), np.array([[1.0], [-1.0]])).tolist()
    [4.0, 2.0]
    """
    tree, width = cKDTree(points), np.empty(len(x))
    left, k = np.arange(len(x)), _NEAREST
    while len(left):
        k = min(k, tree.n)
        parts = np.array_split(left, -(-len(left) * k // _PAIRS))
        found = [_width_among(tree, x[part], k, skipped) for part in parts]
        width[left], known = map(np.concatenate, zip(*found, strict=True))
        left = left[~known & (k < min(tree.n, _FARTHEST))]
        k *= 4
    return width


def _width_among(
    tree: cKDTree, x: np.ndarray, k: int, skipped: int
) -> tuple[np.ndarray, np.ndarray]:
    """Widths (m,) of gaps among the k nearest samples, and whether both sides are among them."""
    distance, index = tree.query(x, [*range(1 + skipped, 1 + k)])
    offset = tree.data[index] - x[:, None, :]
    along = np.einsum("mkd,md->mk", offset, offset[:, 0])
    beyond = along < _OPPOSITE * distance * distance[:, :1]
    first = np.take_along_axis(distance, beyond.argmax(axis=1)[:, None], axis=1)[:, 0]
    known = beyond.any(axis=1)
    return distance[:, 0] + np.where(known, first, distance[:, 0]), known


def _neighborhoods(
    tree: cKDTree, x: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Samples of the vicinities of queries, and distances and gaps of the queries.

    The distances are given to the samples in the order of their own distances from the others:
    if both have one distribution already, nothing but the sample itself is excluded. Each distance
    comes with the width of the gap of its query, or with twice the distance if the gaps of the
    queries are not wider than those of samples.
    """
    n = tree.n
    rank = rng.integers(1, max(int(VICINITY * n), min(_LEAST_VICINITY, n)) + 1, len(x))
    center = np.array([tree.query(q, [k])[1][0] for q, k in zip(x, rank, strict=True)], dtype=int)
    own = tree.query(tree.data[center], [2])[0][:, 0]
    distance = tree.query(x)[0]
    ascending = np.argsort(distance, kind="stable")
    radius, gap = np.empty(len(x)), np.empty(len(x))
    of_own = np.argsort(own, kind="stable")
    radius[of_own], gap[of_own] = distance[ascending], _gaps(tree, x, distance)[ascending]
    order = rng.permutation(len(x))  # the radii of equal distances are sorted
    return center[order], radius[order], gap[order]


def _gaps(tree: cKDTree, x: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """The widths of gaps that the samples held out for the queries (m, d) shall have."""
    points = np.asarray(tree.data)
    some = points[:: -(-len(points) // _GAPS_OF)]
    width = gap_widths(points, x)
    wider = width.mean() > _WIDER * gap_widths(points, some, 1).mean() if len(points) > 1 else False
    return width if wider else 2 * distance


@dataclass(frozen=True, eq=False)
class _Draw:
    """A sample to hold out, those excluded with it, and those that no other draw may touch."""

    center: int
    radius: float
    excluded: np.ndarray
    touched: np.ndarray

    @classmethod
    def of(cls, tree: cKDTree, center: int, radius: float, gap: float) -> _Draw:
        """Exclude all samples within the radius, and within the gap on the other side."""
        reach = _APART * max(radius, gap - radius)
        near = np.array(tree.query_ball_point(tree.data[center], reach), dtype=int)
        offset = tree.data[near] - tree.data[center]
        distance = np.linalg.norm(offset, axis=1)
        own = distance <= _APART * radius
        inner = distance < _closest_to(radius, distance[own])
        nearest = offset[np.argmin(np.where(inner, np.inf, distance))]
        along = offset @ nearest
        beyond = along < _OPPOSITE * distance * np.linalg.norm(nearest)
        excluded = near[inner | beyond & (distance < gap - radius)]
        touched = near[own | beyond & (distance < gap - radius)]
        return cls(
            int(center), float(radius), np.union1d(excluded, center), np.union1d(touched, center)
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
