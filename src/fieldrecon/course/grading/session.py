"""A submission at work behind the walls: cells, then calls, and what is salvaged when it breaks.

The deadlines are kept here, by ending the process, since whatever runs over there can refuse to be
interrupted. What hangs or dies is left out, and the rest is run again in a new process.
"""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fieldcheck.calls import Call, Outcome
from fieldrecon.course.grading.isolation import Ended, Server
from fieldrecon.course.sandbox import frames

SECONDS_PER_CELL = 10.0
SECONDS_TO_START = 20.0
GRACE = 1.0
"""A call ends itself after its limit where it can; so much later it is ended from here."""
MOST_STARTS = 25
"""After so many processes what is left of a submission is given up."""

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
        Why processes had to be ended: ``"time"``, ``"memory"``, ``"output"`` or a signal.
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
    for _ in range(MOST_STARTS):
        if not todo:
            break
        process = _Process(server, log)
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
    given_up = Outcome("raised", error="the program broke down too often to go on")
    outcomes |= {task.name: (given_up,) * len(task.calls) for task in todo}
    log.seconds = time.monotonic() - started
    return outcomes, log


def _without(todo: Sequence[Task], broken: Task) -> list[Task]:
    return [task for task in todo if not broken.question or task.question != broken.question]


class _Process:
    """One process of a submission, from its start to its end."""

    def __init__(self, server: Server, log: Log) -> None:
        self.server, self.log = server, log
        self.task: Task | None = None
        self.done: list[Outcome] = []
        self.ended: Ended | None = None
        self.ready = False
        self.to_it, self.from_it = server.run()

    def run_cells(self, cells: Sequence[str], skipped: set[int]) -> None:
        """Run the cells in order; remember the one that breaks the process, to leave it out."""
        for number, code in enumerate(cells):
            if number in skipped:
                continue
            try:
                head, _ = self._ask({"cell": number, "code": code}, (), SECONDS_PER_CELL)
            except Broken as broken:
                skipped.add(number)
                self.log.cell_errors[number] = str(broken)
                raise
            error = head.get("error")
            if isinstance(error, str) and error:
                self.log.cell_errors[number] = error

    def make_calls(self, task: Task) -> tuple[Outcome, ...]:
        """Make the calls of a task; once there is nothing to call, the others are not tried."""
        self.task, self.done = task, []
        for call in task.calls:
            start = time.monotonic()
            head, values = self._ask(*_told(call, task.seconds), task.seconds + GRACE)
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

    def _ended(self) -> Ended:
        if self.ended is None:
            self.ended = self.server.end()
            self.log.processes.append(self.ended)
        return self.ended

    def _ask(
        self, head: dict[str, Any], arrays: tuple[Any, ...], seconds: float
    ) -> tuple[dict[str, Any], list[np.ndarray]]:
        """Send a frame and return the answer.

        Raises
        ------
        Broken
            There is none in time, or what comes is no answer.
        """
        try:
            if not self.ready:
                frames.receive(self.from_it, time.monotonic() + SECONDS_TO_START)
                self.ready = True
            frames.send(self.to_it, head, arrays)
            return frames.receive(self.from_it, time.monotonic() + seconds)
        except frames.Late:
            raise Broken("time", f"it was stopped after {seconds:.0f} seconds") from None
        except frames.BadFrame as error:
            raise Broken("output", f"what it returns cannot be read: {error}") from None
        except (frames.Gone, BrokenPipeError):
            raise _death(self._ended()) from None


def _death(ended: Ended) -> Broken:
    """Return why a process died by itself."""
    names = {9: "memory", 11: "crash", 24: "time", 25: "output", 31: "forbidden", 6: "crash"}
    told = {
        9: "it was ended by the system, as when memory runs out",
        11: "it crashed (segmentation fault)",
        6: "it aborted itself",
        24: "it used up its processor time",
        25: "it wrote a file that is too large",
        31: "it did what is forbidden here",
    }
    if ended.signal:
        sentence = told.get(ended.signal, f"it was ended by signal {ended.signal}")
        return Broken(names.get(ended.signal, "crash"), sentence)
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
    return text if isinstance(text, str) else ""


def _filled(outcomes: Sequence[Outcome], count: int) -> tuple[Outcome, ...]:
    """Repeat the last outcome for the calls that were not tried."""
    return (*outcomes, *[outcomes[-1]] * (count - len(outcomes)))
