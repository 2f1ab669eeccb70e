"""PLY files: text or binary of either byte order, properties of any kind, faces and strips.

Rows of the elements of a PLY file, with lists that may be long or short.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

import numpy as np

Column: TypeAlias = np.ndarray | list[np.ndarray]


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


@dataclass
class Property:
    """Numbers of a type, or lists of them, whose length has a type too."""

    name: str
    type: str
    count: str = ""


@dataclass
class Element:
    """An element that the header announces: its name, number of rows, and properties."""

    name: str
    rows: int
    properties: list[Property] = field(default_factory=list)


def _cut_off(element: Element, rows: int) -> ValueError:
    kind = {"vertex": "vertices", "face": "faces"}.get(element.name, f"rows of {element.name}")
    return ValueError(f"it is cut off: it announces {element.rows} {kind} and holds {rows}")


class Words:
    """The words of a text, taken one element after the other."""

    def __init__(self, body: bytes) -> None:
        try:
            self._words = np.array(body.split(), dtype=bytes).astype(float)
        except ValueError:
            raise ValueError("it holds a word that is no number") from None
        self._at = 0

    def read(self, element: Element) -> dict[str, Column]:
        """Properties of the next element."""
        lengths = self._lengths(element, self._at)
        width = len(element.properties) + sum(lengths.values())
        rest = self._words[self._at :]
        rows = min(element.rows, len(rest) // max(width, 1))
        table = rest[: rows * width].reshape(rows, width)
        columns: dict[str, Column] = {}
        at = 0
        for p in element.properties:
            if p.count:
                if (table[:, at] != lengths[p.name]).any() or rows < element.rows:
                    return self._row_by_row(element)
                columns[p.name] = table[:, at + 1 : at + 1 + lengths[p.name]].astype(p.type)
                at += 1 + lengths[p.name]
            else:
                columns[p.name] = table[:, at].astype(p.type)
                at += 1
        if rows < element.rows:
            raise _cut_off(element, rows)
        self._at += rows * width
        return columns

    def _lengths(self, element: Element, at: int) -> dict[str, int]:
        """Of the lists of the row that begins there."""
        lengths = {}
        for p in element.properties:
            if p.count and at < len(self._words):
                lengths[p.name] = int(self._words[at])
                at += lengths[p.name]
            elif p.count:
                lengths[p.name] = 0
            at += 1
        return lengths

    def _row_by_row(self, element: Element) -> dict[str, Column]:
        columns: dict[str, list[np.ndarray]] = {p.name: [] for p in element.properties}
        for row in range(element.rows):
            for p in element.properties:
                length = 1
                if p.count:
                    if self._at >= len(self._words):
                        raise _cut_off(element, row)
                    length = int(self._words[self._at])
                    self._at += 1
                values = self._words[self._at : self._at + length]
                if len(values) < length or length < 0:
                    raise _cut_off(element, row)
                columns[p.name].append(values.astype(p.type))
                self._at += length
        return _plain(element, columns)


class Bytes:
    """The bytes of a file, taken one element after the other."""

    def __init__(self, content: bytes, at: int, order: str) -> None:
        self._content, self._at, self._order = content, at, order

    def read(self, element: Element) -> dict[str, Column]:
        """Properties of the next element."""
        begin = self._at
        lengths = self._lengths(element)
        parts: list[tuple] = []
        for k, p in enumerate(element.properties):
            if p.count:
                parts.append((f"n{k}", self._order + p.count))
                parts.append((f"p{k}", self._order + p.type, (lengths[k],)))
            else:
                parts.append((f"p{k}", self._order + p.type))
        record = np.dtype(parts)
        rows = min(element.rows, (len(self._content) - begin) // max(record.itemsize, 1))
        table = np.frombuffer(self._content, record, rows, begin)
        self._at = begin + rows * record.itemsize
        if any((table[f"n{k}"] != length).any() for k, length in lengths.items()) or (
            lengths and rows < element.rows
        ):
            self._at = begin
            return self._row_by_row(element)
        if rows < element.rows:
            raise _cut_off(element, rows)
        return {p.name: table[f"p{k}"].astype(p.type) for k, p in enumerate(element.properties)}

    def _lengths(self, element: Element) -> dict[int, int]:
        """Of the lists of the next row."""
        at, lengths = self._at, {}
        for k, p in enumerate(element.properties):
            if p.count:
                count = np.dtype(self._order + p.count)
                some = self._content[at : at + count.itemsize]
                whole = len(some) == count.itemsize and element.rows > 0
                lengths[k] = max(0, int(np.frombuffer(some, count)[0])) if whole else 0
                at += count.itemsize
            at += np.dtype(p.type).itemsize * lengths.get(k, 1)
        return lengths

    def _row_by_row(self, element: Element) -> dict[str, Column]:
        columns: dict[str, list[np.ndarray]] = {p.name: [] for p in element.properties}
        for row in range(element.rows):
            for p in element.properties:
                length = int(self._take(p.count, 1, element, row)[0]) if p.count else 1
                columns[p.name].append(self._take(p.type, length, element, row).astype(p.type))
        return _plain(element, columns)

    def _take(self, kind: str, count: int, element: Element, row: int) -> np.ndarray:
        dtype = np.dtype(self._order + kind)
        if count < 0 or self._at + count * dtype.itemsize > len(self._content):
            raise _cut_off(element, row)
        self._at += count * dtype.itemsize
        return np.frombuffer(self._content, dtype, count, self._at - count * dtype.itemsize)


def _plain(element: Element, columns: dict[str, list[np.ndarray]]) -> dict[str, Column]:
    """Lists as they are, single numbers as one array."""
    return {
        p.name: columns[p.name] if p.count else np.concatenate([*columns[p.name], np.empty(0)])
        for p in element.properties
    }
