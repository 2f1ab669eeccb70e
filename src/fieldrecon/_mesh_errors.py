"""The errors of a mesh: those of its connection, and those of where its vertices are."""

from __future__ import annotations

from typing import Any

import numpy as np

from fieldrecon._chunks import Progress
from fieldrecon._contacts import contacts
from fieldrecon._copies import coincident, first_alike, rows_in, three_corners
from fieldrecon._orientation import inside_out, turned
from fieldrecon._predicates import collinear
from fieldrecon._sheets import Sheets
from fieldrecon._triangle_pairs import close_pairs


def connection_errors(p: np.ndarray, t: np.ndarray, place: np.ndarray) -> dict[str, Any]:
    """Errors of triangles t (m, 3) on points p (n, 3), each of which is at place (n,)."""
    real = np.flatnonzero(three_corners(t))
    first = first_alike(t[real], len(p))
    once = first == np.arange(len(real))
    kept = real[once]
    sheets = Sheets(t[kept], len(p))
    flipped, one_sided = turned(sheets)
    inner = inside_out(p, sheets, flipped) & ~one_sided
    either_way = np.isin(np.flatnonzero(once), first[~once])  # its copy may be the right one
    used = np.zeros(len(p), dtype=bool)
    used[t] = True
    return {
        "parts": int(sheets.parts.max(initial=-1)) + 1,
        "nonmanifold_edges": sheets.crowded_edges,
        "bow_tie_vertices": sheets.bow_ties,
        "boundary_loops": sheets.rims,
        "flipped_triangles": kept[flipped & ~either_way],
        "one_sided_triangles": kept[one_sided],
        "inside_out_triangles": kept[inner],
        **coincident(sheets, place, np.flatnonzero(used)),
    }


def geometric_errors(
    p: np.ndarray, t: np.ndarray, tolerance: float = 0.0, progress: Progress | None = None
) -> dict[str, Any]:
    """Errors of triangles t (m, 3) whose different vertices are in different places p (n, 3)."""
    three = three_corners(t)
    flat = ~three
    flat[three] = collinear(*(p[t[three, c]] for c in range(3)), tolerance=tolerance)
    real = np.flatnonzero(three)
    first = first_alike(t[real], len(p))
    copies = first != np.arange(len(real))
    solid = real[~copies & ~flat[real]]
    pairs = np.empty((0, 2), dtype=np.intp)
    if len(solid):
        pairs = solid[close_pairs(p, t[solid], tolerance, progress)]
    meet = contacts(p, t, pairs, tolerance)
    corners = np.sort(meet.corners_on_edges, axis=1)
    sewn = rows_in(corners, np.sort(t[flat & three], axis=1))  # by a triangle without area
    return {
        "duplicate_triangles": np.column_stack([real[copies], real[first[copies]]]),
        "degenerate_triangles": np.flatnonzero(flat),
        "crossings": pairs[meet.crossing],
        "overlaps": pairs[meet.overlapping],
        "t_junctions": meet.corners_on_edges[~sewn],
    }
