"""A mesh of triangles in space put right where that can be done without asking.

The steps of a repair: each changes triangles, and points where it must, and counts what it did.

Points are never moved and never renumbered; new ones follow the old.

Patches over small holes: of all triangulations of a loop the one of least area.

References
----------
Barequet and Sharir, Filling Gaps in the Boundary of a Polyhedron (1995).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress
from fieldrecon.triangles.audit import MeshAudit, as_surface, audit_mesh, unit_of
from fieldrecon.triangles.duplicates import first_alike, merged_vertices, three_corners
from fieldrecon.triangles.half_edges import Sheets
from fieldrecon.triangles.intersections import close_pairs, contacts
from fieldrecon.triangles.orientation import inside_out, turned
from fieldrecon.triangles.predicates import collinear


@dataclass(frozen=True, eq=False)
class MeshRepair:
    """A mesh after its repair, what was done, and what was found before and after.

    Attributes
    ----------
    points : (n, 3) ndarray
    triangles : (m, 3) ndarray of int
    before, after : MeshAudit
    done : dict of str to int
        Welded vertices; removed triangles, without area or repeated; edges split where a vertex lay
        inside them; vertices split at bow-ties; turned triangles; filled holes and the triangles
        that fill them; removed vertices, which no triangle had. Zeros are left out.
    """

    points: np.ndarray
    triangles: np.ndarray
    before: MeshAudit
    after: MeshAudit
    done: dict[str, int]


def repair_mesh(
    points: ArrayLike,
    triangles: ArrayLike,
    tolerance: float | None = None,
    largest_hole: float = 0.1,
    progress: Progress | None = None,
) -> MeshRepair:
    """Repair what is wrong with a mesh of triangles in space, and leave alone what is right.

    Vertices that `audit_mesh` calls duplicates are merged, in a soup all that coincide.
    Triangles that have no area or repeat others are removed. Free edges are split where a vertex
    of the boundary lies inside them, and bow-ties are made into one vertex for each sheet.
    Triangles are turned like most around them, and bodies outward; small holes are filled; vertices
    that no triangle has are removed.

    Parameters
    ----------
    points : (n, 3) array_like
    triangles : (m, 3) array_like of int
    tolerance : float, optional
        As for `audit_mesh`.
    largest_hole : float
        A hole is filled if its patch has at most this share of the area of the part around it, and
        its rim at most 32 edges; with 0 none is.
    progress : callable, optional
        Called with what is done and the total, in the audit before and in that after.

    Returns
    -------
    MeshRepair
        No point has moved; points and triangles are in the given order, new ones follow. A mesh in
        which nothing is found comes back as it is.

    Raises
    ------
    ValueError
        As for `audit_mesh`, and if no triangle is left.

    Notes
    -----
    Edges of three triangles or more, self-intersections, and surfaces with one side remain, since
    it is not the mesh that tells what was meant; `after` lists them. A patch that would cross
    something is not put in.

    References
    ----------
    Attene, Campen and Kobbelt, Polygon Mesh Repairing: An Application Perspective (2013);
    Guéziec, Taubin, Lazarus and Horn, Cutting and Stitching: Converting Sets of Polygons to
    Manifold Surfaces (2001); Barequet and Sharir, Filling Gaps in the Boundary of a Polyhedron
    (1995).

    Examples
    --------
    >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> faces = [[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 3, 2], [2, 3, 1], [3, 3, 0]]
    >>> repaired = repair_mesh(corners, faces)
    >>> repaired.done
    {'removed_triangles': 2, 'turned_triangles': 1}
    >>> repaired.triangles.tolist(), repaired.after.clean
    ([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], True)
    """
    p, given = as_surface(points, triangles)
    largest_hole = valid.as_length(largest_hole, "largest_hole", zero_allowed=True)
    before = audit_mesh(points, given, tolerance, progress)
    if before.clean and not before.soup:
        return MeshRepair(p.copy(), given, before, before, {})
    unit = unit_of(p)
    p, tolerance = p / unit, before.tolerance / unit
    place = _places(before, p, tolerance)
    t = without_copies(place[given], len(p))
    t = without_flat(p, t, tolerance)
    if len(t) == 0:
        raise ValueError("triangles must not all be degenerate; none is left to repair")
    kept = len(t)
    t = sewn(p, t, tolerance)
    p_new, t = parted(p, t)
    faces = oriented(p_new, t)
    patches, hole = hole_patches(p_new, faces, largest_hole)
    result, after, put_in = _patched(p_new, faces, patches, hole, tolerance, progress)
    done = {
        "welded_vertices": int((place != np.arange(len(p))).sum()),
        "removed_triangles": len(given) - kept,
        "split_edges": len(t) - kept,
        "split_vertices": len(p_new) - len(p),
        "turned_triangles": _turned(t, result[1]),
        "filled_holes": len(np.unique(hole[put_in])),
        "filling_triangles": int(put_in.sum()),
        "removed_vertices": int((np.bincount(place, minlength=len(p)) > 0).sum())
        + len(p_new)
        - len(p)
        - len(result[0]),
    }
    after = replace(after, tolerance=before.tolerance)
    done = {what: n for what, n in done.items() if n}
    return MeshRepair(result[0] * unit, result[1], before, after, done)


def _places(before: MeshAudit, p: np.ndarray, tolerance: float) -> np.ndarray:
    """For each vertex the one it is merged with."""
    if before.soup:
        return merged_vertices(p, tolerance)
    place = np.arange(len(p))
    place[before.duplicate_vertices[:, 0]] = before.duplicate_vertices[:, 1]
    return place


def _patched(
    p: np.ndarray,
    t: np.ndarray,
    patches: np.ndarray,
    hole: np.ndarray,
    tolerance: float,
    progress: Progress | None,
) -> tuple[tuple[np.ndarray, np.ndarray], MeshAudit, np.ndarray]:
    """The mesh with those patches that cross nothing, oriented, its audit, and which they are."""
    put_in = np.ones(len(patches), dtype=bool)
    while True:
        whole = oriented(p, np.concatenate([t, patches[put_in]]))
        mesh = _without_unused(p, whole)
        after = audit_mesh(*mesh, tolerance, progress)
        crossed = np.unique(np.concatenate([after.crossings.ravel(), after.overlaps.ravel()]))
        wrong = np.flatnonzero(put_in)[crossed[crossed >= len(t)] - len(t)]
        if len(wrong) == 0:
            return mesh, after, put_in
        put_in &= ~np.isin(hole, hole[wrong])


def _without_unused(p: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    used = np.zeros(len(p), dtype=bool)
    used[t] = True
    return p[used], (np.cumsum(used) - 1)[t]


def _turned(before: np.ndarray, after: np.ndarray) -> int:
    """How many of the first triangles, numbered anew in the same order, were turned."""
    same = np.argsort(np.argsort(before, axis=1), axis=1)
    now = np.argsort(np.argsort(after[: len(before)], axis=1), axis=1)
    return int((same != now).any(axis=1).sum())


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


LONGEST = 32
"""Edges of the longest loop that is filled; the work grows with the third power."""


def patches(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of least total area over many loops (l, k, 3) of equal length.

    Returns
    -------
    triangles : (l, k - 2, 3) ndarray of int
        By the places of the corners in the loop, in its direction round.
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
    """Follow the choices (l, k, k): the triangle over a span, then those over its two parts."""
    loops, k = choice.shape[:2]
    triangles = np.empty((loops, k - 2, 3), dtype=np.intp)
    row = np.arange(loops)
    spans = np.tile([0, k - 1], (loops, k, 1))
    waiting = np.ones(loops, dtype=np.intp)  # spans of each loop that still lack their triangle
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
    normal = np.cross(b - a, c - a)
    return np.sqrt(np.einsum("...i,...i->...", normal, normal)) / 2
