"""The late policy: the penalty as a function of time of receipt, deadline and extension.

The penalty is not stored with the grades, so changing a deadline changes the final grades.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from math import ceil
from pathlib import Path

from fieldgrade.class_folder.csv_tables import Row, notebook, read_table

DAY = timedelta(days=1)


@dataclass(frozen=True)
class LatePolicy:
    """A deadline and the penalty for late submission.

    Parameters
    ----------
    due : datetime, optional
        The deadline, with its time zone; without one nothing is late.
    grace : timedelta
        A submission within this time after the deadline is not late.
    per_day : float
        The share of the points that is lost for each started day after the deadline.
    most : float
        The largest share that is lost.
    """

    due: datetime | None = None
    grace: timedelta = timedelta(0)
    per_day: float = 0.0
    most: float = 1.0


@dataclass(frozen=True)
class Extension:
    """An extended deadline for one student and one notebook, with the reason."""

    student: str
    notebook: str
    until: datetime
    reason: str


def days_late(received: datetime, due: datetime, grace: timedelta = timedelta(0)) -> int:
    """Return the number of started days after the deadline; 0 within the grace period.

    Examples
    --------
    >>> due = moment("2026-11-30T23:59+01:00")
    >>> days_late(moment("2026-12-01T00:04+01:00"), due)
    1
    >>> days_late(moment("2026-12-01T00:04+01:00"), due, timedelta(minutes=15))
    0
    """
    over = received - due
    return 0 if over <= max(grace, timedelta(0)) else ceil(over / DAY)


def late_factor(
    received: datetime | None, policy: LatePolicy, until: datetime | None = None
) -> float:
    """Return the share of the points that remains, between 0 and 1.

    It is max(1 - d p, 1 - m) after d started days, with penalty p per day and largest penalty m.

    Parameters
    ----------
    received : datetime, optional
        The time of receipt; a submission without one is not late.
    policy : LatePolicy
        The deadline and the penalty.
    until : datetime, optional
        An extended deadline; the later of the two deadlines counts.

    Examples
    --------
    >>> policy = LatePolicy(moment("2026-11-30T23:59+01:00"), per_day=0.1, most=0.5)
    >>> late_factor(moment("2026-12-02T12:00+01:00"), policy)
    0.8
    """
    if received is None or policy.due is None:
        return 1.0
    due = policy.due if until is None else max(policy.due, until)
    lost = days_late(received, due, policy.grace) * policy.per_day
    return 1.0 - min(lost, policy.most, 1.0)


def moment(text: str) -> datetime:
    """Parse a time with a time zone.

    Raises
    ------
    ValueError
        The text is not a time, or has no time zone.
    """
    try:
        time = datetime.fromisoformat(text)
    except ValueError:
        raise ValueError(
            f"a time must be written as 2026-11-30T23:59+01:00, not {text!r}"
        ) from None
    if len(text) <= len("2026-11-30"):
        raise ValueError(f"{text!r} is a day without a time: write 2026-11-30T23:59+01:00")
    if time.tzinfo is None:
        raise ValueError(f"{text!r} has no time zone: write it as {text}+01:00 or {text}Z")
    return time


def read_extensions(path: Path) -> Mapping[tuple[str, str], Extension]:
    """Return the extensions in a file, by student and notebook; the longest one counts.

    Columns: student, notebook, until, reason.
    """
    found: dict[tuple[str, str], Extension] = {}
    for extension in read_table(path, _extension, ("student", "notebook", "until", "reason")):
        key = (extension.student, extension.notebook)
        if key not in found or found[key].until < extension.until:
            found[key] = extension
    return found


def _extension(row: Row) -> Extension:
    return Extension(row["student"], notebook(row["notebook"]), moment(row["until"]), row["reason"])
