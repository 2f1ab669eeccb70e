"""Which boxes overlap: pairs found by going down a balanced tree of boxes, level by level.

The boxes are sorted along a Morton curve, so that neighbours in the order are neighbours in space;
each box of a level holds two of the next. All pairs of a level are looked at at once.

References
----------
Morton, A Computer Oriented Geodetic Data Base (1966); Lauterbach, Garland, Sengupta, Luebke and
Manocha, Fast BVH Construction on GPUs (2009).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from fieldrecon._core.chunks import Progress, chunked

_FRONTIER = 2**12  # pairs of nodes from which on the work is shared out
_ROWS = 2**8  # of these in one chunk
_MOST = 2**20  # pairs looked at at once; bounds the memory where everything overlaps

Keep = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Takes numbers of leaves, i and j, and returns those pairs (k, 2) that are wanted."""


class BoxTree:
    """Boxes in the order of a Morton curve, and the boxes round two, four, eight ... of them.

    Parameters
    ----------
    low, high : (m, 3) ndarray
        Corners of each box.
    origin : (3,) ndarray
        Near the boxes. Trees that are compared have the same.
    """

    def __init__(self, low: np.ndarray, high: np.ndarray, origin: np.ndarray) -> None:
        low, high = low - origin, high - origin
        self.order = np.argsort(_morton(low + high), kind="stable")
        leaves = np.column_stack([low, -high])[self.order].astype(np.float32)
        leaves = np.nextafter(leaves, np.float32(-np.inf))  # outward, the rounding included
        levels = [leaves]
        while len(levels[-1]) > 1:
            levels.append(_pairwise(levels[-1]))
        self.levels = [np.ascontiguousarray(level.T) for level in reversed(levels)]

    def level(self, k: int) -> np.ndarray:
        """Low corners and negative high corners (6, n) of the boxes k steps below the root."""
        return self.levels[min(k, len(self.levels) - 1)]


def overlapping(
    one: BoxTree, keep: Keep, other: BoxTree | None = None, progress: Progress | None = None
) -> np.ndarray:
    """Pairs (k, 2) of boxes that overlap and that `keep` keeps, by their places in the order.

    Of one tree, each pair of different boxes once. The result does not depend on the machine.
    """
    mirrored = other is None
    other = one if other is None else other
    depth = max(len(one.levels), len(other.levels)) - 1
    nodes, k = np.zeros((1, 2), dtype=np.intp), 0
    while k < depth and len(nodes) < _FRONTIER:
        k += 1
        nodes = np.column_stack(_below(one, other, k, nodes[:, 0], nodes[:, 1], mirrored))

    def work(some: np.ndarray) -> np.ndarray:
        found = [keep(i, j) for i, j in _leaves(one, other, k, some[:, 0], some[:, 1], mirrored)]
        return np.concatenate(found) if found else np.empty((0, 2), dtype=np.intp)

    parts = [part for _, part in chunked(work, nodes, _ROWS, progress=progress)]
    return np.concatenate(parts) if parts else np.empty((0, 2), dtype=np.intp)


def _leaves(
    one: BoxTree, other: BoxTree, k: int, i: np.ndarray, j: np.ndarray, mirrored: bool
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield pairs of leaves below pairs of nodes, never too many at once."""
    depth = max(len(one.levels), len(other.levels)) - 1
    waiting = [(k, i, j)]
    while waiting:
        k, i, j = waiting.pop()
        if 4 * len(i) > _MOST and len(i) > 1 and k < depth:
            half = len(i) // 2
            waiting += [(k, i[half:], j[half:]), (k, i[:half], j[:half])]
        elif k < depth:
            waiting.append((k + 1, *_below(one, other, k + 1, i, j, mirrored)))
        else:
            different = i != j if mirrored else slice(None)
            yield i[different], j[different]


def _below(
    one: BoxTree, other: BoxTree, k: int, i: np.ndarray, j: np.ndarray, mirrored: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Overlapping pairs on level k of the children of nodes i and j."""
    first = _children(one, k, i)
    second = _children(other, k, j)
    pairs = [(a, b) for a in first for b in second]
    if mirrored:  # of a node with itself, its second child with the first is not another pair
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


def _children(tree: BoxTree, k: int, node: np.ndarray) -> list[np.ndarray]:
    """Nodes on level k below each; the same where the tree is no deeper."""
    return [2 * node, 2 * node + 1] if k < len(tree.levels) else [node]


def _pairwise(boxes: np.ndarray) -> np.ndarray:
    """The boxes round two neighbours each."""
    if len(boxes) % 2:
        boxes = np.concatenate([boxes, np.full((1, 6), np.inf, dtype=boxes.dtype)])
    return np.minimum(boxes[::2], boxes[1::2])


def _morton(places: np.ndarray) -> np.ndarray:
    """Numbers whose bits are those of three coordinates in turn."""
    start, size = places.min(axis=0), np.ptp(places, axis=0)
    steps = (places - start) * ((2**21 - 1) / np.where(size > 0, size, 1.0))
    x, y, z = (_spread(steps[:, axis]) << np.uint64(axis) for axis in range(3))
    return x | y | z


def _spread(steps: np.ndarray) -> np.ndarray:
    """Bits of whole numbers below 2²¹, with two zeros after each."""
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
