"""Timing of several candidates in turn, and the parts of a result: comparisons, tables, charts."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field

from threadpoolctl import threadpool_limits

Track = Callable[[Sequence[str], str], Iterable[str]]
"""Iterates over items and shows a progress bar with a description, as rich's `Progress.track`."""


@dataclass(frozen=True)
class Comparison:
    """Time of fieldrecon divided by that of a peer, one ratio per repetition."""

    what: str
    peer: str
    ours: Sequence[float]
    theirs: Sequence[float]
    at_most: float | None = None

    @property
    def ratios(self) -> list[float]:
        return [a / b for a, b in zip(self.ours, self.theirs, strict=True)]

    def summary(self) -> dict:
        return {
            "what": self.what,
            "peer": self.peer,
            "ratio": statistics.median(self.ratios),
            "least": min(self.ratios),
            "most": max(self.ratios),
            "at_most": self.at_most,
            "seconds": statistics.median(self.ours),
            "seconds_of_peer": statistics.median(self.theirs),
            "repeats": len(self.ours),
        }


@dataclass(frozen=True)
class Table:
    """A table of further numbers."""

    caption: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str | int | float]]


@dataclass(frozen=True)
class Chart:
    """Lines on logarithmic axes, over a common x, or over one x for each line by its name."""

    title: str
    x_label: str
    y_label: str
    x: Sequence[float] | Mapping[str, Sequence[float]]
    lines: Mapping[str, Sequence[float]]


@dataclass(frozen=True)
class BenchmarkResult:
    """The result of one benchmark; `notes` are remarks for readers."""

    comparisons: Sequence[Comparison] = ()
    tables: Sequence[Table] = ()
    charts: Sequence[Chart] = ()
    notes: Sequence[str] = ()
    parameters: Mapping[str, int | str] = field(default_factory=dict)

    def as_dict(self) -> dict:
        return {
            "parameters": dict(self.parameters),
            "comparisons": [c.summary() for c in self.comparisons],
            "tables": [asdict(t) for t in self.tables],
            "charts": [asdict(c) for c in self.charts],
            "notes": list(self.notes),
        }


def in_turn(
    candidates: Mapping[str, Callable[[], object]], repeats: int, track: Track, what: str
) -> dict[str, list[float]]:
    """Seconds of each candidate, run in turn A B C A B C ...; the first round is not counted.

    Consecutive runs see the same load, so their ratio is meaningful on a shared machine.
    """
    seconds: dict[str, list[float]] = {name: [] for name in candidates}
    for name in track([*candidates] * (repeats + 1), what):
        start = time.perf_counter()
        candidates[name]()
        seconds[name].append(time.perf_counter() - start)
    return {name: times[1:] for name, times in seconds.items()}


def cores() -> int:
    """The number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def threads(number: int) -> Iterator[None]:
    """Limit the BLAS threads and, if the system supports it, the cores."""
    with threadpool_limits(number):
        if not hasattr(os, "sched_setaffinity"):
            yield
            return
        before = os.sched_getaffinity(0)
        os.sched_setaffinity(0, sorted(before)[:number])
        try:
            yield
        finally:
            os.sched_setaffinity(0, before)
