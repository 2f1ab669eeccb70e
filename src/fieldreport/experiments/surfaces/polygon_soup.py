"""Polygon soup: closed implicit surfaces that interpolate or approximate loose polygons.

Segments with gaps and crossings, and triangles torn from a ring, define the zero level set of
implicit moving least squares, in which weights are integrated over each polygon and the data are
functions. Without smoothing the level set passes through the polygons. With smoothing it bulges,
and is corrected around the corners by moving each polygon. On a cube the distance of the level set
is measured as the smoothing tends to zero, and the integrals in closed form are compared with
quadrature.

References
----------
Shen, O'Brien and Shewchuk, Interpolating and approximating implicit surfaces from polygon soup
(2004).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from fieldrecon._core.geometry import triangle_normals
from fieldrecon.plotting.mesh_pictures import MeshPicture
from fieldrecon.plotting.style import HUES, figure, line, shades
from fieldrecon.solids.ray_casting import View, ray_traced
from fieldrecon.surfaces.polygon_soup import PolygonSoup
from fieldrecon.surfaces.triangle_integrals import by_rule, over_triangles
from fieldreport.experiments.triangles.triangle_shapes import Surface, cube, torus
from fieldreport.framework.error_measures import order
from fieldreport.framework.experiment import Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter

OUTLINE = np.array(
    [
        [0, 0],
        [3, 0],
        [3, 0.8],
        [1.2, 0.8],
        [1.2, 1.4],
        [2.2, 1.4],
        [2.2, 2.2],
        [1.2, 2.2],
        [1.2, 3],
        [0, 3],
    ]
)
VIEWER = np.array([0.5, -0.8, 0.75])
BOX = np.array([[-1.6, -1.6, -0.65], [1.6, 1.6, 0.65]])
_ROUNDING = 1e-15  # smaller relative errors are reported as this
TITLES = ("ε = 0", "ε = {:g}", "ε = {:g}, around")


@dataclass(frozen=True)
class Params(Parameters):
    """The perturbation of the polygons, the smoothing, and the figures."""

    loose: float = parameter(
        0.06, "displacement of the ends of segments, as a length", least=0, most=1
    )
    smoothing: float = parameter(0.25, "epsilon in the plane, as a length", least=1e-6, most=10)
    torn: float = parameter(0.04, "shift of the triangles, in radii of the ring", least=0, most=1)
    lost: float = parameter(0.06, "fraction of the triangles that is missing", least=0, most=0.9)
    smoothing_in_space: float = parameter(
        0.12, "epsilon in space, in radii of the ring", least=1e-6, most=10
    )
    around: int = parameter(22, "quadrilaterals around the ring; half as many across", least=6)
    epsilons: tuple[float, ...] = parameter(
        (0.1, 0.05, 0.025, 0.0125),
        "epsilon on the cube, in edge lengths",
        least=1e-6,
        most=10,
        fewest=2,
        order="decreasing",
    )
    heights: tuple[float, ...] = parameter(
        (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0),
        "heights of points above a triangle, in edge lengths",
        least=1e-9,
        most=1e3,
        order="increasing",
    )
    rules: tuple[int, ...] = parameter(
        (4, 8, 16), "points along each side of a triangle", least=1, order="increasing"
    )
    side: int = parameter(121, "nodes along each side of the plane", least=11)
    pixels: int = parameter(170, "along each side of a picture", least=4)
    seed: int = parameter(3, "seed of the random numbers", least=0)


QUICK = Params(around=8, epsilons=(0.1, 0.05), rules=(4,), side=21, pixels=8)


def run(params: Params, each: Map = map) -> Result:
    """Compute the implicit functions, and measure their errors."""
    rng = np.random.default_rng(params.seed)
    ends, segments = loose_outline(params.loose, rng)
    smooth = PolygonSoup(ends, segments, params.smoothing)
    flat = (PolygonSoup(ends, segments), smooth, smooth.enclosing())
    x, y = np.linspace(-0.5, 3.5, params.side), np.linspace(-0.5, 3.5, params.side)
    grid = np.stack(np.meshgrid(x, y), axis=-1)
    torn = torn_ring(params, rng)
    blurred = PolygonSoup(*torn, params.smoothing_in_space, tol=1e-3)
    bodies = (PolygonSoup(*torn, tol=1e-3), blurred, blurred.enclosing())
    images = list(each(partial(_picture, torn, params.pixels), bodies))
    at_ends = [np.round(soup(ends), 12) + 0.0 for soup in flat]
    inner, edges = np.array(list(each(on_the_cube, params.epsilons))).T
    errors = quadrature_errors(params.heights, params.rules)
    return Result(
        params=params,
        tables={
            "corners": ResultTable(
                ("level", "least F", "largest F"),
                tuple(
                    (name, f.min(), f.max())
                    for name, f in zip(("through", "smoothed", "around"), at_ends, strict=True)
                ),
            ),
            "cube": ResultTable(
                ("epsilon", "on faces", "on edges"),
                tuple(zip(params.epsilons, inner, edges, strict=True)),
            ),
            "quadrature": ResultTable(
                ("height", *(f"{n} x {n}" for n in params.rules)),
                tuple((h, *e) for h, e in zip(params.heights, errors.T, strict=True)),
            ),
        },
        facts={
            "order_faces": order(params.epsilons, inner),
            "order_edges": order(params.epsilons, edges),
            "segments": len(segments),
            "triangles": len(torn[1]),
            "smoothed_least": float(at_ends[1].min()),
            "around_at_corners": float(at_ends[2].max()),
            "worst_rule": float(errors[-1, 0]),
            "best_rule": float(errors[-1, -1]),
        },
        arrays={
            "ends": ends,
            "segments": segments,
            "fields": np.array([soup(grid) for soup in flat]),
            "torn": torn[0],
            "triangles": torn[1],
            "images": np.array(images),
            "inner": inner,
            "edges": edges,
            "errors": errors,
        },
    )


def loose_outline(loose: float, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Segments of the outline with slightly displaced ends."""
    ends = np.stack([OUTLINE, np.roll(OUTLINE, -1, axis=0)], axis=1)
    ends = ends + rng.uniform(-loose, loose, ends.shape)
    return ends.reshape(-1, 2), np.arange(2 * len(OUTLINE)).reshape(-1, 2)


def torn_ring(params: Params, rng: np.random.Generator) -> Surface:
    """Triangles of a ring, without shared corners, shifted, and some of them removed."""
    points, triangles = torus(params.around, params.around // 2)
    kept = rng.random(len(triangles)) >= params.lost
    if not kept.any():
        raise ValueError(f"parameter lost must leave a triangle; {params.lost:g} leaves none")
    corners = points[triangles[kept]]
    corners = corners + rng.uniform(-params.torn, params.torn, (len(corners), 1, 3))
    return corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)


def on_the_cube(epsilon: float) -> tuple[float, float]:
    """Largest |F| on the faces of the unit cube far from its edges, and on its edges."""
    soup = PolygonSoup(*cube(1), epsilon)
    t = np.linspace(0.25, 0.75, 7)
    face = np.stack([*np.meshgrid(t, t), np.zeros((7, 7))], axis=-1)
    edge = np.stack([t, np.zeros(7), np.zeros(7)], axis=-1)
    return float(np.abs(soup(face)).max()), float(np.abs(soup(edge)).max())


def gauss_on_triangles(corners: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (k, n², 3) and weights of Gauss's rule on a square, mapped to triangles (k, 3, 3)."""
    node, weight = np.polynomial.legendre.leggauss(n)
    u, v = np.meshgrid((node + 1) / 2, (node + 1) / 2, indexing="ij")
    share = np.outer(weight, weight).ravel() / 4 * (1 - u.ravel())
    second, third = u.ravel(), (v * (1 - u)).ravel()
    shape = np.stack([1 - second - third, second, third], axis=1)
    normal = triangle_normals(*corners.swapaxes(0, 1))
    twice = np.linalg.norm(normal, axis=1)
    return np.einsum("qc,kcd->kqd", shape, corners), twice[:, None] * share


def quadrature_errors(heights: tuple[float, ...], rules: tuple[int, ...]) -> np.ndarray:
    """Relative errors (rules, heights) of Gauss's rules, compared with the closed form."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    x = np.column_stack([np.full((len(heights), 2), 1 / 3), heights])
    many = np.broadcast_to(corners, (len(x), 3, 3))
    up = np.broadcast_to([0.0, 0, 1], x.shape)
    exact, _ = over_triangles(x, many, up, 0.0)
    return np.array(
        [
            np.maximum(
                np.abs(by_rule(x, *gauss_on_triangles(many, n), 0.0)[0] / exact - 1), _ROUNDING
            )
            for n in rules
        ]
    )


def _picture(torn: Surface, pixels: int, soup: PolygonSoup) -> np.ndarray:
    points, triangles = torn
    near = np.concatenate([points, points[triangles].mean(axis=1)])
    return ray_traced(soup, View.of_box(BOX, VIEWER, pixels), step=0.08, near=near)


def plot(result: Result) -> Figure:
    """Draw the loose segments and the interpolating and approximating level sets."""
    a, params = result.arrays, result.params
    t = np.linspace(-0.5, 3.5, params.side)
    with figure(height=2.1, columns=3) as (page, axes):
        for panel, values, title in zip(axes, a["fields"], TITLES, strict=True):
            panel.contourf(t, t, values, levels=[0, np.inf], colors=["#cfd6de"])
            panel.contour(
                t,
                t,
                values,
                levels=[-0.6, -0.3, 0.2, 0.4],
                colors="#8a929b",
                linewidths=0.5,
                linestyles="solid",
            )
            panel.contour(t, t, values, levels=[0], colors=[line("MLS")["color"]], linewidths=1.3)
            panel.add_collection(LineCollection(a["ends"][a["segments"]], colors=HUES[3]))
            panel.set(aspect="equal", xlim=(-0.45, 3.45), ylim=(-0.45, 3.45))
            panel.set_title(title.format(params.smoothing), loc="center")
            panel.set_axis_off()
    return page


def plot_bodies(result: Result) -> Figure:
    """Draw the torn ring and the solids reconstructed from it."""
    a, params = result.arrays, result.params
    soup = MeshPicture(a["torn"], a["triangles"], VIEWER, 3 * params.pixels).image()
    titles = ("triangles", *(t.format(params.smoothing_in_space) for t in TITLES))
    seen = a["images"][..., 3].any(axis=0)
    seen |= not seen.any()  # if too few triangles are left, the empty pictures whole
    rows, columns = (np.unique(index) for index in np.nonzero(seen))
    images = a["images"][:, rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    with figure(height=1.4, columns=4) as (page, axes):
        for panel, image, title in zip(axes, (soup, *images), titles, strict=True):
            panel.imshow(image, origin="lower", interpolation="antialiased")
            panel.set_title(title, loc="center")
            panel.set_axis_off()
    return page


def plot_orders(result: Result) -> Figure:
    """Draw the largest values on the faces and edges of a cube, and the errors of quadrature."""
    a, params = result.arrays, result.params
    with figure(height=2.3, columns=2) as (page, (left, right)):
        for name, values, look in zip(
            ("on faces", "on edges"), (a["inner"], a["edges"]), shades("MLS", 2), strict=True
        ):
            left.loglog(params.epsilons, values, **look, label=name)
        left.set(xlabel="ε in edges of the cube", ylabel="largest |F|")
        left.set_xticks(params.epsilons, [f"{e:g}" for e in params.epsilons])
        left.minorticks_off()
        left.legend()
        looks = shades("LS", len(params.rules))
        for n, errors, look in zip(params.rules, a["errors"], looks, strict=True):
            right.loglog(params.heights, errors, **look, label=f"{n} × {n}")
        right.set(xlabel="height above a triangle", ylabel="relative error")
        right.legend()
    return page
