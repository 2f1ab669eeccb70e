"""From a submission to a record of its grades: run behind walls, judged on this side."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fieldcheck.answers import arrays_to_json
from fieldcheck.calls import Outcome
from fieldcheck.ladder import TIMEOUT_FACTOR
from fieldcheck.question import Question
from fieldcheck.verdict import Verdict
from fieldgrade.authoring.trials import PUBLIC, Trial
from fieldgrade.checking.check_results import CheckResult, CheckResults
from fieldgrade.checking.course import Course
from fieldgrade.checking.results import Grade, Record, Status
from fieldgrade.isolation.server import GraderError, Server
from fieldgrade.isolation.session import CallGroup, SessionLog, run
from fieldgrade.submissions.submission import Submission, Unreadable
from fieldgrade.submissions.suppress_warnings import suppress_warnings

MOST_SHOWN = 2000
"""Numbers of a wrong answer that are kept to be drawn."""


Tried = Mapping[str, Mapping[int, Trial]]
"""By question, and by the place of the check among all of the question."""


@dataclass(frozen=True)
class SandboxRun:
    """What was found in one run behind the walls, and what it cost."""

    results: CheckResults
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    peak: int = 0


def grade(
    course: Course, server: Server, submission: Submission, only: Collection[str] = ()
) -> Record:
    """Grade a submission behind the walls of a started server.

    Returns
    -------
    Record
        Also for what cannot be read: a batch never stops because of a submission.

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
    """Make checks of the answers of a submission behind the walls of a started server.

    Nothing of it is imported, executed or unpickled on this side: its code goes to the server as
    text, and arrays come back. All public cases are tried before the first hidden one, so that no
    error that is told to a student can speak of hidden inputs. What is right but slow is tried once
    more: the machine may have been busy.
    """
    tried = {
        name: {k: trial for k, trial in enumerate(its) if trial.name in checks[name]}
        for name, its in course.trials(number, submission.student, checks).items()
    }
    found = _run_sandboxed(server, submission, tried)
    slow = dict(_slow(tried, found.results))
    if not slow:
        return found
    again = _run_sandboxed(server, submission, slow)
    faster = {
        name: {**found.results[name], **its}
        for name, its in again.results.items()
        if next(iter(its.values())).verdict.right
    }
    return SandboxRun(
        {**found.results, **faster},
        found.seconds + again.seconds,
        found.cpu_seconds + again.cpu_seconds,
        max(found.peak, again.peak),
    )


def _slow(tried: Tried, found: CheckResults) -> Iterator[tuple[str, Mapping[int, Trial]]]:
    """Yield what is to be tried of an answer that was slow: from that check on."""
    for name, its in found.items():
        *passed, last = its
        if its[last].verdict.rung == "slow":
            yield name, {k: t for k, t in tried[name].items() if t.name not in passed}


def _run_sandboxed(server: Server, submission: Submission, tried: Tried) -> SandboxRun:
    tasks = [
        (k, CallGroup(f"{name} {k}", trial.calls, TIMEOUT_FACTOR * trial.question.limit, name))
        for name, its in tried.items()
        for k, trial in its.items()
        if trial.question.function in submission.definitions
    ]
    ordered = [task for _, task in sorted(tasks, key=lambda pair: pair[0])]
    outcomes, log = run(server, submission.cells, ordered)
    return SandboxRun(
        {name: dict(_findings(name, its, outcomes, log)) for name, its in tried.items()},
        log.seconds,
        sum(p.cpu_seconds for p in log.processes),
        max((p.peak for p in log.processes), default=0),
    )


def _findings(
    name: str,
    tried: Mapping[int, Trial],
    outcomes: Mapping[str, tuple[Outcome, ...]],
    log: SessionLog,
) -> Iterator[tuple[str, CheckResult]]:
    """Yield what each check finds of an answer, up to the first that it does not pass."""
    for place, trial in tried.items():
        task = f"{name} {place}"
        came = outcomes.get(task, (Outcome("missing"),) * len(trial.calls))
        finding = _finding(trial, came, tuple(_broke(task, log)), log)
        yield trial.name, finding
        if not finding.verdict.right:
            return


def _finding(
    trial: Trial, came: Sequence[Outcome], broke: tuple[str, ...], log: SessionLog
) -> CheckResult:
    verdict = _judged(trial, came)
    check = "" if verdict.right else trial.name
    returned = _shown(verdict, came) if check == PUBLIC else ()
    if check != PUBLIC:
        verdict = replace(verdict, call=None)
    return CheckResult(verdict, check, broke, tuple(sorted(log.cell_errors.items())), returned)


def _shown(verdict: Verdict, came: Sequence[Outcome]) -> tuple[Mapping[str, Any], ...]:
    """Return wrong numbers that a student may see beside the right ones, if few and finite."""
    if verdict.rung not in ("wrong", "misconception") or verdict.call is None:
        return ()
    values = came[verdict.call].values or ()
    real = all(v.dtype.kind in "biuf" and np.isfinite(v).all() for v in values)
    if not real or sum(v.size for v in values) > MOST_SHOWN:
        return ()
    return tuple(arrays_to_json(values))


def _judged(trial: Trial, came: Sequence[Outcome]) -> Verdict:
    """Judge outcomes; what no check can stand is wrong, if it stands the right answer.

    Raises
    ------
    GraderError
        The check fails on the right answer too.
    """
    with suppress_warnings(), np.errstate(all="ignore"):
        try:
            return trial.judged(came)
        except Exception as error:
            right = tuple(Outcome("returned", values=values) for values in trial.answers.right)
            try:
                trial.judged(right)
            except Exception as fault:
                raise GraderError(f"{trial.name} of {trial.question.name}: {fault!r}") from fault
            sentence = f"What it returns cannot be judged ({type(error).__name__})."
            return Verdict(trial.question.name, "wrong", sentence)


def _broke(task: str, log: SessionLog) -> Iterator[str]:
    """Yield why processes had to be ended, but for what happened in calls of other tasks."""
    elsewhere = list(log.broke.values())
    for reason in log.killed:
        if reason in elsewhere:
            elsewhere.remove(reason)
        else:
            yield reason
    if task in log.broke:
        yield log.broke[task]


def assemble_record(
    course: Course, submission: Submission, number: str, tier: str, sandbox_run: SandboxRun
) -> Record:
    """Return the record of a submission from what was found of its answers."""
    found = sandbox_run.results
    each = [finding for its in found.values() for finding in its.values()]
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
    *_, finding = found.values()  # the first check that is not passed, or the last that is
    worth = float(course.worth.get(question.name, question.points))
    return Grade(
        question.name,
        worth * finding.verdict.credit,
        worth,
        finding.verdict,
        finding.check,
        course.made_by(question.name),
        finding.returned,
    )


def _status(findings: Iterable[CheckResult]) -> Status:
    broke = {reason for finding in findings for reason in finding.broke}
    for reason in ("memory", "output", "time"):
        if reason in broke:
            return f"killed: {reason}"  # type: ignore[return-value]
    return "partly" if broke else "graded"


def _notes(
    submission: Submission, asked: Iterable[Question], found: Iterable[CheckResult]
) -> Iterator[str]:
    """Yield what the instructor should look at."""
    for question in asked:
        stubs = submission.definitions.get(question.function, ())
        if len(stubs) > 1 and stubs[-1] and not all(stubs):
            yield f"{question.name}: a stub stands behind an answer, and takes its place"
    for finding in found:
        yield from (f"code cell {number + 1}: {error}" for number, error in finding.cell_errors)
