"""NetCDF files of a field, by the climate and forecast conventions (CF-1.8).

The files are of version 3 with 64-bit offsets, which every reader of NetCDF supports.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from scipy.io import netcdf_file

from fieldrecon.io.targets import Targets, TargetValues, unused_name
from fieldrecon.selection.extrapolation import MEANINGS


def write_netcdf(path: Path, result: TargetValues) -> None:
    """Write variables over the axes of a grid, or over points with their coordinates."""
    targets = result.targets
    taken: list[str] = []
    names = [
        unused_name(re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "v", taken)
        for name in (*result.names[:-1], *result.columns)
    ]
    d = targets.points.shape[1]
    with netcdf_file(path, "w", mmap=False, version=2) as file:
        file.Conventions = "CF-1.8"
        dimensions = _create_dimensions(file, names[:d], targets)
        coordinates = targets.axes or targets.points.T
        for k, column in enumerate([*coordinates, *result.columns.values()]):
            own = dimensions if k >= d or not targets.axes else (names[k],)
            kind = "i1" if column.dtype.kind == "i" else "f8"
            variable = file.createVariable(names[k], kind, own)
            variable[:] = column.reshape(variable.shape)
            variable.long_name = (*result.names[:d], *result.columns)[k].encode()
            if k >= d and not targets.axes:
                variable.coordinates = " ".join(names[:d])
        _set_attributes(file, names, result)


def _create_dimensions(file: netcdf_file, names: list[str], targets: Targets) -> tuple[str, ...]:
    if not targets.axes:
        file.createDimension("point", len(targets.points))
        return ("point",)
    for name, axis in zip(names, targets.axes, strict=True):
        file.createDimension(name, len(axis))
    return tuple(reversed(names))


def _set_attributes(file: netcdf_file, names: list[str], result: TargetValues) -> None:
    """Set the units of degrees, and the meanings of the flags of extrapolation."""
    if result.lonlat:
        file.variables[names[0]].units = "degrees_east"
        file.variables[names[1]].units = "degrees_north"
    flag = file.variables[names[-1]]
    flag.flag_values = np.arange(len(MEANINGS), dtype=np.int8)
    flag.flag_meanings = " ".join(meaning.replace(" ", "_") for meaning in MEANINGS)
