"""Blending of patches: their shares in the value at a query, and the matrices of weights.

The patches form levels. Where those of a level hardly cover a query, the patches of the next level,
which has a fraction of the sites, take over. With W the sum of the weights of the level, they have
the weight c (1 - W/c)^3 for W < c and zero otherwise, so that the shares are twice continuously
differentiable. The last level covers all space.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from itertools import chain, islice, repeat
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from fieldrecon._core.chunks import Progress, progress_after, report_all, split_progress
from fieldrecon._core.duplicates import by_position
from fieldrecon._numerics.jets import composition, product, quotient, rows_of_jet
from fieldrecon._numerics.kd_partition import KDPartition
from fieldrecon.methods.partition_of_unity.ball_weights import COVERED, bump
from fieldrecon.methods.partition_of_unity.patch_systems import PatchSystems, Problem
from fieldrecon.methods.partition_of_unity.patches import SITES_PER_BOX, Patches, systems_of

FEW_COLUMNS = 3
"""Number of columns up to which `bincount` sums faster than a sparse matrix."""
PASSES = 5
"""Steps of the set-up for progress: cuts, balls, reached boxes, systems; and coarser levels."""
ALONE = 4
"""A level of no more sites than this number of patches holds is a single patch."""
EVEN = 1e-3
"""Typical distance of neighbours, relative to the extent, from which on this holds.

In one patch, the kernel of closer sites would be rounding.
"""
FEW = 12
"""A coarser level of no more sites than this number for each axis is a single patch.

A third of the sites of a larger level, and two outliers of each axis, are fewer.
"""


@dataclass(frozen=True)
class Level:
    """Patches on some of the sites.

    Attributes
    ----------
    sites : (s,) ndarray
        Indices of its sites.
    patches : Patches
        The balls.
    systems : tuple of PatchSystems
        Systems of the patches, grouped by size.
    group, member : (p,) ndarray
        For each patch, the index of its group of systems and its index in the group.
    """

    sites: np.ndarray
    patches: Patches
    systems: tuple[PatchSystems, ...]
    group: np.ndarray
    member: np.ndarray


class Share(NamedTuple):
    """Shares of the patches of one level in the values at queries, ordered by query.

    Attributes
    ----------
    level : Level
        The level.
    query, patch : (p,) ndarray
        The pairs.
    weights : (c, p) ndarray
        Jets of the weights. Over all shares, the weights of a query sum to one.
    """

    level: Level
    query: np.ndarray
    patch: np.ndarray
    weights: np.ndarray

    def systems(self) -> Iterator[tuple[PatchSystems, int, np.ndarray, np.ndarray]]:
        """Yield each group of systems, its index, the pairs of its patches, and their members."""
        group = self.level.group[self.patch]
        for number, systems in enumerate(self.level.systems):
            pairs = np.flatnonzero(group == number)
            yield systems, number, pairs, self.level.member[self.patch[pairs]]


class Arrangement(NamedTuple):
    """Sites of a level, by their indices, with a tree of them, and the patches."""

    sites: np.ndarray
    points: np.ndarray
    tree: cKDTree
    patches: Patches


_known: ContextVar[dict[tuple[bytes, int], list[Arrangement]] | None] = ContextVar(
    "_known", default=None
)


@contextmanager
def shared_patches() -> Iterator[None]:
    """Inside the ``with``, methods on the same sites share their patches, which take long to make.

    They do not depend on the kernel, the degree or the smoothing.
    """
    token = _known.set({})
    try:
        yield
    finally:
        _known.reset(token)


def levels_of(
    points: np.ndarray,
    k: int,
    problem: Problem,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Iterator[Level]:
    """Yield levels of patches with k of the sites (n, d) each; the last is a single patch."""
    of_finest = islice(split_progress(progress, len(points), PASSES), PASSES - 1)
    steps = chain(of_finest, repeat(None))
    for sites, own, tree, patches in _arrangements(points, k, executor, steps):
        here = replace(problem, smoothing=problem.smoothing[sites])
        systems = systems_of(own, tree, patches, here, executor, next(steps))
        yield Level(sites, patches, *systems)
    report_all(progress, len(points))


def _arrangements(
    points: np.ndarray, k: int, executor: Executor | None, steps: Iterator[Progress | None]
) -> Iterable[Arrangement]:
    """The patches of all levels: those that are known, or new ones."""
    new = _new_arrangements(points, k, executor, steps)
    known = _known.get()
    if known is None:
        return new
    key = points.tobytes(), k
    if key not in known:
        known[key] = list(new)
    return known[key]


def _new_arrangements(
    points: np.ndarray, k: int, executor: Executor | None, steps: Iterator[Progress | None]
) -> Iterator[Arrangement]:
    """Yield the patches of each level."""
    sites = by_position(points)  # so that their order does not matter where distances tie
    while True:
        own = points[sites]
        own_k = _patch_size(own, k, finest=len(sites) == len(points))
        alone = own_k == len(sites)
        size = len(sites) if alone else max(1, SITES_PER_BOX * own_k)
        boxes = KDPartition.around(own, size, executor, next(steps))
        boxes, order = boxes.in_order()
        sites, own = sites[order], own[order]
        tree = cKDTree(own)
        covering, reaching = next(steps), next(steps)
        patches = (
            Patches.single(own, boxes)
            if alone
            else Patches.of(own, tree, boxes, own_k, executor, covering, reaching)
        )
        yield Arrangement(sites, own, tree, patches)
        if alone:
            return
        sites = sites[patches.representatives]


def _patch_size(points: np.ndarray, k: int, finest: bool) -> int:
    """Number of sites of each patch: all of a few, unless they are clusters far from others."""
    n, d = points.shape
    if n <= (3 if finest else FEW * d):
        return n
    if n > ALONE * k:
        return k
    extent = np.linalg.norm(np.ptp(points, axis=0))
    neighbors = cKDTree(points).query(points, 2)[0][:, 1]
    return n if np.median(neighbors) >= EVEN * extent else min(k, n // 2)


def shares(levels: Sequence[Level], x: np.ndarray, order: int) -> Iterator[Share]:
    """Yield the shares of the levels in the values at the queries (m, d).

    Their weights come with derivatives up to the order. What is left for a level has the jet
    `left` at each query.
    """
    d = x.shape[1]
    query, left = np.arange(len(x)), np.zeros((rows_of_jet(d, order), len(x)))
    left[0] = 1.0
    for level in levels:
        own, patch, offset = level.patches.containing(x[query])
        weight = bump(offset, order)
        weight[1:] /= level.patches.radii[patch]
        weight[1 + d :] /= level.patches.radii[patch]
        total = summed(own, weight.T, len(query)).T
        rest = _taken_over(total, d) if level is not levels[-1] else np.zeros_like(total)
        left = quotient(left, total + rest, d)
        yield Share(level, query[own], patch, product(left[:, own], weight, d))
        further = np.flatnonzero(rest[0])
        if not len(further):
            return
        query, left = query[further], product(left[:, further], rest[:, further], d)


def _taken_over(total: np.ndarray, d: int) -> np.ndarray:
    """Jet of the weight c (1 - W/c)^3 of the next level, zero for W > c, from that of W."""
    behind = np.maximum(1.0 - total[0] / COVERED, 0.0)
    return composition((COVERED * behind**3, -3 * behind**2, 6 * behind / COVERED), total, d)


def weight_rows(levels: Sequence[Level], n: int, x: np.ndarray) -> sparse.csr_array:
    """Weights (m, n) of the data of n sites in the values at queries (m, d)."""
    triples = []
    for share in shares(levels, x, order=0):
        for systems, _, pairs, member in share.systems():
            query = share.query[pairs]
            terms = systems.basis(member, x[query]) * share.weights[0, pairs, None]
            sites = share.level.sites[systems.sites[member]]
            triples.append((query, sites, systems.of_data(member, terms)))
    return _matrix(triples, (len(x), n))


def gradient_weight_rows(levels: Sequence[Level], n: int, x: np.ndarray) -> list[sparse.csr_array]:
    """Weights in each component of the gradient, d matrices (m, n)."""
    triples: list[list[tuple[np.ndarray, np.ndarray, np.ndarray]]] = [[] for _ in x.T]
    for share in shares(levels, x, order=1):
        for systems, _, pairs, member in share.systems():
            query = share.query[pairs]
            basis = systems.basis(member, x[query])
            change = systems.basis_gradient(member, x[query])
            sites = share.level.sites[systems.sites[member]]
            for k, component in enumerate(triples):
                terms = change[..., k] * share.weights[0, pairs, None]
                terms += basis * share.weights[1 + k, pairs, None]
                component.append((query, sites, systems.of_data(member, terms)))
    return [_matrix(component, (len(x), n)) for component in triples]


def number_of_patches(levels: Sequence[Level]) -> int:
    """Number of the patches of all levels."""
    return sum(len(level.patches) for level in levels)


class Moments:
    """Sums of the basis functions of patches at queries, times the loads there."""

    def __init__(self, levels: Sequence[Level], v: int, dtype: np.dtype) -> None:
        self._levels = levels
        self._sums = [
            [np.zeros((len(s), s.size, v), dtype=dtype) for s in level.systems] for level in levels
        ]

    def add(self, parts: Iterable[tuple[int, int, np.ndarray, np.ndarray]]) -> None:
        """Add the result of `moments` for some queries."""
        for level, number, patch, sums in parts:
            self._sums[level][number][patch] += sums

    def of_sites(self, n: int, executor: Executor | None, progress: Progress | None) -> np.ndarray:
        """H^T f (n, v), from the sums by the transposed systems."""
        v = self._sums[0][0].shape[2]
        total = np.zeros((n, v), dtype=self._sums[0][0].dtype)
        done, patches = 0, number_of_patches(self._levels)
        for level, sums in zip(self._levels, self._sums, strict=True):
            for systems, own in zip(level.systems, sums, strict=True):
                sites = level.sites[systems.sites].ravel()
                own_progress = progress_after(progress, done, patches)
                data = systems.adjoint(own, executor, own_progress)
                where, rows = _summed_by_row(sites, data.reshape(len(sites), v))
                total[where] += rows
                done += len(systems)
        return total


def moments(
    levels: Sequence[Level], x: np.ndarray, f: np.ndarray, rows: np.ndarray
) -> list[tuple[int, int, np.ndarray, np.ndarray]]:
    """Sums for some `rows` of queries (m, d) with loads f (m, v): level, group, members, sums."""
    x, f = x[rows], f[rows]
    found = []
    for number, share in enumerate(shares(levels, x, order=0)):
        for systems, own, pairs, member in share.systems():
            query = share.query[pairs]
            basis = systems.basis(member, x[query]) * share.weights[0, pairs, None]
            terms = basis[..., None] * f[query, None, :]
            found.append((number, own, *_summed_by_row(member, terms)))
    return found


def summed(query: np.ndarray, terms: np.ndarray, m: int) -> np.ndarray:
    """Sums (m, ...) of the terms (p, ...) of each query; the terms are ordered by query."""
    columns = terms.reshape(len(terms), math.prod(terms.shape[1:]))
    if columns.dtype == float and columns.shape[1] <= FEW_COLUMNS:
        sums = np.empty((m, columns.shape[1]))
        for total, column in zip(sums.T, columns.T, strict=True):
            total[:] = np.bincount(query, column, m)
    else:
        start = np.searchsorted(query, np.arange(m + 1))
        pairs = np.ones(len(query)), np.arange(len(query)), start
        sums = sparse.csr_array(pairs, (m, len(query))) @ columns
    return sums.reshape(m, *terms.shape[1:])


def _matrix(
    triples: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]], shape: tuple[int, int]
) -> sparse.csr_array:
    """Matrix of entries (p, k) in rows (p,) and columns (p, k); repeated entries are summed."""
    rows = [np.repeat(query, sites.shape[1]) for query, sites, _ in triples]
    columns = [sites.ravel() for _, sites, _ in triples]
    entries = [weights.ravel() for _, _, weights in triples]
    indices = np.concatenate(rows), np.concatenate(columns)
    return sparse.coo_array((np.concatenate(entries), indices), shape).tocsr()


def _summed_by_row(rows: np.ndarray, terms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distinct rows in ascending order, and the sums of their terms (p, ...)."""
    order = np.argsort(rows, kind="stable")
    rows = rows[order]
    new = np.diff(rows, prepend=-1) > 0
    return rows[new], summed(np.cumsum(new) - 1, terms[order], int(new.sum()))
