"""Blended patches as matrices: sparse weights of the data, their gradients, and the adjoint."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from scipy import sparse

from fieldrecon._blending import Level, shares, summed


def weight_rows(levels: Sequence[Level], n: int, x: np.ndarray) -> list[sparse.csr_array]:
    """Weights (m, n) of the data of n sites in the values at queries (m, d), as a list of one."""
    triples = []
    for share in shares(levels, x, gradients=False):
        for systems, _, pairs, member in share.systems():
            query = share.query[pairs]
            terms = systems.basis(member, x[query]) * share.weight[pairs, None]
            sites = share.level.sites[systems.sites[member]]
            triples.append((query, sites, systems.of_data(member, terms)))
    return [_matrix(triples, (len(x), n))]


def gradient_weight_rows(levels: Sequence[Level], n: int, x: np.ndarray) -> list[sparse.csr_array]:
    """Weights in each component of the gradient, d matrices (m, n)."""
    triples: list[list[tuple[np.ndarray, np.ndarray, np.ndarray]]] = [[] for _ in x.T]
    for share in shares(levels, x, gradients=True):
        for systems, _, pairs, member in share.systems():
            query = share.query[pairs]
            basis = systems.basis(member, x[query])
            change = systems.basis_gradient(member, x[query])
            sites = share.level.sites[systems.sites[member]]
            for k, component in enumerate(triples):
                terms = change[..., k] * share.weight[pairs, None]
                terms += basis * share.gradient[pairs, k, None]
                component.append((query, sites, systems.of_data(member, terms)))
    return [_matrix(component, (len(x), n)) for component in triples]


def _matrix(
    triples: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]], shape: tuple[int, int]
) -> sparse.csr_array:
    """The matrix of entries (p, k) in rows (p,) and columns (p, k); entries of one place add."""
    rows = [np.repeat(query, sites.shape[1]) for query, sites, _ in triples]
    columns = [sites.ravel() for _, sites, _ in triples]
    entries = [weights.ravel() for _, _, weights in triples]
    place = np.concatenate(rows), np.concatenate(columns)
    return sparse.coo_array((np.concatenate(entries), place), shape).tocsr()


class Moments:
    """Sums of the bases of patches at queries, times what is given there."""

    def __init__(self, levels: Sequence[Level], v: int, dtype: np.dtype) -> None:
        self._levels = levels
        self._sums = [
            [np.zeros((len(s), s.size, v), dtype=dtype) for s in level.systems] for level in levels
        ]

    def add(self, parts: Iterable[tuple[int, int, np.ndarray, np.ndarray]]) -> None:
        """Add what `moments` gives for some queries."""
        for level, number, patch, sums in parts:
            self._sums[level][number][patch] += sums

    def of_sites(self, n: int) -> np.ndarray:
        """H^T f (n, v): the sums carried over to the sites."""
        v = self._sums[0][0].shape[2]
        total = np.zeros((n, v), dtype=self._sums[0][0].dtype)
        for level, sums in zip(self._levels, self._sums, strict=True):
            for systems, own in zip(level.systems, sums, strict=True):
                sites = level.sites[systems.sites].ravel()
                where, rows = _gathered(sites, systems.adjoint(own).reshape(len(sites), v))
                total[where] += rows
        return total


def moments(
    levels: Sequence[Level], x: np.ndarray, f: np.ndarray, rows: np.ndarray
) -> list[tuple[int, int, np.ndarray, np.ndarray]]:
    """Of some of the queries (m, d) with f (m, v): level, number of systems, patches, sums."""
    x, f = x[rows], f[rows]
    found = []
    for number, share in enumerate(shares(levels, x, gradients=False)):
        for systems, own, pairs, member in share.systems():
            query = share.query[pairs]
            basis = systems.basis(member, x[query]) * share.weight[pairs, None]
            terms = basis[..., None] * f[query, None, :]
            found.append((number, own, *_gathered(member, terms)))
    return found


def _gathered(rows: np.ndarray, terms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows, each once and rising, and the sums of their terms (p, ...)."""
    order = np.argsort(rows, kind="stable")
    rows = rows[order]
    new = np.diff(rows, prepend=-1) > 0
    return rows[new], summed(np.cumsum(new) - 1, terms[order], int(new.sum()))
