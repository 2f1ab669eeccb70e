"""Errors of triangle meshes: detection, classification and repair.

Each kind of error is planted into a valid mesh. The audit finds this error and no other, and the
experiment shows which errors can still be found in a triangle soup, as in STL files. A mesh with
many errors at once is repaired. Orientation signs are compared with exact ones where rounding could
change them, and the pairs of triangles that the search for self-intersections examines are counted.

References
----------
Botsch et al., Geometric Modeling Based on Polygonal Meshes (2007); Kettner, Mehlhorn, Pion,
Schirra and Yap, Classroom Examples of Robustness Problems in Geometric Computations (2008).
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fieldrecon.plotting.mesh_pictures import COLORS, CONCERN_OF, MARKERS, Marks, draw, marks
from fieldrecon.plotting.style import figure, shades
from fieldrecon.triangles.audit import MeshAudit, audit_mesh, in_words
from fieldrecon.triangles.bounding_volumes import BVH, intersecting_pairs
from fieldrecon.triangles.intersections import close_pairs
from fieldrecon.triangles.predicates import orient2d
from fieldrecon.triangles.repair import MeshRepair, repair_mesh
from fieldreport.experiments.triangles.planted_errors import (
    TOWARD,
    Planted,
    damaged,
    planted_errors,
)
from fieldreport.experiments.triangles.triangle_shapes import Surface, bumpy, cube
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter

LINE = np.array([[12.0, 12.0], [24.0, 24.0]])
"""Two points on the diagonal; near (½, ½), rounding affects the computed side."""


@dataclass(frozen=True)
class Params(Parameters):
    """The refinement of the meshes, the number of errors, and the resolution of the sign map."""

    level: int = parameter(2, "subdivisions of an icosahedron, for the single errors", least=1)
    body: int = parameter(4, "subdivisions for the mesh that is repaired", least=2)
    damage: int = parameter(8, "errors of each kind in the mesh that is repaired", least=1)
    side: int = parameter(200, "points along each side of the map of signs, 2⁻⁵³ apart", least=4)
    levels: tuple[int, ...] = parameter(
        (2, 3, 4, 5, 6),
        "subdivisions of the meshes that are searched for self-intersections",
        least=1,
        fewest=2,
        order="increasing",
    )
    seed: int = parameter(6, "seed of the damage", least=0)


QUICK = Params(level=1, body=2, damage=1, side=16, levels=(1, 2))


def run(params: Params, each: Map = map) -> Result:
    """Plant and find each error, repair a body, compare signs, and count pairs."""
    planted = planted_errors(params.level)
    audits = dict(zip(planted, each(_audit, (p.surface for p in planted.values())), strict=True))
    soups = dict(
        zip(planted, each(_audit_soup, (p.surface for p in planted.values())), strict=True)
    )
    repairs = dict(zip(planted, each(_repair, (p.surface for p in planted.values())), strict=True))
    body = damaged(params.body, params.damage, params.seed)
    repaired = _repair(body)
    counts = list(each(pair_counts, params.levels))
    rounded, exact, true = sign_maps(params.side)
    return Result(
        params=params,
        tables={
            "errors": _error_table(planted, audits, soups, repairs),
            "repair": _repair_table(repaired),
            "search": ResultTable(("triangles", "all pairs", "boxes", "planes"), tuple(counts)),
        },
        facts=_example_facts()
        | _planted_facts(planted, audits)
        | {"body_triangles": len(body[1]), "left_after_repair": sum(repaired.after.found.values())}
        | {f"done_{what}": n for what, n in repaired.done.items()}
        | _sign_facts(rounded, exact, true)
        | _search_facts(counts),
        arrays={"names": np.array([*planted]), "rounded": rounded, "exact": exact}
        | {k: a for name, p in planted.items() for k, a in _drawn(name, p.surface, audits[name])}
        | dict(_drawn("before", body, repaired.before))
        | dict(_drawn("after", (repaired.points, repaired.triangles), repaired.after)),
    )


def pair_counts(level: int) -> tuple[int, int, int, int]:
    """Return the numbers of triangles, pairs, pairs of boxes, and remaining pairs."""
    points, triangles = bumpy(level)
    corners = points[triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    tree = BVH(low, high, low.min(axis=0))
    boxes = intersecting_pairs(tree, lambda i, j: np.column_stack([i, j]))
    m = len(triangles)
    return m, m * (m - 1) // 2, len(boxes), len(close_pairs(points, triangles))


def sign_maps(side: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return on which side of the diagonal points near (½, ½) are: rounded, exact, true.

    The points are multiples of 2⁻⁵³, so that the truth is the sign of y - x.
    """
    steps = 0.5 + np.arange(side) * 2.0**-53
    x, y = (axis.ravel() for axis in np.meshgrid(steps, steps))
    points = np.column_stack([x, y])
    a, b = (np.broadcast_to(end, points.shape) for end in LINE)
    u, v = b - a, points - a
    rounded = np.sign(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    exact = orient2d(a, b, points)
    signs = np.stack([rounded, exact, np.sign(y - x)]).astype(np.int8)
    first, second, third = signs.reshape(3, side, side)
    return first, second, third


def _audit(surface: Surface) -> MeshAudit:
    return audit_mesh(*surface)


def _audit_soup(surface: Surface) -> MeshAudit:
    points, triangles = surface
    return audit_mesh(points[triangles].reshape(-1, 3), np.arange(triangles.size).reshape(-1, 3))


def _repair(surface: Surface) -> MeshRepair:
    return repair_mesh(*surface)


def _drawn(name: str, surface: Surface, audit: MeshAudit) -> list[tuple[str, np.ndarray]]:
    """Return the arrays of a figure: points, triangles, and positions of errors."""
    key = name.replace(" ", "_")
    found = marks(audit, surface[1])
    arrays = [(f"{key}:points", surface[0]), (f"{key}:triangles", surface[1])]
    return arrays + [
        (f"{key}:{kind}:{field.name}", getattr(mark, field.name))
        for kind, mark in found.items()
        for field in fields(Marks)
    ]


def _told(found: dict[str, int]) -> str:
    """Return the findings as a text."""
    return ", ".join(in_words(kind, n) for kind, n in found.items()) or "nothing"


def _error_table(
    planted: dict[str, Planted],
    audits: dict[str, MeshAudit],
    soups: dict[str, MeshAudit],
    repairs: dict[str, MeshRepair],
) -> ResultTable:
    rows = tuple(
        (
            name,
            ", ".join(dict.fromkeys(CONCERN_OF[kind] for kind in p.found)),
            _told(audits[name].found),
            _told(soups[name].found),
            _told(repairs[name].done),
            _told(repairs[name].after.found),
        )
        for name, p in planted.items()
    )
    return ResultTable(("error", "concerns", "found", "in a soup", "done", "left"), rows)


def _repair_table(repaired: MeshRepair) -> ResultTable:
    after = repaired.after.counts
    rows = tuple(
        (concern, kind.replace("_", " "), n, after[concern][kind])
        for concern, kinds in repaired.before.counts.items()
        for kind, n in kinds.items()
    )
    return ResultTable(("concerns", "kind", "before", "after"), rows)


def _example_facts() -> dict[str, Cell]:
    """Return the edge counts of two common cases: a triangle soup, and a duplicate triangle."""
    points, triangles = cube(1)
    soup = points[triangles].reshape(-1, 3)
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    again = np.concatenate([sides, sides[:3]])
    _, count = np.unique(again, axis=0, return_counts=True)
    return {
        "cube_triangles": len(triangles),
        "cube_soup_vertices": len(soup),
        "cube_soup_redundant": len(soup) - len(np.unique(soup, axis=0)),
        "cube_soup_free_sides": len(sides),
        "cube_copy_crowded_edges": int((count > 2).sum()),
    }


def _planted_facts(planted: dict[str, Planted], audits: dict[str, MeshAudit]) -> dict[str, Cell]:
    return {
        "planted": len(planted),
        "found_as_planted": sum(audits[name].found == p.found for name, p in planted.items()),
        "overlapping_pairs": planted["overlap"].found["overlaps"],
    }


def _sign_facts(rounded: np.ndarray, exact: np.ndarray, true: np.ndarray) -> dict[str, Cell]:
    return {
        "signs": true.size,
        "signs_rounded_wrong": int((rounded != true).sum()),
        "signs_rounded_wrong_percent": 100 * float(np.mean(rounded != true)),
        "signs_exact_wrong": int((exact != true).sum()),
    }


def _search_facts(counts: list[tuple[int, int, int, int]]) -> dict[str, Cell]:
    (few, _, some, _), (m, pairs, boxes, left) = counts[0], counts[-1]
    return {
        "search_triangles": m,
        "search_pairs": pairs,
        "search_boxes": boxes,
        "search_left": left,
        "search_boxes_per_triangle": boxes / m,
        "search_order": float(np.log(boxes / some) / np.log(m / few)),
    }


FROM_THE_SIDE = np.array([0.9, -0.05, 0.65])
"""The view direction, from which protruding errors are visible."""
WHOLE = ("one side", "inside out", "overlap")
"""Errors that are visible only in the picture of the whole mesh."""
_THREE = ListedColormap(["#56b4e9", "#f0e442", "#d55e00"])  # each also on a dark page


def plot(result: Result) -> Figure:
    """Each planted error, marked by the audit, and a key to the colours."""
    names = result.arrays["names"].tolist()
    columns = 4
    rows = -(-(len(names) + 1) // columns)
    with figure(height=1.62 * rows, rows=rows, columns=columns) as (page, axes):
        panels = axes.ravel()
        for panel, name in zip(panels, names, strict=False):
            panel.set_title(name, loc="center", fontsize=8)
            panel.set_anchor("N")  # titles of one row at one height
            toward = TOWARD if name in WHOLE else FROM_THE_SIDE
            _draw(panel, result, name, toward, near=name not in WHOLE)
        _key(panels[len(names)])
        for panel in panels[len(names) + 1 :]:
            panel.remove()
    return page


def plot_repair(result: Result) -> Figure:
    """A mesh with many errors, before and after its repair."""
    with figure(height=2.75, columns=2) as (page, axes):
        for panel, name in zip(axes, ("before", "after"), strict=True):
            panel.set_title(name, loc="center")
            _draw(panel, result, name, np.array([0.8, -0.7, 0.6]), near=False, pixels=700)
    return page


def plot_signs(result: Result) -> Figure:
    """The side of the diagonal on which points are, in rounded arithmetic and exactly."""
    with figure(height=2.6, columns=2, sharey=True) as (page, axes):
        for panel, name in zip(axes, ("rounded", "exact"), strict=True):
            signs = result.arrays[name]
            panel.imshow(signs, cmap=_THREE, vmin=-1, vmax=1)
            panel.plot([-0.5, len(signs) - 0.5], [-0.5, len(signs) - 0.5], "k", linewidth=0.6)
            panel.set_title(f"{name} sign", loc="center")
            panel.set(xlabel="(x − ½) · 2⁵³", aspect="equal")
            panel.grid(visible=False)
        axes[0].set_ylabel("(y − ½) · 2⁵³")
        swatches = [
            Line2D([], [], marker="s", linestyle="", color=_THREE(k), markersize=6, label=label)
            for k, label in enumerate(("right", "on the line", "left"))
        ]
        page.legend(handles=swatches, loc="outside lower center", ncols=3)
    return page


def plot_search(result: Result) -> Figure:
    """The number of triangle pairs that each stage of the search examines."""
    table = result.tables["search"]
    m = np.array(table.column("triangles"), dtype=float)
    labels = {
        "all pairs": "all pairs",
        "boxes": "pairs whose boxes overlap",
    }
    with figure(height=2.4) as (page, panel):
        for (column, label), look in zip(labels.items(), shades("truth", 2), strict=True):
            panel.loglog(m, np.array(table.column(column), dtype=float), **look, label=label)
        panel.set(xlabel="triangles", ylabel="pairs")
        panel.legend()
    return page


def _draw(
    panel: Axes, result: Result, name: str, toward: np.ndarray, *, near: bool, pixels: int = 330
) -> None:
    key, found = name.replace(" ", "_"), _marks(result, name)
    points, triangles = (result.arrays[f"{key}:{what}"] for what in ("points", "triangles"))
    draw(panel, points, triangles, found, toward, pixels, near=near)


def _marks(result: Result, name: str) -> dict[str, Marks]:
    key = name.replace(" ", "_")
    kinds = {k.split(":")[1] for k in result.arrays if k.startswith(f"{key}:") and k.count(":") > 1}
    return {
        kind: Marks(
            *(result.arrays[f"{key}:{kind}:{what}"] for what in ("triangles", "edges", "vertices"))
        )
        for kind in sorted(kinds)
    }


def _key(panel: Axes) -> None:
    """Draw the key to the colours."""
    handles = [
        Line2D([], [], color=color, marker=MARKERS[concern], markersize=4, label=concern)
        for concern, color in COLORS.items()
    ]
    panel.legend(handles=handles, loc="center", fontsize=7.5, handlelength=2, borderaxespad=0)
    panel.set_axis_off()
