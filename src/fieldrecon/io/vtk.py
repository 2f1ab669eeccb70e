"""Legacy VTK files of a field, in binary: ParaView and VisIt read them without a plug-in."""

from __future__ import annotations

import re
from pathlib import Path
from typing import BinaryIO

import numpy as np

from fieldrecon.io.targets import Targets, TargetValues, unused_name

_VERTEX, _TRIANGLE, _TETRAHEDRON = 1, 5, 10  # the numbers of VTK's cell types


def write_vtk(path: Path, result: TargetValues) -> None:
    """Write a rectilinear grid, or an unstructured grid of cells or of points."""
    targets = result.targets
    with path.open("wb") as file:
        file.write(b"# vtk DataFile Version 3.0\nfieldrecon\nBINARY\n")
        (_write_grid if targets.axes else _write_cells)(file, targets)
        file.write(f"POINT_DATA {len(targets.points)}\n".encode())
        taken: list[str] = []
        for name, column in result.columns.items():
            kind, dtype = ("int", ">i4") if column.dtype.kind == "i" else ("double", ">f8")
            word = unused_name(re.sub(r"\s+", "_", name.strip()) or "value", taken)
            file.write(f"SCALARS {word} {kind} 1\nLOOKUP_TABLE default\n".encode())
            _write_numbers(file, column, dtype)


def _write_grid(file: BinaryIO, targets: Targets) -> None:
    axes = [*targets.axes, *[np.zeros(1)] * (3 - len(targets.axes))]
    sizes = " ".join(str(len(axis)) for axis in axes)
    file.write(f"DATASET RECTILINEAR_GRID\nDIMENSIONS {sizes}\n".encode())
    for letter, axis in zip("XYZ", axes, strict=True):
        file.write(f"{letter}_COORDINATES {len(axis)} double\n".encode())
        _write_numbers(file, axis, ">f8")


def _write_cells(file: BinaryIO, targets: Targets) -> None:
    m, d = targets.points.shape
    cells = np.arange(m)[:, None] if targets.cells is None else targets.cells
    corners = cells.shape[1]
    kind = {1: _VERTEX, 3: _TRIANGLE, 4: _TETRAHEDRON}[corners]
    in_space = np.column_stack([targets.points, np.zeros((m, 3 - d))])
    file.write(f"DATASET UNSTRUCTURED_GRID\nPOINTS {m} double\n".encode())
    _write_numbers(file, in_space, ">f8")
    file.write(f"CELLS {len(cells)} {len(cells) * (corners + 1)}\n".encode())
    _write_numbers(file, np.insert(cells, 0, corners, axis=1), ">i4")
    file.write(f"CELL_TYPES {len(cells)}\n".encode())
    _write_numbers(file, np.full(len(cells), kind), ">i4")


def _write_numbers(file: BinaryIO, array: np.ndarray, dtype: str) -> None:
    file.write(np.ascontiguousarray(array, dtype=dtype).tobytes() + b"\n")
