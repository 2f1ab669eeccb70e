"""Conditionally positive definite kernels: conditions of the theory and counterexamples.

For every kernel the experiment computes the smallest eigenvalue of the quadratic form on the
coefficients that annihilate the polynomials of its order, the same for polynomials of one degree
less, and the inertia of the saddle-point system. Each of the counterexamples violates one premise:
an even power of the distance, collinear points, points in too many dimensions, and a kernel without
its polynomial.

References
----------
Wendland, Scattered Data Approximation (2005), chapters 8 and 9.
Micchelli, Interpolation of scattered data (1986).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.figure import Figure
from scipy.linalg import null_space
from scipy.spatial.distance import cdist
from scipy.special import jv

from fieldrecon.datasets.synthetic import uniform
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import (
    multiquadric,
    polyharmonic,
    thin_plate_spline,
)
from fieldrecon.kernels.positive_definite import gaussian, inverse_multiquadric, matern, wendland
from fieldrecon.methods.rbf import RBF
from fieldrecon.plotting.style import BLACK_ON_MAP, DIVERGING, figure, line, shades
from fieldrecon.polynomials import dimension, monomials
from fieldreport.framework.error_measures import order_of_magnitude
from fieldreport.framework.experiment import Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter

ROUNDING = np.finfo(float).eps
WAVES = np.linspace(1.0, 20.0, 381)
FINE_WAVES = np.linspace(1.0, 20.0, 3801)
VARIABLES = (1, 2, 3)
ON_A_LINE = np.array([0.0, 0.2, 0.35, 0.7, 1.0])
SIDE = 61


@dataclass(frozen=True)
class Params(Parameters):
    """The points and the lengths of the kernels."""

    points: int = parameter(24, "random points in the square [0, 3]²", least=13)
    scale: float = parameter(0.6, "scale of the kernels with a scale", least=1e-3, most=1e3)
    radius: float = parameter(1.5, "radius of Wendland's function", least=1e-3, most=1e3)
    lattice: int = parameter(
        9, "points along the side of the lattice on which (1 - r)₊ fails", least=2
    )
    step: float = parameter(0.7, "step of that lattice, in radii", least=0.1, most=10)
    seed: int = parameter(0, "seed of the points", least=0)


QUICK = Params(points=16, lattice=6)


def kernels(params: Params) -> dict[str, Radial]:
    """Return kernels of every order from zero to four, by name."""
    return {
        "Gaussian": gaussian(params.scale),
        "inverse multiquadric": inverse_multiquadric(params.scale),
        "Matérn 3/2": matern(1.5, params.scale),
        "Wendland 1": wendland(3, 1, params.radius),
        "multiquadric": multiquadric(params.scale),
        "−r": polyharmonic(1),
        "r² log r²": thin_plate_spline(),
        "r³": polyharmonic(3),
        "−r⁴ log r": polyharmonic(4),
        "−r⁵": polyharmonic(5),
        "r⁷": polyharmonic(7),
    }


def run(params: Params, each: Map = map) -> Result:
    """Test every condition, and its counterexample."""
    x = 3 * uniform(params.points, 2, params.seed)
    known = kernels(params)
    rows = list(each(partial(conditions, x), known.values()))
    table = ResultTable(
        ("kernel", "order", "least with", "least below", "positive", "negative", "zero"),
        tuple((name, *row) for name, row in zip(known, rows, strict=True)),
    )
    first, second, apart = two_fields()
    waves = np.array([transform(wendland(1, 0), d, WAVES) for d in VARIABLES])
    return Result(
        params=params,
        tables={"conditions": table},
        facts=_facts(params, x, table, apart),
        arrays={
            "orders": np.array([k.order for k in known.values()]),
            "with": np.array([row[1] for row in rows]),
            "below": np.array([np.nan_to_num(float(row[2] or 0)) for row in rows]),
            "waves": waves,
            "first": first,
            "second": second,
        },
    )


def conditions(x: np.ndarray, kernel: Radial) -> tuple[int, float, float | str, int, int, int]:
    """Return the order, the smallest eigenvalues for it and one less, and the inertia."""
    below = least(kernel, x, kernel.order - 2) if kernel.order else ""
    return (kernel.order, least(kernel, x, kernel.order - 1), below, *inertia(system(kernel, x)))


def least(kernel: Radial, x: np.ndarray, degree: int) -> float:
    """Smallest eigenvalue of the form on the coefficients that annihilate the polynomials."""
    p = monomials(x / 3, degree)
    z = np.linalg.qr(p, mode="complete")[0][:, p.shape[1] :]
    return float(np.linalg.eigvalsh(z.T @ kernel(cdist(x, x)) @ z).min())


def system(kernel: Radial, x: np.ndarray, degree: int | None = None) -> np.ndarray:
    """The kernel matrix bordered by polynomials of its order, or of the given degree."""
    p = monomials(x / 3, kernel.order - 1 if degree is None else degree)
    zero = np.zeros((p.shape[1], p.shape[1]))
    return np.block([[kernel(cdist(x, x)), p], [p.T, zero]])


def inertia(h: np.ndarray) -> tuple[int, int, int]:
    """Numbers of positive, negative and zero eigenvalues."""
    values = np.linalg.eigvalsh(h)
    tiny = 1e-13 * np.abs(values).max()
    return int((values > tiny).sum()), int((values < -tiny).sum()), int((abs(values) <= tiny).sum())


def transform(phi: Radial, d: int, waves: np.ndarray) -> np.ndarray:
    """Fourier transform of phi(|x|) in d variables at the frequencies, up to a factor."""
    nodes, weights = np.polynomial.legendre.leggauss(160)
    r = (nodes + 1) / 2
    z = r * waves[:, None]
    return (jv(d / 2 - 1, z) * z ** (1 - d / 2)) @ (weights / 2 * phi(r) * r ** (d - 1))


def first_negative(phi: Radial, d: int, waves: np.ndarray) -> float:
    """Return the first of the frequencies at which the transform is negative."""
    return float(waves[np.argmax(transform(phi, d, waves) < 0)])


def first_positive_after(phi: Radial, d: int, waves: np.ndarray) -> float:
    """Return the first of the frequencies after negative ones at which it is positive again."""
    negative = transform(phi, d, waves) < 0
    start = int(np.argmax(negative))
    return float(waves[start + np.argmax(~negative[start:])])


def on_the_diagonal() -> tuple[np.ndarray, np.ndarray]:
    """Points on a line in the plane, and data on them."""
    return np.column_stack([ON_A_LINE, ON_A_LINE]), np.cos(6 * ON_A_LINE)


def two_fields() -> tuple[np.ndarray, np.ndarray, float]:
    """Return two thin-plate splines through the same collinear data, and their difference.

    The second differs by a multiple of x - y, which vanishes on the line.
    """
    x, f = on_the_diagonal()
    kernel, n = thin_plate_spline(), len(x)
    solution = np.linalg.lstsq(system(kernel, x), np.append(f, np.zeros(3)), rcond=1e-12)[0]
    t = np.linspace(0, 1, SIDE)
    grid = np.stack(np.meshgrid(t, t), axis=-1).reshape(-1, 2)
    field = kernel(cdist(grid, x)) @ solution[:n] + monomials(grid / 3, 1) @ solution[n:]
    other = field + 2 * (grid[:, 0] - grid[:, 1])
    at_points = 2 * (x[:, 0] - x[:, 1])
    return field.reshape(SIDE, SIDE), other.reshape(SIDE, SIDE), float(np.abs(at_points).max())


def _facts(
    params: Params, x: np.ndarray, table: ResultTable, apart: float
) -> dict[str, float | int | str]:
    line_x, _ = on_the_diagonal()
    h = system(thin_plate_spline(), line_x)
    data = np.random.default_rng(params.seed).standard_normal((len(line_x), 50))
    right = np.vstack([data, np.zeros((3, 50))])
    residual = h @ np.linalg.lstsq(h, right, rcond=1e-12)[0] - right
    free = null_space(h, rcond=1e-12)
    six = x[:6]
    z = null_space(np.ones((1, 6)))
    even = np.linalg.eigvalsh(z.T @ -cdist(six, six, "sqeuclidean") @ z)
    cone = wendland(1, 0, 1.0)
    t = params.step * np.arange(params.lattice)
    square = np.stack(np.meshgrid(t, t), axis=-1).reshape(-1, 2)
    alone = inertia(polyharmonic(1)(cdist(x, x)))
    counts = np.array([table.column(c) for c in ("positive", "negative", "zero")])
    expected = [dimension(2, int(m) - 1) for m in table.column("order")]
    below = [b for b in table.column("least below") if b != ""]
    return {
        "kernels": len(table.rows),
        "least_of_all": min(map(float, table.column("least with"))),
        "largest_below": max(map(float, below)),
        "as_predicted": int(
            (counts[0] == len(x)).sum() == (counts[1] == expected).sum() == len(table.rows)
        )
        * len(table.rows),
        "rank_on_a_line": int(np.linalg.matrix_rank(h)),
        "size_on_a_line": len(h),
        "residual_on_a_line": order_of_magnitude(max(float(np.abs(residual).max()), ROUNDING)),
        "free_kernels": order_of_magnitude(max(float(np.abs(free[: len(line_x)]).max()), ROUNDING)),
        "fields_apart_at_points": apart,
        "even_zero": int((even < 1e-12).sum()),
        "even_size": len(even),
        "refusal": refusal(line_x),
        "cone_least": float(np.linalg.eigvalsh(cone(cdist(square, square))).min()),
        "cone_wave": first_negative(cone, 2, FINE_WAVES),
        "cone_wave_end": first_positive_after(cone, 2, FINE_WAVES),
        "late_wave": first_negative(wendland(3, 1, 1.0), 4, np.linspace(80.0, 95.0, 751)),
        "alone_positive": alone[0],
        "alone_negative": alone[1],
    }


def refusal(x: np.ndarray) -> str:
    """Return the error message of the library for collinear points."""
    try:
        RBF(x, thin_plate_spline())
    except np.linalg.LinAlgError as error:
        return str(error)
    return "none"


def plot(result: Result) -> Figure:
    """Smallest eigenvalues for the order and one less; the transform of (1 - r)₊."""
    a = result.arrays
    names = result.tables["conditions"].column("kernel")
    with figure(height=2.9, columns=2, width_ratios=[1.25, 1]) as (page, (left, right)):
        rows = np.arange(len(names))[::-1]
        left.axvline(0, color="black", linewidth=0.8)
        left.plot(a["with"], rows, **line("RBF", linestyle="none", label="degree $m-1$"))
        needed = a["orders"] > 0
        hollow = line("LS", linestyle="none", label="degree $m-2$", markerfacecolor="white")
        left.plot(a["below"][needed], rows[needed], **hollow)
        left.set_xscale("symlog", linthresh=1e-6, linscale=0.5)
        left.set_xticks([-1e2, -1e-2, 0, 1e-2, 1e2])
        labels = [f"{name}  ({m})" for name, m in zip(names, a["orders"], strict=True)]
        left.set_yticks(rows, labels)
        left.set(title="least eigenvalue of the form")
        left.legend(loc="lower left", bbox_to_anchor=(0, 1.1), ncols=2)
        for d, values, look in zip(VARIABLES, a["waves"], shades("RBF", 3, marker=""), strict=True):
            right.plot(WAVES, values * WAVES ** (0.5 + d / 2), **look, label=f"$D = {d}$")
        right.axhline(0, color="black", linewidth=0.8)
        right.set(title=r"transform of $(1-r)_+$, scaled", xlabel="frequency")
        right.legend(loc="upper right")
    return page


def plot_line(result: Result) -> Figure:
    """Two fields through the same data on a line."""
    a = result.arrays
    x, f = on_the_diagonal()
    t = np.linspace(0, 1, SIDE)
    reach = float(np.abs(a["second"]).max())
    with figure(height=2.7, columns=2, sharey=True) as (page, panels):
        for panel, name, title in zip(
            panels,
            ("first", "second"),
            ("smallest coefficients", "plus $2(x - y)$"),
            strict=True,
        ):
            levels = np.linspace(-reach, reach, 25)
            shown = panel.contourf(t, t, a[name], levels=levels, cmap=DIVERGING)
            panel.contour(t, t, a[name], levels=levels[::2], colors=BLACK_ON_MAP, linewidths=0.4)
            panel.plot([0, 1], [0, 1], color=BLACK_ON_MAP, linewidth=0.6)
            panel.scatter(
                *x.T,
                c=f,
                cmap=DIVERGING,
                vmin=-reach,
                vmax=reach,
                edgecolors=BLACK_ON_MAP,
                zorder=3,
                clip_on=False,
            )
            panel.set(title=title, aspect="equal")
        page.colorbar(shown, ax=panels, shrink=0.9, ticks=[-2, -1, 0, 1, 2])
    return page
