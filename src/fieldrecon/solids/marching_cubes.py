"""Extraction of the surface of a body by marching cubes, with vertices at zeros of the field.

Only the cells that the surface crosses are evaluated: from the cells of known points, the surface
is followed from cell to cell.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress
from fieldrecon._core.extras import optional
from fieldrecon._core.geometry import triangle_normals
from fieldrecon.polynomials import EPS
from fieldrecon.solids.constructive import Solid, as_box, intersection
from fieldrecon.solids.shapes import Box
from fieldrecon.triangles.audit import MeshAudit, audit_mesh

_CELLS = 64  # along the longest side of the box, by default
_FEWEST_CELLS = 12  # along the longest side of the box of the points, by default
_MAX_STEPS = 60  # each is an interpolation or a bisection
_SETTLED = 1e-7  # of an edge: the last step, beyond which the next would be far smaller
_SPECK = 3  # cells: smaller parts of the surface are dropped
_ROUNDINGS = 64  # of the largest coordinate, if larger
_APART = 1e-6  # of an edge: smallest distance of a vertex from its ends
NODE_LIMIT = 2**28
"""Largest number of nodes of a grid, which takes 10 bytes for each."""

_CORNERS = np.array(list(product((0, 1), repeat=3)))
_STRIDE = 4  # cells along the edge of a coarse cell


@dataclass(frozen=True, eq=False)
class ExtractedSurface:
    """Triangles on the surface of a body, counter-clockwise when seen from outside.

    Attributes
    ----------
    points : (n, 3) ndarray
        Vertices, on the zero level.
    triangles : (m, 3) ndarray of int
    solid : Solid
        The body.
    spacing : float
        Edge of the cells.
    cut : (k,) ndarray of int
        Vertices on the wall of the box, where the surface was cut off.
    missed : (k,) ndarray of int
        The points of `near` that are farther than two cells from all vertices.
    """

    points: np.ndarray
    triangles: np.ndarray
    solid: Solid
    spacing: float
    cut: np.ndarray
    missed: np.ndarray

    @cached_property
    def normals(self) -> np.ndarray:
        """Outward unit normals (n, 3) at the vertices, by the gradient of the field."""
        return self.solid.normals(self.points)

    @cached_property
    def audit(self) -> MeshAudit:
        """The errors of the triangles; `audit.clean` if there are none."""
        return audit_mesh(self.points, self.triangles)

    @property
    def area(self) -> float:
        """Sum of the areas of the triangles."""
        return float(np.linalg.norm(self._twice_areas(), axis=1).sum() / 2)

    @property
    def volume(self) -> float:
        """Enclosed volume, positive if the triangles are oriented outward."""
        corner = self.points[self.triangles[:, 0]] - self.points[0]
        return float(np.einsum("ij,ij->", corner, self._twice_areas()) / 6)

    def _twice_areas(self) -> np.ndarray:
        a, b, c = self.points[self.triangles].swapaxes(0, 1)
        return triangle_normals(a, b, c)


def extract_surface(
    solid: Solid,
    spacing: float | None = None,
    *,
    near: ArrayLike | None = None,
    box: ArrayLike | None = None,
    within: float | None = None,
    progress: Progress | None = None,
) -> ExtractedSurface:
    """Triangles on the surface {F = 0} of a body.

    Marching cubes connects the edges of a grid whose ends have different signs; on each of these
    edges the vertex is moved to F = 0, by values of F alone. From the cells that contain points
    near the surface, the surface is followed through the faces that it crosses. The result is
    closed, oriented and without self-intersections for any field. Sharp edges are cut off by less
    than a cell, parts thinner than a cell may be lost, and parts that extend over fewer than three
    cells are dropped.

    Parameters
    ----------
    solid : Solid
        The body; `as_solid` makes one of a field.
    spacing : float, optional
        Edge of the cells; by default the spacing of the points from which the body was made, but
        no more than a 12th of the longest side of the box of these points; and without points, a
        64th of the longest side of the box.
    near : (n, 3) array_like, optional
        Points near the surface; by default those of the body. Without them the whole box is
        searched, and parts smaller than four cells may be missed.
    box : (2, 3) array_like, optional
        The region; by default the box of the body. The surface is closed by the walls of the box.
    within : float, optional
        Drop triangles farther than this length from all points `near`, where the surface is
        invented. The result then has a boundary.
    progress : callable, optional
        Called as progress(done, total) with numbers of nodes; the total grows with the surface.

    Returns
    -------
    ExtractedSurface
        Points, triangles, and where the surface is cut off or missing.

    Raises
    ------
    ValueError
        If there is no surface in the box, or the grid would be too fine for it.
    ImportError
        If scikit-image is missing.

    References
    ----------
    Lorensen and Cline, Marching cubes (1987); Bloomenthal, Polygonization of implicit surfaces
    (1988), for following; Chandrupatla, A new hybrid quadratic/bisection algorithm for finding the
    zero of a nonlinear function without using derivatives (1997); Wendland (2005), section 1.1.

    Examples
    --------
    >>> from fieldrecon.solids.shapes import Ball
    >>> ball = extract_surface(Ball(1.0), spacing=0.05)
    >>> ball.audit.clean, round(ball.volume / (4 / 3 * np.pi), 3)
    (True, 0.999)
    """
    if not isinstance(solid, Solid):
        raise ValueError(f"solid must be a Solid; as_solid makes one of a field; got {solid!r}")
    room = solid.box if box is None else as_box(box)
    spacing = _usual_spacing(solid, room) if spacing is None else spacing
    grid = Grid.over(room, valid.as_length(spacing, "spacing"))
    wall = Box(room[1] - room[0] + 2 * spacing, (room[0] + room[1]) / 2)
    closed = intersection(solid, wall)
    given = solid.near if near is None else valid.as_points(near, "near")
    seeds = search_box(closed, grid) if given is None else grid.cells_of(given)
    values, crossed = follow_surface(closed, grid, seeds, progress=progress)
    if len(crossed) == 0:
        raise ValueError(
            "the body has no surface in the box, or none near the points: F has one sign there"
        )
    ends, triangles = _marching_cubes(values, crossed, grid)
    ends, triangles = _without_specks(ends, triangles)
    points = _on_edges(closed, grid, ends, values)
    cut = np.flatnonzero(np.abs(wall(points)) <= 1e-3 * spacing)
    missed = np.empty(0, np.intp) if given is None else _far_from(points, given, 2 * spacing)
    if within is not None:
        points, triangles, cut = _trimmed(points, triangles, cut, given, within)
    return ExtractedSurface(points, triangles, solid, spacing, cut, missed)


def _usual_spacing(solid: Solid, room: np.ndarray) -> float:
    """Default edge of the cells: the spacing of the points, less where they are few.

    Cells as large as the spacing of a few points are as large as the body, and would lose it.
    """
    finest = float((room[1] - room[0]).max()) / _CELLS
    if solid.spacing is None or solid.near is None:
        return solid.spacing or finest
    extent = float(np.ptp(solid.near, axis=0).max())
    return min(solid.spacing, max(extent / _FEWEST_CELLS, finest))


def _marching_cubes(
    values: np.ndarray, crossed: np.ndarray, grid: Grid
) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray]:
    """Lower ends (n, 3) and axes (n,) of the edges with vertices, and the triangles."""
    measure = optional("skimage.measure")
    mask = np.zeros(grid.shape, dtype=bool)
    mask.ravel()[grid.corners(crossed)[:, -1]] = True
    # of the signs only: each vertex is the midpoint of its edge, which identifies the edge
    signs = np.where(values > 0, np.float32(1), np.float32(-1))
    middle, triangles, _, _ = measure.marching_cubes(
        signs, 0.0, mask=mask, method="lorensen", gradient_direction="ascent"
    )
    lower = np.floor(middle).astype(np.int64)
    return (lower, (middle - lower).argmax(axis=1)), triangles.astype(np.intp)


def _without_specks(
    ends: tuple[np.ndarray, np.ndarray], triangles: np.ndarray
) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray]:
    """Drop the parts of two cells or less, except for the largest."""
    lower, axis = ends
    joints = (triangles.ravel(), np.roll(triangles, 1, axis=1).ravel())
    graph = sparse.csr_array((np.ones(triangles.size, dtype=bool), joints), (len(lower),) * 2)
    count, part = csgraph.connected_components(graph, directed=False)
    if count == 1:
        return ends, triangles
    order = np.argsort(part, kind="stable")
    starts = np.searchsorted(part[order], np.arange(count))
    along = lower[order]
    extent = np.maximum.reduceat(along, starts) - np.minimum.reduceat(along, starts)
    kept = extent.max(axis=1) >= min(_SPECK, extent.max())
    used = kept[part]
    number = np.cumsum(used) - 1
    return (lower[used], axis[used]), number[triangles[used[triangles[:, 0]]]]


def _on_edges(
    solid: Solid, grid: Grid, ends: tuple[np.ndarray, np.ndarray], values: np.ndarray
) -> np.ndarray:
    """Zeros of F on edges, by the method of Chandrupatla (1997), which takes values of F alone."""
    lower, axis = ends
    step = np.eye(3, dtype=np.int64)[axis]
    start = values[tuple(lower.T)].astype(float)
    end = values[tuple((lower + step).T)].astype(float)
    base = grid.nodes(lower)
    apart = max(_APART, _ROUNDINGS * EPS * float(np.abs(base).max()) / grid.spacing)
    t, a = start / (start - end), np.arange(len(base))
    # the newest point, the nearest one across the zero, and the one that was replaced
    x = np.stack([np.ones_like(t), np.zeros_like(t), np.ones_like(t)])
    f = np.stack([end, start, end])
    for _ in range(_MAX_STEPS):
        value = solid(base[a] + grid.spacing * t[a, None] * step[a])
        order = np.where((value > 0) == (f[0] > 0), [[1], [0]], [[0], [1]])
        x = np.concatenate([t[None, a], np.take_along_axis(x, order, axis=0)])
        f = np.concatenate([value[None], np.take_along_axis(f, order, axis=0)])
        change = _next_share(x, f) * (x[1] - x[0])
        t[a] += change
        moving = np.abs(change) > _SETTLED
        a, x, f = a[moving], x[:, moving], f[:, moving]
        if len(a) == 0:
            break
    return base + grid.spacing * np.clip(t, apart, 1 - apart)[:, None] * step


def _next_share(x: np.ndarray, f: np.ndarray) -> np.ndarray:
    """The next point (n,) on the way from x_0 (0) to x_1 (1), of points x and values f (3, n).

    It comes from inverse quadratic interpolation; where the interpolated inverse function is not
    monotone, it is the middle.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        xi, phi = (x[0] - x[1]) / (x[2] - x[1]), (f[0] - f[1]) / (f[2] - f[1])
        monotone = (1 - np.sqrt(1 - xi) < phi) & (phi < np.sqrt(xi))
        inverse = f[0] / (f[1] - f[0]) * f[2] / (f[1] - f[2])
        inverse += (x[2] - x[0]) / (x[1] - x[0]) * f[0] / (f[2] - f[0]) * f[1] / (f[2] - f[1])
    return np.where(f[0] == 0, 0.0, np.where(monotone, inverse, 0.5))


def _trimmed(
    points: np.ndarray,
    triangles: np.ndarray,
    cut: np.ndarray,
    near: np.ndarray | None,
    within: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Drop the triangles farther than a distance from all points."""
    if near is None:
        raise ValueError("within needs points near the surface; this body has none")
    far = _far_from(near, points, valid.as_length(within, "within"))
    left = triangles[~np.isin(triangles, far).any(axis=1)]
    used = np.zeros(len(points), dtype=bool)
    used[left] = True
    number = np.cumsum(used) - 1
    return points[used], number[left], number[cut[used[cut]]]


def _far_from(points: np.ndarray, x: np.ndarray, distance: float) -> np.ndarray:
    """Indices of x that are farther than a distance from all points."""
    found = cKDTree(points - x[0]).query(x - x[0], distance_upper_bound=distance, workers=-1)[0]
    return np.flatnonzero(np.isinf(found))


@dataclass(frozen=True)
class Grid:
    """A grid of nodes low + spacing (i, j, k).

    Attributes
    ----------
    low : (3,) ndarray
    spacing : float
    shape : tuple of int
        Numbers of nodes along the axes.
    """

    low: np.ndarray
    spacing: float
    shape: tuple[int, ...]

    @classmethod
    def over(cls, box: np.ndarray, spacing: float) -> Grid:
        """Return a grid that extends beyond the box by a cell and a half on each side."""
        counts = np.ceil((box[1] - box[0]) / spacing) + 4
        if counts.prod() > NODE_LIMIT:
            raise ValueError(
                f"spacing {spacing:.3g} would take {counts.prod():.2g} nodes in the box, and at "
                f"most {NODE_LIMIT:.2g} are allowed; take {_coarser(box, spacing):.3g} or more"
            )
        middle = (box[0] + box[1]) / 2
        return cls(middle - (counts - 1) / 2 * spacing, spacing, tuple(map(int, counts)))

    @property
    def cells(self) -> tuple[int, ...]:
        """Numbers of cells along the axes."""
        return tuple(n - 1 for n in self.shape)

    def nodes(self, index: np.ndarray) -> np.ndarray:
        """The nodes with indices (..., 3)."""
        return self.low + self.spacing * index

    def cells_of(self, x: np.ndarray) -> np.ndarray:
        """Flat indices of the cells that contain points (n, 3), without duplicates."""
        index = np.floor((x - self.low) / self.spacing).astype(np.int64)
        inside = ((index >= 0) & (index < self.cells)).all(axis=1)
        return np.unique(np.ravel_multi_index(tuple(index[inside].T), self.cells))

    def corners(self, cells: np.ndarray) -> np.ndarray:
        """Flat indices (n, 8) of the nodes of cells."""
        first = np.ravel_multi_index(np.unravel_index(cells, self.cells), self.shape)
        return first[:, None] + np.ravel_multi_index(tuple(_CORNERS.T), self.shape)


def follow_surface(
    solid: Solid, grid: Grid, seeds: np.ndarray, *, progress: Progress | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Values at nodes, NaN where not evaluated, and the cells that the surface crosses.

    The traversal goes from cell to cell through each face whose corners differ in sign. It follows
    a surface to its end, so the result is closed.
    """
    values = np.full(np.prod(grid.shape), np.nan, dtype=np.float32)
    seen = np.zeros(np.prod(grid.cells), dtype=bool)
    crossed, front, done = [np.empty(0, dtype=np.int64)], seeds, 0
    seen[front] = True
    while len(front):
        corners = grid.corners(front)
        new = np.unique(corners[np.isnan(values[corners])])
        values[new] = solid(grid.nodes(np.stack(np.unravel_index(new, grid.shape), axis=1)))
        done += len(new)
        if progress is not None:
            progress(done, max(done, len(seeds)))
        inside = values[corners] > 0
        cut = inside.any(axis=1) & ~inside.all(axis=1)
        crossed.append(front[cut])
        ahead = _across_faces(grid, front[cut], inside[cut])
        front = ahead[~seen[ahead]]
        seen[front] = True
    return values.reshape(grid.shape), np.concatenate(crossed)


def _across_faces(grid: Grid, cells: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """The neighbouring cells across the faces whose corners differ in sign."""
    index, found = np.stack(np.unravel_index(cells, grid.cells)), [np.empty(0, dtype=np.int64)]
    for axis, side in product(range(3), (0, 1)):
        face = inside[:, _CORNERS[:, axis] == side]
        cut = face.any(axis=1) & ~face.all(axis=1)
        beyond = index[:, cut]
        beyond[axis] += 2 * side - 1
        beyond = beyond[:, (beyond[axis] >= 0) & (beyond[axis] < grid.cells[axis])]
        found.append(np.ravel_multi_index(tuple(beyond), grid.cells))
    return np.unique(np.concatenate(found))


def search_box(solid: Solid, grid: Grid) -> np.ndarray:
    """Cells from which to follow the surface, found on a grid four times as coarse.

    A coarse cell is included if its corners differ in sign, or if the surface is nearer to its
    centre than its corners, to first order.
    """
    coarse = Grid(grid.low, _STRIDE * grid.spacing, tuple(-(-n // _STRIDE) + 1 for n in grid.cells))
    index = np.stack(np.meshgrid(*map(np.arange, coarse.shape), indexing="ij"), axis=-1)
    inside = (solid(coarse.nodes(index)) > 0).ravel()[
        coarse.corners(np.arange(np.prod(coarse.cells)))
    ]
    middles = coarse.nodes(index[:-1, :-1, :-1].reshape(-1, 3) + 0.5)
    slope = np.linalg.norm(solid.gradient(middles), axis=1)
    close = np.abs(solid(middles)) <= np.sqrt(3) / 2 * coarse.spacing * slope
    hit = close | (inside.any(axis=1) & ~inside.all(axis=1))
    first = _STRIDE * index[:-1, :-1, :-1].reshape(-1, 3)[hit]
    within = np.array(list(product(range(_STRIDE), repeat=3)))
    cells = (first[:, None] + within).reshape(-1, 3)
    cells = cells[(cells < grid.cells).all(axis=1)]
    return np.ravel_multi_index(tuple(cells.T), grid.cells)


def _coarser(box: np.ndarray, spacing: float) -> float:
    """A spacing of three digits that takes no more nodes than are allowed."""
    while (np.ceil((box[1] - box[0]) / spacing) + 4).prod() > NODE_LIMIT:
        spacing = float(f"{1.05 * spacing:.3g}")
    return spacing
