"""Choice of ε for moving least squares: errors and three criteria from the data alone.

The weight 1/(r² + ε²) has one parameter. A sweep over six decades shows the errors of value and
gradient, with exact and with noisy data, and three criteria that need only the data: the minimized
objective ψ, ψ divided by the sum of the squared weights, and the leave-one-out error. The regret of
a criterion is the error at its ε divided by the error at the best ε.

References
----------
Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 40), where
the exercise suggests ψ as the measure.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fieldrecon.datasets.synthetic import power_of_sum, uniform
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.plotting.style import figure, line, shades
from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter, require

MEASURES = ("error", "gradient error", "leave-one-out", "ψ", "normalized ψ")
CRITERIA = {"ψ": "psi", "normalized ψ": "normalized_psi", "leave-one-out": "leave_one_out"}

LIMIT = 1e2
"""An ε far above the side of the square, whatever the range of the sweep."""


@dataclass(frozen=True)
class Params(Parameters):
    """The field, its samples and their noise, and the range of ε."""

    power: int = parameter(3, "power n of the field (x₁ + x₂)ⁿ", least=2, most=20)
    points: int = parameter(100, "random points in the unit square", least=8)
    queries: int = parameter(100, "random points where the error is measured", least=1)
    draws: int = parameter(20, "number of draws of points, evaluation points and noise", least=1)
    noises: tuple[float, ...] = parameter(
        (0.0, 0.05, 0.2, 0.5, 1.0),
        "standard deviations of the noise, from 0; the field has the maximum 2ⁿ",
        least=0,
        most=1e6,
        fewest=2,
        order="increasing",
    )
    shown_noise: float = parameter(0.5, "noise shown in the figure beside the exact data", above=0)
    smallest: float = parameter(1e-4, "smallest ε; the square has side 1", least=1e-6, most=1)
    largest: float = parameter(1e2, "largest ε", most=1e6)
    steps: int = parameter(25, "values of ε, in geometric progression", least=3)
    seed: int = parameter(0, "seed of the draws", least=0)

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.noises[0] == 0, "noises", "a list with 0", self.noises)
        require(self.shown_noise in self.noises, "shown_noise", "one of noises", self.shown_noise)
        require(
            self.largest >= 10 * self.smallest,
            "largest",
            f"{10 * self.smallest:g} or more, 10 times smallest",
            self.largest,
        )

    @property
    def epsilons(self) -> np.ndarray:
        """The values of ε."""
        return np.geomspace(self.smallest, self.largest, self.steps)


QUICK = Params(queries=20, draws=2, noises=(0.0, 0.5), steps=7)


def run(params: Params, each: Map = map) -> Result:
    """Sweep ε on every draw, and let each criterion choose."""
    seeds = [(params.seed, draw) for draw in range(params.draws)]
    sweeps = np.stack(list(each(partial(sweep_of_draw, params), seeds)))
    means = np.exp(np.log(sweeps).mean(axis=0))
    return Result(
        params=params,
        tables={
            "sweep": _sweep_table(params, means[..., 0]),
            "sweep_noisy": _sweep_table(
                params, means[..., params.noises.index(params.shown_noise)]
            ),
            "choice": _choice_table(params, sweeps),
        },
        facts=_facts(params, sweeps, means),
        arrays={"epsilons": params.epsilons, "means": means}
        | {f"regret_{key}": regrets(sweeps, c) for c, key in CRITERIA.items()}
        | {f"chosen_{key}": chosen(params, sweeps, c) for c, key in CRITERIA.items()}
        | {"chosen_best": chosen(params, sweeps, "error")},
    )


def sweep_of_draw(params: Params, seed: tuple[int, ...]) -> np.ndarray:
    """Return the measures (measure, ε, noise) of one draw."""
    x, queries, values, field = _drawn(params, seed)
    truth, slopes = field(queries)[:, None], field.gradient(queries)[:, None]
    columns = []
    for epsilon in params.epsilons:
        method = MovingLeastSquares(x, inverse_square(epsilon))
        s = method.field(values)
        columns.append(
            [
                _rms(s(queries) - truth),
                np.sqrt(np.mean(np.sum((s.gradient(queries) - slopes) ** 2, axis=-1), axis=0)),
                _rms(leave_one_out(method, values)),
                method.objective(values, queries).mean(axis=0),
                method.objective(values, queries, normalized=True).mean(axis=0),
            ]
        )
    return np.stack(columns, axis=1)


def chosen(params: Params, sweeps: np.ndarray, measure: str) -> np.ndarray:
    """Return the ε (draw, noise) that minimizes a measure."""
    return params.epsilons[sweeps[:, MEASURES.index(measure)].argmin(axis=1)]


def regrets(sweeps: np.ndarray, criterion: str) -> np.ndarray:
    """Return the error at the ε chosen by a criterion over the smallest error: (draw, noise)."""
    errors = sweeps[:, 0]
    choice = sweeps[:, MEASURES.index(criterion)].argmin(axis=1)
    at_choice = np.take_along_axis(errors, choice[:, None], axis=1)[:, 0]
    return at_choice / errors.min(axis=1)


def _drawn(params: Params, seed: tuple[int, ...]) -> tuple:
    rng = np.random.default_rng(seed)
    x, queries = uniform(params.points, 2, rng), uniform(params.queries, 2, rng)
    field = power_of_sum(params.power)
    noise = rng.standard_normal((params.points, 1)) * np.array(params.noises)
    return x, queries, field(x)[:, None] + noise, field


def _rms(errors: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(errors**2, axis=0))


def _sweep_table(params: Params, means: np.ndarray) -> ResultTable:
    rows = np.column_stack([params.epsilons, *means])
    return ResultTable(("epsilon", *MEASURES), tuple(map(tuple, rows)))


def _choice_table(params: Params, sweeps: np.ndarray) -> ResultTable:
    return ResultTable(
        (
            "noise",
            "best epsilon",
            "best epsilon for the gradient",
            *(f"epsilon by {c}" for c in CRITERIA),
            *(f"regret of {c}" for c in CRITERIA),
        ),
        tuple(_choice_rows(params, sweeps)),
    )


def _choice_rows(params: Params, sweeps: np.ndarray) -> Iterator[tuple[Cell, ...]]:
    for k, noise in enumerate(params.noises):
        epsilons = (chosen(params, sweeps, m)[:, k] for m in ("error", "gradient error", *CRITERIA))
        risks = (regrets(sweeps, c)[:, k] for c in CRITERIA)
        yield noise, *map(_geometric_mean, epsilons), *map(_geometric_mean, risks)


def _facts(params: Params, sweeps: np.ndarray, means: np.ndarray) -> dict[str, Cell]:
    shown = params.noises.index(params.shown_noise)
    psi = sweeps[:, MEASURES.index("ψ")]
    least_squares, limit = _limit_of_psi(params)
    spacing = float(1 / np.sqrt(params.points))
    facts: dict[str, Cell] = {"spacing": spacing}
    for label, k in (("exact", 0), ("noisy", shown)):
        facts[f"best_epsilon_{label}"] = _geometric_mean(chosen(params, sweeps, "error")[:, k])
        facts[f"best_epsilon_gradient_{label}"] = _geometric_mean(
            chosen(params, sweeps, "gradient error")[:, k]
        )
        for criterion, key in CRITERIA.items():
            facts[f"regret_{key}_{label}"] = _geometric_mean(regrets(sweeps, criterion)[:, k])
    error = means[0, :, 0]
    if params.smallest <= spacing <= params.largest:
        at_spacing = np.interp(np.log(spacing), np.log(params.epsilons), np.log(error))
        facts["error_at_spacing_over_smallest"] = np.exp(at_spacing) / error[0]
    flat = error <= 1.01 * error.min()
    return facts | {
        "largest_epsilon_within_1_percent": params.epsilons[flat].max(),
        "psi_falls_percent": float(100 * np.mean(np.diff(psi, axis=1) < 0)),
        "error_at_largest_over_smallest": error[-1] / error[0],
        "scaled_psi": limit,
        "psi_of_least_squares": least_squares,
        "scaled_psi_difference_percent": 100 * abs(limit / least_squares - 1),
    }


def _limit_of_psi(params: Params) -> tuple[float, float]:
    """Return half the squared residual of a fit by numpy.linalg.lstsq, and ε⁴ψ at a large ε.

    As ε grows all weights become 1/ε², so that ε⁴ψ tends to ψ of plain least squares.
    """
    x, queries, values, _ = _drawn(params, (params.seed, 0))
    residual = np.linalg.lstsq(np.column_stack([np.ones(len(x)), x]), values[:, 0])[1]
    method = MovingLeastSquares(x, inverse_square(LIMIT))
    psi = method.objective(values[:, 0], queries).mean()
    return float(residual[0] / 2), float(LIMIT**4 * psi)


def _geometric_mean(x: np.ndarray) -> float:
    return float(np.exp(np.mean(np.log(x))))


LOOKS = {
    "error": line("MLS", marker="", label="error"),
    "gradient error": shades("MLS", 2, marker="", label="gradient error")[1],
    "leave-one-out": line("truth", marker="", linestyle=(0, (3, 1.5)), label="leave-one-out error"),
    "ψ": shades("truth", 2, marker="", label="ψ")[0],
    "normalized ψ": shades("truth", 2, marker="", label="normalized ψ")[1],
}


def plot(result: Result) -> Figure:
    """Errors above and ψ below, against ε; exact data on the left, noisy data on the right."""
    params = result.params
    columns = (
        ("exact data", 0),
        (f"noise σ = {params.shown_noise:g}", params.noises.index(params.shown_noise)),
    )
    with figure(height=4.4, rows=2, columns=2, sharex=True, sharey="row") as (page, axes):
        for (title, k), (errors, objectives) in zip(columns, axes.T, strict=True):
            errors.set_title(title)
            _draw(errors, result, k, ("error", "gradient error", "leave-one-out"))
            _draw(objectives, result, k, ("ψ", "normalized ψ"))
            objectives.set_xlabel("ε")
        spacing = 1 / np.sqrt(params.points)
        left = 10 * spacing > params.largest  # on the right there is no room
        objectives.text(
            spacing / 1.15 if left else spacing * 1.15,
            0.92,
            "spacing",
            ha="right" if left else "left",
            transform=objectives.get_xaxis_transform(),
        )
        axes[0, 0].set_ylabel("root mean square")
        axes[1, 0].set_ylabel("mean over the queries")
        axes[0, 0].legend(loc="upper left")
        axes[1, 0].legend(loc="lower left")
    return page


def _draw(axes: Axes, result: Result, noise: int, measures: tuple[str, ...]) -> None:
    """Draw curves with a dot at the minimum of each, and the spacing of the points."""
    epsilons = result.arrays["epsilons"]
    for measure in measures:
        y = result.arrays["means"][MEASURES.index(measure), :, noise]
        axes.plot(epsilons, y, **LOOKS[measure])
        axes.plot(epsilons[y.argmin()], y.min(), "o", color=LOOKS[measure]["color"])
    spacing = 1 / np.sqrt(result.params.points)
    axes.axvline(spacing, color="0.25", linewidth=0.9, linestyle=":", zorder=1.5)
    axes.set(xscale="log", yscale="log")


def plot_choice(result: Result) -> Figure:
    """The ε that each criterion chooses, and its regret, against the noise."""
    noises = np.array(result.params.noises)
    names = {"best": "best", "psi": "ψ", "normalized_psi": "normalized ψ"}
    names |= {"leave_one_out": "leave-one-out"}
    looks = dict(zip(names, shades("truth", 4), strict=True))
    looks["best"] = line("MLS", label="best")
    with figure(height=2.6, columns=2) as (page, (choices, costs)):
        for key, name in names.items():
            look = looks[key] | {"label": name}
            epsilon = np.exp(np.log(result.arrays[f"chosen_{key}"]).mean(axis=0))
            choices.plot(noises, epsilon, **look)
            if key != "best":
                regret = np.exp(np.log(result.arrays[f"regret_{key}"]).mean(axis=0))
                costs.plot(noises, regret, **look)
        choices.set(title="chosen ε", xlabel="noise σ", yscale="log")
        costs.set(title="regret", xlabel="noise σ", yscale="log")
        costs.set_yticks([1, 2, 5, 10], ["1", "2", "5", "10"])
        costs.legend(*choices.get_legend_handles_labels(), loc="upper right")
    return page
