"""NetCDF files of a field, by the climate and forecast conventions (CF-1.8).

The files are of version 3 with 64-bit offsets, which every reader of NetCDF supports.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import netcdf_file

from fieldrecon.io.cf import CONVENTIONS, CfVariable, cf_variables
from fieldrecon.io.targets import TargetValues


def write_netcdf(path: Path, result: TargetValues) -> None:
    """Write variables over the axes of a grid, or over points with their coordinates."""
    variables = cf_variables(result)
    coordinates = " ".join(v.name for v in variables if v.role == "coordinate")
    with netcdf_file(path, "w", version=2) as file:
        file.Conventions = CONVENTIONS
        for variable in variables:
            _create_dimensions(file, variable)
            written = file.createVariable(variable.name, variable.data.dtype, variable.dimensions)
            written[...] = variable.data
            for key, value in variable.attributes.items():
                setattr(written, key, _encoded(value))
            if variable.role == "data" and not result.targets.axes:
                written.coordinates = coordinates


def _create_dimensions(file: netcdf_file, variable: CfVariable) -> None:
    for name, length in zip(variable.dimensions, variable.data.shape, strict=True):
        if name not in file.dimensions:
            file.createDimension(name, length)


def _encoded(value: Any) -> Any:
    """Texts in UTF-8, since scipy takes ASCII, and numbers as arrays, since it rounds a float."""
    return value.encode() if isinstance(value, str) else np.asarray(value)
