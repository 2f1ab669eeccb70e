"""Triangles on the surface of a body, by marching cubes and Newton steps.

The cells of a grid that a surface goes through, found from some of them by following it.
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
from fieldrecon.polynomials import EPS
from fieldrecon.solids.constructive import Solid, as_box, intersection
from fieldrecon.solids.shapes import Box
from fieldrecon.triangles.audit import MeshAudit, audit_mesh

__all__ = ["ExtractedSurface", "extract_surface"]

_CELLS = 64  # along the longest side of the box, where nobody says how fine
_STEPS = 60  # each either a Newton step or the middle of what is left
_SETTLED = 1e-9  # of an edge: a vertex that moves less has arrived
_SPECK = 3  # cells: a part of the surface that extends less says nothing
_ROUNDINGS = 64  # of the largest coordinate, if these are more
_APART = 1e-6  # of an edge: what vertices keep from its ends


@dataclass(frozen=True, eq=False)
class ExtractedSurface:
    """Triangles on the surface of a body, seen anticlockwise from outside.

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
        Vertices on the wall of the box: there the surface would have gone on.
    missed : (k,) ndarray of int
        Those of the points `near` that no vertex is within two cells of.
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
        """What is wrong with the triangles; `audit.clean` where nothing is."""
        return audit_mesh(self.points, self.triangles)

    @property
    def area(self) -> float:
        """Sum of the areas of the triangles."""
        return float(np.linalg.norm(self._twice_areas(), axis=1).sum() / 2)

    @property
    def volume(self) -> float:
        """Volume that they enclose, positive if they are oriented outward."""
        corner = self.points[self.triangles[:, 0]] - self.points[0]
        return float(np.einsum("ij,ij->", corner, self._twice_areas()) / 6)

    def _twice_areas(self) -> np.ndarray:
        a, b, c = self.points[self.triangles].swapaxes(0, 1)
        return np.cross(b - a, c - a)


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

    Marching cubes joins the edges of a grid whose ends differ in sign; on each such edge the vertex
    is led to F = 0 by Newton steps. Cells are looked at only where the surface is: from those that
    contain points near it, it is followed through the faces that it crosses, to its end. It comes
    out closed, oriented and without self-intersections, whatever the field. Sharp edges are cut
    off by less than a cell, what is thinner than a cell may be lost, and parts of the surface that
    extend over less than three cells are left out.

    Parameters
    ----------
    solid : Solid
        The body; `as_solid` makes one of a field.
    spacing : float, optional
        Edge of the cells; by default that of the points that the body was made from, else the 64th
        part of the longest side of the box.
    near : (n, 3) array_like, optional
        Points near the surface; by default those of the body, and without any the whole box is
        searched, where parts smaller than four cells may be missed.
    box : (2, 3) array_like, optional
        Where; by default the box of the body. What would go beyond is closed by its walls.
    within : float, optional
        Leave out triangles that are farther from the points `near`: there the surface is invented.
        It has a rim then.
    progress : callable, optional
        Called as progress(done, total) with numbers of nodes; the total grows with the surface.

    Returns
    -------
    ExtractedSurface
        Points, triangles, and what is to be said about them.

    Raises
    ------
    ValueError
        If there is no surface in the box, or the grid would be too fine for it.
    ImportError
        If scikit-image is missing.

    References
    ----------
    Lorensen and Cline, Marching cubes (1987); Bloomenthal, Polygonization of implicit surfaces
    (1988), for following; Wendland (2005), section 1.1.

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
    if spacing is None:
        spacing = solid.spacing or float((room[1] - room[0]).max()) / _CELLS
    grid = Grid.over(room, valid.as_length(spacing, "spacing"))
    wall = Box(room[1] - room[0] + 2 * spacing, (room[0] + room[1]) / 2)
    closed = intersection(solid, wall)
    given = solid.near if near is None else valid.as_points(near, "near")
    seeds = searched(closed, grid) if given is None else grid.cells_of(given)
    values, crossed = followed(closed, grid, seeds, progress)
    if len(crossed) == 0:
        raise ValueError(
            "the body has no surface in the box, or none near the points: F has one sign there"
        )
    ends, triangles = _marched(values, crossed, grid)
    ends, triangles = _without_specks(ends, triangles)
    points = _on_edges(closed, grid, ends, values)
    cut = np.flatnonzero(np.abs(wall(points)) <= 1e-3 * spacing)
    missed = np.empty(0, np.intp) if given is None else _far_from(points, given, 2 * spacing)
    if within is not None:
        points, triangles, cut = _trimmed(points, triangles, cut, given, within)
    return ExtractedSurface(points, triangles, solid, spacing, cut, missed)


def _marched(
    values: np.ndarray, crossed: np.ndarray, grid: Grid
) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray]:
    """Lower ends (n, 3) and axes (n,) of the edges that bear vertices, and the triangles."""
    measure = optional("skimage.measure")
    mask = np.zeros(grid.shape, dtype=bool)
    mask.ravel()[grid.corners(crossed)[:, -1]] = True
    # of signs alone: each vertex comes to the middle of its edge, which names the edge exactly
    signs = np.where(values > 0, np.float32(1), np.float32(-1))
    middle, triangles, _, _ = measure.marching_cubes(
        signs, 0.0, mask=mask, method="lorensen", gradient_direction="ascent"
    )
    lower = np.floor(middle).astype(np.int64)
    return (lower, (middle - lower).argmax(axis=1)), triangles.astype(np.intp)


def _without_specks(
    ends: tuple[np.ndarray, np.ndarray], triangles: np.ndarray
) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray]:
    """What is left without the parts of two cells or less, but for the largest."""
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
    """Zeros of F on edges: Newton steps, and the middle of the bracket where one would leave it."""
    lower, axis = ends
    step = np.eye(3, dtype=np.int64)[axis]
    start = values[tuple(lower.T)].astype(float)
    end = values[tuple((lower + step).T)].astype(float)
    base, sign = grid.nodes(lower), np.where(start > 0, 1.0, -1.0)
    low, high = np.zeros(len(base)), np.ones(len(base))
    t = start / (start - end)
    apart = max(_APART, _ROUNDINGS * EPS * float(np.abs(base).max()) / grid.spacing)
    active = np.arange(len(base))
    for _ in range(_STEPS):
        a, k = active, axis[active]
        x = base[a] + grid.spacing * t[a, None] * step[a]
        f = solid(x)
        slope = grid.spacing * solid.gradient(x)[np.arange(len(a)), k]
        before = sign[a] * f > 0
        low[a], high[a] = np.where(before, t[a], low[a]), np.where(before, high[a], t[a])
        newton = t[a] - np.divide(f, slope, out=np.full(len(a), np.inf), where=slope != 0)
        settled = np.abs(newton - t[a]) < _SETTLED
        inside = settled | ((newton > low[a]) & (newton < high[a]))
        t[a] = np.where(inside, newton, (low[a] + high[a]) / 2)
        settled |= high[a] - low[a] < _SETTLED
        active = a[~settled]
        if len(active) == 0:
            break
    return base + grid.spacing * np.clip(t, apart, 1 - apart)[:, None] * step


def _trimmed(
    points: np.ndarray,
    triangles: np.ndarray,
    cut: np.ndarray,
    near: np.ndarray | None,
    within: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What is within a distance of the points."""
    if near is None:
        raise ValueError("within needs points near the surface; this body has none")
    far = _far_from(near, points, valid.as_length(within, "within"))
    left = triangles[~np.isin(triangles, far).any(axis=1)]
    used = np.zeros(len(points), dtype=bool)
    used[left] = True
    number = np.cumsum(used) - 1
    return points[used], number[left], number[cut[used[cut]]]


def _far_from(points: np.ndarray, x: np.ndarray, distance: float) -> np.ndarray:
    """Which of x are farther than a distance from all of the points."""
    found = cKDTree(points - x[0]).query(x - x[0], distance_upper_bound=distance, workers=-1)[0]
    return np.flatnonzero(np.isinf(found))


NODE_LIMIT = 2**28
"""Nodes of a grid at the most: 10 bytes each."""

_CORNERS = np.array(list(product((0, 1), repeat=3)))
_STRIDE = 4  # cells along the edge of a coarse cell


@dataclass(frozen=True)
class Grid:
    """Nodes low + spacing (i, j, k).

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
        """The grid that reaches beyond the box by a cell and a half on each side."""
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
        """Points of indices (..., 3)."""
        return self.low + self.spacing * index

    def cells_of(self, x: np.ndarray) -> np.ndarray:
        """Flat indices of the cells that contain points (n, 3), each once."""
        index = np.floor((x - self.low) / self.spacing).astype(np.int64)
        inside = ((index >= 0) & (index < self.cells)).all(axis=1)
        return np.unique(np.ravel_multi_index(tuple(index[inside].T), self.cells))

    def corners(self, cells: np.ndarray) -> np.ndarray:
        """Flat indices (n, 8) of the nodes of cells."""
        first = np.ravel_multi_index(np.unravel_index(cells, self.cells), self.shape)
        return first[:, None] + np.ravel_multi_index(tuple(_CORNERS.T), self.shape)


def followed(
    solid: Solid, grid: Grid, seeds: np.ndarray, progress: Progress | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Values at nodes, NaN where none was needed, and the cells the surface goes through.

    From cell to cell through each face whose corners differ in sign: a surface that is entered is
    followed to its end, so that it is closed.
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
        ahead = _through_faces(grid, front[cut], inside[cut])
        front = ahead[~seen[ahead]]
        seen[front] = True
    return values.reshape(grid.shape), np.concatenate(crossed)


def _through_faces(grid: Grid, cells: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Cells beyond the faces whose corners differ in sign."""
    index, found = np.stack(np.unravel_index(cells, grid.cells)), [np.empty(0, dtype=np.int64)]
    for axis, side in product(range(3), (0, 1)):
        face = inside[:, _CORNERS[:, axis] == side]
        cut = face.any(axis=1) & ~face.all(axis=1)
        beyond = index[:, cut]
        beyond[axis] += 2 * side - 1
        beyond = beyond[:, (beyond[axis] >= 0) & (beyond[axis] < grid.cells[axis])]
        found.append(np.ravel_multi_index(tuple(beyond), grid.cells))
    return np.unique(np.concatenate(found))


def searched(solid: Solid, grid: Grid) -> np.ndarray:
    """Cells from which all of the surface is found that a grid four times as coarse meets.

    A coarse cell counts if its corners differ in sign, or if the surface is nearer to its middle
    than its corners, to first order.
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
    while (np.ceil((box[1] - box[0]) / spacing) + 4).prod() > NODE_LIMIT:
        spacing *= 1.05
    return spacing
