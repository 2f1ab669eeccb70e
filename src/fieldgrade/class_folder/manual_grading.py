"""Answers in words: a page per question to read them on, and a CSV file to write points into."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path

from fieldgrade.authoring.sources import Source
from fieldgrade.class_folder.csv_tables import (
    Row,
    header,
    points,
    question,
    read_table,
    short,
    to_csv,
)
from fieldgrade.digests import bytes_digest
from fieldrecon._core.atomic_files import write_atomically

COLUMNS = ("student", "points", "comment", "answer")
NOTHING = "Nothing was written."


@dataclass(frozen=True)
class Mark:
    """The points and the comment that a reader gave for a written answer."""

    student: str
    question: str
    points: float
    comment: str = ""


@dataclass(frozen=True)
class WrittenQuestion:
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


def written_questions(source: Source) -> list[WrittenQuestion]:
    """Return the questions of a source that are answered in words."""
    rubrics = {cell.rubric: cell.text for cell in source.cells if cell.rubric}
    return [
        WrittenQuestion(
            cell.answer,
            float(cell.metadata.get("points", 0)),
            before.text,
            cell.text,
            rubrics.get(cell.answer, ""),
        )
        for before, cell in zip(source.cells, source.cells[1:], strict=False)
        if cell.answer
    ]


def marking_page(
    question: WrittenQuestion,
    answers: Mapping[str, str],
    marks: Mapping[str, Mark] | None = None,
    changed: Collection[str] = (),
) -> str:
    """Return the page with the question, its rubric, the model answer, and everybody's words.

    In students' words formulas are set, and nothing else is interpreted; below they stand as typed.

    Parameters
    ----------
    question : WrittenQuestion
        What was asked.
    answers : mapping
        The words of each student; empty where nothing was written.
    marks : mapping, optional
        The points given so far, by student.
    changed : collection of str
        Who wrote something else since.
    """
    # late, since who only reads marks need not wait for fonts
    from fieldgrade.html_pages import page, rendered, with_formulas

    written = {student: words for student, words in sorted(answers.items()) if words}
    silent = sorted(set(answers) - set(written))
    typeset = with_formulas(list(written.values()))
    body = [
        rendered(question.asked),
        "<h2>How it is graded</h2>",
        rendered(question.rubric),
        f"<details open><summary>A model answer</summary>{rendered(question.answer)}</details>",
        f"<h2>{_counted(len(written))}</h2>",
        *(
            _article(question, who, words, html, (marks or {}).get(who), who in changed)
            for (who, words), html in zip(written.items(), typeset, strict=True)
        ),
        f'<p class="quiet">Nothing written: {escape(", ".join(silent))}.</p>' if silent else "",
    ]
    told = f"{short(question.points)} points, to be written into {question.name}.csv"
    return page(f"Question {question.name}", told, "\n".join(body))


def _counted(answers: int) -> str:
    return "One answer" if answers == 1 else f"{answers or 'No'} answers"


def _article(
    question: WrittenQuestion,
    student: str,
    words: str,
    html: str,
    mark: Mark | None,
    is_changed: bool,
) -> str:
    given = f"{short(mark.points)} of {short(question.points)}" if mark else "not read"
    given += ", and changed since" if is_changed else ""
    comment = f'<p class="quiet">{escape(mark.comment)}</p>' if mark and mark.comment else ""
    kind = "wrong" if is_changed else "right" if mark else "open"
    return (
        f'<article class="answer {kind}"><header><h3>{escape(student)}</h3>'
        f'<span class="points">{given}</span></header>{html}{comment}'
        f"<details><summary>as typed</summary><pre>{escape(words)}</pre></details></article>"
    )


def update_table(file: Path, answers: Mapping[str, str]) -> list[str]:
    """Add a line for each student to a table of points, and return who wrote something else since.

    Lines that are there stay as they are, byte by byte, whatever they hold. Who wrote nothing
    gets a line with no points.

    Parameters
    ----------
    file : Path
        ``NN.k.csv``; it is made if there is none.
    answers : mapping
        The words of each student; empty where nothing was written.

    Raises
    ------
    ValueError
        A line of the file makes no sense.
    """
    if not file.is_file():
        lines = (_line(*pair) for pair in sorted(answers.items()))
        write_atomically(file, to_csv(COLUMNS, lines).encode())
        return []
    rows = {row["student"]: row for row in read_table(file, _checked, ("student",), COLUMNS)}
    new = sorted(set(answers) - set(rows))
    if new:
        before = file.read_bytes()
        columns, delimiter = header(file)
        cells = [dict(zip(COLUMNS, _line(who, answers[who]), strict=True)) for who in new]
        added = to_csv(columns, ([row.get(c) for c in columns] for row in cells), delimiter)
        joint = b"" if before.endswith(b"\n") else b"\n"
        write_atomically(file, before + joint + added.partition("\n")[2].encode())
    read = {who: row.get("answer") for who, row in rows.items() if row.get("points")}
    return [
        who
        for who, words in sorted(answers.items())
        if read.get(who) is not None and read[who] != answer_digest(words)
    ]


def answer_digest(words: str) -> str:
    """Return a short digest of an answer, by which it is seen that it changed since it was read."""
    return bytes_digest(words.encode())[:10] if words else ""


def _line(student: str, words: str) -> tuple[object, ...]:
    return student, None if words else 0.0, "" if words else NOTHING, answer_digest(words)


def read_marks(folder: Path) -> list[Mark]:
    """Return the points that were entered, from the files ``NN.k.csv`` of a folder.

    Columns: student, points, comment, answer. A line without points is not read yet.

    Raises
    ------
    ValueError
        A line makes no sense; the sentence names file and line.
    """
    return [
        Mark(row["student"], question(file.stem), points(row["points"]), row.get("comment", ""))
        for file in sorted(folder.glob("[0-9][0-9].*.csv"))
        for row in read_table(file, _checked, ("student",), COLUMNS)
        if row.get("points")
    ]


def _checked(row: Row) -> Row:
    if row.get("points"):
        points(row["points"])
    return row
