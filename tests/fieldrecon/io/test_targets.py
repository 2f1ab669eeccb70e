"""Target points and the files of their values: what is written can be read back."""

import csv
from dataclasses import replace

import meshio
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import netcdf_file

import fieldrecon as fr
from fieldrecon.io.frames import Frame
from fieldrecon.io.targets import (
    Targets,
    TargetValues,
    grid_nodes,
    grid_over,
    targets_of_mesh,
    targets_of_table,
)
from fieldrecon.io.values import FORMATS, as_formats

NAMES = ("east [m]", "north", "up", "a b/c")


def result_at(targets, lonlat=False):
    """Values, errors and flags that differ from point to point."""
    points = targets.points
    m, d = points.shape
    values = points @ np.array([1.0, np.pi, np.e])[:d] + 1 / 3
    return TargetValues(
        (*NAMES[:d], NAMES[-1]),
        targets,
        values,
        np.sqrt(abs(values)),
        (np.arange(m) % 3).astype(np.int8),
        lonlat,
    )


MESH = fr.SimplexMesh.delaunay(fr.datasets.uniform(30, 2, seed=0))
SOLID = fr.SimplexMesh.delaunay(fr.datasets.uniform(30, 3, seed=0))
TARGETS = {
    "grid": grid_over(np.array([[0.0, 0.0], [0.1, 1 / 3]]), (4, 3)),
    "grid in space": grid_over(np.array([[0.0, 0.0, 1.0], [0.1, 1 / 3, 2.0]]), (4, 3, 2)),
    "points": Targets(fr.datasets.uniform(7, 2, seed=0)),
    "points in space": Targets(fr.datasets.uniform(7, 3, seed=0)),
    "mesh": Targets(MESH.points, cells=MESH.cells),
    "mesh in space": Targets(SOLID.points, cells=SOLID.cells),
    "surface": Targets(SOLID.points, cells=SOLID.cells[:, :3]),
}
each_kind = pytest.mark.parametrize("targets", TARGETS.values(), ids=TARGETS)


# --- files --------------------------------------------------------------------------------------


@each_kind
def test_csv_files_keep_every_digit(tmp_path, targets):
    """The columns have the names of the samples."""
    result = result_at(targets)
    FORMATS["csv"](tmp_path / "a.csv", result)
    with (tmp_path / "a.csv").open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert header == [*result.names[:-1], "a b/c", "error", "extrapolated"]
    numbers = np.array(rows, dtype=float)
    d = targets.points.shape[1]
    assert np.array_equal(numbers[:, :d], targets.points)
    assert np.array_equal(numbers[:, d:], np.column_stack([*result.columns.values()]))


def test_csv_files_are_written_in_blocks_of_rows(tmp_path, monkeypatch):
    """The file does not depend on where a block ends."""
    result = result_at(TARGETS["points"])
    FORMATS["csv"](tmp_path / "whole.csv", result)
    for rows in (1, 3, 7, 8):
        monkeypatch.setattr("fieldrecon.io.values._ROWS", rows)
        FORMATS["csv"](tmp_path / "a.csv", result)
        assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


@each_kind
def test_npz_files_keep_axes_points_and_cells(tmp_path, targets):
    """A grid has axes and shaped arrays; other targets have points, and a mesh also its cells."""
    result = result_at(targets)
    FORMATS["npz"](tmp_path / "a.npz", result)
    with np.load(tmp_path / "a.npz", allow_pickle=False) as stored:
        arrays = dict(stored)
    assert arrays["values"].shape == targets.shape
    assert np.array_equal(arrays["values"].ravel(), result.values)
    assert np.array_equal(arrays["error"].ravel(), result.error)
    assert np.array_equal(arrays["extrapolated"].ravel(), result.extrapolated)
    if targets.axes:
        x, y = arrays["x"], arrays["y"]
        assert arrays["values"].shape[-2:] == (len(y), len(x))
        at = np.array([x[1], y[2], *(arrays["z"][:1] if "z" in arrays else ())])
        one = Targets(at[None, :])
        assert arrays["values"][..., 2, 1].ravel()[0] == pytest.approx(result_at(one).values[0])
    else:
        assert np.array_equal(arrays["points"], targets.points)
    assert ("cells" in arrays) == (targets.cells is not None)


@each_kind
def test_vtk_files_keep_points_data_and_cells(tmp_path, targets):
    """meshio reads the same points, values and cells, to the last bit."""
    result = result_at(targets)
    FORMATS["vtk"](tmp_path / "a.vtk", result)
    mesh = meshio.read(tmp_path / "a.vtk")
    d = targets.points.shape[1]
    assert np.array_equal(mesh.points[:, :d], targets.points)
    assert not mesh.points[:, d:].any()
    for name, column in (("a_b/c", result.values), ("error", result.error)):
        assert np.array_equal(mesh.point_data[name].ravel(), column)
    assert np.array_equal(mesh.point_data["extrapolated"].ravel(), result.extrapolated)
    if not targets.axes:
        corners = 1 if targets.cells is None else targets.cells.shape[1]
        assert mesh.cells[0].type == {1: "vertex", 3: "triangle", 4: "tetra"}[corners]
    if targets.cells is not None:
        assert np.array_equal(mesh.cells[0].data, targets.cells)


@each_kind
def test_netcdf_files_keep_variables_and_dimensions(tmp_path, targets):
    """Variables have the dimensions of the grid or of the points; flags state their meanings."""
    result = result_at(targets)
    FORMATS["nc"](tmp_path / "a.nc", result)
    assert (tmp_path / "a.nc").read_bytes().startswith(b"CDF\x02")  # offsets of 64 bits
    with netcdf_file(tmp_path / "a.nc", mmap=False) as file:
        value = file.variables["a_b_c"]
        assert np.array_equal(value.data.ravel(), result.values)
        assert value.long_name == b"a b/c"
        coordinates = targets.axes or targets.points.T
        for name, axis in zip(("east", "north", "up"), coordinates, strict=False):
            assert np.array_equal(file.variables[name].data, axis)
        named = {n for n, variable in file.variables.items() if hasattr(variable, "coordinates")}
        assert named == (set() if targets.axes else {"a_b_c", "error", "extrapolated"})
        flags = file.variables["extrapolated"]
        assert flags.flag_meanings == b"among_the_samples in_a_gap outside"
        assert np.array_equal(flags.data.ravel(), result.extrapolated)
        wanted = ("up", "north", "east")[-len(targets.axes) :] if targets.axes else ("point",)
        assert value.dimensions == wanted


def test_longitude_and_latitude_have_cf_units(tmp_path):
    """The units are those of the climate and forecast (CF) conventions."""
    FORMATS["nc"](tmp_path / "a.nc", result_at(TARGETS["grid"], lonlat=True))
    with netcdf_file(tmp_path / "a.nc", mmap=False) as file:
        assert file.variables["east"].units == b"degrees_east"
        assert file.variables["north"].units == b"degrees_north"


@pytest.mark.parametrize("kind", FORMATS)
def test_clashing_names_are_made_unique(tmp_path, kind):
    """A value may be called "error"; coordinates may have names that are not ASCII."""
    result = result_at(TARGETS["points"])
    odd = TargetValues(
        ("ä", "ö", "error"), result.targets, result.values, result.error, result.extrapolated
    )
    assert list(odd.columns) == ["error", "error_2", "extrapolated"]
    FORMATS[kind](tmp_path / "a", odd)
    assert (tmp_path / "a").stat().st_size > 100


def test_formats_are_recognized_by_their_suffix():
    """The dot and the case do not matter; unknown formats are refused."""
    assert as_formats([".CSV", " nc"]) == ["csv", "nc"]
    with pytest.raises(ValueError, match="no format 'tif'; there are csv, npz, vtk, nc"):
        as_formats(["tif"])


# --- targets -------------------------------------------------------------------------------------


def test_x_varies_fastest_in_grid_nodes():
    """Nodes have the order of the pixels in an image, row by row."""
    nodes = grid_nodes((np.array([0.0, 1.0]), np.array([5.0, 6.0, 7.0])))
    assert nodes.tolist() == [[0, 5], [1, 5], [0, 6], [1, 6], [0, 7], [1, 7]]


@given(
    middle=st.floats(-180, 179),
    width=st.floats(1, 340),
    seed=st.integers(0, 100),
)
def test_a_grid_of_longitudes_spans_the_data_only(middle, width, seed):
    """The grid is as wide as the data and contains each of them, also across the date line."""
    turned = middle + width * np.append(fr.datasets.uniform(200, 1, seed)[:, 0], [0, 1])
    longitudes = (turned + 180) % 360 - 180
    points = np.column_stack([longitudes, np.zeros(202)])
    points[0, 1] = 1.0
    x = grid_over(points, (5, 2), lonlat=True).axes[0]
    widest = np.diff(np.sort(turned)).max()
    if widest < 360 - width:
        assert np.ptp(x) == pytest.approx(width, abs=1e-6)
    assert ((longitudes - x[0] + 1e-6) % 360 <= np.ptp(x) + 2e-6).all()
    assert -180 <= x[0] < 180


@pytest.mark.parametrize(
    ("longitudes", "first", "last"),
    [
        ([*range(10, 351, 10), 359.5], 10.0, 359.5),
        ([*range(0, 171, 10), 180.5, *range(190, 351, 10)], -179.5, 170.0),
        ([-180.0, -100.0], -180.0, -100.0),
        ([-179.5, -100.0], -179.5, -100.0),
        ([180.0, -100.0], -180.0, -100.0),
        ([540.5, 620.0], -179.5, -100.0),
        ([179.5, -100.0], 179.5, 260.0),
        ([7.0], 7.0, 7.0),
    ],
)
def test_a_grid_of_longitudes_begins_after_the_widest_gap(longitudes, first, last):
    """From a longitude of -180 up to 180, excluding it."""
    points = np.column_stack([longitudes, np.zeros(len(longitudes))])
    x = grid_over(points, (2, 2), lonlat=True).axes[0]
    np.testing.assert_allclose(x, [first, last], atol=1e-9)


def test_a_grid_of_longitudes_is_the_shortest_over_them():
    """The literal way: from one of the longitudes eastward to the last of the others."""
    for longitudes in np.random.default_rng(0).uniform(-180, 180, (100, 4)):
        x = grid_over(np.column_stack([longitudes] * 2), (2, 2), lonlat=True).axes[0]
        widths = (longitudes - longitudes[:, None]) % 360
        assert np.ptp(x) == pytest.approx(widths.max(axis=1).min())


def test_impossible_grids_are_refused():
    """A grid must have as many sides as there are variables, and must fit into memory."""
    points = np.array([[0.0, 0.0], [1.0, 1.0]])
    with pytest.raises(ValueError, match="a grid in 2 variables has 2 sides; got 2x2x2"):
        grid_over(points, (2, 2, 2))
    with pytest.raises(ValueError, match=r"at most 4e\+08 nodes; got 100000x100000"):
        grid_over(points, (100_000, 100_000))


def test_target_tables_need_the_columns_of_the_samples(tmp_path):
    """Columns are found by name, in any order; bad rows are skipped and reported."""
    path = tmp_path / "at.csv"
    path.write_text("id,y,x\n1,2,3\n2,?,4\n3,95,6\n")
    targets = targets_of_table(path, ("x", "y"))
    assert targets.points.tolist() == [[3, 2], [6, 95]]
    assert (targets.kind, targets.shape) == ("points", (2,))
    assert targets.bad == ((3, "y must be a finite number; got '?'", 1),)
    assert len(targets_of_table(path, ("x", "y"), lonlat=True).bad) == 2
    with pytest.raises(ValueError, match=r"at\.csv, line 3: y must be a finite number"):
        targets_of_table(path, ("x", "y"), strict=True)
    path.write_text("1 234\n2 3\n")
    assert targets_of_table(path, ("y", "x")).points.tolist() == [[234, 1], [3, 2]]
    path.write_text("id,y,x\n1,2,3\n")
    with pytest.raises(ValueError, match="has no column 'z', as the samples have; it has id, y, x"):
        targets_of_table(path, ("x", "y", "z"))


def test_targets_on_the_globe_reach_to_the_poles(tmp_path):
    """Beyond them there is no latitude; a longitude is any finite number."""
    path = tmp_path / "at.csv"
    path.write_text("lon,lat\n0,90\n-1e3,-90\n7,90.001\n8,-90.001\n")
    targets = targets_of_table(path, ("lon", "lat"), lonlat=True)
    assert targets.points.tolist() == [[0, 90], [-1000, -90]]
    assert [row.row for row in targets.bad] == [2, 3]


def test_npz_files_keep_the_rows_of_a_table_of_targets(tmp_path):
    """Two values at each target: in a bad row, both are missing."""
    path = tmp_path / "at.csv"
    path.write_text("x,y\n3,2\n2,?\n6,95\n7,5\n")
    targets = targets_of_table(path, ("x", "y"))
    values = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])
    names, marks = ("x", "y", "east", "north"), np.zeros(3, np.int8)
    FORMATS["npz"](tmp_path / "a.npz", TargetValues(names, targets, values, 10 * values, marks))
    with np.load(tmp_path / "a.npz") as stored:
        found = {name: stored[name] for name in ("points", "values", "error")}
    good = [0, 2, 3]
    assert np.array_equal(found["points"][good], targets.points)
    assert np.array_equal(found["values"][good], values)
    assert np.array_equal(found["error"][good], 10 * values)
    assert all(np.isnan(array[1]).all() and array.shape == (4, 2) for array in found.values())


def test_npz_files_keep_several_values_on_a_grid(tmp_path):
    """The values of a node stand together; of equal names without units, one is numbered."""
    grid = TARGETS["grid"]
    values = np.arange(24.0).reshape(12, 2)
    names, marks = ("x", "y", "wind [m/s]", "wind [km/h]"), np.zeros(12, np.int8)
    result = TargetValues(names, grid, values, 10 * values, marks)
    assert [*result.columns] == [
        *("wind [m/s]", "error of wind", "wind [km/h]", "error of wind_2", "extrapolated")
    ]
    FORMATS["npz"](tmp_path / "a.npz", result)
    with np.load(tmp_path / "a.npz") as stored:
        assert np.array_equal(stored["values"], values.reshape(3, 4, 2))
        assert np.array_equal(stored["error"], 10 * values.reshape(3, 4, 2))


def test_targets_may_be_the_vertices_of_a_mesh(tmp_path):
    """The mesh may consist of triangles in the plane, tetrahedra, or triangles in space."""
    for mesh in (MESH, SOLID):
        fr.io.write_mesh(tmp_path / "a.vtk", mesh)
        d = mesh.points.shape[1]
        targets = targets_of_mesh(tmp_path / "a.vtk", d)
        assert np.array_equal(targets.points, mesh.points)
        assert np.array_equal(targets.cells, mesh.cells)
        assert targets.kind == "vertices"
    with pytest.raises(ValueError, match="is a mesh in 3 variables; the samples have 2"):
        targets_of_mesh(tmp_path / "a.vtk", 2)
    surface = meshio.Mesh(SOLID.points, [("triangle", SOLID.cells[:, :3])])
    meshio.write(tmp_path / "s.ply", surface)
    assert np.array_equal(targets_of_mesh(tmp_path / "s.ply", 3).points, SOLID.points)
    with pytest.raises(ValueError, match="holds a surface in space"):
        targets_of_mesh(tmp_path / "s.ply", 2)


def test_axes_of_complex_numbers_are_no_coordinates():
    """A picture of a complex spectrum may have such."""
    axes = {"x": np.arange(3) + 0j, "y": np.arange(2.0)}
    frame = Frame("the data set", ["x", "y"], lambda names: [axes[n] for n in names], axes=axes)
    with pytest.raises(ValueError, match="x must be an array of real numbers"):
        targets_of_table(frame, ("x", "y"))
    real = replace(frame, axes={name: axis.real for name, axis in axes.items()})
    assert targets_of_table(real, ("x", "y")).points.shape == (6, 2)
