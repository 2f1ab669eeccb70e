"""A run with nothing to do repeats the last report; any change of its inputs is noticed."""

import argparse
import os
import resource
import subprocess
import sys
from importlib.metadata import distributions
from pathlib import Path

import pytest

from fieldgrade.commands import grade as command
from fieldgrade.grading import unchanged
from fieldgrade.grading.unchanged import Report, inputs_digest, keep_report, last_report
from graded_class import TIER, class_files
from submission_files import write_files

MACHINE = {"PACKAGES": (), "tiers": lambda: ("none",), "distributions": list}
REPORT = Report(3, ("2 submissions", "results.json"), ("no secret",))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Submissions, tables, a checkout, and results; of the machine as little as possible."""
    for name, value in MACHINE.items():
        monkeypatch.setattr(unchanged, name, value)
    return write_files(
        tmp_path,
        {
            "in/ada/01.ipynb": b"1",
            "in/bob.zip": b"2",
            "class/roster.csv": b"student\n",
            "root/solutions/01.py": b"x",
            "root/.course-secret.json": b"{}",
            "out/results.json": b"{}",
            "out/received/ab/abcd": b"1",
        },
    )


def options(folder, **changed):
    found = {
        "submissions": str(folder / "in"),
        "out": folder / "out",
        "tables": folder / "class",
        "root": folder / "root",
        "only": [],
        "jobs": 2,
        "pytest": [],
        "diff": False,
    }
    return argparse.Namespace(**found | changed)


def kept(folder):
    """The report of a run with nothing to do, which is None if there is something to do."""
    return last_report(folder / "out", inputs_digest(options(folder)))


def test_a_report_is_repeated_if_nothing_has_changed(folder):
    keep_report(folder / "out", inputs_digest(options(folder)), REPORT)
    assert kept(folder) == REPORT
    assert last_report(folder / "out", inputs_digest(options(folder, jobs=1))) == REPORT


CHANGES = {
    "a submission": lambda at: (at / "in/ada/01.ipynb").write_bytes(b"3"),
    "a time of receipt": lambda at: os.utime(at / "in/bob.zip", (1, 1)),
    "a new submission": lambda at: (at / "in/cai.ipynb").write_bytes(b"1"),
    "a removed submission": lambda at: (at / "in/bob.zip").unlink(),
    "a renamed submission": lambda at: (at / "in/bob.zip").rename(at / "in/cai.zip"),
    "a link for a submission": lambda at: (at / "in/eve").symlink_to(at / "in/bob.zip"),
    "a table": lambda at: (at / "class/points.csv").write_bytes(b"question,points\n"),
    "a check of the instructor": lambda at: (at / "class/checks").mkdir(),
    "a source": lambda at: (at / "root/solutions/01.py").write_bytes(b"y"),
    "the secret": lambda at: (at / "root/.course-secret.json").unlink(),
    "the results": lambda at: (at / "out/results.json").write_bytes(b"[]"),
    "no results": lambda at: (at / "out/results.json").unlink(),
    "a lost file of the archive": lambda at: (at / "out/received/ab/abcd").unlink(),
    "a damaged report": lambda at: (at / "out/last-report.json").write_bytes(b"{}"),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_a_change_is_noticed(folder, change):
    keep_report(folder / "out", inputs_digest(options(folder)), REPORT)
    change(folder)
    assert kept(folder) is None


@pytest.mark.parametrize("changed", [{"only": ["01"]}, {"diff": True}, {"pytest": ["-x"]}])
def test_other_options_are_another_run(folder, changed):
    keep_report(folder / "out", inputs_digest(options(folder)), REPORT)
    assert last_report(folder / "out", inputs_digest(options(folder, **changed))) is None


@pytest.mark.parametrize("name", ["PACKAGES", "tiers", "distributions"])
def test_another_grader_environment_or_sandbox_is_noticed(folder, name, monkeypatch):
    keep_report(folder / "out", inputs_digest(options(folder)), REPORT)
    others = {
        "PACKAGES": ("fieldcheck",),
        "tiers": lambda: ("landlock", "none"),
        "distributions": distributions,
    }
    monkeypatch.setattr(unchanged, name, others[name])
    assert kept(folder) is None


def test_a_failure_of_the_grader_is_not_repeated(folder, monkeypatch):
    """The same command tries again."""
    from fieldgrade.commands import grade_report

    runs = []
    monkeypatch.setattr(grade_report, "graded", lambda _: runs.append(1) or Report(1))
    monkeypatch.setattr(command, "prepare", lambda _: None)
    assert [command.grade(options(folder)) for _ in range(2)] == [1, 1]
    assert len(runs) == 2


@pytest.mark.slow
def test_a_second_run_prints_the_same_in_a_fraction_of_a_second(tmp_path):
    """The whole command in processor time, which other programs do not change."""
    write_files(tmp_path / "in", class_files())
    command = Path(sys.executable).parent / "fieldrecon"
    arguments = [str(tmp_path / "in"), "--out", str(tmp_path / "out"), "--tier", TIER]
    printed, seconds = [], []
    for _ in range(2):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        run = subprocess.run([command, "grade", *arguments], capture_output=True, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        assert run.returncode == 3
        printed.append(run.stdout)
        seconds.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    assert printed[0] == printed[1]
    assert seconds[1] < 1.0, seconds
