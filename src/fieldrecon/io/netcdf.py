"""Values at places, in files: CSV, NPZ, VTK and NetCDF.

Every format bears the same columns: the value under its name, ``error`` (what `ErrorEstimate` says)
and ``extrapolated`` (0 among the samples, 1 in a gap, 2 outside). VTK is the legacy format in
binary, which ParaView reads without more; NetCDF is version 3, which everything reads.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from types import MappingProxyType
from typing import BinaryIO

import numpy as np
from scipy.io import netcdf_file

from fieldrecon.io.targets import Places
from fieldrecon.selection.extrapolation import MEANINGS

_ROWS = 100_000  # of CSV that are spelled at once


@dataclass(frozen=True, eq=False)
class Result:
    """A field at places.

    Parameters
    ----------
    names : sequence of str
        Of the coordinates, and of the value.
    places : Places
    values, error : ndarray of shape (m,)
    extrapolated : ndarray of shape (m,), of small integers
    lonlat : bool
        Whether the coordinates are degrees of longitude and latitude.
    """

    names: Sequence[str]
    places: Places
    values: np.ndarray
    error: np.ndarray
    extrapolated: np.ndarray
    lonlat: bool = False

    @property
    def columns(self) -> Mapping[str, np.ndarray]:
        """The value, its error, and whether it is extrapolated, under names that differ."""
        taken = list(self.names)
        error, flag = (_free(name, taken) for name in ("error", "extrapolated"))
        return {self.names[-1]: self.values, error: self.error, flag: self.extrapolated}


def write_csv(path: Path, result: Result) -> None:
    """Write a row for each place, each number in the shortest form that reads back the same."""
    columns = [*result.places.points.T, *result.columns.values()]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*result.names[:-1], *result.columns])
        for start in range(0, len(result.values), _ROWS):
            part = (column[start : start + _ROWS].tolist() for column in columns)
            writer.writerows(zip(*part, strict=True))


def write_npz(path: Path, result: Result) -> None:
    """Write `values`, `error`, `extrapolated`, and `x`, `y` (and `z`) of a grid, or `points`."""
    places = result.places
    named = zip("xyz", places.axes, strict=False)
    where = dict(named) if places.axes else {"points": places.points}
    if places.cells is not None:
        where["cells"] = places.cells
    data = {"values": result.values, "error": result.error, "extrapolated": result.extrapolated}
    shaped = {name: array.reshape(places.shape) for name, array in data.items()}
    with path.open("wb") as file:
        np.savez(file, **where, **shaped)  # type: ignore[arg-type]


def write_vtk(path: Path, result: Result) -> None:
    """Write a rectilinear grid, an unstructured grid of cells, or of points, as legacy VTK."""
    places = result.places
    with path.open("wb") as file:
        file.write(b"# vtk DataFile Version 3.0\nfieldrecon\nBINARY\n")
        (_vtk_grid if places.axes else _vtk_cells)(file, places)
        file.write(f"POINT_DATA {len(places.points)}\n".encode())
        taken: list[str] = []
        for name, column in result.columns.items():
            kind, dtype = ("int", ">i4") if column.dtype.kind == "i" else ("double", ">f8")
            word = _free(re.sub(r"\s+", "_", name.strip()) or "value", taken)
            file.write(f"SCALARS {word} {kind} 1\nLOOKUP_TABLE default\n".encode())
            _write_numbers(file, column, dtype)


def _vtk_grid(file: BinaryIO, places: Places) -> None:
    axes = [*places.axes, *[np.zeros(1)] * (3 - len(places.axes))]
    sizes = " ".join(str(len(axis)) for axis in axes)
    file.write(f"DATASET RECTILINEAR_GRID\nDIMENSIONS {sizes}\n".encode())
    for letter, axis in zip("XYZ", axes, strict=True):
        file.write(f"{letter}_COORDINATES {len(axis)} double\n".encode())
        _write_numbers(file, axis, ">f8")


def _vtk_cells(file: BinaryIO, places: Places) -> None:
    m, d = places.points.shape
    cells = np.arange(m)[:, None] if places.cells is None else places.cells
    corners = cells.shape[1]
    kind = {1: 1, 3: 5, 4: 10}[corners]  # vertex, triangle, tetrahedron
    in_space = np.column_stack([places.points, np.zeros((m, 3 - d))])
    file.write(f"DATASET UNSTRUCTURED_GRID\nPOINTS {m} double\n".encode())
    _write_numbers(file, in_space, ">f8")
    file.write(f"CELLS {len(cells)} {len(cells) * (corners + 1)}\n".encode())
    _write_numbers(file, np.insert(cells, 0, corners, axis=1), ">i4")
    file.write(f"CELL_TYPES {len(cells)}\n".encode())
    _write_numbers(file, np.full(len(cells), kind), ">i4")


def _write_numbers(file: BinaryIO, array: np.ndarray, dtype: str) -> None:
    file.write(np.ascontiguousarray(array, dtype=dtype).tobytes() + b"\n")


def write_netcdf(path: Path, result: Result) -> None:
    """Write variables over the axes of a grid, or over points that bear their coordinates."""
    places, taken = result.places, []  # type: tuple[Places, list[str]]
    names = [
        _free(re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "v", taken)
        for name in (*result.names[:-1], *result.columns)
    ]
    d = places.points.shape[1]
    with netcdf_file(path, "w", mmap=False, version=2) as file:
        file.Conventions = "CF-1.8"
        dimensions = _dimensions(file, names[:d], places)
        coordinates = places.axes or places.points.T
        for k, column in enumerate([*coordinates, *result.columns.values()]):
            own = dimensions if k >= d or not places.axes else (names[k],)
            kind = "i1" if column.dtype.kind == "i" else "f8"
            variable = file.createVariable(names[k], kind, own)
            variable[:] = column.reshape(variable.shape)
            variable.long_name = (*result.names[:d], *result.columns)[k].encode()
            if k >= d and not places.axes:
                variable.coordinates = " ".join(names[:d])
        _described(file, names, result)


def _dimensions(file: netcdf_file, names: list[str], places: Places) -> tuple[str, ...]:
    if not places.axes:
        file.createDimension("point", len(places.points))
        return ("point",)
    for name, axis in zip(names, places.axes, strict=True):
        file.createDimension(name, len(axis))
    return tuple(reversed(names))


def _described(file: netcdf_file, names: list[str], result: Result) -> None:
    """Say what the numbers are, in the words of the climate and forecast conventions."""
    if result.lonlat:
        file.variables[names[0]].units = "degrees_east"
        file.variables[names[1]].units = "degrees_north"
    flag = file.variables[names[-1]]
    flag.flag_values = np.arange(len(MEANINGS), dtype=np.int8)
    flag.flag_meanings = " ".join(meaning.replace(" ", "_") for meaning in MEANINGS)


def _free(name: str, taken: list[str]) -> str:
    """The name, or with a number where it is taken; from now on it is."""
    tries: Iterator[str] = (name if k == 1 else f"{name}_{k}" for k in count(1))
    free = next(word for word in tries if word not in taken)
    taken.append(free)
    return free


FORMATS: Mapping[str, Callable[[Path, Result], None]] = MappingProxyType(
    {"csv": write_csv, "npz": write_npz, "vtk": write_vtk, "nc": write_netcdf}
)
"""What writes a file, by the suffix of its name."""


def as_formats(texts: Iterable[str]) -> list[str]:
    """Formats by their suffixes, with or without the dot.

    Raises
    ------
    ValueError
        If one is unknown.
    """
    formats = [text.strip().lower().removeprefix(".") for text in texts]
    for name in formats:
        if name not in FORMATS:
            raise ValueError(f"there is no format {name!r}; there are {', '.join(FORMATS)}")
    return formats
