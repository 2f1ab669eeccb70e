"""Targets of a reconstruction: a grid, the points of a table, or the vertices of a mesh.

Also the values of a field at them, which the writers of `fieldrecon.io.values` take.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from fieldrecon._core import validation as valid
from fieldrecon.io.column_names import name_and_unit
from fieldrecon.io.frames import Frame, Source, bad_row_message, numbered, read_source
from fieldrecon.io.meshes import read_mesh, read_surface
from fieldrecon.io.tables import BadRow, ColumnSpec

MAX_NODES = 4e8
"""Largest number of nodes of a grid; its files alone would exceed the memory of most machines."""


@dataclass(frozen=True, eq=False)
class Targets:
    """The points at which a field is evaluated, and their connectivity.

    Parameters
    ----------
    points : ndarray of shape (m, d)
        Those of the valid rows, if they come from a table.
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

    def in_rows(self, column: np.ndarray) -> np.ndarray:
        """A column (m,) in the rows of the table, masked in those that were skipped.

        Examples
        --------
        >>> targets = Targets(np.array([[0.0, 0.0], [1.0, 2.0]]), bad=(BadRow(3, "no point", 1),))
        >>> targets.in_rows(np.array([5.0, 7.0])).tolist()
        [5.0, None, 7.0]
        """
        if not self.bad:
            return column
        rows = len(column) + len(self.bad)
        result = np.ma.masked_all(rows, column.dtype)
        result[np.delete(np.arange(rows), [row.row for row in self.bad])] = column
        return result


@dataclass(frozen=True, eq=False)
class TargetValues:
    """A field at targets, with its error.

    Parameters
    ----------
    names : sequence of str
        Names of the coordinates and of the values.
    targets : Targets
    values, error : ndarray of shape (m,) or (m, k)
        As of the samples: of one value, or of k values.
    extrapolated : ndarray of shape (m,), of small integers
        As `fieldrecon.selection.extrapolated` returns them.
    lonlat : bool
        Whether the coordinates are degrees of longitude and latitude.
    units : sequence of str
        Units of the coordinates and of the values, empty where unknown.
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
        """For each coordinate and value, the name without its unit, and the unit."""
        units = self.units or ("",) * len(self.names)
        found = [name_and_unit(name) for name in self.names]
        return [(bare, own or known) for own, (bare, known) in zip(units, found, strict=True)]

    @property
    def labels(self) -> list[str]:
        """Names of the coordinates and of the values, with units in brackets where known."""
        return [f"{name} [{unit}]" if unit else name for name, unit in self.names_and_units]

    @property
    def columns(self) -> Mapping[str, np.ndarray]:
        """Each value and its error, and the flag of extrapolation, under distinct names."""
        taken = list(self.names)
        columns: dict[str, np.ndarray] = {}
        for k, name in enumerate(self.value_names):
            one = self.single(k)
            of_name = "error" if self.values.ndim == 1 else f"error of {name_and_unit(name)[0]}"
            columns |= {name: one.values, unused_name(of_name, taken): one.error}
        return columns | {unused_name("extrapolated", taken): self.extrapolated}

    @property
    def rows(self) -> Mapping[str, np.ndarray]:
        """Coordinates and columns in the rows of the table, masked in those that were skipped."""
        coordinates = zip(self.names[: self.d], self.targets.points.T, strict=True)
        columns = {**dict(coordinates), **self.columns}
        return {name: self.targets.in_rows(column) for name, column in columns.items()}

    @property
    def d(self) -> int:
        """Number of coordinates."""
        return self.targets.points.shape[1]

    @property
    def value_names(self) -> Sequence[str]:
        """Names of the values."""
        return self.names[self.d :]

    def single(self, k: int) -> TargetValues:
        """The value of index k alone, of shape (m,)."""
        if self.values.ndim == 1:
            return self
        columns = [*range(self.d), self.d + k]
        return replace(
            self,
            names=[self.names[i] for i in columns],
            units=[self.units[i] for i in columns] if self.units else (),
            values=self.values[:, k],
            error=self.error[:, k],
        )


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
    table: Source,
    names: Sequence[str],
    lonlat: bool = False,
    strict: bool = False,
    decimal: str | None = None,
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
    spec = ColumnSpec(choose, (np.inf, 90.0) if lonlat else None, decimal)
    found = read_source(table, spec)
    if found.bad and (strict or not len(found.numbers)):
        raise ValueError(bad_row_message(table, found.bad[0]))
    index = table.index if isinstance(table, Frame) else None
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
