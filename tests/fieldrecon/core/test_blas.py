"""BLAS on one thread while the library computes, and afterwards as many as before."""

import multiprocessing
import pkgutil
import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from itertools import permutations

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import fieldrecon as fr
from fieldrecon._core.blas_threads import FEW, Owner, blas_threads_for
from fieldrecon._core.chunks import Inline, chunked
from fieldreport.experiments.coupling.vortex_lattice import VortexLattice

MANY = 3
X = np.zeros((4, 2))


def threads() -> set[int]:
    return {info["num_threads"] for info in threadpool_info() if info["user_api"] == "blas"}


@pytest.fixture(autouse=True)
def many_threads():
    """As on a machine with more cores than one, and no variable that says otherwise."""
    with threadpool_limits(MANY):
        assert threads() == {MANY}
        yield
        assert threads() == {MANY}


class Evaluation:
    """An evaluation in a thread of its own, which goes on when it is told to."""

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
def test_evaluations_that_overlap(order, rows):
    """One thread for each until it ends, whichever does first; then as many as before."""
    with ThreadPoolExecutor(2) as pool:
        both = [Evaluation(pool, rows) for _ in range(2)]
        for i in order:
            assert threads() == {1}
            both[i].finish()
        assert threads() == {MANY}


def test_an_evaluation_within_another():
    """The inner one does not give the threads back before the outer one ends."""
    seen = []

    def outer(x):
        list(chunked(np.sum, x, 1, Inline()))
        seen.append(threads())
        return x

    list(chunked(outer, X, 2, Inline()))
    assert seen == [{1}, {1}]
    assert threads() == {MANY}


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_an_evaluation_that_fails(error):
    """An error and an interrupt leave the threads as they were."""

    def work(_):
        assert threads() == {1}
        raise error

    with pytest.raises(error):
        list(chunked(work, X, 2, Inline()))
    assert threads() == {MANY}


def test_an_evaluation_that_is_abandoned():
    """Between two chunks the caller has all threads, and after the last that was asked for."""
    seen = []
    parts = chunked(lambda x: seen.append(threads()) or x, X, 1, Inline())
    next(parts)
    assert set(map(frozenset, seen)) == {frozenset({1})}
    assert threads() == {MANY}
    del parts
    assert threads() == {MANY}


def seen_there(_):
    return threads()


def begin_with_many():
    threadpool_limits(MANY)


def test_an_evaluation_in_another_process():
    """BLAS has one thread there."""
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn, initializer=begin_with_many) as pool:
        assert pool.submit(threads).result() == {MANY}
        assert [seen for _, seen in chunked(seen_there, X, 2, pool)] == [{1}, {1}]
        assert pool.submit(threads).result() == {MANY}


def orders(holders):
    """Every order in which so many can enter and leave."""
    every = set(permutations(sorted([*range(holders)] * 2)))
    return [tuple((i, i in order[:k]) for k, i in enumerate(order)) for order in sorted(every)]


@pytest.mark.parametrize("order", orders(3), ids=lambda o: "".join(str(i) for i, _ in o))
def test_every_order_of_entering_and_leaving(order):
    """One thread while somebody is inside, and the number before when nobody is."""
    number = [MANY]
    owner = Owner([(lambda: number[0], lambda n: number.__setitem__(0, n))])
    inside = set()
    for i, entered in order:
        (owner.leave if entered else owner.enter)(i)
        inside ^= {i}
        assert number == [1 if inside else MANY]


def test_an_interrupt_while_entering():
    """What has set one thread, and gets no further, gives the threads back."""
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


def test_many_operations_are_shared_among_threads():
    """Few are not: the threads would wait for each other."""
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
        "methods.least_squares.qr": lambda: fr.LeastSquares(P),
        "polynomials.np.linalg.svd": lambda: fr.LeastSquares(P),
        f"{FITS}.by_elimination": lambda: (
            fr.MovingLeastSquares(P, fr.wendland(3, 1)).weights(P),
            fr.vertex_gradients(MESH, CELLS),
        ),
        f"{PATCHES}.within_range": lambda: fr.PartitionOfUnityRBF(P).weights(P),
        f"{WING}.vortex_lattice.lu_factor": lambda: VortexLattice(GRID),
    }.items(),
)
def test_a_small_factorization(monkeypatch, within, call):
    """It runs on one thread, wherever it is called from."""
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
