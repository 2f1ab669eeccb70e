"""Safe and unique file names for students."""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Iterable

from fieldrecon._core.digests import bytes_digest

LONGEST = 60


def file_names(students: Iterable[str]) -> dict[str, str]:
    """Return a file name for each student: valid on every system, and unique.

    Examples
    --------
    >>> file_names(["ada", "Å. Ng"])
    {'ada': 'ada', 'Å. Ng': 'A._Ng-0b0609'}
    """
    everybody = list(students)
    plain = {student: _plain(student) for student in everybody}
    taken = Counter(name.casefold() for name in plain.values())
    return {
        student: name
        if name == student and taken[name.casefold()] == 1
        else f"{name}-{bytes_digest(student.encode('utf-8', 'replace'))[:6]}"
        for student, name in plain.items()
    }


def _plain(student: str) -> str:
    """Return the ASCII letters and digits of a name, with . _ -; device names are changed."""
    ascii_only = unicodedata.normalize("NFKD", student).encode("ascii", "ignore").decode()
    name = re.sub(r"[^A-Za-z0-9._-]+", "_", ascii_only).strip("._-")[:LONGEST]
    reserved = re.fullmatch(r"(?i)(con|prn|aux|nul|com\d|lpt\d)(\..*)?", name)
    return f"_{name}" if reserved or not name else name
