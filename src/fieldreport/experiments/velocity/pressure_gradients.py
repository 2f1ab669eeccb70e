"""Pressure gradients at vertices from the pressure at circumcentres, by three methods.

A smooth pressure is known at the circumcentres of the cells. Least squares, moving least squares
and radial basis functions on the cells around a vertex give its gradient there, in the interior and
on the boundary, in the plane and in space; the orders of the errors are measured. Two common errors
are measured as well: moving least squares without the derivative of the weights, and cell averages
taken for values at circumcentres.

References
----------
Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 14-16).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.figure import Figure
from scipy.interpolate import RBFInterpolator

from fieldrecon.kernels.weights import inverse_square
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.plotting.style import FULL_WIDTH, figure, line
from fieldrecon.velocity.gradients import (
    CellStencils,
    LocalGradient,
    local_least_squares,
    local_moving_least_squares,
    local_rbf,
    vertex_gradients,
)
from fieldreport.experiments.meshes.reference_flows import equilateral_mesh, jittered_cube
from fieldreport.framework.error_measures import order, order_of_magnitude, rms
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter, require

METHODS = ("LS", "MLS", "RBF")
SPACE = "jittered, space"
MESHES = {"jittered, plane": 2, "equilateral, plane": 2, SPACE: 3}
WHERE = ("inside", "boundary")
STEP = 1e-5  # of central differences, in steps of the mesh


@dataclass(frozen=True)
class Params(Parameters):
    """Meshes, and the weight of moving least squares."""

    sides: tuple[int, ...] = parameter(
        (8, 16, 32, 64),
        "steps along a side of the unit square",
        least=4,
        fewest=2,
        order="increasing",
    )
    sides_3d: tuple[int, ...] = parameter(
        (4, 6, 9, 13), "steps along a side of the unit cube", least=2, fewest=2, order="increasing"
    )
    jitter: float = parameter(
        0.6, "range of the random displacement of a vertex, in steps", least=0, below=1
    )
    epsilon: float = parameter(0.5, "ε of the weight 1/(r² + ε²), in steps", least=1e-3, most=1e3)
    smallest: float = parameter(0.03, "smallest ε of the sweep, in steps", least=1e-3, most=1e3)
    largest: float = parameter(10.0, "largest ε of the sweep, in steps", most=1e6)
    values: int = parameter(16, "values of ε in the sweep, in geometric progression", least=2)
    sweep_side: int = parameter(32, "steps along a side of the unit square in the sweep", least=4)
    compared: int = parameter(
        40, "vertices at which methods are compared with NumPy and SciPy", least=1
    )
    seed: int = parameter(0, "seed of the meshes", least=0)

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.largest > self.smallest, "largest", "more than smallest", self.largest)


QUICK = Params(sides=(6, 12), sides_3d=(3, 5), values=3, sweep_side=8, compared=5)


@dataclass(frozen=True)
class diffuse(local_moving_least_squares):
    """The diffuse derivative: the slope of the local fit, for fixed weights."""

    def _log_gradient(self, stencils: CellStencils) -> np.ndarray:
        return np.zeros_like(stencils.y)


def run(params: Params, each: Map = map) -> Result:
    """Measure errors on all meshes, and sweep ε."""
    jobs = [(mesh, side) for mesh in MESHES for side in _sides(params, mesh)]
    measured = dict(zip(jobs, each(partial(errors_on_mesh, params), jobs), strict=True))
    errors = {
        mesh: np.array([measured[mesh, side] for side in _sides(params, mesh)]) for mesh in MESHES
    }
    ratios = np.geomspace(params.smallest, params.largest, params.values)
    sweep = np.array(list(each(partial(errors_of_epsilon, params), ratios)))
    orders = {mesh: _orders(params, mesh, errors[mesh]) for mesh in MESHES}
    return Result(
        params=params,
        tables={
            "orders": _order_table(errors, orders),
            "sweep": ResultTable(
                ("epsilon/h", "full derivative", "diffuse derivative", "difference"),
                tuple(map(tuple, np.column_stack([ratios, sweep]))),
            ),
        },
        facts=_facts(params, errors, orders, ratios, sweep),
        arrays={mesh.replace(", ", "_"): errors[mesh] for mesh in MESHES}
        | {"ratios": ratios, "sweep": sweep},
    )


def pressure(x: np.ndarray) -> np.ndarray:
    """Return ¼ Σ cos(2π x_k + k)."""
    return np.cos(2 * np.pi * x + np.arange(x.shape[-1])).sum(axis=-1) / 4


def pressure_gradient(x: np.ndarray) -> np.ndarray:
    """Return the gradient of `pressure`."""
    return -np.pi / 2 * np.sin(2 * np.pi * x + np.arange(x.shape[-1]))


def errors_on_mesh(params: Params, job: tuple[str, int]) -> np.ndarray:
    """Return the rms errors (method, where), and those of least squares from means of cells.

    The means are used as values at the circumcentres, and then at the centroids, where they are
    correct to second order.
    """
    mesh, side = _mesh(params, *job), job[1]
    methods = _methods(params.epsilon / side)
    p = pressure(mesh.circumcenters)
    errors = [_inside_and_boundary(mesh, vertex_gradients(mesh, p, by)) for by in methods]
    means = _means(mesh)
    errors.append(_inside_and_boundary(mesh, vertex_gradients(mesh, means)))
    right = vertex_gradients(mesh, means, sites=mesh.cell_centers)
    errors.append(_inside_and_boundary(mesh, right))
    return np.array(errors)


def errors_of_epsilon(params: Params, ratio: float) -> np.ndarray:
    """Return inner rms errors of the full and the diffuse derivative, and their rms difference."""
    side = params.sweep_side
    mesh = jittered_cube(side, 2, params.jitter, params.seed)
    inner = np.flatnonzero(~mesh.boundary_vertices)
    p, weight = pressure(mesh.circumcenters), inverse_square(ratio / side)
    full, slope = (
        vertex_gradients(mesh, p, by(weight), vertices=inner)
        for by in (local_moving_least_squares, diffuse)
    )
    true = pressure_gradient(mesh.points[inner])
    return np.array([rms(full - true), rms(slope - true), rms(full - slope)])


def _methods(epsilon: float) -> tuple[LocalGradient, ...]:
    return (
        local_least_squares(),
        local_moving_least_squares(inverse_square(epsilon)),
        local_rbf(),
    )


def _mesh(params: Params, name: str, side: int) -> SimplexMesh:
    if name.startswith("equilateral"):
        return equilateral_mesh(side)
    return jittered_cube(side, MESHES[name], params.jitter, params.seed)


def differences_from_others(params: Params) -> dict[str, float]:
    """Return the difference of each method from NumPy and SciPy over the largest gradient."""
    side, epsilon = params.sweep_side, params.epsilon / params.sweep_side
    mesh = jittered_cube(side, 2, params.jitter, params.seed)
    inner = np.flatnonzero(~mesh.boundary_vertices)
    vertices = inner[np.linspace(0, len(inner) - 1, params.compared).astype(int)]
    p = pressure(mesh.circumcenters)
    exact = (*_methods(epsilon)[:2], local_rbf(smoothing=0.0))
    others = gradients_by_others(mesh, p, vertices, epsilon, STEP / side)
    return {
        name: float(
            np.abs(vertex_gradients(mesh, p, by, vertices=vertices) - others[name]).max()
            / (np.pi / 2)
        )
        for name, by in zip(METHODS, exact, strict=True)
    }


def _means(mesh: SimplexMesh) -> np.ndarray:
    """Means over the cells, by quadrature with d + 1 points, which is exact for degree two."""
    center, corners = mesh.cell_centers[:, None], mesh.points[mesh.cells]
    return pressure(center + (corners - center) / np.sqrt(corners.shape[1] + 1)).mean(axis=1)


def cells_at_inner_vertices(mesh: SimplexMesh) -> float:
    """Return the mean number of cells around an inner vertex."""
    return float(np.diff(mesh.vertex_cell_incidence.indptr)[~mesh.boundary_vertices].mean())


def _inside_and_boundary(mesh: SimplexMesh, found: np.ndarray) -> list[float]:
    error, used = found - pressure_gradient(mesh.points), mesh.referenced
    inner = ~mesh.boundary_vertices
    return [rms(error[used & inner]), rms(error[used & ~inner])]


def _sides(params: Params, mesh: str) -> tuple[int, ...]:
    return params.sides if MESHES[mesh] == 2 else params.sides_3d


def _orders(params: Params, mesh: str, errors: np.ndarray) -> np.ndarray:
    h = 1 / np.array(_sides(params, mesh))
    flat = errors.reshape(len(h), -1).T
    return np.array([order(h, e) for e in flat]).reshape(errors.shape[1:])


def _order_table(errors: dict[str, np.ndarray], orders: dict[str, np.ndarray]) -> ResultTable:
    columns = (f"{method}{what}" for method in METHODS for what in ("", ", order"))
    rows = (
        (mesh, where, *np.stack([errors[mesh][-1, :3, k], orders[mesh][:3, k]], axis=1).ravel())
        for mesh in MESHES
        for k, where in enumerate(WHERE)
    )
    return ResultTable(("mesh", "where", *columns), tuple(rows))


def _facts(
    params: Params,
    errors: dict[str, np.ndarray],
    orders: dict[str, np.ndarray],
    ratios: np.ndarray,
    sweep: np.ndarray,
) -> dict[str, Cell]:
    plane, space = errors["jittered, plane"], errors[SPACE]
    facts: dict[str, Cell] = {
        "means_order": orders["jittered, plane"][3, 0],
        "means_error": plane[-1, 3, 0],
        "means_at_centroids_order": orders["jittered, plane"][4, 0],
        "means_at_centroids_error": plane[-1, 4, 0],
        "error_ls_space": space[-1, 0, 0],
        "error_rbf_space": space[-1, 2, 0],
        "best_ratio_full": ratios[np.argmin(sweep[:, 0])],
        "best_full": sweep[:, 0].min(),
        "best_ratio_diffuse": ratios[np.argmin(sweep[:, 1])],
        "best_diffuse": sweep[:, 1].min(),
        "largest_difference": sweep[:, 2].max(),
        "largest_difference_ratio": ratios[np.argmax(sweep[:, 2])],
        "cells_at_vertex_3d": cells_at_inner_vertices(_mesh(params, SPACE, params.sides_3d[-1])),
    }
    gaps = differences_from_others(params)
    return facts | {f"gap_{name.lower()}": order_of_magnitude(gap) for name, gap in gaps.items()}


def gradients_by_others(
    mesh: SimplexMesh, p: np.ndarray, vertices: np.ndarray, epsilon: float, step: float
) -> dict[str, np.ndarray]:
    """Return the gradients at inner vertices of the plane by each method, from one ring of cells.

    Parameters
    ----------
    mesh : SimplexMesh
        A mesh of triangles.
    p : (c,) ndarray
        Values at the circumcentres.
    vertices : (m,) ndarray of int
        Vertices at which the gradient is computed.
    epsilon : float
        ε of the weight 1/(r² + ε²) of moving least squares.
    step : float
        Step of the central differences.
    """
    found: dict[str, list[np.ndarray]] = {"LS": [], "MLS": [], "RBF": []}
    for i in vertices:
        cells = mesh.vertex_cells(i)
        sites, values, x = mesh.circumcenters[cells], p[cells], mesh.points[i]
        at = x + step * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
        moving = np.array([_weighted_fit(sites, values, epsilon, y)[0] for y in at])
        spline = RBFInterpolator(sites, values, kernel="thin_plate_spline")(at)
        found["LS"].append(_weighted_fit(sites, values, np.inf, x)[1:])
        found["MLS"].append((moving[::2] - moving[1::2]) / (2 * step))
        found["RBF"].append((spline[::2] - spline[1::2]) / (2 * step))
    return {name: np.array(gradients) for name, gradients in found.items()}


def _weighted_fit(
    sites: np.ndarray, values: np.ndarray, epsilon: float, x: np.ndarray
) -> np.ndarray:
    """Return the affine fit about x, (value, slopes), with equal weights for ε = ∞."""
    y = sites - x
    w = np.ones(len(y)) if np.isinf(epsilon) else 1 / ((y**2).sum(axis=1) + epsilon**2)
    basis = np.column_stack([np.ones(len(y)), y])
    return np.linalg.lstsq(w[:, None] * basis, w * values)[0]


def plot(result: Result) -> Figure:
    """Errors against the step of the mesh, inside and on the boundary."""
    panels = {
        "jittered_plane": "plane, jittered",
        "equilateral_plane": "plane, equilateral",
        "jittered_space": "space, jittered",
    }
    with figure(FULL_WIDTH, height=2.7, columns=3) as (page, axes):
        for panel, (name, title) in zip(axes, panels.items(), strict=True):
            sides = result.params.sides if "plane" in name else result.params.sides_3d
            h, errors = 1 / np.array(sides), result.arrays[name]
            for k, method in enumerate(METHODS):
                panel.plot(h, errors[:, k, 0], **line(method, label=f"{method}, inside"))
                hollow = line(method, label=f"{method}, boundary", markerfacecolor="white")
                panel.plot(h, errors[:, k, 1], **hollow | {"linewidth": 0.7})
            lowest, power = errors[-1, :3].min(), 2 if "equilateral" in name else 1
            panel.plot(h, 0.6 * lowest * (h / h[-1]) ** power, **line("truth", label=None))
            label = "$h^2$" if power == 2 else "$h$"
            panel.annotate(label, (h[-1], 0.6 * lowest), (6, -4), textcoords="offset points")
            panel.set(xscale="log", yscale="log", xlabel="step $h$", title=title)
            panel.set_xticks(h, [f"1/{side}" for side in sides])
            panel.minorticks_off()
        axes[0].set_ylabel("root mean square error")
        handles, labels = axes[0].get_legend_handles_labels()
        page.legend(handles, labels, loc="outside upper center", ncols=3)
    return page


def plot_epsilon(result: Result) -> Figure:
    """Errors of the full and the diffuse derivative against ε."""
    ratios, sweep = result.arrays["ratios"], result.arrays["sweep"]
    with figure(FULL_WIDTH * 0.62, height=2.4) as (page, axes):
        axes.plot(ratios, sweep[:, 0], **line("MLS", label="error of the full derivative"))
        axes.plot(ratios, sweep[:, 1], **line("PU", label="error of the diffuse derivative"))
        axes.plot(ratios, sweep[:, 2], **line("RBF", label="their difference"))
        axes.set(xscale="log", ylim=(0, None), xlabel=r"$\varepsilon / h$")
        axes.set_ylabel("root mean square")
        axes.legend(loc="center right")
    return page
