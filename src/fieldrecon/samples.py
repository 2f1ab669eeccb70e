"""Samples of a field from a table: a CSV file with a header, its columns chosen by name."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

_X = ("x", "easting", "east", "lon", "long", "longitude")
_Y = ("y", "northing", "north", "lat", "latitude")
_VALUE = ("value", "z", "f", "v", "h", "height", "elevation", "depth")


@dataclass(frozen=True)
class Samples:
    """Values at scattered points of the plane.

    Parameters
    ----------
    names : tuple of str
        Of the columns that hold x, y and the value.
    points : ndarray of shape (n, 2)
    values : ndarray of shape (n,)
    merged : int
        How many rows were left out because they repeat a point; the point bears the mean of the
        values given there.
    """

    names: tuple[str, str, str]
    points: np.ndarray
    values: np.ndarray
    merged: int = 0

    @property
    def in_degrees(self) -> bool:
        """Whether the names of the columns say longitude and latitude."""
        return any(name.lower().startswith(("lon", "lat")) for name in self.names[:2])


def read_samples(
    path: Path, x: str | None = None, y: str | None = None, value: str | None = None
) -> Samples:
    """Read samples from a CSV file.

    Cells are separated by commas, semicolons or tabs, whichever the header has most of. Blank
    lines and lines that begin with ``#`` are passed over.

    Parameters
    ----------
    path : Path
    x, y, value : str, optional
        Names of the columns. Where not given, usual names are looked for, and the value may be
        the only column left.

    Raises
    ------
    ValueError
        If a column cannot be found, or a row is not three finite numbers: with its line number.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise ValueError(f"{path} is not a text in UTF-8: {error.reason}") from None
    rows = _rows(path, lines)
    _, header = next(rows, (0, []))
    columns = [name.strip() for name in header]
    chosen = _chosen(path, columns, (x, y, value))
    numbers = np.array([_numbers(path, line, row, columns, chosen) for line, row in rows])
    if len(numbers) == 0:
        raise ValueError(f"{path} has no rows below its header")
    at_x, at_y, at_value = (columns[k] for k in chosen)
    points, values = _merged(numbers[:, :2], numbers[:, 2])
    return Samples((at_x, at_y, at_value), points, values, merged=len(numbers) - len(points))


def _rows(path: Path, lines: Sequence[str]) -> Iterator[tuple[int, list[str]]]:
    """Yield number and cells of each line that says something; the first is the header."""
    told = [(k, line) for k, line in enumerate(lines, 1) if line.strip() and line[0] != "#"]
    if not told:
        raise ValueError(f"{path} is empty; a header such as x,y,value and rows were expected")
    separator = max(",;\t", key=told[0][1].count)
    for number, line in told:
        yield number, next(csv.reader([line], delimiter=separator))


def _chosen(path: Path, columns: list[str], names: Sequence[str | None]) -> tuple[int, int, int]:
    """Find the columns of x, y and the value."""
    for name in names:
        if name is not None and name not in columns:
            raise ValueError(f"{path} has no column {name!r}; it has {', '.join(columns)}")
    x, y, value = (
        columns.index(name) if name is not None else _usual(columns, usual)
        for name, usual in zip(names, (_X, _Y, _VALUE), strict=True)
    )
    left = set(range(len(columns))) - {x, y}
    value = left.pop() if value is None and len(left) == 1 else value
    for option, column in (("--x", x), ("--y", y), ("--value", value)):
        if column is None:
            raise ValueError(
                f"it is not clear which column of {path} to take; "
                f"name it with {option}: {', '.join(columns)}"
            )
    if len({x, y, value}) < 3:
        raise ValueError("x, y and the value must be three different columns")
    return x, y, value  # type: ignore[return-value]


def _usual(columns: list[str], usual: Sequence[str]) -> int | None:
    """Find the column of the most usual name, if any; units in brackets do not count."""
    bare = [column.lower().split("(")[0].split("[")[0].strip() for column in columns]
    return next((bare.index(name) for name in usual if name in bare), None)


def _numbers(
    path: Path, line: int, row: list[str], columns: list[str], chosen: Sequence[int]
) -> list[float]:
    if len(row) != len(columns):
        raise ValueError(
            f"{path}, line {line}: the header has {len(columns)} cells and this row {len(row)}"
        )
    return [_number(f"{path}, line {line}: {columns[k]}", row[k]) for k in chosen]


def _number(place: str, text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f"{place} must be a finite number; got {text.strip()!r}")
    return number


def _merged(points: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give each point once, in the order of the file, with the mean of its values."""
    _, first, which, count = np.unique(
        points, axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    means = np.bincount(which.ravel(), weights=values) / count
    order = np.argsort(first)
    return points[first[order]], means[order]
