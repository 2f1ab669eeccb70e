"""The pytest items of a class: a check of an answer in a submission."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import pytest

from fieldgrade.checking.course import Course
from fieldgrade.checking.results import Grade, Record
from fieldgrade.grading.batch import GradingTask

READABLE = "can be read"


@dataclass(frozen=True)
class AnswerId:
    """Identifies an answer: a submission and a question.

    Parameters
    ----------
    student, notebook, file : str
        The student, the number of the notebook, and the name of the file.
    digest : str
        Digest of the file.
    question : str
        The name of the question; empty for the submission as a whole.
    """

    student: str
    notebook: str
    file: str
    digest: str
    question: str = ""

    @property
    def whole(self) -> AnswerId:
        """The identifier of the submission as a whole."""
        return replace(self, question="")


def answer_ids(task: GradingTask) -> Iterator[AnswerId]:
    """Yield the identifiers of the answers of a task."""
    file = task.file
    for question in task.questions or ("",):
        yield AnswerId(file.student, file.notebook, file.name, file.digest, question)


def printable(text: str) -> str:
    r"""Replace the characters of a text that are not printable, as in names of files.

    Examples
    --------
    >>> printable("a\x1b[2J\udce4.ipynb")
    'a?[2J?.ipynb'
    """
    return "".join(c if c.isprintable() else "?" for c in text)


def group(answer_id: AnswerId) -> pytest.MarkDecorator:
    """Return the mark by which pytest-xdist keeps a submission in one process."""
    return pytest.mark.xdist_group(printable(f"{answer_id.student} {answer_id.notebook}"))


class CheckItem(pytest.Item):
    """A check of an answer, whose result comes from the batch."""

    def __init__(
        self,
        *,
        answer_id: AnswerId,
        checks: list[str],
        check: str,
        record: Callable[[AnswerId], Record],
        **others: Any,
    ) -> None:
        super().__init__(**others)
        self.answer_id, self.checks, self.check, self.record = answer_id, checks, check, record

    def runtest(self) -> None:
        """Pass, fail or skip by the record of the submission."""
        record = self.record(self.answer_id)
        if self.check == READABLE or not record.grades:
            if record.status in ("unreadable", "fault"):
                pytest.fail(printable("; ".join(record.notes)), pytrace=False)
            return
        grade = next(g for g in record.grades if g.question == self.answer_id.question)
        report_check(grade, self.check, self.checks)

    def reportinfo(self) -> tuple[str, None, str]:
        """Return the heading of a report."""
        return printable(self.answer_id.file), None, self.check


def report_check(grade: Grade, check: str, checks: list[str]) -> None:
    """Report to pytest whether a check passed, failed or was not reached."""
    if grade.check == check:
        pytest.fail(printable(str(grade.verdict)), pytrace=False)
    if grade.check in checks and checks.index(check) > checks.index(grade.check):
        pytest.skip(f"{grade.question} did not pass: {grade.check}")


def items(
    session: pytest.Session, task: GradingTask, course: Course, record: Callable[[AnswerId], Record]
) -> Iterator[CheckItem]:
    """Yield the items of a task: ``ada::01_fit.ipynb::01.2::public cases``."""
    for answer_id in answer_ids(task):
        checks = [*course.checks(answer_id.question)] if answer_id.question else [READABLE]
        owner = printable(
            "::".join(filter(None, (answer_id.student, answer_id.file, answer_id.question)))
        )
        for check in checks:
            item = CheckItem.from_parent(
                session,
                name=f"{owner}::{check}",
                nodeid=f"{owner}::{check}",
                answer_id=answer_id,
                checks=checks,
                check=check,
                record=record,
            )
            item.extra_keyword_matches.update(
                (answer_id.student, answer_id.notebook, answer_id.question)
            )
            item.add_marker(group(answer_id))
            yield item
