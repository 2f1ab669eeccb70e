"""Moving least squares on nearest neighbours, compared with the search and with compiled fits.

The lower bound is the query of the k-d tree, which every method on nearest neighbours needs.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.spatial import cKDTree

from benchmarks.timing import BenchmarkResult, Comparison, Table, Track, in_turn
from fieldrecon._core.chunks import chunked
from fieldrecon._numerics.neighbor_search import Neighborhood
from fieldrecon.datasets.synthetic import franke, uniform
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.moving_least_squares import MovingLeastSquares

try:
    import wlsqm
except ImportError:
    wlsqm = None

THREADS = 2


@dataclass(frozen=True)
class Size:
    sites: int = 100_000
    queries: int = 300_000
    neighbors: int = 20
    queries_of_yardstick: int = 20_000
    repeats: int = 7


FULL = Size()
QUICK = Size(sites=20_000, queries=50_000, queries_of_yardstick=2_000, repeats=3)
TOY = Size(sites=300, queries=500, queries_of_yardstick=50, repeats=1)


def run(size: Size, track: Track) -> BenchmarkResult:
    points, x = uniform(size.sites, 2, seed=1), uniform(size.queries, 2, seed=2)
    problem = Problem(points, franke(points), x, size.neighbors)
    candidates = {"search": problem.search}
    for degree in (1, 2):
        candidates[f"total {degree}"] = problem.total(degree)
        candidates[f"solve {degree}"] = problem.solve(degree)
        if wlsqm:
            candidates[f"wlsqm {degree}"] = problem.wlsqm(degree)
    seconds = in_turn(candidates, size.repeats, track, "moving least squares")
    few = Problem(points, problem.values, x[: size.queries_of_yardstick], size.neighbors)
    yardstick = {"ours": few.total(1), "scipy": few.local_rbf}
    slow = in_turn(yardstick, min(size.repeats, 3), track, "scipy with neighbours")
    return BenchmarkResult(
        parameters=asdict(size) | {"dimension": 2, "field": "Franke's function"},
        comparisons=[
            *(
                Comparison(
                    f"degree {degree}, in total: tree, search, rank detection, fits",
                    f"scipy.spatial.cKDTree.query(k={size.neighbors}) alone",
                    seconds[f"total {degree}"],
                    seconds["search"],
                    at_most=1.45 if degree == 1 else None,
                )
                for degree in (1, 2)
            ),
            *(
                Comparison(
                    f"degree {degree}, fits alone, neighbourhoods given",
                    "wlsqm, OpenMP",
                    seconds[f"solve {degree}"],
                    seconds[f"wlsqm {degree}"],
                    at_most=1.0,
                )
                for degree in (1, 2)
                if wlsqm
            ),
            Comparison(
                f"degree 1, in total, {size.queries_of_yardstick} queries",
                f"scipy.interpolate.RBFInterpolator(neighbors={size.neighbors})",
                slow["ours"],
                slow["scipy"],
            ),
        ],
        tables=[accuracy(problem, few)],
        notes=[
            "wlsqm is given the coordinates and data of each neighbourhood ready in memory; "
            "gathering them counts in the time of fieldrecon.",
            "RBFInterpolator solves another, larger problem at each query: it is here for scale.",
            *([] if wlsqm else ["wlsqm is not installed."]),
        ],
    )


def accuracy(problem: Problem, few: Problem) -> Table:
    results = {f"fieldrecon, degree {d}": (problem, problem.total(d)()) for d in (1, 2)}
    if wlsqm:
        results |= {f"wlsqm, degree {d}": (problem, problem.wlsqm(d)()) for d in (1, 2)}
    results["scipy RBFInterpolator, nearest neighbours"] = (few, few.local_rbf())
    errors = {name: at.error(values) for name, (at, values) in results.items()}
    rows = [(name, float(np.sqrt(np.mean(e**2))), float(e.max())) for name, e in errors.items()]
    return Table("Errors against Franke's function", ("method", "rms", "maximum"), rows)


class Problem:
    """Sites, data and queries, and the ways to solve the problem."""

    def __init__(self, points: np.ndarray, values: np.ndarray, x: np.ndarray, k: int) -> None:
        self.points, self.values, self.x, self.k = points, values, x, k

    def error(self, values: np.ndarray) -> np.ndarray:
        return np.abs(values - franke(self.x))

    def search(self) -> None:
        cKDTree(self.points).query(self.x, k=self.k, workers=THREADS)

    def total(self, degree: int) -> Callable[[], np.ndarray]:
        return lambda: self.method(degree).field(self.values)(self.x)

    def method(self, degree: int) -> MovingLeastSquares:
        return MovingLeastSquares(self.points, wendland(2, 1), degree, neighbors=self.k)

    def solve(self, degree: int) -> Callable[[], np.ndarray]:
        """The fits without the search, whose result is computed beforehand."""
        method = self.method(degree)
        found = method.search(self.x / method.unit)

        def fits(rows: np.ndarray) -> np.ndarray:
            part = slice(rows[0], rows[-1] + 1)
            known = copy.copy(method)
            known.search = lambda x, without: Neighborhood(  # noqa: ARG005
                found.index[part], found.distance[part], found.reach[part], found.reach_index[part]
            )
            return known._value_rows(self.x[part], self.values[:, None])

        def solve() -> np.ndarray:
            rows = method._chunk_rows(1)
            parts = chunked(fits, np.arange(len(self.x)), rows)
            return np.concatenate([values for _, values in parts])[:, 0]

        return solve

    def wlsqm(self, degree: int) -> Callable[[], np.ndarray]:
        """The fits of wlsqm, weighted towards the query.

        The first coefficient is the value there.
        """
        m = len(self.x)
        _, index = cKDTree(self.points).query(self.x, k=self.k, workers=THREADS)
        near, data = self.points[index], self.values[index]
        coefficients = np.zeros((m, wlsqm.number_of_dofs(2, degree)))

        def each(value: int, dtype: type) -> np.ndarray:
            return np.full(m, value, dtype=dtype)

        def fit() -> np.ndarray:
            wlsqm.fit_2D_many_parallel(
                xk=near,
                fk=data,
                nk=each(self.k, np.int32),
                xi=self.x,
                fi=coefficients,
                sens=None,
                do_sens=False,
                order=each(degree, np.int32),
                knowns=each(0, np.int64),
                weighting_method=each(wlsqm.WEIGHT_CENTER, np.int32),
                ntasks=THREADS,
            )
            return coefficients[:, 0]

        return fit

    def local_rbf(self) -> np.ndarray:
        return RBFInterpolator(self.points, self.values, neighbors=self.k)(self.x)
