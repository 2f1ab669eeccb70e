"""Tables in text files, read in blocks of lines, each all at once where its lines are regular."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from fieldrecon._chunks import Progress
from fieldrecon._wanted_columns import BadRow, Part, Wanted, number_in

BLOCK_BYTES = 2**23
LONGEST_HEADER = 2**20
AXES = ("x", "y", "z")


@dataclass(frozen=True)
class _Layout:
    """How the lines of a text are taken apart."""

    columns: list[str]
    separator: str | None
    chosen: list[int]
    wanted: Wanted

    @property
    def names(self) -> list[str]:
        return [self.columns[k] for k in self.chosen]

    def part(self, first: int, text: str) -> Part:
        """Numbers of a block of lines, the first of which has this number."""
        told = [(i, line) for i, line in enumerate(text.split("\n"), first) if _says(line)]
        numbers = self._quickly([line for _, line in told])
        if numbers is None:
            return self._line_by_line(told)
        good = self.wanted.good(numbers)
        again = [told[i] for i in np.flatnonzero(~good)]
        return self.names, numbers[good], self._line_by_line(again)[2]

    def _quickly(self, lines: list[str]) -> np.ndarray | None:
        """All lines at once, or None if some must be looked at one by one."""
        if not all(self._regular(line) for line in lines) or not lines:
            return None
        try:
            return np.loadtxt(
                lines, delimiter=self.separator, usecols=self.chosen, comments=None, ndmin=2
            )
        except ValueError:
            return None

    def _regular(self, line: str) -> bool:
        if self.separator is None:
            return len(line.split()) == len(self.columns)
        return line.count(self.separator) == len(self.columns) - 1 and '"' not in line

    def _line_by_line(self, told: list[tuple[int, str]]) -> Part:
        numbers, bad = [], []
        for number, line in told:
            cells = _cells(line, self.separator)
            wanted = [cells[k] for k in self.chosen] if len(cells) == len(self.columns) else None
            if wanted is None:
                heads = len(self.columns)
                fault = f"the header has {heads} cells and this row {len(cells)}"
            else:
                fault = self.wanted.fault(self.names, wanted)
            if fault:
                bad.append(BadRow(number, fault))
            else:
                numbers.append([float(cell) for cell in wanted or ()])
        return self.names, np.array(numbers).reshape(-1, len(self.chosen)), bad


def text_parts(path: Path, wanted: Wanted, progress: Progress | None) -> Iterator[Part]:
    with path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        line, header, start = _header(path, file)
        separator = max(",;\t", key=header.count)
        cut = separator if separator in header else None
        columns = [cell.strip() for cell in _cells(header, cut)]
        if all(math.isfinite(number_in(cell)) for cell in columns):
            columns = _unnamed(len(columns))
            file.seek(start)
        else:
            line += 1
        layout = _Layout(columns, cut, list(wanted.choose(columns)), wanted)
        while block := file.read(BLOCK_BYTES) + file.readline():
            yield layout.part(line, _decoded(path, block))
            line += block.count(b"\n")
            if progress:
                progress(file.tell(), size)


def _header(path: Path, file: BinaryIO) -> tuple[int, str, int]:
    """Number and text of the first line that says something, and where it begins."""
    start = 0
    for number, line in enumerate(iter(lambda: file.readline(LONGEST_HEADER), b""), 1):
        if b"\0" in line:
            raise ValueError(f"{path} is not a text: it holds bytes of zero")
        text = _decoded(path, line.removeprefix(b"\xef\xbb\xbf") if number == 1 else line)
        if _says(text):
            return number, text, start
        start = file.tell()
    raise ValueError(f"{path} is empty; a header such as x,y,value and rows were expected")


def _decoded(path: Path, block: bytes) -> str:
    try:
        return block.replace(b"\r\n", b"\n").decode()
    except UnicodeDecodeError as error:
        raise ValueError(f"{path} is not a text in UTF-8: {error.reason}") from None


def _says(line: str) -> bool:
    return bool(line.strip()) and line[0] != "#"


def _cells(line: str, separator: str | None) -> list[str]:
    if separator is None:
        return line.split()
    try:
        return next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    except (csv.Error, StopIteration):
        return []


def _unnamed(count: int) -> list[str]:
    return [*AXES, *(f"column {k}" for k in range(4, count + 1))][:count]
