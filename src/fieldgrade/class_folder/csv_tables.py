"""CSV tables that people edit with spreadsheets: strict reading, safe writing."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")
Row = Mapping[str, str]

FORMULA = re.compile(r"'*[=+\-@\t\r\n＝＋－＠#]")
"""Beginnings of cells that a spreadsheet would evaluate, or that would be read as a comment; a
leading apostrophe prevents both."""


def read_table(
    path: Path,
    parse: Callable[[Row], T],
    needed: Sequence[str],
    known: Sequence[str] = (),
    unique: Sequence[str] = (),
    distinct: Sequence[str] = (),
) -> list[T]:
    """Return the parsed lines of a CSV file.

    Columns may have any order, separated by commas or semicolons. Empty lines and lines that begin
    with ``#`` are skipped.

    Parameters
    ----------
    path : Path
        The file, in UTF-8.
    parse : callable
        From a line, as a mapping from columns to stripped cells, to the parsed value; it raises
        `ValueError` with a message for an invalid line.
    needed : sequence of str
        Required columns, whose cells must not be empty.
    known : sequence of str
        Optional columns; any other column is an error.
    unique : sequence of str
        Columns that together must not be equal in two lines.
    distinct : sequence of str
        Columns each of which must not be equal in two lines, unless it is empty.

    Raises
    ------
    ValueError
        All errors of the file, one line each: ``roster.csv:7: column student is empty``.
    """
    lines = list(_lines(path))
    if not lines:
        raise ValueError(f"{path.name} is empty; its first line should be {', '.join(needed)}")
    columns = [cell.lower() for cell in lines[0][1]]
    _require_columns(path, columns, needed, (*needed, *known))
    found: list[T] = []
    problems: list[str] = []
    first: dict[tuple[str, ...], int] = {}
    groups = [tuple(unique), *((column,) for column in distinct)]
    for number, cells in lines[1:]:
        try:
            row = _row(columns, cells, needed)
            _require_unique(row, groups, number, first)
            found.append(parse(row))
        except ValueError as error:
            problems.append(f"{path.name}:{number}: {error}")
    if problems:
        raise ValueError("\n".join(problems))
    return found


def header(path: Path) -> tuple[list[str], str]:
    """Return the columns of a CSV file, and its delimiter."""
    return next((cells for _, cells in _lines(path)), []), _delimiter(_text(path))


def to_csv(columns: Sequence[str], rows: Iterable[Sequence[object]], delimiter: str = ",") -> str:
    r"""Return a table as CSV, safe against formula injection.

    Numbers have at most two decimals; None is an empty cell.

    Examples
    --------
    >>> to_csv(("student", "points"), [("=HYPERLINK(1)", -0.5), ("ada", None)])
    "student,points\n'=HYPERLINK(1),-0.5\nada,\n"

    References
    ----------
    OWASP, "CSV Injection", https://owasp.org/www-community/attacks/CSV_Injection.
    """
    file = io.StringIO()
    writer = csv.writer(file, delimiter=delimiter, lineterminator="\n")
    writer.writerow([_safe(column) for column in columns])
    writer.writerows([_cell(value) for value in row] for row in rows)
    return file.getvalue()


def points(text: str) -> float:
    """Parse points; both 1.5 and 1,5 are valid.

    Examples
    --------
    >>> points("1,5")
    1.5
    """
    if not re.fullmatch(r"\d+([.,]\d+)?", text):
        raise ValueError(f"points must be a number such as 1.5, not {text!r}")
    return float(text.replace(",", "."))


def question(text: str) -> str:
    """Parse the name of a question, which a spreadsheet may have shortened.

    Examples
    --------
    >>> question("01.10")
    '01.10'
    """
    if not re.fullmatch(r"\d\d\.\d+", text):
        raise ValueError(
            f"a question is written as 01.2, not {text!r}; spreadsheets shorten such names "
            "unless the column is formatted as text"
        )
    return text


def notebook(text: str) -> str:
    """Parse the number of a notebook, also without the leading zero.

    Examples
    --------
    >>> notebook("2")
    '02'
    """
    if not re.fullmatch(r"\d{1,2}", text):
        raise ValueError(f"a notebook is written as 02, not {text!r}")
    return text.zfill(2)


def short(number: float) -> str:
    """Format points with at most two decimals.

    Examples
    --------
    >>> short(2.0), short(1 / 3)
    ('2', '0.33')
    """
    return f"{round(number, 2) + 0.0:.2f}".rstrip("0").rstrip(".")


def _cell(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return short(value)
    return str(value) if isinstance(value, int) else _safe(str(value))


def _safe(text: str) -> str:
    text = text.replace("\r\n", "\n").replace("\r", "\n")  # csv does not quote the latter
    return f"'{text}" if FORMULA.match(text) else text


def _plain(text: str) -> str:
    """Undo `_safe`."""
    return text[1:] if text.startswith("'") and FORMULA.match(text) else text


def _lines(path: Path) -> Iterable[tuple[int, list[str]]]:
    """Yield the lines with content as cells, with the line number at which each ends."""
    text = _text(path)
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=_delimiter(text))
    try:
        for cells in reader:
            stripped = [_plain(cell).strip() for cell in cells]
            if any(stripped) and not cells[0].lstrip().startswith("#"):
                yield reader.line_num, stripped
    except csv.Error as error:
        raise ValueError(f"{path.name}:{reader.line_num}: {error}") from None


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"{path.name} is not in UTF-8: save it as CSV UTF-8") from None


def _delimiter(text: str) -> str:
    first = text.partition("\n")[0]
    return ";" if first.count(";") > first.count(",") else ","


def _require_columns(
    path: Path, columns: Sequence[str], needed: Sequence[str], known: Sequence[str]
) -> None:
    missing = [name for name in needed if name not in columns]
    if missing:
        raise ValueError(f"{path.name}:1: there is no column {', '.join(missing)}")
    strange = [name for name in columns if name not in known]
    if strange:
        raise ValueError(
            f"{path.name}:1: unknown column {', '.join(map(repr, strange))}; "
            f"the columns are {', '.join(known)}"
        )
    if len(set(columns)) < len(columns):
        raise ValueError(f"{path.name}:1: a column occurs twice")


def _require_unique(
    row: Row, groups: Iterable[Sequence[str]], number: int, first: dict[tuple[str, ...], int]
) -> None:
    for names in groups:
        cells = [row.get(name, "") for name in names]
        before = first.setdefault((*names, *(cell.lower() for cell in cells)), number)
        if before != number and all(cells) and cells:
            raise ValueError(f"{', '.join(names)} {', '.join(cells)} is already in line {before}")


def _row(columns: Sequence[str], cells: Sequence[str], needed: Sequence[str]) -> Row:
    if len(cells) > len(columns):
        raise ValueError(f"the line has {len(cells)} cells for {len(columns)} columns")
    row = dict.fromkeys(columns, "") | dict(zip(columns, cells, strict=False))
    if row.get("notebook", "").isdecimal():  # so that 1 and 01 are equal
        row["notebook"] = row["notebook"].zfill(2)
    empty = [name for name in needed if not row[name]]
    if empty:
        raise ValueError(f"column {', '.join(empty)} is empty")
    return row
