"""Methods with local weights: executors, progress and interrupts."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from unittest import mock

import numpy as np
import pytest

from fieldrecon import reconstruction
from fieldrecon._core import chunks as _chunks
from fieldrecon._numerics import neighbor_search
from fieldrecon._numerics.neighbor_search import by_cells
from fieldrecon.datasets.synthetic import franke, halton, uniform
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.globe import OnGlobe
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.selection.leaving_one_out import leave_one_out
from laws import assert_close, assert_counted, assert_same_bits

METHODS = {
    "MLS": partial(MovingLeastSquares, weight=wendland(2, 1), degree=1, neighbors=12),
    "compact RBF": partial(RBF, kernel=wendland(2, 1, 0.2)),
    "PU": PartitionOfUnityRBF,
    "PU on the globe": lambda x: OnGlobe(x, partial(PartitionOfUnityRBF, degree=1)),
}
SITES, QUERIES = halton(250, 2), uniform(400, 2, seed=1)


def record(steps, *call):
    steps.append(call)


def evaluations(method, x):
    """All results at queries, as functions of an executor and progress."""
    s, adjoint = method.field(franke(SITES)), partial(method.adjoint, f=np.cos(np.arange(len(x))))
    functions = s, s.gradient, method.weights, method.gradient_weights, adjoint
    return [partial(evaluate, x) for evaluate in functions]


@pytest.fixture
def small_chunks(monkeypatch):
    """Chunks so small that a few hundred queries need many."""
    monkeypatch.setattr(_chunks, "CHUNK_BYTES", 2**14)


@pytest.mark.parametrize("scale", [1e308, 1.0, 1e-310, 0.0])
@pytest.mark.parametrize(("d", "cells"), [(1, 65534), (2, 254), (3, 39)])
def test_queries_are_ordered_along_the_first_axis(monkeypatch, scale, d, cells):
    """In each group every query occurs once, and none lies more than a cell behind another."""
    monkeypatch.setattr(neighbor_search, "_GROUP", 300)
    x = scale * (2 * uniform(700, d, seed=1) - 1)
    order = by_cells(x)
    for start in range(0, 700, 300):
        group = order[start : start + 300]
        assert sorted(group) == [*range(start, min(start + 300, 700))]
        along = x[group, 0] / 2
        behind = np.maximum.accumulate(along) - along
        assert behind.max() <= 1.01 * np.ptp(along) / cells


@pytest.mark.slow
@pytest.mark.parametrize("name", METHODS)
@pytest.mark.usefixtures("small_chunks")
def test_values_and_progress_do_not_depend_on_the_executor(name):
    """All results agree bit for bit; progress increases to the number of queries."""
    with ThreadPoolExecutor(3) as executor:
        for evaluate in evaluations(METHODS[name](SITES), QUERIES[:80]):
            steps = []
            there = evaluate(executor=executor, progress=partial(record, steps))
            assert_same_bits(there, evaluate())
            assert len(set(steps)) > 5
            assert_counted(steps, 80)


@pytest.mark.slow
@pytest.mark.parametrize("name", METHODS)
@pytest.mark.usefixtures("small_chunks")
def test_method_and_executor_can_be_used_after_an_interrupt(name):
    """No chunk is started beyond those already submitted."""
    begun = []

    class Counting(ThreadPoolExecutor):
        def submit(self, *args, **kwargs):
            begun.append(1)
            return super().submit(*args, **kwargs)

    def interrupt(_done, _total):
        raise KeyboardInterrupt

    with Counting(2) as executor:
        for evaluate in evaluations(METHODS[name](SITES), QUERIES):
            begun.clear()
            with pytest.raises(KeyboardInterrupt):
                evaluate(executor=executor, progress=interrupt)
            assert len(begun) <= _chunks._AHEAD
        for evaluate in evaluations(METHODS[name](SITES), QUERIES[:9]):
            assert_same_bits(evaluate(executor=executor), evaluate())


@pytest.mark.usefixtures("small_chunks")
def test_an_error_in_a_chunk_names_the_query():
    """The first query that no site is near, whatever the executor."""
    m = MovingLeastSquares(SITES, wendland(2, 1, 0.4))
    x = np.concatenate([QUERIES[:9], [[7.0, 5.0]], QUERIES[:30] + 30])
    for executor in (None, _chunks.Inline()):
        for evaluate in (m.weights, m.gradient_weights, partial(m.adjoint, f=x[:, 0])):
            with pytest.raises(np.linalg.LinAlgError, match=r"at the query \(7, 5\) do"):
                evaluate(x, executor=executor)


def test_dense_weights_are_refused_before_any_chunk_is_computed():
    """Sparse ones of the same queries are not refused."""
    m = LeastSquares(SITES)
    with mock.patch.object(reconstruction, "DENSE_LIMIT_BYTES", 1000):
        for weights in (m.weights, m.gradient_weights):
            with pytest.raises(MemoryError, match=r"dense weights of 400 queries for 250 sites"):
                weights(QUERIES, executor=None, progress=partial(record, steps := []))
            assert not steps
        assert METHODS["MLS"](SITES).weights(QUERIES).shape == (400, 250)


class Backwards(LeastSquares):
    """Dense weights that are computed in another order of the queries."""

    def _order(self, x):
        return np.argsort(-x[:, 0])


@pytest.mark.usefixtures("small_chunks")
def test_results_are_in_the_order_of_the_queries():
    """Dense weights as well, in whatever order the chunks are computed."""
    x = QUERIES[:40]
    both = (evaluations(made(SITES, 2), x) for made in (Backwards, LeastSquares))
    for backwards, forwards in zip(*both, strict=True):
        np.testing.assert_allclose(backwards(), forwards(), atol=1e-12)


@pytest.mark.parametrize(
    "make", [METHODS["MLS"], partial(MovingLeastSquares, weight=wendland(2, 1, 0.4)), METHODS["PU"]]
)
@pytest.mark.usefixtures("small_chunks")
def test_sparse_weights_are_in_canonical_form(make):
    """A row has each site once, in ascending order, as some programs outside SciPy require."""
    m = make(SITES)
    for matrix in (m.weights(QUERIES[:40]), *m.gradient_weights(QUERIES[:40])):
        assert matrix.has_canonical_format


@pytest.mark.slow
@pytest.mark.parametrize("name", ["MLS", "PU", "PU on the globe"])
@pytest.mark.usefixtures("small_chunks")
def test_leave_one_out_reports_progress(name):
    """Progress increases to the total, and the residuals are the same as without it."""
    method, steps = METHODS[name](SITES), []
    residuals = leave_one_out(method, franke(SITES), progress=partial(record, steps))
    assert_close(residuals, leave_one_out(method, franke(SITES)), 0.0)
    assert len(steps) > 5
    assert [done for done, _ in steps] == sorted({done for done, _ in steps})
    assert steps[-1][0] == steps[-1][1]


CTRL_C = """
import signal, threading
from functools import partial
import numpy as np
from fieldrecon._core import chunks
from fieldrecon.datasets.synthetic import uniform
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.kernels.positive_definite import wendland

chunks.CHUNK_BYTES = 2**14
load = np.ones(45_000)
x, few = uniform(5000, 2, seed=1), uniform(20, 2, seed=2)
mls = MovingLeastSquares(x, wendland(2, 1), 1, 12).field(x[:, 0])
method = PartitionOfUnityRBF(x)
pu = method.field(x[:, 0])
before = mls(few), pu(few)


def stopped(work):
    told = []

    def progress(done, total):
        told.append((done, total))
        if len(told) == 1:
            signal.raise_signal(signal.SIGINT)  # to this thread: another one might be late

    try:
        work(progress)
    except KeyboardInterrupt:
        return told[-1][0] < told[-1][1]
    return False


assert stopped(lambda progress: PartitionOfUnityRBF(x, progress=progress)), "set-up"
assert stopped(lambda progress: method.field(x[:, 1], progress=progress)), "fit"
assert stopped(lambda progress: RBF(x[:2000], polyharmonic(3), progress=progress)), "matrix"
for m in (mls.method, method):
    assert stopped(lambda progress: m.weights(np.tile(x, (9, 1)), progress=progress)), "weights"
    adjoint = partial(m.adjoint, np.tile(x, (9, 1)), load)
    assert stopped(lambda progress: adjoint(progress=progress)), "adjoint"
for s, again in zip((mls, pu), before):
    assert stopped(lambda progress: s(np.tile(x, (9, 1)), progress=progress)), "evaluation"
    assert stopped(lambda progress: s.gradient(np.tile(x, (9, 1)), progress=progress)), "gradient"
    assert np.array_equal(s(few), again), "lost"
assert threading.active_count() <= 2, "running on"
"""


@pytest.mark.slow
def test_ctrl_c_stops_set_up_fit_and_evaluation():
    """A real SIGINT stops set-up, fit, values, gradients, weights and adjoints early.

    Afterwards the field is unchanged.
    """
    done = subprocess.run(
        [sys.executable, "-c", CTRL_C], capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stderr
