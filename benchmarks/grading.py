"""Grading of a class, compared with nbgrader and otter."""

from __future__ import annotations

import ctypes
import json
import os
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks import graders
from benchmarks.assignments import LARGE, ROOT, SMALL, BenchmarkAssignment
from benchmarks.timing import BenchmarkResult, Comparison, Table, Track
from fieldgrade.grading.run import chosen_tier
from fieldgrade.isolation.server import Server

COMMAND = "import sys; from fieldrecon.cli.main import main; sys.exit(main())"
AT_MOST = {(SMALL, "nbgrader"): 1 / 15, (SMALL, "otter"): 1 / 30}
PR_SET_CHILD_SUBREAPER = 36
SECONDS_TO_END = 5.0
MOST_CPU = 0.25
"""Largest processor time in seconds for a submission of the small notebook."""
CALLED = {
    "nbgrader": "nbgrader {} (autograde, one command for {})",
    "otter": "otter {} (run, a command each for {})",
}


@dataclass(frozen=True)
class Size:
    submissions: int = 100
    of_nbgrader: int = 6
    of_otter: int = 3
    assignments: tuple[str, ...] = (SMALL, LARGE)
    repeats: int = 3


FULL = Size()
QUICK = Size(submissions=20, of_nbgrader=2, of_otter=1, repeats=1)
TOY = Size(submissions=3, of_nbgrader=0, of_otter=0, assignments=(SMALL,), repeats=1)


@dataclass(frozen=True)
class Cost:
    """The cost of grading, per submission."""

    seconds: float
    cpu_seconds: float


def run(size: Size, track: Track) -> BenchmarkResult:
    _adopt_orphans()
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # as usual, commands share compiled modules
    comparisons, rows, tiers = [], [], set[str]()
    for name in size.assignments:
        with TemporaryDirectory() as folder:
            bench = Bench(Path(folder), BenchmarkAssignment(name), size)
            costs = bench.in_turn(track)
            tiers |= bench.tiers
        comparisons += list(_compared(name, costs, size))
        rows += list(_rows(name, costs))
    return BenchmarkResult(
        comparisons,
        [Table("Seconds for each submission, medians", COLUMNS, rows)],
        notes=[NOTE],
        parameters=asdict(size) | {"sandbox": ", ".join(sorted(tiers))},
    )


class Bench:
    """All graders on one assignment."""

    def __init__(self, folder: Path, assignment: BenchmarkAssignment, size: Size) -> None:
        self.folder, self.assignment, self.tiers = folder, assignment, set[str]()
        self.count = size.submissions
        (folder / "tables").mkdir()
        for k in range(size.submissions):
            file = folder / "in" / f"s{k:03}" / "work.ipynb"
            file.parent.mkdir(parents=True)
            file.write_bytes(assignment.submission(k))
        self.peers = {
            name: graders.PEERS[name](folder / name, assignment, _files(assignment, number))
            for name, number in (("nbgrader", size.of_nbgrader), ("otter", size.of_otter))
            if number
        }
        self.repeats = size.repeats
        self.cpu_of_sandbox_start = _cpu_of_sandbox_start()

    def in_turn(self, track: Track) -> Mapping[str, list[Cost]]:
        """Grade with each in turn; the first round is not counted.

        Raises
        ------
        RuntimeError
            A grader accepts other answers than the correct ones.
        """
        costs: dict[str, list[Cost]] = {"1": [], "2": []} | {name: [] for name in self.peers}
        rounds = [*costs] * (self.repeats + 1)
        for turn in track(rounds, f"grading, {self.assignment.name}"):
            costs[turn].append(self._with_peer(turn) if turn in self.peers else self._ours(turn))
        return {name: found[1:] for name, found in costs.items()}

    def _ours(self, jobs: str) -> Cost:
        """Grade the whole class by the command, without a cache."""
        with TemporaryDirectory() as out:
            command = [
                sys.executable,
                "-c",
                COMMAND,
                "grade",
                self.folder / "in",
                "--out",
                out,
                "--root",
                ROOT,
                "--jobs",
                jobs,
                "--class",
                self.folder / "tables",
            ]
            start, before = time.perf_counter(), _cpu_of_children()
            done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True)
            if done.returncode not in (0, 3):  # 3: some submissions need the instructor's eyes
                raise RuntimeError(f"fieldrecon grade: {done.stderr}")
            seconds, cpu = time.perf_counter() - start, _cpu_of_children() - before
            cpu += _cpu_in_sandboxes(Path(out)) + int(jobs) * self.cpu_of_sandbox_start
            records = json.loads((Path(out) / "results.json").read_text())["records"]
        self.tiers |= {record["tier"] for record in records}
        found = [
            {g["question"] for g in record["grades"] if g["verdict"]["outcome"] == "right"}
            for record in sorted(records, key=lambda record: record["student"])
        ]
        self._require_right("fieldrecon", found, self.count, inherit=False)
        return Cost(seconds / self.count, cpu / self.count)

    def _with_peer(self, name: str) -> Cost:
        peer = self.peers[name]
        start, before = time.perf_counter(), _cpu_of_children()
        found = peer.grade()
        seconds, cpu = time.perf_counter() - start, _cpu_of_children() - before
        self._require_right(name, found, len(peer.files), inherit=True)
        return Cost(seconds / len(peer.files), cpu / len(peer.files))

    def _require_right(
        self, who: str, found: Sequence[set[str]], count: int, *, inherit: bool
    ) -> None:
        if len(found) != count:
            raise RuntimeError(f"{who} grades {len(found)} submissions instead of {count}")
        for k, questions in enumerate(found):
            wanted = self.assignment.right(k, inherit=inherit)
            if questions != wanted:
                message = f"{who}, submission {k}: {sorted(questions)} instead of {sorted(wanted)}"
                raise RuntimeError(message)


def _files(assignment: BenchmarkAssignment, number: int) -> list[bytes]:
    return [assignment.submission(k) for k in range(number)]


def _adopt_orphans() -> None:
    """Become the parent of orphaned processes on Linux, so that their processor time counts."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def _cpu_of_children() -> float:
    """Processor time of all terminated child processes, including their children."""
    last = time.monotonic() + SECONDS_TO_END
    with suppress(ChildProcessError):
        while time.monotonic() < last:
            if os.waitpid(-1, os.WNOHANG) == (0, 0):
                time.sleep(0.01)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _compared(name: str, costs: Mapping[str, list[Cost]], size: Size) -> list[Comparison]:
    numbers = {"nbgrader": size.of_nbgrader, "otter": size.of_otter}
    return [
        Comparison(
            f"{name}: {size.submissions} submissions, isolated, two workers",
            CALLED[peer].format(graders.version(peer), numbers[peer]),
            [cost.seconds for cost in costs["2"]],
            [cost.seconds for cost in costs[peer]],
            AT_MOST.get((name, peer)),
        )
        for peer in costs
        if peer in numbers
    ]


def _cpu_in_sandboxes(out: Path) -> float:
    """Processor time of the students' code, which the grader records for each process."""
    lines = (out / "ledger.jsonl").read_text().splitlines()
    return sum(json.loads(line)["cpu_seconds"] for line in lines)


def _cpu_of_sandbox_start() -> float:
    """An upper bound of the processor time for starting a sandbox, once per worker."""
    tier, _ = chosen_tier()
    start = time.perf_counter()
    with Server(tier).started():
        return time.perf_counter() - start


COLUMNS = ("assignment", "grader", "seconds", "least", "most", "CPU seconds", "speed-up by workers")
NOTE = (
    f"The grader is the whole command: it starts, archives what was received, grades, writes. On "
    f"the small notebook its CPU seconds, inside and outside the sandbox together, are to be at "
    f"most {MOST_CPU}. Each grader found exactly the right answers, as was required of it; "
    f"fieldrecon also pays a right answer that calls a wrong one."
)


def _rows(name: str, costs: Mapping[str, list[Cost]]) -> list[tuple[str | float, ...]]:
    alone = statistics.median(cost.seconds for cost in costs["1"])
    called = {"1": "fieldrecon, one worker", "2": "fieldrecon, two workers"}
    rows = []
    for who, found in costs.items():
        seconds = [cost.seconds for cost in found]
        median = statistics.median(seconds)
        cpu = statistics.median(cost.cpu_seconds for cost in found)
        speed_up = alone / median if who in called else ""
        rows.append((name, called.get(who, who), median, min(seconds), max(seconds), cpu, speed_up))
    return rows
