"""The cells of a grid that a surface goes through, found from some of them by following it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from fieldrecon._chunks import Progress
from fieldrecon.solids import Solid

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
