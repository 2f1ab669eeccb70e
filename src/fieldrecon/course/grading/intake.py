"""What was handed in: whose it is, what is graded of it, and the rest, which is told.

Each file is archived first. Of several files of a student with one notebook the latest is graded:
by the time it came, then by the number that a platform or a browser puts behind its name.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from fieldrecon.course.grading.archive import Archive
from fieldrecon.course.grading.platforms import (
    METADATA,
    Metadata,
    attempt,
    gradescope_metadata,
    is_platform,
    place,
)
from fieldrecon.course.grading.roster import Student, student_of
from fieldrecon.course.grading.submission import MOST_BYTES, Submission, Unreadable
from fieldrecon.course.grading.unpack import MEBIBYTE, Item, NoZip, folder_items, zip_items

MOST_FILE, MOST_PACK = 64 * MEBIBYTE, 8192 * MEBIBYTE
MOST_UNPACKED = 256 * MEBIBYTE
MOST_FILES = 500
"""Bytes and files that are unpacked of what one student packed."""


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


@dataclass(frozen=True)
class Handed:
    """What a student handed in of one notebook.

    Parameters
    ----------
    file : File
        What is graded.
    notebook : str
        Which it is; empty if it cannot be graded.
    problem : str
        Why it cannot.
    notes : tuple of str
        What else came, and why it is not graded.
    """

    file: File
    notebook: str = ""
    problem: str = ""
    notes: tuple[str, ...] = ()

    @property
    def student(self) -> str:
        """Whose it is."""
        return self.file.student

    def submission(self, archive: Archive) -> Submission:
        """Return the file with its content."""
        content = archive.read(self.file.digest, MOST_BYTES) if self.file.digest else b""
        return Submission(self.student, self.file.name, content)


@dataclass
class Intake:
    """Takes in a folder, or a zip file, of what a class handed in.

    Parameters
    ----------
    archive : Archive
        Where received files are kept.
    functions : mapping
        The functions that each notebook asks for.
    roster : mapping
        The students by name or number; may be empty.
    times : mapping
        When files came, by student and notebook, where it is better known than from the files.
    strays : list of str
        What came and is nobody's.
    """

    archive: Archive
    functions: Mapping[str, Iterable[str]]
    roster: Mapping[str, Student] = field(default_factory=dict)
    times: Mapping[tuple[str, str], str] = field(default_factory=dict)
    strays: list[str] = field(default_factory=list)

    def take(self, folder: Path) -> list[Handed]:
        """Return what is to be graded, in the order of students and notebooks.

        Raises
        ------
        ValueError
            There is nothing.
        """
        files = list(self._files(folder))
        by_student: dict[str, list[File]] = {}
        for file in files:
            by_student.setdefault(file.student, []).append(file)
        handed = [h for student in sorted(by_student) for h in self._sorted(by_student[student])]
        if not handed:
            raise ValueError(f"nothing was handed in: there is no file to be graded in {folder}")
        return handed

    # From the folder to the files of each student.

    def _files(self, folder: Path) -> Iterator[File]:
        items, metadata = self._described(self._items(folder))
        for item in items:
            where = place(item.parts, metadata)
            received, by = (where.received, "platform") if where.received else (item.time, item.by)
            for owner in where.owners:
                if item.refused and item.parts[0] == item.parts[-1] and item.by == "zip":
                    self.strays.append(f"{item.name}: {item.refused}")
                    continue
                student = student_of(owner, self.roster)
                file = File(student, where.name, "", received, by, where.late_mark)
                yield from self._unpacked(file, item)

    def _items(self, folder: Path) -> Iterator[Item]:
        """Yield the files of all students; a bulk download lies there as if it were unpacked."""
        if folder.is_file():
            yield from self._bulk(folder)
            return
        items = list(folder_items(folder))
        for item in items:
            if len(item.parts) == 1 and item.is_zip and not item.refused:
                inside = self._inside(item)
                if any(is_platform(i.parts[0]) or METADATA in i.parts[:2] for i in inside):
                    yield from inside
                    continue
                if len(items) == 1 and len({i.parts[0] for i in inside}) > 1:
                    yield from inside
                    continue
            yield item

    def _inside(self, item: Item) -> list[Item]:
        with item.open() as stream:
            digest = self.archive.put(stream, MOST_PACK)
        try:
            return _without_common_folder(zip_items(self.archive.path(digest)))
        except NoZip:
            return []

    def _bulk(self, pack: Path) -> list[Item]:
        with pack.open("rb") as stream:
            digest = self.archive.put(stream, MOST_PACK)
        return _without_common_folder(zip_items(self.archive.path(digest)))

    def _described(self, items: Iterable[Item]) -> tuple[list[Item], Metadata]:
        """Take out the file in which Gradescope tells whose each folder is."""
        found = list(items)
        metadata: Metadata = {}
        for item in found:
            if item.parts[-1] == METADATA and len(item.parts) <= 2 and not item.refused:
                with item.open() as stream:
                    text = stream.read(MOST_FILE).decode("utf-8", "replace")
                metadata = gradescope_metadata(text)
                root = item.parts[:-1]
                found = [
                    replace(i, parts=i.parts[len(root) :]) if i.parts[: len(root)] == root else i
                    for i in found if i is not item
                ]  # fmt: skip
                break
        return found, metadata

    def _unpacked(self, file: File, item: Item) -> Iterator[File]:
        """Yield a file of a student, or what is in it if it is a zip file."""
        kept = self._kept(file, item, MOST_FILE)
        if kept.problem or not item.is_zip:
            yield kept
            return
        try:
            inside = zip_items(self.archive.path(kept.digest))
        except NoZip as problem:
            yield replace(kept, problem=str(problem))
            return
        left = MOST_UNPACKED
        for member in inside[:MOST_FILES]:
            name = f"{file.name}/{member.name}"
            nested = replace(member, refused="it is a zip file in a zip file")
            taken = self._kept(
                replace(file, name=name), nested if member.is_zip else member, min(left, MOST_FILE)
            )
            if taken.digest:
                left -= self.archive.path(taken.digest).stat().st_size
            yield taken

    def _kept(self, file: File, item: Item, most: int) -> File:
        """Put a file into the archive; whatever is wrong with it is its problem."""
        if item.refused:
            return replace(file, problem=item.refused)
        try:
            with item.open() as stream:
                return replace(file, digest=self.archive.put(stream, most))
        except OSError as error:
            if item.by != "zip":
                raise
            return replace(file, problem=f"it cannot be unpacked ({error})")
        except Exception as error:  # each way to compress has errors of its own
            return replace(file, problem=f"it cannot be unpacked ({error})")

    # From the files of a student to what is graded.

    def _sorted(self, files: Sequence[File]) -> list[Handed]:
        graded: dict[str, Handed] = {}
        broken: list[Handed] = []
        notes: list[str] = []
        for file in sorted(files, key=_age):
            found = self._looked_at(file)
            if found.notebook:
                before = graded.get(found.notebook)
                if before and before.file.digest != file.digest:
                    notes.append(f"{before.file.name} is not graded: {file.name} came later")
                graded[found.notebook] = found
            elif found.problem:
                broken.append(found)
        hopeless = [h for h in broken if _was_meant(h)]
        rest = [h for h in broken if h not in hopeless]
        if not graded and not hopeless:
            hopeless, rest = rest[-1:], rest[:-1]
        notes += [f"{h.file.name} is not graded: {h.problem}" for h in rest]
        found = [*(graded[number] for number in sorted(graded)), *hopeless]
        if found:
            found[0] = replace(found[0], notes=tuple(notes))
        return found

    def _looked_at(self, file: File) -> Handed:
        """Return which notebook a file is."""
        if file.problem:
            return Handed(file, problem=file.problem)
        submission = Handed(file).submission(self.archive)
        if not _may_be_code(submission):
            return Handed(file, problem="it is no notebook")
        try:
            number = submission.notebook(self.functions)
        except Unreadable as error:
            return Handed(file, problem=str(error))
        except Exception as error:  # nothing that a student hands in stops the class
            return Handed(file, problem=f"it cannot be read ({type(error).__name__})")
        told = self.times.get((file.student, number))
        return Handed(replace(file, received=told, received_by="list") if told else file, number)


def _without_common_folder(items: list[Item]) -> list[Item]:
    """Take away a folder that all lie in, if it is no student's."""
    first = {item.parts[0] for item in items}
    inner = {item.parts[1] if len(item.parts) > 1 else "" for item in items}
    deep = all(len(item.parts) > 2 or is_platform(item.parts[-1]) for item in items)
    if len(first) != 1 or is_platform(*first) or not deep or "" in inner:
        return items
    return [replace(item, parts=item.parts[1:]) for item in items]


def _age(file: File) -> tuple[str, int, bool, str]:
    """Return by what the latest file is found."""
    return file.received, attempt(file.name), file.name.lower().endswith(".ipynb"), file.name


def _may_be_code(submission: Submission) -> bool:
    """Whether a file may be a notebook or a script, whatever it is called."""
    if submission.name.lower().endswith((".ipynb", ".py")):
        return True
    start = submission.content[:4096].lstrip(b"\xef\xbb\xbf \t\r\n")
    return start.startswith(b"{") and any(
        key in submission.content for key in (b'"cells"', b'"worksheets"')
    )


def _was_meant(handed: Handed) -> bool:
    """Whether what cannot be graded was meant to be: a notebook that is damaged."""
    is_notebook = handed.file.name.lower().endswith((".ipynb", ".zip"))
    return is_notebook and "none of the functions" not in handed.problem
