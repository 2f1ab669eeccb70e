"""Semi-Lagrangian advection on scattered sites: a rotation, and a deformation that reverses.

A cone, a smooth hump and a slotted disc rotate with the plane, and are deformed by a flow that
reverses, so that in both cases the exact final state is the initial state. The experiment records
errors, extrema and mass, with and without a limiter that keeps bounds and mass. It measures the
orders in the time step and in the spacing, and the norms of the powers of the matrix of one step.

References
----------
Wendland, Scattered Data Approximation (2005), section 1.3; Zalesak (1979); LeVeque (1996).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fieldrecon.advection.characteristics import SCHEMES, Velocity, departure_points
from fieldrecon.advection.semi_lagrangian_steps import State, semi_lagrangian
from fieldrecon.datasets.synthetic import halton
from fieldrecon.kernels.conditionally_positive_definite import polyharmonic
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.plotting.style import FULL_WIDTH, SEQUENTIAL, figure, line
from fieldreport.framework.error_measures import order, rms
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.orders_of_magnitude import floored
from fieldreport.framework.parameters import Parameters, parameter

DISC, CONE, HUMP = np.array([[0.5, 0.75], [0.5, 0.25], [0.25, 0.5]])
RADIUS = 0.15
ROUNDING = 1e-12
VARIANTS: dict[str, dict[str, bool]] = {
    "without bounds": {"bounded": False, "massive": False},
    "with bounds": {"bounded": True, "massive": False},
    "with bounds and mass": {"bounded": True, "massive": True},
}


@dataclass(frozen=True)
class Params(Parameters):
    """Sites, in the unit square or its inner disc, and steps."""

    sites: int = parameter(5000, "sites in the rotation, approximately", least=100)
    steps: int = parameter(40, "time steps of one revolution", least=2)
    deformed_sites: int = parameter(3000, "sites in the flow that reverses", least=100)
    deformed_steps: int = parameter(30, "time steps, until the flow has returned", least=2)
    period: float = parameter(1.5, "period of the flow", above=0, most=100)
    counts: tuple[int, ...] = parameter(
        (500, 1000, 2000, 4000),
        "numbers of sites, for the order in h",
        least=100,
        fewest=2,
        order="increasing",
    )
    divisions: tuple[int, ...] = parameter(
        (16, 32, 64, 128),
        "time steps of a revolution, for the order in dt",
        least=2,
        fewest=2,
        order="increasing",
    )
    powers: int = parameter(700, "sites of the matrix whose powers are computed", least=50)
    angles: tuple[float, ...] = parameter(
        (15.0, 30.0, 45.0, 60.0, 75.0),
        "degrees by which these sites are rotated relative to the patches",
        least=0,
        most=360,
        order="increasing",
    )
    grid: int = parameter(120, "points along a side of the pictures", least=5)


QUICK = Params(
    sites=700,
    steps=8,
    deformed_sites=300,
    deformed_steps=4,
    counts=(300, 600),
    divisions=(4, 8),
    powers=100,
    angles=(60.0,),
    grid=20,
)


DIGITS = {"excess_disc": 3, "excess_rotated": 3, "growth_per_revolution": 3}


def disc(n: int) -> np.ndarray:
    """About n sites in the inscribed disc of the square, which the rotation maps to itself."""
    x = halton(round(4 / np.pi * n), 2)
    return x[np.linalg.norm(x - 0.5, axis=1) < 0.5]


def turning(x: np.ndarray, _: float) -> np.ndarray:
    """One revolution about the centre of the square in unit time."""
    return 2 * np.pi * (x - 0.5)[:, ::-1] * [-1, 1]


def deforming(period: float, x: np.ndarray, t: float) -> np.ndarray:
    """The flow of LeVeque (1996), which reverses after half its period."""
    wave, double = np.sin(np.pi * x) ** 2, np.sin(2 * np.pi * x)
    return np.cos(np.pi * t / period) * wave * double[:, ::-1] * [1, -1]


def shapes(x: np.ndarray) -> np.ndarray:
    """The slotted disc, the cone and the hump of height one, (m, 3)."""
    away = [np.linalg.norm(x - center, axis=1) / RADIUS for center in (DISC, CONE, HUMP)]
    slot = (np.abs(x[:, 0] - DISC[0]) < 0.025) & (x[:, 1] < DISC[1] + 0.1)
    disc = (away[0] <= 1) & ~slot
    cone = np.maximum(1 - away[1], 0)
    hump = (1 + np.cos(np.pi * np.minimum(away[2], 1))) / 2
    return np.column_stack([disc.astype(float), cone, hump])


def smooth(x: np.ndarray) -> np.ndarray:
    """A smooth hill that all sets of sites resolve, for measuring orders."""
    return np.exp(-60 * ((x - HUMP) ** 2).sum(axis=1))


def method_on(x: np.ndarray) -> PartitionOfUnityRBF:
    """The kernel r³ with linear polynomials on patches, which overshoots little."""
    return PartitionOfUnityRBF(x, polyharmonic(3), 1)


def run(params: Params, each: Map = map) -> Result:
    """Rotate, deform, refine."""
    jobs = [(flow, variant) for flow in ("rotation", "deformation") for variant in VARIANTS]
    told = dict(zip(jobs, each(partial(carried, params), jobs), strict=True))
    time_jobs = [(scheme, k) for scheme in SCHEMES for k in params.divisions]
    in_time = np.reshape(list(each(time_error, time_jobs)), (len(SCHEMES), -1))
    in_space = np.array(list(each(space_error, params.counts)))
    norms, radii = norms_of_powers(params)
    rotated = np.array(list(each(partial(radius_of_rotated, params), params.angles)))
    x = (np.arange(params.grid) + 0.5) / params.grid
    arrays = {"x": x}
    for (flow, variant), (history, frames) in told.items():
        name = f"{flow}_{list(VARIANTS).index(variant)}"
        arrays |= {f"{name}_history": history, f"{name}_frames": frames}
    arrays |= {"in_time": in_time, "in_space": in_space, "norms": norms}
    return Result(
        params=params,
        tables={"errors": _table(told)},
        facts=_facts(params, told, in_time, in_space, norms, radii)
        | _growth_facts(params.steps, radii[0], rotated),
        arrays=arrays,
    )


def carried(params: Params, job: tuple[str, str]) -> tuple[np.ndarray, np.ndarray]:
    """History (step, shape, [rms error, mean error, minimum, maximum, mass]) and frames on a grid.

    Errors are relative to the initial field, so only the final ones are meaningful. The frames (3,
    g, g) show the three shapes together at the beginning, in the middle and at the end.
    """
    flow, variant = job
    turn = flow == "rotation"
    x = disc(params.sites) if turn else halton(params.deformed_sites, 2)
    steps = params.steps if turn else params.deformed_steps
    velocity: Velocity = turning if turn else partial(deforming, params.period)
    keep = VARIANTS[variant]
    first = shapes(x)
    states = semi_lagrangian(
        method_on(x),
        first,
        velocity,
        np.linspace(0, 1.0 if turn else params.period, steps + 1),
        steady=turn,
        bounded=keep["bounded"],
        masses=np.full(len(x), 1 / len(x)) if keep["massive"] else None,
    )
    g = (np.arange(params.grid) + 0.5) / params.grid
    places = np.stack(np.meshgrid(g, g), axis=-1)
    history, frames = [], []
    for k, state in enumerate(_limited(states, steps)):
        u = state.values
        size = np.sqrt(np.mean(first**2, axis=0)), np.mean(first, axis=0)
        away = np.sqrt(np.mean((u - first) ** 2, axis=0)), np.mean(np.abs(u - first), axis=0)
        mass = u.sum(axis=0) / first.sum(axis=0)
        history.append([away[0] / size[0], away[1] / size[1], u.min(axis=0), u.max(axis=0), mass])
        if k in (0, steps // 2, steps):
            frame = state.method.field(u.sum(axis=1))(places)
            reached = np.linalg.norm(places - 0.5, axis=-1) < 0.5
            frames.append(np.where(reached | (not turn), frame, 0.0))
    return np.array(history).transpose(0, 2, 1), np.array(frames)


def _limited(states: Iterable[State], steps: int) -> Iterator[State]:
    """Yield the states; where bounds and mass contradict each other, the steps are too long."""
    try:
        yield from states
    except ValueError as error:
        raise ValueError(
            f"in {steps} steps the limiter cannot keep the mass within the bounds of neighbouring "
            f"values; more steps or a shorter period help: {error}"
        ) from error


def time_error(job: tuple[str, int]) -> float:
    """Error of the positions after one revolution, relative to the distance from the centre."""
    scheme, k = job
    x = halton(200, 2)
    y = x
    for j in range(k):
        y = departure_points(y, turning, 1 - j / k, 1 / k, scheme)
    return rms(y - x) / rms(x - 0.5)


def space_error(n: int) -> float:
    """Error of the smooth hill after one revolution in 20 steps with exact departure points."""
    x = disc(n)
    c, s = np.cos(2 * np.pi / 20), np.sin(2 * np.pi / 20)
    feet = 0.5 + (x - 0.5) @ np.array([[c, -s], [s, c]])
    h, u = method_on(x).weights(feet), smooth(x)
    for _ in range(20):
        u = h @ u
    return rms(u - smooth(x)) / rms(smooth(x))


def norms_of_powers(params: Params) -> tuple[np.ndarray, np.ndarray]:
    """Norms of H^k for k = 1, 2, 4, ... 1024 of one step, and spectral radii: disc, and square.

    The corners of the square come from outside, where the field is extrapolated; the disc is mapped
    to itself. Norms above 1e9 are reported as 1e9.
    """
    norms, radii = np.full((2, 11), 1e9), np.empty(2)
    for k, x in enumerate((disc(params.powers), halton(params.powers, 2))):
        h = step_matrix(params, x)
        radii[k] = spectral_radius(h)
        for power in range(11):
            found = float(np.linalg.norm(h, 2))
            if found > 1e9:
                break
            norms[k, power] = found
            h = h @ h
    return norms, radii


def radius_of_rotated(params: Params, degrees: float) -> float:
    """Return the spectral radius of one step in the disc if the sites are rotated.

    The patches of the method have the directions of the axes, so each has other sites.
    """
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    x = 0.5 + (disc(params.powers) - 0.5) @ np.array([[c, s], [-s, c]])
    return spectral_radius(step_matrix(params, x))


def step_matrix(params: Params, x: np.ndarray) -> np.ndarray:
    """Return the matrix H of one step of the rotation, dense."""
    feet = departure_points(x, turning, 1 / params.steps, 1 / params.steps)
    return method_on(x).weights(feet) @ np.eye(len(x))


def spectral_radius(h: np.ndarray) -> float:
    """Return the largest modulus of the eigenvalues."""
    return float(np.abs(np.linalg.eigvals(h)).max())


def _table(told: dict[tuple[str, str], tuple[np.ndarray, np.ndarray]]) -> ResultTable:
    columns = ("rms error", "mean error", "least", "most", "mass")
    rows = [
        (flow, shape, variant, *history[-1, k])
        for (flow, variant), (history, _) in told.items()
        for k, shape in enumerate(("slotted disc", "cone", "hump"))
    ]
    return ResultTable(("flow", "shape", "variant", *columns), tuple(rows))


def _facts(
    params: Params,
    told: dict[tuple[str, str], tuple[np.ndarray, np.ndarray]],
    in_time: np.ndarray,
    in_space: np.ndarray,
    norms: np.ndarray,
    radii: np.ndarray,
) -> dict[str, Cell]:
    steps, h = 1 / np.array(params.divisions), np.array(params.counts) ** -0.5
    facts: dict[str, Cell] = {
        f"order_{scheme}": order(steps[-2:], errors[-2:])
        for scheme, errors in zip(SCHEMES, in_time, strict=True)
    }
    facts |= {
        "order_in_space": order(h, in_space),
        "largest_power": 2 ** (norms.shape[1] - 1),
        "largest_norm_disc": float(norms[0].max()),
        "radius_square": float(radii[1]),
    }
    histories = {variant: told["rotation", variant][0] for variant in VARIANTS}
    for name, history in zip(("free", "bounded", "kept"), histories.values(), strict=True):
        facts[f"{name}_disc_error"] = history[-1, 0, 1]
        facts[f"{name}_cone_most"] = history[-1, 1, 3]
        facts[f"{name}_hump_error"] = history[-1, 2, 0]
    facts["least"] = histories["without bounds"][:, 0, 2].min()
    facts["most"] = histories["without bounds"][:, 0, 3].max()
    back = told["deformation", "without bounds"][0]
    facts["deformed_hump_error"] = back[-1, 2, 0]
    return facts


def _growth_facts(steps: int, radius: float, rotated: np.ndarray) -> dict[str, Cell]:
    """Excess of the spectral radius over one: of the sites, and the largest if they are rotated."""
    most = rotated.max()
    return {
        "excess_disc": floored(radius - 1, ROUNDING),
        "excess_rotated": floored(most - 1, ROUNDING),
        "growth_per_revolution": round(max(most, 1.0) ** steps - 1, 6),
    }


VARIANT_STYLES = ("RBF", "LS", "MLS")
VARIANT_NAMES = tuple(VARIANTS)


def plot(result: Result) -> Figure:
    """The initial shapes, and after one revolution without and with the limiter."""
    free, kept = result.arrays["rotation_0_frames"], result.arrays["rotation_2_frames"]
    titles = ("initial, exact", "after one revolution", "with bounds and mass")
    return _maps(result, (free[-1], kept[-1]), titles)


def plot_deformation(result: Result) -> Figure:
    """The shapes in the flow that reverses: initially, half-way, and at the end."""
    frames = result.arrays["deformation_2_frames"]
    return _maps(result, frames[1:], ("initial, exact", "half way", "at the end"))


def _maps(
    result: Result, later: np.ndarray | Sequence[np.ndarray], titles: tuple[str, ...]
) -> Figure:
    """Draw the exact shapes, whose edges the sites would not resolve, and later fields."""
    x = result.arrays["x"]
    places = np.stack(np.meshgrid(x, x), axis=-1)
    exact = shapes(places.reshape(-1, 2)).sum(axis=1).reshape(places.shape[:2])
    levels = np.arange(0.1, 1.0, 0.2)
    with figure(FULL_WIDTH, height=2.25, columns=3, sharey=True) as (page, axes):
        for panel, frame, title in zip(axes, (exact, *later), titles, strict=True):
            _shaded(panel, x, frame)
            panel.contour(x, x, frame, levels, colors="black", linewidths=0.4)
            panel.set(title=title, aspect="equal", xticks=[0, 0.5, 1], yticks=[0, 0.5, 1])
            panel.grid(visible=False)
        bar = page.colorbar(axes[0].images[0], ax=axes, shrink=0.85, aspect=30)
        bar.set_ticks([-0.2, 0, 0.5, 1, 1.2])
    return page


def _shaded(panel: Axes, x: np.ndarray, frame: np.ndarray) -> None:
    panel.imshow(
        frame,
        cmap=SEQUENTIAL,
        vmin=-0.2,
        vmax=1.2,
        origin="lower",
        extent=(0, 1, 0, 1),
        interpolation="nearest",
    )
    panel.set(xlim=(x[0], x[-1]), ylim=(x[0], x[-1]))


def plot_history(result: Result) -> Figure:
    """Extrema and mass of the slotted disc over one revolution."""
    with figure(FULL_WIDTH, height=2.6, columns=2) as (page, axes):
        for k, (name, style) in enumerate(zip(VARIANT_NAMES, VARIANT_STYLES, strict=True)):
            history = result.arrays[f"rotation_{k}_history"][:, 0]
            turn = np.linspace(0, 1, len(history))
            look = line(style, label=name, marker="")
            axes[0].plot(turn, history[:, 3], **look)
            axes[0].plot(turn, history[:, 2], **look | {"label": None})
            axes[1].plot(turn, history[:, 4], **look)
        axes[0].set(xlabel="revolutions", title="minimum and maximum")
        axes[1].set(xlabel="revolutions", title="mass, relative")
        axes[1].ticklabel_format(useOffset=False)
        page.legend(*axes[1].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return page


def plot_orders(result: Result) -> Figure:
    """Errors of departure points and of a hill against step and spacing; norms of powers."""
    p = result.params
    styles = ("LS", "MLS", "PU", "RBF")
    with figure(FULL_WIDTH, height=2.7, columns=3) as (page, axes):
        for name, style, row in zip(
            ("Euler", "midpoint", "Heun", "RK4"), styles, result.arrays["in_time"], strict=True
        ):
            axes[0].plot(1 / np.array(p.divisions), row, **line(style, label=name))
        axes[0].set(
            xlabel="step, in revolutions",
            title="error of departure points",
            xscale="log",
            yscale="log",
        )
        axes[0].set_xticks(1 / np.array(p.divisions), [f"1/{k}" for k in p.divisions])
        h = np.array(p.counts) ** -0.5
        axes[1].plot(h, result.arrays["in_space"], **line("PU", label=None))
        axes[1].set(
            xlabel="spacing $n^{-1/2}$, in thousandths",
            title="error of a smooth hump",
            xscale="log",
            yscale="log",
        )
        axes[1].set_xticks(h, [f"{1000 * x:.0f}" for x in h])
        k = 2.0 ** np.arange(result.arrays["norms"].shape[1])
        for name, style, row in zip(
            ("disc", "square"), ("MLS", "LS"), result.arrays["norms"], strict=True
        ):
            axes[2].plot(k, row, **line(style, label=name))
        axes[2].set(xlabel="power $k$", title="norm of $H^k$", xscale="log", yscale="log")
        axes[2].set_ylim(1, 5e7)
        axes[2].legend()
        for panel in axes[:2]:
            panel.minorticks_off()
        axes[0].set_ylim(1e-10, None)
        axes[0].legend(loc="lower right")
    return page
