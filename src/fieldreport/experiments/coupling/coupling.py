"""Load transfer from the skin of a wing to its structure: interpolation and transpose.

A pressure with known lift acts on the skin of a wing. Its forces are transferred, in several
plausible ways, to the nodes of a few spars, which neither match the skin nor reach its edges. Lift,
moments and the tip deflection of a uniform cantilever under the transferred loads are compared with
closed forms. The experiment also shows to which nodes the load of one point of the skin is
distributed.

References
----------
Wendland, Scattered Data Approximation (2005), section 1.2; Farhat, Lesoinne and Le Tallec (1998).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from fieldrecon.coupling.flat_structures import FlatCoupling, blended_plates
from fieldrecon.coupling.rigid_body_motions import net_force_and_moment
from fieldrecon.coupling.transfer import Coupling, Transfer
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic, thin_plate_spline
from fieldrecon.kernels.positive_definite import wendland
from fieldrecon.methods.rbf import RBF
from fieldrecon.plotting.style import FULL_WIDTH, SEQUENTIAL, figure, line
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.orders_of_magnitude import floored
from fieldreport.framework.parameters import Parameters, parameter

Kernel: TypeAlias = Callable[[np.ndarray], np.ndarray]

THICKNESS = 0.12  # of the profile, as a fraction of the chord
SPARS = (0.2, 0.45, 0.7)  # positions along the chord
SPAR_HEIGHT = 0.8  # of the spars, as a fraction of the local thickness
SPARRED = 0.95  # of the span
REACH = 0.5  # of the kernel compared with preCICE, as a fraction of the half span
ROUNDING = 1e-12  # smaller errors are rounding errors, and are reported as this


@dataclass(frozen=True)
class Params(Parameters):
    """The wing of half span 1, its meshes, and the load."""

    chord: float = parameter(
        0.3, "chord of the wing, as a fraction of the half span", least=0.01, most=10
    )
    stations: tuple[int, ...] = parameter(
        (4, 8, 16, 32), "stations of the structure along the span", least=3, order="increasing"
    )
    shown: int = parameter(8, "stations in the table", least=3)
    pictured: int = parameter(40, "stations in the figure of the load distribution", least=3)
    across: int = parameter(20, "points of the skin along the chord, on each side", least=4)
    along: int = parameter(60, "points of the skin along the span", least=4)
    drag: float = parameter(0.05, "drag as a fraction of the lift, everywhere", least=0, most=10)


QUICK = Params(stations=(4, 8), pictured=16, across=8, along=16)


@dataclass(frozen=True)
class Wing:
    """Skin and loads: points (m, 3), areas (m,), forces (m, 3)."""

    skin: np.ndarray
    areas: np.ndarray
    forces: np.ndarray


def height(c: np.ndarray) -> np.ndarray:
    """Half thickness of the profile at fractions c of the chord, in chords."""
    return THICKNESS * np.sqrt(np.maximum(c * (1 - c), 0.0))


def wing(params: Params) -> Wing:
    """Lift that is elliptic along the span and falls linearly along the chord, half on each side.

    The total is one: with y = sin θ each point carries its exact share, by Gauss-Chebyshev
    quadrature along the span and the midpoint rule along the chord.
    """
    k = np.arange(1, params.along + 1)
    angle = k * np.pi / (2 * params.along + 1)
    y = np.cos(angle)
    lift = 4 / (2 * params.along + 1) * np.sin(angle) ** 2
    c = (np.arange(params.across) + 0.5) / params.across
    places = np.meshgrid(np.arange(params.along), c, [1.0, -1.0], indexing="ij")
    span, part, side = (a.ravel() for a in places)
    skin = np.column_stack([params.chord * part, y[span], side * params.chord * height(part)])
    widths = np.pi / (2 * params.along + 1) * np.sin(angle)
    areas = params.chord / params.across * widths[span]
    loads = lift[span] * 2 * (1 - part) / params.across / 2
    return Wing(skin, areas, loads[:, None] * [params.drag, 0.0, 1.0])


def spars(params: Params, stations: int, sides: tuple[float, ...] = (1.0, -1.0)) -> np.ndarray:
    """Nodes of the structure; with side 0, in its middle plane."""
    y = SPARRED * np.arange(stations) / (stations - 1)
    c, span, side = (a.ravel() for a in np.meshgrid(SPARS, y, sides, indexing="ij"))
    return np.column_stack([params.chord * c, span, side * SPAR_HEIGHT * params.chord * height(c)])


def interpolated_loads(nodes: np.ndarray, given: Wing) -> np.ndarray:
    """Forces interpolated as they are."""
    return RBF(given.skin, thin_plate_spline()).field(given.forces)(nodes)


def interpolated_pressures(nodes: np.ndarray, given: Wing) -> np.ndarray:
    """Forces per area interpolated, times the area of the skin nearest to each node."""
    pressures = given.forces / given.areas[:, None]
    areas = np.bincount(cKDTree(nodes).query(given.skin)[1], given.areas, len(nodes))
    return areas[:, None] * RBF(given.skin, thin_plate_spline()).field(pressures)(nodes)


def nearest_node(nodes: np.ndarray, given: Wing) -> np.ndarray:
    """Each force to the nearest node."""
    total = np.zeros((len(nodes), 3))
    np.add.at(total, cKDTree(nodes).query(given.skin)[1], given.forces)
    return total


def transposed(make: Callable[[np.ndarray, np.ndarray], Transfer]) -> Callable[..., np.ndarray]:
    """Loads by the transpose of a coupling."""
    return lambda nodes, given: make(nodes, given.skin).loads(given.forces)


COUPLINGS: dict[str, Callable[[np.ndarray, np.ndarray], Transfer]] = {
    "transpose, constants": lambda x, y: Coupling(RBF(x, polyharmonic(1)), y),
    "transpose, linear": lambda x, y: Coupling(RBF(x, thin_plate_spline()), y),
    "transpose, patches": lambda x, y: Coupling(blended_plates(x), y),
    "transpose, flat": lambda x, y: FlatCoupling(x, y, partial(RBF, kernel=polyharmonic(3))),
}
WAYS: dict[str, Callable[[np.ndarray, Wing], np.ndarray]] = {
    "forces interpolated": interpolated_loads,
    "pressures interpolated": interpolated_pressures,
    "nearest node": nearest_node,
} | {name: transposed(make) for name, make in COUPLINGS.items()}
QUANTITIES = ("lift", "root bending", "twisting moment", "tip deflection")


def closed_forms(params: Params) -> np.ndarray:
    """Lift 1; moments about x and y at the root; deflection of the tip for bending stiffness 1.

    With the lift q = (4/π) √(1 - y²): ∫ q y = 4/(3π), and the tip of the cantilever moves by
    ∫ q y² (3 - y) / 6 = 1/8 - 4/(45 π). Along the chord the lift acts at a third of it.
    """
    return np.array([1.0, 4 / (3 * np.pi), -params.chord / 3, 1 / 8 - 4 / (45 * np.pi)])


def quantities(points: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """The same quantities for forces at points, about the leading edge of the root."""
    total = net_force_and_moment(points, forces)
    y = points[:, 1]
    return np.array([total[2], total[3], total[4], forces[:, 2] @ (y**2 * (3 - y)) / 6])


def run(params: Params, each: Map = map) -> Result:
    """Transfer the load in all ways, for all numbers of stations."""
    jobs = [(way, k) for way in WAYS for k in (*params.stations, params.shown)]
    found = dict(zip(jobs, each(partial(errors_of, params), jobs), strict=True))
    errors = np.array([[found[way, k] for k in params.stations] for way in WAYS])
    rows: list[tuple[Cell, ...]] = [
        (way, *(floored(x, ROUNDING) for x in found[way, params.shown])) for way in WAYS
    ]
    given = wing(params)
    places, weights = footprints(params, given)
    maps = mappings(params, given)
    return Result(
        params=params,
        tables={
            "errors": ResultTable(("way", *QUANTITIES), tuple(rows)),
            "mappings": ResultTable(
                ("polynomial", "displacements", "loads", *QUANTITIES[:3]),
                tuple(maps),
            ),
        },
        facts=_facts(params, given, found) | {"precice_difference": maps[1][2]},
        arrays={"errors": errors, "skin": given.skin, "places": places, "weights": weights},
    )


def errors_of(params: Params, job: tuple[str, int]) -> np.ndarray:
    """Relative errors of the quantities, compared with the forces on the skin."""
    way, stations = job
    given = wing(params)
    nodes = spars(params, stations, (0.0,) if way.endswith("flat") else (1.0, -1.0))
    wanted = quantities(given.skin, given.forces)
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        try:
            loads = WAYS[way](nodes, given)
        except RuntimeWarning as warning:
            raise ValueError(
                f"with {stations} stations the spars of a chord of {params.chord:g} are too far "
                "apart for the edges of the skin; a smaller chord or fewer stations help: "
                f"{warning}"
            ) from None
    return np.maximum(np.abs(quantities(nodes, loads) / wanted - 1), ROUNDING)


def footprints(params: Params, given: Wing) -> tuple[np.ndarray, np.ndarray]:
    """Distribution of a unit load at one point of the skin: nodal weights of two couplings."""
    nodes = spars(params, params.pictured)
    inner = np.abs(given.skin - [0.35 * params.chord, 0.5, 0.05 * params.chord]).sum(axis=1)
    one = given.skin[[int(np.argmin(inner))]]
    load = np.array([[0.0, 0.0, 1.0]])
    both = [
        COUPLINGS[name](nodes, one).loads(load)[:, 2]
        for name in ("transpose, linear", "transpose, patches")
    ]
    return np.vstack([nodes, one]), np.array(both)


def mappings(params: Params, given: Wing) -> list[tuple[Cell, ...]]:
    """The two mappings of preCICE compared with the coupling with the same kernel; their errors.

    Largest differences, relative to the largest entries; then relative errors of the loads.
    """
    nodes, kernel = spars(params, params.shown), wendland(3, 2, REACH)
    ours = np.asarray(RBF(nodes, kernel, degree=1).weights(given.skin))
    wanted = quantities(given.skin, given.forces)[:3]
    rows: list[tuple[Cell, ...]] = []
    for name, made in (("integrated", integrated), ("separate", separate)):
        there, back = made(nodes, given.skin, kernel)
        away = [np.abs(h - g).max() / np.abs(g).max() for h, g in ((there, ours), (back, ours.T))]
        errors = np.abs(quantities(nodes, back @ given.forces)[:3] / wanted - 1)
        rows.append((name, *(floored(x, ROUNDING) for x in (*away, *errors))))
    return rows


def _facts(
    params: Params, given: Wing, found: dict[tuple[str, int], np.ndarray]
) -> dict[str, Cell]:
    exact = quantities(given.skin, given.forces) / closed_forms(params) - 1
    nodes = spars(params, params.shown)
    facts: dict[str, Cell] = {
        "nodes": len(nodes),
        "skin_points": len(given.skin),
        "skin_against_closed_forms": float(np.abs(exact).max()),
    }
    for way in list(WAYS)[:3]:
        lift, _, twist, tip = found[way, params.shown]
        name = way.replace(" ", "_")
        facts |= {f"{name}_lift": lift, f"{name}_twist": twist, f"{name}_tip": tip}
    facts["linear_tip"] = found["transpose, linear", params.shown][3]
    linear = Coupling(RBF(nodes, thin_plate_spline()), given.skin)
    facts["most_amplified"] = float(np.abs(linear.method.weights(given.skin)).sum(axis=1).max())
    parts = (given.skin[:, 1] > 0.5).astype(int), (nodes[:, 1] > 0.5).astype(int)
    lift = linear.shares(given.forces, *parts)[..., 2]
    facts["outer_lift_to_outer_part"] = float(lift[1, 1] / lift[1].sum())
    return facts


def integrated(x: np.ndarray, y: np.ndarray, kernel: Kernel) -> tuple[np.ndarray, np.ndarray]:
    """Return the mappings of preCICE with the polynomial integrated: the augmented system.

    With kernel matrices C between nodes and A from nodes to evaluation points, and the linear
    polynomials Q and V at both, displacements are mapped by the consistent matrix (m, n), loads by
    the conservative one (n, m). Source: Chourdakis and others, preCICE v2 (2022).
    """
    q, v, c, a = _parts(x, y, kernel)
    system = np.block([[np.zeros((q.shape[1],) * 2), q.T], [q, c]])
    evaluation = np.hstack([v, a])
    given = np.vstack([np.zeros((q.shape[1], len(x))), np.eye(len(x))])
    conservative = np.linalg.solve(system.T, evaluation.T)[q.shape[1] :]
    return evaluation @ np.linalg.solve(system, given), conservative


def separate(x: np.ndarray, y: np.ndarray, kernel: Kernel) -> tuple[np.ndarray, np.ndarray]:
    """Return the same mappings with the polynomial fitted first, and kernels for the rest."""
    q, v, c, a = _parts(x, y, kernel)
    fit = np.linalg.pinv(q)
    consistent = a @ np.linalg.solve(c, np.eye(len(x)) - q @ fit) + v @ fit
    mu = np.linalg.solve(c, a.T)
    return consistent, mu - fit.T @ (q.T @ mu - v.T)


def _parts(
    x: np.ndarray, y: np.ndarray, kernel: Kernel
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    q, v = (np.column_stack([np.ones(len(p)), p]) for p in (x, y))
    return q, v, kernel(cdist(x, x)), kernel(cdist(y, x))


def plot(result: Result) -> Figure:
    """Errors of lift, root bending and tip deflection against the stations of the structure."""
    stations, errors = result.params.stations, result.arrays["errors"]
    styles = ("data", "LS", "truth", "MLS", "RBF", "PU", "RBF")
    marks = (".", "s", "x", "o", "^", "D", "v")
    shown = {"lift": 0, "twisting moment": 2, "tip deflection": 3}
    with figure(FULL_WIDTH, height=3.0, columns=3) as (page, axes):
        for panel, (title, k) in zip(axes, shown.items(), strict=True):
            for way, row, style, mark in zip(WAYS, errors, styles, marks, strict=True):
                look = line(style, label=way, marker=mark)
                if style == "data":
                    look |= {"linestyle": (0, (3, 1, 1, 1, 1, 1))}
                if way.endswith("flat"):
                    look |= {"markerfacecolor": "white", "linewidth": 0.7}
                panel.plot(stations, row[:, k], **look)
            panel.set(xscale="log", yscale="log", xlabel="stations along the span", title=title)
            panel.set_xticks(stations, [str(s) for s in stations])
            panel.minorticks_off()
        axes[0].set_ylabel("relative error")
        handles, labels = axes[0].get_legend_handles_labels()
        page.legend(handles, labels, loc="outside upper center", ncols=4)
    return page


def plot_footprint(result: Result) -> Figure:
    """Plan view of the upper nodes among which the load of one point of the skin is distributed."""
    places, weights = result.arrays["places"], result.arrays["weights"]
    nodes, one = places[:-1], places[-1]
    upper = nodes[:, 2] > 0
    x, y = nodes[upper, 0], nodes[upper, 1]
    with figure(FULL_WIDTH, height=2.6, rows=2, sharex=True) as (page, axes):
        for panel, w, title in zip(axes, weights, ("thin plates", "on patches"), strict=True):
            size = np.abs(w[upper])
            panel.plot(y, x, "o", markersize=3.5, markerfacecolor="white", color="#999999")
            reached = size > ROUNDING
            shades = panel.scatter(
                y[reached],
                x[reached],
                22,
                np.log10(size[reached]),
                cmap=SEQUENTIAL,
                vmin=-6,
                vmax=0,
                edgecolors="black",
                linewidths=0.3,
                zorder=3,
            )
            panel.plot(one[1], one[0], "+", color="black", markersize=8)
            panel.set(title=title, ylabel="chord", ylim=(0, result.params.chord))
            panel.grid(visible=False)
        axes[-1].set_xlabel("span")
        bar = page.colorbar(shades, ax=axes, label="fraction of the load")
        bar.set_ticks([-6, -4, -2, 0], labels=["$10^{-6}$", "$10^{-4}$", "1 %", "all"])
    return page
