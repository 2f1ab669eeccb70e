"""Intake: which of the received files of each student is graded, and notes on the others.

If a student submitted several files for one notebook, the latest is graded: by the time of receipt,
then by the number that a platform or a browser appends to a repeated name. A notebook takes
precedence over a script.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath

from fieldgrade.class_folder.roster import Student
from fieldgrade.submissions.archive import Archive
from fieldgrade.submissions.bulk_downloads import attempt
from fieldgrade.submissions.collection import Collection, ReceivedFile
from fieldgrade.submissions.helper_files import TOO_LARGE, helper_files, is_mentioned
from fieldgrade.submissions.submission import Submission, Unreadable


@dataclass
class Intake:
    """Takes in the submissions of a class from a folder or a zip file.

    Parameters
    ----------
    archive : Archive
        Where received files are kept.
    functions : mapping
        The functions that each notebook asks for.
    roster : mapping
        The students by name or number; may be empty.
    times : mapping
        Times of receipt by student and notebook, which override those of the files.
    strays : list of str
        Files that belong to no student.
    """

    archive: Archive
    functions: Mapping[str, Iterable[str]]
    roster: Mapping[str, Student] = field(default_factory=dict)
    times: Mapping[tuple[str, str], str] = field(default_factory=dict)
    strays: list[str] = field(default_factory=list)

    def take(self, folder: Path) -> list[ReceivedFile]:
        """Return the files to be graded, in the order of students and notebooks.

        Raises
        ------
        ValueError
            There is no file.
        """
        by_student: dict[str, list[ReceivedFile]] = {}
        for file in Collection(self.archive, self.roster, self.strays).files(folder):
            by_student.setdefault(file.student, []).append(file)
        chosen = [f for student in sorted(by_student) for f in self._chosen(by_student[student])]
        if not chosen:
            missing = f"there is no submission: {folder} contains no file to be graded"
            raise ValueError("\n".join([missing, *self.strays]))
        return chosen

    def _chosen(self, files: Sequence[ReceivedFile]) -> list[ReceivedFile]:
        """Return the files of a student to be graded; the first has the notes on the others."""
        graded: dict[str, ReceivedFile] = {}
        broken: list[ReceivedFile] = []
        notes: list[str] = []
        by_age = sorted(files, key=_age)
        for file in map(self._identified, by_age):
            if not file.notebook:
                broken.append(file)
                continue
            before = graded.get(file.notebook)
            if before and before.digest != file.digest:
                notes.append(f"{before.name} is not graded: {_reason(before, file)}")
            graded[file.notebook] = file
        graded = self._without_imported(graded)
        reported = [f for f in broken if _is_damaged(f)] or ([] if graded else broken[-1:])
        chosen, used = list[ReceivedFile](), set[str]()
        for _, file in sorted(graded.items()):
            helpers, left_out = helper_files(file, by_age, self.archive)
            notes += [TOO_LARGE.format(f.name) for f in self._mentioned(file, left_out)]
            used |= {f.digest for f in self._mentioned(file, [*helpers.values(), *left_out])}
            paths = tuple(sorted((path, f.digest) for path, f in helpers.items()))
            chosen.append(replace(file, helpers=paths))
        others = (f for f in broken if f not in reported and f.digest not in used)
        notes += [f"{f.name} is not graded: {f.problem}" for f in others]
        if self.roster and files[0].student not in self.roster:
            notes.append(f"{files[0].student} is not on the roster")
        senders = sorted({file.sender for file in files})
        if len(senders) > 1:
            notes.append(f"the files of {' and of '.join(senders)} count for {files[0].student}")
        found = [*chosen, *reported]
        return [replace(found[0], notes=tuple(dict.fromkeys(notes))), *found[1:]]

    def _mentioned(
        self, file: ReceivedFile, others: Iterable[ReceivedFile]
    ) -> Iterator[ReceivedFile]:
        """Yield Python files, and other files whose names are in the code of a file."""
        others = list(others)
        if all(map(_is_script, others)):
            yield from others
            return
        code = "\n".join(file.submission(self.archive).sources)
        yield from (f for f in others if _is_script(f) or is_mentioned(f, code))

    def _without_imported(self, graded: dict[str, ReceivedFile]) -> dict[str, ReceivedFile]:
        """Leave out scripts that a notebook imports: they answer no notebook of their own."""
        notebooks = [file for file in graded.values() if not _is_script(file)]
        if not notebooks or len(notebooks) == len(graded):
            return graded
        code = (file.submission(self.archive) for file in notebooks)
        imported = frozenset[str]().union(*(submission.imported for submission in code))
        return {
            number: file
            for number, file in graded.items()
            if not (_is_script(file) and PurePosixPath(file.name).stem in imported)
        }

    def _identified(self, file: ReceivedFile) -> ReceivedFile:
        """Return a file with the number of its notebook, or with a problem."""
        if file.problem:
            return file
        submission = file.submission(self.archive)
        if not _may_be_code(submission):
            return replace(file, problem="it is not a notebook")
        try:
            number = submission.notebook(self.functions)
        except Unreadable as error:
            return replace(file, problem=str(error))
        except Exception as error:  # no submission stops the class
            return replace(file, problem=f"it cannot be read ({type(error).__name__})")
        if time := self.times.get((file.student, number)):
            file = replace(file, received=time, received_by="list")
        return replace(file, notebook=number)


def _age(file: ReceivedFile) -> tuple[bool, str, int, str]:
    """Return the key by which files are sorted; the last is graded."""
    return not _is_script(file), file.received, attempt(file.name), file.name


def _is_script(file: ReceivedFile) -> bool:
    return file.name.lower().endswith(".py")


def _reason(before: ReceivedFile, file: ReceivedFile) -> str:
    is_upgrade = _is_script(before) and not _is_script(file)
    return f"{file.name} is the notebook" if is_upgrade else f"{file.name} came later"


def _may_be_code(submission: Submission) -> bool:
    """Whether a file may be a notebook or a script, whatever its name."""
    if submission.name.lower().endswith((".ipynb", ".py")):
        return True
    start = submission.content[:4096].lstrip(b"\xef\xbb\xbf \t\r\n")
    return start.startswith(b"{") and any(
        key in submission.content for key in (b'"cells"', b'"worksheets"')
    )


def _is_damaged(file: ReceivedFile) -> bool:
    """Whether a file that cannot be graded is a damaged notebook, rather than something else."""
    is_notebook = file.name.lower().endswith((".ipynb", ".zip"))
    return is_notebook and "none of the functions" not in file.problem
