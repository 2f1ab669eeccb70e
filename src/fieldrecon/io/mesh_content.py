"""What a file of a mesh or of a point cloud holds, before it is checked: points, cells, data."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fieldrecon.triangles.duplicates import merged_vertices

_KINDS = {0: "empty", 1: "vertex", 2: "line", 3: "triangle", 4: "quad"}
_FACES = ("triangle", "quad", "polygon")
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

    def fan_triangles(self) -> np.ndarray:
        """Triangles (m, 3) of all faces: those of a polygon share its first corner."""
        fans = [_fan(cells) for kind, cells in self.cells if kind in _FACES and len(cells)]
        return np.concatenate([np.empty((0, 3), dtype=np.intp), *fans])

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


def _block(faces: np.ndarray) -> CellBlock:
    return _KINDS.get(faces.shape[1], "polygon"), faces.astype(np.intp)


def _fan(polygons: np.ndarray) -> np.ndarray:
    """Triangles (m, 3) of convex polygons (k, corners), polygon by polygon."""
    fans = [polygons[:, [0, k, k + 1]] for k in range(1, polygons.shape[1] - 1)]
    return np.stack(fans, axis=1).reshape(-1, 3).astype(np.intp)
