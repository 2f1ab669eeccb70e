"""Exact reference for intersections of triangles: rational arithmetic and all pairs.

Two triangles are intersected, and every point of the intersection is classified: in the interior,
on an edge, or at a corner of each triangle.
"""

import itertools
from fractions import Fraction as F

EDGES = ((0, 1), (1, 2), (2, 0))


def exact(points):
    return [tuple(F(float(c)) for c in p) for p in points]


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b, strict=True))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normal(t):
    return cross(minus(t[1], t[0]), minus(t[2], t[0]))


def is_flat(t):
    return not any(normal(t))


def between(a, b, t):
    return tuple(x + t * (y - x) for x, y in zip(a, b, strict=True))


def heights(t, e, points):
    """Heights of points in the plane of a triangle over its e-th edge; positive inside."""
    a, b = t[EDGES[e][0]], t[EDGES[e][1]]
    inward = cross(normal(t), minus(b, a))
    return [dot(inward, minus(p, a)) for p in points]


def cut(polygon, t):
    """The part of a convex polygon in the plane of a triangle that lies in the triangle."""
    for e in range(3):
        over, kept = heights(t, e, polygon), []
        for k, p in enumerate(polygon):
            before, q = over[k - 1], polygon[k - 1]
            if before * over[k] < 0:
                kept.append(between(q, p, before / (before - over[k])))
            if over[k] >= 0:
                kept.append(p)
        polygon = kept
    return [p for k, p in enumerate(polygon) if p not in polygon[:k]]


def in_plane(t, plane):
    """Intersection of a triangle with the plane of another."""
    n, origin = normal(plane), plane[0]
    over = [dot(n, minus(p, origin)) for p in t]
    found = [p for p, h in zip(t, over, strict=True) if h == 0]
    for i, j in EDGES:
        if over[i] * over[j] < 0:
            found.append(between(t[i], t[j], over[i] / (over[i] - over[j])))
    return found


def location_in(p, t):
    """2 in the interior, 1 inside an edge, 0 at a corner of a triangle."""
    return 2 - sum(heights(t, e, [p])[0] == 0 for e in range(3))


def meet(s, t):
    """ "crossing", "overlap" or None for two triangles that are not flat."""
    common = in_plane(s, t)
    if len(common) == 3:
        polygon = cut(list(s), t)
        area = any(not is_flat(corners) for corners in itertools.combinations(polygon, 3))
        return "overlap" if area else None
    common = cut(common, t)
    samples = [*common, between(*common, F(1, 2))] if len(common) == 2 else common
    kinds = [(location_in(p, s), location_in(p, t)) for p in samples]
    if any(2 in kind for kind in kinds):
        return "crossing"
    return "crossing" if kinds == [(1, 1)] else None  # two edges cross


def on_edge(p, a, b):
    inside = 0 < dot(minus(p, a), minus(b, a)) < dot(minus(b, a), minus(b, a))
    return inside and not any(cross(minus(p, a), minus(b, a)))


def findings(points, triangles):
    """Crossings, overlaps, T-junctions and flat triangles of a mesh, as sets."""
    points = exact(points)
    first_copy = [points.index(p) for p in points]
    named = [tuple(first_copy[i] for i in t) for t in triangles]
    corners = [tuple(points[i] for i in t) for t in named]
    flat = {k for k, t in enumerate(corners) if is_flat(t)}
    sets = [frozenset(t) for t in named]
    solid = [k for k in range(len(named)) if k not in flat and sets.index(sets[k]) == k]
    found = {"crossing": set(), "overlap": set(), None: set()}
    junctions = set()
    for i, j in itertools.combinations(solid, 2):
        found[meet(corners[i], corners[j])].add((i, j))
        for s, t in ((i, j), (j, i)):
            for v, (e, f) in itertools.product(named[s], EDGES):
                a, b = sorted((named[t][e], named[t][f]))
                if on_edge(points[v], points[a], points[b]) and frozenset((v, a, b)) not in sets:
                    junctions.add((v, a, b))
    return found["crossing"], found["overlap"], junctions, flat


def edge_counts(triangles):
    """Number of triangles at each edge, without duplicates and triangles with repeated corners."""
    counts = {}
    for t in {frozenset(map(int, t)) for t in triangles}:
        if len(t) == 3:
            for edge in itertools.combinations(sorted(t), 2):
                counts[edge] = counts.get(edge, 0) + 1
    return counts


def fans(triangles, vertex):
    """Number of groups of triangles at a vertex that are connected by edges at the vertex."""
    groups = []
    for t in {frozenset(map(int, t)) for t in triangles}:
        if len(t) == 3 and vertex in t:
            link = set(t - {vertex})
            joined = [g for g in groups if g & link]
            groups = [g for g in groups if not g & link] + [link.union(*joined)]
    return len(groups)
