"""A hostile case: a submitted file, its fair grade, and the tiers that guarantee it."""

import json
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from fieldcheck.questions import questions
from fieldgrade.isolation.server import tiers
from fieldgrade.submissions.submission import Submission

ROOT = Path(__file__).parent.parent.parent
ALL = frozenset({"bubblewrap", "landlock", "none"})
SANDBOXED = frozenset({"bubblewrap", "landlock"})
"""Tiers that keep harmful programs away from files, network and other processes."""
HERE = tiers()
"""The tiers available on this machine."""
COUNTED = ALL if sys.platform == "linux" else SANDBOXED
"""Tiers that enforce the memory limit and find every leftover process; macOS does neither."""
POINTS = {
    number: {q.name: float(q.points) for q in questions().values() if q.notebook == number}
    for number in ("01", "02")
}
EVERYTHING = tuple(POINTS["01"])


@dataclass(frozen=True)
class Case:
    """A submission.

    Parameters
    ----------
    name : str
        A short description.
    lost : tuple of str
        The questions that earn no points from a fair grader; all others are answered rightly.
    before, after : str
        Cells inserted after the first cell, or at the end.
    answers : mapping
        Code that replaces the cell that defines a function.
    make : callable, optional
        Makes the file instead, from the notebook to its name and its bytes.
    tiers : frozenset
        The tiers that guarantee the grade and the safety of everything else. On other tiers the
        case is not run, since its attempts would succeed.
    status : str
        The expected status of the record, if the case tests it.
    notes : str
        Text expected in the notes, if any.
    number : str
        The notebook from which the file is made.
    helpers : mapping
        The content of files beside it, by their paths.
    missing : str
        The modules that are reported as missing.
    missing_files, missing_fonts : tuple of str
        The files and fonts that are reported as missing.
    """

    name: str
    lost: tuple[str, ...] = ()
    before: str = ""
    after: str = ""
    answers: Mapping[str, str] = field(default_factory=dict)
    make: Callable[[dict[str, Any]], tuple[str, bytes]] | None = None
    tiers: frozenset[str] = ALL
    status: str = ""
    notes: str = ""
    number: str = "01"
    helpers: Mapping[str, str | bytes] = field(default_factory=dict)
    missing: str = ""
    missing_files: tuple[str, ...] = ()
    missing_fonts: tuple[str, ...] = ()

    def fair_points(self) -> dict[str, float]:
        """The points of each question that a fair grader gives."""
        return {q: 0.0 if q in self.lost else p for q, p in POINTS[self.number].items()}

    def submission(self, places: Mapping[str, str]) -> Submission:
        """The file with its helpers, as a submission."""
        helpers = tuple(
            (name, text.encode() if isinstance(text, str) else text)
            for name, text in self.helpers.items()
        )
        return Submission("hostile", *self.submitted_file(places), helpers)

    def submitted_file(self, places: Mapping[str, str]) -> tuple[str, bytes]:
        """The name and the bytes of the file; ``@NAME@`` in code stands for a value of `places`."""
        made = notebook(self.number)
        for index, cell in enumerate(made["cells"]):
            for function, code in self.answers.items():
                if f"def {function}(" in cell["source"]:
                    made["cells"][index] = code_cell(code)
        first = next(i for i, c in enumerate(made["cells"]) if c["cell_type"] == "code")
        if self.before:
            made["cells"].insert(first + 1, code_cell(self.before))
        if self.after:
            made["cells"].append(code_cell(self.after))
        name, content = (self.make or as_file)(made)
        for place, value in places.items():
            content = content.replace(f"@{place}@".encode(), value.encode())
        return name, content


def as_file(made: dict[str, Any]) -> tuple[str, bytes]:
    """A notebook as Jupyter writes it."""
    return "01.ipynb", json.dumps(made, indent=1).encode()


def code_cell(code: str) -> dict[str, Any]:
    """A code cell."""
    return {
        "cell_type": "code",
        "execution_count": None,
        "metadata": {},
        "outputs": [],
        "source": code,
    }


def notebook(number: str = "01") -> dict[str, Any]:
    """The notebook with right answers as a student submits it; sources are strings."""
    made = json.loads(_solved(number))
    for cell in made["cells"]:
        cell["source"] = "".join(cell["source"])
    return dict(made)


@cache
def _solved(number: str) -> str:
    (file,) = (ROOT / "solutions").glob(f"{number}_*.ipynb")
    return file.read_text(encoding="utf-8")


def stub(function: str) -> str:
    """A function that is not written yet."""
    return f"def {function}(*args):\n    raise NotImplementedError\n"


FUNCTIONS = [q.function for q in questions().values() if q.notebook == "01"]
NO_ANSWERS = {function: f"def {function}(*args):\n    return 0.0\n" for function in FUNCTIONS}
"""Wrong answers to all questions."""
