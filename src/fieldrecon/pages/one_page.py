"""A self-contained page of HTML: pictures, warnings, tables and parameters.

All HTML is made by `fill`, which escapes every text that is not HTML already.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.metadata import version
from string import Template
from typing import Any
from urllib.parse import quote

import numpy as np


class Html(str):
    """A text that is HTML, and is not escaped again."""


def fill(template: str, **values: object) -> Html:
    """Substitute values for the names in a template; all but `Html` are escaped.

    Examples
    --------
    >>> fill("<b>$name</b>$more", name="a < b", more=Html("<hr>"))
    '<b>a &lt; b</b><hr>'
    """
    escaped = {k: v if isinstance(v, Html) else escape(str(v)) for k, v in values.items()}
    return Html(Template(template).substitute(escaped))


NOTHING = Html()


def joined(parts: Iterable[Html]) -> Html:
    """Concatenate pieces of HTML."""
    return Html("".join(parts))


_STYLE = """
:root { color-scheme: light dark; --paper: #fff; --ink: #1c1c1c; --quiet: #56606b; --line: #d5d9df;
  --box: #f5f7f9; }
@media (prefers-color-scheme: dark) { :root { --paper: #16181b; --ink: #e4e4e2; --quiet: #a3abb5;
  --line: #3a4048; --box: #1f2327; } }
*, ::before, ::after { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem 1.2rem 3rem; max-width: 64rem; background: var(--paper);
  color: var(--ink); font: 1.05rem/1.5 Georgia, "Libertinus Serif", serif;
  overflow-wrap: anywhere; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: .5rem 0; }
h2 { font-size: 1.2rem; margin: 2rem 0 .6rem; }
.quiet { color: var(--quiet); margin: 0; }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 24rem), 1fr));
  gap: 1.2rem; margin: 1.5rem 0; }
figure { margin: 0; }
img { display: block; width: 100%; height: auto; background: #fff; border-radius: 3px;
  padding: .4rem; }
figcaption { font-size: .9rem; color: var(--quiet); margin-top: .4rem; }
ul { padding-left: 1.2rem; } li { margin: .35rem 0; }
a { color: inherit; text-underline-offset: .15em; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; min-width: min(100%, 34rem); font-size: .92rem;
  font-variant-numeric: tabular-nums; }
caption { text-align: left; color: var(--quiet); padding-bottom: .4rem; }
th, td { padding: .25rem .7rem .25rem 0; text-align: left; vertical-align: top; }
thead tr { border-bottom: 1.5px solid currentColor; }
tbody tr { border-bottom: 1px solid var(--line); }
td.number, th.number { text-align: right; white-space: nowrap; }
tr.chosen { font-weight: bold; background: var(--box); }
td.number, th.number { padding: .25rem 0 .25rem 1.4rem; }
tr > :first-child { white-space: nowrap; }
td.words { min-width: 10rem; overflow-wrap: break-word; }
"""
_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>$title</title>
<style>$style</style>
</head>
<body>
<main>
<h1>$title</h1>
<p class="quiet">$lead</p>
<div class="pictures">$figures</div>
<h2>What to know</h2>
<ul>$warnings</ul>
$sections
<h2>Parameters</h2>
$parameters
</main>
</body>
</html>
"""
_FIGURE = (
    '<figure><img alt="$caption" src="data:image/png;base64,$image">'
    "<figcaption>$caption</figcaption></figure>"
)
_LINK = '<li><a href="$where" download>$name</a></li>'
_TABLE = '<div class="scroll"><table>$head<tbody>$rows</tbody></table></div>'
_PAIR = '<tr><th scope="row">$name</th><td class="words">$value</td></tr>'


def page(
    title: str,
    lead: str,
    pictures: Mapping[str, bytes],
    warnings: Sequence[str],
    sections: Html,
    parameters: Mapping[str, Any],
) -> str:
    """Return the HTML of a page.

    Parameters
    ----------
    title, lead : str
        The subject, in a few words and in a sentence.
    pictures : mapping of str to bytes
        PNG by caption.
    warnings : sequence of str
        What a reader has to know.
    sections : Html
        More sections.
    parameters : mapping
        Parameters of the computation; the version is added.
    """
    figures = (
        fill(_FIGURE, caption=caption, image=b64encode(png).decode())
        for caption, png in pictures.items()
    )
    return fill(
        _PAGE,
        title=title,
        style=Html(_STYLE),
        lead=lead,
        figures=joined(figures),
        warnings=joined(fill("<li>$text</li>", text=text) for text in warnings),
        sections=sections,
        parameters=pairs(dict(parameters) | {"fieldrecon": version("fieldrecon")}),
    )


def table(rows: Iterable[Html], head: Html = NOTHING) -> Html:
    """Return a table of these rows, which scrolls if it is too wide."""
    return fill(_TABLE, head=head, rows=joined(rows))


def links(files: Iterable[str]) -> Html:
    """Return a list of links to files beside the page."""
    items = (fill(_LINK, where=quote(file), name=file) for file in files)
    return fill("<ul>$items</ul>", items=joined(items))


def pairs(parameters: Mapping[str, Any]) -> Html:
    """Return a table with a row for each name and value."""
    return table(fill(_PAIR, name=k, value=_formatted(v)) for k, v in parameters.items())


def _formatted(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, np.ndarray) and value.ndim:
        return f"{' × '.join(map(str, value.shape))} numbers"
    if isinstance(value, Sequence) and not isinstance(value, str):
        between = ", " if any(isinstance(one, str) for one in value) else " × "
        return between.join(map(str, value))
    return str(value)
