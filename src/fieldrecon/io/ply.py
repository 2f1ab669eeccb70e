"""PLY files: text or binary of either byte order, with faces and triangle strips.

An element, such as "vertex" or "face", is a table whose columns are numbers or lists of numbers.
A table whose lists are equally long is read at once, any other row by row.

References
----------
Turk, The PLY polygon file format (1994).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

import numpy as np

from fieldrecon.io.mesh_content import CellBlock, MeshContent, face_blocks

Column: TypeAlias = np.ndarray | list[np.ndarray]
Elements: TypeAlias = dict[str, dict[str, Column]]

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
_BYTE_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_MAX_HEADER = 2**20
_CORNERS = ("vertex_indices", "vertex_index")


def read_ply(path: str | Path) -> MeshContent:
    """Read the vertices, faces and triangle strips of a PLY file.

    Returns
    -------
    MeshContent
        The other properties of vertices are point data. Those of faces are cell data, unless
        there are also strips.

    Raises
    ------
    ValueError
        If the file is not a PLY file, is truncated, or has no vertices in space: with its path.
    FileNotFoundError
        If there is no such file.
    """
    elements = read_elements(path)
    vertices = elements.get("vertex", {})
    if not {"x", "y", "z"} <= {*vertices}:
        raise ValueError(f"{path} has no vertices with x, y and z")
    points = np.column_stack([np.asarray(vertices[name], dtype=float) for name in "xyz"])
    numeric = {k: v for k, v in vertices.items() if isinstance(v, np.ndarray) and k not in "xyz"}
    faces = elements.get("face", {})
    blocks = face_blocks(_corner_lists(faces))
    strips = _strip_blocks(elements.get("tristrips", {}))
    if strips:
        return MeshContent(points, [*blocks, *strips], numeric)
    ends = np.cumsum([len(cells) for _, cells in blocks])[:-1]
    cell_data = {
        name: np.split(column, ends)
        for name, column in faces.items()
        if isinstance(column, np.ndarray) and column.ndim == 1 and blocks
    }
    return MeshContent(points, blocks, numeric, cell_data)


def _corner_lists(faces: dict[str, Column]) -> Column:
    """Return the lists of corners among the properties of the faces."""
    lists = {k: v for k, v in faces.items() if isinstance(v, list) or v.ndim == 2}
    named = next((lists[name] for name in _CORNERS if name in lists), None)
    return named if named is not None else next(iter(lists.values()), [])


def _strip_blocks(strips: dict[str, Column]) -> list[CellBlock]:
    lists = next(iter(strips.values()), [])
    triangles = [_triangles_of_strip(np.asarray(strip, dtype=np.intp)) for strip in lists]
    return [("triangle", np.concatenate(triangles))] if triangles else []


def _triangles_of_strip(strip: np.ndarray) -> np.ndarray:
    """Triangles of three successive vertices, every second one reversed; -1 ends a strip."""
    if len(strip) < 3:
        return np.empty((0, 3), dtype=np.intp)
    ends = np.flatnonzero(strip < 0)
    starts = np.concatenate([[0], ends + 1])
    position = np.arange(len(strip)) - starts[np.searchsorted(ends, np.arange(len(strip)))]
    windows = np.lib.stride_tricks.sliding_window_view(strip, 3)
    odd = position[: len(windows)] % 2 == 1
    triangles = np.where(odd[:, None], windows[:, [1, 0, 2]], windows)
    a, b, c = triangles.T
    return triangles[(windows >= 0).all(axis=1) & (a != b) & (b != c) & (c != a)]


def read_elements(path: str | Path) -> Elements:
    """Read all elements of a PLY file.

    Returns
    -------
    dict of str to dict
        The properties of each element by name. A property of numbers is an array of shape
        (rows,). A property of lists is an array of shape (rows, length) if the lists are equally
        long, and a list of arrays otherwise.

    Raises
    ------
    ValueError
        If the file is not a PLY file, or is truncated: with its path.
    FileNotFoundError
        If there is no such file.
    """
    content = Path(path).read_bytes()
    try:
        order, elements, body = _parse_header(content)
        source = _TextBody(content[body:]) if order == "" else _BinaryBody(content, body, order)
        return {element.name: source.read(element) for element in elements}
    except ValueError as error:
        raise ValueError(f"{path} cannot be read as PLY: {error}") from None


@dataclass
class _Property:
    """A column of an element: the type of its numbers and, for lists, that of their lengths."""

    name: str
    type: str
    length_type: str = ""


@dataclass
class _Element:
    """An element that the header declares."""

    name: str
    rows: int
    properties: list[_Property] = field(default_factory=list)

    def truncated(self, rows: int) -> ValueError:
        """Return the error that only this number of rows is in the file."""
        kind = {"vertex": "vertices", "face": "faces"}.get(self.name, f"rows of {self.name}")
        return ValueError(f"it is truncated: it announces {self.rows} {kind} and holds {rows}")

    def columns(self, rows: dict[str, list[np.ndarray]]) -> dict[str, Column]:
        """Return rows that were read one by one as columns: lists, or an array of numbers."""
        return {
            p.name: rows[p.name] if p.length_type else np.concatenate([*rows[p.name], np.empty(0)])
            for p in self.properties
        }


def _parse_header(content: bytes) -> tuple[str, list[_Element], int]:
    """Return the byte order, the elements, and the offset of the first of them."""
    if not content.startswith(b"ply"):
        raise ValueError("it does not begin with the word ply")
    end = content.find(b"end_header", 0, _MAX_HEADER)
    body = content.find(b"\n", end) + 1
    if end < 0 or body == 0:
        raise ValueError("its header has no end")
    order, elements = None, []
    for line in content[:end].decode("latin-1").splitlines()[1:]:
        match line.split():
            case ["format", name, *_] if name in _BYTE_ORDERS:
                order = _BYTE_ORDERS[name]
            case ["element", name, rows] if rows.isdecimal():
                elements.append(_Element(name, int(rows)))
            case ["property", "list", count, kind, name] if {count, kind} <= {*_TYPES} and elements:
                elements[-1].properties.append(_Property(name, _TYPES[kind], _TYPES[count]))
            case ["property", kind, name] if kind in _TYPES and elements:
                elements[-1].properties.append(_Property(name, _TYPES[kind]))
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise ValueError(f"its header has the line {line.strip()!r}")
    if order is None:
        raise ValueError("its header names no format")
    return order, elements, body


class _TextBody:
    """The numbers of a text file, read one element after the other."""

    def __init__(self, body: bytes) -> None:
        try:
            self._words = np.array(body.split(), dtype=bytes).astype(float)
        except ValueError:
            raise ValueError("it holds a word that is not a number") from None
        self._position = 0

    def read(self, element: _Element) -> dict[str, Column]:
        """Read the next element, at once if its lists are as long as those of its first row."""
        lengths = self._first_lengths(element)
        width = len(element.properties) + sum(lengths.values())
        rest = self._words[self._position :]
        rows = min(element.rows, len(rest) // max(width, 1))
        table = rest[: rows * width].reshape(rows, width)
        columns: dict[str, Column] = {}
        k = 0
        for p in element.properties:
            if p.length_type:
                if (table[:, k] != lengths[p.name]).any() or rows < element.rows:
                    return self._read_row_by_row(element)
                columns[p.name] = table[:, k + 1 : k + 1 + lengths[p.name]].astype(p.type)
                k += 1 + lengths[p.name]
            else:
                columns[p.name] = table[:, k].astype(p.type)
                k += 1
        if rows < element.rows:
            raise element.truncated(rows)
        self._position += rows * width
        return columns

    def _first_lengths(self, element: _Element) -> dict[str, int]:
        """Return the lengths of the lists of the next row."""
        lengths, k = {}, self._position
        for p in element.properties:
            if p.length_type:
                lengths[p.name] = max(0, self._length(k)) if element.rows > 0 else 0
                k += lengths[p.name]
            k += 1
        return lengths

    def _length(self, position: int) -> int:
        """Return the length of the list that begins there, -1 if none does."""
        number = self._words[position] if position < len(self._words) else -1
        return int(number) if 0 <= number <= len(self._words) else -1

    def _read_row_by_row(self, element: _Element) -> dict[str, Column]:
        columns: dict[str, list[np.ndarray]] = {p.name: [] for p in element.properties}
        for row in range(element.rows):
            for p in element.properties:
                length = 1
                if p.length_type:
                    length = self._length(self._position)
                    self._position += 1
                values = self._words[self._position : self._position + length]
                if len(values) < length or length < 0:
                    raise element.truncated(row)
                columns[p.name].append(values.astype(p.type))
                self._position += length
        return element.columns(columns)


class _BinaryBody:
    """The bytes of a binary file, read one element after the other."""

    def __init__(self, content: bytes, position: int, order: str) -> None:
        self._content, self._position, self._order = content, position, order

    def read(self, element: _Element) -> dict[str, Column]:
        """Read the next element, at once if its lists are as long as those of its first row."""
        start = self._position
        lengths = self._first_lengths(element)
        record = np.dtype([*self._record_fields(element, lengths)])
        rows = min(element.rows, (len(self._content) - start) // max(record.itemsize, 1))
        table = np.frombuffer(self._content, record, rows, start)
        self._position = start + rows * record.itemsize
        if any((table[f"n{k}"] != length).any() for k, length in lengths.items()) or (
            lengths and rows < element.rows
        ):
            self._position = start
            return self._read_row_by_row(element)
        if rows < element.rows:
            raise element.truncated(rows)
        return {p.name: table[f"p{k}"].astype(p.type) for k, p in enumerate(element.properties)}

    def _record_fields(self, element: _Element, lengths: dict[int, int]) -> Iterator[tuple]:
        for k, p in enumerate(element.properties):
            if p.length_type:
                yield f"n{k}", self._order + p.length_type
                yield f"p{k}", self._order + p.type, (lengths[k],)
            else:
                yield f"p{k}", self._order + p.type

    def _first_lengths(self, element: _Element) -> dict[int, int]:
        """Return the lengths of the lists of the next row."""
        position, lengths = self._position, {}
        for k, p in enumerate(element.properties):
            if p.length_type:
                count = np.dtype(self._order + p.length_type)
                found = self._content[position : position + count.itemsize]
                whole = len(found) == count.itemsize and element.rows > 0
                lengths[k] = max(0, int(np.frombuffer(found, count)[0])) if whole else 0
                position += count.itemsize
            position += np.dtype(p.type).itemsize * lengths.get(k, 1)
        return lengths

    def _read_row_by_row(self, element: _Element) -> dict[str, Column]:
        columns: dict[str, list[np.ndarray]] = {p.name: [] for p in element.properties}
        for row in range(element.rows):
            for p in element.properties:
                length = int(self._take(p.length_type, 1, element, row)[0]) if p.length_type else 1
                columns[p.name].append(self._take(p.type, length, element, row).astype(p.type))
        return element.columns(columns)

    def _take(self, kind: str, count: int, element: _Element, row: int) -> np.ndarray:
        dtype = np.dtype(self._order + kind)
        if count < 0 or self._position + count * dtype.itemsize > len(self._content):
            raise element.truncated(row)
        self._position += count * dtype.itemsize
        return np.frombuffer(self._content, dtype, count, self._position - count * dtype.itemsize)
