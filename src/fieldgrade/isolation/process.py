"""A process behind the walls as it is seen from here: what it is asked, and what it answers.

A student's code runs in it, and can reach the pipe through which it answers. So whatever comes is
data to be doubted, and to answer in time is all that it is trusted to do.
"""

from __future__ import annotations

import os
import secrets
import time
from typing import Any

import numpy as np

from fieldcheck.calls import Call, Outcome
from fieldgrade.isolation.server import ProcessEnd, Server
from fieldgrade.sandbox import frames

SECONDS_TO_START = 20.0
GRACE = 1.0
"""A call ends itself after its limit where it can; so much later it is ended from here."""
MOST_STRAYS = 100
"""So many frames that answer something else are overlooked."""
MOST_TEXT = 2000
"""Characters of what a student's side tells in words."""

STATUSES = ("returned", "raised", "unwritten", "missing", "timed out")


class ProcessFailed(Exception):
    """The process is of no more use; the reason in a word, and in a sentence."""

    def __init__(self, reason: str, sentence: str) -> None:
        super().__init__(sentence)
        self.reason = reason


class NotStarted(RuntimeError):
    """No process comes into being, or it cannot lock itself in."""


class Process:
    """A process of a submission, from its start to its end.

    Parameters
    ----------
    server : Server
        A started server, which makes it.
    last : float
        The time of ``time.monotonic`` after which it is asked nothing.
    """

    def __init__(self, server: Server, last: float) -> None:
        self.server, self.last = server, last
        self.ended: ProcessEnd | None = None
        self.to_it, self.from_it = server.run()

    def await_start(self) -> None:
        """Wait for what comes before any code of a student's has run.

        Raises
        ------
        NotStarted
            It does not come.
        """
        try:
            frames.receive(self.from_it, time.monotonic() + SECONDS_TO_START)
        except (frames.FrameTimeout, frames.BadFrame, frames.PipeClosed):
            raise NotStarted(f"no process starts behind {self.server.tier}") from None

    def cell(self, number: int, code: str) -> str:
        """Run a cell, and return its error, or nothing."""
        seconds = self.server.limits.seconds_per_cell
        head, _ = self._ask({"cell": number, "code": code}, (), seconds)
        return _text(head.get("error"))

    def call(self, call: Call, seconds: float) -> Outcome:
        """Make a call within so many seconds, and return what came of it."""
        seconds = min(seconds, self.server.limits.seconds_per_call)
        start = time.monotonic()
        head, values = self._ask(*_told(call, seconds), seconds + GRACE)
        return _outcome(head, values, time.monotonic() - start)

    def end(self, patiently: bool = False) -> ProcessEnd:
        """End the process, and return how it ended."""
        if self.ended is None:
            self.ended = self.server.end(patiently)
            os.close(self.to_it)
            os.close(self.from_it)
        return self.ended

    def _ask(
        self, head: dict[str, Any], arrays: tuple[Any, ...], seconds: float
    ) -> tuple[dict[str, Any], list[np.ndarray]]:
        """Send a frame and return the answer, which bears its number.

        A student's code can find the pipe and write to it. The number is drawn, so that no answer
        can be given to what was not asked yet, nor one too many be taken for the next.

        Raises
        ------
        ProcessFailed
            There is none in time, or what comes is no answer.
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
            raise ProcessFailed("output", f"no answer can be had: {error}") from None
        except frames.PipeClosed:
            limit = self.server.limits.cpu_seconds
            raise _death(self.end(patiently=True), limit) from None
        raise ProcessFailed("output", "it answers what was not asked")


def _death(ended: ProcessEnd, cpu_seconds: float) -> ProcessFailed:
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
        return ProcessFailed(reason, watched.get(ended.ended_for, ended.ended_for))
    if ended.killed:
        return ProcessFailed("output", "it closed the pipe through which it answers")
    if ended.signal == 9 and ended.cpu_seconds >= cpu_seconds:
        return ProcessFailed(*signals[24])
    if ended.signal:
        told = f"it was ended by signal {ended.signal}"
        return ProcessFailed(*signals.get(ended.signal, ("crash", told)))
    return ProcessFailed("exit", f"it ended the program (exit status {ended.exit})")


def _told(call: Call, seconds: float) -> tuple[dict[str, Any], tuple[Any, ...]]:
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
        modified=tuple(int(i) for i in modified if isinstance(i, int))
        if isinstance(modified, list)
        else (),
    )


def _text(text: object) -> str:
    """Return words as far as they are some: short, and nothing that steers a terminal."""
    words = text[:MOST_TEXT] if isinstance(text, str) else ""
    return "".join(c if c.isprintable() or c == "\n" else "\ufffd" for c in words)
