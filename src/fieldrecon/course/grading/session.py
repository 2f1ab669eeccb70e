"""A submission at work behind the walls: cells, then calls, and what is salvaged when it breaks.

The deadlines are kept here, by ending the process, since whatever runs over there can refuse to be
interrupted. What hangs or dies is left out, and the rest is run again in a new process.
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
from fieldrecon.course.grading.isolation import Ended, Server
from fieldrecon.course.sandbox import frames

SECONDS_TO_START = 20.0
GRACE = 1.0
"""A call ends itself after its limit where it can; so much later it is ended from here."""
MOST_STRAYS = 100
"""So many frames that answer something else are overlooked."""
MOST_TEXT = 2000
"""Characters of what a student's side tells in words."""

STATUSES = ("returned", "raised", "unwritten", "missing", "timed out")


@dataclass
class Log:
    """What happened while a submission ran.

    Parameters
    ----------
    cell_errors : dict
        The error of each cell that did not end well, by its number.
    processes : list of Ended
        How each process ended.
    killed : list of str
        Why processes had to be ended: ``"time"``, ``"memory"``, ``"output"``, ``"crash"``,
        ``"exit"``, ``"threads"`` or ``"disk"``.
    broke : dict
        The same for the tasks in which it happened, by name; the others happened in cells.
    seconds : float
        Wall time in all.
    """

    cell_errors: dict[int, str] = field(default_factory=dict)
    processes: list[Ended] = field(default_factory=list)
    killed: list[str] = field(default_factory=list)
    broke: dict[str, str] = field(default_factory=dict)
    seconds: float = 0.0


@dataclass(frozen=True)
class Task:
    """Calls to be made one after the other, each within so many seconds.

    Once a task of a question has hung or broken down, its others are not tried: each would take as
    long, and none could mend the first.
    """

    name: str
    calls: tuple[Call, ...]
    seconds: float
    question: str = ""


class Broken(Exception):
    """The process is of no more use; the reason in a word, and in a sentence."""

    def __init__(self, reason: str, sentence: str) -> None:
        super().__init__(sentence)
        self.reason = reason


def run(
    server: Server, cells: Sequence[str], tasks: Sequence[Task]
) -> tuple[dict[str, tuple[Outcome, ...]], Log]:
    """Run the cells of a submission and make the calls of all tasks.

    Parameters
    ----------
    server : Server
        A started server.
    cells : sequence of str
        Code, in order.
    tasks : sequence of Task
        What is to be called once the cells have run.

    Returns
    -------
    outcomes : dict
        What came of the calls, by the name of the task.
    log : Log
        What else happened.
    """
    log, outcomes, skipped = Log(), dict[str, tuple[Outcome, ...]](), set[int]()
    started, todo = time.monotonic(), list(tasks)
    last = started + server.limits.seconds_in_all
    for _ in range(server.limits.most_starts):
        if not todo or time.monotonic() > last:
            break
        process = _Process(server, log, last)
        try:
            process.run_cells(cells, skipped)
            while todo:
                task = todo.pop(0)
                outcomes[task.name] = process.make_calls(task)
                if outcomes[task.name][-1].status == "timed out":
                    todo = _without(todo, task)
        except Broken as broken:
            log.killed.append(broken.reason)
            if process.task:
                log.broke[process.task.name] = broken.reason
                outcomes[process.task.name] = process.salvaged(broken)
                todo = _without(todo, process.task)
        finally:
            process.end()
    given_up = Outcome("raised", error="the program broke down, or took long, too often to go on")
    outcomes |= {task.name: (given_up,) * len(task.calls) for task in todo}
    log.seconds = time.monotonic() - started
    return outcomes, log


def _without(todo: Sequence[Task], broken: Task) -> list[Task]:
    return [task for task in todo if not broken.question or task.question != broken.question]


class _Process:
    """One process of a submission, from its start to its end."""

    def __init__(self, server: Server, log: Log, last: float) -> None:
        self.server, self.log, self.last = server, log, last
        self.task: Task | None = None
        self.done: list[Outcome] = []
        self.ended: Ended | None = None
        self.to_it, self.from_it = server.run()

    def run_cells(self, cells: Sequence[str], skipped: set[int]) -> None:
        """Run the cells in order; remember the one that breaks the process, to leave it out."""
        self._await_start()
        for number, code in enumerate(cells):
            if number in skipped:
                continue
            seconds = self.server.limits.seconds_per_cell
            try:
                head, _ = self._ask({"cell": number, "code": code}, (), seconds)
            except Broken as broken:
                skipped.add(number)
                self.log.cell_errors[number] = str(broken)
                raise
            error = _text(head.get("error"))
            if error:
                self.log.cell_errors[number] = error

    def make_calls(self, task: Task) -> tuple[Outcome, ...]:
        """Make the calls of a task; once there is nothing to call, the others are not tried."""
        self.task, self.done = task, []
        seconds = min(task.seconds, self.server.limits.seconds_per_call)
        for call in task.calls:
            start = time.monotonic()
            head, values = self._ask(*_told(call, seconds), seconds + GRACE)
            self.done.append(_outcome(head, values, time.monotonic() - start))
            if self.done[-1].status not in ("returned", "raised"):
                break
        self.task = None
        return _filled(self.done, len(task.calls))

    def salvaged(self, broken: Broken) -> tuple[Outcome, ...]:
        """Return the outcomes of the task that broke the process."""
        task = self.task
        assert task is not None
        if broken.reason == "time":
            last = Outcome("timed out", seconds=task.seconds)
            return _filled([*self.done, last], len(task.calls))
        return _filled([*self.done, Outcome("raised", error=str(broken))], len(task.calls))

    def end(self) -> None:
        """End the process and note how it ended."""
        os.close(self.to_it)
        os.close(self.from_it)
        self._ended()

    def _ended(self, patiently: bool = False) -> Ended:
        if self.ended is None:
            self.ended = self.server.end(patiently)
            self.log.processes.append(self.ended)
        return self.ended

    def _await_start(self) -> None:
        """Wait for what comes before any code of a student's has run; that fails is not its fault.

        Raises
        ------
        Broken
            The process does not start.
        """
        try:
            frames.receive(self.from_it, time.monotonic() + SECONDS_TO_START)
        except (frames.Late, frames.BadFrame, frames.Gone):
            raise Broken("crash", "it did not start") from None

    def _ask(
        self, head: dict[str, Any], arrays: tuple[Any, ...], seconds: float
    ) -> tuple[dict[str, Any], list[np.ndarray]]:
        """Send a frame and return the answer, which bears its number.

        A student's code can find the pipe and write to it. The number is drawn, so that no answer
        can be given to what was not asked yet, nor one too many be taken for the next.

        Raises
        ------
        Broken
            There is none in time, or what comes is no answer.
        """
        number, late = secrets.randbits(50), min(time.monotonic() + seconds, self.last)
        try:
            frames.send(self.to_it, head | {"frame": number}, arrays, late)
            for _ in range(MOST_STRAYS):
                answer, values = frames.receive(self.from_it, late)
                if answer.get("frame") == number:
                    return answer, values
        except frames.Late:
            raise Broken("time", f"it was stopped after {seconds:.3g} seconds") from None
        except frames.BadFrame as error:
            raise Broken("output", f"what it returns cannot be read: {error}") from None
        except frames.Gone:
            limit = self.server.limits.cpu_seconds
            raise _death(self._ended(patiently=True), limit) from None
        raise Broken("output", "it answers what was not asked")


def _death(ended: Ended, cpu_seconds: float) -> Broken:
    """Return why a process ended by itself."""
    watched = {
        "threads": "it started too many threads",
        "disk": "it wrote more than it may",
        "server": "it ended the program that runs it",
    }
    signals = {
        6: ("crash", "it aborted itself"),
        9: ("memory", "it was ended by the system, as when memory runs out"),
        11: ("crash", "it crashed (segmentation fault)"),
        24: ("time", "it used up its processor time"),
        25: ("output", "it wrote a file that is too large"),
        31: ("crash", "it did what is forbidden here"),
    }
    if ended.ended_for:
        reason = "crash" if ended.ended_for == "server" else ended.ended_for
        return Broken(reason, watched.get(ended.ended_for, ended.ended_for))
    if ended.killed:
        return Broken("output", "it closed the pipe through which it answers")
    if ended.signal == 9 and ended.cpu_seconds >= cpu_seconds:
        return Broken(*signals[24])
    if ended.signal:
        told = f"it was ended by signal {ended.signal}"
        return Broken(*signals.get(ended.signal, ("crash", told)))
    return Broken("exit", f"it ended the program (exit status {ended.exit})")


def _told(call: Call, seconds: float) -> tuple[dict[str, Any], tuple[Any, ...]]:
    """Return a call as the head and the arrays of a frame."""
    arrays = tuple(a for a in call.arguments if isinstance(a, np.ndarray))
    numbers = iter(range(len(arrays)))
    arguments = [
        {"array": next(numbers)} if isinstance(a, np.ndarray) else {"number": a}
        for a in call.arguments
    ]
    head = {
        "function": call.function, "arguments": arguments, "case": call.case, "seconds": seconds
    }  # fmt: skip
    return head, arrays


def _outcome(head: dict[str, Any], values: list[np.ndarray], seconds: float) -> Outcome:
    """Return what an answer says, as far as it says what it may; the time is measured here."""
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
        modified=tuple(int(i) for i in modified if isinstance(i, int)) if isinstance(modified, list)
        else (),
    )  # fmt: skip


def _text(text: object) -> str:
    """Return words as far as they are some: short, and nothing that steers a terminal."""
    words = text[:MOST_TEXT] if isinstance(text, str) else ""
    return "".join(c if c.isprintable() or c == "\n" else "\ufffd" for c in words)


def _filled(outcomes: Sequence[Outcome], count: int) -> tuple[Outcome, ...]:
    """Repeat the last outcome for the calls that were not tried."""
    return (*outcomes, *[outcomes[-1]] * (count - len(outcomes)))
