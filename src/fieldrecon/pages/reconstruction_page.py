"""The page of ``fieldrecon reconstruct``: the field, its error, and the methods by their errors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fieldrecon._core.extras import PICTURES, require
from fieldrecon.io.saved_fields import description
from fieldrecon.io.tables import csv_bytes
from fieldrecon.pages.one_page import NOTHING, Html, fill, joined, links, page, table
from fieldrecon.plotting.figure_files import figure_bytes
from fieldrecon.selection.model_scores import ModelScore

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fieldrecon.pipelines.survey_results import SurveyResult

CAPTIONS = {
    "reconstruction": "The field",
    "error": "The error of the field",
    "nearest": "Distance from the nearest sample",
    "variogram": "The variogram of the samples",
    "distances": "Distances from the nearest sample: of the targets, of the held-out samples, and "
    "of each sample from the others",
    "held_out": "Held-out samples against their predictions",
}
"""The pictures of a page, by name."""
COLORS = "viridis"
"""The colour map unless another one is chosen."""
OF_EACH_VALUE = ("reconstruction", "error", "variogram", "held_out")
"""The pictures of one value, which there are for each of several."""
METHODS = ("method", "what it is", "held out", "rms error", "largest error", "remark")

_METHODS = "<h2>Methods</h2>$table"
_HEAD = """<caption>Errors at samples that are held out$unit. All methods are compared at the first
of them, and the best at all.</caption>
<thead><tr><th>method</th><th>what it is</th><th class="number">held out</th>
<th class="number">rms error</th>
<th class="number">largest error</th></tr></thead>
"""
_ROW = '<tr$chosen><td>$name</td><td class="words">$meaning</td>$errors</tr>'
_VARIOGRAM = "<h2>Variogram</h2>$table"
_VARIOGRAM_HEAD = """<caption>The exponential model that is fitted to half the mean square of the
differences of samples, by their distance. The nugget is the noise, and what varies between nearest
samples; the range is the distance beyond which samples are hardly correlated. It describes the
samples; the methods are chosen by the held-out samples.</caption>
<thead><tr><th>value</th><th class="number">nugget</th><th class="number">sill</th>
<th class="number">range</th></tr></thead>
"""
_VARIOGRAM_ROW = (
    '<tr><td>$name</td><td class="number">$nugget</td><td class="number">$sill</td>'
    '<td class="number">$range</td></tr>'
)
_COVERAGE = "<h2>Coverage of the error$of_value by distance</h2>$table"
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


def pictures(survey: SurveyResult, colors: str = COLORS) -> dict[str, Figure]:
    """Draw all pictures that there are, by their names; those of several values are numbered.

    Raises
    ------
    ModuleNotFoundError
        If the packages that draw are not installed: with the extra that provides them.
    ValueError
        If there is no such colour map.
    """
    several = survey.samples.values.ndim == 2
    names = [name for name in CAPTIONS if _is_known(survey, name)]
    return {
        f"{name}_{k + 1}" if several and name in OF_EACH_VALUE else name: picture(
            survey, name, k, colors
        )
        for k in range(len(survey.samples.value_names))
        for name in names
        if k == 0 or name in OF_EACH_VALUE
    }


def as_png(drawn: Mapping[str, Figure]) -> dict[str, bytes]:
    """The pictures as PNG, by their names."""
    return {name: figure_bytes(one, "png") for name, one in drawn.items()}


def _is_known(survey: SurveyResult, name: str) -> bool:
    """Whether there is such a picture: those of a validation only if there is one."""
    if name == "variogram":
        return survey.has_variogram
    return name not in ("distances", "held_out") or not isinstance(survey.validations, str)


def picture(survey: SurveyResult, name: str, k: int = 0, colors: str = COLORS) -> Figure:
    """Draw the picture of this name, of the value of index k."""
    require(*PICTURES)
    from fieldrecon.plotting import field_pictures, validation_pictures

    maps = {
        "reconstruction": field_pictures.plot,
        "error": field_pictures.plot_error,
        "nearest": field_pictures.plot_nearest,
    }
    label = survey.result.single(k).labels[-1]
    if name in maps:
        return maps[name](survey, k, field_pictures.color_map(colors))
    if name == "variogram":
        return validation_pictures.plot_variogram(survey.variogram(k), label)
    assert not isinstance(survey.validations, str), "pictures of a validation take one"
    if name == "distances":
        return validation_pictures.plot_distances(survey.validations[k])
    return validation_pictures.plot_held_out(survey.validations[k], label)


def summary(
    survey: SurveyResult,
    options: Mapping[str, Any],
    drawn: Mapping[str, bytes],
    *,
    title: str | None = None,
    files: Sequence[str] = (),
) -> str:
    """Return the HTML of the page.

    Parameters
    ----------
    survey : SurveyResult
    options : mapping
        The options of the command line, or other parameters.
    drawn : mapping of str to bytes
        The pictures as PNG, by their names; none if the packages that draw are missing.
    title : str, optional
        Of the page; by default the names of the values.
    files : sequence of str
        Files beside the page to which it links.
    """
    images = {_caption(survey, name): image for name, image in drawn.items()}
    method = description(survey.field.method)
    parameters = {"method": method.pop("name")} | _flattened(method) | dict(options)
    samples = f"{len(survey.samples.points):,} samples of {survey.source}"
    targets = f"{len(survey.result.values):,} {survey.result.targets.kind}"
    return page(
        title or f"{survey.title}, reconstructed",
        f"From {samples}, at {targets}, by {survey.method}.",
        images,
        survey.warnings,
        joined(
            [
                _methods_section(survey),
                _variogram_section(survey),
                *_coverage_sections(survey),
                fill("<h2>Files</h2>$files", files=links(files)) if files else NOTHING,
            ]
        ),
        parameters | {"time and memory": survey.cost},
    )


def _caption(survey: SurveyResult, name: str) -> str:
    """The caption of a picture, with the name of its value if there are several."""
    known, _, number = name.rpartition("_")
    if not number.isdigit():
        return CAPTIONS[name]
    return f"{CAPTIONS[known]}: {survey.samples.value_names[int(number) - 1]}"


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
    several = survey.samples.values.ndim == 2
    head = fill(_HEAD, unit=", in standard deviations of each value" if several else "")
    return fill(_METHODS, table=table(rows, head))


def _variogram_section(survey: SurveyResult) -> Html:
    """Return the nugget, the sill and the range of each value, in the words of kriging."""
    if not survey.has_variogram:
        return NOTHING
    found = {name: survey.variogram(k) for k, name in enumerate(survey.samples.value_names)}
    rows = (
        fill(
            _VARIOGRAM_ROW,
            name=name,
            nugget=one.nugget_in_words,
            sill=one.sill_in_words,
            range=one.range_in_words,
        )
        for name, one in found.items()
    )
    return fill(_VARIOGRAM, table=table(rows, fill(_VARIOGRAM_HEAD)))


def _coverage_sections(survey: SurveyResult) -> Iterator[Html]:
    """Yield for each value the coverage of the error, by distance from the nearest sample."""
    if isinstance(survey.validations, str):
        return
    several = len(survey.validations) > 1
    for name, validation in zip(survey.samples.value_names, survey.validations, strict=True):
        rows = (
            fill(_COVERAGE_ROW, far=far, count=count, share=f"{100 * share:.0f}")
            for far, share, count in validation.coverage()
        )
        of_value = f" of {name}" if several else ""
        yield fill(_COVERAGE, of_value=of_value, table=table(rows, fill(_COVERAGE_HEAD)))


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
    """Return nested parameters under one name each: "kernel scale", "methods 2 degree"."""
    flat: dict[str, Any] = {}
    for key, value in described.items():
        if isinstance(value, list) and all(isinstance(one, Mapping) for one in value):
            flat |= _flattened({f"{key} {k}": one for k, one in enumerate(value, 1)}, prefix)
        elif isinstance(value, Mapping):
            inner = dict(value)
            flat[f"{prefix}{key}"] = inner.pop("name")
            flat |= _flattened(inner, f"{prefix}{key} ")
        elif value is not None:
            flat[f"{prefix}{key}"] = value
    return flat
