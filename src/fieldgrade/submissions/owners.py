"""Whose a file is: what its place says, compared with the roster by the surest sign first."""

from __future__ import annotations

import re
import unicodedata
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from fieldgrade.class_folder.roster import Student

PLATFORMS = ("canvas", "moodle")


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
    index: dict[tuple[int, str], list[Student]] = defaultdict(list)
    for student in roster.values():
        for key in _keys(_known(student)):
            index[key].append(student)
    known = {owner: _student(owner, index) for owner in dict.fromkeys(owners)}
    numbers: dict[str, set[str]] = defaultdict(set)
    for owner, found in known.items():
        if found is None:
            numbers[owner.text].add(owner.number)
    return {
        owner: found.student
        if found
        else f"{owner.text} ({owner.number})"
        if owner.number and len(numbers[owner.text]) > 1
        else owner.text
        for owner, found in known.items()
    }


def _student(owner: Owner, index: Mapping[tuple[int, str], list[Student]]) -> Student | None:
    """Return the student who fits by the surest sign; none where two fit equally well."""
    fitting: dict[int, dict[str, Student]] = defaultdict(dict)
    for key in _keys(_told(owner)):
        for student in index.get(key, ()):
            if not _is_another(student, owner):
                fitting[key[0]][student.student] = student
    sure = (fitting[sign] for sign in sorted(fitting) if len(fitting[sign]) == 1)
    return next((student for found in sure for student in found.values()), None)


def _known(student: Student) -> Sequence[Iterable[str]]:
    """Return what is known of a student, the surest sign first, as `_told` tells it."""
    names = (student.student, student.login)
    return (
        [f"{name} {n}" for name in PLATFORMS if (n := getattr(student, f"{name}_id", ""))],
        [student.email],
        [*names, student.email, student.sis_id],
        [student.student, student.sis_id],
        _spellings(student.name),
        [_words(key) for key in names if any(c.isdigit() for c in key)],
    )


def _told(owner: Owner) -> Sequence[Iterable[str]]:
    """Return what an owner tells, sign by sign; at last the words that stand in the text."""
    words = _words(owner.text).split()
    runs = [" ".join(words[i:j]) for j in range(len(words) + 1) for i in range(max(0, j - 4), j)]
    return (
        [f"{owner.platform} {owner.number}"] if owner.number else [],
        [owner.email],
        [owner.text],
        [owner.number],
        [_letters(owner.text)],
        runs,
    )


def _keys(signs: Sequence[Iterable[str]]) -> Iterator[tuple[int, str]]:
    for sign, values in enumerate(signs):
        yield from ((sign, text) for text in {v.strip().lower() for v in values} if text)


def _is_another(student: Student, owner: Owner) -> bool:
    """Whether Canvas says that it is somebody else, perhaps of the same name."""
    number = owner.number if owner.platform == "canvas" else ""
    return number != "" and student.canvas_id not in ("", number)


def _words(text: str) -> str:
    return " ".join(re.findall(r"[^\W_]+", text.casefold()))


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
