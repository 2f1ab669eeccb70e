"""What a notebook says about itself: a table below its title, and a line at each question.

Both are built from the `outline`, so that they agree with the map of the course.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from fieldgrade.authoring.outline import Item, Outline, minutes, points
from fieldgrade.authoring.sources import Cell

HEADING = re.compile(r"^#+ (\d\d\.\d+) .*$", re.MULTILINE)
BOLD = re.compile(r"^\*\*(\d\d\.\d+)\*\*", re.MULTILINE)


def with_orientation(outline: Outline, cell: Cell, text: str) -> str:
    """Return the text of a Markdown cell, with the table or the lines that belong to it.

    Parameters
    ----------
    outline : Outline
        The outline of the notebook.
    cell : Cell
        The cell.
    text : str
        Its text for this notebook.
    """
    if cell.kind != "markdown" or cell.answer or cell.rubric:
        return text
    items = {item.question: item for item in outline.items}
    text = HEADING.sub(lambda match: _below(match, items), text)
    text = BOLD.sub(lambda match: _behind(match, items), text)
    if cell is outline.source.cells[0]:
        text += "\n\n" + table(outline)
    return text


def effort(item: Item) -> str:
    """Return the points, the minutes and the length of a question in words.

    Examples
    --------
    >>> effort(Item("02.3", "Dimensions", "", 2.0, 10, 60, True))
    '2 points, about 10 minutes, about 60 words; optional'
    """
    parts = [counted(item.points, "point"), f"about {item.minutes} minutes"]
    parts += [f"about {item.words} words"] if item.words else []
    return ", ".join(parts) + ("; optional" if item.is_optional else "")


def counted(number: float, noun: str) -> str:
    """Return a number with its noun.

    Examples
    --------
    >>> counted(1.0, "point"), counted(2.5, "point")
    ('1 point', '2.5 points')
    """
    return f"{number:g} {noun}" + ("s" if number != 1 else "")


def table(outline: Outline) -> str:
    """Return the table below the title of a notebook."""
    core, optional = outline.core, outline.optional
    time, worth = f"about {minutes(core)} minutes", f"{points(core):g}"
    if optional:
        time += f"; about {minutes(optional)} more for the optional {listed(optional)}"
        worth += f", and {points(optional):g} for the optional questions"
    rows = {
        "Builds on": "; ".join(
            f"[{source.number} {source.title}]({source.name}.ipynb): {what}"
            for source, what in outline.builds_on
        )
        or "no other notebook",
        "Time": time,
        "Points": worth,
        "Source": outline.pages,
        "Report": "chapter" + "s" * (len(outline.chapters) > 1) + " " + _chapters(outline),
    }
    return "\n".join(["| | |", "|---|---|", *(f"| **{k}** | {v} |" for k, v in rows.items())])


def listed(items: Sequence[Item]) -> str:
    """Return the names of questions in a sentence: ``02.8, 02.9 and 02.10``."""
    *first, last = (item.question for item in items)
    return " and ".join(filter(None, [", ".join(first), last]))


def _chapters(outline: Outline) -> str:
    return ", ".join(f"*{title}*" for title in outline.chapters)


def _below(match: re.Match[str], items: Mapping[str, Item]) -> str:
    return f"{match[0]}\n\n*{effort(items[match[1]])}*"


def _behind(match: re.Match[str], items: Mapping[str, Item]) -> str:
    return f"{match[0]} *({effort(items[match[1]])})*"
