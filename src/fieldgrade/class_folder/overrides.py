"""Overrides of grades by the staff, with name and reason, and regrade requests.

Both are CSV files to which lines are appended. An override does not change the automatic grade, and
the last override counts.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path

from fieldgrade.class_folder.csv_tables import Row, points, question, read_table

COLUMNS = ("student", "question", "points", "by", "reason", "on")


@dataclass(frozen=True)
class Override:
    """Points that replace those of the grader.

    Parameters
    ----------
    student, question : str
        The student and the question.
    points : float
        The new points.
    by, reason : str
        The person who decided, and the reason.
    on : date
        The day.
    """

    student: str
    question: str
    points: float
    by: str
    reason: str
    on: date


@dataclass(frozen=True)
class RegradeRequest:
    """A regrade request of a student.

    Parameters
    ----------
    student, question : str
        The student and the question.
    on : date
        The day.
    request : str
        The reason, in the student's words.
    answer : str
        The answer, if no points were changed; empty as long as the request is open.
    """

    student: str
    question: str
    on: date
    request: str
    answer: str = ""


def read_overrides(path: Path) -> list[Override]:
    """Return the overrides in a file. Columns: student, question, points, by, reason, on."""
    return read_table(path, _override, COLUMNS)


def read_requests(path: Path) -> list[RegradeRequest]:
    """Return the requests in a file. Columns: student, question, on, request, answer."""
    return read_table(path, _request, ("student", "question", "on", "request"), ("answer",))


def latest(overrides: Iterable[Override]) -> Mapping[tuple[str, str], Override]:
    """Return the override that counts, by student and question: the last one written."""
    return {(o.student, o.question): o for o in overrides}


def open_requests(
    requests: Iterable[RegradeRequest], overrides: Sequence[Override]
) -> list[RegradeRequest]:
    """Return the requests without an answer and without a later override."""
    decided = {key: o.on for key, o in latest(overrides).items()}
    return [
        r
        for r in requests
        if not r.answer and decided.get((r.student, r.question), date.min) < r.on
    ]


def _override(row: Row) -> Override:
    return Override(
        row["student"],
        question(row["question"]),
        points(row["points"]),
        row["by"],
        row["reason"],
        _day(row["on"]),
    )


def _request(row: Row) -> RegradeRequest:
    return RegradeRequest(
        row["student"],
        question(row["question"]),
        _day(row["on"]),
        row["request"],
        row.get("answer", ""),
    )


def _day(text: str) -> date:
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise ValueError(f"a day must be written as 2026-11-30, not {text!r}") from None
