"""Numbers as programs and countries write them: decimal commas, grouped digits, Fortran exponents.

A number such as ``1,234`` is ambiguous. The other cells of a table decide whether its comma marks
decimals or thousands: ``0,5`` and ``12,34`` have decimals, ``1,234.5`` and ``1,234,567`` thousands.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

_FORTRAN = re.compile(r"(?<=[0-9.])[dD](?=[+-]?[0-9])")
_GROUPED = re.compile(
    r"[+-]?[1-9]\d{0,2}([,' \u2019\u00a0\u202f])\d{3}(?:\1\d{3})*(?:\.\d*)?(?:e.+)?"
)
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3}){2,}|[+-]?[1-9]\d{0,2}(?:,\d{3})+\.\d*")
_EITHER = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
_DECIMALS = re.compile(
    r"[+-]?(?:\d+|[1-9]\d{0,2}(?:[.' \u2019\u00a0\u202f]\d{3})+)?,\d+(?:[eEdD][+-]?\d+)?"
)
_POINT = re.compile(r"[+-]?\d*\.(?:\d{1,2}|\d{4,}|\d*[eEdD][+-]?\d+)")
_EXCHANGED = str.maketrans(".,", ",.")


def parse_number(cell: object) -> float:
    """Convert a cell to a number, or to NaN; Python's 1_000 is not accepted.

    Examples
    --------
    >>> parse_number("1.5D-3"), parse_number("1,5")
    (0.0015, nan)
    """
    try:
        return _parsed(cell) if isinstance(cell, str) else float(cell)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return math.nan


def _parsed(text: str) -> float:
    return math.nan if "_" in text else float(_FORTRAN.sub("e", text))


@dataclass(frozen=True)
class NumberFormat:
    """What a comma in a number means.

    Parameters
    ----------
    decimal : str, optional
        ``","``: decimals, and points group digits. ``"."``: points mark decimals, and commas group
        digits. None: no number has a comma.
    """

    decimal: str | None = None

    @classmethod
    def of(cls, cells: Iterable[str]) -> NumberFormat:
        """The format of most of the cells.

        Raises
        ------
        ValueError
            If commas may mark decimals as well as thousands: with such a cell.

        Examples
        --------
        >>> NumberFormat.of(["0,5", "1.234,25"]), NumberFormat.of(["1,234", "0.5"])
        (NumberFormat(decimal=','), NumberFormat(decimal='.'))
        """
        stripped = [cell.strip() for cell in cells]
        with_comma = [cell for cell in stripped if "," in cell]
        decimals = sum(1 for c in with_comma if _DECIMALS.fullmatch(c) and not _EITHER.fullmatch(c))
        thousands = sum(1 for c in with_comma if _THOUSANDS.fullmatch(c))
        either = next((c for c in with_comma if _EITHER.fullmatch(c)), None)
        points = sum(1 for c in stripped if _POINT.fullmatch(c)) if either or thousands else 0
        if decimals > thousands + points:
            return cls(",")
        if thousands + points > 0 and (thousands or either):
            return cls(".")
        if either is not None:
            raise ValueError(
                f"it is not clear whether the comma in {either} marks decimals or thousands: "
                "say so by the option decimal, which is , or ."
            )
        return cls("," if decimals else None)

    def parse(self, cell: object) -> float:
        """Convert a cell to a number, or to NaN.

        Examples
        --------
        >>> NumberFormat(",").parse("1.234,5"), NumberFormat(".").parse("1,234.5")
        (1234.5, 1234.5)
        >>> NumberFormat(",").parse("1.5"), NumberFormat().parse("1'000")
        (nan, 1000.0)
        """
        if not isinstance(cell, str):
            return parse_number(cell)
        text = cell.strip()
        if self.decimal == ",":
            if text.endswith(","):
                return math.nan
            text = text.translate(_EXCHANGED)
        number = parse_number(text)
        if math.isfinite(number) or not (grouped := _GROUPED.fullmatch(text)):
            return number
        known = grouped[1] != "," or self.decimal is not None
        return parse_number(text.replace(grouped[1], "")) if known else number

    def plain(self, lines: Sequence[str]) -> list[str] | None:
        """The lines as NumPy reads them, or None if their numbers have to be converted singly."""
        if self.decimal == ".":
            return None
        if self.decimal == ",":
            if any("." in line for line in lines):
                return None
            lines = [line.replace(",", ".") for line in lines]
        return [_FORTRAN.sub("e", line) for line in lines]


ANY_FORMATS = (NumberFormat(), NumberFormat(","), NumberFormat("."))


def is_number(cell: str) -> bool:
    """Whether a cell is a finite number in some format."""
    return any(math.isfinite(known.parse(cell)) for known in ANY_FORMATS)
