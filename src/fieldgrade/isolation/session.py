"""Run a submission in the sandbox: its cells, then calls, with recovery when a process breaks.

Deadlines are enforced here by killing the process, since code in the sandbox can refuse to be
interrupted. A cell or call that hangs or crashes is left out; the others run again in a new
process.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

from fieldcheck.calls import Call, Outcome
from fieldgrade.isolation.process import NotStarted, Process, ProcessFailed
from fieldgrade.isolation.server import ProcessEnd, Server

MOST_FAILURES = 3
"""The largest number of failed starts."""


@dataclass
class SessionLog:
    """Errors, killed processes and costs of a submission.

    Parameters
    ----------
    cell_errors : dict
        The errors of cells, by the number of the cell.
    processes : list of ProcessEnd
        The end of each process.
    killed : list of str
        Why processes were killed: ``"time"``, ``"memory"``, ``"output"``, ``"crash"``,
        ``"exit"``, ``"threads"`` or ``"disk"``.
    broke : dict
        The same for the groups in which it happened, by name; all others happened in cells.
    seconds : float
        Total wall time.
    """

    cell_errors: dict[int, str] = field(default_factory=dict)
    processes: list[ProcessEnd] = field(default_factory=list)
    killed: list[str] = field(default_factory=list)
    broke: dict[str, str] = field(default_factory=dict)
    seconds: float = 0.0


@dataclass(frozen=True)
class CallGroup:
    """Calls to be made one after the other, each with a time limit in seconds.

    Once a group of a question has hung or crashed, the other groups of the question are skipped:
    each could take as long, and none could change the verdict.
    """

    name: str
    calls: tuple[Call, ...]
    seconds: float
    question: str = ""


def run(
    server: Server, cells: Sequence[str], tasks: Sequence[CallGroup]
) -> tuple[dict[str, tuple[Outcome, ...]], SessionLog]:
    """Run the cells of a submission and make the calls of all groups.

    Parameters
    ----------
    server : Server
        A started server.
    cells : sequence of str
        Code, in order.
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
        Time and again no process starts, which is no submission's fault.
    """
    log, outcomes, skipped = SessionLog(), dict[str, tuple[Outcome, ...]](), set[int]()
    started, todo = time.monotonic(), list(tasks)
    last, failures = started + server.limits.seconds_in_all, 0
    for _ in range(server.limits.most_starts):
        if not todo or time.monotonic() > last:
            break
        attempt = _Attempt(server, log, last)
        try:
            attempt.run_cells(cells, skipped)
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


class _Attempt:
    """One process of a submission; it knows the group of calls in which it broke."""

    def __init__(self, server: Server, log: SessionLog, last: float) -> None:
        self.process, self.log = Process(server, last), log
        self.task: CallGroup | None = None
        self.done: list[Outcome] = []

    def run_cells(self, cells: Sequence[str], skipped: set[int]) -> None:
        """Run the cells in order; a cell that breaks the process is added to the skipped ones."""
        self.process.await_start()
        for number, code in enumerate(cells):
            if number in skipped:
                continue
            try:
                error = self.process.cell(number, code)
            except ProcessFailed as broken:
                skipped.add(number)
                self.log.cell_errors[number] = str(broken)
                raise
            if error:
                self.log.cell_errors[number] = error

    def make_calls(self, task: CallGroup) -> tuple[Outcome, ...]:
        """Make the calls of a group; after a missing function or a time-out, skip the others."""
        self.task, self.done = task, []
        for call in task.calls:
            self.done.append(self.process.call(call, task.seconds))
            if self.done[-1].status not in ("returned", "raised"):
                break
        self.task = None
        return _filled(self.done, len(task.calls))

    def salvaged(self, task: CallGroup, broken: ProcessFailed) -> tuple[Outcome, ...]:
        """Return the outcomes of the group that broke the process."""
        last = Outcome("raised", error=str(broken))
        if broken.reason == "time":
            last = Outcome("timed out", seconds=task.seconds)
        return _filled([*self.done, last], len(task.calls))

    def end(self) -> None:
        """End the process and note how it ended."""
        self.log.processes.append(self.process.end())


def _filled(outcomes: Sequence[Outcome], count: int) -> tuple[Outcome, ...]:
    """Repeat the last outcome for the calls that were skipped."""
    return (*outcomes, *[outcomes[-1]] * (count - len(outcomes)))
