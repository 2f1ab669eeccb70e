"""Half-edges of triangles: edges, connected parts, fans around vertices, boundary loops."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components


class HalfEdges:
    """The connectivity of triangles (m, 3), with three distinct vertices each and no duplicates.

    The half-edge, or *side*, 3 t + k of triangle t goes from its k-th vertex to the next; its
    *corner* 3 t + k is at its k-th vertex. Sides with the same ends form one edge.
    """

    def __init__(self, triangles: np.ndarray, n: int) -> None:
        self.triangles, self.n = triangles, n
        self.start = triangles.ravel()
        self.end = triangles[:, [1, 2, 0]].ravel()
        key = np.minimum(self.start, self.end) * np.int64(n) + np.maximum(self.start, self.end)
        self._order = np.argsort(key)
        key = key[self._order]
        again = np.zeros(len(key), dtype=bool)
        again[1:] = key[1:] == key[:-1]
        self._linked = np.flatnonzero(again)
        self._first = np.flatnonzero(~again)
        self._count = np.diff(self._first, append=len(key))

    @cached_property
    def links(self) -> np.ndarray:
        """Pairs (l, 2) of sides at a common edge; k - 1 pairs at an edge of k sides."""
        return np.column_stack([self._order[self._linked - 1], self._order[self._linked]])

    @cached_property
    def manifold_links(self) -> np.ndarray:
        """Pairs (l, 2) of sides at the edges of exactly two sides."""
        first = self._first[self._count == 2]
        return np.column_stack([self._order[first], self._order[first + 1]])

    @cached_property
    def edges(self) -> np.ndarray:
        """Ends (e, 2) of each edge, the smaller index first."""
        return self._ends(self._order[self._first])

    @cached_property
    def nonmanifold_edges(self) -> np.ndarray:
        """Ends (k, 2) of the edges of more than two triangles."""
        return self._ends(self._order[self._first[self._count > 2]])

    @cached_property
    def free_sides(self) -> np.ndarray:
        """Boundary sides (b,), which no other triangle shares, increasing."""
        return np.sort(self._order[self._first[self._count == 1]])

    @cached_property
    def parts(self) -> np.ndarray:
        """Label (m,) of the part of each triangle; parts are connected by edges."""
        return component_labels(len(self.triangles), self.links // 3)

    @cached_property
    def closed_parts(self) -> np.ndarray:
        """Whether each part has two triangles at every edge."""
        closed = np.ones(self.parts.max(initial=-1) + 1, dtype=bool)
        closed[self.parts[self.free_sides // 3]] = False
        if len(self.nonmanifold_edges):
            links = self.links
            usual = np.isin(links[:, 0], self.manifold_links[:, 0])
            closed[self.parts[links[~usual, 0] // 3]] = False
        return closed

    @cached_property
    def fans(self) -> np.ndarray:
        """Label (3m,) of the fan of each corner.

        A fan consists of the corners at a vertex that are connected by edges at that vertex.
        """
        one, other = self.links.T
        along = (self.start[one] == self.start[other])[:, None]
        corners = (
            np.column_stack([one, other]),
            np.column_stack([next_sides(one), next_sides(other)]),
        )
        first = np.where(along, corners[0], np.column_stack([one, next_sides(other)]))
        second = np.where(along, corners[1], np.column_stack([next_sides(one), other]))
        return component_labels(len(self.start), np.concatenate([first, second]))

    @cached_property
    def bow_ties(self) -> np.ndarray:
        """Vertices with more than one fan, increasing."""
        count = self.fans.max(initial=-1) + 1
        vertex = np.empty(count, dtype=np.intp)
        vertex[self.fans] = self.start
        return np.flatnonzero(np.bincount(vertex, minlength=self.n) > 1)

    @cached_property
    def loop_sides(self) -> tuple[np.ndarray, ...]:
        """Sides around each hole, in order, most of them in their own direction.

        At a vertex with several fans the loop stays in one of them. A sequence that ends at an edge
        of more than two triangles is open.
        """
        return tuple(self.free_sides[walk // 2] for walk in self._walks)

    @cached_property
    def boundary_loops(self) -> tuple[np.ndarray, ...]:
        """Vertices around each hole: the first end of each side along the loop."""
        ends = np.column_stack([self.start[self.free_sides], self.end[self.free_sides]]).ravel()
        return tuple(ends[walk] for walk in self._walks)

    @cached_property
    def _walks(self) -> tuple[np.ndarray, ...]:
        """Ends of the free sides at which a walk around each hole enters them."""
        free = self.free_sides
        if len(free) == 0:
            return ()
        fan = np.column_stack([self.fans[free], self.fans[next_sides(free)]]).ravel()
        where = np.arange(len(fan))
        onward = _partners(fan)[where ^ 1]
        label, rank = _cycles(onward)
        order = np.lexsort((rank, label))
        position = np.empty_like(order)
        position[order] = where
        seen = order[position[order] < position[order ^ 1]]  # each side once, in one direction
        return tuple(np.split(seen, np.flatnonzero(np.diff(label[seen])) + 1))

    def _ends(self, sides: np.ndarray) -> np.ndarray:
        ends = np.column_stack([self.start[sides], self.end[sides]])
        ends.sort(axis=1)
        return ends


def component_labels(n: int, links: np.ndarray) -> np.ndarray:
    """Label of the connected component of each of n nodes, given the links (l, 2) between them."""
    ones = np.ones(len(links), dtype=np.int8)
    graph = sparse.csr_array((ones, (links[:, 0], links[:, 1])), shape=(n, n))
    return connected_components(graph, directed=False)[1]


def next_sides(sides: np.ndarray) -> np.ndarray:
    """The next side of the same triangle."""
    return sides + 1 - 3 * (sides % 3 == 2)


def _partners(groups: np.ndarray) -> np.ndarray:
    """Pair the elements of each group; the last of an odd number is its own partner."""
    order = np.argsort(groups, kind="stable")
    ordered = groups[order]
    starts = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]]))
    size = np.diff(starts, append=len(groups))
    position = np.arange(len(groups)) - np.repeat(starts, size)
    other = np.arange(len(groups)) + 1 - 2 * (position % 2)
    alone = (position % 2 == 0) & (position == np.repeat(size, size) - 1)
    partner = np.empty_like(order)
    partner[order] = order[np.where(alone, np.arange(len(groups)), other)]
    return partner


def _cycles(onward: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The smallest element of the cycle of each element of a permutation, and the steps from it."""
    label, jump = np.arange(len(onward)), onward
    for _ in range(len(onward).bit_length()):
        label, jump = np.minimum(label, label[jump]), jump[jump]
    least = label == np.arange(len(onward))
    steps, jump = np.where(least, 0, 1), np.where(least, np.arange(len(onward)), onward)
    for _ in range(len(onward).bit_length()):
        steps, jump = steps + steps[jump], jump[jump]
    size = np.bincount(label, minlength=len(onward))[label]
    return label, -steps % size
