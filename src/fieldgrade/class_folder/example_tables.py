"""Empty tables of a class, with columns and example lines."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from fieldgrade.class_folder import assignments, dismissals, overrides
from fieldgrade.class_folder.private import keep_out_of_git
from fieldgrade.class_folder.roster import OPTIONAL
from fieldrecon._core.atomic_files import write_atomically

HEADERS: Mapping[str, tuple[str, ...]] = {
    "roster.csv": ("student", *OPTIONAL),
    "points.csv": ("question", "points"),
    "received.csv": ("student", "notebook", "received"),
    "assignments.csv": ("notebook", *assignments.COLUMNS),
    "extensions.csv": ("student", "notebook", "until", "reason"),
    "overrides.csv": overrides.COLUMNS,
    "dismissed.csv": dismissals.COLUMNS,
    "requests.csv": ("student", "question", "on", "request", "answer"),
}

DESCRIPTIONS: Mapping[str, str] = {
    "roster.csv": "The students of the class. Column student is required and must equal the "
    "text in student.txt; the others are needed for the files of your platform.",
    "points.csv": "Points of questions, if they differ from those of the notebooks.",
    "received.csv": "Times of receipt, which override those of the files.",
    "assignments.csv": "Deadlines, late penalty for each day begun, names and ids in Canvas "
    "and Moodle, and whether optional questions count (yes or no).",
    "extensions.csv": "Extended deadlines, with the reason.",
    "overrides.csv": "Points that replace those of the grader; the last line counts.",
    "dismissed.csv": "Entries of needs-your-eyes.csv that need nobody's eyes any more.",
    "requests.csv": "Regrade requests; a request with an empty answer is open.",
}

LINES: Mapping[str, tuple[str, ...]] = {
    "roster.csv": (
        'ada,"Lovelace, Ada",ada@uni.example,ada,1204,4711,Monday,88012',
        "alan,Alan Turing,alan@uni.example,alan,1205,4712,Monday,88013",
    ),
    "points.csv": ("01.3,4", "01.5,1.5"),
    "received.csv": ("ada,01,2026-11-30T22:10+01:00",),
    "assignments.csv": (
        "01,2026-11-30T23:59+01:00,15,10,50,Least squares (48213),Assignment: Least squares,no",
    ),
    "extensions.csv": ("ada,01,2026-12-04T23:59+01:00,ill",),
    "overrides.csv": ("ada,01.3,2,Grace Hopper,right but for a typing error,2026-12-02",),
    "dismissed.csv": ("kdbqwmzrta,Grace Hopper,The picture is part of the answer.",),
    "requests.csv": ("ada,01.3,2026-12-01,It works on my machine.,",),
}


def example(name: str) -> str:
    """Return an empty table: columns, a comment on its purpose, example lines as comments."""
    comments = (f"# {line}" for line in LINES[name])
    comment = '"# ' + DESCRIPTIONS[name].replace('"', '""') + '"'
    return "\n".join([",".join(HEADERS[name]), comment, *comments]) + "\n"


def write_examples(folder: Path) -> Iterator[tuple[Path, bool]]:
    """Write missing tables of a class; yield all paths, and whether each was written.

    Inside a git repository, git ignores the folder.
    """
    keep_out_of_git(folder)
    for name in HEADERS:
        file = folder / name
        is_new = not file.exists()
        if is_new:
            write_atomically(file, example(name).encode())
        yield file, is_new
