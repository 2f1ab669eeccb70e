"""Answers that resemble each other, side by side, for somebody who knows the students."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape

from fieldgrade.class_folder.csv_tables import to_csv
from fieldgrade.gradebook.similarity import Code, Pair
from fieldgrade.html_pages import page

MOST_PAIRS = 30
"""So many are shown in full; the table has all."""
MOST_FUNCTIONS = 4
CAUTION = (
    "This is evidence to look at, and no verdict. Students who worked together as they were asked "
    "to, or who read the same page of a book, write what is alike; and a short question has few "
    "answers. Marked is what these two share and few others do; what was handed out is left out, "
    "and so are names, comments and layout."
)


def to_table(pairs: Sequence[tuple[str, Pair]]) -> str:
    """Return the pairs of each notebook as CSV."""
    columns = ("notebook", "one", "other", "shared part", "shared fingerprints", "functions")
    return to_csv(
        columns,
        (
            (number, p.one.student, p.other.student, p.part, len(p.shared), _functions(p))
            for number, p in pairs
        ),
    )


def similarity_page(title: str, pairs: Sequence[Pair], compared: int) -> str:
    """Return the page for a notebook.

    Parameters
    ----------
    title : str
        Of the notebook.
    pairs : sequence of Pair
        Those that share most first.
    compared : int
        How many answers were compared.
    """
    head = "<tr><th>Pair</th><th class='number'>Shared</th><th>In</th></tr>"
    rows = "".join(
        f'<tr><td><a href="#p{n}">{_names(p)}</a></td><td class="number">{p.part:.0%}</td>'
        f"<td>{escape(_functions(p))}</td></tr>"
        for n, p in enumerate(pairs[:MOST_PAIRS])
    )
    table = f'<div class="scroll"><table>{head}{rows}</table></div>' if pairs else ""
    body = [f"<p>{escape(CAUTION)}</p>", table]
    body += [line for n, p in enumerate(pairs[:MOST_PAIRS]) for line in _pair(n, p)]
    if not pairs:
        body.append("<p>No two of them share anything that few others do.</p>")
    told = f"{compared} notebooks compared, {len(pairs)} pairs share something"
    return page(f"Similar answers: {title}", told, "\n".join(body))


def _pair(number: int, pair: Pair) -> Iterator[str]:
    yield f'<h2 id="p{number}">{_names(pair)}, {pair.part:.0%}</h2>'
    for mine, theirs, _ in pair.functions()[:MOST_FUNCTIONS]:
        here, there = pair.lines(mine, theirs)
        sides = _side(pair.one, mine, here) + _side(pair.other, theirs, there)
        yield f'<div class="pair">{sides}</div>'


def _side(code: Code, name: str, marked: set[int]) -> str:
    text = "\n".join(
        f"<mark>{escape(line)}</mark>" if n in marked and line.strip() else escape(line)
        for n, line in enumerate(code.texts[name].splitlines())
    )
    return f'<div><p class="quiet">{escape(code.student)}</p><pre>{text}</pre></div>'


def _names(pair: Pair) -> str:
    return f"{escape(pair.one.student)} and {escape(pair.other.student)}"


def _functions(pair: Pair) -> str:
    found = pair.functions()
    return ", ".join(one if one == other else f"{one} and {other}" for one, other, _ in found)
