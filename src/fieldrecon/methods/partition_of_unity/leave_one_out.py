"""Leave-one-out residuals of blended patches, without a refit of any patch.

The patches stay, and each gives up the site. With lambda = S^-1 f the residual of a patch at its
site i is lambda_i / (S^-1)_ii; the residual of the method is the mean of those of the patches that
contain the site, weighted as the patches are blended. Without the site, patches would lie elsewhere
and have other neighbours: the residuals estimate the error, and are not those of refits.

References
----------
Rippa, An algorithm for selecting a good value for the parameter c in radial basis function
interpolation (1999).
"""

from __future__ import annotations

from functools import partial

import numpy as np

from fieldrecon._core.chunks import Progress, chunked, progress_after
from fieldrecon._core.validation import format_point
from fieldrecon.methods.partition_of_unity.batched_systems import leverages, solved
from fieldrecon.methods.partition_of_unity.blending import Level
from fieldrecon.methods.partition_of_unity.patch_systems import MOST_LEVERAGE, PatchSystems


def blended_residuals(
    points: np.ndarray, level: Level, values: np.ndarray, progress: Progress | None
) -> np.ndarray:
    """Residuals (n, v) of the data (n, v), each against the field of all others."""
    total, weights = np.zeros_like(values), np.zeros(len(values))
    done = 0
    for number, systems in enumerate(level.systems):
        patches = np.flatnonzero(level.group == number)
        work = partial(patch_residuals, systems, values[level.sites])
        own = progress_after(progress, done, len(level.patches))
        done += len(systems)
        every = np.arange(len(systems))
        for part, (residuals, is_valid) in chunked(work, every, systems.rows(), progress=own):
            sites = systems.sites[part]
            weight = level.patches.weights(patches[part], systems.points[sites]) * is_valid
            np.add.at(weights, level.sites[sites], weight)
            np.add.at(total, level.sites[sites], weight[..., None] * residuals)
    if not weights.all():
        i = int(np.flatnonzero(weights == 0)[0])
        raise np.linalg.LinAlgError(
            f"without point {i}, ({format_point(points[i])}), the others of its patches do not "
            "determine the polynomial"
        )
    return total / weights[:, None]


def patch_residuals(
    systems: PatchSystems, values: np.ndarray, patch: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Residuals (p, k, v) of the sites, against the others of its patch, and their validity.

    A residual is valid (p, k) if the other sites determine the polynomials, and zero otherwise.
    """
    k = systems.sites.shape[1]
    unit = np.zeros((len(patch), systems.size, k))
    unit[:, range(k), range(k)] = 1.0
    matrix = systems.matrices(patch)
    inverse = solved(matrix, unit, k)[:, :k]
    is_valid = leverages(matrix, k) <= MOST_LEVERAGE
    diagonal = np.where(is_valid, inverse[:, range(k), range(k)], 1.0)
    residuals = inverse @ values[systems.sites[patch]] / diagonal[..., None]
    return np.where(is_valid[..., None], residuals, 0.0), is_valid
