"""What the learning platform knows of a notebook: its deadline, and the names of its columns."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import timedelta
from pathlib import Path

from fieldgrade.class_folder.csv_tables import Row, notebook, read_table
from fieldgrade.class_folder.late_policy import LatePolicy, moment

CANVAS = re.compile(r".+ \(\d+\)")
COLUMNS = ("due", "grace_minutes", "percent_per_day", "most_percent", "canvas", "moodle")


@dataclass(frozen=True)
class Assignment:
    """A notebook as it stands in the learning platform.

    Parameters
    ----------
    notebook : str
        ``"02"``.
    policy : LatePolicy
        When it is due, and what it costs to be late.
    canvas : str
        Its column in Canvas, with the number: ``"Moving least squares (48213)"``.
    moodle : str
        Its name in Moodle.
    """

    notebook: str
    policy: LatePolicy = field(default_factory=LatePolicy)
    canvas: str = ""
    moodle: str = ""


def read_assignments(path: Path) -> Mapping[str, Assignment]:
    """Return the assignments in a file, by notebook.

    Columns: notebook, due, grace_minutes, percent_per_day, most_percent, canvas, moodle; all but
    the first may be empty.
    """
    return {a.notebook: a for a in read_table(path, _assignment, ("notebook",), COLUMNS)}


def _assignment(row: Row) -> Assignment:
    canvas = row.get("canvas", "")
    if canvas and not CANVAS.fullmatch(canvas):
        raise ValueError(f"Canvas names a column as in 'Least squares (48213)', not {canvas!r}")
    policy = LatePolicy(
        due=moment(row["due"]) if row.get("due") else None,
        grace=timedelta(minutes=_number(row, "grace_minutes", 0.0)),
        per_day=_number(row, "percent_per_day", 0.0, 100.0) / 100,
        most=_number(row, "most_percent", 100.0, 100.0) / 100,
    )
    return Assignment(notebook(row["notebook"]), policy, canvas, row.get("moodle", ""))


def _number(row: Row, column: str, default: float, most: float = float("inf")) -> float:
    text = row.get(column, "")
    if not text:
        return default
    if not re.fullmatch(r"\d+(\.\d+)?", text) or float(text) > most:
        raise ValueError(f"{column} is a number from 0 to {most:g}, not {text!r}")
    return float(text)
