"""Partition-of-unity RBF: error and operation count by kernel, degree and patch size.

Smooth, steep, noisy and rough data are reconstructed by radial basis functions on overlapping
patches, with the same sites and queries for every choice. The experiment does no timing: the cost
is the number of multiplications needed to factor the systems of the patches and to evaluate the
field once for each site.

References
----------
Wendland, Scattered Data Approximation (2005), section 15.4; Franke (1982).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from scipy.interpolate import RBFInterpolator

from fieldrecon.datasets.elevation import terrain
from fieldrecon.datasets.synthetic import franke, halton, uniform
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.plotting.style import figure, hues
from fieldrecon.polynomials import dimension
from fieldreport.framework.error_measures import order_of_magnitude
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter, require

DATA = ("smooth", "front", "noisy", "terrain")


@dataclass(frozen=True)
class Params(Parameters):
    """The sites and the choices."""

    sites: int = parameter(
        6000, "number of sites, at random in the unit square and in the terrain", least=200
    )
    queries: int = parameter(6000, "number of points where errors are measured", least=1)
    sizes: tuple[int, ...] = parameter(
        (16, 24, 40, 64), "numbers of sites in a patch, increasing", least=16, order="increasing"
    )
    told: int = parameter(40, "the patch size for which facts are reported", least=16)
    radius: float = parameter(
        0.1, "radius of Wendland's function; the square has side 1", least=1e-3, most=1e3
    )
    steepness: float = parameter(40.0, "1 / width of the steep front", above=0, most=1e6)
    seed: int = parameter(1, "seed of sites, queries and noise", least=0)

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.told in self.sizes, "told", "one of sizes", self.told)
        nodes = terrain().height.size
        require(
            self.sites + self.queries <= nodes,
            "queries",
            f"{nodes - self.sites} or less, the nodes of the terrain that are not sites",
            self.queries,
        )

    @property
    def choices(self) -> dict[str, tuple[str, Radial, int]]:
        """Label, kernel and degree, by name."""
        return {
            "plate": ("r² log r, degree 1", thin_plate_spline(), 1),
            "cubic": ("r³, degree 1", polyharmonic(3), 1),
            "wendland": ("Wendland C⁴, degree 3", wendland(2, 2, self.radius), 3),
            "default": ("r³, degree 3", polyharmonic(3), 3),
            "logarithmic": ("r⁴ log r, degree 3", polyharmonic(4), 3),
            "quintic": ("r⁵, degree 3", polyharmonic(5), 3),
            "septic": ("r⁷, degree 3", polyharmonic(7), 3),
            "quartics": ("r³, degree 4", polyharmonic(3), 4),
        }


QUICK = Params(sites=600, queries=300, sizes=(24, 40))
TITLES = {
    "smooth": "Franke's function",
    "front": "a steep front",
    "noisy": "noise alone, of size one",
    "terrain": "terrain, m",
}


class SampledData(NamedTuple):
    """Data (n, v) at sites (n, 2), and exact values (m, v) at queries (m, 2)."""

    sites: np.ndarray
    data: np.ndarray
    queries: np.ndarray
    truth: np.ndarray


def run(params: Params, each: Map = map) -> Result:
    """Reconstruct all data with every choice and patch size."""
    cases = [(name, size) for name in params.choices for size in params.sizes]
    found = np.array(list(each(partial(cost_and_errors, params), cases)))
    found = found.reshape(len(params.choices), len(params.sizes), 1 + len(DATA))
    rows: list[tuple[Cell, ...]] = [
        (params.choices[name][0], size, *map(float, numbers))
        for (name, size), numbers in zip(cases, found.reshape(len(cases), -1), strict=True)
    ]
    columns = ("choice", "sites of a patch", "multiplications per site", *TITLES.values())
    return Result(
        params=params,
        tables={"choices": ResultTable(columns, tuple(rows))},
        facts=_facts(params, found)
        | {"difference_from_scipy": order_of_magnitude(_difference(params))},
        arrays={"cost": found[..., 0], "error": found[..., 1:]},
    )


def cost_and_errors(params: Params, case: tuple[str, int]) -> list[float]:
    """Return the multiplications per site, and the rms error for each data set."""
    name, size = case
    _, kernel, degree = params.choices[name]
    errors: list[float] = []
    for samples in (square(params), land(params)):
        method = PartitionOfUnityRBF(samples.sites, kernel, degree, size)
        error = method.field(samples.data)(samples.queries) - samples.truth
        errors += np.sqrt(np.mean(error**2, axis=0)).tolist()
    # a third of the cube to factor, and all coefficients of each patch that reaches a query
    unknowns = method.patch_sizes + dimension(2, degree)
    cost = (unknowns**3 / 3 + method.patch_sizes * unknowns).sum() / params.sites
    return [float(cost), *errors]


def square(params: Params) -> SampledData:
    """Franke's function, a front, and noise around zero, as three components."""
    rng = np.random.default_rng(params.seed)
    x, q = uniform(params.sites, 2, rng), uniform(params.queries, 2, rng)
    data = np.stack([franke(x), front(params, x), rng.standard_normal(len(x))], axis=1)
    return SampledData(x, data, q, np.stack([franke(q), front(params, q), 0 * q[:, 0]], axis=1))


def front(params: Params, x: np.ndarray) -> np.ndarray:
    """Return tanh across a curved line."""
    return np.tanh(params.steepness * (x[:, 1] - 0.5 - 0.2 * np.sin(4 * x[:, 0])))


def land(params: Params) -> SampledData:
    """Heights at some nodes of the terrain, and at others as queries; its longer side is one."""
    whole = terrain()
    x, height = whole.points / whole.points.max(), whole.height.reshape(-1, 1)
    drawn = np.random.default_rng(params.seed).permutation(len(x))
    known, asked = np.split(drawn[: params.sites + params.queries], [params.sites])
    return SampledData(x[known], height[known], x[asked], height[asked])


def _facts(params: Params, found: np.ndarray) -> dict[str, Cell]:
    told = params.sizes.index(params.told)
    facts: dict[str, Cell] = {}
    for name, numbers in zip(params.choices, found[:, told], strict=True):
        for what, number in zip(("cost", *DATA), numbers, strict=True):
            facts[f"{what}_{name}"] = float(number)
    return facts


def _difference(params: Params) -> float:
    """Return the largest difference of a single patch from `scipy.interpolate`."""
    x, q = halton(60, 2), uniform(200, 2, params.seed)
    ours = PartitionOfUnityRBF(x).field(franke(x))(q)
    theirs = RBFInterpolator(x, franke(x), kernel="cubic", degree=3)(q)
    return max(float(np.abs(ours - theirs).max()), 1e-16)


def plot(result: Result) -> Figure:
    """Error against cost for every choice, patches growing along each curve."""
    choices = result.params.choices
    looks = hues(len(choices))
    with figure(height=5.0, rows=2, columns=2) as (page, panels):
        for k, (panel, title) in enumerate(zip(panels.flat, TITLES.values(), strict=True)):
            for i, ((label, *_), look) in enumerate(zip(choices.values(), looks, strict=True)):
                own = {"label": label} if k == 0 else {}
                cost, error = result.arrays["cost"][i], result.arrays["error"][i, :, k]
                panel.plot(cost, error, **look, **own)
            panel.set(title=f"rms error: {title}", xscale="log", yscale="log")
        for panel in panels[1]:
            panel.set_xlabel("multiplications per site")
        page.legend(loc="outside lower center", ncols=3)
    return page
