"""Pictures of triangles in space: hidden surfaces, shading, edges, and marked errors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fieldrecon._core.geometry import triangle_normals
from fieldrecon.plotting.style import figure
from fieldrecon.triangles.audit import CONCERNS, MeshAudit

_PIXELS = 800
_VIEWS = {
    "from the front, right and above": (0.8, -0.7, 0.6),
    "from behind, left and below": (-0.8, 0.7, -0.6),
}

COLORS = dict(zip(CONCERNS, ("#cc3f8e", "#d55e00", "#0072b2", "#c99700", "#009e73"), strict=True))
"""Colours of errors by concern."""
MARKERS = dict(zip(CONCERNS, "sD^vo", strict=True))
CONCERN_OF = {kind: concern for concern, kinds in CONCERNS.items() for kind in kinds}
LIGHT = np.array([-0.35, 0.5, 0.8]) / np.linalg.norm([-0.35, 0.5, 0.8])
OUTSIDE, INSIDE = np.array(to_rgb("#d9dde3")), np.array(to_rgb("#a9927d"))
"""Colours of the two sides of a triangle: normals point away from the outer one."""

_CHUNK = 2**21  # pixels at once
_MAX_MARKS = 2000  # of each kind of error
_NEAR = 0.36  # share of the mesh in a close-up
_WIDE = 7.0  # median length of the edges in pixels, beyond which edges are drawn


@dataclass(frozen=True)
class Marks:
    """The errors of one kind as triangles (t,), edges (e, 2) and vertices (v,)."""

    triangles: np.ndarray
    edges: np.ndarray
    vertices: np.ndarray

    def of_vertices(self, triangles: np.ndarray) -> np.ndarray:
        """All vertices of the marked triangles and edges, and the marked vertices."""
        return np.concatenate(
            [triangles[self.triangles].ravel(), self.edges.ravel(), self.vertices]
        )


def marks(audit: MeshAudit, triangles: np.ndarray) -> dict[str, Marks]:
    """Return the marks of the errors of each kind that was found."""
    return {kind: _marks(kind, getattr(audit, kind), triangles) for kind in audit.found}


def _marks(kind: str, found: np.ndarray, triangles: np.ndarray) -> Marks:
    no_edges, none = np.empty((0, 2), dtype=np.intp), np.empty(0, dtype=np.intp)
    if kind == "boundary_loops":
        loops = [np.column_stack([loop, np.roll(loop, -1)]) for loop in found]
        return Marks(none, np.concatenate(loops), none)
    if kind == "free_edge_pairs":
        return Marks(none, found.reshape(-1, 2), none)
    if kind == "nonmanifold_edges":
        return Marks(none, found, none)
    if kind == "degenerate_triangles":
        return Marks(none, triangles[found][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), none)
    if kind in ("crossings", "overlaps"):
        return Marks(np.unique(found), no_edges, none)
    first = found[:, 0] if found.ndim == 2 else found
    if kind.endswith("_triangles"):
        return Marks(first, no_edges, none)
    return Marks(none, no_edges, first)


class MeshPicture:
    """A parallel projection of triangles, drawn pixel by pixel.

    Parameters
    ----------
    points : (n, 3) ndarray
    triangles : (m, 3) ndarray of int
    toward : (3,) ndarray
        Direction to the viewer; the z axis points up in the picture.
    pixels : int
        Number of pixels along the longer side.
    middle : ndarray of int, optional
        Points at the centre of a square close-up.
    """

    def __init__(
        self,
        points: np.ndarray,
        triangles: np.ndarray,
        toward: np.ndarray,
        pixels: int,
        middle: np.ndarray | None = None,
    ) -> None:
        self.triangles = triangles
        self.axes = _view(toward)
        projected = (points - points.min(axis=0)) / np.ptp(points, axis=0).max() @ self.axes
        low, high = projected.min(axis=0), projected.max(axis=0)
        scale = (pixels - 8) / (high - low)[:2].max()
        self.points = (projected - low) * scale + 4
        rows, columns = (int(s) for s in np.ceil((high - low)[1::-1] * scale) + 8)
        if middle is not None:
            rows = columns = pixels
            near = self.points[middle, :2] / _NEAR
            self.points /= _NEAR
            self.points[:, :2] -= (near.min(axis=0) + near.max(axis=0) - pixels) / 2
        self.shape = rows, columns
        self.depth = np.full(self.shape[0] * self.shape[1], -np.inf)
        self.front = np.full(len(self.depth), -1)
        self.near_edge = np.zeros(len(self.depth), dtype=bool)
        for pixel, triangle, depth, near_edge in self._fragments():
            np.maximum.at(self.depth, pixel, depth)
            on_top = np.flatnonzero(depth == self.depth[pixel])
            self.front[pixel[on_top]] = triangle[on_top]
            self.near_edge[pixel[on_top]] = near_edge[on_top]

    def image(self, tints: dict[int, np.ndarray] | None = None) -> np.ndarray:
        """Colours (rows, columns, 4), the lowest row first; triangles may be tinted."""
        a, b, c = self.points[self.triangles].swapaxes(0, 1)
        normal = triangle_normals(a, b, c)
        length = np.linalg.norm(normal, axis=1)[:, None]
        normal = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
        light = 0.5 + 0.5 * np.abs(normal @ LIGHT)
        color = np.where(normal[:, 2:] > 0, OUTSIDE, INSIDE)
        for triangle, tint in (tints or {}).items():
            color[triangle] = 0.15 * color[triangle] + 0.85 * tint
        color *= light[:, None]
        image = np.zeros((len(self.front), 4))
        there = self.front >= 0
        image[there, :3], image[there, 3] = color[self.front[there]], 1
        if self._edge_width() > _WIDE:
            image[there & self.near_edge, :3] *= 0.6
        return np.clip(image, 0, 1).reshape(*self.shape, 4)

    def hidden(self, points: np.ndarray) -> np.ndarray:
        """Whether points (k, 3) of the picture are hidden."""
        column, row = np.clip(points[:, :2].astype(int), 0, np.array(self.shape[::-1]) - 1).T
        slack = 0.02 * max(self.shape)
        return points[:, 2] < self.depth[row * self.shape[1] + column] - slack

    def _edge_width(self) -> float:
        corners = self.points[self.triangles[:: max(1, len(self.triangles) // 1000)], :2]
        return float(np.median(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)))

    def _fragments(self) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
        """Yield pixels, the triangles that cover them, their depths, and whether near an edge."""
        corners = self.points[self.triangles]
        low = np.maximum(np.ceil(corners[:, :, :2].min(axis=1) - 0.5), 0).astype(int)
        high = np.floor(corners[:, :, :2].max(axis=1) - 0.5).astype(int)
        size = np.maximum(np.minimum(high, np.array(self.shape[::-1]) - 1) - low + 1, 0)
        count = size.prod(axis=1)
        starts = np.concatenate([[0], np.cumsum(count)])
        cuts = np.searchsorted(starts, np.arange(0, starts[-1] + _CHUNK, _CHUNK))
        for first, last in pairwise(cuts):
            rows_of_chunk = np.arange(first, min(last, len(count)))
            triangle = np.repeat(rows_of_chunk, count[rows_of_chunk])
            if len(triangle) == 0:
                continue
            offset = np.arange(starts[first], starts[rows_of_chunk[-1] + 1]) - starts[triangle]
            row, column = np.divmod(offset, size[triangle, 0])
            row, column = row + low[triangle, 1], column + low[triangle, 0]
            yield self._covered(corners, triangle, row, column)

    def _covered(
        self, corners: np.ndarray, triangle: np.ndarray, row: np.ndarray, column: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        a, b, c = corners[triangle].swapaxes(0, 1)
        x, y = column + 0.5, row + 0.5
        shares = np.stack([_twice_area(p, q, x, y) for p, q in ((b, c), (c, a), (a, b))])
        area = shares.sum(axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            weights = shares / area
        inside = (weights >= 0).all(axis=0)
        weights, a, b, c = weights[:, inside], a[inside], b[inside], c[inside]
        depth = weights[0] * a[:, 2] + weights[1] * b[:, 2] + weights[2] * c[:, 2]
        sides = np.stack([np.hypot(*(q - p)[:, :2].T) for p, q in ((b, c), (c, a), (a, b))])
        near = (weights * np.abs(area[inside]) < 0.6 * sides).any(axis=0)
        pixel = (row * self.shape[1] + column)[inside]
        return pixel, triangle[inside], depth, near


def draw(
    panel: Axes,
    points: np.ndarray,
    triangles: np.ndarray,
    found: dict[str, Marks],
    toward: np.ndarray,
    pixels: int = 500,
    *,
    near: bool = False,
) -> None:
    """Draw a mesh with its errors: triangles tinted, edges and vertices marked.

    Hidden errors are marked faintly. With `near`, the picture is a close-up of the errors.
    """
    marked = [mark.of_vertices(triangles) for mark in found.values()]
    middle = np.concatenate(marked) if near else None
    picture = MeshPicture(points, triangles, toward, pixels, middle)
    tints = {
        int(t): np.array(to_rgb(COLORS[CONCERN_OF[kind]]))
        for kind, mark in found.items()
        for t in mark.triangles
    }
    rows, columns = picture.shape
    panel.imshow(picture.image(tints), extent=(0, columns, 0, rows), interpolation="antialiased")
    for kind, mark in found.items():
        _draw_edges(panel, picture, mark.edges[:_MAX_MARKS], COLORS[CONCERN_OF[kind]])
        _draw_vertices(panel, picture, mark.vertices[:_MAX_MARKS], CONCERN_OF[kind])
    panel.set(xlim=(0, columns), ylim=(0, rows), aspect="equal")
    panel.set_axis_off()


def _draw_edges(panel: Axes, picture: MeshPicture, edges: np.ndarray, color: str) -> None:
    ends = picture.points[edges]
    hidden = picture.hidden(ends.mean(axis=1))
    for behind, width, opacity in ((True, 1.0, 0.6), (False, 1.8, 1.0)):
        lines = ends[hidden == behind][:, :, :2]
        panel.add_collection(
            LineCollection(lines, colors=color, linewidths=width, alpha=opacity, capstyle="round")
        )


def _draw_vertices(panel: Axes, picture: MeshPicture, vertices: np.ndarray, concern: str) -> None:
    marked = picture.points[vertices]
    shown = ((marked[:, :2] >= 0) & (marked[:, :2] <= picture.shape[::-1])).all(axis=1)
    marked = marked[shown]
    hidden = picture.hidden(marked)
    color = COLORS[concern]
    for behind, fill, opacity in ((True, "none", 0.5), (False, color, 1.0)):
        x, y = marked[hidden == behind, :2].T
        panel.plot(
            x,
            y,
            MARKERS[concern],
            color=color,
            markerfacecolor=fill,
            alpha=opacity,
            markersize=4.5,
            markeredgewidth=0.8,
            clip_on=False,  # a mark at the edge of the picture is whole
            in_layout=False,
        )


def _twice_area(p: np.ndarray, q: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Twice the signed area of the triangle p, q, (x, y) in the picture."""
    return (q[:, 0] - p[:, 0]) * (y - p[:, 1]) - (q[:, 1] - p[:, 1]) * (x - p[:, 0])


def _view(toward: np.ndarray) -> np.ndarray:
    """Return the matrix whose columns point right, up, and to the viewer."""
    towards = np.asarray(toward, dtype=float) / np.linalg.norm(toward)
    right = np.cross([0, 0, 1], towards)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(towards, right), towards])


def plot_audit(audit: MeshAudit, points: np.ndarray, triangles: np.ndarray) -> Figure:
    """Draw the mesh from two sides with each error marked; hidden errors are faint."""
    found = marks(audit, triangles)
    with figure(height=3.6, columns=2) as (page, axes):
        for panel, (title, toward) in zip(axes, _VIEWS.items(), strict=True):
            draw(panel, points, triangles, found, np.array(toward), pixels=_PIXELS)
            panel.set_title(title, loc="center")
        handles = [
            Line2D(
                [],
                [],
                color=COLORS[concern],
                marker=MARKERS[concern],
                label=f"{concern}: {sum(audit.counts[concern].values())}",
            )
            for concern in CONCERNS
            if any(audit.counts[concern].values())
        ]
        if handles:
            page.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return page
