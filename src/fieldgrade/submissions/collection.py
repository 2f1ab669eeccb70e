"""Collects the files of each student from a folder or from bulk downloads, and archives them.

Only the instructor's folder and a platform determine the owner of a file. Everything that a student
packed belongs to this student, whatever the names inside: nobody can submit for somebody else.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile
from pathlib import Path

from fieldgrade.class_folder.roster import Student
from fieldgrade.submissions.archive import Archive, CannotArchive
from fieldgrade.submissions.bulk_downloads import (
    METADATA,
    FileOrigin,
    Metadata,
    gradescope_metadata,
    is_platform,
    parse_path,
)
from fieldgrade.submissions.owners import students_of
from fieldgrade.submissions.submission import MOST_BYTES, Submission
from fieldgrade.submissions.unpack import (
    LEADS_OUT,
    MEBIBYTE,
    BadZip,
    InputFile,
    folder_items,
    zip_items,
)

MOST_FILE, MOST_PACK = 64 * MEBIBYTE, 8192 * MEBIBYTE
MOST_UNPACKED = 256 * MEBIBYTE
MOST_FILES, MOST_DEPTH = 500, 3
"""Limits for the zip files of one student: bytes and files unpacked, and depth of nesting."""


@dataclass(frozen=True)
class ReceivedFile:
    """A file of a student, in the archive unless there is a problem with it.

    Parameters
    ----------
    student : str
        The name or number of the student.
    name : str
        The name of the file, with folders.
    digest : str
        SHA-256 of the content; empty if the file is not in the archive.
    received, received_by : str
        The time of receipt, and its source: ``"list"``, ``"platform"``, ``"zip"`` or ``"file"``.
    late_mark : bool
        Whether the platform marked the file as late.
    problem : str
        Why the file cannot be graded; empty if it can.
    notebook : str
        The number of the notebook, known after the intake; empty if it cannot be graded.
    notes : tuple of str
        Other files of the student that are not graded, and why.
    """

    student: str
    name: str
    digest: str = ""
    received: str = ""
    received_by: str = ""
    late_mark: bool = False
    problem: str = ""
    notebook: str = ""
    notes: tuple[str, ...] = ()

    def submission(self, archive: Archive) -> Submission:
        """Return the file with its content."""
        content = archive.read(self.digest, MOST_BYTES) if self.digest else b""
        return Submission(self.student, self.name, content)


@dataclass
class Collection:
    """Collects the files of a class.

    Parameters
    ----------
    archive : Archive
        Where received files are kept.
    roster : mapping
        The students by name or number; may be empty.
    strays : list of str
        Files that belong to no student.
    """

    archive: Archive
    roster: Mapping[str, Student] = field(default_factory=dict)
    strays: list[str] = field(default_factory=list)

    def files(self, place_of_all: Path) -> Iterator[ReceivedFile]:
        """Yield the files of all students in a folder or a zip file.

        Raises
        ------
        BadZip
            It is a file, but not a zip file.
        """
        items, metadata = self._described(self._items(place_of_all))
        placed = [
            (item, parse_path(item.parts, metadata)) for item in items if not self._stray(item)
        ]
        students = students_of((o for _, where in placed for o in where.owners), self.roster)
        for item, where in placed:
            for owner in where.owners:
                yield from self._taken(_file(students[owner], item, where), item, _Left())

    def _stray(self, item: InputFile) -> bool:
        """Whether a file is a stray: no platform writes a name that leads out of the folder."""
        if item.refused == LEADS_OUT:
            self.strays.append(f"{item.name}: {item.refused}")
        return item.refused == LEADS_OUT

    # Find the level of folders at which the students' files begin.

    def _items(self, place_of_all: Path) -> list[InputFile]:
        if place_of_all.is_file():
            with place_of_all.open("rb") as stream:
                digest = self.archive.put(stream, MOST_PACK)
            return self._begun(zip_items(self.archive.path(digest)), packed=True)
        items = folder_items(place_of_all)
        loose = [item for item in items if len(item.parts) == 1]
        packs_only = len(loose) == len(items) and all(i.is_zip and not i.refused for i in loose)
        if packs_only and not self._are_students(item.name for item in loose):
            inside = (self._begun(self._inside(item), packed=True) for item in loose)
            is_download = _is_class if len(loose) == 1 else _is_bulk
            packs = list(takewhile(is_download, inside))  # not all are open at once
            if len(packs) == len(loose):
                return [item for pack in packs for item in pack]
        return self._begun(items)

    def _inside(self, item: InputFile) -> list[InputFile]:
        try:
            with item.open() as stream:
                digest = self.archive.put(stream, MOST_PACK)
            return zip_items(self.archive.path(digest))
        except (BadZip, CannotArchive, OSError):
            return []

    def _begun(self, items: list[InputFile], packed: bool = False) -> list[InputFile]:
        """Remove the folders above those of the students."""
        if not items or any(len(item.parts) == 1 for item in items):
            return items  # there are files, so no folder lies above
        folders: dict[str, list[InputFile]] = {}
        for item in items:
            folders.setdefault(item.parts[0], []).append(item.below(1))
        if any(map(is_platform, folders)) or self._are_students(folders):
            return items
        inside = list(folders.values())
        if all(map(_is_bulk, inside)) or (packed and len(inside) == 1 and _is_class(inside[0])):
            return [item for folder in inside for item in folder]
        if packed and len(inside) == 1:
            below = self._begun(inside[0], packed)
            return items if below is inside[0] else below
        return items

    def _are_students(self, names: Iterable[str]) -> bool:
        """Whether any of the folders or zip files belongs to a student of the roster."""
        owners = (owner for name in names for owner in parse_path([name], {}).owners)
        return not self.roster.keys().isdisjoint(students_of(owners, self.roster).values())

    def _described(self, items: Sequence[InputFile]) -> tuple[list[InputFile], Metadata]:
        """Separate Gradescope's files of metadata from the other files."""
        origins: dict[str, FileOrigin] = {}
        for item in items:
            if item.parts == (METADATA,):
                kept = self._kept(ReceivedFile("", item.name), item, _Left())
                if kept.problem:
                    self.strays.append(f"{item.name}: {kept.problem}")
                else:
                    content = self.archive.read(kept.digest, MOST_FILE)
                    origins |= gradescope_metadata(content.decode("utf-8", "replace"))
        return [item for item in items if item.parts != (METADATA,)], origins

    # Unpack what a student submitted.

    def _taken(
        self, file: ReceivedFile, item: InputFile, left: _Left, depth: int = 0
    ) -> Iterator[ReceivedFile]:
        """Yield a file, or the content of a zip file."""
        left.files -= 1
        kept = self._kept(file, item, left if depth else _Left())
        if kept.problem or not item.is_zip:
            yield kept
            return
        try:
            inside = zip_items(self.archive.path(kept.digest))
        except BadZip as error:
            yield replace(kept, problem=str(error))
            return
        if depth == MOST_DEPTH or not inside:
            problem = "it is a zip file in too many others" if inside else "there is nothing in it"
            yield replace(kept, problem=problem)
            return
        for number, member in enumerate(sorted(inside, key=_importance)):
            if left.files <= 0:
                problem = f"there are too many files: {len(inside) - number} are left out"
                yield replace(file, name=f"{file.name}/…", problem=problem)
                return
            named = replace(file, name=f"{file.name}/{member.name}")
            yield from self._taken(named, member, left, depth + 1)

    def _kept(self, file: ReceivedFile, item: InputFile, left: _Left) -> ReceivedFile:
        """Archive a file, or describe its problem."""
        if item.refused:
            return replace(file, problem=item.refused)
        try:
            stream = item.open()
        except Exception as error:  # damaged, encrypted, forbidden, an unknown compression
            return replace(file, problem=f"it cannot be opened ({error})")
        with stream:
            try:
                digest = self.archive.put(stream, min(left.bytes, MOST_FILE))
            except CannotArchive as problem:
                return replace(file, problem=str(problem))
        left.bytes -= self.archive.path(digest).stat().st_size
        return replace(file, digest=digest)


@dataclass
class _Left:
    """How many bytes and files of a student may still be unpacked."""

    bytes: int = field(default_factory=lambda: MOST_UNPACKED)
    files: int = field(default_factory=lambda: MOST_FILES)


def _file(student: str, item: InputFile, where: FileOrigin) -> ReceivedFile:
    received, by = (where.received, "platform") if where.received else (item.time, item.by)
    return ReceivedFile(student, where.name, "", received, by, where.late_mark)


def _is_bulk(items: Sequence[InputFile]) -> bool:
    """Whether all names have the form of a platform."""
    return bool(items) and all(is_platform(item.parts[0]) for item in items)


def _is_class(items: Sequence[InputFile]) -> bool:
    """Whether there are several folders and nothing else, or files of a platform."""
    folders = {item.parts[0] for item in items if len(item.parts) > 1}
    return _is_bulk(items) or (len(folders) > 1 and all(len(i.parts) > 1 for i in items))


def _importance(item: InputFile) -> tuple[bool, tuple[str, ...]]:
    """Return the key by which files that are likely to be graded come first."""
    return not item.parts[-1].lower().endswith((".ipynb", ".py", ".zip")), item.parts
