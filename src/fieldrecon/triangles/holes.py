"""Patches for small holes: the triangulation of a boundary loop with the least area.

References
----------
Barequet and Sharir, Filling Gaps in the Boundary of a Polyhedron (1995).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from operator import itemgetter

import numpy as np

from fieldrecon._core.geometry import triangle_normals
from fieldrecon.triangles.half_edges import HalfEdges, component_labels, next_sides

MAX_LOOP = 32
"""Largest number of edges of a loop that is filled; the cost grows with its third power."""

MAX_CYCLES = 256
"""Largest number of paths that are followed from each side at which holes touch."""


def hole_patches(p: np.ndarray, t: np.ndarray, largest: float) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (k, 3) that fill the small holes of oriented triangles, and the hole of each.

    A hole is small if its boundary has at most MAX_LOOP edges, and its patch at most the given
    share of the area of the part around it. A patch must not have an edge inside that exists.
    """
    half_edges = HalfEdges(t, len(p))
    normal = triangle_normals(*p[t.T])
    area = np.bincount(half_edges.parts, np.sqrt(np.einsum("ki,ki->k", normal, normal)) / 2)
    known = _keys(half_edges.edges, len(p))
    found, hole, count = [t[:0]], [t[:0, 0]], 0
    for sides in _loops_by_length(p, half_edges):
        loop = half_edges.start[sides]
        order, size = minimum_area_patches(p[loop])
        new = np.take_along_axis(loop, order.reshape(len(loop), -1), axis=1).reshape(order.shape)
        around = area[half_edges.parts[sides // 3]].max(axis=1)
        fits = (size <= largest * around) & ~_has_known_diagonals(order, new, known, len(p))
        found.append(new[fits][..., ::-1].reshape(-1, 3))
        hole.append(np.repeat(count + np.arange(fits.sum()), loop.shape[1] - 2))
        count += int(fits.sum())
    return np.concatenate(found), np.concatenate(hole)


def _loops_by_length(p: np.ndarray, half_edges: HalfEdges) -> Iterator[np.ndarray]:
    """Yield the simple loops (l, k) of k successive sides together, for each length k."""
    by_length: dict[int, list[np.ndarray]] = {}
    for loop in simple_loops(p, half_edges):
        if len(loop) <= MAX_LOOP:
            by_length.setdefault(len(loop), []).append(loop)
    for _, loops in sorted(by_length.items()):
        yield np.array(loops)


def simple_loops(p: np.ndarray, half_edges: HalfEdges) -> Iterator[np.ndarray]:
    """Yield successive sides around each hole; around one hole at a time where several touch."""
    start, end = half_edges.start, half_edges.end
    closed = []
    for loop in half_edges.loop_sides:
        for sides in (loop, loop[::-1]):
            if (end[sides] == np.roll(start[sides], -1)).all():
                closed.append(sides)
    if not closed:
        return
    which = np.repeat(np.arange(len(closed)), [len(sides) for sides in closed])
    vertex = start[np.concatenate(closed)]
    joint = np.bincount(vertex, minlength=half_edges.n) > 1
    touching = np.unique(which[joint[vertex]])
    for k in np.setdiff1d(np.arange(len(closed)), touching):
        yield closed[k]
    if len(touching):
        sides = np.concatenate([closed[k] for k in touching])
        links = np.column_stack([start[sides], end[sides]])
        group = component_labels(half_edges.n, links)[start[sides]]
        for g in np.unique(group):
            yield from _least_cycles(p, half_edges, sides[group == g], joint)


def _least_cycles(
    p: np.ndarray, half_edges: HalfEdges, sides: np.ndarray, joint: np.ndarray
) -> Iterator[np.ndarray]:
    """Yield disjoint simple cycles of boundary sides.

    Where holes touch, the two sides of a hole are in different fans; those in one fan go around the
    piece between two holes. So cycles with few of the latter are first, then those of least area.
    """
    paths = _paths(half_edges, sides, joint)
    cycles = []
    for cycle in _cycles(half_edges, paths):
        loop = np.concatenate([paths[k] for k in cycle])
        fan_before = half_edges.fans[next_sides(np.roll(loop, 1))]
        turns = int((joint[half_edges.start[loop]] & (fan_before == half_edges.fans[loop])).sum())
        area = minimum_area_patches(p[half_edges.start[loop]][None])[1]
        cycles.append(((turns, float(area[0])), cycle, loop))
    used: set[int] = set()
    for _, cycle, loop in sorted(cycles, key=itemgetter(0)):
        if used.isdisjoint(cycle):
            used.update(cycle)
            yield loop


def _paths(half_edges: HalfEdges, sides: np.ndarray, joint: np.ndarray) -> list[np.ndarray]:
    """Split successive sides into paths from one joint of holes to the next."""
    after = dict(zip(half_edges.start[sides].tolist(), sides.tolist(), strict=True))
    paths = []
    for side in sides[joint[half_edges.start[sides]]].tolist():
        path = [side]
        while not joint[half_edges.end[path[-1]]]:
            path.append(after[int(half_edges.end[path[-1]])])
        paths.append(np.array(path))
    return paths


def _cycles(half_edges: HalfEdges, paths: list[np.ndarray]) -> Iterator[tuple[int, ...]]:
    """Yield short simple cycles of paths, each once, from its first path."""
    start = [int(half_edges.start[path[0]]) for path in paths]
    end = [int(half_edges.end[path[-1]]) for path in paths]
    for first in range(len(paths)):
        waiting: deque[tuple[int, ...]] = deque([(first,)])
        for _ in range(MAX_CYCLES):
            if not waiting:
                break
            cycle = waiting.popleft()
            here = end[cycle[-1]]
            if sum(len(paths[k]) for k in cycle) > MAX_LOOP:
                continue
            if here == start[first]:
                yield cycle
            elif here not in {start[k] for k in cycle}:
                further = (k for k in range(first + 1, len(paths)) if start[k] == here)
                waiting.extend((*cycle, k) for k in further)


def _has_known_diagonals(
    order: np.ndarray, new: np.ndarray, known: np.ndarray, n: int
) -> np.ndarray:
    """Whether a patch (l, k - 2, 3) has an interior edge that is already in the mesh."""
    k = order.shape[1] + 2
    result = np.zeros(len(order), dtype=bool)
    for a, b in ((0, 1), (1, 2), (0, 2)):
        inside = ~np.isin(order[..., b] - order[..., a], (1, k - 1))
        ends = np.sort(np.stack([new[..., a], new[..., b]], axis=-1), axis=-1)
        result |= (inside & np.isin(_keys(ends, n), known)).any(axis=1)
    return result


def _keys(ends: np.ndarray, n: int) -> np.ndarray:
    return ends[..., 0] * n + ends[..., 1]


def minimum_area_patches(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangulations of least area of many loops (l, k, 3) of equal length.

    Returns
    -------
    triangles : (l, k - 2, 3) ndarray of int
        Indices of corners in the loop, in its direction.
    areas : (l,) ndarray
    """
    loops, k = corners.shape[:2]
    least = np.zeros((loops, k, k))
    choice = np.zeros((loops, k, k), dtype=np.intp)
    for span in range(2, k):
        for i in range(k - span):
            j, between = i + span, np.arange(i + 1, i + span)
            area = _areas(corners[:, i, None], corners[:, between], corners[:, j, None])
            total = area + least[:, i, between] + least[:, between, j]
            best = total.argmin(axis=1)
            choice[:, i, j] = between[best]
            least[:, i, j] = np.take_along_axis(total, best[:, None], axis=1)[:, 0]
    return _chosen(choice), least[:, 0, k - 1]


def _chosen(choice: np.ndarray) -> np.ndarray:
    """Follow the choices (l, k, k): the triangle over a span, then those over its two halves."""
    loops, k = choice.shape[:2]
    triangles = np.empty((loops, k - 2, 3), dtype=np.intp)
    row = np.arange(loops)
    spans = np.tile([0, k - 1], (loops, k, 1))
    waiting = np.ones(loops, dtype=np.intp)  # spans of each loop without a triangle
    for t in range(k - 2):
        waiting -= 1
        i, j = spans[row, waiting].T
        middle = choice[row, i, j]
        triangles[:, t] = np.column_stack([i, middle, j])
        for a, b in ((i, middle), (middle, j)):
            spans[row, waiting] = np.column_stack([a, b])
            waiting += b - a > 1
    return triangles


def _areas(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    normal = triangle_normals(a, b, c)
    return np.sqrt(np.einsum("...i,...i->...", normal, normal)) / 2
