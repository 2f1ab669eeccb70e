"""Faces of a convex polygon or polyhedron given by its corners, and the faces at each corner."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError, cKDTree

from fieldrecon._core.validation import format_point
from fieldrecon.polynomials import Frame, resolution

KIND = {2: "polygon", 3: "polyhedron"}

ROUNDINGS = 32
"""Distance from an edge or face within which a point is on it, in roundings of the points."""


@dataclass(frozen=True)
class Polytope:
    """A convex polytope whose corners have coordinates of size one, up to a shift.

    Attributes
    ----------
    corners : (n, d) ndarray
        Corners, in the caller's order.
    faces : list of integer arrays
        Corners of each face: the two ends of an edge in 2-D, where the edges are in order round the
        polygon; in order round the face in 3-D.
    normals : (f, d) ndarray
        Outward normals, of a length such that the corner farthest below the face has a height
        between 1/2 and 1.
    corner_faces : list of integer arrays
        Faces at each corner, in order round it in 3-D.
    """

    corners: np.ndarray
    faces: list[np.ndarray]
    normals: np.ndarray
    corner_faces: list[np.ndarray]

    @classmethod
    def of(cls, points: np.ndarray) -> Polytope:
        """The polytope whose corners are these points, in units of its size.

        Raises
        ------
        ValueError
            If a point is not a corner of the convex hull, or is repeated.
        numpy.linalg.LinAlgError
            If all points lie on a line, or in a plane.
        """
        tolerance = ROUNDINGS * resolution(points)
        corners = points / Frame.around(points).scale
        _require_dimension(corners, tolerance)
        _require_distinct(points, corners, tolerance)
        faces, outward = _faces(corners, tolerance)
        meeting = _faces_at(corners, faces, outward)
        _require_corners(points, corners, faces, outward, meeting, tolerance)
        normals = np.stack([_normal(corners[f], n) for f, n in zip(faces, outward, strict=True)])
        depth = [((corners[f[0]] - corners) @ n).max() for f, n in zip(faces, normals, strict=True)]
        normals *= np.exp2(-np.frexp(depth)[1])[:, None]
        return cls(corners, faces, normals, meeting)


def around(vectors: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Order of vectors in space by their angle about an axis; none may be parallel to it."""
    flat = vectors - np.outer(vectors @ axis, axis) / (axis @ axis)
    first = flat[0]
    second = np.cross(axis, first) / np.linalg.norm(axis)
    return np.argsort(np.arctan2(flat @ second, flat @ first), kind="stable")


def in_order(normals: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Faces that meet at a corner, in order round it."""
    if len(at) <= normals.shape[1]:
        return at
    unit = normals[at] / np.linalg.norm(normals[at], axis=1)[:, None]
    return at[around(unit, unit.sum(axis=0))]


def hanging_vertices(points: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """Corners of a convex polygon (n, 2), and the vertices along each edge that has inner ones.

    A vertex is inside an edge if it is no farther from it than rounding. All vertices are corners
    if one of them is neither a corner nor inside an edge.

    Returns
    -------
    corners : (k,) ndarray of int
        Increasing.
    edges : list of ndarray
        Vertices from one end of an edge to the other.
    """
    tolerance = ROUNDINGS * resolution(points)
    p = points / Frame.around(points).scale
    _require_dimension(p, tolerance)
    _require_distinct(points, p, tolerance)
    everything: tuple[np.ndarray, list[np.ndarray]] = np.arange(len(p)), []
    try:
        ring = ConvexHull(p - p.mean(axis=0)).vertices.tolist()
    except QhullError:
        return everything
    straight = True
    while straight and len(ring) > 2:
        height = _heights(p[ring], p[np.roll(ring, 1)], p[np.roll(ring, -1)])[0]
        straight = bool(height.min() <= tolerance)
        if straight:
            del ring[int(height.argmin())]
    if len(ring) < 3:
        return everything
    rest, edges = np.setdiff1d(np.arange(len(p)), ring), []
    for a, b in zip(ring, np.roll(ring, -1), strict=True):
        height, t = _heights(p[rest], p[a], p[b])
        on = (height <= tolerance) & (t > 0) & (t < 1)
        if on.any():
            edges.append(np.array([a, *rest[on][np.argsort(t[on])], b]))
    found = sum(len(edge) - 2 for edge in edges) == len(rest)
    return (np.sort(ring), edges) if found else everything


def _heights(p: np.ndarray, a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances of points from the lines through a and b, and their parameters, from 0 to 1."""
    along, away = b - a, p - a
    squared = (along**2).sum(axis=-1)
    cross = along[..., 0] * away[..., 1] - along[..., 1] * away[..., 0]
    return np.abs(cross) / np.sqrt(squared), (along * away).sum(axis=-1) / squared


def _faces(corners: np.ndarray, tolerance: float) -> tuple[list[np.ndarray], np.ndarray]:
    """Corners of each face, in order, and unit normals; coplanar triangles are one face."""
    d = corners.shape[1]
    center = corners.mean(axis=0)  # Qhull's planes keep their digits only near the origin
    try:
        hull = ConvexHull(corners - center)
    except QhullError:
        raise _flat(d) from None
    if d == 2:
        edges = np.stack([hull.vertices, np.roll(hull.vertices, -1)], axis=1)  # anticlockwise
        along = corners[edges[:, 1]] - corners[edges[:, 0]]
        outward = np.stack([along[:, 1], -along[:, 0]], axis=1)
        return list(edges), outward / np.linalg.norm(along, axis=1)[:, None]
    found: dict[frozenset[int], np.ndarray] = {}
    for plane in np.unique(hull.equations, axis=0):
        height = (corners - center) @ plane[:3] + plane[3]
        found.setdefault(frozenset(np.flatnonzero(np.abs(height) <= tolerance).tolist()), plane[:3])
    largest = {f: n for f, n in found.items() if len(f) > 2 and not any(f < g for g in found)}
    faces = []
    for face, normal in largest.items():
        members = np.array(sorted(face))
        faces.append(members[around(corners[members] - corners[members].mean(axis=0), normal)])
    return faces, np.array(list(largest.values()))


def _normal(face: np.ndarray, outward: np.ndarray) -> np.ndarray:
    """Normal of a face from its corners (k, d), by sums of products."""
    edges = face[1:] - face[0]
    if len(outward) == 2:
        normal = np.array([edges[0, 1], -edges[0, 0]])
    else:
        normal = np.cross(edges[:-1], edges[1:]).sum(axis=0)
    return normal if normal @ outward > 0 else -normal


def _faces_at(
    corners: np.ndarray, faces: list[np.ndarray], outward: np.ndarray
) -> list[np.ndarray]:
    """Faces at each corner, in order round it."""
    lists: list[list[int]] = [[] for _ in corners]
    for a, face in enumerate(faces):
        for i in face:
            lists[i].append(a)
    meeting = [np.array(which, dtype=int) for which in lists]
    return [in_order(outward, m) for m in meeting]


def _flat(d: int) -> np.linalg.LinAlgError:
    where = "on a line" if d == 2 else "in a plane"
    return np.linalg.LinAlgError(
        f"the vertices lie {where}: they are not the corners of a {KIND[d]}"
    )


def _require_dimension(corners: np.ndarray, tolerance: float) -> None:
    d = corners.shape[1]
    sigma = np.linalg.svd(corners - corners.mean(axis=0), compute_uv=False)
    if sigma[d - 1] <= tolerance * sigma[0]:
        raise _flat(d)


def _require_distinct(points: np.ndarray, corners: np.ndarray, tolerance: float) -> None:
    pairs = cKDTree(corners).query_pairs(tolerance)
    if pairs:
        i, j = min(pairs)
        raise ValueError(f"vertices must differ; {_named(points, i)} and vertex {j} coincide")


def _require_corners(
    points: np.ndarray,
    corners: np.ndarray,
    faces: list[np.ndarray],
    outward: np.ndarray,
    meeting: list[np.ndarray],
    tolerance: float,
) -> None:
    """Refuse a vertex that no plane separates from its neighbours by more than the tolerance."""
    for i, at in enumerate(meeting):
        others = np.setdiff1d(np.concatenate([faces[a] for a in at]), i) if len(at) else at
        normal = outward[at].sum(axis=0)
        if not len(at) or (normal @ (corners[i] - corners[others]).T).min() <= tolerance:
            height = [n @ (corners[f[0]] - corners[i]) for f, n in zip(faces, outward, strict=True)]
            where = "inside" if min(height) > tolerance else "on the boundary of"
            raise ValueError(
                f"vertices must be the corners of a convex {KIND[points.shape[1]]}; "
                f"{_named(points, i)} lies {where} the hull of the others"
            )


def _named(points: np.ndarray, i: int) -> str:
    return f"vertex {i}, ({format_point(points[i])}),"
