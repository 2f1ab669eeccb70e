"""Targets of a reconstruction: a grid, the points of a table, or the vertices of a mesh.

Also the values of a field at them, which the writers of `fieldrecon.io.values` take.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from fieldrecon._core import validation as valid
from fieldrecon.io.frames import Frame, Source, bad_row_message, numbered, read_source
from fieldrecon.io.meshes import read_mesh, read_surface
from fieldrecon.io.tables import BadRow, ColumnSpec, name_and_unit

MAX_NODES = 4e8
"""Largest number of nodes of a grid; its files alone would exceed the memory of most machines."""


@dataclass(frozen=True, eq=False)
class Targets:
    """The points at which a field is evaluated, and their connectivity.

    Parameters
    ----------
    points : ndarray of shape (m, d)
    axes : tuple of ndarray
        Coordinates along x, y and z, if the points are the nodes of a grid; x varies fastest.
    cells : ndarray of shape (c, corners), optional
        Triangles or tetrahedra, if the points are the vertices of a mesh.
    bad : tuple of BadRow
        Skipped rows of the table.
    index : object, optional
        Labels of the rows of a data frame.
    numbered : str
        What the numbers of the skipped rows are: "line" of a file, or "row" in memory, from 0.
    """

    points: np.ndarray
    axes: tuple[np.ndarray, ...] = ()
    cells: np.ndarray | None = None
    bad: tuple[BadRow, ...] = ()
    index: Any = None
    numbered: str = "line"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the values: (rows, columns) of a grid in the plane."""
        return tuple(len(axis) for axis in reversed(self.axes)) or (len(self.points),)

    @property
    def kind(self) -> str:
        """Their name: "nodes", "points" or "vertices"."""
        return "nodes" if self.axes else "points" if self.cells is None else "vertices"


@dataclass(frozen=True, eq=False)
class TargetValues:
    """A field at targets, with its error.

    Parameters
    ----------
    names : sequence of str
        Names of the coordinates and of the value.
    targets : Targets
    values, error : ndarray of shape (m,)
    extrapolated : ndarray of shape (m,), of small integers
        As `fieldrecon.selection.extrapolated` returns them.
    lonlat : bool
        Whether the coordinates are degrees of longitude and latitude.
    units : sequence of str
        Units of the coordinates and of the value, empty where unknown.
    crs : mapping, optional
        Attributes of the grid mapping, as `fieldrecon.io.crs.grid_mapping` returns them.
    """

    names: Sequence[str]
    targets: Targets
    values: np.ndarray
    error: np.ndarray
    extrapolated: np.ndarray
    lonlat: bool = False
    units: Sequence[str] = ()
    crs: Mapping[str, Any] | None = None

    @property
    def names_and_units(self) -> list[tuple[str, str]]:
        """For each coordinate and the value, the name without its unit, and the unit."""
        units = self.units or ("",) * len(self.names)
        found = [name_and_unit(name) for name in self.names]
        return [
            (bare, known) if not own else (name, own)
            for name, own, (bare, known) in zip(self.names, units, found, strict=True)
        ]

    @property
    def labels(self) -> list[str]:
        """Names of the coordinates and of the value, with units in brackets where known."""
        return [f"{name} [{unit}]" if unit else name for name, unit in self.names_and_units]

    @property
    def columns(self) -> Mapping[str, np.ndarray]:
        """The value, its error and the flag of extrapolation, under distinct names."""
        taken = list(self.names)
        error, flag = (unused_name(name, taken) for name in ("error", "extrapolated"))
        return {self.names[-1]: self.values, error: self.error, flag: self.extrapolated}


def unused_name(name: str, taken: list[str]) -> str:
    """Return the name, with a number if it is taken, and add it to the taken ones."""
    candidates = (name if k == 1 else f"{name}_{k}" for k in count(1))
    unused = next(candidate for candidate in candidates if candidate not in taken)
    taken.append(unused)
    return unused


def grid_over(points: np.ndarray, counts: Sequence[int], lonlat: bool = False) -> Targets:
    """Return a grid over the bounding box of the points (n, d).

    Longitudes start after the widest gap between the points, so that points on both sides of the
    date line have one grid across it. Its longitudes may exceed 180.

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
    if np.ndim(counts) != 1:
        raise ValueError(f"grid must be {d} numbers of nodes; got {counts!r}")
    if len(counts) != d:
        sides = "x".join(map(str, counts))
        raise ValueError(f"a grid in {d} variables has {d} sides; got {sides}")
    for nodes in counts:
        valid.as_count(nodes, "each number of grid", 2)
    if np.prod(np.array(counts, dtype=float)) > MAX_NODES:
        raise ValueError(
            f"a grid must have at most {MAX_NODES:.0e} nodes; got {'x'.join(map(str, counts))}"
        )
    if lonlat:
        points = np.column_stack([_unwrapped(points[:, 0]), points[:, 1]])
    low, high = points.min(axis=0), points.max(axis=0)
    axes = tuple(np.linspace(*side) for side in zip(low, high, counts, strict=True))
    return Targets(grid_nodes(axes), axes)


def grid_nodes(axes: Sequence[np.ndarray]) -> np.ndarray:
    """Return the nodes (m, d) of the grid over the axes; the first coordinate varies fastest."""
    nodes = np.meshgrid(*reversed(axes), indexing="ij")
    return np.stack(nodes[::-1], axis=-1).reshape(-1, len(axes))


def _unwrapped(longitudes: np.ndarray) -> np.ndarray:
    """Shift longitudes by multiples of 360 so that they start after the widest gap between them.

    The smallest lies in [-180, 180).
    """
    ordered = np.unique(longitudes % 360)
    gaps = np.diff(ordered, append=ordered[0] + 360)
    widest = int(gaps.argmax())
    cut = ordered[widest] + gaps[widest] / 2
    unwrapped = cut + (longitudes - cut) % 360
    return unwrapped - 360 * np.floor((unwrapped.min() + 180) / 360)


def targets_of_table(
    table: Source, names: Sequence[str], lonlat: bool = False, strict: bool = False
) -> Targets:
    """Read targets from the columns of a table with these names; bad rows are skipped.

    If these columns are the axes of a grid, as those of a data set may be, the targets are its
    nodes.

    Raises
    ------
    ValueError
        If a column is missing, no row is valid, or, if strict, one is not: with its line.
    """

    def choose(columns: list[str]) -> list[int]:
        for name in names:
            if name not in columns:
                have = ", ".join(columns)
                raise ValueError(
                    f"{table} has no column {name!r}, as the samples have; it has {have}"
                )
        return [columns.index(name) for name in names]

    if isinstance(table, Frame) and {*names} <= {*table.axes}:
        axes = tuple(
            valid.as_numbers(table.axes[name], name, complex_allowed=False) for name in names
        )
        return Targets(grid_nodes(axes), axes)
    found = read_source(table, ColumnSpec(choose, (np.inf, 90.0) if lonlat else None))
    if found.bad and (strict or not len(found.numbers)):
        raise ValueError(bad_row_message(table, found.bad[0]))
    index = None
    if isinstance(table, Frame) and table.index is not None:
        index = table.index.delete([row.line for row in found.bad])
    return Targets(found.numbers, bad=tuple(found.bad), index=index, numbered=numbered(table))


def targets_of_mesh(path: Path, d: int) -> Targets:
    """Read the vertices of a mesh of triangles, or in space also of tetrahedra, as targets.

    Raises
    ------
    ValueError
        If the file holds no such mesh in d variables.
    ImportError
        If the format takes meshio, which is not installed.
    """
    try:
        mesh = read_mesh(path)
        if mesh.points.shape[1] == d:
            return Targets(mesh.points, cells=mesh.cells)
        reason = f"{path} is a mesh in {mesh.points.shape[1]} variables; the samples have {d}"
    except ValueError as error:
        reason = str(error)
    if d != 3:
        raise ValueError(reason)
    points, triangles = read_surface(path)
    return Targets(points, cells=triangles)
