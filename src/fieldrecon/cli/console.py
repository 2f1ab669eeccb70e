"""Paragraphs and tables on standard output, no wider than the terminal; imported without NumPy."""

from __future__ import annotations

import shutil
import sys
import textwrap
from collections.abc import Sequence
from itertools import zip_longest
from typing import Any

_WIDEST = 7
_MOST_ROWS = 40
_GAP = "  "
_NARROW = 8  # characters: columns are made no narrower
_ENDLESS = 10**6


def say(text: str) -> None:
    """Print a paragraph, between words broken to the width of a terminal."""
    print("\n".join(_wrapped(text, _width())))


def print_table(
    columns: Sequence[str], rows: Sequence[Sequence[Any]], title: str = "", whole: bool = False
) -> None:
    """Print a table; one with many columns lies on its side, so that it fits a terminal.

    Of a long one the first rows are shown, since a file has the others, unless it is to be whole.
    """
    most = max(len(rows), len(columns)) if whole else _MOST_ROWS
    texts = [[_typed(cell) for cell in row] for row in (columns, *rows)]
    if len(columns) > _WIDEST >= len(rows) or len(columns) > 2 * _WIDEST:
        texts = [list(column) for column in zip(*texts, strict=True)]
    shown = texts[: 1 + most]
    widths = _fitted([max(map(len, column)) for column in zip(*shown, strict=True)], _width())
    if title:
        say(title)
    for row in (shown[0], ["-" * width for width in widths], *shown[1:]):
        _print_row(row, widths)
    if len(texts) - 1 > most:
        print(f"… and {len(texts) - 1 - most} rows more, in the file")
    print()


def _print_row(row: Sequence[str], widths: Sequence[int]) -> None:
    """Print the cells beside each other, each in as many lines as it takes."""
    cells = [_wrapped(cell, width) for cell, width in zip(row, widths, strict=True)]
    for lines in zip_longest(*cells, fillvalue=""):
        padded = (line.ljust(width) for line, width in zip(lines, widths, strict=True))
        print(_GAP.join(padded).rstrip())


def _fitted(widths: list[int], width: int) -> list[int]:
    """Narrow the widest columns until all fit beside each other, but none beyond reading.

    Examples
    --------
    >>> _fitted([4, 60, 30], 60)
    [4, 26, 26]
    """
    widths = list(widths)
    room = width - len(_GAP) * (len(widths) - 1)
    while sum(widths) > room and max(widths) > _NARROW:
        widths[widths.index(max(widths))] -= 1
    return widths


def _wrapped(text: str, width: int) -> list[str]:
    return [part for line in text.splitlines() for part in textwrap.wrap(line, width)] or [""]


def _width() -> int:
    """Characters of a line: those of the terminal; a file has no end of them."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else _ENDLESS


def _typed(cell: Any) -> str:
    """Spell a value for the terminal; a list as it would be typed."""
    if isinstance(cell, float):
        return f"{cell:.4g}"
    return ",".join(map(_typed, cell)) if isinstance(cell, list | tuple) else str(cell)
