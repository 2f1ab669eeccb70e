"""Bounding-volume hierarchy: pairs of overlapping boxes.

The boxes are sorted along a Morton curve, so that neighbours in the order are neighbours in space.
They are the leaves of a balanced tree; each box of a level contains two boxes of the next. The
traversal goes down level by level, and tests all pairs of a level at once.

References
----------
Morton, A Computer Oriented Geodetic Data Base (1966); Lauterbach, Garland, Sengupta, Luebke and
Manocha, Fast BVH Construction on GPUs (2009).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from fieldrecon._core.chunks import Progress, chunked

_FRONTIER = 2**12  # pairs of nodes at which the traversal is divided among the workers
_ROWS = 2**8  # pairs of nodes of one chunk
_MAX_PAIRS = 2**20  # pairs tested at once; bounds the memory if everything overlaps

Filter = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Takes the indices of leaves i and j, and returns the pairs (k, 2) to report."""


class BVH:
    """Boxes in the order of a Morton curve, and the boxes around two, four, eight ... of them.

    Parameters
    ----------
    low, high : (m, 3) ndarray
        Corners of each box.
    origin : (3,) ndarray
        A point near the boxes. Trees that are intersected must have the same origin.
    """

    def __init__(self, low: np.ndarray, high: np.ndarray, origin: np.ndarray) -> None:
        low, high = low - origin, high - origin
        self.order = np.argsort(_morton_codes(low + high), kind="stable")
        leaves = np.column_stack([low, -high])[self.order].astype(np.float32)
        leaves = np.nextafter(leaves, np.float32(-np.inf))  # enlarged, to allow for rounding
        levels = [leaves]
        while len(levels[-1]) > 1:
            levels.append(_pairwise(levels[-1]))
        self.levels = [np.ascontiguousarray(level.T) for level in reversed(levels)]

    def level(self, k: int) -> np.ndarray:
        """Low corners and negative high corners (6, n) of the boxes k levels below the root."""
        return self.levels[min(k, len(self.levels) - 1)]


def intersecting_pairs(
    one: BVH, filter: Filter, other: BVH | None = None, *, progress: Progress | None = None
) -> np.ndarray:
    """Pairs (k, 2) that `filter` returns of the overlapping boxes, by their rank in the order.

    Each pair of different boxes of a single tree is passed once. The result does not depend on
    the machine.
    """
    mirrored = other is None
    other = one if other is None else other
    depth = max(len(one.levels), len(other.levels)) - 1
    nodes, k = np.zeros((1, 2), dtype=np.intp), 0
    while k < depth and len(nodes) < _FRONTIER:
        k += 1
        nodes = np.column_stack(_below(one, other, k, nodes[:, 0], nodes[:, 1], mirrored))

    def work(some: np.ndarray) -> np.ndarray:
        found = [filter(i, j) for i, j in _leaves(one, other, k, some[:, 0], some[:, 1], mirrored)]
        return np.concatenate(found)

    parts = [part for _, part in chunked(work, nodes, _ROWS, progress=progress)]
    return np.concatenate(parts) if parts else np.empty((0, 2), dtype=np.intp)


def _leaves(
    one: BVH, other: BVH, k: int, i: np.ndarray, j: np.ndarray, mirrored: bool
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield pairs of leaves below pairs of nodes, at most _MAX_PAIRS at once."""
    depth = max(len(one.levels), len(other.levels)) - 1
    waiting = [(k, i, j)]
    while waiting:
        k, i, j = waiting.pop()
        if 4 * len(i) > _MAX_PAIRS and len(i) > 1 and k < depth:
            half = len(i) // 2
            waiting += [(k, i[half:], j[half:]), (k, i[:half], j[:half])]
        elif k < depth:
            waiting.append((k + 1, *_below(one, other, k + 1, i, j, mirrored)))
        else:
            different = i != j if mirrored else slice(None)
            yield i[different], j[different]


def _below(
    one: BVH, other: BVH, k: int, i: np.ndarray, j: np.ndarray, mirrored: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Overlapping pairs on level k of the children of nodes i and j."""
    first = _children(one, k, i)
    second = _children(other, k, j)
    pairs = [(a, b) for a in first for b in second]
    if mirrored:  # the children of a node with itself form three pairs, not four
        (a, b), different = pairs[2], i != j
        pairs[2] = a[different], b[different]
    i, j = (np.concatenate(side) for side in zip(*pairs, strict=True))
    a, b = one.level(k), other.level(k)
    held = (i < a.shape[1]) & (j < b.shape[1])
    i, j = i[held], j[held]
    for axis in range(3):
        meet = a[axis][i] + b[axis + 3][j] <= 0
        meet &= a[axis + 3][i] + b[axis][j] <= 0
        i, j = i[meet], j[meet]
    return i, j


def _children(tree: BVH, k: int, node: np.ndarray) -> list[np.ndarray]:
    """Children on level k of each node; the node itself if the tree is not that deep."""
    return [2 * node, 2 * node + 1] if k < len(tree.levels) else [node]


def _pairwise(boxes: np.ndarray) -> np.ndarray:
    """The boxes around two neighbours each."""
    if len(boxes) % 2:
        boxes = np.concatenate([boxes, np.full((1, 6), np.inf, dtype=boxes.dtype)])
    return np.minimum(boxes[::2], boxes[1::2])


def _morton_codes(points: np.ndarray) -> np.ndarray:
    """Morton codes: the bits of the three coordinates interleaved."""
    start, size = points.min(axis=0), np.ptp(points, axis=0)
    steps = (points - start) * ((2**21 - 1) / np.where(size > 0, size, 1.0))
    x, y, z = (_interleaved(steps[:, axis]) << np.uint64(axis) for axis in range(3))
    return x | y | z


def _interleaved(steps: np.ndarray) -> np.ndarray:
    """The bits of integers below 2²¹, with two zeros after each bit."""
    x = steps.astype(np.uint64)
    for shift, mask in (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        x = (x | (x << np.uint64(shift))) & np.uint64(mask)
    return x
