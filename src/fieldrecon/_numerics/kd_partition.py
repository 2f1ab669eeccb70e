"""Partition of space by a k-d tree into boxes with nearly equally many sites."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from scipy import sparse

from fieldrecon._core.chunks import Progress, chunked, rows_of

MOST_SLABS = 7
"""Maximum number of slabs of the first cut, so that boxes can have nearly any size."""

Cuts: TypeAlias = tuple[np.ndarray, np.ndarray]
"""For each box of a level (b,): the axis it is cut across, and the coordinate of the cut."""


@dataclass(frozen=True)
class KDPartition:
    """A few slabs, each halved repeatedly across its longest side; the boxes fill all space.

    Attributes
    ----------
    across : int
        Axis that the slabs are cut across.
    slabs : (s - 1,) ndarray
        Coordinates of the cuts between the slabs.
    halvings : sequence of Cuts
        For each level l, the cuts of its s 2^l boxes.
    sites : (s 2^L, m) ndarray
        Sites in each box of the last level, m or m - 1 of them; -1 where there is none.
    """

    across: int
    slabs: np.ndarray
    halvings: Sequence[Cuts]
    sites: np.ndarray

    @classmethod
    def around(
        cls,
        points: np.ndarray,
        size: float,
        executor: Executor | None = None,
        progress: Progress | None = None,
    ) -> KDPartition:
        """Boxes of at most `size` of the sites (n, d) each, and at least four fifths of that."""
        number, levels = _slabs_and_levels(len(points) / size)
        across = int(np.argmax(points.max(axis=0) / 2 - points.min(axis=0) / 2))
        cuts, slabs = _slabs(points[:, across], number)
        parts = chunked(partial(_cut, points, levels), slabs, 1, executor, progress)
        *halvings, sites = zip(*(part for _, part in parts), strict=True)
        return cls(across, cuts, [_joined(level) for level in halvings], np.concatenate(sites))

    def in_order(self) -> tuple[KDPartition, np.ndarray]:
        """The same boxes for sites renumbered box by box, and the order of the old numbers."""
        there = self.sites >= 0
        sites = np.full_like(self.sites, -1)
        sites[there] = np.arange(there.sum())
        return replace(self, sites=sites), self.sites[there]

    def containing(self, x: np.ndarray) -> np.ndarray:
        """Index (m,) of the box that contains each of the points (m, d)."""
        box, each = np.searchsorted(self.slabs, x[:, self.across]), np.arange(len(x))
        for axis, cut in self.halvings:
            box = 2 * box + (x[each, axis[box]] > cut[box])
        return box

    def reached(
        self,
        centers: np.ndarray,
        radii: np.ndarray,
        executor: Executor | None = None,
        progress: Progress | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Balls that reach into each box b: `ball[start[b] : start[b + 1]]`, in ascending order."""
        rows = rows_of(2**7 * 8 * centers.shape[1])
        work = partial(self._reach, centers, radii)
        parts = chunked(work, np.arange(len(centers)), rows, executor, progress)
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
        outside = np.zeros((len(ball), x.shape[1]))  # distance of the centre from the box, by axis
        outside[:, self.across] = beside[ball, box]
        for axis, cut in self.halvings:
            across = axis[box]
            beyond = x[ball, across] - cut[box]
            further = outside.copy()  # only the half without the centre is farther
            each = np.arange(len(ball)), across
            further[each] = np.maximum(further[each], np.abs(beyond))
            near = np.einsum("pd,pd->p", further, further) <= r[ball] ** 2
            here = 2 * box + (beyond > 0)
            ball = np.concatenate([ball, ball[near]])
            box = np.concatenate([here, here[near] ^ 1])
            outside = np.concatenate([outside, further[near]])
        return np.stack([balls[ball], box])


def _slabs_and_levels(boxes: float) -> tuple[int, int]:
    """S and L of the smallest s 2^L that is at least the number of boxes."""
    levels = max(0, math.ceil(math.log2(max(boxes, 1.0) / MOST_SLABS)))
    return math.ceil(boxes / 2**levels), levels


def _slabs(along: np.ndarray, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Cuts (s - 1,) of the coordinates (n,), and the sites of each slab (s, n // s + 1)."""
    n = len(along)
    ends = np.arange(1, number) * n // number
    order = np.argpartition(along, ends)
    parts = np.split(order, ends)
    rows = np.full((number, n // number + 1), -1)
    for row, part in zip(rows, parts, strict=True):
        row[: len(part)] = part
    pairs = pairwise(parts)
    cuts = [along[left].max() / 2 + along[right].min() / 2 for left, right in pairs]
    return np.array(cuts), rows


def _cut(points: np.ndarray, levels: int, rows: np.ndarray) -> tuple[Cuts | np.ndarray, ...]:
    """Halve each of the rows `levels` times: the cuts of each level, and the rows of the last."""
    cuts, coordinates = [], points.T[:, rows]
    for _ in range(levels):
        axis, cut, rows, coordinates = halved(rows, coordinates)
        cuts.append((axis, cut))
    return (*cuts, rows)


def _joined(cuts: Sequence[Cuts]) -> Cuts:
    axes, coordinates = zip(*cuts, strict=True)
    return np.concatenate(axes), np.concatenate(coordinates)


def halved(
    rows: np.ndarray, coordinates: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Cut each row of sites across the longest side of its box, into halves that differ by one.

    Parameters
    ----------
    rows : (b, s + 1) ndarray
        Indices of sites, s or s + 1 in each row; -1 where the last is missing.
    coordinates : (d, b, s + 1) ndarray
        Coordinates of the sites.

    Returns
    -------
    axis, cut : (b,) ndarray
        Axis and coordinate of each cut.
    halves : (2 b, s // 2 + 1) ndarray
        Rows of the same form, two for each row.
    half_coordinates : (d, 2 b, s // 2 + 1) ndarray
        Coordinates of their sites.
    """
    low, high = extents(rows, coordinates)
    axis = np.argmax(high - low, axis=0)
    along = coordinates[axis, np.arange(len(rows))]
    along[rows[:, -1] < 0, -1] = np.inf
    s = rows.shape[1] - 1
    left = (s + 1) // 2
    order = np.argpartition(along, (left, s), axis=1)  # a missing site stays last
    along = np.take_along_axis(along, order, axis=1)
    cut = along[:, :left].max(axis=1) / 2 + along[:, left] / 2
    halves = _split(np.take_along_axis(rows, order, axis=1), left, -1)
    half_coordinates = [
        _split(np.take_along_axis(p, order, axis=1), left, 0.0) for p in coordinates
    ]
    return axis, cut, halves, np.stack(half_coordinates)


def extents(rows: np.ndarray, coordinates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest coordinates (d, b) of the sites in each row."""
    low, high = coordinates[..., :-1].min(axis=2), coordinates[..., :-1].max(axis=2)
    last = coordinates[..., -1]
    there = rows[:, -1] >= 0
    return np.where(there, np.minimum(low, last), low), np.where(
        there, np.maximum(high, last), high
    )


def _split(ordered: np.ndarray, left: int, missing: float) -> np.ndarray:
    """The first `left` columns and the other columns as rows of the same length."""
    b, s = ordered.shape[0], ordered.shape[1] - 1
    halves = np.full((b, 2, s // 2 + 1), missing, dtype=ordered.dtype)
    halves[:, 0, :left] = ordered[:, :left]
    halves[:, 1] = ordered[:, left:]
    return halves.reshape(2 * b, -1)
