"""Natural cubic splines: minimal energy, linear extrapolation, locality.

Data of sin(k x) at scattered sites on [0, 1] are interpolated by the natural cubic spline, by other
splines with the same sites, and by the polynomial. Their energies are compared with that of the
function, which has a closed form. For increasing numbers of sites the errors are measured in the
interior and near the ends, and the decay of the influence of one datum is compared with the root of
a recurrence.

References
----------
Wendland, Scattered Data Approximation (2005), section 1.4.
De Boor, A Practical Guide to Splines (2001), chapters IV and IX.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.figure import Figure
from scipy.interpolate import CubicSpline, KroghInterpolator

from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.methods.natural_splines import NaturalCubicSpline, NaturalSpline
from fieldrecon.methods.rbf import RBF
from fieldrecon.methods.spline_bases import (
    b_splines,
    b_splines_by_divided_differences,
    cardinal_b_spline,
)
from fieldrecon.plotting.style import figure, line, shades
from fieldreport.framework.error_measures import order, order_of_magnitude
from fieldreport.framework.experiment import Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter

Curve = Callable[[np.ndarray], np.ndarray]

NATURAL = "natural"
DECAY = 2 - np.sqrt(3)  # the small root of z² + 4z + 1, with its sign changed
DEGREES = (0, 1, 2, 3)
ROUNDING = np.finfo(float).eps


@dataclass(frozen=True)
class Params(Parameters):
    """The function and its sites."""

    sites: int = parameter(11, "scattered sites on [0, 1]", least=4, most=30)
    frequency: float = parameter(9.0, "k of the function sin(k x)", least=0.1, most=1000)
    sizes: tuple[int, ...] = parameter(
        (17, 33, 65, 129, 257, 513),
        "numbers of equidistant sites of the convergence study",
        least=9,
        fewest=2,
        order="increasing",
    )
    reach: float = parameter(
        0.3, "length beyond the outer sites that the figure shows", least=0, most=10
    )
    seed: int = parameter(4, "seed of the sites", least=0)


QUICK = Params(sites=7, sizes=(9, 17))


def run(params: Params, each: Map = map) -> Result:
    """Interpolate by all splines, measure energies, errors and decay."""
    rng = np.random.default_rng(params.seed)
    x = (np.arange(params.sites) + 0.2 + 0.6 * rng.random(params.sites)) / params.sites
    f = np.sin(params.frequency * x)
    curves = interpolants(x, f)
    at = np.linspace(x[0] - params.reach, x[-1] + params.reach, 401)
    energies = {name: energy(x, bend) for name, (_, bend) in curves.items()}
    errors = np.array(list(each(partial(errors_at, params.frequency), params.sizes)))
    weights = influence(max(params.sizes[-1], FAR_FROM_ENDS))
    knots = np.arange(DEGREES[-1] + 2.0)
    inside = np.linspace(0, knots[-1], 201)
    return Result(
        params=params,
        tables={
            "energies": ResultTable(("curve", "energy"), tuple(energies.items())),
            "errors": ResultTable(
                ("sites", "middle", "ends"),
                tuple((n, *row) for n, row in zip(params.sizes, errors, strict=True)),
            ),
        },
        facts=_facts(params, x, f, energies, errors, weights),
        arrays={
            "sites": x,
            "values": f,
            "at": at,
            "curves": np.array([curve(at) for curve, _ in curves.values()]),
            "bends": np.array([bend(at) for _, bend in curves.values()]),
            "errors": errors,
            "weights": weights,
            "inside": inside,
            "b_splines": np.array([cardinal_b_spline(k, inside) for k in DEGREES]),
        },
    )


def interpolants(x: np.ndarray, f: np.ndarray) -> dict[str, tuple[Curve, Curve]]:
    """Return curves through the data and their second derivatives, the natural spline first."""
    natural = NaturalCubicSpline(x).field(f)
    witness, not_a_knot = CubicSpline(x, f, bc_type="natural"), CubicSpline(x, f)
    polynomial = KroghInterpolator(x, f)
    return {
        NATURAL: (natural, partial(bend_of, natural)),
        "natural, SciPy": (witness, witness.derivative(2)),
        "not-a-knot": (not_a_knot, not_a_knot.derivative(2)),
        "polynomial": (polynomial, partial(polynomial.derivative, der=2)),
    }


def bend_of(spline: NaturalSpline, at: np.ndarray) -> np.ndarray:
    """Second derivative between sites: a difference quotient, exact for the quadratic s'."""
    h = 1e-6
    return (spline.gradient(at + h) - spline.gradient(at - h)) / (2 * h)


def energy(x: np.ndarray, bend: Curve) -> float:
    """Integral of a squared second derivative between the outer sites, by Gauss's rule."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    half = np.diff(x)[:, None] / 2
    at = (x[:-1, None] + half * (nodes + 1)).ravel()
    return float((half * weights).ravel() @ bend(at) ** 2)


def energy_of_sine(k: float, a: float, b: float) -> float:
    """Return the integral of (k² sin kx)² from a to b, in closed form."""
    return k**4 * ((b - a) / 2 - (np.sin(2 * k * b) - np.sin(2 * k * a)) / (4 * k))


def errors_at(frequency: float, sites: int) -> np.ndarray:
    """Return the largest errors in the middle third of [0, 1] and in the outer intervals."""
    x = np.linspace(0, 1, sites)
    s = NaturalCubicSpline(x).field(np.sin(frequency * x))
    middle = np.linspace(1 / 3, 2 / 3, 2000)
    end = 1 - np.linspace(0, x[1], 200)
    return np.array([np.abs(s(t) - np.sin(frequency * t)).max() for t in (middle, end)])


FAR_FROM_ENDS = 65
"""Sites of a lattice whose ends do not change the influence of its central datum."""


def influence(sites: int) -> np.ndarray:
    """Return the influence of a central datum on the midpoints of the intervals to its right."""
    middle = sites // 2
    x = np.arange(sites, dtype=float)
    return NaturalCubicSpline(x).weights(x[middle] + 0.5 + np.arange(12))[:, middle]


def _facts(
    params: Params,
    x: np.ndarray,
    f: np.ndarray,
    energies: dict[str, float],
    errors: np.ndarray,
    weights: np.ndarray,
) -> dict[str, float]:
    method = NaturalCubicSpline(x)
    s, k = method.field(f), params.frequency
    witness = CubicSpline(x, f, bc_type="natural")
    inside = np.linspace(x[0], x[-1], 401)
    outside = x[-1] + params.reach
    rest = energy(x, lambda t: -k * k * np.sin(k * t) - bend_of(s, t))
    of_function = energy_of_sine(k, x[0], x[-1])
    radial = RBF(x[:, None], polyharmonic(3)).coefficients(f)[0]
    alpha = method.coefficients(f)[0]
    knots = np.sort(np.concatenate([x, x[3:5]]))
    pairs = (b_splines(knots, 3, inside), b_splines_by_divided_differences(knots, 3, inside))
    uniform = np.arange(5.0)
    inner = np.linspace(0, 3.99, 200)
    convolved = cardinal_b_spline(3, inner) - b_splines(uniform, 3, inner)[:, 0]
    steps = 1 / (np.array(params.sizes) - 1)
    return {
        "difference_from_scipy": _magnitude(s(inside) - witness(inside)),
        "difference_from_radial": _magnitude((alpha - radial) / np.abs(alpha).max()),
        "outside_natural": float(s(outside)),
        "outside_scipy": float(witness(outside)),
        "energy_natural": float(method.energy(f)),
        "energy_by_coefficients": float(12 * alpha @ f),
        "energy_function": of_function,
        "energy_rest": rest,
        "pythagoras_defect": _magnitude([(float(method.energy(f)) + rest) / of_function - 1]),
        "energy_not_a_knot_ratio": energies["not-a-knot"] / energies[NATURAL],
        "energy_polynomial_ratio": energies["polynomial"] / energies[NATURAL],
        "order_middle": order(steps[-3:], errors[-3:, 0]),
        "order_ends": order(steps[-3:], errors[-3:, 1]),
        "decay": float(-weights[6] / weights[5]),
        "decay_exact": float(DECAY),
        "decay_ten": float(DECAY) ** 10,
        "b_splines_difference": _magnitude(
            np.concatenate([(pairs[0] - pairs[1]).ravel(), convolved])
        ),
    }


def _magnitude(difference: np.ndarray | list) -> float:
    return order_of_magnitude(max(float(np.abs(difference).max()), ROUNDING))


def plot(result: Result) -> Figure:
    """Curves through the data and beyond, and their second derivatives."""
    a = result.arrays
    looks = [
        line("RBF", marker="", linestyle="-", linewidth=1.8, label="natural spline"),
        line("LS", marker="", label="SciPy's, extrapolated"),
        line("MLS", marker="", linestyle=(0, (1, 1.2)), label="not-a-knot spline"),
        line("truth", linestyle=(0, (6, 1.5, 1, 1.5)), label="polynomial"),
    ]
    with figure(height=2.7, columns=2) as (page, (left, right)):
        for curve, bend, look in zip(a["curves"][::-1], a["bends"][::-1], looks[::-1], strict=True):
            left.plot(a["at"], curve, **look)
            right.plot(a["at"], bend, **look)
        left.plot(a["sites"], a["values"], **line("data", label=None), markersize=5)
        left.set(title="interpolants", xlabel="$x$", ylim=(-2.6, 2.6))
        size = 1.6 * result.params.frequency**2
        right.set(title="second derivative", xlabel="$x$", ylim=(-size, size))
        handles, labels = left.get_legend_handles_labels()
        page.legend(handles[::-1], labels[::-1], loc="outside lower center", ncols=4)
    return page


def plot_locality(result: Result) -> Figure:
    """B-splines of degrees 0 to 3, the influence of a datum, and the errors."""
    a = result.arrays
    sizes = np.array(result.params.sizes)
    with figure(height=2.5, columns=3) as (page, (basis, decay, errors)):
        looks = shades("RBF", len(DEGREES), marker="")
        for k, look, b in zip(DEGREES, looks, a["b_splines"], strict=True):
            part = a["inside"] <= k + 1
            basis.plot(a["inside"][part], b[part], **look, label=f"degree {k}")
        basis.set(title="B-splines", xlabel="$x$", ylim=(0, 1.55))
        basis.legend(loc="upper right")
        steps = np.arange(len(a["weights"])) + 0.5
        decay.semilogy(steps, np.abs(a["weights"]), **line("RBF", linestyle="none", label="weight"))
        reference = np.abs(a["weights"][5]) * DECAY ** (steps - steps[5])
        decay.semilogy(steps, reference, **line("truth", label=f"${DECAY:.3f}^j$"))
        decay.set(title="influence of a datum", xlabel="distance in intervals")
        decay.legend(loc="upper right")
        for column, (look, label) in enumerate(
            zip(shades("RBF", 2), ("middle third", "outer intervals"), strict=True)
        ):
            errors.loglog(sizes, a["errors"][:, column], **look, label=label)
        errors.set(title="largest error", xlabel="sites")
        errors.set_xticks(sizes[::2], [str(n) for n in sizes[::2]])
        errors.minorticks_off()
        errors.legend(loc="lower left")
    return page
