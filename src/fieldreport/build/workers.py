"""Workers of a build: processes with pinned kernels, terminated when the build fails."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from typing import Any

from fieldrecon._core.worker_processes import WorkerPool
from fieldreport.build import pinned_kernels


class PinnedProcesses(WorkerPool):
    """Processes whose OpenBLAS and NumPy use the pinned kernels in every environment of the caller.

    They are spawned: a fork server would keep the environment in which it was started.

    Parameters
    ----------
    count : int
        The largest number of processes.
    """

    def __init__(self, count: int) -> None:
        super().__init__(count, context=multiprocessing.get_context("spawn"))
        self._pins = pinned_kernels.pins()

    def submit(self, fn: Callable, /, *args: Any, **kwargs: Any) -> Future:
        """Submit a call; a process is started if none is free."""
        with pinned_kernels.environment(self._pins):
            return super().submit(pinned_kernels.run_pinned, self._pins, fn, *args, **kwargs)


@contextmanager
def workers(count: int) -> Iterator[Executor]:
    """Yield an executor whose processes are terminated if an error leaves the ``with``.

    Parameters
    ----------
    count : int
        The number of processes.
    """
    pool = PinnedProcesses(count)
    try:
        yield pool
    except BaseException:
        for child in multiprocessing.active_children():
            child.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
