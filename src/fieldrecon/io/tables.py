"""Columns of numbers from a table of millions of rows: text, NPZ or Parquet.

A row that is not what the header promises is left out, and told with its line and the reason; the
others stay.

Tables in text files, read in blocks of lines, each all at once where its lines are regular.

What is wanted of a table: some columns, and rows whose numbers are numbers.

Which columns of a table hold coordinates and value: those named, else those of usual names.
"""

from __future__ import annotations

import csv
import io
import math
import os
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple, TypeAlias

import numpy as np

from fieldrecon._core.chunks import Progress
from fieldrecon._core.extras import optional

PARQUET_ROWS = 2**18


@dataclass(frozen=True, eq=False)
class Table:
    """Wanted columns of a table.

    Parameters
    ----------
    names : list of str
    numbers : ndarray of shape (n, columns)
        Of the good rows, in their order.
    bad : list of BadRow
    """

    names: list[str]
    numbers: np.ndarray
    bad: list[BadRow]


def read_table(path: Path, wanted: Wanted, progress: Progress | None = None) -> Table:
    """Read columns from ``.npz`` (arrays by name), ``.parquet``, or from text of any other suffix.

    Cells of a text are separated by commas, semicolons, tabs or white space, whichever the first
    line has most of. Blank lines and lines that begin with ``#`` are passed over. Without a header
    (the first line is all numbers) the columns are x, y, z, column 4 and so on.

    Raises
    ------
    ValueError
        If the file is not such a table, or `wanted` does not find its columns.
    ImportError
        If it is Parquet and pyarrow is not installed.
    """
    routes = {".npz": _npz, ".parquet": _parquet, ".pq": _parquet}
    parts = list(routes.get(path.suffix.lower(), text_parts)(path, wanted, progress))
    if not any(len(numbers) + len(bad) for _, numbers, bad in parts):
        raise ValueError(f"{path} has no rows below its header")
    names, numbers, bad = zip(*parts, strict=True)
    return Table(names[0], np.concatenate(numbers), [row for rows in bad for row in rows])


def _npz(path: Path, wanted: Wanted, progress: Progress | None) -> Iterator[Part]:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
    except (ValueError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path} cannot be read as arrays: {error}") from None
    columns = dict(_columns_of(path, arrays))
    everything = [*columns]
    chosen = wanted.choose(everything)
    names = [everything[k] for k in chosen]
    lengths = {len(columns[name]) for name in names}
    if len(lengths) > 1:
        sizes = ", ".join(f"{name} {len(columns[name])}" for name in names)
        raise ValueError(f"{path}: the columns must be equally long; got {sizes}")
    yield _checked(wanted, names, np.column_stack([columns[name] for name in names]), 1)
    if progress:
        progress(1, 1)


def _columns_of(path: Path, arrays: dict[str, np.ndarray]) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the arrays of numbers as columns: `points` as x, y and z, `values` as value."""
    for name, array in arrays.items():
        if array.dtype.kind not in "biuf" or array.ndim not in (1, 2):
            continue
        if array.ndim == 1:
            yield ("value" if name == "values" else name), array
        elif name == "points" and array.shape[1] <= len(AXES):
            yield from zip(AXES, array.T, strict=False)
        else:
            raise ValueError(f"{path}: a column must be one number for each row; {name} is not")


def _parquet(path: Path, wanted: Wanted, progress: Progress | None) -> Iterator[Part]:
    parquet = optional("pyarrow.parquet")
    with path.open("rb") as stream:
        try:
            file = parquet.ParquetFile(stream)
        except ValueError as error:
            raise ValueError(f"{path} cannot be read as Parquet: {error}") from None
        everything = list(file.schema_arrow.names)
        names = [everything[k] for k in wanted.choose(everything)]
        done = 0
        for batch in file.iter_batches(PARQUET_ROWS, columns=names):
            try:
                columns = [batch[name].cast("float64").to_numpy(False) for name in names]
            except (ValueError, NotImplementedError) as error:
                raise ValueError(f"{path} must hold numbers in {names}: {error}") from None
            yield _checked(wanted, names, np.column_stack(columns), done + 1)
            done += len(columns[0])
            if progress:
                progress(done, file.metadata.num_rows)


def _checked(wanted: Wanted, names: list[str], numbers: np.ndarray, first: int) -> Part:
    """The good rows, and what is wrong with the others, counted from the first."""
    good = wanted.good(numbers)
    faults = [
        BadRow(first + int(i), wanted.fault(names, numbers[i].tolist()))
        for i in np.flatnonzero(~good)
    ]
    return names, numbers[good].astype(float, copy=False), faults


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
    """Yield the wanted columns of a text file, block by block."""
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


class BadRow(NamedTuple):
    """A row that was left out: its line, or its number where there are no lines, and the reason."""

    line: int
    reason: str


@dataclass(frozen=True)
class Wanted:
    """Which columns of a table are wanted, and how large their numbers may be.

    Parameters
    ----------
    choose : callable
        Takes the names of all columns to the places of the wanted ones.
    limits : sequence of float
        For each of these, the largest size of a number; infinity for none.
    """

    choose: Callable[[list[str]], Sequence[int]]
    limits: Sequence[float]

    def fault(self, names: Sequence[str], cells: Sequence[object]) -> str:
        """Say which of the wanted cells is no number, or too large; empty if none is."""
        for name, cell, limit in zip(names, cells, self.limits, strict=True):
            number = number_in(cell)
            if not math.isfinite(number):
                got = repr(cell.strip()) if isinstance(cell, str) else f"{cell}"
                return f"{name} must be a finite number; got {got}"
            if abs(number) > limit:
                return f"{name} must lie within ±{limit:g}; got {number:g}"
        return ""

    def good(self, numbers: np.ndarray) -> np.ndarray:
        """Tell which rows (n, k) have no fault."""
        with np.errstate(invalid="ignore"):
            inside = np.abs(numbers) <= np.asarray(self.limits)
        return (np.isfinite(numbers) & inside).all(axis=1)


Part: TypeAlias = tuple[list[str], np.ndarray, list[BadRow]]
"""Names of the wanted columns, the numbers of good rows, and the bad ones."""


def number_in(cell: object) -> float:
    """The number that a cell holds, or none; Python's 1_000 is not one."""
    try:
        return math.nan if isinstance(cell, str) and "_" in cell else float(cell)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return math.nan


_USUAL = {
    "x": ("x", "easting", "east", "lon", "long", "longitude"),
    "y": ("y", "northing", "north", "lat", "latitude"),
    "z": ("z", "height", "elevation", "depth", "altitude"),
    "value": ("value", "f", "v", "z", "h", "height", "elevation", "depth", "intensity"),
}


def chosen_columns(path: Path, columns: list[str], names: Mapping[str, str | None]) -> list[int]:
    """Find the columns of the coordinates and of the value."""
    for name in names.values():
        if name is not None and name not in columns:
            raise ValueError(f"{path} has no column {name!r}; it has {', '.join(columns)}")
    named = [columns.index(name) for name in names.values() if name is not None]
    found: dict[str, int | None] = {}
    for role, name in names.items():
        taken = {*named, *found.values()}
        usual = _usual(columns, _USUAL[role], taken)
        found[role] = columns.index(name) if name is not None else usual
    left = set(range(len(columns))) - set(found.values())
    if found["value"] is None and len(left) == 1:
        found["value"] = left.pop()
    for role, column in found.items():
        if column is None:
            raise ValueError(
                f"it is not clear which column of {path} to take; "
                f"name it with --{role}: {', '.join(columns)}"
            )
    chosen = [column for column in found.values() if column is not None]
    if len(set(chosen)) < len(chosen):
        raise ValueError("the coordinates and the value must be different columns")
    return chosen


def _usual(columns: list[str], usual: Sequence[str], taken: Iterable[int | None]) -> int | None:
    """Find the column of the most usual name, if any is left; units in brackets do not count."""
    taken = set(taken)
    bare = {bare_name(name): k for k, name in reversed([*enumerate(columns)]) if k not in taken}
    return next((bare[name] for name in usual if name in bare), None)


def bare_name(name: str) -> str:
    """Return the name of a column in lower case without its unit in brackets."""
    return name.lower().split("(")[0].split("[")[0].strip()


def csv_bytes(columns: Iterable[str], rows: Iterable[Iterable[Any]]) -> bytes:
    """Return header and rows as CSV, each float in the shortest form that reads back the same."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue().encode()
