"""What is wrong with a mesh of triangles in space, and what of it concerns what.

The errors of a mesh: those of its connection, and those of where its vertices are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress
from fieldrecon.triangles.duplicates import (
    coincident,
    first_alike,
    merged_vertices,
    rows_in,
    three_corners,
)
from fieldrecon.triangles.half_edges import Sheets
from fieldrecon.triangles.intersections import close_pairs, contacts
from fieldrecon.triangles.orientation import inside_out, turned
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
"""Which findings of a `MeshAudit` concern what."""

ROUNDING = 4.0
"""The default tolerance in roundings of the largest coordinate."""


@dataclass(frozen=True, eq=False)
class MeshAudit:
    """Findings about a mesh, each as indices of its vertices or triangles.

    Attributes
    ----------
    vertices, triangles, parts : int
        How many there are; parts are connected by edges.
    tolerance : float
        By how much points may be off.
    soup : bool
        Whether each triangle has vertices of its own, as in STL files. That is the format, and no
        error: what follows is said of the surface with equal vertices merged, and a vertex is
        called by the first in its place.
    duplicate_vertices : (k, 2) ndarray
        A vertex, and an earlier one in its place; to weld them joins edges that are one to the eye.
    unreferenced_vertices : (k,) ndarray
        Those that no triangle has.
    duplicate_triangles : (k, 2) ndarray
        A triangle, and the first with its vertices, in whatever order.
    degenerate_triangles : (k,) ndarray
        Those without area: with equal corners, or all three on a line.
    nonmanifold_edges : (k, 2) ndarray
        Ends of the edges of more than two triangles, copies not counted.
    bow_tie_vertices : (k,) ndarray
        Those whose triangles hang together at the vertex only.
    boundary_loops : tuple of ndarray
        Vertices round each hole or rim, in order.
    free_edge_pairs : (k, 4) ndarray
        Ends of two edges of the boundary that are one to the eye: a seam that is not sewn.
    flipped_triangles : (k,) ndarray
        Those turned against most of their neighbourhood.
    one_sided_triangles : (k,) ndarray
        Those of parts, like the Möbius band, that no turning of triangles orients.
    inside_out_triangles : (k,) ndarray
        Those of closed parts whose normals point into the body.
    crossings, overlaps : (k, 2) ndarray
        Two triangles that share more than corners and edges, in two planes or in one.
    t_junctions : (k, 3) ndarray
        A vertex inside an edge of a triangle that does not have it, and the ends of that edge.
    touching_vertices : (k, 2) ndarray
        A vertex, and an earlier one in its place, of sheets that touch at that point only.

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
        """How many of each kind were found, by what they concern."""
        return {
            concern: {kind: len(getattr(self, kind)) for kind in kinds}
            for concern, kinds in CONCERNS.items()
        }

    @property
    def found(self) -> dict[str, int]:
        """How many of each kind were found, of those that were."""
        return {kind: n for kinds in self.counts.values() for kind, n in kinds.items() if n}

    @property
    def clean(self) -> bool:
        """Whether nothing was found: a closed, oriented surface without self-intersections."""
        return not self.found

    def as_dict(self) -> dict[str, Any]:
        """All of it in lists and numbers, as for JSON."""
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
    tolerance: float | None = None,
    progress: Progress | None = None,
) -> MeshAudit:
    """Look for all that is wrong with a mesh of triangles in space.

    Parameters
    ----------
    points : (n, 3) array_like
        The vertices. Coordinates are taken for exact; one that is 10⁶⁰ times smaller than the
        largest is taken for zero.
    triangles : (m, 3) array_like of int
        Vertices of each triangle.
    tolerance : float, optional
        By how much points may be off. Vertices so near to one another are one; a vertex is on an
        edge, a triangle flat, and two in one plane, if to move points so far could make it so. By
        default four roundings of the largest coordinate, in the precision of `points`; with 0
        every decision is exact.
    progress : callable, optional
        Called with what is done and the total while self-intersections are looked for.

    Raises
    ------
    ValueError
        If the points are not in space, or the triangles do not index them.

    Notes
    -----
    What one error brings along is not told twice: of triangles that repeat one another one counts
    for edges and orientation, and triangles with equal corners do not. Triangles without area
    cannot cross. The signs that decide are those of determinants, computed anew in integers where
    rounding could change them.

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
    if tolerance is None:
        tolerance = default_tolerance(points)
    tolerance = valid.as_length(tolerance, "tolerance", zero_allowed=True)
    unit = unit_of(p)
    p = np.where(np.abs(p / unit) > 2.0**-200, p / unit, 0.0)
    place = merged_vertices(p, tolerance / unit)
    referenced = np.bincount(t.ravel(), minlength=len(p))
    soup = bool((referenced <= 1).all() and (place[t] != t).any())
    return MeshAudit(
        vertices=len(p),
        triangles=len(t),
        tolerance=tolerance,
        soup=soup,
        unreferenced_vertices=np.flatnonzero(referenced == 0),
        **connection_errors(p, place[t] if soup else t, place),
        **geometric_errors(p, place[t], tolerance / unit, progress),
    )


def in_words(kind: str, n: int) -> str:
    """How many of a kind, as it is said.

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
    """Points in space, and triangles that index them."""
    p = valid.as_points(points)
    if p.shape[1] != 3:
        raise ValueError(f"points must have the shape (n, 3); got {p.shape}")
    try:
        given = np.asarray(triangles)
    except ValueError:
        raise ValueError("triangles must have three vertices each; the rows differ") from None
    if given.dtype.kind not in "iu":
        raise ValueError(f"triangles must be integers; got the type {given.dtype}")
    if given.ndim != 2 or given.shape[1] != 3 or len(given) == 0:
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
    return ROUNDING * float(precision) * float(np.abs(given.astype(float)).max())


def unit_of(p: np.ndarray) -> float:
    """The power of two in which the largest coordinate is from 1 to 2."""
    return float(np.ldexp(1.0, int(np.frexp(np.abs(p).max())[1]) - 1))


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
