"""Mairhuber-Curtis theorem: a determinant that vanishes while two points exchange places.

Three points admit interpolation in the span of 1, x and y if and only if the determinant of these
functions at the points is not zero. Two of the points are exchanged along paths that meet neither
each other nor the third point. Two rows are then exchanged, so the determinant ends with the
opposite sign, and vanishes on the way; the same happens to six points and quadratics. Radial basis
functions, whose centres move with the points, keep a determinant of fixed sign.

References
----------
Mairhuber, On Haar's theorem (1956); Curtis, n-parameter families and best approximation (1959).
Wendland, Scattered Data Approximation (2005), section 1.4 and theorem 2.3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.optimize import brentq
from scipy.spatial.distance import cdist, pdist

from fieldrecon.kernels.conditionally_positive_definite import thin_plate_spline
from fieldrecon.kernels.positive_definite import gaussian
from fieldrecon.methods.least_squares import LeastSquares
from fieldrecon.methods.rbf import RBF
from fieldrecon.plotting.style import METHOD_COLORS, figure, line
from fieldrecon.polynomials import monomials
from fieldreport.framework.experiment import Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter

TIMES = np.linspace(0.0, 1.0, 241)
THIRD = np.array([[0.55, 0.75]])
Basis = Callable[[np.ndarray], np.ndarray]
OTHERS = np.array([[0.55, 0.75], [-0.9, -0.35], [0.1, -0.95], [0.95, -0.6]])


@dataclass(frozen=True)
class Params(Parameters):
    """The paths of the points."""

    rise: float = parameter(
        0.6, "height of the ellipse on which two points change places", least=0.05, most=1
    )
    scale: float = parameter(
        1.0, "scale of the Gaussian that moves with the points", least=0.05, most=10
    )
    frames: int = parameter(5, "frames of the strip, the singular one among them", least=3, most=12)


QUICK = Params(rise=0.4, frames=3)


def exchanged(rise: float, others: np.ndarray, t: float) -> np.ndarray:
    """Return the points at time t: two on opposite ends of an ellipse's diameter, and the others.

    >>> exchanged(0.5, THIRD, 1.0)[:2].round(12) + 0.0
    array([[-1.,  0.],
           [ 1.,  0.]])
    """
    first = np.array([np.cos(np.pi * t), rise * np.sin(np.pi * t)])
    return np.vstack([first, -first, others])


def determinant(basis: Basis, points: np.ndarray) -> float:
    """Determinant of the functions at the points."""
    return float(np.linalg.det(basis(points)))


def gaussians(scale: float, points: np.ndarray) -> np.ndarray:
    """Gaussians centred at the points, evaluated at the points."""
    return gaussian(scale)(cdist(points, points))


def bordered(points: np.ndarray) -> np.ndarray:
    """Thin-plate kernels centred at the points, bordered by 1, x and y."""
    return RBF(points, thin_plate_spline()).matrix()


def run(params: Params, each: Map = map) -> Result:
    """Compute the determinants along the paths, and the zeros of those of fixed functions."""
    ways: dict[str, tuple[Basis, np.ndarray]] = {
        "1, x, y": (partial(monomials, degree=1), THIRD),
        "quadratics": (partial(monomials, degree=2), OTHERS),
        "gaussians": (partial(gaussians, params.scale), THIRD),
        "thin plates": (bordered, OTHERS),
    }
    curves = np.array(list(each(partial(curve, params.rise), ways.values())))
    zeros = {name: zero(params.rise, *ways[name]) for name in ("1, x, y", "quadratics")}
    singular = exchanged(params.rise, THIRD, zeros["1, x, y"])
    times = np.linspace(0, 1, params.frames)
    times[np.argmin(np.abs(times - zeros["1, x, y"]))] = zeros["1, x, y"]
    smallest = min(
        pdist(exchanged(params.rise, others, t)).min() for t in TIMES for others in (THIRD, OTHERS)
    )
    return Result(
        params=params,
        tables={
            "determinants": ResultTable(
                ("functions", "first", "last", "smallest", "largest"),
                tuple(
                    (name, d[0], d[-1], d.min(), d.max())
                    for name, d in zip(ways, curves, strict=True)
                ),
            )
        },
        facts={
            "time_linear": zeros["1, x, y"],
            "time_linear_exact": collinear_time(params.rise),
            "time_quadratic": zeros["quadratics"],
            "ratio_linear": curves[0, -1] / curves[0, 0],
            "ratio_quadratic": curves[1, -1] / curves[1, 0],
            "ratio_gaussians": curves[2, -1] / curves[2, 0],
            "ratio_thin_plates": curves[3, -1] / curves[3, 0],
            "closest": smallest,
            "refusal": refusal(singular),
            "least_gaussians": curves[2].min() / curves[2, 0],
            "least_thin_plates": np.abs(curves[3]).min() / abs(curves[3, 0]),
        },
        arrays={
            "times": times,
            "curves": curves,
            "frames": np.array([exchanged(params.rise, THIRD, t) for t in times]),
            "path": np.array([exchanged(params.rise, THIRD, t)[:2] for t in TIMES]),
        },
    )


def curve(rise: float, way: tuple[Basis, np.ndarray]) -> list[float]:
    """Return the determinant at all times."""
    basis, others = way
    return [determinant(basis, exchanged(rise, others, t)) for t in TIMES]


def zero(rise: float, basis: Basis, others: np.ndarray) -> float:
    """Return a time at which the determinant vanishes; there is one, since it changes sign."""
    return float(brentq(lambda t: determinant(basis, exchanged(rise, others, t)), 0, 1, xtol=1e-14))


def collinear_time(rise: float) -> float:
    """Return when the line through both points, which passes through 0, meets the third.

    The direction (cos πt, rise sin πt) is parallel to (x, y) where tan πt = y / (rise x).
    """
    x, y = THIRD[0]
    return float(np.arctan2(y, rise * x) / np.pi % 1)


def refusal(singular: np.ndarray) -> str:
    """Return the error message of least squares for three collinear points."""
    try:
        LeastSquares(singular)
    except np.linalg.LinAlgError as error:
        return str(error)
    return "none"


def plot(result: Result) -> Figure:
    """A strip of frames, and the determinant of 1, x and y under it."""
    a = result.arrays
    with figure(height=3.6, rows=2, columns=len(a["times"]), height_ratios=[1, 1.25]) as (
        page,
        axes,
    ):
        for panel, points, t in zip(axes[0], a["frames"], a["times"], strict=True):
            _frame(panel, a["path"], points, t)
        for panel in axes[1]:
            panel.remove()
        below = page.add_subplot(axes[0, 0].get_gridspec()[1, :])
        for name, values, look in zip(
            ("1, $x$, $y$", "quadratics", "Gaussians", "thin plates"),
            a["curves"],
            (
                line("LS", marker=""),
                line("MLS", marker=""),
                line("RBF", marker=""),
                line("PU", marker=""),
            ),
            strict=True,
        ):
            below.plot(TIMES, values / np.abs(values).max(), **look | {"label": name})
        below.axhline(0, color="black", linewidth=0.8)
        shown = np.interp(a["times"], TIMES, a["curves"][0] / np.abs(a["curves"][0]).max())
        below.plot(a["times"], shown, **line("LS", linestyle="none", marker="o", label=None))
        below.set(title="determinant / its largest magnitude", xlabel="time")
        page.legend(*below.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return page


def _frame(panel: Axes, path: np.ndarray, points: np.ndarray, t: float) -> None:
    (a, b), c = points[1] - points[0], points[2] - points[0]
    reach = np.abs(path[..., 1]).max() + 0.25
    area = a * c[1] - b * c[0]
    tint = METHOD_COLORS["MLS" if area > 0 else "LS"]
    for way in path.transpose(1, 0, 2):
        panel.plot(*way.T, color="#a0a0a0", linewidth=0.8, linestyle=(0, (2, 2)))
    panel.fill(*points.T, facecolor=tint, edgecolor=tint, alpha=0.35, linewidth=1.2)
    panel.plot(*points.T, **line("data", label=None), markersize=5)
    for name, place, away in zip("123", points, (points[0], points[1], (1, 1)), strict=True):
        shift = 7 * np.asarray(away) / np.linalg.norm(away) * (1 if name == "3" else -1)
        panel.annotate(
            name,
            place,
            xytext=tuple(shift),
            textcoords="offset points",
            fontsize=8,
            ha="center",
            va="center",
        )
    panel.set(
        title=f"$t = {t:.2f}$",
        xlim=(-1.3, 1.3),
        ylim=(-max(0.85, reach), max(1.1, reach)),
        aspect="equal",
    )
    panel.set(xticks=[], yticks=[])
    panel.grid(False)
    panel.spines[:].set_visible(False)
