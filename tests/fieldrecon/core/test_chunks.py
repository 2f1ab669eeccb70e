"""Chunked evaluation: order, bounded memory, executors, errors and interrupts."""

import multiprocessing
import os
import tempfile
import threading
import tracemalloc
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from fieldrecon._core import chunks as _chunks
from fieldrecon._core.chunks import chunked, progress_after, rows_of, split_progress
from fieldrecon.datasets.synthetic import halton
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.functionals import values_at
from fieldrecon.methods.hermite import HermiteRBF
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.mean import Mean
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.reconstruction import Reconstruction

X = np.arange(20.0).reshape(10, 2)


def double(x: np.ndarray) -> np.ndarray:
    return 2 * x


@pytest.mark.parametrize("rows", [1, 3, 10, 11])
def test_chunks_cover_the_rows_in_order(rows):
    """The slices are consecutive and cover each row once."""
    parts = list(chunked(double, X, rows))
    assert [s.start for s, _ in parts] == list(range(0, 10, rows))
    np.testing.assert_array_equal(np.concatenate([r for _, r in parts]), 2 * X)


@pytest.mark.parametrize("rows", [1, 3, 11])
def test_chunks_follow_an_order(rows):
    """A slice of the order has the results of the rows that it names."""
    order = np.roll(np.arange(10)[::-1], 4)
    result = np.empty_like(X)
    for part, values in chunked(double, X, rows, order=order):
        result[order[part]] = values
    np.testing.assert_array_equal(result, 2 * X)


def test_zero_rows_give_zero_chunks():
    """The work function is not called."""
    assert list(chunked(double, X[:0], 3)) == []


def test_rows_per_chunk_follow_from_the_bytes_per_row():
    """A chunk has CHUNK_BYTES in total and at least one row, whatever the number of cores."""
    assert rows_of(1024) == _chunks.CHUNK_BYTES // 1024
    assert rows_of(1e30) == 1
    assert rows_of(0) == _chunks.CHUNK_BYTES


@pytest.mark.parametrize("cores", [1, 2, 64])
def test_chunks_do_not_depend_on_the_number_of_cores(cores, monkeypatch):
    """Therefore results are the same on every machine."""
    sizes = []

    def note(x):
        sizes.append(len(x))
        return x

    affinity = set(range(cores))
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: affinity, raising=False)
    list(chunked(note, X, 3))
    assert sorted(sizes) == [1, 3, 3, 3]


def test_progress_is_reported_after_each_chunk():
    """`progress` receives the number of finished rows and the number of all rows."""
    calls = []
    list(chunked(double, X, 4, progress=lambda *call: calls.append(call)))
    assert calls == [(4, 10), (8, 10), (10, 10)]


def test_the_progress_of_a_part_begins_where_the_others_end():
    """A part knows its own things only; the caller hears of all of them."""
    calls = []
    part = progress_after(lambda *call: calls.append(call), 30, 100)
    for done in (5, 20):
        part(done, 20)
    assert calls == [(35, 100), (50, 100)]
    assert progress_after(None, 30, 100) is None


@pytest.mark.parametrize("number", [1, 2, 3])
def test_the_progress_of_several_passes_goes_once_from_nothing_to_all(number):
    """Each of them has an equal share, in whatever units it reports."""
    calls = []
    passes = split_progress(lambda *call: calls.append(call), 600, number)
    for k, progress in enumerate(passes):
        for done in range(0, 8, 2):
            progress(done + 1, 7)
            assert calls[-1] == (600 * (k + (done + 1) / 7) // number, 600)
    assert calls[-1] == (600, 600)
    assert list(split_progress(None, 600, number)) == [None] * number


class Counting(ThreadPoolExecutor):
    """An executor that counts the tasks that are waiting or running."""

    def __init__(self):
        super().__init__(1)
        self.open, self.most = 0, 0

    def submit(self, fn, /, *args, **kwargs) -> Future:
        self.open += 1
        self.most = max(self.most, self.open)
        return super().submit(fn, *args, **kwargs)


def test_the_number_of_pending_chunks_is_bounded():
    """Memory stays bounded, even if the executor is fast and the consumer slow."""
    with Counting() as executor:
        for _ in chunked(double, np.zeros((1000, 2)), 1, executor):
            executor.open -= 1
    assert executor.most <= _chunks._AHEAD


def test_a_given_executor_stays_open():
    """The executor belongs to the caller, so `chunked` must not shut it down."""
    with ThreadPoolExecutor(1) as executor:
        list(chunked(double, X, 3, executor))
        assert executor.submit(double, 1).result() == 2


class Busy(Executor):
    """An executor that runs the first task at once and all later ones only at its shutdown."""

    def __init__(self) -> None:
        self.submitted = 0
        self.waiting: list[tuple[Future, Callable[[], object]]] = []

    def submit(self, fn, /, *args, **kwargs) -> Future:
        self.submitted += 1
        self.waiting.append((Future(), partial(fn, *args, **kwargs)))
        future = self.waiting[-1][0]
        if self.submitted == 1:
            self._work()
        return future

    def shutdown(self, wait=True, *, cancel_futures=False) -> None:  # noqa: ARG002
        while self.waiting:
            self._work()

    def _work(self) -> None:
        future, work = self.waiting.pop(0)
        if future.set_running_or_notify_cancel():
            try:
                future.set_result(work())
            except RuntimeError as error:
                future.set_exception(error)


@pytest.fixture(params=["default", "given"])
def busy(request, monkeypatch):
    """A busy worker, created by `chunked` or given by its caller, and the `executor` argument."""
    with Busy() as worker:
        monkeypatch.setattr(_chunks, "_threads", lambda _chunks: worker)
        yield worker, worker if request.param == "given" else None


def test_an_error_in_a_chunk_is_raised_and_cancels_the_others(busy):
    """Chunks that have not started never start."""
    worker, executor = busy
    begun = []

    def fail(x):
        begun.append(x[0, 0])
        raise RuntimeError("no value here")

    with pytest.raises(RuntimeError, match="no value here"):
        list(chunked(fail, X, 1, executor))
    worker.shutdown()
    assert begun == [0]
    assert worker.submitted > 1


def test_an_interrupt_cancels_the_other_chunks(busy):
    """Ctrl-C during `progress` of the first chunk cancels all chunks that have not started."""
    worker, executor = busy
    begun = []

    def note(x):
        begun.append(x[0, 0])
        return x

    def interrupt(_done, _total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        list(chunked(note, X, 1, executor, progress=interrupt))
    worker.shutdown()
    assert begun == [0]
    assert worker.submitted > 1


class Pickled:
    """Work that counts how often it is pickled."""

    packed = 0

    def __call__(self, x: np.ndarray) -> np.ndarray:
        return 2 * x

    def __getstate__(self) -> dict:
        Pickled.packed += 1
        return {}


@pytest.mark.slow
def test_the_work_is_pickled_once(tmp_path, monkeypatch):
    """The work may hold millions of sites, so it is sent once, not with every chunk.

    Its file is removed afterwards.
    """
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as processes:
        parts = [part for _, part in chunked(Pickled(), X, 1, processes)]
    np.testing.assert_array_equal(np.concatenate(parts), 2 * X)
    assert Pickled.packed == 1
    assert not list(tmp_path.iterdir())


def test_a_single_chunk_runs_in_the_calling_thread():
    where = []
    list(chunked(lambda x: where.append(threading.current_thread()) or x, X, 100))
    assert where == [threading.current_thread()]


def test_blas_has_one_thread_while_chunks_run():
    """The chunks share the cores; afterwards BLAS has as many threads as before."""
    np.ones((2, 2)) @ np.ones((2, 2))

    def threads() -> list[int]:
        return [i["num_threads"] for i in threadpool_info() if i["user_api"] == "blas"]

    before, during = threads(), []
    list(chunked(lambda x: during.extend(threads()) or x, X, 3))
    assert set(during) <= {1}
    assert threads() == before


class OwnMethod(LeastSquares):
    """A method of the user, without a faster route or another size of its chunks."""

    _value_rows, _gradient_rows = Reconstruction._value_rows, Reconstruction._gradient_rows
    _prepare, _chunk_rows = Reconstruction._prepare, Reconstruction._chunk_rows
    _weight_chunk_rows = Reconstruction._weight_chunk_rows


METHODS = {
    "LS": lambda p: LeastSquares(p, 3),
    "own": OwnMethod,
    "MLS": lambda p: MovingLeastSquares(p, wendland(3, 1), 2, 20),
    "RBF": lambda p: RBF(p, thin_plate_spline()),
    "compact": lambda p: RBF(p, wendland(3, 2, 0.2)),
    "Hermite": lambda p: HermiteRBF(values_at(p), polyharmonic(3)),
    "PU": lambda p: PartitionOfUnityRBF(p),
    "mean": lambda p: Mean(p, [LeastSquares, partial(RBF, kernel=thin_plate_spline())]),
}


@pytest.mark.parametrize("columns", [1, 40])
@pytest.mark.parametrize("name", METHODS)
def test_a_chunk_takes_about_its_share_of_memory(monkeypatch, name, columns):
    """A quarter to four times as much, for gradients and for gradient weights."""
    monkeypatch.setattr(_chunks, "CHUNK_BYTES", 2**20)
    p = halton(200, 3)
    m = METHODS[name](p)
    s = m.field(np.cos(p @ np.ones((3, columns))))
    for evaluate, rows in (
        (s.gradient, m._chunk_rows(columns)),
        (m.gradient_weights, m._weight_chunk_rows()),
    ):
        assert 8 * 3 * rows < _chunks.CHUNK_BYTES
        x = halton(rows, 3, seed=1)
        evaluate(x[:5], executor=_chunks.Inline())
        tracemalloc.start()
        evaluate(x, executor=_chunks.Inline())
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert 2**18 < peak < 2**22


def test_chunks_of_second_derivatives_have_fewer_queries(monkeypatch):
    """A Hessian in three variables has three times as many numbers as a gradient."""
    monkeypatch.setattr(_chunks, "CHUNK_BYTES", 2**18)
    m = LeastSquares(halton(50, 3), 2)
    s, rows = m.field(m.points[:, 0]), m._chunk_rows(1)
    x = np.broadcast_to(m.points[0], (rows, 3))
    for evaluate, first in (
        (s, rows),
        (s.gradient, rows),
        (s.hessian, rows // 3),
        (s.laplacian, rows // 3),
    ):
        steps = []
        evaluate(x, progress=lambda *step, steps=steps: steps.append(step))
        assert steps[0] == (first, rows)


@pytest.mark.slow
@pytest.mark.parametrize(
    "make",
    [
        lambda p: LeastSquares(p, 3),
        lambda p: MovingLeastSquares(p, wendland(3, 1), 2, 20),
        lambda p: RBF(p, thin_plate_spline()),
        lambda p: PartitionOfUnityRBF(p),
    ],
    ids=["LS", "MLS", "RBF", "PU"],
)
def test_memory_stays_bounded(make):
    """The peak is below 1.5 times input, output and one chunk, for any number of queries."""
    p = np.random.default_rng(1).random((600, 2))
    m = make(p)
    s = m.field(np.cos(p @ [3.0, 2.0]))
    x = np.random.default_rng(2).random((40_000, 2))

    def adjoint(x: np.ndarray, executor: Executor) -> np.ndarray:
        return m.adjoint(x, x[:, 0], executor=executor)

    with ThreadPoolExecutor(1) as executor:
        for evaluate in (s, s.gradient, adjoint):
            evaluate(x[:10], executor=executor)
            tracemalloc.start()
            result = evaluate(x, executor=executor)
            peak = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
            assert peak < 1.5 * (x.nbytes + result.nbytes + _chunks.CHUNK_BYTES)
