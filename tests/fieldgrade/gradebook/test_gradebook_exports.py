"""The files for learning platforms, held against the forms in which they read them."""

import csv
import io
import json

import pytest

from fieldgrade.class_folder import csv_tables as tables
from fieldgrade.class_folder.assignments import Assignment
from fieldgrade.class_folder.decisions import Decisions
from fieldgrade.class_folder.late_policy import LatePolicy, moment
from fieldgrade.gradebook import exports
from fieldgrade.gradebook.grade_sheets import grade_sheets
from gradebook_class import asked, grade, record, results

ADA = {
    "student": "ada",
    "name": "Lovelace, Ada",
    "canvas_id": "1204",
    "sis_id": "4711",
    "login": "ada",
    "section": "Monday",
    "email": "ada@uni.example",
}
BOB = {"student": "bob", "name": "Bob", "login": "bob", "email": "bob@uni.example"}
NAMED = {
    "01": Assignment("01", canvas="Least squares (48213)", moodle="Assignment: Least squares"),
    "02": Assignment("02"),
}
FORMULAS = ["=1+1", "+1", "-1", "@SUM(1)", "\t=1", "\r=1", "＝1", '=HYPERLINK("http://x","y")']


def sheets(*students, decisions=None, **parts):
    found = [
        record("ada", [grade("01.1", 2.0), grade("01.2", 0.5, rung="slow", **parts)]),
        record("ada", [grade("02.1", 1.0)], notebook="02"),
    ]
    questions = asked("01.1", "01.2", "02.1")
    return grade_sheets(results(found, questions, students or (ADA, BOB)), decisions)


def test_canvas_reads_its_own_columns_in_their_order():
    """Header, the row of points possible, quoted names, and an empty cell where nothing came."""
    assert exports.canvas_csv(sheets(), NAMED) == (
        "Student,ID,SIS User ID,SIS Login ID,Section,Least squares (48213)\n"
        "    Points Possible,,,,,4\n"
        '"Lovelace, Ada",1204,4711,ada,Monday,2.5\n'
        "Bob,,,bob,,\n"
    )


def as_canvas_does(text):
    """Read a file by the rules of Canvas' importer: where columns stand, and how it tells rows."""
    rows = list(csv.reader(io.StringIO(text)))
    header = rows[0]
    assert "Student" in header[0]
    assert "ID" in header[1]
    assert header[2:5] == ["SIS User ID", "SIS Login ID", "Section"]
    assert "Points Possible" in rows[1][0]
    assert len({len(row) for row in rows}) == 1
    columns = [name.rpartition(" (")[2].rstrip(")") for name in header[5:]]
    return {row[0]: dict(zip(columns, row[5:], strict=True)) for row in rows[2:]}


def test_canvas_finds_students_and_assignments():
    """Read by its importer's rules the file gives the points back, assignment by assignment."""
    assert as_canvas_does(exports.canvas_csv(sheets(), NAMED)) == {
        "Lovelace, Ada": {"48213": "2.5"},
        "Bob": {"48213": ""},
    }


def test_canvas_without_a_number_is_refused(tmp_path):
    """A name without its number would make a new assignment, so the table refuses it."""
    from fieldgrade.class_folder.assignments import read_assignments

    file = tmp_path / "assignments.csv"
    file.write_text("notebook,canvas\n01,Least squares\n")
    with pytest.raises(
        ValueError, match=r"a Canvas column has a name and an id, 'Least squares \(48213\)'"
    ):
        read_assignments(file)


def test_moodle_has_grade_and_feedback_together():
    """Columns as in Moodle's export; where no grade is, there is no feedback either."""
    text = exports.moodle_csv(sheets(ADA, BOB, sentence="Use <arrays> & more."), NAMED)
    header, ada, bob = csv.reader(io.StringIO(text))
    assert header == [
        "Email address",
        "Assignment: Least squares (Real)",
        "Assignment: Least squares (Feedback)",
    ]
    assert ada == [
        "ada@uni.example",
        "2.5",
        "01.1 right (2 of 2).<br>01.2 right, but slow (0.5 of 2). Use &lt;arrays&gt; &amp; more.",
    ]
    assert bob == ["bob@uni.example", "", ""]


def test_moodle_tells_students_by_number_where_more_have_one():
    """The ID number is taken where at least as many have it as have an address."""
    text = exports.moodle_csv(sheets(ADA), NAMED)
    assert text.splitlines()[0].startswith("ID number,")
    assert text.splitlines()[1].startswith("4711,")


def test_gradescope_reads_a_score_and_a_test_for_each_question():
    """The whole object, literally: late points in the score, full ones in the tests."""
    late = LatePolicy(moment("2026-11-30T23:59Z"), per_day=0.2)
    record_ = record(
        "ada",
        [grade("01.1", 2.0), grade("01.2", 0.0, sentence="Look at (1.2).")],
        received="2026-12-01T12:00:00Z",
    )
    questions = asked("01.1", "01.2") + asked("01.7", points=3.0, kind="words")
    (sheet,) = grade_sheets(
        results([record_], questions), Decisions({"01": Assignment("01", late)})
    )
    shared = {"name_format": "text", "output_format": "text", "visibility": "after_published"}
    assert json.loads(exports.gradescope_text(sheet)) == {
        "score": 1.6,
        "output": "Submitted late: 0.4 points less.",
        "output_format": "text",
        "visibility": "after_published",
        "stdout_visibility": "hidden",
        "tests": [
            {
                "score": 2.0,
                "max_score": 2.0,
                "status": "passed",
                "name": "01.1 right",
                "number": "01.1",
                "output": "",
                **shared,
            },
            {
                "score": 0.0,
                "max_score": 2.0,
                "status": "failed",
                "name": "01.2 not right yet",
                "number": "01.2",
                "output": "Look at (1.2).",
                **shared,
            },
            {
                "score": 0.0,
                "max_score": 3.0,
                "name": "01.7",
                "number": "01.7",
                "output": "Not graded yet.",
                **shared,
            },
        ],
        "extra_data": {"digest": "ab" * 32, "isolation": "bubblewrap"},
    }


def test_who_a_platform_cannot_tell_is_left_out_and_told():
    """A stray file must not stop the class, nor become somebody else's grade."""
    stray = {"student": "unknown"}
    found = sheets(ADA, stray)
    assert exports.left_out("canvas", found) == ["unknown"]
    assert "unknown" not in exports.canvas_csv(found, NAMED)
    assert exports.left_out("moodle", found) == ["unknown"]
    with pytest.raises(ValueError, match="Moodle cannot identify any student: the roster needs"):
        exports.moodle_csv(sheets(stray), NAMED)
    with pytest.raises(ValueError, match="no graded notebook has a name in Canvas"):
        exports.canvas_csv(found, {})


@pytest.mark.parametrize("formula", FORMULAS)
def test_no_spreadsheet_computes_what_a_student_wrote(formula):
    """In every table a text that begins like a formula has a quotation mark before it."""
    evil = ADA | {"name": formula, "section": formula, "student": "ada"}
    found = sheets(evil, sentence=formula)
    texts = [
        exports.gradebook_csv(found),
        exports.canvas_csv(found, NAMED),
        exports.moodle_csv(found, NAMED),
        tables.to_csv(["x"], [[formula]]),
    ]
    for text in texts:
        cells = [cell for row in csv.reader(io.StringIO(text, newline="")) for cell in row]
        assert not [c for c in cells if c.startswith(tuple("=+@\t\r＝")) or c == "-1"], text
    assert texts[3].partition("\n")[2].lstrip('"').startswith("'")


def test_numbers_are_no_formulas():
    """Points below zero stay numbers: only text is guarded."""
    assert tables.to_csv(["late"], [[-0.5], ["-0.5"]]) == "late\n-0.5\n'-0.5\n"


def test_a_table_without_the_guard_is_caught(monkeypatch):
    """Were texts written as they come, the test above would see a formula."""
    monkeypatch.setattr(tables, "_safe", lambda text: text)
    assert "\n=1+1" in tables.to_csv(["x"], [["=1+1"]])


def test_a_name_that_looks_like_a_comment_survives(tmp_path):
    """A student called #1 does not vanish when a table is written and read again."""
    file = tmp_path / "t.csv"
    file.write_text(tables.to_csv(["student"], [["#1"], ["'#2"], ["=3"]]))
    assert tables.read_table(file, lambda row: row["student"], ["student"]) == ["#1", "'#2", "=3"]
