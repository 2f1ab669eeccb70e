"""Repair of a mesh of triangles in space.

Each step changes triangles, and adds points where it must; points are never displaced or
renumbered. Small holes are filled by the triangulation of their boundary loop with the least area.

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
from fieldrecon._core.geometry import triangle_normals
from fieldrecon.triangles.audit import MeshAudit, as_surface, audit_mesh, unit_of
from fieldrecon.triangles.duplicates import first_duplicates, has_three_corners, merged_vertices
from fieldrecon.triangles.half_edges import HalfEdges
from fieldrecon.triangles.intersections import close_pairs, contacts
from fieldrecon.triangles.orientation import inconsistently_oriented, inverted
from fieldrecon.triangles.predicates import collinear


@dataclass(frozen=True, eq=False)
class MeshRepair:
    """A repaired mesh, the repairs, and the errors before and after.

    Attributes
    ----------
    points : (n, 3) ndarray
    triangles : (m, 3) ndarray of int
    before, after : MeshAudit
    done : dict of str to int
        Numbers of repairs, without zeros: merged vertices; removed degenerate and duplicate
        triangles; edges split at a vertex inside them; vertices split at bow-ties; reversed
        triangles; filled holes and the triangles that fill them; removed unreferenced vertices.
    """

    points: np.ndarray
    triangles: np.ndarray
    before: MeshAudit
    after: MeshAudit
    done: dict[str, int]


def repair_mesh(
    points: ArrayLike,
    triangles: ArrayLike,
    tol: float | None = None,
    largest_hole: float = 0.1,
    *,
    progress: Progress | None = None,
) -> MeshRepair:
    """Repair the errors of a mesh of triangles in space that have an unambiguous repair.

    Vertices that `audit_mesh` reports as duplicates are merged; in a soup, all that coincide.
    Degenerate and duplicate triangles are removed. Boundary edges are split where a boundary vertex
    lies inside them, and a bow-tie vertex is split into one vertex for each fan. Triangles are
    oriented like most of their patch, and closed parts outward. Small holes are filled, and
    unreferenced vertices removed.

    Parameters
    ----------
    points : (n, 3) array_like
    triangles : (m, 3) array_like of int
    tol : float, optional
        As for `audit_mesh`.
    largest_hole : float
        A hole is filled if its triangles have at most this share of the area of the part around it,
        and its boundary has at most 32 edges; with 0 none is filled.
    progress : callable, optional
        Called as progress(done, total), in the audits before and after.

    Returns
    -------
    MeshRepair
        No point is displaced; points and triangles are in the given order, and new ones follow. A
        mesh without errors is returned unchanged.

    Raises
    ------
    ValueError
        As for `audit_mesh`, and if all triangles are degenerate.

    Notes
    -----
    Edges of three or more triangles, self-intersections and one-sided surfaces remain, since the
    mesh does not determine their repair; `after` lists them. A hole is not filled if its triangles
    would cross others.

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
    before = audit_mesh(points, given, tol, progress=progress)
    if before.clean and not before.soup:
        return MeshRepair(p.copy(), given, before, before, {})
    unit = unit_of(p)
    p, tolerance = p / unit, before.tolerance / unit
    merged = _merge_targets(before, p, tolerance)
    t = without_duplicates(merged[given], len(p))
    t = without_flat(p, t, tolerance)
    if len(t) == 0:
        raise ValueError("triangles must not all be degenerate; none is left to repair")
    kept = len(t)
    t = split_free_edges(p, t, tolerance)
    p_new, t = split_bow_ties(p, t)
    faces = oriented(p_new, t)
    patches, hole = hole_patches(p_new, faces, largest_hole)
    result, after, used = _patched(p_new, faces, patches, hole, tolerance, progress)
    done = {
        "welded_vertices": int((merged != np.arange(len(p))).sum()),
        "removed_triangles": len(given) - kept,
        "split_edges": len(t) - kept,
        "split_vertices": len(p_new) - len(p),
        "turned_triangles": _count_reversed(t, result[1]),
        "filled_holes": len(np.unique(hole[used])),
        "filling_triangles": int(used.sum()),
        "removed_vertices": int((np.bincount(merged, minlength=len(p)) > 0).sum())
        + len(p_new)
        - len(p)
        - len(result[0]),
    }
    after = replace(after, tolerance=before.tolerance)
    done = {what: n for what, n in done.items() if n}
    return MeshRepair(result[0] * unit, result[1], before, after, done)


def _merge_targets(before: MeshAudit, p: np.ndarray, tolerance: float) -> np.ndarray:
    """Return for each vertex the one it is merged with."""
    if before.soup:
        return merged_vertices(p, tolerance)
    merged = np.arange(len(p))
    merged[before.duplicate_vertices[:, 0]] = before.duplicate_vertices[:, 1]
    return merged


def _patched(
    p: np.ndarray,
    t: np.ndarray,
    patches: np.ndarray,
    hole: np.ndarray,
    tolerance: float,
    progress: Progress | None,
) -> tuple[tuple[np.ndarray, np.ndarray], MeshAudit, np.ndarray]:
    """Add the patches that cross nothing; return the mesh, its audit and a mask of them."""
    used = np.ones(len(patches), dtype=bool)
    while True:
        whole = oriented(p, np.concatenate([t, patches[used]]))
        mesh = _without_unused(p, whole)
        after = audit_mesh(*mesh, tolerance, progress=progress)
        crossed = np.unique(np.concatenate([after.crossings.ravel(), after.overlaps.ravel()]))
        wrong = np.flatnonzero(used)[crossed[crossed >= len(t)] - len(t)]
        if len(wrong) == 0:
            return mesh, after, used
        used &= ~np.isin(hole, hole[wrong])


def _without_unused(p: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    used = np.zeros(len(p), dtype=bool)
    used[t] = True
    return p[used], (np.cumsum(used) - 1)[t]


def _count_reversed(before: np.ndarray, after: np.ndarray) -> int:
    """Number of reversed triangles; their vertices may be renumbered in the same order."""
    same = np.argsort(np.argsort(before, axis=1), axis=1)
    now = np.argsort(np.argsort(after[: len(before)], axis=1), axis=1)
    return int((same != now).any(axis=1).sum())


_ROUNDS = 64  # each halves the edges that still have vertices inside


def without_duplicates(t: np.ndarray, n: int) -> np.ndarray:
    """Remove all but the first of the triangles with the same vertices."""
    return t[first_duplicates(t, n) == np.arange(len(t))]


def without_flat(p: np.ndarray, t: np.ndarray, tolerance: float) -> np.ndarray:
    """Remove the triangles without area."""
    t = t[has_three_corners(t)]
    return t[~collinear(*(p[t[:, c]] for c in range(3)), tolerance=tolerance)]


def split_free_edges(p: np.ndarray, t: np.ndarray, tolerance: float) -> np.ndarray:
    """Split triangles at boundary vertices that lie inside their boundary edges."""
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
    """Return at most one boundary side of each triangle, and the vertex nearest to its midpoint."""
    half_edges = HalfEdges(t, len(p))
    free = half_edges.free_sides
    ends = np.sort(np.column_stack([half_edges.start[free], half_edges.end[free]]), axis=1)
    loop = np.zeros(len(p), dtype=bool)
    loop[ends] = True
    near = t[loop[t].any(axis=1)]
    if len(near) == 0:
        return free[:0], free[:0]
    found = contacts(p, near, close_pairs(p, near, tolerance), tolerance).corners_on_edges
    found = found[loop[found[:, 0]]]
    n = len(p)
    order = np.argsort(ends[:, 0] * n + ends[:, 1])
    key, wanted = (ends[:, 0] * n + ends[:, 1])[order], found[:, 1] * n + found[:, 2]
    position = np.minimum(np.searchsorted(key, wanted), len(key) - 1)
    on_free = key[position] == wanted
    side, vertex = free[order[position[on_free]]], found[on_free, 0]
    off = np.abs(2 * p[vertex] - p[half_edges.start[side]] - p[half_edges.end[side]]).max(axis=1)
    best = np.lexsort((off, side // 3))
    _, first = np.unique(side[best] // 3, return_index=True)
    return side[best[first]], vertex[best[first]]


def split_bow_ties(p: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Split each vertex with several fans of triangles into one vertex for each fan."""
    half_edges = HalfEdges(t, len(p))
    corner = np.flatnonzero(np.isin(half_edges.start, half_edges.bow_ties))
    fan, first = np.unique(half_edges.fans[corner], return_index=True)
    vertex = half_edges.start[corner[first]]
    order = np.lexsort((first, vertex))
    further = order[1:][vertex[order[1:]] == vertex[order[:-1]]]
    new = np.full(half_edges.fans.max(initial=-1) + 1, -1)
    new[fan[further]] = len(p) + np.arange(len(further))
    vertex_of = new[half_edges.fans]
    split = np.where(vertex_of >= 0, vertex_of, half_edges.start).reshape(-1, 3)
    return np.concatenate([p, p[vertex[further]]]), split


def oriented(p: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Orient the triangles like most of their patch, and closed parts outward."""
    half_edges = HalfEdges(t, len(p))
    flipped, one_sided = inconsistently_oriented(half_edges)
    wrong = flipped ^ (inverted(p, half_edges, flipped) & ~one_sided)
    return np.where(wrong[:, None], t[:, [0, 2, 1]], t)


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
    for sides in _loops_by_length(half_edges):
        loop = half_edges.start[sides]
        order, size = minimum_area_patches(p[loop])
        new = np.take_along_axis(loop, order.reshape(len(loop), -1), axis=1).reshape(order.shape)
        part = half_edges.parts[sides[:, 0] // 3]
        fits = (size <= largest * area[part]) & ~_has_known_diagonals(order, new, known, len(p))
        found.append(new[fits][..., ::-1].reshape(-1, 3))
        hole.append(np.repeat(count + np.arange(fits.sum()), loop.shape[1] - 2))
        count += int(fits.sum())
    return np.concatenate(found), np.concatenate(hole)


def _loops_by_length(half_edges: HalfEdges) -> Iterator[np.ndarray]:
    """Yield the loops (l, k) of k successive sides together, for each length k."""
    by_length: dict[int, list[np.ndarray]] = {}
    for loop in half_edges.loop_sides:
        if len(loop) <= MAX_LOOP:
            for sides in (loop, loop[::-1]):
                if (half_edges.end[sides] == np.roll(half_edges.start[sides], -1)).all():
                    by_length.setdefault(len(loop), []).append(sides)
    for _, loops in sorted(by_length.items()):
        yield np.array(loops)


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


MAX_LOOP = 32
"""Largest number of edges of a loop that is filled; the cost grows with its third power."""


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
