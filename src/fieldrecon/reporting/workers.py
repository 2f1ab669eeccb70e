"""What computes for a build: processes, which end at once when the build fails."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from fieldrecon._chunks import Inline
from fieldrecon._processes import Processes


@contextmanager
def workers(count: int) -> Iterator[Executor]:
    """Give processes to compute in, which end at once when the ``with`` is left by an error.

    Parameters
    ----------
    count : int
        How many; 1 computes in this process.
    """
    if count == 1:
        yield Inline()
        return
    pool = Processes(count)
    try:
        yield pool
    except BaseException:
        for child in multiprocessing.active_children():
            child.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
