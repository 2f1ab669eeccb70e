"""BLAS uses one thread while the library computes; afterwards the old number is restored."""

import multiprocessing
import pkgutil
import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from itertools import permutations

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import fieldrecon as fr
from fieldrecon._core.blas_threads import _LIBRARIES, FEW, Owner, _number, blas_threads_for
from fieldrecon._core.chunks import Inline, chunked
from fieldreport.experiments.coupling.vortex_lattice import VortexLattice

MANY = 3
X = np.zeros((4, 2))


def threads() -> set[int]:
    return {info["num_threads"] for info in threadpool_info() if info["user_api"] == "blas"}


@pytest.fixture(autouse=True)
def many_threads():
    """Give BLAS several threads before each test, and check that it has them again afterwards."""
    with threadpool_limits(MANY):
        assert threads() == {MANY}
        yield
        assert threads() == {MANY}


class Evaluation:
    """An evaluation in its own thread that waits inside the work function until `finish`."""

    def __init__(self, pool: ThreadPoolExecutor, rows: int) -> None:
        self.inside, self.go_on = threading.Event(), threading.Event()
        self.done = pool.submit(lambda: list(chunked(self.work, X, rows, Inline())))
        assert self.inside.wait(10)

    def work(self, _: np.ndarray) -> set[int]:
        self.inside.set()
        assert self.go_on.wait(10)
        return threads()

    def finish(self) -> None:
        self.go_on.set()
        assert {frozenset(seen) for _, seen in self.done.result(10)} == {frozenset({1})}


@pytest.mark.parametrize("rows", [2, 4], ids=["two chunks", "one chunk"])
@pytest.mark.parametrize("order", [(0, 1), (1, 0)], ids=["first leaves first", "last first"])
def test_overlapping_evaluations_keep_blas_on_one_thread(order, rows):
    """BLAS has one thread until the last evaluation ends, whichever ends first."""
    with ThreadPoolExecutor(2) as pool:
        both = [Evaluation(pool, rows) for _ in range(2)]
        for i in order:
            assert threads() == {1}
            both[i].finish()
        assert threads() == {MANY}


def test_a_nested_evaluation_does_not_restore_the_threads():
    """BLAS has one thread until the outer evaluation ends."""
    seen = []

    def outer(x):
        list(chunked(np.sum, x, 1, Inline()))
        seen.append(threads())
        return x

    list(chunked(outer, X, 2, Inline()))
    assert seen == [{1}, {1}]
    assert threads() == {MANY}


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_an_exception_restores_the_threads(error):
    """The number of threads is restored after an error and after an interrupt."""

    def work(_):
        assert threads() == {1}
        raise error

    with pytest.raises(error):
        list(chunked(work, X, 2, Inline()))
    assert threads() == {MANY}


def test_threads_are_restored_between_chunks():
    """The caller has all threads between two chunks, and also after it abandons the iterator."""
    seen = []
    parts = chunked(lambda x: seen.append(threads()) or x, X, 1, Inline())
    next(parts)
    assert set(map(frozenset, seen)) == {frozenset({1})}
    assert threads() == {MANY}
    del parts
    assert threads() == {MANY}


def threads_in_worker(_):
    return threads()


def start_with_many_threads():
    threadpool_limits(MANY)


@pytest.mark.slow
def test_worker_processes_use_one_blas_thread():
    """In a process pool BLAS has one thread during the work and the old number afterwards."""
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn, initializer=start_with_many_threads) as pool:
        assert pool.submit(threads).result() == {MANY}
        assert [seen for _, seen in chunked(threads_in_worker, X, 2, pool)] == [{1}, {1}]
        assert pool.submit(threads).result() == {MANY}


def test_the_number_of_threads_can_be_set_from_any_thread():
    """For each library, threadpoolctl reads the same number."""
    for library in _LIBRARIES:
        number, set_number = _number(library)
        for wanted in (1, 2, MANY):
            with ThreadPoolExecutor(1) as pool:
                pool.submit(set_number, wanted).result()
                assert pool.submit(number).result() == wanted
            assert number() == library.get_num_threads() == wanted


def orders(holders):
    """Every order in which the holders can enter and leave."""
    every = set(permutations(sorted([*range(holders)] * 2)))
    return [tuple((i, i in order[:k]) for k, i in enumerate(order)) for order in sorted(every)]


def test_one_thread_while_any_holder_is_inside():
    """BLAS has one thread while a holder is inside, and the original number when none is."""
    for order in orders(3):
        number = [MANY]
        owner = Owner([(lambda n=number: n[0], partial(number.__setitem__, 0))])
        inside = set()
        for i, entered in order:
            (owner.leave if entered else owner.enter)(i)
            inside ^= {i}
            assert number == [1 if inside else MANY], order


def test_an_interrupt_during_enter_can_be_undone():
    """An interrupt after the number was set to one still lets `leave` restore it."""
    number = [MANY]

    def set_number(n):
        number[0] = n
        if n == 1:
            raise KeyboardInterrupt

    owner = Owner([(lambda: number[0], set_number)])
    with pytest.raises(KeyboardInterrupt):
        owner.enter("interrupted")
    owner.leave("interrupted")
    assert number == [MANY]


def test_only_large_computations_use_several_threads():
    """Up to FEW operations use one thread, because synchronization costs more than it gains."""
    with blas_threads_for(FEW):
        assert threads() == {1}
    with blas_threads_for(1.01 * FEW):
        assert threads() == {MANY}


RNG = np.random.default_rng(0)
P = RNG.random((60, 2))
F = np.cos(P @ [3.0, 2.0])


FITS, PATCHES = "_numerics.weighted_least_squares", "methods.partition_of_unity.batched_systems"
WING = "fieldreport.experiments.coupling"
SPACE = RNG.random((500, 3))
MESH = fr.SimplexMesh.delaunay(P)
CELLS = np.ones(len(MESH.cells))
GRID = np.dstack(np.meshgrid(np.linspace(0, 9, 4), np.linspace(0, 3, 3), indexing="ij"))


@pytest.mark.parametrize(
    ("within", "call"),
    {
        "_numerics.saddle_point._factored": lambda: fr.RBF(P, fr.thin_plate_spline()),
        "_numerics.saddle_point.lapack.dpotrs": lambda: fr.RBF(P, fr.thin_plate_spline()).field(F),
        "_numerics.saddle_point.qr": lambda: fr.RBF(SPACE, fr.wendland(3, 2, 0.12)),
        "_numerics.orthonormal_polynomials._svd": lambda: fr.LeastSquares(P),
        "polynomials.np.linalg.svd": lambda: fr.RBF(P, fr.thin_plate_spline()),
        f"{FITS}.by_elimination": lambda: (
            fr.MovingLeastSquares(P, fr.wendland(3, 1)).weights(P),
            fr.vertex_gradients(MESH, CELLS),
        ),
        f"{PATCHES}.within_range": lambda: fr.PartitionOfUnityRBF(P).weights(P),
        f"{WING}.vortex_lattice.lu_factor": lambda: VortexLattice(GRID),
    }.items(),
)
def test_small_factorizations_run_on_one_thread(monkeypatch, within, call):
    """Every factorization in the library, at every place that calls it, sees one BLAS thread."""
    seen = []
    within = within if within.startswith(WING) else f"fieldrecon.{within}"
    module, _, name = within.rpartition(".")
    holder = pkgutil.resolve_name(module)
    whole = getattr(holder, name)

    def spy(*args, **options):
        seen.append(threads())
        return whole(*args, **options)

    monkeypatch.setattr(holder, name, spy)
    call()
    assert set(map(frozenset, seen)) == {frozenset({1})}
