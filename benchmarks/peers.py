"""Comparison with other libraries: error against time on the same data.

Each run is a separate process on the same two cores. It imports its method, fits a few sites as a
warm-up, and then times the fit and the evaluation. Therefore the memory belongs to one method, and
a run that does not end can be stopped.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from benchmarks.compared_methods import METHODS, OURS, SMALL
from benchmarks.finished_runs import FinishedRuns
from benchmarks.memory import largest_memory
from benchmarks.scattered_data import DATA, survey_files, survey_samples
from benchmarks.timing import BenchmarkResult, Comparison, Table, Track

PATIENCE = 400.0
"""Time in seconds after which a run is stopped."""
ENOUGH = 60.0
"""Time in seconds after which a run is not repeated."""
YIELDING = "Other programs ran beside, at the lowest priority: they got what these runs left."
ELSEWHERE = "Ratios at the largest sizes that `million` measures are stated there only."
NOT_LARGER = ("front", "noisy", "clusters")
COLUMNS = (
    "data",
    "sites",
    "method",
    "fit s",
    "evaluate s",
    "total s",
    "least s",
    "most s",
    "cpu s",
    "rms error",
    "largest error",
    "left out",
    "memory MiB",
)


def _task(data: str, sites: int) -> str:
    return f"{data}, {sites} sites: fit and evaluate"


LEAST = 2_000
"""Samples of a survey that is measured; those of smaller ones are fitted at once."""
HELD_OUT = 0.2


def of_surveys() -> tuple[tuple[str, tuple[int, ...]], ...]:
    """Four fifths of each survey."""
    counts = {name: len(survey_samples(path)[0]) for name, path in survey_files().items()}
    return tuple((name, (int((1 - HELD_OUT) * n),)) for name, n in counts.items() if n >= LEAST)


@dataclass(frozen=True)
class Size:
    """Numbers of sites of each data set.

    The number of queries is the same, except for the terrain.
    """

    sites: tuple[tuple[str, tuple[int, ...]], ...] = (
        ("smooth", (10**3, 10**4, 10**5, 10**6)),
        *((name, (10**3, 10**4, 10**5)) for name in NOT_LARGER),
        ("cube", (10**4, 2 * 10**5)),
        ("terrain", (50_000,)),
    )
    repeats: int = 3
    """Measurements in each process."""
    rounds: int = 1
    """Rounds, in which each method has its turn, in a new process."""
    methods: tuple[str, ...] = tuple(METHODS)
    elsewhere: tuple[tuple[str, str], ...] = ()
    """Comparisons, by what is measured and the other method, that another benchmark states."""
    kept: Path | None = None
    """A file of the finished runs: a comparison that was interrupted goes on after them."""


LARGEST = (("smooth", 10**6), ("cube", 2 * 10**5))
LARGEST_METHODS = (
    OURS,
    SMALL,
    "fieldrecon MLS, degree 2",
    "SciPy RBF, r³, 40 neighbours",
    "ferreus_rbf, thin plate",
)
"""Sizes and methods of the benchmark `million`."""
FULL = Size(
    Size.sites + of_surveys(),
    elsewhere=tuple((_task(*one), peer) for one in LARGEST for peer in LARGEST_METHODS),
    kept=Path(__file__).parents[1] / "build" / "finished-peers.jsonl",
)
QUICK = Size(tuple((name, (10**3,)) for name, _ in Size.sites) + of_surveys(), repeats=1)
TOY = Size((("smooth", (60,)), ("terrain", (80,))), repeats=1, methods=(OURS, "SciPy LinearND"))


@dataclass(frozen=True)
class Run:
    """The result of one method on one data set, with the seconds of each repetition."""

    data: str
    sites: int
    method: str
    fit: Sequence[float]
    evaluate: Sequence[float]
    cpu: Sequence[float]
    rms: float
    largest: float
    left_out: int
    memory: int

    @property
    def total(self) -> list[float]:
        return [a + b for a, b in zip(self.fit, self.evaluate, strict=True)]

    def and_then(self, later: Run) -> Run:
        """Both in one: all seconds, the largest memory, and the errors, which are the same."""
        return replace(
            self,
            fit=[*self.fit, *later.fit],
            evaluate=[*self.evaluate, *later.evaluate],
            cpu=[*self.cpu, *later.cpu],
            memory=max(self.memory, later.memory),
        )

    def row(self) -> tuple[str | int | float, ...]:
        fit, evaluate, total = map(median, (self.fit, self.evaluate, self.total))
        return (
            self.data,
            self.sites,
            self.method,
            fit,
            evaluate,
            total,
            min(self.total),
            max(self.total),
            median(self.cpu),
            self.rms,
            self.largest,
            self.left_out,
            round(self.memory / 2**20),
        )


def run(size: Size, track: Track) -> BenchmarkResult:
    asked = [
        (data, n, method)
        for data, sizes in size.sites
        for n in sizes
        for method, c in METHODS.items()
        if method in size.methods and c.takes(data, n)
    ]
    names = {" ".join(map(str, a)): a for a in asked}
    runs: dict[str, Run] = {}
    missing: dict[str, str] = {}
    finished = FinishedRuns(size.kept)
    for round_and_name in track([f"{i} {n}" for i in range(size.rounds) for n in names], "peers"):
        name = round_and_name.split(maxsplit=1)[1]
        done = finished.get(round_and_name)
        if done is None and name not in missing:
            done = in_own_process(*names[name], repeats=size.repeats)
            finished.add(round_and_name, done)
        if isinstance(done, str):
            missing[name] = done
        elif done:
            runs[name] = runs[name].and_then(Run(**done)) if name in runs else Run(**done)
    finished.forget()
    return BenchmarkResult(
        parameters={
            "repeats": size.repeats * size.rounds,
            "patience in seconds": int(PATIENCE),
            "not repeated beyond seconds": int(ENOUGH),
            "niceness": os.nice(0),
        },
        comparisons=[
            c
            for data, sizes in size.sites
            for n in sizes
            for c in _ratios([*runs.values()], data, n)
            if (c.what, c.peer) not in size.elsewhere
        ],
        tables=[Table("Runs", COLUMNS, [r.row() for r in runs.values()])],
        notes=[
            "As many queries as sites; of the terrain and of surveys (see `surveys`) all that were "
            "not drawn as sites. An error is "
            'against the truth, over the queries that a method answers; "left out" are those it '
            "does not (outside of the hull). CPU seconds over total seconds is the number of cores "
            "kept busy.",
            *([ELSEWHERE] if size.elsewhere else []),
            *([YIELDING] if os.nice(0) < 0 else []),
            *(f"Did not end well: {what}." for what in missing.values()),
        ],
    )


def _ratios(runs: Sequence[Run], data: str, n: int) -> list[Comparison]:
    runs_here = {r.method: r for r in runs if (r.data, r.sites) == (data, n)}
    if OURS not in runs_here:
        return []
    ours = runs_here[OURS].total
    return [
        Comparison(_task(data, n), r.method, *_of_same_rounds(ours, r.total))
        for r in runs_here.values()
        if r.method != OURS
    ]


def _of_same_rounds(ours: list[float], theirs: list[float]) -> tuple[list[float], list[float]]:
    rounds = min(len(ours), len(theirs))
    return ours[:rounds], theirs[:rounds]


def in_own_process(data: str, n: int, method: str, repeats: int) -> dict[str, Any] | str:
    """The fields of the `Run` of a separate process, or the reason why there is none."""
    command = [sys.executable, "-m", "benchmarks.peers", data, str(n), method, str(repeats)]
    root = Path(__file__).parents[1]
    about = f"{method} on {data}, {n} sites"
    try:
        done = subprocess.run(
            command, cwd=root, capture_output=True, text=True, timeout=PATIENCE, check=False
        )
    except subprocess.TimeoutExpired:
        return f"{about}: stopped after {PATIENCE:.0f} s"
    if done.returncode:
        last = (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
        return f"{about}: {last}"
    fields: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return fields


def in_this_process(data: str, n: int, method: str, repeats: int) -> Run:
    """Time a method in this process."""
    fit, given = METHODS[method].fit, DATA[data](n)
    some = min(n, 500)
    fit(given.points[:some], given.values[:some])(given.x[:10])
    fits, evaluations, cpu = [], [], []
    while len(fits) < repeats and sum(fits) + sum(evaluations) < ENOUGH:
        start, used = time.perf_counter(), time.process_time()
        interpolant = fit(given.points, given.values)
        fitted = time.perf_counter()
        found = np.ravel(interpolant(given.x))
        fits.append(fitted - start)
        evaluations.append(time.perf_counter() - fitted)
        cpu.append(time.process_time() - used)
    answered = np.isfinite(found)
    error = np.abs(found - given.truth)[answered]
    rms = float(np.sqrt(np.mean(error**2)))
    left_out = int((~answered).sum())
    return Run(
        data,
        n,
        method,
        fits,
        evaluations,
        cpu,
        rms,
        float(error.max()),
        left_out,
        largest_memory(),
    )


if __name__ == "__main__":
    data, n, method, repeats = sys.argv[1:]
    print(json.dumps(asdict(in_this_process(data, int(n), method, int(repeats)))))
