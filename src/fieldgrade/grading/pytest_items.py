"""The pytest items of a class: a check of an answer in a submission."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import pytest

from fieldcheck.verdict import Verdict
from fieldgrade.checking.check_results import CheckResult
from fieldgrade.checking.course import Course
from fieldgrade.checking.dependency_digests import (
    dependency_digest,
    environment_digest,
    grader_digest,
)
from fieldgrade.checking.instructor_checks import (
    InstructorCheck,
    InstructorCheckResult,
    answer_of_solution,
)
from fieldgrade.checking.results import Grade, Record
from fieldgrade.grading.batch import GradingTask
from fieldgrade.grading.run import GradingRun
from fieldgrade.isolation.server import GraderError
from fieldgrade.submissions.submission import Submission
from fieldrecon._core.digests import json_digest

MARK, FIXTURE = "question", "answer"
USAGE = f"{MARK}(name, sentence, costs=None): a check that an instructor adds to a question"

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
    r"""Replace the characters of a text, such as a file name, that are not printable.

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
            if record.status in ("unreadable", "grader failed"):
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
            name_for_option_k(item, answer_id)
            item.add_marker(group(answer_id))
            yield item


def name_for_option_k(item: pytest.Item, answer_id: AnswerId) -> None:
    """Have ``-k`` select an item by student, notebook and question."""
    item.extra_keyword_matches.update((answer_id.student, answer_id.notebook, answer_id.question))


def check_of(holder: pytest.Function | Any) -> InstructorCheck | None:
    """Return the check of a test function; None if it is an ordinary test.

    Raises
    ------
    ValueError
        The arguments of the mark are wrong.
    """
    mark = next(iter(holder.iter_markers(MARK)), None)
    if mark is None:
        return None
    try:
        return InstructorCheck(*mark.args, **mark.kwargs)
    except TypeError:
        raise ValueError(f"{holder.name}: write @pytest.mark.{USAGE}") from None


def parametrized(metafunc: pytest.Metafunc, tasks: Sequence[GradingTask]) -> None:
    """Parametrise a check with each submission that has its question."""
    check = check_of(metafunc.definition)
    if check is None and FIXTURE not in metafunc.fixturenames:
        return
    if check is None or FIXTURE not in metafunc.fixturenames:
        name = metafunc.definition.name
        raise ValueError(f"{name} needs both @pytest.mark.{MARK}(...) and an argument {FIXTURE!r}")
    asked = [a for task in tasks for a in answer_ids(task) if a.question == check.question]
    parameters = [
        pytest.param(
            answer_id,
            id=printable(f"{answer_id.student}-{answer_id.notebook}"),
            marks=group(answer_id),
        )
        for answer_id in asked
    ]
    metafunc.parametrize(FIXTURE, parameters, indirect=True)


def answer_of_item(item: pytest.Item) -> AnswerId | None:
    """Return the answer that an instructor's check belongs to."""
    spec = getattr(item, "callspec", None)
    answer_id = spec.params.get(FIXTURE) if spec else None
    return answer_id if isinstance(answer_id, AnswerId) else None


class InstructorCheckRunner:
    """Runs the checks of instructors whose results are not cached."""

    def __init__(self, run: GradingRun) -> None:
        self.run = run
        self.errors_on_solution: dict[str, str] = {}

    def checked(
        self, item: pytest.Function, check: InstructorCheck, submission: Submission
    ) -> InstructorCheckResult:
        """Return the result of a check, from the cache or by running it.

        Raises
        ------
        GraderError
            It fails on the solution.
        """
        made_by, name = _made_by(item, check), _in_words(item)
        key = self._key(made_by, check.question, submission)
        found = self.run.cache.get(submission).get(key)
        if found is None:
            self._require_passes_on_solution(item, check, made_by)
            passed = not _error(item, item.funcargs)
            verdict = Verdict(check.question, "right" if passed else "wrong", check.sentence)
            found = CheckResult(verdict, "" if passed else name)
            self.run.cache.put(submission, {key: found})
        return InstructorCheckResult(check, name, made_by, found.verdict.right)

    def _require_passes_on_solution(
        self, item: pytest.Function, check: InstructorCheck, made_by: str
    ) -> None:
        if made_by not in self.errors_on_solution:
            right = answer_of_solution(self.run.course.solution(check.question))
            self.errors_on_solution[made_by] = _error(item, item.funcargs | {FIXTURE: right})
        if self.errors_on_solution[made_by]:
            raise GraderError(
                f"{_in_words(item)} fails on the solution: {self.errors_on_solution[made_by]}"
            )

    def _key(self, made_by: str, question: str, submission: Submission) -> str:
        server, course = self.run.server, self.run.course
        return json_digest(
            made_by,
            submission.code_digest,
            environment_digest(),
            grader_digest(),
            server.tier,
            asdict(server.limits),
            [course.made_by(earlier) for earlier in course.given(question)],
        )


def _error(item: pytest.Function, arguments: dict[str, Any]) -> str:
    """Return the error of a check with these arguments; empty if it passes."""
    wanted = {name: arguments[name] for name in item._fixtureinfo.argnames}
    try:
        item.obj(**wanted)
    except GraderError:
        raise
    except (Exception, pytest.fail.Exception) as error:
        return f"{type(error).__name__}: {error}"
    return ""


def _made_by(item: pytest.Function, check: InstructorCheck) -> str:
    """Return the digest of a check, its parameters and its fixtures."""
    given = {name: value for name, value in item.callspec.params.items() if name != FIXTURE}
    fixtures = {k: v for k, v in item._fixtureinfo.name2fixturedefs.items() if k != FIXTURE}
    functions = [definition.func for name in sorted(fixtures) for definition in fixtures[name]]
    return dependency_digest(item.function, given, functions, check)


def _in_words(item: pytest.Function) -> str:
    return item.originalname.removeprefix("test_").replace("_", " ")
