"""Grade one submission: run its code in the sandbox, judge the returned values outside."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fieldcheck.answers import arrays_to_json
from fieldcheck.calls import Outcome
from fieldcheck.judge import TIMEOUT_FACTOR
from fieldcheck.question import Question
from fieldcheck.verdict import Verdict
from fieldgrade.authoring.trials import PUBLIC, Trial
from fieldgrade.checking.check_results import CheckResult, CheckResults
from fieldgrade.checking.course import Course
from fieldgrade.checking.results import Grade, Record, Status
from fieldgrade.isolation.server import GraderError, Server
from fieldgrade.isolation.session import CallGroup, SessionLog, run
from fieldgrade.submissions.definitions import suppress_warnings
from fieldgrade.submissions.submission import Submission, Unreadable

MOST_SHOWN = 2000
"""Values of a wrong answer that are kept for a picture, at most."""


Tried = Mapping[str, Mapping[int, Trial]]
"""By question, and by the index of the check among all checks of the question."""


@dataclass(frozen=True)
class SandboxRun:
    """The results of one run in the sandbox, and its cost."""

    results: CheckResults
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    peak: int = 0


def grade(
    course: Course, server: Server, submission: Submission, only: Collection[str] = ()
) -> Record:
    """Grade a submission with a started server.

    Returns
    -------
    Record
        Also for an unreadable submission: no submission stops a batch.

    Raises
    ------
    GraderError
        A check fails on the right answer.
    """
    try:
        number = submission.notebook(course.functions())
    except Unreadable as error:
        return Record(
            submission.student,
            submission.name,
            submission.digest,
            "",
            "unreadable",
            "",
            notes=(str(error),),
        )
    checks = {q.name: course.checks(q.name) for q in course.asked(number, only)}
    sandbox_run = run_checks(course, server, submission, number, checks)
    return assemble_record(course, submission, number, server.tier, sandbox_run)


def run_checks(
    course: Course,
    server: Server,
    submission: Submission,
    number: str,
    checks: Mapping[str, Collection[str]],
) -> SandboxRun:
    """Run checks of the answers of a submission with a started server.

    Nothing of the submission is imported, executed or unpickled outside the sandbox: its code goes
    to the server as text, and the server returns arrays. All public cases run before the first
    hidden one, so that no error message shown to a student can contain hidden inputs. An answer
    that is right but slow runs once more: the machine may have been busy.
    """
    tried = {
        name: {k: trial for k, trial in enumerate(its) if trial.name in checks[name]}
        for name, its in course.trials(number, submission.student, checks).items()
    }
    first = _run_sandboxed(server, submission, tried)
    slow = dict(_slow(tried, first.results))
    if not slow:
        return first
    again = _run_sandboxed(server, submission, slow)
    faster = {
        name: {**first.results[name], **its}
        for name, its in again.results.items()
        if next(iter(its.values())).verdict.right
    }
    return SandboxRun(
        {**first.results, **faster},
        first.seconds + again.seconds,
        first.cpu_seconds + again.cpu_seconds,
        max(first.peak, again.peak),
    )


def _slow(tried: Tried, found: CheckResults) -> Iterator[tuple[str, Mapping[int, Trial]]]:
    """Yield the checks to repeat for slow answers: from the slow check on."""
    for name, its in found.items():
        *passed, last = its
        if its[last].verdict.rung == "slow":
            yield name, {k: t for k, t in tried[name].items() if t.name not in passed}


def _run_sandboxed(server: Server, submission: Submission, tried: Tried) -> SandboxRun:
    groups = [
        (k, CallGroup(f"{name} {k}", trial.calls, TIMEOUT_FACTOR * trial.question.limit, name))
        for name, its in tried.items()
        for k, trial in its.items()
        if trial.question.function in submission.definitions
    ]
    ordered = [group for _, group in sorted(groups, key=lambda pair: pair[0])]
    outcomes, log = run(server, submission.cells, ordered)
    return SandboxRun(
        {name: dict(_check_results(name, its, outcomes, log)) for name, its in tried.items()},
        log.seconds,
        sum(p.cpu_seconds for p in log.processes),
        max((p.peak for p in log.processes), default=0),
    )


def _check_results(
    name: str,
    tried: Mapping[int, Trial],
    outcomes: Mapping[str, tuple[Outcome, ...]],
    log: SessionLog,
) -> Iterator[tuple[str, CheckResult]]:
    """Yield the result of each check of an answer, up to the first failure."""
    for index, trial in tried.items():
        group = f"{name} {index}"
        outcomes_of_trial = outcomes.get(group, (Outcome("missing"),) * len(trial.calls))
        result = _check_result(trial, outcomes_of_trial, tuple(_broke(group, log)), log)
        yield trial.name, result
        if not result.verdict.right:
            return


def _check_result(
    trial: Trial, outcomes_of_trial: Sequence[Outcome], broke: tuple[str, ...], log: SessionLog
) -> CheckResult:
    verdict = _judged(trial, outcomes_of_trial)
    check = "" if verdict.right else trial.name
    returned = _shown(verdict, outcomes_of_trial) if check == PUBLIC else ()
    if check != PUBLIC:
        verdict = replace(verdict, call=None)
    return CheckResult(verdict, check, broke, tuple(sorted(log.cell_errors.items())), returned)


def _shown(verdict: Verdict, outcomes_of_trial: Sequence[Outcome]) -> tuple[Mapping[str, Any], ...]:
    """Return wrong values that are shown beside the right ones, if they are few and finite."""
    if verdict.rung not in ("wrong", "misconception") or verdict.call is None:
        return ()
    values = outcomes_of_trial[verdict.call].values or ()
    real = all(v.dtype.kind in "biuf" and np.isfinite(v).all() for v in values)
    if not real or sum(v.size for v in values) > MOST_SHOWN:
        return ()
    return tuple(arrays_to_json(values))


def _judged(trial: Trial, outcomes_of_trial: Sequence[Outcome]) -> Verdict:
    """Judge outcomes; if judging raises an error, the answer is wrong.

    Raises
    ------
    GraderError
        Judging the right answer raises an error too.
    """
    with suppress_warnings(), np.errstate(all="ignore"):
        try:
            return trial.judge_outcomes(outcomes_of_trial)
        except Exception as error:
            right = tuple(Outcome("returned", values=values) for values in trial.answers.right)
            try:
                trial.judge_outcomes(right)
            except Exception as fault:
                raise GraderError(f"{trial.name} of {trial.question.name}: {fault!r}") from fault
            sentence = f"What it returns cannot be judged ({type(error).__name__})."
            return Verdict(trial.question.name, "wrong", sentence)


def _broke(group: str, log: SessionLog) -> Iterator[str]:
    """Yield why processes were killed, except in calls of other groups."""
    elsewhere = list(log.broke.values())
    for reason in log.killed:
        if reason in elsewhere:
            elsewhere.remove(reason)
        else:
            yield reason
    if group in log.broke:
        yield log.broke[group]


def assemble_record(
    course: Course, submission: Submission, number: str, tier: str, sandbox_run: SandboxRun
) -> Record:
    """Return the record of a submission, from the results of its checks."""
    found = sandbox_run.results
    each = [result for its in found.values() for result in its.values()]
    return Record(
        submission.student,
        submission.name,
        submission.digest,
        number,
        _status(each),
        tier,  # type: ignore[arg-type]
        grades=tuple(_grade(course, q, found[q.name]) for q in course.asked(number, tuple(found))),
        notes=tuple(dict.fromkeys(_notes(submission, course.asked(number), each))),
        code=submission.code_digest,
        seconds=sandbox_run.seconds,
        cpu_seconds=sandbox_run.cpu_seconds,
        peak=sandbox_run.peak,
    )


def _grade(course: Course, question: Question, found: Mapping[str, CheckResult]) -> Grade:
    *_, result = found.values()  # the first failure, or the last check
    worth = float(course.worth.get(question.name, question.points))
    return Grade(
        question.name,
        worth * result.verdict.credit,
        worth,
        result.verdict,
        result.check,
        course.made_by(question.name),
        result.returned,
    )


def _status(results: Iterable[CheckResult]) -> Status:
    broke = {reason for result in results for reason in result.broke}
    for reason in ("memory", "output", "time"):
        if reason in broke:
            return f"killed: {reason}"  # type: ignore[return-value]
    return "partly" if broke else "graded"


def _notes(
    submission: Submission, asked: Iterable[Question], found: Iterable[CheckResult]
) -> Iterator[str]:
    """Yield notes for the instructor."""
    for question in asked:
        stubs = submission.definitions.get(question.function, ())
        if len(stubs) > 1 and stubs[-1] and not all(stubs):
            yield f"{question.name}: a stub is defined after an answer and replaces it"
    for result in found:
        yield from (f"code cell {number + 1}: {error}" for number, error in result.cell_errors)
