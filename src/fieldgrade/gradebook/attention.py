"""Submissions that need the instructor's eyes: what happened, and what can be done.

The list is printed after grading and written as ``needs-your-eyes.html`` and ``.csv``.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import groupby, islice
from string import ascii_lowercase

from fieldgrade.checking.results import Record, Results
from fieldgrade.class_folder.csv_tables import to_csv
from fieldgrade.class_folder.dismissals import Dismissal
from fieldgrade.html_pages import page, table
from fieldrecon._core.digests import json_digest

FILE = "needs-your-eyes"
COLUMNS = ("entry", "student", "notebook", "file", "what", "details")

GRADER_FAILED = "not graded: the grader failed"
"""This cannot be dismissed: there is no grade yet."""

KINDS: Mapping[str, str] = {
    GRADER_FAILED: "Run the same command again; what is graded is kept.",
    "not graded: unreadable file": "The file is not a notebook that can be read. Ask the student "
    "for another file.",
    "not graded: no student": "The file belongs to no student. Correct its name or the roster, and "
    "grade again.",
    "student not on the roster": "The submission was graded under the name in the download. Add "
    "the student to the roster, or correct the columns by which your platform identifies students.",
    "partly graded": "A part of the notebook was stopped; the other answers were graded. Look "
    "whether the answers without points deserve an override.",
    "module missing": "The notebook imports a module, or a part of one, that is not available in "
    "the sandbox. Answers that need it have no points.",
    "file missing": "The notebook opens a file or a folder that was not submitted beside it. "
    "Answers that need it have no points. Ask the student for the file.",
    "file too large": "A submitted file is too large to be copied into the sandbox, or there are "
    "too many. Answers that need it have no points.",
    "helper file not used": "A submitted file has the name of a library, and the library is used.",
    "stub below an answer": "The function that was handed out stands below an answer. The answer "
    "counts.",
    "several senders": "Files under several names belong to one student of the roster. Check that "
    "this student sent them.",
    "several files": "The student submitted several files for one notebook, or files that are not "
    "notebooks. The latest notebook was graded.",
    "notebook does not count": "The notebook is not in assignments.csv or, without this table, few "
    "students submitted it. It changes nobody's total. To count it, add a line to "
    "assignments.csv.",
    "font missing": "A figure uses a font that is not installed here. Another font was used; this "
    "costs no points.",
    "error in a cell": "A cell stopped with an error. This costs no points unless an answer needs "
    "the cell.",
}
"""What can need attention, the most urgent first, and what it means."""

HARMLESS = ("error in a cell", "font missing", "stub below an answer")
"""Kinds that are listed and need no decision."""

NOTES: Mapping[str, re.Pattern[str]] = {
    "partly graded": re.compile(r"only the code that the answers need was run$"),
    "student not on the roster": re.compile(r" is not on the roster$"),
    "file too large": re.compile(r" is not available to the notebook: "),
    "helper file not used": re.compile(r" is not used, since a library has this name$"),
    "stub below an answer": re.compile(r"a stub is defined after an answer"),
    "several senders": re.compile(r"^the files of .+ count for "),
    "several files": re.compile(r" is not graded: "),
    "error in a cell": re.compile(r"^code cell \d+\b"),
}
"""How the notes of the grader are recognized."""

UNCOUNTED = "notebook does not count"
"""Its details count students, and change with each submission of others."""

STOPPED = {
    "partly": "a part of it broke down",
    "killed: time": "a part of it took too much time",
    "killed: memory": "a part of it took too much memory",
    "killed: output": "a part of it wrote too much",
}
DISMISSED = "These entries stand in dismissed.csv. An entry that changes is listed again."
MOST_NAMES = 8
"""Students that are printed for each kind."""


@dataclass(frozen=True)
class Concern:
    """A submission that needs attention.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    student, notebook, file : str
        The submission; the student of a file that belongs to none is empty.
    details : str
        What happened, in the words of the grader.
    digest : str
        SHA-256 of the file.
    """

    kind: str
    student: str
    notebook: str
    file: str
    details: str
    digest: str = ""

    @property
    def entry(self) -> str:
        """Ten letters that name it; others for another file, or if something else happened."""
        told = "" if self.kind == UNCOUNTED else self.details
        parts = self.kind, self.student, self.notebook, self.file, told, self.digest
        number = int(json_digest(*parts), 16)
        return "".join(ascii_lowercase[number // 26**k % 26] for k in range(10))

    @property
    def needs_decision(self) -> bool:
        """Whether somebody should look at it before the grades are published."""
        return self.kind not in HARMLESS


def concerns(
    results: Results, counted: Collection[str], strays: Iterable[str] = ()
) -> list[Concern]:
    """Return the submissions that need attention, the most urgent kind first.

    Parameters
    ----------
    results : Results
        The results of the grader.
    counted : collection of str
        The notebooks that count for the class.
    strays : iterable of str
        Files that belong to no student.
    """
    found = [Concern("not graded: no student", "", "", *_file_and_reason(s)) for s in strays]
    found += [concern for record in results.records for concern in _of_record(record)]
    found += _uncounted(results.records, counted)
    order = list(KINDS)
    return sorted(found, key=lambda c: (order.index(c.kind), c.student, c.notebook, c.file))


def _file_and_reason(stray: str) -> tuple[str, str]:
    name, _, reason = stray.rpartition(": ")
    return name or reason, reason if name else ""


def _uncounted(records: Sequence[Record], counted: Collection[str]) -> Iterator[Concern]:
    """Yield the submissions of notebooks that do not count, and how many students have one."""
    submitted = {(record.student, record.notebook) for record in records}
    students = Counter(notebook for _, notebook in submitted)
    everybody = len({student for student, _ in submitted})
    for record in records:
        if record.notebook and record.notebook not in counted:
            count = f"submitted by {students[record.notebook]} of {everybody} students"
            own = record.student, record.notebook, record.file
            yield Concern(UNCOUNTED, *own, count, record.digest)


def _of_record(record: Record) -> Iterator[Concern]:
    """Yield what a record says by its status and its notes."""

    def concern(kind: str, details: str) -> Concern:
        own = record.student, record.notebook, record.file
        return Concern(kind, *own, details, record.digest)

    if record.status == "grader failed":
        yield concern(GRADER_FAILED, "; ".join(record.notes))
    elif record.status == "unreadable":
        yield concern("not graded: unreadable file", "; ".join(record.notes[:1]))
    elif record.status in STOPPED:
        yield concern("partly graded", STOPPED[record.status])
    for kind, names in vars(record.missing).items():
        if names:
            yield concern(f"{kind.removesuffix('s')} missing", ", ".join(names))
    for note in record.notes:
        found = (kind for kind, pattern in NOTES.items() if pattern.search(note))
        yield from (concern(kind, note) for kind in islice(found, 1))


def attention_csv(found: Sequence[Concern]) -> str:
    """Return the list as a table."""
    return to_csv(
        COLUMNS, ((c.entry, c.student, c.notebook, c.file, c.kind, c.details) for c in found)
    )


def without_dismissed(
    found: Iterable[Concern], dismissals: Mapping[str, Dismissal]
) -> tuple[list[Concern], list[Concern]]:
    """Return the entries that still need attention, and those that were dismissed."""
    left, dismissed = list[Concern](), list[Concern]()
    for concern in found:
        is_dismissed = concern.entry in dismissals and concern.kind != GRADER_FAILED
        (dismissed if is_dismissed else left).append(concern)
    return left, dismissed


def attention_page(
    found: Sequence[Concern],
    dismissed: Sequence[Concern] = (),
    dismissals: Mapping[str, Dismissal] | None = None,
) -> str:
    """Return the list as a page with a table for each kind, and one of the dismissed entries."""
    columns = ("Student", "Submission", "Details", "Entry")
    body = [
        f"<h2>{escape(kind.capitalize())} ({len(its)})</h2><p>{escape(KINDS[kind])}</p>"
        + table(columns, map(_row, its), narrow=True)
        for kind, its in _by_kind(found)
    ]
    if dismissed:
        decided = [(*_row(c), _decision((dismissals or {})[c.entry])) for c in dismissed]
        body.append(f"<h2>Dismissed ({len(dismissed)})</h2><p>{DISMISSED}</p>")
        body.append(table((*columns, "Dismissed by"), decided, narrow=True))
    return page("Needs your eyes", f"{_sum(found)}.", "\n".join(body))


def _decision(dismissal: Dismissal) -> str:
    return f"{escape(dismissal.by)}: {escape(dismissal.reason)}"


def in_lines(found: Sequence[Concern], file: str, dismissed: int = 0) -> Iterator[str]:
    """Yield the list in short: how many submissions, the file, then for each kind the students."""
    yield f"{_sum(found)}: {file}" if found or dismissed else f"{_sum(found)}."
    for kind, its in _by_kind(found):
        names = list(dict.fromkeys(c.student or c.file for c in its))
        more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
        yield f"  {kind} ({len(names)}): {', '.join(names[:MOST_NAMES])}{more}"
    if dismissed:
        entries = "1 entry" if dismissed == 1 else f"{dismissed} entries"
        yield f"  dismissed in dismissed.csv: {entries}"


def _sum(found: Sequence[Concern]) -> str:
    files = {(c.student, c.file) for c in found if c.needs_decision}
    if not files:
        return "No submission needs your eyes"
    return f"{len(files)} submission{'s need' if len(files) > 1 else ' needs'} your eyes"


def _by_kind(found: Sequence[Concern]) -> Iterator[tuple[str, list[Concern]]]:
    yield from ((kind, list(its)) for kind, its in groupby(found, key=lambda c: c.kind))


def _row(concern: Concern) -> tuple[str, ...]:
    notebook = f"Notebook {concern.notebook}<br>" if concern.notebook else ""
    texts = escape(concern.student), notebook + escape(concern.file), escape(concern.details)
    return *texts, f"<code>{concern.entry}</code>"
