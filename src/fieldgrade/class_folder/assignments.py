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
IGNORED_BY_CANVAS = re.compile(
    r"(Current|Final) (Score|Points|Grade)|Override (Score|Grade|Status)"
)
"""Columns whose name contains one of these are totals for the importer of Canvas, which skips them
(``NON_ASSIGNMENT_COLUMN_HEADERS`` in ``lib/gradebook_importer.rb`` of instructure/canvas-lms)."""
COLUMNS = (
    "due",
    "grace_minutes",
    "percent_per_day",
    "most_percent",
    "canvas",
    "moodle",
    "optional",
)
YES_OR_NO = {"": False, "no": False, "yes": True}


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
    counts_optional : bool
        Whether the optional questions count.
    """

    notebook: str
    policy: LatePolicy = field(default_factory=LatePolicy)
    canvas: str = ""
    moodle: str = ""
    counts_optional: bool = False


def read_assignments(path: Path) -> Mapping[str, Assignment]:
    """Return the assignments in a file, by notebook.

    Columns: notebook, due, grace_minutes, percent_per_day, most_percent, canvas, moodle, optional;
    all but the first may be empty. In the last one, ``yes`` makes optional questions count. No two
    notebooks may have the same name in Canvas or Moodle, since the grades of one would replace
    those of the other.
    """
    found = read_table(
        path, _assignment, ("notebook",), COLUMNS, ("notebook",), ("canvas", "moodle")
    )
    return {assignment.notebook: assignment for assignment in found}


def _assignment(row: Row) -> Assignment:
    canvas = row.get("canvas", "")
    if canvas and not CANVAS.fullmatch(canvas):
        raise ValueError(
            f"a Canvas column has a name and an id, 'Least squares (48213)', not {canvas!r}"
        )
    if IGNORED_BY_CANVAS.search(canvas):
        raise ValueError(f"Canvas skips a column named {canvas!r}: rename the assignment")
    policy = LatePolicy(
        due=moment(row["due"]) if row.get("due") else None,
        grace=timedelta(minutes=_number(row, "grace_minutes", 0.0)),
        per_day=_number(row, "percent_per_day", 0.0, 100.0) / 100,
        most=_number(row, "most_percent", 100.0, 100.0) / 100,
    )
    optional = row.get("optional", "").lower()
    if optional not in YES_OR_NO:
        raise ValueError(f"column optional must be yes or no, not {optional!r}")
    name, moodle = notebook(row["notebook"]), row.get("moodle", "")
    return Assignment(name, policy, canvas, moodle, YES_OR_NO[optional])


def _number(row: Row, column: str, default: float, most: float = float("inf")) -> float:
    text = row.get(column, "")
    if not text:
        return default
    if not re.fullmatch(r"\d+(\.\d+)?", text) or float(text) > most:
        raise ValueError(f"{column} must be a number from 0 to {most:g}, not {text!r}")
    return float(text)
