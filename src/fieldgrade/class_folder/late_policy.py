"""What a late hand-in costs: a pure function of when it came, the deadline and an extension.

Nothing is stored with the grades, so a deadline that moves is all that has to be changed.
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
    """A deadline and what it costs to miss it.

    Parameters
    ----------
    due : datetime, optional
        The deadline, with its time zone; without one nothing is late.
    grace : timedelta
        So much later is not late yet.
    per_day : float
        The part of the points that each day begun after the deadline costs.
    most : float
        The part that is lost at most.
    """

    due: datetime | None = None
    grace: timedelta = timedelta(0)
    per_day: float = 0.0
    most: float = 1.0


@dataclass(frozen=True)
class Extension:
    """More time for one student and one notebook, and why."""

    student: str
    notebook: str
    until: datetime
    reason: str


def days_late(received: datetime, due: datetime, grace: timedelta = timedelta(0)) -> int:
    """Return how many days after the deadline have begun; none within the grace.

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


def kept(received: datetime | None, policy: LatePolicy, until: datetime | None = None) -> float:
    """Return the part of the points that is kept, between 0 and 1.

    It is max(1 - d p, 1 - m) after d days begun, with p lost per day and m at most.

    Parameters
    ----------
    received : datetime, optional
        When it was handed in; what has no time is not late.
    policy : LatePolicy
        The deadline, and what a day costs.
    until : datetime, optional
        An extension. It never hurts: the later of the two deadlines counts.

    Examples
    --------
    >>> policy = LatePolicy(moment("2026-11-30T23:59+01:00"), per_day=0.1, most=0.5)
    >>> kept(moment("2026-12-02T12:00+01:00"), policy)
    0.8
    """
    if received is None or policy.due is None:
        return 1.0
    due = policy.due if until is None else max(policy.due, until)
    lost = days_late(received, due, policy.grace) * policy.per_day
    return 1.0 - min(lost, policy.most, 1.0)


def moment(text: str) -> datetime:
    """Return a point in time, which has a time zone.

    Raises
    ------
    ValueError
        It is none, or it might be any of 24.
    """
    try:
        time = datetime.fromisoformat(text)
    except ValueError:
        raise ValueError(f"a time is written as 2026-11-30T23:59+01:00, not {text!r}") from None
    if time.tzinfo is None:
        raise ValueError(f"{text!r} has no time zone: write it as {text}+01:00 or {text}Z")
    return time


def read_extensions(path: Path) -> Mapping[tuple[str, str], Extension]:
    """Return the extensions in a file by student and notebook; of several the longest counts.

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
