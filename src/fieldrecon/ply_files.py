"""PLY files: text or binary of either byte order, properties of any kind, faces and strips."""

from __future__ import annotations

from pathlib import Path
from typing import TypeAlias

import numpy as np

from fieldrecon._ply_rows import Bytes, Column, Element, Property, Words

_TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "float32": "f4",
    "float64": "f8",
}
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_LONGEST_HEADER = 2**20

Elements: TypeAlias = dict[str, dict[str, Column]]


def read_ply(path: str | Path) -> Elements:
    """Read all elements of a PLY file.

    Parameters
    ----------
    path : str or pathlib.Path

    Returns
    -------
    dict of str to dict
        Of each element its properties by name: an array of a number for each row, or, of lists,
        an array (rows, length) if they are equally long and else a list of arrays.

    Raises
    ------
    ValueError
        If it is no PLY file, or cut off: with its path.
    FileNotFoundError
        If there is no such file.

    References
    ----------
    Turk, The PLY polygon file format (1994).
    """
    content = Path(path).read_bytes()
    try:
        order, elements, body = _header(content)
        source = Words(content[body:]) if order == "" else Bytes(content, body, order)
        return {element.name: source.read(element) for element in elements}
    except ValueError as error:
        raise ValueError(f"{path} cannot be read as PLY: {error}") from None


def triangles_of(elements: Elements) -> np.ndarray:
    """Triangles (m, 3) of the faces, cut into fans, and of the strips, in which -1 ends a strip."""
    parts = [np.empty((0, 3), dtype=np.intp)]
    for lists in elements.get("face", {}).values():
        faces = lists if isinstance(lists, list) else [lists] * (np.ndim(lists) == 2)
        parts += [fans(np.atleast_2d(face)) for face in faces]
    for lists in elements.get("tristrips", {}).values():
        strips = lists if isinstance(lists, list) else list(np.atleast_2d(lists))
        parts += [_of_strip(np.asarray(strip, dtype=np.intp)) for strip in strips]
    return np.concatenate(parts)


def fans(polygons: np.ndarray) -> np.ndarray:
    """Triangles (m, 3) of convex polygons (k, corners): all from the first corner."""
    corners = polygons.shape[1]
    cut = [polygons[:, [0, k, k + 1]] for k in range(1, corners - 1)]
    return np.concatenate([np.empty((0, 3), dtype=np.intp), *cut]).astype(np.intp)


def _of_strip(strip: np.ndarray) -> np.ndarray:
    """Triangles of successive corners, every second one turned round."""
    ends = np.flatnonzero(strip < 0)
    begins = np.concatenate([[0], ends + 1])
    place = np.arange(len(strip)) - begins[np.searchsorted(ends, np.arange(len(strip)))]
    windows = (
        np.lib.stride_tricks.sliding_window_view(strip, 3)
        if len(strip) > 2
        else (np.empty((0, 3), dtype=np.intp))
    )
    odd = place[: len(windows)] % 2 == 1
    turned = np.where(odd[:, None], windows[:, [1, 0, 2]], windows)
    a, b, c = turned.T
    return turned[(windows >= 0).all(axis=1) & (a != b) & (b != c) & (c != a)]


def _header(content: bytes) -> tuple[str, list[Element], int]:
    """Byte order, what there is, and where it begins."""
    if not content.startswith(b"ply"):
        raise ValueError("it does not begin with the word ply")
    end = content.find(b"end_header", 0, _LONGEST_HEADER)
    body = content.find(b"\n", end) + 1
    if end < 0 or body == 0:
        raise ValueError("its header has no end")
    order, elements = None, []
    for line in content[:end].decode("latin-1").splitlines()[1:]:
        words = line.split()
        match words:
            case ["format", name, *_] if name in _ORDERS:
                order = _ORDERS[name]
            case ["element", name, rows] if rows.isdecimal():
                elements.append(Element(name, int(rows)))
            case ["property", "list", count, kind, name] if {count, kind} <= {*_TYPES} and elements:
                elements[-1].properties.append(Property(name, _TYPES[kind], _TYPES[count]))
            case ["property", kind, name] if kind in _TYPES and elements:
                elements[-1].properties.append(Property(name, _TYPES[kind]))
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise ValueError(f"its header has the line {line.strip()!r}")
    if order is None:
        raise ValueError("its header names no format")
    return order, elements, body
