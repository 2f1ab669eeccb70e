"""Speed-up of grading by a second worker.

Only the batch is timed, after its workers have started their sandboxes. The command that `grading`
times also starts, reads and reports, which workers do not share. Each worker has one core. With two
cores a single worker would use more than one, because the grader prepares and checks while a
submission runs in its sandbox.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.assignments import LARGE, ROOT, SMALL, BenchmarkAssignment
from benchmarks.timing import BenchmarkResult, Table, Track, threads
from fieldgrade.grading.batch import Batch
from fieldgrade.grading.run import GradingRun, chosen_tier
from fieldgrade.isolation import worker_servers
from fieldgrade.isolation.server import Server

COLUMNS = ("assignment", "workers", "cores", "seconds", "least", "most", "speed-up", "range of it")
SHAPES = ((1, 1), (1, 2), (2, 2))
"""Numbers of workers and of cores for all of them."""


@dataclass(frozen=True)
class Size:
    """``warm_up`` submissions at the start of each round are not timed."""

    submissions: int = 100
    warm_up: int = 10
    assignments: tuple[str, ...] = (SMALL, LARGE)
    repeats: int = 3


FULL = Size()
QUICK = Size(submissions=20, repeats=1)
TOY = Size(submissions=2, warm_up=1, assignments=(SMALL,), repeats=1)


def run(size: Size, track: Track) -> BenchmarkResult:
    tier, _ = chosen_tier()
    rows: list[tuple[str | int | float, ...]] = []
    for name in size.assignments:
        with TemporaryDirectory() as scratch:
            folder = Path(scratch)
            for k in range(size.warm_up + size.submissions):
                file = folder / "in" / f"s{k:03}" / "work.ipynb"
                file.parent.mkdir(parents=True)
                file.write_bytes(BenchmarkAssignment(name).submission(k))
            seconds: dict[tuple[int, int], list[float]] = {shape: [] for shape in SHAPES}
            for shape in track([*SHAPES] * size.repeats, f"grading_workers, {name}"):
                seconds[shape].append(_seconds(folder, tier, size.warm_up, *shape))
        rows += [_row(name, shape, seconds) for shape in seconds]
    return BenchmarkResult(
        tables=[Table("Seconds for each submission", COLUMNS, rows)],
        notes=[
            "speed-up: time of one worker on one core, divided by that of the row, round by round."
        ],
        parameters=asdict(size) | {"sandbox": tier},
    )


def _seconds(folder: Path, tier: str, warm_up: int, workers: int, cores: int) -> float:
    """Seconds per submission of a class that is graded without a cache."""
    with TemporaryDirectory() as out:
        plan = GradingRun(folder / "in", Path(out), ROOT, tier=tier, jobs=workers)  # type: ignore[arg-type]
        with threads(cores), _batch(plan, workers) as batch:
            ends = [time.perf_counter() for _ in batch.records(plan.tasks())]
    return (ends[-1] - ends[warm_up - 1]) / (len(ends) - warm_up)


@contextmanager
def _batch(plan: GradingRun, workers: int) -> Iterator[Batch]:
    kept = (plan.archive, plan.cache, plan.ledger)
    with worker_servers.serving(), worker_servers.worker_pool(workers) as executor:
        _ = [*executor.map(time.sleep, [1.0] * workers)]  # wait until all processes have started
        yield Batch(plan.course, Server(plan.tier), *kept, executor, workers)


def _row(
    name: str, shape: tuple[int, int], seconds: dict[tuple[int, int], list[float]]
) -> tuple[str | int | float, ...]:
    found = seconds[shape]
    gains = [alone / shared for alone, shared in zip(seconds[1, 1], found, strict=True)]
    spread = f"{min(gains):.2f}–{max(gains):.2f}"
    times = statistics.median(found), min(found), max(found)
    return (name, *shape, *times, statistics.median(gains), spread)
