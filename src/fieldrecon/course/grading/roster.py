"""Who is in the class, what the questions are worth, and when files came: a CSV file each."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection, Iterable, Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from fieldrecon.course.gradebook.late import moment
from fieldrecon.course.grading.tables import Row, notebook, points, question, read_table


@dataclass(frozen=True)
class Student:
    """A line of the roster; only the first column must be filled.

    Parameters
    ----------
    student : str
        The name or number from which the student's inputs are drawn: as in ``student.txt``.
    name : str
        ``"Ada Lovelace"`` or ``"Lovelace, Ada"``.
    email, login : str
        As the learning platform has them.
    canvas_id, sis_id, section : str
        The columns ID, SIS User ID and Section of Canvas.
    moodle_id : str
        The number of the participant, which Moodle writes into the names of files.
    """

    student: str
    name: str = ""
    email: str = ""
    login: str = ""
    canvas_id: str = ""
    sis_id: str = ""
    section: str = ""
    moodle_id: str = ""


OPTIONAL = tuple(field.name for field in fields(Student))[1:]


def read_roster(path: Path) -> dict[str, Student]:
    """Return the students of a file, by the first column, in its order.

    Raises
    ------
    ValueError
        What is wrong, line by line.
    """
    found: dict[str, Student] = {}

    def student(row: Row) -> Student:
        who = Student(**row)
        if who.student.lower() in (name.lower() for name in found):
            raise ValueError(f"{who.student} stands on the list twice")
        found[who.student] = who
        return who

    read_table(path, student, ("student",), OPTIONAL)
    return found


def read_points(path: Path, known: Collection[str]) -> dict[str, float]:
    """Return what questions are worth, where it differs. Columns: question, points.

    Raises
    ------
    ValueError
        What is wrong, line by line.
    """

    def worth(row: Row) -> tuple[str, float]:
        name = question(row["question"])
        if name not in known:
            raise ValueError(f"there is no question {name}")
        return name, points(row["points"])

    return dict(read_table(path, worth, ("question", "points")))


def read_times(path: Path) -> dict[tuple[str, str], str]:
    """Return when files came, by student and notebook. Columns: student, notebook, received.

    Raises
    ------
    ValueError
        What is wrong, line by line.
    """

    def time(row: Row) -> tuple[tuple[str, str], str]:
        key = row["student"], notebook(row["notebook"])
        return key, moment(row["received"]).isoformat()

    return dict(read_table(path, time, ("student", "notebook", "received")))


@dataclass(frozen=True)
class Owner:
    """What the place of a file tells of whose it is.

    Parameters
    ----------
    text : str
        A name, as it stands there.
    number : str
        The number that the platform gives to the student, if it stands there.
    email : str
        An address, if it stands there.
    platform : str
        ``"canvas"``, ``"moodle"``, ``"gradescope"``, or nothing.
    """

    text: str
    number: str = ""
    email: str = ""
    platform: str = ""


def student_of(owner: Owner, roster: Mapping[str, Student]) -> str:
    """Return the student whose file it is; one who is not on the roster by the name in the file."""
    for found in _candidates(owner, roster.values()):
        return found.student
    return owner.text


def _candidates(owner: Owner, students: Iterable[Student]) -> list[Student]:
    """Return the student that fits by the surest sign; none where two fit equally well."""
    everybody = list(students)
    signs = (
        lambda s: owner.number and owner.number in (getattr(s, f"{owner.platform}_id", ""),),
        lambda s: _same(owner.email, s.email),
        lambda s: any(_same(owner.text, o) for o in (s.student, s.login, s.email, s.sis_id)),
        lambda s: owner.number and owner.number in (s.student, s.sis_id),
        lambda s: _letters(owner.text) and _letters(owner.text) in _spellings(s.name),
        lambda s: _stands_in(s.student, owner.text) or _stands_in(s.login, owner.text),
    )
    for sign in signs:
        fitting = [student for student in everybody if sign(student)]
        if len(fitting) == 1:
            return fitting
    return []


def _same(one: str, other: str) -> bool:
    return bool(one) and one.strip().lower() == other.strip().lower()


def _stands_in(name: str, text: str) -> bool:
    """Whether a name stands in a text as a word of its own."""
    word = rf"(?<![^\W_]){re.escape(name)}(?![^\W_])"
    return bool(name) and re.search(word, text, re.IGNORECASE) is not None


def _spellings(name: str) -> set[str]:
    """Return a name as platforms write it: the first name in front, or the last."""
    last, comma, first = name.partition(",")
    words = [*first.split(), *last.split()] if comma else name.split()
    turned = {_letters("".join(words[k:] + words[:k])) for k in range(len(words))}
    return {text for text in turned if text}


def _letters(text: str) -> str:
    """Return the letters and digits of a text, without accents and case."""
    plain = unicodedata.normalize("NFKD", text.casefold())
    return "".join(c for c in plain if c.isalnum())


def columns(student: Student) -> dict[str, str]:
    """Return the columns of a student that are filled."""
    return {name: value for name, value in asdict(student).items() if value}
