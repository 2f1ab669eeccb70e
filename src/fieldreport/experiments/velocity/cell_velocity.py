"""Cell velocities from normal velocities: accuracy at the circumcentre and elsewhere.

One constant velocity is fitted to the normal velocities of the faces of each cell. For a rotation,
an expansion and a strain it is compared with the field at the circumcentre of the cell and, as a
warning, at its centroid and at its vertices; the error is compared with its closed form. Then the
normal velocities are perturbed, so that inflow and outflow of a cell no longer balance.

References
----------
Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 23-25, 44).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from matplotlib.tri import Triangulation

from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.plotting.style import FULL_WIDTH, METHOD_COLORS, figure, line
from fieldrecon.velocity.cells import cell_velocities, raviart_thomas
from fieldrecon.velocity.cells_to_vertices import vertex_velocities_from_cells
from fieldrecon.velocity.vertices import normal_velocities
from fieldreport.experiments.meshes.reference_flows import abc_flow, jittered_cube, taylor_green
from fieldreport.framework.error_measures import middle, order, order_of_magnitude, rms
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter, require

ROTATION = np.array([[0.0, -1.0], [1.0, 0.0]])
STRAIN = np.diag([1.0, -1.0])

Velocity = Callable[[np.ndarray], np.ndarray]

GRADIENTS = {
    2: {
        "rotation": ROTATION,
        "expansion": np.eye(2),
        "strain": STRAIN,
    },
    3: {
        "rotation": np.array([[0.0, -1.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 1.0, 0.0]]) / np.sqrt(3),
        "expansion": np.eye(3),
        "strain": np.diag([1.0, 0.0, -1.0]),
    },
}
"""Gradients G of the affine fields u(x) = G (x - m), by dimension."""

PLACES = ("circumcentre", "centroid", "vertices", "RT at circumcentre", "inner vertices")
EXACT = 1e-12
FLAT = 1e-6
"""Area of a flat triangle, over the square of its size."""


@dataclass(frozen=True)
class Params(Parameters):
    """Meshes, a triangle, and the perturbation of the normal velocities."""

    sides: tuple[int, ...] = parameter(
        (8, 16, 32, 64, 128),
        "steps along a side of the unit square",
        least=2,
        fewest=2,
        order="increasing",
    )
    sides_3d: tuple[int, ...] = parameter(
        (4, 6, 9, 13), "steps along a side of the unit cube", least=2, fewest=2, order="increasing"
    )
    shown_side: int = parameter(4, "steps along a side of the mesh in the figure", least=2)
    jitter: float = parameter(
        0.6, "range of the random displacement of a vertex, in steps", least=0, below=1
    )
    triangle: tuple[float, ...] = parameter(
        (0.0, 0.0, 4.0, 0.0, 1.0, 2.6),
        "coordinates of the corners of the triangle in the figure",
        least=-1e6,
        most=1e6,
        entries=6,
    )
    strains: int = parameter(24, "axes of the strains of that triangle", least=3)
    draws: int = parameter(100, "number of draws of the noise", least=1)
    disturbance: float = parameter(
        0.1, "standard deviation of the noise; a rotation has rate 1", least=1e-9, most=1e9
    )
    seed: int = parameter(0, "seed of meshes and noise", least=0)

    def __post_init__(self) -> None:
        super().__post_init__()
        a, b, c = self.corners
        (u, v), (x, y) = b - a, c - a
        flat = abs(u * y - v * x) <= FLAT * np.ptp(self.corners) ** 2
        wanted = f"three corners that are not on one line, to {FLAT:g} of their extent"
        require(not flat, "triangle", wanted, self.triangle)

    @property
    def corners(self) -> np.ndarray:
        """The corners (3, 2) of the triangle in the figure."""
        return np.reshape(self.triangle, (3, 2))


QUICK = Params(sides=(4, 8), sides_3d=(3, 5), shown_side=3, strains=3)


def run(params: Params, each: Map = map) -> Result:
    """Reconstruct each field on each mesh, and a few more on one triangle."""
    jobs = [(d, side) for d in (2, 3) for side in _sides(params, d)]
    found = dict(zip(jobs, each(partial(errors_on_mesh, params), jobs), strict=True))
    finest = {d: found[d, max(_sides(params, d))] for d in (2, 3)}
    disturbed = [
        _disturbed(params, finest_side, d)
        for d, finest_side in ((2, max(params.sides)), (3, max(params.sides_3d)))
    ]
    places = places_on_triangle(params.corners, params.strains)
    return Result(
        params=params,
        tables={
            "fields": _table(finest),
            "disturbed": ResultTable(
                ("dimension", "disturbance", "predicted disturbance", "defect / noise"),
                tuple((d, *row) for d, row in zip((2, 3), disturbed, strict=True)),
            ),
        },
        facts=_facts(params, found, disturbed, places),
        arrays=_shown(params) | places | _curves(params, found),
    )


def errors_on_mesh(params: Params, job: tuple[int, int]) -> dict[str, np.ndarray]:
    """Return for each field the rms errors at PLACES and the rms defect; of vortices, medians.

    For affine fields the largest distance from the closed form follows, in space NaN.
    """
    d, side = job
    mesh = jittered_cube(side, d, params.jitter, params.seed)
    errors = {}
    u: Velocity
    for name, g in GRADIENTS[d].items():
        u = partial(_affine, g)
        v = normal_velocities(mesh, u(mesh.points))
        closed = _gap_from_closed_form(mesh, g, v) if d == 2 else np.nan
        errors[name] = np.array([*_errors(mesh, u, v), closed])
    if d == 3:  # the face normal through the circumcentre of the cell meets that of the face
        u = partial(_affine, GRADIENTS[3]["rotation"])
        v = np.einsum("fd,fd->f", mesh.face_normals, u(mesh.face_circumcenters))
        errors["rotation, v at circumcentres"] = np.array([*_errors(mesh, u, v), np.nan])
    u = taylor_green if d == 2 else abc_flow
    v = normal_velocities(mesh, u(mesh.points))
    errors["vortices"] = np.array(_errors(mesh, u, v, middle))
    return errors


def _affine(g: np.ndarray, x: np.ndarray) -> np.ndarray:
    return (x - 0.5) @ g.T


def _errors(
    mesh: SimplexMesh, u: Velocity, v: np.ndarray, size: Callable[[np.ndarray], float] = rms
) -> list[float]:
    found = cell_velocities(mesh, v)
    corners = found.values[:, None] - u(mesh.points[mesh.cells])
    inner = np.flatnonzero(~mesh.boundary_vertices)
    back = vertex_velocities_from_cells(mesh, found.values, inner) - u(mesh.points[inner])
    return [
        size(found.values - u(mesh.circumcenters)),
        size(found.values - u(mesh.cell_centers)),
        size(corners),
        size(raviart_thomas(mesh, v) - u(mesh.circumcenters)),
        size(back),
        float(np.sqrt(np.mean(found.defect**2))),
    ]


def _gap_from_closed_form(mesh: SimplexMesh, g: np.ndarray, v: np.ndarray) -> float:
    error = cell_velocities(mesh, v).values - _affine(g, mesh.circumcenters)
    return float(np.abs(error - closed_form(mesh.points[mesh.cells], g)).max())


def _disturbed(params: Params, side: int, d: int) -> tuple[float, float, float]:
    """Return the rms change of velocities by noise, its value by numpy, and the defect."""
    mesh = jittered_cube(side, d, params.jitter, params.seed)
    shape = (len(mesh.faces), params.draws)
    noise = np.random.default_rng(params.seed).normal(0, params.disturbance, shape)
    found = cell_velocities(mesh, noise)
    inverse = np.linalg.pinv(mesh.face_normals[mesh.cell_faces])
    predicted = params.disturbance * np.sqrt((inverse**2).sum(axis=(1, 2)).mean())
    defect = np.sqrt(np.mean(found.defect**2)) / params.disturbance
    return rms(found.values), float(predicted), float(defect)


def _sides(params: Params, d: int) -> tuple[int, ...]:
    return params.sides if d == 2 else params.sides_3d


def _told(error: float) -> float:
    return order_of_magnitude(error) if error < EXACT else float(error)


def _table(finest: dict[int, dict[str, np.ndarray]]) -> ResultTable:
    rows: Iterable[tuple[Cell, ...]] = (
        (d, name, *map(_told, errors[: len(PLACES) + 1]))
        for d, of_fields in finest.items()
        for name, errors in of_fields.items()
        if name != "vortices"
    )
    return ResultTable(("dimension", "field", *PLACES, "defect"), tuple(rows))


def _curves(
    params: Params, found: dict[tuple[int, int], dict[str, np.ndarray]]
) -> dict[str, np.ndarray]:
    """Errors of the vortices by dimension, (sides, places)."""
    return {
        f"vortices_{d}d": np.array([found[d, side]["vortices"] for side in _sides(params, d)])
        for d in (2, 3)
    }


def _shown(params: Params) -> dict[str, np.ndarray]:
    mesh = jittered_cube(params.shown_side, 2, params.jitter, params.seed)
    fields = [partial(_affine, g) for g in GRADIENTS[2].values()]
    found = [cell_velocities(mesh, normal_velocities(mesh, u(mesh.points))).values for u in fields]
    return {
        "points": mesh.points,
        "cells": mesh.cells,
        "circumcenters": mesh.circumcenters,
        "found": np.array(found),
        "truth": np.array([u(mesh.circumcenters) for u in fields]),
    }


def _facts(
    params: Params,
    found: dict[tuple[int, int], dict[str, np.ndarray]],
    disturbed: list[tuple[float, float, float]],
    places: dict[str, np.ndarray],
) -> dict[str, Cell]:
    steps = {d: 1 / np.array(_sides(params, d)) for d in (2, 3)}
    curves = {d: _curves(params, found)[f"vortices_{d}d"] for d in (2, 3)}
    gaps = [found[2, side][name][-1] for side in params.sides for name in GRADIENTS[2]]
    finest = {d: found[d, max(_sides(params, d))] for d in (2, 3)}
    off_circle = (
        np.linalg.norm(places["places"][2:] - places["nine_point_center"], axis=1)
        - places["nine_point_radius"]
    )
    facts: dict[str, Cell] = {
        "closed_form_gap": order_of_magnitude(max(gaps)),
        "off_circle": order_of_magnitude(np.abs(off_circle).max()),
        "rotation_error": order_of_magnitude(finest[2]["rotation"][0]),
        "rotation_at_centroid": finest[2]["rotation"][1],
        "rotation_at_vertices": finest[2]["rotation"][2],
        "strain_error": finest[2]["strain"][0],
        "strain_defect": order_of_magnitude(finest[2]["strain"][-2]),
        "expansion_error": finest[2]["expansion"][0],
        "expansion_defect": finest[2]["expansion"][-2],
        "rotation_error_3d": finest[3]["rotation"][0],
        "rotation_circumcentres_3d": order_of_magnitude(
            finest[3]["rotation, v at circumcentres"][0]
        ),
    }
    for d, (change, predicted, defect) in zip((2, 3), disturbed, strict=True):
        inner = curves[d][:, PLACES.index("inner vertices")]
        facts |= {
            f"order_{d}d": order(steps[d], curves[d][:, 0]),
            f"first_order_inner_{d}d": order(steps[d][:2], inner[:2]),
            f"last_order_inner_{d}d": order(steps[d][-2:], inner[-2:]),
            f"gain_inner_{d}d": curves[d][-1, 0] / inner[-1],
            f"disturbance_gain_{d}d": predicted / params.disturbance,
            f"drawn_gain_{d}d": change / params.disturbance,
            f"defect_over_noise_{d}d": defect,
        }
    return facts


def closed_form(corners: np.ndarray, g: np.ndarray) -> np.ndarray:
    """Return u − G O of the least-squares velocity u of triangles (m, 3, 2) in the field G x.

    With O the circumcentre, R the circumradius, q_a the corners from O as complex numbers, h their
    sum, K the symmedian point from O, and G = sI + ωJ + S with Sz = σ z̄:
    u − u(O) = s K + ½ (σ h̄ − σ̄ q₁q₂q₃ / R²).

    Examples
    --------
    >>> equilateral = np.array([[[0.0, 0.0], [1.0, 0.0], [0.5, np.sqrt(0.75)]]])
    >>> closed_form(equilateral, np.diag([1.0, -1.0])).round(6) + 0.0
    array([[0.      , 0.288675]])
    """
    s, sigma = np.trace(g) / 2, complex(g[0, 0] - g[1, 1], g[0, 1] + g[1, 0]) / 2
    p = corners @ np.array([1, 1j])
    sides = np.abs(np.roll(p, -1, axis=1) - np.roll(p, -2, axis=1)) ** 2  # opposite each corner
    weights = sides * (sides.sum(axis=1, keepdims=True) - 2 * sides)
    center = (weights * p).sum(axis=1) / weights.sum(axis=1)
    q = p - center[:, None]
    symmedian = (sides * q).sum(axis=1) / sides.sum(axis=1)
    strain = sigma * q.sum(axis=1).conj() - sigma.conjugate() * q.prod(axis=1) / abs(q[:, 0]) ** 2
    error = s * symmedian + strain / 2
    return np.stack([error.real, error.imag], axis=-1)


def places_on_triangle(corners: np.ndarray, strains: int) -> dict[str, np.ndarray]:
    """Find the points of a triangle where each field equals its least-squares velocity.

    Returns
    -------
    dict
        The corners, circumcentre, centroid, symmedian point, the centre and radius of the
        nine-point circle, and the points for the rotation, the expansion, and strains.
    """
    mesh = SimplexMesh(corners, np.array([[0, 1, 2]]))
    center, sides = mesh.circumcenters[0], mesh.face_measures[mesh.cell_faces[0]]
    angle = (
        np.arange(strains) * np.pi / strains
    )  # argument of σ; the angle of the axis is half of it
    cos, sin = np.cos(angle), np.sin(angle)
    gradients = [
        ROTATION,
        np.eye(2),
        *np.moveaxis(np.array([[cos, sin], [sin, -cos]]), -1, 0),
    ]
    velocities = [
        cell_velocities(mesh, normal_velocities(mesh, mesh.points @ g.T)).values[0]
        for g in gradients
    ]
    return {
        "corners": corners,
        "center": center,
        "centroid": mesh.cell_centers[0],
        "symmedian": sides**2 @ mesh.points[mesh.cells[0]] / (sides @ sides),
        "nine_point_center": center + (mesh.points - center).sum(axis=0) / 2,
        "nine_point_radius": np.linalg.norm(mesh.points[0] - center) / 2,
        "places": np.linalg.solve(np.array(gradients), np.array(velocities)[..., None])[..., 0],
    }


TRUE, FOUND = "#b4b4b4", METHOD_COLORS["RBF"]


def plot(result: Result) -> Figure:
    """The reconstructed velocities, thin, over the exact ones at the circumcentres, thick."""
    arrays, names = result.arrays, tuple(GRADIENTS[2])
    triangles = Triangulation(arrays["points"][:, 0], arrays["points"][:, 1], arrays["cells"])
    with figure(FULL_WIDTH, height=2.35, columns=len(names)) as (page, axes):
        for panel, name, found, true in zip(
            axes, names, arrays["found"], arrays["truth"], strict=True
        ):
            panel.triplot(triangles, color="#d2d2d2", linewidth=0.6)
            look = {"angles": "xy", "scale_units": "xy", "scale": 4.2, "zorder": 3}
            at = arrays["circumcenters"].T
            thick = {"width": 0.021, "headwidth": 2.2, "headlength": 2.6, "headaxislength": 2.4}
            panel.quiver(*at, *true.T, color=TRUE, label="exact", **thick, **look)
            panel.quiver(*at, *found.T, color=FOUND, width=0.006, label="reconstructed", **look)
            panel.set_title(name)
            _bare(panel)
        axes[1].legend(loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=2)
    return page


def plot_places(result: Result) -> Figure:
    """A triangle with its centres, its nine-point circle, and the points of exact velocity."""
    arrays = result.arrays
    corners, places = arrays["corners"], arrays["places"]
    center, nine = arrays["center"], arrays["nine_point_center"]
    with figure(FULL_WIDTH * 0.62, height=3.0) as (page, panel):
        panel.add_patch(Polygon(corners, facecolor="#f1f1f1", edgecolor="black", linewidth=0.9))
        radius = float(np.linalg.norm(corners[0] - center))
        circle = {"fill": False, "edgecolor": "#8a8a8a", "linewidth": 0.7}
        panel.add_patch(Circle(tuple(center), radius, linestyle=(0, (4, 2)), **circle))
        panel.add_patch(Circle(tuple(nine), float(arrays["nine_point_radius"]), **circle))
        small = {"linestyle": "none", "zorder": 4, "clip_on": False}
        panel.plot(*places[2:].T, "o", color=METHOD_COLORS["LS"], label="strains", **small)
        panel.plot(*places[1], "s", color=METHOD_COLORS["MLS"], label="expansion", **small)
        panel.plot(*places[0], "^", color=METHOD_COLORS["RBF"], label="rotation", **small)
        named = {"$O$": center, "$K$": arrays["symmedian"], "$M$": arrays["centroid"]}
        panel.plot(
            *arrays["centroid"], "x", color="black", markersize=4, label="(centroid)", **small
        )
        for name, at in named.items():
            panel.annotate(name, at, (5, 3), textcoords="offset points")
        _bare(panel)
        panel.set(xlim=center[0] + np.array([-1.04, 1.04]) * radius)
        panel.set(ylim=center[1] + np.array([-1.04, 1.04]) * radius)
        panel.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return page


def plot_orders(result: Result) -> Figure:
    """Errors of the vortices against the size of the cells, left in the plane, right in space."""
    arrays, params = result.arrays, result.params
    looks = {
        "at the vertices": line("LS"),
        "at the circumcentre": line("RBF"),
        "at the centroid": line("MLS"),
        "interpolated to inner vertices": line("PU"),
    }
    shown = [2, 0, 1, 4]
    with figure(FULL_WIDTH, height=2.7, columns=2) as (page, axes):
        for panel, d, sides in zip(axes, (2, 3), (params.sides, params.sides_3d), strict=True):
            h = 1 / np.array(sides)
            errors = arrays[f"vortices_{d}d"][:, shown]
            for error, (label, look) in zip(errors.T, looks.items(), strict=True):
                panel.plot(h, error, **look | {"label": label})
            reach = h[[0, -1]]
            slope = 0.6 * errors[-1].min() * reach / h[-1]
            panel.plot(reach, slope, **line("truth", label=None))
            panel.annotate("$h$", (h[0], slope[0]), (-8, -10), textcoords="offset points")
            panel.set(xscale="log", yscale="log", xlabel="step $h$")
            panel.set_title("vortices in the plane" if d == 2 else "ABC flow in space")
            panel.set_xticks(h, [f"1/{side}" for side in sides], minor=False)
            panel.minorticks_off()
        axes[0].set_ylabel("median error")
        handles, labels = axes[0].get_legend_handles_labels()
        page.legend(handles, labels, loc="outside upper center", ncols=len(looks))
    return page


def _bare(panel: Axes) -> None:
    panel.set_aspect("equal")
    panel.set_axis_off()
