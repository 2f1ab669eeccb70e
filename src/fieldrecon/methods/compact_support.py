"""Sparse kernel matrices of kernels of compact support, and their sparse factorization."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from fieldrecon._core.chunks import Progress
from fieldrecon._numerics.saddle_point import SparseSaddlePoint, entries_of_factor
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.derivatives import laplacian, second_derivatives
from fieldrecon.methods.solvability import refuse_beyond_memory


class NearPairs:
    """Sparse kernel matrices of queries with the sites within the support of the kernel.

    Parameters
    ----------
    sites : (n, d) ndarray
        Centres.
    kernel : Radial
        Positive definite kernel of compact support, in the sites' unit of length.
    """

    def __init__(self, sites: np.ndarray, kernel: Radial) -> None:
        self.sites, self.kernel = sites, kernel
        self._tree = cKDTree(sites)
        self.pairs = int(self._tree.count_neighbors(self._tree, kernel.support))

    def system(
        self,
        p: np.ndarray,
        smoothing: np.ndarray,
        executor: Executor | None = None,  # noqa: ARG002 - as for all pairs
        progress: Progress | None = None,  # noqa: ARG002
    ) -> SparseSaddlePoint:
        """Factored sparse system of the kernel between all sites, smoothed and bordered by P."""
        n, d = self.sites.shape
        refuse_beyond_memory(n, entries_of_factor(self.pairs, n, d))
        ((_, a),) = self.values(self.sites)
        return SparseSaddlePoint((a + sparse.diags_array(smoothing)).tocsc(), p)

    def values(self, x: np.ndarray) -> Iterator[tuple[slice, sparse.csr_array]]:
        """All sites, and the kernel at the queries (m, d) from them."""
        i, j, _, squared = self._near(x)
        yield slice(None), self._matrix(i, j, self.kernel.of_squared(squared), len(x))

    def gradients(self, x: np.ndarray) -> Iterator[tuple[slice, tuple[sparse.csr_array, ...]]]:
        """All sites, and d matrices of derivatives of the kernel at the queries."""
        i, j, offsets, squared = self._near(x)
        slope = self.kernel.slope_of_squared(squared)
        yield (
            slice(None),
            tuple(self._matrix(i, j, slope * offsets[:, k], len(x)) for k in range(x.shape[1])),
        )

    def hessians(self, x: np.ndarray) -> Iterator[tuple[slice, tuple[sparse.csr_array, ...]]]:
        """All sites, and the second derivatives, d (d + 1)/2 matrices by `upper_pairs`."""
        i, j, offsets, _ = self._near(x)
        entries = second_derivatives(self.kernel, list(offsets.T))
        yield slice(None), tuple(self._matrix(i, j, entry, len(x)) for entry in entries)

    def laplacians(self, x: np.ndarray) -> Iterator[tuple[slice, sparse.csr_array]]:
        """All sites, and the Laplacian of the kernel at the queries."""
        i, j, _, squared = self._near(x)
        yield slice(None), self._matrix(i, j, laplacian(self.kernel, squared, x.shape[1]), len(x))

    def bytes_per_query(self) -> float:
        """Working memory of one query among the sites."""
        return 64.0 * (3 + self.sites.shape[1]) * self.pairs / len(self.sites)

    def _near(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Query, site, offset and squared distance of each near pair."""
        found = cKDTree(x).sparse_distance_matrix(
            self._tree, self.kernel.support, output_type="ndarray"
        )
        i, j = found["i"], found["j"]
        offsets = x[i] - self.sites[j]
        return i, j, offsets, np.einsum("ij,ij->i", offsets, offsets)

    def _matrix(
        self, i: np.ndarray, j: np.ndarray, entries: np.ndarray, m: int
    ) -> sparse.csr_array:
        return sparse.csr_array((entries, (i, j)), shape=(m, len(self.sites)))
