"""One page about a reconstruction, complete in itself: the field, its error, how it came about."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.metadata import version
from typing import Any

from fieldrecon.experiments.files import csv_bytes
from fieldrecon.field_files import description
from fieldrecon.judging import Trial
from fieldrecon.outcome import Outcome

METHODS = ("method", "what it is", "rms error", "largest error", "remark")
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


def summary(outcome: Outcome, pictures: Mapping[str, bytes], options: Mapping[str, Any]) -> str:
    """HTML of the page.

    Parameters
    ----------
    outcome : Outcome
    pictures : mapping of str to bytes
        PNG by what it shows.
    options : mapping
        What was asked for on the command line.
    """
    name = outcome.result.names[-1]
    figures = "".join(_figure(caption, png) for caption, png in pictures.items())
    remarks = "".join(f"<li>{escape(remark)}</li>" for remark in outcome.remarks)
    method = description(outcome.field.method)
    parameters = {"method": method.pop("name")} | _flat(method) | dict(options)
    parameters |= {"fieldrecon": version("fieldrecon"), "time and memory": outcome.cost}
    size = f"{len(outcome.samples.points):,} samples of {outcome.source}"
    at = f"{len(outcome.result.values):,} {outcome.result.places.kind}"
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(name)}, reconstructed</title>
<style>{_STYLE}</style>
</head>
<body>
<main>
<h1>{escape(name)}, reconstructed</h1>
<p class="quiet">From {escape(size)}, at {escape(at)}, by {escape(outcome.method)}.</p>
<div class="pictures">{figures}</div>
<h2>What to know</h2>
<ul>{remarks}</ul>
{_methods(outcome)}
<h2>Parameters</h2>
<div class="scroll"><table><tbody>{_pairs(parameters)}</tbody></table></div>
</main>
</body>
</html>
"""


def methods_csv(outcome: Outcome) -> bytes:
    """Table of the methods: their errors at samples left out, or why there are none."""
    return csv_bytes(METHODS, (_method_row(trial) for trial in outcome.ranked))


def _method_row(trial: Trial) -> tuple[object, ...]:
    errors = ("", "") if trial.residuals is None else (trial.rms, trial.largest)
    return trial.candidate.name, trial.candidate.meaning, *errors, trial.reason


def _figure(caption: str, png: bytes) -> str:
    image = b64encode(png).decode()
    text = escape(caption, quote=True)
    return (
        f'<figure><img alt="{text}" src="data:image/png;base64,{image}">'
        f"<figcaption>{text}</figcaption></figure>"
    )


def _methods(outcome: Outcome) -> str:
    """The table of methods, the one that misses least first."""
    if not outcome.trials:
        return ""
    rows = "".join(
        f"<tr{' class=chosen' if trial is outcome.chosen else ''}>"
        + _cells([trial.candidate.name])
        + f'<td class="words">{escape(trial.candidate.meaning)}</td>'
        + (
            f'<td class="words" colspan="2">{escape(trial.reason)}</td>'
            if trial.residuals is None
            else _cells([f"{trial.rms:.4g}", f"{trial.largest:.4g}"], "number")
        )
        + "</tr>"
        for trial in outcome.ranked
    )
    head = '<th>method</th><th>what it is</th><th class="number">rms error</th>'
    return (
        "<h2>Methods</h2>"
        '<div class="scroll"><table>'
        f"<caption>How far each misses {outcome.judged:,} samples that are left out.</caption>"
        f'<thead><tr>{head}<th class="number">largest error</th></tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )


def _cells(texts: Iterable[str], kind: str = "") -> str:
    attribute = f' class="{kind}"' if kind else ""
    return "".join(f"<td{attribute}>{escape(text)}</td>" for text in texts)


def _pairs(parameters: Mapping[str, Any]) -> str:
    return "".join(
        f'<tr><th scope="row">{escape(key)}</th><td class="words">{escape(_typed(value))}</td></tr>'
        for key, value in parameters.items()
    )


def _flat(described: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """Parameters of parameters under one name each: kernel, kernel scale."""
    flat: dict[str, Any] = {}
    for key, value in described.items():
        if isinstance(value, Mapping):
            inner = dict(value)
            flat[f"{before}{key}"] = inner.pop("name")
            flat |= _flat(inner, f"{before}{key} ")
        elif value is not None:
            flat[f"{before}{key}"] = value
    return flat


def _typed(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return " × ".join(map(str, value))
    return str(value)
