"""The map of the course: ``docs/course.md`` and its diagram, made from the outlines.

The diagram has a box for each notebook, one column further right than the last notebook on which it
builds. Boxes are light with dark text and the background is transparent, so that the diagram is
readable on light and dark pages.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from html import escape
from pathlib import Path
from textwrap import wrap

from fieldgrade.authoring.orientation import counted
from fieldgrade.authoring.outline import Item, Outline, minutes, points
from fieldgrade.authoring.sources import Source

PAGE, DIAGRAM = Path("docs/course.md"), Path("docs/images/course.svg")
NOTEBOOKS = "../exercises/"
"""Where the notebooks are, seen from the page; in the bundle they are beside it."""

COLORS = {"slides": "#d5e8d4", "book": "#dae8fc", "appendix": "#ffe6cc"}
"""The colour of a box, by the source of the notebook."""
WIDTH, HEIGHT, ACROSS, DOWN = 192, 62, 240, 78
"""The size of a box and the distances between boxes, in pixels."""
LINE, LETTERS = 15, 22
"""The height of a line of text, and the letters that fit into a box."""

INTRODUCTION = """\
# Map of the course

Each arrow leads from a notebook to one that builds on it. Each notebook defines, quotes or imports
all that it needs, so you may begin with any of them; the column *Builds on* says which ideas to
look up.

{diagram}

Minutes include reading, and are for a student who knows NumPy and meets the topic for the first
time; others may need twice as long. The core of a notebook fits into one sitting of two and a
half hours. *Optional* questions are not needed by any other question. All notebooks together:
{core} hours for the core, {optional} hours for the optional questions.

The sources are the lecture slides *Field Reconstruction: A Quick Survey of Methods* by K.
Erleben, chapter 1 of the book *Scattered Data Approximation* by H. Wendland (Cambridge University
Press, 2005), and the appendix of a thesis on mesh errors and conditionally positive definite
functions. The report of the project has a chapter on each topic.

## Ready-made functions

Notebooks import finished functions of earlier ones from `fieldcheck.given`:

| Function | Explained in | Imported by |
| --- | --- | --- |
| `distances` | notebook 03 | 09, 11, 12, 13 |
| `saddle_point_matrix` | notebook 03 | 09, 10, 11, 12, 13 |

You may use them in every answer, also in notebook 03. No function is there that a question asks
for, since each question is graded, in whatever order you do the notebooks. Where a later notebook
needs such a function, it asks for a variant of its own: 02.2 includes the matrix of 01.1, 05.7 is
04.1 with the origin at a vertex, and 06.4, 07.2 and 08.2 are circumcentres in the plane and in
space. Each of them can be written without the earlier one. If you have done that one, adapt your
own function.

## Notebooks
"""


def map_page(sources: Sequence[Source]) -> str:
    """Return the page with the diagram, a table of notebooks, and their questions."""
    outlines = [Outline(source) for source in sources]
    core = sum(minutes(outline.core) for outline in outlines)
    optional = sum(minutes(outline.optional) for outline in outlines)
    introduction = INTRODUCTION.format(
        diagram=f"![{in_words(outlines)}](images/{DIAGRAM.name})",
        core=round(core / 60),
        optional=round(optional / 60),
    )
    parts = [introduction, _notebooks(outlines), "## Questions\n"]
    return "\n".join([*parts, *map(_questions, outlines)])


def in_words(outlines: Sequence[Outline]) -> str:
    """Return the arrows of the diagram as text."""
    arrows = (
        f"{outline.source.number} builds on {' and '.join(source.number for source, _ in builds)}"
        for outline in outlines
        if (builds := outline.builds_on)
    )
    return "Diagram of the notebooks: " + "; ".join(arrows)


def _notebooks(outlines: Sequence[Outline]) -> str:
    heads = ("Notebook", "Builds on", "Core", "Optional", "Source", "Chapter of the report")
    return _table(heads, (_notebook(outline) for outline in outlines))


def _notebook(outline: Outline) -> tuple[str, ...]:
    source = outline.source
    builds = "; ".join(f"{earlier.number}: {what}" for earlier, what in outline.builds_on)
    return (
        f"[{source.number} {source.title}]({NOTEBOOKS}{source.name}.ipynb)",
        builds or "no other notebook",
        _effort(outline.core),
        _effort(outline.optional) if outline.optional else "–",
        outline.pages,
        ", ".join(f"*{chapter}*" for chapter in outline.chapters),
    )


def _effort(items: Sequence[Item]) -> str:
    return f"{minutes(items)} min, {counted(points(items), 'point')}"


def _questions(outline: Outline) -> str:
    heads = ("Question", "Title", "Function", "Points", "Minutes")
    rows = (
        (
            item.question,
            item.title + " (optional)" * item.is_optional,
            f"`{item.function}`" if item.function else f"about {item.words} words",
            f"{item.points:g}",
            str(item.minutes),
        )
        for item in outline.items
    )
    return f"### {outline.source.number} {outline.source.title}\n\n{_table(heads, rows)}"


def _table(heads: Sequence[str], rows: Iterator[tuple[str, ...]]) -> str:
    lines = (heads, ["---"] * len(heads), *rows)
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def map_diagram(sources: Sequence[Source]) -> str:
    """Return the diagram as SVG."""
    outlines = {source.number: Outline(source) for source in sources}
    earlier = {
        number: [source.number for source, _ in outline.builds_on]
        for number, outline in outlines.items()
    }
    places = _places(earlier)
    columns = 1 + max(column for column, _ in places.values())
    height = (1 + max(row for _, row in places.values())) * DOWN + LINE + 20
    width = (columns - 1) * ACROSS + WIDTH + 4
    body = [
        *(_arrow(places[a], places[b]) for b, before in earlier.items() for a in before),
        *(_box(places[number], outline) for number, outline in outlines.items()),
        *_legend(height - LINE - 12),
    ]
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height:g}" '
            f'width="{width}" height="{height:g}" font-family="sans-serif" font-size="13">',
            "<title>Which notebook builds on which</title>",
            '<defs><marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" '
            'markerHeight="8" orient="auto"><path d="M0 0L8 4L0 8z" fill="#7d8590"/>'
            "</marker></defs>",
            *body,
            "</svg>\n",
        ]
    )


def _places(earlier: Mapping[str, Sequence[str]]) -> dict[str, tuple[int, float]]:
    """Return the column and the row of each notebook.

    Each column is sorted by the mean row of the neighbours in the diagram, alternately those to the
    left and those to the right, which reduces the crossings (barycentre method of Sugiyama).
    """
    columns: dict[str, int] = {}
    for number, before in sorted(earlier.items()):
        columns[number] = 1 + max((columns[other] for other in before), default=-1)
    later = {n: [other for other in earlier if n in earlier[other]] for n in earlier}
    layers = [[n for n in columns if columns[n] == k] for k in range(1 + max(columns.values()))]
    for neighbours in (earlier, later, earlier, later, earlier):
        for layer in layers:
            layer.sort(key=partial(_mean_row, _rows(layers), neighbours))
    return {number: (columns[number], row) for number, row in _rows(layers).items()}


def _rows(layers: Sequence[Sequence[str]]) -> dict[str, float]:
    """Return the row of each notebook, such that each column fills the height."""
    most = max(map(len, layers))
    return {
        number: (k + 0.5) * most / len(layer) - 0.5
        for layer in layers
        for k, number in enumerate(layer)
    }


def _mean_row(
    rows: Mapping[str, float], neighbours: Mapping[str, Sequence[str]], number: str
) -> float:
    there = [rows[other] for other in neighbours[number]] or [rows[number]]
    return sum(there) / len(there)


def _corner(place: tuple[int, float]) -> tuple[float, float]:
    return 2 + place[0] * ACROSS, 2 + place[1] * DOWN


def _arrow(start: tuple[int, float], end: tuple[int, float]) -> str:
    (x, y), (to_x, to_y) = _corner(start), _corner(end)
    x, y, to_y = x + WIDTH, y + HEIGHT / 2, to_y + HEIGHT / 2
    bend = (to_x - x) / 2
    path = f"M{x:g} {y:g}C{x + bend:g} {y:g} {to_x - bend:g} {to_y:g} {to_x:g} {to_y:g}"
    return (
        f'<path d="{path}" fill="none" stroke="#7d8590" stroke-width="1.5" marker-end="url(#tip)"/>'
    )


def _box(place: tuple[int, float], outline: Outline) -> str:
    x, y = _corner(place)
    time = f"{minutes(outline.core)} min"
    if outline.optional:
        time += f", {minutes(outline.optional)} optional"
    title = wrap(f"{outline.source.number} {outline.source.title}", LETTERS)
    first = y + HEIGHT / 2 - len(title) * LINE / 2 + 4
    texts = [
        _text(x + 10, first + k * LINE, line, 'font-weight="bold"') for k, line in enumerate(title)
    ]
    texts.append(_text(x + 10, first + len(title) * LINE, time))
    return _rectangle(x, y, WIDTH, HEIGHT, COLORS[outline.pages.split()[0].strip(",")]) + "".join(
        texts
    )


def _legend(y: float) -> Iterator[str]:
    for k, (name, color) in enumerate(COLORS.items()):
        yield _rectangle(2 + k * 100, y, 90, LINE + 8, color)
        yield _text(12 + k * 100, y + LINE, name)


def _rectangle(x: float, y: float, width: float, height: float, color: str) -> str:
    return (
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="6" '
        f'fill="{color}" stroke="#57606a"/>'
    )


def _text(x: float, y: float, text: str, style: str = "") -> str:
    return f'<text x="{x:g}" y="{y:g}" fill="#1f2328" {style}>{escape(text)}</text>'
