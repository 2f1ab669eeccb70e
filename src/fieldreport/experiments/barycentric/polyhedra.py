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

import numpy as np
from matplotlib.figure import Figure

from fieldrecon.barycentric.coordinates import BarycentricCoordinates
from fieldreport.experiments.barycentric import coordinate_formulas as formulas
from fieldreport.experiments.barycentric.coordinate_limits import Outside, errors_beside
from fieldreport.experiments.barycentric.polyhedra_figures import (
    FROM_THE_RIGHT,
    TOWARD,
    draw_solids,
    plot_edge,
    plot_outside,
    plot_polygons,
    plot_splitting,
)
from fieldreport.experiments.barycentric.polytopes import (
    OUTSIDE,
    POLYHEDRA,
    Planes,
    mesh_of,
    polygons,
)
from fieldreport.framework.experiment import (
    Cell,
    Map,
    Parameters,
    Result,
    ResultTable,
    order_of_magnitude,
    parameter,
    require,
)

__all__ = [
    "QUICK",
    "Params",
    "plot",
    "plot_edge",
    "plot_outside",
    "plot_polygons",
    "plot_splitting",
    "run",
]

CLOSED_FORMS: dict[str, tuple[str, Callable[[np.ndarray, np.ndarray], np.ndarray]]] = {
    "triangle": ("affine", formulas.affine),
    "tetrahedron": ("affine", formulas.affine),
    "square": ("bilinear", formulas.multilinear),
    "cube": ("trilinear", formulas.multilinear),
}
EXACT = 1e-10
SMALL = 0.02
"""Only shifts below this are used for the power law: larger ones show the next order."""


@dataclass(frozen=True)
class Params(Parameters):
    """Numbers of query points, shifts of the faces, and distances from edges."""

    corners: int = parameter(7, "corners of the random polygon", least=4)
    queries: int = parameter(100, "random query points in each polytope", least=1)
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
            f"{2 * self.smallest_shift:g} or more",
            self.largest_shift,
        )


QUICK = Params(queries=4, splits=2, shifts=4, turns=2, distances=6, poles=12, rings=3)
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
    planes, x = Planes.of(corners), _places(params, corners)
    w = BarycentricCoordinates(corners).weights(x)
    few = formulas.quotient(planes, x, corners.shape[1]) @ corners - x
    found = {
        "positions": np.abs(w @ corners - x).max(),
        "polar": np.abs(w - formulas.polar(planes, x)).max(),
        "few faces": np.sqrt(np.mean(np.sum(few**2, axis=1))),
    }
    if name in CLOSED_FORMS:
        found["closed"] = np.abs(w - CLOSED_FORMS[name][1](corners, x)).max()
    return {key: float(value) for key, value in found.items()}


def splitting_errors(params: Params, corners: np.ndarray) -> np.ndarray:
    """Return the largest difference (split, shift) from the weights of the split polyhedra."""
    planes, x = Planes.of(corners), 0.8 * _places(params, corners)
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
    x = _places(params, corners)
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
    return np.geomspace(params.largest_shift, params.smallest_shift, params.shifts)


def _places(params: Params, corners: np.ndarray) -> np.ndarray:
    rng = np.random.default_rng((params.seed, len(corners)))
    return rng.dirichlet(np.full(len(corners), 0.5), params.queries) @ corners


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
    small = shifts(params) < SMALL
    slopes = np.polyfit(np.log(shifts(params)[small]), np.log(errors[:, small]).T, 1)[0]
    return {
        "slope_least": slopes.min(),
        "slope_most": slopes.max(),
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
