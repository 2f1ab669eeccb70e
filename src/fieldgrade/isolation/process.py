"""A sandboxed process as the grader sees it: requests and answers.

A student's code runs in the process and can reach the pipe through which it answers. Everything
that comes from the pipe is therefore validated.
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
"""Seconds between the limit of a call, which interrupts it inside, and the killing from outside."""
MOST_STRAYS = 100
"""How many frames with a wrong number are ignored."""
MOST_TEXT = 2000
"""Characters of a text from the sandbox."""

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
