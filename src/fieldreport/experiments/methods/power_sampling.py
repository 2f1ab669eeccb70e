"""Least squares and moving least squares on powers of the sum of the coordinates.

The field (x₁ + x₂)ⁿ is sampled at random points of the unit square and reconstructed at a few other
random points with polynomials of degree one. A single draw does not show which method is better,
and by how much, so the draw is repeated and the errors are reported with their spread.

References
----------
Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 40).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from fieldrecon.datasets.synthetic import power_of_sum, uniform
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.plotting.style import figure, line
from fieldreport.framework.error_measures import order_of_magnitude
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter, require

METHODS = ("LS", "MLS")
MEASURES = ("rms", "max")
LOW, HIGH = 10, 90
REPRODUCED = 1  # power that linear polynomials reproduce: the errors are rounding errors


@dataclass(frozen=True)
class Params(Parameters):
    """The fields, the samples, and the weight."""

    powers: tuple[int, ...] = parameter(
        (1, 2, 3, 4, 5, 6, 7, 8), "powers n of the field", least=1, most=100, order="increasing"
    )
    points: int = parameter(100, "random points at which the field is sampled", least=4)
    queries: int = parameter(10, "random points at which it is reconstructed", least=1)
    draws: int = parameter(1000, "number of draws", least=1)
    epsilon: float = parameter(
        0.01, "ε of the weight 1/(r² + ε²); the square has side 1", least=1e-6, most=1e6
    )
    seed: int = parameter(0, "seed of the draws", least=0)

    def __post_init__(self) -> None:
        super().__post_init__()
        require(
            self.powers[-1] > 1,
            "powers",
            "a list that holds an n of 2 or more: both methods reproduce n = 1",
            self.powers,
        )


QUICK = Params(powers=(1, 2, 3), draws=20)


def run(params: Params, each: Map = map) -> Result:
    """Draw, reconstruct and measure repeatedly."""
    seeds = [(params.seed, draw) for draw in range(params.draws)]
    errors = np.stack(list(each(partial(errors_of_draw, params), seeds)))
    rms = np.sqrt(np.mean(errors**2, axis=2))
    measured = {"rms": rms, "max": np.abs(errors).max(axis=2)}
    all_draws = np.sqrt(np.mean(errors[:, 0] ** 2, axis=(0, 1)))
    best = np.array([best_linear_rms(n) for n in params.powers])
    return Result(
        params=params,
        tables={
            "errors": _table(params, measured),
            "best_linear": _limits(params, all_draws, best),
        },
        facts=_facts(params, rms)
        | {
            "largest_excess_percent": 100 * (all_draws[best > 0] / best[best > 0] - 1).max(),
            "difference_from_lapack": order_of_magnitude(_difference_from_lapack(params)),
        },
        arrays={f"{name}_errors": values for name, values in measured.items()}
        | {"best_linear_rms": best},
    )


def errors_of_draw(params: Params, seed: tuple[int, ...]) -> np.ndarray:
    """Return the errors (method, query, power) of one draw."""
    x, queries, values, truth = _drawn(params, seed)
    methods = (LeastSquares(x), MovingLeastSquares(x, inverse_square(params.epsilon)))
    return np.stack([method.field(values)(queries) - truth for method in methods])


def best_linear_rms(n: int) -> float:
    """Return the rms distance of (x₁ + x₂)ⁿ from its best linear fit over the whole square.

    By symmetry the fit is a + b s with s = x₁ + x₂, so that the squared distance is
    Var sⁿ − Cov(s, sⁿ)² / Var s, in which E sᵐ = 2 (2ᵐ⁺¹ − 1) / ((m + 1)(m + 2)). Least squares
    tends to it as the number of points increases.

    Examples
    --------
    >>> best_linear_rms(1), round(best_linear_rms(2) ** 2 * 180, 12)
    (0.0, 7.0)
    """

    def moment(m: int) -> float:
        return 2 * (2 ** (m + 1) - 1) / ((m + 1) * (m + 2))

    variance = moment(2 * n) - moment(n) ** 2
    covariance = moment(n + 1) - moment(n) * moment(1)
    left = variance - covariance**2 / (moment(2) - moment(1) ** 2)
    return float(np.sqrt(left)) if n > REPRODUCED else 0.0


def _drawn(params: Params, seed: tuple[int, ...]) -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(seed)
    x, queries = uniform(params.points, 2, rng), uniform(params.queries, 2, rng)
    fields = [power_of_sum(n) for n in params.powers]
    values, truth = (np.stack([f(at) for f in fields], axis=-1) for at in (x, queries))
    return x, queries, values, truth


def _table(params: Params, measured: dict[str, np.ndarray]) -> ResultTable:
    columns = (
        f"{method} {measure}{part}"
        for measure in MEASURES
        for method in METHODS
        for part in ("", f" {LOW} %", f" {HIGH} %")
    )
    rows = (
        _row(n, {m: measured[m][:, :, k] for m in MEASURES}) for k, n in enumerate(params.powers)
    )
    return ResultTable(("n", *columns, "LS/MLS rms", "MLS better, % of draws"), tuple(rows))


def _row(n: int, measured: dict[str, np.ndarray]) -> tuple[Cell, ...]:
    cells = (
        _told(n, x)
        for measure in MEASURES
        for method in range(len(METHODS))
        for x in _mean_and_spread(measured[measure][:, method])
    )
    if n == REPRODUCED:
        return n, *cells, "both exact", "both exact"
    ls, mls = measured["rms"].T
    return n, *cells, float(_geometric_mean(ls / mls)), float(100 * np.mean(mls < ls))


def _limits(params: Params, all_draws: np.ndarray, best: np.ndarray) -> ResultTable:
    columns = ("n", "LS rms over all draws", "best linear fit rms, exact")
    rows = zip(params.powers, map(_told, params.powers, all_draws), best, strict=True)
    return ResultTable(columns, tuple(rows))


def _facts(params: Params, rms: np.ndarray) -> dict[str, Cell]:
    curved = [k for k, n in enumerate(params.powers) if n > REPRODUCED]
    ls, mls = rms[:, 0, curved], rms[:, 1, curved]
    ratios = _geometric_mean(ls / mls)
    facts: dict[str, Cell] = {
        "spacing": float(1 / np.sqrt(params.points)),
        "smallest_ratio": ratios.min(),
        "largest_ratio": ratios.max(),
        "mls_better_percent": float(100 * np.mean(mls < ls)),
    }
    for j, k in enumerate(curved):
        n = params.powers[k]
        facts[f"ls_rms_{n}"] = _geometric_mean(ls)[j]
        facts[f"mls_rms_{n}"] = _geometric_mean(mls)[j]
        facts[f"ratio_{n}"] = ratios[j]
    flat = [k for k in range(len(params.powers)) if k not in curved]
    return facts | (
        {"rms_where_both_exact": order_of_magnitude(rms[:, :, flat].max())} if flat else {}
    )


def _difference_from_lapack(params: Params) -> float:
    """Return the relative difference of MLS from a weighted fit by numpy.linalg.lstsq."""
    x, queries, values, truth = _drawn(params, (params.seed, 0))
    errors = errors_of_draw(params, (params.seed, 0))[1]
    differences = []
    for q, error, exact in zip(queries, errors, truth, strict=True):
        w = 1 / (np.sum((x - q) ** 2, axis=1) + params.epsilon**2)
        basis = np.column_stack([np.ones(len(x)), x - q])
        coefficients = np.linalg.lstsq(w[:, None] * basis, w[:, None] * values)[0]
        differences.append(np.abs(coefficients[0] - (exact + error)).max())
    return max(differences) / np.abs(values).max()


def _mean_and_spread(errors: np.ndarray) -> tuple[float, float, float]:
    low, high = np.percentile(errors, [LOW, HIGH])
    return float(_geometric_mean(errors)), low, high


def _geometric_mean(errors: np.ndarray) -> np.ndarray:
    return np.exp(np.mean(np.log(np.maximum(errors, np.finfo(float).tiny)), axis=0))


def _told(n: int, error: float) -> float:
    """Report an error that is only rounding by its order of magnitude."""
    return order_of_magnitude(error) if n == REPRODUCED else float(error)


def plot(result: Result) -> Figure:
    """Errors of both methods against the power, with their spread over the draws."""
    powers = np.array(result.params.powers)
    curved = np.flatnonzero(powers > REPRODUCED)
    alone = {"linestyle": "none"} if len(curved) == 1 else {}
    titles = {"rms": "root mean square error", "max": "largest error"}
    with figure(height=2.6, columns=2, sharey=True) as (page, axes):
        for panel, measure in zip(axes, MEASURES, strict=True):
            errors = result.arrays[f"{measure}_errors"]
            for j, method in enumerate(METHODS):
                look = line(method) | alone
                low, high = np.percentile(errors[:, j, curved], [LOW, HIGH], axis=0)
                panel.fill_between(
                    powers[curved], low, high, color=look["color"], alpha=0.22, linewidth=0
                )
                panel.plot(powers[curved], _geometric_mean(errors[:, j, curved]), **look)
            for n in set(powers) - set(powers[curved]):
                panel.annotate(
                    "both\nexact", (n, 0.04), xycoords=("data", "axes fraction"), ha="center"
                )
            panel.set(title=titles[measure], xlabel="power $n$", yscale="log", xticks=powers)
            panel.set_xlim(powers.min() - 0.6, powers.max() + 0.3)
        rms = axes[0]
        rms.plot(
            powers[curved],
            result.arrays["best_linear_rms"][curved],
            **line("truth", label="best linear fit, exact")
            | ({"marker": "_"} if alone else {})
            | alone,
        )
        rms.set_ylabel("error")
        rms.legend(loc="upper left")
    return page
