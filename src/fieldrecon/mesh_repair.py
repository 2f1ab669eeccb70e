"""A mesh of triangles in space put right where that can be done without asking."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon import _mending as mending
from fieldrecon import _validation as valid
from fieldrecon._chunks import Progress
from fieldrecon._welding import welded
from fieldrecon.mesh_audit import MeshAudit, as_surface, audit_mesh, unit_of


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

    Vertices that `audit_mesh` calls duplicates are welded, in a soup all that are in one place.
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
    t = mending.without_copies(place[given], len(p))
    t = mending.without_flat(p, t, tolerance)
    if len(t) == 0:
        raise ValueError("triangles must not all be degenerate; none is left to repair")
    kept = len(t)
    t = mending.sewn(p, t, tolerance)
    p_new, t = mending.parted(p, t)
    oriented = mending.oriented(p_new, t)
    patches, hole = mending.hole_patches(p_new, oriented, largest_hole)
    result, after, put_in = _patched(p_new, oriented, patches, hole, tolerance, progress)
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
    """For each vertex the one it is welded to."""
    if before.soup:
        return welded(p, tolerance)
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
        whole = mending.oriented(p, np.concatenate([t, patches[put_in]]))
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
