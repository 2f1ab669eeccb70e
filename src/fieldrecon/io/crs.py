"""Coordinate reference systems as grid mappings of the climate and forecast (CF) conventions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fieldrecon._core.extras import optional

WGS_84: Mapping[str, Any] = {
    "grid_mapping_name": "latitude_longitude",
    "longitude_of_prime_meridian": 0.0,
    "semi_major_axis": 6378137.0,
    "inverse_flattening": 298.257223563,
    "crs_wkt": 'GEOGCRS["WGS 84",DATUM["World Geodetic System 1984",'
    'ELLIPSOID["WGS 84",6378137,298.257223563,LENGTHUNIT["metre",1]]],'
    'PRIMEM["Greenwich",0,ANGLEUNIT["degree",0.0174532925199433]],CS[ellipsoidal,2],'
    'AXIS["geodetic latitude (Lat)",north,ORDER[1],ANGLEUNIT["degree",0.0174532925199433]],'
    'AXIS["geodetic longitude (Lon)",east,ORDER[2],ANGLEUNIT["degree",0.0174532925199433]],'
    'ID["EPSG",4326]]',
}
"""That of degrees for which no other is given."""


def grid_mapping(crs: Any) -> Mapping[str, Any] | None:
    """Return the attributes of the grid mapping of a coordinate reference system.

    Parameters
    ----------
    crs : object, optional
        A name that pyproj knows, such as ``"EPSG:32612"``, its number, a ``pyproj.CRS``, or the
        attributes themselves.

    Raises
    ------
    ValueError
        If there is no such system.
    ImportError
        If it is a name, and pyproj is not installed.
    """
    if crs is None or isinstance(crs, Mapping):
        return crs
    if not hasattr(crs, "to_cf"):
        pyproj = optional("pyproj")
        try:
            crs = pyproj.CRS.from_user_input(crs)
        except pyproj.exceptions.CRSError as error:
            raise ValueError(
                f"there is no coordinate reference system {crs!r}; one is such as EPSG:32612 "
                f"({error})"
            ) from None
    attributes: Mapping[str, Any] = crs.to_cf()
    return attributes


def is_geographic(mapping: Mapping[str, Any] | None) -> bool:
    """Whether the coordinates are degrees of longitude and latitude."""
    return mapping is not None and mapping.get("grid_mapping_name") == "latitude_longitude"
