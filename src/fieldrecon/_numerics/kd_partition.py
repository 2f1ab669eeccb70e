"""Space cut into boxes that hold nearly equally many sites, and the balls that reach into each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from scipy import sparse

from fieldrecon._core.chunks import Progress, chunked, rows_of

MOST_SLABS = 7
"""Parts of the first cut, so that boxes need not be as large as powers of two make them."""

Cuts: TypeAlias = tuple[np.ndarray, np.ndarray]
"""Of each box of a level (b,): across which axis it is cut, and where."""


@dataclass(frozen=True)
class KDPartition:
    """A few slabs, each halved across the longest side again and again; they fill all space.

    Attributes
    ----------
    across : int
        Axis that the slabs are cut across.
    slabs : (s - 1,) ndarray
        Where.
    halvings : sequence of Cuts
        Of each level, for its s 2^l boxes.
    sites : (s 2^L, m) ndarray
        Sites in the boxes of the last level, as many in each or one fewer; -1 where there is none.
    """

    across: int
    slabs: np.ndarray
    halvings: Sequence[Cuts]
    sites: np.ndarray

    @classmethod
    def around(
        cls, points: np.ndarray, size: float, progress: Progress | None = None
    ) -> KDPartition:
        """Boxes of so many of the sites (n, d) or fewer, but not by more than a fifth."""
        number, levels = _slabs_and_levels(len(points) / size)
        across = int(np.argmax(points.max(axis=0) / 2 - points.min(axis=0) / 2))
        cuts, slabs = _slabs(points[:, across], number)
        parts = chunked(partial(_cut, points, levels), slabs, 1, progress=progress)
        *halvings, sites = zip(*(part for _, part in parts), strict=True)
        return cls(across, cuts, [_joined(level) for level in halvings], np.concatenate(sites))

    def in_order(self) -> tuple[KDPartition, np.ndarray]:
        """The same boxes for sites renumbered so that neighbours follow each other; the order."""
        there = self.sites >= 0
        sites = np.full_like(self.sites, -1)
        sites[there] = np.arange(there.sum())
        return replace(self, sites=sites), self.sites[there]

    def containing(self, x: np.ndarray) -> np.ndarray:
        """The box (m,) of each of the places (m, d)."""
        box, each = np.searchsorted(self.slabs, x[:, self.across]), np.arange(len(x))
        for axis, cut in self.halvings:
            box = 2 * box + (x[each, axis[box]] > cut[box])
        return box

    def reached(
        self, centers: np.ndarray, radii: np.ndarray, progress: Progress | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Which balls reach into each box: `ball[start[b] : start[b + 1]]`, rising."""
        rows = rows_of(2**7 * 8 * centers.shape[1])
        work = partial(self._reach, centers, radii)
        parts = chunked(work, np.arange(len(centers)), rows, progress=progress)
        ball, box = np.concatenate([part for _, part in parts], axis=1)
        shape = len(self.sites), len(centers)
        there = sparse.coo_array((np.ones(len(ball), dtype=bool), (box, ball)), shape).tocsr()
        return there.indices, there.indptr

    def _reach(self, centers: np.ndarray, radii: np.ndarray, balls: np.ndarray) -> np.ndarray:
        """Pairs (2, p) of a ball and a box that it reaches into."""
        x, r = centers[balls], radii[balls]
        along = x[:, self.across, None]
        low, high = np.append(-np.inf, self.slabs), np.append(self.slabs, np.inf)
        beside = np.maximum(np.maximum(low - along, along - high), 0.0)
        ball, box = np.nonzero(beside <= r[:, None])
        outside = np.zeros((len(ball), x.shape[1]))  # of the box, by axis
        outside[:, self.across] = beside[ball, box]
        for axis, cut in self.halvings:
            across = axis[box]
            beyond = x[ball, across] - cut[box]
            further = outside.copy()  # the half in which the centre lies is no farther
            each = np.arange(len(ball)), across
            further[each] = np.maximum(further[each], np.abs(beyond))
            near = np.einsum("pd,pd->p", further, further) <= r[ball] ** 2
            here = 2 * box + (beyond > 0)
            ball = np.concatenate([ball, ball[near]])
            box = np.concatenate([here, here[near] ^ 1])
            outside = np.concatenate([outside, further[near]])
        return np.stack([balls[ball], box])


def _slabs_and_levels(boxes: float) -> tuple[int, int]:
    """The least s 2^L that is no fewer boxes."""
    levels = max(0, math.ceil(math.log2(max(boxes, 1.0) / MOST_SLABS)))
    return math.ceil(boxes / 2**levels), levels


def _slabs(along: np.ndarray, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Where to cut (s - 1,) the coordinates (n,), and the sites of each slab (s, n // s + 1)."""
    n = len(along)
    ends = np.arange(1, number) * n // number
    order = np.argpartition(along, ends) if number > 1 else np.arange(n)
    parts = np.split(order, ends)
    rows = np.full((number, n // number + 1), -1)
    for row, part in zip(rows, parts, strict=True):
        row[: len(part)] = part
    pairs = pairwise(parts)
    cuts = [along[left].max() / 2 + along[right].min() / 2 for left, right in pairs]
    return np.array(cuts), rows


def _cut(points: np.ndarray, levels: int, rows: np.ndarray) -> tuple[Cuts | np.ndarray, ...]:
    """Halve each of the rows so many times: the cuts of each level, and the rows of the last."""
    cuts, places = [], points.T[:, rows]
    for _ in range(levels):
        axis, cut, rows, places = halved(rows, places)
        cuts.append((axis, cut))
    return (*cuts, rows)


def _joined(cuts: Sequence[Cuts]) -> Cuts:
    axes, places = zip(*cuts, strict=True)
    return np.concatenate(axes), np.concatenate(places)


def halved(
    rows: np.ndarray, places: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Cut each row of sites across the longest side of its box, into halves that differ by one.

    Parameters
    ----------
    rows : (b, s + 1) ndarray
        Numbers of sites, s or s + 1 in each row; where the last is missing, -1.
    places : (d, b, s + 1) ndarray
        Where they are.

    Returns
    -------
    axis, cut : (b,) ndarray
        Across which axis, and where.
    halves : (2 b, s // 2 + 1) ndarray
        Rows of the same form, two for each.
    halfplaces : (d, 2 b, s // 2 + 1) ndarray
        Where they are.
    """
    low, high = extents(rows, places)
    axis = np.argmax(high - low, axis=0)
    along = places[axis, np.arange(len(rows))]
    along[rows[:, -1] < 0, -1] = np.inf
    s = rows.shape[1] - 1
    left = (s + 1) // 2
    order = np.argpartition(along, (left, s), axis=1)  # what is no site stays last
    along = np.take_along_axis(along, order, axis=1)
    cut = along[:, :left].max(axis=1) / 2 + along[:, left] / 2
    halves = _split(np.take_along_axis(rows, order, axis=1), left, -1)
    halfplaces = [_split(np.take_along_axis(p, order, axis=1), left, 0.0) for p in places]
    return axis, cut, halves, np.stack(halfplaces)


def extents(rows: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest coordinates (d, b) of the sites in each row."""
    low, high = places[..., :-1].min(axis=2), places[..., :-1].max(axis=2)
    last = places[..., -1]
    there = rows[:, -1] >= 0
    return np.where(there, np.minimum(low, last), low), np.where(
        there, np.maximum(high, last), high
    )


def _split(ordered: np.ndarray, left: int, nothing: float) -> np.ndarray:
    """The first `left` columns and the rest as rows of the same length."""
    b, s = ordered.shape[0], ordered.shape[1] - 1
    halves = np.full((b, 2, s // 2 + 1), nothing, dtype=ordered.dtype)
    halves[:, 0, :left] = ordered[:, :left]
    halves[:, 1] = ordered[:, left:]
    return halves.reshape(2 * b, -1)
