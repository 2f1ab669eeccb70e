"""Points of a mesh; cells as distinct indices of them, not flat, and positively oriented."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon import _simplices as simplices
from fieldrecon import _validation as valid


def as_plane_or_space(points: ArrayLike) -> np.ndarray:
    """Points in two or three dimensions."""
    p = valid.as_points(points)
    if p.shape[1] not in (2, 3):
        raise ValueError(f"points must have the shape (n, 2) or (n, 3); got {p.shape}")
    return p


def as_cells(cells: ArrayLike, n: int, d: int) -> np.ndarray:
    """Cells as an array of their own, with d + 1 different indices below n each."""
    kind = "triangles" if d == 2 else "tetrahedra"
    try:
        given = np.asarray(cells)
    except ValueError:
        raise ValueError(f"cells must be {kind}; the rows differ in length") from None
    if given.dtype.kind not in "iu":
        raise ValueError(f"cells must be integers; got the type {given.dtype}")
    if given.ndim != 2 or given.shape[1] != d + 1 or len(given) == 0:
        raise ValueError(f"cells must be {kind}, shape (c, {d + 1}); got {given.shape}")
    outside = (given < 0) | (given >= n)
    if outside.any():
        i, k = map(int, np.argwhere(outside)[0])
        raise ValueError(f"cells must index {n} points; cells[{i}, {k}] is {given[i, k]}")
    ordered = np.sort(given, axis=1)
    repeats = (ordered[:, 1:] == ordered[:, :-1]).any(axis=1)
    if repeats.any():
        i = int(np.argmax(repeats))
        raise ValueError(f"cells must have distinct vertices; cells[{i}] is {given[i].tolist()}")
    return given.astype(np.intp)


def positive(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """The cells, the last two vertices exchanged where the orientation is negative."""
    with np.errstate(over="ignore", invalid="ignore"):
        volumes, _, flat = simplices.signed_volumes(points.take(cells, axis=0))
    if not np.isfinite(volumes).all():
        i = int(np.argmin(np.isfinite(volumes)))
        raise OverflowError(f"the size of cell {i} exceeds the range of floating-point numbers")
    if flat.any():
        i = int(np.argmax(flat))
        where = "line" if points.shape[1] == 2 else "plane"
        others = f"; so are {flat.sum() - 1} others" if flat.sum() > 1 else ""
        raise ValueError(
            f"cells must not be flat; cell {i} is: its vertices {cells[i].tolist()} lie on one "
            f"{where} within rounding{others}"
        )
    negative = volumes < 0
    cells[negative, -2:] = cells[negative, :-3:-1]
    return cells
