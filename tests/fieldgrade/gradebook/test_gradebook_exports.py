"""The exported files have the form that each learning platform imports."""

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


def test_the_canvas_file_has_the_columns_of_canvas_in_order():
    """The second row has the possible points; a missing submission leaves its cell empty."""
    assert exports.canvas_csv(sheets(), NAMED) == (
        "Student,ID,SIS User ID,SIS Login ID,Section,Least squares (48213)\n"
        "    Points Possible,,,,,4\n"
        '"Lovelace, Ada",1204,4711,ada,Monday,2.5\n'
        "Bob,,,bob,,\n"
    )


def read_as_canvas(text):
    """Read a file by the rules of the importer of Canvas, which finds columns by position."""
    rows = list(csv.reader(io.StringIO(text)))
    header = rows[0]
    assert "Student" in header[0]
    assert "ID" in header[1]
    assert header[2:5] == ["SIS User ID", "SIS Login ID", "Section"]
    assert "Points Possible" in rows[1][0]
    assert len({len(row) for row in rows}) == 1
    columns = [name.rpartition(" (")[2].rstrip(")") for name in header[5:]]
    return {row[0]: dict(zip(columns, row[5:], strict=True)) for row in rows[2:]}


def test_the_canvas_file_assigns_points_to_students_and_assignments():
    """The points are read by the rules of the importer."""
    assert read_as_canvas(exports.canvas_csv(sheets(), NAMED)) == {
        "Lovelace, Ada": {"48213": "2.5"},
        "Bob": {"48213": ""},
    }


def test_a_canvas_assignment_without_an_id_is_refused(tmp_path):
    """Canvas would create a new assignment from a name without an id."""
    from fieldgrade.class_folder.assignments import read_assignments

    file = tmp_path / "assignments.csv"
    file.write_text("notebook,canvas\n01,Least squares\n")
    with pytest.raises(
        ValueError, match=r"a Canvas column has a name and an id, 'Least squares \(48213\)'"
    ):
        read_assignments(file)


def test_the_moodle_file_has_grades_and_feedback():
    """The columns are those of Moodle's own export; without a grade there is no feedback."""
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


def test_the_moodle_file_identifies_students_by_the_more_complete_column():
    """The ID number is used if at least as many students have one as have an address."""
    text = exports.moodle_csv(sheets(ADA), NAMED)
    assert text.splitlines()[0].startswith("ID number,")
    assert text.splitlines()[1].startswith("4711,")


def test_the_gradescope_file_has_a_score_and_one_test_per_question():
    """The total score includes the late penalty, the scores of the tests do not."""
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


def test_students_without_a_platform_id_are_left_out_and_reported():
    """A stray file neither stops the export nor becomes the grade of somebody else."""
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
def test_text_that_looks_like_a_formula_is_quoted_in_every_table(formula):
    """A quotation mark keeps a spreadsheet from evaluating what a student wrote."""
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


def test_negative_numbers_are_not_quoted():
    """Only text is quoted."""
    assert tables.to_csv(["late"], [[-0.5], ["-0.5"]]) == "late\n-0.5\n'-0.5\n"


def test_without_quoting_a_formula_reaches_the_table(monkeypatch):
    """A mutant that the test of quoted formulas catches."""
    monkeypatch.setattr(tables, "_safe", lambda text: text)
    assert "\n=1+1" in tables.to_csv(["x"], [["=1+1"]])


def test_a_student_named_like_a_comment_is_read_back(tmp_path):
    """A student called #1 is still in a table that is written and read again."""
    file = tmp_path / "t.csv"
    file.write_text(tables.to_csv(["student"], [["#1"], ["'#2"], ["=3"]]))
    assert tables.read_table(file, lambda row: row["student"], ["student"]) == ["#1", "'#2", "=3"]
