"""Neighbour search: all sites, those within a radius, or the k nearest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._core.duplicates import by_position
from fieldrecon._core.validation import as_count

_GROUP = 2**18  # queries that are ordered together


@dataclass(frozen=True)
class Neighborhood:
    """Sites about a batch of m queries, at most k of them each.

    Attributes
    ----------
    index : (m, k) ndarray
        Indices of sites; an entry is missing where `distance` is infinite.
    distance : (m, k) ndarray
        Distances r of the sites from the query.
    reach : (m,) ndarray or None
        Distance of the nearest site outside the neighbourhood, if the weight is scaled by it.
    reach_index : (m,) ndarray or None
        Index of that site.
    """

    index: np.ndarray
    distance: np.ndarray
    reach: np.ndarray | None = None
    reach_index: np.ndarray | None = None

    @property
    def missing(self) -> np.ndarray:
        """Entries (m, k) without a site."""
        return np.isinf(self.distance)


def as_neighbors(neighbors: int | None, n: int) -> int | None:
    """A number of neighbours below n, so that one more site sets the scale, or None for all."""
    if neighbors is None:
        return None
    wanted = f"an integer from 1 to {n - 1}, fewer than the {n} points, or None for all of them"
    return as_count(neighbors, "neighbors", 1, n - 1, wanted)


def group_rows(label: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For each of (m, k) labels: the column of the first equal one in its row, and their number."""
    order = np.argsort(label, axis=1, kind="stable")
    ordered = np.take_along_axis(label, order, axis=1)
    new = np.diff(ordered, axis=1, prepend=-1) != 0
    start = np.maximum.accumulate(np.where(new, np.arange(label.shape[1]), 0), axis=1)
    lead, count = np.empty_like(order), np.zeros_like(order)
    np.put_along_axis(lead, order, np.take_along_axis(order, start, axis=1), axis=1)
    np.add.at(count, (np.arange(len(label))[:, None], lead), 1)
    return lead, np.take_along_axis(count, lead, axis=1)


def by_cells(x: np.ndarray) -> np.ndarray:
    """Order of queries (m, d) for a search: cell by cell of a grid, group after group.

    The sites of one query are then in the processor's cache for the next, which takes up to half
    the time off queries in random order. Groups bound the memory beyond the result.
    """
    order = np.empty(len(x), dtype=np.intp)
    for start in range(0, len(x), _GROUP):
        group = slice(start, start + _GROUP)
        order[group] = start + np.argsort(_cells(x[group]), kind="stable")
    return order


def _cells(x: np.ndarray) -> np.ndarray:
    """Number (m,) of the cell of each point (m, d), on a grid of fewer than 2^16 cells."""
    per_axis = int((2**16 - 1) ** (1 / x.shape[1]))
    cell = np.zeros(len(x), dtype=np.uint16)  # two bytes: `argsort` is fastest for them
    for along in x.T / 2:  # half the coordinates, whose differences do not overflow
        along -= along.min()
        extent = along.max()
        along /= extent if extent > 0 else 1.0
        cell = cell * np.uint16(per_axis) + (along * (per_axis - 1)).astype(np.uint16)
    return cell


class Search(Protocol):
    """A neighbour search; `without` excludes one site for each query."""

    local: bool

    def typical_size(self) -> int:
        """Typical number of sites of one query, for the size of the chunks."""

    def __call__(self, x: np.ndarray, without: np.ndarray | None = None) -> Neighborhood:
        """Neighbourhoods of the queries (m, d)."""


class AllSites:
    """Search that returns every site for every query."""

    local = False

    def __init__(self, sites: np.ndarray) -> None:
        self._sites = sites

    def typical_size(self) -> int:
        """The number of all sites."""
        return len(self._sites)

    def __call__(self, x: np.ndarray, without: np.ndarray | None = None) -> Neighborhood:
        """All sites, at their distances."""
        n = len(self._sites)
        distance = np.linalg.norm(self._sites - x[:, None, :], axis=-1)
        if without is not None:
            distance[np.arange(len(x)), without] = math.inf
        return Neighborhood(np.broadcast_to(np.arange(n), (len(x), n)), distance)


class WithinRadius:
    """Search for the sites within a radius, the support of the weight."""

    local = True

    def __init__(self, sites: np.ndarray, radius: float) -> None:
        self._tree = cKDTree(sites)
        self._radius = radius
        sample = sites[:: max(1, len(sites) // 1000)]
        counts = self._tree.query_ball_point(sample, radius, return_length=True)
        self._typical = int(np.max(counts))

    def typical_size(self) -> int:
        """The largest number about a sample of the sites."""
        return self._typical

    def __call__(self, x: np.ndarray, without: np.ndarray | None = None) -> Neighborhood:
        """The sites within the radius, padded to the largest number of them."""
        counts = self._tree.query_ball_point(x, self._radius, return_length=True)
        k = max(1, int(np.max(counts, initial=0)))
        # one step beyond the radius, since the search excludes the bound itself
        bound = math.nextafter(self._radius, math.inf)
        distance, index = self._tree.query(x, k=[*range(1, k + 1)], distance_upper_bound=bound)
        index[np.isinf(distance)] = 0
        if without is not None:
            distance[index == without[:, None]] = math.inf
        return Neighborhood(index, distance)


class Nearest:
    """Search for the k nearest sites; the (k + 1)-th sets the scale of the weight.

    Where distances tie, the sites' positions decide, and not their order.
    """

    local = True

    def __init__(self, sites: np.ndarray, k: int) -> None:
        self._order = by_position(sites)
        self._tree = cKDTree(sites[self._order])
        self._k = k

    def typical_size(self) -> int:
        """The number k."""
        return self._k

    def __call__(self, x: np.ndarray, without: np.ndarray | None = None) -> Neighborhood:
        """The k nearest sites, and the next one with its distance."""
        distance, index = self._tree.query(x, k=self._k + 1 + (without is not None))
        index = self._order.take(index)
        if without is not None:
            distance, index = _dropped(distance, index, without)
        return Neighborhood(index[:, :-1], distance[:, :-1], distance[:, -1], index[:, -1])


def _dropped(
    distance: np.ndarray, index: np.ndarray, without: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """One column fewer: without the given site, or the last where it is not found (duplicates)."""
    hit = index == without[:, None]
    hit[~hit.any(axis=1), -1] = True
    shape = (len(index), index.shape[1] - 1)
    return distance[~hit].reshape(shape), index[~hit].reshape(shape)
