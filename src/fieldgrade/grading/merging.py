"""Records of several runs as one: what was graded now stands in the place of what was before."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from fieldgrade.checking.results import STATUSES, Record


def ordered(records: Iterable[Record]) -> tuple[Record, ...]:
    """Return records in the order of students, notebooks and files."""
    return tuple(sorted(records, key=lambda r: (r.student, r.notebook, r.file, r.digest)))


def merged(before: Iterable[Record], now: Iterable[Record]) -> tuple[Record, ...]:
    """Return the records of before with those of a run in their place.

    Where only some questions of the same file were graded, the other grades stay; they go where
    the file is another one. What could not be read goes too, once a file of its name could.
    """
    kept = {_whose(record): record for record in before}
    for record in now:
        kept.pop((record.student, "", record.file), None)
        kept[_whose(record)] = _completed(record, kept.get(_whose(record)))
    return ordered(kept.values())


def _completed(record: Record, old: Record | None) -> Record:
    """Return a record with the grades that another one has of the same file."""
    asked = {grade.question for grade in record.grades}
    rest = [grade for grade in old.grades if grade.question not in asked] if old else []
    if old is None or old.digest != record.digest or not rest:
        return record
    grades = sorted((*record.grades, *rest), key=lambda grade: _number(grade.question))
    status = max(record.status, old.status, key=STATUSES.index)
    return replace(record, grades=tuple(grades), status=status)


def _whose(record: Record) -> tuple[str, ...]:
    own = (record.student, record.notebook)
    return own if record.notebook else (*own, record.file)


def _number(question: str) -> tuple[int, ...]:
    return tuple(int(part) for part in question.split("."))
