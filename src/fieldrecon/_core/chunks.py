"""Evaluation in chunks: bounded memory, threads by default, the same result on any machine."""

from __future__ import annotations

import pickle
import tempfile
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import numpy as np

from fieldrecon._core.blas_threads import one_blas_thread
from fieldrecon._core.worker_processes import available_cores

Progress = Callable[[int, int], object]
Stages: TypeAlias = Callable[[str], Progress]
"""Opens a stage of the work by its name, and returns the progress of the stage."""
Result = TypeVar("Result")

CHUNK_BYTES = 2**24
"""Working memory of one chunk, in bytes; it never depends on the number of cores."""

_AHEAD = 8  # chunks submitted at once: bounds the memory for any executor


def rows_of(bytes_per_row: float) -> int:
    """Rows of a chunk whose working memory is CHUNK_BYTES, at least one."""
    return max(1, int(CHUNK_BYTES // max(bytes_per_row, 1)))


def chunked(
    work: Callable[[np.ndarray], Result],
    x: np.ndarray,
    rows: int,
    executor: Executor | None = None,
    progress: Progress | None = None,
    order: np.ndarray | None = None,
) -> Iterator[tuple[slice, Result]]:
    """Yield each slice of rows of `x` with work(x[slice]), in order.

    With an order (m,) of the rows, it is work(x[order[slice]]).

    The chunks run on `executor` (a pool of threads if None); `progress(done, total)` is called
    after each. An exception or an interrupt cancels the chunks that have not begun. `work` may
    hold millions of sites: processes of a pool read it once, not with every chunk.
    """
    slices = [slice(i, min(i + rows, len(x))) for i in range(0, len(x), rows)]
    pool: AbstractContextManager[Executor] = (
        nullcontext(executor) if executor else _threads(len(slices))
    )
    pending: deque[tuple[slice, Future[Result]]] = deque()
    done, ahead = 0, iter(slices)
    with pool as workers, _shared_work(partial(_on_one_thread, work), executor) as work_there:
        try:
            while True:
                while len(pending) < _AHEAD and (s := next(ahead, None)) is not None:
                    part = x[s if order is None else order[s]]
                    pending.append((s, workers.submit(work_there, part)))
                if not pending:
                    return
                s, future = pending.popleft()
                result = future.result()
                done += s.stop - s.start
                if progress is not None:
                    progress(done, len(x))
                yield s, result
        finally:
            for _, future in pending:
                future.cancel()


def report_all(progress: Progress | None, total: int) -> None:
    """Report that all of the work is done, where it is not split."""
    if progress is not None:
        progress(total, total)


def progress_after(progress: Progress | None, before: int, total: int) -> Progress | None:
    """Return the progress of a part of `total` things, of which `before` are done already."""
    return progress and partial(_part_progress, progress, before, total)


def _part_progress(progress: Progress, before: int, total: int, done: int, _: int) -> None:
    progress(before + done, total)


def split_progress(progress: Progress | None, total: int, number: int) -> Iterator[Progress | None]:
    """Yield a progress callable for each of `number` passes over `total` things."""
    for before in range(number):
        yield progress and partial(_pass_progress, progress, total, before, number)


def _pass_progress(
    progress: Progress, total: int, before: int, number: int, done: int, of: int
) -> None:
    progress(total * (before * of + done) // (number * of), total)


def _on_one_thread(work: Callable[[np.ndarray], Result], x: np.ndarray) -> Result:
    """Work on a chunk with one BLAS thread: the chunks already share the cores."""
    with one_blas_thread():
        return work(x)


@contextmanager
def _shared_work(
    work: Callable[[np.ndarray], Result], executor: Executor | None
) -> Iterator[Callable[[np.ndarray], Result]]:
    """Yield the work for threads as it is, for processes as a file that is deleted at the end.

    An executor that shares work in its own way has a method `shared_work`.
    """
    shared_work = getattr(executor, "shared_work", None)
    if shared_work is not None:
        with shared_work(work) as held:
            yield held
        return
    if not isinstance(executor, ProcessPoolExecutor):
        yield work
        return
    with tempfile.TemporaryDirectory(prefix="fieldrecon-") as folder:
        file = Path(folder) / "work.pickle"
        file.write_bytes(pickle.dumps(work, protocol=pickle.HIGHEST_PROTOCOL))
        yield partial(_do, file)


def _do(file: Path, x: np.ndarray) -> Any:
    return _read(file)(x)


@lru_cache(maxsize=1)
def _read(file: Path) -> Callable[[np.ndarray], Any]:
    work: Callable[[np.ndarray], Any] = pickle.loads(file.read_bytes())
    return work


class Inline(Executor):
    """An executor that runs each call at once in the calling thread."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except BaseException as error:
            future.set_exception(error)
        return future


def _threads(chunks: int) -> Executor:
    workers = min(chunks, available_cores())
    return Inline() if workers <= 1 else ThreadPoolExecutor(workers)


def silent(_name: str) -> Progress:
    """Open a stage that nobody sees."""
    return lambda *_: None
