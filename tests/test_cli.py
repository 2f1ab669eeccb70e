"""The command line: what it prints, what it writes, and how it says what is wrong."""

import csv
import json
import os
import subprocess
import sys
from importlib.metadata import version

import numpy as np
import pytest

from fieldrecon import cli, experiments
from fieldrecon.cli import main
from fieldrecon.datasets import clustered, franke
from fieldrecon.experiments import files

SMALL = ["--set", "powers=2,3", "--set", "draws=3"]


@pytest.fixture
def survey(tmp_path):
    """Write samples of Franke's function to a table and return its path."""
    points = clustered(60, 2, 5, 0.2, seed=0)
    path = tmp_path / "survey.csv"
    rows = np.column_stack([1000 * points, 50 * franke(points)])
    path.write_bytes(files.csv_bytes(("easting", "northing", "depth [m]"), rows.tolist()))
    return path


def read_csv(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_the_program_runs():
    """As a program it tells its version and leaves with status 0."""
    done = subprocess.run(
        [sys.executable, "-m", "fieldrecon.cli", "--version"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == f"fieldrecon {version('fieldrecon')}\n"


def test_a_program_that_fails_shows_no_traceback():
    """A user's mistake is told in one line on standard error, with status 2."""
    done = subprocess.run(
        [sys.executable, "-m", "fieldrecon.cli", "reconstruct", "nowhere.csv"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr == "fieldrecon: nowhere.csv: no such file or directory\n"
    assert done.stdout == ""


def test_a_reader_that_has_seen_enough_is_no_error():
    """When the pipe is closed early, as by head, nothing is told and the status is 0."""
    reads, writes = os.pipe()
    os.close(reads)
    done = subprocess.run(
        [sys.executable, "-m", "fieldrecon.cli", "experiments", "show", "power_sampling"],
        stdout=writes,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    os.close(writes)
    assert (done.returncode, done.stderr) == (0, "")


def test_list_names_every_experiment(capsys):
    """Each with its title."""
    assert main(["experiments", "list"]) == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in experiments.names())
    assert "Least squares against moving" in shown


@pytest.mark.parametrize("name", experiments.names())
def test_show_tells_every_parameter(capsys, name):
    """Name, default and meaning, and the figures."""
    assert main(["experiments", "show", name]) == 0
    shown = capsys.readouterr().out
    assert all(parameter in shown for parameter in experiments.get(name).meanings)
    assert f"Figures: {name}" in shown


def test_run_writes_what_it_lists(capsys, tmp_path):
    """The files it prints are all that it wrote, and hold the parameters that were set."""
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


def test_seed_and_processes(tmp_path):
    """A seed changes the result; the number of processes does not."""
    runs = {"a": [], "b": ["--jobs", "2"], "c": ["--seed", "5"], "d": ["--set", "seed=5"]}
    for out, more in runs.items():
        arguments = [*SMALL, *more, "--out", str(tmp_path / out)]
        assert main(["experiments", "run", "power_sampling", *arguments]) == 0
    facts = {out: (tmp_path / out / "power_sampling" / "facts.json").read_bytes() for out in runs}
    assert facts["a"] == facts["b"]
    assert facts["a"] != facts["c"]
    assert facts["c"] == facts["d"]


def test_reconstruct_writes_a_grid(capsys, tmp_path, survey):
    """Grid as table and arrays, the errors of all methods, a picture; all say the same."""
    out = tmp_path / "out"
    assert main(["reconstruct", str(survey), "--grid", "13x11", "--out", str(out)]) == 0
    shown = capsys.readouterr().out
    rows = read_csv(out / "grid.csv")
    with np.load(out / "grid.npz") as stored:
        arrays = dict(stored)
    assert list(rows[0]) == ["easting", "northing", "depth [m]", "extrapolated"]
    assert arrays["values"].shape == (11, 13)
    assert [float(row["depth [m]"]) for row in rows] == arrays["values"].ravel().tolist()
    assert [row["extrapolated"] == "1" for row in rows] == arrays["extrapolated"].ravel().tolist()
    assert float(rows[1]["easting"]) == arrays["x"][1]
    assert 0 < arrays["extrapolated"].sum() < 143
    assert f"{arrays['extrapolated'].sum()} of 143 nodes lie outside the convex hull" in shown
    methods = read_csv(out / "methods.csv")
    assert {row["method"] for row in methods} == {
        "ls1", "ls2", "ls4", "mls1", "mls2", "tps", "cubic", "smooth",
    }  # fmt: skip
    errors = [float(row["rms error"]) for row in methods if row["rms error"]]
    assert errors == sorted(errors)
    assert f"Drawn: {methods[0]['method']}," in shown
    assert (out / "reconstruction.png").read_bytes().startswith(b"\x89PNG")
    assert b"<svg" in (out / "reconstruction.svg").read_bytes()


def test_reconstruct_is_near_the_truth(tmp_path, survey):
    """Inside the hull the grid is as near to the function as the left-out error promises."""
    assert main(["reconstruct", str(survey), "--grid", "30x30", "--out", str(tmp_path / "o")]) == 0
    with np.load(tmp_path / "o" / "grid.npz") as stored:
        x, y, values, outside = (stored[k] for k in ("x", "y", "values", "extrapolated"))
    truth = 50 * franke(np.stack(np.meshgrid(x, y), axis=-1) / 1000)
    rms = np.sqrt(np.mean((values - truth)[~outside] ** 2))
    promised = float(read_csv(tmp_path / "o" / "methods.csv")[0]["rms error"])
    assert rms < 2 * promised
    assert promised < 0.2 * np.std(truth)


def test_reconstruct_obeys(capsys, tmp_path, survey):
    """Columns and method are those asked for."""
    options = ["--x", "northing", "--y", "easting", "--value", "depth [m]", "--method", "ls2"]
    assert main(["reconstruct", str(survey), *options, "--out", str(tmp_path / "out")]) == 0
    assert "Drawn: ls2, least squares, degree 2." in capsys.readouterr().out
    assert list(read_csv(tmp_path / "out" / "grid.csv")[0])[:2] == ["northing", "easting"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["experiments", "run", "power"], "there is no experiment 'power'; there are"),
        (["experiments", "show", "power"], "there is no experiment 'power'; there are"),
        (["experiments", "run", "power_sampling", "--set", "n"], "--set wants KEY=VALUE; got 'n'"),
        (
            ["experiments", "run", "power_sampling", "--set", "n=3"],
            "there is no parameter 'n'; there are powers, points",
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
        (["reconstruct", "SURVEY", "--out", "SURVEY/x"], "not a directory"),
    ],
)
def test_mistakes_are_told_in_a_sentence(capsys, survey, arguments, words):
    """On standard error, with status 2 and without a traceback."""
    assert main([a.replace("SURVEY", str(survey)) for a in arguments]) == 2
    told = capsys.readouterr().err
    assert told.startswith("fieldrecon: ")
    assert words in told
    assert told.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["reconstruct", "a.csv", "--grid", "20"], "must be such as 200x150, each 2 or more"),
        (["reconstruct", "a.csv", "--grid", "1x20"], "must be such as 200x150, each 2 or more"),
        (["experiments", "run", "x", "--jobs", "0"], "must be a positive whole number; got '0'"),
        (["experiments"], "the following arguments are required: COMMAND"),
    ],
)
def test_a_wrong_command_is_told_with_its_usage(capsys, arguments, words):
    """As argparse does it, with status 2."""
    with pytest.raises(SystemExit, match="2"):
        main(arguments)
    assert words in capsys.readouterr().err


def test_a_missing_package_is_told_with_the_remedy(capsys, monkeypatch):
    """Without the packages of the report, the command line says what to install."""
    monkeypatch.setitem(sys.modules, "rich.table", None)
    monkeypatch.delitem(sys.modules, "fieldrecon.reporting.terminal", raising=False)
    assert main(["experiments", "list"]) == 2
    assert "pip install 'fieldrecon[report]'" in capsys.readouterr().err


def test_an_interrupt_is_no_failure_of_the_program(capsys, monkeypatch):
    """Ctrl-C ends with the customary status 130."""

    def interrupted(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "_list", interrupted)
    assert main(["experiments", "list"]) == 130
    assert capsys.readouterr().err == "fieldrecon: interrupted\n"


def test_a_developer_can_see_where(survey):
    """With --traceback the exception comes through."""
    with pytest.raises(ValueError, match="no method 'kriging'"):
        main(["--traceback", "reconstruct", str(survey), "--method", "kriging"])


def test_report_is_wired(capsys):
    """The report's own options are known to the command line."""
    with pytest.raises(SystemExit, match="0"):
        main(["report", "--help"])
    assert "--check-reproducible" in capsys.readouterr().out
