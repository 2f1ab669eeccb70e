"""Bulk downloads of learning platforms: file names that identify students.

Canvas writes ``lovelaceada_LATE_1234_56789_01.ipynb``: student name, late mark, Canvas id of the
student, id of the upload, name of the file. Moodle writes ``Ada
Lovelace_1234_assignsubmission_file_`` before the file name, or as a folder. Gradescope has a folder
``submission_1234`` for each submission, and a file of metadata that names the submitters. Otherwise
each student has a folder or a file.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime

from fieldgrade.submissions.owners import OwnerHint

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
class FileOrigin:
    """The origin of a file, from its path.

    Parameters
    ----------
    owners : tuple of OwnerHint
        The submitters; several for a group.
    name : str
        The file name that the student chose.
    late_mark : bool
        Whether the platform marked it as late.
    received : str
        The time of receipt, if the platform states it.
    """

    owners: tuple[OwnerHint, ...]
    name: str
    late_mark: bool = False
    received: str = ""


Metadata = Mapping[str, FileOrigin]


def is_platform(name: str) -> bool:
    """Whether a name has the form that a platform uses in its bulk downloads."""
    named = (CANVAS, MOODLE, GRADESCOPE)
    return name == METADATA or any(pattern.fullmatch(name) for pattern in named)


def parse_path(parts: Sequence[str], metadata: Metadata) -> FileOrigin:
    """Return the origin of a file, from its path below the folder of all submissions.

    Examples
    --------
    >>> parse_path(["lovelaceada_LATE_12_345_01-2.ipynb"], {}).owners[0].text
    'lovelaceada'
    >>> parse_path(["Ada Lovelace_12_assignsubmission_file_", "work", "01.ipynb"], {}).name
    'work/01.ipynb'
    >>> parse_path(["ada_01.ipynb"], {}).owners[0].text
    'ada'
    """
    first, rest = parts[0], "/".join(parts[1:])
    if first in metadata:
        return replace(metadata[first], name=rest)
    if found := GRADESCOPE.fullmatch(first):
        return FileOrigin((OwnerHint(first, found["id"], platform="gradescope"),), rest)
    if found := MOODLE.fullmatch(first):
        name = "/".join(part for part in (found["file"], rest) if part)
        return FileOrigin((OwnerHint(found["who"], found["id"], platform="moodle"),), name)
    if found := CANVAS.fullmatch(first):
        name = "/".join(part for part in (found["file"], rest) if part)
        owner = OwnerHint(found["who"], found["id"], platform="canvas")
        return FileOrigin((owner,), name, late_mark=bool(found["late"]))
    return FileOrigin((OwnerHint(first if rest else stem(first)),), rest or first)


def stem(name: str) -> str:
    """Return the student's name in the name of a file, without that of the notebook.

    Examples
    --------
    >>> stem("ada_02_moving_least_squares.ipynb"), stem("2024-01.ipynb"), stem("bob (1).zip")
    ('ada', '2024', 'bob')
    """
    bare = re.sub(r"(?:\.(?:ipynb|py|zip|json|txt))+$", "", name, flags=re.IGNORECASE)
    bare = TRAILING_NUMBER.sub("", bare) if not NOTEBOOK.search(bare) else bare
    return NOTEBOOK.sub("", bare) or bare


def attempt(name: str) -> int:
    """Return the number that a platform or browser appended to a repeated file name.

    Examples
    --------
    >>> attempt("01-2.ipynb"), attempt("01 (3).ipynb"), attempt("01.ipynb")
    (2, 3, 0)
    """
    bare = name.rpartition("/")[2].partition(".")[0]
    found = TRAILING_NUMBER.search(bare)
    return int(found[1] or found[2]) if found else 0


def gradescope_metadata(text: str) -> dict[str, FileOrigin]:
    """Return the origin of each folder of a Gradescope export, from its metadata file."""
    found: dict[str, FileOrigin] = {}
    for block in re.split(r"^(?=submission_\d+:)", text.replace("\r\n", "\n"), flags=re.MULTILINE):
        head = re.match(r"submission_\d+", block)
        listed = SUBMITTERS.search(block)
        if head is None or listed is None:
            continue
        people = re.split(r"^ +- ", listed[1], flags=re.MULTILINE)[1:]
        owners = tuple(
            OwnerHint(
                _field(p, "name") or head[0], _field(p, "sid"), _field(p, "email"), "gradescope"
            )
            for p in people
        )
        if owners:
            created = re.search(r"^  :created_at: *(.*)$", block, flags=re.MULTILINE)
            found[head[0]] = FileOrigin(owners, "", received=_time(created[1]) if created else "")
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
    time = f"{found[1]}T{found[2]}{f'{zone[1]}:{zone[2]}' if zone else '+00:00'}"
    try:
        return datetime.fromisoformat(time).astimezone(UTC).isoformat()
    except (ValueError, OverflowError):
        return ""
