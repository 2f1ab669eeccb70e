"""Tables on the terminal; imported without NumPy, so that a list of names is shown at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

_WIDEST = 7
_MOST_ROWS = 40


class Terminal(Console):
    """A console that leaves it to the program what a closed pipe means."""

    def on_broken_pipe(self) -> None:
        """Pass it on."""
        raise BrokenPipeError


def print_table(
    columns: Sequence[str], rows: Sequence[Sequence[Any]], title: str = "", whole: bool = False
) -> None:
    """Print a table; one with many columns lies on its side, so that it fits a terminal.

    Of a long one the first rows are shown, since a file has the others, unless it is to be whole.
    """
    most = max(len(rows), len(columns)) if whole else _MOST_ROWS
    texts = [[escape(_typed(cell)) for cell in row] for row in (columns, *rows)]
    if len(columns) > _WIDEST >= len(rows) or len(columns) > 2 * _WIDEST:
        texts = [list(column) for column in zip(*texts, strict=True)]
    table = Table(*texts[0], title=escape(title) or None, title_justify="left")
    for row in texts[1 : 1 + most]:
        table.add_row(*row)
    Terminal().print(table)
    if len(texts) - 1 > most:
        Terminal().print(f"… and {len(texts) - 1 - most} rows more, in the file")


def _typed(cell: Any) -> str:
    """Spell a value for the terminal; a list as it would be typed."""
    if isinstance(cell, float):
        return f"{cell:.4g}"
    return ",".join(map(_typed, cell)) if isinstance(cell, list | tuple) else str(cell)
