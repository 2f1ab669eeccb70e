"""Checks that an instructor adds: functions of pytest in ``checks/test_*.py`` beside the tables.

A check is asked of every submission whose answer is right so far. It calls what the student wrote,
behind the walls, and gets arrays back::

    @pytest.mark.question("01.2", "The plane must not depend on the order of the points.", costs=1)
    def test_order_does_not_matter(answer):
        points, values = ...
        turned = answer("01.2", points[::-1], values[::-1])
        np.testing.assert_allclose(turned, answer("01.2", points, values))

When it fails, the student is told the sentence, and never the inputs. Each check is tried on the
solution before it may fail anybody.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fieldcheck.calls import Call, Outcome, perform
from fieldcheck.ladder import TIMEOUT_FACTOR
from fieldcheck.question import Question
from fieldcheck.questions import get
from fieldcheck.shapes import fitted, in_words
from fieldcheck.verdict import Verdict
from fieldgrade.checking.dependency_digests import dependency_digest
from fieldgrade.checking.results import Grade, Record
from fieldgrade.isolation import worker_servers
from fieldgrade.isolation.server import Server
from fieldgrade.isolation.session import CallGroup, run
from fieldgrade.submissions.submission import Submission

Answer = Callable[..., Any]
"""``answer(question, *arguments)``: what the student's function returns, as array or arrays."""
Caller = Callable[[Question, Call], Outcome]


class CallFailed(AssertionError):
    """A call of a student's function returned nothing that could be looked at."""


@dataclass(frozen=True)
class InstructorCheck:
    """What an instructor asks beyond the questions.

    Parameters
    ----------
    question : str
        On which it bears.
    sentence : str
        What students are told whose answers do not pass.
    costs : float, optional
        The points that this takes away; all of them if it is not told.
    """

    question: str
    sentence: str
    costs: float | None = None

    def __post_init__(self) -> None:
        """Refuse what would mislead students."""
        get(self.question)
        if not self.sentence.strip():
            raise ValueError(f"a check of {self.question} needs a sentence for the student")
        if self.costs is not None and not self.costs > 0:
            raise ValueError(f"a check of {self.question} costs points, not {self.costs}")


@dataclass(frozen=True)
class InstructorCheckResult:
    """What came of a check for a submission.

    Parameters
    ----------
    check : InstructorCheck
        What was asked.
    name : str
        In words, from the name of the function.
    made_by : str
        Digest of the function and all that it calls.
    passed : bool
        Whether the answer passed.
    """

    check: InstructorCheck
    name: str
    made_by: str
    passed: bool


def answer_of_submission(server: Server, submission: Submission) -> Answer:
    """Return what calls functions of a submission, each call in a process of its own."""

    def outcome(question: Question, call: Call) -> Outcome:
        task = CallGroup("check", (call,), TIMEOUT_FACTOR * question.limit)
        outcomes, _ = worker_servers.with_server(
            server.tier, server.limits, lambda s: run(s, submission.cells, [task])
        )
        return outcomes["check"][0]

    return _answer(outcome)


def answer_of_solution(functions: dict[str, Any]) -> Answer:
    """Return what calls functions of the solution, in this process."""
    return _answer(lambda q, call: perform(functions, (call,), TIMEOUT_FACTOR * q.limit)[0])


def _answer(outcome: Caller) -> Answer:
    def answer(question: str, *arguments: Any) -> Any:
        asked = get(question)
        call = Call(asked.function, tuple(map(_plain, arguments)), "a check")
        return _arrays(asked, call, outcome(asked, call))

    return answer


def _plain(argument: Any) -> Any:
    """Return an argument as frames can carry it: numbers and text as they are, the rest arrays."""
    is_plain = isinstance(argument, bool | int | float | str) or argument is None
    return argument if is_plain else np.asarray(argument)


def _arrays(question: Question, call: Call, outcome: Outcome) -> Any:
    if outcome.values is None:
        told = outcome.error or outcome.returned
        raise CallFailed(f"{question.function}: {outcome.status} {told}".rstrip())
    values, shapes = fitted(outcome.values, question.shapes(call)), list(question.shapes(call))
    if [v.shape for v in values] != shapes:
        raise CallFailed(f"{question.function} returns {in_words(values)}, not shapes {shapes}")
    return values[0] if len(values) == 1 else values


def apply_instructor_checks(record: Record, checked: Iterable[InstructorCheckResult]) -> Record:
    """Return a record in whose grades the checks of instructors have had their say."""
    made = list(checked)
    return replace(
        record,
        grades=tuple(
            _with_checks(grade, [c for c in made if c.check.question == grade.question])
            for grade in record.grades
        ),
    )


def _with_checks(grade: Grade, made: Sequence[InstructorCheckResult]) -> Grade:
    if not made:
        return grade
    ordered = sorted(made, key=lambda c: (c.made_by, c.name))
    grade = replace(grade, made_by=dependency_digest(grade.made_by, [c.made_by for c in ordered]))
    failed = [c for c in sorted(made, key=lambda c: c.name) if not c.passed]
    if not failed or not grade.verdict.right:
        return grade
    costs = sum(grade.possible if c.check.costs is None else c.check.costs for c in failed)
    told = " ".join(dict.fromkeys(c.check.sentence for c in failed))
    return replace(
        grade,
        points=max(0.0, grade.points - costs),
        check=failed[0].name,
        verdict=Verdict(grade.question, "wrong", told),
    )
