"""Barycentric coordinates of convex polygons and polyhedra against independent formulas.

The coordinates of triangles, squares, other polygons and six polyhedra are compared with closed
forms, and with volumes of the polar dual that are computed from a convex hull. Where four faces
meet they are compared with the coordinates of polyhedra whose faces were shifted apart, by
decreasing distances. Near an edge and near a corner the quotient form of the slides loses digits;
the product form does not. Outside a polygon the coordinates have poles, on the curve through the
intersections of its extended edges.

References
----------
Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 27-31);
Wachspress, A Rational Finite Element Basis (1975); Warren, Schaefer, Hirani and Desbrun,
Barycentric coordinates for convex sets (2007).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.ticker import NullLocator
from matplotlib.tri import Triangulation

from fieldrecon.barycentric.coordinates import BarycentricCoordinates
from fieldrecon.plotting.style import (
    BLACK_ON_MAP,
    DIVERGING,
    SEQUENTIAL,
    WHITE_ON_MAP,
    figure,
    shades,
)
from fieldreport.experiments.barycentric import coordinate_formulas as formulas
from fieldreport.experiments.barycentric.coordinate_formulas import Outside, errors_beside, split
from fieldreport.experiments.barycentric.polytopes import (
    OUTSIDE,
    POLYHEDRA,
    Planes,
    mesh_of,
    polygons,
)
from fieldreport.framework.error_measures import order, order_of_magnitude, rms
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter, require

LEVELS = np.linspace(0, 1, 11)
FAR = np.array([-10, -5, -2, -1, -0.5, 0, 0.5, 1, 2, 5, 10])
SEEN: dict[str, Any] = {"color": "black", "linewidth": 0.9}
FAINT: dict[str, Any] = {"color": "0.6", "linewidth": 0.5}
HIDDEN: dict[str, Any] = {"color": "0.55", "linewidth": 0.5, "linestyle": (0, (4, 3))}

TOWARD = {"octahedron": (0.88, 0.24, 0.36), "rhombic dodecahedron": (0.85, 0.36, 0.38)}
"""View direction of some polyhedra, from which all four faces at a corner are visible."""
FROM_THE_RIGHT = (0.62, 0.42, 0.46)
"""View direction of the other polyhedra."""

CLOSED_FORMS: dict[str, tuple[str, Callable[[np.ndarray, np.ndarray], np.ndarray]]] = {
    "triangle": ("affine", formulas.affine),
    "tetrahedron": ("affine", formulas.affine),
    "square": ("bilinear", formulas.multilinear),
    "cube": ("trilinear", formulas.multilinear),
}
EXACT = 1e-6
"""Smaller errors are due to rounding, which quotients amplify at points close to a face."""
SMALL = 0.02
"""Only shifts below this are used for the power law: larger ones show the next order."""


@dataclass(frozen=True)
class Params(Parameters):
    """Numbers of query points, shifts of the faces, and distances from edges."""

    corners: int = parameter(7, "corners of the random polygon", least=4)
    queries: int = parameter(100, "random query points in each polytope", least=1)
    sampled: int = parameter(
        10_000, "random points at which the formula with D faces is evaluated", least=1
    )
    splits: int = parameter(6, "random splittings, in which faces are shifted apart", least=1)
    largest_shift: float = parameter(
        0.1, "largest distance δ by which a face is shifted", above=0, most=0.1
    )
    smallest_shift: float = parameter(1e-10, "smallest δ", least=1e-11, most=0.01)
    shifts: int = parameter(10, "values of δ, in geometric progression", least=2)
    turns: int = parameter(
        25, "random rotations of the hexagon for queries near its edges", least=1
    )
    nearest: float = parameter(
        1e-18, "smallest distance from an edge or corner; the size is 1", least=1e-300, most=0.01
    )
    distances: int = parameter(
        37, "distances from an edge or corner, in geometric progression", least=2
    )
    poles: int = parameter(200, "directions in which poles are searched outside", least=1)
    rings: int = parameter(14, "refinement of the meshes in the figures", least=2)
    seed: int = parameter(4, "seed of polygons, query points, shifts and rotations", least=0)

    def __post_init__(self) -> None:
        super().__post_init__()
        require(
            self.largest_shift >= 2 * self.smallest_shift,
            "largest_shift",
            f"{2 * self.smallest_shift:g} or more, twice smallest_shift",
            self.largest_shift,
        )
        require(
            (self.deltas < SMALL).sum() > 1,
            "shifts",
            f"so many that two values from largest_shift to smallest_shift are below {SMALL:g}",
            self.shifts,
        )

    @property
    def deltas(self) -> np.ndarray:
        """The distances δ, the largest first."""
        return np.geomspace(self.largest_shift, self.smallest_shift, self.shifts)


QUICK = Params(queries=4, sampled=1000, splits=2, shifts=4, turns=2, distances=6, poles=12, rings=3)
DIGITS = {"difference_at_smallest_shift": 3, "quotient_digits_lost": 2}


def run(params: Params, each: Map = map) -> Result:
    """Compare formulas, split corners, approach edges, and evaluate outside."""
    shapes = polygons(params.corners, params.seed) | POLYHEDRA
    compared = dict(zip(shapes, each(partial(comparison, params), shapes.items()), strict=True))
    crowded = {name: p for name, p in POLYHEDRA.items() if not Planes.of(p).simple}
    errors = each(partial(splitting_errors, params), crowded.values())
    split = dict(zip(crowded, errors, strict=True))
    distances = np.geomspace(0.1, params.nearest, params.distances)
    turns = np.random.default_rng(params.seed).uniform(0, np.pi / 3, params.turns)
    beside = np.stack(list(each(partial(errors_beside, distances), turns.tolist())))
    outside = [Outside.of(p, params.poles, 20 * params.rings) for p in OUTSIDE.values()]
    return Result(
        params=params,
        tables={"polytopes": _table(shapes, compared), "splitting": _split_table(params, split)},
        facts=_facts(compared)
        | {"gradient_error": order_of_magnitude(gradient_error(params))}
        | _split_facts(params, split)
        | _facts_beside(distances, beside)
        | _facts_outside(outside),
        arrays={"distances": distances, "beside": np.where(beside < 0, 1, beside).max(axis=0)}
        | {"shifts": shifts(params), "splits": np.stack([*split.values()])}
        | {"crowded": np.array([*crowded])}
        | {key: array for seen in outside for key, array in seen.arrays().items()}
        | _pictures(params, shapes),
    )


def comparison(params: Params, shape: tuple[str, np.ndarray]) -> dict[str, float]:
    """Return the errors of the coordinates of a polytope, and of the quotient on d faces."""
    name, corners = shape
    planes, x = Planes.of(corners), _places(params.queries, params.seed, corners)
    w = BarycentricCoordinates(corners).weights(x)
    found = {
        "positions": np.abs(w @ corners - x).max(),
        "polar": np.abs(w - formulas.polar(planes, x)).max(),
        "few faces": error_of_few_faces(params, corners),
    }
    if name in CLOSED_FORMS:
        found["closed"] = np.abs(w - CLOSED_FORMS[name][1](corners, x)).max()
    return {key: float(value) for key, value in found.items()}


def error_of_few_faces(params: Params, corners: np.ndarray) -> float:
    """Return the rms error of positions from d faces at each corner, as if it were simple."""
    x = _places(params.sampled, params.seed, corners)
    return rms(formulas.quotient(Planes.of(corners), x, corners.shape[1]) @ corners - x)


def splitting_errors(params: Params, corners: np.ndarray) -> np.ndarray:
    """Return the largest difference (split, shift) from the weights of the split polyhedra."""
    planes, x = Planes.of(corners), 0.8 * _places(params.queries, params.seed, corners)
    w = BarycentricCoordinates(corners).weights(x)
    errors = np.empty((params.splits, params.shifts))
    for row, direction in zip(errors, _directions(params, planes), strict=True):
        for k, delta in enumerate(shifts(params)):
            apart, origin = formulas.split(planes, delta * direction)
            parts = formulas.quotient(apart, x)
            row[k] = np.abs(formulas.added_up(parts, origin, len(corners)) - w).max()
    return errors


def gradient_error(params: Params) -> float:
    """Return the largest error of the gradient of xyz in the cube, which should be zero."""
    corners = POLYHEDRA["cube"]
    x = _places(params.queries, params.seed, corners)
    gradient = BarycentricCoordinates(corners).field(corners.prod(axis=1)).gradient(x)
    return float(np.abs(gradient - x[:, [1, 0, 0]] * x[:, [2, 2, 1]]).max())


def ways_apart(params: Params, name: str) -> int:
    """Return the number of combinatorially different splittings of a polyhedron."""
    planes = Planes.of(POLYHEDRA[name])
    apart = (
        formulas.split(planes, params.smallest_shift * direction)[0]
        for direction in _directions(params, planes)
    )
    return len({frozenset(map(bytes, p.on)) for p in apart})


def shifts(params: Params) -> np.ndarray:
    """Return the distances δ by which faces are shifted."""
    return params.deltas


def _places(n: int, seed: int, corners: np.ndarray) -> np.ndarray:
    rng = np.random.default_rng((seed, len(corners)))
    return rng.dirichlet(np.full(len(corners), 0.5), n) @ corners


def _directions(params: Params, planes: Planes) -> np.ndarray:
    rng = np.random.default_rng((params.seed, len(planes.offsets)))
    return rng.uniform(-1, 1, (params.splits, len(planes.offsets)))


def _told(error: float) -> float:
    return order_of_magnitude(error) if error < EXACT else error


def _table(shapes: dict[str, np.ndarray], compared: dict[str, dict[str, float]]) -> ResultTable:
    rows = []
    for name, corners in shapes.items():
        planes, found = Planes.of(corners), compared[name]
        counts = corners.shape[1], len(corners), len(planes.offsets), int(planes.faces_at.max())
        closed = (
            (CLOSED_FORMS[name][0], _told(found["closed"])) if "closed" in found else ("–",) * 2
        )
        errors = (_told(found[key]) for key in ("positions", "polar", "few faces"))
        rows.append((name, *counts, "yes" if planes.simple else "no", *errors, *closed))
    counts_named = ("D", "corners", "faces", "faces at a corner, most", "simple")
    errors_named = ("positions", "polar dual", "positions, D faces", "closed form", "difference")
    return ResultTable(("polytope", *counts_named, *errors_named), tuple(rows))


def _split_table(params: Params, split: dict[str, np.ndarray]) -> ResultTable:
    names = [f"{name}, {what}" for name in split for what in ("least", "most")]
    columns = [f(errors, axis=0) for errors in split.values() for f in (np.min, np.max)]
    return ResultTable(("delta", *names), tuple(zip(shifts(params), *columns, strict=True)))


def _facts(compared: dict[str, dict[str, float]]) -> dict[str, Cell]:
    def worst(what: str) -> float:
        return order_of_magnitude(max(found.get(what, 0.0) for found in compared.values()))

    few: dict[str, Cell] = {
        f"few_faces_{name.replace(' ', '_')}": found["few faces"]
        for name, found in compared.items()
        if found["few faces"] > EXACT
    }
    return few | {f"{what}_error": worst(what) for what in ("positions", "polar", "closed")}


def _split_facts(params: Params, split: dict[str, np.ndarray]) -> dict[str, Cell]:
    errors = np.concatenate([*split.values()])
    delta = shifts(params)
    slopes = [order(delta[delta < SMALL], e[delta < SMALL]) for e in errors]
    return {
        "slope_least": min(slopes),
        "slope_most": max(slopes),
        "difference_at_smallest_shift": errors[:, -1].max(),
        "ways_pyramid": ways_apart(params, "square pyramid"),
    }


def _facts_beside(distances: np.ndarray, beside: np.ndarray) -> dict[str, Cell]:
    quotient, products = beside[:, :, 0], beside[:, :, 1]
    half = int(np.abs(np.log10(distances) + 8).argmin())
    return {
        "half_way": distances[half],
        "quotient_half_way": order_of_magnitude(np.abs(quotient[:, 0, half]).max()),
        "products_beside_error": order_of_magnitude(products.max()),
        "quotient_digits_lost": np.log10(np.abs(quotient[:, :, -1]).max() / products.max()),
    }


def _facts_outside(outside: list[Outside]) -> dict[str, Cell]:
    return {
        "adjoint_difference": order_of_magnitude(max(seen.difference for seen in outside)),
        "crossings": sum(len(seen.crossings) for seen in outside),
        "poles": sum(len(seen.poles) for seen in outside),
        "poles_refused": sum(seen.refused for seen in outside),
    }


def _pictures(params: Params, shapes: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return, for each shape, a mesh of it or of its faces, and one coordinate there."""
    arrays = {"shapes": np.array([*shapes])}
    for name, corners in shapes.items():
        planes, key = Planes.of(corners), name.replace(" ", "_")
        most = planes.faces_at == planes.faces_at.max()
        toward = corners @ TOWARD.get(name, FROM_THE_RIGHT)[: corners.shape[1]]
        nearest = int(np.argmax(np.where(most, toward, -np.inf)))
        loops = (
            [corners]
            if corners.shape[1] == 2
            else [corners[planes.around(a)] for a in range(len(planes.offsets))]
        )
        meshes = [mesh_of(loop, params.rings) for loop in loops]
        starts = np.cumsum([0, *(len(points) for points, _ in meshes)])
        points = np.concatenate([points for points, _ in meshes])
        arrays |= {
            f"{key}_corners": corners,
            f"{key}_chosen": np.array(nearest),
            f"{key}_points": points,
            f"{key}_triangles": np.concatenate(
                [t + start for (_, t), start in zip(meshes, starts, strict=False)]
            ),
            f"{key}_faces": np.repeat(np.arange(len(meshes)), [len(t) for _, t in meshes]),
            f"{key}_values": BarycentricCoordinates(corners).weights(points)[:, nearest],
        }
    return arrays


def plot(result: Result) -> Figure:
    """The six polyhedra, with one coordinate on their visible faces."""
    return draw_solids(result)


def draw_solids(result: Result) -> Figure:
    """Draw the polyhedra, the simple ones above, and a coordinate on their visible faces."""
    with figure(height=4.35, rows=2, columns=3) as (page, axes):
        for panel, name in zip(axes.ravel(), POLYHEDRA, strict=True):
            bands = _draw_solid(panel, result, name)
            simple = Planes.of(POLYHEDRA[name]).simple
            panel.set_title(name if simple else f"{name}, not simple", loc="center")
        _color_bar(page, bands, axes)
    return page


def plot_polygons(result: Result) -> Figure:
    """The coordinate of one corner in the polygons."""
    names = [name for name in result.arrays["shapes"] if name not in POLYHEDRA]
    with figure(height=1.85, columns=len(names)) as (page, axes):
        for panel, name in zip(axes, names, strict=True):
            mesh = _Mesh(result, name)
            bands = _bands(panel, mesh.points, mesh.triangles, mesh.values)
            panel.add_patch(Polygon(mesh.corners, fill=False, edgecolor="black", linewidth=0.9))
            panel.plot(*mesh.corners[mesh.chosen], "o", color="black")
            _bare(panel)
            panel.set(xlim=(-1.1, 1.1), ylim=(-1.05, 1.05))
            panel.set_title(name, loc="center", fontsize=8)
        _color_bar(page, bands, axes)
    return page


def plot_edge(result: Result) -> Figure:
    """Errors of the quotient and of the products near an edge and near a corner."""
    arrays, (dark, light) = result.arrays, shades("truth", 2, markersize=3, markevery=2)
    with figure(height=2.4, columns=2, sharey=True) as (page, axes):
        for panel, what, errors in zip(
            axes, ("an edge", "a corner"), arrays["beside"], strict=True
        ):
            for error, label, look in zip(
                errors, ("quotient of the slides", "products"), (light, dark), strict=True
            ):
                panel.plot(arrays["distances"], np.maximum(error, 1e-17), **look, label=label)
            panel.set(title=f"near {what}", xscale="log", yscale="log", ylim=(3e-18, 10))
            panel.set_xlabel("distance")
            panel.invert_xaxis()
            panel.xaxis.set_minor_locator(NullLocator())
        axes[0].set_ylabel("largest error of a weight")
        axes[1].legend(loc="center left")
    return page


def plot_splitting(result: Result) -> Figure:
    """Two ways to split the apex of a pyramid, and the difference as the faces come together."""
    arrays, planes = result.arrays, Planes.of(POLYHEDRA["square pyramid"])
    view = _view(FROM_THE_RIGHT)
    with figure(height=2.3, columns=3, width_ratios=(1, 1, 1.9)) as (page, axes):
        for panel, pair, title in zip(
            axes, planes.opposite, ("one way", "the other way"), strict=False
        ):
            shift = np.zeros(len(planes.offsets))
            shift[pair] = 0.22
            _outline(panel, split(planes, shift)[0], view)
            _outline(panel, planes, view, faint=True)
            panel.set(xlim=(-1.75, 1.75), ylim=(-1.3, 2.1))
            panel.set_title(title, loc="center")
        looks = shades("truth", len(arrays["crowded"]), marker="", linewidth=0.7)
        for name, errors, look in zip(arrays["crowded"], arrays["splits"], looks, strict=True):
            for k, row in enumerate(errors):
                axes[2].plot(arrays["shifts"], row, **look, label=None if k else name)
        ends = arrays["shifts"][[0, -1]]
        axes[2].plot(ends, 4 * ends, color="0.8", linewidth=2.5, label="slope 1")
        axes[2].set(xscale="log", yscale="log", xlabel="displacement δ of the faces")
        axes[2].set_title("difference of the weights")
        axes[2].legend(loc="lower right", fontsize=7)
    return page


def plot_outside(result: Result) -> Figure:
    """One coordinate of polygons inside and outside, and the curve on which it has poles."""
    sizes = sorted({int(key.split("_")[1]) for key in result.arrays if key.startswith("outside_")})
    norm = BoundaryNorm(FAR, 256, extend="both")
    with figure(height=2.75, columns=len(sizes)) as (page, axes):
        for panel, n in zip(axes, sizes, strict=True):
            corners, crossings, grid, weight, denominator = (
                result.arrays[f"outside_{n}_{what}"]
                for what in ("corners", "crossings", "grid", "weight", "denominator")
            )
            x, y = np.moveaxis(grid, -1, 0)
            bands = panel.contourf(
                x, y, weight, levels=FAR, norm=norm, cmap=DIVERGING, extend="both"
            )
            bands.set(edgecolor="face", linewidth=0.3, rasterized=True)
            for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
                panel.axline(a, b, color=BLACK_ON_MAP, alpha=0.7, linewidth=0.4)
            panel.contour(x, y, denominator, levels=[0], colors=BLACK_ON_MAP, linewidths=1.8)
            panel.add_patch(Polygon(corners, fill=False, edgecolor=BLACK_ON_MAP, linewidth=1.0))
            mark = {"marker": "o", "linestyle": "none", "color": BLACK_ON_MAP, "zorder": 4}
            panel.plot(*crossings.T, markerfacecolor=WHITE_ON_MAP, **mark)
            panel.plot(*corners[0], **mark)
            _bare(panel)
            panel.set(xlim=(x.min(), x.max()), ylim=(y.min(), y.max()))
            panel.set_title(f"{n} corners, degree {n - 3}", loc="center")
        label = "coordinate of the corner with the dot"
        bar = page.colorbar(bands, ax=axes, location="bottom", shrink=0.6, aspect=42, label=label)
        bar.set_ticks(FAR.tolist(), labels=[f"{level:g}".replace("-", "−") for level in FAR])
    return page


class _Mesh:
    """The data of one shape: a mesh of it or of its faces, and a coordinate there."""

    def __init__(self, result: Result, name: str) -> None:
        key = name.replace(" ", "_")
        self.corners = result.arrays[f"{key}_corners"]
        self.points = result.arrays[f"{key}_points"]
        self.triangles = result.arrays[f"{key}_triangles"]
        self.faces = result.arrays[f"{key}_faces"]
        self.values = result.arrays[f"{key}_values"]
        self.chosen = int(result.arrays[f"{key}_chosen"])


def _draw_solid(panel: Axes, result: Result, name: str) -> ContourSet:
    mesh, planes = _Mesh(result, name), Planes.of(POLYHEDRA[name])
    view = _view(TOWARD.get(name, FROM_THE_RIGHT))
    flat = mesh.points @ view[:, :2]
    for face in np.flatnonzero(planes.normals @ view[:, 2] > 0):
        triangles = mesh.triangles[mesh.faces == face]
        used, local = np.unique(triangles, return_inverse=True)
        bands = _bands(panel, flat[used], local.reshape(triangles.shape), mesh.values[used])
    _outline(panel, planes, view)
    low, high = flat.min(axis=0), flat.max(axis=0)
    pad = 0.04 * (high - low).max()
    panel.set(xlim=(low[0] - pad, high[0] + pad), ylim=(low[1] - pad, high[1] + pad))
    panel.plot(*(mesh.corners[mesh.chosen] @ view[:, :2]), "o", color="black", zorder=4)
    return bands


def _view(toward: tuple[float, float, float]) -> np.ndarray:
    """Return the matrix whose columns point right, up, and to the viewer."""
    towards = np.array(toward) / np.linalg.norm(toward)
    right = np.cross([0, 0, 1], towards) / np.linalg.norm(np.cross([0, 0, 1], towards))
    return np.stack([right, np.cross(towards, right), towards], axis=1)


def _outline(panel: Axes, planes: Planes, view: np.ndarray, *, faint: bool = False) -> None:
    """Draw the edges of a polyhedron, those behind it dashed."""
    edges, flat = planes.edges, planes.corners @ view[:, :2]
    front = planes.normals @ view[:, 2] > 0
    seen = (planes.on[edges[:, 0]] & planes.on[edges[:, 1]] & front).any(axis=1)
    panel.add_collection(LineCollection(flat[edges[~seen]], **(FAINT if faint else HIDDEN)))
    panel.add_collection(LineCollection(flat[edges[seen]], **(FAINT if faint else SEEN)))
    panel.autoscale_view()
    _bare(panel)


def _bands(
    panel: Axes, points: np.ndarray, triangles: np.ndarray, values: np.ndarray
) -> ContourSet:
    """Fill the bands between the levels of a coordinate, and draw the levels."""
    mesh = Triangulation(points[:, 0], points[:, 1], triangles)
    bands = panel.tricontourf(mesh, np.clip(values, 0, 1), levels=LEVELS, cmap=SEQUENTIAL)
    bands.set(edgecolor="face", linewidth=0.3)
    panel.tricontour(mesh, values, levels=LEVELS[1:-1], colors="white", linewidths=0.4)
    return bands


def _color_bar(page: Figure, bands: ContourSet, axes: Any) -> None:
    label = "coordinate of the corner with the dot"
    bar = page.colorbar(bands, ax=axes, location="bottom", shrink=0.5, aspect=35, label=label)
    bar.set_ticks(LEVELS[::2].tolist())


def _bare(panel: Axes) -> None:
    panel.set_aspect("equal")
    panel.set_axis_off()
