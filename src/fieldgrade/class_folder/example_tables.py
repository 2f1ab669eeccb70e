"""The tables of a class with their columns, and lines that show how to fill them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from fieldgrade.class_folder import assignments, overrides
from fieldgrade.class_folder.roster import OPTIONAL
from fieldrecon._core.atomic_files import write_atomically

HEADERS: Mapping[str, tuple[str, ...]] = {
    "roster.csv": ("student", *OPTIONAL),
    "points.csv": ("question", "points"),
    "received.csv": ("student", "notebook", "received"),
    "assignments.csv": ("notebook", *assignments.COLUMNS),
    "extensions.csv": ("student", "notebook", "until", "reason"),
    "overrides.csv": overrides.COLUMNS,
    "requests.csv": ("student", "question", "on", "request", "answer"),
}

TOLD: Mapping[str, str] = {
    "roster.csv": "Who is in the class. Only the first column must be filled; the others are "
    "needed by the platform whose files you want.",
    "points.csv": "What questions are worth, where it differs from the notebooks.",
    "received.csv": "When notebooks came, where it is better known than from the files.",
    "assignments.csv": "When notebooks are due, what a day begun after that costs, and what they "
    "are called in Canvas and Moodle.",
    "extensions.csv": "Who has more time, and why.",
    "overrides.csv": "Points that a person grants in place of the grader's; the last line counts.",
    "requests.csv": "What students ask to be looked at again; an empty answer is an open request.",
}

LINES: Mapping[str, tuple[str, ...]] = {
    "roster.csv": (
        'ada,"Lovelace, Ada",ada@uni.example,ada,1204,4711,Monday,88012',
        "alan,Alan Turing,alan@uni.example,alan,1205,4712,Monday,88013",
    ),
    "points.csv": ("01.3,4", "01.5,1.5"),
    "received.csv": ("ada,01,2026-11-30T22:10+01:00",),
    "assignments.csv": (
        "01,2026-11-30T23:59+01:00,15,10,50,Least squares (48213),Assignment: Least squares",
    ),
    "extensions.csv": ("ada,01,2026-12-04T23:59+01:00,ill",),
    "overrides.csv": ("ada,01.3,2,Grace Hopper,right but for a typing error,2026-12-02",),
    "requests.csv": ("ada,01.3,2026-12-01,It works on my machine.,",),
}


def example(name: str) -> str:
    """Return a table without content: a line on what it is for, its columns, lines to copy."""
    comments = (f"# {line}" for line in LINES[name])
    told = '"# ' + TOLD[name].replace('"', '""') + '"'
    return "\n".join([",".join(HEADERS[name]), told, *comments]) + "\n"


def write_examples(folder: Path) -> Iterator[tuple[Path, bool]]:
    """Write the tables of a class that are missing; yield all, and whether each was written."""
    for name in HEADERS:
        file = folder / name
        is_new = not file.exists()
        if is_new:
            write_atomically(file, example(name).encode())
        yield file, is_new
