"""How the questions did, as a page for the instructor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from itertools import groupby

from fieldgrade.gradebook.item_analysis import Item
from fieldgrade.html_pages import page

LITTLE = 0.2
"""A discrimination below this says that a question tells little."""
BAR = 7.0
"""Length, in em, of the bar of a question that everybody fails."""

EXPLAINED = (
    "Failed is the part of the answers that did not earn all points; the mean is of the part of "
    "the points that was earned. Discrimination is the correlation of a question's points with "
    "those of the other questions of its notebook: below 0.2 it tells little, and below zero "
    "those who do worse on the rest do better on it, so that it should be looked at."
)


def analysis_page(found: Sequence[Item], titles: Mapping[str, str], told: str = "") -> str:
    """Return the page with a table for each notebook.

    Parameters
    ----------
    found : sequence of Item
        How the questions did, in their order.
    titles : mapping
        The titles of the notebooks.
    told : str
        A line on who was graded.
    """
    body = [f"<p>{escape(EXPLAINED)}</p>"]
    for notebook, its in groupby(found, key=lambda item: item.question.partition(".")[0]):
        title = f"{notebook} {titles.get(notebook, '')}".strip()
        body.append(f"<h2>{escape(title)}</h2>{_table(list(its))}")
    return page("How the questions did", told, "\n".join(body))


def _table(its: Sequence[Item]) -> str:
    head = (
        '<tr><th>Question</th><th class="number">Answers</th><th>Failed</th>'
        '<th class="number">Mean</th><th class="number">Discrimination</th>'
        "<th>Commonest mistakes</th></tr>"
    )
    return f'<div class="scroll"><table>{head}{"".join(map(_row, its))}</table></div>'


def _row(item: Item) -> str:
    mistakes = "<br>".join(f"{escape(name)} ({count})" for name, count in item.mistakes)
    bar = f'<span class="bar" style="width:{BAR * item.failed:.2f}em"></span>'
    return (
        f'<tr><td>{escape(item.question)}</td><td class="number">{item.answers}</td>'
        f'<td class="bars">{bar} {item.failed:.0%}</td><td class="number">{item.mean:.0%}</td>'
        f'<td class="number">{_discrimination(item)}</td><td>{mistakes}</td></tr>'
    )


def _discrimination(item: Item) -> str:
    if item.discrimination is None:
        return "–"
    text = f"{item.discrimination:.2f}".replace("-", "−")
    return f"<mark>{text}</mark>" if item.discrimination < LITTLE else text
