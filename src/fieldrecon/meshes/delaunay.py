"""Delaunay cells that form a mesh: no flat cells, and no point left out, even with degeneracies.

Qhull breaks ties by flat cells: if five points or more lie on an empty sphere, four of them in one
plane may become a cell of volume zero, and leaving it out makes a crack. Here ties are broken by
perturbing the heights of the points on the paraboloid; no cell below the lifted hull is flat.
"""

from __future__ import annotations

import math

import numpy as np
from scipy import sparse
from scipy.spatial import ConvexHull, Delaunay, KDTree, QhullError

from fieldrecon._core.duplicates import refuse_coincident
from fieldrecon.meshes import simplices
from fieldrecon.meshes.exact_delaunay import exact_delaunay_cells

_TIE = 1e-5
"""Perturbation that breaks ties, in squares of the distance to the nearest point."""

_VIOLATION = 1e-3
"""Relative violation of the empty sphere that rounding of points of one scale does not reach."""

_THIN = 1e-10
"""Thickness in extents up to which Qhull's rounding hides cells at the hull: some 1e-9 of it."""

_CRACK = 1e-7
"""Relative excess of the boundary over the hull that rounding explains."""

_LOST = 1e-9
"""Part of the volume that may be left out with flat cells at the hull."""

_TINY = (1e-16, 1e-14, 1e-12)
"""Parts of the volume of cells that are taken for flat if there is no mesh otherwise."""


def delaunay_cells(points: np.ndarray, by_exact_signs: bool = False) -> np.ndarray:
    """Vertices (c, d + 1) of the Delaunay cells of points (n, d), d = 2 or 3.

    Cells at the hull that are flat within the rounding of the coordinates are left out. Exact signs
    decide where Qhull's rounding loses a point or a part of the volume, or everywhere if this is
    asked for.

    Raises
    ------
    ValueError
        If there are too few points, or two of them coincide.
    numpy.linalg.LinAlgError
        If all points lie on one line or plane, or the mesh has cracks without its flat cells.
    OverflowError
        If the extent of the points exceeds the range of floating-point numbers.
    """
    _refuse_too_few(points)
    refuse_coincident(points, "points must be distinct; these coincide: {pairs}")
    local = _in_local_frame(points)
    if by_exact_signs or _is_thin(local):
        return _cells_by_exact_signs(points)
    try:
        cells = _cells_without_flat_ones(points, local)
    except (QhullError, np.linalg.LinAlgError):  # its first simplex was flat, or there are cracks
        cells = np.empty((0, points.shape[1] + 1), dtype=int)
    if len(np.unique(cells)) < len(points):  # rounding hid some
        cells = _cells_by_exact_signs(points)
    return cells


def _cells_by_exact_signs(points: np.ndarray) -> np.ndarray:
    """Cells by integer arithmetic, for which Qhull's rounding is too large."""
    ties = _TIE * KDTree(points).query(points, k=2)[0][:, 1] ** 2
    above = ties * np.random.default_rng(0).random(len(points))
    for heights in (None, above):
        cells, neighbors = exact_delaunay_cells(points, heights)
        if len(cells) == 0 or _outer(neighbors, _flat_within_rounding(points, cells)).all():
            raise np.linalg.LinAlgError(
                f"no mesh: the points lie on one {_flat_shape(points)} within rounding"
            )
        outer = _left_out(points, cells, neighbors)
        if outer is not None:
            return cells[~outer]
    uncertain = simplices.signed_volumes(points.take(cells, axis=0))[2]
    outer = _outer(neighbors, uncertain)
    i = int(np.argmax(uncertain & ~outer)) if (uncertain & ~outer).any() else int(np.argmax(outer))
    raise np.linalg.LinAlgError(
        f"no mesh: the points {cells[i].tolist()} lie so nearly on one "
        f"{_flat_shape(points)} that floating-point numbers do not decide the sign of their cell; "
        "merge or remove points"
    )


def _flat_shape(points: np.ndarray) -> str:
    return "line" if points.shape[1] == 2 else "plane"


def _left_out(points: np.ndarray, cells: np.ndarray, neighbors: np.ndarray) -> np.ndarray | None:
    """Flat cells at the hull without which the mesh is whole, and the sign of each cell certain.

    They are flat within the rounding of the coordinates. If a point or a part of the volume is lost
    with them, they are only those whose sign the computation of a volume does not find. But such a
    cell can lie behind one that is less flat; then tiny cells are left out as well.
    """
    corners = points.take(cells, axis=0)
    uncertain = simplices.signed_volumes(corners)[2]
    parts = _parts_of_the_volume(corners)
    for flat in (
        _flat_within_rounding(points, cells),
        uncertain,
        *(uncertain | (parts <= t) for t in _TINY),
    ):
        outer = _outer(neighbors, flat)
        kept = cells[~outer]
        whole = len(np.unique(kept)) == len(points) and parts[outer].sum() <= _LOST
        if whole and not (uncertain & ~outer).any():
            return outer
    return None


def _parts_of_the_volume(corners: np.ndarray) -> np.ndarray:
    """Volume (c,) of each cell (c, d + 1, d), divided by their sum."""
    edges = corners[:, 1:] - corners[:, :1]
    volumes = simplices.volumes(edges / np.abs(edges).max())
    return volumes / volumes.sum()


def _in_local_frame(points: np.ndarray) -> np.ndarray:
    with np.errstate(over="ignore", invalid="ignore"):
        offsets = points - points.mean(axis=0)
        extent = np.ptp(points, axis=0).max()
    if not np.isfinite(extent) or not np.isfinite(offsets).all():
        raise OverflowError("the extent of the points exceeds the range of floating-point numbers")
    return offsets / extent


def _is_thin(local: np.ndarray) -> bool:
    """Whether the points are so near to a line or plane that cells may be lost unnoticed."""
    sizes = np.linalg.svd(local, compute_uv=False)
    return bool(sizes[-1] < _THIN * sizes[0])


def _cells_without_flat_ones(points: np.ndarray, local: np.ndarray) -> np.ndarray:
    """Cells by Qhull without the flat ones at the hull; none if its rounding made them wrong."""
    triangulation = Delaunay(local)
    cells, neighbors = triangulation.simplices, triangulation.neighbors
    if (cells >= len(points)).any():  # Qhull's point at infinity
        return cells[:0]
    flat = _flat_within_rounding(points, cells)
    if flat.any() and points.shape[1] == 3:  # in the plane, ties make no flat cells
        cells, neighbors = _tie_broken(local)
        flat = _flat_within_rounding(points, cells)
    elif _violations(local, cells, neighbors, ~flat).max(initial=0.0) > _VIOLATION:
        return cells[:0]
    if not flat.any():
        return cells
    outer = _left_out(points, cells, neighbors)
    if outer is None:
        return cells[:0]
    _refuse_cracks(local, cells, ~outer & ((neighbors < 0) | outer[neighbors]).T)
    return cells[~outer]


def _violations(
    points: np.ndarray, cells: np.ndarray, neighbors: np.ndarray, sure: np.ndarray
) -> np.ndarray:
    """How far the vertex opposite to each inner face is inside the sphere of the cell behind it.

    It is the determinant of the lifted cell, relative to the product of its column sums; only for
    `sure` cells, whose orientation is known.
    """
    found = []
    for k in range(cells.shape[1]):
        cell = np.flatnonzero((neighbors[:, k] > np.arange(len(cells))) & sure)
        cell = cell[sure[neighbors[cell, k]]]
        others = np.delete(cells[cell], k, axis=1).sum(axis=1)
        opposite = cells[neighbors[cell, k]].sum(axis=1) - others
        e = points[cells[cell]] - points[opposite][:, None]
        e /= np.abs(e).max(axis=(1, 2), keepdims=True)
        height = np.einsum("mki,mki->mk", e, e)
        minors = np.stack(
            [
                (-1) ** j * simplices.determinants(np.delete(e, j, axis=1))
                for j in range(cells.shape[1])
            ],
            axis=1,
        )  # their sum is the volume of the cell
        inside = np.sign(minors.sum(axis=1)) * (height * minors).sum(axis=1)
        size = np.abs(e).sum(axis=1).prod(axis=1) * height.sum(axis=1)
        found.append(inside / size)
    return np.concatenate(found)


def _flat_within_rounding(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Whether a change of the coordinates by their rounding could invert each cell."""
    rounding = np.finfo(float).eps * np.abs(points).max()
    return simplices.signed_volumes(points.take(cells, axis=0), rounding)[2]


def _outer(neighbors: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """Whether each cell is flat and connected with the outside through flat cells."""
    outside = len(neighbors)
    one, k = np.nonzero(np.broadcast_to(flat[:, None], neighbors.shape))
    two = neighbors[one, k]
    joined = (two < 0) | flat[two]
    pairs = (np.ones(joined.sum()), (one[joined], np.where(two < 0, outside, two)[joined]))
    graph = sparse.coo_array(pairs, shape=(outside + 1, outside + 1))
    part = sparse.csgraph.connected_components(graph, directed=False)[1]
    return part[:-1] == part[outside]


def _tie_broken(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cells and their neighbours below the hull of the points lifted to |x|², a little above it."""
    spacing = KDTree(points).query(points, k=2)[0][:, 1]
    above = _TIE * spacing**2 * np.random.default_rng(0).random(len(points))
    hull = ConvexHull(np.column_stack([points, (points**2).sum(axis=1) + above]))
    below = hull.equations[:, -2] < 0
    number = np.where(below, np.cumsum(below) - 1, -1)
    return hull.simplices[below], number[hull.neighbors[below]]


def _refuse_too_few(points: np.ndarray) -> None:
    n, d = points.shape
    if n <= d:
        raise ValueError(f"points must be at least {d + 1} for a mesh in {d} dimensions; got {n}")


def _refuse_cracks(points: np.ndarray, cells: np.ndarray, open_sides: np.ndarray) -> None:
    """Refuse cells whose boundary, their `open_sides` (d + 1, c), is larger than the hull."""
    d = points.shape[1]
    faces = np.concatenate([np.delete(cells[side], k, axis=1) for k, side in enumerate(open_sides)])
    edges = points[faces[:, 1:]] - points[faces[:, :1]]
    area = simplices.volumes(edges).sum() / math.factorial(d - 1)
    if area > (1 + _CRACK) * ConvexHull(points).area:
        raise np.linalg.LinAlgError(
            "no mesh: some points coincide, or lie on one line or plane, within rounding, which "
            "makes flat cells between others"
        )
