"""What counts: the grader's points, a reader's, a person's override, and what being late costs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Literal

from fieldcheck.verdict import TITLES
from fieldgrade.checking.results import Grade, Record, Results
from fieldgrade.class_folder.csv_tables import short
from fieldgrade.class_folder.decisions import Decisions, require_known
from fieldgrade.class_folder.late_policy import kept, moment

NOT_YET = "Not graded yet."

How = Literal["checked", "read", "override", "open"]


@dataclass(frozen=True)
class GradeLine:
    """What one question earns.

    Parameters
    ----------
    question : str
        Its name.
    points, possible : float
        Earned, and to be earned.
    how : str
        ``"checked"`` by the grader, ``"read"`` by a person, changed by an ``"override"``, or still
        ``"open"``: an answer in words that nobody has read.
    comment : str
        What the reader wrote, or why it was changed.
    grade : Grade, optional
        What the grader found.
    """

    question: str
    points: float
    possible: float
    how: How
    comment: str = ""
    grade: Grade | None = None


@dataclass(frozen=True)
class GradeSheet:
    """What one student earns with one notebook.

    Parameters
    ----------
    student : mapping
        Who, as on the roster.
    notebook : str
        Which.
    lines : tuple of GradeLine
        One for each question.
    record : Record, optional
        The submission that counts; without one nothing was handed in.
    kept : float
        The part of the points that being late leaves.
    unreadable : tuple of Record
        What else the student handed in, and nobody can read.
    """

    student: Mapping[str, str]
    notebook: str
    lines: tuple[GradeLine, ...]
    record: Record | None = None
    kept: float = 1.0
    unreadable: tuple[Record, ...] = ()

    @property
    def earned(self) -> float:
        """The points before what being late costs."""
        return sum(line.points for line in self.lines)

    @property
    def points(self) -> float:
        """The points that count, to two decimals."""
        return round(self.earned * self.kept, 2)

    @property
    def lost(self) -> float:
        """What being late costs."""
        return round(self.earned - self.points, 2)

    @property
    def possible(self) -> float:
        """The points that could be earned."""
        return sum(line.possible for line in self.lines)

    @property
    def status(self) -> str:
        """How the submission went, or that there is none."""
        return self.record.status if self.record else "nothing handed in"


def grade_sheets(results: Results, decisions: Decisions | None = None) -> list[GradeSheet]:
    """Return a sheet for each student and notebook, in the order of the roster.

    Of several submissions of a student to a notebook the last one handed in counts. Who is not on
    the roster stands at the end; notebooks that nobody handed in are left out.

    Parameters
    ----------
    results : Results
        What was graded.
    decisions : Decisions, optional
        What people decided.

    Raises
    ------
    ValueError
        A decision is about nobody's answer, or grants more than a question is worth.
    """
    decisions = decisions or Decisions()
    in_code = {q["question"] for q in results.questions if q["kind"] == "code"}
    require_known(decisions, everybody(results), _worth(results), in_code)
    return compute_sheets(results, decisions)


def compute_sheets(results: Results, decisions: Decisions) -> list[GradeSheet]:
    """Return what `grade_sheets` does, whatever the decisions are."""
    counting = _last(results.records)
    worth = _worth(results)
    notebooks = sorted({notebook for _, notebook in counting})

    def sheet(student: Mapping[str, str], notebook: str) -> GradeSheet:
        name = student["student"]
        record = counting.get((name, notebook))
        return GradeSheet(
            student,
            notebook,
            tuple(_lines(name, notebook, worth, record, decisions)),
            record,
            _kept(record, decisions),
            tuple(r for r in results.records if r.student == name and not r.notebook),
        )

    return [
        sheet(student, notebook)
        for student in everybody(results).values()
        for notebook in notebooks
    ]


def _worth(results: Results) -> dict[str, float]:
    return {q["question"]: float(q["points"]) for q in results.questions}


def everybody(results: Results) -> dict[str, Mapping[str, str]]:
    """Return the students by name: the roster, then who handed something in and is not on it."""
    students = {student["student"]: student for student in results.students}
    others = sorted({record.student for record in results.records} - set(students))
    return students | {name: {"student": name} for name in others}


def _last(records: Iterable[Record]) -> dict[tuple[str, str], Record]:
    """Return the submission that counts, by student and notebook."""
    last: dict[tuple[str, str], Record] = {}
    for record in records:
        key = (record.student, record.notebook)
        if record.notebook and (key not in last or _when(record) >= _when(last[key])):
            last[key] = record
    return last


def _when(record: Record) -> float:
    return moment(record.received).timestamp() if record.received else float("-inf")


def _lines(
    student: str,
    notebook: str,
    worth: Mapping[str, float],
    record: Record | None,
    decisions: Decisions,
) -> Iterator[GradeLine]:
    """Yield what each question earns: by an override if there is one, else as read or checked."""
    grades = {grade.question: grade for grade in (record.grades if record else ())}
    for question, possible in worth.items():
        if question.partition(".")[0] != notebook:
            continue
        grade = grades.get(question)
        override = decisions.override(student, question)
        mark = decisions.mark(student, question)
        if override:
            yield GradeLine(question, override.points, possible, "override", override.reason, grade)
        elif mark:
            yield GradeLine(question, mark.points, possible, "read", mark.comment)
        elif grade:
            yield GradeLine(question, grade.points, grade.possible, "checked", "", grade)
        else:
            yield GradeLine(question, 0.0, possible, "open" if record else "checked")


def _kept(record: Record | None, decisions: Decisions) -> float:
    if record is None or not record.received or record.notebook not in decisions.assignments:
        return 1.0
    extension = decisions.extensions.get((record.student, record.notebook))
    policy = decisions.assignments[record.notebook].policy
    return kept(moment(record.received), policy, extension.until if extension else None)


def by_student(sheets: Iterable[GradeSheet]) -> list[list[GradeSheet]]:
    """Return the sheets of each student together; they are in the order of students."""
    return [list(row) for _, row in groupby(sheets, key=lambda s: s.student["student"])]


def said_of(line: GradeLine) -> tuple[str, str]:
    """Return what is said of an answer: a title, and a sentence that may be empty."""
    if line.how == "open":
        return line.question, NOT_YET
    if line.grade is None:
        return line.question, line.comment
    title = f"{line.question} {TITLES[line.grade.verdict.rung].lstrip('— ')}"
    changed = f"Changed by a person: {line.comment}" if line.how == "override" else ""
    return title, " ".join(filter(None, (line.grade.verdict.sentence, changed)))


def summary(sheet: GradeSheet) -> list[str]:
    """Return the feedback on a notebook, a line for each question."""
    lines = [
        f"{title} ({short(line.points)} of {short(line.possible)}). {sentence}".strip()
        for line in sheet.lines
        for title, sentence in (said_of(line),)
    ]
    return [*about(sheet), *lines]


def about(sheet: GradeSheet) -> list[str]:
    """Return what is said of a whole notebook: what being late costs."""
    return [f"Handed in late: {short(sheet.lost)} points less."] if sheet.lost else []
