"""Places where a field is wanted: a grid, the points of a table, or the vertices of a mesh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fieldrecon.io.meshes import read_mesh, read_surface
from fieldrecon.io.tables import BadRow, Wanted, read_table

NODES = 4e8
"""Most nodes of a grid: beyond, its files alone are larger than the memory of most machines."""


@dataclass(frozen=True, eq=False)
class Places:
    """Places, and how they hang together.

    Parameters
    ----------
    points : ndarray of shape (m, d)
    axes : tuple of ndarray
        Coordinates along x, y and z, if the places are the nodes of a grid, x fastest.
    cells : ndarray of shape (c, corners), optional
        Triangles or tetrahedra of a mesh, whose vertices the places are.
    bad : tuple of BadRow
        Rows of the table that were no points.
    """

    points: np.ndarray
    axes: tuple[np.ndarray, ...] = ()
    cells: np.ndarray | None = None
    bad: tuple[BadRow, ...] = ()

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the values: (rows, columns) of a grid in the plane."""
        return tuple(len(axis) for axis in reversed(self.axes)) or (len(self.points),)

    @property
    def kind(self) -> str:
        """What they are, in a word."""
        return "nodes" if self.axes else "points" if self.cells is None else "vertices"


def grid_over(points: np.ndarray, counts: Sequence[int], lonlat: bool = False) -> Places:
    """Lay a grid over the points (n, d), as wide and as high as they are.

    Longitudes start after the widest gap between them, so that data about the date line have one
    grid across it, whose longitudes may exceed 180.

    Raises
    ------
    ValueError
        If there is not one count for each coordinate, or too many nodes.

    Examples
    --------
    >>> grid = grid_over(np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]]), (3, 2))
    >>> [axis.tolist() for axis in grid.axes], grid.shape
    ([[0.0, 1.0, 2.0], [0.0, 1.0]], (2, 3))
    >>> grid_over(np.array([[170.0, 0.0], [-170.0, 5.0]]), (3, 2), lonlat=True).axes[0].tolist()
    [170.0, 180.0, 190.0]
    """
    d = points.shape[1]
    if len(counts) != d:
        sides = "x".join(map(str, counts))
        raise ValueError(f"a grid in {d} variables has {d} sides; got --grid {sides}")
    if np.prod(np.array(counts, dtype=float)) > NODES:
        raise ValueError(
            f"a grid must have at most {NODES:.0e} nodes; got {'x'.join(map(str, counts))}"
        )
    if lonlat:
        points = np.column_stack([_unrolled(points[:, 0]), points[:, 1]])
    low, high = points.min(axis=0), points.max(axis=0)
    axes = tuple(np.linspace(*side) for side in zip(low, high, counts, strict=True))
    return Places(nodes_of(axes), axes)


def nodes_of(axes: Sequence[np.ndarray]) -> np.ndarray:
    """Return the points (m, d) of the grid over the axes, the first of which runs fastest."""
    nodes = np.meshgrid(*reversed(axes), indexing="ij")
    return np.stack(nodes[::-1], axis=-1).reshape(-1, len(axes))


def points_in(
    path: Path, names: Sequence[str], lonlat: bool = False, strict: bool = False
) -> Places:
    """Read places from the columns of these names of a table; bad rows are left out, and kept told.

    Raises
    ------
    ValueError
        If a column is missing, no row is good, or, if strict, one is not: with its line.
    """

    def choose(columns: list[str]) -> list[int]:
        for name in names:
            if name not in columns:
                have = ", ".join(columns)
                raise ValueError(
                    f"{path} has no column {name!r}, as the samples have; it has {have}"
                )
        return [columns.index(name) for name in names]

    limits = (np.inf, 90.0) if lonlat else (np.inf,) * len(names)
    table = read_table(path, Wanted(choose, limits))
    if table.bad and (strict or not len(table.numbers)):
        raise ValueError(f"{path}, line {table.bad[0].line}: {table.bad[0].reason}")
    return Places(table.numbers, bad=tuple(table.bad))


def vertices_of(path: Path, d: int) -> Places:
    """Read a mesh, whose vertices are the places: of triangles, or of tetrahedra in space.

    Raises
    ------
    ValueError
        If there is no such mesh in d variables.
    ImportError
        If meshio is not installed.
    """
    try:
        mesh = read_mesh(path)
        if mesh.points.shape[1] == d:
            return Places(mesh.points, cells=mesh.cells)
        reason = f"{path} is a mesh in {mesh.points.shape[1]} variables; the samples have {d}"
    except ValueError as error:
        reason = str(error)
    if d != 3:
        raise ValueError(reason)
    points, triangles = read_surface(path)
    return Places(points, cells=triangles)


def _unrolled(longitudes: np.ndarray) -> np.ndarray:
    """Longitudes that start after the widest gap between them, in [-180, 180)."""
    ordered = np.unique(longitudes % 360)
    gaps = np.diff(ordered, append=ordered[0] + 360)
    widest = int(gaps.argmax())
    cut = ordered[widest] + gaps[widest] / 2
    unrolled = cut + (longitudes - cut) % 360
    return unrolled - 360 * np.floor((unrolled.min() + 180) / 360)
