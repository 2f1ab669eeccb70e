"""Evaluation on a Dask cluster: the same bits as on one machine, also if a worker is killed."""

import os
import signal
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from uuid import uuid4

import dask.array
import numpy as np
import pytest
from distributed import Client, LocalCluster, wait

from fieldrecon._core import chunks as _chunks
from fieldrecon.datasets.synthetic import franke, halton
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.pipelines.cluster import Cluster, evaluated
from laws import assert_close

X, Q = halton(3000, 2), halton(4000, 2, seed=1)
# the Dask servers log warnings about a killed worker
pytestmark = pytest.mark.filterwarnings("ignore")


@contextmanager
def cluster(folder, **workers):
    """A client of a local cluster with these workers."""
    quiet = {"dashboard_address": None, "silence_logs": "CRITICAL"}
    with (
        LocalCluster(threads_per_worker=1, local_directory=folder, **quiet, **workers) as cluster,
        Client(cluster) as client,
    ):
        yield client


class Recorded:
    """Work that logs the process identifier of each call and kills the first process."""

    def __init__(self, work, log: Path) -> None:
        self.work, self.log = work, log

    def __call__(self, x: np.ndarray) -> np.ndarray:
        with self.log.open("a") as log:
            log.write(f"{os.getpid()}\n")
        with suppress(FileExistsError):
            with self.log.with_suffix(".killed").open("x") as log:
                log.write(f"{os.getpid()}")
            os.kill(os.getpid(), signal.SIGKILL)
        return self.work(x)


class Recording(Cluster):
    """A cluster that records its work."""

    log: Path

    def shared_work(self, work):
        return super().shared_work(Recorded(work, self.log))


@pytest.mark.slow
def test_fit_and_evaluation_survive_a_killed_worker(tmp_path, monkeypatch):
    """A worker is killed after it has begun a chunk; other workers repeat it with the same bits."""
    monkeypatch.setattr(_chunks, "CHUNK_BYTES", 2**19)
    m = PartitionOfUnityRBF(X)
    here = m.field(franke(X))
    with cluster(tmp_path, n_workers=3, processes=True) as client:  # each has a nanny
        executor = Recording(client)
        executor.log = tmp_path / "fit"
        there = m.field(franke(X), executor=executor)
        executor.log = tmp_path / "values"
        values = there(Q, executor=executor)
    for log in ("fit", "values"):
        begun = (tmp_path / log).read_text().split()
        killed = (tmp_path / log).with_suffix(".killed").read_text()
        assert begun.count(killed) == 1
        assert len(set(begun)) > 1
        with pytest.raises(ProcessLookupError):
            os.kill(int(killed), 0)
    assert_close(values, here(Q), 0.0)
    assert_close(there.gradient(Q), here.gradient(Q), 0.0)


@pytest.mark.slow
def test_the_work_survives_the_worker_that_alone_has_it(tmp_path):
    """Scattered data would be lost with the processes that hold them."""
    with (
        cluster(tmp_path, n_workers=2, processes=True) as client,
        Cluster(client).shared_work(partial(np.multiply, 3.0)) as work,
    ):
        wait(work)
        (holder,) = client.who_has(work)[work.key]
        os.kill(client.run(os.getpid, workers=[holder])[holder], signal.SIGKILL)
        assert Cluster(client).submit(work, 14.0).result() == 42.0


@pytest.mark.slow
def test_a_cluster_of_threads_gives_the_same_bits(tmp_path, monkeypatch):
    """The work is sent to the two workers in the same way as to processes."""
    monkeypatch.setattr(_chunks, "CHUNK_BYTES", 2**19)
    m = PartitionOfUnityRBF(X)
    here = m.field(franke(X))
    with cluster(tmp_path, n_workers=2, processes=False) as client:
        there = m.field(franke(X), executor=Cluster(client))
        assert_close(there(Q, executor=Cluster(client)), here(Q), 0.0)


def test_shared_work_is_held_until_all_chunks_are_done_and_each_task_is_run(tmp_path):
    """Also a task like one before; the workers keep nothing."""
    with cluster(tmp_path, n_workers=1, processes=False) as client:
        executor = Cluster(client)
        with executor.shared_work(abs) as work:
            assert executor.submit(work, -3).result() == 3
            assert work.key in client.futures
            assert executor.submit(uuid4).result() != executor.submit(uuid4).result()
        client.who_has()  # waits for what the client has begun
        assert work.key not in client.futures


def test_queries_may_be_a_dask_array():
    """The evaluation is lazy, and the result has the row chunks of the queries."""
    m = PartitionOfUnityRBF(X)
    for data in (franke(X), np.stack([franke(X), X[:, 0]], axis=1)):
        s = m.field(data)
        lazy = evaluated(s, dask.array.from_array(Q, chunks=(1500, 1)))
        assert lazy.shape == (4000, *data.shape[1:])
        assert lazy.chunks[0] == (1500, 1500, 1000)
        assert_close(lazy.compute(), s(Q), 0.0)


def test_queries_of_another_shape_are_refused():
    s = PartitionOfUnityRBF(X).field(franke(X))
    with pytest.raises(ValueError, match=r"x must have the shape \(m, 2\); got \(4000, 3\)"):
        evaluated(s, dask.array.zeros((4000, 3)))


def test_a_field_that_is_evaluated_twice_is_held_once():
    """The graphs of different queries share a task, which is the field."""
    field = PartitionOfUnityRBF(halton(50, 2)).field(halton(50, 2)[:, 0])
    queries = (dask.array.from_array(halton(n, 2), chunks=(5, 2)) for n in (10, 20))
    one, other = ({*evaluated(field, x).dask} for x in queries)
    assert len(one & other) == 1
