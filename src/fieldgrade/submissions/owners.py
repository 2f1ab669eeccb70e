"""Match files to students: hints in the path, compared with the roster, most reliable first.

A file counts for one student or for nobody on the roster: where signs contradict each other, and
where two senders match one student, nobody is chosen.
"""

from __future__ import annotations

import re
import unicodedata
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from fieldgrade.class_folder.roster import Student

NUMBERED = ("canvas", "moodle")
"""The platforms whose numbers are columns of the roster."""
SURE = 1
"""The last of the signs that a student cannot choose: the platform's number, and the address."""


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
    download : int
        The download that contains the file, counted from 0.
    """

    text: str
    number: str = ""
    email: str = ""
    platform: str = ""
    download: int = 0


class RosterIndex:
    """The students of a roster, by the signs that identify them.

    Parameters
    ----------
    roster : mapping
        The students by name or number; may be empty.
    """

    def __init__(self, roster: Mapping[str, Student]) -> None:
        self.roster = roster
        self._of_sign: dict[tuple[int, str], list[Student]] = defaultdict(list)
        for student in roster.values():
            for key in _keys(_known(student)):
                self._of_sign[key].append(student)

    def named(self, owners: Iterable[OwnerHint]) -> set[str]:
        """Return the students of the roster whom any of these hints identifies."""
        found = map(self._match, owners)
        return {student for match in found if match for student in match[1:]}

    def students(self, owners: Iterable[OwnerHint]) -> dict[OwnerHint, str]:
        """Return the student for each hint; without a match, the name in the path.

        Unknown students of one name are distinguished by their numbers, and have no name of the
        roster, so that nobody's work counts as another's.
        """
        matches = {owner: self._match(owner) for owner in dict.fromkeys(owners)}
        for owners_of_one in _senders(matches).values():
            _separate(matches, owners_of_one)
        numbers: dict[str, set[str]] = defaultdict(set)
        for owner, match in matches.items():
            if match is None:
                numbers[owner.text].add(owner.number)
        taken = {name.strip().lower() for name in self.roster}
        return {
            owner: match[1]
            if match
            else f"{owner.text} ({owner.number or '?'})"
            if (owner.number and len(numbers[owner.text]) > 1)
            or owner.text.strip().lower() in taken
            else owner.text
            for owner, match in matches.items()
        }

    def _match(self, owner: OwnerHint) -> tuple[int, str] | None:
        """Return the most reliable sign and the student whom it identifies.

        None if two students match equally, or if no sign is sure and two signs disagree.
        """
        fitting: dict[int, set[str]] = defaultdict(set)
        for key in _keys(_hinted(owner)):
            for student in self._of_sign.get(key, ()):
                if not _is_another(student, owner):
                    fitting[key[0]].add(student.student)
        found = [(s, min(fitting[s])) for s in sorted(fitting) if len(fitting[s]) == 1]
        if not found or (found[0][0] > SURE and len({student for _, student in found}) > 1):
            return None
        return found[0]


def students_of(owners: Iterable[OwnerHint], roster: Mapping[str, Student]) -> dict[OwnerHint, str]:
    """Return the student for each hint, as `RosterIndex.students` does."""
    return RosterIndex(roster).students(owners)


Matches = dict[OwnerHint, tuple[int, str] | None]


def _senders(matches: Matches) -> dict[tuple[int, str], list[OwnerHint]]:
    """Return the hints with numbers that match one student in one download."""
    found: dict[tuple[int, str], list[OwnerHint]] = defaultdict(list)
    for owner, match in matches.items():
        if match and owner.number:
            found[owner.download, match[1]].append(owner)
    return found


def _separate(matches: Matches, owners: Sequence[OwnerHint]) -> None:
    """Two numbers are two people: only one with a sure sign can be the student who matches."""
    if len({owner.number for owner in owners}) == 1:
        return
    sure = [owner for owner in owners if (match := matches[owner]) and match[0] <= SURE]
    is_one = len({owner.number for owner in sure}) == 1
    for owner in owners:
        if not (is_one and owner in sure):
            matches[owner] = None


def _known(student: Student) -> Sequence[Iterable[str]]:
    """Return the signs of a student, the most reliable first, in the order of `_hinted`."""
    names = (student.student, student.login)
    return (
        [f"{name} {n}" for name in NUMBERED for n in getattr(student, f"{name}_id").split()],
        [student.email],
        [*names, student.email, student.sis_id],
        [student.student, student.sis_id],
        _spellings(student.name),
        [_words(key) for key in names if any(c.isdigit() for c in key)],
    )


def _hinted(owner: OwnerHint) -> Sequence[Iterable[str]]:
    """Return the signs in a hint, the most reliable first; the last are words of the text."""
    words = [] if owner.platform else _words(owner.text).split()  # there the name is exact
    runs = [" ".join(words[i:j]) for j in range(len(words) + 1) for i in range(max(0, j - 4), j)]
    return (
        [f"{owner.platform} {owner.number}"] if owner.number else [],
        [owner.email],
        [owner.text],
        # The numbers of Canvas and Moodle are their own: equal student numbers are a coincidence.
        [owner.number] if owner.platform not in NUMBERED else [],
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
