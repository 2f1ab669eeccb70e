"""The page of ``fieldrecon reconstruct``: the field, its error, and the methods by their errors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fieldrecon.io.saved_fields import description
from fieldrecon.io.tables import csv_bytes
from fieldrecon.pages.one_page import NOTHING, Html, fill, page, table
from fieldrecon.pipelines.reconstruct import SurveyResult
from fieldrecon.selection.cross_validation import ModelScore

METHODS = ("method", "what it is", "rms error", "largest error", "remark")

_METHODS = "<h2>Methods</h2>$table"
_HEAD = """<caption>Errors at $held_out samples that are left out.</caption>
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
        _methods_section(survey) if survey.scores else NOTHING,
        parameters | {"time and memory": survey.cost},
    )


def methods_csv(survey: SurveyResult) -> bytes:
    """Return a table of the methods: their errors at samples left out, or why there are none."""
    return csv_bytes(METHODS, (_csv_row(score) for score in survey.ranked))


def _csv_row(score: ModelScore) -> tuple[object, ...]:
    errors = ("", "") if score.residuals is None else (score.rms, score.largest)
    return score.model.name, score.model.meaning, *errors, score.reason


def _methods_section(survey: SurveyResult) -> Html:
    """Return the table of methods, by their error."""
    rows = (_row(score, score is survey.chosen) for score in survey.ranked)
    head = fill(_HEAD, held_out=f"{survey.n_held_out:,}")
    return fill(_METHODS, table=table(rows, head))


def _row(score: ModelScore, chosen: bool) -> Html:
    if score.residuals is None:
        errors = fill(_NO_ERRORS, reason=score.reason)
    else:
        errors = fill(_ERRORS, rms=f"{score.rms:.4g}", largest=f"{score.largest:.4g}")
    return fill(
        _ROW,
        chosen=Html(' class="chosen"' if chosen else ""),
        name=score.model.name,
        meaning=score.model.meaning,
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
