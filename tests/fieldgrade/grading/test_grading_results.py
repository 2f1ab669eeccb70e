"""The results file: reading and writing, the schema, the history, and merging of runs."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from checkout import ROOT
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
from fieldgrade.class_folder.roster import Student
from fieldgrade.grading.run import Choice, GradingRun
from fieldgrade.submissions.collection import ReceivedFile
from fieldrecon._core.atomic_files import write_atomically

DIGEST, OTHER = "a" * 64, "b" * 64


def grade(question="01.1", points=1.0, finding="right", **more):
    return Grade(question, points, 2.0, Verdict(question, finding, "A sentence."), **more)


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
    (
        {
            "question": "01.1",
            "notebook": "01",
            "kind": "code",
            "function": "f",
            "title": "The matrix",
            "points": 2.0,
        },
    ),
    True,
    "e",
    "g",
)


def test_results_are_reproduced_from_their_file(tmp_path):
    """Every field is written and read, also file names that are not valid UTF-8."""
    write_results(FULL, tmp_path / "results.json")
    assert read_results(tmp_path / "results.json") == FULL


@pytest.mark.parametrize("status", STATUSES)
def test_results_of_every_status_conform_to_the_schema(status):
    records = (replace(FULL.records[0], status=status),)
    assert invalid(json.loads(json.dumps(to_json(replace(FULL, records=records))))) == ""


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("secret",), "yes", r"\$.secret: 'yes' is not of type 'boolean'"),
        (("records", 0, "status"), "lost", r"records\[0\].status: 'lost' is not one of"),
        (("records", 0, "grades", 0, "points"), -1, "less than the minimum of 0"),
        (("records", 0, "salt"), "x", "'salt' was unexpected"),
        (("records", 0, "grades", 1, "returned", 0, "numbers"), [0] * 2001, "too long"),
    ],
)
def test_results_that_violate_the_schema_are_refused(tmp_path, place, value, message):
    """The message names the file and the JSON path."""
    data = json.loads(json.dumps(to_json(FULL)))
    part = data
    for step in place[:-1]:
        part = part[step]
    part[place[-1]] = value
    file = tmp_path / "results.json"
    file.write_text(json.dumps(data))
    with pytest.raises(ValueError, match=f"results.json: the results are damaged: .*{message}"):
        read_results(file)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{}", "not a file of results"),
        ("[1]", "not a file of results"),
        ('{"format": "fieldrecon results", "version": 1}', "version 1, and .* version 3"),
        ('{"format": "fieldrecon results", "version": 4}', "version 4.*into a new folder"),
        ('{"format": "fieldrecon results"}', "version None"),
        ("{", "results.json: "),
    ],
)
def test_files_that_are_not_results_are_refused(tmp_path, text, message):
    """Results of another version are refused, with what to do about it."""
    file = tmp_path / "results.json"
    file.write_text(text)
    with pytest.raises(ValueError, match=message):
        read_results(file)


def test_measured_times_are_not_written_to_the_results():
    """Times differ from run to run, and the results file must not."""
    slow = replace(FULL.records[0], seconds=3.0, cpu_seconds=2.0, peak=9)
    assert to_json(replace(FULL, records=(slow, FULL.records[1]))) == to_json(FULL)


def test_earlier_results_are_kept_in_the_history(tmp_path):
    """No file of the history is overwritten, and equal results are kept once."""
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
def test_an_interrupted_write_leaves_the_old_file(tmp_path, monkeypatch, step):
    """If the disk is full, the old file stays, and no other file is added."""
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


def test_merging_keeps_the_grades_of_other_questions():
    """The grades are in the order of the questions, in which 10 comes after 2."""
    before = record(grades=[grade("01.2"), grade("01.3")])
    now = record(grades=[grade("01.10"), grade("01.2", 0.0)])
    (found,) = merged([before], [now])
    assert [(g.question, g.points) for g in found.grades] == [
        ("01.2", 0.0),
        ("01.3", 1.0),
        ("01.10", 1.0),
    ]


def test_merging_drops_the_grades_of_an_earlier_file():
    """A new submission is graded anew."""
    (found,) = merged([record(grades=[grade("01.2")])], [record(digest=OTHER, grades=[grade()])])
    assert [g.question for g in found.grades] == ["01.1"]


def test_merging_keeps_the_worse_status_while_its_grades_remain():
    """Regrading one question of a submission that was killed does not make its status graded."""
    before = record(grades=[grade(), grade("01.2")], status="killed: time")
    assert merged([before], [record(grades=[grade()])])[0].status == "killed: time"
    assert merged([before], [record(grades=before.grades)])[0].status == "graded"


def test_merging_keeps_other_students_and_sorts_the_records():
    """Records are sorted by student, then by notebook."""
    bob, ada = record("bob"), record("ada", notebook="02")
    assert merged([bob], [ada, record("ada")]) == ordered([record("ada"), ada, bob])


def test_merging_drops_an_unreadable_record_once_the_file_is_readable():
    """An unreadable file with another name stays."""
    torn = record(notebook="", status="unreadable")
    other = record(notebook="", status="unreadable", file="b.ipynb")
    assert merged([torn, other], [record()]) == ordered([record(), other])


def test_a_stranger_disappears_once_the_roster_names_the_student():
    """Only if the same file now belongs to a student; a run for one student drops nobody."""
    strangers = [record("dahlcai"), record("elsewhere", OTHER), record("still a stranger")]
    cai, twin = (ReceivedFile(who, "a.ipynb", DIGEST) for who in ("cai", "still a stranger"))
    for choice, gone in ((Choice(student="cai"), set()), (Choice(), {"dahlcai"})):
        run = GradingRun(Path(), Path(), ROOT, choice=choice)
        run.__dict__.update(roster={"cai": Student("cai")}, taken=([cai, twin], []))
        kept = run._without_assigned([*strangers, record("cai")])
        assert {r.student for r in kept} == {"cai", *(r.student for r in strangers)} - gone
