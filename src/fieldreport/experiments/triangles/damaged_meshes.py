"""A body with many errors at once, as files from elsewhere have them."""

from __future__ import annotations

import numpy as np

from fieldreport.experiments.triangles.triangle_shapes import Surface, bumpy


def damaged(level: int, each: int, seed: int) -> Surface:
    """Return a bumpy sphere with so many errors of each kind that a repair can undo.

    Holes, flipped triangles, copies, triangles cut on one side of an edge, points that nothing
    uses, and all of it as a soup but for these points.
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
    """Triangles of which no two share a vertex, nor have a neighbour in common."""
    near = np.zeros(triangles.max() + 1, dtype=bool)
    chosen = []
    for t in rng.permutation(len(triangles)):
        if not near[triangles[t]].any():
            chosen.append(t)
            near[triangles[np.isin(triangles, triangles[t]).any(axis=1)]] = True
    return np.array(chosen)
