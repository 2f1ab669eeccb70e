"""Thin-plate splines through all sites, compared with SciPy's.

If ferreus_rbf is installed, it represents approximate methods that scale to more sites.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from scipy.interpolate import RBFInterpolator

from benchmarks.timing import BenchmarkResult, Comparison, Table, Track, in_turn
from fieldrecon.datasets.synthetic import franke, uniform
from fieldrecon.fields import Field
from fieldrecon.kernels.conditionally_positive_definite import thin_plate_spline
from fieldrecon.methods.rbf import RBF

try:
    import ferreus_rbf
    from ferreus_rbf.interpolant_config import Drift, InterpolantSettings, RBFKernelType
except ImportError:
    ferreus_rbf = None


@dataclass(frozen=True)
class Size:
    sites: int = 10_000
    queries: int = 100_000
    repeats: int = 3


FULL = Size()
QUICK = Size(sites=3_000, queries=20_000)
TOY = Size(sites=200, queries=300, repeats=1)

OURS, SCIPY, FAST = "fieldrecon", "scipy.interpolate.RBFInterpolator", "ferreus_rbf"


class Interpolants:
    """Fits and evaluations of the same data; an evaluation uses the last fit."""

    def __init__(self, points: np.ndarray, x: np.ndarray) -> None:
        self.points, self.values, self.x = points, franke(points), x
        self.fitted: dict = {}
        self.result: dict[str, np.ndarray] = {}

    def fit(self, name: str) -> None:
        self.fitted.pop(name, None)  # release the memory of the last fit first
        self.fitted[name] = {OURS: self._ours, SCIPY: self._scipy, FAST: self._fast}[name]()

    def evaluate(self, name: str) -> None:
        interpolant = self.fitted[name]
        evaluate = interpolant.evaluate if name == FAST else interpolant
        self.result[name] = np.ravel(evaluate(self.x))

    def gradient(self) -> None:
        self.fitted[OURS].gradient(self.x)

    def _ours(self) -> Field:
        return RBF(self.points, thin_plate_spline()).field(self.values)

    def _scipy(self) -> RBFInterpolator:
        return RBFInterpolator(self.points, self.values, kernel="thin_plate_spline")

    def _fast(self) -> object:
        settings = InterpolantSettings(RBFKernelType.ThinPlateSpline, drift=Drift.Linear)
        return ferreus_rbf.RBFInterpolator(self.points, self.values[:, None], settings)


def run(size: Size, track: Track) -> BenchmarkResult:
    them = Interpolants(uniform(size.sites, 2, seed=1), uniform(size.queries, 2, seed=2))
    names = [OURS, SCIPY, *([FAST] if ferreus_rbf else [])]
    candidates = {f"fit {n}": lambda n=n: them.fit(n) for n in names}
    candidates |= {f"evaluate {n}": lambda n=n: them.evaluate(n) for n in names}
    candidates["gradient"] = them.gradient
    seconds = in_turn(candidates, size.repeats, track, "radial basis functions")
    targets = {("fit", SCIPY): 1 / 1.5, ("evaluate", SCIPY): 1 / 2}
    return BenchmarkResult(
        parameters=asdict(size) | {"dimension": 2, "field": "Franke's function"},
        comparisons=[
            *(
                Comparison(
                    what,
                    peer,
                    seconds[f"{what} {OURS}"],
                    seconds[f"{what} {peer}"],
                    targets.get((what, peer)),
                )
                for peer in names[1:]
                for what in ("fit", "evaluate")
            ),
            Comparison(
                "evaluate the gradient",
                "fieldrecon, values",
                seconds["gradient"],
                seconds[f"evaluate {OURS}"],
            ),
        ],
        tables=[accuracy(them)],
        notes=[
            "fieldrecon and SciPy compute the same interpolant to rounding.",
            "ferreus_rbf is approximate (fast multipole sums, an iterative solver) and faster here;"
            " its time grows almost linearly, and it goes on where a dense matrix no longer fits."
            if ferreus_rbf
            else "ferreus_rbf is not installed.",
        ],
    )


def accuracy(them: Interpolants) -> Table:
    truth, ours = franke(them.x), them.result[OURS]
    rows = [
        (name, float(np.sqrt(np.mean((v - truth) ** 2))), float(np.abs(v - ours).max()))
        for name, v in them.result.items()
    ]
    columns = ("method", "rms error against Franke's function", "largest difference to fieldrecon")
    return Table("Accuracy", columns, rows)
