"""Which grades changed since the class was graded before, and why.

Final grades are compared: automatic grades, marks, overrides and late penalties. All reasons that
apply are reported; if both the answer and the grader changed, either may be the cause.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from fieldgrade.checking.results import Results, read_results
from fieldgrade.class_folder.csv_tables import to_csv
from fieldgrade.class_folder.decisions import ClassFolder, Decisions, saved_decisions
from fieldgrade.gradebook.grade_sheets import GradeLine, GradeSheet, compute_sheets

TOLERANCE = 1e-9
LATE = "late"
"""Replaces the number of the question for a changed late penalty of a notebook."""
COLUMNS = ("student", "question", "before", "now", "reasons")


@dataclass(frozen=True)
class Difference:
    """A grade that changed.

    Parameters
    ----------
    student, question : str
        The student and the question; ``"02 late"`` is the late penalty.
    before, now : float, optional
        Points; None if nothing was graded.
    reasons : tuple of str
        The reasons.
    """

    student: str
    question: str
    before: float | None
    now: float | None
    reasons: tuple[str, ...]


@dataclass(frozen=True)
class GradedState:
    """The results and the decisions at one time."""

    results: Results
    decisions: Decisions

    def sheets(self) -> dict[tuple[str, str], GradeSheet]:
        """Return the sheets by student and notebook."""
        found = compute_sheets(self.results, self.decisions)
        return {(sheet.student["student"], sheet.notebook): sheet for sheet in found}


def before(results: Path) -> Path:
    """Return the previous results: the last of the history, or these if there is none."""
    earlier = sorted((results.parent / "history").glob("[0-9][0-9][0-9][0-9].json"))
    return earlier[-1] if earlier else results


def compared(results: Path, folder: ClassFolder, earlier: Path | None = None) -> list[Difference]:
    """Return the differences from earlier results with the decisions of that time.

    Parameters
    ----------
    results : Path
        The file of results.
    folder : ClassFolder
        The current decisions.
    earlier : Path, optional
        A file of the history; otherwise the last.
    """
    earlier = earlier or before(results)
    decisions = folder.decisions()
    then = saved_decisions(earlier)
    return differences(
        GradedState(read_results(earlier), decisions if then is None else then),
        GradedState(read_results(results), decisions),
    )


def differences(then: GradedState, now: GradedState) -> list[Difference]:
    """Return the grades that changed, in the order of students and questions."""
    old, new = then.sheets(), now.sheets()
    shared = _shared(then.results, now.results)
    return [
        difference
        for key in dict.fromkeys([*new, *old])
        for difference in _of_sheets(old.get(key), new.get(key), shared)
    ]


def _of_sheets(
    old: GradeSheet | None, new: GradeSheet | None, shared: list[str]
) -> Iterator[Difference]:
    """Yield what changed in a notebook of a student."""
    sheet = new or old
    if sheet is None:
        return
    student, lines, was = sheet.student["student"], _lines(new), _lines(old)
    for question in dict.fromkeys([*lines, *was]):
        points, earlier = _points(lines.get(question)), _points(was.get(question))
        if _differ(earlier, points):
            reasons = _submitted(old, new) or _reasons(
                was.get(question), lines.get(question), _answer(old, new), shared
            )
            yield Difference(student, question, earlier, points, reasons)
    lost, less = _lost(old), _lost(new)
    if _differ(lost, less):
        reasons = _submitted(old, new) or tuple(_why_late(old, new))
        yield Difference(student, f"{sheet.notebook} {LATE}", lost, less, reasons)


def _reasons(
    was: GradeLine | None, line: GradeLine | None, answer: list[str], shared: list[str]
) -> tuple[str, ...]:
    """Return why a grade changed; a decision of the staff is the only reason if it counts."""
    if was is None or line is None:
        return ("the question is new" if was is None else "the question is gone",)
    person = [*_by_person(was, line)]
    if person:
        return tuple(person)
    made = answer.copy()
    if abs(was.possible - line.possible) > TOLERANCE:
        made.append("points changed")
    if was.grade and line.grade:
        made += ["check changed"] if was.grade.made_by != line.grade.made_by else []
        made += shared
    elif line.grade or was.grade:
        made.append("graded for the first time" if line.grade else "not graded now")
    return tuple(made) or ("no recorded change: other hidden inputs, or chance",)


def _by_person(was: GradeLine, line: GradeLine) -> Iterator[str]:
    if line.how == "override":
        yield f"override: {line.comment}"
    elif was.how == "override":
        yield "override withdrawn"
    if "read" in (was.how, line.how) and line.how != "override":
        yield "marked" if line.how == "read" else "mark withdrawn"


def _shared(then: Results, now: Results) -> list[str]:
    """Return the changes that affect everybody."""
    found = ["grader changed"] if then.grader != now.grader else []
    found += ["packages changed"] if then.environment != now.environment else []
    return found + (["secret inputs"] if then.secret != now.secret else [])


def _answer(old: GradeSheet | None, new: GradeSheet | None) -> list[str]:
    """Return whether the code of the submission changed; text and pictures do not count."""
    if not (old and new and old.record and new.record) or old.record.code == new.record.code:
        return []
    return ["answer changed"]


def _submitted(old: GradeSheet | None, new: GradeSheet | None) -> tuple[str, ...]:
    had, has = old is not None and old.record, new is not None and new.record
    if has and not had:
        return ("submitted",)
    return ("withdrawn",) if had and not has else ()


def _why_late(old: GradeSheet | None, new: GradeSheet | None) -> Iterator[str]:
    if old is None or new is None or old.record is None or new.record is None:
        return
    if old.record.received != new.record.received:
        yield "submitted at another time"
    if old.late_factor != new.late_factor and old.record.received == new.record.received:
        yield "deadline or extension changed"
    if old.earned != new.earned:
        yield "points changed"


def _lines(sheet: GradeSheet | None) -> Mapping[str, GradeLine]:
    return {line.question: line for line in sheet.lines} if sheet and sheet.record else {}


def _points(line: GradeLine | None) -> float | None:
    return None if line is None or line.how == "open" else line.points


def _lost(sheet: GradeSheet | None) -> float:
    return -sheet.late_penalty if sheet and sheet.record else 0.0


def _differ(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is not other
    return abs(one - other) > TOLERANCE


def to_table(found: Iterable[Difference]) -> str:
    """Return differences as CSV."""
    return to_csv(
        COLUMNS, ((d.student, d.question, d.before, d.now, "; ".join(d.reasons)) for d in found)
    )
