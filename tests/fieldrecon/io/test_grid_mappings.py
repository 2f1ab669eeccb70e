"""Coordinates of files and data sets: units, axes and the grid mapping of the CF conventions."""

import numpy as np
import pyproj
import pytest
import xarray as xr
from scipy.io import netcdf_file

from fieldrecon.io.cf import cf_variables
from fieldrecon.io.column_names import name_and_unit
from fieldrecon.io.crs import WGS_84, grid_mapping
from fieldrecon.io.labelled import to_xarray
from fieldrecon.io.targets import Targets, TargetValues, grid_over
from fieldrecon.io.values import write_values

GRID = grid_over(np.array([[0.0, 0.0], [0.1, 1 / 3]]), (4, 3))
SCATTERED = Targets(GRID.points)


def result_at(targets, **options):
    """Values that differ from point to point, in metres."""
    values = targets.points @ [1.0, np.pi]
    flags = (np.arange(len(values)) % 3).astype(np.int8)
    return TargetValues(("x", "y [m]", "depth (m)"), targets, values, values**2, flags, **options)


@pytest.mark.parametrize("targets", [GRID, SCATTERED], ids=["grid", "points"])
@pytest.mark.parametrize("options", [{}, {"lonlat": True}, {"crs": grid_mapping("EPSG:32612")}])
def test_a_data_set_and_a_netcdf_file_are_the_same(tmp_path, targets, options):
    """xarray reads from the file what `to_xarray` gives, and what it writes itself."""
    result = result_at(targets, **options)
    made = to_xarray(result)
    with xr.open_dataset(write_values(tmp_path / "a.nc", result), decode_coords="all") as stored:
        written = stored.load()
    made.to_netcdf(tmp_path / "b.nc", engine="scipy")
    with xr.open_dataset(tmp_path / "b.nc", decode_coords="all") as stored:
        again = stored.load()
    xr.testing.assert_equal(made, written)
    xr.testing.assert_equal(made, again)
    for name in made.variables:
        named = {k: v for k, v in made[name].attrs.items() if k != "grid_mapping"}
        assert {*named} == {*written[name].attrs}
        for key, value in named.items():
            assert np.array_equal(written[name].attrs[key], value), (name, key)


def test_the_grid_mapping_is_the_coordinate_reference_system():
    """pyproj reads the system back from the attributes: all digits are there."""
    for crs in ("EPSG:32612", 27700, pyproj.CRS("EPSG:3035"), "+proj=lcc +lat_1=33 +lat_2=45"):
        mapping = to_xarray(result_at(GRID, crs=grid_mapping(crs))).spatial_ref.attrs
        assert pyproj.CRS.from_cf(mapping) == pyproj.CRS.from_user_input(crs)
        without = {key: value for key, value in mapping.items() if key != "crs_wkt"}
        assert pyproj.CRS.from_cf(without).is_projected
    assert pyproj.CRS.from_cf(WGS_84) == pyproj.CRS("EPSG:4326")
    degrees = pyproj.CRS("EPSG:4326").to_cf()
    assert {key: value for key, value in degrees.items() if key in WGS_84} == {
        **WGS_84,
        "crs_wkt": degrees["crs_wkt"],
    }


def test_numbers_of_the_grid_mapping_have_double_precision(tmp_path):
    """Also in files, where scipy would write a float as one of single precision."""
    path = write_values(tmp_path / "a.nc", result_at(GRID, lonlat=True))
    with netcdf_file(path, mmap=False) as file:
        mapping = file.variables["spatial_ref"]
        assert mapping.inverse_flattening == 298.257223563
        assert file.variables["depth"].grid_mapping == b"spatial_ref"


def test_axes_have_the_standard_names_of_their_system():
    """Degrees, lengths on a projection, and lengths without a known place."""
    degrees, projected, plain = (
        to_xarray(result_at(GRID, **options))
        for options in ({"lonlat": True}, {"crs": grid_mapping("EPSG:32612")}, {})
    )
    assert degrees.y.attrs["standard_name"] == "latitude"
    assert degrees.y.attrs["units"] == "degrees_north"
    assert projected.x.attrs["standard_name"] == "projection_x_coordinate"
    assert (plain.y.attrs["units"], plain.y.attrs["axis"]) == ("m", "Y")
    assert "standard_name" not in plain.x.attrs
    assert "spatial_ref" not in plain


def test_units_in_names_become_attributes():
    """Units are in brackets; what is in parentheses may be a part of the name."""
    depth = to_xarray(result_at(GRID)).depth
    assert (depth.attrs["units"], depth.attrs["long_name"]) == ("m", "depth")
    assert result_at(GRID).labels == ["x", "y [m]", "depth [m]"]
    assert name_and_unit("Depth (m, below sea)") == ("Depth (m, below sea)", "")
    assert name_and_unit("wind [m s-1] ") == ("wind", "m s-1")
    assert name_and_unit("[m]") == ("[m]", "")


def test_a_value_may_have_the_name_of_the_grid_mapping():
    """It is numbered, as the error of a value that is called error."""
    result = result_at(GRID, lonlat=True)
    odd = TargetValues(("error", "y", "spatial_ref"), GRID, *[result.values] * 3, lonlat=True)
    names = [variable.name for variable in cf_variables(odd)]
    assert len({*names}) == len(names) == 6
