"""From what lies in a folder, or in bulk downloads, to the files of each student, archived.

Only the instructor's folder and a platform say whose a file is. What a student packed is the
student's, whatever the names in it say: nobody can hand in for somebody else.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile
from pathlib import Path

from fieldgrade.class_folder.roster import Student
from fieldgrade.submissions.archive import Archive, NotTaken
from fieldgrade.submissions.owners import students_of
from fieldgrade.submissions.platforms import (
    METADATA,
    Metadata,
    Place,
    gradescope_metadata,
    is_platform,
    place,
)
from fieldgrade.submissions.unpack import LEADS_OUT, MEBIBYTE, Item, NoZip, folder_items, zip_items

MOST_FILE, MOST_PACK = 64 * MEBIBYTE, 8192 * MEBIBYTE
MOST_UNPACKED = 256 * MEBIBYTE
MOST_FILES, MOST_DEPTH = 500, 3
"""Bytes and files that are unpacked of what one student packed, and zip files in each other."""


@dataclass(frozen=True)
class File:
    """A file of a student, in the archive unless there is a problem with it."""

    student: str
    name: str
    digest: str
    received: str = ""
    received_by: str = ""
    late_mark: bool = False
    problem: str = ""


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
        What came and is nobody's.
    """

    archive: Archive
    roster: Mapping[str, Student] = field(default_factory=dict)
    strays: list[str] = field(default_factory=list)

    def files(self, place_of_all: Path) -> Iterator[File]:
        """Yield the files of all students in a folder, or in a zip file of all.

        Raises
        ------
        NoZip
            It is a file, and no zip file.
        """
        items, metadata = self._described(self._items(place_of_all))
        placed = [(item, place(item.parts, metadata)) for item in items if not self._stray(item)]
        students = students_of((o for _, where in placed for o in where.owners), self.roster)
        for item, where in placed:
            for owner in where.owners:
                yield from self._taken(_file(students[owner], item, where), item, _Left())

    def _stray(self, item: Item) -> bool:
        """Whether an item is nobody's: a platform names its files so that they stay in place."""
        if item.refused == LEADS_OUT:
            self.strays.append(f"{item.name}: {item.refused}")
        return item.refused == LEADS_OUT

    # Where the students' files begin.

    def _items(self, place_of_all: Path) -> list[Item]:
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

    def _inside(self, item: Item) -> list[Item]:
        try:
            with item.open() as stream:
                digest = self.archive.put(stream, MOST_PACK)
            return zip_items(self.archive.path(digest))
        except (NoZip, NotTaken, OSError):
            return []

    def _begun(self, items: list[Item], packed: bool = False) -> list[Item]:
        """Leave out the folders that lie above those of the students."""
        if not items or any(len(item.parts) == 1 for item in items):
            return items  # there are files, so no folder lies above
        folders: dict[str, list[Item]] = {}
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
        """Whether folders or zip files are those of people on the roster: of any of them."""
        owners = (owner for name in names for owner in place([name], {}).owners)
        return not self.roster.keys().isdisjoint(students_of(owners, self.roster).values())

    def _described(self, items: Sequence[Item]) -> tuple[list[Item], Metadata]:
        """Take out the files in which Gradescope tells whose each folder is."""
        told: dict[str, Place] = {}
        for item in items:
            if item.parts == (METADATA,):
                kept = self._kept(File("", item.name, ""), item, _Left())
                if kept.problem:
                    self.strays.append(f"{item.name}: {kept.problem}")
                else:
                    content = self.archive.read(kept.digest, MOST_FILE)
                    told |= gradescope_metadata(content.decode("utf-8", "replace"))
        return [item for item in items if item.parts != (METADATA,)], told

    # What a student handed in.

    def _taken(self, file: File, item: Item, left: _Left, depth: int = 0) -> Iterator[File]:
        """Yield a file, or what is in it if it is a zip file."""
        left.files -= 1
        kept = self._kept(file, item, left if depth else _Left())
        if kept.problem or not item.is_zip:
            yield kept
            return
        try:
            inside = zip_items(self.archive.path(kept.digest))
        except NoZip as error:
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

    def _kept(self, file: File, item: Item, left: _Left) -> File:
        """Put a file into the archive; whatever is wrong with it is its problem."""
        if item.refused:
            return replace(file, problem=item.refused)
        try:
            stream = item.open()
        except Exception as error:  # damaged, encrypted, forbidden, compressed as nobody does
            return replace(file, problem=f"it cannot be opened ({error})")
        with stream:
            try:
                digest = self.archive.put(stream, min(left.bytes, MOST_FILE))
            except NotTaken as problem:
                return replace(file, problem=str(problem))
        left.bytes -= self.archive.path(digest).stat().st_size
        return replace(file, digest=digest)


@dataclass
class _Left:
    """What may still be unpacked of what a student packed."""

    bytes: int = field(default_factory=lambda: MOST_UNPACKED)
    files: int = field(default_factory=lambda: MOST_FILES)


def _file(student: str, item: Item, where: Place) -> File:
    received, by = (where.received, "platform") if where.received else (item.time, item.by)
    return File(student, where.name, "", received, by, where.late_mark)


def _is_bulk(items: Sequence[Item]) -> bool:
    """Whether all the names are those that a platform gives."""
    return bool(items) and all(is_platform(item.parts[0]) for item in items)


def _is_class(items: Sequence[Item]) -> bool:
    """Whether there are folders only, more than one, or what a platform writes."""
    folders = {item.parts[0] for item in items if len(item.parts) > 1}
    return _is_bulk(items) or (len(folders) > 1 and all(len(i.parts) > 1 for i in items))


def _importance(item: Item) -> tuple[bool, tuple[str, ...]]:
    """Return by what the files come first that are likely to be graded."""
    return not item.parts[-1].lower().endswith((".ipynb", ".py", ".zip")), item.parts
