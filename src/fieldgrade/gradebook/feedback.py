"""The feedback page of a student, from the results and public material.

It shows no hidden input: pictures are drawn for public cases only, and a hidden case is represented
by its sentence for students.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from fieldcheck.answers import arrays_from_json, public_answers
from fieldcheck.calls import Outcome, Values
from fieldcheck.questions import questions
from fieldcheck.verdict import TITLES
from fieldgrade.authoring.known_answers import public_calls
from fieldgrade.checking.results import Record
from fieldgrade.class_folder.csv_tables import short
from fieldgrade.gradebook.grade_sheets import NOT_YET, GradeLine, GradeSheet
from fieldgrade.html_pages import page, picture, table

LARGEST = 1e6
"""Values that exceed the right ones by this factor are not drawn."""

STATUS = {
    "partly": "A part of the notebook broke down while it was run; the rest was graded.",
    "killed: time": "A part of the notebook took too long and was stopped; the rest was graded.",
    "killed: memory": "A part of the notebook needed too much memory and was stopped; the rest was "
    "graded.",
    "killed: output": "A part of the notebook wrote too much and was stopped; the rest was graded.",
    "fault": "It could not be graded yet. This is not your fault; it will be graded later.",
}
SANDBOX = {
    "bubblewrap": "Your notebook was run in a sandbox, without a network.",
    "landlock": "Your notebook was run in a sandbox, without a network.",
    "none": "Your notebook was run on the grader's own machine.",
    "": "Your notebook was not run.",
}
FOR_STUDENTS = ("a stub is defined after an answer",)
"""Notes for instructors that students see too."""


def feedback(sheets: Sequence[GradeSheet], titles: Mapping[str, str] | None = None) -> str:
    """Return the page for one student.

    Parameters
    ----------
    sheets : sequence of GradeSheet
        The grade sheets of the student.
    titles : mapping, optional
        The titles of the notebooks.
    """
    titles, student = titles or {}, sheets[0].student
    who = student.get("name") or student["student"]
    body = [_unreadable(record) for record in sheets[0].unreadable]
    body += [_overview(sheets, titles)] if len(sheets) > 1 else []
    body += [_notebook(sheet, titles.get(sheet.notebook, "")) for sheet in sheets]
    return page(who, _sum(sheets), "\n".join(body))


def _sum(sheets: Sequence[GradeSheet]) -> str:
    points, possible = sum(s.points for s in sheets), sum(s.possible for s in sheets)
    text = f"{short(points)} of {short(possible)} points"
    waiting = sum(line.how == "open" for sheet in sheets for line in sheet.lines)
    if not waiting:
        return text
    return f"{text}; {'one answer is' if waiting == 1 else f'{waiting} answers are'} not graded yet"


def _unreadable(record: Record) -> str:
    reason = "".join(f" {escape(note)}." for note in record.notes[:1])
    return (
        f'<p class="warning">The file {escape(record.file)} could not be graded:{reason} '
        "Submit it again, saved as a notebook.</p>"
    )


def _overview(sheets: Sequence[GradeSheet], titles: Mapping[str, str]) -> str:
    rows = [
        (
            f'<a href="#n{s.notebook}">{_title(s.notebook, titles.get(s.notebook, ""))}</a>',
            short(s.points),
            short(s.possible),
            _at_a_glance(s),
        )
        for s in sheets
    ]
    return table(("Notebook", "Points", "of", "Questions"), rows, numbers=(1, 2))


def _at_a_glance(sheet: GradeSheet) -> str:
    """Return a square for each question, filled according to its points."""
    if sheet.record is None:
        return "not submitted"
    squares = "".join(_square(line) for line in sheet.lines)
    return f'<span class="squares">{squares}</span>'


def _square(line: GradeLine) -> str:
    kind, title, _ = _said(line)
    text = f"{line.question} {title or NOT_YET} {_points(line)} of {short(line.possible)}"
    return f'<i class="{kind}" title="{escape(text)}"></i>'


def _title(notebook: str, title: str) -> str:
    return escape(f"{notebook} {title}".strip())


def _notebook(sheet: GradeSheet, title: str) -> str:
    heading = f'<h2 id="n{sheet.notebook}">{_title(sheet.notebook, title)}</h2>'
    if sheet.record is None:
        readable = " that could be graded" if sheet.unreadable else ""
        return f"<section>{heading}<p>Nothing was submitted{readable}.</p></section>"
    about = "".join(f"<p>{escape(said)}</p>" for said in _about(sheet))
    answers = "\n".join(_answer(line) for line in sheet.lines)
    footer = " ".join((SANDBOX[sheet.record.tier], f"File: {sheet.record.file},"))
    return (
        f"<section>{heading}{about}\n{answers}\n<footer>{escape(footer)} SHA-256 "
        f"{sheet.record.digest[:16]}…</footer></section>"
    )


def _about(sheet: GradeSheet) -> list[str]:
    """Return the feedback on the whole notebook."""
    record = sheet.record
    if record is None:
        return []
    sentences = [f"{short(sheet.points)} of {short(sheet.possible)} points."]
    if record.status in STATUS:
        sentences.append(STATUS[record.status])
    if sheet.late_penalty:
        sentences.append(f"Late submission: {short(sheet.late_penalty)} points less.")
    sentences += [n for n in record.notes if any(known in n for known in FOR_STUDENTS)]
    return sentences


def _answer(line: GradeLine) -> str:
    kind, title, said = _said(line)
    drawn = _drawn(line)
    figure = f"<figure>{drawn}</figure>" if drawn else ""
    paragraphs = "".join(f"<p>{escape(text)}</p>" for text in said if text)
    return (
        f'<article class="answer {kind}"><header><h3>{escape(line.question)} {escape(title)}</h3>'
        f'<span class="points">{_points(line)} of {short(line.possible)}</span></header>'
        f"{paragraphs}{figure}</article>"
    )


def _points(line: GradeLine) -> str:
    return "–" if line.how == "open" else short(line.points)


def _said(line: GradeLine) -> tuple[str, str, tuple[str, ...]]:
    """Return the CSS class of an answer, its title, and its sentences."""
    if line.how == "open":
        return "open", "", (NOT_YET,)
    if line.grade is None:
        return _kind(line), "", (line.comment,)
    verdict = line.grade.verdict
    changed = f"Changed by the staff: {line.comment}" if line.how == "override" else ""
    kind = verdict.rung if verdict.rung == "unwritten" else _kind(line)
    return kind, TITLES[verdict.rung], (verdict.sentence, changed)


def _kind(line: GradeLine) -> str:
    if line.points >= line.possible:
        return "right"
    return "half" if line.points else "wrong"


def _drawn(line: GradeLine) -> str:
    """Return a picture of the student's values and the right ones, on a public case."""
    from fieldcheck.pictures import picture_of_difference

    if line.grade is None or not line.grade.returned or line.grade.verdict.call is None:
        return ""
    question = questions()[line.question]
    answers = public_answers(question.notebook).get(question.name)
    calls, values = public_calls(question), _arrays(line)
    index = line.grade.verdict.call
    if answers is None or index >= len(calls) or not _can_be_drawn(values, answers.right[index]):
        return ""
    outcomes = [
        Outcome("returned", values=values if i == index else None) for i in range(len(calls))
    ]
    drawn = picture_of_difference(line.grade.verdict, question, calls, outcomes, answers).picture
    if not drawn:
        return ""
    case = f"For {calls[index].case}: what {question.function} returns, and what is right."
    return f"{picture(drawn, case)}<figcaption>{escape(case)}</figcaption>"


def _arrays(line: GradeLine) -> Values:
    """Return the values of the student's function that the results contain."""
    return arrays_from_json(line.grade.returned if line.grade else ())


def _can_be_drawn(values: Values, right: Values) -> bool:
    largest = max((float(np.abs(v).max(initial=0.0)) for v in values), default=0.0)
    known = max((float(np.abs(v).max(initial=0.0)) for v in right), default=0.0)
    return largest <= LARGEST * max(known, 1.0)
