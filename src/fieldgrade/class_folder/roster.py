"""The roster, the points of questions, and times of receipt: one CSV file each."""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from fieldgrade.class_folder.csv_tables import Row, notebook, points, question, read_table
from fieldgrade.class_folder.late_policy import moment
from fieldrecon._core.digests import bytes_digest

LONGEST = 50
DIGITS = 12
"""Characters of a name in a file name, and hexadecimal digits of its digest after them."""
WITH_DIGEST = re.compile(rf"(?i)-[0-9a-f]{{{DIGITS}}}$")


@dataclass(frozen=True)
class Student:
    """A line of the roster; only the first column is required.

    Parameters
    ----------
    student : str
        The name or number in ``student.txt``, from which the student's inputs are drawn.
    name : str
        ``"Ada Lovelace"`` or ``"Lovelace, Ada"``.
    email, login : str
        As in the learning platform.
    canvas_id, sis_id, section : str
        The columns ID, SIS User ID and Section of Canvas.
    moodle_id : str
        The numbers of the participant in the file names of Moodle, separated by spaces: there is
        another one in each assignment.
    """

    student: str
    name: str = ""
    email: str = ""
    login: str = ""
    canvas_id: str = ""
    sis_id: str = ""
    section: str = ""
    moodle_id: str = ""


TIMES = ("student", "notebook", "received")
OPTIONAL = tuple(field.name for field in fields(Student))[1:]
IDENTIFYING = ("email", "login", "canvas_id", "sis_id", "moodle_id")


def read_roster(path: Path) -> dict[str, Student]:
    """Return the students of a file, by the first column, in its order.

    No two lines may have the same number, address or login, since the work and the grades of one
    student would count as those of another.

    Raises
    ------
    ValueError
        Invalid lines, one message each.
    """
    students = read_table(
        path, lambda row: Student(**row), ("student",), OPTIONAL, ("student",), IDENTIFYING
    )
    return {student.student: student for student in students}


def read_points(path: Path, known: Collection[str]) -> dict[str, float]:
    """Return points that override those of the questions. Columns: question, points.

    Raises
    ------
    ValueError
        Invalid lines, one message each.
    """

    def worth(row: Row) -> tuple[str, float]:
        name = question(row["question"])
        if name not in known:
            raise ValueError(f"there is no question {name}")
        return name, points(row["points"])

    return dict(read_table(path, worth, ("question", "points"), unique=("question",)))


def read_times(path: Path) -> dict[tuple[str, str], str]:
    """Return times of receipt, by student and notebook. Columns: student, notebook, received.

    Raises
    ------
    ValueError
        Invalid lines, one message each.
    """

    def time(row: Row) -> tuple[tuple[str, str], str]:
        key = row["student"], notebook(row["notebook"])
        return key, moment(row["received"]).isoformat()

    return dict(read_table(path, time, TIMES, unique=TIMES[:2]))


def columns(student: Student) -> dict[str, str]:
    """Return the non-empty columns of a student."""
    return {name: value for name, value in asdict(student).items() if value}


def file_names(students: Iterable[str]) -> dict[str, str]:
    """Return a file name for each student: valid on every system, and unique.

    Examples
    --------
    >>> file_names(["ada", "Å. Ng"])
    {'ada': 'ada', 'Å. Ng': 'A._Ng-0b06091f4e03'}
    """
    everybody = list(students)
    plain = {student: _plain(student) for student in everybody}
    taken = Counter(name.casefold() for name in plain.values())
    return {
        student: name
        if name == student and taken[name.casefold()] == 1 and not WITH_DIGEST.search(name)
        else f"{name}-{bytes_digest(student.encode('utf-8', 'surrogatepass'))[:DIGITS]}"
        for student, name in plain.items()
    }


def _plain(student: str) -> str:
    """Return the ASCII letters and digits of a name, with . _ -; device names are changed."""
    ascii_only = unicodedata.normalize("NFKD", student).encode("ascii", "ignore").decode()
    name = re.sub(r"[^A-Za-z0-9._-]+", "_", ascii_only).strip("._-")[:LONGEST]
    reserved = re.fullmatch(r"(?i)(con|prn|aux|nul|com\d|lpt\d)(\..*)?", name)
    return f"_{name}" if reserved or not name else name
