"""Static aeroelasticity of a swept wing: fixed-point iteration to the steady state.

A transport wing at Mach 0.8: a vortex lattice for the flow, a plate of finite elements for the
skins, and a coupling between their nodes. Flow and structure are solved alternately, without and
with relaxation. The rate of convergence and the divergence of the wing are compared with the
eigenvalues of the coupled problem, and the components with closed forms. Finally the loads are
transferred pointwise instead of by the transpose.

References
----------
Wendland, Scattered Data Approximation (2005), section 1.2 and figure 1.4.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from fieldrecon.coupling.flat_structures import FlatCoupling
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.plotting.style import FULL_WIDTH, SEQUENTIAL, figure, line, shades
from fieldreport.experiments.coupling.plate import Plate, isotropic_rigidity
from fieldreport.experiments.coupling.pointwise_loads import compared
from fieldreport.experiments.coupling.standard_atmosphere import TOP, standard_atmosphere
from fieldreport.experiments.coupling.static_aeroelasticity import ElasticWing, settled
from fieldreport.experiments.coupling.vortex_lattice import VortexLattice
from fieldreport.experiments.coupling.wing_models import Plan, built_incidences, elastic, flat, skin
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.orders_of_magnitude import floored
from fieldreport.framework.parameters import Parameters, parameter, require

RELAXATIONS = {"plain": 1.0, "half": 0.5, "aitken": None}
SKIN = (16, 29)  # cells of the drawn skin, along half its section and along the span
SETTLED = 1e-8  # residual at which convergence factors are measured, well above rounding
UNLOADED = 1e-6  # incidence of a panel, in radians, below which it counts as unloaded
NONE = 100  # multiples of the flight's dynamic pressure beyond which divergence is ignored
ROUNDING = 1e-12  # smaller errors are rounding errors, and are reported as this


@dataclass(frozen=True)
class Params(Parameters):
    """The flight, the wing, and the meshes."""

    mach: float = parameter(0.8, "Mach number", least=0.1, below=1)
    angle: float = parameter(-0.087, "angle of attack, degrees", least=-30, most=30)
    height: float = parameter(10498.0, "height of the flight, m", least=0, most=TOP)
    half_span: float = parameter(29.0, "half span, m", least=1, most=1000)
    root_chord: float = parameter(10.5, "chord at the root, m", least=0.1, most=100)
    taper: float = parameter(
        0.25, "chord at the tip, as a fraction of the root chord", least=0.01, most=2
    )
    sweep: float = parameter(30.0, "sweep of the quarter chords, degrees", least=-60, most=60)
    thickness: float = parameter(
        0.12, "thickness of the profile, as a fraction of the chord", least=0.01, most=0.5
    )
    camber: float = parameter(
        0.02, "height of the mean line, as a fraction of the chord", least=-0.2, most=0.2
    )
    incidence: tuple[float, ...] = parameter(
        (4.5, 0.0), "incidence at root and tip, degrees", least=-30, most=30, entries=2
    )
    skin: tuple[float, ...] = parameter(
        (0.009, 0.003), "thickness of the skins at root and tip, m", least=1e-4, most=1, entries=2
    )
    plate: tuple[float, ...] = parameter(
        (0.03, 0.97),
        "edges of the plate, as fractions of the chord",
        least=0,
        most=1,
        entries=2,
        order="increasing",
    )
    young: float = parameter(70e9, "Young's modulus, Pa", least=1e6, most=1e13)
    poisson: float = parameter(0.33, "Poisson's ratio", least=0, below=0.5)
    pieces: tuple[int, ...] = parameter(
        (30, 120), "cells of the plate along chord and span", least=2, entries=2
    )
    panels: tuple[int, ...] = parameter(
        (12, 32), "panels of the lattice along chord and span", least=2, entries=2
    )
    section: float = parameter(
        0.77, "section shown, as a fraction of the half span", least=0, below=1
    )
    sweeps: tuple[float, ...] = parameter(
        (30.0, 0.0, -20.0), "sweeps compared, degrees", least=-60, most=60, order="decreasing"
    )
    pressures: tuple[float, ...] = parameter(
        (0.5, 1.0, 1.5, 2.0, 2.5),
        "dynamic pressures compared, as fractions of that of the flight",
        least=0.01,
        most=100,
        order="increasing",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        loaded = np.abs(self.incidences(self.sweep)).max() > UNLOADED
        require(
            loaded, "angle", "such that, with incidence and camber, there is a load", self.angle
        )

    def plan(self, sweep: float) -> Plan:
        """The wing model with a sweep."""
        named = {field.name: getattr(self, field.name) for field in fields(Plan)}
        return Plan(**named | {"sweep": sweep})

    def wing(self, sweep: float) -> ElasticWing:
        """The same, with its meshes, at the Mach number."""
        return elastic(self.plan(sweep), self.pieces, self.panels, self.mach)

    def incidences(self, sweep: float) -> np.ndarray:
        """Incidences of its panels as built."""
        return built_incidences(self.plan(sweep), self.panels, self.angle)

    @property
    def pressure(self) -> float:
        """Dynamic pressure of the flight, Pa."""
        return float(standard_atmosphere(self.height).dynamic_pressure(self.mach))


QUICK = Params(pieces=(4, 12), panels=(3, 6), sweeps=(30.0, -20.0), pressures=(0.5, 1.0))


def run(params: Params, each: Map = map) -> Result:
    """Compute the steady state and all transfers, vary the sweep, check the components."""
    jobs = (
        partial(flight, params),
        *(partial(swept, params, s) for s in params.sweeps),
        partial(checked, params),
    )
    (facts, arrays, ways), *found, rows = each(_done, jobs)
    sweeps = tuple(row for row, _ in found)
    return Result(
        params=params,
        tables={
            "loads": ResultTable(("loads by", "lift", "bending", "work", "tip", "lift lost"), ways),
            "sweeps": ResultTable(
                ("sweep", "factor", "contracts below", "observed", "diverges at"), sweeps
            ),
            "checks": ResultTable(("quantity", "computed", "closed form", "error"), rows),
        },
        facts=facts | _divergence(params, sweeps[-1][-1]),
        arrays=arrays | {"rates": np.array([r for _, r in found])},
    )


def _done(job: partial) -> tuple:
    return job()


def checked(params: Params) -> tuple[tuple[Cell, ...], ...]:
    """Rows of the components compared with closed forms."""
    found = checks(params.mach)
    return tuple((*c, abs(c.computed / c.closed_form - 1)) for c in found)


def swept(params: Params, sweep: float) -> tuple[tuple[Cell, ...], np.ndarray]:
    """The factor of unrelaxed iteration in flight; pressures in kPa; contraction at each pressure.

    The pressures are those at which unrelaxed iteration ceases to converge, by the largest
    eigenvalue and as observed, and at which the wing diverges.
    """
    wing, incidences = params.wing(sweep), params.incidences(sweep)
    pressures = np.array(params.pressures) * params.pressure
    turns = [wing.steady_state(q, incidences, 1.0, tol=SETTLED) for q in pressures]
    rates = np.array([t.contraction for t in turns])
    factor = params.pressure * wing.eigenvalues[0].real
    limits = (1 / wing.contraction(1.0), pressures[-1] / rates[-1])
    diverges = wing.divergence_pressure
    last = "none" if diverges > NONE * params.pressure else diverges / 1000
    return (sweep, factor, *(q / 1000 for q in limits), last), rates


def flight(params: Params) -> tuple[dict[str, Cell], dict[str, np.ndarray], tuple]:
    """Facts, arrays and the table of transfers for the wing in flight."""
    wing, incidences = params.wing(params.sweep), params.incidences(params.sweep)
    q, air = params.pressure, wing.lattice
    if q >= wing.divergence_pressure:
        raise ValueError(
            f"the wing diverges at {wing.divergence_pressure / 1000:.3g} kPa, and the dynamic "
            f"pressure of the flight is {q / 1000:.3g} kPa: there is no stable steady state"
        )
    turns = {
        name: wing.steady_state(q, incidences, relaxation=omega, maxiter=300)
        for name, omega in RELAXATIONS.items()
    }
    w, plain = settled(turns["aitken"]), turns["plain"].residuals
    middle = plain[min(len(plain) // 2, len(plain) - 2) :][:2]
    stiff, bent = air.circulations(incidences), wing.circulations(w, incidences)
    z = wing.heights(w).reshape(air.shape[0] + 1, -1)
    before, after = drawn(params, wing, w)
    ways = compared(wing, q, incidences)
    corners = air.points.reshape(*z.shape, 2)
    chord = corners[-1, :, 0] - corners[0, :, 0]
    arrays = {
        "y": corners[0, :, 1] / params.half_span,
        "rise": z.mean(axis=0),
        "twist": np.degrees((z[0] - z[-1]) / chord),
        "section": np.array([at_section(params, wing, air.pressures(g)) for g in (stiff, bent)]),
        "lift": 2 * np.array([g.sum(axis=0) for g in (stiff, bent)]),
        "before": before,
        "after": after,
        "profile": np.array([profile_at(params, p) for p in (before, after)]),
    } | {name: t.residuals / t.residuals[0] for name, t in turns.items()}
    facts = _flight_facts(params, wing, stiff, bent)
    facts |= {
        f"{name}_turns": len(t.residuals) - 1 if t.converged else "none"
        for name, t in turns.items()
    }
    facts |= {
        "contraction": wing.contraction(q),
        "observed_contraction": float(middle[1] / middle[0]),
        "tip": float(arrays["rise"][-1]),
        "tip_nose_down": float(-arrays["twist"][-1]),
    }
    rows: list[tuple[Any, ...]] = [
        (way, *(floored(x, ROUNDING) for x in errors), tip, lost)
        for way, *errors, tip, lost in ways
    ]
    for way, lift, _, work, *_ in rows[2:]:
        facts |= {
            f"{way.replace(' ', '_')}_{name}": x for name, x in (("lift", lift), ("work", work))
        }
    return facts, arrays, tuple(rows)


def at_section(params: Params, wing: ElasticWing, panels: np.ndarray) -> np.ndarray:
    """Values (a,) at the shown section, interpolated from panels (a, b)."""
    y = wing.lattice.points.reshape(wing.lattice.shape[0] + 1, -1, 2)[0, :, 1]
    middles = (y[1:] + y[:-1]) / 2
    return np.array([np.interp(params.section * params.half_span, middles, row) for row in panels])


def drawn(params: Params, wing: ElasticWing, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points of the skin before and after the deflection of the plate."""
    before = skin(params.plan(params.sweep), *SKIN)
    points = before.reshape(-1, 3)
    moved = FlatCoupling(wing.coupling.structure, points).displacements(w[:, None] * [0, 0, 1.0])
    return before, (points + moved).reshape(before.shape)


def profile_at(params: Params, points: np.ndarray) -> np.ndarray:
    """Outline (k, 2) of the skin's section, along the stream and upwards."""
    where = params.section * (points.shape[1] - 1)
    k, part = int(where), where % 1
    return ((1 - part) * points[:, k] + part * points[:, k + 1])[:, [0, 2]]


def _flight_facts(
    params: Params, wing: ElasticWing, stiff: np.ndarray, bent: np.ndarray
) -> dict[str, Cell]:
    air, lattice = standard_atmosphere(params.height), wing.lattice
    lifts = [lattice.lift_coefficient(g) for g in (stiff, bent)]
    sections = [at_section(params, wing, 2 * g).sum() for g in (stiff, bent)]
    return {
        "nodes": len(wing.plate.mesh.points),
        "unknowns": wing.plate.stiffness.shape[0],
        "panels": lattice.spans.size,
        "corners": len(lattice.points),
        "temperature": float(air.temperature),
        "density": float(air.density),
        "speed": float(params.mach * air.sound_speed),
        "pressure_kpa": params.pressure / 1000,
        "stiff_lift": lifts[0],
        "elastic_lift": lifts[1],
        "lift_lost": 1 - lifts[1] / lifts[0],
        "section_lost": 1 - sections[1] / sections[0],
        "carried_tonnes": lifts[1] * 2 * lattice.area * params.pressure / 9.80665 / 1000,
    }


def _divergence(params: Params, kilopascals: Cell) -> dict[str, Cell]:
    """Altitude below which the wing of the last sweep diverges, and the speed there."""
    facts: dict[str, Cell] = {"divergence_kpa": kilopascals}
    if isinstance(kilopascals, str):
        return facts

    def excess(height: float) -> float:
        air = standard_atmosphere(height)
        return float(air.dynamic_pressure(params.mach) / 1000 - kilopascals)

    if excess(TOP) < 0 < excess(0.0):
        height = float(brentq(excess, 0.0, TOP))
        speed = float(params.mach * standard_atmosphere(height).sound_speed)
        facts |= {"divergence_height": height / 1000, "divergence_speed": speed}
    return facts


TURN, RISE = np.radians([155.0, 26.0])  # view direction: azimuth and elevation


def seen(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions (..., 2) in the picture, and depths (...), in parallel projection."""
    x, y, z = np.moveaxis(points, -1, 0)
    right = -np.sin(TURN) * x + np.cos(TURN) * y
    toward = np.cos(TURN) * x + np.sin(TURN) * y
    up = np.cos(RISE) * z - np.sin(RISE) * toward
    return np.stack([right, up], axis=-1), np.cos(RISE) * toward + np.sin(RISE) * z


class ClosedFormCheck(NamedTuple):
    """A quantity, its computed value, and the value of a closed form."""

    quantity: str
    computed: float
    closed_form: float


class Strips(VortexLattice):
    """Strip theory: the lift of each strip of the wing is lift slope times incidence.

    There is one panel along the chord, whose vortex lies at a quarter of the chord.
    """

    lift_slope = 2 * np.pi

    def circulations(self, incidences: ArrayLike) -> np.ndarray:
        """Circulations γ = a c θ / 2."""
        theta = np.asarray(incidences)
        chords = self.chords.reshape(self.chords.shape + (1,) * (theta.ndim - 2))
        return self.lift_slope / 2 * chords * theta


def strip(length: float, across: int, along: int) -> SimplexMesh:
    """Triangles of a rectangle of width one."""
    x, y = np.meshgrid(np.linspace(0, 1, across + 1), np.linspace(0, length, along + 1))
    n = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (k.ravel() for k in (n[:-1, :-1], n[:-1, 1:], n[1:, 1:], n[1:, :-1]))
    cells = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return SimplexMesh(np.column_stack([x.ravel(), y.ravel()]), cells)


def cantilever(across: int = 8) -> ClosedFormCheck:
    """Deflection of the end of a strip, evenly loaded: q L⁴ / (8 D), for a Poisson's ratio of 0."""
    length = 4.0
    mesh = strip(length, across, 4 * across)
    plate = Plate(mesh, isotropic_rigidity(1.0, 0.0), mesh.points[:, 1] == 0)
    areas = np.bincount(mesh.cells.ravel(), np.repeat(mesh.cell_measures / 3, 3))
    end = plate.deflections(areas)[mesh.points[:, 1] == length]
    return ClosedFormCheck(
        "deflection of an evenly loaded cantilever", float(end.mean()), length**4 / 8
    )


def straight_wing(along: int = 60) -> ClosedFormCheck:
    """Divergence of a straight uniform wing that only twists: (π/2)² GJ / (e a L²), e = c² / 4.

    The section's twisting stiffness is GJ = 4 D_66 c. Chords do not bend, since D_11 is large; and
    as D_22 is small, holding the root does not stiffen the wing against twisting.
    """
    length = 20.0
    mesh = strip(length, 4, along)
    plate = Plate(mesh, np.diag([1e3, 1e-2, 0.5]), mesh.points[:, 1] == 0)
    x, y = np.meshgrid([0.0, 1.0], np.linspace(0, length, along // 2 + 1), indexing="ij")
    air = Strips(np.stack([x, y], axis=-1))
    wing = ElasticWing(plate, air, FlatCoupling(flat(mesh.points), flat(air.points)))
    closed = (np.pi / 2) ** 2 * 2.0 / (2 * np.pi / 4 * length**2)
    return ClosedFormCheck(
        "divergence of a straight uniform wing", wing.divergence_pressure, closed
    )


def elliptic_wing(aspect: float = 100.0, along: int = 40) -> ClosedFormCheck:
    """Lift slope of an elliptic wing of high aspect ratio: 2 π / (1 + 2 / A), after Prandtl."""
    angle = np.linspace(0, np.pi / 2, along + 1)
    chord = 8 / (np.pi * aspect) * np.maximum(np.cos(angle), 1e-3)
    part = np.linspace(0, 1, 9)[:, None]
    air = VortexLattice(np.stack(np.broadcast_arrays((part - 0.25) * chord, np.sin(angle)), -1))
    slope = air.lift_coefficient(air.circulations(np.ones(air.shape)))
    return ClosedFormCheck("lift slope of an elliptic wing", slope, 2 * np.pi / (1 + 2 / aspect))


def long_wing(mach: float, length: float = 1000.0) -> ClosedFormCheck:
    """Lift slope of a long wing at a Mach number: 2 π / √(1 - M²), after Prandtl and Glauert."""
    x, y = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, length, 11), indexing="ij")
    air = VortexLattice(np.stack([x, y], axis=-1), mach)
    gamma = air.circulations(np.ones(air.shape))
    slope = float(2 * gamma[:, 0].sum())  # at the root, far from the tip
    closed = 2 * np.pi / np.sqrt(1 - mach**2)
    return ClosedFormCheck("lift slope of a long wing at this Mach number", slope, closed)


def checks(mach: float) -> list[ClosedFormCheck]:
    """All checks, the last at this Mach number."""
    return [cantilever(), straight_wing(), elliptic_wing(), long_wing(mach)]


def plot(result: Result) -> Figure:
    """The undeformed skin by its edges, and the deformed skin coloured by its rise."""
    before, after = result.arrays["before"], result.arrays["after"]
    with figure(FULL_WIDTH, height=1.8) as (page, panel):
        surface(panel, after, (after - before)[..., 2])
        for curve in (before[0], before[len(before) // 2], before[:, 0], before[:, -1]):
            panel.plot(*seen(curve)[0].T, color="black", linewidth=0.7, linestyle=(0, (4, 2)))
        panel.set(aspect="equal")
        panel.set_axis_off()
        page.colorbar(panel.collections[0], ax=panel, shrink=0.8, aspect=15, label="deflection [m]")
    return page


def surface(panel: Axes, points: np.ndarray, values: np.ndarray) -> None:
    """Draw the cells of a surface (u, v, 3), the farthest first, coloured by values and shaded."""
    places, near = seen(points)
    corners = [places[:-1, :-1], places[1:, :-1], places[1:, 1:], places[:-1, 1:]]
    pieces = np.stack(corners, axis=2).reshape(-1, 4, 2)
    depth = (near[:-1, :-1] + near[1:, 1:] + near[1:, :-1] + near[:-1, 1:]).ravel()
    mean = (values[:-1, :-1] + values[1:, 1:]).ravel() / 2
    order = np.argsort(depth, kind="stable")
    drawn = PolyCollection(list(pieces[order]), cmap=SEQUENTIAL, array=mean[order])
    drawn.set(edgecolor="white", linewidth=0.15)
    panel.add_collection(drawn)
    panel.autoscale_view()


def plot_section(result: Result) -> Figure:
    """Pressure along the chord of the section, and the section itself, stiff and elastic."""
    pressures, outlines = result.arrays["section"], result.arrays["profile"]
    with figure(FULL_WIDTH, height=2.3, columns=2) as (page, axes):
        part = (np.arange(pressures.shape[1]) + 0.25) / pressures.shape[1]
        for (name, look), pressure, outline in zip(looks(), pressures, outlines, strict=True):
            axes[0].plot(part, pressure, **look | {"label": name, "marker": "."})
            axes[1].plot(*outline.T, **look)
        axes[0].set(xlabel="fraction of the chord", ylabel="$\\Delta p/q$", xlim=(0, 1))
        axes[0].set_ylim(bottom=0)
        axes[0].legend()
        axes[1].set(xlabel="streamwise [m]", ylabel="vertical [m]", aspect="equal")
    return page


def plot_span(result: Result) -> Figure:
    """Rise, twist, and lift, along the span."""
    y = result.arrays["y"]
    with figure(FULL_WIDTH, height=2.0, columns=3) as (page, axes):
        elastic = looks()[1][1]
        axes[0].plot(y, result.arrays["rise"], **elastic)
        axes[1].plot(y, result.arrays["twist"], **elastic)
        for (name, look), lift in zip(looks(), result.arrays["lift"], strict=True):
            axes[2].plot((y[1:] + y[:-1]) / 2, lift, **look | {"label": name})
        titles = ("deflection [m]", "twist, nose up [°]", "lift per length over $q$ [m]")
        for panel, title in zip(axes, titles, strict=True):
            panel.set(title=title, xlim=(0, 1))
        axes[1].set_xlabel("fraction of the half span")
        axes[2].set_ylim(bottom=0)
        axes[2].legend()
    return page


def looks() -> tuple[tuple[str, dict[str, Any]], ...]:
    """Line styles of the rigid and of the elastic wing."""
    return (
        ("stiff", line("truth", linestyle=(0, (5, 2)), marker="")),
        ("elastic", line("MLS", marker="")),
    )


def plot_turns(result: Result) -> Figure:
    """Left, the iteration at the pressure of the flight; right, contraction against pressure."""
    params, rates = result.params, result.arrays["rates"]
    table = result.tables["sweeps"]
    with figure(FULL_WIDTH, height=2.6, columns=2) as (page, axes):
        names = {"plain": "plain", "half": "half steps", "aitken": "Aitken"}
        for look, (key, name) in zip(shades("MLS", 3), names.items(), strict=True):
            size = result.arrays[key]
            axes[0].semilogy(np.arange(len(size)), size, **look | {"label": name, "markersize": 2})
        axes[0].set(xlabel="steps", ylabel="residual, relative")
        axes[0].legend()
        q = np.array(params.pressures) * params.pressure / 1000
        most = 1.25 * q[-1]
        for look, sweep, limit, rate, bound in zip(
            shades("RBF", len(rates)),
            table.column("sweep"),
            table.column("contracts below"),
            rates,
            table.column("diverges at"),
            strict=True,
        ):
            label = f"{sweep:.0f}°".replace("-", "−")
            axes[1].plot([0, most], [0, most / limit], **look | {"marker": ""})
            axes[1].plot(q, rate, **look | {"linestyle": "none", "label": label})
            if bound != "none" and bound < most:
                axes[1].plot(bound, 1, marker="*", markersize=10, color="black", zorder=5)
        axes[1].axhline(1, color="black", linewidth=0.6)
        axes[1].axvline(params.pressure / 1000, color="black", linewidth=0.6, linestyle=":")
        axes[1].set(xlabel="dynamic pressure [kPa]", ylabel="contraction factor", xlim=(0, most))
        axes[1].set_ylim(0, 1.5)
        axes[1].legend(title="sweep", loc="center right", bbox_to_anchor=(1, 0.42))
    return page
