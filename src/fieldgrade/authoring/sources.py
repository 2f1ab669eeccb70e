"""The source of a notebook: a Python file in percent format, solutions included.

The header of a cell says what it is::

    # %% tags=["setup"]                                          imports, run before the answers
    # %% question="02.3" minutes=10                              a function that the student writes
    # %% [markdown] answer="02.7" points=2 minutes=10 words=60   a model answer in words
    # %% [markdown] rubric="02.7"                                how it is graded; for instructors

The word ``optional`` at the end of the header of a question marks it as optional. All other cells
are the same in both notebooks. The solution is between ``# BEGIN SOLUTION`` and
``# END SOLUTION``. The front matter declares what the notebook builds on (`outline`).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

BEGIN, END = "# BEGIN SOLUTION", "# END SOLUTION"
REGION = re.compile(rf"^(?P<indent> *){BEGIN}\n(?P<body>.*?)^ *{END}\n?", re.MULTILINE | re.DOTALL)
ASKED = re.compile(r'^# %% (?:\[markdown\] )?(question|answer)="(.+?)"(.*)$', re.MULTILINE)
NUMBER = re.compile(r"(points|minutes|words)=(\S+)")
HEADING = re.compile(r"^# #+ (\d\d\.\d+) (.+)$", re.MULTILINE)
NAME = re.compile(r"\d\d_\w+\.py")
IN_WORDS = "Answer in words"
"""The title of a question without a heading of its own."""


@dataclass(frozen=True)
class Header:
    """What the header of a cell declares about a question.

    Parameters
    ----------
    question : str
        ``"02.3"``.
    is_in_words : bool
        Whether the answer is written in words.
    is_optional : bool
        Whether it is optional.
    numbers : dict
        The declared points, minutes and words.
    """

    question: str
    is_in_words: bool
    is_optional: bool
    numbers: dict[str, float]


@dataclass(frozen=True)
class Cell:
    """A cell of a source.

    Parameters
    ----------
    kind : str
        ``"markdown"`` or ``"code"``.
    text : str
        The content.
    metadata : dict
        The metadata in its header.
    """

    kind: str
    text: str
    metadata: dict[str, Any]

    @property
    def question(self) -> str:
        """The question that it answers in code; may be empty."""
        return str(self.metadata.get("question", ""))

    @property
    def answer(self) -> str:
        """The question that it answers in words; may be empty."""
        return str(self.metadata.get("answer", ""))

    @property
    def rubric(self) -> str:
        """The question whose rubric it is; may be empty."""
        return str(self.metadata.get("rubric", ""))

    @property
    def is_setup(self) -> bool:
        """Whether it must run before the answers."""
        return "setup" in self.metadata.get("tags", ())

    @property
    def solutions(self) -> list[str]:
        """The solutions between the markers."""
        return [region["body"] for region in REGION.finditer(self.text + "\n")]


@dataclass(frozen=True)
class Source:
    """The source of a notebook."""

    path: Path

    @property
    def name(self) -> str:
        """``"02_moving_least_squares"``."""
        return self.path.stem

    @property
    def number(self) -> str:
        """``"02"``."""
        return self.name.partition("_")[0]

    @cached_property
    def _notebook(self) -> Any:
        import jupytext

        return jupytext.read(self.path, fmt="py:percent")

    @cached_property
    def cells(self) -> tuple[Cell, ...]:
        """All cells in order."""
        cells = self._notebook.cells
        return tuple(Cell(c.cell_type, c.source, dict(c.metadata)) for c in cells)

    @property
    def front_matter(self) -> dict[str, Any]:
        """The entry ``course`` of the front matter."""
        return dict(self._notebook.metadata.get("course", {}))

    @property
    def title(self) -> str:
        """The first heading."""
        return self.cells[0].text.partition("\n")[0].lstrip("# ")

    @cached_property
    def headers(self) -> dict[str, Header]:
        """What the headers declare about the questions, without reading the rest of the source."""
        found = ASKED.findall(self.path.read_text(encoding="utf-8"))
        return {
            question: Header(
                question,
                kind == "answer",
                rest.endswith(" optional"),
                {name: float(number) for name, number in NUMBER.findall(rest)},
            )
            for kind, question, rest in found
        }

    @property
    def written_points(self) -> dict[str, float]:
        """The points of the questions with written answers, from the headers alone."""
        written = (header for header in self.headers.values() if header.is_in_words)
        return {header.question: header.numbers.get("points", 0.0) for header in written}

    @cached_property
    def question_titles(self) -> dict[str, str]:
        """The titles of the questions, from the headings alone: ``{"01.1": "The matrix", …}``."""
        headings = HEADING.findall(self.path.read_text(encoding="utf-8"))
        return dict.fromkeys(self.written_points, IN_WORDS) | dict(headings)

    def answer_cells(self) -> dict[str, Cell]:
        """Return the cells with the requested functions, by question."""
        return {cell.question: cell for cell in self.cells if cell.question}

    def functions(self) -> dict[str, Any]:
        """Return the definitions of set-up and answers, without running checks or pictures."""
        namespace: dict[str, Any] = {"__name__": self.name}
        for number, cell in enumerate(self.cells):
            if cell.question or (cell.is_setup and cell.kind == "code"):
                exec(compile(cell.text, f"{self.path.name}, cell {number}", "exec"), namespace)
        return namespace


def sources(folder: Path) -> Iterator[Source]:
    """Yield the sources in a folder in the order of their numbers."""
    for path in sorted(folder.glob("*.py")):
        if NAME.fullmatch(path.name):
            yield Source(path)
