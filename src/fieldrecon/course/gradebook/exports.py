"""Grades in the forms that others read: a table, Gradescope, Canvas and Moodle."""

from __future__ import annotations

import html
import json
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import Any

from fieldcheck.verdict import TITLES
from fieldrecon.course.gradebook.assignments import Assignment
from fieldrecon.course.gradebook.sheets import Line, Sheet
from fieldrecon.course.grading.tables import short, to_csv

NOT_READ = "Not read yet."


def gradebook_csv(sheets: Iterable[Sheet]) -> str:
    """Return a row for each student, with a column for each question, deduction and sum."""
    rows = _by_student(sheets)
    columns = ["student", "name", "section"]
    for sheet in rows[0] if rows else ():
        columns += [f"{line.question} of {short(line.possible)}" for line in sheet.lines]
        columns += [f"{sheet.notebook} {what}" for what in ("late", "points", "status")]
    return to_csv([*columns, "points"], (_row(row) for row in rows))


def _row(sheets: Sequence[Sheet]) -> list[object]:
    student = sheets[0].student
    row: list[object] = [student["student"], student.get("name", ""), student.get("section", "")]
    for sheet in sheets:
        row += [None if line.how == "open" else line.points for line in sheet.lines]
        row += [-sheet.lost, sheet.points, sheet.status]
    return [*row, sum(sheet.points for sheet in sheets)]


def canvas_csv(sheets: Iterable[Sheet], assignments: Mapping[str, Assignment]) -> str:
    """Return a file for *Import* in the gradebook of Canvas.

    The columns that Canvas wants are Student, ID, SIS Login ID and Section, in this order; then one
    for each notebook that has a name there, with its number in parentheses: without the number
    Canvas would make a new assignment. The second row has the points possible, which Canvas takes
    over. A notebook that was not handed in has an empty cell, which leaves Canvas as it is.

    Parameters
    ----------
    sheets : iterable of Sheet
        The grades. The roster has the columns name, canvas (Canvas' ID of the student), login and
        section.
    assignments : mapping
        What the notebooks are called.

    Raises
    ------
    ValueError
        No notebook has a name in Canvas, or a student neither an ID nor a login.

    References
    ----------
    Instructure, "How do I import grades in the Gradebook?", Canvas Instructor Guide; and what reads
    the file, ``lib/gradebook_importer.rb`` of github.com/instructure/canvas-lms.
    """
    rows = _by_student(sheets)
    named = _named("canvas", rows, {n: a.canvas for n, a in assignments.items()})
    _require_told("Canvas", "canvas or login", rows, ("canvas", "login"))
    header = ["Student", "ID", "SIS Login ID", "Section"]
    possible: list[object] = ["    Points Possible", None, None, None]
    return to_csv(
        [*header, *named.values()],
        [
            [*possible, *(_possible(rows, notebook) for notebook in named)],
            *([*_canvas_student(row[0].student), *_points(row, named)] for row in rows),
        ],
    )


def _canvas_student(student: Mapping[str, str]) -> list[object]:
    name = student.get("name") or student["student"]
    return [name, *(student.get(column, "") for column in ("canvas", "login", "section"))]


def moodle_csv(sheets: Iterable[Sheet], assignments: Mapping[str, Assignment]) -> str:
    """Return a file for *Import, CSV file* in the grades of Moodle.

    Students are told by their ID number where all have one, otherwise by their address; map it to
    *ID number* or *Email address*. Each notebook has two columns, for the grade and for the
    feedback, which have to be imported together: feedback without grades deletes the grades.

    Parameters
    ----------
    sheets : iterable of Sheet
        The grades. The roster has the column idnumber, or email.
    assignments : mapping
        What the notebooks are called in Moodle.

    Raises
    ------
    ValueError
        No notebook has a name in Moodle, or a student neither a number nor an address.

    References
    ----------
    Moodle documentation, "Grade import", https://docs.moodle.org/en/Grade_import, notes 1 and 3.
    """
    rows = _by_student(sheets)
    named = _named("moodle", rows, {n: a.moodle for n, a in assignments.items()})
    numbered = all(row[0].student.get("idnumber") for row in rows)
    key, title = ("idnumber", "ID number") if numbered else ("email", "Email address")
    _require_told("Moodle", "idnumber for everybody, or email", rows, (key,))
    columns = [title]
    for name in named.values():
        columns += [f"{name} (grade)", f"{name} (feedback)"]
    return to_csv(
        columns, ([row[0].student[key], *_grades_and_feedback(row, named)] for row in rows)
    )


def _grades_and_feedback(row: Sequence[Sheet], named: Iterable[str]) -> Iterable[object]:
    """Yield grade and feedback of each notebook: both, or neither."""
    sheets = {sheet.notebook: sheet for sheet in row if sheet.record}
    for notebook in named:
        sheet = sheets.get(notebook)
        yield sheet.points if sheet else None
        yield "<br>".join(html.escape(said) for said in summary(sheet)) if sheet else None


def gradescope_json(sheet: Sheet) -> dict[str, Any]:
    """Return what Gradescope reads as ``results.json`` of a submission.

    One test for each question. The score of the whole is given too, since it knows what being late
    costs, and Gradescope takes it in place of the sum.

    References
    ----------
    Gradescope, "Autograder Specifications: Output format",
    https://gradescope-autograders.readthedocs.io/en/latest/specs/.
    """
    return {
        "score": sheet.points,
        "output": "\n".join(_about(sheet)),
        "output_format": "text",
        "visibility": "after_published",
        "stdout_visibility": "hidden",
        "tests": [_test(line) for line in sheet.lines],
        "extra_data": {"digest": sheet.record.digest if sheet.record else "",
                       "isolation": sheet.record.tier if sheet.record else ""},
    }  # fmt: skip


def _test(line: Line) -> dict[str, Any]:
    return {
        "number": line.question,
        "name": said_of(line)[0],
        "name_format": "text",
        "score": line.points,
        "max_score": line.possible,
        "status": "passed" if line.points == line.possible else "failed",
        "output": said_of(line)[1],
        "output_format": "text",
        "visibility": "after_published",
    }


def gradescope_text(sheet: Sheet) -> str:
    """Return `gradescope_json` as the text of the file."""
    return json.dumps(gradescope_json(sheet), indent=1, ensure_ascii=False) + "\n"


def said_of(line: Line) -> tuple[str, str]:
    """Return what is said of an answer: a title, and a sentence that may be empty."""
    if line.how == "open":
        return line.question, NOT_READ
    if line.grade is None:
        return line.question, line.comment
    title = f"{line.question} {TITLES[line.grade.verdict.rung]}"
    said = (line.grade.verdict.sentence, f"Changed: {line.comment}" if line.comment else "")
    return title, " ".join(filter(None, said))


def summary(sheet: Sheet) -> list[str]:
    """Return the feedback on a notebook, a line for each question."""
    lines = [
        f"{title} ({short(line.points)} of {short(line.possible)}). {sentence}".strip()
        for line in sheet.lines for title, sentence in (said_of(line),)
    ]  # fmt: skip
    return [*_about(sheet), *lines]


def _about(sheet: Sheet) -> list[str]:
    return [f"Handed in late: {short(sheet.lost)} points less."] if sheet.lost else []


def _by_student(sheets: Iterable[Sheet]) -> list[list[Sheet]]:
    return [list(row) for _, row in groupby(sheets, key=lambda s: s.student["student"])]


def _points(row: Sequence[Sheet], named: Iterable[str]) -> list[object]:
    points = {sheet.notebook: sheet.points for sheet in row if sheet.record}
    return [points.get(notebook) for notebook in named]


def _possible(rows: Sequence[Sequence[Sheet]], notebook: str) -> object:
    return next((s.possible for row in rows for s in row if s.notebook == notebook), None)


def _named(
    column: str, rows: Sequence[Sequence[Sheet]], names: Mapping[str, str]
) -> Mapping[str, str]:
    """Return the names of the notebooks that were graded."""
    graded = {sheet.notebook for row in rows for sheet in row}
    named = {notebook: name for notebook, name in names.items() if name and notebook in graded}
    if not named:
        raise ValueError(
            f"no graded notebook has a name in {column.title()}: write it into assignments.csv, in "
            f"the column {column}"
        )
    return named


def _require_told(
    platform: str, columns: str, rows: Sequence[Sequence[Sheet]], keys: Sequence[str]
) -> None:
    students = [row[0].student for row in rows]
    unknown = [s["student"] for s in students if not any(s.get(key) for key in keys)]
    if unknown:
        raise ValueError(
            f"{platform} cannot tell who these are: {', '.join(unknown)}. The roster needs {columns}"
        )
