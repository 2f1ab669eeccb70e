"""Fluid animation on dynamic meshes: velocity transfer and pressure projection.

A steady vortex in a box stretches a drop of ink. Each frame has a new mesh, which is refined at the
boundary of the ink. The flow is represented by the normal velocities of the faces only. They
determine the velocities of the vertices; these give the normal velocities of the next mesh, one
time step earlier along the characteristics; a pressure projection then removes their divergence.
The vortex is a steady flow of an ideal fluid, so its energy and its velocities are known at all
times.

References
----------
Klingner, Feldman, Chentanez and O'Brien, Fluid animation with dynamic meshes (2006); Zehnder,
Narain and Thomaszewski, An advection-reflection solver (2018).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation
from scipy.spatial import cKDTree

from fieldrecon.advection.characteristics import departure_points
from fieldrecon.advection.incompressible import (
    carried_normal_velocities,
    divergence_free,
    flow_energy,
)
from fieldrecon.datasets.synthetic import halton
from fieldrecon.fields import Field
from fieldrecon.kernels.weights import inverse_square
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.methods.moving_least_squares import MovingLeastSquares
from fieldrecon.methods.partition_of_unity.method import PartitionOfUnityRBF
from fieldrecon.plotting.style import FULL_WIDTH, figure, line
from fieldrecon.reconstruction import Reconstruction
from fieldrecon.velocity.vertices import divergence, vertex_velocities
from fieldreport.framework.error_measures import order_of_magnitude, rms
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.orders_of_magnitude import floored
from fieldreport.framework.parameters import Parameters, parameter, require

SMOOTHINGS = 3
GROWTH = 0.35
"""Growth of the edge length per distance from where it is smallest."""

INK = np.array([0.5, 0.72])
RADIUS = 0.16
FRAMES = 6
LONGEST_STEP = 0.2  # a tenth of a revolution
ENERGY = 0.25  # of the vortex, at all times
BLUES = LinearSegmentedColormap.from_list("blues", ["#b9d6ec", "#2a78bb"])
"""Shades of the ink, which are visible on a white and on a dark page."""
EPSILON = 1e-3  # of the weights of faces and of vertices, far below the spacing


@dataclass(frozen=True)
class Params(Parameters):
    """Meshes and steps."""

    spacing: float = parameter(
        0.06, "edge length of the mesh away from the ink", least=0.005, most=0.3
    )
    finest: float = parameter(
        0.025, "edge length of the mesh at the boundary of the ink", least=0.002, most=0.3
    )
    steps: int = parameter(10, "time steps, of two meshes each", least=FRAMES - 1)
    time: float = parameter(2.0, "final time; the centre rotates once in time 2", above=0, most=100)

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.finest <= self.spacing, "finest", "spacing or less", self.finest)
        longest = self.steps * LONGEST_STEP
        require(self.time <= longest, "time", f"{longest:g} or less in so many steps", self.time)


QUICK = Params(spacing=0.2, finest=0.15, steps=5, time=0.5)


def vortex(x: np.ndarray) -> np.ndarray:
    """The steady Taylor-Green vortex in the unit square, tangential at the boundary."""
    s, c = np.sin(np.pi * x), np.cos(np.pi * x)
    return np.stack([s[..., 0] * c[..., 1], -c[..., 0] * s[..., 1]], axis=-1)


def on_patches(x: np.ndarray) -> Reconstruction:
    """Radial basis functions on patches."""
    return PartitionOfUnityRBF(x)


def moving_planes(x: np.ndarray) -> Reconstruction:
    """Moving least squares of degree one on the nearest vertices."""
    return MovingLeastSquares(x, inverse_square(EPSILON), degree=1, neighbors=9)


@dataclass(frozen=True)
class Way:
    """The interpolation of velocities; whether there is a pressure projection, and a reflection."""

    name: str
    method: Callable[[np.ndarray], Reconstruction]
    pressure: bool = True
    reflected: bool = False


WAYS = (
    Way("reflected", on_patches, reflected=True),
    Way("reflected, planes", moving_planes, reflected=True),
    Way("plain", on_patches),
    Way("without pressure", on_patches, pressure=False),
)


@dataclass(frozen=True)
class AnimationFrame:
    """A mesh, its normal velocities (f,), those for the next frame (f,), and vertex ink (n,)."""

    mesh: SimplexMesh
    v: np.ndarray
    carried: np.ndarray
    ink: np.ndarray

    def field(self, method: Callable[[np.ndarray], Reconstruction], v: np.ndarray) -> Field:
        """The velocity field reconstructed from normal velocities."""
        u = vertex_velocities(self.mesh, v, inverse_square(EPSILON)).values
        return method(self.mesh.points).field(u)

    @property
    def energy(self) -> float:
        """Kinetic energy for density one."""
        return float(self.v @ (flow_energy(self.mesh) @ self.v)) / 2


def walled(mesh: SimplexMesh, v: np.ndarray) -> np.ndarray:
    """Set the normal velocities of the boundary to zero."""
    return np.where(mesh.face_cells[:, 1] < 0, 0.0, v)


def first(params: Params) -> AnimationFrame:
    """The exact fluxes of the vortex, on a mesh refined at the boundary of the drop."""
    mesh = box_mesh(partial(near_rim, params.spacing, params.finest, None), seed=0)
    for _ in range(2):
        rim = np.abs(np.linalg.norm(mesh.points - INK, axis=1) - RADIUS) < params.finest
        mesh = box_mesh(partial(near_rim, params.spacing, params.finest, mesh.points[rim]), seed=0)
    psi = np.sin(np.pi * mesh.points).prod(axis=1) / np.pi
    start, end = mesh.faces.T
    along = mesh.points[end] - mesh.points[start]
    across = along[:, ::-1] * [1, -1]
    turned = np.sign((across * mesh.face_normals).sum(axis=1))
    v = turned * (psi[end] - psi[start]) / mesh.face_measures
    away = np.linalg.norm(mesh.points - INK, axis=1) - RADIUS
    return AnimationFrame(mesh, v, v, np.clip(0.5 - away / (2 * params.finest), 0, 1))


def next_frame(params: Params, way: Way, k: int, now: AnimationFrame) -> AnimationFrame:
    """Advance by half a step to a mesh that is refined at the new boundary of the ink."""
    dt = params.time / params.steps / 2
    flow = now.field(way.method, now.v)
    rim = now.mesh.points[(now.ink > 0.1) & (now.ink < 0.9)]
    goes = departure_points(rim, flow, 0.0, -dt) if len(rim) else rim
    mesh = box_mesh(partial(near_rim, params.spacing, params.finest, goes), seed=k)
    carried = now.field(way.method, now.carried)
    met = walled(mesh, carried_normal_velocities(mesh, flow, 0.0, dt, carried))
    v = divergence_free(mesh, met) if way.pressure else met
    feet = departure_points(mesh.points, flow, 0.0, dt)
    ink = way.method(now.mesh.points).field(now.ink)(feet)
    reflect = way.reflected and k % 2 == 1
    return AnimationFrame(mesh, v, 2 * v - met if reflect else v, np.clip(ink, 0, 1))


def animated(params: Params, way: Way) -> tuple[np.ndarray, list[AnimationFrame]]:
    """Energy, error and divergence (steps + 1, 3) at the end of each step, and the frames."""
    frames, now = [first(params)], first(params)
    for k in range(1, 2 * params.steps + 1):
        now = next_frame(params, way, k, now)
        if k % 2 == 0:
            frames.append(now)
    return np.array([judged(frame) for frame in frames]), frames


def judged(frame: AnimationFrame) -> tuple[float, float, float]:
    """Energy, root mean square error of the velocities of vertices, largest divergence."""
    u = vertex_velocities(frame.mesh, frame.v, inverse_square(EPSILON)).values
    outflow = np.abs(divergence(frame.mesh, frame.v)).max()
    return frame.energy, rms(u - vortex(frame.mesh.points)), float(outflow)


def exact_rim(time: float, count: int = 400) -> np.ndarray:
    """Points (count, 2) on the boundary of the drop at a given time, traced in the exact flow."""
    angle = np.linspace(0, 2 * np.pi, count)
    x = INK + RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    steps = max(1, round(time / 0.02))
    for _ in range(steps):
        x = departure_points(x, lambda y, _: vortex(y), 0.0, -time / steps)
    return x


def run(params: Params, each: Map = map) -> Result:
    """Run all variants, and keep some frames of the first."""
    found = list(each(partial(animated, params), WAYS))
    history = np.array([h for h, _ in found])
    frames = found[0][1]
    left = history[:, -1, 0] / ENERGY
    rows = [(w.name, e, h[-1, 1], h[-1, 2]) for w, e, h in zip(WAYS, left, history, strict=True)]
    shown = np.linspace(0, params.steps, FRAMES).round().astype(int)
    arrays = {"history": history, "times": shown * params.time / params.steps}
    for k, at in enumerate(shown):
        frame = frames[at]
        arrays |= {f"points_{k}": frame.mesh.points, f"cells_{k}": frame.mesh.cells}
        arrays |= {f"ink_{k}": frame.ink, f"rim_{k}": exact_rim(arrays["times"][k])}
    counts = [len(frame.mesh.points) for frame in frames]
    facts: dict[str, Cell] = {
        "meshes": 2 * params.steps,
        "fewest": min(counts),
        "most": max(counts),
        "divergence": order_of_magnitude(float(history[0, :, 2].max())),
    }
    for name, energy, (_, error, _) in zip(
        ("reflected", "planes", "plain", "loose"), left, history[:, -1], strict=True
    ):
        facts |= {f"{name}_energy": energy, f"{name}_error": float(error)}
    return Result(
        params=params,
        tables={
            "ways": ResultTable(
                ("frames", "energy left", "error", "divergence"),
                tuple((name, e, error, floored(d, 1e-12)) for name, e, error, d in rows),
            )
        },
        facts=facts,
        arrays=arrays,
    )


def near_rim(wide: float, fine: float, rim: np.ndarray | None, x: np.ndarray) -> np.ndarray:
    """Edge lengths: `fine` at the given points, growing to `wide` away from them."""
    if rim is None or not len(rim):
        return np.full(len(x), wide)
    away = cKDTree(rim).query(x)[0]
    return np.minimum(wide, fine + GROWTH * np.maximum(away - fine, 0))


def box_mesh(lengths: Callable[[np.ndarray], np.ndarray], seed: int) -> SimplexMesh:
    """Delaunay mesh of the unit square with edges of about these lengths.

    Random points are accepted if no other point is too close, and then smoothed by moving them a
    few times to the mean of their neighbours.
    """
    rim = boundary(lengths)
    shortest = float(lengths(halton(4000, 2)).min())
    tried = halton(int(4 / shortest**2), 2, seed=seed)
    points = np.vstack([rim, thinned(rim, tried, lengths)])
    for _ in range(SMOOTHINGS):
        points[len(rim) :] = means_of_neighbours(SimplexMesh.delaunay(points))[len(rim) :]
    return SimplexMesh.delaunay(points)


def boundary(lengths: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Points on the sides, spaced according to the edge lengths."""
    t = np.linspace(0, 1, 401)
    sides = []
    for corner, along in (((0, 0), (1, 0)), ((1, 0), (0, 1)), ((1, 1), (-1, 0)), ((0, 1), (0, -1))):
        x = np.array(corner) + t[:, None] * np.array(along)
        density = 1 / lengths(x)
        count = np.concatenate([[0], np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(t))])
        even = np.arange(round(count[-1])) * (count[-1] / round(count[-1]))
        sides.append(np.array(corner) + np.interp(even, count, t)[:, None] * np.array(along))
    return np.vstack(sides)


def thinned(
    rim: np.ndarray, tried: np.ndarray, lengths: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """Select the candidates far enough from given points and from those selected before."""
    apart = 0.8 * lengths(tried)
    free = cKDTree(rim).query(tried)[0] > 0.75 * apart
    tried, apart = tried[free], apart[free]
    near = cKDTree(tried).query_ball_point(tried, apart)
    stays = np.zeros(len(tried), dtype=bool)
    for k, others in enumerate(near):
        stays[k] = not stays[[j for j in others if j < k]].any()
    return tried[stays]


def means_of_neighbours(mesh: SimplexMesh) -> np.ndarray:
    """Means (n, 2) of the vertices that share an edge with each."""
    start, end = np.concatenate([mesh.edges, mesh.edges[:, ::-1]]).T
    count = np.bincount(start, minlength=len(mesh.points))
    sums = [np.bincount(start, mesh.points[end, k], len(mesh.points)) for k in (0, 1)]
    return np.stack(sums, axis=1) / count[:, None]


def plot(result: Result) -> Figure:
    """Six frames: the mesh, the ink, and its exact boundary."""
    with figure(FULL_WIDTH, height=4.1, rows=2, columns=3) as (page, axes):
        for k, (panel, t) in enumerate(zip(axes.flat, result.arrays["times"], strict=True)):
            drawn(panel, *(result.arrays[f"{name}_{k}"] for name in ("points", "cells", "ink")))
            panel.plot(*result.arrays[f"rim_{k}"].T, color="#c48600", linewidth=0.9)
            panel.set(title=f"$t = {t:.1f}$", aspect="equal", xlim=(0, 1), ylim=(0, 1))
            panel.set_axis_off()
    return page


def drawn(panel: Axes, points: np.ndarray, cells: np.ndarray, ink: np.ndarray) -> None:
    """Draw the ink in four shades, and the mesh as one line with gaps."""
    x, y = points.T
    shades = [0.2, 0.4, 0.6, 0.8, 1.01]
    panel.tricontourf(Triangulation(x, y, cells), ink, shades, cmap=BLUES)
    around = np.concatenate(
        [points[cells[:, [0, 1, 2, 0]]], np.full((len(cells), 1, 2), np.nan)], 1
    )
    panel.plot(*around.reshape(-1, 2).T, color="#777777", linewidth=0.2)


def plot_history(result: Result) -> Figure:
    """Remaining energy and error of the velocities over time."""
    history, params = result.arrays["history"], result.params
    t = np.linspace(0, params.time, params.steps + 1)
    styles = ("RBF", "MLS", "PU", "LS")
    with figure(FULL_WIDTH, height=2.4, columns=2) as (page, axes):
        for way, row, style in zip(WAYS, history, styles, strict=True):
            axes[0].plot(t, row[:, 0] / ENERGY, **line(style, label=way.name))
            axes[1].plot(t, row[:, 1], **line(style, label=way.name))
        axes[0].axhline(1, color="black", linewidth=0.6)
        axes[0].set(xlabel="time", title="kinetic energy / exact", ylim=(0, 1.1))
        axes[1].set(xlabel="time", title="error of velocities", yscale="log")
        handles, labels = axes[0].get_legend_handles_labels()
        page.legend(handles, labels, loc="outside upper center", ncols=4)
    return page
