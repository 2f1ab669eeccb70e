"""Run a submission in the sandbox: its cells, then calls, with recovery if a process fails.

A statement or call that hangs or crashes is left out; the others run again in a new process. If
cells crash too often, only what the answers need is run.
"""

from __future__ import annotations

import re
import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Any

from fieldcheck.calls import Call, Outcome
from fieldgrade.authoring.right_functions import RightFunctions
from fieldgrade.isolation.process import (
    TOO_LARGE,
    CellError,
    NotStarted,
    Process,
    ProcessFailed,
    Program,
    as_number,
    as_text,
)
from fieldgrade.isolation.server import ProcessEnd, Server
from fieldgrade.sandbox.missing import MOST_MISSING, NOTHING, Missing, validated
from fieldgrade.sandbox.statements import NO_DEFINITION

NAME = re.compile(r"\w{1,80}")
SEEN_LATE = ("disk", "threads")
"""Reasons to end a process that are seen when a later statement may run."""
KEPT_OF_EACH_GROUP, KEPT_OF_ALL = 1 << 22, 1 << 26
"""Bytes of values that each group of calls may return, and that all groups may share beyond."""

MOST_FAILURES = 3
"""The largest number of failed starts."""


@dataclass
class SessionLog:
    """Errors, killed processes and costs of a submission.

    Parameters
    ----------
    cell_errors : dict
        The first error of each cell that has one, by the index of the cell.
    missing : Missing
        Modules, files and fonts that cells need and that are not there.
    missing_in_calls : dict
        The same for the calls of each group, by name; hidden inputs may decide what is missing.
    stubs : list of str
        Functions for which a stub stands after an answer; the stub was passed over.
    unused_files : list of str
        Submitted files that are not used, since a library has their name.
    needed_only : bool
        Whether only the statements that the answers need were run.
    processes : list of ProcessEnd
        The end of each process.
    killed : list of str
        Why processes were killed: ``"time"``, ``"memory"``, ``"output"``, ``"crash"``,
        ``"exit"``, ``"threads"`` or ``"disk"``.
    broke : dict
        The same for the groups in which it happened, by name; all others happened in cells.
    seconds : float
        Total wall time.
    room : int
        Bytes that the groups may still share for large values.
    """

    cell_errors: dict[int, CellError] = field(default_factory=dict)
    missing: Missing = field(default_factory=Missing)
    missing_in_calls: dict[str, Missing] = field(default_factory=dict)
    stubs: list[str] = field(default_factory=list)
    unused_files: list[str] = field(default_factory=list)
    needed_only: bool = False
    processes: list[ProcessEnd] = field(default_factory=list)
    killed: list[str] = field(default_factory=list)
    broke: dict[str, str] = field(default_factory=dict)
    seconds: float = 0.0
    room: int = field(default_factory=lambda: KEPT_OF_ALL)


@dataclass(frozen=True)
class CallGroup:
    """Calls to be made one after the other, each with a time limit in seconds.

    Once a group of a question has hung or crashed, the other groups of the question are skipped:
    each could take as long, and none could change the verdict. Right functions of earlier questions
    may be given in place of those of the submission.
    """

    name: str
    calls: tuple[Call, ...]
    seconds: float
    question: str = ""
    given: RightFunctions | None = None


def run(
    server: Server, program: Program | Sequence[str], tasks: Sequence[CallGroup]
) -> tuple[dict[str, tuple[Outcome, ...]], SessionLog]:
    """Run the cells of a submission and make the calls of all groups.

    Parameters
    ----------
    server : Server
        A started server.
    program : Program or sequence of str
        The code, in order.
    tasks : sequence of CallGroup
        The calls to make after the cells have run.

    Returns
    -------
    outcomes : dict
        The outcomes of the calls, by the name of the group.
    log : SessionLog
        Errors, killed processes and costs.

    Raises
    ------
    NotStarted
        Several attempts to start a process failed, which is not the fault of the submission.
    MachineFailed
        The machine or the server failed, so that the submission must run again.
    """
    program = program if isinstance(program, Program) else Program(program)
    log, outcomes = SessionLog(), dict[str, tuple[Outcome, ...]]()
    started, todo = time.monotonic(), list(tasks)
    last, failures = started + server.limits.seconds_in_all, 0
    plan = _Plan(program, {call.function for task in tasks for call in task.calls}, server, log)
    while todo and time.monotonic() < last and plan.failures < server.limits.most_starts:
        attempt = _Attempt(server, log, last)
        try:
            attempt.run_cells(plan)
            while todo:
                task = todo.pop(0)
                outcomes[task.name] = attempt.make_calls(task)
                if outcomes[task.name][-1].status == "timed out":
                    todo = _without(todo, task)
                    break  # the state after an interruption is unknown: start a new process
        except NotStarted:
            failures += 1
            if failures == MOST_FAILURES:
                raise
        except ProcessFailed as broken:
            log.killed.append(broken.reason)
            plan.failures += attempt.task is None
            log.needed_only |= plan.failures >= server.limits.most_starts // 2
            if attempt.task:
                task = attempt.task
                log.broke[task.name] = broken.reason
                outcomes[task.name] = attempt.salvaged(task, broken)
                todo = _without(todo, task)
        finally:
            attempt.end()
    given_up = Outcome("raised", error="the program crashed or timed out too often to continue")
    outcomes |= {task.name: (given_up,) * len(task.calls) for task in todo}
    log.seconds = time.monotonic() - started
    return outcomes, log


def _without(todo: Sequence[CallGroup], broken: CallGroup) -> list[CallGroup]:
    return [task for task in todo if not broken.question or task.question != broken.question]


class _Plan:
    """What is run of the cells: all but the statements at which processes failed.

    After half of the possible starts, or half of the time, only what the answers need is run.
    """

    def __init__(
        self, program: Program, asked: Collection[str], server: Server, log: SessionLog
    ) -> None:
        self.program, self.asked, self.log = program, asked, log
        self.halfway = time.monotonic() + server.limits.seconds_in_all / 2
        self.failures = 0
        self.left_out: dict[int, set[int]] = {}
        self.cells_left_out: set[int] = set()

    def leave_out(self, number: int, process: Process, broken: ProcessFailed) -> None:
        """Leave out the statement at which a process failed; the whole cell, if it is unknown."""
        if not self.log.needed_only and time.monotonic() >= self.halfway:
            self.log.needed_only = True  # all cells together take too long, perhaps not this one
            return
        left_out = self.left_out.setdefault(number, set())
        if not process.statement or process.statement - 1 in left_out:
            self.cells_left_out.add(number)
        left_out.add(NO_DEFINITION if broken.reason in SEEN_LATE else process.statement - 1)
        error = self.program.error(number, process.line, str(broken))
        self.log.cell_errors.setdefault(number, error)


class _Attempt:
    """One process of a submission, with the group of calls in which it failed."""

    def __init__(self, server: Server, log: SessionLog, last: float) -> None:
        self.process, self.log, self.last = Process(server, last), log, last
        self.task: CallGroup | None = None
        self.done: list[Outcome] = []

    def run_cells(self, plan: _Plan) -> None:
        """Run the cells in order, without what the plan leaves out."""
        self.process.await_start()
        self.log.unused_files = self.process.load(plan.program, plan.asked)
        if self.log.needed_only:
            self.process.keep_needed(plan.cells_left_out)
        else:
            self.process.last = min(self.last, plan.halfway)
        for number in range(len(plan.program.cells)):
            if number in plan.cells_left_out:
                continue
            try:
                report = self.process.cell(number, plan.left_out.get(number, ()))
                self.process.check_limits()
            except ProcessFailed as broken:
                plan.leave_out(number, self.process, broken)
                raise
            self._note(plan.program, number, report)
        self.process.last = self.last

    def _note(self, program: Program, number: int, report: dict[str, Any]) -> None:
        """Note what a cell reports, validated."""
        if error := as_text(report.get("error")):
            line = as_number(report.get("line"))
            self.log.cell_errors.setdefault(number, program.error(number, line, error))
        self.log.missing |= validated(report.get("missing"))
        stubs, known = report.get("stubs"), self.log.stubs
        for name in stubs[:MOST_MISSING] if isinstance(stubs, list) else ():
            is_new = isinstance(name, str) and NAME.fullmatch(name) and name not in known
            if is_new and len(known) < MOST_MISSING:
                known.append(name)

    def make_calls(self, task: CallGroup) -> tuple[Outcome, ...]:
        """Make the calls of a group in turn.

        After a missing function, a time-out or a value that is too large, skip the others.
        """
        self.task, self.done, self.process.missing = task, [], NOTHING
        own = KEPT_OF_EACH_GROUP
        for call in task.calls:
            outcome = self.process.call(call, task.seconds, task.given)
            size = sum(value.nbytes for value in outcome.values or ())
            if size > own + self.log.room:
                outcome, size = Outcome("raised", error=TOO_LARGE), 0
            self.log.room -= max(0, size - own)
            own = max(0, own - size)
            self.done.append(outcome)
            self.log.missing_in_calls[task.name] = self.process.missing
            if outcome.status not in ("returned", "raised") or outcome.error == TOO_LARGE:
                break
        self.process.check_limits()
        self.task = None
        return _filled(self.done, len(task.calls))

    def salvaged(self, task: CallGroup, broken: ProcessFailed) -> tuple[Outcome, ...]:
        """Return the outcomes of the group in which the process failed."""
        last = Outcome("raised", error=str(broken))
        if broken.reason == "time":
            last = Outcome("timed out", seconds=task.seconds)
        count = len(task.calls)
        return _filled([*self.done[: count - 1], last], count)

    def end(self) -> None:
        """End the process and note how it ended."""
        self.log.processes.append(self.process.end())


def _filled(outcomes: Sequence[Outcome], count: int) -> tuple[Outcome, ...]:
    """Repeat the last outcome for the calls that were skipped."""
    return (*outcomes, *[outcomes[-1]] * (count - len(outcomes)))
