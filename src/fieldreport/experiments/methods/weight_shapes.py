"""Bumps and dimples of moving least squares, and their dependence on ε.

The slides warn of bumps and dimples unless ε is substantially larger than the spacing of the
points. Bumps occur with either basis. With constant polynomials, as ε decreases, the field becomes
flat at every point, a staircase in one variable and terraces in two, since its slope there is of
the order of ε⁴. With linear polynomials part of the slope remains, and the terraces become ripples:
extrema that the field does not have, and errors of slope and curvature. An ε of about the spacing
removes them with either basis, and costs accuracy of the values; a larger ε blurs.

References
----------
Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 9);
Shepard, A two-dimensional interpolation function for irregularly-spaced data, ACM National
Conference (1968), for the constant case.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fieldrecon.datasets.synthetic import franke, jittered_grid
from fieldrecon.fields import Field
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.plotting.maps import SHADE, hillshade
from fieldrecon.plotting.style import figure, line, shades
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter, require

DEGREES = {0: "constant", 1: "linear"}
JUDGED = {"tenth": 0.1, "half": 0.5, "spacing": 1.0, "two": 2.0}
"""Values of ε/h at which extrema are counted, by the name that a fact gives them."""


@dataclass(frozen=True)
class Params(Parameters):
    """Sites in one and in two variables, and values of ε relative to their spacing."""

    sites: int = parameter(9, "points on the interval [0, 1]", least=4)
    side: int = parameter(16, "cells along a side of the square, with a point in each", least=3)
    jitter: float = parameter(
        0.6, "fraction of its cell in which a point is drawn", least=0, most=1
    )
    shown: tuple[float, ...] = parameter(
        (0.1, 0.5, 2.0), "values of ε/h that are drawn", least=1e-3, most=1e3, order="increasing"
    )
    smallest: float = parameter(
        0.01, "smallest ε/h of the sweep; h is the side of a cell", least=1e-3, most=1
    )
    largest: float = parameter(10.0, "largest ε/h of the sweep", least=1, most=1e3)
    steps: int = parameter(19, "values of ε/h in the sweep, in geometric progression", least=3)
    curve_points: int = parameter(401, "points on a curve in the figure", least=2)
    relief_side: int = parameter(110, "points along a side of a relief", least=2)
    draws: int = parameter(5, "draws of sites for the count of extrema", least=1)
    fine: int = parameter(
        80, "points along a side of the grid on which errors are measured", least=5
    )
    points_per_epsilon: int = parameter(
        3,
        "points per length ε of the grid on which extrema are counted",
        least=1,
        most=9,
    )
    points_per_spacing: int = parameter(
        10, "points per spacing h of that grid, at least", least=1, most=20
    )
    seed: int = parameter(1, "seed of the jitter; the draws take the seeds that follow", least=0)

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.largest > self.smallest, "largest", "more than smallest", self.largest)


QUICK = Params(steps=5, relief_side=12, curve_points=21, side=6, draws=2, fine=30)


def run(params: Params, each: Map = map) -> Result:
    """Reconstruct a curve and a relief, and sweep ε."""
    ratios = np.geomspace(params.smallest, params.largest, params.steps)
    sites = jittered_grid(params.side, 2, params.jitter, params.seed)
    kept, error = np.stack(list(each(partial(slope_and_error, params, sites), ratios)), axis=-1)
    judged = [(ratio, degree) for ratio in JUDGED.values() for degree in DEGREES]
    bumps = dict(zip(judged, each(partial(bumps_and_errors, params), judged), strict=True))
    columns = [f"{what}, {basis}" for what in ("slope kept", "error") for basis in DEGREES.values()]
    return Result(
        params=params,
        tables={
            "sweep": ResultTable(
                ("epsilon/h", *columns), tuple(map(tuple, np.column_stack([ratios, *kept, *error])))
            ),
            "bumps": _bump_table(bumps),
        },
        facts=_facts(params, sites, kept, error, ratios) | _bump_facts(params, bumps),
        arrays={"ratios": ratios, "kept": kept, "error": error}
        | _curves(params)
        | {"reliefs": _reliefs(params, sites), "relief": franke(_mesh(params.relief_side))}
        | {"square_sites": sites},
    )


def slope_and_error(params: Params, sites: np.ndarray, ratio: float) -> np.ndarray:
    """Return, for both degrees, the reproduced fraction of the slope at the sites, and the error.

    The fraction is the sum of ∇s · ∇f over the sites divided by that of ∇f · ∇f: ideally 1, 0 if
    flat.
    """
    queries, slopes = _mesh(40), franke.gradient(sites)
    fields = [_field(params, sites, degree, ratio) for degree in DEGREES]
    kept = [np.sum(s.gradient(sites) * slopes) / np.sum(slopes**2) for s in fields]
    error = [np.sqrt(np.mean((s(queries) - franke(queries)) ** 2)) for s in fields]
    return np.array([kept, error])


def bumps_and_errors(params: Params, case: tuple[float, int]) -> np.ndarray:
    """Extrema, and rms errors of value, slope and curvature: medians over the draws."""
    ratio, degree = case
    x, counted = _mesh(params.fine), _mesh(counting_side(params, ratio))
    truth, slope, curvature = franke(x), franke.gradient(x), second_derivatives(x)
    found = []
    for draw in range(params.draws):
        sites = jittered_grid(params.side, 2, params.jitter, params.seed + 1 + draw)
        s = _field(params, sites, degree, ratio)
        wrong = s(x) - truth, s.gradient(x) - slope, s.hessian(x) - curvature
        # root mean squares over the points of the norm of a vector and of a matrix
        errors = [np.sqrt(np.sum(e**2) / truth.size) for e in wrong]
        found.append([count_extrema(s(counted)), *errors])
    return np.median(found, axis=0)


def counting_side(params: Params, ratio: float) -> int:
    """Points along a side of a grid that resolves ε and h, the widths of the smallest bumps."""
    per_spacing = max(params.points_per_spacing, params.points_per_epsilon / ratio)
    return max(5, math.ceil(params.side * per_spacing))


def second_derivatives(x: np.ndarray, step: float = 1e-5) -> np.ndarray:
    """Return those of Franke's function by central differences of its gradient, (..., 2, 2)."""
    steps = step * np.eye(2)
    rises = [franke.gradient(x + e) - franke.gradient(x - e) for e in steps]
    return np.stack(rises, axis=-1) / (2 * step)


def count_extrema(values: np.ndarray) -> int:
    """Inner points of a grid whose value is above, or below, those of all eight neighbours."""
    n, m = values.shape
    steps = [(i, j) for i in (0, 1, 2) for j in (0, 1, 2) if (i, j) != (1, 1)]
    around = np.stack([values[i : n - 2 + i, j : m - 2 + j] for i, j in steps])
    middle = values[1:-1, 1:-1]
    return int(np.sum((middle > around.max(axis=0)) | (middle < around.min(axis=0))))


def _bump_table(bumps: dict[tuple[float, int], np.ndarray]) -> ResultTable:
    rows: list[tuple[Cell, ...]] = [
        (DEGREES[k], ratio, *map(float, bumps[ratio, k]))
        for k in DEGREES
        for ratio in JUDGED.values()
    ]
    columns = ("polynomials", "epsilon/h", "extrema", "error", "slope error", "curvature error")
    return ResultTable(columns, tuple(rows))


def _bump_facts(params: Params, bumps: dict[tuple[float, int], np.ndarray]) -> dict[str, Cell]:
    facts: dict[str, Cell] = {"extrema_true": count_extrema(franke(_mesh(params.fine)))}
    for name, ratio in JUDGED.items():
        for degree, basis in DEGREES.items():
            extrema, _, slope, curvature = bumps[ratio, degree]
            facts[f"extrema_{basis}_{name}"] = round(extrema)
            facts[f"slope_error_{basis}_{name}"] = slope
            facts[f"curvature_error_{basis}_{name}"] = curvature
    values = {case: found[1] for case, found in bumps.items()}
    tenth, spacing = JUDGED["tenth"], JUDGED["spacing"]
    facts["error_linear_ratio"] = values[spacing, 1] / values[tenth, 1]
    constant, linear = (bumps[tenth, degree] for degree in DEGREES)
    facts["slope_constant_over_linear"] = constant[2] / linear[2]
    facts["curvature_constant_over_linear"] = constant[3] / linear[3]
    return facts


def curve(x: np.ndarray) -> np.ndarray:
    """Return the field in one variable, which is increasing."""
    return x[..., 0] + 0.12 * np.sin(2 * np.pi * x[..., 0])


def _field(params: Params, sites: np.ndarray, degree: int, ratio: float) -> Field:
    weight = inverse_square(ratio / params.side)
    return MovingLeastSquares(sites, weight, degree).field(franke(sites))


def _mesh(side: int) -> np.ndarray:
    ticks = (np.arange(side) + 0.5) / side
    return np.stack(np.meshgrid(ticks, ticks), axis=-1)


def _curves(params: Params) -> dict[str, np.ndarray]:
    sites = jittered_grid(params.sites, 1, params.jitter, params.seed)
    x = np.linspace(0, 1, params.curve_points)[:, None]
    curves = [
        [
            MovingLeastSquares(sites, inverse_square(ratio / params.sites), degree).field(
                curve(sites)
            )(x)
            for ratio in params.shown
        ]
        for degree in DEGREES
    ]
    return {
        "x": x[:, 0],
        "truth": curve(x),
        "sites": sites[:, 0],
        "values": curve(sites),
        "curves": np.array(curves),
    }


def _reliefs(params: Params, sites: np.ndarray) -> np.ndarray:
    x = _mesh(params.relief_side)
    return np.array(
        [[_field(params, sites, degree, r)(x) for r in params.shown] for degree in DEGREES]
    )


def _facts(
    params: Params, sites: np.ndarray, kept: np.ndarray, error: np.ndarray, ratios: np.ndarray
) -> dict[str, Cell]:
    best = error.argmin(axis=1)
    facts: dict[str, Cell] = {"smallest_ratio": params.smallest, "largest_ratio": params.largest}
    for k, basis in DEGREES.items():
        facts[f"slope_kept_{basis}_smallest"] = kept[k, 0]
        facts[f"slope_kept_{basis}_at_spacing"] = np.interp(0, np.log(ratios), kept[k])
        facts[f"error_{basis}_smallest"] = error[k, 0]
        facts[f"error_{basis}_largest"] = error[k, -1]
        facts[f"error_{basis}_least"] = error[k].min()
        facts[f"best_ratio_{basis}"] = ratios[best[k]]
        facts[f"best_ratio_for_slope_{basis}"] = ratios[kept[k].argmax()]
        facts[f"slope_kept_{basis}_most"] = kept[k].max()
    return facts | _slope_against_its_limit(params, sites)


def _slope_against_its_limit(params: Params, sites: np.ndarray) -> dict[str, Cell]:
    """Compare the slope at the sites, with constants, to the leading term of its expansion in ε.

    At site k it is 4 ε⁴ Σ (pᵢ − p_k)(fᵢ − f_k) / |pᵢ − p_k|⁶, the sum going over the others.
    """
    values = franke(sites)
    apart = sites[None] - sites[:, None]
    rise = values[None] - values[:, None]
    r = np.linalg.norm(apart, axis=-1)
    np.fill_diagonal(r, np.inf)
    epsilon = params.smallest / params.side
    limit = 4 * epsilon**4 * np.sum(apart * (rise / r**6)[..., None], axis=1)
    slope = _field(params, sites, 0, params.smallest).gradient(sites)
    return {
        "rms_slope_constant_smallest": np.sqrt(np.mean(slope**2)),
        "rms_slope_by_expansion": np.sqrt(np.mean(limit**2)),
        "slope_difference_percent": 100 * np.linalg.norm(slope - limit) / np.linalg.norm(limit),
    }


def plot(result: Result) -> Figure:
    """The curve from constant and from linear polynomials, for a few values of ε/h."""
    a = result.arrays
    looks = shades("MLS", len(result.params.shown), marker="")
    with figure(height=2.7, columns=2, sharey=True) as (page, axes):
        for panel, basis, curves in zip(axes, DEGREES.values(), a["curves"], strict=True):
            panel.plot(a["x"], a["truth"], **line("truth", linestyle=":", label="field"))
            for ratio, y, look in zip(result.params.shown, curves, looks, strict=True):
                panel.plot(a["x"], y, **look, label=f"ε = {ratio:g} h")
            panel.plot(a["sites"], a["values"], "o", color="black", markersize=3, label="data")
            panel.set(title=f"{basis} polynomials", xlabel="$x$")
        axes[0].legend(loc="upper left")
    return page


def plot_relief(result: Result) -> Figure:
    """Franke's function from constant (above) and linear polynomials (below), as lit reliefs."""
    shown, a = result.params.shown, result.arrays
    with figure(height=3.4, rows=2, columns=1 + len(shown)) as (page, axes):
        for row, basis, reliefs in zip(axes, DEGREES.values(), a["reliefs"], strict=True):
            for panel, ratio, heights in zip(row, shown, reliefs, strict=False):
                _draw_relief(panel, heights, f"{basis}, ε = {ratio:g} h")
        _draw_relief(axes[0, -1], a["relief"], "the field")
        _draw_relief(axes[1, -1], a["relief"], "and its samples")
        axes[1, -1].plot(*a["square_sites"].T, ".", color="black", markersize=2)
    return page


def _draw_relief(axes: Axes, heights: np.ndarray, title: str) -> None:
    light = hillshade(heights, 1 / len(heights), 1 / len(heights))
    axes.imshow(light, cmap=SHADE, vmin=0, vmax=1, extent=(0, 1, 0, 1))
    axes.set(title=title, xticks=[], yticks=[], xlim=(0, 1), ylim=(0, 1))
    axes.grid(visible=False)
    axes.spines[:].set_visible(True)


def plot_sweep(result: Result) -> Figure:
    """The reproduced fraction of the slope at the sites, and the error, against ε/h."""
    a = result.arrays
    looks = dict(zip(DEGREES.values(), shades("MLS", 2, marker=""), strict=True))
    with figure(height=2.5, columns=2) as (page, (slopes, errors)):
        for basis, kept, error in zip(DEGREES.values(), a["kept"], a["error"], strict=True):
            slopes.plot(a["ratios"], kept, **looks[basis], label=f"{basis} polynomials")
            errors.plot(a["ratios"], error, **looks[basis])
        slopes.set(
            title="slope at the samples / true slope",
            xscale="log",
            xlabel="ε / h",
            ylim=(-0.05, 1.1),
        )
        errors.set(title="root mean square error", xscale="log", yscale="log", xlabel="ε / h")
        slopes.legend(loc="center left")
    return page
