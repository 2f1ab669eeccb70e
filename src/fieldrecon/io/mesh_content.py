"""What a file of a mesh or of a point cloud holds, before it is checked: points, cells, data."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fieldrecon._core.geometry import triangle_normals
from fieldrecon.triangles.duplicates import merged_vertices
from fieldrecon.triangles.holes import minimum_area_patches

_KINDS = {0: "empty", 1: "vertex", 2: "line", 3: "triangle", 4: "quad"}
_FACES = ("triangle", "quad", "polygon")
_TRIANGLE = 3
_TIE = 1e-6  # relative difference of areas that are taken as equal
CellBlock = tuple[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class MeshContent:
    """The content of a file, as a reader returns it.

    Parameters
    ----------
    points : ndarray of shape (n, d)
    cells : sequence of (str, ndarray of shape (c, corners))
        Blocks of cells of one kind, in the order of the file: "triangle", "tetra" and so on.
    point_data : dict of str to ndarray
        Arrays of n rows.
    cell_data : dict of str to list of ndarray
        An array for each block of cells.
    separate_corners : bool
        Whether each triangle has vertices of its own, as in STL.
    """

    points: np.ndarray
    cells: Sequence[CellBlock]
    point_data: dict[str, np.ndarray] = field(default_factory=dict)
    cell_data: dict[str, list[np.ndarray]] = field(default_factory=dict)
    separate_corners: bool = False

    @property
    def kinds(self) -> list[str]:
        """The kinds of cells that occur."""
        return sorted({kind for kind, cells in self.cells if len(cells)})

    def cells_of(self, kind: str) -> np.ndarray:
        """All cells (c, corners) of a kind that occurs."""
        return np.concatenate([cells for k, cells in self.cells if k == kind])

    def cell_data_of(self, kind: str, name: str) -> np.ndarray:
        """The rows of the data that belong to the cells of a kind."""
        blocks = zip(self.cells, self.cell_data[name], strict=True)
        return np.concatenate([values for (k, _), values in blocks if k == kind])

    @property
    def polygonal(self) -> bool:
        """Whether all cells are triangles, quads and polygons, and there are some."""
        return bool(self.kinds) and {*self.kinds} <= {*_FACES}

    def face_triangles(self) -> np.ndarray:
        """Triangles (m, 3) of all faces, in the order of the file."""
        parts = [
            divided(self.points, cells)
            for kind, cells in self.cells
            if kind in _FACES and len(cells)
        ]
        return np.concatenate([np.empty((0, 3), dtype=np.intp), *parts])

    def with_merged_vertices(self) -> MeshContent:
        """The same content with equal vertices merged, if each triangle has its own."""
        if not self.separate_corners:
            return self
        first = merged_vertices(self.points.astype(float))
        kept, number = np.unique(first, return_inverse=True)
        blocks = [(kind, number[cells]) for kind, cells in self.cells]
        return replace(self, points=self.points[kept], cells=blocks, separate_corners=False)


def face_blocks(faces: np.ndarray | Iterable[np.ndarray]) -> list[CellBlock]:
    """Cut a sequence of faces into blocks of successive ones with equally many corners."""
    if isinstance(faces, np.ndarray):
        return [_block(faces)]
    blocks: list[list[np.ndarray]] = []
    for face in faces:
        if not blocks or len(blocks[-1][-1]) != len(face):
            blocks.append([])
        blocks[-1].append(face)
    return [_block(np.array(block)) for block in blocks]


def require_vertices(source: object, triangles: np.ndarray, n: int) -> None:
    """Refuse triangles (m, 3) with a corner that is none of n vertices."""
    missing = np.flatnonzero(((triangles < 0) | (triangles >= n)).any(axis=1))
    if len(missing):
        first = int(missing[0])
        raise ValueError(
            f"{source}: triangle {first} has the corners {triangles[first].tolist()}, and the "
            f"vertices are numbered from 0 to {n - 1}"
        )


def _block(faces: np.ndarray) -> CellBlock:
    return _KINDS.get(faces.shape[1], "polygon"), faces.astype(np.intp)


def divided(points: np.ndarray, polygons: np.ndarray) -> np.ndarray:
    """Triangles (m, 3) of polygons (k, corners), polygon by polygon.

    Those of a polygon share its first corner, unless it is not convex: then other triangles have a
    smaller area, and those of the least area are taken.

    Examples
    --------
    >>> arrow = np.array([[0.0, 0, 0], [2, -1, 0], [1, 0, 0], [2, 1, 0]])
    >>> divided(arrow, np.array([[1, 2, 3, 0]])).tolist()
    [[1, 2, 0], [2, 3, 0]]
    """
    corners = polygons.shape[1]
    fan = np.array([[0, k, k + 1] for k in range(1, corners - 1)], dtype=np.intp).reshape(-1, 3)
    chosen = np.tile(fan, (len(polygons), 1, 1))
    if corners > _TRIANGLE and points.shape[1] == 3:
        at = points[polygons].astype(float)
        size = np.linalg.norm(triangle_normals(*at[:, fan].transpose(2, 0, 1, 3)), axis=-1)
        least, area = minimum_area_patches(at - at[:, :1])
        smaller = 2 * area < (1 - _TIE) * size.sum(axis=1)
        chosen[smaller] = least[smaller]
    rows = np.arange(len(polygons))[:, None, None]
    return polygons[rows, chosen].reshape(-1, 3).astype(np.intp)
