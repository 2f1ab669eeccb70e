"""The page of ``fieldrecon reconstruct``: the field, its error, and the methods by their errors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fieldrecon.io.saved_fields import description
from fieldrecon.io.tables import csv_bytes
from fieldrecon.pages.one_page import NOTHING, Html, fill, page, table
from fieldrecon.pipelines.reconstruct import SurveyResult
from fieldrecon.selection.cross_validation import Trial

METHODS = ("method", "what it is", "rms error", "largest error", "remark")

_METHODS = "<h2>Methods</h2>$table"
_HEAD = """<caption>Errors at $judged samples that are left out.</caption>
<thead><tr><th>method</th><th>what it is</th><th class="number">rms error</th>
<th class="number">largest error</th></tr></thead>
"""
_ROW = '<tr$chosen><td>$name</td><td class="words">$meaning</td>$errors</tr>'
_ERRORS = '<td class="number">$rms</td><td class="number">$largest</td>'
_NO_ERRORS = '<td class="words" colspan="2">$reason</td>'


def summary(survey: SurveyResult, pictures: Mapping[str, bytes], options: Mapping[str, Any]) -> str:
    """Return the HTML of the page.

    Parameters
    ----------
    survey : SurveyResult
    pictures : mapping of str to bytes
        PNG by caption.
    options : mapping
        The options of the command line.
    """
    name = survey.result.names[-1]
    method = description(survey.field.method)
    parameters = {"method": method.pop("name")} | _flattened(method) | dict(options)
    samples = f"{len(survey.samples.points):,} samples of {survey.source}"
    targets = f"{len(survey.result.values):,} {survey.result.targets.kind}"
    return page(
        f"{name}, reconstructed",
        f"From {samples}, at {targets}, by {survey.method}.",
        pictures,
        survey.warnings,
        _methods_section(survey) if survey.trials else NOTHING,
        parameters | {"time and memory": survey.cost},
    )


def methods_csv(survey: SurveyResult) -> bytes:
    """Return a table of the methods: their errors at samples left out, or why there are none."""
    return csv_bytes(METHODS, (_csv_row(trial) for trial in survey.ranked))


def _csv_row(trial: Trial) -> tuple[object, ...]:
    errors = ("", "") if trial.residuals is None else (trial.rms, trial.largest)
    return trial.candidate.name, trial.candidate.meaning, *errors, trial.reason


def _methods_section(survey: SurveyResult) -> Html:
    """Return the table of methods, by their error."""
    rows = (_row(trial, trial is survey.chosen) for trial in survey.ranked)
    head = fill(_HEAD, judged=f"{survey.judged:,}")
    return fill(_METHODS, table=table(rows, head))


def _row(trial: Trial, chosen: bool) -> Html:
    if trial.residuals is None:
        errors = fill(_NO_ERRORS, reason=trial.reason)
    else:
        errors = fill(_ERRORS, rms=f"{trial.rms:.4g}", largest=f"{trial.largest:.4g}")
    return fill(
        _ROW,
        chosen=Html(' class="chosen"' if chosen else ""),
        name=trial.candidate.name,
        meaning=trial.candidate.meaning,
        errors=errors,
    )


def _flattened(described: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested parameters under one name each, such as "kernel scale"."""
    flat: dict[str, Any] = {}
    for key, value in described.items():
        if isinstance(value, Mapping):
            inner = dict(value)
            flat[f"{prefix}{key}"] = inner.pop("name")
            flat |= _flattened(inner, f"{prefix}{key} ")
        elif value is not None:
            flat[f"{prefix}{key}"] = value
    return flat
