"""Moodle's grading worksheet with grades and feedback, and students' pages as feedback files.

The worksheet is the table that *Download grading worksheet* of an assignment gives. Moodle reads it
back by the columns Identifier, Grade, Last modified (grade) and Feedback comments; the others say
who the student is. The number of a participant belongs to one assignment, so it is known from the
worksheet alone.

References
----------
In github.com/moodle/moodle: ``mod/assign/gradingtable.php`` writes the worksheet,
``mod/assign/feedback/offline/importgradeslib.php`` and ``locallib.php`` read it, and
``mod/assign/feedback/file/importziplib.php`` reads the feedback files.
"""

from __future__ import annotations

import csv
import io
import re
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from fieldgrade.class_folder.csv_tables import short
from fieldgrade.class_folder.roster import Student
from fieldgrade.gradebook.exports import feedback_html
from fieldgrade.gradebook.grade_sheets import GradeSheet
from fieldgrade.submissions.owners import OwnerHint, students_of

FOLDER = "worksheets"
NEEDED = ("Identifier", "Full name", "Grade", "Last modified (grade)")
EMAIL, GRADE, MOST, FEEDBACK = "Email address", "Grade", "Maximum Grade", "Feedback comments"
LOCKED = ("Grade can be changed", "No")


@dataclass(frozen=True)
class Participant:
    """A line of a worksheet, with the grade of its student.

    Parameters
    ----------
    line : mapping
        The cells by column, as Moodle wrote them.
    student : str
        The student of the class; empty if there is none.
    sheet : GradeSheet, optional
        The grade of the student, if there is one.
    """

    line: Mapping[str, str]
    student: str = ""
    sheet: GradeSheet | None = None

    @property
    def number(self) -> str:
        """The number of the participant: ``"88012"`` of ``"Participant 88012"``."""
        found = re.search(r"\d+$", self.line["Identifier"])
        return found[0] if found else ""

    @property
    def filled(self) -> dict[str, str]:
        """The cells with grade and feedback; unchanged if there is no grade."""
        if self.sheet is None:
            return dict(self.line)
        new = {GRADE: short(self.sheet.points), FEEDBACK: feedback_html(self.sheet)}
        return dict(self.line) | {name: new[name] for name in new if name in self.line}

    @property
    def problem(self) -> str:
        """Why Moodle would skip the grade without a word; empty if it would not."""
        if self.sheet is None:
            return ""
        most = self.line.get(MOST, "").replace(",", ".")
        if re.fullmatch(r"\d+(\.\d+)?", most) and self.sheet.points > float(most):
            return f"{short(self.sheet.points)} points are more than the maximum grade, {most}"
        return "the grade is locked in Moodle" if self.line.get(LOCKED[0]) == LOCKED[1] else ""


def read_worksheet(file: Path, sheets: Iterable[GradeSheet]) -> list[Participant]:
    """Return the lines of a worksheet with the grades of one notebook.

    Students are matched by e-mail address, then by name.

    Raises
    ------
    ValueError
        A column is missing.
    """
    graded = {sheet.student["student"]: sheet for sheet in sheets}
    lines = list(csv.DictReader(io.StringIO(file.read_text("utf-8-sig"), newline="")))
    missing = [name for name in NEEDED if not lines or name not in lines[0]]
    if missing:
        raise ValueError(
            f"{file.name} is not a grading worksheet in English: it has no column {missing[0]!r}"
        )
    roster = {name: Student(**sheet.student) for name, sheet in graded.items()}
    hints = [OwnerHint(line["Full name"], "", line.get(EMAIL, "")) for line in lines]
    owners = students_of(hints, roster)
    found = [(line, graded.get(owners[hint])) for line, hint in zip(lines, hints, strict=True)]
    return [
        Participant(line, sheet.student["student"], sheet if sheet.has_grade else None)
        if sheet
        else Participant(line)
        for line, sheet in found
    ]


def worksheet_csv(participants: Iterable[Participant]) -> str:
    """Return the worksheet with grades and feedback."""
    rows = [participant.filled for participant in participants]
    file = io.StringIO()
    writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return file.getvalue()


def problems(
    participants: Iterable[Participant], sheets: Iterable[GradeSheet]
) -> Iterator[tuple[str, str]]:
    """Yield students whose grades would not arrive in Moodle, and why."""
    arrived = {p.student: p.problem for p in participants}
    for sheet in sheets:
        student = sheet.student["student"]
        if sheet.has_grade and arrived.get(student, "absent"):
            yield student, arrived.get(student) or "no line of the worksheet has the name"


def feedback_zip(participants: Iterable[Participant], pages: Mapping[str, Path]) -> bytes:
    """Return the file for *Upload multiple feedback files in a zip*.

    Parameters
    ----------
    participants : iterable of Participant
        The lines of the worksheet.
    pages : mapping
        The page of each student.
    """
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for participant in participants:
            page = pages.get(participant.student)
            if page and page.is_file():
                name = re.sub(r"[_/\\]", " ", participant.line["Full name"])
                folder = f"{name}_{participant.number}_assignfeedback_file"
                archive.writestr(f"{folder}/feedback.html", page.read_bytes())
    return packed.getvalue()
