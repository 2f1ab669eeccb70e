"""What people decide beside what is graded: points of readers, overrides, deadlines."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from fieldgrade.class_folder.assignments import Assignment
from fieldgrade.class_folder.csv_tables import short
from fieldgrade.class_folder.late import Extension
from fieldgrade.class_folder.overrides import Override, latest


@dataclass(frozen=True)
class Mark:
    """What a reader gave for an answer in words."""

    student: str
    question: str
    points: float
    comment: str = ""


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


def require_known(
    decisions: Decisions, students: Collection[str], worth: Mapping[str, float], in_code: set[str]
) -> None:
    """Refuse decisions that would be without effect, or out of range: they are mistyped.

    Parameters
    ----------
    decisions : Decisions
        All of them.
    students : collection of str
        Who there is.
    worth : mapping
        What each question is worth.
    in_code : set of str
        The questions that are answered in code.

    Raises
    ------
    ValueError
        What is wrong, a line each.
    """
    problems: list[str] = []
    given: list[Mark | Override] = [*decisions.marks, *decisions.overrides]
    for decision in given:
        what = f"{short(decision.points)} points for {decision.student}, {decision.question}"
        if decision.student not in students:
            problems.append(f"{what}: nobody of that name is on the roster")
        elif decision.question not in worth:
            problems.append(f"{what}: there is no such question")
        elif decision.points > worth[decision.question]:
            problems.append(f"{what}: the question is worth {short(worth[decision.question])}")
        elif isinstance(decision, Mark) and decision.question in in_code:
            problems.append(f"{what}: answers in code are checked; write an override instead")
    for name in sorted({student for student, _ in decisions.extensions} - set(students)):
        problems.append(f"an extension for {name}: nobody of that name is on the roster")
    if problems:
        raise ValueError("\n".join(problems))
