"""A case: a file that is handed in, the grade that is fair, and where that is promised."""

import json
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from fieldcheck.questions import questions
from fieldgrade.isolation.server import tiers

ROOT = Path(__file__).parent.parent.parent
ALL = frozenset({"bubblewrap", "landlock", "none"})
WALLS = frozenset({"bubblewrap", "landlock"})
"""Tiers that keep a program that means harm away from files, network and other processes."""
HERE = tiers()
"""The tiers of this machine."""
COUNTED = ALL if sys.platform == "linux" else WALLS
"""Tiers that hold memory to its limit and find every process that was left; macOS does neither."""
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
        What it is, in a few words.
    lost : tuple of str
        The questions for which a fair grader gives nothing; all others are answered rightly.
    before, after : str
        Cells put after the first one, or at the end.
    answers : mapping
        Code in the place of the cell that defines a function.
    make : callable, optional
        Makes the file instead: from the text of the notebook to its name and its bytes.
    tiers : frozenset
        On which tiers the grade, and that nobody is harmed, is promised. On the others it is not
        run, since it would do what it tries.
    status : str
        The status of the record, where the case is about it.
    notes : str
        What a note says, where there is to be one.
    number : str
        The notebook that it starts from.
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

    def fair(self) -> dict[str, float]:
        """The points of each question that a fair grader gives."""
        return {q: 0.0 if q in self.lost else p for q, p in POINTS[self.number].items()}

    def handed_in(self, places: Mapping[str, str]) -> tuple[str, bytes]:
        """The name and the bytes of the file; ``@NAME@`` in code stands for a place."""
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
    """The notebook with right answers, as a student hands it in; sources are text, not lines."""
    made = json.loads(_solved(number))
    for cell in made["cells"]:
        cell["source"] = "".join(cell["source"])
    return dict(made)


@cache
def _solved(number: str) -> str:
    (file,) = (ROOT / "solutions").glob(f"{number}_*.ipynb")
    return file.read_text(encoding="utf-8")


def stub(function: str) -> str:
    """A function that is not written."""
    return f"def {function}(*args):\n    raise NotImplementedError\n"


FUNCTIONS = [q.function for q in questions().values() if q.notebook == "01"]
NO_ANSWERS = {function: f"def {function}(*args):\n    return 0.0\n" for function in FUNCTIONS}
"""Answers that are all wrong."""
