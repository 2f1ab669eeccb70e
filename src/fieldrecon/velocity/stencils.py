"""Stencils: sites about many vertices at once, in rings of cells, and local fits on them.

The first ring of a vertex is its cells, and each further ring the cells of their vertices. For each
vertex, a fit takes the first rings that determine its result.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from fieldrecon._core.chunks import chunked, rows_of
from fieldrecon._numerics.weighted_least_squares import LARGEST_WEIGHT
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.weights import relative_weights
from fieldrecon.meshes.simplex_mesh import SimplexMesh, as_indices_of_points
from fieldrecon.polynomials import EPS, power_of_two_above

WELL_DETERMINED = 10.0
"""Amplification of data errors beyond which a fit takes one more ring."""

BLOCK = 2**17
"""Number of vertices whose neighbourhoods are held in memory at once."""


@dataclass(frozen=True)
class Stencils:
    """Sites about a batch of m vertices, at most k of them each.

    Attributes
    ----------
    positions : (m,) ndarray of int
        Positions in the list of vertices.
    vertices : (m,) ndarray of int
        The vertices.
    index : (m, k) ndarray of int
        Sites (faces or cells) about each.
    there : (m, k) ndarray of bool
        Whether there is a site.
    """

    positions: np.ndarray
    vertices: np.ndarray
    index: np.ndarray
    there: np.ndarray

    def subset(self, chosen: np.ndarray) -> Stencils:
        """The stencils of the chosen vertices."""
        kept = (part[chosen] for part in (self.positions, self.vertices, self.index, self.there))
        return Stencils(*kept)


@dataclass(frozen=True)
class LocalWeights:
    """Result of a fit on a batch of stencils.

    Attributes
    ----------
    weights : (m, r, k) ndarray
        Weights of the data in each of the r results; nan where these are not determined.
    amplification : (m,) ndarray
        Change of the results by errors of norm one of the data, in units in which both have size
        one; infinite where they are not determined.
    counted : (m,) ndarray of int
        Number of sites that take part in the fit.
    """

    weights: np.ndarray
    amplification: np.ndarray
    counted: np.ndarray


Fit = Callable[[Stencils], LocalWeights]


Accumulate = Callable[[np.ndarray, Stencils, np.ndarray], None]
"""Receives positions in the list of vertices, their stencils, and their weights (m, r, k)."""


def fit_on_rings(
    mesh: SimplexMesh,
    sites_of_cells: sparse.csr_array | None,
    vertices: np.ndarray,
    fit: Fit,
    accumulate: Accumulate,
    names: tuple[str, str],
) -> np.ndarray:
    """Fit at vertices, each on the data of the first rings that determine the result.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh.
    sites_of_cells : (c, s) sparse array or None
        Incidence of cells and sites; None if the sites are the cells.
    vertices : (m,) ndarray of int
        The vertices.
    fit : Fit
        The fit.
    accumulate : callable
        Called with the weights, batch by batch, from several threads; each vertex once.
    names : (str, str)
        Names of the sites and of the result for the error message: "faces", "its velocity".

    Returns
    -------
    (m,) ndarray of int
        Number of rings of each vertex.

    Raises
    ------
    numpy.linalg.LinAlgError
        If all rings together do not determine a result.
    """
    touching = mesh.vertex_cell_incidence.astype(bool)
    incidences = _Incidences(
        touching,
        touching.T.tocsr(),
        None if sites_of_cells is None else sites_of_cells.astype(bool),
    )
    rings = np.zeros(len(vertices), dtype=int)
    for start in range(0, len(vertices), BLOCK):
        positions = np.arange(start, min(start + BLOCK, len(vertices)))
        _fit_block(incidences, vertices, positions, rings, fit, accumulate, names)
    return rings


class MatrixOfWeights:
    """Accumulates weights in a sparse matrix (m, s) for each result."""

    def __init__(self, results: int, shape: tuple[int, int]) -> None:
        self.results, self.shape = results, shape
        self.counts = np.zeros(shape[0], dtype=np.intp)
        self.parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def __call__(self, positions: np.ndarray, stencils: Stencils, weights: np.ndarray) -> None:
        """Accumulate a batch."""
        self.counts[positions] = np.count_nonzero(stencils.there, axis=1)
        data = np.moveaxis(weights, 1, 0)[:, stencils.there]
        self.parts.append((positions, stencils.index[stencils.there], data))

    def matrices(self) -> tuple[sparse.csr_array, ...]:
        """The matrices; batches are released one by one, so that no weight is held twice."""
        pointer = np.concatenate([[0], np.cumsum(self.counts)])
        columns = np.empty(pointer[-1], dtype=np.int32 if self.shape[1] < 2**31 else np.int64)
        data = [np.empty(pointer[-1]) for _ in range(self.results)]
        while self.parts:
            positions, index, weights = self.parts.pop()
            count = self.counts[positions]
            first = np.cumsum(count) - count
            at = np.arange(len(index)) + np.repeat(pointer[positions] - first, count)
            columns[at] = index
            for of_result, w in zip(data, weights, strict=True):
                of_result[at] = w
        parts = ((d, columns.copy(), pointer.copy()) for d in data)
        result = tuple(sparse.csr_array(part, shape=self.shape) for part in parts)
        for matrix in result:
            matrix.sort_indices()
        return result


class ValuesOfWeights:
    """Applies weights to the data (s, v) for results (m, v, r)."""

    def __init__(self, results: int, positions: int, data: np.ndarray) -> None:
        self.data = data
        self.values = np.empty((positions, data.shape[1], results), dtype=data.dtype)

    def __call__(self, positions: np.ndarray, stencils: Stencils, weights: np.ndarray) -> None:
        """Accumulate a batch."""
        weights = np.where(stencils.there[:, None], weights, 0.0)
        of_sites = self.data.take(stencils.index, axis=0)
        self.values[positions] = (weights @ of_sites).mT


def as_vertices(mesh: SimplexMesh, vertices: ArrayLike | None) -> np.ndarray:
    """Indices of vertices, all points by default; a point of no cell is refused."""
    n = len(mesh.points)
    i = np.arange(n) if vertices is None else as_indices_of_points(vertices, n)
    alone = i[~mesh.referenced[i]]
    if len(alone):
        raise np.linalg.LinAlgError(
            f"point {alone[0]} belongs to no cell, so there are no data about it; name the "
            "vertices that are wanted, for instance vertices=numpy.flatnonzero(mesh.referenced)"
        )
    return i


def amplification(c: np.ndarray) -> np.ndarray:
    """Largest change (m,) of the results C f, C (m, r, k), by errors of norm one of the data f."""
    return np.sqrt(np.einsum("mrk,mrk->mr", c, c).max(axis=1))


def scaled_offsets(offset: np.ndarray, there: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Offsets (m, k, d) of the sites in units (m,) of their size, powers of two."""
    # a sum instead of the largest: numpy adds along a short axis in a fraction of the time
    size = np.einsum("mkd,mk->mk", np.abs(offset), there).max(axis=1)
    unit = power_of_two_above(size)
    return offset / unit[:, None, None], unit


def weights_at(
    weight: Radial | None, unit: float, offset: np.ndarray, there: np.ndarray
) -> np.ndarray:
    """Weights (m, k) of sites at offsets (m, k, d), the largest of each vertex one.

    Distances are taken in units of the size of the mesh: no square of them overflows.
    """
    if weight is None:
        return there.astype(np.float64)
    return relative_weights(weight.in_units(unit), np.linalg.norm(offset / unit, axis=2), there)


def number_that_count(w: np.ndarray) -> np.ndarray:
    """Number (m,) of relative weights (m, k) above rounding: the sites that take part in a fit.

    A narrow gaussian gives a tiny weight to every other site.
    """
    return np.count_nonzero(w > EPS, axis=1)


@dataclass(frozen=True)
class _Incidences:
    """Cells of vertices, vertices of cells, and sites of cells unless these are the cells."""

    cells: sparse.csr_array
    vertices: sparse.csr_array
    sites: sparse.csr_array | None


def _fit_block(
    of: _Incidences,
    vertices: np.ndarray,
    pending: np.ndarray,
    rings: np.ndarray,
    fit: Fit,
    accumulate: Accumulate,
    names: tuple[str, str],
) -> None:
    cells = of.cells[vertices[pending]]
    before = np.zeros(len(pending), dtype=int)
    while len(pending):
        rings[pending] += 1
        sites = cells if of.sites is None else cells @ of.sites
        done, counted = _fit_ring(sites, vertices, pending, before, fit, accumulate)
        exhausted = counted == before
        rings[pending[done & exhausted]] -= 1  # the ring before had the same sites
        if (exhausted & ~done).any():
            i = int(np.flatnonzero(exhausted & ~done)[0])
            raise np.linalg.LinAlgError(
                f"the {counted[i]} {names[0]} that count about vertex {vertices[pending[i]]} do "
                f"not determine {names[1]}, and wider rings have no more"
            )
        pending, before, cells = pending[~done], counted[~done], cells[~done]
        cells = (cells @ of.vertices) @ of.cells


def _fit_ring(
    sites: sparse.csr_array,
    vertices: np.ndarray,
    pending: np.ndarray,
    before: np.ndarray,
    fit: Fit,
    accumulate: Accumulate,
) -> tuple[np.ndarray, np.ndarray]:
    """Fit each row of `sites`: whether it is determined, and how many sites take part."""
    start, counts = sites.indptr[:-1], np.diff(sites.indptr)
    done = np.empty(len(pending), dtype=bool)
    counted = np.empty(len(pending), dtype=int)

    def work(rows: np.ndarray) -> np.ndarray:
        column = np.arange(counts[rows].max())
        there = column < counts[rows, None]
        index = sites.indices.take(np.where(there, start[rows, None] + column, 0))
        stencils = Stencils(pending[rows], vertices[pending[rows]], index, there)
        local = fit(stencils)
        # if wider rings have no further sites, any determined result is accepted
        limit = np.where(local.counted == before[rows], LARGEST_WEIGHT, WELL_DETERMINED)
        ok = local.amplification <= limit
        done[rows], counted[rows] = ok, local.counted
        if ok.all():
            accumulate(pending[rows], stencils, local.weights)
        else:
            accumulate(pending[rows[ok]], stencils.subset(ok), local.weights[ok])
        return rows

    # ordered by the number of sites, so that chunks need little padding
    order = np.argsort(counts, kind="stable")
    size = int(counts.mean()) + 1
    for _ in chunked(work, order, rows_of(8 * size * 24)):
        pass
    return done, counted
