"""Grading by pytest: selected items, reports, and checks that an instructor adds."""

import json
import os
import re
import subprocess
import sys
import textwrap
import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest

from fieldcheck.verdict import Verdict
from fieldgrade.checking import instructor_checks
from fieldgrade.checking.instructor_checks import (
    InstructorCheck,
    InstructorCheckResult,
    apply_instructor_checks,
)
from fieldgrade.checking.results import VERSION, Grade, Record, read_results
from fieldgrade.grading.grade_class import grade_class as graded
from fieldgrade.grading.run import chosen_tier
from fieldrecon.cli import main as cli
from graded_class import ROOT, TIER, checkout, class_files, points, right, run
from submission_files import notebook, write_files

pytestmark = pytest.mark.slow  # each test grades a class and starts pytest inside pytest

CHECKS = """
import numpy as np
import pytest

@pytest.fixture
def cloud():
    return np.random.default_rng(3).normal(size=(31, 2))

@pytest.mark.question("01.2", "Values that all grow by one move the plane up by one.", costs=1)
def test_constants_add(answer, cloud):
    values = cloud[:, 0] ** 2
    change = answer("01.2", cloud, values + 1) - answer("01.2", cloud, values)
    np.testing.assert_allclose(change, [1, 0, 0], atol=1e-9)

@pytest.mark.question("01.4", "The rank does not depend on the order of the points.")
@pytest.mark.parametrize("turn", [1, 4])
def test_order(answer, cloud, turn):
    assert answer("01.4", np.roll(cloud, turn, axis=0)) == answer("01.4", cloud)
"""
STEEP = """
def fit(points, values):
    plane = np.linalg.lstsq(basis_matrix(points), values, rcond=None)[0]
    return plane * (2 if len(points) == 31 else 1)
"""
"""This answer is right on all inputs of the course and wrong on those of the instructor."""


@pytest.fixture
def calls(monkeypatch):
    """The functions that instructors' checks call in the sandbox."""
    made = []

    def counted(server, cells, tasks):
        made.append(tasks[0].calls[0].function)
        return real(server, cells, tasks)

    real = instructor_checks.run
    monkeypatch.setattr(instructor_checks, "run", counted)
    return made


def run_with_own_checks(folder, text=CHECKS, files=None):
    write_files(folder / "class", {"checks/test_own.py": text.encode()})
    files = {"ada/01.ipynb": notebook(*right()), "eve/01.ipynb": notebook(*right(), STEEP)} | (
        files or {}
    )
    return run(folder, files, tables=folder / "class")


def grades(grading):
    return {(r.student, g.question): g for r in grading.results.records for g in r.grades}


# Instructors' checks


def test_an_instructors_check_deducts_its_points(tmp_path):
    """The feedback contains the sentence of the check and not its inputs."""
    found = grades(graded(run_with_own_checks(tmp_path)))
    lost, kept = found["eve", "01.2"], found["ada", "01.2"]
    assert (lost.points, kept.points) == (2.0, 3.0)
    assert str(lost.verdict).endswith("Values that all grow by one move the plane up by one.")
    assert (lost.check, kept.check) == ("constants add", "")
    assert lost.made_by == kept.made_by != found["ada", "01.1"].made_by


def test_the_check_in_the_documentation_works(tmp_path, calls):
    """The code block of docs/instructors.md is run as it is printed."""
    page = (ROOT / "docs" / "instructors.md").read_text(encoding="utf-8")
    shown = textwrap.dedent(re.search(r"^ *```python\n(.*?)^ *```", page, re.M | re.S)[1])
    text = shown.replace("test_order", "test_shown")
    found = grades(graded(run_with_own_checks(tmp_path, text)))
    assert calls == ["fit"] * 4
    assert found["ada", "01.2"].points == found["eve", "01.2"].points == 3.0


def test_only_an_edited_check_is_repeated(tmp_path, calls):
    """Without an edit no check is repeated."""
    todo = run_with_own_checks(tmp_path)
    graded(todo)
    assert sorted(set(calls)) == ["fit", "rank"]
    calls.clear()
    graded(replace(todo))
    assert calls == []
    text = CHECKS.replace("[1, 0, 0]", "(1, 0, 0)")
    write_files(tmp_path / "class", {"checks/test_own.py": text.encode()})
    graded(replace(todo))
    assert set(calls) == {"fit"}


def test_editing_a_fixture_repeats_the_checks_that_use_it(tmp_path, calls):
    todo = run_with_own_checks(tmp_path)
    graded(todo)
    calls.clear()
    write_files(
        tmp_path / "class", {"checks/test_own.py": CHECKS.replace("rng(3)", "rng(4)").encode()}
    )
    graded(todo)
    assert set(calls) == {"fit", "rank"}


def test_an_instructors_check_that_fails_on_the_solution_deducts_nothing(tmp_path):
    """The failure is reported as a failure of the grader."""
    unfair = CHECKS.replace("[1, 0, 0], atol", "[2, 0, 0], atol")
    grading = graded(run_with_own_checks(tmp_path, unfair))
    assert [f for f in grading.collector.failures if "constants add fails on the solution" in f]
    assert points(grading.results)["eve", "01.2"] == points(grading.results)["ada", "01.2"] == 3.0


def test_wrong_answers_are_not_run_through_instructors_checks(tmp_path, calls):
    """Instructors' checks apply to answers that have passed all other checks."""
    files = {name: content for name, content in class_files().items() if name[:3] == "bob"}
    todo = run_with_own_checks(tmp_path, files=files)
    grading = graded(replace(todo, choice=run(tmp_path, {}, student="bob", question="01.2").choice))
    assert points(grading.results)["bob", "01.2"] == 0.0
    assert calls == []


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"01.2", "Values', '"01.99", "Values', "no function to write in question '01.99'"),
        ("Values that all grow by one move the plane up by one.", " ", "needs a sentence"),
        ("costs=1", "costs=0", "must cost more than 0 points, not 0"),
        ("costs=1", "price=1", "write @pytest.mark.question"),
        ("(answer, cloud):", "(cloud):", "needs both"),
    ],
)
def test_a_check_with_an_invalid_mark_is_refused(tmp_path, old, new, message):
    """The message names the error, and nothing is graded."""
    assert old in CHECKS
    todo = run_with_own_checks(tmp_path, CHECKS.replace(old, new, 1))
    with pytest.raises(ValueError, match=message):
        graded(todo)
    assert not (todo.out / "results.json").exists()


def test_an_answer_that_returns_text_fails_the_instructors_check(tmp_path):
    """The other answers of the student are not affected."""
    odd = """
def rank(points):
    points = np.asarray(points)
    return "many" if points.shape == (9, 2) else np.linalg.matrix_rank(basis_matrix(points))
"""
    files = {"odd/01.ipynb": notebook(*right(), odd)}
    found = grades(graded(run_with_own_checks(tmp_path, files=files)))
    assert found["odd", "01.4"].points == 0.0
    assert found["odd", "01.2"].points == 3.0


def grade(finding="right", points=3.0):
    return Grade("01.2", points, 3.0, Verdict("01.2", finding, ""), made_by="m")


@pytest.mark.parametrize(
    ("costs", "left"), [((1.0,), 2.0), ((1.0, 1.5), 0.5), ((1.0, None), 0.0), ((2.0, 2.0), 0.0)]
)
def test_the_costs_of_failed_checks_add_up(costs, left):
    """The sum is at most the points of the question."""
    record = Record("a", "a.ipynb", "d", "01", "graded", "none", grades=(grade(),))
    made = [
        InstructorCheckResult(
            InstructorCheck("01.2", f"Sentence {k}.", c), f"check {k}", str(k), False
        )
        for k, c in enumerate(costs)
    ]
    (found,) = apply_instructor_checks(record, made).grades
    assert found.points == left
    assert found.verdict.sentence == " ".join(f"Sentence {k}." for k in range(len(costs)))
    assert apply_instructor_checks(record, reversed(made)).grades == (found,)


# Items of pytest


@pytest.fixture(scope="module")
def reported(tmp_path_factory):
    """The JUnit report that pytest writes for a small class."""
    folder = tmp_path_factory.mktemp("reported")
    files = {n: c for n, c in class_files().items() if n[:3] in ("bob", "cai", "dan")}
    todo = run(folder, files)
    graded(todo, options=[f"--junit-xml={folder / 'junit.xml'}", "-q"])
    return folder, todo


def test_the_report_contains_each_check_of_each_answer(reported):
    """Checks before the failed check are passed, and checks after it are skipped."""
    folder, _ = reported
    cases = {
        (case.get("classname"), case.get("name")): [part.tag for part in case]
        for case in ET.parse(folder / "junit.xml").iter("testcase")
    }
    assert cases["bob.01.ipynb.01.2", "public cases"] == ["failure"]
    assert cases["bob.01.ipynb.01.2", "own inputs"] == ["skipped"]
    assert cases["bob.01.ipynb.01.4", "tiny and huge"] == []
    assert cases["cai.01.ipynb.01.4", "public cases"] == ["failure"]
    assert cases["dan.01.ipynb", "can be read"] == ["failure"]
    message = {
        c.get("name"): f.get("message")
        for c in ET.parse(folder / "junit.xml").iter("testcase")
        for f in c.iter("failure")
        if c.get("classname") == "cai.01.ipynb.01.4"
    }
    assert "not written yet" in message["public cases"]


def test_option_x_ends_the_run_at_the_first_failure(reported, tmp_path, capsys):
    _, todo = reported
    graded(replace(todo, out=tmp_path), options=["-x", "-q", "-p", "no:randomly"])
    assert "1 failed" in capsys.readouterr().out


def test_option_k_writes_grades_of_completely_checked_questions_only(reported, tmp_path):
    """A grade depends on all checks of its question, so a part of them gives no grade."""
    _, todo = reported
    some = graded(replace(todo, out=tmp_path), options=["-k", "cai and 01.1", "-q"])
    assert set(points(some.results)) == {("cai", "01.1")}
    part = graded(replace(todo, out=tmp_path), options=["-k", "bob and public", "-q"])
    assert set(points(part.results)) == {("cai", "01.1")}


def test_an_empty_selection_is_refused(reported, tmp_path):
    _, todo = reported
    with pytest.raises(ValueError, match="no check was selected"):
        graded(replace(todo, out=tmp_path), options=["-k", "nobody", "-q"])


HOSTILE = "raise SystemError('a file of somebody else is read')"


def test_pytest_ignores_settings_and_tests_of_the_working_directory(
    reported, tmp_path, monkeypatch
):
    """Files conftest.py and pytest.ini, other tests, and environment variables have no effect."""
    _, todo = reported
    write_files(
        tmp_path,
        {
            "conftest.py": HOSTILE.encode(),
            "tests/conftest.py": HOSTILE.encode(),
            "test_it.py": HOSTILE.encode(),
            "pytest.ini": b"[pytest]\naddopts = --no-such-option\n",
        },
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTEST_ADDOPTS", "--no-such-option")
    monkeypatch.setenv("PYTEST_PLUGINS", "no_such_plugin")
    assert len(graded(replace(todo, out=tmp_path / "out")).results.records) == 3


@pytest.mark.slow
def test_pytest_xdist_gives_the_same_results_file(tmp_path):
    """Each process has a sandbox of its own, and instructors' checks run too."""
    todo = run_with_own_checks(tmp_path, files=class_files())
    graded(todo)
    other = replace(todo, out=tmp_path / "other")
    graded(other, options=["-n", "2", "-q"])
    assert (other.out / "results.json").read_bytes() == (todo.out / "results.json").read_bytes()


@pytest.mark.slow
def test_the_plugin_works_with_the_pytest_command(reported, tmp_path):
    """The exit status reports failed answers and wrong options."""
    _, todo = reported
    command = [sys.executable, "-m", "pytest", "-p", "fieldgrade.grading.pytest_plugin", "-q"]
    command += ["--submissions", todo.submissions, "--out", tmp_path / "out", "--root", ROOT]
    command += ["--tier", TIER, "-c", "/dev/null", "-p", "no:cacheprovider"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1, done.stdout
    assert "FAILED" in done.stdout
    assert read_results(tmp_path / "out" / "results.json").records
    wrong = subprocess.run([*command, "--only", "99"], cwd=tmp_path, capture_output=True, text=True)
    assert (wrong.returncode, "there is no notebook 99" in wrong.stderr) == (4, True)


# The command


def grade_by_command(folder, *more):
    return cli.main(
        [
            "grade",
            str(folder / "in"),
            "--out",
            str(folder / "out"),
            "--root",
            str(ROOT),
            "--tier",
            TIER,
            "--jobs",
            "1",
            *more,
        ]
    )


def test_the_grade_command_prints_a_summary(tmp_path, capsys):
    """The exit status is 3 if submissions need the instructor, 0 if only answers are wrong."""
    run(tmp_path)
    assert grade_by_command(tmp_path) == 3
    printed = capsys.readouterr()
    listed = [line.partition(":")[0] for line in printed.out.splitlines()[:4]]
    assert listed == [
        "2 submissions need your eyes",
        "  not graded",
        "  notebook does not count (1)",
        "5 submissions, sandbox",
    ]
    assert "unreadable file (1): dan" in printed.out
    for suffix in ("html", "csv"):
        assert "dan" in (tmp_path / "out" / f"needs-your-eyes.{suffix}").read_text("utf-8")
    assert f"5 submissions, sandbox: {TIER}; 4 graded, 1 unreadable" in printed.out
    assert "dan, 01.ipynb: the file is not a complete notebook" in printed.out
    assert str(tmp_path / "out" / "results.json") in printed.out
    assert "fieldrecon course feedback" in printed.out
    assert "There is no secret salt" in printed.err
    assert "Traceback" not in printed.err
    assert grade_by_command(tmp_path, "--student", "ada", "--only", "02", "--diff") == 3
    printed = capsys.readouterr().out
    assert "1 submission," in printed
    assert "4 submissions of earlier runs are unchanged" in printed
    assert "no grade changed" in printed


def test_control_characters_in_file_names_are_not_printed(tmp_path, capsys):
    """The terminal, the JUnit report and other submissions are not affected."""
    odd = os.fsdecode(b"eve\xe4\x1b[2J\n.ipynb")
    files = {odd: notebook(*right()), "zoe/01.ipynb": notebook(*right()), "\x1b]0;.ipynb": b"{"}
    run(tmp_path, files)
    report = f"--pytest=-v --junit-xml={tmp_path / 'junit.xml'}"
    assert grade_by_command(tmp_path, report) == 3
    printed = capsys.readouterr()
    assert "2 graded, 1 unreadable" in printed.out
    assert "\x1b" not in printed.out + printed.err
    assert ET.parse(tmp_path / "junit.xml").getroot().tag == "testsuites"
    assert read_results(tmp_path / "out" / "results.json").records


def test_a_grader_fault_gives_exit_status_1(tmp_path, capsys):
    """A script can detect that the grader needs attention."""
    root = checkout(tmp_path, "01")
    file = root / "solutions" / "grading" / "01_least_squares.py"
    file.write_text(file.read_text().replace("(1e5 * line,)", "(line, line)"))
    run(tmp_path, {"ada/01.ipynb": notebook(*right())})
    assert grade_by_command(tmp_path, "--root", str(root)) == 1
    printed = capsys.readouterr()
    assert "1 submission needs your eyes" in printed.out
    assert "run the same command again: what is graded is kept" in printed.err


def test_wrong_answers_alone_give_exit_status_0(tmp_path, capsys):
    """Nothing needs the instructor: the list is empty, and the files say so."""
    run(tmp_path, {"bob/01.ipynb": notebook(*right()[:2])})
    assert grade_by_command(tmp_path) == 0
    assert capsys.readouterr().out.startswith("No submission needs your eyes.\n1 submission, ")
    assert "No submission needs" in (tmp_path / "out" / "needs-your-eyes.html").read_text("utf-8")


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--only", "99"], "there is no notebook 99"),
        (["--question", "01.99"], "no function to write in question '01.99'"),
        (["--question", "01.2", "--only", "02"], "question 01.2 is not in 02"),
        (["--student", "nobody"], "contains no submission of the selection"),
        (["--class", "nowhere"], "nowhere is not a folder with the tables of a class"),
        (["--out", "IN/graded"], "results must not be among the submissions"),
        (["--pytest", "--no-such"], "pytest does not understand --no-such"),
    ],
)
def test_invalid_options_of_the_grade_command_are_reported(tmp_path, capsys, more, message):
    """The exit status is 2."""
    run(tmp_path, {"ada/01.ipynb": notebook(*right())})
    more = [word.replace("IN", str(tmp_path / "in")) for word in more]
    more = ["=".join(more)] if more[0] == "--pytest" else more
    assert grade_by_command(tmp_path, *more) == 2
    assert message in capsys.readouterr().err


def test_results_of_another_version_are_refused_before_grading(tmp_path, capsys):
    """A folder that the version before began is kept as it is, and the message says what to do."""
    run(tmp_path, {"ada/01.ipynb": notebook(*right())})
    old = json.dumps({"format": "fieldrecon results", "version": VERSION - 1, "records": []})
    write_files(tmp_path / "out", {"results.json": old.encode()})
    assert grade_by_command(tmp_path) == 2
    printed = capsys.readouterr().err
    other = f"the results have version {VERSION - 1}, and this program reads version {VERSION}"
    assert f"results.json: {other}" in printed
    assert (
        "Grade all submissions again into a new folder: fieldrecon grade DIR --out NEW" in printed
    )
    assert [file.name for file in (tmp_path / "out").iterdir()] == ["results.json"]
    assert (tmp_path / "out" / "results.json").read_text() == old


def test_errors_in_the_tables_of_a_class_are_reported_with_their_lines(tmp_path, capsys):
    """They are reported before any submission is run."""
    run(tmp_path, {"ada/01.ipynb": notebook(*right())})
    write_files(tmp_path / "class", {"points.csv": b"question,points\n01.2,many\n01.99,3\n"})
    assert grade_by_command(tmp_path, "--class", str(tmp_path / "class")) == 2
    printed = capsys.readouterr().err
    assert "points.csv:2" in printed
    assert "points.csv:3: there is no question 01.99" in printed


def test_grading_without_a_sandbox_warns_or_is_refused(monkeypatch):
    """The option require_isolation decides."""
    monkeypatch.setattr("fieldgrade.grading.run.tiers", lambda: ("none",))
    assert chosen_tier()[1].startswith("NOT ISOLATED")
    with pytest.raises(ValueError, match="neither bubblewrap nor Landlock"):
        chosen_tier(require_isolation=True)
    with pytest.raises(ValueError, match="bubblewrap does not work on this machine"):
        chosen_tier("bubblewrap")
