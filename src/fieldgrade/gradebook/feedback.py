"""The feedback page of a student, from the results and public material.

It says for every lost point whether the answer was wrong, missing, stopped by an error, or too
slow. It shows no hidden input: pictures are drawn for public cases only, and a hidden case is
represented by its sentence for students.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from fieldcheck.answers import arrays_from_json, public_answers
from fieldcheck.calls import Outcome, Values
from fieldcheck.questions import questions
from fieldgrade.authoring.known_answers import public_calls
from fieldgrade.checking.results import Record
from fieldgrade.class_folder.csv_tables import short
from fieldgrade.gradebook.explanations import explained, heading
from fieldgrade.gradebook.grade_sheets import GradeLine, GradeSheet
from fieldgrade.html_pages import page, picture, table
from fieldgrade.isolation.process import CellError

LARGEST = 1e6
"""Values that exceed the right ones by this factor are not drawn."""

STATUS = {
    "partly": "A part of the notebook broke down while it was run; the rest was graded.",
    "killed: time": "A part of the notebook took too long and was stopped; the rest was graded.",
    "killed: memory": "A part of the notebook needed too much memory and was stopped; the rest was "
    "graded.",
    "killed: output": "A part of the notebook wrote too much and was stopped; the rest was graded.",
    "grader failed": "It could not be graded yet. This is not your fault; it will be graded later.",
}
SANDBOX = {
    "bubblewrap": "Your notebook was run in a sandbox, without a network.",
    "landlock": "Your notebook was run in a sandbox, without a network.",
    "none": "Your notebook was run on the grader's own machine.",
    "": "Your notebook was not run.",
}
FOR_STUDENTS = (
    "a stub is defined after an answer",
    " is not graded: ",
    "only the code that the answers need was run",
    "a library has this name",
    " is not available to the notebook: ",
    "only the code that the answers need",
)
"""Parts of the notes for instructors that students see too."""
MISSING = {
    "modules": "Modules that were not available where the notebook ran: {}.",
    "files": "Files that were not found where the notebook ran: {}. Only files that are submitted "
    "beside the notebook are there.",
    "fonts": "Fonts of figures that were not installed where the notebook ran, which costs no "
    "points: {}.",
}
CODE = re.compile(r"`([^`\n]{1,80})`")
OTHERS = re.compile(r"that of .* and of .*: the file must have another name", re.DOTALL)
"""The part of a note that names other students."""
MOST_ERRORS = 10
"""Errors of cells that a page shows."""


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
    body += [_uncounted(record, titles) for record in sheets[0].uncounted]
    body += [_overview(sheets, titles)] if len(sheets) > 1 else []
    body += [_notebook(sheet, titles.get(sheet.notebook, "")) for sheet in sheets]
    return page(who, _sum(sheets), "\n".join(body))


def _sum(sheets: Sequence[GradeSheet]) -> str:
    points, possible = sum(s.points for s in sheets), sum(s.possible for s in sheets)
    text = f"{short(points)} of {short(possible)} points"
    waiting = sum(sheet.waiting for sheet in sheets)
    if not waiting:
        return text
    return f"{text}; {'one answer is' if waiting == 1 else f'{waiting} answers are'} not graded yet"


def _unreadable(record: Record) -> str:
    reason = "".join(f" {escape(_without_others(note))}." for note in record.notes[:1])
    return (
        f'<p class="warning">The file {escape(record.file)} could not be graded:{reason} '
        "Submit it again, saved as a notebook.</p>"
    )


def _without_others(note: str) -> str:
    """Return a note without the names of other students."""
    return OTHERS.sub("that of another student: the file must have another name", note)


def _uncounted(record: Record, titles: Mapping[str, str]) -> str:
    notebook = _title(record.notebook, titles.get(record.notebook, ""))
    return (
        f'<p class="warning">The file {escape(record.file)} is notebook {notebook}, which is not '
        "an assignment of this class. It does not count.</p>"
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
    outcome = explained(line).outcome
    text = f"{heading(line)}: {outcome}, {_points(line)} of {short(line.possible)}"
    return f'<i class="{line.outcome}" title="{escape(text)}"></i>'


def _title(notebook: str, title: str) -> str:
    return escape(f"{notebook} {title}".strip())


def _notebook(sheet: GradeSheet, title: str) -> str:
    heading = f'<h2 id="n{sheet.notebook}">{_title(sheet.notebook, title)}</h2>'
    if sheet.record is None:
        readable = " that could be graded" if sheet.unreadable else ""
        return f"<section>{heading}<p>Nothing was submitted{readable}.</p></section>"
    about = "".join(f"<p>{escape(said)}</p>" for said in _about(sheet)) + _cell_errors(sheet.record)
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
    notes = (n for n in record.notes if any(known in n for known in FOR_STUDENTS))
    sentences += [_as_sentence(_without_others(note)) for note in notes]
    missing = vars(record.missing).items()
    return [
        *sentences,
        *(MISSING[kind].format(", ".join(names)) for kind, names in missing if names),
    ]


def _cell_errors(record: Record) -> str:
    """Return the errors of the cells, which may have cost the answers below their points."""
    if not record.cell_errors:
        return ""
    more = len(record.cell_errors) - MOST_ERRORS
    shown = [f"<li>{_cell_error(error)}</li>" for error in record.cell_errors[:MOST_ERRORS]]
    shown += [f"<li>and {more} more</li>"] if more > 0 else []
    return f"<p>While the notebook ran, these cells had an error:</p><ul>{''.join(shown)}</ul>"


def _cell_error(error: CellError) -> str:
    line = f", line {error.line}" if error.line else ""
    source = f": <code>{escape(error.source)}</code>" if error.source else ""
    return f"Code cell {error.cell}{line}{source} — {escape(error.error)}"


def _as_sentence(note: str) -> str:
    return f"{note[:1].upper()}{note[1:]}."


def _answer(line: GradeLine) -> str:
    outcome, sentences, code = explained(line)
    drawn = _drawn(line)
    figure = f"<figure>{drawn}</figure>" if drawn else ""
    paragraphs = "".join(f"<p>{_with_code(text)}</p>" for text in sentences)
    quoted = f"<pre>{escape(code)}</pre>" if code else ""
    return (
        f'<article class="answer {line.outcome}"><header><h3>{escape(heading(line))} — '
        f'<span class="outcome">{escape(outcome)}</span></h3>'
        f'<span class="points">{_points(line)} of {short(line.possible)}</span></header>'
        f"{paragraphs}{quoted}{figure}</article>"
    )


def _with_code(text: str) -> str:
    """Return a text as HTML, words between backticks as code."""
    return CODE.sub(r"<code>\1</code>", escape(text))


def _points(line: GradeLine) -> str:
    return "–" if line.how == "open" else short(line.points)


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
