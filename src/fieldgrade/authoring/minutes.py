"""Suggested minutes of each question, from its text and its solution.

A question takes the time to read the text that leads to it, to study the pictures, to write and
debug the function, or to write the answer. The speeds are for a student who knows NumPy and meets
the topic for the first time: 130 words per minute, about half the speed of easy prose, and one
minute for each displayed formula. Composing text at a keyboard takes 19 words per minute (Karat,
Halverson, Horn and Karat, CHI 1999); two minutes of thought for each point come before it. Two
minutes for a line of a solution are not measured: with them the core of a notebook fits into the
150 minutes of one sitting.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from fieldgrade.authoring.notebooks import DRAWS
from fieldgrade.authoring.outline import Item, Outline
from fieldgrade.authoring.sources import Cell

WORDS_PER_MINUTE = 130
WRITTEN_WORDS_PER_MINUTE = 19
PER_FORMULA, PER_PICTURE, PER_LINE, PER_CHECK, PER_POINT_IN_WORDS = 1.0, 2.0, 2.0, 3.0, 2.0
"""Minutes for a displayed formula, a picture, a line of a solution, a check, a point in words."""
STEP = 5
"""Suggestions are multiples of this number of minutes."""
DISPLAYED = re.compile(r"\$\$.*?\$\$", re.DOTALL)
INLINE = re.compile(r"\$.*?\$", re.DOTALL)
TAG = re.compile(r"</?\w+>")
OPENS = re.compile(r"^#+ |^\*\*\d\d\.\d+\*\*", re.MULTILINE)
"""The first line of the section of a question."""
LAST_SECTION = re.compile(r"^## Dig deeper", re.MULTILINE)


def suggested_minutes(outline: Outline) -> dict[str, int]:
    """Return the suggested minutes of each question."""
    sections = dict(_sections(outline.source.cells))
    return {
        item.question: max(STEP, STEP * round(_minutes(item, sections[item.question]) / STEP))
        for item in outline.items
    }


def _minutes(item: Item, cells: Sequence[Cell]) -> float:
    """Return the minutes for the section of a question."""
    prose = "\n".join(c.text for c in cells if c.kind == "markdown" and not c.answer)
    pictures = sum(bool(DRAWS.search(cell.text)) for cell in cells)
    lines = sum(len(body.split("\n")) - 1 for cell in cells for body in cell.solutions)
    writing = PER_POINT_IN_WORDS * item.points + item.words / WRITTEN_WORDS_PER_MINUTE
    return (
        number_of_words(prose) / WORDS_PER_MINUTE
        + PER_FORMULA * len(DISPLAYED.findall(prose))
        + PER_PICTURE * pictures
        + (PER_CHECK + PER_LINE * lines if item.function else writing)
    )


def number_of_words(prose: str) -> int:
    """Return the number of words; a formula in a sentence is one, a displayed one is none."""
    return len(TAG.sub("", INLINE.sub("x", DISPLAYED.sub("", prose))).split())


def _sections(cells: Sequence[Cell]) -> Iterator[tuple[str, list[Cell]]]:
    """Yield each question with its cells: from its heading to that of the next question."""
    name, section = "", list[Cell]()
    for cell in _until_the_last_section(cells):
        heading = OPENS.search(cell.text) if cell.kind == "markdown" and not cell.answer else None
        if name and heading:
            yield name, [*section, replace(cell, text=cell.text[: heading.start()])]
            name, section = "", [replace(cell, text=cell.text[heading.start() :])]
        else:
            name, section = cell.question or cell.answer or name, [*section, cell]
    yield name, section


def _until_the_last_section(cells: Sequence[Cell]) -> Iterator[Cell]:
    for cell in cells:
        end = LAST_SECTION.search(cell.text) if cell.kind == "markdown" else None
        if end:
            yield replace(cell, text=cell.text[: end.start()])
            return
        if not cell.rubric:
            yield cell
