"""The list of submissions that need the instructor's eyes."""

import csv
import io
import re
from dataclasses import replace

import pytest

from fieldgrade.checking import grade_submission
from fieldgrade.checking.results import STATUSES
from fieldgrade.class_folder.decisions import ClassFolder
from fieldgrade.class_folder.dismissals import Dismissal
from fieldgrade.gradebook.attention import (
    COLUMNS,
    GRADER_FAILED,
    KINDS,
    Concern,
    attention_csv,
    attention_page,
    concerns,
    in_lines,
    without_dismissed,
)
from fieldgrade.sandbox.missing import Missing
from fieldgrade.submissions.helper_files import TOO_LARGE
from gradebook_class import Tags, grade, harmless, record, results

EVIL = '<script>alert(1)</script>, "=1+1"'
SOUND = record("ada", [grade("01.1", 2.0)])


def kinds(found_record, counted=("01",)):
    """The kinds of concern about one record."""
    return [c.kind for c in concerns(results([found_record]), counted)]


@pytest.mark.parametrize("status", STATUSES)
def test_every_status_but_graded_needs_eyes(status):
    """A submission that was graded as a whole is not listed."""
    found = concerns(results([replace(SOUND, status=status)]), ["01"])
    assert bool(found) == (status != "graded")
    assert all(concern.needs_decision for concern in found)


@pytest.mark.parametrize(
    ("note", "kind"),
    [
        ("zoe is not on the roster", "student not on the roster"),
        ("the files of x and of y count for zoe", "several senders"),
        ("a.ipynb is not graded: b.ipynb came later", "several files"),
        ("photo.png is not graded: it is not a notebook", "several files"),
        (grade_submission.STUB.format("rank"), "stub below an answer"),
        (grade_submission.UNUSED.format("numpy.py"), "helper file not used"),
        (TOO_LARGE.format("data.csv"), "file too large"),
        ("code cell 7, line 3 (x): NameError: name 'x' is not defined", "error in a cell"),
    ],
)
def test_every_note_of_the_grader_has_a_kind(note, kind):
    """The note is shown as it is."""
    (found,) = concerns(results([replace(SOUND, notes=(note,))]), ["01"])
    assert (found.kind, found.details) == (kind, note)
    assert found.needs_decision == (kind not in ("error in a cell", "stub below an answer"))


def test_what_is_missing_is_listed():
    """It is named once, also if no cell stopped first at it; another font costs no points."""
    missing = Missing(("numba", "tqdm"), ("data.csv",), ("Arial",))
    found = concerns(results([replace(SOUND, missing=missing)]), ["01"])
    assert [(c.kind, c.details, c.needs_decision) for c in found] == [
        ("module missing", "numba, tqdm", True),
        ("file missing", "data.csv", True),
        ("font missing", "Arial", False),
    ]


def test_a_notebook_that_does_not_count_and_a_file_of_nobody_are_listed():
    """Strays keep their name and the reason; the most urgent kind is first."""
    assert kinds(SOUND) == []
    assert kinds(SOUND, ["02"]) == ["notebook does not count"]
    other = record("bob", [grade("01.1", 2.0)])
    (stray,) = concerns(results([SOUND, other, replace(other, notebook="02")]), ["01"])
    assert (stray.notebook, stray.details) == ("02", "submitted by 1 of 2 students")
    strays = ["../x: y.ipynb: it leads out of the folder"]
    found = concerns(results([SOUND]), ["02"], strays)
    assert found[0] == Concern(
        "not graded: no student", "", "", "../x: y.ipynb", "it leads out of the folder"
    )
    assert [c.kind for c in found] == sorted((c.kind for c in found), key=list(KINDS).index)


def test_a_dismissed_entry_returns_when_it_changes(tmp_path):
    """The line names what happened to this file; a failure of the grader cannot be dismissed."""
    part = replace(SOUND, status="partly")
    (entry,) = concerns(results([part]), ["01"])
    file = tmp_path / "dismissed.csv"
    line = f"{entry.entry},ada,1,01.ipynb,partly graded,a part,Hopper,Seen."
    file.write_text(f"{','.join(COLUMNS)},by,reason\n{line}\n")
    dismissals = ClassFolder(tmp_path).dismissals()
    assert dismissals == {entry.entry: Dismissal(entry.entry, "Hopper", "Seen.")}

    def listed(found_record, counted=("01",)):
        found = concerns(results([found_record]), counted)
        return [c.kind for c in without_dismissed(found, dismissals)[0]]

    assert listed(part) == []
    assert listed(replace(part, digest="0" * 64)) == ["partly graded"]
    assert listed(replace(part, status="killed: time")) == ["partly graded"]
    assert listed(replace(part, student="bob")) == ["partly graded"]
    assert listed(replace(part, notes=("x is not on the roster",))) == ["student not on the roster"]
    failed = Concern(GRADER_FAILED, "ada", "01", "01.ipynb", "no space left")
    known = {failed.entry: Dismissal(failed.entry, "Hopper", "Seen.")}
    assert without_dismissed([failed], known) == ([failed], [])


def test_an_entry_that_counts_students_does_not_change_with_others():
    """How many students submitted a stray notebook is not what was dismissed."""
    stray = replace(SOUND, notebook="02")
    (one,) = concerns(results([stray]), ["01"])
    two = next(
        c for c in concerns(results([stray, record("bob", [])]), ["01"]) if c.file == one.file
    )
    assert one.details != two.details
    assert one.entry == two.entry


def test_the_page_shows_who_dismissed_what_and_why():
    """Names and reasons are text; the table has the open entries only."""
    found = concerns(results([replace(SOUND, status="partly")]), ["01"])
    dismissals = {found[0].entry: Dismissal(found[0].entry, EVIL, EVIL)}
    page = attention_page([], found, dismissals)
    assert harmless(page)
    assert Tags(page).text.count(EVIL) == 2
    assert "Dismissed (1)" in Tags(page).text
    assert found[0].entry in Tags(attention_page(found)).text
    assert list(in_lines([], "list.html", 1)) == [
        "No submission needs your eyes: list.html",
        "  dismissed in dismissed.csv: 1 entry",
    ]


@pytest.mark.parametrize(
    ("line", "message"), [("x,Hopper,Seen.", "ten letters"), ("abcdefghij,,Seen.", "by is empty")]
)
def test_a_dismissal_has_an_entry_a_name_and_a_reason(line, message, tmp_path):
    """Otherwise the line is reported with its number."""
    (tmp_path / "dismissed.csv").write_text(f"entry,by,reason\n{line}\n")
    with pytest.raises(ValueError, match=f"dismissed.csv:2: .*{message}"):
        ClassFolder(tmp_path).dismissals()


def test_the_list_is_short_and_has_counts_and_names():
    """Each kind is one line; a student is counted once, and errors in cells are not counted."""
    many = [replace(SOUND, student=f"s{k}", file=f"s{k}", status="partly") for k in range(11)]
    error = replace(SOUND, student="zoe", notes=("code cell 2: KeyError: 1",))
    lines = list(in_lines(concerns(results([*many, error]), ["01"]), "list.html"))
    assert lines == [
        "11 submissions need your eyes: list.html",
        "  partly graded (11): s0, s1, s10, s2, s3, s4, s5, s6 and 3 more",
        "  error in a cell (1): zoe",
    ]
    assert list(in_lines([], "list.html")) == ["No submission needs your eyes."]


def test_the_page_and_the_table_have_every_concern():
    """What students wrote is text, on the page and in a spreadsheet."""
    found = concerns(
        results([replace(SOUND, student="=1", file=EVIL, status="unreadable", notes=(EVIL,))]),
        ["01"],
    )
    page = attention_page(found)
    assert harmless(page)
    assert Tags(page).text.count(EVIL) == 2
    assert KINDS["not graded: unreadable file"] in Tags(page).text
    header, row = csv.reader(io.StringIO(attention_csv(found)))
    assert tuple(header) == COLUMNS
    assert row == [found[0].entry, "'=1", "01", EVIL, "not graded: unreadable file", EVIL]
    assert not re.search(r"\bfault\b", page)
