"""Circumcentric and barycentric dual meshes, with and without the Delaunay property.

The same points are triangulated twice: by Delaunay, and by Delaunay after they were stretched in
one direction, which gives a mesh that is not Delaunay. The experiment counts reversed and crossing
dual edges, and measures the angles between dual edges and face normals. It repeats this in space,
where dual edges do not cross and the dual cells overlap instead.

References
----------
Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 32, figure
3); Perot and Subramanian, Discrete calculus methods for diffusion, Journal of Computational
Physics 224 (2007).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from fieldrecon.meshes.duals import barycentric_dual, circumcentric_dual
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.plotting.style import FULL_WIDTH, METHOD_COLORS, figure
from fieldreport.experiments.meshes.reference_flows import jittered_cube
from fieldreport.framework.error_measures import order_of_magnitude
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter

ROUNDING = 1e-16
NO_LENGTH = 1e-9
"""Dual edges shorter than this, in sides of the domain, have no direction."""

DUALS = {"circumcentric": circumcentric_dual, "barycentric": barycentric_dual}
CASES = {
    "delaunay": ("Delaunay", "circumcentric"),
    "other": ("not Delaunay", "circumcentric"),
    "barycentric": ("Delaunay", "barycentric"),
}
"""A mesh and a dual of it: the three panels of the slides' figure."""


@dataclass(frozen=True)
class Params(Parameters):
    """The points and their stretching."""

    side: int = parameter(5, "steps of the grid along the unit square", least=3)
    side_3d: int = parameter(6, "steps of the grid along the unit cube", least=3)
    jitter: float = parameter(
        0.6, "range of the random displacement of a vertex, in steps", least=0, below=1
    )
    stretch: float = parameter(
        2.0, "factor by which the first coordinate is stretched", least=1, most=100
    )
    seed: int = parameter(1, "seed of the displacements", least=0)


QUICK = Params(side=4, side_3d=3)


def run(params: Params, each: Map = map) -> Result:
    """Make the duals in the plane and in space, and measure them."""
    meshes = {
        (d, name): mesh
        for d, side in ((2, params.side), (3, params.side_3d))
        for name, mesh in _both_meshes(params, d, side).items()
    }
    jobs = [(d, case, meshes[d, CASES[case][0]]) for d in (2, 3) for case in CASES]
    measured = list(each(measure, [(mesh, CASES[case][1]) for _, case, mesh in jobs]))
    rows = (
        (d, *CASES[case], *(_told(x) for x in found.values()))
        for (d, case, _), found in zip(jobs, measured, strict=True)
    )
    by_case = {f"{case}_{d}d": found for (d, case, _), found in zip(jobs, measured, strict=True)}
    return Result(
        params=params,
        tables={"duals": ResultTable(("dimension", "mesh", "dual", *measured[0]), tuple(rows))},
        facts=_facts(by_case),
        arrays=_drawn({case: mesh for d, case, mesh in jobs if d == 2}),
    )


def _both_meshes(params: Params, d: int, side: int) -> dict[str, SimplexMesh]:
    delaunay = jittered_cube(side, d, params.jitter, params.seed)
    return {"Delaunay": delaunay, "not Delaunay": stretched(delaunay, params.stretch)}


def stretched(mesh: SimplexMesh, factor: float) -> SimplexMesh:
    """Return the mesh of the same points whose cells are Delaunay once x₁ is stretched."""
    scale = np.r_[factor, np.ones(mesh.points.shape[1] - 1)]
    return SimplexMesh(mesh.points, SimplexMesh.delaunay(mesh.points * scale).cells)


def measure(job: tuple[SimplexMesh, str]) -> dict[str, Cell]:
    """Count and measure one dual of one mesh; the names are the columns of the table."""
    mesh, kind = job
    off = off_perpendicular(mesh, kind)
    lengths = dual_lengths(mesh)
    inner = mesh.face_cells[:, 1] >= 0
    circumcentric, plane = kind == "circumcentric", mesh.points.shape[1] == 2
    return {
        "inner faces": int(inner.sum()),
        "off, mean": float(off.mean()),
        "off, most": float(off.max()),
        "backwards": int((lengths[inner] < -NO_LENGTH).sum()) if circumcentric else 0,
        "inside a sphere": int(inside_a_sphere(mesh).sum()) if circumcentric else 0,
        "crossings": len(crossings(DUALS[kind](mesh)[0])) if plane else "–",
        "overlap, %": 100 * overlap(mesh, lengths) if circumcentric else 0.0,
    }


def off_perpendicular(mesh: SimplexMesh, kind: str) -> np.ndarray:
    """Return the angles, in degrees, between dual edges at inner faces and the faces' normals."""
    segments, faces = DUALS[kind](mesh)
    edges = segments[:, 1] - segments[:, 0]
    size = np.linalg.norm(edges, axis=1)
    told = (mesh.face_cells[faces, 1] >= 0) & (size > NO_LENGTH)
    edges, normals = edges[told], mesh.face_normals[faces[told]]
    along = np.einsum("sd,sd->s", edges, normals)[:, None] * normals
    sine = np.linalg.norm(edges - along, axis=1) / size[told]
    return np.degrees(np.arcsin(np.minimum(sine, 1.0)))


def dual_lengths(mesh: SimplexMesh) -> np.ndarray:
    """Return the lengths of circumcentric dual edges, negative where they run backwards."""
    segments, faces = circumcentric_dual(mesh)
    return np.einsum("fd,fd->f", segments[:, 1] - segments[:, 0], mesh.face_normals[faces])


def overlap(mesh: SimplexMesh, lengths: np.ndarray) -> float:
    """Return the relative excess of the measure of the diamonds over that of the mesh.

    The signed ones measure Σ A_f l*_f / d, the volume of the mesh, since each cell is the sum of
    the pyramids from its circumcentre to its faces. Those of negative length lie on others.
    """
    diamonds = mesh.face_measures * lengths / mesh.points.shape[1]
    volume = mesh.cell_measures.sum()
    if not np.isclose(diamonds.sum(), volume):
        raise ArithmeticError(f"the diamonds measure {diamonds.sum()}, the mesh {volume}")
    return max(float(np.abs(diamonds).sum() / volume - 1), 0.0)


def inside_a_sphere(mesh: SimplexMesh) -> np.ndarray:
    """Return for each inner face whether one apex lies in the sphere of the cell across.

    From the sign of the simplex of all d + 2 vertices lifted to the paraboloid: no circumcentre.
    """
    inner = np.flatnonzero(mesh.face_cells[:, 1] >= 0)
    cells = mesh.cells[mesh.face_cells[inner]]  # (f, 2, d + 1)
    across = ~(cells[:, 1][:, :, None] == cells[:, 0][:, None]).any(axis=2)
    apex = cells[:, 1][across]
    edges = mesh.points[cells[:, 0]] - mesh.points[apex][:, None]
    lifted = np.concatenate([edges, (edges**2).sum(axis=2, keepdims=True)], axis=2)
    d = edges.shape[2]
    return (-1) ** d * np.linalg.det(lifted) > NO_LENGTH / len(mesh.points) ** 2


def crossings(segments: np.ndarray) -> np.ndarray:
    """Return the points (k, 2) where two segments in the plane cross inside both."""
    a, b = segments[:, 0], segments[:, 1]
    start, edge = a[None] - a[:, None], b - a
    turn = _cross(edge[:, None], edge[None])
    with np.errstate(divide="ignore", invalid="ignore"):
        on_first = _cross(start, edge[None]) / turn
        on_second = _cross(start, edge[:, None]) / turn
    crossed = (np.minimum(on_first, on_second) > NO_LENGTH) & (
        np.maximum(on_first, on_second) < 1 - NO_LENGTH
    )
    i, j = np.nonzero(np.triu(crossed, 1))
    return a[i] + on_first[i, j][:, None] * edge[i]


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def _told(x: Cell) -> Cell:
    return order_of_magnitude(x) if isinstance(x, float) and 0 < x < 1e-9 else x


def _facts(found: dict[str, dict[str, Cell]]) -> dict[str, Cell]:
    facts = {
        f"{what}_{case}": found[case][column]
        for case in ("other_2d", "other_3d")
        for what, column in (("inner", "inner faces"), ("backwards", "backwards"))
    }
    facts |= {
        f"{what}_{case}": found[case][f"off, {what}"]
        for case in ("barycentric_2d", "barycentric_3d")
        for what in ("mean", "most")
    }
    circumcentric = [f for case, f in found.items() if not case.startswith("barycentric")]
    return facts | {
        "crossings": found["other_2d"]["crossings"],
        "overlap": found["other_2d"]["overlap, %"],
        "overlap_3d": found["other_3d"]["overlap, %"],
        "off_circumcentric": order_of_magnitude(
            max(*(float(f["off, most"]) for f in circumcentric), ROUNDING)
        ),
    }


def _drawn(meshes: Mapping[str, SimplexMesh]) -> dict[str, np.ndarray]:
    arrays = {}
    for case, mesh in meshes.items():
        dual = DUALS[CASES[case][1]](mesh)[0]
        arrays[f"{case}_edges"] = mesh.points[mesh.edges]
        arrays[f"{case}_dual"] = dual
        arrays[f"{case}_crossings"] = crossings(dual)
    return arrays


def plot(result: Result) -> Figure:
    """The three duals in the plane side by side, the mesh thin, the dual strong."""
    titles = ("Delaunay, circumcentric", "not Delaunay, circumcentric", "Delaunay, barycentric")
    with figure(FULL_WIDTH, height=2.15, columns=3) as (page, axes):
        for panel, case, title in zip(axes, CASES, titles, strict=True):
            _draw(panel, *(result.arrays[f"{case}_{k}"] for k in ("edges", "dual", "crossings")))
            panel.set_title(title, loc="center")
    return page


def _draw(panel: Axes, edges: np.ndarray, dual: np.ndarray, crossed: np.ndarray) -> None:
    strong = METHOD_COLORS["RBF"]
    panel.add_collection(LineCollection(list(edges), colors="#9a9a9a", linewidths=0.5))
    panel.add_collection(LineCollection(list(dual), colors=strong, linewidths=1.3))
    x, y = crossed.T
    panel.plot(x, y, "o", color="black", markersize=5.5, fillstyle="none", markeredgewidth=0.8)
    panel.set_aspect("equal")
    panel.axis("off")
    panel.autoscale_view()
