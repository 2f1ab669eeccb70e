"""Grade one submission: run its code in the sandbox, judge the returned values outside."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import or_
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from fieldcheck.answers import arrays_to_json
from fieldcheck.calls import Outcome
from fieldcheck.judge import TIMEOUT_FACTOR
from fieldcheck.question import Question
from fieldcheck.questions import get
from fieldcheck.verdict import Verdict
from fieldgrade.authoring.right_functions import RightFunctions
from fieldgrade.authoring.trials import PUBLIC, Trial
from fieldgrade.checking.check_results import CellReport, CheckResult, CheckResults
from fieldgrade.checking.course import Course
from fieldgrade.checking.earlier_mistakes import is_right, with_given
from fieldgrade.checking.missing_names import cause
from fieldgrade.checking.results import Grade, Record, Status
from fieldgrade.isolation.process import Program
from fieldgrade.isolation.server import GraderError, Server
from fieldgrade.isolation.session import CallGroup, SessionLog, run
from fieldgrade.sandbox.missing import NOTHING
from fieldgrade.submissions.definitions import suppress_warnings
from fieldgrade.submissions.submission import Submission, Unreadable

T = TypeVar("T")

MOST_SHOWN = 2000
"""Values of a wrong answer that are kept for a picture, at most."""

STUB = "a stub is defined after an answer: the answer of {} counts, not the stub"
UNUSED = "{} is not used, since a library has this name"
NEEDED_ONLY = (
    "cells crashed too often or took too long together: only the code that the answers need was run"
)

NO_RESULTS: CheckResults = MappingProxyType({})

Tried = Mapping[str, Mapping[int, Trial]]
"""By question, and by the index of the check among all checks of the question."""


@dataclass(frozen=True)
class SandboxRun:
    """The results of one run in the sandbox, and its cost."""

    results: CheckResults
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    peak: int = 0

    def with_run(self, other: SandboxRun, results: CheckResults) -> SandboxRun:
        """Return this run with some other results, and with the cost of another run."""
        return SandboxRun(
            {**self.results, **results},
            self.seconds + other.seconds,
            self.cpu_seconds + other.cpu_seconds,
            max(self.peak, other.peak),
        )


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
    known: CheckResults = NO_RESULTS,
) -> SandboxRun:
    """Run checks of the answers of a submission with a started server.

    Nothing of the submission is imported, executed or unpickled outside the sandbox: its code goes
    to the server as text, and the server returns arrays. All public cases run before the first
    hidden one, so that no error message shown to a student can contain hidden inputs. An answer
    that is right but slow runs once more: the machine may have been busy. An answer that calls
    wrong earlier ones is asked again with right ones. The results of other questions may be `known`
    already.
    """
    tried = {
        name: {k: trial for k, trial in enumerate(its) if trial.name in checks[name]}
        for name, its in course.trials(number, submission.student, checks).items()
    }
    found = _run_until_fast(server, submission, tried)
    for name in (name for name, its in found.results.items() if not is_right(its)):
        needed = [e for e in course.given(name) if e not in {**known, **found.results}]
        if needed:
            more = {earlier: course.checks(earlier) for earlier in needed}
            known = {**known, **run_checks(course, server, submission, number, more, known).results}
        found = _asked_again(course, server, submission, name, tried[name], found, known)
    return found


def _asked_again(
    course: Course,
    server: Server,
    submission: Submission,
    name: str,
    tried: Mapping[int, Trial],
    before: SandboxRun,
    known: CheckResults,
) -> SandboxRun:
    """Ask a wrong answer again, in its own run, with right functions for wrong earlier ones."""
    first, results = before.results[name], {**known, **before.results}
    wrong = [get(earlier) for earlier in course.given(name) if not is_right(results[earlier])]
    if not wrong:
        return before
    functions = {question.function: question.name for question in wrong}
    given = RightFunctions(course.source(wrong[0].notebook).path, functions)
    again = _run_sandboxed(server, submission, {name: tried}, given)
    called = tuple(sorted(functions[function] for function in given.called))
    merged = with_given(first, again.results[name], called) if called else first
    return before.with_run(again, {name: merged})


def _run_until_fast(server: Server, submission: Submission, tried: Tried) -> SandboxRun:
    """Run checks, and again those of slow answers."""
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
    return first.with_run(again, faster)


def _slow(tried: Tried, found: CheckResults) -> Iterator[tuple[str, Mapping[int, Trial]]]:
    """Yield the checks to repeat for slow answers: from the slow check on."""
    for name, its in found.items():
        *passed, last = its
        if its[last].verdict.finding == "slow":
            yield name, {k: t for k, t in tried[name].items() if t.name not in passed}


def _run_sandboxed(
    server: Server, submission: Submission, tried: Tried, given: RightFunctions | None = None
) -> SandboxRun:
    def group(name: str, k: int, trial: Trial) -> CallGroup:
        seconds = TIMEOUT_FACTOR * trial.question.limit
        return CallGroup(f"{name} {k}", trial.calls, seconds, name, given)

    groups = [(k, group(name, k, trial)) for name, its in tried.items() for k, trial in its.items()]
    ordered = [group for _, group in sorted(groups, key=lambda pair: pair[0])]
    outcomes, log = run(server, Program(submission.sources, tuple(submission.files())), ordered)
    cells = _cell_report(log, [g.name for k, g in groups if not k])
    results = {
        name: dict(_check_results(name, its, outcomes, log, cells)) for name, its in tried.items()
    }
    return SandboxRun(
        results,
        log.seconds,
        sum(p.cpu_seconds for p in log.processes),
        max((p.peak for p in log.processes), default=0),
    )


def _cell_report(log: SessionLog, public: Iterable[str]) -> CellReport:
    """Return what is reported about the cells; calls with hidden inputs report nothing here."""
    in_calls = (log.missing_in_calls.get(name, NOTHING) for name in public)
    missing = reduce(or_, in_calls, log.missing)
    notes = [STUB.format(name) for name in log.stubs]
    notes += [UNUSED.format(name) for name in log.unused_files]
    notes += [NEEDED_ONLY] * log.needed_only
    errors = tuple(error for _, error in sorted(log.cell_errors.items()))
    return CellReport(errors, missing, tuple(notes))


def _check_results(
    name: str,
    tried: Mapping[int, Trial],
    outcomes: Mapping[str, tuple[Outcome, ...]],
    log: SessionLog,
    cells: CellReport,
) -> Iterator[tuple[str, CheckResult]]:
    """Yield the result of each check of an answer, up to the first failure."""
    for index, trial in tried.items():
        group = f"{name} {index}"
        outcomes_of_trial = outcomes.get(group, (Outcome("missing"),) * len(trial.calls))
        result = _check_result(trial, outcomes_of_trial, tuple(_broke(group, log)), cells)
        yield trial.name, result
        if not result.verdict.right:
            return


def _check_result(
    trial: Trial, outcomes_of_trial: Sequence[Outcome], broke: tuple[str, ...], cells: CellReport
) -> CheckResult:
    verdict = _judged(trial, outcomes_of_trial)
    check = "" if verdict.right else trial.name
    returned = _shown(verdict, outcomes_of_trial) if check == PUBLIC else ()
    if check != PUBLIC:
        verdict = replace(verdict, call=None)
    return CheckResult(verdict, check, broke, cells, returned)


def _shown(verdict: Verdict, outcomes_of_trial: Sequence[Outcome]) -> tuple[Mapping[str, Any], ...]:
    """Return wrong values that are shown beside the right ones, if they are few and finite."""
    if verdict.finding not in ("wrong", "misconception") or verdict.call is None:
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
            except Exception as failure:
                raise GraderError(
                    f"{trial.name} of {trial.question.name}: {failure!r}"
                ) from failure
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
        grades=tuple(
            _grade(course, q, found[q.name], submission) for q in course.asked(number, tuple(found))
        ),
        notes=tuple(dict.fromkeys(_notes(each))),
        cell_errors=_all(result.cells.errors for result in each),
        missing=reduce(or_, (result.cells.missing for result in each), NOTHING),
        helper_files=tuple(name for name, _ in submission.helpers),
        code=submission.code_digest,
        seconds=sandbox_run.seconds,
        cpu_seconds=sandbox_run.cpu_seconds,
        peak=sandbox_run.peak,
    )


def _all(found: Iterable[Iterable[T]]) -> tuple[T, ...]:
    return tuple(dict.fromkeys(each for its in found for each in its))


def _grade(
    course: Course, question: Question, found: Mapping[str, CheckResult], submission: Submission
) -> Grade:
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
        cause(question, result, submission),
        result.given,
    )


def _status(results: Iterable[CheckResult]) -> Status:
    broke = {reason for result in results for reason in result.broke}
    for reason in ("memory", "output", "time"):
        if reason in broke:
            return f"killed: {reason}"  # type: ignore[return-value]
    return "partly" if broke else "graded"


def _notes(each: Iterable[CheckResult]) -> Iterator[str]:
    """Yield notes for the instructor."""
    for result in each:
        yield from result.cells.notes
        yield from map(str, result.cells.errors)
