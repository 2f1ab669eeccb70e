"""Texts in the encodings in use: UTF-8, UTF-16 and UTF-32, with or without a mark, and Latin-1."""

from __future__ import annotations

import codecs
import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

_HEAD = 4096  # bytes from which the encoding is recognized
_MARKS = {
    codecs.BOM_UTF32_LE: "utf-32",
    codecs.BOM_UTF32_BE: "utf-32",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
_NO_TEXTS = {
    b"PK\x03\x04": "a spreadsheet or another zip archive; save the table as CSV",
    b"\xd0\xcf\x11\xe0": "a spreadsheet of an old form; save the table as CSV",
    b"\x1f\x8b": "compressed; unpack it first, for example by gunzip",
    b"\x89HDF": "NetCDF or HDF5; open it with xarray, and give the data set to "
    "fieldrecon.pipelines.reconstruct",
    b"CDF": "NetCDF; open it with xarray, and give the data set to "
    "fieldrecon.pipelines.reconstruct",
    b"%PDF": "a PDF; export the table as CSV",
}
"""What a file is that begins with these bytes, and what to do."""


@contextmanager
def open_text(path: Path) -> Iterator[TextIO]:
    """Open a text; every line ends with a line feed.

    Bytes that are not UTF-8 are escaped, and `legible` takes them for Latin-1.

    Raises
    ------
    ValueError
        If the file is not a text: with what it is, and what to do.
    """
    with path.open("rb") as file:
        encoding = _encoding(path, file.read(_HEAD))
        file.seek(0)
        errors = "surrogateescape" if encoding == "utf-8-sig" else "replace"
        yield io.TextIOWrapper(file, encoding, errors, newline=None)


def _encoding(path: Path, head: bytes) -> str:
    for mark, encoding in _MARKS.items():
        if head.startswith(mark):
            return encoding
    for begin, meaning in _NO_TEXTS.items():
        if head.startswith(begin):
            raise ValueError(f"{path} is {meaning}")
    even, odd = head[::2].count(0), head[1::2].count(0)
    if max(even, odd) > len(head) / 4 and min(even, odd) < max(even, odd) / 8:
        return "utf-16-le" if odd > even else "utf-16-be"
    if b"\0" not in head.partition(b"\n")[0]:
        return "utf-8-sig"
    raise ValueError(f"{path} is not a text: it holds bytes of zero; save the table as CSV")


def legible(text: str) -> str:
    """The text, taken for Latin-1 (as Windows has it) if it is not UTF-8.

    Examples
    --------
    >>> legible("Höhe".encode("latin-1").decode("utf-8", "surrogateescape"))
    'Höhe'
    """
    if text.isascii():
        return text
    try:
        text.encode()
    except UnicodeEncodeError:
        return text.encode("utf-8", "surrogateescape").decode("cp1252", "replace")
    return text


def bytes_read(text: TextIO) -> tuple[int, int]:
    """Number of bytes that were read from the file of a text, and its size."""
    return text.buffer.tell(), os.fstat(text.fileno()).st_size
