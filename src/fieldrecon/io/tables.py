"""Tables of numbers with millions of rows: text, NPZ and Parquet, read by named columns.

A row with a missing, non-numeric or non-finite cell is skipped and reported with its line and the
reason. A text is read in blocks of lines; a block whose lines are regular is parsed at once. The
readers of pandas, polars and pyarrow do not report the lines of bad rows, and take one decimal sign
and one encoding that have to be named.
"""

from __future__ import annotations

import csv
import io
import math
import zipfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple, TextIO, TypeAlias

import numpy as np

from fieldrecon._core.chunks import Progress
from fieldrecon._core.extras import optional
from fieldrecon.io.column_names import AXES
from fieldrecon.io.number_formats import NumberFormat, is_number, parse_number
from fieldrecon.io.text_files import bytes_read, legible, open_text

PARQUET_ROWS = 2**18
BLOCK_SIZE = 2**23
"""Characters of a text that are parsed at once."""
LONGEST_HEADER = 2**20


class BadRow(NamedTuple):
    """A skipped row.

    Parameters
    ----------
    line : int
        Its line, or its number where a file has no lines.
    reason : str
        Why it was skipped.
    row : int
        Its position among all rows, from 0.
    """

    line: int
    reason: str
    row: int


@dataclass(frozen=True, eq=False)
class Table:
    """The columns that were read from a table.

    Parameters
    ----------
    names : list of str
    numbers : ndarray of shape (n, columns)
        The valid rows, in their order.
    bad : list of BadRow
        The skipped rows.
    """

    names: list[str]
    numbers: np.ndarray
    bad: list[BadRow]


@dataclass(frozen=True)
class ColumnSpec:
    """Which columns of a table to read, and what numbers they hold.

    Parameters
    ----------
    choose : callable
        Takes the names of all columns and returns the indices of those to read.
    limits : sequence of float, optional
        The largest absolute value in each of these columns; any finite number if not given.
    decimal : str, optional
        The decimal sign of a text, "." or ","; by default that of its numbers.
    missing : sequence of float
        Numbers that mark missing values; a row with one of them has no errors.
    """

    choose: Callable[[list[str]], Sequence[int]]
    limits: Sequence[float] | None = None
    decimal: str | None = None
    missing: Sequence[float] = ()

    def __post_init__(self) -> None:
        if self.decimal not in (None, ".", ","):
            raise ValueError(f"decimal must be '.' or ','; got {self.decimal!r}")

    def error(
        self,
        names: Sequence[str],
        cells: Sequence[object],
        parse: Callable[[object], float] = parse_number,
    ) -> str:
        """Return what is wrong with the cells of a row, or an empty string."""
        limits = self.limits or (math.inf,) * len(names)
        numbers = [parse(cell) for cell in cells]
        if not {*self.missing}.isdisjoint(numbers):
            return ""
        for name, cell, number, limit in zip(names, cells, numbers, limits, strict=True):
            if not math.isfinite(number):
                got = repr(cell.strip()) if isinstance(cell, str) else f"{cell}"
                return f"{name} must be a finite number; got {got}"
            if abs(number) > limit:
                return f"{name} must lie within ±{limit:g}; got {number:g}"
        return ""

    def valid_rows(self, numbers: np.ndarray) -> np.ndarray:
        """Return a mask (n,) of the rows (n, k) without errors."""
        finite: np.ndarray = np.isfinite(numbers)
        if self.limits is not None:
            with np.errstate(invalid="ignore"):
                finite &= np.abs(numbers) <= np.asarray(self.limits)
        valid: np.ndarray = np.all(finite, axis=1) | self.missing_rows(numbers)
        return valid

    def missing_rows(self, numbers: np.ndarray) -> np.ndarray:
        """Return a mask (n,) of the rows (n, k) with a number that marks a missing value."""
        marked: np.ndarray = np.isin(numbers, list(self.missing))
        return np.any(marked, axis=1)


Block: TypeAlias = tuple[list[str], np.ndarray, list[BadRow]]
"""The names of the columns, the numbers of valid rows, and the skipped rows."""


def read_table(path: Path, spec: ColumnSpec, progress: Progress | None = None) -> Table:
    """Read columns from ``.npz`` (arrays by name), ``.parquet``, or from text of any other suffix.

    Rows of missing data are skipped: null in Parquet, and where the array ``mask`` of a ``.npz``
    file is true.
    The cells of a text are separated by commas, semicolons, tabs or white space, whichever occurs
    most often in the first line. Blank lines and lines that begin with ``#`` are ignored. A text
    without a header (its first line is all numbers) has the columns x, y, z, column 4 and so on.
    See `fieldrecon.io.text_files` for encodings, and `fieldrecon.io.number_formats` for numbers.

    Raises
    ------
    ValueError
        If the file is not such a table, or `spec` does not find its columns.
    ImportError
        If the file is Parquet and pyarrow is not installed.
    """
    readers = {".npz": _read_npz, ".parquet": _read_parquet, ".pq": _read_parquet}
    blocks = list(readers.get(path.suffix.lower(), _read_text)(path, spec, progress))
    if not any(len(numbers) + len(bad) for _, numbers, bad in blocks):
        raise ValueError(f"{path} has no rows below its header")
    names, numbers, bad = zip(*blocks, strict=True)
    return Table(names[0], np.concatenate(numbers), [row for rows in bad for row in rows])


# --- binary tables --------------------------------------------------------------------------------


def _read_npz(path: Path, spec: ColumnSpec, progress: Progress | None) -> Iterator[Block]:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
    except (ValueError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path} cannot be read as arrays: {error}") from None
    columns = dict(_npz_columns(path, arrays))
    all_names = [*columns]
    names = [all_names[k] for k in spec.choose(all_names)]
    lengths = {len(columns[name]) for name in names}
    if len(lengths) > 1:
        sizes = ", ".join(f"{name} {len(columns[name])}" for name in names)
        raise ValueError(f"{path}: the columns must be equally long; got {sizes}")
    numbers = np.column_stack([columns[name] for name in names])
    yield _validated(spec, names, numbers, 1, _masked_rows(path, arrays, len(numbers)))
    if progress:
        progress(1, 1)


def _masked_rows(path: Path, arrays: dict[str, np.ndarray], n: int) -> np.ndarray | None:
    """Which of n rows the array `mask` hides; NumPy saves a masked array without its mask."""
    mask = arrays.get("mask")
    if mask is not None and (mask.dtype.kind != "b" or mask.shape != (n,)):
        raise ValueError(f"{path}: mask must have one truth value for each of {n} rows")
    return mask


def _npz_columns(path: Path, arrays: dict[str, np.ndarray]) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the numeric arrays as columns: `points` as x, y and z, `values` as value."""
    for name, array in arrays.items():
        if array.dtype.kind not in "biuf" or array.ndim not in (1, 2) or name == "mask":
            continue
        if array.ndim == 1:
            yield ("value" if name == "values" else name), array
        elif name == "points" and array.shape[1] <= len(AXES):
            yield from zip(AXES, array.T, strict=False)
        else:
            raise ValueError(f"{path}: a column must be one number for each row; {name} is not")


def _read_parquet(path: Path, spec: ColumnSpec, progress: Progress | None) -> Iterator[Block]:
    parquet = optional("pyarrow.parquet")
    with path.open("rb") as stream:
        try:
            file = parquet.ParquetFile(stream)
        except ValueError as error:
            raise ValueError(f"{path} cannot be read as Parquet: {error}") from None
        all_names = list(file.schema_arrow.names)
        names = [all_names[k] for k in spec.choose(all_names)]
        done = 0
        for batch in file.iter_batches(PARQUET_ROWS, columns=names):
            try:
                columns = [batch[name].cast("float64").to_numpy(False) for name in names]
            except (ValueError, NotImplementedError) as error:
                raise ValueError(f"{path} must hold numbers in {names}: {error}") from None
            yield _validated(spec, names, np.column_stack(columns), done + 1)
            done += len(columns[0])
            if progress:
                progress(done, file.metadata.num_rows)


def _validated(
    spec: ColumnSpec,
    names: list[str],
    numbers: np.ndarray,
    first: int,
    masked: np.ndarray | None = None,
) -> Block:
    """Return the valid rows and the errors of the others, which are numbered from `first`."""
    hidden = np.zeros(len(numbers), dtype=bool) if masked is None else masked
    good = spec.valid_rows(numbers) & ~hidden
    bad = [
        BadRow(
            first + int(i),
            "the row is masked" if hidden[i] else spec.error(names, numbers[i].tolist()),
            first - 1 + int(i),
        )
        for i in np.flatnonzero(~good)
    ]
    return names, numbers[good].astype(float, copy=False), bad


# --- text -----------------------------------------------------------------------------------------


def _read_text(path: Path, spec: ColumnSpec, progress: Progress | None) -> Iterator[Block]:
    with open_text(path) as file:
        line, first = _first_line(path, file)
        separator, columns = _columns(first)
        begun = "" if columns else first
        if not columns:
            columns = _default_names(len(_split(first, separator)))
        else:
            line += 1
        parser = None
        row = 0
        while block := legible(begun + file.read(BLOCK_SIZE) + file.readline()):
            begun = ""
            rows = [(i, text) for i, text in enumerate(block.split("\n"), line) if _is_row(text)]
            if parser is None:
                parser = _TextParser.of(path, columns, separator, spec, [text for _, text in rows])
            yield parser.parse_block(rows, row)
            line += block.count("\n")
            row += len(rows)
            if progress:
                progress(*bytes_read(file))


def _columns(line: str) -> tuple[str | None, list[str]]:
    """The separator of the first line, and the names in it; none if it is all numbers."""
    for separator in (";", "\t", None, ","):
        cells = _split(line, separator)
        if len(cells) > 1 and all(map(is_number, cells)):
            return separator, []
    most_frequent = max(",;\t", key=line.count)
    separator = most_frequent if most_frequent in line else None
    return separator, [cell.strip() for cell in _split(line, separator)]


@dataclass(frozen=True)
class _TextParser:
    """Parses blocks of lines whose columns, separator and numbers are known."""

    columns: list[str]
    separator: str | None
    chosen: list[int]
    spec: ColumnSpec
    numbers: NumberFormat

    @classmethod
    def of(
        cls,
        path: Path,
        columns: list[str],
        separator: str | None,
        spec: ColumnSpec,
        lines: Sequence[str],
    ) -> _TextParser:
        """A parser of numbers such as those in these lines."""
        parser = cls(columns, separator, list(spec.choose(columns)), spec, NumberFormat())
        try:
            return replace(parser, numbers=parser._number_format(lines))
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None

    def _number_format(self, lines: Sequence[str]) -> NumberFormat:
        if self.spec.decimal is not None:
            return NumberFormat(self.spec.decimal)
        if self.separator == ",":
            lines = [line for line in lines if '"' in line]
        lines = [line for line in lines if "," in line]
        rows = (_split(line, self.separator) for line in lines)
        whole = (cells for cells in rows if len(cells) == len(self.columns))
        return NumberFormat.of(cells[k] for cells in whole for k in self.chosen)

    @property
    def names(self) -> list[str]:
        return [self.columns[k] for k in self.chosen]

    def parse_block(self, rows: Sequence[tuple[int, str]], first: int) -> Block:
        """Parse rows, each with the number of its line; their positions are from `first` on."""
        placed = [(first + k, number, line) for k, (number, line) in enumerate(rows)]
        numbers = self._parse_at_once([line for _, line in rows])
        if numbers is None:
            return self._parse_line_by_line(placed)
        good = self.spec.valid_rows(numbers)
        invalid = [placed[i] for i in np.flatnonzero(~good)]
        return self.names, numbers[good], self._parse_line_by_line(invalid)[2]

    def _parse_at_once(self, lines: list[str]) -> np.ndarray | None:
        """Parse all lines at once, or return None if one of them is irregular."""
        if not all(self._is_regular(line) for line in lines) or not lines:
            return None
        plain = self.numbers.plain(lines)
        if plain is None:
            return None
        try:
            return np.loadtxt(
                plain, delimiter=self.separator, usecols=self.chosen, comments=None, ndmin=2
            )
        except ValueError:
            return None

    def _is_regular(self, line: str) -> bool:
        if self.separator is None:
            return len(line.split()) == len(self.columns)
        return line.count(self.separator) == len(self.columns) - 1 and '"' not in line

    def _parse_line_by_line(self, rows: Sequence[tuple[int, int, str]]) -> Block:
        numbers, bad = [], []
        parse = self.numbers.parse
        for row, number, line in rows:
            cells = _split(line, self.separator)
            chosen = [cells[k] for k in self.chosen] if len(cells) == len(self.columns) else None
            if chosen is None:
                expected = len(self.columns)
                error = f"the header has {expected} cells and this row {len(cells)}"
            else:
                error = self.spec.error(self.names, chosen, parse)
            if error:
                bad.append(BadRow(number, error, row))
            else:
                numbers.append([parse(cell) for cell in chosen or ()])
        return self.names, np.array(numbers).reshape(-1, len(self.chosen)), bad


def _first_line(path: Path, file: TextIO) -> tuple[int, str]:
    """Return the number and text of the first line that is neither blank nor a comment."""
    for number, line in enumerate(iter(lambda: file.readline(LONGEST_HEADER), ""), 1):
        text = legible(line)
        if _is_row(text):
            return number, text
    raise ValueError(f"{path} is empty; a header such as x,y,value and rows were expected")


def _is_row(line: str) -> bool:
    return bool(line.strip()) and line[0] != "#"


def _split(line: str, separator: str | None) -> list[str]:
    if separator is None:
        return line.split()
    try:
        return next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    except (csv.Error, StopIteration):
        return []


def _default_names(count: int) -> list[str]:
    return [*AXES, *(f"column {k}" for k in range(4, count + 1))][:count]


# --- writing --------------------------------------------------------------------------------------


def csv_bytes(columns: Iterable[str], rows: Iterable[Iterable[Any]]) -> bytes:
    """Return header and rows as CSV; each float has the fewest digits that reproduce it."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue().encode()
