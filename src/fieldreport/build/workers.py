"""What computes for a build: pinned processes, which end at once when the build fails."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from typing import Any

from fieldrecon._core.worker_processes import WorkerPool
from fieldreport.build import pinned_kernels


class PinnedProcesses(WorkerPool):
    """Processes whose OpenBLAS and NumPy obey the pins, whatever the caller's environment says.

    A process of the server that others are forked from would have the environment of its start.

    Parameters
    ----------
    count : int
        How many at most.
    """

    def __init__(self, count: int) -> None:
        super().__init__(count, context=multiprocessing.get_context("spawn"))
        self._pins = pinned_kernels.pins()

    def submit(self, fn: Callable, /, *args: Any, **kwargs: Any) -> Future:
        """Have a function called, in a process that is started now if none is free."""
        with pinned_kernels.environment(self._pins):
            return super().submit(pinned_kernels.run_pinned, self._pins, fn, *args, **kwargs)


@contextmanager
def workers(count: int) -> Iterator[Executor]:
    """Give processes to compute in, which end at once when the ``with`` is left by an error.

    Parameters
    ----------
    count : int
        How many.
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
