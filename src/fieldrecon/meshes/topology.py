"""Faces of many cells, with the cells on both sides and the outward orientation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

_OUTWARD = {
    2: np.array([[1, 2], [2, 0], [0, 1]]),
    3: np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]),
}
"""Corners of the face opposite each corner of a positive simplex, as seen from outside."""


@dataclass(frozen=True)
class Topology:
    """Faces of the cells, and cells at the faces.

    Parameters
    ----------
    faces : (f, d) ndarray
        Vertices of each face, increasing; the faces in lexicographic order.
    face_cells : (f, 2) ndarray
        The cells at each face, the lower first; -1 for none.
    cell_faces : (c, d + 1) ndarray
        Faces of each cell, the k-th opposite its k-th vertex.
    signs : (f,) ndarray
        1 if the vertices in increasing order have the outward orientation of the first cell,
        otherwise -1.
    """

    faces: np.ndarray
    face_cells: np.ndarray
    cell_faces: np.ndarray
    signs: np.ndarray


def topology(cells: np.ndarray, n: int) -> Topology:
    """Faces of positive simplices (c, d + 1) on n points.

    Raises
    ------
    ValueError
        If more than two cells share a face, or two on the same side of it.
    """
    d = cells.shape[1] - 1
    sides = cells[:, _OUTWARD[d]].reshape(-1, d)
    even = _sorted_by_even_permutation(sides)
    sides = np.sort(sides, axis=1)
    order = _lexicographic_order(sides, n)
    sides = sides.take(order, axis=0)
    start = np.flatnonzero(_first_of_equals(sides))
    count = np.diff(start, append=len(order))
    faces = sides.take(start, axis=0)
    _refuse_crowded(faces, count, order // (d + 1), start)

    cell_faces = np.empty(len(order), dtype=np.intp)
    cell_faces[order] = np.repeat(np.arange(len(faces)), count)
    second = order[start + count - 1]  # the first again on the boundary
    one, two = np.minimum(order[start], second), np.maximum(order[start], second)
    inside = count == 2
    face_cells = np.column_stack([one // (d + 1), np.where(inside, two // (d + 1), -1)])
    _refuse_overlap(faces, face_cells, inside & (even[one] == even[two]))
    return Topology(faces, face_cells, cell_faces.reshape(-1, d + 1), np.where(even[one], 1, -1))


def incidence(groups: np.ndarray, n: int) -> sparse.csr_array:
    """Ones (n, m) where an index below n occurs in a group, (m, k)."""
    m, k = groups.shape
    ones = np.ones(m * k, dtype=np.int32)
    pointer = np.arange(0, m * k + 1, k)
    return sparse.csr_array(sparse.csc_array((ones, groups.ravel(), pointer), shape=(n, m)))


def pattern(matrix: sparse.csr_array) -> sparse.csr_array:
    """Ones where a matrix has entries, columns in order."""
    ones = np.ones(matrix.nnz, dtype=np.int32)
    result = sparse.csr_array((ones, matrix.indices, matrix.indptr), shape=matrix.shape)
    result.sort_indices()
    return result


def _sorted_by_even_permutation(rows: np.ndarray) -> np.ndarray:
    """Whether an even number of exchanges sorts each row of two or three."""
    odd = rows[:, 0] > rows[:, 1]
    if rows.shape[1] == 3:
        odd = odd ^ (rows[:, 0] > rows[:, 2]) ^ (rows[:, 1] > rows[:, 2])
    return ~odd


def _lexicographic_order(rows: np.ndarray, n: int) -> np.ndarray:
    """Lexicographic order of rows of numbers below n."""
    if n ** rows.shape[1] >= 2**63:
        return np.lexsort(rows.T[::-1])
    key = rows[:, 0]
    for column in rows.T[1:]:
        key = key * n + column
    return np.argsort(key)


def _first_of_equals(ordered: np.ndarray) -> np.ndarray:
    """Whether each row differs from the previous row."""
    differs = (ordered[1:] != ordered[:-1]).any(axis=1)
    return np.concatenate([[True], differs])


def _refuse_crowded(
    faces: np.ndarray, count: np.ndarray, cell: np.ndarray, start: np.ndarray
) -> None:
    if count.max() > 2:
        f = int(np.argmax(count > 2))
        shared = sorted(cell[start[f] : start[f] + count[f]].tolist())
        raise ValueError(
            f"at most two cells may meet at a face; the face {faces[f].tolist()} belongs to the "
            f"cells {', '.join(map(str, shared))}"
        )


def _refuse_overlap(faces: np.ndarray, face_cells: np.ndarray, folded: np.ndarray) -> None:
    if folded.any():
        f = int(np.argmax(folded))
        i, j = face_cells[f].tolist()
        raise ValueError(
            f"cells must not overlap; the cells {i} and {j} lie on the same side of their common "
            f"face {faces[f].tolist()}"
        )
