"""What lies before somebody who makes something from results: they, the class, the notebooks."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from fieldgrade.authoring.build import all_sources
from fieldgrade.authoring.sources import Source
from fieldgrade.checking.results import Record, Results, read_results
from fieldgrade.class_folder.decided import ClassFolder
from fieldgrade.class_folder.decisions import Decisions
from fieldgrade.class_folder.names import file_names
from fieldgrade.gradebook.sheets import Sheet, gradebook
from fieldgrade.submissions.archive import Archive
from fieldgrade.submissions.submission import MOST_BYTES, Submission
from fieldrecon._core.atomic_files import write_atomically

DEFAULT = "class"
"""The folder of the class, where none is named."""


@dataclass(frozen=True)
class Desk:
    """The results, and all that goes with them, read when it is asked for.

    Parameters
    ----------
    options : argparse.Namespace
        ``results``, a file or the folder that holds it; ``folder`` of the class, or None; ``out``,
        or None for beside the results; ``root``, the checkout.
    """

    options: argparse.Namespace

    @property
    def file(self) -> Path:
        """The file of results."""
        given: Path = self.options.results
        return given / "results.json" if given.is_dir() else given

    @property
    def out(self) -> Path:
        """Where to write."""
        return self.options.out or self.file.parent

    @property
    def folder(self) -> ClassFolder:
        """The tables of the class.

        Raises
        ------
        ValueError
            The folder was named, and is not there: what is decided would be without effect.
        """
        given: Path | None = self.options.folder
        if given is not None and not given.is_dir():
            raise ValueError(f"there is no folder {given}")
        return ClassFolder(given or Path(DEFAULT))

    @cached_property
    def results(self) -> Results:
        """What was graded."""
        return read_results(self.file)

    @cached_property
    def decisions(self) -> Decisions:
        """What people decided."""
        return self.folder.decisions()

    @cached_property
    def sheets(self) -> list[Sheet]:
        """What counts."""
        return gradebook(self.results, self.decisions)

    @cached_property
    def sources(self) -> dict[str, Source]:
        """The notebooks that somebody handed in."""
        numbers = {sheet.notebook for sheet in self.sheets}
        return {s.number: s for s in all_sources(self.options.root) if s.number in numbers}

    @property
    def titles(self) -> dict[str, str]:
        """Their titles."""
        return {number: source.title for number, source in self.sources.items()}

    @cached_property
    def names(self) -> dict[str, str]:
        """A name for the files of each student."""
        return file_names(dict.fromkeys(sheet.student["student"] for sheet in self.sheets))

    def write(self, name: str, text: str) -> Path:
        """Write a file, and return it."""
        file = self.out / name
        write_atomically(file, text.encode("utf-8", "replace"))
        return file

    def submission(self, record: Record) -> Submission:
        """Return what was handed in, from the archive beside the results."""
        content = Archive(self.file.parent / "received").read(record.digest, MOST_BYTES)
        return Submission(record.student, record.file, content)

    def records(self, notebook: str) -> dict[str, Record]:
        """Return the submissions of a notebook that count, by student."""
        return {
            sheet.record.student: sheet.record
            for sheet in self.sheets
            if sheet.record and sheet.notebook == notebook
        }
