"""One started sandbox server for each thread or process that grades, in any pool."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from multiprocessing import Pipe, get_context, util
from multiprocessing.connection import Connection
from multiprocessing.queues import SimpleQueue
from tempfile import gettempdir
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

from fieldgrade.isolation import scratch
from fieldgrade.isolation.process import NotStarted
from fieldgrade.isolation.server import GraderError, Limits, MachineFailed, Server, Tier
from fieldgrade.sandbox import homes
from fieldrecon._core.worker_processes import WorkerPool

T = TypeVar("T")


class _Held(threading.local):
    """The server of a thread; a forked process inherits the memory, but not the server."""

    server: Server | None = None
    process: int = 0
    stack: ExitStack | None = None


_here = _Held()
_open: dict[int, list[ExitStack]] = {}
_lock = threading.Lock()
_over = threading.Event()


class WorkEnded(Exception):
    """The grading has ended, and no server is started any more."""


def with_server(tier: Tier, limits: Limits, do: Callable[[Server], T]) -> T:
    """Call a function with a server; if it fails, call it again with a new server.

    Raises
    ------
    GraderError
        It fails again: the grader is at fault, not the submission.
    """
    for last in (False, True):
        try:
            return do(server(tier, limits))
        except (GraderError, WorkEnded):
            raise
        except Exception as error:
            dismiss()
            if last or _over.is_set():
                raise GraderError(_sentence(error)) from error
    raise AssertionError


def _sentence(error: Exception) -> str:
    """Return an error in words; that of a full disk does not always name the folder."""
    told = isinstance(error, MachineFailed | NotStarted)
    words = str(error) if told else f"{type(error).__name__}: {error}"
    lack = "" if "is full" in words else homes.lacking(gettempdir())
    return f"{words} ({lack})" if lack else words


def server(tier: Tier, limits: Limits) -> Server:
    """Return the server of this thread, started if need be.

    Raises
    ------
    WorkEnded
        The block in which the work was to be done has ended.
    """
    held = _here.server
    if held and _here.process == os.getpid() and (held.tier, held.limits) == (tier, limits):
        return held
    dismiss()
    with _lock:  # a server that is being started is seen by `close`
        if _over.is_set():
            raise WorkEnded
        stack = ExitStack()
        _here.server = stack.enter_context(Server(tier, limits).started())
        _here.process, _here.stack = os.getpid(), stack
        if os.getpid() not in _open:
            _open[os.getpid()] = []
            util.Finalize(None, close, exitpriority=10)  # processes of a pool do not run atexit
        _open[os.getpid()].append(stack)
    return _here.server


def dismiss() -> None:
    """End the server of this thread, which may be broken."""
    stack, _here.server, _here.stack = _here.stack, None, None
    if stack and _here.process == os.getpid():
        with _lock:
            if stack in (known := _open.get(os.getpid(), [])):
                known.remove(stack)
        with suppress(Exception):
            stack.close()


def close() -> None:
    """End all servers of this process; concurrent callers wait until they have ended."""
    with _lock:
        for stack in _open.pop(os.getpid(), []):
            with suppress(Exception):
                stack.close()
    _here.server = _here.stack = None


@contextmanager
def serving() -> Iterator[None]:
    """Permit servers in this block; at its end, end all servers of this process.

    At first the folders that killed graders left behind are removed.
    """
    _over.clear()
    scratch.remove_abandoned()
    try:
        yield
    finally:
        _over.set()
        close()


@contextmanager
def worker_pool(count: int) -> Iterator[Executor]:
    """Give an executor: a thread for one worker, else a process for each, with its own server.

    Threads would compete for the interpreter. Unfinished work is abandoned at the end of the block:
    by processes at once, by the thread at the end of the surrounding block of `serving`.
    """
    if count == 1:
        thread = ThreadPoolExecutor(1, "grading")
        try:
            yield thread
        finally:
            thread.shutdown(wait=False, cancel_futures=True)
        return
    with _processes(count) as processes:
        yield processes


@contextmanager
def _processes(count: int) -> Iterator[Executor]:
    over, block = Pipe(duplex=False)

    def start() -> WorkerPool:
        begin = partial(_begin, over, _cores_for_each(count))
        return WorkerPool(count, begin=begin, end=close)

    processes = _Replaced(start)
    try:
        yield processes
    finally:
        block.close()
        processes.shutdown(cancel_futures=True)
        over.close()


def run_alone(do: Callable[..., T], *arguments: Any) -> T:
    """Call a function in a worker process of its own, after the process that ran it was lost.

    Raises
    ------
    GraderError
        This process is lost too.
    """
    with _processes(1) as processes:
        try:
            return processes.submit(do, *arguments).result()
        except BrokenExecutor:
            lost = "the system killed the process that graded it, twice, as when memory runs out"
            raise GraderError(lost) from None


class _Replaced(Executor):
    """A pool of processes that is replaced after one of them was lost."""

    def __init__(self, start: Callable[[], WorkerPool]) -> None:
        self._start = start
        self._pool = start()

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Submit a call; if it fails with `BrokenExecutor`, the next one goes to a new pool."""
        try:
            return self._pool.submit(fn, *args, **kwargs)
        except BrokenExecutor:
            self._pool.shutdown(cancel_futures=True)
            self._pool = self._start()
            return self._pool.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes."""
        self._pool.shutdown(wait, cancel_futures=cancel_futures)


def _cores_for_each(count: int) -> SimpleQueue[int] | None:
    """Return a core for each worker if their numbers agree; otherwise the system assigns them.

    A worker and its sandboxed process alternate. On two cores each answer would have to wake a
    sleeping core.
    """
    free = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []
    if len(free) != count:
        return None
    cores: SimpleQueue[int] = get_context("spawn").SimpleQueue()
    for core in free:
        cores.put(core)
    return cores


def _begin(over: Connection, cores: SimpleQueue[int] | None) -> None:
    """Bind to a core; end the servers of this process when the other end of the pipe is closed."""

    def watch() -> None:
        with suppress(EOFError, OSError):
            over.recv_bytes()
        _over.set()
        close()

    if cores:
        os.sched_setaffinity(0, {cores.get()})
    threadpool_limits(1)
    threading.Thread(target=watch, daemon=True).start()
