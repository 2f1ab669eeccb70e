"""Errors of a mesh of triangles in space, in its connectivity and in its geometry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress
from fieldrecon.triangles.duplicates import (
    coincident_vertices,
    first_duplicates,
    has_three_corners,
    merged_vertices,
    rows_in,
)
from fieldrecon.triangles.half_edges import HalfEdges
from fieldrecon.triangles.intersections import close_pairs, contacts
from fieldrecon.triangles.orientation import inconsistently_oriented, inverted
from fieldrecon.triangles.predicates import collinear

CONCERNS: dict[str, tuple[str, ...]] = {
    "representation": (
        "duplicate_vertices",
        "unreferenced_vertices",
        "duplicate_triangles",
        "degenerate_triangles",
    ),
    "manifoldness": ("nonmanifold_edges", "bow_tie_vertices"),
    "boundary": ("boundary_loops", "free_edge_pairs"),
    "orientation": ("flipped_triangles", "one_sided_triangles", "inside_out_triangles"),
    "embedding": ("crossings", "overlaps", "t_junctions", "touching_vertices"),
}
"""The findings of a `MeshAudit` by concern."""

ROUNDING = 4.0
"""The default tolerance in roundings of the largest coordinate."""


@dataclass(frozen=True, eq=False)
class MeshAudit:
    """The errors of a mesh, as indices of its vertices or triangles.

    Attributes
    ----------
    vertices, triangles, parts : int
        Their numbers; parts are connected by edges.
    tolerance : float
        The largest error of the coordinates, a length.
    soup : bool
        Whether each triangle has vertices of its own, as in STL files. This is a property of the
        format and not an error: equal vertices are merged for all the other findings, and a vertex
        is given by the first that coincides with it.
    duplicate_vertices : (k, 2) ndarray
        A vertex and an earlier one that coincides with it, whose merging joins coincident edges.
    unreferenced_vertices : (k,) ndarray
        Vertices of no triangle.
    duplicate_triangles : (k, 2) ndarray
        A triangle and the first with the same vertices, in any order.
    degenerate_triangles : (k,) ndarray
        Triangles without area: with equal or with collinear corners.
    nonmanifold_edges : (k, 2) ndarray
        Ends of the edges of more than two triangles; duplicate triangles do not count.
    bow_tie_vertices : (k,) ndarray
        Vertices whose triangles are connected at the vertex only.
    boundary_loops : tuple of ndarray
        Vertices around each hole or boundary, in order.
    free_edge_pairs : (k, 4) ndarray
        Ends of two boundary edges that coincide, whose vertices are not merged.
    flipped_triangles : (k,) ndarray
        Triangles oriented against most of their patch.
    one_sided_triangles : (k,) ndarray
        Triangles of parts that cannot be oriented, such as the Möbius band.
    inside_out_triangles : (k,) ndarray
        Triangles of closed parts whose normals point into the body.
    crossings, overlaps : (k, 2) ndarray
        Two triangles that share more than corners and edges, not coplanar or coplanar.
    t_junctions : (k, 3) ndarray
        A vertex inside an edge of a triangle of which it is not a corner, and the ends of the edge.
    touching_vertices : (k, 2) ndarray
        A vertex and an earlier one that coincides with it, where the surface only touches itself.

    References
    ----------
    Botsch, Pauly, Kobbelt, Alliez, Lévy, Bischoff and Rössl, Geometric Modeling Based on Polygonal
    Meshes (2007), section 3, for the kinds of errors.
    """

    vertices: int
    triangles: int
    parts: int
    tolerance: float
    soup: bool
    duplicate_vertices: np.ndarray
    unreferenced_vertices: np.ndarray
    duplicate_triangles: np.ndarray
    degenerate_triangles: np.ndarray
    nonmanifold_edges: np.ndarray
    bow_tie_vertices: np.ndarray
    boundary_loops: tuple[np.ndarray, ...]
    free_edge_pairs: np.ndarray
    flipped_triangles: np.ndarray
    one_sided_triangles: np.ndarray
    inside_out_triangles: np.ndarray
    crossings: np.ndarray
    overlaps: np.ndarray
    t_junctions: np.ndarray
    touching_vertices: np.ndarray

    @property
    def counts(self) -> dict[str, dict[str, int]]:
        """Number of errors of each kind, by concern."""
        return {
            concern: {kind: len(getattr(self, kind)) for kind in kinds}
            for concern, kinds in CONCERNS.items()
        }

    @property
    def found(self) -> dict[str, int]:
        """Number of errors of each kind that occurs."""
        return {kind: n for kinds in self.counts.values() for kind, n in kinds.items() if n}

    @property
    def clean(self) -> bool:
        """Whether there are no errors: a closed, oriented surface without self-intersections."""
        return not self.found

    def as_dict(self) -> dict[str, Any]:
        """The audit as lists and numbers, for JSON."""
        indices = {
            kind: [loop.tolist() for loop in value] if isinstance(value, tuple) else value.tolist()
            for kind in self.found
            for value in [getattr(self, kind)]
        }
        sizes = {name: getattr(self, name) for name in ("vertices", "triangles", "parts")}
        about = {"tolerance": self.tolerance, "soup": self.soup, "clean": self.clean}
        return {**sizes, **about, "counts": self.counts, "indices": indices}


def audit_mesh(
    points: ArrayLike,
    triangles: ArrayLike,
    tol: float | None = None,
    *,
    progress: Progress | None = None,
) -> MeshAudit:
    """Find the errors of a mesh of triangles in space.

    Parameters
    ----------
    points : (n, 3) array_like
        The vertices. Coordinates count as exact; one that is 10⁶⁰ times smaller than the largest
        counts as zero.
    triangles : (m, 3) array_like of int
        Vertices of each triangle.
    tol : float, optional
        The largest error of the coordinates, a length. Vertices no farther apart coincide; a vertex
        is on an edge, a triangle degenerate, or two triangles coplanar, if a displacement of the
        points by the tolerance could make it so. By default four roundings of the largest
        coordinate in the precision of `points`; with 0 every decision is exact.
    progress : callable, optional
        Called as progress(done, total) during the search for self-intersections.

    Raises
    ------
    ValueError
        If the points are not in space, or the triangles do not index them.

    Notes
    -----
    Consequences of an error are not reported again: of duplicate triangles only the first counts
    for edges and orientation, and triangles with equal corners do not count. Degenerate triangles
    do not cross. The decisions depend on the signs of determinants, which are computed again in
    integers where rounding could change them.

    References
    ----------
    Botsch et al., Geometric Modeling Based on Polygonal Meshes (2007), section 3; Shewchuk,
    Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates (1997).

    Examples
    --------
    >>> tetrahedron = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
    >>> audit_mesh(tetrahedron, faces).clean
    True
    >>> audit_mesh(tetrahedron, faces[:3]).found
    {'boundary_loops': 1}
    >>> audit_mesh(tetrahedron, [[0, 1, 2], *faces[1:]]).flipped_triangles
    array([0])
    """
    p, t = as_surface(points, triangles)
    if tol is None:
        tol = default_tolerance(points)
    tolerance = valid.as_length(tol, "tol", zero_allowed=True)
    unit = unit_of(p)
    p = np.where(np.abs(p / unit) > 2.0**-200, p / unit, 0.0)
    merged = merged_vertices(p, tolerance / unit)
    referenced = np.bincount(t.ravel(), minlength=len(p))
    soup = bool((referenced <= 1).all() and (merged[t] != t).any())
    return MeshAudit(
        vertices=len(p),
        triangles=len(t),
        tolerance=tolerance,
        soup=soup,
        unreferenced_vertices=np.flatnonzero(referenced == 0),
        **connection_errors(p, merged[t] if soup else t, merged),
        **geometric_errors(p, merged[t], tolerance / unit, progress=progress),
    )


def in_words(kind: str, n: int) -> str:
    """Return the number of errors of a kind in words.

    Examples
    --------
    >>> in_words("bow_tie_vertices", 1), in_words("t_junctions", 1200)
    ('1 bow-tie vertex', '1,200 T-junctions')
    """
    words = kind.replace("_", " ").replace("bow tie", "bow-tie").replace("t junction", "T-junction")
    if n == 1:
        words = words.replace("vertices", "vertex").removesuffix("s")
    return f"{n:,} {words}"


def as_surface(points: ArrayLike, triangles: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Validate points in space, and triangles that index them; there may be none."""
    p = valid.as_points(points, none_allowed=True)
    if p.shape[1] != 3:
        raise ValueError(f"points must have the shape (n, 3); got {p.shape}")
    triangles = valid.unmasked(triangles, "triangles")
    try:
        given = np.asarray(triangles)
    except ValueError:
        raise ValueError("triangles must have three vertices each; the rows differ") from None
    if given.dtype.kind not in "iu":
        raise ValueError(f"triangles must be integers; got the type {given.dtype}")
    if given.ndim != 2 or given.shape[1] != 3:
        raise ValueError(f"triangles must have the shape (m, 3); got {given.shape}")
    outside = (given < 0) | (given >= len(p))
    if outside.any():
        i, k = map(int, np.argwhere(outside)[0])
        raise ValueError(
            f"triangles must index {len(p)} points; triangles[{i}, {k}] is {given[i, k]}"
        )
    return p, given.astype(np.intp)


def default_tolerance(points: ArrayLike) -> float:
    """Four roundings of the largest coordinate, in the precision of the points."""
    given = np.asarray(points)
    precision = np.finfo(given.dtype if given.dtype.kind == "f" else float).eps
    return ROUNDING * float(precision) * float(np.abs(given.astype(float)).max(initial=0.0))


def unit_of(p: np.ndarray) -> float:
    """The power of two in which the largest coordinate is from 1 to 2."""
    return float(np.ldexp(1.0, int(np.frexp(np.abs(p).max(initial=0.0))[1]) - 1))


def connection_errors(p: np.ndarray, t: np.ndarray, merged: np.ndarray) -> dict[str, Any]:
    """Errors in the connectivity of triangles t (m, 3); merged[v] is the first duplicate of v."""
    real = np.flatnonzero(has_three_corners(t))
    first = first_duplicates(t[real], len(p))
    once = first == np.arange(len(real))
    kept = real[once]
    half_edges = HalfEdges(t[kept], len(p))
    flipped, one_sided = inconsistently_oriented(half_edges)
    inner = inverted(p, half_edges, flipped) & ~one_sided
    either_way = np.isin(np.flatnonzero(once), first[~once])  # its duplicate may be the right one
    used = np.zeros(len(p), dtype=bool)
    used[t] = True
    return {
        "parts": int(half_edges.parts.max(initial=-1)) + 1,
        "nonmanifold_edges": half_edges.nonmanifold_edges,
        "bow_tie_vertices": half_edges.bow_ties,
        "boundary_loops": half_edges.boundary_loops,
        "flipped_triangles": kept[flipped & ~either_way],
        "one_sided_triangles": kept[one_sided],
        "inside_out_triangles": kept[inner],
        **coincident_vertices(half_edges, merged, np.flatnonzero(used)),
    }


def geometric_errors(
    p: np.ndarray, t: np.ndarray, tolerance: float, *, progress: Progress | None = None
) -> dict[str, Any]:
    """Errors in the geometry of triangles t (m, 3) whose coincident vertices are merged."""
    three = has_three_corners(t)
    flat = ~three
    flat[three] = collinear(*(p[t[three, c]] for c in range(3)), tolerance=tolerance)
    real = np.flatnonzero(three)
    first = first_duplicates(t[real], len(p))
    duplicates = first != np.arange(len(real))
    solid = real[~duplicates & ~flat[real]]
    pairs = np.empty((0, 2), dtype=np.intp)
    if len(solid):
        pairs = solid[close_pairs(p, t[solid], tolerance, progress=progress)]
    meet = contacts(p, t, pairs, tolerance)
    corners = np.sort(meet.corners_on_edges, axis=1)
    closed = rows_in(corners, np.sort(t[flat & three], axis=1))  # by a degenerate triangle
    return {
        "duplicate_triangles": np.column_stack([real[duplicates], real[first[duplicates]]]),
        "degenerate_triangles": np.flatnonzero(flat),
        "crossings": pairs[meet.crossing],
        "overlaps": pairs[meet.overlapping],
        "t_junctions": meet.corners_on_edges[~closed],
    }
