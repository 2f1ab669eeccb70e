"""The figures of Voronoi coordinates on spirals."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from fieldrecon.plotting.style import FULL_WIDTH, SEQUENTIAL, figure, line, shades

VIEW = Rotation.from_euler("zyx", [200, 0, -70], degrees=True).as_matrix()
"""To the right, upward, and toward the reader: rows."""

FLOOR = 3e-17
"""Where errors of zero are drawn."""


def draw_stars(arrays: Mapping[str, np.ndarray]) -> Figure:
    """The stars, their Voronoi cells, and the spirals coloured by value."""
    with figure(FULL_WIDTH, height=5.0, rows=2, columns=2) as (page, axes):
        asked, middle, moved, space = axes.flat
        points = _draw_star(asked, "as asked", arrays, "asked")
        _draw_star(middle, "as asked, the middle enlarged", arrays, "asked")
        s = arrays["asked_spiral"]
        reach = 1.15 * np.abs(s[3]).max()
        middle.set(xlim=(-0.45 * reach, reach), ylim=(-0.55 * reach, 0.9 * reach))
        for n in range(4, len(s) + 1):
            if n in (4, 6, 10, 20, len(s)):
                outward = 9 * s[n - 1] / np.linalg.norm(s[n - 1])
                look = {"textcoords": "offset points", "ha": "center", "va": "center"}
                middle.annotate(f"{n}", s[n - 1], outward, **look)
        _draw_star(moved, "turned and moved", arrays, "moved")
        moved.plot(*s.T, ".", color="#8a8a8a", markersize=3)
        moved.annotate("without\n$x_i$", s[-1], (6, -8), textcoords="offset points", va="top")
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
    """Project from space along a fixed direction; what lies in the plane stays."""
    return points if points.shape[-1] == 2 else points @ VIEW[:2].T


def _behind(pieces: np.ndarray) -> np.ndarray:
    """Whether the middle of each piece (m, k, d) is behind the plane of the drawing."""
    depth = pieces.mean(axis=1) @ VIEW[2] if pieces.shape[-1] == 3 else np.zeros(len(pieces))
    return depth < -1e-9


def draw_errors(arrays: Mapping[str, np.ndarray], forms: tuple[str, ...]) -> Figure:
    """Errors of linear data along the spiral that begins on an edge, and ever nearer to an edge."""
    looks = dict(zip(forms, [line("LS"), shades("truth", 2)[1], line("MLS")], strict=True))
    with figure(FULL_WIDTH, height=2.6, columns=2, sharey=True) as (page, (left, right)):
        for form in (forms[0], forms[-1]):
            errors = np.maximum(arrays[f"moved_{form}"], FLOOR)
            look = looks[form] | {"linestyle": "none", "label": form}
            left.plot(np.arange(1, len(errors) + 1), errors, **look)
        left.set(xlabel="point $n$ of the spiral", ylabel="error of linear data")
        left.set_title("first point on an edge")
        distances = arrays["distances"]
        for form, errors in zip(forms, arrays["near"].T, strict=True):
            right.plot(distances, np.maximum(errors, FLOOR), **looks[form] | {"label": form})
        guide = np.finfo(float).eps / distances
        right.plot(distances, guide, **line("truth", label="rounding / distance"))
        right.set(xscale="log", yscale="log", xlabel="distance from the edge")
        right.set_title("ever nearer to an edge")
        for panel in (left, right):
            panel.legend(loc="upper right")
    return page
