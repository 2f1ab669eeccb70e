"""The right functions of earlier questions, called with arguments that a submission chooses.

They run on the trusted side in a process of their own, which is ended if a call takes too long or
too much memory. It gets a request as numbers and arrays, and returns arrays.
"""

from __future__ import annotations

import os
import resource
import sys
import time
from collections.abc import Collection, Sequence
from contextlib import suppress
from functools import cache, partial
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from fieldcheck.calls import Call, perform
from fieldgrade.authoring.sources import Source
from fieldgrade.sandbox import confine, frames
from fieldgrade.sandbox.kernel import processes
from fieldrecon._core.worker_processes import start_process

MOST_CALLS = 10_000
"""Calls that an answer may make in all its cases together."""
MOST_BYTES = 1 << 18
"""Size of the arguments of a call."""
MOST_ARGUMENTS = 16
LARGEST_INTEGER = 1 << 53
SECONDS_OF_A_CALL, SECONDS_IN_ALL = 5.0, 60.0
GRACE = 1.0
"""Seconds between the limit of a call, which interrupts it inside, and ending the process."""
MEMORY = 1 << 28
"""Bytes that the process may use beside those of NumPy and the solutions."""
SECONDS_TO_START = 60.0

Reply = tuple[dict[str, Any], tuple[np.ndarray, ...]]
REFUSED: Reply = ({"given": False}, ())


class RightFunctions:
    """Right functions of one notebook, for the calls of one answer.

    Parameters
    ----------
    source : Path
        The source of the notebook.
    names : collection of str
        The functions that may be called.

    Attributes
    ----------
    called : set of str
        The functions that were called.
    seconds : float
        The time that their calls took.
    """

    def __init__(self, source: Path, names: Collection[str]) -> None:
        self.source, self.names = source, names
        self.called = set[str]()
        self.seconds, self._calls = 0.0, 0
        _process.load(source)

    def answer(self, request: dict[str, Any], arrays: Sequence[np.ndarray], late: float) -> Reply:
        """Answer a request from the sandbox, before a time of ``time.monotonic``.

        It is refused if it is not valid, if one of the limits is reached, or if the function raises
        an error.
        """
        name = request.get("asks")
        if not isinstance(name, str) or name not in self.names:
            return REFUSED
        self.called.add(name)
        self._calls += 1
        left = min(SECONDS_OF_A_CALL, SECONDS_IN_ALL - self.seconds, late - time.monotonic())
        if self._calls > MOST_CALLS or left <= 0 or not _is_valid(request, arrays):
            return REFUSED
        start = time.monotonic()
        wanted = {key: request[key] for key in ("asks", "arguments", "named")}
        wanted |= {"source": str(self.source), "seconds": left}
        reply = _process.request(wanted, tuple(arrays), left + GRACE)
        self.seconds += time.monotonic() - start
        if reply is None:  # a new process would take long to start
            self._calls = MOST_CALLS
        return reply or REFUSED


def _is_valid(request: dict[str, Any], arrays: Sequence[np.ndarray]) -> bool:
    """Whether a request describes few numbers and small arrays, each array once."""
    arguments, named = request.get("arguments"), request.get("named")
    if not isinstance(arguments, list) or not isinstance(named, list):
        return False
    if len(named) > len(arguments) or len(arguments) > MOST_ARGUMENTS:
        return False
    if not all(isinstance(name, str) for name in named) or len({*named}) < len(named):
        return False
    if sum(array.nbytes for array in arrays) > MOST_BYTES:
        return False
    used = [a["array"] for a in arguments if isinstance(a, dict) and [*a] == ["array"]]
    numbers = [a["number"] for a in arguments if isinstance(a, dict) and [*a] == ["number"]]
    complete = len(used) + len(numbers) == len(arguments) and used == [*range(len(arrays))]
    return complete and all(map(_is_number, numbers))


def _is_number(value: object) -> bool:
    if type(value) is int:
        return abs(value) <= LARGEST_INTEGER
    return value is None or type(value) in (bool, float)


class _Process:
    """A process that calls the functions of solutions; it is started when it is needed."""

    def __init__(self) -> None:
        self._process: BaseProcess | None = None
        self._lock = Lock()

    def load(self, source: Path) -> None:
        """Have the process read a source, so that this does not take the time of a call.

        Raises
        ------
        RuntimeError
            The process does not start.
        """
        if self.request({"source": str(source)}, (), SECONDS_TO_START) is None:
            raise RuntimeError("the process that computes right values does not start")

    def request(
        self, head: dict[str, Any], arrays: tuple[np.ndarray, ...], seconds: float
    ) -> Reply | None:
        """Return the reply to a request; None if there is none in time, and the process is ended.

        Raises
        ------
        RuntimeError
            The process has ended by itself.
        """
        late = time.monotonic() + seconds
        with self._lock:
            to_it, from_it = self._pipes()
            try:
                frames.send(to_it, head, arrays, late)
                reply, values = frames.receive(from_it, late)
            except frames.FrameTimeout:
                self.end()
                return None
            except (frames.PipeClosed, frames.BadFrame):
                self.end()
                raise RuntimeError("the process that computes right values has ended") from None
        return reply, tuple(values)

    def _pipes(self) -> tuple[int, int]:
        if self._process is None:
            theirs, self._to_it = Pipe(duplex=False)
            self._from_it, to_us = Pipe(duplex=False)
            os.set_blocking(self._to_it.fileno(), False)
            self._process = start_process(serve, theirs, to_us)
            theirs.close()
            to_us.close()
        return self._to_it.fileno(), self._from_it.fileno()

    def end(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.join()
            self._to_it.close()
            self._from_it.close()


_process = _Process()


@cache
def _functions(source: str) -> dict[str, Any]:
    """Return the functions of a source; from then on, memory is limited."""
    _limit_memory(-1)
    functions = Source(Path(source)).functions()
    _limit_memory(confine.address_space() + MEMORY)
    return functions


def _limit_memory(size: int) -> None:
    if sys.platform == "linux":  # macOS does not enforce it
        resource.setrlimit(resource.RLIMIT_AS, (size, resource.RLIM_INFINITY))


def evaluate(functions: dict[str, Any], request: dict[str, Any], arrays: Sequence[Any]) -> Reply:
    """Call a function as a request describes, and return its values.

    Parameters
    ----------
    functions : dict
        The functions of a solution.
    request : dict
        Its name, its arguments as ``{"number": 1.0}`` or ``{"array": 0}``, the names of the last of
        them, and a time limit.
    arrays : sequence of ndarray
        The arrays.
    """
    given = [arrays[a["array"]] if "array" in a else a["number"] for a in request["arguments"]]
    count = len(given) - len(request["named"])
    named = dict(zip(request["named"], given[count:], strict=True))
    call = Call(request["asks"], tuple(given[:count]), "")
    function = partial(functions[call.function], **named)
    (outcome,) = perform({call.function: function}, (call,), request["seconds"])
    return REFUSED if outcome.values is None else ({"given": True}, outcome.values)


def _serve(incoming: int, outgoing: int) -> None:
    """Answer requests until the pipe is closed."""
    with suppress(frames.PipeClosed):
        while True:
            request, arrays = frames.receive(incoming)
            functions = _functions(request["source"])
            reply = evaluate(functions, request, arrays) if "asks" in request else REFUSED
            try:
                frames.send(outgoing, *reply)
            except frames.BadFrame:  # the values are too large
                frames.send(outgoing, *REFUSED)


def serve(incoming: Connection, outgoing: Connection) -> None:
    """Serve two pipes in a process of its own; what a solution prints goes nowhere."""
    os.setsid()  # Ctrl-C is for the grader
    pipes = incoming.fileno(), outgoing.fileno()
    kept = (number for number in (*pipes, processes()) if number is not None)
    confine.close_all_but([*kept])  # a forked process has the pipes of sandboxes, too
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1):
        os.dup2(null, stream)
    threadpool_limits(1)
    _serve(*pipes)
