"""The checks of instructors as pytest items: how they are parametrised and run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import pytest

from fieldcheck.verdict import Verdict
from fieldgrade.checking.check_results import CheckResult
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
from fieldgrade.grading.batch import GradingTask
from fieldgrade.grading.pytest_items import AnswerId, answer_ids, group, printable
from fieldgrade.grading.run import GradingRun
from fieldgrade.isolation.server import GraderError
from fieldgrade.submissions.submission import Submission
from fieldrecon._core.digests import json_digest

MARK, FIXTURE = "question", "answer"
USAGE = f"{MARK}(name, sentence, costs=None): a check that an instructor adds to a question"


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
        key = self._key(made_by, submission)
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

    def _key(self, made_by: str, submission: Submission) -> str:
        server = self.run.server
        return json_digest(
            made_by,
            submission.code_digest,
            environment_digest(),
            grader_digest(),
            server.tier,
            asdict(server.limits),
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
