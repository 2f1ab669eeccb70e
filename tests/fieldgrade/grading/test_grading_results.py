"""Results: the same in memory and in the file, complete or not there, and merged run by run."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from fieldcheck.verdict import Verdict
from fieldgrade.checking.results import (
    STATUSES,
    Grade,
    Record,
    Results,
    invalid,
    merged,
    ordered,
    read_results,
    to_json,
    write_results,
)
from fieldrecon._core.atomic_files import write_atomically

DIGEST, OTHER = "a" * 64, "b" * 64


def grade(question="01.1", points=1.0, rung="right", **more):
    return Grade(question, points, 2.0, Verdict(question, rung, "A sentence."), **more)


def record(student="ada", digest=DIGEST, notebook="01", status="graded", grades=(), **more):
    return Record(
        student,
        more.pop("file", "a.ipynb"),
        digest,
        notebook,
        status,
        "landlock",
        grades=tuple(grades),
        **more,
    )


FULL = Results(
    (
        record(
            grades=[
                grade(),
                grade(
                    "01.2",
                    0.0,
                    "wrong",
                    check="public cases",
                    made_by="c" * 64,
                    returned=({"shape": [2], "numbers": [1.0, 0.5]},),
                ),
            ],
            notes=("A note.",),
            code=OTHER,
            received="2026-11-21T12:00:00+01:00",
            received_by="platform",
            late_mark=True,
        ),
        record("bob", "", "", "unreadable", file="\udce4.ipynb"),
    ),
    ({"student": "ada", "name": "Ada"},),
    ({"question": "01.1", "notebook": "01", "kind": "code", "function": "f", "points": 2.0},),
    True,
    "e",
    "g",
)


def test_results_come_back_from_their_file(tmp_path):
    """Every field is written and read; names of files that are no text too."""
    write_results(FULL, tmp_path / "results.json")
    assert read_results(tmp_path / "results.json") == FULL


@pytest.mark.parametrize("status", STATUSES)
def test_results_have_the_form_of_the_schema(status):
    """Whatever the status."""
    records = (replace(FULL.records[0], status=status),)
    assert invalid(json.loads(json.dumps(to_json(replace(FULL, records=records))))) == ""


@pytest.mark.parametrize(
    ("place", "value", "told"),
    [
        (("secret",), "yes", r"\$.secret: 'yes' is not of type 'boolean'"),
        (("records", 0, "status"), "lost", r"records\[0\].status: 'lost' is not one of"),
        (("records", 0, "grades", 0, "points"), -1, "less than the minimum of 0"),
        (("records", 0, "salt"), "x", "'salt' was unexpected"),
        (("records", 0, "grades", 1, "returned", 0, "numbers"), [0] * 2001, "too long"),
    ],
)
def test_what_has_another_form_is_refused(tmp_path, place, value, told):
    """The sentence names the file and the place."""
    data = json.loads(json.dumps(to_json(FULL)))
    part = data
    for step in place[:-1]:
        part = part[step]
    part[place[-1]] = value
    file = tmp_path / "results.json"
    file.write_text(json.dumps(data))
    with pytest.raises(ValueError, match=f"results.json: the results are damaged: .*{told}"):
        read_results(file)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("{}", "not a file of results"),
        ("[1]", "not a file of results"),
        ('{"format": "fieldrecon results", "version": 2}', "version 2; version 1 is known"),
        ("{", "results.json: "),
    ],
)
def test_other_files_are_refused(tmp_path, text, told):
    """Those of a later version by its number."""
    file = tmp_path / "results.json"
    file.write_text(text)
    with pytest.raises(ValueError, match=told):
        read_results(file)


def test_what_was_measured_stays_out():
    """Times differ from run to run, and results must not."""
    slow = replace(FULL.records[0], seconds=3.0, cpu_seconds=2.0, peak=9)
    assert to_json(replace(FULL, records=(slow, FULL.records[1]))) == to_json(FULL)


def test_results_before_are_kept(tmp_path):
    """Each in a file of its own, of which none is ever written over; equal ones count once."""
    file, history = tmp_path / "results.json", tmp_path / "history"
    for environment in ("1", "2", "2", "3"):
        write_results(replace(FULL, environment=environment), file)
    assert sorted(f.name for f in history.iterdir()) == ["0001.json", "0002.json"]
    (history / "0001.json").unlink()
    assert write_results(replace(FULL, environment="4"), file)
    assert not write_results(replace(FULL, environment="4"), file)
    assert read_results(history / "0002.json").environment == "2"
    assert read_results(history / "0003.json").environment == "3"


@pytest.mark.parametrize("step", ["write_bytes", "replace"])
def test_a_file_is_there_whole_or_not_at_all(tmp_path, monkeypatch, step):
    """When a disk is full at any step, what was there before is there still, and nothing else."""
    file = tmp_path / "results.json"
    write_atomically(file, b"before")

    def full(*_):
        raise OSError("no space left on device")

    monkeypatch.setattr(Path, step, full)
    with pytest.raises(OSError, match="no space"):
        write_atomically(file, b"now")
    monkeypatch.undo()
    assert [f.name for f in tmp_path.iterdir()] == ["results.json"]
    assert file.read_bytes() == b"before"


# Merging


def test_grades_of_other_questions_stay_with_the_same_file():
    """In the order of the questions, of which the tenth comes after the second."""
    before = record(grades=[grade("01.2"), grade("01.3")])
    now = record(grades=[grade("01.10"), grade("01.2", 0.0)])
    (found,) = merged([before], [now])
    assert [(g.question, g.points) for g in found.grades] == [
        ("01.2", 0.0),
        ("01.3", 1.0),
        ("01.10", 1.0),
    ]


def test_grades_of_another_file_go():
    """What was handed in again is graded anew."""
    (found,) = merged([record(grades=[grade("01.2")])], [record(digest=OTHER, grades=[grade()])])
    assert [g.question for g in found.grades] == ["01.1"]


def test_the_worse_status_stays_while_its_grades_do():
    """A question of a submission that was killed does not make the rest whole."""
    before = record(grades=[grade(), grade("01.2")], status="killed: time")
    assert merged([before], [record(grades=[grade()])])[0].status == "killed: time"
    assert merged([before], [record(grades=before.grades)])[0].status == "graded"


def test_others_stay_and_all_are_in_order():
    """By student, then by notebook."""
    bob, ada = record("bob"), record("ada", notebook="02")
    assert merged([bob], [ada, record("ada")]) == ordered([record("ada"), ada, bob])


def test_what_could_not_be_read_goes_once_it_can():
    """Under the same name; another file that cannot be read stays."""
    torn = record(notebook="", status="unreadable")
    other = record(notebook="", status="unreadable", file="b.ipynb")
    assert merged([torn, other], [record()]) == ordered([record(), other])
