"""Normal equations: squared condition number and lost digits.

An affine field is sampled on a regular grid in a unit square, at increasing distances from the
origin. The same least-squares problem is solved by the normal equations BᵀB c = BᵀV and by
orthogonal factorization of B, both in the given coordinates, and by `LeastSquares`, which factors B
in a local frame.

References
----------
Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 5).
Higham, Accuracy and Stability of Numerical Algorithms (2002), chapter 20.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from fieldrecon.datasets.synthetic import jittered_grid, uniform
from fieldrecon.methods.least_squares import LeastSquares, monomial_matrix, normal_equations
from fieldrecon.plotting.style import figure, line, shades
from fieldreport.framework.error_measures import order_of_magnitude
from fieldreport.framework.experiment import Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter

SOLVERS = ("normal equations", "factorization, same coordinates", "factorization, local frame")
CERTAIN = 1e13  # larger computed condition numbers have no correct digits
ROUNDING = np.finfo(float).eps


@dataclass(frozen=True)
class Params(Parameters):
    """The positions of the points."""

    side: int = parameter(
        10, "points along each side of the grid on which the field is sampled", least=2
    )
    queries: int = parameter(100, "random points at which it is reconstructed", least=1)
    decades: tuple[int, ...] = parameter(
        (0, 1, 2, 3, 4, 5, 6, 7, 8),
        "decimal logarithms of the offset of the square of side 1",
        least=0,
        most=15,
        order="increasing",
    )
    seed: int = parameter(0, "seed of the random points", least=0)


QUICK = Params(side=5, queries=5, decades=(0, 6))
DIGITS = {"square_defect": 0, "far_error_normal": 0, "far_error_same": 0}


def run(params: Params, each: Map = map) -> Result:
    """Solve the same problem at every offset, including none."""
    offsets = np.array([0.0, *(10.0**k for k in params.decades)])
    measured = np.stack(list(each(partial(at_offset, params), offsets)))
    conditions, errors = measured[:, :2], measured[:, 2:]
    exact = np.array([exact_condition(params.side, a) for a in offsets])
    return Result(
        params=params,
        tables={"offsets": _table(offsets, conditions, errors)},
        facts=_facts(offsets, conditions, errors, exact),
        arrays={
            "offsets": offsets,
            "conditions": conditions,
            "errors": errors,
            "exact": exact,
        },
    )


def at_offset(params: Params, offset: float) -> np.ndarray:
    """Return cond B and cond BᵀB as formed, then the largest error of each solver."""
    points = jittered_grid(params.side, 2, jitter=0, seed=0) + offset
    queries = uniform(params.queries, 2, params.seed) + offset
    b = monomial_matrix(points, 1)
    values = affine(points - offset)
    truth = affine(queries - offset)
    at_queries = monomial_matrix(queries, 1)
    fits = (
        at_queries @ _normal_coefficients(points, values),
        at_queries @ np.linalg.lstsq(b, values, rcond=0)[0],
        LeastSquares(points).field(values)(queries),
    )
    conditions = [np.linalg.cond(b), np.linalg.cond(b.T @ b)]
    return np.array([*conditions, *(np.abs(fit - truth).max() for fit in fits)])


def _normal_coefficients(points: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the coefficients, or infinities where rounding has made BᵀB singular."""
    try:
        return normal_equations(points, values)
    except np.linalg.LinAlgError:
        return np.full(3, np.inf)


def affine(x: np.ndarray) -> np.ndarray:
    """Return 1 + x₁ − x₂, a field that least squares of degree one reproduces."""
    return 1 + x[..., 0] - x[..., 1]


def exact_condition(side: int, offset: float) -> float:
    """Return cond BᵀB for the grid, in closed form.

    BᵀB/N holds the moments of (1, x₁, x₂). With m = offset + ½ and the variance
    v = (1 − 1/side²)/12 of a coordinate it has the eigenvalue v, of (0, 1, −1), and two more of
    product v and sum 1 + v + 2m².

    Examples
    --------
    >>> points = jittered_grid(4, 2, jitter=0, seed=0)
    >>> b = monomial_matrix(points, 1)
    >>> round(float(np.linalg.cond(b.T @ b)) / exact_condition(4, 0.0), 12)
    1.0
    """
    v = (1 - 1 / side**2) / 12
    total = 1 + v + 2 * (offset + 0.5) ** 2
    largest = (total + np.sqrt(total**2 - 4 * v)) / 2
    return float(largest / min(v, v / largest))


def _table(offsets: np.ndarray, conditions: np.ndarray, errors: np.ndarray) -> ResultTable:
    columns = ("offset", "cond B", "cond BᵀB", *(f"error, {solver}" for solver in SOLVERS))
    rows = (
        (offset, *map(_told, condition), *map(_told_order, np.maximum(error, ROUNDING)))
        for offset, condition, error in zip(offsets, conditions, errors, strict=True)
    )
    return ResultTable(columns, tuple(rows))


def _facts(
    offsets: np.ndarray, conditions: np.ndarray, errors: np.ndarray, exact: np.ndarray
) -> dict[str, float]:
    of_b, of_normal = conditions.T
    certain = of_normal < CERTAIN
    far = int(np.argmin(np.abs(offsets - 1e6)))
    return {
        "cond_b": float(of_b[0]),
        "cond_normal": float(of_normal[0]),
        "square_defect": max(np.abs(of_normal / of_b**2 - 1)[certain].max(), ROUNDING),
        "far_offset": float(offsets[far]),
        "far_cond_b": float(of_b[far]),
        "far_error_normal": errors[far, 0],
        "far_error_same": max(errors[far, 1], ROUNDING),
        "far_error_local": order_of_magnitude(max(errors[far, 2], ROUNDING)),
        "exact_difference": order_of_magnitude(
            max(np.abs(of_b**2 / exact - 1)[of_b < np.sqrt(CERTAIN)].max(), ROUNDING)
        ),
    }


def _told(condition: float) -> float | str:
    return float(condition) if condition < CERTAIN else _told_order(condition)


def _told_order(x: float) -> float | str:
    return order_of_magnitude(x) if np.isfinite(x) else "singular"


def plot(result: Result) -> Figure:
    """Condition numbers and errors against the offset."""
    far = result.arrays["offsets"] > 0
    offsets = result.arrays["offsets"][far]
    of_b, of_normal = result.arrays["conditions"][far].T
    errors = np.maximum(result.arrays["errors"][far], ROUNDING)
    exact = result.arrays["exact"][far]
    looks = shades("LS", 3)
    with figure(height=2.6, columns=2) as (page, (left, right)):
        left.plot(offsets, exact, **line("truth", label="closed form"))
        left.plot(offsets, np.sqrt(exact), **line("truth", label=None))
        left.plot(offsets, of_normal, **looks[0] | {"linestyle": "none"}, label="$B^T B$")
        left.plot(offsets, of_b, **looks[1] | {"linestyle": "none"}, label="$B$")
        left.axhline(1 / ROUNDING, color="black", linewidth=0.6, linestyle=":")
        left.annotate("no correct digit", (offsets[0], 1 / ROUNDING), va="bottom", fontsize=8)
        left.set(title="condition number", xlabel="offset of the unit square")
        left.legend(loc="upper left")
        for look, solver, error in zip(looks, SOLVERS, errors.T, strict=True):
            right.plot(offsets, error, **look, label=solver)
        right.set(title="largest error of the field", xlabel="offset of the unit square")
        right.set_ylim(ROUNDING / 4, 1e7)
        right.legend(loc="upper left")
        for panel in (left, right):
            panel.set(xscale="log", yscale="log")
    return page
