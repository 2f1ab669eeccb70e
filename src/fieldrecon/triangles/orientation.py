"""Which triangles are turned the wrong way: against their neighbours, or against the outside."""

from __future__ import annotations

import numpy as np

from fieldrecon.triangles.bounding_volumes import BoxTree, overlapping
from fieldrecon.triangles.half_edges import Sheets, labels
from fieldrecon.triangles.predicates import orient2d, orient3d

_NOTHING = 1e-12
"""Volume of a body over the sum of those of its pieces below which it has none."""


def turned(sheets: Sheets) -> tuple[np.ndarray, np.ndarray]:
    """Whether each triangle is turned against the most of its patch, and is in a one-sided one.

    A patch is connected by edges of two triangles. In a patch that can be oriented the fewer are
    turned against the others, of as many the ones without the first. The patch is looked at twice,
    once as it is and once turned over, as a surface with two sides is: if both are connected, it
    has but one side.

    Returns
    -------
    turned, one_sided : (m,) ndarray of bool
    """
    m, links = len(sheets.triangles), sheets.manifold_links
    against = sheets.start[links[:, 0]] == sheets.start[links[:, 1]]
    if not against.any():
        return np.zeros(m, dtype=bool), np.zeros(m, dtype=bool)
    one, other = (links // 3).T
    across = np.where(against, m, 0)
    cover = np.concatenate(
        [np.column_stack([one, other + across]), np.column_stack([one + m, other + m - across])]
    )
    side = labels(2 * m, cover)
    patch = labels(m, links // 3)
    one_sided = side[:m] == side[m:]
    count = patch.max() + 1
    first = np.full(count, m)
    np.minimum.at(first, patch, np.arange(m))
    unlike = side[:m] != side[first[patch]]
    many = 2 * np.bincount(patch[unlike], minlength=count) > np.bincount(patch, minlength=count)
    return (unlike ^ many[patch]) & ~one_sided, one_sided


def inside_out(points: np.ndarray, sheets: Sheets, flipped: np.ndarray) -> np.ndarray:
    """Whether each triangle is in a closed part whose normals point to the wrong side.

    They are to point out of the body, hence into the cavity from a part that lies inside an odd
    number of others.

    Parameters
    ----------
    points : (n, 3) ndarray
    sheets : Sheets
    flipped : (m,) ndarray of bool
        Triangles that are to be turned first.
    """
    closed = sheets.closed_parts
    if not closed.any():
        return np.zeros(len(flipped), dtype=bool)
    outward = _outward(points, sheets, flipped)
    inner = _depths(points, sheets) % 2 == 1
    return (closed & (outward == np.where(inner, 1, -1)))[sheets.parts]


def _outward(points: np.ndarray, sheets: Sheets, flipped: np.ndarray) -> np.ndarray:
    """Sign of the volume that is inside of each part; 0 where rounding decides."""
    parts, count = sheets.parts, sheets.parts.max() + 1
    some = np.zeros(count, dtype=np.intp)
    some[parts] = sheets.triangles[:, 0]
    a, b, c = (points[sheets.triangles[:, k]] - points[some[parts]] for k in range(3))
    volume = np.einsum("ki,ki->k", a, np.cross(b, c))
    total = np.bincount(parts, np.where(flipped, -volume, volume), minlength=count)
    terms = np.bincount(parts, np.abs(volume), minlength=count)
    return np.where(np.abs(total) > _NOTHING * terms, np.sign(total), 0)


def _depths(points: np.ndarray, sheets: Sheets) -> np.ndarray:
    """In how many closed parts each closed part lies.

    A ray upward from one of its vertices goes out through a part that it is in once more than in.
    """
    parts, closed = sheets.parts, sheets.closed_parts
    count = len(closed)
    if closed.sum() < 2:
        return np.zeros(count, dtype=np.intp)
    walls = np.flatnonzero(closed[parts])
    origin = np.zeros(count, dtype=np.intp)
    origin[parts] = sheets.triangles[:, 0]
    which = np.flatnonzero(closed)
    start = points[origin[which]]
    corners = points[sheets.triangles[walls]]
    top = np.broadcast_to([0.0, 0.0, points[:, 2].max()], start.shape)
    low, high = corners.min(axis=1), corners.max(axis=1)
    rays = BoxTree(start, np.maximum(start, top * [0, 0, 1] + start * [1, 1, 0]), low.min(axis=0))
    tree = BoxTree(low, high, low.min(axis=0))
    boxes = np.full((2, count, 3), np.inf)
    np.minimum.at(boxes[0], parts[walls], low)
    np.minimum.at(boxes[1], parts[walls], -high)

    def pierced(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        ray, wall = rays.order[i], tree.order[j]
        within = _inside_boxes(boxes[:, which[ray]], boxes[:, parts[walls[wall]]])
        ray, wall = ray[within], wall[within]
        above = _below(start[ray], corners[wall])
        return np.column_stack([which[ray[above]], parts[walls[wall[above]]]])

    hits = overlapping(rays, pierced, tree)
    crossed, times = np.unique(hits, axis=0, return_counts=True)
    return np.bincount(crossed[times % 2 == 1, 0], minlength=count)


def _inside_boxes(inner: np.ndarray, outer: np.ndarray) -> np.ndarray:
    """Whether boxes (2, k, 3), of low and of negative high corners, lie strictly inside others."""
    return np.logical_and.reduce(inner > outer, axis=(0, 2))


def _below(p: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Whether triangles (k, 3, 3) are above points; of those at a common edge, one at most is.

    Seen from above, a triangle holds a point if a line from there to the right crosses its edges
    an odd number of times; an edge is crossed or not, whichever triangle asks.
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
