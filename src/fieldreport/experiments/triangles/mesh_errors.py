"""Errors of triangle meshes: planted, found, told apart, and repaired.

Each kind of error is planted into a mesh without any. The audit finds it, and nothing else; what a
soup of triangles, as in STL files, can tell of it is found again there. A body with many errors at
once is repaired. The signs that decide are compared with exact ones where rounding could change
them, and the pairs of triangles that the search for self-intersections looks at are counted.

References
----------
Botsch et al., Geometric Modeling Based on Polygonal Meshes (2007); Kettner, Mehlhorn, Pion,
Schirra and Yap, Classroom Examples of Robustness Problems in Geometric Computations (2008).
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from matplotlib.figure import Figure

from fieldrecon.plotting.mesh_pictures import CONCERN_OF, Marks, marks
from fieldrecon.triangles.audit import MeshAudit, audit_mesh, in_words
from fieldrecon.triangles.bounding_volumes import BoxTree, overlapping
from fieldrecon.triangles.intersections import close_pairs
from fieldrecon.triangles.predicates import orient2d
from fieldrecon.triangles.repair import MeshRepair, repair_mesh
from fieldreport.experiments.triangles.damaged_meshes import damaged
from fieldreport.experiments.triangles.mesh_errors_figures import (
    draw_gallery,
    plot_repair,
    plot_search,
    plot_signs,
)
from fieldreport.experiments.triangles.planted_errors import Planted, planted_errors
from fieldreport.experiments.triangles.triangle_shapes import Surface, bumpy, cube
from fieldreport.framework.experiment import Cell, Map, Result, Table, parameter, require_at_least

__all__ = ["QUICK", "Params", "plot", "plot_repair", "plot_search", "plot_signs", "run"]

LINE = np.array([[12.0, 12.0], [24.0, 24.0]])
"""Two points on the diagonal; beside it, near (½, ½), rounding decides about the side."""


@dataclass(frozen=True)
class Params:
    """How fine the meshes are, how much is damaged, how closely signs are looked at."""

    level: int = parameter(2, "times the triangles of an icosahedron are cut, for each error")
    body: int = parameter(4, "times they are cut for the body that is repaired")
    damage: int = parameter(8, "errors of each kind in it")
    side: int = parameter(200, "points along each side of the map of signs, 2⁻⁵³ apart")
    levels: tuple[int, ...] = parameter((2, 3, 4, 5, 6), "cuts of the bodies that are searched")
    seed: int = parameter(6, "seed of the damage")

    def __post_init__(self) -> None:
        require_at_least(self, level=1, body=2, damage=1, side=4, levels=1, seed=0)


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
            "search": Table(("triangles", "all pairs", "boxes", "planes"), tuple(counts)),
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
    """Return how many triangles, pairs of them, pairs of boxes, and pairs left there are."""
    points, triangles = bumpy(level)
    corners = points[triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    tree = BoxTree(low, high, low.min(axis=0))
    boxes = overlapping(tree, lambda i, j: np.column_stack([i, j]))
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
    """Return what is drawn of a mesh: points, triangles, and where its errors are."""
    key = name.replace(" ", "_")
    found = marks(audit, surface[1])
    arrays = [(f"{key}:points", surface[0]), (f"{key}:triangles", surface[1])]
    return arrays + [
        (f"{key}:{kind}:{field.name}", getattr(mark, field.name))
        for kind, mark in found.items()
        for field in fields(Marks)
    ]


def _told(found: dict[str, int]) -> str:
    """Spell what was found."""
    return ", ".join(in_words(kind, n) for kind, n in found.items()) or "nothing"


def _error_table(
    planted: dict[str, Planted],
    audits: dict[str, MeshAudit],
    soups: dict[str, MeshAudit],
    repairs: dict[str, MeshRepair],
) -> Table:
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
    return Table(("error", "concerns", "found", "in a soup", "done", "left"), rows)


def _repair_table(repaired: MeshRepair) -> Table:
    after = repaired.after.counts
    rows = tuple(
        (concern, kind.replace("_", " "), n, after[concern][kind])
        for concern, kinds in repaired.before.counts.items()
        for kind, n in kinds.items()
    )
    return Table(("concerns", "kind", "before", "after"), rows)


def _example_facts() -> dict[str, Cell]:
    """Return what two common files do to the count of edges: a soup, and one triangle twice."""
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


def plot(result: Result) -> Figure:
    """Each planted error, marked by the audit."""
    return draw_gallery(result)
