"""Rank of B' and configurations of normals that reduce it.

The slides ask which conditions the normals must satisfy so that B' has full column rank if B has.
The configurations here violate them, some in obvious ways and some not. Each is approached by
rotating the normals, and the smallest singular value decreases in proportion to the distance t. In
the plane they include the edges of triangles whose vertices lie on a conic; in space, stars of
tetrahedra with few vertices.

References
----------
Erleben, "Field Reconstruction: A Quick Survey of Methods", University of Copenhagen (p. 42).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import combinations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.spatial import ConvexHull

from fieldrecon.datasets.synthetic import uniform
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.plotting.style import FULL_WIDTH, METHOD_COLORS, figure, hues
from fieldrecon.polynomials import monomials
from fieldreport.experiments.velocity.normal_matrix_rank import normal_matrix, one_ring, rank
from fieldreport.framework.error_measures import order
from fieldreport.framework.experiment import Cell, Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter, require

Samples = tuple[np.ndarray, np.ndarray]

OCTAHEDRON = np.vstack([np.eye(3), -np.eye(3)])
STEP = 1e-6
"""Step of the difference quotient in t."""

FULL = "full rank"

NEARLY_CONSTANT = np.array([1.0, 0.5, 0.03, 0.02, -0.01, 0.04])
"""Among the fields that are tangent to all samples, the figure shows the one nearest to this."""


@dataclass(frozen=True)
class Params(Parameters):
    """Numbers of samples, and the approach to the rank-deficient configurations."""

    samples: int = parameter(12, "samples (p, n) in the plane; twice as many in space", least=7)
    smallest: float = parameter(
        1e-6, "smallest t, the angle in radians by which normals rotate", least=1e-7, most=0.01
    )
    largest: float = parameter(1.0, "largest t", most=1)
    steps: int = parameter(13, "values of t, in geometric progression", least=3)
    sets: int = parameter(
        400, "random sets of points of a small grid, for the largest possible rank", least=1
    )
    stars: int = parameter(100, "stars of tetrahedra drawn for each number of vertices", least=1)
    vertices: tuple[int, ...] = parameter(
        (5, 6, 7, 8, 10, 14), "vertices of those stars", least=5, order="increasing"
    )
    seed: int = parameter(3, "seed of points, normals and stars", least=0)

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.largest > self.smallest, "largest", "more than smallest", self.largest)


QUICK = Params(steps=7, sets=40, stars=5, vertices=(5, 6, 7))
DIGITS = {"rate_difference": 0}


def run(params: Params, each: Map = map) -> Result:
    """Approach each configuration; draw sets of points, and stars of tetrahedra."""
    cases = configurations(params.samples, params.seed)
    t = np.geomspace(params.smallest, params.largest, params.steps)
    smallest = np.array([[smallest_singular_value(case, x) for x in t] for case in cases])
    rows = tuple(_row(case, t, s) for case, s in zip(cases, smallest, strict=True))
    jobs = [(params.seed, n) for n in params.vertices]
    stars = tuple(each(partial(ranks_of_stars, params.stars), jobs))
    return Result(
        params=params,
        tables={
            "configurations": ResultTable(CONFIGURATIONS, rows),
            "stars": ResultTable(STARS, (*stars, _octahedron())),
        },
        facts=_facts(rows) | _sets_of_points(params),
        arrays={"t": t, "smallest": smallest} | _drawn(cases),
    )


# --- configurations ----------------------------------------------------------------------

CONFIGURATIONS = (
    "configuration",
    "D",
    "n",
    "rank B",
    "known rank",
    "rank B'",
    "slope",
    "σ/t",
    "σ/t by theory",
)


def smallest_singular_value(case: Configuration, t: float) -> float:
    """Return the smallest singular value of B', relative to the largest."""
    s = np.linalg.svd(normal_matrix(*case.at(t)), compute_uv=False)
    return float(s[-1] / s[0])


def rate_by_perturbation(case: Configuration) -> float:
    """Return the limit of σ/t: the least singular value of (I − U Uᵀ) dB'/dt V₀.

    U spans the range of B' and V₀ its kernel.
    """
    u, s, vt = np.linalg.svd(normal_matrix(*case.at(0.0)))
    r = rank(normal_matrix(*case.at(0.0)))
    plus, minus = (normal_matrix(*case.at(x)) for x in (STEP, -STEP))
    moved = u[:, r:].T @ ((plus - minus) / (2 * STEP)) @ vt[r:].T
    return float(np.linalg.svd(moved, compute_uv=False)[-1] / s[0])


def _row(case: Configuration, t: np.ndarray, smallest: np.ndarray) -> tuple[Cell, ...]:
    p, n = case.at(0.0)
    found = rank(normal_matrix(p, n))
    start = (case.title, p.shape[1], len(p), rank(np.column_stack([np.ones(len(p)), p])))
    if found == p.shape[1] * (p.shape[1] + 1):
        return *start, case.rank, found, FULL, FULL, FULL
    near = t <= max(1e-2 * t[-1], t[1])
    slope = order(t[near], smallest[near])
    return *start, case.rank, found, slope, smallest[0] / t[0], rate_by_perturbation(case)


def _facts(rows: tuple[tuple[Cell, ...], ...]) -> dict[str, Cell]:
    lost = [row for row in rows if row[-1] != FULL]
    slope, measured, theory = np.array([row[6:] for row in lost], dtype=float).T
    return {
        "configurations": len(lost),
        "rank_mismatches": sum(row[4] != row[5] for row in rows),
        "least_slope": slope.min(),
        "largest_slope": slope.max(),
        "rate_difference": np.abs(measured / theory - 1).max(),
    }


def _drawn(cases: list[Configuration]) -> dict[str, np.ndarray]:
    """For rank-deficient configurations in the plane: samples, and a field tangent to all."""
    arrays: dict[str, np.ndarray] = {}
    for case in cases:
        p, n = case.at(0.0)
        if p.shape[1] == 2 and case.rank < 6:
            null = np.linalg.svd(normal_matrix(p, n))[2][case.rank :]
            field = null.T @ (null @ NEARLY_CONSTANT)
            arrays |= {
                f"{case.name}_p": p,
                f"{case.name}_n": n,
                f"{case.name}_field": field / np.linalg.norm(field),
                f"{case.name}_edges": case.edges,
            }
    return arrays


# --- largest possible rank ----------------------------------------------------------------------


def best_rank(p: np.ndarray) -> int:
    """Return the rank of B' for almost all normals: min over sets S of n − |S| + 2 rank B(S).

    It suffices to consider the empty set, coincident points, points on one line, and all points.
    """
    ones = np.column_stack([np.ones(len(p)), p])
    bounds = [len(p), 2 * rank(ones)]
    places = Counter(map(tuple, p))
    bounds.append(len(p) - max(places.values()) + 2)
    for a, b in combinations(places, 2):
        normal = np.array([b[1] - a[1], a[0] - b[0]])
        on_line = np.isclose((p - a) @ normal, 0, atol=1e-12).sum()
        bounds.append(len(p) - on_line + 4)
    return int(min(bounds))


def _sets_of_points(params: Params) -> dict[str, Cell]:
    """Compare that bound, on points of a 3 x 3 grid, to the rank with random normals."""
    rng = np.random.default_rng((params.seed, 1))
    mismatches, spoilt = 0, 0
    for _ in range(params.sets):
        n = int(rng.integers(6, 10))
        p = rng.integers(-1, 2, (n, 2)).astype(float)
        angle = rng.uniform(0, np.pi, n)
        found = rank(normal_matrix(p, np.column_stack([np.cos(angle), np.sin(angle)])))
        mismatches += found != best_rank(p)
        spoilt += found < 6 and rank(np.column_stack([np.ones(n), p])) == 3
    return {"sets_mismatches": mismatches, "sets_spoilt": spoilt}


# --- tetrahedra ---------------------------------------------------------------------------------

STARS = (
    "star",
    "vertices",
    "tetrahedra",
    "faces",
    "bound",
    "lowest rank",
    "highest rank",
    "value determined, %",
)


def ranks_of_stars(stars: int, job: tuple[int, int]) -> tuple[Cell, ...]:
    """Return the number of vertices, and the ranks of B' of random stars with this number."""
    seed, n = job
    return _star_row("at random", list(_random_stars(stars, n, np.random.default_rng((seed, n)))))


def _octahedron() -> tuple[Cell, ...]:
    return _star_row("octahedron", [_star(OCTAHEDRON)])


def _star_row(name: str, meshes: list[SimplexMesh]) -> tuple[Cell, ...]:
    fits = [one_ring(mesh, np.zeros(len(mesh.faces))) for mesh in meshes]
    ranks = [int(fit.rank[0]) for fit in fits]
    mesh = meshes[0]
    n, cells, faces = len(mesh.points), len(mesh.cells), len(mesh.faces)
    bound = min(12, faces - cells + 1)
    determined = 100 * np.mean([fit.determined[0] for fit in fits])
    return name, n, cells, faces, bound, min(ranks), max(ranks), float(determined)


def _random_stars(stars: int, n: int, rng: np.random.Generator) -> Iterator[SimplexMesh]:
    """Yield tetrahedra round vertex 0 with n - 1 others at random directions and distances."""
    while stars:
        rim = rng.standard_normal((n - 1, 3))
        rim /= np.linalg.norm(rim, axis=1)[:, None]
        if (ConvexHull(rim).equations[:, 3] < -0.05).all():  # the origin well inside
            yield _star(rim, rng.uniform(0.7, 1.3, (n - 1, 1)))
            stars -= 1


def _star(rim: np.ndarray, distance: np.ndarray | float = 1.0) -> SimplexMesh:
    sides = ConvexHull(rim).simplices + 1
    cells = np.column_stack([np.zeros(len(sides), dtype=int), sides])
    return SimplexMesh(np.vstack([np.zeros(3), distance * rim]), cells)


SHOWN = {
    "parallel": "all parallel",
    "two": "all but two parallel",
    "three": "all but three, in line",
    "five": "five of six points in line",
    "rotation": "rotation",
    "expansion": "expansion",
    "spiral": "spiral",
    "saddle": "saddle",
    "parabola": "parabolas",
    "hyperbola": "vertices on a hyperbola",
}
COLUMNS = 5
HALF_EDGE = 0.15


@dataclass(frozen=True)
class Configuration:
    """Samples that are rank deficient at t = 0.

    Attributes
    ----------
    name, title : str
        An identifier, and a title for readers.
    rank : int
        The rank of B' at t = 0, known by theory.
    at : callable
        Maps t to points and unit normals (n, d).
    edges : (n, 2, d) ndarray
        Ends of the edges at t = 0, if the samples are edges of triangles; none otherwise.
    """

    name: str
    title: str
    rank: int
    at: Callable[[float], Samples]
    edges: np.ndarray = field(default_factory=lambda: np.empty((0, 2, 2)))


def configurations(samples: int, seed: int) -> list[Configuration]:
    """Return all configurations, in the plane and in space, the last ones with random normals."""
    rng = np.random.default_rng(seed)
    return [*_in_the_plane(samples, rng), *_in_space(2 * samples, rng)]


def _in_the_plane(n: int, rng: np.random.Generator) -> list[Configuration]:
    p = 0.9 * (2 * uniform(n, 2, rng) - 1)
    m = np.array([0.3, -0.2])  # the centre, off the origin
    parallel = np.tile(_unit(np.array([0.3, 1.0])), (n, 1))
    free = _unit(rng.standard_normal((n, 2)))
    two, three = (np.where(np.arange(n)[:, None] < k, free, parallel) for k in (2, 3))
    in_line = p.copy()
    in_line[:3] = np.array([-0.6, -0.5]) + np.array([[0.0], [0.5], [1.1]]) * np.array([1.0, 0.6])
    along = {
        "rotation": ("rotation", lambda x: _turned(x - m)),
        "expansion": ("expansion", lambda x: x - m),
        "spiral": ("spiral", lambda x: 0.4 * (x - m) + _turned(x - m)),
        "saddle": ("saddle", lambda x: (x - m) * [1.0, -1.0]),
        "parabola": ("parabolas", lambda x: np.column_stack([np.ones(len(x)), 2 * x[:, 0]])),
    }
    tangent = [
        _turning(name, title, 5, p, _turned(_unit(u(p))), rng) for name, (title, u) in along.items()
    ]
    return [
        _turning("parallel", "all normals parallel", 3, p, parallel, rng),
        _turning("two", "all but two parallel", 5, p, two, rng),
        _turning("three", "all but three, in line", 5, in_line, three, rng),
        *tangent,
        _hyperbola(rng),
        _five_in_line(rng),
        _turning("random", "normals at random", 6, p, free, rng),
    ]


def _in_space(n: int, rng: np.random.Generator) -> list[Configuration]:
    p = 2 * uniform(n, 3, rng) - 1
    m, axis = np.array([0.3, -0.2, 0.1]), _unit(np.array([1.0, 1.0, 1.0]))
    free = _unit(rng.standard_normal((n, 3)))
    parallel = np.tile(_unit(np.array([0.3, 1.0, 0.5])), (n, 1))
    about = np.cross(axis, p - m)
    fields = {
        "axis": ("rotation about an axis", about),
        "source": ("expansion in space", p - m),
        "screw": ("screw", about + 0.4 * axis),
    }
    return [
        _turning("planes", "all parallel in space", 4, p, parallel, rng),
        *(
            _turning(name, title, 11, p, _unit(np.cross(u, free)), rng)
            for name, (title, u) in fields.items()
        ),
        _turning("random_space", "at random in space", 12, p, free, rng),
    ]


def _turning(
    name: str, title: str, rank: int, p: np.ndarray, n: np.ndarray, rng: np.random.Generator
) -> Configuration:
    """Samples whose normals rotate by angles of the order of t."""
    away = rng.standard_normal(n.shape)
    away -= (away * n).sum(axis=1)[:, None] * n
    return Configuration(name, title, rank, lambda t: (p, _unit(n + t * away)))


def _hyperbola(rng: np.random.Generator) -> Configuration:
    """The edges of a star with vertices on the hyperbola xy = 1/9, which move by t."""
    x = np.array([1.0, 2.6, 0.4, -0.45, -1.1, -2.4]) / 3
    vertices = np.column_stack([x, 1 / (9 * x)])
    order = 1 + np.argsort(np.arctan2(*(vertices[1:] - vertices[0]).T[::-1]))
    triangles = np.column_stack([np.zeros(5, dtype=int), order, np.roll(order, -1)])
    sides = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    start, end = np.unique(np.sort(sides, axis=1), axis=0).T
    away = rng.standard_normal(vertices.shape) / 3

    def at(t: float) -> Samples:
        corner = vertices + t * away
        return (corner[start] + corner[end]) / 2, _turned(_unit(corner[end] - corner[start]))

    ends = np.stack([vertices[start], vertices[end]], axis=1)
    return Configuration("hyperbola", "vertices on a hyperbola", 5, at, ends)


def _five_in_line(rng: np.random.Generator) -> Configuration:
    """Six samples, five of them at distances t from a line, with arbitrary normals."""
    p = np.array([-0.7, -0.2]) + np.linspace(0, 1.4, 6)[:, None] * np.array([1.0, 0.5])
    p[5] = [0.3, -0.6]
    n, away = _unit(rng.standard_normal((6, 2))), rng.standard_normal((6, 2))
    return Configuration("five", "five of six points in line", 5, lambda t: (p + t * away, n))


def _turned(u: np.ndarray) -> np.ndarray:
    """Vectors (n, 2), rotated by 90 degrees."""
    return np.column_stack([-u[:, 1], u[:, 0]])


def _unit(u: np.ndarray) -> np.ndarray:
    return u / np.linalg.norm(u, axis=-1, keepdims=True)


def plot(result: Result) -> Figure:
    """Draw each sample as a short edge, and the streamlines of the tangent field."""
    with figure(FULL_WIDTH, 2.75, rows=2, columns=COLUMNS) as (page, axes):
        for panel, (name, title) in zip(axes.ravel(), SHOWN.items(), strict=True):
            p, n, edges, c = (result.arrays[f"{name}_{k}"] for k in ("p", "n", "edges", "field"))
            along = HALF_EDGE * np.column_stack([-n[:, 1], n[:, 0]])
            edges = edges if len(edges) else np.stack([p - along, p + along], axis=1)
            _draw_field(panel, c)
            for ends in edges:
                panel.plot(*ends.T, color="black", linewidth=1.2)
            panel.plot(*p.T, ".", color="black", markersize=3.5)
            panel.set(xlim=(-1.1, 1.1), ylim=(-1.1, 1.1), aspect="equal", xticks=[], yticks=[])
            panel.set_title(title, fontsize=7.5)
            panel.grid(visible=False)
            panel.spines[:].set_visible(True)
    return page


def _draw_field(axes: Axes, c: np.ndarray) -> None:
    ticks = np.linspace(-1.1, 1.1, 40)
    x, y = np.meshgrid(ticks, ticks)
    u, v = np.moveaxis(monomials(np.stack([x, y], axis=-1), 1) @ c.reshape(3, 2), -1, 0)
    blue = METHOD_COLORS["MLS"]
    axes.streamplot(x, y, u, v, color=blue, linewidth=0.6, arrowsize=0.5, density=0.55)


def plot_approach(result: Result) -> Figure:
    """Draw the smallest singular value over t against t, in the plane and in space."""
    t, table = result.arrays["t"], result.tables["configurations"]
    rows = list(zip(table.rows, result.arrays["smallest"], strict=True))
    with figure(FULL_WIDTH, 3.1, columns=2, sharey=True) as (page, axes):
        for panel, d, where in zip(axes, (2, 3), ("in the plane", "in space"), strict=True):
            *lines, _ = [(row, s) for row, s in rows if row[1] == d]  # the last is of full rank
            for (row, s), look in zip(lines, hues(len(lines) + 1, markersize=3)[1:], strict=True):
                panel.plot(t, s / t, **(look | {"label": row[0], "linewidth": 0.9}))
            panel.set(xscale="log", yscale="log", xlabel="$t$", title=where)
            below = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.21), "ncols": 2}
            panel.legend(fontsize=7, labelspacing=0.3, columnspacing=1.0, **below)
        axes[0].set_ylabel(r"$\sigma_{\min} / (t\,\sigma_{\max})$")
    return page
