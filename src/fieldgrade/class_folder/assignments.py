"""Assignments: the deadline and late policy of each notebook, and its name in Canvas and Moodle."""

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
    """A notebook as an assignment of the learning platform.

    Parameters
    ----------
    notebook : str
        ``"02"``.
    policy : LatePolicy
        The deadline and the late penalty.
    canvas : str
        Its column in the Canvas gradebook, with the id: ``"Moving least squares (48213)"``.
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
        raise ValueError(
            f"a Canvas column has a name and an id, 'Least squares (48213)', not {canvas!r}"
        )
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
        raise ValueError(f"{column} must be a number from 0 to {most:g}, not {text!r}")
    return float(text)
