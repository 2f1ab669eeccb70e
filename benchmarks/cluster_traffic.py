"""Traffic between a cluster's scheduler and its workers, counted without a network."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from fieldrecon.datasets.synthetic import franke, uniform
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF


@dataclass(frozen=True)
class Traffic:
    """Bytes per site or query: sent once to each worker, and sent and received with the chunks."""

    held: float
    there: float
    back: float

    def gigabytes(self, n: int, workers: int) -> float:
        """Total for this number of sites or queries."""
        return n * (workers * self.held + self.there + self.back) / 1e9


class Counting(Executor):
    """An executor that computes in this process and counts the bytes that a cluster would send."""

    def __init__(self) -> None:
        self.held = self.there = self.back = 0

    @contextmanager
    def shared_work(self, work: Any) -> Iterator[Any]:
        """The work, which every worker would receive once."""
        self.held += pickled_size(work)
        yield work

    def submit(self, fn: Any, /, *args: Any, **_: Any) -> Future[Any]:
        """Run the function at once; its arguments and its result are arrays."""
        done: Future[Any] = Future()
        done.set_result(fn(*args))
        self.there += pickled_size(args)
        self.back += pickled_size(done.result())
        return done


def pickled_size(what: Any) -> int:
    return len(pickle.dumps(what, pickle.HIGHEST_PROTOCOL))


def traffic_of(n: int) -> dict[str, Traffic]:
    """The traffic of a fit to n sites and of an evaluation at n queries."""
    x = uniform(n, 2, seed=1)
    fit, evaluate = Counting(), Counting()
    s = PartitionOfUnityRBF(x).field(franke(x), executor=fit)
    s(uniform(n, 2, seed=2), executor=evaluate)
    return {
        step: Traffic(c.held / n, c.there / n, c.back / n)
        for step, c in (("fit", fit), ("evaluate", evaluate))
    }
