"""Answers in words: a page per question to read them on, and a CSV file to write points into."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path

from fieldrecon.course.gradebook.pages import page, rendered
from fieldrecon.course.gradebook.sheets import Mark
from fieldrecon.course.grading.tables import Row, points, read_table, short, to_csv
from fieldrecon.course.sources import Source

COLUMNS = ("student", "points", "comment")


@dataclass(frozen=True)
class Theory:
    """A question that is answered in words.

    Parameters
    ----------
    name : str
        ``"01.7"``.
    points : float
        What it is worth.
    asked, answer, rubric : str
        The question, the model answer, and how it is graded, as Markdown.
    """

    name: str
    points: float
    asked: str
    answer: str
    rubric: str


def theory(source: Source) -> list[Theory]:
    """Return the questions of a source that are answered in words."""
    rubrics = {cell.rubric: cell.text for cell in source.cells if cell.rubric}
    return [
        Theory(
            cell.answer, float(cell.metadata.get("points", 0)), before.text, cell.text,
            rubrics.get(cell.answer, ""),
        )
        for before, cell in zip(source.cells, source.cells[1:], strict=False) if cell.answer
    ]  # fmt: skip


def reading_page(question: Theory, answers: Mapping[str, str]) -> str:
    """Return the page with the question, its rubric, the model answer, and everybody's words.

    Students' words are shown as they were typed: nothing in them is taken for a formula or a link.

    Parameters
    ----------
    question : Theory
        What was asked.
    answers : mapping
        The words of each student who wrote some.
    """
    body = [
        rendered(question.asked),
        "<h2>How it is graded</h2>", rendered(question.rubric),
        "<h2>A model answer</h2>", rendered(question.answer),
        f"<h2>{len(answers)} answers</h2>",
        *(
            f'<article class="answer open" id="{escape(student)}"><header><h3>{escape(student)}</h3>'
            f'<span class="points">of {short(question.points)}</span></header>'
            f"<pre>{escape(words)}</pre></article>"
            for student, words in sorted(answers.items())
        ),
    ]  # fmt: skip
    told = f"{short(question.points)} points, to be written into {question.name}.csv"
    return page(question.name, told, "\n".join(body))


def points_csv(students: Iterable[str], before: Iterable[Mark], unread: Row | None = None) -> str:
    """Return the table for the points: what stands there already, and a line for each other student.

    Parameters
    ----------
    students : iterable of str
        Who answered.
    before : iterable of Mark
        What was entered already.
    unread : mapping, optional
        Comments in lines that have no points yet, by student.
    """
    marks = {mark.student: mark for mark in before}
    names = sorted(set(students) | set(marks) | set(unread or ()))
    return to_csv(
        COLUMNS,
        (
            (n, marks[n].points, marks[n].comment) if n in marks else (n, None, (unread or {}).get(n))
            for n in names
        ),
    )


def read_marks(folder: Path) -> list[Mark]:
    """Return the points that were entered, from the files ``NN.k.csv`` of a folder.

    Columns: student, points, comment. A line without points is not read yet.

    Raises
    ------
    ValueError
        A line makes no sense; the sentence names file and line.
    """
    return [
        mark
        for file in sorted(folder.glob("[0-9][0-9].*.csv"))
        for mark in read_table(file, lambda row, q=file.stem: _mark(row, q), ("student",), COLUMNS)  # type: ignore[misc]
        if mark
    ]


def unread_comments(file: Path) -> Row:
    """Return the comments of lines that have no points, so that none is lost."""
    rows = read_table(file, dict, ("student",), COLUMNS) if file.is_file() else []
    return {row["student"]: row["comment"] for row in rows if not row.get("points")}


def _mark(row: Row, question: str) -> Mark | None:
    if not row.get("points"):
        return None
    return Mark(row["student"], question, points(row["points"]), row.get("comment", ""))
