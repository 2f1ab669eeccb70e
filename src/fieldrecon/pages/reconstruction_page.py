"""One page about a reconstruction, complete in itself: the field, its error, how it came about."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from html import escape
from typing import Any

from fieldrecon.io.saved_fields import description
from fieldrecon.io.tables import csv_bytes
from fieldrecon.pages.one_page import page
from fieldrecon.pipelines.survey import Outcome
from fieldrecon.selection.cross_validation import ModelScore

METHODS = ("method", "what it is", "rms error", "largest error", "remark")


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
    method = description(outcome.field.method)
    parameters = {"method": method.pop("name")} | _flat(method) | dict(options)
    size = f"{len(outcome.samples.points):,} samples of {outcome.source}"
    at = f"{len(outcome.result.values):,} {outcome.result.places.kind}"
    return page(
        f"{name}, reconstructed",
        f"From {size}, at {at}, by {outcome.method}.",
        pictures,
        outcome.remarks,
        _methods(outcome),
        parameters | {"time and memory": outcome.cost},
    )


def methods_csv(outcome: Outcome) -> bytes:
    """Table of the methods: their errors at samples left out, or why there are none."""
    return csv_bytes(METHODS, (_method_row(trial) for trial in outcome.ranked))


def _method_row(trial: ModelScore) -> tuple[object, ...]:
    errors = ("", "") if trial.residuals is None else (trial.rms, trial.largest)
    return trial.model.name, trial.model.meaning, *errors, trial.reason


def _methods(outcome: Outcome) -> str:
    """The table of methods, the one that misses least first."""
    if not outcome.trials:
        return ""
    rows = "".join(
        f"<tr{' class=chosen' if trial is outcome.chosen else ''}>"
        + _cells([trial.model.name])
        + f'<td class="words">{escape(trial.model.meaning)}</td>'
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
