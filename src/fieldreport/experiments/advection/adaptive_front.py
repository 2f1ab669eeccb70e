"""Adaptive sites for a steep front in a swirling flow.

A flow that reverses stretches a steep circular front and should return it to its initial position.
Sites are inserted where the leave-one-out residual is large and removed where it is small. The
final error is compared with the errors on fixed sets of sites, of equal and of larger size.

References
----------
Wendland, Scattered Data Approximation (2005), section 1.3; Behrens and Iske (2002).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from fieldrecon.advection.adaptation import adapted_points
from fieldrecon.advection.characteristics import departure_points
from fieldrecon.advection.semi_lagrangian_steps import State, semi_lagrangian
from fieldrecon.datasets.synthetic import halton, uniform
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.plotting.style import FULL_WIDTH, figure
from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldreport.experiments.advection.advection import DISC, RADIUS, deforming, method_on
from fieldreport.framework.error_measures import rms
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter, require

FRAMES = 4
HEIGHTS = LinearSegmentedColormap.from_list("heights", ["#2a78bb", "#c48600"])
"""Colours of small points, which are visible on a white and on a dark page."""
NOISE = 1e-6  # of the coarsening threshold: smaller residuals are rounding errors


@dataclass(frozen=True)
class Params(Parameters):
    """The front, the flow, and the rules for inserting and removing sites."""

    sites: int = parameter(800, "initial sites, before adaptation", least=50)
    fixed: tuple[int, ...] = parameter(
        (1000, 2000, 4000, 8000), "numbers of fixed sites", least=50, order="increasing"
    )
    steps: int = parameter(30, "time steps, until the flow has returned", least=6)
    period: float = parameter(1.5, "period of the flow", above=0, most=100)
    steepness: float = parameter(40.0, "slope of the front", above=0, most=1e6)
    refine: float = parameter(0.01, "residual above which sites are inserted", above=0, most=1)
    coarsen: float = parameter(0.001, "residual below which sites are removed", least=0, most=1)
    spacing: float = parameter(0.008, "smallest distance of new sites", least=0.001, most=1)
    widest: float = parameter(
        0.05, "distance to the nearest site beyond which sites are kept", above=0, most=2
    )
    rounds: int = parameter(4, "adaptations to the initial field", least=0, most=100)
    shift: float = parameter(
        1e-4, "side of the squares in which sites are shifted randomly", least=0, most=0.01
    )
    seed: int = parameter(0, "seed of the shifts", least=0)

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.coarsen < self.refine, "coarsen", "less than refine", self.coarsen)


QUICK = Params(sites=200, fixed=(200, 400), steps=6, spacing=0.03, rounds=1)


def front(params: Params, x: np.ndarray) -> np.ndarray:
    """One inside the disc and zero outside, with a steep transition."""
    away = np.linalg.norm(x - DISC, axis=-1) - RADIUS
    return (1 - np.tanh(params.steepness * away)) / 2


def following(params: Params, state: State, t: float) -> PartitionOfUnityRBF:
    """The method on the sites of the next step: adapted to this step, then moved with the flow."""
    eta = np.abs(leave_one_out(state.method, state.values))
    eta[eta < NOISE * params.coarsen] = 0
    rules = {"refine": params.refine, "coarsen": params.coarsen, "spacing": params.spacing}
    rules["widest"] = params.widest
    x = shifted(params, adapted_points(state.method.points, eta, **rules))
    flow = partial(deforming, params.period)
    return method_on(departure_points(x, flow, state.time, state.time - t))


def shifted(params: Params, x: np.ndarray) -> np.ndarray:
    """Shift sites slightly, so that distances differ and rounding does not decide about neighbours.

    Distances between midpoints, and between initial sites, are often equal.
    """
    return x + params.shift * (uniform(len(x), 2, params.seed) - 0.5)


def run(params: Params, each: Map = map) -> Result:
    """Advect the front on adaptive sites, and on all numbers of fixed sites."""
    jobs = (0, *params.fixed)
    found = list(each(partial(carried, params), jobs))
    counts, error, frames = found[0]
    rows = [("adaptive", int(counts.mean()), error)]
    rows += [("fixed", n, e) for n, (_, e, _) in zip(params.fixed, found[1:], strict=True)]
    stay = np.array([e for _, e, _ in found[1:]])
    facts: dict[str, Cell] = {
        "mean_sites": float(counts.mean()),
        "most_sites": int(counts.max()),
        "error": error,
        "best_fixed_error": float(stay.min()),
    }
    arrays = {f"sites_{k}": x for k, x in enumerate(frames)}
    return Result(
        params=params,
        tables={"errors": ResultTable(("sites", "number", "rms error"), tuple(rows))},
        facts=facts,
        arrays=arrays | {"counts": counts},
    )


def carried(params: Params, fixed: int) -> tuple[np.ndarray, float, list[np.ndarray]]:
    """Numbers of sites, final error, and sites with values (n, 3) at a few times.

    The error is measured on a lattice against the initial field. Without a number of fixed sites,
    the sites are adaptive.
    """
    follow = fixed == 0
    x = shifted(params, halton(params.sites, 2)) if follow else halton(fixed, 2)
    for _ in range(params.rounds if follow else 0):
        x = following(params, State(0.0, method_on(x), front(params, x)), 0.0).points
    states = semi_lagrangian(
        method_on(x),
        front(params, x),
        partial(deforming, params.period),
        np.linspace(0, params.period, params.steps + 1),
        sites=partial(following, params) if follow else None,
    )
    counts, frames = [], []
    shown = np.linspace(0, params.steps / 2, FRAMES).round()
    for k, state in enumerate(states):
        counts.append(len(state.values))
        if k in shown:
            frames.append(np.column_stack([state.method.points, state.values]))
    g = (np.arange(150) + 0.5) / 150
    lattice = np.stack(np.meshgrid(g, g), axis=-1)
    end = state.method.field(state.values)(lattice)
    return np.array(counts), rms((end - front(params, lattice))[..., None]), frames


def plot(result: Result) -> Figure:
    """Adaptive sites and their values at four times until the flow reverses."""
    with figure(FULL_WIDTH, height=1.75, columns=FRAMES, sharey=True) as (page, axes):
        half = result.params.period / 2
        for k, panel in enumerate(axes):
            x, y, u = result.arrays[f"sites_{k}"].T
            panel.scatter(x, y, 1.5, u, cmap=HEIGHTS, vmin=0, vmax=1, linewidths=0)
            panel.set(title=f"$t = {k * half / (FRAMES - 1):.2f}$", aspect="equal")
            panel.set(xlim=(0, 1), ylim=(0, 1), xticks=[0, 1], yticks=[0, 1])
            panel.grid(visible=False)
    return page
