"""What is wanted of a table: some columns, and rows whose numbers are numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np


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
