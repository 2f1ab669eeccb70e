"""Partition-of-unity RBF: error and time by kernel, degree, patch size and overlap; scaling.

The choices are timed in turn in this process. The growth is measured in one process per size, which
sets up the patches, fits, and evaluates at as many queries as sites. Its peak memory includes the
interpreter. The experiment `partition_of_unity` counts multiplications for the same choices, and
also covers the terrain.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.memory import largest_memory
from benchmarks.scattered_data import DATA, Scattered
from benchmarks.timing import BenchmarkResult, Chart, Table, Track
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.partition_of_unity import blending as _blending
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF

STEPS = ("set-up", "fit", "evaluate")
SUPPORT = 7.7
"""Radius of Wendland's function in units of the spacing 1 / sqrt(n)."""
WITHOUT_TIME = ("front", "noisy")
USUAL = {2: 40, 3: 80}
"""Default number of sites per patch, in the plane and in space."""
LARGER = 100_000
"""Number of sites beyond which a second exponent is fitted, because overhead is negligible."""


@dataclass(frozen=True)
class Choice:
    """Kernel, degree of the polynomials, and number of sites per patch."""

    kernel: str
    degree: int
    patch_size: int
    sites_per_box: float = _blending.SITES_PER_BOX

    @property
    def label(self) -> str:
        return f"{self.kernel}, degree {self.degree}"

    def on(self, n: int) -> Radial:
        return {
            "r² log r": thin_plate_spline(),
            "r³": polyharmonic(3),
            "r⁴ log r": polyharmonic(4),
            "r⁵": polyharmonic(5),
            "r⁷": polyharmonic(7),
            "Wendland C⁴": wendland(2, 2, SUPPORT / math.sqrt(n)),
        }[self.kernel]


KINDS = (
    *(("r² log r", degree) for degree in (1, 3)),
    *(("r³", degree) for degree in (1, 2, 3, 4)),
    *((kernel, 3) for kernel in ("r⁴ log r", "r⁵", "r⁷", "Wendland C⁴")),
)


@dataclass(frozen=True)
class Size:
    sites: int = 100_000
    kinds: tuple[tuple[str, int], ...] = KINDS
    patch_sizes: tuple[int, ...] = (16, 24, 40, 64)
    sites_per_box: tuple[float, ...] = (1 / 8, 1 / 5, 1 / 3, 1 / 2)
    growth: tuple[int, ...] = (10_000, 40_000, 100_000, 400_000, 1_000_000, 4_000_000)
    in_space: int = 200_000
    runs: int = 2


FULL = Size()
QUICK = Size(10_000, (("r³", 1), ("r³", 3)), (24, 40), (1 / 3,), (10_000, 40_000), 20_000)
TOY = Size(300, (("r³", 1),), (24, 40), (1 / 3,), growth=(200, 400), in_space=300, runs=1)


def run(size: Size, track: Track) -> BenchmarkResult:
    choices = [Choice(*kind, k) for kind in size.kinds for k in size.patch_sizes]
    overlaps = [Choice("r³", 3, USUAL[2], part) for part in size.sites_per_box]
    samples = {name: DATA[name](size.sites) for name in ("smooth", *WITHOUT_TIME)}
    both = {f"{c}": c for c in (*choices, *overlaps)}
    of = partial(cost_and_errors, samples, runs=size.runs)
    costs = {name: of(both[name]) for name in track([*both], "choices")}
    grown = [
        in_own_processes(int(n), "smooth", size.runs)
        for n in track([*map(str, size.growth)], "growth")
    ]
    space = in_own_processes(size.in_space, "cube", size.runs)
    return BenchmarkResult(
        parameters={"runs": size.runs, "sites": size.sites, "queries": "as many as sites"},
        tables=[
            choices_table(size.sites, {c: costs[f"{c}"] for c in choices}),
            overlap_table(size.sites, {c: costs[f"{c}"] for c in overlaps}),
            growth_table(size, grown, space),
        ],
        charts=[choices_chart(size, costs), growth_chart(size, grown)],
        notes=[
            "Times are the least of the runs. Smooth: Franke's function; front: a step of width "
            "1/25; noisy: Franke's function with errors of 0.01, judged by the function without.",
            "p: exponent of the power law s = C n^p fitted, in logarithms, to all sizes in the "
            f"plane, and to those from {LARGER} sites on; at most 1.15 is wanted.",
        ],
    )


def choices_table(n: int, costs: dict[Choice, dict[str, float]]) -> Table:
    errors = ("smooth", *WITHOUT_TIME)
    columns = (
        "kernel",
        "degree",
        "patch",
        *(f"{s}, s" for s in STEPS),
        "total, s",
        *(f"rms error, {e}" for e in errors),
    )
    rows = [
        (
            c.kernel,
            c.degree,
            c.patch_size,
            *(cost[s] for s in STEPS),
            total(cost),
            *(cost[e] for e in errors),
        )
        for c, cost in costs.items()
    ]
    return Table(f"{n} sites in the square", columns, rows)


def overlap_table(n: int, costs: dict[Choice, dict[str, float]]) -> Table:
    columns = (
        "sites of a box",
        "patches at a site",
        "total, s",
        "rms error, smooth",
        "rms error, front",
    )
    rows = [
        (
            round(c.patch_size * c.sites_per_box, 1),
            cost["overlap"],
            total(cost),
            cost["smooth"],
            cost["front"],
        )
        for c, cost in costs.items()
    ]
    return Table(f"Overlap: {n} sites, patches of {USUAL[2]} about boxes of fewer", columns, rows)


def growth_table(size: Size, costs: list[dict[str, float]], space: dict[str, float]) -> Table:
    columns = ("sites", "dimension", *(f"{s}, s" for s in STEPS), "memory, GB", "rms error")
    every = [
        *((n, 2, c) for n, c in zip(size.growth, costs, strict=True)),
        (size.in_space, 3, space),
    ]
    rows: list[tuple[str | int | float, ...]] = [
        (n, d, *(cost[s] for s in STEPS), cost["bytes"] / 1e9, cost["error"])
        for n, d, cost in every
    ]
    for name, least in (("p", 0), (f"p from {LARGER} on", LARGER)):
        if sum(n >= least for n in size.growth) > 1:
            powers = [exponent(size.growth, costs, s, least) for s in STEPS]
            rows.append((name, 2, *powers, "–", "–"))
    return Table("Growth, by default", columns, rows)


def choices_chart(size: Size, costs: dict[str, dict[str, float]]) -> Chart:
    seconds, errors = {}, {}
    for kind in size.kinds:
        own = [Choice(*kind, k) for k in size.patch_sizes]
        seconds[own[0].label] = [total(costs[f"{c}"]) for c in own]
        errors[own[0].label] = [costs[f"{c}"]["smooth"] for c in own]
    sizes = ", ".join(map(str, size.patch_sizes))
    title = f"{size.sites} sites; patches of {sizes}"
    return Chart(title, "seconds in all", "rms error", seconds, errors)


def growth_chart(size: Size, costs: list[dict[str, float]]) -> Chart:
    lines = {
        f"{s}: p = {exponent(size.growth, costs, s):.2f}": [cost[s] for cost in costs]
        for s in STEPS
    }
    return Chart("Growth, by default", "sites and queries", "seconds", size.growth, lines)


def exponent(
    sizes: Sequence[int], costs: Sequence[dict[str, float]], step: str, least: int = 0
) -> float:
    points = [(n, cost[step]) for n, cost in zip(sizes, costs, strict=True) if n >= least]
    return float(np.polyfit(*np.log(points).T, 1)[0])


def total(cost: dict[str, float]) -> float:
    return sum(cost[s] for s in STEPS)


def cost_and_errors(samples: dict[str, Scattered], choice: Choice, runs: int) -> dict[str, float]:
    """The least seconds of each step on smooth data, and the errors on all data sets."""
    given = samples["smooth"]
    make = partial(
        PartitionOfUnityRBF,
        given.points,
        choice.on(len(given.points)),
        choice.degree,
        choice.patch_size,
    )
    with boxes_of(choice.sites_per_box):
        costs = [steps(make, given) for _ in range(runs)]
        method = make()
    cost = {key: min(t[key] for t in costs) for key in costs[0]}
    cost["smooth"] = cost.pop("error")
    for name in WITHOUT_TIME:
        cost[name] = rms(method.field(samples[name].values)(given.x) - samples[name].truth)
    return cost | {"overlap": method.patch_sizes.sum() / len(given.points)}


@contextmanager
def boxes_of(part: float) -> Iterator[None]:
    """Set the fraction of the sites of a patch that lie in its box."""
    usual, _blending.SITES_PER_BOX = _blending.SITES_PER_BOX, part
    try:
        yield
    finally:
        _blending.SITES_PER_BOX = usual


def steps(make: partial[PartitionOfUnityRBF], given: Scattered) -> dict[str, float]:
    """Seconds of each step, and the rms error."""
    times = [time.perf_counter()]
    method = make()
    times.append(time.perf_counter())
    s = method.field(given.values)
    times.append(time.perf_counter())
    values = s(given.x)
    times.append(time.perf_counter())
    return dict(zip(STEPS, np.diff(times).tolist(), strict=True)) | {
        "error": rms(values - given.truth)
    }


def rms(error: np.ndarray) -> float:
    return math.sqrt(np.mean(error**2))


def in_own_processes(n: int, data: str, runs: int) -> dict[str, float]:
    """The least seconds of each step and the peak memory over several processes."""
    command = [sys.executable, "-m", "benchmarks.patch_sizes", str(n), data]
    root = Path(__file__).parents[1]
    costs = [
        json.loads(subprocess.run(command, cwd=root, stdout=subprocess.PIPE, check=True).stdout)
        for _ in range(runs)
    ]
    least = {key: min(t[key] for t in costs) for key in costs[0]}
    return least | {"bytes": max(t["bytes"] for t in costs)}


def measured(n: int, data: str) -> dict[str, float]:
    """The measurement of one process."""
    given = DATA[data](n)
    return steps(partial(PartitionOfUnityRBF, given.points), given) | {"bytes": largest_memory()}


if __name__ == "__main__":
    print(json.dumps(measured(int(sys.argv[1]), sys.argv[2])))
