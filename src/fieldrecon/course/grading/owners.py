"""Whose a file is: what its place says, compared with the roster by the surest sign first."""

from __future__ import annotations

import re
import unicodedata
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache

from fieldrecon.course.grading.roster import Student


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


def students_of(owners: Iterable[Owner], roster: Mapping[str, Student]) -> dict[Owner, str]:
    """Return the student behind each owner; who is not on the roster is called as the file says.

    Strangers of one name are told apart by their numbers: nobody's work counts as another's.
    """
    everybody = list(roster.values())
    known = {owner: _student(owner, everybody) for owner in dict.fromkeys(owners)}
    numbers: dict[str, set[str]] = defaultdict(set)
    for owner, student in known.items():
        if student is None:
            numbers[owner.text].add(owner.number)
    return {
        owner: student.student if student
        else f"{owner.text} ({owner.number})" if owner.number and len(numbers[owner.text]) > 1
        else owner.text
        for owner, student in known.items()
    }  # fmt: skip


def _student(owner: Owner, everybody: Iterable[Student]) -> Student | None:
    """Return the student who fits by the surest sign; none where two fit equally well."""
    possible = [student for student in everybody if not _is_another(student, owner)]
    text = _letters(owner.text)
    signs = (
        lambda s: owner.number and owner.number == getattr(s, f"{owner.platform}_id", ""),
        lambda s: _same(owner.email, s.email),
        lambda s: any(_same(owner.text, o) for o in (s.student, s.login, s.email, s.sis_id)),
        lambda s: owner.number and owner.number in (s.student, s.sis_id),
        lambda s: text and text in _spellings(s.name),
        lambda s: _stands_in(s.student, owner.text) or _stands_in(s.login, owner.text),
    )
    for sign in signs:
        fitting = [student for student in possible if sign(student)]
        if len(fitting) == 1:
            return fitting[0]
    return None


def _is_another(student: Student, owner: Owner) -> bool:
    """Whether Canvas says that it is somebody else, perhaps of the same name."""
    return owner.platform == "canvas" and student.canvas_id not in ("", owner.number)


def _same(one: str, other: str) -> bool:
    return bool(one) and one.strip().lower() == other.strip().lower()


def _stands_in(key: str, text: str) -> bool:
    """Whether a key with a digit in it, so not a part of a name, stands in a text as a word."""
    return any(c.isdigit() for c in key) and f" {_words(key)} " in f" {_words(text)} "


@cache
def _words(text: str) -> str:
    return " ".join(re.findall(r"[^\W_]+", text.casefold()))


@cache
def _spellings(name: str) -> frozenset[str]:
    """Return a name as platforms write it: the first name in front, or the last."""
    last, comma, first = name.partition(",")
    words = [*first.split(), *last.split()] if comma else name.split()
    turned = {_letters("".join(words[k:] + words[:k])) for k in range(len(words))}
    return frozenset(text for text in turned if text)


def _letters(text: str) -> str:
    """Return the letters and digits of a text, without accents and case."""
    plain = unicodedata.normalize("NFKD", text.casefold())
    return "".join(c for c in plain if c.isalnum())
