"""Manual grading of written answers: a page to read for each question, and a table of points."""

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
from fieldrecon._core.atomic_files import write_atomically
from fieldrecon._core.digests import bytes_digest

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
    """A question with a written answer.

    Parameters
    ----------
    name : str
        ``"01.7"``.
    points : float
        The points.
    asked, answer, rubric : str
        The question, the model answer and the rubric, as Markdown.
    """

    name: str
    points: float
    asked: str
    answer: str
    rubric: str


def written_questions(source: Source) -> list[WrittenQuestion]:
    """Return the questions of a source with written answers."""
    rubrics = {cell.rubric: cell.text for cell in source.cells if cell.rubric}
    return [
        WrittenQuestion(
            cell.answer,
            float(cell.metadata.get("points", 0)),
            _question(cell.answer, before.text),
            cell.text,
            rubrics.get(cell.answer, ""),
        )
        for before, cell in zip(source.cells, source.cells[1:], strict=False)
        if cell.answer
    ]


def _question(name: str, text: str) -> str:
    """Return the text from the question's name on; it may follow remarks on a picture."""
    _, marked, question = text.partition(f"**{name}**")
    return (marked + question) or text


def marking_page(
    question: WrittenQuestion,
    answers: Mapping[str, str],
    marks: Mapping[str, Mark] | None = None,
    changed: Collection[str] = (),
) -> str:
    """Return the page with the question, its rubric, the model answer, and all answers.

    In students' answers formulas are typeset, and nothing else is interpreted; the typed text is
    shown below.

    Parameters
    ----------
    question : WrittenQuestion
        The question.
    answers : mapping
        The answer of each student; may be empty.
    marks : mapping, optional
        The marks so far, by student.
    changed : collection of str
        The students whose answers changed after they were marked.
    """
    # imported here, since reading marks needs no pandoc
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
    subtitle = f"{short(question.points)} points, to be entered into {question.name}.csv"
    return page(f"Question {question.name}", subtitle, "\n".join(body))


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
    given = f"{short(mark.points)} of {short(question.points)}" if mark else "not marked"
    given += ", changed since then" if is_changed else ""
    comment = f'<p class="quiet">{escape(mark.comment)}</p>' if mark and mark.comment else ""
    kind = "wrong" if is_changed else "right" if mark else "open"
    return (
        f'<article class="answer {kind}"><header><h3>{escape(student)}</h3>'
        f'<span class="points">{given}</span></header>{html}{comment}'
        f"<details><summary>as typed</summary><pre>{escape(words)}</pre></details></article>"
    )


def update_table(file: Path, answers: Mapping[str, str]) -> list[str]:
    """Add missing students to a table of points; return those who changed a marked answer.

    Existing lines stay unchanged, byte by byte. A student without an answer gets a line with 0
    points.

    Parameters
    ----------
    file : Path
        ``NN.k.csv``; it is created if it does not exist.
    answers : mapping
        The answer of each student; may be empty.

    Raises
    ------
    ValueError
        A line of the file is invalid.
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
    """Return a short digest of an answer, which shows whether it changed after it was marked."""
    return bytes_digest(words.encode())[:10] if words else ""


def _line(student: str, words: str) -> tuple[object, ...]:
    return student, None if words else 0.0, "" if words else NOTHING, answer_digest(words)


def read_marks(folder: Path) -> list[Mark]:
    """Return the marks in the files ``NN.k.csv`` of a folder.

    Columns: student, points, comment, answer. A line without points is not marked yet.

    Raises
    ------
    ValueError
        A line is invalid; the message names file and line.
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
