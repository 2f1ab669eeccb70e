"""A field at targets as variables of the climate and forecast (CF-1.8) conventions.

NetCDF files and data sets of xarray are made of the same variables: coordinates with units, the
value with its error and the flag of extrapolation, and the grid mapping, from which GDAL and other
programs know where the coordinates lie on the Earth.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fieldrecon.io.crs import WGS_84, is_geographic
from fieldrecon.io.targets import TargetValues, unused_name
from fieldrecon.selection.extrapolation import MEANINGS

CONVENTIONS = "CF-1.8"
GRID_MAPPING = "spatial_ref"
"""Name of the variable of the grid mapping; that which GDAL and rioxarray use."""
_DEGREES = (
    {"standard_name": "longitude", "units": "degrees_east"},
    {"standard_name": "latitude", "units": "degrees_north"},
)
_PROJECTED = (
    {"standard_name": "projection_x_coordinate"},
    {"standard_name": "projection_y_coordinate"},
)


@dataclass(frozen=True, eq=False)
class CfVariable:
    """A variable with its dimensions and attributes.

    Parameters
    ----------
    name : str
    dimensions : tuple of str
        Empty for the grid mapping.
    data : ndarray
    attributes : mapping
    role : str
        "coordinate", "data" or "grid mapping".
    """

    name: str
    dimensions: tuple[str, ...]
    data: np.ndarray
    attributes: Mapping[str, Any] = field(default_factory=dict)
    role: str = "data"


def cf_variables(result: TargetValues) -> list[CfVariable]:
    """Return the coordinates, the data and the grid mapping of a field at targets."""
    mapping = result.crs or (WGS_84 if result.lonlat else None)
    d = result.targets.points.shape[1]
    names = _names(result)
    coordinates = list(_coordinates(result, names[:d], mapping))
    return [*coordinates, *_data(result, names[d:], coordinates, mapping), *_mapping(mapping)]


def _names(result: TargetValues) -> list[str]:
    """Names without units, of letters, digits and underscores."""
    bare = [name for name, _ in result.names_and_units]
    taken = [GRID_MAPPING]
    return [
        unused_name(re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "v", taken)
        for name in (*bare[: result.d], *_columns(result, bare[result.d :]))
    ]


def _columns(result: TargetValues, bare: list[str]) -> list[str]:
    """Names of the columns, those of the values without their units."""
    values = dict(zip(result.value_names, bare, strict=True))
    return [values.get(name, name) for name in result.columns]


def _coordinates(
    result: TargetValues, names: list[str], mapping: Mapping[str, Any] | None
) -> Iterator[CfVariable]:
    targets = result.targets
    conventional: tuple[Mapping[str, str], ...] = ()
    if mapping is not None:
        conventional = _DEGREES if is_geographic(mapping) else _PROJECTED
    for k, (long_name, unit) in enumerate(result.names_and_units[: len(names)]):
        attributes = {"long_name": long_name} | ({"units": unit} if unit else {})
        attributes |= conventional[k] if k < len(conventional) else {}
        if targets.axes:
            dimensions, data = (names[k],), targets.axes[k]
            attributes["axis"] = "XYZ"[k]
        else:
            dimensions, data = ("point",), targets.points[:, k]
        yield CfVariable(names[k], dimensions, data, attributes, "coordinate")


def _data(
    result: TargetValues,
    names: list[str],
    coordinates: list[CfVariable],
    mapping: Mapping[str, Any] | None,
) -> Iterator[CfVariable]:
    targets = result.targets
    dimensions = tuple(c.name for c in reversed(coordinates)) if targets.axes else ("point",)
    where = {} if mapping is None else {"grid_mapping": GRID_MAPPING}
    attributes = [*_attributes(result, names)]
    for name, column, own in zip(names, result.columns.values(), attributes, strict=True):
        yield CfVariable(name, dimensions, column.reshape(targets.shape), own | where)


def _attributes(result: TargetValues, names: list[str]) -> Iterator[dict[str, Any]]:
    """Attributes of each value and its error, and of the flag."""
    values = result.names_and_units[result.d :]
    for k, (value, unit) in enumerate(values):
        of_unit = {"units": unit} if unit else {}
        ancillary = f"{names[2 * k + 1]} {names[-1]}"
        yield {"long_name": value, "ancillary_variables": ancillary} | of_unit
        yield {"long_name": f"half-width of the 95 % prediction band of {value}"} | of_unit
    yield {
        "long_name": f"extrapolation of {', '.join(value for value, _ in values)}",
        "flag_values": np.arange(len(MEANINGS), dtype=np.int8),
        "flag_meanings": " ".join(meaning.replace(" ", "_") for meaning in MEANINGS),
    }


def _mapping(mapping: Mapping[str, Any] | None) -> Iterator[CfVariable]:
    if mapping is not None:
        yield CfVariable(GRID_MAPPING, (), np.zeros((), dtype=np.int32), mapping, "grid mapping")
