"""Voronoi coordinates on a spiral inside a hexagon and inside other vertex stars.

The exercise of the slides: a regular hexagon, values at the circumcentres of its six triangles, and
a spiral from near an edge of the dual cell to its centre. Further cases are rotated and translated
hexagons, one with the first point of the spiral on an edge, random stars, and stars in space. In
all of them the quotient form of the slides is compared with the product form.

References
----------
Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 45); Meyer,
Barr, Lee and Desbrun, Generalized Barycentric Coordinates on Irregular Polygons, Journal of
Graphics Tools 7 (2002), for the same weights from areas.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from fieldrecon.barycentric.voronoi import VoronoiCell
from fieldrecon.datasets.synthetic import uniform
from fieldrecon.meshes.duals import circumcentric_dual
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.plotting.style import FULL_WIDTH, SEQUENTIAL, figure, line, shades
from fieldreport.framework.error_measures import order_of_magnitude
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter

GOLDEN = (1 + 5**0.5) / 2

ROUNDING = 1e-16
FORMS = ("quotient", "quotient, one height", "product")


@dataclass(frozen=True)
class Params(Parameters):
    """The spiral, the stars, and the distances from an edge of a cell."""

    steps: int = parameter(
        50,
        "points N of the spiral",
        least=7,
        because="the first of fewer can lie on an edge of the cell",
    )
    turn: float = parameter(
        20.0, "angle by which a hexagon is rotated, in degrees", least=-360, most=360
    )
    center: tuple[float, ...] = parameter(
        (-1.5, 0.5), "centre of the translated hexagon", least=-1e6, most=1e6, entries=2
    )
    scattered: int = parameter(
        60, "random points, in the unit square and in the unit cube", least=40
    )
    nearest: int = parameter(
        16, "smallest distance from an edge, as a negative power of ten", least=2, most=16
    )
    places: int = parameter(200, "points along the edge at each distance", least=2)
    seed: int = parameter(0, "seed of the random points", least=0)


QUICK = Params(steps=12, nearest=6, places=9)


def run(params: Params, each: Map = map) -> Result:
    """Reconstruct three fields in every star, and approach an edge of one."""
    stars = stars_of(params)
    found = dict(zip(stars, each(partial(measure, params.steps), stars.values()), strict=True))
    distances = 10.0 ** -np.arange(1, params.nearest + 1)
    near = np.array([errors_near_an_edge(params, distance) for distance in distances])
    return Result(
        params=params,
        tables={
            "stars": _stars_table(stars, found),
            "spiral": _spiral_table(params.steps),
            "edge": ResultTable(
                ("distance", *FORMS),
                tuple((d, *map(_told, row)) for d, row in zip(distances, near, strict=True)),
            ),
        },
        facts=_facts(params, found) | _facts_near(distances, near),
        arrays={"distances": distances, "near": near} | _drawn(params),
    )


def stars_of(params: Params) -> dict[str, Star]:
    """Return the stars by name; in one of them the spiral begins on an edge of the dual cell."""
    on_edge, (x, y) = 360 / params.steps, params.center
    return {
        "regular hexagon": hexagon(),
        f"rotated by {params.turn:g}°": hexagon(params.turn),
        f"shifted to ({x:g}, {y:g})".replace("-", "−"): hexagon(0.0, params.center),
        f"shifted, and rotated by {on_edge:g}°": hexagon(on_edge, params.center),
        "at random in the plane": at_random(params.scattered, 2, params.seed),
        "icosahedron": icosahedron(),
        "at random in space": at_random(params.scattered, 3, params.seed),
    }


def measure(steps: int, star: Star) -> dict[str, float]:
    """Return the smallest weight on the spiral, and the largest errors of three kinds of data."""
    cell, s = VoronoiCell(*star), spiral(star, steps)
    w = cell.weights(s)
    squares = ((cell.points - star.center) ** 2).sum(axis=1)
    return {
        "smallest": w.min(),
        "constant": np.abs(w.sum(axis=1) - 1).max(),
        "linear": linear_error(w, cell.points, s).max(),
        "quotient": linear_error(quotients(star, s), star.corners, s).max(),
        "quadratic": np.abs(w @ squares - ((s - star.center) ** 2).sum(axis=1)).max(),
    }


def linear_error(w: np.ndarray, corners: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the relative error of linear data at each query; 1 if there is no value."""
    with np.errstate(invalid="ignore"):  # weights that are not finite
        values = w @ corners.sum(axis=1)
    error = np.abs(values - x.sum(axis=1)) / np.abs(corners.sum(axis=1)).max()
    return np.where(np.isfinite(error), error, 1.0)


def errors_near_an_edge(params: Params, distance: float) -> list[float]:
    """Return the largest error of linear data, by the three forms, at a distance from an edge."""
    star = hexagon(params.turn)
    cell, spoke = VoronoiCell(*star), star.spokes[0]
    a, b = cell.points[np.argsort(cell.points @ spoke)[-2:]]  # the ends of the edge
    x = a + np.linspace(0.05, 0.95, params.places)[:, None] * (b - a) - distance * spoke
    return [
        linear_error(quotients(star, x), star.corners, x).max(),
        linear_error(quotients(star, x, one_height=True), star.corners, x).max(),
        linear_error(cell.weights(x), cell.points, x).max(),
    ]


def _stars_table(stars: dict[str, Star], found: dict[str, dict[str, float]]) -> ResultTable:
    columns = (
        "star",
        "dimension",
        "corners",
        "faces",
        "smallest weight",
        "constant",
        "linear",
        "linear, quotient",
        "quadratic",
    )
    rows = (_star_row(name, star, found[name]) for name, star in stars.items())
    return ResultTable(columns, tuple(rows))


def _star_row(name: str, star: Star, m: dict[str, float]) -> tuple[Cell, ...]:
    smallest = m["smallest"] if m["smallest"] > 100 * ROUNDING else 0.0
    errors = (_told(m[data]) for data in ("constant", "linear", "quotient"))
    size = len(star.center), len(star.corners), len(star.spokes)
    return name, *size, smallest, *errors, m["quadratic"]


def _spiral_table(steps: int) -> ResultTable:
    """The exercise: each point, its smallest weight, and values beside the exact ones."""
    star = hexagon()
    cell, s = VoronoiCell(*star), spiral(star, steps)
    smallest = cell.weights(s).min(axis=1)
    linear, quadratic = cell.points.sum(axis=1), (cell.points**2).sum(axis=1)
    values = (cell.field(linear)(s), s.sum(axis=1), cell.field(quadratic)(s), (s**2).sum(axis=1))
    numbers = np.round(np.column_stack([s, smallest, *values]), 13) + 0.0
    columns = ("n", "x", "y", "smallest weight", "linear", "x + y", "quadratic", "x² + y²")
    return ResultTable(columns, tuple((n + 1, *row) for n, row in enumerate(numbers.tolist())))


def _told(error: float) -> float:
    return order_of_magnitude(max(error, ROUNDING))


def _facts(params: Params, found: dict[str, dict[str, float]]) -> dict[str, Cell]:
    star = hexagon()
    cell, s = VoronoiCell(*star), spiral(star, params.steps)
    around = np.argsort(np.arctan2(*cell.points.T))
    areas = from_areas(cell.points[around], s)
    first = _spiral_table(params.steps).rows[0]
    return {
        "turn_on_edge": 360 / params.steps,
        "margin": 0.5 - float(s[0, 0]),
        "smallest_weight": first[3],
        "first_value": first[4],
        "quadratic": first[6],
        "quadratic_first": first[7],
        "constant_error": _told(max(m["constant"] for m in found.values())),
        "linear_error": _told(max(m["linear"] for m in found.values())),
        "from_areas": _told(np.abs(cell.weights(s)[:, around] - areas).max()),
    }


def _facts_near(distances: np.ndarray, near: np.ndarray) -> dict[str, Cell]:
    half = len(distances) // 2 - 1
    return {
        "half_way": float(distances[half]),
        "quotient_half_way": _told(near[half, 0]),
        "product_near": _told(near[:, 2].max()),
    }


def _drawn(params: Params) -> dict[str, np.ndarray]:
    stars = {
        "asked": hexagon(),
        "moved": hexagon(360 / params.steps, params.center),
        "space": icosahedron(),
    }
    arrays: dict[str, np.ndarray] = {}
    for name, star in stars.items():
        cell, s = VoronoiCell(*star), spiral(star, params.steps)
        values = cell.field(cell.points.sum(axis=1))
        arrays |= {
            f"{name}_edges": star.mesh.points[star.mesh.edges],
            f"{name}_dual": star.dual_edges,
            f"{name}_corners": cell.points,
            f"{name}_spiral": s,
            f"{name}_values": values(s) - values(star.center),
            f"{name}_product": linear_error(cell.weights(s), cell.points, s),
            f"{name}_quotient": linear_error(quotients(star, s), star.corners, s),
        }
    return arrays


VIEW = Rotation.from_euler("zyx", [200, 0, -70], degrees=True).as_matrix()
"""Rows: directions to the right, upward, and toward the viewer."""

BESIDE = 10
"""Distance up to which the spiral that was not moved is drawn beside the moved hexagon."""

FLOOR = 3e-17
"""The value at which zero errors are drawn."""


class Star(NamedTuple):
    """The cells of a mesh around one of its vertices."""

    mesh: SimplexMesh
    vertex: int

    @property
    def center(self) -> np.ndarray:
        """The vertex x_i (d,)."""
        return self.mesh.points[self.vertex]

    @property
    def cells(self) -> np.ndarray:
        """Indices of the cells at x_i."""
        return self.mesh.vertex_cells(self.vertex)

    @property
    def spokes(self) -> np.ndarray:
        """Differences x_b − x_i (f, d), one for each face of the Voronoi cell."""
        around = self.mesh.cells[self.cells]
        return self.mesh.points[np.unique(around[around != self.vertex])] - self.center

    @property
    def corners(self) -> np.ndarray:
        """Circumcentres (c, d) of the cells."""
        return self.mesh.circumcenters[self.cells]

    @property
    def dual_edges(self) -> np.ndarray:
        """Edges (e, 2, d) of the Voronoi cell."""
        at = (self.mesh.faces == self.vertex).any(axis=1)
        return circumcentric_dual(self.mesh)[0][at]


def hexagon(turn: float = 0.0, center: tuple[float, ...] = (0.0, 0.0)) -> Star:
    """Return a regular hexagon of radius 1, rotated by an angle in degrees, with its centre.

    Examples
    --------
    >>> len(hexagon().cells), len(icosahedron().cells)
    (6, 20)
    """
    angle = np.deg2rad(turn) + np.arange(6) * np.pi / 3
    rim = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return Star(SimplexMesh.delaunay(np.vstack([np.zeros((1, 2)), rim]) + center), 0)


def icosahedron() -> Star:
    """Return an icosahedron of radius 1 with its centre; its Voronoi cell is a dodecahedron."""
    corners = np.array([[0, s, t * GOLDEN] for s in (-1, 1) for t in (-1, 1)])
    rim = np.vstack([np.roll(corners, k, axis=1) for k in range(3)]) / np.sqrt(1 + GOLDEN**2)
    return Star(SimplexMesh.delaunay(np.vstack([np.zeros((1, 3)), rim])), 0)


def at_random(n: int, d: int, seed: int) -> Star:
    """Return the star of the vertex nearest to the centre, for random points in the unit cube."""
    points = uniform(n, d, np.random.default_rng((seed, d)))
    return Star(SimplexMesh.delaunay(points), int(((points - 0.5) ** 2).sum(axis=1).argmin()))


def spiral(star: Star, steps: int) -> np.ndarray:
    """Return the points x_i + (r/n) e_n, n = 1 ... N, r the distance from x_i to the nearest face.

    In the plane e_n has the angle 2πn/N. In space it also makes one revolution about the axis while
    it moves from one pole to the other.
    """
    r = np.sqrt((star.spokes**2).sum(axis=1).min()) / 2
    n = np.arange(1, steps + 1)
    e = np.stack([np.cos(2 * np.pi * n / steps), np.sin(2 * np.pi * n / steps)], axis=1)
    if len(star.center) == 3:
        height = 1 - (2 * n - 1) / steps
        e = np.column_stack([np.sqrt(1 - height**2)[:, None] * e, height])
    return star.center + (r / n)[:, None] * e


def quotients(star: Star, x: np.ndarray, one_height: bool = False) -> np.ndarray:
    """Return V_a / Π_b h_ab of the slides over their sum, at queries (m, d), for the cells a.

    h_ab = (x_b − x_i)ᵀ(p_a − x) is computed at each corner a; with `one_height`, from the same
    ½ l_b² − (x_b − x_i)ᵀ(x − x_i) at all corners of face b. Where a height is zero there is no
    value, NaN.
    """
    around = star.mesh.cells[star.cells]
    others = around[around != star.vertex].reshape(len(around), -1)
    spokes = star.mesh.points[others] - star.center
    if one_height:
        half = (spokes**2).sum(axis=2) / 2
        heights = half - np.einsum("abk,mk->mab", spokes, x - star.center)
    else:
        heights = np.einsum("abk,mak->mab", spokes, star.corners - x[:, None])
    with np.errstate(divide="ignore", invalid="ignore"):
        w = star.mesh.cell_measures[star.cells] / heights.prod(axis=2)
        return w / w.sum(axis=1, keepdims=True)


def from_areas(corners: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the weights of the corners of a convex polygon from areas of triangles alone.

    w_a = area(p_a−1, p_a, p_a+1) / (area(x, p_a−1, p_a) area(x, p_a, p_a+1)): no mesh, no normals.
    """
    before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
    here = x[:, None]
    w = _area(before, corners, after) / (_area(here, before, corners) * _area(here, corners, after))
    return w / w.sum(axis=1, keepdims=True)


def _area(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    u, v = b - a, c - a
    return (u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]) / 2


def plot(result: Result) -> Figure:
    """The stars, their Voronoi cells, and the spirals coloured by value."""
    arrays = result.arrays
    with figure(FULL_WIDTH, height=5.0, rows=2, columns=2) as (page, axes):
        asked, middle, moved, space = axes.flat
        points = _draw_star(asked, "regular hexagon", arrays, "asked")
        _draw_star(middle, "centre of the regular hexagon", arrays, "asked")
        s = arrays["asked_spiral"]
        reach = 1.15 * np.abs(s[3]).max()
        low, high = reach * np.array([[-0.45, -0.55], [1.0, 0.9]])
        if ((s[3:] < low) | (s[3:] > high)).any():  # the fourth of few points lies elsewhere
            low, high = reach * np.array([[-1.0, -1.0], [1.0, 1.0]])
        middle.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        for n in range(4, len(s) + 1):
            if n in (4, 6, 10, 20, len(s)):
                outward = 9 * s[n - 1] / np.linalg.norm(s[n - 1])
                look = {"textcoords": "offset points", "ha": "center", "va": "center"}
                middle.annotate(f"{n}", s[n - 1], outward, **look)
        _draw_star(moved, "rotated and shifted", arrays, "moved")
        if np.abs(result.params.center).max() < BESIDE:
            moved.plot(*s.T, ".", color="#8a8a8a", markersize=3)
            above = result.params.center[1] > 1  # the hexagon, so the label goes there
            away = {"va": "bottom"} if above else {"va": "top"}
            shift = (6, 8 if above else -8)
            moved.annotate("without\n$x_i$", s[-1], shift, textcoords="offset points", **away)
        _draw_star(space, "icosahedron", arrays, "space")
        page.colorbar(points, ax=list(axes.flat), shrink=0.6, label="value above that at $x_i$")
    return page


def _draw_star(
    panel: Axes, title: str, arrays: Mapping[str, np.ndarray], name: str
) -> PathCollection:
    edges, dual, corners, s = (
        arrays[f"{name}_{what}"] for what in ("edges", "dual", "corners", "spiral")
    )
    for lines, near, far, width in (
        (edges, "#9a9a9a", "#d8d8d8", 0.6),
        (dual, "black", "#b0b0b0", 1.3),
    ):
        colors = np.where(_behind(lines), far, near)
        panel.add_collection(LineCollection(list(_seen(lines)), colors=colors, linewidths=width))
    front = corners[~_behind(corners[:, None])]
    panel.plot(*_seen(front).T, "s", color="black", markersize=3)
    sizes = 24 / np.sqrt(np.arange(1, len(s) + 1))
    x, y = _seen(s).T
    points = panel.scatter(
        x,
        y,
        c=arrays[f"{name}_values"],
        s=sizes,
        zorder=3,
        cmap=SEQUENTIAL,
        vmin=-0.1,
        vmax=0.6,
        edgecolors="black",
        linewidths=0.3,
    )
    panel.set_aspect("equal", anchor="N")
    panel.axis("off")
    panel.set_title(title, loc="center")
    return points


def _seen(points: np.ndarray) -> np.ndarray:
    """Project from space along a fixed direction; planar points stay."""
    return points if points.shape[-1] == 2 else points @ VIEW[:2].T


def _behind(pieces: np.ndarray) -> np.ndarray:
    """Whether the middle of each piece (m, k, d) is behind the plane of the drawing."""
    depth = pieces.mean(axis=1) @ VIEW[2] if pieces.shape[-1] == 3 else np.zeros(len(pieces))
    return depth < -1e-9


def plot_errors(result: Result) -> Figure:
    """Errors of linear data along the spiral from an edge, and near an edge."""
    arrays = result.arrays
    looks = dict(zip(FORMS, [line("LS"), shades("truth", 2)[1], line("MLS")], strict=True))
    with figure(FULL_WIDTH, height=2.6, columns=2, sharey=True) as (page, (left, right)):
        for form in (FORMS[0], FORMS[-1]):
            errors = np.maximum(arrays[f"moved_{form}"], FLOOR)
            look = looks[form] | {"linestyle": "none", "label": form}
            left.plot(np.arange(1, len(errors) + 1), errors, **look)
        left.set(xlabel="point $n$ of the spiral", ylabel="error of linear data")
        left.set_title("first point on an edge")
        distances = arrays["distances"]
        for form, errors in zip(FORMS, arrays["near"].T, strict=True):
            right.plot(distances, np.maximum(errors, FLOOR), **looks[form] | {"label": form})
        guide = np.finfo(float).eps / distances
        right.plot(distances, guide, **line("truth", label="rounding / distance"))
        right.set(xscale="log", yscale="log", xlabel="distance from the edge")
        right.set_title("approaching an edge")
        for panel in (left, right):
            panel.legend(loc="upper right")
    return page
