"""Methods with local weights: executors, progress and interrupts."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import pytest

from fieldrecon._core import chunks as _chunks
from fieldrecon.datasets.synthetic import franke, halton, uniform
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.globe import OnGlobe
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.selection.leaving_one_out import leave_one_out
from laws import assert_close

METHODS = {
    "MLS": partial(MovingLeastSquares, weight=wendland(2, 1), degree=1, neighbors=12),
    "compact RBF": partial(RBF, kernel=wendland(2, 1, 0.2)),
    "PU": PartitionOfUnityRBF,
    "PU on the globe": lambda x: OnGlobe(x, partial(PartitionOfUnityRBF, degree=1)),
}
SITES, QUERIES = halton(250, 2), uniform(400, 2, seed=1)


def record(steps, *call):
    steps.append(call)


@pytest.fixture
def small_chunks(monkeypatch):
    """Chunks so small that a few hundred queries need many."""
    monkeypatch.setattr(_chunks, "CHUNK_BYTES", 2**14)


@pytest.mark.slow
@pytest.mark.parametrize("name", METHODS)
@pytest.mark.usefixtures("small_chunks")
def test_values_and_progress_do_not_depend_on_the_executor(name):
    """Values and gradients agree bit for bit; progress increases to the number of queries."""
    s = METHODS[name](SITES).field(franke(SITES))
    with ThreadPoolExecutor(3) as executor:
        for evaluate in (s, s.gradient):
            steps = []
            there = evaluate(QUERIES, executor=executor, progress=partial(record, steps))
            assert_close(there, evaluate(QUERIES), 0.0)
            assert len(steps) > 5
            assert [done for done, _ in steps] == sorted({done for done, _ in steps})
            assert steps[-1] == (len(QUERIES), len(QUERIES))


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.usefixtures("small_chunks")
def test_field_and_executor_can_be_used_after_an_interrupt(name):
    """No chunk is started beyond those already submitted."""
    s = METHODS[name](SITES).field(franke(SITES))
    before, begun = s(QUERIES), []

    class Counting(ThreadPoolExecutor):
        def submit(self, *args, **kwargs):
            begun.append(1)
            return super().submit(*args, **kwargs)

    def interrupt(_done, _total):
        raise KeyboardInterrupt

    with Counting(2) as executor:
        with pytest.raises(KeyboardInterrupt):
            s(QUERIES, executor=executor, progress=interrupt)
        assert len(begun) <= _chunks._AHEAD
        assert_close(s(QUERIES, executor=executor), before, 0.0)


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
import numpy as np
from fieldrecon._core import chunks
from fieldrecon.datasets.synthetic import uniform
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.kernels.positive_definite import wendland

chunks.CHUNK_BYTES = 2**14
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
for s, again in zip((mls, pu), before):
    assert stopped(lambda progress: s(np.tile(x, (9, 1)), progress=progress)), "evaluation"
    assert stopped(lambda progress: s.gradient(np.tile(x, (9, 1)), progress=progress)), "gradient"
    assert np.array_equal(s(few), again), "lost"
assert threading.active_count() <= 2, "running on"
"""


@pytest.mark.slow
def test_ctrl_c_stops_set_up_fit_and_evaluation():
    """A real SIGINT stops set-up, fit, values and gradients early.

    Afterwards the field is unchanged.
    """
    done = subprocess.run(
        [sys.executable, "-c", CTRL_C], capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stderr
