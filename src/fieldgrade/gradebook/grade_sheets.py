"""Final grades: automatic grades, manual marks, overrides and late penalties combined."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Literal

from fieldcheck.verdict import TITLES
from fieldgrade.checking.results import Grade, Record, Results
from fieldgrade.class_folder.csv_tables import short
from fieldgrade.class_folder.decisions import Decisions, require_known
from fieldgrade.class_folder.late_policy import late_factor, moment

NOT_YET = "Not graded yet."

How = Literal["checked", "read", "override", "open"]


@dataclass(frozen=True)
class GradeLine:
    """The final points of one question.

    Parameters
    ----------
    question : str
        Its name.
    points, possible : float
        Points earned, and the largest possible number.
    how : str
        Graded by the grader (``"checked"``), by hand (``"read"``), by an ``"override"``, or not yet
        (``"open"``): a written answer without a mark.
    comment : str
        The comment of the marker, or the reason of the override.
    grade : Grade, optional
        The automatic grade.
    """

    question: str
    points: float
    possible: float
    how: How
    comment: str = ""
    grade: Grade | None = None


@dataclass(frozen=True)
class GradeSheet:
    """The final points of one student for one notebook.

    Parameters
    ----------
    student : mapping
        The line of the roster.
    notebook : str
        The number of the notebook.
    lines : tuple of GradeLine
        One for each question.
    record : Record, optional
        The graded submission, if there is one.
    late_factor : float
        The share of the points that remains after the late penalty.
    unreadable : tuple of Record
        Other submitted files, which are unreadable.
    """

    student: Mapping[str, str]
    notebook: str
    lines: tuple[GradeLine, ...]
    record: Record | None = None
    late_factor: float = 1.0
    unreadable: tuple[Record, ...] = ()

    @property
    def earned(self) -> float:
        """The points before the late penalty."""
        return sum(line.points for line in self.lines)

    @property
    def points(self) -> float:
        """The points after the late penalty, to two decimals."""
        return round(self.earned * self.late_factor, 2)

    @property
    def late_penalty(self) -> float:
        """The late penalty."""
        return round(self.earned - self.points, 2)

    @property
    def possible(self) -> float:
        """The points that could be earned."""
        return sum(line.possible for line in self.lines)

    @property
    def status(self) -> str:
        """The status of the submission, or that there is none."""
        return self.record.status if self.record else "not submitted"


def grade_sheets(results: Results, decisions: Decisions | None = None) -> list[GradeSheet]:
    """Return a sheet for each student and notebook, in the order of the roster.

    If a student submitted a notebook several times, the last submission counts. Students who are
    not on the roster come last; notebooks that nobody submitted are left out.

    Parameters
    ----------
    results : Results
        The results of the grader.
    decisions : Decisions, optional
        The decisions of the staff.

    Raises
    ------
    ValueError
        A decision names no existing answer, or gives more points than possible.
    """
    decisions = decisions or Decisions()
    in_code = {q["question"] for q in results.questions if q["kind"] == "code"}
    require_known(decisions, everybody(results), _worth(results), in_code)
    return compute_sheets(results, decisions)


def compute_sheets(results: Results, decisions: Decisions) -> list[GradeSheet]:
    """Return the same as `grade_sheets`, without validating the decisions."""
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
            _late_factor(record, decisions),
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
    """Return the students by name: the roster, then submitters who are not on it."""
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
    """Yield the points of each question: from an override, else a mark, else the grader."""
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


def _late_factor(record: Record | None, decisions: Decisions) -> float:
    if record is None or not record.received or record.notebook not in decisions.assignments:
        return 1.0
    extension = decisions.extensions.get((record.student, record.notebook))
    policy = decisions.assignments[record.notebook].policy
    return late_factor(moment(record.received), policy, extension.until if extension else None)


def by_student(sheets: Iterable[GradeSheet]) -> list[list[GradeSheet]]:
    """Return the sheets of each student together; they are in the order of students."""
    return [list(row) for _, row in groupby(sheets, key=lambda s: s.student["student"])]


def said_of(line: GradeLine) -> tuple[str, str]:
    """Return the feedback on an answer: a title, and a sentence, which may be empty."""
    if line.how == "open":
        return line.question, NOT_YET
    if line.grade is None:
        return line.question, line.comment
    title = f"{line.question} {TITLES[line.grade.verdict.rung].lstrip('— ')}"
    changed = f"Changed by the staff: {line.comment}" if line.how == "override" else ""
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
    """Return the feedback on a notebook as a whole: the late penalty."""
    return (
        [f"Submitted late: {short(sheet.late_penalty)} points less."] if sheet.late_penalty else []
    )
