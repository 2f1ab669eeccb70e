"""Bulk downloads of learning platforms: file names that identify students.

Canvas writes ``lovelaceada_LATE_1234_56789_01.ipynb``: student name, late mark, Canvas id of the
student, id of the upload, name of the file. Moodle writes ``Ada
Lovelace_1234_assignsubmission_file_`` before the file name, or as a folder. Gradescope has a folder
``submission_1234`` for each submission, and a file of metadata that names the submitters. Otherwise
each student has a folder or a file.

A student chooses the end of a name, and can imitate another platform there. Therefore the platform
is determined from all names of a download together, never from one name.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime

from fieldgrade.submissions.owners import OwnerHint

CANVAS = re.compile(
    r"(?P<who>[^\W\d_][^_]*)_(?P<late>LATE_)?(?P<id>\d+)_(?P<attachment>\d+)_(?P<file>.+)"
)
MOODLE = re.compile(
    r"(?P<who>[^_]+)_(?P<id>\d+)_assignsubmission_(?:file|onlinetext)_?(?P<file>.*)"
)
"""Moodle replaces underscores in names of students by spaces, and Canvas removes them."""
MOODLE_ANYWHERE = re.compile(r"([^_]*)_(\d+)_assignsubmission_")
GRADESCOPE = re.compile(r"submission_(?P<id>\d+)")
PLATFORMS = {"Canvas": CANVAS, "Moodle": MOODLE, "Gradescope": GRADESCOPE}
METADATA = "submission_metadata.yml"
SUBMITTERS = re.compile(r"^  :submitters: *\n((?:  - .*\n| {4,}.*\n)*)", re.MULTILINE)
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


def platforms_of(names: Collection[str]) -> tuple[str, ...]:
    """Return the platform whose form fits most names; none, or several that fit equally many.

    Examples
    --------
    >>> platforms_of(["lovelaceada_12_345_01.ipynb", "bytebob_13_346_x_12_assignsubmission_file_"])
    ('Canvas',)
    >>> platforms_of(["ada", "bob"])
    ()
    """
    fitting = {p: sum(map(bool, map(form.fullmatch, names))) for p, form in PLATFORMS.items()}
    most = max(fitting.values())
    return tuple(platform for platform, count in fitting.items() if count == most > 0)


def is_of_one_platform(names: Collection[str]) -> bool:
    """Whether one platform wrote all names."""
    written = [name for name in names if name != METADATA]
    return bool(names) and any(all(map(form.fullmatch, written)) for form in PLATFORMS.values())


def platform_of(name: str) -> str:
    """Return the platform whose form fits a name; no name fits two, and most fit none.

    Examples
    --------
    >>> platform_of("eve_7_8_x_12_assignsubmission_file_1.ipynb"), platform_of("eve_01.ipynb")
    ('Canvas', '')
    """
    return next((p for p, form in PLATFORMS.items() if form.fullmatch(name)), "")


def claims(name: str) -> list[OwnerHint]:
    """Return the students whom a name claims in the form of Moodle, wherever this form begins.

    Examples
    --------
    >>> [hint.number for hint in claims("eve_7_8_x_12_assignsubmission_file_1.ipynb")]
    ['12']
    """
    found = MOODLE_ANYWHERE.findall(name)
    return [OwnerHint(who, number, platform="moodle") for who, number in found]


def parse_path(
    parts: Sequence[str], platform: str = "", metadata: Metadata | None = None
) -> FileOrigin:
    """Return the origin of a file, from its path below the folder of a download.

    Parameters
    ----------
    parts : sequence of str
        The folders of its path, and its name.
    platform : str
        The platform that made the download; empty if none did.
    metadata : mapping
        The origins by folder, from Gradescope's file of metadata.

    Examples
    --------
    >>> parse_path(["lovelaceada_LATE_12_345_01-2.ipynb"], "Canvas").owners[0].text
    'lovelaceada'
    >>> parse_path(["Ada Lovelace_12_assignsubmission_file_", "work", "01.ipynb"], "Moodle").name
    'work/01.ipynb'
    >>> parse_path(["ada_01.ipynb"]).owners[0].text
    'ada'
    """
    first, rest = parts[0], "/".join(parts[1:])
    found = PLATFORMS[platform].fullmatch(first) if platform else None
    if found is None:
        return FileOrigin((OwnerHint(first if rest else stem(first)),), rest or first)
    if platform == "Gradescope":
        unknown = FileOrigin((OwnerHint(first, platform="gradescope"),), "")
        return replace((metadata or {}).get(first, unknown), name=rest)
    read = found.groupdict()
    name = "/".join(part for part in (read["file"], rest) if part)
    owner = OwnerHint(read["who"], read["id"], platform=platform.lower())
    return FileOrigin((owner,), name, late_mark=bool(read.get("late")))


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
        # A long name continues in the next line, indented more deeply, whatever it contains.
        people = re.split(r"^  - ", listed[1], flags=re.MULTILINE)[1:]
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
    found = re.search(rf"^(?: {{4}})?:{name}: *(.*)$", person, flags=re.MULTILINE)
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
