"""A page of HTML that is complete in itself: pictures, what to know, tables, parameters."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from html import escape
from importlib.metadata import version
from typing import Any

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
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .92rem; font-variant-numeric: tabular-nums; }
caption { text-align: left; color: var(--quiet); padding-bottom: .4rem; }
th, td { padding: .25rem .7rem .25rem 0; text-align: left; vertical-align: top; }
thead tr { border-bottom: 1.5px solid currentColor; }
tbody tr { border-bottom: 1px solid var(--line); }
td.number, th.number { text-align: right; white-space: nowrap; }
tr.chosen { font-weight: bold; background: var(--box); }
td.number + td.number, th.number + th.number { padding-right: 0; }
tr > :first-child { white-space: nowrap; }
td.words { min-width: 10rem; overflow-wrap: break-word; }
"""


def page(
    title: str,
    lead: str,
    pictures: Mapping[str, bytes],
    remarks: Sequence[str],
    middle: str,
    parameters: Mapping[str, Any],
) -> str:
    """HTML of the page.

    Parameters
    ----------
    title, lead : str
        What it is about, in a few words and in a sentence.
    pictures : mapping of str to bytes
        PNG by what it shows.
    remarks : sequence of str
        What a reader should know.
    middle : str
        HTML of more sections.
    parameters : mapping
        What it was made with; the version is added.
    """
    figures = "".join(_figure(caption, png) for caption, png in pictures.items())
    told = "".join(f"<li>{escape(remark)}</li>" for remark in remarks)
    made = dict(parameters) | {"fieldrecon": version("fieldrecon")}
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}</title>
<style>{_STYLE}</style>
</head>
<body>
<main>
<h1>{escape(title)}</h1>
<p class="quiet">{escape(lead)}</p>
<div class="pictures">{figures}</div>
<h2>What to know</h2>
<ul>{told}</ul>
{middle}
<h2>Parameters</h2>
<div class="scroll"><table><tbody>{pairs(made)}</tbody></table></div>
</main>
</body>
</html>
"""


def _figure(caption: str, png: bytes) -> str:
    image = b64encode(png).decode()
    text = escape(caption, quote=True)
    return (
        f'<figure><img alt="{text}" src="data:image/png;base64,{image}">'
        f"<figcaption>{text}</figcaption></figure>"
    )


def pairs(parameters: Mapping[str, Any]) -> str:
    """Rows of a table: a name and a value each."""
    return "".join(
        f'<tr><th scope="row">{escape(key)}</th><td class="words">{escape(_typed(value))}</td></tr>'
        for key, value in parameters.items()
    )


def _typed(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return " × ".join(map(str, value))
    return str(value)
