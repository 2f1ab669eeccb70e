"""Blended patches: time against patch size and degree, and growth to millions of sites.

Each number comes from a process of its own, which makes the patches, fits and evaluates at as many
queries as there are sites; so its largest memory is what that takes, with the interpreter. The
experiment `partition_of_unity` has the errors of the same choices on other data.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from benchmarks.measure import Chart, Outcome, Table, Track
from benchmarks.memory import largest_memory
from fieldrecon.datasets import franke, uniform
from fieldrecon.partition_of_unity import PartitionOfUnityRBF
from fieldrecon.radial import polyharmonic

STEPS = ("set-up", "fit", "evaluate")


@dataclass(frozen=True)
class Choice:
    """r^power with polynomials on patches of so many sites."""

    power: int
    degree: int
    patch_size: int


@dataclass(frozen=True)
class Size:
    sites: int = 100_000
    choices: tuple[Choice, ...] = (
        *(Choice(3, 1, k) for k in (16, 24, 40, 64)),
        *(Choice(3, 3, k) for k in (16, 24, 40, 64)),
        *(Choice(5, 3, 40), Choice(7, 3, 40), Choice(3, 4, 40), Choice(3, 4, 64)),
    )
    growth: tuple[int, ...] = (10_000, 40_000, 100_000, 400_000, 1_000_000, 4_000_000)
    in_space: int = 200_000
    runs: int = 3


FULL = Size()
QUICK = Size(choices=(Choice(3, 1, 24), Choice(3, 3, 40)), growth=(10_000, 40_000), in_space=20_000)
TOY = Size(300, (Choice(3, 1, 24),), growth=(200, 400), in_space=300, runs=1)


def run(size: Size, track: Track) -> Outcome:
    usual = Choice(3, 3, 40)
    names = {f"{c}": c for c in size.choices}
    chosen = [cost(size.sites, 2, names[c], size.runs) for c in track([*names], "choices")]
    grown = [
        cost(int(n), 2, usual, size.runs) for n in track([str(n) for n in size.growth], "growth")
    ]
    space = cost(size.in_space, 3, Choice(3, 3, 80), size.runs)
    return Outcome(
        parameters=asdict(size) | {"queries": "as many as sites"},
        tables=[choices_table(size, chosen), growth_table(size, grown, space)],
        charts=[growth_chart(size, grown)],
        notes=["p: exponent of the power law s = C n^p fitted, in logarithms, to all sizes."],
    )


def choices_table(size: Size, costs: list[dict[str, float]]) -> Table:
    columns = ("kernel", "degree", "patch", *(f"{s}, s" for s in STEPS), "rms error")
    rows = [
        (f"r^{c.power}", c.degree, c.patch_size, *(cost[s] for s in STEPS), cost["error"])
        for c, cost in zip(size.choices, costs, strict=True)
    ]
    return Table(f"{size.sites} sites and queries, Franke's function", columns, rows)


def growth_table(size: Size, costs: list[dict[str, float]], space: dict[str, float]) -> Table:
    columns = ("sites", "dimension", *(f"{s}, s" for s in STEPS), "memory, GB", "rms error")
    rows: list[tuple[str | int | float, ...]] = [
        (n, d, *(cost[s] for s in STEPS), cost["bytes"] / 1e9, cost["error"])
        for n, d, cost in [
            *((n, 2, cost) for n, cost in zip(size.growth, costs, strict=True)),
            (size.in_space, 3, space),
        ]
    ]
    powers = [exponent(size.growth, [cost[s] for cost in costs]) for s in STEPS]
    return Table("Growth, by default", columns, [*rows, ("p", 2, *powers, "–", "–")])


def growth_chart(size: Size, costs: list[dict[str, float]]) -> Chart:
    lines = {s: [cost[s] for cost in costs] for s in STEPS}
    return Chart("Blended patches", "sites and queries", "seconds", size.growth, lines)


def exponent(sizes: tuple[int, ...], seconds: list[float]) -> float:
    return float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])


def cost(n: int, d: int, choice: Choice, runs: int) -> dict[str, float]:
    """The least seconds of each step, and the largest memory, of several processes."""
    arguments = map(str, (n, d, choice.power, choice.degree, choice.patch_size))
    command = [sys.executable, "-m", "benchmarks.patch_sizes", *arguments]
    root = Path(__file__).parents[1]
    told = [
        json.loads(subprocess.run(command, cwd=root, stdout=subprocess.PIPE, check=True).stdout)
        for _ in range(runs)
    ]
    least = {key: min(t[key] for t in told) for key in told[0]}
    return least | {"bytes": max(t["bytes"] for t in told)}


def measured(n: int, d: int, power: int, degree: int, patch_size: int) -> dict[str, float]:
    """What the process of its own does."""
    x, q = uniform(n, d, seed=1), uniform(n, d, seed=2)
    data, truth = field(x), field(q)
    start = time.perf_counter()
    method = PartitionOfUnityRBF(x, polyharmonic(power), degree, patch_size)
    made = time.perf_counter()
    s = method.field(data)
    fitted = time.perf_counter()
    values = s(q)
    done = time.perf_counter()
    return {
        **dict(zip(STEPS, (made - start, fitted - made, done - fitted), strict=True)),
        "error": math.sqrt(np.mean((values - truth) ** 2)),
        "bytes": largest_memory(),
    }


def field(x: np.ndarray) -> np.ndarray:
    """Franke's function, times a cosine of the third variable."""
    return franke(x[:, :2]) * np.cos(x[:, 2:]).prod(axis=1)


if __name__ == "__main__":
    print(json.dumps(measured(*map(int, sys.argv[1:]))))
