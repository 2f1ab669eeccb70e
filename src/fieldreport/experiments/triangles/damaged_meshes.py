"""A triangle mesh with many errors at once."""

from __future__ import annotations

import numpy as np

from fieldreport.experiments.triangles.triangle_shapes import Surface, bumpy


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
