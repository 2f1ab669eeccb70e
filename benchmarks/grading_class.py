"""Grading of three hundred submissions, a tenth of them hostile: the grader's memory.

Every tenth submission is a case of the hostile suite, with its limits. The grader runs in its own
process. The peak memory of the grader and of its workers is read after each third of the class.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from multiprocessing import active_children
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from benchmarks.assignments import ROOT
from benchmarks.memory import largest_memory
from benchmarks.timing import BenchmarkResult, Table, Track

if TYPE_CHECKING:
    from hostile.case import Case

WORKERS = 2
COLUMNS = ("graded", "seconds", "peak memory of the grader in MiB", "statuses")


@dataclass(frozen=True)
class Size:
    submissions: int = 300
    notebooks: int = 14


FULL = Size()
QUICK = Size(submissions=60)
TOY = Size(submissions=3, notebooks=1)


def run(size: Size, track: Track) -> BenchmarkResult:
    lines = list(track(list(printed_lines(size)), "grading_class"))
    rows = [tuple(json.loads(line)) for line in lines]
    fair = rows.pop()
    return BenchmarkResult(
        tables=[Table("After each third of the class", COLUMNS, rows)],
        notes=[
            f"{fair[0]} of {size.submissions} submissions got the fair grade for every question, "
            f"{fair[1]} of them of {fair[2]} hostile ones. The peak is the sum of those of the "
            "trusted processes, of which each worker is one; what students wrote runs in others, "
            "with limits of their own."
        ],
        parameters=asdict(size) | {"workers": WORKERS, "sandbox": fair[3]},
    )


def printed_lines(size: Size) -> Iterator[str]:
    command = [sys.executable, "-m", "benchmarks.grading_class", json.dumps(asdict(size))]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        yield from process.stdout or ()
    if process.returncode:
        raise RuntimeError("the class was not graded")


def grade_class(size: Size) -> None:
    """Grade in this process; print a line after each third, and one about the grades."""
    sys.path.append(str(ROOT / "tests"))
    from fieldgrade.grading.batch import Batch
    from fieldgrade.grading.run import GradingRun, chosen_tier
    from fieldgrade.isolation import worker_servers
    from fieldgrade.isolation.server import Server
    from hostile.conftest import LIMITS

    tier, _ = chosen_tier()
    with TemporaryDirectory() as scratch:
        folder = Path(scratch)
        fair = dict(_class(folder / "in", size, list(_cases(tier))))
        plan = GradingRun(folder / "in", folder / "out", ROOT, tier=tier, jobs=WORKERS)
        start, statuses, good, tamed, done = time.monotonic(), Counter[str](), 0, 0, 0
        with worker_servers.serving(), worker_servers.worker_pool(WORKERS) as executor:
            server, kept = Server(tier, LIMITS), (plan.archive, plan.cache, plan.ledger)
            batch = Batch(plan.course, server, *kept, executor, WORKERS)
            for _, record in batch.records(plan.tasks()):
                done, statuses[record.status] = done + 1, statuses[record.status] + 1
                points = {grade.question: grade.points for grade in record.grades}
                wanted, hostile = fair[record.student]
                is_fair = points == (wanted if record.status != "unreadable" else {})
                good, tamed = good + is_fair, tamed + (is_fair and hostile)
                if not is_fair:
                    print(record.student, record.status, record.notes, file=sys.stderr)
                if done % (size.submissions // 3) == 0:
                    print(json.dumps(_row(done, time.monotonic() - start, statuses)), flush=True)
    count = sum(hostile for _, hostile in fair.values())
    if done != size.submissions or "grader failed" in statuses:
        raise SystemExit(f"{done} of {size.submissions} were graded: {dict(statuses)}")
    print(json.dumps([good, tamed, count, tier]), flush=True)


def _row(done: int, seconds: float, statuses: Counter[str]) -> tuple[int, float, float, str]:
    counts = ", ".join(f"{number} {status}" for status, number in sorted(statuses.items()))
    peak = largest_memory() + sum(largest_memory(worker.pid) for worker in active_children())
    return done, round(seconds, 1), round(peak / 2**20, 1), counts


def _class(
    folder: Path, size: Size, cases: list[Case]
) -> Iterable[tuple[str, tuple[dict[str, float], bool]]]:
    """Write all submissions; yield each name, the fair points, and whether it is hostile."""
    from fieldcheck.questions import questions
    from hostile.case import as_file, notebook

    for k in range(size.submissions):
        student = folder / f"s{k:03}"
        student.mkdir(parents=True)
        if k % 10 == 5:
            case = cases[(k // 10) * len(cases) // (size.submissions // 10 + 1)]
            name, content = case.submitted_file(dict.fromkeys(PLACES, str(folder / "nothing")))
            wanted = case.fair_points()
        else:
            number = f"{k % size.notebooks + 1:02}"
            _, content = as_file(notebook(number))
            name = "work.ipynb"
            wanted = {q.name: float(q.points) for q in questions().values() if q.notebook == number}
        (student / name).write_bytes(content)
        yield student.name, (wanted, k % 10 == 5)


PLACES = ("CANARY", "OUT", "MARK", "ROOT", "HOME", "GRADER", "TCP", "UNIX", "UDP")


def _cases(tier: str) -> Iterator[Case]:
    from hostile import breakdowns, cheats, damage, oddities, trespass

    lists = (
        cheats.CASES,
        breakdowns.LOOPS,
        breakdowns.CRASHES,
        breakdowns.MEMORY,
        breakdowns.FLOODS,
        trespass.LEFTOVERS,
        trespass.FILES,
        trespass.NETWORK,
        trespass.ENVIRONMENT,
        trespass.POISON,
        damage.CASES,
        oddities.CASES,
    )
    yield from (case for its in lists for case in its if tier in case.tiers)


if __name__ == "__main__":
    grade_class(Size(**json.loads(sys.argv[1])))
