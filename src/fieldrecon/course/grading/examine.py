"""From a submission to a record of its grades: run behind walls, judged on this side."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fieldcheck.answers import arrays_to_json
from fieldcheck.calls import Outcome
from fieldcheck.ladder import PATIENCE
from fieldcheck.question import Question
from fieldcheck.verdict import Verdict
from fieldrecon.course.grading.isolation import Server
from fieldrecon.course.grading.quiet import quiet
from fieldrecon.course.grading.results import Grade, Record, Status
from fieldrecon.course.grading.session import Log, Task, run
from fieldrecon.course.grading.submission import Submission, Unreadable
from fieldrecon.course.grading.trusted import Course
from fieldrecon.course.trials import PUBLIC, Trial

MOST_SHOWN = 2000
"""Numbers of a wrong answer that are kept to be drawn."""


class Fault(Exception):
    """The grader fails, not the submission."""


@dataclass(frozen=True)
class Finding:
    """What is found of one answer; it can be kept, since it depends on no points.

    Parameters
    ----------
    verdict : Verdict
        How far up the ladder the answer came.
    check : str
        The check that it did not pass.
    broke : tuple of str
        Why processes had to be ended, in cells or in calls of this answer.
    cell_errors : tuple of (int, str)
        The code cells that did not end well.
    returned : tuple of mapping
        The wrong numbers on the public case that shows it best, for a picture.
    """

    verdict: Verdict
    check: str = ""
    broke: tuple[str, ...] = ()
    cell_errors: tuple[tuple[int, str], ...] = ()
    returned: tuple[Mapping[str, Any], ...] = ()


@dataclass(frozen=True)
class Examined:
    """The findings of one run behind the walls, by question, and what it cost."""

    findings: Mapping[str, Finding]
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
    Fault
        A check fails on the right answer.
    """
    try:
        number = submission.notebook(course.functions())
    except Unreadable as error:
        return Record(
            submission.student, submission.name, submission.digest, "", "unreadable", "",
            notes=(str(error),),
        )  # fmt: skip
    examined = examine(course, server, submission, number, only)
    return assembled(course, submission, number, server.tier, examined)


def examine(
    course: Course,
    server: Server,
    submission: Submission,
    number: str,
    only: Collection[str] = (),
) -> Examined:
    """Run a submission behind the walls of a started server, and judge what comes back.

    Nothing of it is imported, executed or unpickled on this side: its code goes to the server as
    text, and arrays come back. All public cases are tried before the first hidden one, so that no
    error that is told to a student can speak of hidden inputs. What is right but slow is tried once
    more: the machine may have been busy.
    """
    tried = course.trials(number, submission.student, only)
    found = _examined(server, submission, tried)
    slow = {name: tried[name] for name, f in found.findings.items() if f.verdict.rung == "slow"}
    if not slow:
        return found
    again = _examined(server, submission, slow)
    faster = {name: f for name, f in again.findings.items() if f.verdict.right}
    return Examined(
        {**found.findings, **faster},
        found.seconds + again.seconds,
        found.cpu_seconds + again.cpu_seconds,
        max(found.peak, again.peak),
    )


def _examined(
    server: Server, submission: Submission, tried: Mapping[str, Sequence[Trial]]
) -> Examined:
    tasks = [
        (k, Task(f"{name} {k}", trial.calls, PATIENCE * trial.question.limit, name))
        for name, gone_through in tried.items() for k, trial in enumerate(gone_through)
        if trial.question.function in submission.definitions
    ]  # fmt: skip
    ordered = [task for _, task in sorted(tasks, key=lambda pair: pair[0])]
    outcomes, log = run(server, submission.cells, ordered)
    return Examined(
        {name: _finding(name, its, outcomes, log) for name, its in tried.items()},
        log.seconds,
        sum(p.cpu_seconds for p in log.processes),
        max((p.peak for p in log.processes), default=0),
    )


def _finding(
    name: str, tried: Sequence[Trial], outcomes: Mapping[str, tuple[Outcome, ...]], log: Log
) -> Finding:
    """Return what is found of an answer: the verdict of the first trial that it does not pass."""
    verdict, check = Verdict(name, "right", ""), ""
    returned: tuple[Mapping[str, Any], ...] = ()
    for index, trial in enumerate(tried):
        came = outcomes.get(f"{name} {index}", (Outcome("missing"),) * len(trial.calls))
        verdict = _judged(trial, came)
        if not verdict.right:
            check = trial.name
            break
    if check == PUBLIC:
        returned = _shown(verdict, came)
    else:
        verdict = replace(verdict, call=None)
    errors = tuple(sorted(log.cell_errors.items()))
    return Finding(verdict, check, tuple(_broke(name, log)), errors, returned)


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
    Fault
        The check fails on the right answer too.
    """
    with quiet(), np.errstate(all="ignore"):
        try:
            return trial.judged(came)
        except Exception as error:
            right = tuple(Outcome("returned", values=values) for values in trial.answers.right)
            try:
                trial.judged(right)
            except Exception as fault:
                raise Fault(f"{trial.name} of {trial.question.name}: {fault!r}") from fault
            sentence = f"What it returns cannot be judged ({type(error).__name__})."
            return Verdict(trial.question.name, "wrong", sentence)


def _broke(name: str, log: Log) -> Iterator[str]:
    """Yield why processes had to be ended, but for what happened in calls of other answers."""
    elsewhere = list(log.broke.values())
    for reason in log.killed:
        if reason in elsewhere:
            elsewhere.remove(reason)
        else:
            yield reason
    yield from (reason for task, reason in log.broke.items() if task.split()[0] == name)


def code_digest(submission: Submission) -> str:
    """Return a digest of the code of all cells: any of them may bear on any answer."""
    return hashlib.sha256(json.dumps(submission.cells).encode()).hexdigest()


def assembled(
    course: Course, submission: Submission, number: str, tier: str, examined: Examined
) -> Record:
    """Return the record of a submission from what was found of its answers."""
    found = examined.findings
    return Record(
        submission.student, submission.name, submission.digest, number,
        _status(found.values()), tier,  # type: ignore[arg-type]
        grades=tuple(_grade(course, q, found[q.name]) for q in course.asked(number, tuple(found))),
        notes=tuple(dict.fromkeys(_notes(submission, course.asked(number), found))),
        code=code_digest(submission),
        seconds=examined.seconds, cpu_seconds=examined.cpu_seconds, peak=examined.peak,
    )  # fmt: skip


def _grade(course: Course, question: Question, finding: Finding) -> Grade:
    worth = float(course.worth.get(question.name, question.points))
    return Grade(
        question.name, worth * finding.verdict.credit, worth, finding.verdict, finding.check,
        course.made_by(question.name), finding.returned,
    )  # fmt: skip


def _status(findings: Iterable[Finding]) -> Status:
    broke = {reason for finding in findings for reason in finding.broke}
    for reason in ("memory", "output", "time"):
        if reason in broke:
            return f"killed: {reason}"  # type: ignore[return-value]
    return "partly" if broke else "graded"


def _notes(
    submission: Submission, asked: Iterable[Question], found: Mapping[str, Finding]
) -> Iterator[str]:
    """Yield what the instructor should look at."""
    for question in asked:
        stubs = submission.definitions.get(question.function, ())
        if len(stubs) > 1 and stubs[-1] and not all(stubs):
            yield f"{question.name}: a stub stands behind an answer, and takes its place"
    for finding in found.values():
        yield from (f"code cell {number + 1}: {error}" for number, error in finding.cell_errors)
