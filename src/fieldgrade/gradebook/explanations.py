"""Why an answer earned its points, in the words of a graded page.

The sentences of `fieldcheck` are written for a notebook, whose cells can be run again. A graded
page says instead whether an answer was wrong, missing, stopped by an error, or too slow.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from fieldcheck.verdict import Finding
from fieldgrade.authoring.trials import PUBLIC
from fieldgrade.checking.results import Grade
from fieldgrade.class_folder.csv_tables import short
from fieldgrade.gradebook.grade_sheets import GradeLine, GradeSheet

NOT_YET = "not graded yet"

OUTCOMES: Mapping[Finding, str] = {
    "missing": "missing",
    "unwritten": "missing: not written",
    "exception": "stopped by an error",
    "endless": "too slow: stopped",
    "type": "wrong: not the requested kind of value",
    "shape": "wrong: not the requested shape",
    "not finite": "wrong: values that are not finite",
    "modified": "wrong: an argument is changed",
    "inherited": "wrong: an earlier answer is wrong",
    "misconception": "wrong: a known mistake",
    "wrong": "wrong",
    "slow": "right, but too slow",
    "right": "right",
}

UNSEEN = "for an input that is not shown here"
HIDDEN: Mapping[Finding, str] = {
    "exception": f"The function stops with an error {UNSEEN}.",
    "endless": f"The function takes too long {UNSEEN}, and was stopped.",
    "type": f"The function does not return the requested kind of value {UNSEEN}.",
    "shape": f"The function returns an array of another shape than requested {UNSEEN}.",
    "not finite": f"The function returns values that are NaN or infinite {UNSEEN}.",
    "slow": f"The values are right, but the function takes too long {UNSEEN}.",
}
"""What is said of a hidden case, whose own sentence describes the requirement."""

ORIGIN = re.compile(
    r"(?P<error>.*) It arises in (?P<place>line \d+ of [^:]*)(?:: (?P<code>.*))?\.", re.DOTALL
)
"""The sentence of an error with the student's line, as `fieldcheck.judge` writes it."""


class Explanation(NamedTuple):
    """The outcome of an answer, sentences, and the student's line at which an error arose."""

    outcome: str
    sentences: tuple[str, ...] = ()
    code: str = ""


def explained(line: GradeLine) -> Explanation:
    """Return why an answer earned its points."""
    if line.how == "open":
        return Explanation(NOT_YET)
    if line.how == "read":
        return Explanation(_by_points(line), (line.comment,) * bool(line.comment))
    changed = (f"Points set by the staff: {line.comment}",) if line.how == "override" else ()
    if line.grade is None:
        return Explanation(_by_points(line), changed)
    outcome, sentences, code = _of_grade(line.grade, line.function)
    return Explanation(outcome, (*_given(line.grade), *sentences, *changed), code)


def _given(grade: Grade) -> Iterator[str]:
    """Yield the sentence on earlier answers that the grader replaced by right ones."""
    if grade.given:
        verb = "mistake there costs" if len(grade.given) == 1 else "mistakes there cost"
        yield f"Graded with our {' and '.join(grade.given)}, so that the {verb} points once."


def _by_points(line: GradeLine) -> str:
    """Return the outcome of an answer that a person graded."""
    if line.points >= line.possible:
        return "right"
    return "right in part" if line.points else "wrong"


def _of_grade(grade: Grade, function: str) -> Explanation:
    """Return why the grader gave the points of an answer."""
    finding, sentence = grade.verdict.finding, grade.verdict.sentence
    outcome, code = OUTCOMES[finding], ""
    sentences = [sentence]
    if finding == "missing":
        sentences = [f"After all cells had run, there was no function {function}.", grade.cause]
    elif finding == "unwritten":
        sentences = [f"The function {function} was submitted without an answer in it."]
    elif finding in HIDDEN and grade.check not in ("", PUBLIC):
        sentences = [HIDDEN[finding], sentence]
    elif finding == "exception" and (origin := ORIGIN.fullmatch(sentence)):
        code = origin["code"] or ""
        sentences = [
            origin["error"],
            grade.cause,
            f"The error arises in {origin['place']}{':' if code else '.'}",
        ]
    return Explanation(outcome, tuple(filter(None, sentences)), code)


def heading(line: GradeLine) -> str:
    """Return the number and the title of a question: ``"01.4 The rank"``."""
    heading = f"{line.question} {line.title}".strip()
    return heading if line.counts else f"{heading} (optional, does not count)"


def in_one_line(line: GradeLine) -> tuple[str, str]:
    """Return the heading with the outcome, and the sentences in one line; they may be empty."""
    outcome, sentences, code = explained(line)
    return f"{heading(line)}: {outcome}", " ".join(filter(None, (*sentences, code)))


def summary(sheet: GradeSheet) -> list[str]:
    """Return the feedback on a notebook, a line for each question."""
    lines = [
        f"{title} ({short(line.points)} of {short(line.possible)}). {sentences}".strip()
        for line in sheet.lines
        for title, sentences in (in_one_line(line),)
    ]
    return [*about(sheet), *lines]


def about(sheet: GradeSheet) -> list[str]:
    """Return the feedback on a notebook as a whole: the late penalty."""
    return (
        [f"Submitted late: {short(sheet.late_penalty)} points less."] if sheet.late_penalty else []
    )
