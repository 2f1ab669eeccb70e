"""Self-contained HTML pages without scripts and network, for screens (light and dark) and print."""

from __future__ import annotations

import base64
import json
import re
import subprocess
from collections.abc import Collection, Iterable, Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from fieldreport.build.typesetting import pandoc

TEMPLATE = Path(__file__).parent / "page.html"
FORMULA = re.compile(r"(\$\$[^$]{1,2000}\$\$|\$(?!\s)[^$\n]{1,500}(?<!\s)\$)")
HARD, HARD_BREAK = "\u2028", re.compile(r"\n(?=[ \t]*(?:[-*+|>#]|\d+[.)]|\n))|(?<=\n)\n")
"""Line breaks that are kept: before lines that look like list items, and around empty lines."""
BREAKS = {"\n": {"t": "SoftBreak"}, HARD: {"t": "LineBreak"}}
API = [1, 23]
"""The version of pandoc's syntax tree."""
CUT: Any = {"t": "RawBlock", "c": ["html", "<!-- next -->"]}
LONGEST = 20.0
"""Time limit for formulas, in seconds."""


def page(title: str, subtitle: str, body: str) -> str:
    """Return a page; title and subtitle are text, the body is HTML."""
    form = Template(TEMPLATE.read_text(encoding="utf-8"))
    return form.substitute(title=escape(title), subtitle=escape(subtitle), body=body)


def table(
    columns: Sequence[str],
    rows: Iterable[Sequence[str]],
    numbers: Collection[int] = (),
    narrow: bool = False,
) -> str:
    """Return a table of HTML cells under plain titles.

    Parameters
    ----------
    columns : sequence of str
        The titles.
    rows : iterable of sequence of str
        The cells, as HTML.
    numbers : collection of int
        Columns that are right-aligned.
    narrow : bool
        Whether long words are broken, so that the table fits a narrow screen.
    """

    def line(tag: str, cells: Sequence[str]) -> str:
        kinds = (' class="number"' if k in numbers else "" for k in range(len(cells)))
        inside = (f"<{tag}{kind}>{c}</{tag}>" for kind, c in zip(kinds, cells, strict=True))
        return f"<tr>{''.join(inside)}</tr>"

    body = "".join(line("td", row) for row in rows)
    kind = "scroll narrow" if narrow else "scroll"
    head = line("th", list(map(escape, columns)))
    return f'<div class="{kind}"><table>{head}{body}</table></div>'


def picture(svg: str, alt: str) -> str:
    """Return a drawing as an image, in which no script runs."""
    content = base64.b64encode(svg.encode()).decode()
    return f'<img src="data:image/svg+xml;base64,{content}" alt="{escape(alt)}">'


def rendered(markdown: str) -> str:
    """Return the course's own Markdown as HTML with formulas; not for students' text.

    Raises
    ------
    ValueError
        Pandoc reports an error or a warning.
    """
    return _pandoc(markdown, "--from=markdown", "--fail-if-warnings")


def with_formulas(texts: Sequence[str]) -> list[str]:
    """Return typed text as HTML: formulas are typeset, and nothing else is interpreted.

    Pandoc gets words, line ends and formulas as a syntax tree, so that there can be no markup, link
    or picture. Text that it cannot typeset is shown unchanged.
    """
    blocks = [block for text in texts for block in (_paragraph(text), CUT)]
    tree = {"pandoc-api-version": API, "meta": {}, "blocks": blocks}
    try:
        html = _pandoc(json.dumps(tree), "--from=json", "--wrap=preserve", timeout=LONGEST)
    except (ValueError, subprocess.TimeoutExpired):
        if len(texts) == 1:
            return [f"<pre>{escape(texts[0])}</pre>"]
        return [html for text in texts for html in with_formulas([text])]
    return html.split(CUT["c"][1])[: len(texts)]


def _paragraph(text: str) -> dict[str, Any]:
    inlines: list[dict[str, Any]] = []
    for part in FORMULA.split(HARD_BREAK.sub(HARD, text)):
        if FORMULA.fullmatch(part):
            kind = "DisplayMath" if part.startswith("$$") else "InlineMath"
            tex = part.strip("$").replace(HARD, "\n")
            inlines.append({"t": "Math", "c": [{"t": kind}, tex]})
        else:
            pieces = re.split(rf"([\n{HARD}])", part)
            inlines += [BREAKS.get(piece, {"t": "Str", "c": piece}) for piece in pieces]
    return {"t": "Para", "c": inlines}


def _pandoc(text: str, *options: str, timeout: float | None = None) -> str:
    run = subprocess.run(
        [str(pandoc()), "--to=html5", "--mathml", "--sandbox", *options],
        input=text,
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
        timeout=timeout,
    )
    if run.returncode:
        raise ValueError(f"pandoc: {run.stderr.strip()}")
    return run.stdout
