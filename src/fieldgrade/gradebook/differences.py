"""Which grades changed since the class was graded before, and why.

A grade is what counts: the grader's points, a reader's, or an override, and what being late costs.
All reasons that apply are told; where the answer changed and the grader too, nobody knows which of
them it was.
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
"""Stands for the question where the whole notebook costs more or less for being late."""
COLUMNS = ("student", "question", "before", "now", "reasons")


@dataclass(frozen=True)
class Difference:
    """A grade that changed.

    Parameters
    ----------
    student, question : str
        Whose, and for what; ``"02 late"`` is what being late costs.
    before, now : float, optional
        Points; None where nothing was graded.
    reasons : tuple of str
        Why.
    """

    student: str
    question: str
    before: float | None
    now: float | None
    reasons: tuple[str, ...]


@dataclass(frozen=True)
class GradedState:
    """What was graded, and what was decided beside it, at one time."""

    results: Results
    decisions: Decisions

    def sheets(self) -> dict[tuple[str, str], GradeSheet]:
        """Return the sheets by student and notebook."""
        found = compute_sheets(self.results, self.decisions)
        return {(sheet.student["student"], sheet.notebook): sheet for sheet in found}


def before(results: Path) -> Path:
    """Return the results before: the last of the history, or these where there is none."""
    earlier = sorted((results.parent / "history").glob("[0-9][0-9][0-9][0-9].json"))
    return earlier[-1] if earlier else results


def compared(results: Path, folder: ClassFolder, earlier: Path | None = None) -> list[Difference]:
    """Return how grades differ from those of earlier results, with what was decided then.

    Parameters
    ----------
    results : Path
        The file of results.
    folder : ClassFolder
        What is decided now.
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
            reasons = _handed_in(old, new) or _reasons(
                was.get(question), lines.get(question), _answer(old, new), shared
            )
            yield Difference(student, question, earlier, points, reasons)
    lost, less = _lost(old), _lost(new)
    if _differ(lost, less):
        reasons = _handed_in(old, new) or tuple(_why_late(old, new))
        yield Difference(student, f"{sheet.notebook} {LATE}", lost, less, reasons)


def _reasons(
    was: GradeLine | None, line: GradeLine | None, answer: list[str], shared: list[str]
) -> tuple[str, ...]:
    """Return why a grade changed; what a person decided is the only reason, where it counts."""
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
    return tuple(made) or ("nothing that is recorded: other hidden inputs, or chance",)


def _by_person(was: GradeLine, line: GradeLine) -> Iterator[str]:
    if line.how == "override":
        yield f"override: {line.comment}"
    elif was.how == "override":
        yield "override withdrawn"
    if "read" in (was.how, line.how) and line.how != "override":
        yield "read by a person" if line.how == "read" else "reader's points withdrawn"


def _shared(then: Results, now: Results) -> list[str]:
    """Return what changed for everybody."""
    found = ["grader changed"] if then.grader != now.grader else []
    found += ["packages changed"] if then.environment != now.environment else []
    return found + (["secret inputs"] if then.secret != now.secret else [])


def _answer(old: GradeSheet | None, new: GradeSheet | None) -> list[str]:
    """Return whether another answer was handed in; words and drawings in a file change no code."""
    if not (old and new and old.record and new.record) or old.record.code == new.record.code:
        return []
    return ["answer changed"]


def _handed_in(old: GradeSheet | None, new: GradeSheet | None) -> tuple[str, ...]:
    had, has = old is not None and old.record, new is not None and new.record
    if has and not had:
        return ("handed in",)
    return ("withdrawn",) if had and not has else ()


def _why_late(old: GradeSheet | None, new: GradeSheet | None) -> Iterator[str]:
    if old is None or new is None or old.record is None or new.record is None:
        return
    if old.record.received != new.record.received:
        yield "handed in at another time"
    if old.kept != new.kept and old.record.received == new.record.received:
        yield "deadline or extension changed"
    if old.earned != new.earned:
        yield "points changed"


def _lines(sheet: GradeSheet | None) -> Mapping[str, GradeLine]:
    return {line.question: line for line in sheet.lines} if sheet and sheet.record else {}


def _points(line: GradeLine | None) -> float | None:
    return None if line is None or line.how == "open" else line.points


def _lost(sheet: GradeSheet | None) -> float:
    return -sheet.lost if sheet and sheet.record else 0.0


def _differ(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is not other
    return abs(one - other) > TOLERANCE


def to_table(found: Iterable[Difference]) -> str:
    """Return differences as CSV."""
    return to_csv(
        COLUMNS, ((d.student, d.question, d.before, d.now, "; ".join(d.reasons)) for d in found)
    )
