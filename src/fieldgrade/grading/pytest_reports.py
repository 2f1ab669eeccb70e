"""What the items of pytest tell of their submissions, gathered from one process or several."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from fieldgrade.checking.instructor_checks import (
    InstructorCheck,
    InstructorCheckResult,
    apply_instructor_checks,
)
from fieldgrade.checking.results import Record, record_from_json, record_to_json
from fieldgrade.grading.pytest_items import AnswerId


def answer_of_record(record: Record) -> AnswerId:
    """Return the place of a submission, from its record."""
    return AnswerId(record.student, record.notebook, record.file, record.digest)


def written(
    place: AnswerId,
    of: int,
    records: Iterable[Record],
    checked: InstructorCheckResult | None,
    fault: str,
) -> str:
    """Return what an item has to tell when it is done, as text that can travel.

    Parameters
    ----------
    place : AnswerId
        What it is about.
    of : int
        How many items there are about the same.
    records : iterable of Record
        Those that came in the meantime, of whatever submission.
    checked : InstructorCheckResult, optional
        What came of an instructor's check.
    fault : str
        In what the grader failed; empty if it did not.
    """
    return json.dumps(
        {
            "place": asdict(place),
            "of": of,
            "records": [record_to_json(r) for r in records],
            "checked": asdict(checked) if checked else None,
            "fault": fault,
        }
    )


@dataclass
class ReportCollector:
    """What was found in a run.

    Parameters
    ----------
    records : dict
        The records, by submission.
    faults : list of str
        In what the grader failed.
    """

    records: dict[AnswerId, Record] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)
    _done: Counter[AnswerId] = field(default_factory=Counter)
    _of: dict[AnswerId, int] = field(default_factory=dict)
    _checked: dict[AnswerId, list[InstructorCheckResult]] = field(default_factory=dict)

    def add(self, text: str) -> None:
        """Take in what an item told."""
        data: dict[str, Any] = json.loads(text)
        place = AnswerId(**data["place"])
        self._done[place] += 1
        self._of[place] = data["of"]
        for record in map(record_from_json, data["records"]):
            self.records[answer_of_record(record)] = record
        if data["checked"]:
            check = InstructorCheck(**data["checked"].pop("check"))
            self._checked.setdefault(place.whole, []).append(
                InstructorCheckResult(check, **data["checked"])
            )
        if data["fault"] and data["fault"] not in self.faults:
            self.faults.append(data["fault"])

    def complete(self) -> Iterator[Record]:
        """Yield records with the grades of those questions whose checks were all made."""
        for place, record in self.records.items():
            whole = apply_instructor_checks(record, self._checked.get(place, ()))
            grades = tuple(g for g in whole.grades if self._is_done(place, g.question))
            if grades or not whole.grades:
                yield replace(whole, grades=grades)

    def _is_done(self, place: AnswerId, question: str) -> bool:
        at = replace(place, question=question)
        return self._done[at] > 0 and self._done[at] == self._of[at]
