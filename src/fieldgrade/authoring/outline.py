"""The outline of a notebook: its questions with points and minutes, and what it builds on.

The headers of the cells declare the minutes of each question; the front matter declares the rest::

    # jupyter:
    #   course:
    #     builds_on:
    #       "01": the matrix B and the normal equations
    #     pages: slides, pages 8–10 and 40
    #     chapters: [12-moving-least-squares]
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from fieldcheck.questions import questions
from fieldgrade.authoring.sources import Header, Source, sources

MOST_CORE_MINUTES = 150
"""The longest time of the questions of a notebook that are not optional."""


@dataclass(frozen=True)
class Item:
    """A question in the outline of a notebook.

    Parameters
    ----------
    question : str
        ``"02.3"``.
    title : str
        Its heading.
    function : str
        The requested function; empty if the answer is written in words.
    points : float
        The points of a right answer.
    minutes : int
        The expected time, reading included.
    words : int
        The expected length of an answer in words.
    is_optional : bool
        Whether it is optional.
    """

    question: str
    title: str
    function: str
    points: float
    minutes: int
    words: int
    is_optional: bool


@dataclass(frozen=True)
class Outline:
    """The questions of a source, and what its notebook builds on."""

    source: Source

    @cached_property
    def items(self) -> tuple[Item, ...]:
        """The questions in the order of the notebook."""
        titles, headers = self.source.question_titles, self.source.headers
        return tuple(_item(header, titles.get(name, "")) for name, header in headers.items())

    @property
    def core(self) -> tuple[Item, ...]:
        """The questions that are not optional."""
        return tuple(item for item in self.items if not item.is_optional)

    @property
    def optional(self) -> tuple[Item, ...]:
        """The optional questions."""
        return tuple(item for item in self.items if item.is_optional)

    @property
    def builds_on(self) -> list[tuple[Source, str]]:
        """The earlier notebooks on which it builds, each with what it uses of them."""
        declared = self.source.front_matter.get("builds_on") or {}
        return [(self._notebook(number), str(what)) for number, what in declared.items()]

    def _notebook(self, number: str) -> Source:
        there = {source.number: source for source in sources(self.source.path.parent)}
        if number not in there or number >= self.source.number:
            raise ValueError(
                f"{self.source.path.name} builds on {number!r}, which is no earlier notebook"
            )
        return there[number]

    @property
    def pages(self) -> str:
        """The pages that it is taken from."""
        return str(self.source.front_matter.get("pages", ""))

    @cached_property
    def chapters(self) -> tuple[str, ...]:
        """The titles of the chapters of the report on the same topic."""
        folder = self.source.path.parents[1] / "report" / "chapters"
        names = self.source.front_matter.get("chapters", ())
        return tuple(_title(folder / f"{name}.md") for name in names)

    def problems(self) -> list[str]:
        """Return what is missing or contradictory, in sentences."""
        name = self.source.path.name
        found = [f"{name}: {problem}" for item in self.items for problem in _problems(item)]
        if minutes(self.core) > MOST_CORE_MINUTES:
            found.append(
                f"{name}: the core takes {minutes(self.core)} minutes, more than "
                f"{MOST_CORE_MINUTES}; make a question optional"
            )
        declared = {"pages": self.pages, "chapters": self.chapters}
        return found + [
            f"{name}: the front matter has no {key}" for key in declared if not declared[key]
        ]


def points(items: Iterable[Item]) -> float:
    """Return the points of the items together."""
    return sum(item.points for item in items)


def minutes(items: Iterable[Item]) -> int:
    """Return the minutes of the items together."""
    return sum(item.minutes for item in items)


def _item(header: Header, title: str) -> Item:
    name, declared = header.question, header.numbers
    in_code = None if header.is_in_words else questions()[name]
    return Item(
        question=name,
        title=title,
        function=in_code.function if in_code else "",
        points=float(in_code.points) if in_code else declared.get("points", 0.0),
        minutes=int(declared.get("minutes", 0)),
        words=int(declared.get("words", 0)),
        is_optional=header.is_optional,
    )


def _problems(item: Item) -> list[str]:
    declared = {"points": item.points, "minutes": item.minutes}
    if not item.function:
        declared["words"] = item.words
    return [f"{item.question} has no {name}" for name, number in declared.items() if not number]


def _title(chapter: Path) -> str:
    if not chapter.is_file():
        raise ValueError(f"the front matter of a notebook names {chapter}, which does not exist")
    heading = chapter.read_text(encoding="utf-8").partition("\n")[0]
    return heading.lstrip("# ").partition(" {")[0]
