"""A run of the grader: from the folders that it is given to the results that it leaves."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from fieldcheck.questions import get, questions
from fieldgrade.authoring.build import all_sources
from fieldgrade.authoring.secret_salt import Salt, read_salt
from fieldgrade.authoring.sources import Source
from fieldgrade.checking.cache import Cache
from fieldgrade.checking.course import Course
from fieldgrade.checking.dependency_digests import environment_digest, grader_digest
from fieldgrade.checking.results import Record, Results, merged, read_results, write_results
from fieldgrade.class_folder.roster import Student, columns, read_points, read_roster, read_times
from fieldgrade.grading.batch import GradingTask
from fieldgrade.grading.ledger import Ledger
from fieldgrade.isolation.server import BANNER, Server, Tier, tiers
from fieldgrade.submissions.archive import Archive
from fieldgrade.submissions.collection import ReceivedFile
from fieldgrade.submissions.intake import Intake

RESULTS = "results.json"


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@dataclass(frozen=True)
class Choice:
    """Which part of a class is graded; everything where nothing is chosen."""

    notebooks: Collection[str] = ()
    question: str = ""
    student: str = ""

    def has(self, file: ReceivedFile) -> bool:
        """Whether something of what was handed in is to be graded."""
        wanted = {self.question[:2]} - {""} or set(self.notebooks)
        if self.student and file.student.lower() != self.student.lower():
            return False
        return not wanted or file.notebook in wanted


@dataclass(frozen=True)
class GradingRun:
    """Where everything is, and what is to be done with it.

    Parameters
    ----------
    submissions : Path
        A folder or a zip file of what a class handed in.
    out : Path
        Where the results go, and what is kept beside them.
    root : Path
        The checkout.
    tables : Path, optional
        The folder with the roster and the other tables of the class.
    tier : str
        The walls.
    jobs : int
        How many submissions are worked on at once.
    choice : Choice
        Which part of the class.
    """

    submissions: Path
    out: Path
    root: Path = Path()
    tables: Path | None = None
    tier: Tier = "none"
    jobs: int = 1
    choice: Choice = field(default_factory=Choice)

    # What is read.

    @cached_property
    def salt(self) -> Salt:
        """The salt of the checkout."""
        return read_salt(self.root)

    @cached_property
    def course(self) -> Course:
        """The sources, the salt, and what questions are worth."""
        sources = [Source(source.path.resolve()) for source in all_sources(self.root)]
        file = self._table("points.csv")
        known = [*questions(), *(q["question"] for q in self.words)]
        return Course(sources, self.salt.text, read_points(file, known) if file else {})

    @cached_property
    def words(self) -> list[dict[str, Any]]:
        """The questions that are answered in words."""
        return [
            {
                "question": question,
                "notebook": source.number,
                "kind": "words",
                "function": "",
                "points": points,
            }
            for source in all_sources(self.root)
            for question, points in source.words.items()
        ]

    @cached_property
    def roster(self) -> Mapping[str, Student]:
        """Who is in the class, if there is a list."""
        file = self._table("roster.csv")
        return read_roster(file) if file else {}

    @property
    def checks(self) -> Path | None:
        """The folder with the checks of the instructor, if there is one."""
        folder = self.tables / "checks" if self.tables else None
        return folder if folder and folder.is_dir() else None

    def _table(self, name: str) -> Path | None:
        file = (self.tables or self.out) / name
        return file if self.tables and file.is_file() else None

    # What is kept.

    @property
    def archive(self) -> Archive:
        """The files that were received."""
        return Archive(self.out.resolve() / "received")

    @property
    def cache(self) -> Cache:
        """What was found before."""
        return Cache(self.out.resolve() / "cache")

    @property
    def ledger(self) -> Ledger:
        """What ran."""
        return Ledger(
            self.out / "ledger.jsonl", environment_digest(), grader_digest(), self.salt.year
        )

    @property
    def server(self) -> Server:
        """The walls, not started."""
        return Server(self.tier)

    # What is done.

    @cached_property
    def taken(self) -> tuple[list[ReceivedFile], list[str]]:
        """What was handed in and is to be graded, and what came and is nobody's.

        Raises
        ------
        ValueError
            There is nothing to be graded, or a table is wrong.
        """
        if self.choice.question:
            get(self.choice.question)
        unknown = set(self.choice.notebooks) - set(self.course.functions())
        if unknown:
            raise ValueError(f"there is no notebook {', '.join(sorted(unknown))}")
        if not self.submissions.exists():
            raise ValueError(f"{self.submissions} is not there")
        if self.out.resolve().is_relative_to(self.submissions.resolve()):
            raise ValueError(f"{self.out} lies in {self.submissions}: results are no submissions")
        file = self._table("received.csv")
        times = read_times(file) if file else {}
        intake = Intake(self.archive, self.course.functions(), self.roster, times)
        files = [f for f in intake.take(self.submissions) if self.choice.has(f)]
        if not files:
            raise ValueError(f"{self.submissions} holds nothing of what was chosen")
        return files, intake.strays

    def tasks(self) -> list[GradingTask]:
        """Return what is to be graded, in the order of students and notebooks."""
        only = {self.choice.question} - {""}
        return [
            GradingTask(f, tuple(q.name for q in self.course.asked(f.notebook, only)))
            for f in self.taken[0]
        ]

    def finish(self, records: Iterable[Record]) -> tuple[Results, bool]:
        """Write what was found into the results; return them, and whether they differ from before.

        Raises
        ------
        ValueError
            The results of before are damaged, or of a later version.
        """
        file = self.out / RESULTS
        before = read_results(file).records if file.is_file() else ()
        results = self.results(merged(before, records))
        return results, write_results(results, file)

    def results(self, records: tuple[Record, ...]) -> Results:
        """Return records with all that is needed to understand them."""
        students = {name: columns(student) for name, student in self.roster.items()}
        for record in records:
            students.setdefault(record.student, {"student": record.student})
        return Results(
            records,
            tuple(students.values()),
            tuple(self._asked()),
            self.salt.secret,
            environment_digest(),
            grader_digest(),
        )

    def _asked(self) -> Iterator[dict[str, Any]]:
        worth = self.course.worth
        code = [
            {
                "question": q.name,
                "notebook": q.notebook,
                "kind": "code",
                "function": q.function,
                "points": float(q.points),
            }
            for q in questions().values()
        ]
        for asked in sorted((*code, *self.words), key=lambda q: _order(q["question"])):
            yield asked | {"points": worth.get(asked["question"], asked["points"])}


def _order(question: str) -> tuple[int, ...]:
    return tuple(map(int, question.split(".")))


def chosen_tier(tier: str = "", require_isolation: bool = False) -> tuple[Tier, str]:
    """Return the tier to be used, and what must be said of it.

    Parameters
    ----------
    tier : str
        The one that is wanted; the safest that works if it is empty.
    require_isolation : bool
        Whether to refuse to grade without walls.

    Raises
    ------
    ValueError
        It does not work on this machine, or there are no walls and they are required.
    """
    found = tiers()
    if tier and tier not in found:
        raise ValueError(f"{tier} does not work on this machine; there are {', '.join(found)}")
    chosen = next(t for t in found if tier in ("", t))
    if require_isolation and chosen == "none":
        raise ValueError(BANNER.replace("NOT ISOLATED: ", ""))
    return chosen, BANNER if chosen == "none" else ""
