"""How learning platforms name what students handed in, in their bulk downloads.

Canvas writes ``lovelaceada_LATE_1234_56789_01.ipynb``: name, mark, number of the student, number of
the file, name of the file. Moodle writes ``Ada Lovelace_1234_assignsubmission_file_`` before the
name, or as a folder. Gradescope has a folder ``submission_1234`` each, and a file that tells whose
it is. Otherwise each student has a folder, or a file.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime

from fieldgrade.submissions.owners import Owner

CANVAS = re.compile(
    r"(?P<who>[^\W\d_][^_]*)_(?P<late>LATE_)?(?P<id>\d+)_(?P<attachment>\d+)_(?P<file>.+)"
)
MOODLE = re.compile(r"(?P<who>.+?)_(?P<id>\d+)_assignsubmission_(?:file|onlinetext)_?(?P<file>.*)")
GRADESCOPE = re.compile(r"submission_(?P<id>\d+)")
METADATA = "submission_metadata.yml"
SUBMITTERS = re.compile(r"^  :submitters: *\n((?: {2,}- .*\n| {4,}.*\n)*)", re.MULTILINE)
TRAILING_NUMBER = re.compile(r"(?<=.)[ _-]*(?:-(\d{1,3})|\((\d{1,3})\))$")
NOTEBOOK = re.compile(
    r"(?:^|[ _.-]+)(?:(?:notebook|exercise)[ _-]*)?\d\d(?:[ _-][a-z0-9_-]*)?$", re.IGNORECASE
)


@dataclass(frozen=True)
class Place:
    """What the names of folders and file tell.

    Parameters
    ----------
    owners : tuple of Owner
        Whose it is; several for a group.
    name : str
        The name that the student gave to it.
    late_mark : bool
        Whether the platform calls it late.
    received : str
        When it came, where the platform tells.
    """

    owners: tuple[Owner, ...]
    name: str
    late_mark: bool = False
    received: str = ""


Metadata = Mapping[str, Place]


def is_platform(name: str) -> bool:
    """Whether a name is one that a platform gives in its bulk downloads."""
    named = (CANVAS, MOODLE, GRADESCOPE)
    return name == METADATA or any(pattern.fullmatch(name) for pattern in named)


def place(parts: Sequence[str], metadata: Metadata) -> Place:
    """Return what the path of a file below the folder of all tells of whose it is.

    Examples
    --------
    >>> place(["lovelaceada_LATE_12_345_01-2.ipynb"], {}).owners[0].text
    'lovelaceada'
    >>> place(["Ada Lovelace_12_assignsubmission_file_", "work", "01.ipynb"], {}).name
    'work/01.ipynb'
    >>> place(["ada", "01.ipynb"], {}).owners[0].text, place(["ada_01.ipynb"], {}).owners[0].text
    ('ada', 'ada')
    """
    first, rest = parts[0], "/".join(parts[1:])
    if first in metadata:
        return replace(metadata[first], name=rest)
    if found := GRADESCOPE.fullmatch(first):
        return Place((Owner(first, found["id"], platform="gradescope"),), rest)
    if found := MOODLE.fullmatch(first):
        name = "/".join(part for part in (found["file"], rest) if part)
        return Place((Owner(found["who"], found["id"], platform="moodle"),), name)
    if found := CANVAS.fullmatch(first):
        name = "/".join(part for part in (found["file"], rest) if part)
        owner = Owner(found["who"], found["id"], platform="canvas")
        return Place((owner,), name, late_mark=bool(found["late"]))
    return Place((Owner(first if rest else stem(first)),), rest or first)


def stem(name: str) -> str:
    """Return a student's name from that of a file, without the notebook's.

    Examples
    --------
    >>> stem("ada_02_moving_least_squares.ipynb"), stem("2024-01.ipynb"), stem("bob (1).zip")
    ('ada', '2024', 'bob')
    """
    bare = re.sub(r"(?:\.(?:ipynb|py|zip|json|txt))+$", "", name, flags=re.IGNORECASE)
    bare = TRAILING_NUMBER.sub("", bare) if not NOTEBOOK.search(bare) else bare
    return NOTEBOOK.sub("", bare) or bare


def attempt(name: str) -> int:
    """Return which of several files of one name this is.

    Examples
    --------
    >>> attempt("01-2.ipynb"), attempt("01 (3).ipynb"), attempt("01.ipynb")
    (2, 3, 0)
    """
    bare = name.rpartition("/")[2].partition(".")[0]
    found = TRAILING_NUMBER.search(bare)
    return int(found[1] or found[2]) if found else 0


def gradescope_metadata(text: str) -> dict[str, Place]:
    """Return whose each folder of an export of Gradescope is, from the file that it tells it in."""
    found: dict[str, Place] = {}
    for block in re.split(r"^(?=submission_\d+:)", text.replace("\r\n", "\n"), flags=re.MULTILINE):
        head = re.match(r"submission_\d+", block)
        listed = SUBMITTERS.search(block)
        if head is None or listed is None:
            continue
        people = re.split(r"^ +- ", listed[1], flags=re.MULTILINE)[1:]
        owners = tuple(
            Owner(_field(p, "name") or head[0], _field(p, "sid"), _field(p, "email"), "gradescope")
            for p in people
        )
        if owners:
            created = re.search(r"^  :created_at: *(.*)$", block, flags=re.MULTILINE)
            found[head[0]] = Place(owners, "", received=_time(created[1]) if created else "")
    return found


def _field(person: str, name: str) -> str:
    found = re.search(rf"^ *:{name}: *(.*)$", person, flags=re.MULTILINE)
    return found[1].strip().strip("'\"") if found else ""


def _time(text: str) -> str:
    """Return a time of Gradescope, ``2026-11-20 12:00:00.123 Z``, as ISO 8601 in UTC."""
    found = re.match(r"(\d{4}-\d\d-\d\d)[ T](\d\d:\d\d:\d\d)", text)
    zone = re.search(r"([+-]\d\d):?(\d\d)$", text)
    if found is None or not (text.endswith(("Z", "UTC")) or zone):
        return ""
    told = f"{found[1]}T{found[2]}{f'{zone[1]}:{zone[2]}' if zone else '+00:00'}"
    try:
        return datetime.fromisoformat(told).astimezone(UTC).isoformat()
    except (ValueError, OverflowError):
        return ""
