"""Values of a field at targets, written as CSV, NPZ, VTK or NetCDF.

Every format holds the same columns: the value under its name, ``error`` (of `ErrorBand`), and
``extrapolated`` (0 within the validated distance, 1 beyond, 2 also outside the hull). Of several
values each has its column, and its error as ``error of`` its name without the unit. CSV and NPZ
keep the rows of a table of targets: a bad one is empty in CSV and NaN in NPZ.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np

from fieldrecon._core.atomic_files import whole_file
from fieldrecon.io.archives import write_archive
from fieldrecon.io.netcdf import write_netcdf
from fieldrecon.io.targets import Targets, TargetValues
from fieldrecon.io.vtk import write_vtk

_ROWS = 100_000  # rows of CSV that are converted to text at once


def write_csv(path: Path, result: TargetValues) -> None:
    """Write a row for each target; each number has the fewest digits that reproduce it."""
    rows = result.rows
    count = len(next(iter(rows.values())))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(rows)
        for start in range(0, count, _ROWS):
            block = (column[start : start + _ROWS].tolist() for column in rows.values())
            writer.writerows(zip(*block, strict=True))


def write_npz(path: Path, result: TargetValues) -> None:
    """Write `values`, `error`, `extrapolated`, and `x`, `y` (and `z`) of a grid, or `points`."""
    targets = result.targets
    named = zip("xyz", targets.axes, strict=False)
    where = dict(named) if targets.axes else {"points": _in_rows(targets, targets.points)}
    if targets.cells is not None:
        where["cells"] = targets.cells
    data = {"values": result.values, "error": result.error, "extrapolated": result.extrapolated}
    placed = {name: _in_rows(targets, array) for name, array in data.items()}
    shaped = {
        name: array.reshape(targets.shape + array.shape[1:]) if targets.axes else array
        for name, array in placed.items()
    }
    write_archive(path, {**where, **shaped})


def _in_rows(targets: Targets, array: np.ndarray) -> np.ndarray:
    """An array (m, ...) in the rows of the table, NaN in those that were skipped."""
    if not targets.bad:
        return array
    columns = [targets.in_rows(column) for column in array.reshape(len(array), -1).T.astype(float)]
    filled = np.stack([np.ma.filled(column, np.nan) for column in columns], axis=-1)
    return filled.reshape(-1, *array.shape[1:])


FORMATS: Mapping[str, Callable[[Path, TargetValues], None]] = MappingProxyType(
    {"csv": write_csv, "npz": write_npz, "vtk": write_vtk, "nc": write_netcdf}
)
"""The writer of each format, by its suffix."""


def write_values(path: Path, result: TargetValues) -> Path:
    """Write a file in the format that its suffix names, completely or not at all."""
    (kind,) = as_formats([path.suffix])
    with whole_file(path) as temporary:
        FORMATS[kind](temporary, result)
    return path


def as_formats(texts: Iterable[str]) -> list[str]:
    """Return the formats with these suffixes, given with or without the dot.

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
