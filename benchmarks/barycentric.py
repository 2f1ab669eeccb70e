"""Barycentric coordinates of a hexagon, compared with as many products of arrays.

The weights of n corners are n products of heights, divided by their sum. Therefore the time of n
multiplications of arrays is a lower bound for any program that works on arrays.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

from benchmarks.timing import BenchmarkResult, Comparison, Table, Track, in_turn
from fieldrecon.barycentric.coordinates import BarycentricCoordinates
from fieldrecon.datasets.synthetic import uniform


@dataclass(frozen=True)
class Size:
    queries: int = 1_000_000
    repeats: int = 31


FULL = Size()
QUICK = Size(queries=200_000, repeats=7)
TOY = Size(queries=300, repeats=1)

CORNERS = 6
FRESH = f"{CORNERS} products of arrays, into new memory"
KEPT = f"{CORNERS} products of arrays, into memory kept from before"
AT_MOST = {"values of one field": 6.0, "weights of all corners": 6.0}


def run(size: Size, track: Track) -> BenchmarkResult:
    hexagon = Hexagon(size.queries)
    work = hexagon.work()
    seconds = in_turn(work, size.repeats, track, "barycentric coordinates")
    return BenchmarkResult(
        parameters=asdict(size) | {"corners": CORNERS, "dimension": 2},
        comparisons=[
            Comparison(what, peer, seconds[what], seconds[peer], AT_MOST.get(what))
            for peer in (FRESH, KEPT)
            for what in work
            if what not in (FRESH, KEPT)
        ],
        tables=[hexagon.checks()],
        notes=[
            "The products are of double precision, as are the queries. Those into new memory make "
            f"{CORNERS} new arrays each time, as the weights do; whether the system hands out "
            "pages anew then, or the allocator still has some, is as it comes, and is why the "
            "products into memory that is kept stand beside them.",
            "Weights and products run on one thread. The values come in chunks on two.",
        ],
    )


class Hexagon:
    """An irregular hexagon and points inside it."""

    def __init__(self, queries: int) -> None:
        angle = np.pi / 3 * (np.arange(CORNERS) + uniform(CORNERS, 1, seed=1)[:, 0] / 2)
        self.corners = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        shares = -np.log(uniform(queries, CORNERS, seed=2))
        self.x = shares / shares.sum(axis=1, keepdims=True) @ self.corners
        self.values = uniform(CORNERS, 1, seed=3)[:, 0]
        self.method = BarycentricCoordinates(self.corners)
        self.field = self.method.field(self.values)
        self.factors = list(uniform(queries, 2 * CORNERS, seed=4).T.copy())

    def work(self) -> dict[str, Callable[[], object]]:
        left, right = self.factors[:CORNERS], self.factors[CORNERS:]
        kept = list(np.ones((CORNERS, len(self.x))))
        return {
            FRESH: lambda: [a * b for a, b in zip(left, right, strict=True)],
            "values of one field": lambda: self.field(self.x),
            "weights of all corners": lambda: self.method.weights(self.x),
            "gradients of one field": lambda: self.field.gradient(self.x),
            KEPT: lambda: [
                np.multiply(a, b, out=c) for a, b, c in zip(left, right, kept, strict=True)
            ],
        }

    def checks(self) -> Table:
        """Errors that must be rounding errors."""
        w = self.method.weights(self.x)
        rows = {
            "sum of the weights, less one": w.sum(axis=1) - 1,
            "weights times corners, less the point": w @ self.corners - self.x,
            "negative weights": np.minimum(w, 0),
            "values of the field, less weights times data": self.field(self.x) - w @ self.values,
        }
        largest = [(what, float(np.abs(error).max())) for what, error in rows.items()]
        return Table("Largest errors, all of them rounding", ("what", "largest"), largest)
