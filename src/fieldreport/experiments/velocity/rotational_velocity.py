"""Rotation from the normal velocities of edges: vertices that one ring determines.

The exercise of the slides: a rotation about the mean of the vertices of a mesh is reduced to the
normal velocities of the edges and reconstructed at the vertices. The field is affine, so it is
reproduced exactly wherever the edges determine it. The edges of the triangles at a vertex do not
determine it at interior vertices of three or four triangles, nor at boundary vertices of one to
three: all vertices of so few triangles lie on a conic, and the net flow along the conic through
each edge is zero.

References
----------
Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 18-22
and 43).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fieldrecon.kernels.weights import inverse_square
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.plotting.style import FULL_WIDTH, METHOD_COLORS, figure, line
from fieldrecon.polynomials import monomials
from fieldrecon.velocity.vertices import (
    normal_velocities,
    velocity_weights,
    vertex_velocities,
)
from fieldreport.experiments.meshes.reference_flows import (
    abc_flow,
    jittered_cube,
    random_square,
    rotation,
    taylor_green,
)
from fieldreport.experiments.velocity.normal_matrix_rank import (
    SPACE,
    VALENCES,
    conics_through,
    counts_of_mesh,
    facts_of_counts,
    field_along,
    one_ring,
    rotation_in_space,
    valences,
    vertices_around,
)
from fieldreport.framework.error_measures import order, order_of_magnitude
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter

FLOWS = {2: taylor_green, 3: abc_flow}


@dataclass(frozen=True)
class Params(Parameters):
    """The meshes, and the weight of moving least squares."""

    inside: int = parameter(110, "random vertices inside the square of a mesh", least=10)
    side: int = parameter(8, "edges along each side of the square", least=2)
    meshes: int = parameter(
        20, "random meshes whose vertices are counted; the first is in the figure", least=1
    )
    epsilon: float = parameter(
        0.5, "ε of the weight 1/(r² + ε²), in lengths of an edge", least=1e-3, most=1e3
    )
    jitter: float = parameter(
        0.6, "fraction of its cell in which a point of a jittered mesh is drawn", least=0, below=1
    )
    sides_2d: tuple[int, ...] = parameter(
        (8, 16, 32, 64, 128),
        "edges along a square, Taylor-Green",
        least=3,
        fewest=2,
        order="increasing",
    )
    sides_3d: tuple[int, ...] = parameter(
        (4, 8, 12, 16), "edges along a cube", least=3, fewest=2, order="increasing"
    )
    weights_side: int = parameter(
        32, "edges along the square on which weights are compared", least=3
    )
    ratios: tuple[float, ...] = parameter(
        (2.0, 1.0, 0.5, 0.25, 0.1),
        "values of ε/h compared",
        least=1e-3,
        most=1e3,
        order="decreasing",
    )
    seed: int = parameter(5, "seed of the meshes", least=0)


QUICK = Params(
    inside=60,
    side=5,
    meshes=4,
    sides_2d=(8, 16),
    sides_3d=(3, 5),
    weights_side=8,
    ratios=(1.0, 0.1),
)


def run(params: Params, each: Map = map) -> Result:
    """Reconstruct on the first mesh, count on all of them, and refine."""
    draw = partial(random_square, params.inside, params.side)
    meshes = [draw((params.seed, k)) for k in range(params.meshes)]
    counted = np.concatenate(list(each(counts_of_mesh, meshes)))
    jobs = [(2, side) for side in params.sides_2d] + [(3, side) for side in params.sides_3d]
    errors = np.array(list(each(partial(errors_on_grid, params), jobs)))
    cubes = [jittered_cube(side, 3, params.jitter, params.seed) for side in params.sides_3d]
    space = zip(params.sides_3d, each(rotation_in_space, cubes), strict=True)
    convergence = tuple((*job, *map(float, e)) for job, e in zip(jobs, errors, strict=True))
    facts, arrays = _exercise(params, meshes[0])
    weights, noise = _compared_weights(params)
    return Result(
        params=params,
        tables={
            "valences": ResultTable(VALENCES, tuple(valences(counted))),
            "convergence": ResultTable(("D", "side", *ERRORS), convergence),
            "weights": ResultTable(WEIGHTS, tuple(weights)),
            "space": ResultTable(("side", *SPACE), tuple((side, *row) for side, row in space)),
        },
        facts=facts
        | noise
        | facts_of_counts(counted)
        | _orders(convergence)
        | _gain_by_rings(params),
        arrays=arrays | _stars(meshes),
    )


# --- the exercise -------------------------------------------------------------------------------


def _exercise(params: Params, mesh: SimplexMesh) -> tuple[dict[str, Cell], dict[str, np.ndarray]]:
    middle = mesh.points.mean(axis=0)
    u = rotation(mesh.points, middle)
    v = normal_velocities(mesh, u)
    first, all_rings = one_ring(mesh, v), vertex_velocities(mesh, v)
    moving = vertex_velocities(mesh, v, inverse_square(params.epsilon / params.side)).values
    error = np.linalg.norm(first.values - u, axis=1)
    at_middle = (mesh.face_normals * rotation(mesh.face_centers, middle)).sum(axis=1)
    cells = np.diff(mesh.vertex_cell_incidence.indptr)
    inside = ~mesh.boundary_vertices
    facts: dict[str, Cell] = {
        "vertices": len(mesh.points),
        "triangles": len(mesh.cells),
        "edges": len(mesh.faces),
        "undetermined": (~first.determined).sum(),
        "of_three": (inside & (cells == 3)).sum(),
        "of_four": (inside & (cells == 4)).sum(),
        "on_boundary": (~inside & ~first.determined).sum(),
        "two_rings": (all_rings.rings == 2).sum(),
        "most_rings": all_rings.rings.max(),
        "error_one_ring": error.max(),
        "speed_at_worst": float(np.linalg.norm(u[error.argmax()])),
        "error_where_determined": order_of_magnitude(error[first.determined].max()),
        "error_ls": order_of_magnitude(np.abs(all_rings.values - u).max()),
        "error_mls": order_of_magnitude(np.abs(moving - u).max()),
        "midpoint_difference": order_of_magnitude(np.abs(v - at_middle).max()),
    }
    arrays = {
        "points": mesh.points,
        "cells": mesh.cells,
        "truth": u,
        "one_ring": first.values,
        "determined": first.determined,
        "triangles": cells,
        "inside": inside,
    }
    return facts, arrays


def _stars(meshes: list[SimplexMesh]) -> dict[str, np.ndarray]:
    """The roundest star of each kind that is not determined; and a cross, which is determined."""
    kinds = {"three": (False, 3), "four": (False, 4), "fan": (True, 3)}
    arrays: dict[str, np.ndarray] = {}
    for kind, (boundary, valence) in kinds.items():
        stars = [
            vertices_around(mesh, int(i))
            for mesh in meshes
            for i in np.flatnonzero(
                (mesh.boundary_vertices == boundary)
                & (np.diff(mesh.vertex_cell_incidence.indptr) == valence)
            )
        ]
        if stars:
            arrays |= _star(kind, max(stars, key=_roundness))
    cross = np.array([[0, 0], [0.8, 0.1], [-0.1, 0.7], [-1.0, -0.125], [0.12, -0.84]])
    return arrays | _star("cross", cross)


def _roundness(y: np.ndarray) -> float:
    apart = np.linalg.norm(y[:, None] - y, axis=2)[np.triu_indices(len(y), 1)]
    return float(apart.min() / apart.max())


def _star(kind: str, y: np.ndarray) -> dict[str, np.ndarray]:
    """Vertices in a frame of size one, and of the conics through them the steepest at the first."""
    y = y / np.abs(y).max()
    conics = conics_through(y)
    steepest = np.linalg.svd(conics[1:3])[2][0]
    conic = conics @ steepest
    conic *= np.sign(conic[np.abs(conic).argmax()])  # the sign of the flow is arbitrary
    return {f"{kind}_points": y, f"{kind}_conic": conic}


# --- refinement ----------------------------------------------------------------------

ERRORS = (
    "h",
    "one ring rms",
    "one ring max",
    "LS rms",
    "LS max",
    "MLS rms",
    "MLS max",
    "one ring rms, undetermined",
    "one ring max, determined",
)
WEIGHTS = (
    "weight",
    "error",
    "error / LS",
    "noise",
    "noise / LS",
    "noise / LS, same edges",
)


def errors_on_grid(params: Params, job: tuple[int, int]) -> np.ndarray:
    """Errors, rms and largest, of the three fits of a smooth flow on a grid of some dimension."""
    d, side = job
    mesh = jittered_cube(side, d, params.jitter, params.seed)
    u = FLOWS[d](mesh.points)
    v = normal_velocities(mesh, u)
    weight = inverse_square(params.epsilon / side)
    first = one_ring(mesh, v)
    fits = [first.values, *(vertex_velocities(mesh, v, w).values for w in (None, weight))]
    lengths = [np.linalg.norm(fit - u, axis=1) for fit in fits]
    measured = [x for e in lengths for x in (_rms(e), e.max())]
    left, right = lengths[0][~first.determined], lengths[0][first.determined]
    return np.array([1 / side, *measured, _rms(left), right.max()])


def _compared_weights(params: Params) -> tuple[list[tuple[Cell, ...]], dict[str, Cell]]:
    """Error of the flow, and velocity caused by unit noise in the data: the rows, and facts.

    Some vertices take other rings with other weights. The theorem of Gauss and Markov compares
    weights on the same edges only, so the noise is compared there as well.
    """
    mesh = jittered_cube(params.weights_side, 2, params.jitter, params.seed)
    u = taylor_green(mesh.points)
    v = normal_velocities(mesh, u)
    rows: list[tuple[Cell, ...]] = []
    least, ratio_on_same, others, share = np.inf, 1.0, 0, 0.0
    for ratio in (None, *params.ratios):
        weight = None if ratio is None else inverse_square(ratio / params.weights_side)
        x, y = velocity_weights(mesh, weight)
        rings = vertex_velocities(mesh, v, weight).rings
        error = _rms(np.linalg.norm(np.column_stack([x @ v, y @ v]) - u, axis=1))
        noise = np.sqrt(x.power(2).sum(axis=1) + y.power(2).sum(axis=1))
        if ratio is None:
            plain, equal, plain_rings = error, noise, rings
        same = rings == plain_rings
        name = "LS" if ratio is None else f"MLS, ε = {ratio:g} h"
        ratio_on_same = _rms(noise[same]) / _rms(equal[same])
        rows.append(
            (name, error, error / plain, _rms(noise), _rms(noise) / _rms(equal), ratio_on_same)
        )
        least = min(least, float((noise[same] / equal[same]).min()))
        others = max(others, int((~same).sum()))
        share = max(share, float(np.sum(equal[~same] ** 2) / np.sum(equal**2)))
    return rows, {
        "least_noise_on_same_edges": least,
        "largest_noise_on_same_edges": ratio_on_same,
        "most_with_other_edges": others,
        "share_with_other_edges": share,
        "compared_vertices": len(u),
    }


def _gain_by_rings(params: Params) -> dict[str, Cell]:
    """Error of least squares over that with weights, at vertices of one and of two rings."""
    mesh = jittered_cube(params.weights_side, 2, params.jitter, params.seed)
    u = taylor_green(mesh.points)
    v = normal_velocities(mesh, u)
    weights = (None, inverse_square(params.epsilon / params.weights_side))
    plain, weighted = (vertex_velocities(mesh, v, w) for w in weights)
    ls, mls = (np.linalg.norm(found.values - u, axis=1) for found in (plain, weighted))
    return {f"gain_{r}": _rms(ls[plain.rings == r]) / _rms(mls[plain.rings == r]) for r in (1, 2)}


def _rms(lengths: np.ndarray) -> float:
    return float(np.sqrt(np.mean(lengths**2)))


def _orders(convergence: tuple[tuple[Cell, ...], ...]) -> dict[str, Cell]:
    """Orders over the last refinement, and undetermined vertices on the finest mesh."""
    facts: dict[str, Cell] = {}
    for d in FLOWS:
        rows = np.array([row for row in convergence if row[0] == d], dtype=float)
        h, *errors = rows[-2:, 2:].T
        for k, name in ((0, "one_ring"), (2, "ls"), (4, "mls")):
            facts[f"order_{name}_{d}d"] = order(h, errors[k])
        facts[f"undetermined_{d}d"] = float(rows[-1, 9])
    facts["largest_one_ring_3d"] = convergence[-1][4]
    facts["determined_over_ls"] = max(float(row[10]) / float(row[6]) for row in convergence)
    return facts


EDGES: dict[str, Any] = {"color": "0.72", "linewidth": 0.5, "zorder": 1}
WRONG = METHOD_COLORS["RBF"]
ARROWS: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "pivot": "tail", "zorder": 3}

KINDS = {
    "three": "inside, 3 triangles",
    "four": "inside, 4 triangles",
    "fan": "boundary, 3 triangles",
    "cross": "inside, a cross",
}
"""Stars drawn with a field that none of their edges sees."""


def plot(result: Result) -> Figure:
    """The mesh, the vertices that one ring does not determine, and their velocities by one ring."""
    a = result.arrays
    left, inside, cells = ~a["determined"], a["inside"], a["triangles"]
    kinds = (
        (left & inside & (cells == 3), "^", "inside, 3 triangles"),
        (left & inside & (cells == 4), "s", "inside, 4 triangles"),
        (left & ~inside, "o", "boundary, 1 to 3 triangles"),
    )
    with figure(FULL_WIDTH, 3.45, columns=2) as (page, (marked, arrows)):
        for axes in (marked, arrows):
            axes.triplot(*a["points"].T, a["cells"], **EDGES)
            _bare(axes)
        for mask, marker, label in kinds:
            marked.plot(*a["points"][mask].T, marker, color=WRONG, markersize=4, label=label)
        marked.plot(*a["points"][~left].T, ".", color="0.35", markersize=2.5)
        scale = 7 * np.abs(a["truth"]).max()
        given = {"color": METHOD_COLORS["LS"], "width": 0.009, "label": "least norm, one ring"}
        _arrows(arrows, a["points"][left], a["one_ring"][left], scale, **given)
        truth = {"color": "black", "width": 0.004, "label": "exact"}
        _arrows(arrows, a["points"][left], a["truth"][left], scale, **truth)
        arrows.margins(0.2)  # for the longest arrow
        marked.set(xlim=arrows.get_xlim(), ylim=arrows.get_ylim())
        marked.set_title("undetermined by one ring")
        arrows.set_title("velocities there")
        page.legend(loc="outside lower center", ncols=5, handlelength=1.2, columnspacing=1.2)
    return page


def _arrows(axes: Axes, start: np.ndarray, u: np.ndarray, scale: float, **look: Any) -> None:
    axes.quiver(*start.T, *u.T, scale=scale, **ARROWS, **look)


def plot_unseen(result: Result) -> Figure:
    """Conics through the vertices of four stars, and the flows along their level lines."""
    kinds = [kind for kind in KINDS if f"{kind}_points" in result.arrays]
    with figure(FULL_WIDTH, 1.68, columns=len(kinds), squeeze=False) as (page, axes):
        for panel, kind in zip(axes[0], kinds, strict=True):
            y, conic = result.arrays[f"{kind}_points"], result.arrays[f"{kind}_conic"]
            draw_flow_along(panel, y, conic)
            _draw_star(panel, y, boundary=kind == "fan")
            velocity = field_along(conic)[:2]
            if np.linalg.norm(velocity) > 1e-6:
                tip = 0.55 * velocity / np.linalg.norm(velocity)
                panel.quiver(0, 0, *tip, color=WRONG, scale=1, width=0.02, **ARROWS)
            panel.set_title(KINDS[kind])
            _bare(panel)
    return page


def draw_flow_along(axes: Axes, y: np.ndarray, conic: np.ndarray) -> None:
    """Draw the level lines of a conic round points, the conic itself thick."""
    reach = 1.25 * np.abs(y).max()
    ticks = np.linspace(-reach, reach, 161)
    grid = np.stack(np.meshgrid(ticks, ticks), axis=-1)
    psi = monomials(grid, 2) @ conic
    levels = np.linspace(-1, 1, 14) * np.abs(psi).max() * 0.7
    axes.contour(
        ticks,
        ticks,
        psi,
        levels=levels,
        colors=[METHOD_COLORS["MLS"]],
        linewidths=0.5,
        linestyles="solid",
        alpha=0.75,
    )
    axes.contour(ticks, ticks, psi, levels=[0.0], colors=[METHOD_COLORS["MLS"]], linewidths=1.6)


def _draw_star(axes: Axes, y: np.ndarray, boundary: bool) -> None:
    """Draw the triangles round the first vertex, in the order of the angles of the others."""
    angle = np.arctan2(*y[1:].T[::-1])
    order = np.argsort(angle)
    if boundary:  # begin after the widest gap, which is the exterior
        turn = np.argmax(np.diff(angle[order], append=angle[order[0]] + 2 * np.pi))
        order = np.roll(order, -turn - 1)
    rim = y[1:][order]
    rim = rim if boundary else np.vstack([rim, rim[:1]])
    look: dict[str, Any] = {"color": "black", "linewidth": 0.8, "zorder": 2}
    axes.plot(*rim.T, **look)
    for corner in y[1:]:
        axes.plot(*np.stack([y[0], corner]).T, **look)
    axes.plot(*y.T, "o", color="black", markersize=3, zorder=4)


def _bare(axes: Axes) -> None:
    axes.set(aspect="equal", xticks=[], yticks=[])
    axes.grid(visible=False)
    axes.spines[:].set_visible(False)


def plot_convergence(result: Result) -> Figure:
    """Errors of smooth flows against the length of the edges, in the plane and in space."""
    table = result.tables["convergence"]
    rows = np.array(table.rows, dtype=float)
    column = {name: k for k, name in enumerate(table.columns)}
    looks: dict[str, dict[str, Any]] = {
        "one ring max": line("truth", linestyle=":", marker="v", label="one ring, largest"),
        "one ring rms": line("truth", marker="v", label="one ring, rms"),
        "LS rms": line("LS", label="rings as needed, LS, rms"),
        "MLS rms": line("MLS", label="rings as needed, MLS, rms"),
    }
    with figure(FULL_WIDTH, 2.9, columns=2) as (page, axes):
        for panel, d, flow in zip(axes, (2, 3), ("Taylor-Green", "ABC flow"), strict=True):
            chosen = rows[rows[:, column["D"]] == d]
            h = chosen[:, column["h"]]
            for name, look in looks.items():
                panel.plot(h, chosen[:, column[name]], **look)
            second = 0.6 * chosen[0, column["LS rms"]] * (h / h[0]) ** 2
            panel.plot(h, second, color="0.6", linewidth=0.8, zorder=0)
            at = (np.sqrt(h[0] * h[1]), np.sqrt(second[0] * second[1]))
            panel.annotate("$h^2$", at, (3, -3), textcoords="offset points", va="top", color="0.4")
            panel.set(xscale="log", yscale="log", xlabel="$h$", title=f"{flow}, D = {d}")
            sides = chosen[:, column["side"]].astype(int)
            panel.set_xticks(h, [f"1/{side}" for side in sides])
            panel.minorticks_off()
        axes[0].set_ylabel("error of the velocity")
        page.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return page
