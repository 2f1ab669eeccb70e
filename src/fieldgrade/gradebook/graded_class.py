"""A graded class: its results with the tables, the notebooks and the received files."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from fieldgrade.authoring.build import all_sources
from fieldgrade.authoring.sources import Source
from fieldgrade.checking.results import Record, Results, read_results
from fieldgrade.class_folder.decisions import ClassFolder, Decisions
from fieldgrade.class_folder.roster import file_names
from fieldgrade.gradebook.grade_sheets import GradeSheet, grade_sheets
from fieldgrade.submissions.archive import Archive
from fieldgrade.submissions.submission import MOST_RECEIVED, Submission
from fieldrecon._core.atomic_files import write_if_changed

DEFAULT_FOLDER = Path("class")


@dataclass(frozen=True)
class GradedClass:
    """The results of a class and all that belongs to them, read when it is needed.

    Parameters
    ----------
    given : Path
        ``results.json``, or the folder with it.
    folder_name : Path, optional
        The folder with the tables of the class; ``class`` if not given.
    out_folder : Path, optional
        Where to write; beside the results if not given.
    root : Path
        The checkout.
    """

    given: Path
    folder_name: Path | None = None
    out_folder: Path | None = None
    root: Path = Path()

    @property
    def file(self) -> Path:
        """The file of results."""
        return self.given / "results.json" if self.given.is_dir() else self.given

    @property
    def out(self) -> Path:
        """The folder to write to."""
        return self.out_folder or self.file.parent

    @property
    def folder(self) -> ClassFolder:
        """The tables of the class.

        Raises
        ------
        ValueError
            The folder was named and does not exist: its decisions would have no effect.
        """
        if self.folder_name is not None and not self.folder_name.is_dir():
            raise ValueError(f"there is no folder {self.folder_name}")
        return ClassFolder(self.folder_name or DEFAULT_FOLDER)

    @cached_property
    def results(self) -> Results:
        """The results of the grader."""
        return read_results(self.file)

    @cached_property
    def decisions(self) -> Decisions:
        """The decisions of the staff."""
        return self.folder.decisions()

    @cached_property
    def sheets(self) -> list[GradeSheet]:
        """The final grades."""
        return grade_sheets(self.results, self.decisions)

    @cached_property
    def sources(self) -> dict[str, Source]:
        """The sources of the submitted notebooks, by number."""
        numbers = {sheet.notebook for sheet in self.sheets}
        return {s.number: s for s in all_sources(self.root) if s.number in numbers}

    @property
    def titles(self) -> dict[str, str]:
        """The titles of the submitted notebooks, by number."""
        return {number: source.title for number, source in self.sources.items()}

    @cached_property
    def names(self) -> dict[str, str]:
        """A file name for each student."""
        return file_names(dict.fromkeys(sheet.student["student"] for sheet in self.sheets))

    def write(self, name: str, text: str) -> Path:
        """Write a file to the output folder, unless it is there unchanged, and return its path."""
        return write_if_changed(self.out / name, text.encode("utf-8", "replace"))

    def submission(self, record: Record) -> Submission:
        """Return a submission from the archive beside the results."""
        content = Archive(self.file.parent / "received").read(record.digest, MOST_RECEIVED)
        return Submission(record.student, record.file, content)

    def records(self, notebook: str) -> dict[str, Record]:
        """Return the graded submissions of a notebook, by student."""
        return {
            sheet.record.student: sheet.record
            for sheet in self.sheets
            if sheet.record and sheet.notebook == notebook
        }
