"""The grade book as a table, and what is said of an answer in few words."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby

from fieldcheck.verdict import TITLES
from fieldgrade.class_folder.csv_tables import short, to_csv
from fieldgrade.gradebook.sheets import Line, Sheet

NOT_YET = "Not graded yet."


def gradebook_csv(sheets: Iterable[Sheet]) -> str:
    """Return a row for each student, with a column for each question, deduction and sum.

    An empty cell is an answer that nobody has graded yet.
    """
    rows = by_student(sheets)
    columns = ["student", "name", "section"]
    for sheet in rows[0] if rows else ():
        columns += [f"{line.question} of {short(line.possible)}" for line in sheet.lines]
        columns += [f"{sheet.notebook} {what}" for what in ("late", "points", "status")]
    return to_csv([*columns, "points", "unreadable files"], (_row(row) for row in rows))


def _row(sheets: Sequence[Sheet]) -> list[object]:
    student = sheets[0].student
    row: list[object] = [student["student"], student.get("name", ""), student.get("section", "")]
    for sheet in sheets:
        row += [None if line.how == "open" else line.points for line in sheet.lines]
        row += [-sheet.lost, sheet.points, sheet.status]
    files = "; ".join(record.file for record in sheets[0].unreadable)
    return [*row, sum(sheet.points for sheet in sheets), files]


def said_of(line: Line) -> tuple[str, str]:
    """Return what is said of an answer: a title, and a sentence that may be empty."""
    if line.how == "open":
        return line.question, NOT_YET
    if line.grade is None:
        return line.question, line.comment
    title = f"{line.question} {TITLES[line.grade.verdict.rung].lstrip('— ')}"
    changed = f"Changed by a person: {line.comment}" if line.how == "override" else ""
    return title, " ".join(filter(None, (line.grade.verdict.sentence, changed)))


def summary(sheet: Sheet) -> list[str]:
    """Return the feedback on a notebook, a line for each question."""
    lines = [
        f"{title} ({short(line.points)} of {short(line.possible)}). {sentence}".strip()
        for line in sheet.lines
        for title, sentence in (said_of(line),)
    ]
    return [*about(sheet), *lines]


def about(sheet: Sheet) -> list[str]:
    """Return what is said of a whole notebook: what being late costs."""
    return [f"Handed in late: {short(sheet.lost)} points less."] if sheet.lost else []


def by_student(sheets: Iterable[Sheet]) -> list[list[Sheet]]:
    """Return the sheets of each student together; they are in the order of students."""
    return [list(row) for _, row in groupby(sheets, key=lambda s: s.student["student"])]
