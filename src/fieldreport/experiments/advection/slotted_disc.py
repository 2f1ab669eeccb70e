"""Slotted disc after one revolution, compared with published finite-element errors.

As in level set methods, the disc is the set where a field is negative; initially the field is the
signed distance to the boundary. The disc makes one revolution on scattered sites, as many as the
published finite-element computation had unknowns, and the errors are measured in the same way.

References
----------
Doyeux, Modélisation et simulation de systèmes multi-fluides, thesis, Grenoble (2014), as tabulated
in the Feel++ book, "Solid rotation of a slotted disk".
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial import cKDTree

from fieldrecon.advection.semi_lagrangian_steps import semi_lagrangian
from fieldrecon.plotting.style import FULL_WIDTH, figure
from fieldreport.experiments.advection.advection import (
    DISC,
    RADIUS,
    disc,
    method_on,
    shapes,
    turning,
)
from fieldreport.framework.error_measures import order
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter

UNKNOWNS = 72314
"""Unknowns of the finest published mesh; each coarser mesh has twice the time step."""
PUBLISHED = {  # for four time steps, the longest first: sign change error, mass error
    "CIP": ((0.072, 0.055, 0.033, 0.020), (0.00029, 0.00202, 0.00049, 0.00110)),
    "SUPG": ((0.065, 0.049, 0.030, 0.018), (0.01632, 0.07052, 0.00073, 0.00831)),
    "GLS": ((0.066, 0.051, 0.031, 0.019), (0.02499, 0.05180, 0.00805, 0.00672)),
    "SGS": ((0.065, 0.050, 0.030, 0.018), (0.01103, 0.07570, 0.00084, 0.00850)),
}
SLOT, TOP = 0.025, 0.1  # half its width; its end above the centre of the disc


@dataclass(frozen=True)
class Params(Parameters):
    """Sites and steps."""

    levels: int = parameter(
        3,
        "number of the four published meshes to use, coarsest first",
        least=2,
        most=len(PUBLISHED["CIP"][0]),
    )
    steps: int = parameter(20, "time steps of the revolution", least=2)
    lattice: int = parameter(
        1200, "points along a side of the square in which areas are measured", least=10
    )


QUICK = Params(levels=2, steps=4, lattice=200)


def sites_of(level: int) -> int:
    """Sites in the unit square, as many as the mesh had unknowns."""
    return round(UNKNOWNS / 4 ** (len(PUBLISHED["CIP"][0]) - 1 - level))


def rim(count: int = 40_000) -> np.ndarray:
    """Points (count, 2) along the boundary of the slotted disc, nearly equidistant."""
    half = np.arcsin(SLOT / RADIUS)
    foot = -RADIUS * np.cos(half)
    angle = -np.pi / 2 + np.linspace(half, 2 * np.pi - half, 1000)
    arc = RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    corners = np.array([[-SLOT, foot], [-SLOT, TOP], [SLOT, TOP], [SLOT, foot]])
    turns = np.vstack([arc, corners])
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(turns, axis=0), axis=1))])
    at = np.linspace(0, length[-1], count)
    return DISC + np.stack([np.interp(at, length, turns[:, k]) for k in (0, 1)], axis=1)


def signed_distance(x: np.ndarray) -> np.ndarray:
    """Signed distance (m,) to the boundary, negative in the slotted disc."""
    return np.where(shapes(x)[:, 0] > 0, -1.0, 1.0) * cKDTree(rim()).query(x)[0]


def run(params: Params, each: Map = map) -> Result:
    """Rotate the disc once, on all numbers of sites."""
    levels = range(params.levels)
    found = list(each(partial(turned, params), levels))
    signs, masses = np.array([f[:2] for f in found]).T
    rows = [
        (
            sites_of(k),
            s,
            *(PUBLISHED[w][0][k] for w in PUBLISHED),
            m,
            *(PUBLISHED[w][1][k] for w in ("CIP", "SUPG")),
        )
        for k, s, m in zip(levels, signs, masses, strict=True)
    ]
    names = ("unknowns", "here", *PUBLISHED, "mass here", "mass CIP", "mass SUPG")
    best = np.array([min(PUBLISHED[w][0][k] for w in PUBLISHED) for k in levels])
    steps = np.array([sites_of(k) for k in levels]) ** -0.5
    facts: dict[str, Cell] = {
        "published_unknowns": UNKNOWNS,
        "coarsest": sites_of(0),
        "smallest_of_best": float((signs / best).min()),
        "order": order(steps, signs),
        "published_order": order(steps, best),
        "area_coarsest": masses[0],
        "area_published_coarsest": PUBLISHED["CIP"][1][0],
        "area_finest": masses[-1],
        "area_published_finest": PUBLISHED["CIP"][1][levels[-1]],
    }
    frames = {f"frame_{k}": frame for k, (_, _, frame) in enumerate(found)}
    return Result(
        params=params,
        tables={"errors": ResultTable(names, tuple(rows))},
        facts=facts,
        arrays=frames | {"rim": rim(2000)},
    )


def turned(params: Params, level: int) -> tuple[float, float, np.ndarray]:
    """Sign change error, mass error, and the field after one revolution on a coarse lattice.

    The errors are the root of the area where the sign has changed, and the relative change of the
    negative area.
    """
    x = disc(round(np.pi / 4 * sites_of(level)))
    method = method_on(x)
    times = np.linspace(0, 1, params.steps + 1)
    *_, end = semi_lagrangian(method, signed_distance(x), turning, times, steady=True)
    part = (np.arange(params.lattice) + 0.5) / params.lattice - 0.5
    places = DISC + 2.4 * RADIUS * np.stack(np.meshgrid(part, part), axis=-1)
    inside = shapes(places.reshape(-1, 2))[:, 0].reshape(places.shape[:2]) > 0
    field = method.field(end.values)(places)
    cell = (2.4 * RADIUS / params.lattice) ** 2
    changed = ((field < 0) != inside).sum() * cell
    mass = abs((field < 0).sum() / inside.sum() - 1)
    return float(np.sqrt(changed)), float(mass), field[::6, ::6]


def plot(result: Result) -> Figure:
    """The disc after one revolution on all numbers of sites, and its initial boundary."""
    levels = result.params.levels
    side = 1.2 * RADIUS
    with figure(FULL_WIDTH, height=2.2, columns=levels, squeeze=False) as (page, axes):
        for k, panel in enumerate(axes[0]):
            field = result.arrays[f"frame_{k}"]
            at = np.linspace(-side, side, len(field))
            x, y = DISC[0] + at, DISC[1] + at
            panel.contourf(x, y, field, [-1, 0], colors=["#a9cbe6"])
            panel.plot(*result.arrays["rim"].T, color="#c48600", linewidth=0.9)
            panel.set(title=f"{sites_of(k):,} sites", aspect="equal")
            panel.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
            panel.set_axis_off()
    return page
