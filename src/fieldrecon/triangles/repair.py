"""Repair of a mesh of triangles in space.

Each step changes triangles, and adds points where it must; points are never displaced or
renumbered. Small holes are filled by the triangulation of their boundary loop with the least area.

References
----------
Barequet and Sharir, Filling Gaps in the Boundary of a Polyhedron (1995).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress
from fieldrecon._core.geometry import triangle_normals
from fieldrecon.triangles.audit import MeshAudit, as_surface, audit_mesh, unit_of
from fieldrecon.triangles.duplicates import (
    first_duplicates,
    has_three_corners,
    merged_vertices,
    rows_in,
)
from fieldrecon.triangles.half_edges import HalfEdges, component_labels
from fieldrecon.triangles.holes import hole_patches
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
        triangles, those of fins included; fins; edges split at a vertex inside them; vertices split
        at bow-ties; reversed triangles; filled holes and the triangles that fill them; removed
        unreferenced vertices.
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
    Degenerate and duplicate triangles are removed, and fins: small sheets with a free edge, at
    edges that have two other triangles. Boundary edges are split where a boundary vertex
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
        and its boundary has at most 32 edges; with 0 none is filled. Fins have at most this share
        of the area of all triangles.
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
    Other edges of three or more triangles, self-intersections and one-sided surfaces remain, since
    the mesh does not determine their repair; `after` lists them. Holes that touch at vertices are
    filled one at a time, before bow-ties are split. A hole is not filled if the audit would find an
    error in its triangles. No repair adds a kind of error, but the vertices into which a bow-tie is
    split touch: a repair that would add one is left out, and so are those that build on it.

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
    {'removed_triangles': 2, 'reoriented_triangles': 1}
    >>> repaired.triangles.tolist(), repaired.after.clean
    ([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], True)
    """
    p, given = as_surface(points, triangles)
    largest_hole = valid.as_length(largest_hole, "largest_hole", zero_allowed=True)
    before = audit_mesh(points, given, tol, progress=progress)
    if before.clean and not before.soup:
        return MeshRepair(p.copy(), given, before, before, {})
    unit = unit_of(p)
    damaged = _Damaged(p / unit, given, before, before.tolerance / unit, largest_hole, progress)
    for stages, spare in ((STAGES, False), *((k, True) for k in range(STAGES, 0, -1))):
        repaired = damaged.repaired(stages, spare)
        if not added_kinds(before, repaired.after):
            after = replace(repaired.after, tolerance=before.tolerance)
            return replace(repaired, points=repaired.points * unit, after=after)
    return MeshRepair(p.copy(), given, before, before, {})


def added_kinds(before: MeshAudit, after: MeshAudit) -> set[str]:
    """Kinds of errors that only the second audit finds; the fans of a bow-tie may touch."""
    had = {*before.found, *(["touching_vertices"] if len(before.bow_tie_vertices) else [])}
    return {*after.found} - had


STAGES = 5
"""Stages of a repair: removal of duplicates and degenerate triangles, splitting of edges,
orientation, filling of holes, splitting of bow-ties."""


@dataclass(frozen=True)
class _Damaged:
    """A mesh with its errors, in a unit in which its largest coordinate is from 1 to 2."""

    points: np.ndarray
    triangles: np.ndarray
    before: MeshAudit
    tolerance: float
    largest_hole: float
    progress: Progress | None

    def repaired(self, stages: int, spare: bool) -> MeshRepair:
        """Return the mesh after the first stages.

        If `spare`, degenerate triangles at edges of three or more triangles are not removed.
        """
        p, n, tolerance = self.points, len(self.points), self.tolerance
        merged = merge_targets(self.triangles, self.before, p, tolerance)
        kept = without_duplicates(merged[self.triangles], n)
        kept = without_flat(p, kept, tolerance, spare)
        kept, fins = (kept, 0) if spare else without_fins(p, kept, self.largest_hole)
        if len(kept) == 0 and len(self.triangles):
            raise ValueError("triangles must not all be degenerate; none is left to repair")
        t = kept
        if stages > 1:
            t = without_duplicates(split_free_edges(p, kept, tolerance), n)
        faces = oriented(p, t) if stages > 2 else t
        patches, hole = t[:0], t[:0, 0]
        if stages > 3:
            patches, hole = hole_patches(p, faces, self.largest_hole)
        whole, after, used = self._patched(faces, patches, hole, stages)
        mesh, split = self._split(whole, stages)
        referenced = int((np.bincount(merged, minlength=n) > 0).sum())
        done = {
            "merged_vertices": int((merged != np.arange(n)).sum()),
            "removed_triangles": len(self.triangles) - len(kept),
            "removed_fins": fins,
            "split_edges": len(t) - len(kept),
            "split_vertices": split,
            "reoriented_triangles": int((whole[: len(t)] != t).any(axis=1).sum()),
            "filled_holes": len(np.unique(hole[used])),
            "filling_triangles": int(used.sum()),
            "removed_vertices": referenced + split - len(mesh[0]),
        }
        return MeshRepair(*mesh, self.before, after, {what: k for what, k in done.items() if k})

    def _patched(
        self, t: np.ndarray, patches: np.ndarray, hole: np.ndarray, stages: int
    ) -> tuple[np.ndarray, MeshAudit, np.ndarray]:
        """Add the patches in which the audit finds no error; the rest may be reversed.

        Returns
        -------
        whole : (k, 3) ndarray of int
        after : MeshAudit
        used : (l,) ndarray of bool
            Whether each patch was added.
        """
        used = np.ones(len(patches), dtype=bool)
        while True:
            whole = np.concatenate([t, patches[used]])
            if stages > 3:
                whole = oriented(self.points, whole)
            mesh, _ = self._split(whole, stages)
            after = audit_mesh(*mesh, self.tolerance, progress=self.progress)
            wrong = np.flatnonzero(used)[erroneous(after, mesh[1], len(t)) - len(t)]
            if len(wrong) == 0:
                return whole, after, used
            used &= ~np.isin(hole, hole[wrong])

    def _split(self, t: np.ndarray, stages: int) -> tuple[tuple[np.ndarray, np.ndarray], int]:
        """Split the bow-ties; return the mesh of the referenced vertices, and the number added."""
        p = self.points
        if stages > 4:
            p, t = split_bow_ties(p, t)
        return _without_unused(p, t), len(p) - len(self.points)


def erroneous(after: MeshAudit, t: np.ndarray, first: int) -> np.ndarray:
    """Triangles from the first one on in which the audit finds an error."""
    of_triangles = ("crossings", "overlaps", "duplicate_triangles", "degenerate_triangles")
    wrong = np.zeros(len(t), dtype=bool)
    for kind in of_triangles:
        wrong[getattr(after, kind)] = True
    new = t[first:]
    for ends in (after.nonmanifold_edges, after.t_junctions[:, 1:]):
        sides = np.sort(np.stack([new, np.roll(new, -1, axis=1)], axis=-1), axis=-1)
        on = rows_in(sides.reshape(-1, 2), np.sort(ends, axis=1)).reshape(-1, 3)
        wrong[first:] |= on.any(axis=1)
    wrong[first:] |= np.isin(new, after.duplicate_vertices).any(axis=1)
    return first + np.flatnonzero(wrong[first:])


def merge_targets(t: np.ndarray, before: MeshAudit, p: np.ndarray, tolerance: float) -> np.ndarray:
    """Return for each vertex the one it is merged with, unless an edge of three triangles forms."""
    if before.soup:
        return merged_vertices(p, tolerance)
    pairs, n = before.duplicate_vertices, len(p)
    while True:
        merged = np.arange(n)
        merged[pairs[:, 0]] = pairs[:, 1]
        joined = merged[t][has_three_corners(merged[t])]
        edges = HalfEdges(without_duplicates(joined, n), n).nonmanifold_edges
        had = np.sort(merged[before.nonmanifold_edges], axis=1)
        formed = edges[~rows_in(edges, had)]
        right = ~np.isin(pairs[:, 1], formed)
        if right.all():
            return merged
        pairs = pairs[right]


def _without_unused(p: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    used = np.zeros(len(p), dtype=bool)
    used[t] = True
    return p[used], (np.cumsum(used) - 1)[t]


_OTHERS = 2  # triangles at an edge of a closed surface
_ROUNDS = 64  # each halves the edges that still have vertices inside


def without_duplicates(t: np.ndarray, n: int) -> np.ndarray:
    """Remove all but the first of the triangles with the same vertices."""
    return t[first_duplicates(t, n) == np.arange(len(t))]


def without_flat(p: np.ndarray, t: np.ndarray, tolerance: float, spare: bool) -> np.ndarray:
    """Remove the triangles without area; or `spare` those at edges of three or more triangles."""
    t = t[has_three_corners(t)]
    flat = collinear(*(p[t[:, c]] for c in range(3)), tolerance=tolerance)
    if spare:
        sides = np.sort(np.stack([t, np.roll(t, -1, axis=1)], axis=-1), axis=-1).reshape(-1, 2)
        edges = HalfEdges(t, len(p)).nonmanifold_edges
        flat &= ~rows_in(sides, edges).reshape(-1, 3).any(axis=1)
    return t[~flat]


def without_fins(p: np.ndarray, t: np.ndarray, largest: float) -> tuple[np.ndarray, int]:
    """Remove the fins, at most a share of the area each; return the rest, and how many there were.

    Sheets are cut at the edges of three or more triangles. A fin is a small sheet with a free edge;
    at each of its cuts the sheets that are not such have two triangles.
    """
    half_edges = HalfEdges(t, len(p))
    cuts = half_edges.nonmanifold_edges
    if not len(cuts):
        return t, 0
    sheet = component_labels(len(t), half_edges.manifold_links // 3)
    count = sheet.max() + 1
    normal = triangle_normals(*p[t.T])
    area = np.bincount(sheet, np.linalg.norm(normal, axis=1))
    sides = np.sort(np.column_stack([half_edges.start, half_edges.end]), axis=1)
    at_cut = np.flatnonzero(rows_in(sides, cuts))
    fin = np.zeros(count, dtype=bool)
    fin[sheet[half_edges.free_sides // 3]] = True
    fin &= (area <= largest * area.sum()) & (np.bincount(sheet[at_cut // 3], minlength=count) > 0)
    _, cut = np.unique(sides[at_cut], axis=0, return_inverse=True)
    solid = ~fin[sheet[at_cut // 3]]
    others = np.bincount(cut.ravel()[solid], minlength=len(cuts))[cut.ravel()]
    fin[sheet[at_cut // 3][others != _OTHERS]] = False
    return t[~fin[sheet]], int(fin.sum())


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
        return free, free
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
