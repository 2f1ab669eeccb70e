"""Final grades: automatic grades, manual marks, overrides and late penalties combined."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Any, Literal

from fieldgrade.checking.results import Grade, Record, Results
from fieldgrade.class_folder.decisions import Decisions, require_known
from fieldgrade.class_folder.late_policy import late_factor, moment

SHARE = 0.1
"""Without assignments, a notebook counts if this share of the most submitted one submitted it."""

How = Literal["checked", "read", "override", "open"]
LineOutcome = Literal["right", "half", "wrong", "missing", "open"]


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
    title : str
        The title of the question.
    function : str
        The requested function; empty for a written answer.
    counts : bool
        Whether its points count. Those of an optional question do not, unless the instructor
        decided so.
    """

    question: str
    points: float
    possible: float
    how: How
    comment: str = ""
    grade: Grade | None = None
    title: str = ""
    function: str = ""
    counts: bool = True

    @property
    def outcome(self) -> LineOutcome:
        """Whether the answer earned all its points, some or none, is missing, or has no mark."""
        if self.how == "open":
            return "open"
        if self.points >= self.possible:
            return "right"
        if self.points:
            return "half"
        finding = None if self.grade is None else self.grade.verdict.finding
        return "missing" if finding in ("missing", "unwritten") else "wrong"


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
    uncounted : tuple of Record
        Submissions of notebooks that do not count for the class.
    """

    student: Mapping[str, str]
    notebook: str
    lines: tuple[GradeLine, ...]
    record: Record | None = None
    late_factor: float = 1.0
    unreadable: tuple[Record, ...] = ()
    uncounted: tuple[Record, ...] = ()

    @property
    def earned(self) -> float:
        """The points before the late penalty."""
        return sum(line.points for line in self.lines if line.counts)

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
        return sum(line.possible for line in self.lines if line.counts)

    @property
    def waiting(self) -> int:
        """How many answers that count are not graded yet."""
        return sum(line.how == "open" and line.counts for line in self.lines)

    @property
    def has_grade(self) -> bool:
        """Whether there is a grade: by the grader, unless it failed, or by the staff."""
        by_grader = self.record is not None and self.record.status != "grader failed"
        return by_grader or any(line.how in ("read", "override") for line in self.lines)

    @property
    def status(self) -> str:
        """The status of the submission, or that there is none."""
        return self.record.status if self.record else "not submitted"


def grade_sheets(results: Results, decisions: Decisions | None = None) -> list[GradeSheet]:
    """Return a sheet for each student and notebook, in the order of the roster.

    If a student submitted a notebook several times, the last submission counts. Students who are
    not on the roster come last. The notebooks are listed by `counted_notebooks`.

    Parameters
    ----------
    results : Results
        The results of the grader.
    decisions : Decisions, optional
        The decisions of the staff.

    Raises
    ------
    ValueError
        A decision names no existing answer, or gives more points than possible, or no submitted
        notebook is an assignment.
    """
    decisions = decisions or Decisions()
    in_code = {q["question"] for q in results.questions if q["kind"] == "code"}
    worth = {q["question"]: float(q["points"]) for q in results.questions}
    require_known(decisions, everybody(results), worth, in_code)
    submitted = {record.notebook for record in results.records} - {""}
    if submitted and not counted_notebooks(results, decisions):
        names = ", ".join(sorted(submitted))
        raise ValueError(f"assignments.csv has no line for any submitted notebook, such as {names}")
    return compute_sheets(results, decisions)


def compute_sheets(results: Results, decisions: Decisions) -> list[GradeSheet]:
    """Return the same as `grade_sheets`, without validating the decisions."""
    counting = _last(results.records)
    notebooks = counted_notebooks(results, decisions)

    def sheet(student: Mapping[str, str], notebook: str) -> GradeSheet:
        name = student["student"]
        record = counting.get((name, notebook))
        return GradeSheet(
            student,
            notebook,
            tuple(_lines(name, asked[notebook], record, decisions)),
            record,
            _late_factor(record, decisions),
            tuple(r for r in files[name] if not r.notebook),
            tuple(r for r in files[name] if r.notebook and r.notebook not in notebooks),
        )

    students = everybody(results)
    files: dict[str, list[Record]] = {name: [] for name in students}
    for record in results.records:
        files[record.student].append(record)
    asked = {n: [q for q in results.questions if q["notebook"] == n] for n in notebooks}

    return [sheet(student, notebook) for student in students.values() for notebook in notebooks]


def counted_notebooks(results: Results, decisions: Decisions) -> list[str]:
    """Return the notebooks whose points count for everybody in the class, in order.

    If ``assignments.csv`` has lines, they are the submitted notebooks that it lists. Otherwise they
    are the notebooks that at least a tenth as many students submitted as the most submitted one,
    and more than one student if more than two submitted that one. A notebook that a student
    submitted by mistake therefore adds no points to the totals of the others.
    """
    submitted = {(record.student, record.notebook) for record in results.records}
    students = Counter(notebook for _, notebook in submitted if notebook)
    if decisions.assignments:
        return sorted(students.keys() & decisions.assignments.keys())
    most = max(students.values(), default=0)
    fewest = max(SHARE * most, 2 if most > 2 else 1)
    return sorted(notebook for notebook, count in students.items() if count >= fewest)


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
    asked: Iterable[Mapping[str, Any]],
    record: Record | None,
    decisions: Decisions,
) -> Iterator[GradeLine]:
    """Yield the points of each question: from an override, else a mark, else the grader."""
    grades = {grade.question: grade for grade in (record.grades if record else ())}
    for entry in asked:
        question, possible = entry["question"], float(entry["points"])
        about = {
            "title": entry.get("title", ""),
            "function": entry["function"],
            "counts": not entry.get("optional") or decisions.counts_optional(entry["notebook"]),
        }
        grade = grades.get(question)
        override = decisions.override(student, question)
        mark = decisions.mark(student, question)
        if override:
            points, why = override.points, override.reason
            yield GradeLine(question, points, possible, "override", why, grade, **about)
        elif mark:
            yield GradeLine(question, mark.points, possible, "read", mark.comment, **about)
        elif grade:
            yield GradeLine(question, grade.points, grade.possible, "checked", "", grade, **about)
        else:
            yield GradeLine(question, 0.0, possible, "open" if record else "checked", **about)


def _late_factor(record: Record | None, decisions: Decisions) -> float:
    if record is None or not record.received or record.notebook not in decisions.assignments:
        return 1.0
    extension = decisions.extensions.get((record.student, record.notebook))
    policy = decisions.assignments[record.notebook].policy
    return late_factor(moment(record.received), policy, extension.until if extension else None)


def by_student(sheets: Iterable[GradeSheet]) -> list[list[GradeSheet]]:
    """Return the sheets of each student together; they are in the order of students."""
    return [list(row) for _, row in groupby(sheets, key=lambda s: s.student["student"])]
