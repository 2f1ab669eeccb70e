"""Patches: overlapping balls of nearest sites, and smooth weights that sum to one.

A patch is a ball about the middle of a box of sites. Its sites are the k nearest to its centre, and
its radius is the distance of the next one. So each site in the ball belongs to the patch, and if
the field of each patch interpolates, so does the blended field. Where sites are dense, balls are
small. A patch whose sites do not determine its polynomials takes more of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._core.chunks import Progress, chunked, rows_of
from fieldrecon._numerics.kd_partition import KDPartition, halved
from fieldrecon.methods.partition_of_unity.patch_systems import PatchSystems, Problem
from fieldrecon.methods.partition_of_unity.polynomial_rank import (
    determined_basis,
    maybe_rank_deficient,
)
from fieldrecon.polynomials import dimension, power_of_two_above

SITES_PER_BOX = 1 / 3
"""Number of sites of a box, as a fraction of the sites of its patch."""
REACH = 0.8
"""A box is covered if all its sites are within this fraction of the radius from the centre."""
THINNED = 10
"""Maximum number of neighbouring sites that one site represents on the next, coarser level."""
MAX_GROWTH = 4
"""Maximum factor by which a patch that does not determine its polynomials gets more sites."""
FEW = 3
"""Minimum of this number."""


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
        covering: Progress | None = None,
        reaching: Progress | None = None,
    ) -> Patches:
        """Patches of k of the sites (n, d) each, in the order of their boxes."""
        rows = boxes.sites[(boxes.sites >= 0).any(axis=1)]
        centers, radii, sites = _covering(points, tree, rows, k, covering)
        representatives = _thinned(points, rows)
        reached = boxes.reached(centers, radii, reaching)
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
        """Weights (p, s) of patches (p,) at points (p, s, d), before normalisation."""
        away = (x - self.centers[patch, None, :]) / self.radii[patch, None, None]
        inside = np.einsum("psd,psd->ps", away, away) < 1
        weight = np.zeros(inside.shape)
        weight[inside] = bump(away[inside])[0]
        return weight


def systems_of(
    points: np.ndarray,
    tree: cKDTree,
    patches: Patches,
    problem: Problem,
    progress: Progress | None = None,
) -> tuple[tuple[PatchSystems, ...], np.ndarray, np.ndarray]:
    """Systems of the patches, and for each patch the index of its system and its index in it.

    A patch that does not determine its polynomials, or barely does, gets more sites. If even the
    maximum number is too few, it uses only the polynomials that its sites determine. Progress is
    reported for the first round, which has all of the patches.
    """
    groups: list[PatchSystems] = []
    group, member = np.zeros((2, len(patches)), dtype=int)
    rest, sites = np.arange(len(patches)), patches.sites
    most = min(len(points), MAX_GROWTH * sites.shape[1])
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


def bump(offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weight (1 - r)^4 (4 r + 1) of Wendland (1995) at offsets (p, d), and its gradient by them.

    It is twice continuously differentiable, and so are the blended fields.
    """
    r = np.sqrt(np.einsum("pd,pd->p", offset, offset))
    rest = 1.0 - r
    cubed = rest**3
    return cubed * rest * (4.0 * r + 1.0), -20.0 * cubed[:, None] * offset


def _covering(
    points: np.ndarray, tree: cKDTree, rows: np.ndarray, k: int, progress: Progress | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Balls about the middles of boxes; boxes that their ball does not cover are halved.

    Progress is reported for the first round, which has nearly all of them.
    """
    work = partial(_balls, points, tree, k)
    found: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    while len(rows):
        parts = chunked(work, rows, rows_of(8 * 8 * k), progress=None if found else progress)
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
    radius = distance[:, -1]
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
    every = -(-FEW * len(rows) // len(points))
    return np.sort(rows[np.arange(len(rows)), nearest])[::every]


def _reduce(systems: PatchSystems, patches: np.ndarray) -> None:
    for patch in patches.tolist():
        transform = determined_basis(systems.frames(np.array([patch]))[0], systems.degree)
        if transform is not None:
            systems.reduced[patch] = transform


def _frames(
    points: np.ndarray, sites: np.ndarray, degree: int, progress: Progress | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Origins and units of length of patches with these sites, and their `maybe_rank_deficient`."""
    d = points.shape[1]
    rows = rows_of(16 * sites.shape[1] * (d + dimension(d, degree)))
    parts = chunked(partial(_some_frames, points, degree), sites, rows, progress=progress)
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
