"""Which sites each patch takes: its own, more where they do not determine its polynomials."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._chunks import Progress, chunked, rows_of
from fieldrecon._determined import doubtful, told_apart
from fieldrecon._patch_systems import PatchSystems, Problem
from fieldrecon._patches import Patches
from fieldrecon.polynomials import dimension

MOST_GROWTH = 4
"""So many times more sites are given to a patch that does not determine its polynomials."""


def systems_of(
    points: np.ndarray,
    tree: cKDTree,
    patches: Patches,
    problem: Problem,
    progress: Progress | None = None,
) -> tuple[tuple[PatchSystems, ...], np.ndarray, np.ndarray]:
    """Systems of the patches, in which of them each patch is, and where in it.

    A patch that does not determine its polynomials, or only just, is given more sites; if even the
    most are too few, it uses those polynomials only that its sites tell apart. Progress is told of
    the first round, which has all of the patches.
    """
    groups: list[PatchSystems] = []
    group, member = np.zeros((2, len(patches)), dtype=int)
    rest, sites = np.arange(len(patches)), patches.sites
    most = min(len(points), MOST_GROWTH * sites.shape[1])
    while len(rest):
        origin, radius, doubt = _frames(points, sites, problem.degree, None if groups else progress)
        last = sites.shape[1] >= most
        stays = np.ones_like(doubt) if last else ~doubt
        systems = PatchSystems(points, sites[stays], problem, origin[stays], radius[stays])
        if last:
            _reduce(systems, np.flatnonzero(doubt))
        member[rest[stays]], group[rest[stays]] = np.arange(len(systems)), len(groups)
        groups.append(systems)
        rest = rest[~stays]
        more = min(2 * sites.shape[1], len(points))
        sites = tree.query(patches.centers[rest], more)[1].reshape(len(rest), more)
    return tuple(groups), group, member


def _reduce(systems: PatchSystems, patches: np.ndarray) -> None:
    for patch in patches.tolist():
        transform = told_apart(systems.frames(np.array([patch]))[0], systems.degree)
        if transform is not None:
            systems.reduced[patch] = transform


def _frames(
    points: np.ndarray, sites: np.ndarray, degree: int, progress: Progress | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Origins and units of length of patches with these sites (p, k), and which are doubtful."""
    d = points.shape[1]
    rows = rows_of(16 * sites.shape[1] * (d + dimension(d, degree)))
    parts = chunked(partial(_some_frames, points, degree), sites, rows, progress=progress)
    origin, radius, doubt = map(np.concatenate, zip(*(part for _, part in parts), strict=True))
    return origin, radius, doubt


def _some_frames(
    points: np.ndarray, degree: int, sites: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    places = points[sites]
    origin = places.mean(axis=1)
    y = places - origin[:, None, :]
    radius = np.linalg.norm(y, axis=2).max(axis=1)
    # a power of two, so that it rounds nothing
    radius = np.exp2(np.ceil(np.log2(np.where(radius > 0, radius, 1.0))))
    return origin, radius, doubtful(y / radius[:, None, None], degree)
