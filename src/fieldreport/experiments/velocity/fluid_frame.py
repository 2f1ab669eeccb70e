"""Flow past a cylinder: velocities from the fluxes through faces.

A finite-volume solver knows the flux through each face. Here the fluxes are exact: those of
potential flow past a cylinder, on an unstructured mesh. They determine the velocities of all
vertices and cells, streamlines, and the pressure on the cylinder; each is compared with its closed
form while the mesh is refined. The same is done for a ball in space.

References
----------
Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 14-26).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from matplotlib.tri import Triangulation
from scipy.interpolate import LinearNDInterpolator

from fieldrecon.kernels.weights import inverse_square
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.plotting.style import (
    BLACK_ON_MAP,
    FULL_WIDTH,
    METHOD_COLORS,
    WHITE_ON_MAP,
    figure,
    line,
)
from fieldrecon.velocity.cells import cell_velocities
from fieldrecon.velocity.cells_to_vertices import vertex_velocities_from_cells
from fieldrecon.velocity.vertices import divergence, vertex_velocities
from fieldreport.experiments.velocity.potential_flow import (
    ball_mesh,
    disc_mesh,
    mean_normal_velocities,
    pressure_coefficient,
    stream_function,
    velocity,
)
from fieldreport.framework.error_measures import order, order_of_magnitude, rms
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter, require

HALVINGS = 60

MEASURES = (
    "inner vertices",
    "surface",
    "surface by LS",
    "cells",
    "vertices from cells",
    "pressure on surface",
)
LEFT = 3.3
"""Start of the streamlines, left of the cylinder, in radii."""


@dataclass(frozen=True)
class Params(Parameters):
    """Meshes in units of the radius, and streamlines."""

    around: tuple[int, ...] = parameter(
        (24, 48, 96, 192),
        "vertices on the cylinder, by mesh",
        least=12,
        fewest=2,
        order="increasing",
    )
    outer: float = parameter(
        8.0,
        "radius of the mesh of the plane, in radii of the cylinder",
        least=5,
        most=100,
        because="streamlines begin 3.3 radii from the axis",
    )
    relaxations: int = parameter(
        30, "relaxation steps that push the vertices of the mesh apart", least=0
    )
    steps_3d: tuple[float, ...] = parameter(
        (0.5, 0.35, 0.25, 0.18),
        "distance of neighbours on the ball, by mesh, in radii",
        least=0.05,
        most=1,
        fewest=2,
        order="decreasing",
    )
    outer_3d: float = parameter(
        4.0, "radius of the mesh in space, in radii of the ball", least=1.5, most=20
    )
    epsilon: float = parameter(
        0.5, "ε of the weight 1/(r² + ε²), in steps on the surface", least=1e-3, most=1e3
    )
    shown: int = parameter(48, "vertices on the cylinder, for the mesh in the figure", least=12)
    heights: tuple[float, ...] = parameter(
        (0.03, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0),
        "distances of the streamlines from the axis, far away, in radii",
        least=1e-3,
        most=2,
        order="increasing",
    )
    arc: float = parameter(0.02, "step along a streamline, in radii", least=1e-4, most=1)
    seed: int = parameter(0, "seed of the meshes", least=0)

    def __post_init__(self) -> None:
        super().__post_init__()
        least = 1 + 3 * self.steps_3d[0]
        wanted = f"{least:g} or more, for the largest of steps_3d"
        require(self.outer_3d >= least, "outer_3d", wanted, self.outer_3d)


QUICK = Params(
    around=(16, 32),
    relaxations=3,
    steps_3d=(0.6, 0.45),
    outer_3d=3.0,
    shown=16,
    heights=(0.5, 1.5),
    arc=0.1,
)


def run(params: Params, each: Map = map) -> Result:
    """Reconstruct the flow on each mesh, and trace streamlines."""
    jobs: list[tuple[int, float]] = [(2, n) for n in params.around]
    jobs += [(3, step) for step in params.steps_3d]
    found = dict(zip(jobs, each(partial(errors_on_mesh, params), jobs), strict=True))
    shown = _shown(params)
    return Result(
        params=params,
        tables={
            "plane": _plane_table(params, found),
            "space": _space_table(params, found),
        },
        facts=_facts(params, found, shown),
        arrays=shown
        | {
            "errors": np.array([found[2, n]["errors"] for n in params.around]),
            "steps": np.array([2 * np.pi / n for n in params.around]),
            "surface_fine": found[2, max(params.around)]["surface"],
        },
    )


def errors_on_mesh(params: Params, job: tuple[int, float]) -> dict[str, np.ndarray]:
    """Return the sizes of a mesh, its rms errors by MEASURES, and the rest of its table row."""
    d, size = job
    mesh = _disc(params, int(size)) if d == 2 else ball_mesh(size, params.outer_3d, params.seed)
    v = mean_normal_velocities(mesh)
    step = 2 * np.pi / size if d == 2 else size
    at_vertices = _at_vertices(params, mesh, v, step)
    of_cells = cell_velocities(mesh, v).values
    back = vertex_velocities_from_cells(mesh, of_cells)
    inner, surface = ~mesh.boundary_vertices, np.flatnonzero(on_ball(mesh))
    alike = vertex_velocities(mesh, v, vertices=surface).values
    true = velocity(mesh.points)
    pressure = surface_pressure(mesh, at_vertices)
    drift = drift_of_streamlines(params, mesh, at_vertices) if d == 2 else 0.0
    return {
        "counts": np.array([len(mesh.points), len(mesh.cells)]),
        "errors": np.array(
            [
                rms((at_vertices - true)[inner]),
                rms((at_vertices - true)[surface]),
                rms(alike - true[surface]),
                rms(of_cells - velocity(mesh.circumcenters)),
                rms((back - true)[inner]),
                float(np.sqrt(np.mean((pressure[1] - pressure[2]) ** 2))),
            ]
        ),
        "surface_from_cells": np.array(rms((back - true)[surface])),
        "drift": np.array(drift),
        "divergence": np.abs(divergence(mesh, v)).max(),
        "surface": pressure,
    }


def _at_vertices(params: Params, mesh: SimplexMesh, v: np.ndarray, step: float) -> np.ndarray:
    """Return velocities by moving least squares, with ε in units of the cells at the surface."""
    return vertex_velocities(mesh, v, inverse_square(params.epsilon * step)).values


def on_ball(mesh: SimplexMesh) -> np.ndarray:
    """Whether each vertex lies on the cylinder or the ball."""
    return np.linalg.norm(mesh.points, axis=1) < 1 + 1e-9


def surface_pressure(mesh: SimplexMesh, u: np.ndarray) -> np.ndarray:
    """Return the angle from the stream, 1 − |u|² and its closed form, at the surface.

    The angle covers the full circle in the plane, and half of it in space.
    """
    at, d = mesh.points[on_ball(mesh)], mesh.points.shape[1]
    angle = np.arccos(np.clip(at[:, 0], -1, 1))
    if d == 2:
        angle = np.where(at[:, 1] < 0, 2 * np.pi - angle, angle)
    speed = np.linalg.norm(u[on_ball(mesh)], axis=1)
    return np.stack([angle, 1 - speed**2, pressure_coefficient(at[:, 0], d)])


def drift_of_streamlines(params: Params, mesh: SimplexMesh, u: np.ndarray) -> float:
    """Return the rms deviation of ψ from its initial value along streamlines."""
    psi = stream_function(_traced(params, mesh, u))
    return float(np.sqrt(np.mean((psi - psi[:, :1]) ** 2)))


def _traced(params: Params, mesh: SimplexMesh, u: np.ndarray) -> np.ndarray:
    heights = np.array(params.heights)
    x = np.full(len(heights), -LEFT)
    start = exact_streamline(np.concatenate([heights, -heights]), np.tile(x, 2))
    return traced_streamlines(mesh, u, start, params.arc, LEFT)


def _disc(params: Params, around: int) -> SimplexMesh:
    return disc_mesh(around, params.outer, params.relaxations, params.seed)


def _shown(params: Params) -> dict[str, np.ndarray]:
    mesh = _disc(params, params.shown)
    v = mean_normal_velocities(mesh)
    u = _at_vertices(params, mesh, v, 2 * np.pi / params.shown)
    x = np.linspace(-LEFT, LEFT, 300)
    heights = np.array(params.heights)[:, None]
    return {
        "points": mesh.points,
        "cells": mesh.cells,
        "middles": mesh.face_centers,
        "normal_velocities": v[:, None] * mesh.face_normals,
        "velocities": u,
        "circumcenters": mesh.circumcenters,
        "cell_velocities": cell_velocities(mesh, v).values,
        "traced": _traced(params, mesh, u),
        "exact": exact_streamline(heights, np.broadcast_to(x, (len(heights), len(x)))),
        "surface_coarse": surface_pressure(mesh, u),
    }


def _plane_table(
    params: Params, found: dict[tuple[int, float], dict[str, np.ndarray]]
) -> ResultTable:
    rows = (
        (n, *map(int, f["counts"]), *f["errors"], float(f["drift"]))
        for n in params.around
        for f in [found[2, n]]
    )
    return ResultTable(("around", "vertices", "cells count", *MEASURES, "drift"), tuple(rows))


def _space_table(
    params: Params, found: dict[tuple[int, float], dict[str, np.ndarray]]
) -> ResultTable:
    rows = (
        (step, *map(int, f["counts"]), *f["errors"])
        for step in params.steps_3d
        for f in [found[3, step]]
    )
    return ResultTable(("step", "vertices", "cells count", *MEASURES), tuple(rows))


def _facts(
    params: Params,
    found: dict[tuple[int, float], dict[str, np.ndarray]],
    shown: dict[str, np.ndarray],
) -> dict[str, Cell]:
    errors = {
        d: {
            name.replace(" ", "_"): np.array([found[d, size]["errors"][k] for size in sizes])
            for k, name in enumerate(MEASURES)
        }
        for d, sizes in ((2, params.around), (3, params.steps_3d))
    }
    steps = {2: 2 * np.pi / np.array(params.around), 3: np.array(params.steps_3d)}
    angle, pressure, closed = shown["surface_coarse"]
    top = np.argmin(np.abs(angle - np.pi / 2))
    facts: dict[str, Cell] = {
        "divergence": order_of_magnitude(max(float(f["divergence"]) for f in found.values())),
        "order_drift": order(steps[2], [float(found[2, n]["drift"]) for n in params.around]),
        "surface_over_inner": errors[2]["surface"][-1] / errors[2]["inner_vertices"][-1],
        "surface_ls_over_mls": errors[2]["surface_by_LS"][-1] / errors[2]["surface"][-1],
        "error_surface": errors[2]["surface"][-1],
        "error_surface_from_cells": float(found[2, params.around[-1]]["surface_from_cells"]),
        "suction_missed_percent": 100 * abs(pressure[top] / closed[top] - 1),
    }
    facts["cells_over_faces"] = (
        errors[2]["vertices_from_cells"][-1] / errors[2]["inner_vertices"][-1]
    )
    for name in ("inner_vertices", "surface", "cells", "vertices_from_cells"):
        facts |= {f"order_{name}_{d}d": order(steps[d], errors[d][name]) for d in (2, 3)}
    for name in ("inner_vertices", "cells", "vertices_from_cells"):
        facts[f"error_{name}"] = errors[2][name][-1]
    return facts


def traced_streamlines(
    mesh: SimplexMesh, u: np.ndarray, start: np.ndarray, arc: float, right: float
) -> np.ndarray:
    """Trace velocities, linear between the vertices of a mesh, by the Runge-Kutta method.

    Parameters
    ----------
    mesh : SimplexMesh
        A mesh of triangles.
    u : (n, 2) ndarray
        Velocities of the vertices.
    start : (m, 2) ndarray
        Starting points of the lines.
    arc : float
        Length of a step.
    right : float
        Lines stop when x exceeds this value.

    Returns
    -------
    (m, steps, 2) ndarray
        Points along each line.
    """
    field = LinearNDInterpolator(mesh.points, u)

    def direction(x: np.ndarray) -> np.ndarray:
        v = field(x)
        return v / np.linalg.norm(v, axis=1, keepdims=True)

    lines = [start]
    for _ in range(int(2 * (right - start[:, 0].min()) / arc)):
        x = lines[-1]
        going = x[:, 0] < right
        if not going.any():
            break
        y = x[going]
        k1 = direction(y)
        k2 = direction(y + arc / 2 * k1)
        k3 = direction(y + arc / 2 * k2)
        k4 = direction(y + arc * k3)
        x = x.copy()
        x[going] = y + arc / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        lines.append(x)
    return np.stack(lines, axis=1)


def exact_streamline(height: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the points (x, y) with y (1 − 1/r²) = height, the streamlines past the unit circle.

    For height > 0 the left side is zero on the circle, increases with y outside, and exceeds height
    at y = height + 1; so y is found by bisection.

    Examples
    --------
    >>> exact_streamline(np.array(1.5), np.array(0.0)).round(12).tolist()
    [0.0, 2.0]
    """
    target = np.abs(height) + 0 * x
    low = np.sqrt(np.maximum(1 - x**2, 0))
    high = target + 1
    for _ in range(HALVINGS):
        y = (low + high) / 2
        above = y * (1 - 1 / (x**2 + y**2)) > target
        low, high = np.where(above, low, y), np.where(above, y, high)
    return np.stack([x, np.sign(height) * high], axis=-1)


SPEED = LinearSegmentedColormap.from_list("speed", colormaps["YlGnBu"](np.linspace(0, 0.85, 64)))
"""From light (slow) to dark (fast), also in grey, and light enough for black lines."""

BODY = "white"
"""The cylinder is no part of the map: it has the colour of the page, also on a dark one."""

WINDOW = (-3.1, 3.1, -2.15, 2.15)
CLOSE = (-1.75, -0.25, 0.15, 1.65)


def plot(result: Result) -> Figure:
    """Speed and streamlines above the axis, mesh and velocities below."""
    arrays = result.arrays
    points, u = arrays["points"], arrays["velocities"]
    triangles = Triangulation(points[:, 0], points[:, 1], arrays["cells"])
    speed = np.linalg.norm(u, axis=1)
    with figure(FULL_WIDTH, height=4.0) as (page, panel):
        levels = np.linspace(0, 2.1, 43)
        colors = panel.tricontourf(triangles, speed, levels=levels, cmap=SPEED, extend="max")
        colors.set_edgecolor("face")
        left, right, bottom, _ = WINDOW
        half = Rectangle((left, bottom), right - left, -bottom, transform=panel.transData)
        panel.add_patch(Rectangle((-9, -9), 18, 9, facecolor=WHITE_ON_MAP, alpha=0.55, zorder=2))
        for lines in panel.triplot(triangles, color="#3c4650", linewidth=0.3, zorder=2.5):
            lines.set(clip_path=half, in_layout=False)
        below = _inside(points, (*WINDOW[:2], WINDOW[2], -0.02))
        panel.quiver(
            *points[below].T,
            *u[below].T,
            angles="xy",
            scale_units="xy",
            scale=5.5,
            width=0.0021,
            color=METHOD_COLORS["RBF"],
            zorder=3,
        )
        for y in arrays["exact"]:
            panel.plot(*y.T, color=WHITE_ON_MAP, linewidth=2.4, zorder=3)
        upper = arrays["traced"][: len(arrays["exact"])]
        for y in upper:
            panel.plot(*y.T, color=BLACK_ON_MAP, linewidth=0.8, zorder=3.1)
        panel.add_patch(Circle((0, 0), 1, facecolor=BODY, edgecolor="black", zorder=4))
        panel.set(xlim=WINDOW[:2], ylim=WINDOW[2:], aspect="equal", xlabel="$x$", ylabel="$y$")
        panel.grid(visible=False)
        panel.set_yticks([-2, -1, 0, 1, 2])
        bar = page.colorbar(colors, ax=panel, shrink=0.85, pad=0.02, ticks=[0, 0.5, 1, 1.5, 2])
        bar.set_label("speed $|u|$")
        bar.outline.set_linewidth(0.6)
    return page


def plot_data(result: Result) -> Figure:
    """Normal velocities of faces; velocities of cells; velocities of vertices."""
    arrays = result.arrays
    triangles = Triangulation(arrays["points"][:, 0], arrays["points"][:, 1], arrays["cells"])
    panels = {
        "data: normal velocities of faces": ("middles", "normal_velocities", METHOD_COLORS["LS"]),
        "velocities of cells": ("circumcenters", "cell_velocities", METHOD_COLORS["MLS"]),
        "velocities of vertices": ("points", "velocities", METHOD_COLORS["RBF"]),
    }
    with figure(FULL_WIDTH, height=2.25, columns=3) as (page, axes):
        for panel, (title, (where, what, color)) in zip(axes, panels.items(), strict=True):
            panel.triplot(triangles, color="#bcbcbc", linewidth=0.5)
            at, arrows = arrays[where], arrays[what]
            near = _inside(at, CLOSE)
            panel.quiver(
                *at[near].T,
                *arrows[near].T,
                angles="xy",
                scale_units="xy",
                scale=9.0,
                width=0.008,
                color=color,
                zorder=3,
                pivot="mid" if where == "middles" else "tail",
            )
            panel.add_patch(Circle((0, 0), 1, facecolor=BODY, edgecolor="black", zorder=2))
            panel.set(xlim=CLOSE[:2], ylim=CLOSE[2:], aspect="equal", xticks=[], yticks=[])
            panel.set_title(title)
            panel.grid(visible=False)
            panel.spines[:].set_visible(True)
    return page


def plot_surface(result: Result) -> Figure:
    """Pressure coefficient on the cylinder, and errors against the step."""
    arrays = result.arrays
    with figure(FULL_WIDTH, height=2.9, columns=2) as (page, (left, right)):
        theta = np.linspace(0, 360, 361)
        closed = 1 - 4 * np.sin(np.radians(theta)) ** 2
        left.plot(theta, closed, **line("truth", label=r"$1 - 4\,\sin^2\theta$"))
        for name, look in (
            ("coarse", line("MLS", markerfacecolor="white")),
            ("fine", line("RBF", marker=".", markersize=2.5)),
        ):
            angle, found, _ = arrays[f"surface_{name}"]
            label = f"{len(angle)} vertices"
            left.plot(np.degrees(angle), found, **look | {"linestyle": "none", "label": label})
        left.set(xlabel=r"angle $\theta$ in degrees", title="pressure coefficient on the cylinder")
        left.set_xticks([0, 90, 180, 270, 360])
        left.set_ylim(-3.3, 3.6)
        left.set_yticks([-3, -2, -1, 0, 1])
        left.legend(loc="upper center", ncols=1)
        looks = [
            line("MLS"),
            line("RBF"),
            line("RBF", markerfacecolor="white", linewidth=0.7),
            line("LS"),
            line("PU"),
        ]
        for k, look in enumerate(looks):
            right.plot(arrays["steps"], arrays["errors"][:, k], **look | {"label": MEASURES[k]})
        right.set(xscale="log", yscale="log", xlabel="step on the cylinder, in radii")
        right.set_title("error of the velocity")
        h = arrays["steps"]
        lowest = arrays["errors"][-1, 0]
        right.plot(h, 0.5 * lowest * (h / h[-1]) ** 2, **line("truth", label=None))
        right.annotate(
            "$h^2$", (h[0], 0.5 * lowest * (h[0] / h[-1]) ** 2), (4, -8), textcoords="offset points"
        )
        right.set_xticks(h, [f"2π/{round(2 * np.pi / step)}" for step in h])
        right.minorticks_off()
        right.set_ylim(top=200 * arrays["errors"][0, 1])
        right.legend(loc="upper left", ncols=2, columnspacing=1.0)
    return page


def _inside(x: np.ndarray, window: tuple[float, float, float, float]) -> np.ndarray:
    left, right, bottom, top = window
    return (x[:, 0] > left) & (x[:, 0] < right) & (x[:, 1] > bottom) & (x[:, 1] < top)
