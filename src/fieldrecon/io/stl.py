"""STL files, binary and ASCII: triangles whose vertices are not shared.

References
----------
3D Systems, StereoLithography Interface Specification (1989).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fieldrecon._core.geometry import triangle_normals
from fieldrecon.io.mesh_content import MeshContent

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER_BYTES, _COUNT_BYTES = 80, 4
_BLOCK_BYTES = 2**24
_VERTEX = re.compile(rb"^\s*vertex\s+(\S+)\s+(\S+)\s+(\S+)\s*$", re.M | re.I)
_FACET = re.compile(rb"^\s*facet\b", re.M | re.I)


def read_stl(path: str | Path) -> MeshContent:
    """Read an STL file; the normals in the file are ignored.

    Returns
    -------
    MeshContent
        Three points for each triangle, in single precision if the file is binary.

    Raises
    ------
    ValueError
        If the file is not an STL file, or damaged: with its path.
    FileNotFoundError
        If there is no such file.
    """
    content = Path(path).read_bytes()
    corners = _corners_of_binary(content)
    if corners is None:
        corners = _corners_of_text(path, content)
    if len(corners) == 0:
        raise ValueError(f"{path} holds no triangles")
    if not np.isfinite(corners).all():
        raise ValueError(f"{path} holds coordinates that are not finite")
    triangles = np.arange(3 * len(corners)).reshape(-1, 3)
    return MeshContent(corners.reshape(-1, 3), [("triangle", triangles)], separate_corners=True)


def _corners_of_binary(content: bytes) -> np.ndarray | None:
    """Corners (m, 3, 3) if the file has the length of a binary one, whatever its header says."""
    if len(content) < _HEADER_BYTES + _COUNT_BYTES:
        return None
    count = int.from_bytes(content[_HEADER_BYTES : _HEADER_BYTES + _COUNT_BYTES], "little")
    start = _HEADER_BYTES + _COUNT_BYTES
    if len(content) != start + count * _RECORD.itemsize:
        return None
    return np.frombuffer(content, _RECORD, count, start)["corners"].copy()


def _corners_of_text(path: str | Path, content: bytes) -> np.ndarray:
    if content.lstrip()[:5].lower() != b"solid":
        raise ValueError(
            f"{path} is not an STL file: it does not begin with solid, and its length is not that "
            "of a binary file with the number of triangles in its header"
        )
    blocks, facets = [], 0
    for text in _line_blocks(content):
        facets += len(_FACET.findall(text))
        try:
            found = np.array(_VERTEX.findall(text), dtype=bytes)
            blocks.append(found.astype(float).reshape(-1, 3))
        except ValueError:
            raise ValueError(f"{path} holds a vertex whose coordinates are not numbers") from None
    vertices = np.concatenate(blocks)
    if len(vertices) != 3 * facets:
        raise ValueError(
            f"{path} is damaged: it begins {facets} facets and holds {len(vertices)} vertices"
        )
    return vertices.reshape(-1, 3, 3)


def _line_blocks(content: bytes) -> Iterator[bytes]:
    """Yield the content in blocks that end with a line."""
    start = 0
    while start < len(content):
        end = content.find(b"\n", start + _BLOCK_BYTES) + 1 or len(content)
        yield content[start:end]
        start = end


def stl_bytes(corners: np.ndarray) -> bytes:
    """Return the binary file of triangles with the corners (m, 3, 3), in single precision."""
    records = np.zeros(len(corners), dtype=_RECORD)
    records["corners"] = corners
    a, b, c = corners.swapaxes(0, 1)
    normal = triangle_normals(a, b, c)
    length = np.sqrt(np.einsum("ki,ki->k", normal, normal))[:, None]
    records["normal"] = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
    count = len(corners).to_bytes(_COUNT_BYTES, "little")
    return bytes(_HEADER_BYTES) + count + records.tobytes()
