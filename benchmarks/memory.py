"""Peak memory of an evaluation, relative to its inputs, its outputs and one stated chunk.

The stated chunk is `CHUNK_BYTES` for each thread. Two processes read the same fitted field: one
evaluates it, the other only allocates an array of the size of the result. The difference of their
peaks is the memory of the evaluation.
"""

from __future__ import annotations

import pickle
import re
import resource
import subprocess
import sys
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from benchmarks.timing import BenchmarkResult, Table, Track, cores
from fieldrecon._core.chunks import CHUNK_BYTES
from fieldrecon.datasets.synthetic import franke, uniform
from fieldrecon.fields import Field
from fieldrecon.kernels.conditionally_positive_definite import thin_plate_spline
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.rbf import RBF

AT_MOST = 1.5
# Bytes allocated during the measurement, so that the peak is not that of the imports.
BALLAST = 2**28
METHODS = {
    "MLS": lambda n: MovingLeastSquares(uniform(n, 2, seed=1), wendland(2, 1), 2, neighbors=20),
    "RBF": lambda n: RBF(uniform(n, 2, seed=1), thin_plate_spline()),
}


@dataclass(frozen=True)
class Size:
    sites: int = 1_000
    queries: tuple[int, ...] = (200_000, 2_000_000)
    methods: tuple[str, ...] = tuple(METHODS)
    results: tuple[str, ...] = ("values", "gradient")


FULL = Size()
QUICK = Size(queries=(200_000,))
TOY = Size(sites=60, queries=(500,), methods=("MLS",), results=("values",))


def run(size: Size, track: Track) -> BenchmarkResult:
    cases = {
        f"{method}, {what}, {m}": (method, what, m)
        for method in size.methods
        for what in size.results
        for m in size.queries
    }
    fitted = {method: pickle.dumps(field_of(method, size.sites)) for method in size.methods}
    rows = [
        row(*case, fitted[case[0]]) for case in (cases[name] for name in track([*cases], "memory"))
    ]
    return BenchmarkResult(
        parameters=asdict(size) | {"dimension": 2, "chunk": stated_chunk(), "at most": AT_MOST},
        tables=[
            Table(
                "Peak memory in MiB",
                (
                    "method",
                    "what",
                    "queries",
                    "inputs and outputs",
                    "stated chunk",
                    "evaluating",
                    f"ratio (at most {AT_MOST})",
                ),
                rows,
            )
        ],
        notes=["ratio = (inputs + outputs + evaluating) / (inputs + outputs + stated chunk)"],
    )


def stated_chunk() -> int:
    """Bytes of one chunk for each thread."""
    return CHUNK_BYTES * cores()


def field_of(method: str, sites: int) -> Field:
    return METHODS[method](sites).field(franke(uniform(sites, 2, seed=1)))


def row(method: str, what: str, m: int, fitted: bytes) -> tuple[str | int | float, ...]:
    held = 8 * 2 * m + 8 * m * (2 if what == "gradient" else 1)
    with_it, without = (peak_of(fitted, what, m, doing) for doing in ("evaluate", "hold"))
    evaluating = with_it - without
    chunk = stated_chunk()
    ratio = (held + evaluating) / (held + chunk)
    return (method, what, m, *(round(b / 2**20, 1) for b in (held, chunk, evaluating)), ratio)


def peak_of(fitted: bytes, *how: str | int) -> int:
    """Peak memory of a separate process in bytes."""
    command = [sys.executable, "-m", "benchmarks.memory", *map(str, how)]
    root = Path(__file__).parents[1]
    done = subprocess.run(command, cwd=root, input=fitted, stdout=subprocess.PIPE, check=True)
    return int(done.stdout)


def evaluate_or_hold(what: str, m: str, doing: str) -> int:
    """The work of the separate process. It reads a field, which leaves less garbage than a fit."""
    field = pickle.load(sys.stdin.buffer)
    evaluate = field.gradient if what == "gradient" else field
    x = uniform(int(m), 2, seed=2)
    evaluate(x[:2])
    ballast = np.ones(BALLAST // 8)
    if doing == "evaluate":
        evaluate(x)
    else:
        np.ones(evaluate(x[:1]).size * len(x))
    del ballast
    return largest_memory()


def largest_memory(process: int | str = "self") -> int:
    """Peak memory of a process in bytes; processes other than this one on Linux only."""
    status = Path(f"/proc/{process}/status")
    if status.exists():  # on Linux ru_maxrss starts with the peak of the parent
        return 1024 * int(re.search(r"VmHWM:\s*(\d+) kB", status.read_text())[1])
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


if __name__ == "__main__":
    print(evaluate_or_hold(*sys.argv[1:]))
