"""From a table of samples to a field at targets, with a method that the samples choose.

The steps: read the samples, judge the methods by samples that are left out, fit the best one to
all samples, evaluate it at the targets, estimate its error, and mark the extrapolated targets.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from fieldrecon._core.chunks import Stages, silent
from fieldrecon._core.memory import memory_used, peak_memory
from fieldrecon.io.saved_fields import load_with_names
from fieldrecon.io.targets import (
    Targets,
    TargetValues,
    grid_over,
    targets_of_mesh,
    targets_of_table,
)
from fieldrecon.methods.globe import OnGlobe, to_unit
from fieldrecon.pipelines.samples import Samples, read_samples, refuse_flat
from fieldrecon.reconstruction import Field, Reconstruction
from fieldrecon.selection.cross_validation import NO_FIELD, CrossValidator, ModelScore, best
from fieldrecon.selection.extrapolation import GAP, OUTSIDE, extrapolated
from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldrecon.selection.models import MODELS
from fieldrecon.selection.prediction_intervals import COVERAGE, ErrorEstimate

_DEFAULT_GRIDS = {2: (200, 200), 3: (50, 50, 50)}


@dataclass(frozen=True)
class SurveyRequest:
    """What to reconstruct, from which samples, and where.

    Parameters
    ----------
    samples : Path, optional
        A table of samples; see `fieldrecon.io.tables.read_table`.
    load : Path, optional
        A field that `fieldrecon.save` wrote, instead of samples.
    x, y, z, value : str, optional
        Names of the columns; usual names are recognized. `z` makes the samples points in space.
    lonlat : bool
        Whether x and y are degrees of longitude and latitude.
    strict : bool
        Refuse a table with a bad row, instead of skipping the row.
    method : str
        A name in `fieldrecon.selection.MODELS`, or "best": the method with the smallest error
        at samples that are left out.
    grid : tuple of int, optional
        Nodes along each side of a grid over the samples; the default if there is no other target.
    at : Path, optional
        A table with the points at which to evaluate.
    mesh : Path, optional
        A mesh at whose vertices to evaluate.

    Raises
    ------
    ValueError
        If there is not one source, or the method is unknown.
    """

    samples: Path | None = None
    load: Path | None = None
    x: str | None = None
    y: str | None = None
    z: str | None = None
    value: str | None = None
    lonlat: bool = False
    strict: bool = False
    method: str = "best"
    grid: tuple[int, ...] | None = None
    at: Path | None = None
    mesh: Path | None = None

    def __post_init__(self) -> None:
        if (self.samples is None) == (self.load is None):
            raise ValueError("give either a table of samples or --load with a field")
        if self.method not in {"best", *MODELS}:
            raise ValueError(
                f"there is no method {self.method!r}; there are best, {', '.join(MODELS)}"
            )

    @property
    def inputs(self) -> list[Path]:
        """The files that are read."""
        return [path for path in (self.samples, self.load, self.at, self.mesh) if path]

    def read_targets(self, samples: Samples) -> Targets:
        """Read the targets, or lay a grid over the samples."""
        d = samples.points.shape[1]
        if self.at:
            return targets_of_table(self.at, samples.names[:-1], samples.lonlat, self.strict)
        if self.mesh:
            return targets_of_mesh(self.mesh, d)
        return grid_over(samples.points, self.grid or _DEFAULT_GRIDS[d], samples.lonlat)


@dataclass(frozen=True, eq=False)
class SurveyResult:
    """The result of a reconstruction with its warnings.

    Parameters
    ----------
    source : str
        Name of the file with the samples, or with the loaded field.
    samples : Samples
    scores : sequence of ModelScore
        The methods that were compared; empty for a loaded field.
    n_held_out : int
        Number of samples that were left out for each method.
    chosen : ModelScore, optional
        The method that was evaluated; None for a loaded field.
    field : Field
    band : ErrorEstimate or str
        The estimate of the error, or why there is none.
    result : TargetValues
    seconds : float
        Time from the first row to the last value.
    memory : int, optional
        Peak memory of the program in bytes, where the system reports it.
    """

    source: str
    samples: Samples
    scores: Sequence[ModelScore]
    n_held_out: int
    chosen: ModelScore | None
    field: Field
    band: ErrorEstimate | str
    result: TargetValues
    seconds: float
    memory: int | None

    @property
    def method(self) -> str:
        """The method that was evaluated."""
        if self.chosen is None:
            return f"the field of {self.source}"
        return f"{self.chosen.model.name}, {self.chosen.model.meaning}"

    @property
    def ranked(self) -> list[ModelScore]:
        """The compared methods by their error, the smallest first."""
        return sorted(self.scores, key=lambda score: score.rms)

    @property
    def warnings(self) -> list[str]:
        """What a reader of the values has to know, in sentences."""
        return [*self.samples.warnings, *self._target_warnings(), self._error_warning()]

    def _target_warnings(self) -> Iterator[str]:
        result, kind = self.result, self.result.targets.kind
        if bad := result.targets.bad:
            rows = "row is not a point" if len(bad) == 1 else "rows are not points"
            yield f"{len(bad)} {rows}; the first, line {bad[0].line}: {bad[0].reason}."
        outside = np.count_nonzero(result.extrapolated == OUTSIDE)
        hull = "the hull" if result.lonlat else "the convex hull"
        yield f"{outside} of {len(result.values)} {kind} lie outside {hull} of the samples."
        gaps = np.count_nonzero(result.extrapolated == GAP)
        yield f"{gaps} {kind} lie in gaps between the samples. Both are marked as extrapolated."

    def _error_warning(self) -> str:
        if isinstance(self.band, str):
            return f"The error of the field is not known: {self.band}."
        typical = float(np.median(self.result.error))
        return (
            f"The given error bounds the residuals of {100 * COVERAGE:.0f} of 100 samples that are "
            f"left out: it is {self.band.factor:.3g} times the root mean square of the residuals "
            f"at the {self.band.neighbors} nearest samples. Its median over the "
            f"{self.result.targets.kind} is {typical:.3g}. It does not hold where extrapolated."
        )

    @property
    def cost(self) -> str:
        """Time and memory."""
        return f"{self.seconds:.1f} s{memory_used(self.memory, ' of memory')}"


def reconstruct_survey(request: SurveyRequest, *, stages: Stages = silent) -> SurveyResult:
    """Reconstruct a field from samples, and evaluate it at targets with an error estimate.

    Parameters
    ----------
    request : SurveyRequest
    stages : callable, optional
        Opens a stage of the work by its name, and returns its progress(done, total).

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        If a file cannot be read, or no field goes through the samples.
    ImportError
        If a format takes a package that is not installed.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import fieldrecon as fr
    >>> points = fr.datasets.uniform(50, 2, seed=0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     table = Path(folder) / "plane.csv"
    ...     np.savetxt(table, np.column_stack([points, points.sum(axis=1)]))
    ...     request = SurveyRequest(table, method="ls1", grid=(3, 2))
    ...     survey = reconstruct_survey(request)
    >>> targets = survey.result.targets.points
    >>> bool(np.abs(survey.result.values - targets.sum(axis=1)).max() < 1e-12)
    True
    """
    began = perf_counter()
    if request.load:
        samples, loaded = _load(request.load)
    else:
        samples, loaded = _read_samples(request, stages), None
    sites = to_unit(samples.points) if samples.lonlat else samples.points
    targets = request.read_targets(samples)
    if loaded is None:
        validator = CrossValidator.of(sites, samples.values)
        scores = _evaluate_models(validator, request.method, stages)
        chosen, (field, values) = best(
            scores, lambda t: _fit_and_evaluate(t, samples, targets, stages)
        )
        n_held_out = validator.n_held_out
    else:
        field, scores, chosen, n_held_out = loaded, [], None, 0
        values = field(targets.points, progress=stages("evaluating"))
    queries = to_unit(targets.points) if samples.lonlat else targets.points
    band, error = _estimate_error(field, sites, queries, stages)
    stages("looking for gaps")
    flags = extrapolated(sites, queries, samples.lonlat)
    result = TargetValues(samples.names, targets, values, error, flags, samples.lonlat)
    source = request.inputs[0].name
    seconds, memory = perf_counter() - began, peak_memory()
    return SurveyResult(
        source, samples, scores, n_held_out, chosen, field, band, result, seconds, memory
    )


def _read_samples(request: SurveyRequest, stages: Stages) -> Samples:
    assert request.samples is not None, "the request has one source"
    samples = read_samples(
        request.samples,
        request.x,
        request.y,
        request.value,
        request.z,
        request.lonlat,
        request.strict,
        progress=stages("reading"),
    )
    refuse_flat(samples)
    return samples


def _load(path: Path) -> tuple[Samples, Field]:
    """Return the field of a file, and the samples it was fitted to."""
    field, names = load_with_names(path)
    points, values = field.method.points, field.values
    d = points.shape[1]
    if values.ndim != 1 or values.dtype.kind == "c" or d not in _DEFAULT_GRIDS:
        raise ValueError(
            f"{path} must hold one real value at each point of the plane or of space; got "
            f"values of the shape {values.shape} in {d} variables"
        )
    default_names = (*"xyz"[:d], "value")
    own_names = tuple(names) if len(names) == d + 1 else default_names
    return Samples(own_names, points, values, isinstance(field.method, OnGlobe)), field


def _evaluate_models(validator: CrossValidator, method: str, stages: Stages) -> list[ModelScore]:
    """Judge the requested method, or all of them."""
    requested = method in MODELS
    models = [MODELS[method]] if requested else [*MODELS.values()]
    progress, scores = stages("choosing a method"), []
    for done, model in enumerate(models, 1):
        scores.append(validator.evaluate(model, requested))
        progress(done, len(models))
    return scores


def _fit_and_evaluate(
    score: ModelScore, samples: Samples, targets: Targets, stages: Stages
) -> tuple[Field, np.ndarray]:
    """Fit a compared method to all samples, and evaluate it."""
    if score.maker is None:
        raise ValueError(score.reason)
    patches = score.model.family == "PU"
    progress = stages("making patches" if patches else "fitting")
    maker: Callable[..., Reconstruction] = score.maker
    if patches:
        maker = partial(maker, progress=progress)
    method = OnGlobe(samples.points, maker) if samples.lonlat else maker(samples.points)
    how: dict[str, Any] = {"progress": stages("fitting")} if patches else {}
    field = method.field(samples.values, **how)
    return field, field(targets.points, progress=stages("evaluating"))


def _estimate_error(
    field: Field, sites: np.ndarray, queries: np.ndarray, stages: Stages
) -> tuple[ErrorEstimate | str, np.ndarray]:
    """Return the estimate of the error, or why there is none, and the errors at the queries."""
    progress = stages("leaving out each sample")
    try:
        band = ErrorEstimate(sites, leave_one_out(field.method, field.values, progress=progress))
    except NO_FIELD as error:
        return str(error), np.full(len(queries), np.nan)
    return band, band(queries, stages("estimating the error"))
