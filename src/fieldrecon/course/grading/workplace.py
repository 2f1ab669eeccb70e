"""One started server for each thread or process that grades, whatever pool it belongs to."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from multiprocessing import util
from typing import TypeVar

from fieldrecon.course.grading.examine import Fault
from fieldrecon.course.grading.isolation import Limits, Server, Tier

T = TypeVar("T")


class _Workplace(threading.local):
    """What a thread holds; a forked process inherits the memory of it, but not the server."""

    server: Server | None = None
    process: int = 0
    stack: ExitStack | None = None


_here = _Workplace()
_open: dict[int, list[ExitStack]] = {}
_lock = threading.Lock()
_over = threading.Event()


class Over(Exception):
    """The work is over, and no server is started any more."""


def served(tier: Tier, limits: Limits, do: Callable[[Server], T]) -> T:
    """Return what comes of doing something with a server; where it fails, with a fresh one.

    Raises
    ------
    Fault
        It fails again: the grader is at fault, not the submission.
    """
    for last in (False, True):
        try:
            return do(server(tier, limits))
        except (Fault, Over):
            raise
        except Exception as error:
            dismiss()
            if last or _over.is_set():
                raise Fault(f"{type(error).__name__}: {error}") from error
    raise AssertionError


def server(tier: Tier, limits: Limits) -> Server:
    """Return the server of this thread, started if need be.

    Raises
    ------
    Over
        The block in which the work was to be done has ended.
    """
    held = _here.server
    if held and _here.process == os.getpid() and (held.tier, held.limits) == (tier, limits):
        return held
    if _over.is_set():
        raise Over
    dismiss()
    stack = ExitStack()
    _here.server = stack.enter_context(Server(tier, limits).started())
    _here.process, _here.stack = os.getpid(), stack
    with _lock:
        if os.getpid() not in _open:
            _open[os.getpid()] = []
            util.Finalize(None, close, exitpriority=10)  # processes of a pool run no atexit
        _open[os.getpid()].append(stack)
    return _here.server


def dismiss() -> None:
    """End the server of this thread: it is in doubt, and the next one is fresh."""
    stack, _here.server, _here.stack = _here.stack, None, None
    if stack and _here.process == os.getpid():
        with _lock:
            if stack in (known := _open.get(os.getpid(), [])):
                known.remove(stack)
        with suppress(Exception):
            stack.close()


def close() -> None:
    """End all servers of this process."""
    with _lock:
        stacks = _open.pop(os.getpid(), [])
    for stack in stacks:
        with suppress(Exception):
            stack.close()
    _here.server = _here.stack = None


@contextmanager
def opened() -> Iterator[None]:
    """Let servers be started in this block, and end all of this process with it."""
    _over.clear()
    try:
        yield
    finally:
        _over.set()
        close()
