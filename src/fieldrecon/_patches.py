"""Patches: overlapping balls of nearest sites, and smooth weights that sum to one.

A patch is a ball about the middle of a box of sites. Its sites are the k nearest to its centre, and
its radius is the distance of the next one, so that each site in the ball is one of its own: what
interpolates in each patch interpolates after blending. Where sites are dense, balls are small.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._chunks import Progress, chunked, rows_of
from fieldrecon._halving import Boxes, halved

SITES_PER_BOX = 1 / 3
"""Sites of the box that a patch is made for, as a part of the sites of the patch."""
REACH = 0.8
"""A box is covered if no site in it is farther from the centre, as a part of the radius."""
THINNED = 10
"""Of at most so many sites one is kept for patches that cover more,"""
FEW = 3
"""and of no fewer than so many."""


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
    """Balls that hold all sites.

    Attributes
    ----------
    centers : (p, d) ndarray
        Their centres.
    radii : (p,) ndarray
        Their radii; infinite for the one patch of all sites.
    sites : (p, k) ndarray
        The nearest sites of each centre, nearest first.
    representatives : (b,) ndarray
        Sites for patches that cover more: one of every few that lie together.
    """

    centers: np.ndarray
    radii: np.ndarray
    sites: np.ndarray
    representatives: np.ndarray
    boxes: Boxes
    ball: np.ndarray
    start: np.ndarray

    @classmethod
    def of(
        cls,
        points: np.ndarray,
        tree: cKDTree,
        boxes: Boxes,
        k: int,
        covering: Progress | None = None,
        reaching: Progress | None = None,
    ) -> Patches:
        """Patches of k of the sites (n, d) each, which follow each other by box."""
        rows = boxes.sites[(boxes.sites >= 0).any(axis=1)]
        centers, radii, sites = _covering(points, tree, rows, k, covering)
        representatives = _thinned(points, rows)
        reached = boxes.reached(centers, radii, reaching)
        return cls(centers, radii, sites, representatives, boxes, *reached)

    @classmethod
    def single(cls, points: np.ndarray, boxes: Boxes) -> Patches:
        """One patch of all sites (n, d)."""
        center = points.min(axis=0) / 2 + points.max(axis=0) / 2
        every = np.arange(len(points))[None, :]
        start = np.array([0, 1])
        infinite = np.array([np.inf])
        return cls(center[None, :], infinite, every, every[0, :1], boxes, start[:1], start)

    def __len__(self) -> int:
        return len(self.centers)

    def containing(self, x: np.ndarray) -> Pairs:
        """The patches that contain each of the queries (m, d)."""
        box = self.boxes.containing(x)
        first, count = self.start[box], self.start[box + 1] - self.start[box]
        query = np.repeat(np.arange(len(x)), count)
        ends = np.cumsum(count)
        patch = self.ball[np.arange(len(query)) + np.repeat(first - ends + count, count)]
        offset = (x[query] - self.centers[patch]) / self.radii[patch][:, None]
        inside = np.einsum("pd,pd->p", offset, offset) < 1
        return Pairs(query[inside], patch[inside], offset[inside])

    def weights(self, patch: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Weights (p, s) of patches (p,) at places (p, s, d), not yet normalised."""
        away = (x - self.centers[patch, None, :]) / self.radii[patch, None, None]
        inside = np.einsum("psd,psd->ps", away, away) < 1
        weight = np.zeros(inside.shape)
        weight[inside] = bump(away[inside])[0]
        return weight


def _covering(
    points: np.ndarray, tree: cKDTree, rows: np.ndarray, k: int, progress: Progress | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Balls about the middles of boxes; boxes that their ball does not cover are halved.

    Progress is told of the first round, which has nearly all of them.
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
            f"points must not coincide in numbers above {k}, the sites of a patch; merge those "
            "that do, or give a larger patch_size"
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
    """Middle (b, d) of the box of each row of sites, and how far from it the farthest is."""
    there = (rows >= 0)[..., None]
    places = points[rows]
    low = np.where(there, places, np.inf).min(axis=1)
    high = np.where(there, places, -np.inf).max(axis=1)
    center = low / 2 + high / 2
    distance = np.linalg.norm(np.where(there, places - center[:, None, :], 0.0), axis=2)
    return center, distance.max(axis=1)


def _thinned(points: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """One of few sites: the nearest to the middle of its box, which is halved if it is large.

    Of boxes of very few sites each, which follow each other in space, only some have one.
    """
    while rows.shape[1] - 1 > THINNED:
        rows = halved(rows, points.T[:, rows])[2]
    center, _ = _middles(points, rows)
    squared = ((points[rows] - center[:, None, :]) ** 2).sum(axis=2)
    nearest = np.argmin(np.where(rows >= 0, squared, np.inf), axis=1)
    every = -(-FEW * len(rows) // len(points))
    return np.sort(rows[np.arange(len(rows)), nearest])[::every]


def bump(offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weight (1 - r)^4 (4 r + 1) of Wendland (1995) at offsets (p, d), and its gradient by them.

    It is twice continuously differentiable, and so are the blended fields.
    """
    r = np.sqrt(np.einsum("pd,pd->p", offset, offset))
    rest = 1.0 - r
    cubed = rest**3
    return cubed * rest * (4.0 * r + 1.0), -20.0 * cubed[:, None] * offset
