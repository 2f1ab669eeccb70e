"""OBJ files (Wavefront): vertices, their normals, and faces."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fieldrecon.io.mesh_content import MeshContent, face_blocks


def read_obj(path: str | Path) -> MeshContent:
    """Read an OBJ file; texture coordinates, groups and materials are ignored.

    Returns
    -------
    MeshContent
        With the data "normals" if there is one normal for each vertex.

    Raises
    ------
    ValueError
        If a line cannot be read: with its number.
    FileNotFoundError
        If there is no such file.
    """
    vertices: list[list[float]] = []
    normals: list[list[float]] = []
    faces: list[np.ndarray] = []
    for number, line in enumerate(Path(path).read_bytes().splitlines(), 1):
        kind, _, rest = line.strip().partition(b" ")
        try:
            if kind == b"v":
                vertices.append([float(word) for word in rest.split()[:3]])
            elif kind == b"vn":
                normals.append([float(word) for word in rest.split()[:3]])
            elif kind == b"f":
                corners = [int(word.split(b"/")[0]) for word in rest.split()]
                # from 1 on; negative numbers count back from the last vertex
                faces.append(np.array([c - 1 if c > 0 else len(vertices) + c for c in corners]))
        except ValueError:
            raise ValueError(f"{path}, line {number}: {line.decode('latin-1')!r}") from None
    if any(len(row) < 3 for row in (*vertices, *normals)):
        raise ValueError(f"{path} holds a vertex with fewer than three coordinates")
    one_each = normals and len(normals) == len(vertices)
    return MeshContent(
        np.array(vertices, dtype=float).reshape(-1, 3),
        face_blocks(faces),
        {"normals": np.array(normals)} if one_each else {},
    )
