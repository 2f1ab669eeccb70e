"""What counts: the grader's points, a reader's, a person's override, and what being late costs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from fieldrecon.course.gradebook.assignments import Assignment
from fieldrecon.course.gradebook.late import Extension, kept, moment
from fieldrecon.course.gradebook.overrides import Override, latest
from fieldrecon.course.grading.results import Grade, Record, Results
from fieldrecon.course.grading.tables import short

How = Literal["checked", "read", "override", "open"]


@dataclass(frozen=True)
class Mark:
    """What a reader gave for an answer in words."""

    student: str
    question: str
    points: float
    comment: str = ""


@dataclass(frozen=True)
class Line:
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
class Sheet:
    """What one student earns with one notebook.

    Parameters
    ----------
    student : mapping
        Who, as on the roster.
    notebook : str
        Which.
    lines : tuple of Line
        One for each question.
    record : Record, optional
        The submission that counts; without one nothing was handed in.
    kept : float
        The part of the points that being late leaves.
    """

    student: Mapping[str, str]
    notebook: str
    lines: tuple[Line, ...]
    record: Record | None = None
    kept: float = 1.0

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


@dataclass(frozen=True)
class Decisions:
    """What people decided, beside what was graded.

    Parameters
    ----------
    assignments : mapping
        Deadlines, by notebook.
    extensions : mapping
        By student and notebook.
    marks : sequence of Mark
        Of answers in words.
    overrides : sequence of Override
        In the order in which they were written; the last counts.
    """

    assignments: Mapping[str, Assignment] = field(default_factory=dict)
    extensions: Mapping[tuple[str, str], Extension] = field(default_factory=dict)
    marks: Sequence[Mark] = ()
    overrides: Sequence[Override] = ()

    def override(self, student: str, question: str) -> Override | None:
        """Return the override that counts, if there is one."""
        return latest(self.overrides).get((student, question))

    def mark(self, student: str, question: str) -> Mark | None:
        """Return what a reader gave, if somebody has read it."""
        key = (student, question)
        return next((m for m in self.marks if (m.student, m.question) == key), None)


def gradebook(results: Results, decisions: Decisions | None = None) -> list[Sheet]:
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
    counting = _last(results.records)
    students = {student["student"]: student for student in results.students}
    students |= {name: {"student": name} for name, _ in sorted(counting) if name not in students}
    worth = {q["question"]: float(q["points"]) for q in results.questions}
    notebooks = sorted({notebook for _, notebook in counting})
    _require_known(decisions, set(students), worth)
    return [
        Sheet(
            student, notebook,
            tuple(_lines(name, notebook, worth, counting.get((name, notebook)), decisions)),
            counting.get((name, notebook)),
            _kept(counting.get((name, notebook)), decisions),
        )
        for name, student in students.items() for notebook in notebooks
    ]  # fmt: skip


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
) -> Iterator[Line]:
    """Yield what each question earns: by an override if there is one, else as it was read or run."""
    grades = {grade.question: grade for grade in (record.grades if record else ())}
    for question, possible in worth.items():
        if question.partition(".")[0] != notebook:
            continue
        grade = grades.get(question)
        override = decisions.override(student, question)
        mark = decisions.mark(student, question)
        if override:
            yield Line(question, override.points, possible, "override", override.reason, grade)
        elif mark:
            yield Line(question, mark.points, possible, "read", mark.comment)
        elif grade:
            yield Line(question, grade.points, grade.possible, "checked", "", grade)
        else:
            yield Line(question, 0.0, possible, "open" if record else "checked")


def _kept(record: Record | None, decisions: Decisions) -> float:
    if record is None or not record.received or record.notebook not in decisions.assignments:
        return 1.0
    extension = decisions.extensions.get((record.student, record.notebook))
    policy = decisions.assignments[record.notebook].policy
    return kept(moment(record.received), policy, extension.until if extension else None)


def _require_known(decisions: Decisions, students: set[str], worth: Mapping[str, float]) -> None:
    """Refuse decisions that would be without effect, or out of range: they are mistyped."""
    problems = []
    for decision in (*decisions.marks, *decisions.overrides):
        what = f"{short(decision.points)} points for {decision.student}, {decision.question}"
        if decision.student not in students:
            problems.append(f"{what}: nobody of that name is on the roster")
        elif decision.question not in worth:
            problems.append(f"{what}: there is no such question")
        elif decision.points > worth[decision.question]:
            problems.append(f"{what}: the question is worth {short(worth[decision.question])}")
    for name in sorted({student for student, _ in decisions.extensions} - students):
        problems.append(f"an extension for {name}: nobody of that name is on the roster")
    if problems:
        raise ValueError("\n".join(problems))
