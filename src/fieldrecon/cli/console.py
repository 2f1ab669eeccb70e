"""Paragraphs, tables and names of files on standard output, no wider than the terminal.

The module is imported by every command and needs the standard library only.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import textwrap
from collections.abc import Iterable, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any

from fieldrecon._core.extras import PICTURES, absent, remedy

_MAX_COLUMNS = 7  # of a table that is not transposed
_MAX_ROWS = 40
_GAP = "  "
_MIN_WIDTH = 8  # characters: columns are not made narrower
_UNLIMITED = 10**6


def say(text: str) -> None:
    """Print a paragraph, wrapped to the width of the terminal."""
    print("\n".join(_wrapped(text, _width())))


def print_table(
    columns: Sequence[str], rows: Sequence[Sequence[Any]], title: str = "", whole: bool = False
) -> None:
    """Print a table; a table with many columns is transposed, so that it fits the terminal.

    Unless `whole` is set, only the first rows of a long table are printed; a file has the rest.
    """
    limit = max(len(rows), len(columns)) if whole else _MAX_ROWS
    texts = [[_formatted(cell) for cell in row] for row in (columns, *rows)]
    if len(columns) > _MAX_COLUMNS >= len(rows) or len(columns) > 2 * _MAX_COLUMNS:
        texts = [list(column) for column in zip(*texts, strict=True)]
    shown = texts[: 1 + limit]
    widths = _fitted([max(map(len, column)) for column in zip(*shown, strict=True)], _width())
    if title:
        say(title)
    for row in (shown[0], ["-" * width for width in widths], *shown[1:]):
        _print_row(row, widths)
    if len(texts) - 1 > limit:
        print(f"… and {len(texts) - 1 - limit} rows more, in the file")
    print()


def print_json(content: dict[str, Any]) -> None:
    """Print a dictionary as JSON."""
    print(json.dumps(content))


def print_files(paths: Iterable[Path]) -> None:
    """Print the files that were written, one a line, so that another program can read them."""
    for path in paths:
        print(path)


def print_missing_pictures() -> None:
    """Print on standard error which packages to install for pictures, if some are missing."""
    if missing := absent(*PICTURES):
        print(f"fieldrecon: no picture was drawn: {remedy(*missing)}", file=sys.stderr)


def _print_row(row: Sequence[str], widths: Sequence[int]) -> None:
    """Print the cells beside each other, each wrapped to its width."""
    cells = [_wrapped(cell, width) for cell, width in zip(row, widths, strict=True)]
    for lines in zip_longest(*cells, fillvalue=""):
        padded = (line.ljust(width) for line, width in zip(lines, widths, strict=True))
        print(_GAP.join(padded).rstrip())


def _fitted(widths: list[int], width: int) -> list[int]:
    """Narrow the widest columns until the table fits, but none below the minimum.

    Examples
    --------
    >>> _fitted([4, 60, 30], 60)
    [4, 26, 26]
    """
    widths = list(widths)
    room = width - len(_GAP) * (len(widths) - 1)
    while sum(widths) > room and max(widths) > _MIN_WIDTH:
        widths[widths.index(max(widths))] -= 1
    return widths


def _wrapped(text: str, width: int) -> list[str]:
    return [part for line in text.splitlines() for part in textwrap.wrap(line, width)] or [""]


def _width() -> int:
    """Characters of a line of the terminal; the lines of a file are not wrapped."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else _UNLIMITED


def _formatted(cell: Any) -> str:
    """Format a value for the terminal; a list as on the command line."""
    if isinstance(cell, float):
        return f"{cell:.4g}"
    return ",".join(map(_formatted, cell)) if isinstance(cell, list | tuple) else str(cell)


def as_parameters(options: argparse.Namespace, *, omit: str = "") -> dict[str, Any]:
    """Return the options that were given or have a default, by their names on the command line."""
    return {
        f"--{name.replace('_', '-')}": str(value) if isinstance(value, Path) else value
        for name, value in vars(options).items()
        if name not in ("command", "traceback", omit) and value is not None and value is not False
    }
