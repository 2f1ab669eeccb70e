"""Kernel matrices between queries and sites, in blocks: dense, or sparse for compact support.

Both classes have the same methods: `values(x)` yields parts of the sites with phi(|x_i - p_j|),
`gradients(x)` yields them with its derivatives by each variable of x, `hessians(x)` with its second
derivatives, and `laplacians(x)` with the sum of these, as matrices (m, sites of the part).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import Executor
from typing import TypeAlias

import numpy as np
from scipy import sparse
from scipy.spatial.distance import cdist

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, chunked, rows_of
from fieldrecon._numerics.saddle_point import SaddlePoint, balancing, entries_of_factor
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.derivatives import laplacian, second_derivatives
from fieldrecon.methods.compact_support import NearPairs
from fieldrecon.methods.solvability import refuse_beyond_memory, within_range

TILE = 1024
"""Number of centres at once: their distances from a chunk of queries stay in the cache."""

Block: TypeAlias = np.ndarray | sparse.csr_array


def tiles(n: int) -> Iterator[slice]:
    """Slices of at most TILE out of n."""
    for start in range(0, n, TILE):
        yield slice(start, min(start + TILE, n))


class AllPairs:
    """Dense kernel matrices of every query with every site.

    Parameters
    ----------
    sites : (n, d) ndarray
        Centres.
    kernel : Radial
        Kernel in the sites' unit of length.
    """

    def __init__(self, sites: np.ndarray, kernel: Radial) -> None:
        self.sites, self.kernel = sites, kernel

    def system(
        self,
        p: np.ndarray,
        smoothing: np.ndarray,
        executor: Executor | None = None,
        progress: Progress | None = None,
    ) -> SaddlePoint:
        """Factored system of the kernel between all sites, smoothed and bordered by P.

        The executor computes the entries, of whose rows progress is reported.
        """
        refuse_beyond_memory(len(self.sites))
        n = len(self.sites)
        a = np.zeros((n, n), order="F")
        for part, block in chunked(self._rows, np.arange(n), rows_of(64 * n), executor, progress):
            a[part.start :, part] = block.T
        a[np.diag_indices_from(a)] += smoothing
        factors = balancing(np.diagonal(a), a[1:, 0]) if np.ptp(smoothing) else None
        return valid.quiet_evaluate(SaddlePoint, a, p, factors)

    def _rows(self, rows: np.ndarray) -> np.ndarray:
        squared = cdist(self.sites[rows], self.sites[rows[0] :], "sqeuclidean")
        values = valid.quiet_evaluate(self.kernel.of_squared, squared)
        return within_range(values, f"values of {self.kernel!r}")

    def values(self, x: np.ndarray) -> Iterator[tuple[slice, Block]]:
        """Parts of the sites, and the kernel at the queries (m, d) from them."""
        for part in tiles(len(self.sites)):
            yield part, self.kernel.of_squared(cdist(x, self.sites[part], "sqeuclidean"))

    def gradients(self, x: np.ndarray) -> Iterator[tuple[slice, tuple[Block, ...]]]:
        """Parts of the sites, and d matrices of derivatives of the kernel at the queries."""
        for part in tiles(len(self.sites)):
            squared = cdist(x, self.sites[part], "sqeuclidean")
            slope = self.kernel.slope_of_squared(squared)
            yield (
                part,
                tuple(slope * (x[:, k, None] - self.sites[part, k]) for k in range(x.shape[1])),
            )

    def hessians(self, x: np.ndarray) -> Iterator[tuple[slice, tuple[Block, ...]]]:
        """Parts of the sites, and the second derivatives, d (d + 1)/2 matrices by `upper_pairs`."""
        for part in tiles(len(self.sites)):
            offsets = [x[:, k, None] - self.sites[part, k] for k in range(x.shape[1])]
            yield part, second_derivatives(self.kernel, offsets)

    def laplacians(self, x: np.ndarray) -> Iterator[tuple[slice, Block]]:
        """Parts of the sites, and the Laplacian of the kernel at the queries."""
        for part in tiles(len(self.sites)):
            squared = cdist(x, self.sites[part], "sqeuclidean")
            yield part, laplacian(self.kernel, squared, x.shape[1])

    def bytes_per_query(self) -> float:
        """Working memory of one query."""
        return 64.0 * min(TILE, len(self.sites))


def pairs_of(sites: np.ndarray, kernel: Radial) -> AllPairs | NearPairs:
    """Near pairs if the factor of their sparse system is the smaller one, else all pairs."""
    n, d = sites.shape
    if kernel.order == 0 and math.isfinite(kernel.support):
        near = NearPairs(sites, kernel)
        if entries_of_factor(near.pairs, n, d) < n * n / 2:
            return near
    return AllPairs(sites, kernel)


def dense(block: Block) -> np.ndarray:
    """The block as an array."""
    return block if isinstance(block, np.ndarray) else block.toarray()
