"""Levels of patches, and the part that each patch has in the value at a query.

Where the patches of a level cover a query badly, those of the next level, which has a fraction of
the sites, take over: with W the sum of the weights, by c (1 - W/c)^3 for W < c and by nothing
otherwise, so that the parts are twice continuously differentiable. The last level covers all space.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import repeat
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from fieldrecon._chunks import Progress, passes
from fieldrecon._halving import Boxes
from fieldrecon._patch_growth import systems_of
from fieldrecon._patch_systems import PatchSystems, Problem
from fieldrecon._patches import SITES_PER_BOX, Patches, bump

COVERED = 5e-3
"""The sum c of the weights from which on patches are alone."""
FEW_COLUMNS = 3
"""Up to which sums by counting are faster than by a sparse matrix."""
PASSES = 5
"""Parts of the set-up: cuts, balls, what these reach, systems; and all coarser levels."""
ALONE = 4
"""As many sites as these many patches hold are a patch of their own."""


@dataclass(frozen=True)
class Level:
    """Patches on some of the sites.

    Attributes
    ----------
    sites : (s,) ndarray
        Which of all sites.
    patches : Patches
        Where they are.
    systems : tuple of PatchSystems
        Their problems, those of one size together.
    group, member : (p,) ndarray
        In which of the systems each patch is, and where in it.
    """

    sites: np.ndarray
    patches: Patches
    systems: tuple[PatchSystems, ...]
    group: np.ndarray
    member: np.ndarray


class Share(NamedTuple):
    """The part of patches of one level in the values at queries, ordered by query.

    Attributes
    ----------
    level : Level
        Whose patches.
    query, patch : (p,) ndarray
        The pairs.
    weight : (p,) ndarray
        Over all shares, the weights of a query sum to one.
    gradient : (p, d) ndarray
        Their gradients.
    """

    level: Level
    query: np.ndarray
    patch: np.ndarray
    weight: np.ndarray
    gradient: np.ndarray

    def systems(self) -> Iterator[tuple[PatchSystems, int, np.ndarray, np.ndarray]]:
        """Yield each of the systems, its number, the pairs of its patches, and which they are."""
        group = self.level.group[self.patch]
        for number, systems in enumerate(self.level.systems):
            pairs = np.flatnonzero(group == number)
            yield systems, number, pairs, self.level.member[self.patch[pairs]]


def levels_of(
    points: np.ndarray, k: int, problem: Problem, progress: Progress | None = None
) -> Iterator[Level]:
    """Yield levels of patches with k of the sites (n, d) each; the last is a single patch."""
    sites = np.arange(len(points))
    tell: Iterator[Progress | None] = passes(progress, len(points), PASSES)
    while True:
        alone = len(sites) <= ALONE * k
        size = len(sites) if alone else max(1, SITES_PER_BOX * k)
        boxes = Boxes.around(points[sites], size, next(tell))
        boxes, order = boxes.in_order()
        sites = sites[order]
        own = points[sites]
        tree = cKDTree(own)
        told = next(tell), next(tell)
        patches = Patches.single(own, boxes) if alone else Patches.of(own, tree, boxes, k, *told)
        yield Level(sites, patches, *systems_of(own, tree, patches, problem, next(tell)))
        tell = repeat(None)
        if alone:
            if progress is not None:
                progress(len(points), len(points))
            return
        sites = sites[patches.representatives]


def shares(levels: Sequence[Level], x: np.ndarray, gradients: bool) -> Iterator[Share]:
    """Yield the shares of the levels in the values at the queries (m, d).

    Without gradients, those of the weights have no columns.
    """
    columns = x.shape[1] if gradients else 0
    query, left, slope = np.arange(len(x)), np.ones(len(x)), np.zeros((len(x), columns))
    for number, level in enumerate(levels):
        own, patch, offset = level.patches.containing(x[query])
        weight, gradient = bump(offset)
        gradient = gradient[:, :columns] / level.patches.radii[patch, None]
        total, change = summed(own, weight, len(query)), summed(own, gradient, len(query))
        behind = 1.0 - total / COVERED if number + 1 < len(levels) else np.zeros_like(total)
        behind = np.maximum(behind, 0.0)[:, None]
        rest, restchange = COVERED * behind[:, 0] ** 3, -3.0 * behind**2 * change
        whole, wholechange = total + rest, change + restchange
        left = left / whole
        slope = slope / whole[:, None] - left[:, None] * wholechange / whole[:, None]
        part = left[own] * weight
        yield Share(
            level,
            query[own],
            patch,
            part,
            left[own, None] * gradient + slope[own] * weight[:, None],
        )
        slope = slope * rest[:, None] + left[:, None] * restchange
        left = left * rest
        further = np.flatnonzero(rest)
        if not len(further):
            return
        query, left, slope = query[further], left[further], slope[further]


def summed(query: np.ndarray, terms: np.ndarray, m: int) -> np.ndarray:
    """Sums (m, ...) of the terms (p, ...) of each query, which are in the order of queries."""
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
