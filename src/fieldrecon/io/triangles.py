"""Triangles in files as they stand there, nothing welded and nothing left out."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core.extras import optional
from fieldrecon.io.meshes import read_surface
from fieldrecon.triangles.audit import as_surface

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER, _COUNT = 80, 4
_BLOCK = 2**24
_PACKAGES = {".stl": ()} | dict.fromkeys((".ply", ".obj", ".off"), ("meshio",))
_VERTEX = re.compile(rb"^\s*vertex\s+(\S+)\s+(\S+)\s+(\S+)\s*$", re.M | re.I)
_FACET = re.compile(rb"^\s*facet\b", re.M | re.I)


def read_triangles(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Read the triangles of a surface in space, errors and all.

    Parameters
    ----------
    path : str or pathlib.Path
        .stl, binary or ASCII, is read here: each triangle keeps vertices of its own, and the
        normals in the file are left aside. Other suffixes are those of `read_surface`.

    Returns
    -------
    points : (n, 3) ndarray
        In single precision where the file is.
    triangles : (m, 3) ndarray of int

    Raises
    ------
    ValueError
        If the file cannot be read as triangles: with its path.
    FileNotFoundError
        If there is no such file.

    References
    ----------
    3D Systems, StereoLithography Interface Specification (1989).
    """
    if Path(path).suffix.lower() != ".stl":
        return read_surface(path)
    content = Path(path).read_bytes()
    corners = _binary(content)
    if corners is None:
        corners = _ascii(path, content)
    if len(corners) == 0:
        raise ValueError(f"{path} holds no triangles")
    if not np.isfinite(corners).all():
        raise ValueError(f"{path} holds coordinates that are not finite")
    return corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)


def write_triangles(path: str | Path, points: ArrayLike, triangles: ArrayLike) -> None:
    """Write triangles in space to a file.

    Parameters
    ----------
    path : str or pathlib.Path
        .stl is written binary, in single precision; .ply, .obj and .off through meshio.
    points : (n, 3) array_like
    triangles : (m, 3) array_like of int

    Raises
    ------
    ValueError
        If the format is unknown, or these are no triangles in space.
    ModuleNotFoundError
        If the format takes meshio, which is not installed.

    Examples
    --------
    >>> import tempfile
    >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "two.stl"
    ...     write_triangles(path, corners, [[0, 1, 2], [0, 3, 1]])
    ...     points, triangles = read_triangles(path)
    >>> len(points), triangles.tolist()
    (6, [[0, 1, 2], [3, 4, 5]])
    """
    p, t = as_surface(points, triangles)
    if packages_to_write(path):
        optional("meshio").write_points_cells(str(path), p, [("triangle", t.astype(np.int32))])
    else:
        Path(path).write_bytes(_as_binary(p[t]))


def packages_to_write(path: str | Path) -> tuple[str, ...]:
    """Return the optional packages that `write_triangles` takes for a file of this name.

    Raises
    ------
    ValueError
        If the format is unknown.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in _PACKAGES:
        raise ValueError(f"{path} must end with .stl, .ply, .obj or .off")
    return _PACKAGES[suffix]


def _binary(content: bytes) -> np.ndarray | None:
    """Corners (m, 3, 3) if the length is that of a binary file, whatever its first word."""
    if len(content) < _HEADER + _COUNT:
        return None
    count = int.from_bytes(content[_HEADER : _HEADER + _COUNT], "little")
    if len(content) != _HEADER + _COUNT + count * _RECORD.itemsize:
        return None
    return np.frombuffer(content, _RECORD, count, _HEADER + _COUNT)["corners"].copy()


def _ascii(path: str | Path, content: bytes) -> np.ndarray:
    if not content.lstrip()[:5].lower() == b"solid":
        raise ValueError(
            f"{path} is no STL file: it does not begin with solid, and its length is not that of "
            "as many triangles as it announces"
        )
    parts, facets = [], 0
    for block in _blocks(content):
        facets += len(_FACET.findall(block))
        try:
            parts.append(np.array(_VERTEX.findall(block), dtype=bytes).astype(float).reshape(-1, 3))
        except ValueError:
            raise ValueError(f"{path} holds a vertex whose coordinates are no numbers") from None
    vertices = np.concatenate(parts)
    if len(vertices) != 3 * facets:
        raise ValueError(
            f"{path} is broken: it begins {facets} facets and holds {len(vertices)} vertices"
        )
    return vertices.reshape(-1, 3, 3)


def _blocks(content: bytes) -> Iterator[bytes]:
    """Yield the content in pieces that end with a line."""
    start = 0
    while start < len(content):
        end = content.find(b"\n", start + _BLOCK) + 1 or len(content)
        yield content[start:end]
        start = end


def _as_binary(corners: np.ndarray) -> bytes:
    records = np.zeros(len(corners), dtype=_RECORD)
    records["corners"] = corners
    a, b, c = corners.swapaxes(0, 1)
    normal = np.cross(b - a, c - a)
    length = np.sqrt(np.einsum("ki,ki->k", normal, normal))[:, None]
    records["normal"] = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
    return bytes(_HEADER) + len(corners).to_bytes(_COUNT, "little") + records.tobytes()
