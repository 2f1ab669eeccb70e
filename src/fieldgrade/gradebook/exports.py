"""The gradebook as a table, and grades as Canvas, Moodle and Gradescope import them."""

from __future__ import annotations

import html
import io
import json
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from typing import Any

from fieldgrade.class_folder.assignments import Assignment
from fieldgrade.class_folder.csv_tables import short, to_csv
from fieldgrade.gradebook.explanations import about, in_one_line, summary
from fieldgrade.gradebook.grade_sheets import GradeLine, GradeSheet, by_student


def gradebook_csv(sheets: Iterable[GradeSheet]) -> str:
    """Return a row for each student, with a column for each question, deduction and sum.

    An empty cell is an answer that nobody has graded yet, or a submission for which the grader
    failed.
    """
    rows = by_student(sheets)
    columns = ["student", "name", "section"]
    for sheet in rows[0] if rows else ():
        columns += [_column(line) for line in sheet.lines]
        columns += [f"{sheet.notebook} {what}" for what in ("late", "points", "status")]
    return to_csv([*columns, "points", "unreadable files"], (_row(row) for row in rows))


def _column(line: GradeLine) -> str:
    column = f"{line.question} of {short(line.possible)}"
    return column if line.counts else f"{column}, optional"


def _row(sheets: Sequence[GradeSheet]) -> list[object]:
    student = sheets[0].student
    row: list[object] = [student["student"], student.get("name", ""), student.get("section", "")]
    for sheet in sheets:
        row += [None if line.how == "open" else line.points for line in sheet.lines]
        failed = sheet.record is not None and not sheet.has_grade
        row += [-sheet.late_penalty, None if failed else sheet.points, sheet.status]
    unreadable = "; ".join(record.file for record in sheets[0].unreadable)
    return [*row, sum(sheet.points for sheet in sheets), unreadable]


def canvas_csv(sheets: Iterable[GradeSheet], assignments: Mapping[str, Assignment]) -> str:
    """Return a file for *Import* in the gradebook of Canvas.

    Canvas expects the columns Student, ID, SIS User ID, SIS Login ID and Section, in this order,
    then one for each assignment. It identifies a student by the ID, then by the SIS User ID, then
    by the login, and an assignment by the number in parentheses after its name; without the number
    it would create a new assignment. A row that begins with Points Possible follows the header. An
    empty cell deletes the grade that Canvas has, so a student without any grade has no row::

        Student,ID,SIS User ID,SIS Login ID,Section,Least squares (48213)
            Points Possible,,,,,20
        "Lovelace, Ada",1204,4711,ada,Monday,17.5

    Parameters
    ----------
    sheets : iterable of GradeSheet
        The final grades. Students without canvas_id, sis_id and login in the roster are left out.
    assignments : mapping
        The names of the notebooks in Canvas.

    Raises
    ------
    ValueError
        No notebook has a name in Canvas, or no student can be identified.

    References
    ----------
    Instructure, "How do I import grades in the Gradebook?", Canvas Instructor Guide; and in
    github.com/instructure/canvas-lms ``lib/gradebook_importer.rb``, which reads the file,
    ``spec/lib/gradebook_importer_spec.rb`` and ``spec/fixtures/gradebooks/``, with examples.
    """
    rows = _identified("canvas", by_student(sheets))
    named = _named("canvas", rows, {n: a.canvas for n, a in assignments.items()})
    graded = _graded(rows, named)
    header = ["Student", "ID", "SIS User ID", "SIS Login ID", "Section"]
    possible: list[object] = ["    Points Possible", None, None, None, None]
    return to_csv(
        [*header, *named.values()],
        [
            [*possible, *(_possible(rows, notebook) for notebook in named)],
            *([*_canvas_student(row[0].student), *_points(row, named)] for row in graded),
        ],
    )


def _canvas_student(student: Mapping[str, str]) -> list[object]:
    name = student.get("name") or student["student"]
    return [name, *(student.get(c, "") for c in ("canvas_id", "sis_id", "login", "section"))]


def moodle_csv(sheets: Iterable[GradeSheet], assignments: Mapping[str, Assignment]) -> str:
    """Return a file for *Import, CSV file* in the grades of Moodle.

    It has the columns of Moodle's own export: the student, and for each assignment the grade and
    the feedback. Students are identified by ID number or e-mail address, whichever more of them
    have; map this column to the same field. Grade and feedback have to be imported together:
    feedback without grades deletes the grades. An empty cell deletes the grade that Moodle has, so
    a student without any grade has no row. The feedback is HTML::

        Email address,Assignment: Least squares (Real),Assignment: Least squares (Feedback)
        ada@uni.dk,17.5,01.1 The matrix: right (2 of 2).<br>01.2 The coefficients: wrong (0 of 2).

    Parameters
    ----------
    sheets : iterable of GradeSheet
        The final grades. Students without sis_id (Moodle's ID number) or email in the roster are
        left out.
    assignments : mapping
        The names of the notebooks in Moodle: ``"Assignment: Least squares"``.

    Raises
    ------
    ValueError
        No notebook has a name in Moodle, or no student can be identified.

    References
    ----------
    Moodle documentation, "Grade import", https://docs.moodle.org/en/Grade_import, "CSV grade
    import" and note 3; and in github.com/moodle/moodle ``grade/import/csv/classes/load_data.php``,
    which reads the file, ``grade/import/csv/tests/load_data_test.php``, with examples, and
    ``grade/export/lib.php``, which names the columns.
    """
    rows = _identified("moodle", by_student(sheets))
    named = _named("moodle", rows, {n: a.moodle for n, a in assignments.items()})
    (key,) = _keys("moodle", rows)
    columns = ["ID number" if key == "sis_id" else "Email address"]
    for name in named.values():
        columns += [f"{name} (Real)", f"{name} (Feedback)"]
    return to_csv(
        columns,
        ([row[0].student[key], *_grades_and_feedback(row, named)] for row in _graded(rows, named)),
    )


def _grades_and_feedback(row: Sequence[GradeSheet], named: Iterable[str]) -> Iterable[object]:
    """Yield grade and feedback of each notebook: both, or neither."""
    sheets = {sheet.notebook: sheet for sheet in row if sheet.has_grade}
    for notebook in named:
        sheet = sheets.get(notebook)
        yield sheet.points if sheet else None
        yield feedback_html(sheet) if sheet else None


def feedback_html(sheet: GradeSheet) -> str:
    """Return the feedback on a notebook as Moodle shows it, a line for each question."""
    return "<br>".join(html.escape(said) for said in summary(sheet))


def gradescope_json(sheet: GradeSheet) -> dict[str, Any]:
    """Return what Gradescope reads as ``results.json`` of a submission.

    It has one test for each question. The total score is included, since it contains the late
    penalty, and Gradescope uses it instead of the sum. A question that is not graded yet has no
    status::

        {"score": 17.5, "output": "", "output_format": "text", "visibility": "after_published",
         "stdout_visibility": "hidden", "extra_data": {},
         "tests": [{"score": 2.0, "max_score": 2.0, "status": "passed",
                    "name": "01.1 The matrix: right", "name_format": "text", "number": "01.1",
                    "output": "", "output_format": "text", "visibility": "after_published"}]}

    References
    ----------
    Gradescope, "Autograder Specifications: Output format",
    https://gradescope-autograders.readthedocs.io/en/latest/specs/; its source is ``docs/specs.md``
    in github.com/gradescope/autograder_samples.
    """
    return {
        "score": sheet.points,
        "output": "\n".join(about(sheet)),
        "output_format": "text",
        "visibility": "after_published",
        "stdout_visibility": "hidden",
        "tests": [_test(line) for line in sheet.lines],
        "extra_data": {
            "digest": sheet.record.digest if sheet.record else "",
            "isolation": sheet.record.tier if sheet.record else "",
        },
    }


def _test(line: GradeLine) -> dict[str, Any]:
    name, output = in_one_line(line)
    test = {
        "score": line.points,
        "max_score": line.possible,
        "name": name,
        "name_format": "text",
        "number": line.question,
        "output": output,
        "output_format": "text",
        "visibility": "after_published",
    }
    status = "passed" if line.points >= line.possible else "failed"
    return test if line.how == "open" else test | {"status": status}


def gradescope_text(sheet: GradeSheet) -> str:
    """Return `gradescope_json` as the text of the file."""
    return json.dumps(gradescope_json(sheet), indent=1, ensure_ascii=False) + "\n"


def gradescope_zip(sheets: Iterable[GradeSheet]) -> bytes:
    """Return an autograder for Gradescope that shows the grades of a notebook.

    Gradescope imports no files with results: its only way is an autograder, which runs for each
    submission and writes ``results.json``. The zip file has ``setup.sh``, ``run_autograder``, and
    the results by e-mail address. It has no solutions and no hidden inputs, and runs no submission.

    Parameters
    ----------
    sheets : iterable of GradeSheet
        The final grades of one notebook. Students without email in the roster are left out.

    References
    ----------
    Gradescope, "Autograder Specifications", as for `gradescope_json`.
    """
    results = {
        sheet.student["email"].lower(): gradescope_json(sheet)
        for sheet in sheets
        if sheet.has_grade and sheet.student.get("email")
    }
    program = files(__package__).joinpath("gradescope_autograder.py").read_text(encoding="utf-8")
    content = {
        "setup.sh": "#!/usr/bin/env bash\napt-get update && apt-get install -y python3\n",
        "run_autograder": f"#!/usr/bin/env python3\n{program}",
        "results.json": json.dumps(results, indent=1, ensure_ascii=False) + "\n",
    }
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in content.items():
            entry = zipfile.ZipInfo(name)  # of 1980, so that equal grades give equal bytes
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o755 << 16
            archive.writestr(entry, text)
    return packed.getvalue()


def _points(row: Sequence[GradeSheet], named: Iterable[str]) -> list[object]:
    points = {sheet.notebook: sheet.points for sheet in row if sheet.has_grade}
    return [points.get(notebook) for notebook in named]


def _graded(
    rows: Iterable[Sequence[GradeSheet]], named: Mapping[str, str]
) -> list[Sequence[GradeSheet]]:
    """Return the rows of students with a grade for at least one of the named notebooks."""
    return [row for row in rows if any(s.has_grade and s.notebook in named for s in row)]


def _possible(rows: Sequence[Sequence[GradeSheet]], notebook: str) -> object:
    return next((s.possible for row in rows for s in row if s.notebook == notebook), None)


def _named(
    column: str, rows: Sequence[Sequence[GradeSheet]], names: Mapping[str, str]
) -> Mapping[str, str]:
    """Return the platform's names of the graded notebooks."""
    graded = {sheet.notebook for sheet in (rows[0] if rows else ())}
    named = {notebook: name for notebook, name in names.items() if name and notebook in graded}
    if not named:
        raise ValueError(
            f"no graded notebook has a name in {column.title()}: enter it in assignments.csv, in "
            f"the column {column}"
        )
    return named


def left_out(platform: str, sheets: Iterable[GradeSheet]) -> list[str]:
    """Return the students whom a platform cannot identify, and who are not in its file."""
    rows = by_student(sheets)
    keys, students = _keys(platform, rows), [row[0].student for row in rows]
    return [s["student"] for s in students if not any(s.get(key) for key in keys)]


def _identified(platform: str, rows: Sequence[Sequence[GradeSheet]]) -> list[Sequence[GradeSheet]]:
    """Return the rows of students whom a platform can identify."""
    keys = _keys(platform, rows)
    identified = [row for row in rows if any(row[0].student.get(key) for key in keys)]
    if not identified:
        raise ValueError(
            f"{platform.title()} cannot identify any student: the roster needs {' or '.join(keys)}"
        )
    return identified


def _keys(platform: str, rows: Sequence[Sequence[GradeSheet]]) -> tuple[str, ...]:
    """Return the columns of the roster by which a platform identifies students.

    For Moodle it is one of two: the one that more students have.
    """
    if platform == "canvas":
        return "canvas_id", "sis_id", "login"
    if platform == "gradescope":
        return ("email",)
    students = [row[0].student for row in rows]
    having = {key: sum(bool(s.get(key)) for s in students) for key in ("sis_id", "email")}
    return (max(having, key=lambda key: having[key]),)
