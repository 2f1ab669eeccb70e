"""Triangles oriented inconsistently with their neighbours, and closed parts that are inverted."""

from __future__ import annotations

import numpy as np

from fieldrecon.triangles.bounding_volumes import BVH, intersecting_pairs
from fieldrecon.triangles.half_edges import HalfEdges, component_labels
from fieldrecon.triangles.predicates import orient2d, orient3d

_NOTHING = 1e-12
"""Volume of a body, relative to the sum of its absolute terms, below which it is zero."""


def inconsistently_oriented(half_edges: HalfEdges) -> tuple[np.ndarray, np.ndarray]:
    """Whether each triangle is oriented against most of its patch, and is in a one-sided patch.

    A patch is connected by edges of two triangles. The triangles of an orientable patch have two
    orientations; the minority is reported, and in a tie the triangles unlike the first. A patch is
    one-sided if its two sides, as copies of the patch, are connected.

    Returns
    -------
    reversed, one_sided : (m,) ndarray of bool
    """
    m, links = len(half_edges.triangles), half_edges.manifold_links
    against = half_edges.start[links[:, 0]] == half_edges.start[links[:, 1]]
    if not against.any():
        return np.zeros(m, dtype=bool), np.zeros(m, dtype=bool)
    one, other = (links // 3).T
    across = np.where(against, m, 0)
    cover = np.concatenate(
        [np.column_stack([one, other + across]), np.column_stack([one + m, other + m - across])]
    )
    side = component_labels(2 * m, cover)
    patch = component_labels(m, links // 3)
    one_sided = side[:m] == side[m:]
    count = patch.max() + 1
    first = np.full(count, m)
    np.minimum.at(first, patch, np.arange(m))
    unlike = side[:m] != side[first[patch]]
    many = 2 * np.bincount(patch[unlike], minlength=count) > np.bincount(patch, minlength=count)
    return (unlike ^ many[patch]) & ~one_sided, one_sided


def inverted(points: np.ndarray, half_edges: HalfEdges, flipped: np.ndarray) -> np.ndarray:
    """Whether each triangle is in a closed part whose normals point into the body.

    A part inside an odd number of others bounds a cavity, and its normals point into that cavity
    if they are right.

    Parameters
    ----------
    points : (n, 3) ndarray
    sheets : HalfEdges
    flipped : (m,) ndarray of bool
        Triangles to be reversed first.
    """
    closed = half_edges.closed_parts
    if not closed.any():
        return np.zeros(len(flipped), dtype=bool)
    outward = _outward(points, half_edges, flipped)
    inner = _depths(points, half_edges) % 2 == 1
    return (closed & (outward == np.where(inner, 1, -1)))[half_edges.parts]


def _outward(points: np.ndarray, half_edges: HalfEdges, flipped: np.ndarray) -> np.ndarray:
    """Sign of the volume that each part encloses; 0 if rounding would decide."""
    parts, count = half_edges.parts, half_edges.parts.max() + 1
    sample = np.zeros(count, dtype=np.intp)
    sample[parts] = half_edges.triangles[:, 0]
    a, b, c = (points[half_edges.triangles[:, k]] - points[sample[parts]] for k in range(3))
    volume = np.einsum("ki,ki->k", a, np.cross(b, c))
    total = np.bincount(parts, np.where(flipped, -volume, volume), minlength=count)
    terms = np.bincount(parts, np.abs(volume), minlength=count)
    return np.where(np.abs(total) > _NOTHING * terms, np.sign(total), 0)


def _depths(points: np.ndarray, half_edges: HalfEdges) -> np.ndarray:
    """Number of closed parts that contain each closed part.

    A part contains another if an upward ray from a vertex of that one crosses it an odd number of
    times.
    """
    parts, closed = half_edges.parts, half_edges.closed_parts
    count = len(closed)
    if closed.sum() < 2:
        return np.zeros(count, dtype=np.intp)
    faces = np.flatnonzero(closed[parts])
    origin = np.zeros(count, dtype=np.intp)
    origin[parts] = half_edges.triangles[:, 0]
    which = np.flatnonzero(closed)
    start = points[origin[which]]
    corners = points[half_edges.triangles[faces]]
    end = start.copy()
    end[:, 2] = points[:, 2].max()
    low, high = corners.min(axis=1), corners.max(axis=1)
    rays = BVH(start, end, low.min(axis=0))
    tree = BVH(low, high, low.min(axis=0))
    boxes = np.full((2, count, 3), np.inf)
    np.minimum.at(boxes[0], parts[faces], low)
    np.minimum.at(boxes[1], parts[faces], -high)

    def pierced(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        ray, face = rays.order[i], tree.order[j]
        within = _inside_boxes(boxes[:, which[ray]], boxes[:, parts[faces[face]]])
        ray, face = ray[within], face[within]
        above = _below(start[ray], corners[face])
        return np.column_stack([which[ray[above]], parts[faces[face[above]]]])

    hits = intersecting_pairs(rays, pierced, tree)
    crossed, times = np.unique(hits, axis=0, return_counts=True)
    return np.bincount(crossed[times % 2 == 1, 0], minlength=count)


def _inside_boxes(inner: np.ndarray, outer: np.ndarray) -> np.ndarray:
    """Whether boxes (2, k, 3), as low and negative high corners, lie strictly inside others."""
    return np.logical_and.reduce(inner > outer, axis=(0, 2))


def _below(p: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Whether triangles (k, 3, 3) are above points; at a common edge, at most one of them is.

    In the projection from above, a triangle contains a point if a line to the right of the point
    crosses its edges an odd number of times. The crossing of an edge does not depend on the
    triangle.
    """
    odd = np.zeros(len(p), dtype=bool)
    for e, f in ((0, 1), (1, 2), (2, 0)):
        one, other = corners[:, e], corners[:, f]
        up = (one[:, 1] < other[:, 1])[:, None]
        lower, upper = np.where(up, one, other), np.where(up, other, one)
        spans = (lower[:, 1] <= p[:, 1]) & (p[:, 1] < upper[:, 1])
        odd ^= spans & (orient2d(lower[:, :2], upper[:, :2], p[:, :2]) > 0)
    a, b, c = (corners[:, k] for k in range(3))
    return odd & (orient3d(a, b, c, p) * orient2d(a[:, :2], b[:, :2], c[:, :2]) < 0)
