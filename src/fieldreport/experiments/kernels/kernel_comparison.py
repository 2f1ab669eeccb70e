"""Kernels of radial basis functions on Franke's function: error, conditioning, augmentation.

Each kernel interpolates Franke's function at increasing numbers of points, taken from disjoint
parts of the Halton sequence. The smoother the kernel, the faster the error decreases and the
condition number of the system grows. Orders fitted to one sequence of points are uncertain: a
single point in a corner of the square, the origin with which the sequence begins, changes them. The
second half shows the purpose of the polynomial that augments the kernels: affine data are
reproduced exactly, and far from the data the field grows like a polynomial and not like the kernel.

References
----------
Franke, Scattered data interpolation: tests of some methods, Mathematics of Computation 38 (1982);
Wendland, Scattered Data Approximation (2005), chapters 11 and 12;
Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 11-13).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.interpolate import RBFInterpolator
from scipy.spatial.distance import cdist

from fieldrecon.datasets.synthetic import franke, halton
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import (
    multiquadric,
    polyharmonic,
    thin_plate_spline,
)
from fieldrecon.kernels.positive_definite import gaussian, matern, wendland
from fieldrecon.methods.least_squares import monomial_matrix
from fieldrecon.methods.rbf import RBF
from fieldrecon.plotting.style import figure, hues, line, shades
from fieldreport.framework.error_measures import order, order_of_magnitude
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable, round_to_digits
from fieldreport.framework.parameters import Parameters, parameter

CERTAIN = 1e14
"""Errors and condition numbers have correct digits up to this computed condition number.

Larger ones may have none: the smallest eigenvalue is of the size of the rounding errors.
"""
ROUNDING = 1e-16


@dataclass(frozen=True)
class Params(Parameters):
    """The numbers of points, and the lengths of the kernels."""

    sizes: tuple[int, ...] = parameter(
        (50, 100, 200, 400, 800),
        "numbers of points, increasing",
        least=4,
        fewest=2,
        order="increasing",
    )
    parts: int = parameter(
        20, "disjoint parts of the Halton sequence after its first point", least=1, most=1000
    )
    scale: float = parameter(
        0.2,
        "scale of Gaussian, multiquadric and Matérn; the square has side 1",
        least=1e-3,
        most=1e3,
    )
    radius: float = parameter(1.0, "radius of Wendland's function", least=1e-3, most=1e3)
    side: int = parameter(40, "evaluation points along a side of the square", least=2)
    few: int = parameter(100, "points of the part on augmentation", least=4)
    farthest: float = parameter(
        1e3, "largest distance from the centre of the square", least=10, most=1e9
    )

    @property
    def starts(self) -> tuple[int, ...]:
        """The index of the first point of each part; no part contains the origin, a corner."""
        return tuple(1 + k * self.sizes[-1] for k in range(self.parts))

    @property
    def kernels(self) -> dict[str, Radial]:
        """The kernels by name."""
        return {
            "linear": polyharmonic(1),
            "thin_plate": thin_plate_spline(),
            "cubic": polyharmonic(3),
            "wendland": wendland(3, 1, self.radius),
            "matern": matern(2.5, self.scale),
            "multiquadric": multiquadric(self.scale),
            "gaussian": gaussian(self.scale),
        }


LABELS = {
    "linear": "−r",
    "thin_plate": "r² log r²",
    "cubic": "r³",
    "wendland": "Wendland C²",
    "matern": "Matérn 5/2",
    "multiquadric": "multiquadric",
    "gaussian": "Gaussian",
}
POLYHARMONIC = ("linear", "thin_plate", "cubic")
QUICK = Params(sizes=(20, 40, 80), parts=2, side=12, few=30)
DIGITS = {
    "corner_gain_multiquadric": 1,
    "error_multiquadric": 4,
    "condition_multiquadric": 2,
    "condition_gaussian": 4,
}


def run(params: Params, each: Map = map) -> Result:
    """Interpolate with every kernel at every size, and with and without a polynomial."""
    starts = (0, *params.starts)
    cases = [(k, n, i) for k in params.kernels.values() for n in params.sizes for i in starts]
    shape = (len(LABELS), len(params.sizes), len(starts))
    errors, conditions = np.transpose(list(each(partial(error_and_condition, params), cases)))
    errors = errors.reshape(shape)
    solved = (errors[..., 1:] > 0).all(axis=-1)
    error = np.where(solved, np.median(errors[..., 1:], axis=-1), 0.0)
    condition = np.median(conditions.reshape(shape)[..., 1:], axis=-1)
    distances = np.geomspace(1, params.farthest, 40)
    far = _far_fields(params, distances)
    return Result(
        params=params,
        tables={
            "kernels": _kernel_table(params, error, condition),
            "affine": ResultTable(
                ("kernel", "order", "degree", "error", "error with degree 1"),
                tuple(_affine_rows(params)),
            ),
        },
        facts=_facts(params, error, condition)
        | _order_facts(params, errors)
        | _far_facts(distances, far)
        | {"difference_from_scipy": order_of_magnitude(max(_difference(params), ROUNDING))}
        | {"largest_certain_condition": CERTAIN},
        arrays={"error": error, "condition": condition, "distances": distances} | far,
    )


def error_and_condition(params: Params, case: tuple[Radial, int, int]) -> tuple[float, float]:
    """Return the rms error over the square, zero if refused, and the condition number."""
    kernel, n, start = case
    x = halton(start + n, 2)[start:]
    size = np.abs(np.linalg.eigvalsh(interpolation_matrix(kernel, x)))
    condition = size.max() / max(size.min(), np.finfo(float).tiny)
    try:
        s = RBF(x, kernel).field(franke(x))
    except np.linalg.LinAlgError:
        return 0.0, condition
    ticks = (np.arange(params.side) + 0.5) / params.side
    queries = np.stack(np.meshgrid(ticks, ticks), axis=-1)
    return float(np.sqrt(np.mean((s(queries) - franke(queries)) ** 2))), condition


def interpolation_matrix(kernel: Radial, x: np.ndarray) -> np.ndarray:
    """Return the kernel matrix, bordered by the polynomials that its order requires."""
    p = monomial_matrix(x, kernel.order - 1) if kernel.order else np.empty((len(x), 0))
    return np.block([[kernel(cdist(x, x)), p], [p.T, np.zeros((p.shape[1], p.shape[1]))]])


def affine(x: np.ndarray) -> np.ndarray:
    """Return 1 + 2 x₁ + 3 x₂."""
    return 1 + x @ np.array([2.0, 3.0])


def _kernel_table(params: Params, error: np.ndarray, condition: np.ndarray) -> ResultTable:
    columns = (f"{what}, n = {n}" for what in ("error", "condition") for n in params.sizes)
    rows = (
        (
            LABELS[name],
            kernel.order,
            *map(_reported_error, error[k], condition[k]),
            *map(_reported_condition, condition[k]),
        )
        for k, (name, kernel) in enumerate(params.kernels.items())
    )
    return ResultTable(("kernel", "order", *columns), tuple(rows))


def _reported_error(error: float, condition: float) -> Cell:
    """Report an error of an ill-conditioned system by its order of magnitude only."""
    if error == 0:
        return "refused"
    return float(error) if condition < CERTAIN else order_of_magnitude(error)


def _reported_condition(condition: float) -> Cell:
    """Report a condition number with the digits that rounding leaves, at most CERTAIN."""
    if condition >= CERTAIN:
        return f"over {CERTAIN:.0e}"
    return round_to_digits(float(condition), int(-np.log10(condition * np.finfo(float).eps)))


def _affine_rows(params: Params) -> Iterator[tuple[Cell, ...]]:
    x, queries = halton(params.few, 2), halton(params.few + 100, 2)[params.few :]
    for name, kernel in params.kernels.items():
        errors = [
            np.abs(RBF(x, kernel, degree).field(affine(x))(queries) - affine(queries)).max()
            for degree in (kernel.order - 1, 1)
        ]
        told = [float(e) if e > 1e-9 else order_of_magnitude(max(e, ROUNDING)) for e in errors]
        yield LABELS[name], kernel.order, kernel.order - 1, *told


def _far_fields(params: Params, distances: np.ndarray) -> dict[str, np.ndarray]:
    """Return fields along a ray from the centre of the square, with and without a polynomial."""
    x = halton(params.few, 2)
    values, bell, plate = franke(x), gaussian(params.scale), thin_plate_spline()
    ray = 0.5 + distances[:, None] * np.array([0.6, 0.8])
    angle = np.linspace(0, 2 * np.pi, 360, endpoint=False)
    ring = 0.5 + distances[-1] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    # The library refuses the thin plate without its plane. Its matrix happens to be regular
    # here, but without the side conditions the field grows like the kernel.
    weights = np.linalg.solve(plate(cdist(x, x)), values)
    loose = plate(cdist(ray, x)) @ weights
    return {
        "far_plate": RBF(x, plate).field(values)(ray),
        "far_plate_loose": loose,
        "ring_plate": RBF(x, plate).field(values)(ring),
        "ring_plate_loose": plate(cdist(ring, x)) @ weights,
        "far_gaussian": RBF(x, bell).field(values)(ray),
        "far_gaussian_plane": RBF(x, bell, degree=1).field(values)(ray),
    }


def _facts(params: Params, error: np.ndarray, condition: np.ndarray) -> dict[str, Cell]:
    facts: dict[str, Cell] = {}
    for k, name in enumerate(params.kernels):
        certain = (error[k] > 0) & (condition[k] < CERTAIN)
        if certain.any():  # else the table shows why there is nothing to quote
            facts[f"points_{name}"] = int(np.array(params.sizes)[certain][-1])
            facts[f"error_{name}"] = error[k, certain][-1]
            facts[f"condition_{name}"] = condition[k, certain][-1]
    best = np.where(error > 0, error, np.inf)[:, -1].argmin()
    return facts | {"best": LABELS[list(params.kernels)[best]]}


def _order_facts(params: Params, errors: np.ndarray) -> dict[str, Cell]:
    """Orders p of errors like h^p over all sizes, by start; the effect of a point in the corner."""
    names = list(params.kernels)
    facts: dict[str, Cell] = {}
    for name in POLYHARMONIC:
        h = np.array(params.sizes) ** -0.5
        corner, *orders = (order(h, e) for e in errors[names.index(name)].T)
        facts[f"order_{name}_least"], facts[f"order_{name}_most"] = min(orders), max(orders)
        facts[f"order_{name}_corner"] = corner
        facts[f"order_{name}_first"] = orders[0]
    for name in ("cubic", "multiquadric"):
        corner, first = errors[names.index(name), -1, :2]
        if first and corner:  # else the system was refused
            facts[f"corner_gain_{name}"] = first / corner
    return facts


def _far_facts(distances: np.ndarray, far: dict[str, np.ndarray]) -> dict[str, Cell]:
    last = distances >= distances[-1] / 10
    facts: dict[str, Cell] = {}
    for name in ("far_plate", "far_plate_loose", "far_gaussian_plane"):
        facts[f"{name}_growth"] = order(distances[last], np.abs(far[name][last]))
    for name in ("ring_plate", "ring_plate_loose"):
        facts[f"{name}_least"], facts[f"{name}_most"] = far[name].min(), far[name].max()
    return facts


def _difference(params: Params) -> float:
    """Return the largest difference of the interpolants from those of scipy.interpolate."""
    x, queries = halton(params.few, 2), halton(params.few + 100, 2)[params.few :]
    shared: dict[str, dict[str, Any]] = {
        "linear": {"kernel": "linear", "degree": 0},
        "thin_plate": {"kernel": "thin_plate_spline"},
        "cubic": {"kernel": "cubic"},
        "multiquadric": {"kernel": "multiquadric", "epsilon": 1 / params.scale},
    }
    return max(
        np.abs(
            RBF(x, params.kernels[name]).field(franke(x))(queries)
            - RBFInterpolator(x, franke(x), **options)(queries)
        ).max()
        for name, options in shared.items()
    )


def plot(result: Result) -> Figure:
    """Error and condition number against the number of points, for every kernel."""
    sizes = np.array(result.params.sizes)
    looks = hues(len(LABELS))
    with figure(height=3.3, columns=2) as (page, (errors, conditions)):
        for k, (label, look) in enumerate(zip(LABELS.values(), looks, strict=True)):
            solved = result.arrays["error"][k] > 0
            condition = result.arrays["condition"][k]
            errors.plot(sizes[solved], result.arrays["error"][k, solved], **look, label=label)
            certain = condition < CERTAIN
            conditions.plot(sizes[certain], condition[certain], **look)
        for panel, title in ((errors, "root mean square error"), (conditions, "condition number")):
            panel.set(title=title, xlabel="number of points", xscale="log", yscale="log")
            panel.set_xticks(sizes, [str(n) for n in sizes])
            panel.minorticks_off()
        conditions.set_ylim(top=10 * CERTAIN)  # no tick at the title
        page.legend(loc="outside lower center", ncols=4)
    return page


def plot_far(result: Result) -> Figure:
    """Size of the field far from the data, with and without the polynomial."""
    plate, bell = shades("RBF", 2, marker="")
    curves = {
        "far_plate_loose": plate | {"linestyle": ":", "label": "r² log r² alone"},
        "far_plate": plate | {"linestyle": "-", "label": "r² log r² and a plane"},
        "far_gaussian_plane": bell | {"linestyle": "-", "label": "Gaussian and a plane"},
    }
    distances = result.arrays["distances"]
    with figure(height=2.6) as (page, axes):
        for name, look in curves.items():
            axes.plot(distances, np.maximum(np.abs(result.arrays[name]), 1e-4), **look)
        axes.axhline(1, **line("truth", linewidth=0.6, label="magnitude of the data"))
        axes.set(xscale="log", yscale="log", ylim=(3e-3, None))
        axes.set(xlabel="distance from the centre of the data", ylabel="|field|")
        axes.legend(loc="upper left")
    return page
