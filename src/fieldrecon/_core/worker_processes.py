"""Worker processes that leave Ctrl-C to their parent and end with it."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing.context import BaseContext
from multiprocessing.process import BaseProcess
from typing import Any


def available_cores() -> int:
    """Number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def prepare(modules: Sequence[str]) -> None:
    """Begin to import modules for future workers, without waiting for it."""
    if sys.platform == "linux":
        multiprocessing.set_forkserver_preload(list(modules))
    _context()


def _context() -> BaseContext:
    """Start method: on Linux a fork server that has imported what the workers need.

    Elsewhere workers are spawned, since forking a process with NumPy loaded is unsafe.
    """
    if sys.platform == "linux":
        from multiprocessing import forkserver

        with suppress(OSError):  # the path to temporary files may be too long for a socket
            forkserver.ensure_running()
            return multiprocessing.get_context("forkserver")
    return multiprocessing.get_context("spawn")


def start_process(work: Callable[..., object], *arguments: Any) -> BaseProcess:
    """Start a process that calls a function; it does not outlive this one.

    On Linux a worker forks it and shares its memory with it. This is safe since the other threads
    of a worker only wait.
    """
    is_worker = sys.platform == "linux" and multiprocessing.parent_process() is not None
    context: Any = multiprocessing.get_context("fork") if is_worker else _context()
    process: BaseProcess = context.Process(target=work, args=arguments, daemon=True)
    with _ctrl_c_blocked(), warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of Python 3.12, about threads
        process.start()
    return process


def _nothing() -> None:
    """Do nothing."""


class WorkerPool(ProcessPoolExecutor):
    """A pool of fresh processes, started as there is work for them.

    Parameters
    ----------
    count : int
        Maximum number of processes.
    begin : callable
        Called first in each process.
    end : callable
        Called in a process when its parent has ended, before it ends itself.
    context : BaseContext, optional
        Start method; by default a fork server on Linux, and spawning elsewhere.
    """

    def __init__(
        self,
        count: int,
        begin: Callable[[], object] = _nothing,
        end: Callable[[], object] = _nothing,
        context: BaseContext | None = None,
    ) -> None:
        super().__init__(
            count, mp_context=context or _context(), initializer=_begin, initargs=(begin, end)
        )

    def submit(self, fn: Callable, /, *args: Any, **kwargs: Any) -> Future:
        """Submit a call; a process started for it has Ctrl-C blocked until it is ready."""
        with _ctrl_c_blocked():
            return super().submit(fn, *args, **kwargs)


@contextmanager
def _ctrl_c_blocked() -> Iterator[None]:
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin(begin: Callable[[], object], end: Callable[[], object]) -> None:
    # programs started by a worker must receive Ctrl-C: exec resets a handler, but keeps a mask
    signal.signal(signal.SIGINT, lambda *_: None)
    if sys.platform != "win32":
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    threading.Thread(target=_end_with_parent, args=(end,), daemon=True).start()
    begin()


def _end_with_parent(end: Callable[[], object]) -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        end()
        os._exit(1)
