"""A process of a submission: the code it runs, requests to it, and its answers, validated.

Deadlines are enforced here by killing the process, since code in the sandbox can refuse to be
interrupted. A student's code can reach the pipe through which its process answers, so everything
that comes from the pipe is validated.
"""

from __future__ import annotations

import os
import secrets
import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldcheck.calls import Call, Outcome
from fieldgrade.authoring.right_functions import RightFunctions
from fieldgrade.isolation.server import MachineFailed, ProcessEnd, Server
from fieldgrade.sandbox import frames
from fieldgrade.sandbox.missing import NOTHING, validated
from fieldgrade.sandbox.statements import MOST_REPORTED

SECONDS_TO_START = 20.0
GRACE = 1.0
"""Seconds between the limit of a call, which interrupts it inside, and killing its process."""
MOST_STRAYS = 100
"""How many frames with a wrong number are ignored."""
MOST_TEXT = 2000
"""Characters of a text from the sandbox."""
MOST_SOURCE = 200
"""Characters of a line of code that are shown."""

TOO_LARGE = "what it returns is too large"
STATUSES = ("returned", "raised", "unwritten", "missing", "timed out")


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
        self.statement = self.line = 0
        self.missing = NOTHING
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
            sentence = f"no process starts in the sandbox ({self.server.tier})"
            reason = self._ended().machine
            raise NotStarted(f"{sentence}: {reason}" if reason else sentence) from None

    def load(self, program: Program, asked: Collection[str]) -> list[str]:
        """Send the code and the files, and return the names of files that are not used."""
        cells = [cell.encode("utf-8", "surrogatepass") for cell in program.cells]
        files = dict(program.files)
        sizes = {
            "cells": [len(cell) for cell in cells],
            "files": [[name, len(content)] for name, content in files.items()],
            "asked": sorted(asked),
        }
        content = b"".join([*cells, *files.values()])
        words = np.frombuffer(content + bytes(8 - len(content) % 8), "<u8")  # frames widen bytes
        head, _ = self._request({"load": sizes}, (words,), self.server.limits.seconds_per_cell)
        unused = head.get("unused")
        return [name for name in files if isinstance(unused, list) and name in unused]

    def keep_needed(self, left_out: Collection[int]) -> None:
        """Let the cells run only what the definitions of the answers need."""
        head = {"needed": True, "left_out": [*left_out]}
        self._request(head, (), self.server.limits.seconds_per_cell)

    def cell(self, number: int, left_out: Collection[int]) -> dict[str, Any]:
        """Run a cell without some of its statements, and return what it reports."""
        self.statement = self.line = 0
        head, _ = self._request(
            {"cell": number, "left_out": [*left_out]}, (), self.server.limits.seconds_per_cell
        )
        return head

    def call(self, call: Call, seconds: float, given: RightFunctions | None = None) -> Outcome:
        """Make a call with a time limit in seconds, and return its outcome.

        It may call the given functions of earlier questions; computing their values is not part of
        its run time. What it misses is added to `missing`.
        """
        seconds = min(seconds, self.server.limits.seconds_per_call)
        start, before = time.monotonic(), given.seconds if given else 0.0
        head, values = self._request(*_call_frame(call, seconds, given), seconds + GRACE, given)
        self.missing |= validated(head.get("missing"))
        computing = given.seconds - before if given else 0.0
        return _outcome(head, values, time.monotonic() - start - computing)

    def check_limits(self) -> None:
        """Notice now what the server would notice a moment later, when innocent code runs.

        Raises
        ------
        ProcessFailed
            The process has too many threads, or has written too much.
        """
        if self.server.exceeds_a_limit():
            raise _death(self.end(), self.server.limits.cpu_seconds)

    def end(self, patiently: bool = False) -> ProcessEnd:
        """End the process, and return how it ended.

        Raises
        ------
        MachineFailed
            The machine failed meanwhile, so that what the process did may be wrong.
        """
        known = self.ended
        ended = self._ended(patiently)
        if known is None and (sentence := ended.machine or self._killed_by_the_system(ended)):
            raise MachineFailed(sentence)
        return ended

    def _ended(self, patiently: bool = False) -> ProcessEnd:
        if self.ended is None:
            self.ended = self.server.end(patiently)
            os.close(self.to_it)
            os.close(self.from_it)
        return self.ended

    def _killed_by_the_system(self, ended: ProcessEnd) -> str:
        """Return a sentence if the system killed the process; empty if it may have done it itself.

        A process in a sandbox cannot send itself this signal.
        """
        alone = not ended.killed and not ended.ended_for and self.server.tier != "none"
        if not alone or ended.signal != 9 or ended.cpu_seconds >= self.server.limits.cpu_seconds:
            return ""
        return "the system killed a process of the sandbox, as it does when memory runs out"

    def _request(
        self,
        head: dict[str, Any],
        arrays: tuple[Any, ...],
        seconds: float,
        given: RightFunctions | None = None,
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
        strays = 0
        try:
            frames.send(self.to_it, head | {"frame": number}, arrays, late)
            while strays < MOST_STRAYS:
                answer, values = frames.receive(self.from_it, late)
                if answer.get("frame") != number:
                    strays += 1
                elif "cell" in head and self._has_begun(answer):
                    late = min(time.monotonic() + seconds, self.last)
                elif given and "asks" in answer:
                    reply, found = given.answer(answer, values, late)
                    frames.send(self.to_it, reply | {"frame": number}, found, late)
                else:
                    return answer, values
        except frames.FrameTimeout:
            raise ProcessFailed("time", f"it was stopped after {seconds:.3g} seconds") from None
        except frames.BadFrame as error:
            raise ProcessFailed("output", f"no answer is available: {error}") from None
        except frames.PipeClosed:
            limit = self.server.limits.cpu_seconds
            raise _death(self.end(patiently=True), limit) from None
        raise ProcessFailed("output", "it sends answers to other requests")

    def _has_begun(self, answer: dict[str, Any]) -> bool:
        """Whether an answer reports that another statement of a cell begins; note which."""
        statement = answer.get("statement")
        if not isinstance(statement, int) or not self.statement <= statement < MOST_REPORTED:
            return False
        self.statement, self.line = statement + 1, as_number(answer.get("line"))
        return True


def _death(ended: ProcessEnd, cpu_seconds: float) -> ProcessFailed:
    """Return the reason why a process ended by itself."""
    watched = {
        "threads": "it started too many threads",
        "disk": "it wrote too much",
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
        return ProcessFailed(ended.ended_for, watched.get(ended.ended_for, ended.ended_for))
    if ended.killed:
        return ProcessFailed("output", "it closed the pipe through which it answers")
    if ended.signal == 9 and ended.cpu_seconds >= cpu_seconds:
        return ProcessFailed(*signals[24])
    if ended.signal:
        unknown = f"it was ended by signal {ended.signal}"
        return ProcessFailed(*signals.get(ended.signal, ("crash", unknown)))
    return ProcessFailed("exit", f"it ended the program (exit status {ended.exit})")


def _call_frame(
    call: Call, seconds: float, given: RightFunctions | None
) -> tuple[dict[str, Any], tuple[Any, ...]]:
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
        "given": sorted(given.names) if given else [],
    }
    return head, arrays


def _outcome(head: dict[str, Any], values: list[np.ndarray], seconds: float) -> Outcome:
    """Return the outcome in an answer, validated; the time is measured here."""
    status, modified = head.get("status"), head.get("modified")
    if status == "too large":
        return Outcome("raised", error=TOO_LARGE)
    if status not in STATUSES:
        return Outcome("raised", error="what it returns cannot be read")
    return Outcome(
        status,
        values=tuple(values) if head.get("numbers") is True else None,
        returned=as_text(head.get("returned")),
        error=as_text(head.get("error")),
        line=as_text(head.get("line")),
        seconds=seconds,
        modified=tuple(int(i) for i in modified if isinstance(i, int))
        if isinstance(modified, list)
        else (),
    )


def as_text(text: object) -> str:
    """Return a text, validated: short, and without control characters."""
    words = text[:MOST_TEXT] if isinstance(text, str) else ""
    return "".join(c if c.isprintable() or c == "\n" else "\ufffd" for c in words)


def as_number(number: object) -> int:
    """Return a number, validated; neither True nor False is one."""
    return number if type(number) is int and 0 <= number < 1 << 30 else 0


@dataclass(frozen=True)
class CellError:
    """The first error of a cell.

    Parameters
    ----------
    cell : int
        The number of the code cell, from 1.
    error : str
        Type and message of the error, or why the cell was stopped.
    line : int
        The line of the cell; 0 if unknown.
    source : str
        The code in this line.
    """

    cell: int
    error: str
    line: int = 0
    source: str = ""

    def __str__(self) -> str:
        source = f" ({self.source})" if self.source else ""
        line = f", line {self.line}{source}" if self.line else ""
        return f"code cell {self.cell}{line}: {self.error}"


@dataclass(frozen=True)
class Program:
    """The code of a submission.

    Parameters
    ----------
    cells : sequence of str
        The code cells, in order.
    files : sequence of (str, bytes)
        The files that were submitted beside it, by their paths; its code can import them.
    """

    cells: Sequence[str]
    files: Sequence[tuple[str, bytes]] = ()

    def error(self, number: int, line: int, text: str) -> CellError:
        """Return an error in a line of a cell."""
        lines = self.cells[number].split("\n")
        source = lines[line - 1].strip() if 0 < line <= len(lines) else ""
        return CellError(number + 1, text, line, as_text(source)[:MOST_SOURCE])
