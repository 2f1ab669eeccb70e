"""The exported files have the form that each learning platform imports."""

import csv
import io
import json
import re
import zipfile
from datetime import date

import pytest

from fieldgrade.class_folder import csv_tables as tables
from fieldgrade.class_folder.assignments import Assignment, read_assignments
from fieldgrade.class_folder.decisions import Decisions
from fieldgrade.class_folder.example import write_example_class
from fieldgrade.class_folder.late_policy import LatePolicy, moment
from fieldgrade.class_folder.overrides import Override
from fieldgrade.gradebook import exports
from fieldgrade.gradebook.grade_sheets import grade_sheets
from fieldrecon.cli.main import main
from gradebook_class import ROOT, asked, grade, record, results

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
MOODLE_KINDS = ("Assignment", "Feedback")
FORMULAS = ["=1+1", "+1", "-1", "@SUM(1)", "\t=1", "\r=1", "＝1", '=HYPERLINK("http://x","y")']


def sheets(*students, decisions=None, **parts):
    found = [
        record("ada", [grade("01.1", 2.0), grade("01.2", 0.5, finding="slow", **parts)]),
        record("ada", [grade("02.1", 1.0)], notebook="02"),
    ]
    questions = asked("01.1", "01.2", "02.1")
    return grade_sheets(results(found, questions, students or (ADA, BOB)), decisions)


def test_the_canvas_file_has_the_columns_of_canvas_in_order():
    """The second row has the possible points; a student without a grade has no row."""
    assert exports.canvas_csv(sheets(), NAMED) == (
        "Student,ID,SIS User ID,SIS Login ID,Section,Least squares (48213)\n"
        "    Points Possible,,,,,4\n"
        '"Lovelace, Ada",1204,4711,ada,Monday,2.5\n'
    )


TOTALS = re.compile("(Current|Final) (Score|Points|Grade)|Override (Score|Grade|Status)")


def read_as_canvas(text):
    """Return grades by student and assignment, and possible points, as Canvas reads a file.

    The rules are those of lib/gradebook_importer.rb of github.com/instructure/canvas-lms.
    """
    header, *rows = csv.reader(io.StringIO(text))
    assert "Student" in header[0]
    assert "ID" in header[1]
    login = 2 if "SIS Login ID" in header[2] else 3 if "SIS User ID" in header[2] else None
    assert login is None or "SIS Login ID" in header[login]
    first = (login or 1) + 2
    assert "Section" in header[first - 1]
    kept = {n: i for i, n in enumerate(header) if i >= first and not TOTALS.search(n)}
    possible, grades = {}, {}
    for row in rows:
        assert len(row) == len(header)
        cells = {name: row[i].strip() for name, i in kept.items()}
        if "Points Possible" in row[0]:
            possible = cells
        elif not all(re.fullmatch(r"\s*(Muted|Manual Posting.*)?\s*", c, re.I) for c in row):
            grades[row[1] or row[login or 0]] = cells
    return grades, possible


def test_files_of_canvas_are_read_as_canvas_reads_them():
    """Examples of spec/lib/gradebook_importer_spec.rb and spec/fixtures/gradebooks/ of Canvas."""
    weird = (
        "Student,ID,Section,Assignment 1,Final Score\n"
        '"Blend, Bill",6,My Course,-,\nPoints Possible,,,10,\n, ,,Muted,\n'
        '"Farner, Todd",4,My Course,-,\n'
    )
    none = {"Assignment 1": "-"}
    assert read_as_canvas(weird) == ({"6": none, "4": none}, {"Assignment 1": "10"})
    with_login = (
        "Student,ID,SIS Login ID,Section,Assignment 1,Comments,Final Score (read only)\n"
        'Points Possible,,,,,,\n"Blend, Bill",6,,My Course,-,,\n'
    )
    assert list(read_as_canvas(with_login)[0]["6"]) == ["Assignment 1", "Comments"]


def test_canvas_reads_the_points_of_each_student():
    """Every column is found: each assignment by its id, each student by id or login."""
    extra = Override("bob", "01.1", 1.0, "Hopper", "on paper", date(2026, 12, 2))
    grades, possible = read_as_canvas(
        exports.canvas_csv(sheets(decisions=Decisions(overrides=[extra])), NAMED)
    )
    name = "Least squares (48213)"
    assert possible == {name: "4"}
    assert grades == {"1204": {name: "2.5"}, "bob": {name: "1"}}


@pytest.mark.parametrize("platform", ["canvas", "moodle"])
def test_no_cell_deletes_a_grade_of_a_student_who_submitted_nothing(platform):
    """Both platforms delete a grade for an empty cell, so such a student has no row.

    Canvas: populateGradeDataPerSubmission posts each cell that differs from the grade; Moodle:
    update_grade_item of load_data.php makes an empty cell a grade without value.
    """
    write = {"canvas": exports.canvas_csv, "moodle": exports.moodle_csv}[platform]
    assert "bob" not in write(sheets(), NAMED)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("01,Final Points (7)\n", "2: Canvas skips a column named 'Final Points .7.'"),
        ("01,LS (7)\n02,LS (7)\n", r"3: canvas LS \(7\) is already in line 2"),
        ("01,LS (7)\n01,MLS (8)\n", "3: notebook 01 is already in line 2"),
    ],
)
def test_an_assignment_whose_column_would_be_lost_in_canvas_is_refused(lines, message, tmp_path):
    """Canvas skips columns of totals, and takes the first of two columns of one assignment."""
    file = tmp_path / "assignments.csv"
    file.write_text("notebook,canvas\n" + lines)
    with pytest.raises(ValueError, match=message):
        read_assignments(file)


def test_a_canvas_assignment_without_an_id_is_refused(tmp_path):
    """Canvas would create a new assignment from a name without an id."""
    file = tmp_path / "assignments.csv"
    file.write_text("notebook,canvas\n01,Least squares\n")
    with pytest.raises(
        ValueError, match=r"a Canvas column has a name and an id, 'Least squares \(48213\)'"
    ):
        read_assignments(file)


def test_the_moodle_file_has_grades_and_feedback():
    """The columns are those of Moodle's own export; a student without a grade has no row."""
    text = exports.moodle_csv(sheets(ADA, BOB, sentence="Use <arrays> & more."), NAMED)
    header, ada = csv.reader(io.StringIO(text))
    assert header == [
        "Email address",
        "Assignment: Least squares (Real)",
        "Assignment: Least squares (Feedback)",
    ]
    assert ada == [
        "ada@uni.example",
        "2.5",
        "01.1: right (2 of 2).<br>"
        "01.2: right, but too slow (0.5 of 2). Use &lt;arrays&gt; &amp; more.",
    ]


def read_as_moodle(text, columns):
    """Return grade and feedback by student, as Moodle reads a file in which columns are mapped.

    The rules are those of grade/import/csv/classes/load_data.php of github.com/moodle/moodle: every
    line has a cell for each column, and a grade is a number, or empty or - for none.
    """
    header, *rows = csv.reader(io.StringIO(text), skipinitialspace=True)
    assert {len(row) for row in rows} == {len(header)}
    who, grade, feedback = (header.index(name) for name in columns)
    return {
        row[who]: (float(row[grade]) if row[grade] not in ("", "-") else None, row[feedback])
        for row in rows
    }


def test_the_example_of_moodle_and_the_moodle_file_are_read_alike():
    """The example is $oktext of grade/import/csv/tests/load_data_test.php."""
    example = (
        '"First name",Surname,"ID number","Email address","Assignment: Assignment for grape group",'
        ' "Feedback: Assignment for grape group"\n'
        'Anne,Able,,student7@example.com,56.00,"We welcome feedback"\n'
        "Bobby,Bunce,,student5@example.com,75.00,\n"
    )
    columns = ("Email address", *(f"{n}: Assignment for grape group" for n in MOODLE_KINDS))
    assert read_as_moodle(example, columns) == {
        "student7@example.com": (56.0, "We welcome feedback"),
        "student5@example.com": (75.0, ""),
    }
    ours = ("Email address", *(f"Assignment: Least squares ({n})" for n in ("Real", "Feedback")))
    read = read_as_moodle(exports.moodle_csv(sheets(), NAMED), ours)
    assert {who: points for who, (points, _) in read.items()} == {"ada@uni.example": 2.5}
    assert read["ada@uni.example"][1].startswith("01.1: right (2 of 2).<br>")


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
                "name": "01.1: right",
                "number": "01.1",
                "output": "",
                **shared,
            },
            {
                "score": 0.0,
                "max_score": 2.0,
                "status": "failed",
                "name": "01.2: wrong",
                "number": "01.2",
                "output": "Look at (1.2).",
                **shared,
            },
            {
                "score": 0.0,
                "max_score": 3.0,
                "name": "01.7: not graded yet",
                "number": "01.7",
                "output": "",
                **shared,
            },
        ],
        "extra_data": {"digest": "ab" * 32, "isolation": "bubblewrap"},
    }


# docs/specs.md of github.com/gradescope/autograder_samples: the keys of the example, and the values
# that the text below it permits.
# fmt: off
SPECIFIED = {
    "score", "execution_time", "output", "output_format", "test_output_format",
    "test_name_format", "visibility", "stdout_visibility", "extra_data", "tests", "leaderboard",
}
OF_TEST = {
    "score", "max_score", "status", "name", "name_format", "number", "output",
    "output_format", "tags", "visibility", "extra_data",
}
# fmt: on
VISIBILITIES = {"hidden", "after_due_date", "after_published", "visible"}


def test_the_results_for_gradescope_have_only_specified_keys_and_values():
    """Formats, visibilities and states are those of the specification."""
    for sheet in sheets():
        found = exports.gradescope_json(sheet)
        assert set(found) <= SPECIFIED
        for part in (found, *found["tests"]):
            assert part["visibility"] in VISIBILITIES
            assert part["output_format"] in {"text", "html", "simple_format", "md", "ansi"}
        for test in found["tests"]:
            assert set(test) <= OF_TEST
            assert test.get("status", "passed") in {"passed", "failed"}
        assert found["stdout_visibility"] in VISIBILITIES


def test_the_autograder_for_gradescope_shows_each_submitter_the_own_result(tmp_path):
    """It runs in the folders of the specification, on the example of submission_metadata.md."""
    example = {
        "id": 123456,
        "created_at": "2018-07-01T14:22:32.365935-07:00",
        "assignment": {"id": 25828, "title": "Programming Assignment 1", "total_points": "20.0"},
        "submission_method": "upload",
        "users": [{"email": "student@example.com", "id": 1234, "name": "Student User"}],
        "previous_submissions": [],
    }
    student = ADA | {"email": "Student@Example.com"}
    packed = exports.gradescope_zip(s for s in sheets(student) if s.notebook == "01")
    assert packed == exports.gradescope_zip(s for s in sheets(student) if s.notebook == "01")
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        archive.extractall(tmp_path / "source")
        modes = {entry.filename: entry.external_attr >> 16 for entry in archive.infolist()}
    assert modes["run_autograder"] & modes["setup.sh"] & 0o111 == 0o111
    program = (tmp_path / "source/run_autograder").read_text()
    assert program.startswith("#!/usr/bin/env python3\n")
    names = {"__name__": "tested"}
    exec(program, names)
    shown = []
    for email in ("student@example.com", "nobody@example.com"):
        example["users"][0]["email"] = email
        (tmp_path / "submission_metadata.json").write_text(json.dumps(example))
        names["show_result"](tmp_path)
        shown.append(json.loads((tmp_path / "results/results.json").read_text()))
    assert shown[0] == exports.gradescope_json(sheets(student)[0])
    assert shown[1]["score"] == 0
    assert shown[1]["output"] == "There is no grade yet for nobody@example.com."


def test_a_submission_for_which_the_grader_failed_has_no_points_in_any_file():
    """A zero would lower the grade that the platform has."""
    failed = record("ada", [], status="grader failed", notes=("the grader failed: no space left",))
    sound = record("bob", [grade("01.1", 2.0)])
    found = grade_sheets(results([failed, sound], asked("01.1"), (ADA, BOB)))
    assert "Ada" not in exports.canvas_csv(found, NAMED)
    assert "ada@uni.example" not in exports.moodle_csv(found, NAMED)
    assert exports.gradebook_csv(found).splitlines()[1].endswith(",,0,,grader failed,0,")
    assert [sheet.has_grade for sheet in found] == [False, True]


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


PEOPLE = {"ada": ("Ada", "Berg", 10.0), "bob": ("Bob", "Carr", 7.0), "cai": ("Cai", "Dahl", 8.0)}


def download(platform, content):
    """The files of a download of the example class, named as the platform names them.

    Canvas: lib/content_zipper.rb; Moodle: mod/assign/locallib.php; Gradescope: its export. Moodle
    gives each student the number that another has at the university.
    """
    files, metadata = {}, ""
    for k, (student, (first, last, _)) in enumerate(PEOPLE.items(), start=1):
        place = {
            "canvas": f"{last}{first}_{1200 + k}_{90000 + k}_".lower(),
            "moodle": f"{first} {last}_{4705 - k}_assignsubmission_file/",
            "gradescope": f"assignment_5_export/submission_{700 + k}/",
        }[platform]
        files[f"{place}my answers.ipynb"] = content[student]
        metadata += f"submission_{700 + k}:\n  :submitters:\n  - :name: {first} {last}\n"
        metadata += f"    :sid: '{4700 + k}'\n    :email: {student}@uni.example\n"
    if platform == "gradescope":
        files["assignment_5_export/submission_metadata.yml"] = metadata.encode()
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for name, body in files.items():
            archive.writestr(name, body)
    return packed.getvalue()


def exported_points(platform, out):
    """The points in the file for a platform, by the identifier that it uses for a student."""
    if platform == "canvas":
        grades, _ = read_as_canvas((out / "canvas.csv").read_text("utf-8"))
        return {who: float(row["Least squares (48213)"]) for who, row in grades.items()}
    if platform == "moodle":
        columns = ("ID number", *(f"Assignment: Least squares ({n})" for n in ("Real", "Feedback")))
        grades = read_as_moodle((out / "moodle.csv").read_text("utf-8"), columns)
        return {who: points for who, (points, _) in grades.items()}
    with zipfile.ZipFile(out / "gradescope/01.zip") as archive:
        shown = json.loads(archive.read("results.json"))
    return {who: result["score"] for who, result in shown.items()}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("platform", "identifier"),
    [("canvas", "120{k}"), ("moodle", "470{k}"), ("gradescope", "{student}@uni.example")],
)
def test_grades_go_from_the_download_of_a_platform_back_to_it(platform, identifier, tmp_path):
    """As docs/instructors.md describes it, with the tables of the example class."""
    submissions, folder = write_example_class(tmp_path / "example")
    content = {s: (submissions / s / "01_least_squares.ipynb").read_bytes() for s in PEOPLE}
    (tmp_path / "submissions.zip").write_bytes(download(platform, content))
    root, places = ["--root", str(ROOT)], ["--class", str(folder), "--out", str(tmp_path / "out")]
    assert main(["grade", str(tmp_path / "submissions.zip"), *places, *root, "--jobs", "1"]) == 0
    assert main(["course", *root, "export", str(tmp_path / "out"), *places]) == 0
    assert exported_points(platform, tmp_path / "out") == {
        identifier.format(k=k, student=student): points
        for k, (student, (_, _, points)) in enumerate(PEOPLE.items(), start=1)
    }
