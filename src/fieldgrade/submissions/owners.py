"""Match files to students: hints in the path, compared with the roster, most reliable first."""

from __future__ import annotations

import re
import unicodedata
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from fieldgrade.class_folder.roster import Student

PLATFORMS = ("canvas", "moodle")


@dataclass(frozen=True)
class OwnerHint:
    """Hints about the owner of a file in its path.

    Parameters
    ----------
    text : str
        A name, as written in the path.
    number : str
        The platform's number of the student, if present.
    email : str
        An e-mail address, if present.
    platform : str
        ``"canvas"``, ``"moodle"``, ``"gradescope"``, or empty.
    """

    text: str
    number: str = ""
    email: str = ""
    platform: str = ""


def students_of(owners: Iterable[OwnerHint], roster: Mapping[str, Student]) -> dict[OwnerHint, str]:
    """Return the student for each hint; without a match, the name in the path.

    Unknown students of one name are distinguished by their numbers, so that nobody's work counts as
    another's.
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


def _student(owner: OwnerHint, index: Mapping[tuple[int, str], list[Student]]) -> Student | None:
    """Return the student who matches by the most reliable sign; None if two match equally."""
    fitting: dict[int, dict[str, Student]] = defaultdict(dict)
    for key in _keys(_hinted(owner)):
        for student in index.get(key, ()):
            if not _is_another(student, owner):
                fitting[key[0]][student.student] = student
    sure = (fitting[sign] for sign in sorted(fitting) if len(fitting[sign]) == 1)
    return next((student for found in sure for student in found.values()), None)


def _known(student: Student) -> Sequence[Iterable[str]]:
    """Return the signs of a student, the most reliable first, in the order of `_hinted`."""
    names = (student.student, student.login)
    return (
        [f"{name} {n}" for name in PLATFORMS if (n := getattr(student, f"{name}_id", ""))],
        [student.email],
        [*names, student.email, student.sis_id],
        [student.student, student.sis_id],
        _spellings(student.name),
        [_words(key) for key in names if any(c.isdigit() for c in key)],
    )


def _hinted(owner: OwnerHint) -> Sequence[Iterable[str]]:
    """Return the signs in a hint, the most reliable first; the last are words of the text."""
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


def _is_another(student: Student, owner: OwnerHint) -> bool:
    """Whether the Canvas id excludes this student, who may have the same name."""
    number = owner.number if owner.platform == "canvas" else ""
    return number != "" and student.canvas_id not in ("", number)


def _words(text: str) -> str:
    return " ".join(re.findall(r"[^\W_]+", text.casefold()))


def _spellings(name: str) -> frozenset[str]:
    """Return a name as platforms write it: first name first, or last name first."""
    last, comma, first = name.partition(",")
    words = [*first.split(), *last.split()] if comma else name.split()
    rotated = {_letters("".join(words[k:] + words[:k])) for k in range(len(words))}
    return frozenset(text for text in rotated if text)


def _letters(text: str) -> str:
    """Return the letters and digits of a text, without accents and case."""
    plain = unicodedata.normalize("NFKD", text.casefold())
    return "".join(c for c in plain if c.isalnum())
