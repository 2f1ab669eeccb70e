"""What was handed in: which file of a student is graded, and the rest, which is told.

Of several files of a student for one notebook the latest is graded: by the time it came, then by
the number that a platform or a browser puts behind its name. A notebook goes before a script.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from fieldgrade.class_folder.roster import Student
from fieldgrade.submissions.archive import Archive
from fieldgrade.submissions.collection import Collection, File
from fieldgrade.submissions.platforms import attempt
from fieldgrade.submissions.submission import MOST_BYTES, Submission, Unreadable


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
        by_student: dict[str, list[File]] = {}
        for file in Collection(self.archive, self.roster, self.strays).files(folder):
            by_student.setdefault(file.student, []).append(file)
        handed = [h for student in sorted(by_student) for h in self._chosen(by_student[student])]
        if not handed:
            raise ValueError(f"nothing was handed in: there is no file to be graded in {folder}")
        return handed

    def _chosen(self, files: Sequence[File]) -> list[Handed]:
        """Return what is graded of a student's files; the first of it has the notes on the rest."""
        graded: dict[str, Handed] = {}
        broken: list[Handed] = []
        notes: list[str] = []
        for file in sorted(files, key=_age):
            handed = self._looked_at(file)
            if not handed.notebook:
                broken.append(handed)
                continue
            before = graded.get(handed.notebook)
            if before and before.file.digest != file.digest:
                notes.append(f"{before.file.name} is not graded: {_reason(before.file, file)}")
            graded[handed.notebook] = handed
        hopeless = [h for h in broken if _was_meant(h)] or ([] if graded else broken[-1:])
        notes += [f"{h.file.name} is not graded: {h.problem}" for h in broken if h not in hopeless]
        if self.roster and files[0].student not in self.roster:
            notes.append(f"{files[0].student} is not on the roster")
        found = [*(graded[number] for number in sorted(graded)), *hopeless]
        return [replace(found[0], notes=tuple(notes)), *found[1:]]

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


def _age(file: File) -> tuple[bool, str, int, str]:
    """Return by what the latest file is found."""
    is_notebook = not file.name.lower().endswith(".py")
    return is_notebook, file.received, attempt(file.name), file.name


def _reason(before: File, file: File) -> str:
    kinds = [name.lower().endswith(".py") for name in (before.name, file.name)]
    if kinds == [True, False]:
        return f"{file.name} is the notebook"
    return f"{file.name} came later"


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
