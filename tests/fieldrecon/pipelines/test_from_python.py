"""The commands as functions: data in memory, results as tables, pictures, files and pages."""

import io
import re
import subprocess
import sys
from copy import copy
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
import xarray as xr
from scipy.spatial.distance import cdist

import fieldrecon as fr
from fieldrecon._core import extras
from fieldrecon.cli.main import main
from fieldrecon.cli.reconstruct import print_survey
from fieldrecon.cli.surface import print_scan
from fieldrecon.io.frames import as_source, is_table
from fieldrecon.pages import audit_page, surface_page
from fieldrecon.pages.one_page import pairs
from fieldrecon.pages.reconstruction_page import (
    CAPTIONS,
    OF_EACH_VALUE,
    _flattened,
    methods_csv,
    picture,
    pictures,
    summary,
)
from fieldrecon.pipelines import audit, reconstruct, surface
from fieldrecon.pipelines.scans import ScanResult, _percent
from fieldrecon.pipelines.validation import Validation, _degrees
from fieldrecon.pipelines.variograms import variogram
from fieldrecon.selection.models import MODELS
from fieldrecon.solids.marching_cubes import extract_surface
from fieldrecon.solids.shapes import Ball, sample_surface

POINTS = fr.datasets.uniform(60, 2, seed=0)
PLANE = POINTS @ [1.0, 2.0]
FRAME = pd.DataFrame({"east [m]": POINTS[:, 0], "north [m]": POINTS[:, 1], "depth [m]": PLANE})
NAMED = FRAME.set_axis(["x", "y", "depth"], axis=1)
SET = xr.Dataset({"depth": ("point", PLANE)}, {name: ("point", NAMED[name]) for name in "xy"})


def plane(data=None, *names, **options):
    """The least squares plane of the samples on a small grid."""
    return reconstruct(data, *names, **{"method": "ls1", "grid": (3, 2)} | options)


# --- samples in memory ----------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("data", "options"),
    [
        (FRAME, {}),
        (NAMED.sample(frac=1, random_state=0), {"value": "depth"}),
        (pd.concat([FRAME, FRAME.iloc[:0]]).assign(station="a"), {"value": "depth [m]"}),
        (dict(NAMED), {"value": "depth"}),
        (NAMED.to_records(index=False), {"value": "depth"}),
        (pa.Table.from_pandas(NAMED), {"value": "depth"}),
        (SET, {}),
        (SET.to_dataframe().reset_index(drop=True), {}),
        (POINTS, {"value": PLANE}),
        (POINTS.tolist(), {"value": NAMED["depth"]}),
        (None, {"x": POINTS[:, 0], "y": NAMED["y"], "value": list(PLANE)}),
        (np.ma.array(POINTS, mask=False), {"value": PLANE}),
    ],
)
def test_samples_may_be_any_table_in_memory(data, options):
    """A data frame, a data set, named arrays or an array of points give the same field."""
    survey = plane(data, **options)
    assert len(survey.samples.points) == 60
    values, error, extrapolated = survey.predict([[0.25, 0.5], [9.0, 9.0]])
    np.testing.assert_allclose(values, [1.25, 27.0])
    assert (error < 1e-9).all()
    assert extrapolated.tolist() == [0, 2]


@pytest.mark.parametrize("name", ["coords", "data_vars", "to_dataset", "to_dataframe"])
def test_a_column_may_have_the_name_of_an_attribute_of_xarray(name):
    """A column of a data frame is an attribute, too."""
    frame = as_source(NAMED.rename(columns={"depth": name}))
    assert (str(frame), list(frame.names)) == ("the data frame", ["x", "y", name])
    np.testing.assert_array_equal(frame.read([name])[0], PLANE)


def test_the_variables_of_a_grid_are_samples_at_its_nodes():
    """Missing values are left out; the axes are in any order, and a third one is refused."""
    x, y = np.linspace(0, 1, 7), np.linspace(2, 0, 5)
    heights = xr.DataArray(
        x[:, None] + 2 * y, coords={"x": x, "y": y}, name="height", attrs={"units": "km"}
    )
    survey = plane(heights.where(heights < 4))
    assert len(survey.samples.points) == np.count_nonzero(heights < 4)
    assert f"{np.count_nonzero(heights >= 4)} rows skipped, by row: " in survey.warnings[0]
    np.testing.assert_allclose(survey.predict([[0.5, 0.5]]).values, 1.5)
    assert survey.result.labels == ["x", "y", "height [km]"]
    with pytest.raises(ValueError, match=r"dimension 'time' beside .* data\.isel\(time=0\)"):
        plane(heights.expand_dims(time=2))


def test_the_coordinates_of_a_grid_may_be_variables_of_one_dimension_each():
    """They are not marked as coordinates; a row is a combination of the dimensions of all."""
    x, y = np.linspace(0, 1, 7), np.linspace(2, 0, 5)
    plane_at_nodes = x[:, None] + 2 * y
    data = xr.Dataset({"x": ("i", x), "y": ("j", y), "height": (("i", "j"), plane_at_nodes)})
    read = as_source(data).read(["x", "y", "height"])
    nodes = [np.repeat(x, 5), np.tile(y, 7), plane_at_nodes.ravel()]
    assert sorted(zip(*read, strict=True)) == sorted(zip(*nodes, strict=True))


def test_the_only_variable_of_a_data_set_is_the_value():
    """Words and single numbers are no variables; of two variables neither is taken unasked."""
    variables = {"rate": ("point", PLANE), "station": ("point", ["a"] * 60), "grid": 0}
    coordinates = {name: ("point", NAMED[name]) for name in "xy"}
    one = xr.Dataset(variables, {"hour": ("point", np.arange(60.0)), **coordinates})
    assert plane(one).samples.names == ("x", "y", "rate")
    two = one.assign(count=2 * one.rate)
    with pytest.raises(ValueError, match="not clear which column of the data set is value"):
        plane(two)
    np.testing.assert_array_equal(plane(two, value="count").samples.values, 2 * PLANE)


def test_rows_that_are_not_samples_are_left_out_and_reported():
    """By their position from 0: missing, masked, infinite, and words."""
    table = {
        "x": np.ma.array([0.0, 1, 0, 1, 5, 6, 7], mask=[0, 0, 0, 0, 1, 0, 0]),
        "y": [0.0, 0, 1, 1, 5, np.inf, 5],
        "value": np.array([0.0, 1, 1, 2, 5, 5, "n/a"], dtype=object),
    }
    survey = plane(table)
    assert [(row.line, row.reason[:5]) for row in survey.samples.bad] == [
        (4, "x mus"),
        (5, "y mus"),
        (6, "value"),
    ]
    assert "3 rows skipped, by row: 4: x must be a finite number" in survey.warnings[0]
    assert survey.samples.bad[2].reason.endswith("got 'n/a'")
    with pytest.raises(ValueError, match="the mapping, row 4: x must be a finite number"):
        plane(table, strict=True)


def test_masked_points_are_left_out_and_reported():
    """An array of points keeps its mask: of one coordinate, or of both."""
    mask = np.zeros(POINTS.shape, dtype=bool)
    mask[3], mask[7, 1] = True, True
    survey = plane(np.ma.array(POINTS, mask=mask), value=PLANE)
    assert [row.line for row in survey.samples.bad] == [3, 7]
    assert len(survey.samples.points) == len(POINTS) - 2


def test_degrees_are_known_by_their_units():
    """Samples with CF units of degrees are on the globe; the option decides otherwise."""
    degrees = SET.assign_coords(
        x=SET.x.assign_attrs(units="degrees_east"), y=SET.y.assign_attrs(units="degrees_north")
    )
    assert plane(degrees).samples.lonlat
    assert not plane(degrees, lonlat=False).samples.lonlat
    assert not plane(SET).samples.lonlat
    assert plane(SET, lonlat=True).samples.lonlat


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "lonlat"), [("smooth", False), ("smooth", True), ("pu2", True), ("mean", False)]
)
def test_uncertain_samples_count_less(method, lonlat):
    """With their standard deviations the error is less than half of that without them."""
    points = fr.datasets.uniform(450, 2, seed=2)
    sigma = np.where(np.arange(450) % 2, 1.0, 0.01)
    noise = sigma * np.random.default_rng(0).standard_normal(450)
    table = NAMED.reindex(range(450)).assign(
        x=points[:, 0], y=points[:, 1], depth=fr.datasets.franke(points) + noise, std=sigma
    )
    inside = 0.1 + 0.8 * fr.datasets.uniform(200, 2, seed=3)
    errors = {}
    for name in ("std", None):
        survey = plane(table, value="depth", sigma=name, method=method, lonlat=lonlat)
        errors[name] = abs(survey.predict(inside).values - fr.datasets.franke(inside)).mean()
    assert errors["std"] < 0.5 * errors[None]
    again = plane(points, value=table["depth"], sigma=sigma, method=method, lonlat=lonlat)
    assert np.isfinite(again.result.error).all()
    assert "The smoothing is proportional to the variances of the samples." in again.warnings
    equal = plane(table, value="depth", sigma="std", method="ls1")
    assert any(w.startswith("The method takes all samples as equally") for w in equal.warnings)


@pytest.mark.slow
def test_the_smoothing_is_proportional_to_the_variances():
    """And so to the squares of the standard deviations."""
    sigma = np.linspace(0.1, 1.0, 60)
    noise = sigma * np.random.default_rng(1).standard_normal(60)
    smoothing = plane(
        POINTS, value=PLANE + noise, sigma=sigma, method="smooth"
    ).field.method.smoothing
    assert smoothing[0] > 0
    np.testing.assert_allclose(smoothing / sigma**2, smoothing[0] / sigma[0] ** 2, rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    "options", [{"lonlat": True, "sigma": np.linspace(0.01, 0.02, 60)}, {"anisotropy": "3:45"}]
)
def test_the_mean_of_two_methods_is_saved_with_all_that_makes_it(tmp_path, options):
    """With the plane of a region of the globe, the noise of each sample, and the distances."""
    values = np.column_stack([np.sin(3 * POINTS[:, 0]), np.cos(3 * POINTS[:, 1])])
    survey = plane(POINTS, value=values, method="mean", **options)
    assert survey.method.startswith("mean, mean of pu1 and pu2")
    assert abs(survey.predict(POINTS).values - values).max() < 0.2
    fr.save(tmp_path / "f.npz", survey.field)
    again = plane(load=tmp_path / "f.npz").result
    assert np.array_equal(again.values, survey.result.values)
    page = survey.report(tmp_path / "a.html").read_text()
    assert "methods 2" in page
    assert "{" not in page.partition("<h2>Parameters")[2]


def test_the_mean_of_repeated_samples_is_more_certain():
    """The standard deviation of a mean of m equally certain values is smaller by sqrt(m)."""
    table = {"x": [0.0, 1, 1, 0, 1], "y": [0.0, 0, 0, 1, 1], "value": [1.0, 2, 4, 3, 4]}
    survey = plane(table | {"s": [0.1, 0.3, 0.4, 0.5, 0.0]}, sigma="s", value="value")
    np.testing.assert_allclose(survey.samples.sigma, [0.1, 0.25, 0.5, 0.0])
    assert survey.samples.names == ("x", "y", "value")
    with pytest.raises(ValueError, match="s must not be negative: it is a standard deviation"):
        plane(table | {"s": [0.1, 0.3, 0.4, -0.5, 0.0]}, sigma="s", value="value")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("width", "method", "in_plane"), [(10.0, "ls2", True), (100.0, "tps", False)]
)
def test_a_region_of_the_globe_is_projected_to_a_plane(tmp_path, width, method, in_plane):
    """There quadratic polynomials are determined; a larger part of the globe stays in space."""
    lonlat = [100.0, 20.0] + width * (POINTS - 0.5)
    values = np.sin(np.radians(lonlat)).sum(axis=1)
    survey = plane(lonlat, value=values, lonlat=True, method=method)
    assert isinstance(survey.field.method.method, fr.methods.OnTangentPlane) == in_plane
    assert abs(survey.predict(lonlat).values - values).max() < 0.05
    fr.save(tmp_path / "f.npz", survey.field)
    again = plane(load=tmp_path / "f.npz").result
    assert np.array_equal(again.values, survey.result.values)
    np.testing.assert_allclose(again.error, survey.result.error)


@pytest.mark.parametrize(("radius", "in_plane"), [(29.5, True), (30.5, False)])
def test_a_region_of_the_globe_reaches_thirty_degrees_from_its_middle(radius, in_plane):
    """Two circles of latitude about the pole, and the pole."""
    around = np.arange(0.0, 360.0, 30.0)
    circles = [np.column_stack([around, np.full(12, 90.0 - r)]) for r in (radius, radius / 2)]
    samples = np.concatenate([*circles, [[0.0, 90.0]]])
    survey = plane(samples, value=samples[:, 1], lonlat=True)
    assert isinstance(survey.field.method.method, fr.methods.OnTangentPlane) == in_plane


@pytest.mark.parametrize(
    ("data", "options", "error", "words"),
    [
        (None, {}, ValueError, "give samples: data, or arrays x, y and value, or load with a"),
        (3, {}, TypeError, "data must be a path, a data frame, .* got int"),
        (POINTS, {}, ValueError, r"with data as an array of points \(n, d\), give the array value"),
        *(
            (data, {"value": PLANE}, ValueError, r"must have the shape \(n, 2\) or \(n, 3\); got")
            for data in (PLANE, PLANE[:, None], np.ones((60, 4)), np.ones((60, 2, 2)))
        ),
        (POINTS, {"value": PLANE[1:]}, ValueError, "equally long; got x 60, y 60, value 59"),
        (FRAME, {"value": PLANE}, ValueError, "value must be the name of a column of data; got an"),
        (FRAME, {"x": "lon"}, ValueError, "the data frame has no column 'lon'; it has east"),
        (
            NAMED.set_axis([*"xyz"], axis=1).assign(a=1, b=1),
            {"z": "z"},
            ValueError,
            "which column of the data frame is value; name it by",
        ),
        (FRAME.iloc[:0], {}, ValueError, "the data frame has no rows"),
        (FRAME, {"method": "kriging"}, ValueError, "there is no method 'kriging'; there are best"),
        (FRAME, {"grid": 5}, ValueError, "grid must be 2 numbers of nodes; got 5"),
        (FRAME, {"grid": (5, 1)}, ValueError, "each number of grid must be .* 2 or more; got 1"),
        (FRAME, {"at": FRAME}, ValueError, "give one of grid, at and mesh"),
        (FRAME, {"grid": None, "at": [[1.0]]}, ValueError, "at must have 2 coordinates per point"),
        (FRAME, {"load": "f.npz"}, ValueError, "give either samples or load"),
        (FRAME, {"crs": "EPSG:1"}, ValueError, "no coordinate reference system 'EPSG:1'"),
        ("nowhere.csv", {}, FileNotFoundError, "nowhere.csv"),
        (POINTS, {"value": 1j * PLANE}, ValueError, "value is complex; give its real and its"),
        (
            None,
            {"x": FRAME["east [m]"], "y": PLANE, "value": FRAME["depth [m]"][::-1]},
            ValueError,
            "x and value have different indices",
        ),
        (
            POINTS,
            {"value": FRAME["depth [m]"], "sigma": FRAME["depth [m]"][::-1]},
            ValueError,
            "value and sigma have different indices",
        ),
    ],
)
def test_what_is_no_table_is_refused(data, options, error, words):
    """The message names what was given and what is wanted."""
    with pytest.raises(error, match=words):
        plane(data, **options)


def test_data_with_named_columns_are_a_table():
    """Also those of one dimension; points alone are none."""
    named = (FRAME, dict(NAMED), NAMED.to_records(index=False), pa.table(NAMED), SET, SET["depth"])
    assert all(map(is_table, (*named, "a.csv", Path("a.csv"))))
    assert not any(map(is_table, (POINTS, POINTS.tolist(), PLANE, 3, None)))


# --- several values -------------------------------------------------------------------------------

VECTORS = pd.DataFrame(
    {
        "x": POINTS[:, 0],
        "y": POINTS[:, 1],
        "east [mm]": np.sin(4 * POINTS[:, 0]),
        "north [km]": 1e4 * POINTS[:, 1] ** 2 * POINTS[:, 0],
    }
)
BOTH = ["east [mm]", "north [km]"]


@pytest.mark.slow
def test_several_values_are_those_of_single_runs_of_their_method():
    """Values and errors to rounding; the score is a mean square of residuals per deviation."""
    both = plane(VECTORS, value=BOTH, method="tps")
    assert both.predict([0.5, 0.5]).values.shape == (2,)
    squares = []
    for k, name in enumerate(BOTH):
        one = plane(VECTORS, value=name, method="tps")
        size = abs(VECTORS[name]).max()
        found, alone = both.result.single(k), one.result
        np.testing.assert_allclose(found.values, alone.values, rtol=0, atol=1e-9 * size)
        np.testing.assert_allclose(found.error, alone.error, rtol=1e-6)
        residuals = both.validations[k].residuals / VECTORS[name].std(ddof=0)
        squares.append(np.mean(residuals**2))
    np.testing.assert_allclose(both.scores[0].rms, np.sqrt(np.mean(squares)), rtol=1e-9)
    assert any("One method was chosen for all values" in w for w in both.warnings)


@pytest.mark.slow
def test_the_method_of_several_values_does_not_depend_on_their_units():
    """Although one value in metres would outweigh another in kilometres."""
    scaled = VECTORS.assign(**{BOTH[0]: 1e9 * VECTORS[BOTH[0]]})
    found = [reconstruct(data, value=BOTH, grid=(3, 2)) for data in (VECTORS, scaled)]
    assert found[0].method == found[1].method
    np.testing.assert_allclose(found[0].chosen.rms, found[1].chosen.rms, rtol=1e-6)


@pytest.mark.slow
def test_several_values_are_written_in_columns(tmp_path):
    """By the command as from Python: in CSV, NPZ, NetCDF and VTK, and on the page."""
    table = tmp_path / "a.csv"
    VECTORS.to_csv(table, index=False)
    given = ["--value", BOTH[0], "--value", BOTH[1], "--grid", "3x2", "--method", "ls1"]
    folder = tmp_path / "out"
    out = ["--out", str(folder), "--format", "csv,npz,nc,vtk", "--save", str(tmp_path / "f.npz")]
    assert main(["reconstruct", str(table), *given, *out]) == 0
    survey = plane(VECTORS, value=BOTH)
    made = survey.to_dataframe()
    assert [*made] == [
        *("x", "y", "east [mm]", "error of east", "north [km]", "error of north", "extrapolated")
    ]
    stored = pd.read_csv(folder / "grid.csv")
    pd.testing.assert_frame_equal(stored, made, check_dtype=False, check_exact=True)
    with np.load(folder / "grid.npz") as arrays:
        assert arrays["values"].shape == arrays["error"].shape == (2, 3, 2)
    with xr.open_dataset(folder / "grid.nc", engine="scipy") as stored:
        assert stored.north.attrs["units"] == stored.error_of_north.attrs["units"] == "km"
        assert stored.east.attrs["ancillary_variables"] == "error_of_east extrapolated"
    assert b"SCALARS error_of_north double" in (folder / "grid.vtk").read_bytes()
    page = (folder / "summary.html").read_text(encoding="utf-8")
    assert page.count("<img") == 10
    assert "The error of the field: north [km]" in page
    again = plane(load=tmp_path / "f.npz")
    pd.testing.assert_frame_equal(again.to_dataframe(), made)
    assert survey.plot(BOTH[1]).axes[-1].get_ylabel() == "north [km]"
    with pytest.raises(ValueError, match="there is no value 'up'; there are east"):
        survey.plot("up")


def test_values_may_be_columns_of_an_array():
    """The first is drawn, if none is named."""
    values = np.column_stack([PLANE, -PLANE])
    survey = plane(POINTS, value=values, sigma=np.linspace(0.1, 0.2, 60))
    assert survey.samples.value_names == ("value_1", "value_2")
    np.testing.assert_allclose(survey.predict([0.25, 0.5]).values, [1.25, -1.25])
    assert survey.plot().axes[-1].get_ylabel() == "value_1"


# --- what comes out -------------------------------------------------------------------------------


def test_queries_have_any_shape():
    """Arrays have the shape of the queries; a masked or wrong one is refused."""
    survey = plane(FRAME)
    x = np.moveaxis(np.mgrid[0:1:3j, 0:1:4j], 0, -1)
    found = survey.predict(x)
    np.testing.assert_allclose(found.values, x @ [1.0, 2.0], atol=1e-12)
    assert found.error.shape == found.extrapolated.shape == (3, 4)
    assert survey.predict([0.5, 0.5]).values.shape == ()
    with pytest.raises(ValueError, match="points must have 2 coordinates per point"):
        survey.predict([[1.0, 2.0, 3.0]])


@pytest.mark.parametrize(("d", "parts"), [(4, ()), (1, ()), (2, (2, 2))])
def test_a_saved_field_of_other_variables_or_values_is_refused(tmp_path, d, parts):
    """Fields of one or four variables, and values that are matrices."""
    points = fr.datasets.uniform(20, d, seed=1)
    fr.save(tmp_path / "a.npz", fr.LeastSquares(points, 1).field(np.ones((20, *parts))))
    with pytest.raises(ValueError, match=rf"in {d} variables"):
        reconstruct(load=tmp_path / "a.npz", at=points)


def test_units_of_a_value_leave_those_of_the_coordinates():
    """A unit that is given replaces that of the value only."""
    data = SET.assign({name: SET[name].assign_attrs(units="m") for name in ("x", "y", "depth")})
    assert plane(data).samples.units == ("m", "m", "m")
    assert plane(data, units="km").samples.units == ("m", "m", "km")


def test_a_constant_beside_another_value_is_reproduced():
    """It has no standard deviation in whose units errors could be compared."""
    survey = plane(POINTS, value=np.stack([PLANE, np.full(60, 3.0)], axis=1))
    np.testing.assert_allclose(survey.result.values[..., 1], 3.0)
    assert np.isfinite(survey.predict(POINTS).error).all()


@pytest.mark.parametrize("d", [2, 3])
def test_without_targets_a_grid_covers_the_samples(d):
    """In the plane and in space, with as many nodes along each side."""
    points = fr.datasets.uniform(40, d, seed=1)
    survey = reconstruct(points, value=points.sum(axis=1), method="ls1")
    axes = survey.result.targets.axes
    assert len(axes) == d
    assert len({*map(len, axes)}) == 1
    assert 10_000 < len(survey.result.values) < 200_000
    for axis, x in zip(axes, points.T, strict=True):
        assert (axis[0], axis[-1]) == pytest.approx((x.min(), x.max()))


@pytest.mark.parametrize(
    ("method", "fitting"), [("ls1", ["fitting"]), ("pu", ["making patches", "fitting"])]
)
def test_each_stage_of_the_work_is_named_in_its_order(method, fitting):
    """No progress exceeds the total, and that of the evaluation ends with it."""
    seen = {}

    def stages(name):
        reports = seen.setdefault(name, [])
        return lambda done, total: reports.append((done, total))

    plane(FRAME, method=method, stages=stages)
    before = ["reading", "choosing the folds", "choosing a method"]
    after = ["evaluating", "leaving out each sample", "estimating the error"]
    assert [*seen] == [*before, *fitting, *after, "marking extrapolated targets"]
    assert all(0 <= done <= total for reports in seen.values() for done, total in reports)
    done, total = seen["evaluating"][-1]
    assert done == total


def test_a_data_frame_gives_a_data_frame_with_its_index():
    """It can be joined to its queries; without a coordinate there is no row."""
    survey = plane(FRAME)
    queries = FRAME[["north [m]", "east [m]"]].set_axis(range(96, 156)).iloc[5:20:3]
    found = survey.predict(queries)
    assert [*found] == ["depth [m]", "error", "extrapolated"]
    assert found.index.equals(queries.index)
    np.testing.assert_allclose(queries.join(found)["depth [m]"], PLANE[5:20:3])
    with pytest.raises(ValueError, match=r"the data frame, row 0: east.* must be a finite number"):
        survey.predict(queries.where(queries.index.to_series() != 101))


def test_xarray_gives_xarray_on_the_same_grid():
    """Also with axes that decrease; names and units are those of the samples."""
    survey = plane(SET.assign(depth=SET.depth.assign_attrs(units="fathoms")))
    grid = xr.Dataset(coords={"y": [1.0, 0.5, 0.0], "x": [0.0, 1.0]})
    found = survey.predict(grid)
    assert found.depth.dims == ("y", "x")
    np.testing.assert_allclose(found.depth, 2 * grid.y + grid.x + 0 * found.depth, atol=1e-12)
    assert found.depth.attrs["units"] == "fathoms"
    xr.testing.assert_equal(found.x, grid.x)
    at_samples = survey.predict(SET)
    assert at_samples.depth.dims == ("point",)
    np.testing.assert_allclose(at_samples.depth, PLANE)


@pytest.mark.slow
def test_targets_may_be_in_memory():
    """A data frame, a grid of xarray or an array; the result is a table of them."""
    some = FRAME.iloc[::7]
    found = plane(FRAME, grid=None, at=some).to_dataframe()
    assert [*found] == [*FRAME, "error", "extrapolated"]
    pd.testing.assert_frame_equal(found[[*FRAME]], some)
    grid = xr.Dataset(coords={"y": [1.0, 0.5], "x": [0.0, 1.0, 2.0]})
    assert plane(SET, grid=None, at=grid).to_xarray().depth.shape == (2, 3)
    np.testing.assert_allclose(plane(FRAME, grid=None, at=POINTS[:4]).result.values, PLANE[:4])


def test_bad_rows_of_targets_are_kept_without_values(tmp_path):
    """In data frames, CSV and NPZ, so that the rows are those of the table."""
    some = FRAME.iloc[10:16].copy()
    some.iloc[2, 0] = np.nan
    survey = plane(FRAME, grid=None, at=some)
    found = survey.to_dataframe()
    assert [*found.index] == [*range(10, 16)]
    assert [*found.index[found["depth [m]"].isna()]] == [12]
    assert found.loc[13, "extrapolated"] == survey.result.extrapolated[2]
    lines = survey.write(tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    assert [line.startswith(",,,") for line in lines] == [k == 3 for k in range(7)]
    with np.load(survey.write(tmp_path / "a.npz")) as arrays:
        assert np.flatnonzero(np.isnan(arrays["values"])).tolist() == [2]
        assert arrays["points"].shape == (6, 2)
    assert any("1 row is not a point; the first, row 2: east" in w for w in survey.warnings)


def test_errors_of_several_values_are_in_standard_deviations_of_each(capsys):
    """The page and the command say so above their tables of methods, and do not for one value."""
    for value in (PLANE, np.column_stack([PLANE, -PLANE])):
        survey = plane(POINTS, value=value)
        print_survey(survey)
        for words in (summary(survey, {}, {}), capsys.readouterr().out):
            assert ("in standard deviations of each value" in words) == (value.ndim == 2)


def test_methods_have_their_errors_or_the_reason_why_there_are_none(capsys):
    """The least error first; the method that was evaluated is marked on the page, no other one."""
    survey = plane(POINTS, value=np.sin(9 * PLANE))
    best = survey.chosen
    worse = replace(best, model=MODELS["tps"], residuals=10 * best.residuals)
    untried = replace(best, model=MODELS["pu"], residuals=None, reason="too many & too far")
    survey = replace(survey, scores=[untried, worse, best])
    page = summary(survey, {}, {})
    rows = re.findall(r'<tr([^>]*)><td>(\w+)</td><td class="words">[^<]*</td>(.*?)</tr>', page)
    shown = [(name, re.findall(r">([^<]+)<", cells)) for _, name, cells in rows]
    errors = [
        [f"{one.n_held_out}", f"{one.rms:.4g}", f"{one.largest:.4g}"] for one in (best, worse)
    ]
    assert shown == [("ls1", errors[0]), ("tps", errors[1]), ("pu", ["too many &amp; too far"])]
    assert [mark for mark, *_ in rows] == [' class="chosen"', "", ""]
    table = pd.read_csv(io.BytesIO(methods_csv(survey)), index_col="method")
    assert [*table.index] == ["ls1", "tps", "pu"]
    assert [*table["rms error"][:2]] == [best.rms, worse.rms]
    assert [*table["largest error"][:2]] == [best.largest, worse.largest]
    assert [*table["held out"][:2]] == [best.n_held_out] * 2
    assert table.loc["pu", ["held out", "rms error", "largest error"]].isna().all()
    assert [*table["remark"].isna()] == [True, True, False]
    assert untried.reason == table.loc["pu", "remark"]
    print_survey(survey)
    lines = capsys.readouterr().out.splitlines()
    shown = [re.split("  +", line) for line in lines[1:5]]
    numbers = [
        [one.n_held_out, *(float(f"{e:.4g}") for e in (one.rms, one.largest))]
        for one in (best, worse)
    ]
    assert lines[0] == "value at 60 points: error at held-out samples"
    assert [row[0] for row in shown] == ["method", shown[1][0], "ls1", "tps"]
    assert [[float(cell) for cell in row[2:]] for row in shown[2:]] == numbers
    assert lines[5:7] == ["", "pu: too many & too far."]
    assert [*lines[7:-2]] == survey.warnings
    assert lines[-2:] == [f"Evaluated: {survey.method}.", f"{survey.cost}."]


@pytest.mark.parametrize("number", [1, 2])
def test_the_page_has_the_coverage_and_the_variogram_of_each_value(number):
    """Every held-out sample is in one row; the headings name the values if there are several."""
    values = np.column_stack([np.sin(9 * PLANE), PLANE])[:, :number]
    survey = plane(POINTS, value=values[:, 0] if number == 1 else values)
    page = summary(survey, {}, {}, title="Depths", files=["a b.csv"])
    assert '<a href="a%20b.csv" download>a b.csv</a>' in page
    assert page.count("<h1>Depths</h1>") == 1
    headings = re.findall(r"<h2>(Coverage[^<]*)</h2>", page)
    of = [f" of {name}" for name in survey.samples.value_names] if number > 1 else [""]
    assert headings == [f"Coverage of the error{one} by distance" for one in of]
    cell = r'<td class="number">([^<]+)</td>'
    rows = re.findall(rf"<tr>{cell}{cell}{cell}</tr>", page)
    assert rows == [
        (far, f"{count}", f"{100 * share:.0f} %")
        for one in survey.validations
        for far, share, count in one.coverage()
    ]
    counts = [int(count) for _, count, _ in rows]
    assert sum(counts) == sum(len(one.residuals) for one in survey.validations)
    fitted = re.findall(rf"<tr><td>([^<]+)</td>{cell}{cell}{cell}</tr>", page)
    assert fitted == [
        (name, one.nugget_in_words, one.sill_in_words, one.range_in_words)
        for name, one in zip(
            survey.samples.value_names, map(survey.variogram, range(number)), strict=True
        )
    ]


def test_each_of_several_values_has_pictures_of_its_own():
    """They name it, also in their captions, and have its unit: here that of the other by 1000."""
    survey = plane(POINTS, value=np.sin(9 * PLANE)[:, None] * [1.0, 1000.0])
    names = survey.samples.value_names
    for kind, factor in (("variogram", 1e6), ("held_out", 1e3)):
        of_each = [picture(survey, kind, k).axes[0] for k in range(2)]
        for name, other, axes in zip(names, names[::-1], of_each, strict=True):
            words = f"{axes.get_xlabel()} {axes.get_ylabel()}"
            assert name in words
            assert other not in words
        (low, high), (one, other) = (axes.get_ylim() for axes in of_each)
        assert (other - one) / (high - low) == pytest.approx(factor)
        assert picture(survey, kind).axes[0].get_ylabel() == of_each[0].get_ylabel()
    drawn = {f"{kind}_{k}": b"" for kind in OF_EACH_VALUE for k in (1, 2)} | {"nearest": b""}
    captions = re.findall("<figcaption>([^<]+)<", summary(survey, {}, drawn))
    wanted = [f"{CAPTIONS[kind]}: {name}" for kind in OF_EACH_VALUE for name in names]
    assert captions == [*wanted, CAPTIONS["nearest"]]


def test_distances_on_the_globe_are_angles():
    """Of the targets, of the samples from each other, and of those that are held out, in bins."""
    x = fr.datasets.uniform(150, 2, seed=0) * [50, 40] + [-20, 30]
    samples, targets = x[:100], x[100:]
    found = reconstruct(samples, value=samples[:, 1], lonlat=True, method="ls1", at=targets)
    known = found.validations[0]

    def angles(a, b):
        (lon, lat), (east, north) = np.radians(a.T[:, :, None]), np.radians(b.T)
        turned = np.cos(lat) * np.cos(north) * np.sin((lon - east) / 2) ** 2
        return np.degrees(2 * np.arcsin(np.sqrt(turned + np.sin((lat - north) / 2) ** 2)))

    wanted = angles(targets, samples).min(axis=1)
    np.testing.assert_allclose(np.sort(known.targets), np.sort(wanted))
    own = (angles(samples, samples) + 999 * np.eye(100)).min(axis=1)
    np.testing.assert_allclose(known.leave_one_out, np.sort(own))
    np.testing.assert_allclose(_degrees(np.array([0, 1, 2**0.5, 2])), [0, 60, 90, 180])
    assert _degrees(np.nextafter(2.0, 3.0)) == 180  # a chord that is rounded up
    assert known.coverage()[-1][0] == known.farthest == f"{known.held_out.max():.3g} degrees"
    assert known.sentence.count(" degrees") in (4, 5)


@pytest.mark.parametrize(("ratio", "alike"), [(1.19, True), (0.81, True), (1.21, False)])
def test_distances_are_alike_whose_quantiles_differ_by_a_fifth_of_their_mean(ratio, alike):
    """The page has the medians and the ninth deciles of both, and how samples were held out."""
    targets = np.linspace(0, 20, 101)
    found = Validation(None, targets, ratio * targets, 3 * targets, np.zeros(7), np.zeros(7), " m")
    assert found.is_matched_by_leave_one_out == alike
    median, tenth = f"{10 * ratio:.3g}", f"{18 * ratio:.3g}"
    told = (
        "The targets have a median distance of 10 m from the nearest sample, the samples of "
        f"{median} m from each other; a tenth have more than 18 m and {tenth} m. "
    )
    assert found.sentence.startswith(told)
    assert f" estimated at 7 samples that were held out {'with few' if alike else 'together'}" in (
        found.sentence
    )
    assert ("a median distance of 30 m (" in found.sentence) != alike
    assert found.farthest == "60 m"


@pytest.mark.parametrize("number", [1, 2])
def test_each_error_is_said_to_depend_on_the_distance_and_a_power_of_the_roughness(number):
    """That of its band; it names its value if there are several."""
    values = np.column_stack([PLANE, np.sin(9 * PLANE)])
    survey = plane(POINTS, value=values[:, 0] if number == 1 else values)
    of = [f" of {name}" for name in survey.samples.value_names] if number > 1 else [""]
    for exponent, power in ((0.0, ""), (0.5, "the root of the roughness"), (1.0, "the roughness")):
        known = [replace(one, band=copy(one.band)) for one in survey.validations]
        for one in known:
            one.band.exponent = exponent
        words = replace(survey, validations=known).warnings
        said = [sentence for sentence in words if sentence.startswith("The given error")]
        assert [one.partition(" bounds ")[0] for one in said] == [f"The given error{o}" for o in of]
        by = f"the nearest sample{f' and of {power} of the field there' if power else ''}. "
        assert all(by in sentence for sentence in said)


def test_the_error_of_a_value_is_larger_where_this_value_is_rough():
    """One is noise on the left and zero on the right, the other one the reverse."""
    left = POINTS[:, 0] < 0.5
    noise = np.random.default_rng(0).standard_normal(60)
    survey = plane(POINTS, value=np.column_stack([noise * left, noise * ~left]))
    error = survey.predict(POINTS).error
    assert error[left, 0].mean() > 2 * error[~left, 0].mean()
    assert error[~left, 1].mean() > 2 * error[left, 1].mean()


def test_the_variogram_of_a_survey_is_that_of_its_samples():
    """Of the first value by default; on the globe of unit vectors, in degrees."""
    values = np.column_stack([np.sin(9 * PLANE), PLANE**2])
    survey = plane(POINTS, value=values)
    for found, column in (
        (survey.variogram(), 0),
        (survey.variogram(0), 0),
        (survey.variogram(1), 1),
    ):
        np.testing.assert_allclose(found.values, variogram(POINTS, values[:, column]).values)
    on_globe = plane(POINTS, value=PLANE, lonlat=True).variogram()
    flat = POINTS * [np.cos(np.radians(0.5)), 1.0]
    np.testing.assert_allclose(on_globe.distances, variogram(flat, PLANE).distances, rtol=1e-3)
    assert on_globe.unit == " degrees"


def test_nine_samples_have_no_picture_of_their_variogram():
    """Those of the field, its error and the distances from the samples are drawn."""
    drawn = pictures(plane(POINTS[:9], value=PLANE[:9]))
    assert {"reconstruction", "error", "nearest"} <= {*drawn}
    assert "variogram" not in drawn


@pytest.mark.slow
def test_the_result_describes_itself(tmp_path):
    """In a line, in a picture, on a page and in files; the method and the scores are named."""
    survey = plane(FRAME)
    assert repr(survey).startswith("<SurveyResult: depth [m] from 60 samples of data frame, at 6 ")
    assert survey.method == "ls1, least squares, plane"
    own = np.sort(cdist(POINTS, POINTS) + 9 * np.eye(60), axis=1)[:, 0]
    np.testing.assert_allclose(survey.validations[0].leave_one_out, np.sort(own))
    assert "rms error" in repr(survey.scores[0])
    assert "<SurveyResult" not in (page := survey.report(tmp_path / "a.html").read_text())
    assert page.count("<img") == 6
    assert "depth [m], reconstructed" in page
    for suffix in ("csv", "npz", "nc", "vtk"):
        assert survey.write(tmp_path / f"a.{suffix}").stat().st_size > 100
    stored, made = pd.read_csv(tmp_path / "a.csv"), survey.to_dataframe()
    pd.testing.assert_frame_equal(stored, made, check_dtype=False, check_exact=True)
    assert survey.plot().axes[-1].get_ylabel() == "depth [m]"
    assert survey.plot_error().axes[-1].get_ylabel() == "error of depth [m]"


@pytest.mark.slow
def test_the_command_writes_what_the_function_returns(tmp_path):
    """The same values from the table in a file, for the same options."""
    table = tmp_path / "a.csv"
    FRAME.to_csv(table, index=False)
    out = ["--out", str(tmp_path / "b.csv"), "--grid", "3x2", "--method", "ls1"]
    assert main(["reconstruct", str(table), *out]) == 0
    stored, made = pd.read_csv(tmp_path / "b.csv"), plane(FRAME).to_dataframe()
    pd.testing.assert_frame_equal(stored, made, check_dtype=False, check_exact=True)
    pd.testing.assert_frame_equal(plane(table).to_dataframe(), plane(str(table)).to_dataframe())


@pytest.mark.slow
def test_title_units_colors_and_links_are_chosen_by_options(tmp_path):
    """The page links to every other file; units given by an option replace those of the name."""
    FRAME.to_csv(tmp_path / "a.csv", index=False)
    folder = tmp_path / "a folder"
    look = ["--title", "Depths <1>", "--units", "fathoms", "--colors", "cividis"]
    to = ["--out", str(folder), "--grid", "3x2", "--method", "ls1"]
    assert main(["reconstruct", str(tmp_path / "a.csv"), *to, *look]) == 0
    page = (folder / "summary.html").read_text(encoding="utf-8")
    assert "<h1>Depths &lt;1&gt;</h1>" in page
    linked = {*re.findall(r'<a href="([^"]+)" download', page)}
    assert linked == {file.name for file in folder.iterdir()} - {"summary.html"}
    survey = plane(FRAME, units="fathoms")
    assert survey.to_xarray().depth.attrs["units"] == "fathoms"
    picture = survey.plot(colors="cividis")
    assert picture.axes[-1].get_ylabel() == "depth [fathoms]"
    assert picture.axes[0].images[0].get_cmap().name == "cividis"
    with pytest.raises(ValueError, match="there is no colour map 'rainbows'; there are viridis"):
        survey.plot(colors="rainbows")
    with pytest.raises(ValueError, match="units must be 1, one for each value; got m, km"):
        plane(FRAME, units=["m", "km"])


def test_a_saved_field_is_evaluated(tmp_path):
    """As with the option of the command."""
    survey = plane(FRAME)
    fr.save(tmp_path / "f.npz", survey.field, survey.samples.names)
    again = plane(load=tmp_path / "f.npz")
    pd.testing.assert_frame_equal(again.to_dataframe(), survey.to_dataframe())


@pytest.mark.slow
@pytest.mark.parametrize("missing", ["pandas", "xarray"])
def test_the_library_works_without_pandas_and_xarray(missing):
    """Neither is imported by the library, and a missing one is named with its extra."""
    code = (
        f"import sys; sys.modules[{missing!r}] = None\n"
        "import fieldrecon as fr\n"
        "points = fr.datasets.uniform(9, 2, seed=0)\n"
        "s = fr.pipelines.reconstruct(points, value=points[:, 0], method='ls1', grid=(3, 2))\n"
        "assert not {'pandas', 'xarray'} & {k for k, v in sys.modules.items() if v}\n"
        f"s.{'to_dataframe' if missing == 'pandas' else 'to_xarray'}()\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert f"{missing} is not installed; it comes with the extra 'frames'" in done.stderr


# --- surfaces and audits --------------------------------------------------------------------------


@pytest.mark.slow
def test_points_in_memory_become_a_closed_mesh_and_a_damaged_mesh_is_repaired(tmp_path):
    """The mesh of a ball is closed; after removal of one triangle the audit repairs it."""
    points, normals = sample_surface(Ball(1.0), 300, seed=1)
    table = pd.DataFrame(np.hstack([points, normals]), columns=[*"xyz", "nx", "ny", "nz"])
    np.savetxt(tmp_path / "ball.xyz", points)
    scan = surface(tmp_path / "ball.xyz")
    assert scan.sound(open_allowed=False)
    assert not scan.own_normals
    np.testing.assert_array_equal(surface(points).points, scan.points)
    with_normals = surface(table)
    assert with_normals.own_normals
    np.testing.assert_array_equal(surface(points, normals=normals).points, with_normals.points)
    np.testing.assert_array_equal(surface(table, normals="estimate").points, scan.points)
    assert scan.write(tmp_path / "ball.stl") == tmp_path / "ball.stl"
    damaged = tmp_path / "open.stl"
    fr.io.write_triangles(damaged, scan.points, scan.mesh.triangles[1:])
    found = audit(damaged)
    assert found.repair is None
    assert not found.sound()
    assert found.sound(open_allowed=True)
    assert found.findings == {"boundary_loops": 1}
    mended = audit((scan.points, scan.mesh.triangles[1:]), repair=True)
    assert mended.findings == found.findings
    assert mended.sound()
    assert audit(scan).findings == {}
    assert audit(mended.write(tmp_path / "b.stl")).findings == {}
    assert "1 boundary_loops" in repr(found)
    assert "sound" in repr(scan)


def test_what_is_no_scan_or_mesh_is_refused():
    """The message names what was given and what is wanted."""
    with pytest.raises(ValueError, match="has no column 'z'; points in space have x, y and z"):
        surface(POINTS)
    with pytest.raises(ValueError, match="holds 5 points; a surface takes 10 at least"):
        surface(np.eye(5)[:, :3])
    with pytest.raises(ValueError, match="normals must be 'file', 'estimate' or an array"):
        surface(np.eye(12)[:, :3], normals="own")
    with pytest.raises(ValueError, match="smoothing is for points"):
        surface(np.eye(12)[:, :3], smoothing=1, polygons=1)
    with pytest.raises(TypeError, match="data must be a path, a pair of points and triangles"):
        audit(3)


def test_extrapolated_targets_are_counted_and_those_outside_the_hull_of_these():
    """Of five, two lie far away; if none does, that is said."""
    points = fr.datasets.uniform(60, 2, seed=0)
    table = {"x": points[:, 0], "y": points[:, 1], "f": points @ [1.0, 2.0]}
    among = np.array([[0.5, 0.5], [0.4, 0.6], [0.3, 0.3]])
    x = np.vstack([among, [[8.0, 8.0], [9.0, 9.0]]])
    survey = reconstruct(table, value="f", method="ls1", at=x)
    assert survey.result.extrapolated.tolist() == [0, 0, 0, 2, 2]
    words = " ".join(survey.warnings)
    assert "2 of 5 " in words
    assert "; 2 of these lie outside" in words
    assert "None of the 3 " in " ".join(
        reconstruct(table, value="f", method="ls1", at=among).warnings
    )


def scan_of_a_ball(**changed):
    """A scan whose points have a spacing of 0.1, without the fit."""
    mesh = extract_surface(Ball(1.0), spacing=0.25)
    gaps = mesh.points[mesh.triangles].mean(axis=1)[:, 2] > 0.25
    known = SimpleNamespace(warnings=(), spacing=0.1, points=np.zeros((9, 3)))
    given = {"mesh": mesh, "distances": np.zeros(9), "gaps": gaps} | changed
    return ScanResult(known, np.zeros(3), known, **given, own_normals=False, source="a ball")


def test_the_quality_of_a_mesh_is_that_of_the_distances_of_its_points():
    scan = scan_of_a_ball(distances=np.random.default_rng(0).permutation(np.arange(101.0)) ** 2)
    root = np.sqrt(np.sum(np.arange(101.0) ** 4) / 101)
    assert [*scan.quality.values()] == pytest.approx([root, 50**2, 95**2, 100**2])


def test_the_invented_surface_is_a_part_of_the_area():
    """By Archimedes, above the height h of a ball lies the part (1 - h) / 2 of its surface."""
    (sentence, *others) = scan_of_a_ball().warnings
    share, far = re.fullmatch(
        r"([\d.]+) % of the surface is farther than ([\d.]+) from all points: .*", sentence
    ).groups()
    assert float(share) == pytest.approx(37.5, abs=2)
    assert far == "0.3"
    assert len(others) == 2
    count = len(scan_of_a_ball().mesh.triangles)
    assert len(scan_of_a_ball(gaps=np.zeros(count, dtype=bool)).warnings) == 2
    for known in (0, 1):
        sentence = scan_of_a_ball(gaps=np.arange(count) >= known).warnings[0]
        assert sentence.startswith("100 % of the surface is farther than 0.3 from all points")
    assert re.match(r"0\.\d+ % of", scan_of_a_ball(gaps=np.arange(count) < 1).warnings[0])


@pytest.mark.parametrize(
    ("share", "words"),
    [(0.00123, "0.12 %"), (0.9949, "99 %"), (0.995, "100 %"), (0.9999, "100 %"), (1.0, "100 %")],
)
def test_a_part_is_written_in_percent_without_a_power_of_ten(share, words):
    assert _percent(share) == words


@pytest.mark.parametrize("few", [1, 2])
def test_a_mesh_that_is_cut_off_or_far_from_points_is_not_sound(few):
    """The surface may be cut off, or have a boundary, where it is allowed to be open."""
    mesh = scan_of_a_ball().mesh
    assert scan_of_a_ball().sound(open_allowed=False)
    cut = scan_of_a_ball(mesh=replace(mesh, cut=np.arange(few)))
    missed = scan_of_a_ball(mesh=replace(mesh, missed=np.arange(few)))
    opened = scan_of_a_ball(
        mesh=replace(mesh, triangles=mesh.triangles[1:]),
        gaps=np.zeros(len(mesh.triangles) - 1, dtype=bool),
    )
    sound = [[one.sound(open_allowed=o) for o in (False, True)] for one in (cut, missed, opened)]
    assert sound == [[False, True], [False, False], [False, True]]
    assert any(f"was cut off, at {few} vertices" in words for words in cut.warnings)
    points = "1 point has" if few == 1 else "2 points have"
    assert any(words.startswith(f"{points} no surface nearby") for words in missed.warnings)
    assert any("and is open; found: 1 " in words for words in opened.warnings)
    assert any(words.endswith("and is closed.") for words in cut.warnings)


@pytest.mark.slow
def test_scans_and_audits_make_pages(tmp_path):
    """With a picture, what was found, and its parameters."""
    points = sample_surface(Ball(1.0), 300, seed=1)[0]
    scan = surface(points)
    page = scan.report(tmp_path / "a.html", {"edge": 0.1}).read_text()
    assert page.count("<img") == 1
    assert "300 of 300 points of points in memory" in page
    assert re.search(r"edge</t[dh]>\s*<td[^>]*>0.1<", page)
    found = audit((scan.points, scan.mesh.triangles[1:]), repair=True)
    page = found.report(tmp_path / "b.html").read_text()
    assert page.count("<img") == 1
    assert "Left: nothing." in page
    assert len(found.plot().axes) == 2


def test_arguments_of_a_kernel_have_names_of_their_own():
    """On the page of a survey nested arguments are listed one by one, of a list by number."""
    described = {"name": "RBF", "kernel": {"name": "matern", "scale": 2.0}, "degree": None}
    assert _flattened(described) == {"name": "RBF", "kernel": "matern", "kernel scale": 2.0}
    parts = [{"name": "a", "degree": 0, "counts": [1, 2]}, {"name": "b", "kernel": {"name": "c"}}]
    assert _flattened({"methods": parts}) == {
        "methods 1": "a",
        "methods 1 degree": 0,
        "methods 1 counts": [1, 2],
        "methods 2": "b",
        "methods 2 kernel": "c",
    }


@pytest.mark.parametrize(
    "draw",
    [
        lambda: surface_page.picture(scan_of_a_ball()),
        lambda: audit_page.picture(audit((np.eye(3), [[0, 1, 2]]))),
        lambda: picture(plane(FRAME), "reconstruction"),
    ],
)
def test_without_the_packages_that_draw_their_extra_is_named(monkeypatch, draw):
    """Before the work, although only one of them is missing, that of the fonts."""
    find = extras.find_spec
    monkeypatch.setattr(extras, "find_spec", lambda name: None if name == "typst" else find(name))
    with pytest.raises(ModuleNotFoundError, match=r"typst is not installed; .* extra 'pictures'"):
        draw()


def words_of(page):
    """The text of a page, without its tags."""
    return " ".join(re.sub("<[^>]*>", " ", page.partition("<body>")[2]).split())


def test_parameters_on_a_page_are_short():
    """Six digits of a number, the shape of an array, and the items of a list."""
    parameters = {
        "scale": 1 / 3,
        "count": 1234567,
        "counts": (3, 2),
        "names": ["a", "b"],
        "one": ["a"],
        "name": "a b",
        "smoothing": np.ones((4, 2)),
        "number": np.array(0.5),
    }
    assert words_of(f"<body>{pairs(parameters)}") == (
        "scale 0.333333 count 1234567 counts 3 × 2 names a, b one a name a b "
        "smoothing 4 × 2 numbers number 0.5"
    )


def test_the_page_of_an_audit_counts_the_errors_and_says_what_is_left(monkeypatch):
    """Without the packages that draw it has no picture, and all else."""
    monkeypatch.setattr(audit_page, "absent", lambda *_: ["typst"])
    points, triangles = scan_of_a_ball().mesh.points, scan_of_a_ball().mesh.triangles
    points = np.vstack([points, [[9.0, 9, 9]]])
    apart = np.flatnonzero(~np.isin(triangles, triangles[0]).any(axis=1))[0]
    damaged = np.delete(triangles, [0, apart], axis=0)
    found = audit((points, damaged))
    page = words_of(audit_page.audit_page(found, {"--open": True}))
    assert f"{len(damaged):,} triangles and {len(points):,} vertices; tolerance" in page
    assert "What to know 3 errors were found. Errors" in page
    assert "boundary 2 boundary loops" in page
    assert "--open True" in page
    assert "Repaired" not in page
    mended = audit((points, damaged), repair=True)
    page = words_of(audit_page.audit_page(mended, {}))
    assert repr(found).endswith("2 boundary_loops>")
    assert repr(mended).endswith("2 boundary_loops; repaired, 0 left>")
    assert "3 errors were found. Repaired: " in page
    assert "2 filled holes" in page
    assert "Left: nothing." in page
    whole = audit((points[:-1], triangles), repair=True)
    page = audit_page.audit_page(whole, {})
    assert "<img" not in page
    assert "Nothing is wrong: closed, oriented, without self-intersections." in page
    assert "<h2>Errors" not in page
    assert "Repaired: nothing." in page


def test_the_page_of_a_surface_has_the_distances_of_the_points(monkeypatch, capsys):
    """With three digits, what was found, and a picture only if it is given or can be drawn."""
    scan = scan_of_a_ball(distances=np.random.default_rng(0).random(99))
    assert 'base64,YWJj"' in surface_page.surface_page(scan, [], {}, b"abc")
    monkeypatch.setattr(surface_page, "absent", lambda *_: ["typst"])
    page = surface_page.surface_page(scan, ["One <thing>."], {"--edge": 0.5})
    assert "One &lt;thing&gt;." in page
    assert np.array_equal([surface_page.UP[axis] for axis in "xyz"], np.eye(3))
    shown = words_of(page)
    for what, distance in scan.quality.items():
        assert f"{what} {distance:.3g} " in shown
    print_scan(Path("ball.ply"), scan, ["One."], "3 s")
    title, *table, _, one, cost = capsys.readouterr().out.splitlines()
    assert title == "ball.ply: distances of 9 of 9 points from the mesh"
    assert [line.split()[-1] for line in table[2:]] == [f"{d:.4g}" for d in scan.quality.values()]
    assert (one, cost) == ("One.", "3 s.")
    assert "From 9 of 9 points of a ball." in shown
    assert "--edge 0.5 fieldrecon" in shown
    assert "<img" not in page
