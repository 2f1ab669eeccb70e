"""Which tests run which lines of the library, recorded once for a state of the code."""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
from collections import defaultdict
from dataclasses import asdict, dataclass
from itertools import accumulate
from pathlib import Path

from coverage import CoverageData
from tools.mutation.judged import ROOT
from tools.mutation.mutants import LIBRARY, Mutant

WORK = ROOT / "build" / "mutation"
"""Copies of the checkout, and what was found so far."""
OF_THE_LIBRARY = ("tests/fieldrecon", "tests/test_laws.py", "tests/test_units.py")
LONGEST = 90.0
"""Seconds that the tests of one mutant may take together; the slowest are left out."""
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "VECLIB_MAXIMUM_THREADS": "1"}


def of_the_copy(folder: Path) -> dict[str, str]:
    """Return the environment of processes that run the code of a copy of the checkout."""
    return {"PYTHONPATH": str(folder / "src"), "PYTHONDONTWRITEBYTECODE": "1"}


@dataclass(frozen=True)
class Reach:
    """For each line of each file the tests that run it, and the seconds of each test."""

    tests: dict[str, dict[int, list[str]]]
    seconds: dict[str, float]

    def of(self, mutant: Mutant) -> list[str]:
        """Return the tests of a statement, fast ones first; of one run by imports, the file's.

        Where all together take too long, the slowest are left out, and those of other folders
        before those of the statement's own.
        """
        by_line = self.tests.get(mutant.path, {})
        lines = range(mutant.statement[0], mutant.statement[1] + 1)
        found = {test for line in lines for test in by_line.get(line, ())}
        found = found or {test for tests in by_line.values() for test in tests}
        room = "tests/fieldrecon/" + Path(mutant.path).parts[2].removesuffix(".py").strip("_")

        def cost(test: str) -> tuple[float, str]:
            return self.seconds.get(test, 0.0), test

        ordered = sorted(found, key=lambda test: (not test.startswith(room), *cost(test)))
        total = accumulate(cost(test)[0] for test in ordered)
        kept = [test for test, until in zip(ordered, total, strict=True) if until <= LONGEST]
        return sorted(kept, key=cost)


def digest() -> str:
    """Return a digest of the library and the tests."""
    files = (f for top in (LIBRARY, ROOT / "tests") for f in sorted(top.rglob("*.py")))
    return hashlib.sha256(b"".join(f.read_bytes() for f in files)).hexdigest()[:16]


def record_reach(folder: Path, jobs: int) -> Reach:
    """Run the tests once with coverage, and note which of them reach which line.

    Of the slow tests these are those of the library. Those of the course and of the grader take
    longer and reach no more.
    """
    print("recording which tests reach which lines (once for this code; ten minutes)", flush=True)
    tests: dict[str, dict[int, set[str]]] = defaultdict(lambda: defaultdict(set))
    seconds: dict[str, float] = defaultdict(float)
    failed: set[str] = set()
    for number, selection in enumerate((("-m", "not slow"), ("-m", "slow", *OF_THE_LIBRARY))):
        data_file = folder / f"coverage-{number}.db"
        command = (
            *(
                sys.executable,
                "-m",
                "pytest",
                "-p",
                "no:cacheprovider",
                "-q",
                "-vv",
                "--durations=0",
            ),
            *(f"--numprocesses={jobs}", *selection),
            *("--cov=src/fieldrecon", "--cov-context=test", "--cov-report="),
        )
        measured = {"COVERAGE_FILE": str(data_file), "COVERAGE_CORE": "ctrace"}
        result = subprocess.run(
            command,
            cwd=folder,
            env=os.environ | of_the_copy(folder) | measured,
            capture_output=True,
            text=True,
            check=False,
        )
        if not data_file.exists():
            sys.exit(f"the tests did not run:\n{result.stdout[-4000:]}{result.stderr[-4000:]}")
        failed |= set(re.findall(r"^(?:FAILED|ERROR) (.*?)(?: - .*)?$", result.stdout, flags=re.M))
        for time, test in re.findall(
            r"^([\d.]+)s (?:call|setup) +(.*)$", result.stdout, flags=re.M
        ):
            seconds[test] += float(time)
        data = CoverageData(str(data_file))
        data.read()
        for file in data.measured_files():
            by_line = tests[Path(file).relative_to(folder).as_posix()]
            for line, contexts in data.contexts_by_lineno(file).items():
                by_line[line] |= {c.rpartition("|")[0] for c in contexts if c}
    if failed:
        print(f"left out, since they fail without a mutant: {', '.join(sorted(failed))}")
    kept = {
        file: {line: sorted(names - failed) for line, names in by_line.items()}
        for file, by_line in tests.items()
    }
    return Reach(kept, dict(seconds))


def reach(folder: Path, jobs: int) -> Reach:
    """Return what was recorded for this code, or record it."""
    kept = WORK / f"reach-{digest()}.json"
    if not kept.exists():
        kept.write_text(json.dumps(asdict(record_reach(folder, jobs))))
    read = json.loads(kept.read_text())
    tests = {f: {int(n): t for n, t in lines.items()} for f, lines in read["tests"].items()}
    return Reach(tests, read["seconds"])
