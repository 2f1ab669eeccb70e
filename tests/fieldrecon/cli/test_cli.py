"""The command line: its output, the files that it writes, and its error messages."""

import csv
import json
import os
import pty
import re
import runpy
import subprocess
import sys
from contextlib import suppress
from html.parser import HTMLParser
from importlib.metadata import version

import numpy as np
import pytest

from fieldrecon import LeastSquares, OnGlobe, SimplexMesh, load, save
from fieldrecon._core import extras
from fieldrecon.cli import main as main_module
from fieldrecon.cli.commands import OF_THE_LIBRARY
from fieldrecon.cli.console import print_missing_pictures
from fieldrecon.cli.main import main
from fieldrecon.datasets.synthetic import clustered, franke, uniform
from fieldrecon.io import read_mesh_and_data, write_mesh
from fieldrecon.io.tables import csv_bytes
from fieldrecon.selection.models import MODELS
from fieldreport import experiments
from fieldreport.commands import experiments as experiments_command

SMALL = ["--set", "powers=2,3", "--set", "draws=3"]


@pytest.fixture
def survey(tmp_path):
    """Write samples of Franke's function to a table and return its path."""
    points = clustered(60, 2, 5, 0.2, seed=0)
    path = tmp_path / "survey.csv"
    rows = np.column_stack([1000 * points, 50 * franke(points)])
    path.write_bytes(csv_bytes(("easting", "northing", "depth [m]"), rows.tolist()))
    return path


@pytest.fixture
def no_pictures(monkeypatch):
    """As without the packages that draw: drawing takes most of the time, and other tests look."""
    monkeypatch.setattr("fieldrecon.cli.reconstruct.absent", lambda *_: ["matplotlib"])


def read_csv(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_version_is_printed():
    """`python -m fieldrecon.cli.main --version` prints the version and exits with status 0."""
    done = subprocess.run(
        [sys.executable, "-m", "fieldrecon.cli.main", "--version"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == f"fieldrecon {version('fieldrecon')}\n"


def test_the_arguments_of_the_process_are_those_of_the_command(capsys, monkeypatch):
    """All but the first of them, the name of the program."""
    monkeypatch.setattr(sys, "argv", ["fieldrecon", "--version"])
    with pytest.raises(SystemExit, match="0"):
        main()
    assert capsys.readouterr().out == f"fieldrecon {version('fieldrecon')}\n"
    with pytest.raises(SystemExit, match="0"):
        runpy.run_path(main_module.__file__, run_name="__main__")
    assert capsys.readouterr().out == f"fieldrecon {version('fieldrecon')}\n"


@pytest.mark.slow
def test_a_user_error_prints_one_line_without_traceback():
    """A missing file gives one line on standard error and exit status 2."""
    done = subprocess.run(
        [sys.executable, "-m", "fieldrecon.cli.main", "reconstruct", "nowhere.csv"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr == "fieldrecon: nowhere.csv: no such file or directory\n"
    assert done.stdout == ""


@pytest.mark.slow
def test_a_closed_pipe_is_not_an_error():
    """If the reader closes the pipe early, as `head` does, the command exits silently with 0."""
    reads, writes = os.pipe()
    os.close(reads)
    done = subprocess.run(
        [sys.executable, "-m", "fieldrecon.cli.main", "experiments", "show", "power_sampling"],
        stdout=writes,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    os.close(writes)
    assert (done.returncode, done.stderr) == (0, "")


def test_list_names_every_experiment(capsys):
    """`experiments list` prints every name with its title."""
    assert main(["experiments", "list"]) == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in experiments.names())
    assert "Least squares and moving" in shown


@pytest.mark.parametrize("name", experiments.names())
def test_show_prints_every_parameter(capsys, name):
    """`experiments show` prints every parameter and the figures of the experiment."""
    assert main(["experiments", "show", name]) == 0
    shown = capsys.readouterr().out
    assert all(parameter in shown for parameter in experiments.get(name).meanings)
    assert f"Figures: {name}" in shown


@pytest.mark.slow
def test_run_lists_the_files_that_it_writes(capsys, tmp_path):
    """`experiments run` prints the path of every file it wrote.

    The file params.json has the given values.
    """
    assert main(["experiments", "run", "power_sampling", *SMALL, "--out", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    folder = tmp_path / "power_sampling"
    listed = {line for line in shown.splitlines() if line.startswith(str(folder))}
    assert listed == {str(path) for path in folder.iterdir()}
    assert {"power_sampling.svg", "power_sampling.pdf", "power_sampling.png"} <= {
        path.name for path in folder.iterdir()
    }
    params = json.loads((folder / "params.json").read_text())
    assert (params["powers"], params["draws"]) == ([2, 3], 3)
    assert "LS/MLS rms" in shown


@pytest.mark.slow
def test_facts_depend_on_the_seed_and_not_on_the_number_of_processes(tmp_path):
    """Equal seeds give equal bytes, also with --jobs 2; another seed gives other facts."""
    runs = {"a": [], "b": ["--jobs", "2"], "c": ["--seed", "5"], "d": ["--set", "seed=5"]}
    for out, more in runs.items():
        arguments = [*SMALL, *more, "--out", str(tmp_path / out)]
        assert main(["experiments", "run", "power_sampling", *arguments]) == 0
    facts = {out: (tmp_path / out / "power_sampling" / "facts.json").read_bytes() for out in runs}
    assert facts["a"] == facts["b"]
    assert facts["a"] != facts["c"]
    assert facts["c"] == facts["d"]


def reconstruct(survey, out, *options):
    return main(["reconstruct", str(survey), "--out", str(out), *options])


@pytest.mark.parametrize(
    ("options", "compared"),
    [
        (("--method", "tps"), ["tps"]),
        pytest.param((), list(MODELS), marks=pytest.mark.slow),
    ],
    ids=["one method", "all methods"],
)
def test_reconstruct_writes_a_grid(capsys, tmp_path, survey, options, compared):
    """The CSV table, the arrays, the table of methods and the printed summary agree."""
    out = tmp_path / "out"
    assert reconstruct(survey, out, "--grid", "13x11", *options) == 0
    shown = " ".join(capsys.readouterr().out.split())
    rows = read_csv(out / "grid.csv")
    with np.load(out / "grid.npz") as stored:
        arrays = dict(stored)
    assert list(rows[0]) == ["easting", "northing", "depth [m]", "error", "extrapolated"]
    assert arrays["values"].shape == (11, 13)
    assert [float(row["depth [m]"]) for row in rows] == arrays["values"].ravel().tolist()
    assert [int(row["extrapolated"]) for row in rows] == arrays["extrapolated"].ravel().tolist()
    assert float(rows[1]["easting"]) == arrays["x"][1]
    outside = np.count_nonzero(arrays["extrapolated"] == 2)
    assert 0 < outside < 143
    assert f"{outside} of these lie outside the convex hull" in shown
    methods = read_csv(out / "methods.csv")
    assert sorted(row["method"] for row in methods) == sorted(compared)
    most = max(int(row["held out"] or 0) for row in methods)
    errors = [float(row["rms error"]) for row in methods if row["held out"] == str(most)]
    assert errors == sorted(errors)
    assert f"Evaluated: {methods[0]['method']}," in shown
    for name in ("reconstruction", "error"):
        assert (out / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert not (out / f"{name}.svg").exists(), "no other pictures unasked: they take time"
    assert {str(path) for path in out.iterdir()} <= set(shown.split())


@pytest.mark.slow
def test_reconstruct_writes_pictures_in_the_given_formats(tmp_path, survey):
    """Each picture in each of them, and in no other one."""
    grid = "--method", "ls1", "--grid", "4x3"
    assert reconstruct(survey, tmp_path, *grid, "--pictures", "svg,.PDF") == 0
    pictures = {path for path in tmp_path.iterdir() if path.suffix in {".svg", ".pdf", ".png"}}
    assert {path.suffix for path in pictures} == {".svg", ".pdf"}
    assert {path.stem for path in pictures} >= {"reconstruction", "error"}
    for path in pictures:
        assert (b"%PDF" if path.suffix == ".pdf" else b"<svg") in path.read_bytes()[:2000]


@pytest.mark.slow
@pytest.mark.usefixtures("no_pictures")
def test_the_grid_is_within_its_error_estimate(tmp_path, survey):
    """At over 90 % of the nodes inside the hull the true error is below the estimated error."""
    assert reconstruct(survey, tmp_path / "grid.npz", "--grid", "30x30") == 0
    with np.load(tmp_path / "grid.npz") as stored:
        x, y, values, error, flags = (
            stored[k] for k in ("x", "y", "values", "error", "extrapolated")
        )
    truth = 50 * franke(np.stack(np.meshgrid(x, y), axis=-1) / 1000)
    true_error = abs(values - truth)[flags == 0]
    assert np.mean(true_error <= error[flags == 0]) > 0.9
    assert np.median(error[flags == 0]) < 0.5 * np.std(truth)


def test_several_values_are_given_by_repeating_the_option(tmp_path):
    """One is given in the same way; both are planes, which the method reproduces."""
    x, slopes = uniform(20, 2, seed=0), np.array([[2.0, -1.0], [0.5, 3.0]])
    table, out = tmp_path / "planes.csv", tmp_path / "a.csv"
    table.write_bytes(csv_bytes(("x", "y", "f", "g"), np.hstack([x, x @ slopes]).tolist()))
    for names in ("f", "fg"):
        options = [part for name in names for part in ("--value", name)]
        options += ["--method", "ls1", "--grid", "3x2", "--out", str(out)]
        assert main(["reconstruct", str(table), *options]) == 0
        rows = read_csv(out)
        at, found = (
            [[float(row[c]) for c in columns] for row in rows] for columns in ("xy", names)
        )
        np.testing.assert_allclose(found, np.array(at) @ slopes[:, : len(names)], atol=1e-9)


@pytest.mark.slow
@pytest.mark.usefixtures("no_pictures")
def test_columns_and_method_can_be_chosen(capsys, tmp_path, survey):
    """--x, --y, --value and --method override the columns and the method found automatically."""
    options = ["--x", "northing", "--y", "easting", "--value", "depth [m]", "--method", "ls2"]
    assert reconstruct(survey, tmp_path / "out", *options, "--grid", "5x4") == 0
    assert "Evaluated: ls2, least squares, degree 2." in capsys.readouterr().out
    assert list(read_csv(tmp_path / "out" / "grid.csv")[0])[:2] == ["northing", "easting"]


class Page(HTMLParser):
    """Parser of an HTML page: its text, its embedded images, its links, and what it loads."""

    def __init__(self, text):
        super().__init__()
        self.texts, self.open, self.links, self.loaded, self.images = [], [], [], [], 0
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        if tag not in ("meta", "img"):
            self.open.append(tag)
        self.images += tag == "img" and attributes["src"].startswith("data:image/png;base64,")
        addresses = [attributes[key] for key in ("src", "href") if key in attributes]
        refers = self.links if tag == "a" else self.loaded
        refers += [address for address in addresses if not address.startswith("data:")]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)


@pytest.mark.slow
def test_the_page_is_self_contained(tmp_path, survey):
    """The page embeds its pictures, loads nothing, links to the table that was written beside it,
    and escapes names from the samples.
    """
    table = survey.read_text().replace("depth [m]", "<script>&")
    survey.write_text(table + "1,2,?\n")
    assert reconstruct(survey, tmp_path / "a.csv", "--grid", "13x11", "--method", "pu") == 0
    assert {path.name for path in tmp_path.iterdir()} == {"survey.csv", "a.csv", "a.html"}
    text = (tmp_path / "a.html").read_text()
    page = Page(text)
    assert (page.open, page.loaded, page.links, page.images) == ([], [], ["a.csv"], 6)
    assert "url(" not in text
    assert "@import" not in text
    words = " ".join(page.texts)
    assert "<script>&, reconstructed" in words
    for wanted in (
        "PartitionOfUnityRBF",
        "polyharmonic",
        "13 × 11",
        "survey.csv",
        "1 row skipped",
        "95 of 100",
        "GB of memory",
        "patches of r⁵, blended",
    ):
        assert wanted in words, wanted
    assert MODELS["tps"].meaning not in words  # one method was requested, so no comparison


@pytest.mark.slow
@pytest.mark.usefixtures("no_pictures")
def test_the_page_compares_all_methods(tmp_path, survey):
    """Without --method the page lists every method with its meaning or with "not tried"."""
    assert reconstruct(survey, tmp_path / "a.csv", "--grid", "13x11") == 0
    words = " ".join(Page((tmp_path / "a.html").read_text()).texts)
    for name, candidate in MODELS.items():
        assert name in words
        assert candidate.meaning in words or f"{name}: not tried" in words, name


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["csv", "npz", "vtk", "nc"])
@pytest.mark.usefixtures("no_pictures")
def test_the_suffix_selects_the_format(tmp_path, survey, suffix):
    """--out with a suffix writes one file in this format and the HTML page beside it."""
    options = ["--grid", "5x4", "--method", "ls1"]
    assert reconstruct(survey, tmp_path / "to" / f"a.{suffix}", *options) == 0
    assert {path.name for path in (tmp_path / "to").iterdir()} == {f"a.{suffix}", "a.html"}


@pytest.mark.slow
@pytest.mark.usefixtures("no_pictures")
def test_format_selects_the_files_in_a_folder(tmp_path, survey):
    """--format vtk,nc writes the grid in these two formats and in no other."""
    options = ["--grid", "5x4", "--method", "ls1", "--format", "vtk, NC"]
    assert reconstruct(survey, tmp_path / "to", *options) == 0
    assert {"grid.vtk", "grid.nc"} == {
        path.name for path in (tmp_path / "to").iterdir() if path.stem == "grid"
    }


@pytest.mark.slow
def test_targets_may_be_a_table_or_a_mesh(tmp_path, survey):
    """At the sample points an interpolating method reproduces the values.

    A mesh keeps its cells.
    """
    out = tmp_path / "a.csv"
    assert reconstruct(survey, out, "--method", "tps", "--at", str(survey)) == 0
    wanted, rows = read_csv(survey), read_csv(out)
    for name in ("easting", "northing"):
        assert [row[name] for row in rows] == [row[name] for row in wanted]
    values = [[float(row["depth [m]"]) for row in table] for table in (rows, wanted)]
    np.testing.assert_allclose(*values, atol=1e-8)
    mesh = SimplexMesh.delaunay(1000 * uniform(30, 2, seed=0))
    write_mesh(tmp_path / "mesh.vtk", mesh)
    assert reconstruct(survey, tmp_path / "b.vtk", "--mesh", str(tmp_path / "mesh.vtk")) == 0
    again, data, _ = read_mesh_and_data(tmp_path / "b.vtk")
    assert np.array_equal(again.cells, mesh.cells)
    assert set(data) == {"depth_[m]", "error", "extrapolated"}


@pytest.mark.slow
def test_targets_in_space_may_be_a_grid_points_or_a_mesh(tmp_path):
    """For samples in space the targets are a grid with three sides, a table or a mesh."""
    points = uniform(150, 3, seed=0)
    values = points @ [1.0, 2.0, 3.0] + points[:, 0] ** 2
    np.savez(tmp_path / "s.npz", points=points, values=values)
    write_mesh(tmp_path / "mesh.vtk", SimplexMesh.delaunay(points[:40]))
    for k, where in enumerate(
        (
            ["--grid", "4x5x6"],
            ["--at", str(tmp_path / "s.npz")],
            ["--mesh", str(tmp_path / "mesh.vtk")],
        )
    ):
        out = tmp_path / f"{k}.npz"
        assert reconstruct(tmp_path / "s.npz", out, "--z", "z", "--method", "tps", *where) == 0
        assert (tmp_path / f"{k}.html").exists()
    with np.load(tmp_path / "0.npz") as stored:
        assert stored["values"].shape == (6, 5, 4)
    with np.load(tmp_path / "1.npz") as stored:
        assert np.abs(stored["values"] - values).max() < 0.05


@pytest.mark.slow
def test_a_grid_may_cross_the_date_line(tmp_path, capsys):
    """With --lonlat the error across the 180° meridian is below 1e-2, as everywhere else."""
    u = uniform(400, 2, seed=0)
    lon, lat = 170 + 20 * u[:, 0], -10 + 20 * u[:, 1]
    field = np.sin(np.radians(6 * lon)) + np.radians(lat)
    rows = np.column_stack([np.where(lon > 180, lon - 360, lon), lat, field])
    table = tmp_path / "sea.csv"
    table.write_bytes(csv_bytes(("lon", "lat", "t"), rows.tolist()))
    out = tmp_path / "sea.npz"
    assert reconstruct(table, out, "--lonlat", "--grid", "21x11", "--method", "tps") == 0
    assert "look like degrees" not in capsys.readouterr().out
    with np.load(out) as stored:
        x, y, values, flags = (stored[k] for k in ("x", "y", "values", "extrapolated"))
    assert x[0] < 180 < x[-1] < 191
    truth = np.sin(np.radians(6 * x)) + np.radians(y)[:, None]
    assert np.abs(values - truth)[flags == 0].max() < 1e-2
    assert reconstruct(table, tmp_path / "flat.csv", "--grid", "5x5", "--method", "ls1") == 0
    assert "look like degrees" in capsys.readouterr().out


SAVED = [(False, method) for method in ("ls2", "smooth", "pu")]
SAVED += [(True, method) for method in ("mls1", "tps")]


@pytest.mark.slow
@pytest.mark.parametrize(("globe", "method"), SAVED)
@pytest.mark.usefixtures("no_pictures")
def test_a_saved_field_gives_the_same_values(tmp_path, survey, method, globe):
    """A field read with --load gives the same table, byte for byte, as the run that saved it."""
    survey.write_text(survey.read_text().replace("easting", "lon").replace("northing", "lat"))
    if globe:
        header, *rows = survey.read_text().splitlines()
        small = (",".join(str(float(cell) / 20) for cell in row.split(",")) for row in rows)
        survey.write_text("\n".join([header, *small]))
    options = ["--lonlat"] if globe else []
    saved, first, second = (tmp_path / name for name in ("f.npz", "a.csv", "b.csv"))
    where = ["--grid", "6x5"]
    assert (
        reconstruct(survey, first, *options, "--method", method, "--save", str(saved), *where) == 0
    )
    assert main(["reconstruct", "--load", str(saved), "--out", str(second), *where]) == 0
    assert first.read_bytes() == second.read_bytes()
    assert isinstance(load(saved).method, OnGlobe) == globe


@pytest.mark.slow
def test_progress_is_printed_on_a_terminal(tmp_path, survey):
    """Stages, remaining time and memory are printed to standard error, not to standard output."""
    shown, terminal = pty.openpty()
    every_call = (
        "import sys; from fieldrecon.cli.main import main; from fieldrecon.cli import progress; "
        "progress._SECONDS_BETWEEN = 0; sys.exit(main())"
    )
    command = [sys.executable, "-c", every_call, "reconstruct", str(survey)]
    where = ["--grid", "150x150", "--method", "tps", "--out", str(tmp_path / "a.npz")]
    printed = b""
    with subprocess.Popen([*command, *where], stdout=subprocess.PIPE, stderr=terminal) as run:
        os.close(terminal)
        with suppress(OSError):  # on Linux, reading a closed terminal raises OSError
            while more := os.read(shown, 2**16):
                printed += more
        output = run.stdout.read().decode()
    os.close(shown)
    assert run.returncode == 0
    for wanted in ("reading", "choosing a method", "evaluating", "left, ", "GB"):
        assert wanted in printed.decode()
    assert "evaluating" not in output


@pytest.mark.slow
@pytest.mark.usefixtures("no_pictures")
def test_bad_rows_and_repeated_points_are_reported(tmp_path, capsys, survey):
    """Skipped rows are listed with their line numbers; with --strict the first one is an error."""
    row = survey.read_text().splitlines()[1]
    easting, northing, _ = row.split(",")
    survey.write_text(survey.read_text() + f"{easting},{northing},0\n1,two,3\n")
    assert reconstruct(survey, tmp_path / "a.csv", "--grid", "5x5", "--method", "ls1") == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "1 row skipped, by line: 63: northing must be a finite number; got 'two'." in shown
    assert "1 row repeats a point" in shown
    assert "differ at 1 point" in shown
    assert reconstruct(survey, tmp_path / "b.csv", "--strict") == 2
    assert "survey.csv, line 63: northing" in capsys.readouterr().err
    assert not (tmp_path / "b.csv").exists()


def test_collinear_samples_are_refused_and_the_output_file_is_kept(tmp_path, capsys):
    """The existing output file is not overwritten."""
    table, out = tmp_path / "a.csv", tmp_path / "b.csv"
    table.write_text("x,y,z\n" + "".join(f"{k},{2 * k},{k}\n" for k in range(20)))
    out.write_text("kept")
    assert reconstruct(table, out) == 2
    assert "all 20 points lie on one straight line" in capsys.readouterr().err
    assert out.read_text() == "kept"


@pytest.mark.slow
def test_an_unavailable_error_estimate_is_reported(tmp_path, capsys):
    """Three samples determine a plane.

    Without one of them there is no plane, so the error is nan.
    """
    plane = LeastSquares([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]).field([1.0, 2.0, 3.0])
    save(tmp_path / "f.npz", plane)
    out = ["--out", str(tmp_path / "a.csv"), "--grid", "3x3"]
    assert main(["reconstruct", "--load", str(tmp_path / "f.npz"), *out]) == 0
    assert "The error of the field is not known: the points do not determine" in " ".join(
        capsys.readouterr().out.split()
    )
    assert {row["error"] for row in read_csv(tmp_path / "a.csv")} == {"nan"}


@pytest.mark.slow
@pytest.mark.usefixtures("no_pictures")
def test_many_samples_are_cross_validated_in_windows(tmp_path, capsys):
    """For 20 001 samples the cross-validation uses those in windows."""
    points = uniform(20_001, 2, seed=0)
    np.savez(tmp_path / "s.npz", points=points, values=franke(points))
    assert reconstruct(tmp_path / "s.npz", tmp_path / "a.npz", "--grid", "60x50") == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "value at 20001 points: error at held-out samples" in shown
    assert "Evaluated: pu," in shown
    with np.load(tmp_path / "a.npz") as stored:
        nodes = np.stack(np.meshgrid(stored["x"], stored["y"]), axis=-1)
        true_error = abs(stored["values"] - franke(nodes))[stored["extrapolated"] == 0]
        assert true_error.max() < 1e-3
        assert np.mean(true_error <= stored["error"][stored["extrapolated"] == 0]) > 0.95


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["experiments", "run", "power"], "there is no experiment 'power'; there are"),
        (["experiments", "show", "power"], "there is no experiment 'power'; there are"),
        (
            ["experiments", "run", "power_sampling", "--set", "n"],
            "--set must be KEY=VALUE; got 'n'",
        ),
        (
            ["experiments", "run", "power_sampling", "--set", "n=3"],
            "there is no parameter 'n'; there are powers, points",
        ),
        (
            ["experiments", "run", "power_sampling", "--set", "Pionts=3"],
            "there is no parameter 'Pionts'; did you mean points?",
        ),
        (
            ["experiments", "show", "power-samplin"],
            "there is no experiment 'power-samplin'; did you mean power_sampling?",
        ),
        (
            ["experiments", "run", "power_sampling", "--seed", "1", "--set", "seed=2"],
            "parameter seed must be set once; got '2' and '1'",
        ),
        (
            ["experiments", "run", "power_sampling", "--set", "points=20", "--set", "points=30"],
            "parameter points must be set once; got '20' and '30'",
        ),
        (
            ["experiments", "run", "power_sampling", "--seed", ""],
            "parameter seed must be a whole number; got ''",
        ),
        (
            ["experiments", "run", "power_sampling", "--set", "draws=few"],
            "parameter draws must be a whole number; got 'few'",
        ),
        (
            ["experiments", "run", "power_sampling", "--set", "draws=0"],
            "parameter draws must be 1 or more; got 0",
        ),
        (["reconstruct", "SURVEY", "--method", "kriging"], "there is no method 'kriging'; there"),
        (["reconstruct", "SURVEY", "--value", "d"], "has no column 'd'; it has easting"),
        (["reconstruct", "SURVEY", "--out", "a.tif"], "there is no format 'tif'; there are csv,"),
        (["reconstruct", "SURVEY", "--format", "tif"], "there is no format 'tif'; there are csv,"),
        (["reconstruct", "SURVEY", "--out", "a.nc", "--format", "csv"], "names another format"),
        (
            ["reconstruct", "SURVEY", "--pictures", "png,jpg"],
            "no pictures as 'jpg'; there are",
        ),
        (["reconstruct", "SURVEY", "--out", "SURVEY"], "is read, and would be overwritten"),
        (["reconstruct", "SURVEY", "--save", "SURVEY"], "is read, and would be overwritten"),
        (["reconstruct"], "give either a table of samples or --load with a field"),
        (["reconstruct", "SURVEY", "--load", "a"], "give either a table of samples or --load"),
        (["reconstruct", "--load", "SURVEY"], "is not a file of a field"),
        (["reconstruct", "SURVEY", "--grid", "2x2x2"], "a grid in 2 variables has 2 sides"),
        (["reconstruct", "SURVEY", "--at", "nowhere"], "nowhere: no such file or directory"),
        (["reconstruct", "SURVEY", "--lonlat"], "are not degrees of longitude and latitude"),
    ],
)
def test_user_errors_are_one_line_with_status_2(capsys, survey, arguments, words):
    """The message is one line on standard error, without a traceback."""
    assert main([a.replace("SURVEY", str(survey)) for a in arguments]) == 2
    message = capsys.readouterr().err
    assert message.startswith("fieldrecon: ")
    assert words in message
    assert message.count("\n") == 1


@pytest.mark.parametrize(
    "arguments",
    [
        "reconstruct nowhere.csv --out {file}/x",
        "reconstruct nowhere.csv --out {file}/x.nc",
        "reconstruct nowhere.csv --save {file}/x.npz",
        "surface nowhere.ply --out {file}/x.ply",
        "audit nowhere.ply --out {file}/x",
        "audit nowhere.ply --repair {file}/x.ply",
    ],
)
def test_an_output_below_a_file_is_refused_before_the_work(capsys, survey, arguments):
    """The input, which does not exist, is not read."""
    assert main(arguments.format(file=survey).split()) == 2
    assert capsys.readouterr().err.endswith(": not a directory\n")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["reconstruct", "a.csv", "--grid", "20"], "must be such as 200x150, each 2 or more"),
        (["reconstruct", "a.csv", "--grid", "1x20"], "must be such as 200x150, each 2 or more"),
        (["experiments", "run", "x", "--jobs", "0"], "must be a positive whole number; got '0'"),
        (["experiments"], "the following arguments are required: COMMAND"),
    ],
)
def test_usage_errors_are_reported_by_argparse(capsys, arguments, words):
    """The parser exits with status 2 and prints the usage."""
    with pytest.raises(SystemExit, match="2"):
        main(arguments)
    assert words in capsys.readouterr().err


def test_an_interrupt_has_status_130(capsys, monkeypatch):
    """Ctrl-C prints one line and exits with the customary status 130."""

    def interrupted():
        raise KeyboardInterrupt

    monkeypatch.setattr(experiments_command, "titles", interrupted)
    assert main(["experiments", "list"]) == 130
    assert capsys.readouterr().err == "fieldrecon: interrupted\n"


def test_nothing_more_is_written_to_a_pipe_that_was_closed(monkeypatch, tmp_path):
    """The exit status is zero, and Python writes nothing to the closed pipe when it ends."""

    def closed():
        raise BrokenPipeError

    monkeypatch.setattr(experiments_command, "titles", closed)
    with (tmp_path / "out").open("w") as stream, monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", stream)
        assert main(["experiments", "list"]) == 0
        stream.write("more")
    assert (tmp_path / "out").read_text() == ""


def test_a_page_without_pictures_says_which_packages_draw_them(
    capsys, monkeypatch, tmp_path, survey
):
    """Once, on standard error, beside the files that are written."""
    monkeypatch.setattr(extras, "find_spec", lambda _: None)
    out = tmp_path / "field.csv"
    assert (
        main(["reconstruct", str(survey), "--method", "tps", "--grid", "4x3", "--out", str(out)])
        == 0
    )
    shown = capsys.readouterr()
    assert shown.err.count("fieldrecon: no picture was drawn: matplotlib and typst") == 1
    assert shown.out.split()[-2:] == [str(out), str(out.with_suffix(".html"))]
    assert "<img" not in out.with_suffix(".html").read_text()


def test_what_is_not_installed_is_named_before_the_work(capsys, monkeypatch):
    """A command, the packages that it needs, or those for pictures, which it does without."""
    monkeypatch.setattr(extras, "find_spec", lambda _: None)
    with pytest.raises(SystemExit, match="2"):
        main(["grade", "--help"])
    assert re.search("are not installed; .* the extras .*'grade': pip", capsys.readouterr().err)
    print_missing_pictures()
    sentence = "fieldrecon: no picture was drawn: matplotlib and typst are not installed; they come"
    assert capsys.readouterr().err.startswith(sentence)
    monkeypatch.setattr(main_module, "commands", lambda: OF_THE_LIBRARY)
    with pytest.raises(SystemExit, match="2"):
        main(["--traceback", "report"])
    shown = capsys.readouterr().err
    assert "the command 'report' comes with fieldrecon-course: pip install '" in shown
    assert shown.endswith("[report]'\n")
    with pytest.raises(SystemExit, match="2"):
        main(["reports"])
    assert "invalid choice: 'reports'" in capsys.readouterr().err


def test_traceback_option_raises_the_exception(survey):
    """With --traceback the exception is not caught."""
    with pytest.raises(ValueError, match="no method 'kriging'"):
        main(["--traceback", "reconstruct", str(survey), "--method", "kriging"])


def test_report_command_has_its_options(capsys):
    """`fieldrecon report --help` lists the options of the report."""
    with pytest.raises(SystemExit, match="0"):
        main(["report", "--help"])
    assert "--check-reproducible" in capsys.readouterr().out


def test_help_says_which_column_makes_points_of_space(capsys):
    """It is that of z, and not those of x and y."""
    with pytest.raises(SystemExit, match="0"):
        main(["reconstruct", "--help"])
    shown = " ".join(capsys.readouterr().out.split())
    for name, more in (("x", " --y"), ("y", " --z"), ("z", ", of points in space --value")):
        assert f"the column that holds {name}{more}" in shown
