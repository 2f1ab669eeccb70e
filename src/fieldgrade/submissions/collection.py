"""Collects the files of each student from a folder or from bulk downloads, and archives them.

Only the instructor's folder and a platform determine the owner of a file. Everything that a student
packed belongs to this student, whatever the names inside. A download has one platform; a file whose
name can be read as that of two students is refused, and listed by its name.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import takewhile
from pathlib import Path

from fieldgrade.class_folder.roster import Student
from fieldgrade.submissions.archive import Archive, CannotArchive
from fieldgrade.submissions.bulk_downloads import (
    METADATA,
    FileOrigin,
    Metadata,
    claims,
    gradescope_metadata,
    is_of_one_platform,
    parse_path,
    platform_of,
    platforms_of,
)
from fieldgrade.submissions.owners import OwnerHint, RosterIndex
from fieldgrade.submissions.submission import MOST_RECEIVED, Submission
from fieldgrade.submissions.unpack import (
    LEADS_OUT,
    MEBIBYTE,
    BadZip,
    InputFile,
    folder_items,
    zip_items,
)

MOST_FILE, MOST_PACK = MOST_RECEIVED, 8192 * MEBIBYTE
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
    sender : str
        The name of the student in the path.
    helpers : tuple of (str, str)
        Paths and digests of the files beside it, which its code can import or read.
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
    sender: str = ""
    helpers: tuple[tuple[str, str], ...] = ()

    def submission(self, archive: Archive) -> Submission:
        """Return the file with its content."""
        content = archive.read(self.digest, MOST_RECEIVED) if self.digest else b""
        helpers = ((path, archive.path(digest)) for path, digest in self.helpers)
        return Submission(self.student, self.name, content, tuple(helpers))


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
        downloads = enumerate(self._downloads(place_of_all))
        placed = [pair for number, items in downloads for pair in self._placed(items, number)]
        students = self._index.students(o for _, origin in placed for o in origin.owners)
        for item, origin in placed:
            for owner in origin.owners:
                file = _file(students[owner], item, origin, owner)
                if problem := self._claim(file.student, item.parts[0], owner):
                    yield replace(file, problem=problem)
                else:
                    yield from self._taken(file, item, _Left())

    def _claim(self, student: str, name: str, owner: OwnerHint) -> str:
        """Return why a file is refused whose name claims another student; empty if it does not."""
        others = self._index.named(claims(name)) - {student}
        if owner.platform == "moodle" or not others:
            return ""
        named = " and of ".join((student, *sorted(others)))
        return f"its name can be read as that of {named}: the file must have another name"

    @cached_property
    def _index(self) -> RosterIndex:
        return RosterIndex(self.roster)

    def _placed(
        self, items: Sequence[InputFile], number: int
    ) -> Iterator[tuple[InputFile, FileOrigin]]:
        """Yield the files of a download with their origins; the others are strays."""
        items, metadata = self._described(items)
        platforms = platforms_of({item.parts[0] for item in items})
        for item in items:
            if stray := self._stray(item, platforms):
                self.strays.append(f"{item.name}: {stray}")
                continue
            origin = parse_path(item.parts, "".join(platforms[:1]), metadata)
            owners = tuple(replace(owner, download=number) for owner in origin.owners)
            yield item, replace(origin, owners=owners)

    def _stray(self, item: InputFile, platforms: tuple[str, ...]) -> str:
        """Return why a file belongs to no student; empty if it belongs to one."""
        if item.refused == LEADS_OUT:  # no platform writes such a name
            return item.refused
        own = platform_of(item.parts[0])
        if own and (own,) != platforms:
            others = " and ".join(p for p in platforms if p != own)
            return f"its name has the form of {own}, but it is among files of {others}"
        return ""

    # Find the level of folders at which the students' files begin.

    def _downloads(self, place_of_all: Path) -> list[list[InputFile]]:
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
            packs = list(takewhile(lambda found: all(map(is_download, found)), inside))
            if len(packs) == len(loose):
                return [download for pack in packs for download in pack]
        return self._begun(items)

    def _inside(self, item: InputFile) -> list[InputFile]:
        try:
            with item.open() as stream:
                digest = self.archive.put(stream, MOST_PACK)
            return zip_items(self.archive.path(digest))
        except (BadZip, CannotArchive, OSError):
            return []

    def _begun(self, items: list[InputFile], packed: bool = False) -> list[list[InputFile]]:
        """Remove the folders above those of the students; each may be a download."""
        if not items or any(len(item.parts) == 1 for item in items):
            return [items]  # there are files, so no folder lies above
        folders: dict[str, list[InputFile]] = {}
        for item in items:
            folders.setdefault(item.parts[0], []).append(item.below(1))
        if any(map(platform_of, folders)) or self._are_students(folders):
            return [items]
        inside = list(folders.values())
        if all(map(_is_bulk, inside)) or (packed and len(inside) == 1 and _is_class(inside[0])):
            return inside
        if packed and len(inside) == 1:
            below = self._begun(inside[0], packed)
            return [items] if below == inside else below
        return [items]

    def _are_students(self, names: Iterable[str]) -> bool:
        """Whether any of the folders or zip files belongs to a student of the roster."""
        owners = (o for name in names for o in parse_path([name], platform_of(name)).owners)
        return bool(self._index.named(owners))

    def _described(self, items: Sequence[InputFile]) -> tuple[Sequence[InputFile], Metadata]:
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


def _file(student: str, item: InputFile, origin: FileOrigin, owner: OwnerHint) -> ReceivedFile:
    received, by = (origin.received, "platform") if origin.received else (item.time, item.by)
    late, sender = origin.late_mark, owner.text
    return ReceivedFile(student, origin.name, "", received, by, late, sender=sender)


def _is_bulk(items: Sequence[InputFile]) -> bool:
    """Whether all names have the form of one platform."""
    return is_of_one_platform({item.parts[0] for item in items})


def _is_class(items: Sequence[InputFile]) -> bool:
    """Whether there are several folders and nothing else, or files of a platform."""
    folders = {item.parts[0] for item in items if len(item.parts) > 1}
    return _is_bulk(items) or (len(folders) > 1 and all(len(i.parts) > 1 for i in items))


def _importance(item: InputFile) -> tuple[bool, tuple[str, ...]]:
    """Return the key by which files that are likely to be graded come first."""
    return not item.parts[-1].lower().endswith((".ipynb", ".py", ".zip")), item.parts
