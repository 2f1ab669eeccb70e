"""Reconstruction in high dimensions: three to a hundred variables.

Six functions on the unit cube, each of standard deviation one, are sampled at a thousand sites and
more and reconstructed at other points. The methods are compared with the mean of the data (error
one), the value at the nearest site and least-squares polynomials. The experiment also shows the
concentration of distances, the growth of polynomials and of Wendland's functions with the
dimension, and the correlation of the coordinates of Halton points.

References
----------
Wendland, Scattered Data Approximation (2005), chapter 9; Beyer, Goldstein,
Ramakrishnan and Shaft, When is "nearest neighbor" meaningful? (1999).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.optimize import brentq
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist

from fieldrecon.datasets.synthetic import franke, halton, uniform
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.kernels.positive_definite import gaussian, wendland
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.plotting.style import figure, line, shades
from fieldrecon.polynomials import dimension
from fieldreport.framework.error_measures import order, order_of_magnitude
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter, require

KINDS = ("random", "halton", "scrambled")
BINS = np.linspace(0, 2.5, 101)
"""Bins of distances, in units of their mean."""
FEW = 500
"""The number of sites with pairwise distances in the histogram."""

Maker: TypeAlias = Callable[[np.ndarray, np.ndarray], Callable[[np.ndarray], np.ndarray]]
"""Maps sites and data to a field."""
MOST_FOR_PATCHES = 10
"""With more variables, each patch contains a large part of all sites, or is the only patch."""

CERTAIN, ROUNDING = 1e-9, 1e-15


@dataclass(frozen=True)
class Params(Parameters):
    """Numbers of variables, sites and queries."""

    variables: tuple[int, ...] = parameter(
        (3, 5, 10, 20, 50, 100), "numbers of variables", least=2, order="increasing"
    )
    sites: int = parameter(1000, "sites, at random in the unit cube", least=20)
    more: tuple[int, ...] = parameter(
        (500, 1000, 2000, 4000), "numbers of sites compared", least=20, fewest=2, order="increasing"
    )
    at: int = parameter(10, "number of variables for which numbers of sites are compared", least=2)
    queries: int = parameter(150, "random points where errors are measured, at least", least=1)
    coordinates: int = parameter(
        15_000,
        "number of coordinates of these points, at least: in few variables there are more",
        least=0,
    )
    draws: int = parameter(5, "draws of sites and queries; errors are medians over them", least=1)
    large: int = parameter(
        20000, "points for the mean and the deviation of the functions", least=100
    )
    seed: int = parameter(1, "seed of sites, queries and functions in the first draw", least=0)

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.at in self.variables, "at", "one of variables", self.at)
        wanted = f"{self.at + 2} or more each, for at = {self.at}"
        require(self.more[0] > self.at + 1, "more", wanted, self.more[0])


QUICK = Params(
    variables=(3, 10, 20, 100),
    sites=150,
    more=(60, 120),
    queries=10,
    coordinates=100,
    draws=2,
    large=200,
)


def run(params: Params, each: Map = map) -> Result:
    """Reconstruct all functions, by all methods, for each number of variables and of sites."""
    cases = [(d, params.sites, "random") for d in params.variables]
    cases += [(params.at, n, "random") for n in params.more]
    cases += [(d, params.sites, kind) for d in params.variables for kind in KINDS[1:]]
    draws = [(*case, params.seed + 3 * k) for case in cases for k in range(params.draws)]
    drawn = np.array(list(each(partial(errors, params), draws)))
    drawn = drawn.reshape(len(cases), params.draws, *drawn.shape[1:])
    found = median_over_draws(drawn)
    number = len(params.variables)
    by_variables, by_sites, by_kind = np.split(found, [number, number + len(params.more)])
    by_kind = by_kind.reshape(number, 2, *found.shape[1:])
    measure = partial(Geometry.of, params.sites, params.queries, params.seed)
    geometry = list(each(measure, params.variables))
    return Result(
        params=params,
        tables={
            "errors": _table("variables", params.variables, by_variables),
            "sites": _table("sites", params.more, by_sites),
            "geometry": ResultTable(tuple(Geometry.COLUMNS), tuple(g.row() for g in geometry)),
            "kinds": _kinds(params, geometry, by_variables, by_kind),
        },
        facts=_facts(params, by_variables, by_sites, by_kind, geometry)
        | dict(_kink(params, drawn)),
        arrays={
            "by_variables": by_variables,
            "by_sites": by_sites,
            "distances": np.stack([g.distances for g in geometry]),
            "last_columns": halton(params.sites, params.variables[-1])[:, -2:],
            "scrambled": halton(params.sites, params.variables[-1], params.seed)[:, -2:],
        },
    )


def median_over_draws(found: np.ndarray) -> np.ndarray:
    """Medians over the second axis; zero if a method could not be computed in some draw."""
    return np.where((found > 0).all(axis=1), np.median(found, axis=1), 0.0)


def queries_in(params: Params, d: int) -> int:
    """Return the number of query points in d variables.

    In three variables few of them are near the centre, where the distance has a kink, and these
    make up most of its error.
    """
    return max(params.queries, params.coordinates // d)


def errors(params: Params, case: tuple[int, int, str, int]) -> np.ndarray:
    """Return rms errors (methods, functions) in standard deviations; zero where not computed.

    For sites that are not random only the errors of the cubic are computed. The last row is the
    cubic on the two relevant variables, for the function of two variables.
    """
    d, n, kind, seed = case
    x, q = sites(n, d, kind, seed), uniform(queries_in(params, d), d, seed + 1)
    large = uniform(params.large, d, seed + 2)
    scale = [(f(large).mean(), f(large).std()) for f in FIELDS]
    data, truth = (
        np.stack([(f(p) - m) / s for f, (m, s) in zip(FIELDS, scale, strict=True)], axis=1)
        for p in (x, q)
    )
    found = np.zeros((len(METHODS) + 1, len(FIELDS)))
    for name, make in methods(d, n).items():
        if kind != "random" and name != "cubic":
            continue
        with suppress(np.linalg.LinAlgError):  # the neighbours do not determine a plane
            error = make(x, data)(q) - truth
            found[METHODS.index(name)] = np.maximum(rms(error), ROUNDING)
    known = RBF(x[:, :2], polyharmonic(3)).field(data[:, 1])(q[:, :2]) - truth[:, 1]
    found[-1, 1] = rms(known)
    return found


def rms(error: np.ndarray) -> np.ndarray:
    """Return the root mean square of each column."""
    return np.sqrt(np.mean(error**2, axis=0))


def _table(what: str, numbers: tuple[int, ...], found: np.ndarray) -> ResultTable:
    columns = (what, "method", *(f.__name__ for f in FIELDS))
    rows = (
        (number, name, *map(_told, row))
        for number, each in zip(numbers, found, strict=True)
        for name, row in zip(METHODS, each, strict=False)
    )
    return ResultTable(columns, tuple(rows))


def _told(error: float) -> Cell:
    if error == 0:
        return "none"
    return float(error) if error > CERTAIN else order_of_magnitude(error)


def _kinds(
    params: Params, geometry: list[Geometry], random: np.ndarray, others: np.ndarray
) -> ResultTable:
    columns = ("variables", "sites", "largest correlation", *(f.__name__ for f in FIELDS))
    cubic = METHODS.index("cubic")
    rows = (
        (d, kind, g.correlations[k], *map(_told, (random[i], *others[i])[k][cubic]))
        for i, (d, g) in enumerate(zip(params.variables, geometry, strict=True))
        for k, kind in enumerate(KINDS)
    )
    return ResultTable(columns, tuple(rows))


def _facts(
    params: Params,
    by_variables: np.ndarray,
    by_sites: np.ndarray,
    by_kind: np.ndarray,
    geometry: list[Geometry],
) -> dict[str, Cell]:
    facts: dict[str, Cell] = {}
    for d, g, found, kinds in zip(params.variables, geometry, by_variables, by_kind, strict=True):
        facts |= {
            f"{name}_{f.__name__}_{d}": cell
            for name, row in zip(METHODS, found, strict=False)
            for f, error in zip(FIELDS, row, strict=True)
            if not isinstance(cell := _told(error), str)
        }
        row = dict(
            zip(
                ("spread", "nearest", "p1", "p2", "p3", "counting", "degree", "half"),
                g.row()[1:],
                strict=True,
            )
        )
        facts |= {f"geometry_{name}_{d}": cell for name, cell in row.items()}
        facts |= {f"correlation_{k}_{d}": c for k, c in zip(KINDS, g.correlations, strict=True)}
        if g.overlap:
            facts[f"overlap_{d}"] = g.overlap
        facts[f"known_{d}"] = float(found[-1, 1])
        cubic = METHODS.index("cubic")
        if found[cubic].all():  # else there are too few sites for a plane
            facts[f"halton_worse_{d}"] = float((kinds[0, cubic] / found[cubic]).max())
    return facts | dict(_rates(params, by_sites))


def _rates(params: Params, by_sites: np.ndarray) -> Iterator[tuple[str, float]]:
    """Yield the exponents p of errors that decrease as n^-p."""
    for name in ("nearest", "cubic"):
        errors_of = by_sites[:, METHODS.index(name)].T
        rates = [-order(params.more, error) for error in errors_of]
        yield f"rate_{name}_most", max(rates)
        for f, rate in zip(FIELDS, rates, strict=True):
            yield f"rate_{name}_{f.__name__}", rate


def _kink(params: Params, drawn: np.ndarray) -> Iterator[tuple[str, float]]:
    """Yield the range over the draws of the error of the cubic for the distance."""
    of_cubic = drawn[:, :, METHODS.index("cubic"), FIELDS.index(radial)]
    for d, each in zip(params.variables, of_cubic, strict=False):
        yield f"cubic_radial_least_{d}", float(each.min())
        yield f"cubic_radial_most_{d}", float(each.max())


def centred(x: np.ndarray) -> np.ndarray:
    """Return variables of mean zero and variance one."""
    return np.sqrt(12) * (x - 0.5)


def ridge(x: np.ndarray) -> np.ndarray:
    """Return a step across the diagonal, equally steep in any number of variables."""
    return np.tanh(2 * centred(x).sum(axis=1) / np.sqrt(x.shape[1]))


def few(x: np.ndarray) -> np.ndarray:
    """Return Franke's function of the first two variables."""
    return franke(x[:, :2])


def additive(x: np.ndarray) -> np.ndarray:
    """Return a sum of cosines of single variables, which no linear function approximates."""
    return np.cos(2 * np.pi * x).sum(axis=1)


def radial(x: np.ndarray) -> np.ndarray:
    """Return the distance from the centre."""
    return np.linalg.norm(x - 0.5, axis=1)


def pairs(x: np.ndarray) -> np.ndarray:
    """Return a sum of products of two variables, with random coefficients."""
    y, d = centred(x), x.shape[1]
    b = np.triu(np.random.default_rng(d).standard_normal((d, d)), 1)
    return np.einsum("ni,ij,nj->n", y, b, y, optimize=True)


def wave(x: np.ndarray) -> np.ndarray:
    """Return a wave across the diagonal, with the same slope along each axis as in one variable."""
    return np.cos(2 * np.pi * x.sum(axis=1))


FIELDS = (ridge, few, additive, radial, pairs, wave)


def methods(d: int, n: int) -> Mapping[str, Maker]:
    """Return the methods by name that are available for a number of sites."""
    wide = gaussian(np.sqrt(d / 6) / 2)  # half the root mean square distance of two sites
    near = min(4 * dimension(d, 1), n - 1)
    made: dict[str, Maker] = {
        "nearest": nearest,
        "linear": partial(fitted, partial(LeastSquares, degree=1)),
        "quadratic": partial(fitted, partial(LeastSquares, degree=2)),
        "near": partial(
            fitted, partial(MovingLeastSquares, weight=wendland(3, 1), degree=1, neighbors=near)
        ),
        "wide": partial(fitted, partial(MovingLeastSquares, weight=wide, degree=1)),
        "cone": partial(fitted, partial(RBF, kernel=polyharmonic(1), degree=1)),
        "cubic": partial(fitted, partial(RBF, kernel=polyharmonic(3))),
        "patches": partial(fitted, PartitionOfUnityRBF),
    }
    refused = {
        "quadratic": dimension(d, 2) > n,
        "patches": d > MOST_FOR_PATCHES,
    }
    return {name: make for name, make in made.items() if not refused.get(name)}


def fitted(
    make: Callable[..., Any], sites: np.ndarray, data: np.ndarray
) -> Callable[[np.ndarray], np.ndarray]:
    """Return a field of the library."""
    return make(sites).field(data)


def nearest(sites: np.ndarray, data: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Return the datum of the nearest site."""
    tree = cKDTree(sites)
    return lambda x: data[tree.query(x)[1]]


METHODS = tuple(methods(2, 100))


def sites(n: int, d: int, kind: str, seed: int) -> np.ndarray:
    """Return points in the unit cube: random, Halton or scrambled Halton."""
    if kind == "random":
        return uniform(n, d, seed)
    return halton(n, d, seed if kind == "scrambled" else None)


@dataclass(frozen=True)
class Geometry:
    """Distances, polynomial dimensions, weights and Halton points in a number of variables."""

    COLUMNS = (
        "variables",
        "deviation / mean of distances",
        "nearest / mean distance",
        "polynomials of degree 1",
        "of degree 2",
        "of degree 3",
        "sites that count near a query",
        "degree of Wendland's function",
        "its width at half height / radius",
    )
    variables: int
    distances: np.ndarray
    spread: float
    nearest: float
    counting: float
    correlations: tuple[float, ...]
    overlap: float

    @classmethod
    def of(cls, n: int, queries: int, seed: int, d: int) -> Geometry:
        """Measure the geometry on n sites."""
        x = sites(n, d, "random", seed)
        some = pdist(x[:FEW])
        histogram = np.histogram(some / some.mean(), BINS, density=True)[0]
        near = float(np.median(cKDTree(x).query(x, 2)[0][:, 1]) / some.mean())
        correlated = [largest_correlation(sites(n, d, kind, seed)) for kind in KINDS]
        count = counting(x, uniform(queries, d, seed + 1))
        spread = float(some.std() / some.mean())
        return cls(d, histogram, spread, near, count, tuple(correlated), overlap(x))

    def row(self) -> tuple[Cell, ...]:
        """Return the cells of the table."""
        d = self.variables
        half = brentq(lambda r: wendland(d, 1)(np.array(r)) - 0.5, 0.0, 1.0)
        polynomials = (dimension(d, m) for m in (1, 2, 3))
        return (d, self.spread, self.nearest, *polynomials, self.counting, d // 2 + 4, half)


def overlap(x: np.ndarray) -> float:
    """Return the mean number of patches that contain a site; zero if there are no patches."""
    if x.shape[1] > MOST_FOR_PATCHES:
        return 0.0
    return PartitionOfUnityRBF(x).patch_sizes.sum() / len(x)


def counting(x: np.ndarray, q: np.ndarray) -> float:
    """Return the effective number of sites near a query, (sum w²)² / sum w⁴.

    Moving least squares squares its weights: a residual counts by w².
    """
    n, d = x.shape
    near = min(4 * dimension(d, 1), n - 1)
    distance = cKDTree(x).query(q, near + 1)[0]
    weight = wendland(3, 1)(distance[:, :-1] / distance[:, -1:]) ** 2
    return float(np.median(weight.sum(axis=1) ** 2 / (weight**2).sum(axis=1)))


def largest_correlation(x: np.ndarray) -> float:
    """Return the largest absolute correlation of two columns."""
    return float(np.abs(np.triu(np.corrcoef(x.T), 1)).max())


def plot(result: Result) -> Figure:
    """Error against the number of variables, for each function and method."""
    return errors_drawn(result.params.variables, result.arrays["by_variables"], "variables")


TITLES = (
    "step across the diagonal",
    "function of two variables",
    "sum of functions of one",
    "distance from the middle",
    "products of all pairs",
    "wave across the diagonal",
)
LEAST, MOST = 8e-4, 12
"""The range of errors in the figures, in standard deviations."""


def _looks() -> dict[str, dict[str, Any]]:
    """Label and line style of each method, in the order of the arrays."""
    straight, curved = shades("LS", 2)
    near, wide = shades("MLS", 2)
    cone, cubic = shades("RBF", 2)
    return {
        "nearest": line("truth", marker="x", linestyle=":", label="nearest datum"),
        "linear": straight | {"label": "LS, linear"},
        "quadratic": curved | {"label": "LS, quadratic"},
        "near": near | {"label": "MLS, near sites"},
        "wide": wide | {"label": "MLS, all sites"},
        "cone": cone | {"label": "RBF, r"},
        "cubic": cubic | {"label": "RBF, r³"},
        "patches": line("PU", label="patches, r³"),
    }


def plot_sites(result: Result) -> Figure:
    """Error against the number of sites."""
    return errors_drawn(result.params.more, result.arrays["by_sites"], "sites")


def errors_drawn(numbers: Sequence[int], found: np.ndarray, what: str) -> Figure:
    """Draw errors (numbers, methods, functions) against the number of variables or of sites."""
    with figure(height=5.2, rows=2, columns=3, sharex=True, sharey=True) as (page, panels):
        for k, (panel, title) in enumerate(zip(panels.flat, TITLES, strict=True)):
            panel.axhline(1, **line("truth", marker="", label="mean of the data"))
            for i, look in enumerate(_looks().values()):
                error = found[:, i, k]
                there = error > 0
                panel.plot(np.array(numbers)[there], error[there], **look)
            panel.set(title=title, xscale="log", yscale="log", ylim=(LEAST, MOST))
            panel.set_xticks(numbers, [f"{n:,}" for n in numbers])
            panel.minorticks_off()
        for panel in panels[1]:
            panel.set_xlabel(f"number of {what}")
        for panel in panels[:, 0]:
            panel.set_ylabel("rms error / deviation")
        handles, labels = panels[0, 0].get_legend_handles_labels()
        page.legend(handles, labels, loc="outside lower center", ncols=3)
    return page


def plot_distances(result: Result) -> Figure:
    """Concentration of distances; the last two coordinates of Halton points."""
    variables, distances = result.params.variables, result.arrays["distances"]
    with figure(height=2.6, columns=3, width_ratios=(1.6, 1, 1)) as (page, panels):
        middles = (np.arange(distances.shape[1]) + 0.5) * 2.5 / distances.shape[1]
        looks = shades("truth", len(variables), marker="")
        for d, density, look in zip(variables, distances, looks, strict=True):
            panels[0].plot(middles, density, **look, label=str(d))
        panels[0].set(title="distances of two sites", xlabel="distance / mean", ylabel="density")
        panels[0].set(xlim=(0, 2.2), ylim=(0, None))
        panels[0].set_yticks([])
        panels[0].legend(title="variables")
        last = variables[-1]
        for panel, name, title in (
            (panels[1], "last_columns", "Halton"),
            (panels[2], "scrambled", "scrambled"),
        ):
            _cloud(panel, result.arrays[name], title, f"$x_{{{last - 1}}}$", f"$x_{{{last}}}$")
    return page


def _cloud(panel: Axes, points: np.ndarray, title: str, across: str, up: str) -> None:
    panel.plot(*points.T, **line("data", markersize=1.2))
    panel.set(title=title, xlabel=across, ylabel=up, aspect="equal", xlim=(0, 1), ylim=(0, 1))
    panel.set_xticks([0, 1])
    panel.set_yticks([0, 1])
