"""A run of the grader: its input, output and cache folders, and its results."""

from __future__ import annotations

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
from fieldgrade.checking.results import (
    Record,
    Results,
    merged,
    read_results,
    require_known_version,
    write_results,
)
from fieldgrade.class_folder.private import keep_out_of_git
from fieldgrade.class_folder.roster import Student, columns, read_points, read_roster, read_times
from fieldgrade.grading.batch import GradingTask
from fieldgrade.grading.ledger import Ledger
from fieldgrade.isolation.server import BANNER, Server, Tier, tiers
from fieldgrade.submissions.archive import Archive
from fieldgrade.submissions.collection import ReceivedFile
from fieldgrade.submissions.intake import Intake

RESULTS = "results.json"


@dataclass(frozen=True)
class Choice:
    """The part of a class that is graded; all of it by default."""

    notebooks: Collection[str] = ()
    question: str = ""
    student: str = ""

    def has(self, file: ReceivedFile) -> bool:
        """Whether a received file belongs to this part."""
        wanted = {self.question[:2]} - {""} or set(self.notebooks)
        if self.student and file.student.lower() != self.student.lower():
            return False
        return not wanted or file.notebook in wanted


@dataclass(frozen=True)
class GradingRun:
    """The folders and options of a run.

    Parameters
    ----------
    submissions : Path
        The folder or zip file with the submissions.
    out : Path
        The folder of results, cache and received files.
    root : Path
        The checkout.
    tables : Path, optional
        The folder with the roster and the other tables of the class.
    tier : str
        The tier of the sandbox.
    jobs : int
        How many submissions run at once.
    choice : Choice
        The part of the class that is graded.
    """

    submissions: Path
    out: Path
    root: Path = Path()
    tables: Path | None = None
    tier: Tier = "none"
    jobs: int = 1
    choice: Choice = field(default_factory=Choice)

    # Input.

    @cached_property
    def salt(self) -> Salt:
        """The salt of the checkout."""
        return read_salt(self.root)

    @cached_property
    def course(self) -> Course:
        """The sources, the salt, and the points of the questions."""
        sources = [Source(source.path.resolve()) for source in all_sources(self.root)]
        file = self._table("points.csv")
        known = [*questions(), *(q["question"] for q in self.written_questions)]
        return Course(sources, self.salt.text, read_points(file, known) if file else {})

    @cached_property
    def written_questions(self) -> list[dict[str, Any]]:
        """The questions with written answers, as entries of the results."""
        return [
            {
                "question": question,
                "notebook": source.number,
                "kind": "words",
                "function": "",
                "points": points,
            }
            for source in all_sources(self.root)
            for question, points in source.written_points.items()
        ]

    @cached_property
    def roster(self) -> Mapping[str, Student]:
        """The students of the class; empty if there is no roster."""
        file = self._table("roster.csv")
        return read_roster(file) if file else {}

    @property
    def checks(self) -> Path | None:
        """The folder with the instructor's checks, if it exists."""
        folder = self.tables / "checks" if self.tables else None
        return folder if folder and folder.is_dir() else None

    def _table(self, name: str) -> Path | None:
        file = (self.tables or self.out) / name
        return file if self.tables and file.is_file() else None

    # Output.

    @property
    def archive(self) -> Archive:
        """The received files."""
        return Archive(self.out.resolve() / "received")

    @property
    def cache(self) -> Cache:
        """The cache of check results."""
        return Cache(self.out.resolve() / "cache")

    @property
    def ledger(self) -> Ledger:
        """The log of what ran."""
        return Ledger(
            self.out / "ledger.jsonl", environment_digest(), grader_digest(), self.salt.year
        )

    @property
    def server(self) -> Server:
        """The sandbox, not started."""
        return Server(self.tier)

    # Grading.

    @cached_property
    def taken(self) -> tuple[list[ReceivedFile], list[str]]:
        """The files to be graded, and the files that belong to no student.

        Raises
        ------
        ValueError
            There is nothing to be graded, a table is wrong, or the folder of results was written
            by another version.
        """
        if self.choice.question:
            get(self.choice.question)
        unknown = set(self.choice.notebooks) - set(self.course.functions())
        if unknown:
            raise ValueError(f"there is no notebook {', '.join(sorted(unknown))}")
        if not self.submissions.exists():
            raise ValueError(f"{self.submissions} does not exist")
        if self.out.resolve().is_relative_to(self.submissions.resolve()):
            raise ValueError(
                f"{self.out} is in {self.submissions}: results must not be among the submissions"
            )
        if (self.out / RESULTS).is_file():
            require_known_version(self.out / RESULTS)
        keep_out_of_git(self.out)
        file = self._table("received.csv")
        times = read_times(file) if file else {}
        intake = Intake(self.archive, self.course.functions(), self.roster, times)
        files = [f for f in intake.take(self.submissions) if self.choice.has(f)]
        if not files:
            raise ValueError(f"{self.submissions} contains no submission of the selection")
        return files, intake.strays

    def tasks(self) -> list[GradingTask]:
        """Return the grading tasks, in the order of students and notebooks."""
        only = {self.choice.question} - {""}
        return [
            GradingTask(f, tuple(q.name for q in self.course.asked(f.notebook, only)))
            for f in self.taken[0]
        ]

    def finish(self, records: Iterable[Record]) -> tuple[Results, bool]:
        """Write the results; return them, and whether they differ from the previous ones.

        Raises
        ------
        ValueError
            The previous results are damaged, or have a later version.
        """
        file = self.out / RESULTS
        before = read_results(file).records if file.is_file() else ()
        results = self.results(merged(self._without_assigned(before), records))
        return results, write_results(results, file)

    def _without_assigned(self, before: Iterable[Record]) -> list[Record]:
        """Return earlier records, except of strangers whose files now belong to a student.

        Otherwise the name in the download would stay in the results after the roster has been
        corrected.
        """
        if not self.roster or self.choice.student:
            return list(before)
        files = self.taken[0]
        submitters = {file.student for file in files}
        owned = {(file.name, file.digest) for file in files if file.student in self.roster}
        return [
            record
            for record in before
            if record.student in self.roster
            or record.student in submitters
            or (record.file, record.digest) not in owned
        ]

    def results(self, records: tuple[Record, ...]) -> Results:
        """Return records with roster, questions and digests."""
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
        titles = {q: t for s in self.course.sources for q, t in s.question_titles.items()}
        headers = (header for s in self.course.sources for header in s.headers.values())
        optional = {header.question for header in headers if header.is_optional}
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
        for asked in sorted((*code, *self.written_questions), key=lambda q: _order(q["question"])):
            name = asked["question"]
            entry = {"title": titles.get(name, ""), "points": worth.get(name, asked["points"])}
            yield asked | entry | ({"optional": True} if name in optional else {})


def _order(question: str) -> tuple[int, ...]:
    return tuple(map(int, question.split(".")))


def chosen_tier(tier: str = "", require_isolation: bool = False) -> tuple[Tier, str]:
    """Return the tier to use, and a warning if it is not a sandbox.

    Parameters
    ----------
    tier : str
        The requested tier; if empty, the safest one that works.
    require_isolation : bool
        Whether to refuse to grade without a sandbox.

    Raises
    ------
    ValueError
        The tier does not work on this machine, or a sandbox is required and none works.
    """
    found = tiers()
    if tier and tier not in found:
        raise ValueError(f"{tier} does not work on this machine; there are {', '.join(found)}")
    chosen = next(t for t in found if tier in ("", t))
    if require_isolation and chosen == "none":
        raise ValueError(BANNER.replace("NOT ISOLATED: ", ""))
    return chosen, BANNER if chosen == "none" else ""
