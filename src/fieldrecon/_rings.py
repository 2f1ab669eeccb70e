"""Fits about many vertices at once: their data lie on the cells around, ring by ring.

The first ring of a vertex is its cells, each further one the cells of their vertices. A fit takes
the first ring that determines it, for each vertex.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from fieldrecon._chunks import chunked, rows_of
from fieldrecon._estimable import LARGEST_WEIGHT
from fieldrecon._stars import LocalWeights, Stars
from fieldrecon.mesh import SimplexMesh

WELL_DETERMINED = 10.0
"""Data errors of norm one that change the result by more than this ask for one more ring."""

BLOCK = 2**17
"""Vertices whose neighbourhoods are held in memory at once."""


Fit = Callable[[Stars], LocalWeights]


def as_vertices(mesh: SimplexMesh, vertices: ArrayLike | None) -> np.ndarray:
    """Indices of vertices, all points by default; one that no cell has is refused."""
    n = len(mesh.points)
    i = np.arange(n) if vertices is None else np.asarray(vertices)
    if i.ndim != 1 or (i.size and i.dtype.kind not in "iu"):
        raise ValueError(
            f"vertices must be a list of indices, shape (m,); got {i.dtype} of shape {i.shape}"
        )
    i = i.astype(np.intp)
    wrong = i[(i < 0) | (i >= n)]
    if len(wrong):
        raise ValueError(f"vertices must index the {n} points, 0 to {n - 1}; got {wrong[0]}")
    alone = i[~mesh.referenced[i]]
    if len(alone):
        raise np.linalg.LinAlgError(
            f"point {alone[0]} belongs to no cell, so there are no data about it; name the "
            "vertices that are wanted, for instance vertices=numpy.flatnonzero(mesh.referenced)"
        )
    return i


def ring_weights(
    mesh: SimplexMesh,
    sites_of_cells: sparse.csr_array | None,
    vertices: np.ndarray,
    fit: Fit,
    results: int,
    what: tuple[str, str],
) -> tuple[tuple[sparse.csr_array, ...], np.ndarray]:
    """Weights of the data in the results at vertices, from the first ring that determines them.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh.
    sites_of_cells : (c, s) sparse array or None
        Which sites each cell has; None where the sites are the cells.
    vertices : (m,) ndarray of int
        The vertices.
    fit : Fit
        The fit.
    results : int
        How many numbers the fit makes at each vertex.
    what : (str, str)
        What the sites are and what is sought, for the error: "faces", "its velocity".

    Returns
    -------
    weights : tuple of (m, s) csr_array
        One matrix for each result.
    rings : (m,) ndarray of int
        How many rings each vertex took.

    Raises
    ------
    numpy.linalg.LinAlgError
        If all the rings there are do not determine a result.
    """
    touching = mesh.vertex_cell_incidence.astype(bool)
    cells = touching[vertices]
    pending = np.arange(len(vertices))
    rings = np.zeros(len(vertices), dtype=int)
    before = np.zeros(len(vertices), dtype=int)
    parts: list[tuple[np.ndarray, list[sparse.csr_array]]] = []
    while not parts or len(pending):
        rings[pending] += 1
        sites = cells if sites_of_cells is None else cells @ sites_of_cells
        matrices, amplification, counted = _fitted(sites, vertices[pending], fit, results)
        exhausted = counted == before
        done = amplification <= np.where(exhausted, LARGEST_WEIGHT, WELL_DETERMINED)
        rings[pending[done & exhausted]] -= 1  # the ring before had the same sites
        if (exhausted & ~done).any():
            i = int(np.flatnonzero(exhausted & ~done)[0])
            raise np.linalg.LinAlgError(
                f"the {counted[i]} {what[0]} that count about vertex {vertices[pending[i]]} do not "
                f"determine {what[1]}, and wider rings have no more"
            )
        parts.append((pending[done], [w[done] for w in matrices]))
        pending, before, cells = pending[~done], counted[~done], cells[~done]
        cells = (cells @ touching.T) @ touching
    return _in_order(parts, results), rings


def _in_order(
    parts: list[tuple[np.ndarray, list[sparse.csr_array]]], results: int
) -> tuple[sparse.csr_array, ...]:
    place = np.argsort(np.concatenate([rows for rows, _ in parts]))
    stacked = (sparse.vstack([w[r] for _, w in parts], format="csr") for r in range(results))
    return tuple(sparse.csr_array(w[place]) for w in stacked)


def _fitted(
    sites: sparse.csr_array, vertices: np.ndarray, fit: Fit, results: int
) -> tuple[list[sparse.csr_array], np.ndarray, np.ndarray]:
    """One fit for each row of `sites`: its weights, amplification and number of sites."""
    start, counts = sites.indptr[:-1], np.diff(sites.indptr)
    data = np.empty((results, sites.nnz))
    amplification = np.empty(len(vertices))
    counted = np.empty(len(vertices), dtype=int)

    def work(rows: np.ndarray) -> np.ndarray:
        place = np.arange(counts[rows].max(initial=1))
        there = place < counts[rows, None]
        place = np.where(there, start[rows, None] + place, 0)
        local = fit(Stars(vertices[rows], sites.indices[place], there))
        for r in range(results):
            data[r, place[there]] = local.weights[:, r][there]
        amplification[rows], counted[rows] = local.amplification, local.counted
        return rows

    # those with as many sites lie together, so that little is padded
    order = np.argsort(counts, kind="stable")
    size = int(counts.mean()) + 1 if len(counts) else 1
    for _ in chunked(work, order, rows_of(8 * size * 24)):
        pass
    shape = sites.shape
    return (
        [sparse.csr_array((row, sites.indices, sites.indptr), shape=shape) for row in data],
        amplification,
        counted,
    )
