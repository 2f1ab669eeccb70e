"""The checks of instructors as items of pytest: which there are, and how one is made."""

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
from fieldgrade.digests import json_digest
from fieldgrade.grading.batch import GradingTask
from fieldgrade.grading.pytest_items import AnswerId, answer_ids, group, printable
from fieldgrade.grading.run import GradingRun
from fieldgrade.isolation.server import GraderError
from fieldgrade.submissions.submission import Submission

MARK, FIXTURE = "question", "answer"
USAGE = f"{MARK}(name, sentence, costs=None): a check that an instructor adds to a question"


def check_of(holder: pytest.Function | Any) -> InstructorCheck | None:
    """Return what a function checks; None if it is an ordinary test.

    Raises
    ------
    ValueError
        Its mark is not understood.
    """
    mark = next(iter(holder.iter_markers(MARK)), None)
    if mark is None:
        return None
    try:
        return InstructorCheck(*mark.args, **mark.kwargs)
    except TypeError:
        raise ValueError(f"{holder.name}: write @pytest.mark.{USAGE}") from None


def parametrized(metafunc: pytest.Metafunc, tasks: Sequence[GradingTask]) -> None:
    """Let a check be made for each submission that has its question."""
    check = check_of(metafunc.definition)
    if check is None and FIXTURE not in metafunc.fixturenames:
        return
    if check is None or FIXTURE not in metafunc.fixturenames:
        name = metafunc.definition.name
        raise ValueError(f"{name} needs both @pytest.mark.{MARK}(...) and an argument {FIXTURE!r}")
    asked = [p for task in tasks for p in answer_ids(task) if p.question == check.question]
    parameters = [
        pytest.param(place, id=printable(f"{place.student}-{place.notebook}"), marks=group(place))
        for place in asked
    ]
    metafunc.parametrize(FIXTURE, parameters, indirect=True)


def answer_of_item(item: pytest.Item) -> AnswerId | None:
    """Return what an item of an instructor's check is about."""
    spec = getattr(item, "callspec", None)
    place = spec.params.get(FIXTURE) if spec else None
    return place if isinstance(place, AnswerId) else None


class Instructor:
    """Makes the checks of instructors, as far as it is not known what comes of them."""

    def __init__(self, run: GradingRun) -> None:
        self.run = run
        self.sound: dict[str, str] = {}

    def checked(
        self, item: pytest.Function, check: InstructorCheck, submission: Submission
    ) -> InstructorCheckResult:
        """Return what comes of a check, from the cache or by making it.

        Raises
        ------
        GraderError
            It fails on the solution.
        """
        made_by, name = _made_by(item, check), _in_words(item)
        key = self._key(made_by, submission)
        found = self.run.cache.get(submission).get(key)
        if found is None:
            self._require_sound(item, check, made_by)
            passed = not _error(item, item.funcargs)
            verdict = Verdict(check.question, "right" if passed else "wrong", check.sentence)
            found = CheckResult(verdict, "" if passed else name)
            self.run.cache.put(submission, {key: found})
        return InstructorCheckResult(check, name, made_by, found.verdict.right)

    def _require_sound(self, item: pytest.Function, check: InstructorCheck, made_by: str) -> None:
        if made_by not in self.sound:
            right = answer_of_solution(self.run.course.solution(check.question))
            self.sound[made_by] = _error(item, item.funcargs | {FIXTURE: right})
        if self.sound[made_by]:
            raise GraderError(f"{_in_words(item)} fails on the solution: {self.sound[made_by]}")

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
    """Return how a check ends with such arguments; empty if well."""
    wanted = {name: arguments[name] for name in item._fixtureinfo.argnames}
    try:
        item.obj(**wanted)
    except GraderError:
        raise
    except (Exception, pytest.fail.Exception) as error:
        return f"{type(error).__name__}: {error}"
    return ""


def _made_by(item: pytest.Function, check: InstructorCheck) -> str:
    """Return the digest of a check, of what it is given, and of the fixtures that it uses."""
    given = {name: value for name, value in item.callspec.params.items() if name != FIXTURE}
    fixtures = {k: v for k, v in item._fixtureinfo.name2fixturedefs.items() if k != FIXTURE}
    functions = [definition.func for name in sorted(fixtures) for definition in fixtures[name]]
    return dependency_digest(item.function, given, functions, check)


def _in_words(item: pytest.Function) -> str:
    return item.originalname.removeprefix("test_").replace("_", " ")
