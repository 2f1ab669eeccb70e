"""Decisions of the staff beside the grader: assignments, extensions, manual marks, overrides.

The decisions are tables in the folder of the class. A copy of the tables is kept beside the
results in ``decided.json``, so that a later comparison can report which grades changed because a
table changed.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

from fieldgrade.class_folder.assignments import Assignment, read_assignments
from fieldgrade.class_folder.csv_tables import short
from fieldgrade.class_folder.dismissals import Dismissal, read_dismissals
from fieldgrade.class_folder.late_policy import Extension, read_extensions
from fieldgrade.class_folder.manual_grading import Mark, read_marks
from fieldgrade.class_folder.overrides import (
    Override,
    RegradeRequest,
    latest,
    read_overrides,
    read_requests,
)
from fieldrecon._core.atomic_files import write_atomically

T = TypeVar("T")

TABLES = ("assignments.csv", "extensions.csv", "overrides.csv", "manual/*.csv")
"""The tables that change grades after the submissions have been graded."""
MANUAL, SNAPSHOT = "manual", "decided.json"


@dataclass(frozen=True)
class Decisions:
    """The decisions of the staff, which change the automatic grades.

    Parameters
    ----------
    assignments : mapping
        Deadlines and late penalties, by notebook.
    extensions : mapping
        Extensions, by student and notebook.
    marks : sequence of Mark
        Marks for written answers.
    overrides : sequence of Override
        In the order of the table; the last one counts.
    """

    assignments: Mapping[str, Assignment] = field(default_factory=dict)
    extensions: Mapping[tuple[str, str], Extension] = field(default_factory=dict)
    marks: Sequence[Mark] = ()
    overrides: Sequence[Override] = ()

    def override(self, student: str, question: str) -> Override | None:
        """Return the override that counts, if there is one."""
        return latest(self.overrides).get((student, question))

    def mark(self, student: str, question: str) -> Mark | None:
        """Return the manual mark of an answer, if there is one."""
        key = (student, question)
        return next((m for m in self.marks if (m.student, m.question) == key), None)

    def counts_optional(self, notebook: str) -> bool:
        """Return whether the points of optional questions of a notebook count."""
        return notebook in self.assignments and self.assignments[notebook].counts_optional


def require_known(
    decisions: Decisions, students: Collection[str], worth: Mapping[str, float], in_code: set[str]
) -> None:
    """Refuse decisions without effect or out of range, which are probably typing errors.

    Parameters
    ----------
    decisions : Decisions
        All decisions.
    students : collection of str
        Everybody in the class.
    worth : mapping
        The points of each question.
    in_code : set of str
        The questions that are answered in code.

    Raises
    ------
    ValueError
        One line for each problem.
    """
    problems: list[str] = []
    given: list[Mark | Override] = [*decisions.marks, *decisions.overrides]
    for decision in given:
        what = f"{short(decision.points)} points for {decision.student}, {decision.question}"
        if decision.student not in students:
            problems.append(f"{what}: no such student is on the roster")
        elif decision.question not in worth:
            problems.append(f"{what}: there is no such question")
        elif decision.points > worth[decision.question]:
            problems.append(f"{what}: the question is worth {short(worth[decision.question])}")
        elif isinstance(decision, Mark) and decision.question in in_code:
            problems.append(f"{what}: this answer is code; write an override instead")
    for name in sorted({student for student, _ in decisions.extensions} - set(students)):
        problems.append(f"an extension for {name}: no such student is on the roster")
    if problems:
        raise ValueError("\n".join(problems))


@dataclass(frozen=True)
class ClassFolder:
    """The folder of a class with its tables, each of which may be missing.

    Parameters
    ----------
    folder : Path
        The folder with ``assignments.csv``, ``extensions.csv``, ``overrides.csv``,
        ``requests.csv`` and ``manual/``.
    """

    folder: Path

    def decisions(self) -> Decisions:
        """Return the decisions in the tables.

        Raises
        ------
        ValueError
            A table has invalid lines; the message has one line for each.
        """
        return Decisions(
            self._read("assignments.csv", read_assignments, {}),
            self._read("extensions.csv", read_extensions, {}),
            read_marks(self.folder / MANUAL),
            self._read("overrides.csv", read_overrides, []),
        )

    def dismissals(self) -> Mapping[str, Dismissal]:
        """Return the dismissed entries of the list *needs your eyes*."""
        return self._read("dismissed.csv", read_dismissals, {})

    def requests(self) -> list[RegradeRequest]:
        """Return the regrade requests."""
        return self._read("requests.csv", read_requests, [])

    def _read(self, name: str, read: Callable[[Path], T], otherwise: T) -> T:
        file = self.folder / name
        return read(file) if file.is_file() else otherwise

    def texts(self) -> dict[str, str]:
        """Return the tables that change grades, as text, by name."""
        found = (file for pattern in TABLES for file in sorted(self.folder.glob(pattern)))
        return {
            file.relative_to(self.folder).as_posix(): file.read_text("utf-8-sig", "replace")
            for file in found
        }


def save_decisions(out: Path, folder: ClassFolder) -> None:
    """Save a copy of the tables beside the results, after these have been written.

    The copy of the earlier tables moves to ``history/``, beside the earlier results.
    """
    file = out / SNAPSHOT
    text = json.dumps(folder.texts(), indent=1) + "\n"
    if file.is_file():
        if file.read_text(encoding="utf-8") == text and not _without_snapshot(out):
            return
        for earlier in _without_snapshot(out):
            write_atomically(earlier, file.read_bytes())
    write_atomically(file, text.encode())


def saved_decisions(results: Path) -> Decisions | None:
    """Return the decisions at the time of some results; None if they were not saved."""
    file = _snapshot_of(results)
    if results.name == "results.json":
        file = results.parent / SNAPSHOT
    elif not file.is_file():  # replaced by a run whose decisions have not been saved yet
        file = results.parent.parent / SNAPSHOT
    if not file.is_file():
        return None
    texts: Mapping[str, str] = json.loads(file.read_text(encoding="utf-8"))
    with TemporaryDirectory() as folder:
        for name, text in texts.items():
            write_atomically(Path(folder) / name, text.encode())
        return ClassFolder(Path(folder)).decisions()


def _without_snapshot(out: Path) -> list[Path]:
    """Return the missing copies of tables of earlier results."""
    earlier = sorted((out / "history").glob("[0-9][0-9][0-9][0-9].json"))
    return [m for m in map(_snapshot_of, earlier) if not m.is_file()]


def _snapshot_of(results: Path) -> Path:
    return results.with_name(f"{results.stem}-{SNAPSHOT}")
