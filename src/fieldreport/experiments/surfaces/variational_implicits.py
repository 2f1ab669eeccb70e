"""Variational implicit surfaces: minimal energy and shape transformation.

A closed surface is the zero level set of the field of minimal energy that vanishes at points and
decreases along their normals. The normals are given as derivatives or, as by Turk and O'Brien, as
the value of an offset at points slightly inside. Both are tested on an ellipsoid, by the distance
of the zero level set and by the volume that it encloses. Then two shapes become slices of one field
of one more variable: a star is transformed into two discs, and a ring into a ball; the shapes
between them are not given.

References
----------
Turk and O'Brien, Shape transformation using variational implicit functions (1999).
Turk and O'Brien, Modelling with implicit surfaces that interpolate (2002).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.figure import Figure
from scipy import ndimage

from fieldrecon.datasets.synthetic import halton
from fieldrecon.fields import Field
from fieldrecon.plotting.style import figure, line
from fieldrecon.solids.ray_casting import View, ray_traced
from fieldrecon.surfaces.variational_implicits import ShapeTransformation, variational_implicit
from fieldreport.framework.error_measures import order
from fieldreport.framework.experiment import Map, Result, ResultTable
from fieldreport.framework.parameters import Parameters, parameter

AXES = np.array([1.5, 1.0, 0.7])
"""Semi-axes of the ellipsoid."""
RING, TUBE = 0.75, 0.3
STAR_WAVE, STAR_LOBES, DISC = 0.3, 5, 0.55
_NEWTON_STEPS = 4
VIEWER = (0.5, -0.8, 0.75)


@dataclass(frozen=True)
class Params(Parameters):
    """The sizes of the clouds, the offset, and the figures."""

    sizes: tuple[int, ...] = parameter(
        (50, 100, 200, 400), "points on the ellipsoid", least=20, fewest=2, order="increasing"
    )
    offsets: tuple[float, ...] = parameter(
        (0.1, 0.01),
        "distances of the points inside, in radii",
        least=1e-4,
        most=1,
        fewest=2,
        order="decreasing",
    )
    queries: int = parameter(
        800, "points on the ellipsoid at which the error is measured", least=10
    )
    points: int = parameter(48, "points on each shape in the plane", least=12)
    ring_points: int = parameter(160, "points on each solid", least=40)
    distance: float = parameter(
        1.5, "difference of the two times, as a length", least=0.01, most=100
    )
    frames: int = parameter(5, "times in the figure", least=2, most=12)
    side: int = parameter(161, "nodes along each side of the plane", least=21)
    pixels: int = parameter(120, "along each side of a body's picture", least=4)


QUICK = Params(sizes=(30, 60), queries=100, points=20, ring_points=50, frames=3, side=31, pixels=8)


def run(params: Params, each: Map = map) -> Result:
    """Measure the errors on the ellipsoid, and transform shapes."""
    ways = (None, *params.offsets)
    works = [(n, offset) for offset in ways for n in params.sizes]
    missed, volumes = np.array(list(each(partial(on_ellipsoid, params.queries), works))).T
    missed, volumes = (a.reshape(len(ways), -1) for a in (missed, volumes))
    times = np.linspace(0, 1, params.frames)
    star, discs = star_shape(params.points), two_discs(params.points)
    flat = ShapeTransformation([star, discs], [0.0, params.distance])
    t = np.linspace(-1.7, 1.7, params.side)
    grid = np.stack(np.meshgrid(t, t), axis=-1)
    slices = np.array([flat.at(s * params.distance)(grid) for s in times])
    areas = (slices > 0).mean(axis=(1, 2)) * (3.4 * params.side / (params.side - 1)) ** 2
    parts = [int(ndimage.label(f > 0)[1]) for f in slices]
    solid = ShapeTransformation(
        [ring(params.ring_points), ball(params.ring_points)], [0.0, params.distance]
    )
    images = list(each(partial(_picture, solid, params), times))
    ways_named = ["slopes", *(f"offset {offset:g}" for offset in params.offsets)]
    exact_areas = star_area(), 2 * np.pi * DISC**2
    return Result(
        params=params,
        tables={
            "ellipsoid": ResultTable(
                ("points", *ways_named),
                tuple((n, *e) for n, e in zip(params.sizes, missed.T, strict=True)),
            ),
            "slices": ResultTable(
                ("time", "parts", "area"), tuple(zip(times, parts, areas, strict=True))
            ),
        },
        facts={
            "missed_slopes": missed[0, -1],
            "missed_wide": missed[1, -1],
            "missed_narrow": missed[-1, -1],
            "order_slopes": order([n**-0.5 for n in params.sizes], missed[0]),
            "volume_percent": 100 * abs(volumes[0, -1] / (4 / 3 * np.pi * AXES.prod()) - 1),
            "first_parts": parts[0],
            "last_parts": parts[-1],
            "first_area_percent": 100 * abs(areas[0] / exact_areas[0] - 1),
            "last_area_percent": 100 * abs(areas[-1] / exact_areas[1] - 1),
        },
        arrays={
            "missed": missed,
            "times": times,
            "slices": slices,
            "star": star[0],
            "discs": discs[0],
            "images": np.array(images),
        },
    )


def on_ellipsoid(queries: int, work: tuple[int, float | None]) -> tuple[float, float]:
    """Root mean square distance of the zero level set from the ellipsoid, and its volume."""
    n, offset = work
    p, normals = ellipsoid(n)
    f = variational_implicit(p, normals, offset=offset)
    dense, _ = ellipsoid(queries)
    distance = f(dense) / np.linalg.norm(f.gradient(dense), axis=1)
    return float(np.sqrt(np.mean(distance**2))), volume_between(f, dense)


def volume_between(f: Field, dense: np.ndarray) -> float:
    """Volume enclosed by the zero level set, from rays through points on the ellipsoid.

    The unit sphere is scaled by AXES, so the volume is AXES.prod() times 4 pi / 3 times the mean of
    the cubed distances of the zero level set along the rays.
    """
    far = np.ones(len(dense))
    for _ in range(_NEWTON_STEPS):
        x = far[:, None] * dense
        far -= f(x) / np.einsum("nd,nd->n", f.gradient(x), dense)
    return float(4 / 3 * np.pi * AXES.prod() * np.mean(far**3))


def ellipsoid(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) on the ellipsoid and outward unit normals."""
    on = on_sphere(n)
    normals = on / AXES
    return on * AXES, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def on_sphere(n: int) -> np.ndarray:
    """Points (n, 3) on the unit sphere, evenly distributed on a spiral."""
    z = 1 - (2 * np.arange(n) + 1) / n
    angle = np.pi * (3 - 5**0.5) * np.arange(n)
    r = np.sqrt(1 - z**2)
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), z])


def star_shape(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2) of the curve r = 1 + 0.3 cos 5t, and its outward normals."""
    t = 2 * np.pi * np.arange(n) / n
    r = 1 + STAR_WAVE * np.cos(STAR_LOBES * t)
    slope = -STAR_LOBES * STAR_WAVE * np.sin(STAR_LOBES * t)
    radial = np.column_stack([np.cos(t), np.sin(t)])
    around = np.column_stack([-np.sin(t), np.cos(t)])
    return r[:, None] * radial, r[:, None] * radial - slope[:, None] * around


def star_area() -> float:
    """Area within the star, pi (1 + wave^2 / 2)."""
    return float(np.pi * (1 + STAR_WAVE**2 / 2))


def two_discs(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2) on two circles side by side, and outward normals."""
    t = 2 * np.pi * np.arange(n // 2) / (n // 2)
    circle = np.column_stack([np.cos(t), np.sin(t)])
    both = [DISC * circle + [x, 0] for x in (-0.9, 0.9)]
    return np.concatenate(both), np.concatenate([circle, circle])


def ring(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) on a torus about the third axis, and outward normals."""
    u, v = 2 * np.pi * halton(n, 2).T
    radial = np.column_stack([np.cos(u), np.sin(u), np.zeros(n)])
    normals = np.cos(v)[:, None] * radial + np.outer(np.sin(v), [0, 0, 1])
    return RING * radial + TUBE * normals, normals


def ball(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) on a ball, and outward normals."""
    on = on_sphere(n)
    return 0.8 * on, on


def _picture(solid: ShapeTransformation, params: Params, time: float) -> np.ndarray:
    view = View.of_box([[-1.15, -1.15, -0.95], [1.15, 1.15, 0.95]], VIEWER, params.pixels)
    return ray_traced(solid.at(time * params.distance), view, step=0.08, slope=1.5)


def plot(result: Result) -> Figure:
    """Draw the slices in the plane, above those in space."""
    a = result.arrays
    n = len(a["times"])
    t = np.linspace(-1.7, 1.7, a["slices"].shape[1])
    with figure(height=2.5, rows=2, columns=n) as (page, axes):
        for k, (time, values) in enumerate(zip(a["times"], a["slices"], strict=True)):
            flat, solid = axes[:, k]
            flat.contourf(t, t, values, levels=[0, np.inf], colors=["#cfd6de"])
            flat.contour(t, t, values, levels=[0], colors=[line("RBF")["color"]], linewidths=1.2)
            flat.set(aspect="equal", xlim=(-1.65, 1.65), ylim=(-1.5, 1.5))
            flat.set_title(f"{time:.2g}", loc="center")
            solid.imshow(a["images"][k], origin="lower", interpolation="antialiased")
            for panel in (flat, solid):
                panel.set_axis_off()
        for panel, points in ((axes[0, 0], a["star"]), (axes[0, -1], a["discs"])):
            panel.plot(*points.T, **line("data", label=None), markersize=3)
    return page
