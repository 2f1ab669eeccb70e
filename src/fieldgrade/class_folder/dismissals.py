"""Entries of the list *needs your eyes* that the staff has dismissed, with name and reason."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from fieldgrade.class_folder.csv_tables import Row, read_table

COLUMNS = ("entry", "by", "reason")
COPIED = ("student", "notebook", "file", "what", "details")
"""Columns that a line copied from the list also has; they are for the reader."""
ENTRY = re.compile(r"[a-z]{10}")


@dataclass(frozen=True)
class Dismissal:
    """A decision that an entry needs nobody's eyes any more.

    Parameters
    ----------
    entry : str
        The ten letters by which the list names the entry.
    by, reason : str
        The person who decided, and the reason.
    """

    entry: str
    by: str
    reason: str


def read_dismissals(path: Path) -> Mapping[str, Dismissal]:
    """Return the dismissals in a file, by entry. Columns: entry, by, reason."""
    found = read_table(path, _dismissal, COLUMNS, COPIED)
    return {dismissal.entry: dismissal for dismissal in found}


def _dismissal(row: Row) -> Dismissal:
    entry = row["entry"].lower()
    if not ENTRY.fullmatch(entry):
        raise ValueError(
            f"an entry is named by ten letters, as in needs-your-eyes.csv, not {row['entry']!r}"
        )
    return Dismissal(entry, row["by"], row["reason"])
