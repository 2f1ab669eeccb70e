"""The steps of a repair: each changes triangles, and points where it must, and counts what it did.

Points are never moved and never renumbered; new ones follow the old.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fieldrecon._contacts import contacts
from fieldrecon._copies import first_alike, three_corners
from fieldrecon._holes import LONGEST, patches
from fieldrecon._orientation import inside_out, turned
from fieldrecon._predicates import collinear
from fieldrecon._sheets import Sheets
from fieldrecon._triangle_pairs import close_pairs

_ROUNDS = 64  # each halves the edges that still have vertices inside


def without_copies(t: np.ndarray, n: int) -> np.ndarray:
    """The triangles that are the first with their vertices."""
    return t[first_alike(t, n) == np.arange(len(t))]


def without_flat(p: np.ndarray, t: np.ndarray, tolerance: float) -> np.ndarray:
    """The triangles that have an area."""
    t = t[three_corners(t)]
    return t[~collinear(*(p[t[:, c]] for c in range(3)), tolerance=tolerance)]


def sewn(p: np.ndarray, t: np.ndarray, tolerance: float) -> np.ndarray:
    """The triangles, those with a free edge split where a vertex of the boundary lies inside it."""
    for _ in range(_ROUNDS):
        side, vertex = _inside_free_edges(p, t, tolerance)
        if len(side) == 0:
            break
        triangle, k = np.divmod(side, 3)
        corner = np.column_stack([triangle] * 3), np.column_stack([k, (k + 1) % 3, (k + 2) % 3])
        a, b, c = t[corner].T
        t = t.copy()
        t[corner] = np.column_stack([a, vertex, c])
        t = np.concatenate([t, np.column_stack([vertex, b, c])])
    return t


def _inside_free_edges(
    p: np.ndarray, t: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """At most one free side of each triangle, and the vertex that lies nearest to its middle."""
    sheets = Sheets(t, len(p))
    free = sheets.free_sides
    ends = np.sort(np.column_stack([sheets.start[free], sheets.end[free]]), axis=1)
    rim = np.zeros(len(p), dtype=bool)
    rim[ends] = True
    near = t[rim[t].any(axis=1)]
    if len(near) == 0:
        return free[:0], free[:0]
    found = contacts(p, near, close_pairs(p, near, tolerance), tolerance).corners_on_edges
    found = found[rim[found[:, 0]]]
    n = len(p)
    order = np.argsort(ends[:, 0] * n + ends[:, 1])
    key, wanted = (ends[:, 0] * n + ends[:, 1])[order], found[:, 1] * n + found[:, 2]
    place = np.minimum(np.searchsorted(key, wanted), len(key) - 1)
    on_free = key[place] == wanted
    side, vertex = free[order[place[on_free]]], found[on_free, 0]
    off = np.abs(2 * p[vertex] - p[sheets.start[side]] - p[sheets.end[side]]).max(axis=1)
    best = np.lexsort((off, side // 3))
    _, first = np.unique(side[best] // 3, return_index=True)
    return side[best[first]], vertex[best[first]]


def parted(p: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles, a vertex with several fans of triangles made one for each."""
    sheets = Sheets(t, len(p))
    corner = np.flatnonzero(np.isin(sheets.start, sheets.bow_ties))
    fan, first = np.unique(sheets.fans[corner], return_index=True)
    vertex = sheets.start[corner[first]]
    order = np.lexsort((first, vertex))
    further = order[1:][vertex[order[1:]] == vertex[order[:-1]]]
    new = np.full(sheets.fans.max(initial=-1) + 1, -1)
    new[fan[further]] = len(p) + np.arange(len(further))
    moved = new[sheets.fans]
    split = np.where(moved >= 0, moved, sheets.start).reshape(-1, 3)
    return np.concatenate([p, p[vertex[further]]]), split


def oriented(p: np.ndarray, t: np.ndarray) -> np.ndarray:
    """The triangles, turned like most around them, and outward where they close a body."""
    sheets = Sheets(t, len(p))
    flipped, one_sided = turned(sheets)
    wrong = flipped ^ (inside_out(p, sheets, flipped) & ~one_sided)
    return np.where(wrong[:, None], t[:, [0, 2, 1]], t)


def hole_patches(p: np.ndarray, t: np.ndarray, largest: float) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (k, 3) over the small holes of oriented triangles, and which hole each is over.

    A hole is small if it has at most so many edges, and the patch at most the given share of the
    area of the part around it. No patch brings an edge that there already is.
    """
    sheets = Sheets(t, len(p))
    normal = np.cross(p[t[:, 1]] - p[t[:, 0]], p[t[:, 2]] - p[t[:, 0]])
    area = np.bincount(sheets.parts, np.sqrt(np.einsum("ki,ki->k", normal, normal)) / 2)
    known = _keys(sheets.edges, len(p))
    found, hole, count = [t[:0]], [t[:0, 0]], 0
    for sides in _rims_by_length(sheets):
        rim = sheets.start[sides]
        order, size = patches(p[rim])
        new = np.take_along_axis(rim, order.reshape(len(rim), -1), axis=1).reshape(order.shape)
        part = sheets.parts[sides[:, 0] // 3]
        fits = (size <= largest * area[part]) & ~_has_known_diagonals(order, new, known, len(p))
        found.append(new[fits][..., ::-1].reshape(-1, 3))
        hole.append(np.repeat(count + np.arange(fits.sum()), rim.shape[1] - 2))
        count += int(fits.sum())
    return np.concatenate(found), np.concatenate(hole)


def _rims_by_length(sheets: Sheets) -> Iterator[np.ndarray]:
    """Yield loops (l, k) of sides that follow one another, all those of one length at once."""
    by_length: dict[int, list[np.ndarray]] = {}
    for loop in sheets.loops:
        if len(loop) <= LONGEST:
            for sides in (loop, loop[::-1]):
                if (sheets.end[sides] == np.roll(sheets.start[sides], -1)).all():
                    by_length.setdefault(len(loop), []).append(sides)
    for _, loops in sorted(by_length.items()):
        yield np.array(loops)


def _has_known_diagonals(
    order: np.ndarray, new: np.ndarray, known: np.ndarray, n: int
) -> np.ndarray:
    """Whether a patch (l, k - 2, 3) has an edge inside that the mesh has already."""
    k = order.shape[1] + 2
    result = np.zeros(len(order), dtype=bool)
    for a, b in ((0, 1), (1, 2), (0, 2)):
        inside = ~np.isin(order[..., b] - order[..., a], (1, k - 1))
        ends = np.sort(np.stack([new[..., a], new[..., b]], axis=-1), axis=-1)
        result |= (inside & np.isin(_keys(ends, n), known)).any(axis=1)
    return result


def _keys(ends: np.ndarray, n: int) -> np.ndarray:
    return ends[..., 0] * n + ends[..., 1]
