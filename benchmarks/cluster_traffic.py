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
    """Bytes for each site, or query: once to each worker, there and back with the chunks."""

    held: float
    there: float
    back: float

    def gigabytes(self, n: int, workers: int) -> float:
        """Of so many sites, or queries, in all."""
        return n * (workers * self.held + self.there + self.back) / 1e9


class Counting(Executor):
    """Does all at once and here, and counts the bytes that a cluster would send and bring back."""

    def __init__(self) -> None:
        self.held = self.there = self.back = 0

    @contextmanager
    def shared_work(self, work: Any) -> Iterator[Any]:
        """The work, which each worker would get once."""
        self.held += packed(work)
        yield work

    def submit(self, fn: Any, /, *args: Any, **_: Any) -> Future[Any]:
        """Do it; what goes and what comes are arrays."""
        done: Future[Any] = Future()
        done.set_result(fn(*args))
        self.there += packed(args)
        self.back += packed(done.result())
        return done


def packed(what: Any) -> int:
    return len(pickle.dumps(what, pickle.HIGHEST_PROTOCOL))


def carried(n: int) -> dict[str, Traffic]:
    """Of a fit to so many sites, and of an evaluation at as many queries."""
    x = uniform(n, 2, seed=1)
    fit, evaluate = Counting(), Counting()
    s = PartitionOfUnityRBF(x).field(franke(x), executor=fit)
    s(uniform(n, 2, seed=2), executor=evaluate)
    return {
        step: Traffic(c.held / n, c.there / n, c.back / n)
        for step, c in (("fit", fit), ("evaluate", evaluate))
    }
