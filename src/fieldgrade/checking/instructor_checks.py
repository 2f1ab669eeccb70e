"""Checks that an instructor adds: pytest functions in ``checks/test_*.py`` beside the tables.

A check runs for every answer that passed all other checks. It calls the student's function in the
sandbox and gets arrays::

    @pytest.mark.question("01.2", "The plane must not depend on the order of the points.", costs=1)
    def test_order_does_not_matter(answer):
        points, values = ...
        reordered = answer("01.2", points[::-1], values[::-1])
        np.testing.assert_allclose(reordered, answer("01.2", points, values))

If the check fails, the student reads the sentence, and never the inputs. Each check must first pass
on the solution.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fieldcheck.calls import Call, Outcome, perform
from fieldcheck.judge import TIMEOUT_FACTOR
from fieldcheck.question import Question
from fieldcheck.questions import get
from fieldcheck.shapes import fitted, in_words, without_extra_axes
from fieldcheck.verdict import Verdict
from fieldgrade.authoring.right_functions import RightFunctions
from fieldgrade.checking.course import Course
from fieldgrade.checking.dependency_digests import dependency_digest
from fieldgrade.checking.results import Grade, Record
from fieldgrade.isolation import worker_servers
from fieldgrade.isolation.process import Program
from fieldgrade.isolation.server import Server
from fieldgrade.isolation.session import CallGroup, run
from fieldgrade.submissions.submission import Submission

Answer = Callable[..., Any]
"""``answer(question, *arguments)``: the values of the student's function, one array or several."""
Caller = Callable[[Question, Call], Outcome]


class CallFailed(AssertionError):
    """A call of a student's function did not return arrays of the expected shapes."""


@dataclass(frozen=True)
class InstructorCheck:
    """A check that an instructor adds to a question.

    Parameters
    ----------
    question : str
        The name of the question.
    sentence : str
        The sentence for students whose answers fail.
    costs : float, optional
        The points that are deducted; all if not given.
    """

    question: str
    sentence: str
    costs: float | None = None

    def __post_init__(self) -> None:
        """Validate the question, the sentence and the deduction."""
        get(self.question)
        if not self.sentence.strip():
            raise ValueError(f"a check of {self.question} needs a sentence for the student")
        if self.costs is not None and not self.costs > 0:
            raise ValueError(
                f"a check of {self.question} must cost more than 0 points, not {self.costs}"
            )


@dataclass(frozen=True)
class InstructorCheckResult:
    """The result of an instructor's check for a submission.

    Parameters
    ----------
    check : InstructorCheck
        The check.
    name : str
        The name of the function, in words.
    made_by : str
        Digest of the function and of all that it calls.
    passed : bool
        Whether the answer passed.
    """

    check: InstructorCheck
    name: str
    made_by: str
    passed: bool


def answer_of_submission(
    server: Server, submission: Submission, given: Mapping[str, RightFunctions] | None = None
) -> Answer:
    """Return a function that calls a submission in the sandbox, each call in a new process.

    The answers to some questions may be `given` right functions of earlier questions.
    """
    program = Program(submission.sources, tuple(submission.files()))

    def outcome(question: Question, call: Call) -> Outcome:
        seconds, functions = TIMEOUT_FACTOR * question.limit, (given or {}).get(question.name)
        task = CallGroup("check", (call,), seconds, given=functions)
        outcomes, _ = worker_servers.with_server(
            server.tier, server.limits, lambda s: run(s, program, [task])
        )
        return outcomes["check"][0]

    return _answer(outcome)


def given_functions(course: Course, grade: Grade) -> dict[str, RightFunctions]:
    """Return the right functions that an answer was given when it was graded, by its question."""
    if not grade.given:
        return {}
    functions = [get(earlier).function for earlier in grade.given]
    path = course.source(get(grade.question).notebook).path
    return {grade.question: RightFunctions(path, functions)}


def answer_of_solution(functions: dict[str, Any]) -> Answer:
    """Return a function that calls the solution, in this process."""
    return _answer(lambda q, call: perform(functions, (call,), TIMEOUT_FACTOR * q.limit)[0])


def _answer(outcome: Caller) -> Answer:
    def answer(question: str, *arguments: Any) -> Any:
        asked = get(question)
        call = Call(asked.function, tuple(map(_plain, arguments)), "a check")
        return _arrays(asked, call, outcome(asked, call))

    return answer


def _plain(argument: Any) -> Any:
    """Return an argument that frames can carry: numbers and text unchanged, others as arrays."""
    is_plain = isinstance(argument, bool | int | float | str) or argument is None
    return argument if is_plain else np.asarray(argument)


def _arrays(question: Question, call: Call, outcome: Outcome) -> Any:
    if outcome.values is None:
        reason = outcome.error or outcome.returned
        raise CallFailed(f"{question.function}: {outcome.status} {reason}".rstrip())
    shapes = list(question.shapes(call))
    values = fitted(without_extra_axes(outcome, shapes).values or (), shapes)
    if [v.shape for v in values] != shapes:
        raise CallFailed(f"{question.function} returns {in_words(values)}, not shapes {shapes}")
    return values[0] if len(values) == 1 else values


def apply_instructor_checks(record: Record, checked: Iterable[InstructorCheckResult]) -> Record:
    """Return a record whose grades include the checks of instructors."""
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
    sentences = " ".join(dict.fromkeys(c.check.sentence for c in failed))
    return replace(
        grade,
        points=max(0.0, grade.points - costs),
        check=failed[0].name,
        verdict=Verdict(grade.question, "wrong", sentences),
    )
