"""Errors planted into a valid triangle mesh: one of each kind, and many at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fieldreport.experiments.triangles.triangle_shapes import (
    Surface,
    band,
    bumpy,
    cube,
    sphere,
    together,
    turned_over,
)

TOWARD = np.array([0.62, -0.62, 0.48])
"""The direction from the centre in which errors are planted."""


@dataclass(frozen=True)
class Planted:
    """A mesh with an error, and the expected findings of the audit: counts by kind.

    Parameters
    ----------
    surface : tuple of ndarray
    found : dict of str to int
    indexed : bool
        Whether the error is in the sharing of vertices, which a triangle soup does not have.
    """

    surface: Surface
    found: dict[str, int]
    indexed: bool = False


def planted_errors(level: int) -> dict[str, Planted]:
    """Plant each error, most of them into a sphere with 20 · 4ˡᵉᵛᵉˡ triangles."""
    return {
        "duplicate vertex": Planted(
            _slit(level),
            {"duplicate_vertices": 1, "boundary_loops": 1, "free_edge_pairs": 2},
            indexed=True,
        ),
        "unreferenced vertex": Planted(
            _with_spare_point(level), {"unreferenced_vertices": 1}, indexed=True
        ),
        "duplicate triangle": Planted(_repeated(level), {"duplicate_triangles": 1}),
        "degenerate triangle": Planted(_capped(level), {"degenerate_triangles": 1}),
        "edge of four triangles": Planted(_with_fin(level), {"nonmanifold_edges": 1}),
        "bow-tie": Planted(_with_spike(level, shared=True), {"bow_tie_vertices": 1}),
        "hole": Planted(_open(level), {"boundary_loops": 1}),
        "flipped triangle": Planted(_flipped(level), {"flipped_triangles": 1}),
        "one side": Planted(
            band(12 * 2**level, half_turns=1),
            {"boundary_loops": 1, "one_sided_triangles": 24 * 2**level},
        ),
        "inside out": Planted(turned_over(sphere(level)), {"inside_out_triangles": 20 * 4**level}),
        "crossing": Planted(_pierced(level), {"crossings": 3}),
        "overlap": Planted(_folded(), {"overlaps": 11}),
        "T-junction": Planted(_split_on_one_side(level), {"boundary_loops": 1, "t_junctions": 1}),
        "touching vertex": Planted(
            _with_spike(level, shared=False), {"touching_vertices": 1}, indexed=True
        ),
    }


def _toward(surface: Surface) -> int:
    """Return the triangle of a sphere at which errors are planted."""
    points, triangles = surface
    return int(np.argmax(points[triangles].mean(axis=1) @ TOWARD))


def _slit(level: int) -> Surface:
    """Replace a vertex by a copy in two neighbouring triangles."""
    points, triangles = sphere(level)
    vertex = triangles[_toward((points, triangles)), 0]
    at = np.flatnonzero((triangles == vertex).any(axis=1))
    first = set(triangles[at[0]])
    second = next(t for t in at[1:] if len(first & set(triangles[t])) == 2)
    triangles = triangles.copy()
    for t in (at[0], second):
        triangles[t] = np.where(triangles[t] == vertex, len(points), triangles[t])
    return np.concatenate([points, points[[vertex]]]), triangles


def _with_spare_point(level: int) -> Surface:
    points, triangles = sphere(level)
    return np.concatenate([points, 1.4 * TOWARD[None]]), triangles


def _repeated(level: int) -> Surface:
    points, triangles = sphere(level)
    return points, np.concatenate([triangles, triangles[[_toward((points, triangles))]]])


def _flipped(level: int) -> Surface:
    points, triangles = sphere(level)
    chosen = _toward((points, triangles))
    triangles[chosen] = triangles[chosen, ::-1]
    return points, triangles


def _open(level: int) -> Surface:
    points, triangles = sphere(level)
    return points, np.delete(triangles, _toward((points, triangles)), axis=0)


def _split_on_one_side(level: int) -> Surface:
    """Split one triangle at the midpoint of an edge without splitting its neighbour."""
    points, triangles = sphere(level)
    chosen = _toward((points, triangles))
    a, b, c = triangles[chosen]
    halves = [[a, len(points), c], [len(points), b, c]]
    middle = (points[a] + points[b]) / 2
    others = np.delete(triangles, chosen, axis=0)
    return np.concatenate([points, [middle]]), np.concatenate([others, halves])


def _capped(level: int) -> Surface:
    """Do the same, and close the seam by a triangle of zero area."""
    points, triangles = _split_on_one_side(level)
    (a, middle, _), (_, b, _) = triangles[-2:]
    return points, np.concatenate([triangles, [[a, b, middle]]])


def _with_fin(level: int) -> Surface:
    """Attach a tetrahedron to an edge."""
    points, triangles = sphere(level)
    _, a, b = triangles[_toward((points, triangles))]
    along = points[b] - points[a]
    out = points[a] + points[b]
    out *= np.linalg.norm(along) / np.linalg.norm(out)
    across = np.cross(along, out) / np.linalg.norm(along) / 4
    middle = (points[a] + points[b]) / 2
    c, d = len(points), len(points) + 1
    fin = [[a, c, b], [a, d, c], [b, c, d], [a, b, d]]
    tops = [middle + out + across, middle + out - across]
    if np.linalg.det([points[b] - points[a], tops[0] - points[a], tops[1] - points[a]]) < 0:
        fin = [t[::-1] for t in fin]
    return np.concatenate([points, tops]), np.concatenate([triangles, fin])


def _with_spike(level: int, *, shared: bool) -> Surface:
    """Attach a tetrahedron by its tip to a vertex, sharing the vertex or with a copy of it."""
    points, triangles = sphere(level)
    vertex = triangles[_toward((points, triangles)), 0]
    spike = _tetrahedron(points[vertex], 2.2 * points[vertex] / 2**level)
    both = together((points, triangles), spike)
    if not shared:
        return both
    merged = np.where(both[1] == len(points), vertex, both[1])
    return np.delete(both[0], len(points), axis=0), merged - (merged > len(points))


def _pierced(level: int) -> Surface:
    """Let the tip of a tetrahedron pierce a triangle from outside."""
    points, triangles = sphere(level)
    chosen = _toward((points, triangles))
    middle = points[triangles[chosen]].mean(axis=0)
    spike = _tetrahedron(middle * (1 - 0.06 / 2**level), 2.2 * middle / 2**level)
    return together((points, triangles), spike)


def _tetrahedron(tip: np.ndarray, axis: np.ndarray) -> Surface:
    """Return a slender tetrahedron from its tip along its axis."""
    u = np.cross(axis, [0.3, 0.2, 0.9])
    u *= 0.3 * np.linalg.norm(axis) / np.linalg.norm(u)
    v = np.cross(axis, u) / np.linalg.norm(axis)
    turn = 2 * np.pi * np.arange(3) / 3
    base = tip + axis + np.outer(np.cos(turn), u) + np.outer(np.sin(turn), v)
    faces = np.array([[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])
    return np.concatenate([[tip], base]), faces


def _folded() -> Surface:
    """Move one vertex within a flat face so far that triangles overlap."""
    points, triangles = cube(3)
    inner = np.flatnonzero((points[:, 2] == 1) & (points[:, :2] % 1 > 0).all(axis=1))
    points = points.copy()
    points[inner[0], :2] += [0.35, 0.05]
    return points, triangles


def damaged(level: int, each: int, seed: int) -> Surface:
    """Return a bumpy sphere with a number of errors of each kind that a repair can undo.

    Holes, inverted triangles, duplicates, T-junctions and unused points; apart from these points,
    the mesh is a triangle soup.
    """
    rng = np.random.default_rng(seed)
    points, triangles = bumpy(level)
    chosen = _far_apart(triangles, rng)
    if len(chosen) < 4 * each:
        raise ValueError(
            f"{each} errors of each kind do not fit on {len(triangles)} triangles without meeting"
        )
    holes, flips, copies, cuts = np.split(chosen[: 4 * each], 4)
    a, b, c = triangles[cuts].T
    middle = len(points) + np.arange(each)
    halves = np.concatenate([np.column_stack([a, middle, c]), np.column_stack([middle, b, c])])
    points = np.concatenate([points, (points[a] + points[b]) / 2])
    triangles[flips] = triangles[flips, ::-1]
    kept = np.delete(triangles, np.concatenate([holes, cuts]), axis=0)
    every = np.concatenate([kept, halves, triangles[copies]])
    every = every[rng.permutation(len(every))]
    spare = 1.1 * points[rng.integers(len(points), size=each)]
    return (
        np.concatenate([points[every].reshape(-1, 3), spare]),
        np.arange(every.size).reshape(-1, 3),
    )


def _far_apart(triangles: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Select triangles of which no two share a vertex or have a common neighbour."""
    near = np.zeros(triangles.max() + 1, dtype=bool)
    chosen = []
    for t in rng.permutation(len(triangles)):
        if not near[triangles[t]].any():
            chosen.append(t)
            near[triangles[np.isin(triangles, triangles[t]).any(axis=1)]] = True
    return np.array(chosen)
