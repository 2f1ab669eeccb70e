"""OBJ files (Wavefront): vertices, their normals, and faces."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fieldrecon.io.mesh_content import MeshContent, face_blocks


class _NoSuchVertex(ValueError):
    """A face has a number that no vertex has."""


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
    for number, line in _lines(Path(path).read_bytes()):
        kind, *words = line.split() or [b""]
        try:
            if kind == b"v":
                vertices.append([float(word) for word in words[:3]])
            elif kind == b"vn":
                normals.append([float(word) for word in words[:3]])
            elif kind == b"f":
                faces.append(_face([int(word.split(b"/")[0]) for word in words], len(vertices)))
        except ValueError as error:
            why = f": {error}" if isinstance(error, _NoSuchVertex) else ""
            raise ValueError(f"{path}, line {number}: {line.decode('latin-1')!r}{why}") from None
    if any(len(row) < 3 for row in (*vertices, *normals)):
        raise ValueError(f"{path} holds a vertex with fewer than three coordinates")
    one_each = normals and len(normals) == len(vertices)
    return MeshContent(
        np.array(vertices, dtype=float).reshape(-1, 3),
        face_blocks(faces),
        {"normals": np.array(normals)} if one_each else {},
    )


def _lines(content: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield each line and its number; a backslash at the end joins the next line to it."""
    begun = b""
    for number, line in enumerate(content.splitlines(), 1):
        if line.endswith(b"\\"):
            begun += line[:-1] + b" "
        else:
            yield number, begun + line
            begun = b""


def _face(corners: list[int], n: int) -> np.ndarray:
    """Vertices of a face, from 0; in the file from 1, and negative ones back from the last of n."""
    if 0 in corners:
        raise _NoSuchVertex("vertices are numbered from 1")
    if min(corners, default=0) < -n:
        raise _NoSuchVertex(f"there are {n} vertices before this line")
    return np.array([c - 1 if c > 0 else n + c for c in corners])
