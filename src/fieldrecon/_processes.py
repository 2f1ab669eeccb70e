"""Processes that leave Ctrl-C to their parent, and do not outlive it."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import forkserver
from typing import Any

METHOD = "forkserver" if sys.platform == "linux" else "spawn"
"""How processes come into being. Elsewhere a process with NumPy loaded is better not forked."""


def prepare(modules: Sequence[str]) -> None:
    """Begin to import modules for the processes to come; this does not wait for it."""
    if METHOD == "forkserver":
        multiprocessing.get_context(METHOD).set_forkserver_preload(list(modules))
        forkserver.ensure_running()


def _nothing() -> None:
    """Do it."""


class Processes(ProcessPoolExecutor):
    """Fresh processes, started as there is work for them.

    Parameters
    ----------
    count : int
        How many at most.
    begin : callable
        What each does first.
    end : callable
        What it does when its parent is no more, before it ends itself.
    """

    def __init__(
        self,
        count: int,
        begin: Callable[[], object] = _nothing,
        end: Callable[[], object] = _nothing,
    ) -> None:
        context = multiprocessing.get_context(METHOD)
        super().__init__(count, mp_context=context, initializer=_begin, initargs=(begin, end))

    def submit(self, fn: Callable, /, *args: Any, **kwargs: Any) -> Future:
        """Have a function called; what is started for it has Ctrl-C blocked until it is ready."""
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            return super().submit(fn, *args, **kwargs)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin(begin: Callable[[], object], end: Callable[[], object]) -> None:
    # what is started from here is to know Ctrl-C again: a handler ends with exec, a mask does not
    signal.signal(signal.SIGINT, lambda *_: None)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    threading.Thread(target=_end_with_parent, args=(end,), daemon=True).start()
    begin()


def _end_with_parent(end: Callable[[], object]) -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        end()
        os._exit(1)
