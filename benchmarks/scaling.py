"""Scaling with the number of sites and with a second thread."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial

from benchmarks.timing import BenchmarkResult, Table, Track, in_turn, threads
from fieldrecon.datasets.synthetic import franke, uniform
from fieldrecon.fields import Field
from fieldrecon.kernels.conditionally_positive_definite import thin_plate_spline
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.rbf import RBF
from fieldrecon.reconstruction import Reconstruction


@dataclass(frozen=True)
class Size:
    sites_of_mls: tuple[int, ...] = (10_000, 100_000, 1_000_000)
    sites_of_rbf: tuple[int, ...] = (1_000, 2_000, 4_000, 8_000)
    queries: int = 50_000
    repeats: int = 3


FULL = Size()
QUICK = Size(sites_of_mls=(5_000, 50_000), sites_of_rbf=(500, 1_000, 2_000), queries=10_000)
TOY = Size(sites_of_mls=(100, 200), sites_of_rbf=(50, 100), queries=200, repeats=1)


def run(size: Size, track: Track) -> BenchmarkResult:
    methods = {
        "MLS, 20 neighbours, degree 1": (moving_least_squares, size.sites_of_mls),
        "RBF, thin plate": (thin_plate, size.sites_of_rbf),
    }
    rows = []
    for name, (method, sites) in methods.items():
        medians = [times(method, n, size, track, f"{name}, {n} sites") for n in sites]
        for what in ("fit", "evaluate"):
            rows += growth(name, what, sites, [m[what] for m in medians])
    columns = ("method", "what", "sites", "s, 1 thread", "s, 2 threads", "speed-up", "exponent")
    return BenchmarkResult(
        parameters=asdict(size) | {"dimension": 2},
        tables=[Table(f"Seconds; evaluations at {size.queries} queries", columns, rows)],
        notes=["exponent: p where the time on one thread grows like N^p from the row above."],
    )


def moving_least_squares(n: int) -> Reconstruction:
    return MovingLeastSquares(uniform(n, 2, seed=1), wendland(2, 1), neighbors=20)


def thin_plate(n: int) -> Reconstruction:
    return RBF(uniform(n, 2, seed=1), thin_plate_spline())


def times(
    method: Callable[[int], Reconstruction], n: int, size: Size, track: Track, label: str
) -> dict[str, tuple[float, float]]:
    """Median seconds of fit and evaluation, with one thread and with two."""
    x = uniform(size.queries, 2, seed=2)
    field = method(n).field(franke(uniform(n, 2, seed=1)))
    work = {"fit": partial(method, n), "evaluate": partial(Field.__call__, field, x)}
    candidates = {
        f"{what} {number}": partial(on_threads, number, call)
        for what, call in work.items()
        for number in (1, 2)
    }
    seconds = in_turn(candidates, size.repeats, track, label)
    return {
        what: tuple(statistics.median(seconds[f"{what} {number}"]) for number in (1, 2))
        for what in work
    }


def on_threads(number: int, call: Callable[[], object]) -> None:
    with threads(number):
        call()


def growth(
    name: str, what: str, sites: tuple[int, ...], seconds: list[tuple[float, float]]
) -> list[tuple[str | int | float, ...]]:
    rows = []
    for i, (n, (one, two)) in enumerate(zip(sites, seconds, strict=True)):
        known = i > 0
        exponent = math.log(one / seconds[i - 1][0]) / math.log(n / sites[i - 1]) if known else "–"
        rows.append((name, what, n, one, two, one / two, exponent))
    return rows
