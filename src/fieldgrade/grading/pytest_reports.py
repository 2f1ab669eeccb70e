"""Results in the reports of pytest items, collected from one process or several."""

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
    """Return the identifier of a submission, from its record."""
    return AnswerId(record.student, record.notebook, record.file, record.digest)


def to_text(
    answer_id: AnswerId,
    of: int,
    records: Iterable[Record],
    checked: InstructorCheckResult | None,
    fault: str,
) -> str:
    """Return the results of an item as text, which can be sent between processes.

    Parameters
    ----------
    answer_id : AnswerId
        The answer.
    of : int
        How many items the answer has.
    records : iterable of Record
        Records that were completed in the meantime, of any submission.
    checked : InstructorCheckResult, optional
        The result of an instructor's check.
    fault : str
        The failure of the grader; empty if there is none.
    """
    return json.dumps(
        {
            "place": asdict(answer_id),
            "of": of,
            "records": [record_to_json(r) for r in records],
            "checked": asdict(checked) if checked else None,
            "fault": fault,
        }
    )


@dataclass
class ReportCollector:
    """Collects the results of a run.

    Parameters
    ----------
    records : dict
        The records, by submission.
    faults : list of str
        Failures of the grader.
    """

    records: dict[AnswerId, Record] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)
    _done: Counter[AnswerId] = field(default_factory=Counter)
    _of: dict[AnswerId, int] = field(default_factory=dict)
    _checked: dict[AnswerId, list[InstructorCheckResult]] = field(default_factory=dict)

    def add(self, text: str) -> None:
        """Add the results of an item."""
        data: dict[str, Any] = json.loads(text)
        answer_id = AnswerId(**data["place"])
        self._done[answer_id] += 1
        self._of[answer_id] = data["of"]
        for record in map(record_from_json, data["records"]):
            self.records[answer_of_record(record)] = record
        if data["checked"]:
            check = InstructorCheck(**data["checked"].pop("check"))
            self._checked.setdefault(answer_id.whole, []).append(
                InstructorCheckResult(check, **data["checked"])
            )
        if data["fault"] and data["fault"] not in self.faults:
            self.faults.append(data["fault"])

    def complete(self) -> Iterator[Record]:
        """Yield records with the grades of the questions whose checks are complete."""
        for answer_id, record in self.records.items():
            whole = apply_instructor_checks(record, self._checked.get(answer_id, ()))
            grades = tuple(g for g in whole.grades if self._is_done(answer_id, g.question))
            if grades or not whole.grades:
                yield replace(whole, grades=grades)

    def _is_done(self, answer_id: AnswerId, question: str) -> bool:
        at = replace(answer_id, question=question)
        return self._done[at] > 0 and self._done[at] == self._of[at]
