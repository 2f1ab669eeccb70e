"""Run a submission in the sandbox: its cells, then calls, with recovery if a process fails.

Deadlines are enforced here by killing the process, since code in the sandbox can refuse to be
interrupted. A cell or call that hangs or crashes is left out; the others run again in a new
process. A student's code can reach the pipe through which its process answers, so everything that
comes from the pipe is validated.
"""

from __future__ import annotations

import os
import secrets
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fieldcheck.calls import Call, Outcome
from fieldgrade.isolation.server import ProcessEnd, Server
from fieldgrade.sandbox import frames

SECONDS_TO_START = 20.0
GRACE = 1.0
"""Seconds between the limit of a call, which interrupts it inside, and killing its process."""
MOST_STRAYS = 100
"""How many frames with a wrong number are ignored."""
MOST_TEXT = 2000
"""Characters of a text from the sandbox."""

STATUSES = ("returned", "raised", "unwritten", "missing", "timed out")

MOST_FAILURES = 3
"""The largest number of failed starts."""


class ProcessFailed(Exception):
    """The process cannot be used any more; the reason as a word, and as a sentence."""

    def __init__(self, reason: str, sentence: str) -> None:
        super().__init__(sentence)
        self.reason = reason


class NotStarted(RuntimeError):
    """No process starts, or it cannot restrict itself."""


class Process:
    """A process of a submission, from its start to its end.

    Parameters
    ----------
    server : Server
        A started server.
    last : float
        The time of ``time.monotonic`` after which nothing is requested.
    """

    def __init__(self, server: Server, last: float) -> None:
        self.server, self.last = server, last
        self.ended: ProcessEnd | None = None
        self.to_it, self.from_it = server.run()

    def await_start(self) -> None:
        """Wait for the first frame, which is sent before any student's code runs.

        Raises
        ------
        NotStarted
            The frame does not come.
        """
        try:
            frames.receive(self.from_it, time.monotonic() + SECONDS_TO_START)
        except (frames.FrameTimeout, frames.BadFrame, frames.PipeClosed):
            raise NotStarted(f"no process starts in the sandbox ({self.server.tier})") from None

    def cell(self, number: int, code: str) -> str:
        """Run a cell, and return its error; empty if there is none."""
        seconds = self.server.limits.seconds_per_cell
        head, _ = self._request({"cell": number, "code": code}, (), seconds)
        return _text(head.get("error"))

    def call(self, call: Call, seconds: float) -> Outcome:
        """Make a call with a time limit in seconds, and return its outcome."""
        seconds = min(seconds, self.server.limits.seconds_per_call)
        start = time.monotonic()
        head, values = self._request(*_call_frame(call, seconds), seconds + GRACE)
        return _outcome(head, values, time.monotonic() - start)

    def end(self, patiently: bool = False) -> ProcessEnd:
        """End the process, and return how it ended."""
        if self.ended is None:
            self.ended = self.server.end(patiently)
            os.close(self.to_it)
            os.close(self.from_it)
        return self.ended

    def _request(
        self, head: dict[str, Any], arrays: tuple[Any, ...], seconds: float
    ) -> tuple[dict[str, Any], list[np.ndarray]]:
        """Send a frame and return the answer, which has the same number.

        A student's code can find the pipe and write to it. The number is random, so that nothing
        can answer a future request, and a surplus answer is not taken for the next one.

        Raises
        ------
        ProcessFailed
            There is no answer in time, or it is not valid.
        """
        number, late = secrets.randbits(50), min(time.monotonic() + seconds, self.last)
        try:
            frames.send(self.to_it, head | {"frame": number}, arrays, late)
            for _ in range(MOST_STRAYS):
                answer, values = frames.receive(self.from_it, late)
                if answer.get("frame") == number:
                    return answer, values
        except frames.FrameTimeout:
            raise ProcessFailed("time", f"it was stopped after {seconds:.3g} seconds") from None
        except frames.BadFrame as error:
            raise ProcessFailed("output", f"no answer is available: {error}") from None
        except frames.PipeClosed:
            limit = self.server.limits.cpu_seconds
            raise _death(self.end(patiently=True), limit) from None
        raise ProcessFailed("output", "it sends answers to other requests")


def _death(ended: ProcessEnd, cpu_seconds: float) -> ProcessFailed:
    """Return the reason why a process ended by itself."""
    watched = {
        "threads": "it started too many threads",
        "disk": "it wrote too much",
        "server": "it ended the program that runs it",
    }
    signals = {
        6: ("crash", "it aborted itself"),
        9: ("memory", "it was ended by the system, as when memory runs out"),
        11: ("crash", "it crashed (segmentation fault)"),
        24: ("time", "it used up its processor time"),
        25: ("output", "it wrote a file that is too large"),
        31: ("crash", "it made a forbidden system call"),
    }
    if ended.ended_for:
        reason = "crash" if ended.ended_for == "server" else ended.ended_for
        return ProcessFailed(reason, watched.get(ended.ended_for, ended.ended_for))
    if ended.killed:
        return ProcessFailed("output", "it closed the pipe through which it answers")
    if ended.signal == 9 and ended.cpu_seconds >= cpu_seconds:
        return ProcessFailed(*signals[24])
    if ended.signal:
        unknown = f"it was ended by signal {ended.signal}"
        return ProcessFailed(*signals.get(ended.signal, ("crash", unknown)))
    return ProcessFailed("exit", f"it ended the program (exit status {ended.exit})")


def _call_frame(call: Call, seconds: float) -> tuple[dict[str, Any], tuple[Any, ...]]:
    """Return a call as the head and the arrays of a frame."""
    arrays = tuple(a for a in call.arguments if isinstance(a, np.ndarray))
    numbers = iter(range(len(arrays)))
    arguments = [
        {"array": next(numbers)} if isinstance(a, np.ndarray) else {"number": a}
        for a in call.arguments
    ]
    head = {
        "function": call.function,
        "arguments": arguments,
        "case": call.case,
        "seconds": seconds,
    }
    return head, arrays


def _outcome(head: dict[str, Any], values: list[np.ndarray], seconds: float) -> Outcome:
    """Return the outcome in an answer, validated; the time is measured here."""
    status, modified = head.get("status"), head.get("modified")
    if status == "too large":
        return Outcome("raised", error="what it returns is too large")
    if status not in STATUSES:
        return Outcome("raised", error="what it returns cannot be read")
    return Outcome(
        status,
        values=tuple(values) if head.get("numbers") is True else None,
        returned=_text(head.get("returned")),
        error=_text(head.get("error")),
        line=_text(head.get("line")),
        seconds=seconds,
        modified=tuple(int(i) for i in modified if isinstance(i, int))
        if isinstance(modified, list)
        else (),
    )


def _text(text: object) -> str:
    """Return a text, validated: short, and without control characters."""
    words = text[:MOST_TEXT] if isinstance(text, str) else ""
    return "".join(c if c.isprintable() or c == "\n" else "\ufffd" for c in words)


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
        Several attempts to start a process failed, which is not the fault of the submission.
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
    """One process of a submission, with the group of calls in which it failed."""

    def __init__(self, server: Server, log: SessionLog, last: float) -> None:
        self.process, self.log = Process(server, last), log
        self.task: CallGroup | None = None
        self.done: list[Outcome] = []

    def run_cells(self, cells: Sequence[str], skipped: set[int]) -> None:
        """Run the cells in order; a cell at which the process fails is added to `skipped`."""
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
        """Return the outcomes of the group in which the process failed."""
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
