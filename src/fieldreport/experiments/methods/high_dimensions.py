"""High dimensions: what can be reconstructed in ten to a hundred variables, and what cannot.

Six functions on the unit cube, all of standard deviation one, are sampled at a thousand sites and
more, and reconstructed at other places; next to the methods stand the mean of the data (error one),
the nearest datum and polynomials by least squares. Besides: how distances concentrate, how large
polynomials and Wendland's functions become, and what is wrong with Halton's points.

References
----------
Wendland, Scattered Data Approximation (2005), chapter 9; Beyer, Goldstein,
Ramakrishnan and Shaft, When is "nearest neighbor" meaningful? (1999).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from fieldrecon.datasets.synthetic import halton, uniform
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.methods.rbf import RBF
from fieldreport.experiments.methods.high_dimensions_cases import FIELDS, METHODS, methods
from fieldreport.experiments.methods.high_dimensions_figures import (
    errors_drawn,
    plot_distances,
    plot_sites,
)
from fieldreport.experiments.methods.high_dimensions_geometry import KINDS, Geometry, sites
from fieldreport.framework.experiment import (
    Cell,
    Map,
    Result,
    Table,
    order_of_magnitude,
    parameter,
    require_at_least,
)

__all__ = ["QUICK", "Params", "plot", "plot_distances", "plot_sites", "run"]

CERTAIN, ROUNDING = 1e-9, 1e-15


@dataclass(frozen=True)
class Params:
    """Numbers of variables, sites and queries."""

    variables: tuple[int, ...] = parameter((3, 5, 10, 20, 50, 100), "numbers of variables")
    sites: int = parameter(1000, "sites, at random in the unit cube")
    more: tuple[int, ...] = parameter((500, 1000, 2000, 4000), "numbers of sites to compare")
    at: int = parameter(10, "variables where numbers of sites are compared; of variables")
    queries: int = parameter(150, "places where errors are measured, at random too")
    large: int = parameter(20000, "places that tell mean and deviation of the functions")
    seed: int = parameter(1, "of sites, queries and functions")

    def __post_init__(self) -> None:
        require_at_least(self, variables=2, sites=20, more=20, queries=1, large=100)
        if self.at not in self.variables:
            raise ValueError(f"parameter at must be one of variables; got {self.at}")


QUICK = Params(variables=(3, 10, 20, 100), sites=150, more=(60, 120), queries=10, large=200)


def run(params: Params, each: Map = map) -> Result:
    """Reconstruct all functions, by all methods, for each number of variables and of sites."""
    cases = [(d, params.sites, "random") for d in params.variables]
    cases += [(params.at, n, "random") for n in params.more]
    cases += [(d, params.sites, kind) for d in params.variables for kind in KINDS[1:]]
    found = np.array(list(each(partial(errors, params), cases)))
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
            "geometry": Table(tuple(Geometry.COLUMNS), tuple(g.row() for g in geometry)),
            "kinds": _kinds(params, geometry, by_variables, by_kind),
        },
        facts=_facts(params, by_variables, by_sites, by_kind, geometry),
        arrays={
            "by_variables": by_variables,
            "by_sites": by_sites,
            "distances": np.stack([g.distances for g in geometry]),
            "last_columns": halton(params.sites, params.variables[-1])[:, -2:],
            "scrambled": halton(params.sites, params.variables[-1], params.seed)[:, -2:],
        },
    )


def errors(params: Params, case: tuple[int, int, str]) -> np.ndarray:
    """Return rms errors (methods, functions) in standard deviations; zero where there is none.

    Of sites that are not random only those of the cubic are wanted. In the last row is the cubic on
    the two variables that matter, for the function of these.
    """
    d, n, kind = case
    x, q = sites(n, d, kind, params.seed), uniform(params.queries, d, params.seed + 1)
    large = uniform(params.large, d, params.seed + 2)
    scale = [(f(large).mean(), f(large).std()) for f in FIELDS]
    data, truth = (
        np.stack([(f(p) - m) / s for f, (m, s) in zip(FIELDS, scale, strict=True)], axis=1)
        for p in (x, q)
    )
    found = np.zeros((len(METHODS) + 1, len(FIELDS)))
    for name, make in methods(d, n).items():
        if kind != "random" and name != "cubic":
            continue
        with suppress(np.linalg.LinAlgError):  # neighbours that do not determine a plane
            error = make(x, data)(q) - truth
            found[METHODS.index(name)] = np.maximum(rms(error), ROUNDING)
    known = RBF(x[:, :2], polyharmonic(3)).field(data[:, 1])(q[:, :2]) - truth[:, 1]
    found[-1, 1] = rms(known)
    return found


def rms(error: np.ndarray) -> np.ndarray:
    """Return the root mean square of each column."""
    return np.sqrt(np.mean(error**2, axis=0))


def _table(what: str, numbers: tuple[int, ...], found: np.ndarray) -> Table:
    columns = (what, "method", *(f.__name__ for f in FIELDS))
    rows = (
        (number, name, *map(_told, row))
        for number, each in zip(numbers, found, strict=True)
        for name, row in zip(METHODS, each, strict=False)
    )
    return Table(columns, tuple(rows))


def _told(error: float) -> Cell:
    if error == 0:
        return "none"
    return float(error) if error > CERTAIN else order_of_magnitude(error)


def _kinds(
    params: Params, geometry: list[Geometry], random: np.ndarray, others: np.ndarray
) -> Table:
    columns = ("variables", "sites", "largest correlation", *(f.__name__ for f in FIELDS))
    cubic = METHODS.index("cubic")
    rows = (
        (d, kind, g.correlations[k], *((random[i], *others[i])[k][cubic].tolist()))
        for i, (d, g) in enumerate(zip(params.variables, geometry, strict=True))
        for k, kind in enumerate(KINDS)
    )
    return Table(columns, tuple(rows))


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
        facts[f"halton_worse_{d}"] = float((kinds[0, cubic] / found[cubic]).max())
    return facts | dict(_rates(params, by_sites))


def _rates(params: Params, by_sites: np.ndarray) -> Iterator[tuple[str, float]]:
    """Yield the exponents p of errors that fall as n^-p."""
    for name in ("nearest", "cubic"):
        errors_of = np.log(by_sites[:, METHODS.index(name)])
        rates = -np.polyfit(np.log(params.more), errors_of, 1)[0]
        yield f"rate_{name}_most", float(rates.max())
        for f, rate in zip(FIELDS, rates, strict=True):
            yield f"rate_{name}_{f.__name__}", float(rate)


def plot(result: Result) -> Figure:
    """Error against the number of variables, for each function and method."""
    return errors_drawn(result.params.variables, result.arrays["by_variables"], "variables")
