"""Patches: overlapping balls of nearest sites, and smooth weights that sum to one.

A patch is a ball about the middle of a box of sites. Its sites are the k nearest to its centre, and
its radius is the distance of the next one, or less beside a gap. So each site in the ball belongs
to the patch, and if the field of each patch interpolates, so does the blended field. Where sites
are dense, balls are small. A patch whose sites do not determine its polynomials takes more of them.
"""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._core.chunks import Progress, chunked, rows_of
from fieldrecon._numerics.kd_partition import KDPartition, halved
from fieldrecon.methods.partition_of_unity.ball_weights import REACH, weights_of_balls
from fieldrecon.methods.partition_of_unity.patch_systems import PatchSystems, Problem
from fieldrecon.methods.partition_of_unity.polynomial_rank import (
    maybe_rank_deficient,
    orthonormal_basis,
)
from fieldrecon.polynomials import dimension, power_of_two_above

SITES_PER_BOX = 1 / 3
"""Number of sites of a box, as a fraction of the sites of its patch."""
WIDEST = 2.0
"""Maximum radius of a ball, as a multiple of the distance of the farthest of its sites.

Beyond, in the gap about a cluster, a coarser level takes over: a patch would extrapolate there.
"""
THINNED = 10
"""Maximum number of neighbouring sites that one site represents on the next, coarser level."""
THINNED_AT_LEAST = 3
"""Sites of a level for each site of the next one, at least: so few levels are enough."""
MAX_GROWTH = 4
"""Maximum factor by which a patch that does not determine its polynomials gets more sites."""
APART = 1e3
"""Factor by which a patch may become wider with these sites.

Beyond, they are outliers, and the kernel would be flat for the others.
"""
BARELY = 1e-6
"""Size at the sites up to which a polynomial, modulo lower degrees, is not determined by them.

The data's noise is magnified by the inverse of the size. This holds for linear polynomials, and for
those that the kernel needs.
"""
BARELY_MORE = 1e-4
"""The same for polynomials of higher degrees: beside tracks they must not follow the noise."""
BASES = 64
"""Number of patches whose bases are computed at once."""


class Pairs(NamedTuple):
    """Queries and the patches that contain them, ordered by query.

    Attributes
    ----------
    query, patch : (p,) ndarray
        The pairs.
    offset : (p, d) ndarray
        Query minus centre, in units of the radius.
    """

    query: np.ndarray
    patch: np.ndarray
    offset: np.ndarray


@dataclass(frozen=True)
class Patches:
    """Balls that together contain all sites.

    Attributes
    ----------
    centers : (p, d) ndarray
        Centres.
    radii : (p,) ndarray
        Radii; infinite for a single patch of all sites.
    sites : (p, k) ndarray
        The nearest sites of each centre, nearest first.
    representatives : (b,) ndarray
        Sites of the next, coarser level: one of every few neighbouring sites.
    """

    centers: np.ndarray
    radii: np.ndarray
    sites: np.ndarray
    representatives: np.ndarray
    boxes: KDPartition
    ball: np.ndarray
    start: np.ndarray

    @classmethod
    def of(
        cls,
        points: np.ndarray,
        tree: cKDTree,
        boxes: KDPartition,
        k: int,
        executor: Executor | None = None,
        covering: Progress | None = None,
        reaching: Progress | None = None,
    ) -> Patches:
        """Patches of k of the sites (n, d) each, in the order of their boxes."""
        rows = boxes.sites[(boxes.sites >= 0).any(axis=1)]
        centers, radii, sites = _covering(points, tree, rows, k, executor, covering)
        representatives = _thinned(points, rows)
        reached = boxes.reached(centers, radii, executor, reaching)
        return cls(centers, radii, sites, representatives, boxes, *reached)

    @classmethod
    def single(cls, points: np.ndarray, boxes: KDPartition) -> Patches:
        """One patch of all sites (n, d)."""
        center = points.min(axis=0) / 2 + points.max(axis=0) / 2
        every = np.arange(len(points))[None, :]
        start = np.array([0, 1])
        infinite = np.array([np.inf])
        return cls(center[None, :], infinite, every, every[0, :1], boxes, start[:1], start)

    def __len__(self) -> int:
        return len(self.centers)

    def containing(self, x: np.ndarray) -> Pairs:
        """Pairs of the queries (m, d) and the patches that contain them."""
        box = self.boxes.containing(x)
        first, count = self.start[box], self.start[box + 1] - self.start[box]
        query = np.repeat(np.arange(len(x)), count)
        ends = np.cumsum(count)
        patch = self.ball[np.arange(len(query)) + np.repeat(first - ends + count, count)]
        offset = (x[query] - self.centers[patch]) / self.radii[patch][:, None]
        inside = np.einsum("pd,pd->p", offset, offset) < 1
        return Pairs(query[inside], patch[inside], offset[inside])

    def weights(self, patch: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Weights (p, s) of patches (p,) at points (p, s, d), before normalization."""
        return weights_of_balls(self.centers[patch], self.radii[patch], x)


def systems_of(
    points: np.ndarray,
    tree: cKDTree,
    patches: Patches,
    problem: Problem,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> tuple[tuple[PatchSystems, ...], np.ndarray, np.ndarray]:
    """Systems of the patches, and for each patch the index of its system and its index in it.

    A patch that does not determine its polynomials, or barely does, gets more sites. If even the
    maximum number is too few, or the next ones are far away, it uses only the polynomials that its
    sites determine. Progress is
    reported for the first round, which has all of the patches.
    """
    groups: list[PatchSystems] = []
    group, member = np.zeros((2, len(patches)), dtype=int)
    rest, sites = np.arange(len(patches)), patches.sites
    most = min(len(points), MAX_GROWTH * sites.shape[1])
    while len(rest):
        own_progress = None if groups else progress
        origin, radius, doubt = _frames(points, sites, problem.degree, executor, own_progress)
        grows = np.flatnonzero(doubt) if sites.shape[1] < most else np.array([], dtype=int)
        more = min(2 * sites.shape[1], len(points))
        distance, wider = tree.query(
            patches.centers[rest[grows]], [sites.shape[1], *range(1, 1 + more)]
        )
        own, next_ones = distance.T[[0, -1]]
        beside = (own == 0) | (next_ones <= APART * own)  # coincident sites have no size
        grows, wider = grows[beside], wider[beside, 1:]
        stays = np.ones_like(doubt)
        stays[grows] = False
        own = rest[stays]
        systems = PatchSystems(
            points,
            sites[stays],
            problem,
            origin[stays],
            radius[stays],
            patches.centers[own],
            patches.radii[own],
        )
        _find_bases(systems, np.flatnonzero(doubt[stays]), executor)
        member[own], group[own] = np.arange(len(systems)), len(groups)
        groups.append(systems)
        rest, sites = rest[grows], wider
    return tuple(groups), group, member


def _covering(
    points: np.ndarray,
    tree: cKDTree,
    rows: np.ndarray,
    k: int,
    executor: Executor | None,
    progress: Progress | None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Balls about the middles of boxes; boxes that their ball does not cover are halved.

    Progress is reported for the first round, which has nearly all of them.
    """
    work = partial(_balls, points, tree, k)
    found: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    while len(rows):
        own_progress = None if found else progress
        parts = chunked(work, rows, rows_of(8 * 8 * k), executor, own_progress)
        *balls, covers = map(np.concatenate, zip(*(part for _, part in parts), strict=True))
        found.append(tuple(ball[covers] for ball in balls))
        rows = rows[~covers]
        if len(rows):
            rows = halved(rows, points.T[:, rows])[2]
            rows = rows[(rows >= 0).any(axis=1)]
    centers, radii, sites = (np.concatenate(part) for part in zip(*found, strict=True))
    if not radii.all():
        raise ValueError(
            f"at most {k} points, the sites of a patch, may coincide; merge coincident points, or "
            "give a larger patch_size"
        )
    return centers, radii, sites


def _balls(
    points: np.ndarray, tree: cKDTree, k: int, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Centre, radius and sites of the ball of each box, and whether it covers the box."""
    center, reach = _middles(points, rows)
    distance, index = tree.query(center, k + 1)
    own, next_site = distance[:, -2], distance[:, -1]
    radius = np.where(own > 0, np.minimum(next_site, WIDEST * own), next_site)
    return center, radius, index[:, :-1], reach <= REACH * radius


def _middles(points: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Middle (b, d) of the box of each row of sites, and its distance (b,) to the farthest site."""
    there = (rows >= 0)[..., None]
    sites = points[rows]
    low = np.where(there, sites, np.inf).min(axis=1)
    high = np.where(there, sites, -np.inf).max(axis=1)
    center = low / 2 + high / 2
    distance = np.linalg.norm(np.where(there, sites - center[:, None, :], 0.0), axis=2)
    return center, distance.max(axis=1)


def _thinned(points: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """One of every few sites: the nearest to the middle of its box, which is halved if it is large.

    If the boxes have very few sites each, only every second or third box has such a site.
    """
    while rows.shape[1] - 1 > THINNED:
        rows = halved(rows, points.T[:, rows])[2]
    center, _ = _middles(points, rows)
    squared = ((points[rows] - center[:, None, :]) ** 2).sum(axis=2)
    nearest = np.argmin(np.where(rows >= 0, squared, np.inf), axis=1)
    every = -(-THINNED_AT_LEAST * len(rows) // len(points))
    chosen = np.sort(rows[np.arange(len(rows)), nearest])[::every]
    return np.union1d(chosen, _outliers(points, chosen))


def _outliers(points: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """The extreme sites of each axis that are far outside the box of the chosen ones.

    Without them, coarser levels would extrapolate between a cloud and an outlier.
    """
    low, high = points[chosen].min(axis=0), points[chosen].max(axis=0)
    extremes = np.stack([points.argmin(axis=0), points.argmax(axis=0)])
    least, most = np.take_along_axis(points, extremes, axis=0)
    beyond = np.stack([low - least, most - high])
    return extremes[beyond > (high - low) / 2]


def _find_bases(systems: PatchSystems, patches: np.ndarray, executor: Executor | None) -> None:
    """Bases of the polynomials that these patches determine."""
    found = chunked(partial(_bases, systems), patches, BASES, executor)
    for part, bases in found:
        systems.bases.update(zip(patches[part].tolist(), bases, strict=True))


def _bases(systems: PatchSystems, patch: np.ndarray) -> np.ndarray:
    """The `orthonormal_basis` (p, q, q) of each of the patches (p,)."""
    rounding = systems.problem.rounding / systems.radius[patch]
    needed = np.arange(systems.degree + 1) <= max(1, systems.problem.kernel.order - 1)
    barely = np.where(needed, BARELY, BARELY_MORE)
    tolerance = np.maximum(barely, 4 * max(systems.degree, 1) * rounding[:, None])
    return orthonormal_basis(systems.frames(patch), systems.degree, tolerance)


def _frames(
    points: np.ndarray,
    sites: np.ndarray,
    degree: int,
    executor: Executor | None,
    progress: Progress | None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Origins and units of length of patches with these sites, and their `maybe_rank_deficient`."""
    d = points.shape[1]
    rows = rows_of(16 * sites.shape[1] * (d + dimension(d, degree)))
    parts = chunked(partial(_some_frames, points, degree), sites, rows, executor, progress)
    origin, radius, doubt = map(np.concatenate, zip(*(part for _, part in parts), strict=True))
    return origin, radius, doubt


def _some_frames(
    points: np.ndarray, degree: int, sites: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    coordinates = points[sites]
    origin = coordinates.mean(axis=1)
    y = coordinates - origin[:, None, :]
    radius = power_of_two_above(np.linalg.norm(y, axis=2).max(axis=1))
    return origin, radius, maybe_rank_deficient(y / radius[:, None, None], degree)
