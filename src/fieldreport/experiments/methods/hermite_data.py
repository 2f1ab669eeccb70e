"""Hermite data: a closed curve from normals, and Poisson's equation by collocation.

A closed curve is reconstructed from points and normals alone, as the zero set of the field with
value zero and normal derivative minus one; and, as in the book, from additional points beside the
curve. Poisson's equation in the unit square is solved by collocation: Laplacians are given in the
interior and values on the boundary. Errors are measured against a known solution for increasing
numbers of points, and the torsion function of the square is compared with its series.

References
----------
Wendland, Scattered Data Approximation (2005), sections 1.1 and 1.3, chapter 16.
Fasshauer, Solving partial differential equations by collocation with radial basis functions (1997).
Timoshenko and Goodier, Theory of Elasticity (1951), section 94.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fieldrecon.datasets.synthetic import halton
from fieldrecon.fields import Field
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.functionals import derivatives_at, laplacians_at, values_at
from fieldrecon.methods.hermite import HermiteField, HermiteRBF
from fieldrecon.methods.rbf import RBF
from fieldrecon.plotting.style import figure, line, shades
from fieldreport.framework.error_measures import order
from fieldreport.framework.experiment import Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter

KERNELS: dict[str, Radial] = {
    "r⁵": polyharmonic(5),
    "r⁷": polyharmonic(7),
    "Wendland 3": wendland(3, 3, 2.0),
}
SIDE = 121
AROUND = np.linspace(0, 2 * np.pi, 721)


@dataclass(frozen=True)
class Params(Parameters):
    """The curve, the points beside it, and the sizes of the grids."""

    points: int = parameter(24, "points on the closed curve", least=8)
    lobes: int = parameter(3, "lobes of the curve r = 1 + wave cos(lobes t)", least=2)
    wave: float = parameter(0.3, "depth of the lobes, in radii", least=0, below=1)
    offset: float = parameter(
        0.1, "distance of the points beside the curve, in radii", least=1e-4, most=1
    )
    sizes: tuple[int, ...] = parameter(
        (8, 12, 16, 24, 32),
        "points along an edge of the square",
        least=4,
        fewest=2,
        order="increasing",
    )
    queries: int = parameter(500, "points at which the error in the square is measured", least=10)


QUICK = Params(points=16, sizes=(6, 9), queries=50)
DIGITS = {"order_r7": 4, "error_finest": 3, "torsion_percent": 2}


def run(params: Params, each: Map = map) -> Result:
    """Reconstruct the curve in both ways, and solve the equation on every grid."""
    p, normals = on_the_curve(params, np.arange(params.points) * 2 * np.pi / params.points)
    fields = {
        "normals": by_normals(p, normals),
        "beside": by_points_beside(p, normals, params.offset),
        "values": RBF(p, polyharmonic(3)).field(np.zeros(len(p))),
    }
    dense, dense_normals = on_the_curve(params, AROUND)
    missed = {name: rms_distance(fields[name], dense) for name in ("normals", "beside")}
    works = [(n, kernel) for kernel in KERNELS.values() for n in params.sizes]
    errors = np.array(list(each(partial(error_at, params.queries), works)))
    errors = errors.reshape(len(KERNELS), -1)
    t = np.linspace(-1.6, 1.6, SIDE)
    grid = np.stack(np.meshgrid(t, t), axis=-1)
    finest = params.sizes[-1]
    centre = float(torsion(finest)([0.5, 0.5]))
    slope = np.einsum("nd,nd->n", fields["normals"].gradient(dense), dense_normals)
    return Result(
        params=params,
        tables={
            "curve": ResultTable(
                ("data", "number", "missed by"),
                (
                    ("values and normals", 2 * len(p), missed["normals"]),
                    ("values and points beside", 3 * len(p), missed["beside"]),
                ),
            ),
            "poisson": ResultTable(
                ("edge", *KERNELS),
                tuple((n, *e) for n, e in zip(params.sizes, errors.T, strict=True)),
            ),
        },
        facts={
            "missed_normals": missed["normals"],
            "missed_beside": missed["beside"],
            "beside_over_normals": missed["beside"] / missed["normals"],
            "slope_percent": 100 * float(np.abs(slope + 1).max()),
            "largest_zero_field": float(np.abs(fields["values"](dense)).max()),
            **{
                f"order_{key}": order([1 / n for n in params.sizes], e)
                for key, e in zip(("r5", "r7", "wendland"), errors, strict=True)
            },
            "error_finest": errors[1, -1],
            "torsion": centre,
            "torsion_series": torsion_series(),
            "torsion_percent": 100 * abs(centre / torsion_series() - 1),
        },
        arrays={
            "points": p,
            "normals": normals,
            "dense": dense,
            "fields": np.array([fields[name](grid) for name in ("normals", "beside")]),
            "errors": errors,
        },
    )


def on_the_curve(params: Params, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2) of the curve r = 1 + wave cos(lobes t) and their outward unit normals."""
    r = 1 + params.wave * np.cos(params.lobes * t)
    slope = -params.lobes * params.wave * np.sin(params.lobes * t)
    radial = np.column_stack([np.cos(t), np.sin(t)])
    around = np.column_stack([-np.sin(t), np.cos(t)])
    normal = r[:, None] * radial - slope[:, None] * around
    return r[:, None] * radial, normal / np.linalg.norm(normal, axis=1, keepdims=True)


def by_normals(p: np.ndarray, normals: np.ndarray) -> HermiteField:
    """The field of r³ with the value 0 and the normal derivative -1 at every point."""
    method = HermiteRBF([values_at(p), derivatives_at(p, normals)], polyharmonic(3))
    return method.field(np.repeat([0.0, -1.0], len(p)))


def by_points_beside(p: np.ndarray, normals: np.ndarray, offset: float) -> Field:
    """The field of r³ with the signed distance at the points and beside them, on both sides."""
    points = np.concatenate([p, p + offset * normals, p - offset * normals])
    return RBF(points, polyharmonic(3)).field(np.repeat([0.0, -offset, offset], len(p)))


def rms_distance(field: Field, dense: np.ndarray) -> float:
    """Root mean square distance of the zero level from the curve, by one Newton step."""
    slope = np.linalg.norm(field.gradient(dense), axis=1)
    return float(np.sqrt(np.mean((field(dense) / slope) ** 2)))


def solution(x: np.ndarray) -> np.ndarray:
    """Return cos(2x + 3y) + x³, the known solution."""
    return np.cos(x @ [2.0, 3.0]) + x[..., 0] ** 3


def laplacian(x: np.ndarray) -> np.ndarray:
    """Return its Laplacian."""
    return -13 * np.cos(x @ [2.0, 3.0]) + 6 * x[..., 0]


def collocation(n: int, kernel: Radial) -> tuple[HermiteRBF, np.ndarray, np.ndarray]:
    """Return the method on a square of n points along an edge, and its points inside and on it."""
    t = np.arange(n) / n
    low, high = np.zeros(n), np.ones(n)
    edge = np.concatenate(
        [
            np.column_stack(side)
            for side in (
                (t, low),
                (high, t),
                (1 - t, high),
                (low, 1 - t),
            )
        ]
    )
    inside = halton((n - 1) ** 2, 2)
    inside = inside[np.abs(inside - 0.5).max(axis=1) < 0.5 - 0.3 / n]
    return HermiteRBF([laplacians_at(inside), values_at(edge)], kernel), inside, edge


def error_at(queries: int, work: tuple[int, Radial]) -> float:
    """Root mean square error of the solution on n points along an edge, with a kernel."""
    method, inside, edge = collocation(*work)
    x = halton(queries + 1, 2)[1:]
    u = method.field(np.concatenate([laplacian(inside), solution(edge)]))
    return float(np.sqrt(np.mean((u(x) - solution(x)) ** 2)))


def torsion(n: int) -> HermiteField:
    """Return the solution of Laplacian u = -1 in the square with u = 0 on its edge."""
    method, inside, edge = collocation(n, polyharmonic(7))
    return method.field(np.concatenate([-np.ones(len(inside)), np.zeros(len(edge))]))


def torsion_series(terms: int = 400) -> float:
    """Return the value at the centre by the double sine series.

    >>> round(torsion_series(), 6)
    0.073671
    """
    k = np.arange(1, 2 * terms, 2)
    sign = (-1.0) ** ((k - 1) // 2)
    below = np.outer(k, k) * np.add.outer(k**2, k**2)
    return float(16 / np.pi**4 * (np.outer(sign, sign) / below).sum())


def plot(result: Result) -> Figure:
    """The curve in both ways, and the errors of Poisson's equation."""
    a, params = result.arrays, result.params
    with figure(height=2.5, columns=3) as (page, (first, second, third)):
        titles = ("values and normals", "points beside")
        for panel, field, title in zip((first, second), a["fields"], titles, strict=True):
            _curve(panel, a, field)
            panel.set(title=title)
        first.quiver(*a["points"].T, *a["normals"].T, scale=14, width=0.006, color="black")
        for side in (-1, 1):
            beside = a["points"] + side * params.offset * a["normals"]
            second.plot(*beside.T, **line("data", label=None, color="#707070"), markersize=3)
        sizes = np.array(params.sizes)
        looks = shades("RBF", len(KERNELS))
        for name, look, errors in zip(KERNELS, looks, a["errors"], strict=True):
            third.loglog(sizes, errors, **look, label=name)
        third.set(title="Poisson: rms error", xlabel="points along an edge", ylim=(5e-8, 2))
        third.set_xticks(sizes[::2], [str(n) for n in sizes[::2]])
        third.minorticks_off()
        third.legend(loc="upper right")
    return page


def _curve(panel: Axes, a: Mapping[str, np.ndarray], field: np.ndarray) -> None:
    t = np.linspace(-1.6, 1.6, SIDE)
    panel.contourf(t, t, field, levels=[0, np.inf], colors=["#dcdcdc"])
    panel.plot(*a["dense"].T, **line("truth", linewidth=0.6))
    panel.contour(t, t, field, levels=[0], colors=[line("RBF")["color"]], linewidths=1.4)
    panel.plot(*a["points"].T, **line("data", label=None), markersize=4)
    panel.set(aspect="equal", xticks=[], yticks=[], xlim=(-1.5, 1.6), ylim=(-1.55, 1.55))
    panel.grid(False)
    panel.spines[:].set_visible(False)
