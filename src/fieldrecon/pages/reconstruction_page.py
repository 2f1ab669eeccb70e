"""The page of ``fieldrecon reconstruct``: the field, its error, and the methods by their errors."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from fieldrecon._core.extras import PICTURES, absent, require
from fieldrecon.io.saved_fields import description
from fieldrecon.io.tables import csv_bytes
from fieldrecon.pages.one_page import NOTHING, Html, fill, joined, page, table
from fieldrecon.plotting.figure_files import figure_bytes
from fieldrecon.selection.cross_validation import ModelScore

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fieldrecon.pipelines.surveys import SurveyResult

CAPTIONS = {
    "reconstruction": "The field",
    "error": "The error of the field",
    "distances": "Distances from the nearest sample: of the targets, of the held-out samples, and "
    "of each sample from the others",
    "held_out": "Held-out samples against their predictions",
}
"""The pictures of a page, by name."""
METHODS = ("method", "what it is", "held out", "rms error", "largest error", "remark")

_METHODS = "<h2>Methods</h2>$table"
_HEAD = """<caption>Errors at samples that are held out. All methods are compared at the first of
them, and the best at all.</caption>
<thead><tr><th>method</th><th>what it is</th><th class="number">held out</th>
<th class="number">rms error</th>
<th class="number">largest error</th></tr></thead>
"""
_ROW = '<tr$chosen><td>$name</td><td class="words">$meaning</td>$errors</tr>'
_COVERAGE = "<h2>Coverage of the error by distance</h2>$table"
_COVERAGE_HEAD = """<caption>Fraction of the held-out samples whose residual is below the given
error, by distance from the nearest sample.</caption>
<thead><tr><th class="number">distance up to</th><th class="number">held out</th>
<th class="number">covered</th></tr></thead>
"""
_COVERAGE_ROW = (
    '<tr><td class="number">$far</td><td class="number">$count</td>'
    '<td class="number">$share %</td></tr>'
)
_ERRORS = (
    '<td class="number">$held_out</td><td class="number">$rms</td><td class="number">$largest</td>'
)
_NO_ERRORS = '<td class="words" colspan="3">$reason</td>'


def pictures(survey: SurveyResult, *names: str) -> dict[str, Figure]:
    """Draw the pictures of these names, or all that there are.

    Raises
    ------
    ModuleNotFoundError
        If the packages that draw are not installed: with the extra that provides them.
    """
    require(*PICTURES)
    from fieldrecon.plotting.field_pictures import plot, plot_error
    from fieldrecon.plotting.validation_pictures import plot_distances, plot_held_out

    draw = {"reconstruction": partial(plot, survey), "error": partial(plot_error, survey)}
    if not isinstance(survey.validation, str):
        draw["distances"] = partial(plot_distances, survey.validation)
        draw["held_out"] = partial(plot_held_out, survey.validation, survey.result.labels[-1])
    return {name: draw[name]() for name in names or draw}


def summary(
    survey: SurveyResult,
    options: Mapping[str, Any],
    drawn: Mapping[str, Figure] | None = None,
) -> str:
    """Return the HTML of the page; without pictures if the packages that draw are missing.

    Parameters
    ----------
    survey : SurveyResult
    options : mapping
        The options of the command line, or other parameters.
    drawn : mapping of str to Figure, optional
        The pictures, if they are drawn already.
    """
    if drawn is None:
        drawn = {} if absent(*PICTURES) else pictures(survey)
    images = {CAPTIONS[name]: figure_bytes(picture, "png") for name, picture in drawn.items()}
    name = survey.result.labels[-1]
    method = description(survey.field.method)
    parameters = {"method": method.pop("name")} | _flattened(method) | dict(options)
    samples = f"{len(survey.samples.points):,} samples of {survey.source}"
    targets = f"{len(survey.result.values):,} {survey.result.targets.kind}"
    return page(
        f"{name}, reconstructed",
        f"From {samples}, at {targets}, by {survey.method}.",
        images,
        survey.warnings,
        joined([_methods_section(survey), _coverage_section(survey)]),
        parameters | {"time and memory": survey.cost},
    )


def methods_csv(survey: SurveyResult) -> bytes:
    """Return a table of the methods: their errors at samples left out, or why there are none."""
    return csv_bytes(METHODS, (_csv_row(score) for score in survey.ranked))


def _csv_row(score: ModelScore) -> tuple[object, ...]:
    errors: tuple[object, ...] = score.n_held_out, score.rms, score.largest
    if score.residuals is None:
        errors = ("",) * len(errors)
    return score.model.name, score.model.meaning, *errors, score.reason


def _methods_section(survey: SurveyResult) -> Html:
    """Return the table of methods, by their error."""
    if not survey.scores:
        return NOTHING
    rows = (_row(score, score is survey.chosen) for score in survey.ranked)
    head = fill(_HEAD)
    return fill(_METHODS, table=table(rows, head))


def _coverage_section(survey: SurveyResult) -> Html:
    """Return the table of the coverage of the error, by distance from the nearest sample."""
    if isinstance(survey.validation, str):
        return NOTHING
    rows = (
        fill(_COVERAGE_ROW, far=far, count=count, share=f"{100 * share:.0f}")
        for far, share, count in survey.validation.coverage()
    )
    return fill(_COVERAGE, table=table(rows, fill(_COVERAGE_HEAD)))


def _row(score: ModelScore, chosen: bool) -> Html:
    if score.residuals is None:
        errors = fill(_NO_ERRORS, reason=score.reason)
    else:
        errors = fill(
            _ERRORS,
            held_out=score.n_held_out,
            rms=f"{score.rms:.4g}",
            largest=f"{score.largest:.4g}",
        )
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
