"""What pytest collects of a class: for each submission and question, the checks one by one."""

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
    """A question of a submission; none if the submission cannot be read.

    Parameters
    ----------
    student, notebook, file : str
        Whose submission, which notebook it is, and under which name it came.
    digest : str
        Of its content.
    question : str
        Its name.
    """

    student: str
    notebook: str
    file: str
    digest: str
    question: str = ""

    @property
    def whole(self) -> AnswerId:
        """The submission."""
        return replace(self, question="")


def answer_ids(task: GradingTask) -> Iterator[AnswerId]:
    """Yield the questions of a task."""
    file = task.file
    for question in task.questions or ("",):
        yield AnswerId(file.student, file.notebook, file.name, file.digest, question)


def printable(text: str) -> str:
    r"""Return a text without what a terminal or a file could not bear, such as names of files have.

    Examples
    --------
    >>> printable("a\x1b[2J\udce4.ipynb")
    'a?[2J?.ipynb'
    """
    return "".join(c if c.isprintable() else "?" for c in text)


def group(place: AnswerId) -> pytest.MarkDecorator:
    """Return the mark by which pytest-xdist keeps a submission in one process."""
    return pytest.mark.xdist_group(printable(f"{place.student} {place.notebook}"))


class CheckItem(pytest.Item):
    """A check of an answer. What is found of it was found by the batch."""

    def __init__(
        self,
        *,
        place: AnswerId,
        checks: list[str],
        check: str,
        record: Callable[[AnswerId], Record],
        **others: Any,
    ) -> None:
        super().__init__(**others)
        self.place, self.checks, self.check, self.record = place, checks, check, record

    def runtest(self) -> None:
        """Say what was found."""
        record = self.record(self.place)
        if self.check == READABLE or not record.grades:
            if record.status in ("unreadable", "fault"):
                pytest.fail(printable("; ".join(record.notes)), pytrace=False)
            return
        grade = next(g for g in record.grades if g.question == self.place.question)
        told(grade, self.check, self.checks)

    def reportinfo(self) -> tuple[str, None, str]:
        """Return what stands in the head of a report."""
        return printable(self.place.file), None, self.check


def told(grade: Grade, check: str, checks: list[str]) -> None:
    """Let pytest know what a grade says of a check: passed, failed, or not reached."""
    if grade.check == check:
        pytest.fail(printable(str(grade.verdict)), pytrace=False)
    if grade.check in checks and checks.index(check) > checks.index(grade.check):
        pytest.skip(f"{grade.question} did not pass: {grade.check}")


def items(
    session: pytest.Session, task: GradingTask, course: Course, record: Callable[[AnswerId], Record]
) -> Iterator[CheckItem]:
    """Yield the items of a task: ``ada::01_fit.ipynb::01.2::public cases``."""
    for place in answer_ids(task):
        checks = [*course.checks(place.question)] if place.question else [READABLE]
        owner = printable("::".join(filter(None, (place.student, place.file, place.question))))
        for check in checks:
            item = CheckItem.from_parent(
                session,
                name=f"{owner}::{check}",
                nodeid=f"{owner}::{check}",
                place=place,
                checks=checks,
                check=check,
                record=record,
            )
            item.extra_keyword_matches.update((place.student, place.notebook, place.question))
            item.add_marker(group(place))
            yield item
