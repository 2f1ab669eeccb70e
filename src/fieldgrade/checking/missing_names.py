"""Why the definition of an answer, or of what it uses, is missing."""

from __future__ import annotations

import re

from fieldcheck.question import Question
from fieldgrade.checking.check_results import CheckResult
from fieldgrade.submissions.submission import Submission

UNKNOWN_NAME = re.compile(r"stops with NameError: name '(\w+)'")

WORD = re.compile(r"\w+")


def cause(question: Question, result: CheckResult, submission: Submission) -> str:
    """Return what stopped a function, or a name that it uses, from being defined.

    It is the error of a cell, which ran before any call: nothing in it depends on hidden inputs.
    It is empty if the verdict itself says why points are lost.
    """
    verdict = result.verdict
    unknown = UNKNOWN_NAME.search(verdict.sentence)
    if verdict.finding not in ("missing", "exception") or not (
        unknown or verdict.finding == "missing"
    ):
        return ""
    name = unknown[1] if unknown else question.function
    for error in reversed(result.cells.errors):
        if any(_may_define(line, name) for line in submission.sources[error.cell - 1].split("\n")):
            return f"{_sentence_start(str(error))}."
    if verdict.finding == "missing":
        return f"No code cell defines {name}."
    return ""


def _may_define(line: str, name: str) -> bool:
    """Whether a line may define a name: by ``def``, ``class``, an import, or an assignment."""
    target, is_assigned, _ = line.partition("=")
    words = WORD.findall(target)
    return name in words and bool(is_assigned or {"def", "class", "import"} & {*words})


def _sentence_start(text: str) -> str:
    return text[:1].upper() + text[1:]
