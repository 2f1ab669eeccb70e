"""From samples to a field at targets, with a method that the samples choose.

The steps: read the samples, compare the methods at samples that are held out as far from the others
as the targets are, fit the best one to all samples, evaluate it at the targets, estimate its error,
and mark the extrapolated targets.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any, Literal

import numpy as np

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Stages, silent
from fieldrecon._core.memory import peak_memory
from fieldrecon.fields import Field
from fieldrecon.io.frames import Source, as_source, as_table, is_table
from fieldrecon.io.saved_fields import load_with_names
from fieldrecon.io.targets import Targets, grid_over, targets_of_mesh, targets_of_table
from fieldrecon.methods.globe import OnGlobe
from fieldrecon.methods.mean import Mean
from fieldrecon.methods.tangent_plane import OnTangentPlane, mean_direction
from fieldrecon.pipelines.samples import Samples, read_samples, refuse_flat
from fieldrecon.pipelines.survey_results import SurveyResult, on_globe, values_with_error
from fieldrecon.pipelines.validation import Validation
from fieldrecon.reconstruction import Reconstruction
from fieldrecon.selection.anisotropy import Anisotropy, find_anisotropy
from fieldrecon.selection.cross_validation import NO_FIELD, CrossValidator, best
from fieldrecon.selection.error_bands import ErrorBand
from fieldrecon.selection.extrapolation import OUTSIDE, extrapolated
from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldrecon.selection.model_scores import ModelScore
from fieldrecon.selection.models import MODELS, Maker, with_variances

_DEFAULT_GRIDS = {2: (200, 200), 3: (50, 50, 50)}
_REGION = np.cos(np.radians(30))
"""Least cosine of the angle between the samples and their mean direction in a region."""
_MATCHED = 5000  # targets whose distances the held-out samples match


def reconstruct(
    data: Any = None,
    x: Any = None,
    y: Any = None,
    value: Any = None,
    *,
    z: Any = None,
    sigma: Any = None,
    lonlat: bool | None = None,
    strict: bool = False,
    missing: Any = None,
    decimal: str | None = None,
    units: str | Sequence[str] | None = None,
    method: str = "best",
    grid: Sequence[int] | None = None,
    at: Any = None,
    mesh: str | Path | None = None,
    load: str | Path | None = None,
    crs: Any = None,
    anisotropy: str | Anisotropy | None = None,
    stages: Stages = silent,
) -> SurveyResult:
    """Reconstruct a field from samples, and evaluate it at targets with an error estimate.

    Parameters
    ----------
    data : path, pandas.DataFrame, xarray.Dataset, xarray.DataArray, mapping or (n, d) array_like
        Samples: a table in a file (text, NPZ or Parquet) or in memory, or points, whose values are
        `value`. Without data, `x`, `y` and `value` are arrays (n,).
    x, y, z, value : str or (n,) array_like, optional
        Names of columns of a table; usual names are recognized. `z` makes the samples points in
        space. Several values, as a list of names or an array (n, k), are reconstructed by one
        method: the one with the least mean square of the residuals, each divided by the standard
        deviation of its value.
    sigma : str or (n,) array_like, optional
        Standard deviation of the noise of each value. Where a method smooths, it does so in
        proportion to the variances; by how much, the held-out samples decide.
    lonlat : bool, optional
        Whether x and y are degrees of longitude and latitude. By default they are if their units
        in the data are ``degrees_east`` and ``degrees_north``.
    strict : bool
        Refuse a table with a bad row, instead of skipping the row.
    missing : float or sequence of float, optional
        Numbers that mark missing values, such as -9999: rows with one of them are left out.
    decimal : str, optional
        The decimal sign of a text, "." or ","; by default that of its numbers.
    units : str or sequence of str, optional
        The unit of the value, or of each of several values; by default that of the data, or the one
        in brackets in the name of its column.
    method : str
        A name in `fieldrecon.selection.MODELS`, or "best": the method with the smallest error
        at samples that are left out.
    grid : tuple of int, optional
        Nodes along each side of a grid over the samples; the default if there is no other target.
    at : path, pandas.DataFrame, xarray.Dataset or (m, d) array_like, optional
        Points at which to evaluate; a table has the coordinates under the names of the samples.
        Coordinates of xarray that are the axes of a grid give its nodes.
    mesh : path, optional
        A mesh at whose vertices to evaluate.
    load : path, optional
        A field that `fieldrecon.save` wrote, instead of samples.
    crs : object, optional
        Coordinate reference system of x and y, such as ``"EPSG:32612"``, which files and data sets
        record; by default that of the data.
    anisotropy : Anisotropy or str, optional
        A direction of the plane along which the values vary more slowly: a ratio of ranges and an
        angle from x towards y, such as ``"3:45"``, or ``"auto"``, for the one of least error at the
        held-out samples if that is clearly less.
    stages : callable, optional
        Opens a stage of the work by its name, and returns its progress(done, total).

    Returns
    -------
    SurveyResult

    Raises
    ------
    ValueError, numpy.linalg.LinAlgError
        If the data cannot be read, there is no such method, or no field goes through the samples.
    TypeError
        If the data are of no known kind.
    ImportError
        If a format takes a package that is not installed.

    Examples
    --------
    >>> import fieldrecon as fr
    >>> points = fr.datasets.uniform(50, 2, seed=0)
    >>> table = {"x": points[:, 0], "y": points[:, 1], "height": points.sum(axis=1)}
    >>> survey = reconstruct(table, value="height", method="ls1", grid=(3, 2))
    >>> survey.method
    'ls1, least squares, plane'
    >>> values, error, extrapolated = survey.predict([[0.5, 0.25], [9.0, 9.0]])
    >>> values.round(9), extrapolated
    (array([ 0.75, 18.  ]), array([0, 2], dtype=int8))
    """
    began = perf_counter()
    if method not in {"best", *MODELS}:
        raise ValueError(f"there is no method {method!r}; there are best, {', '.join(MODELS)}")
    loaded = None
    if load is not None:
        if data is not None or value is not None:
            raise ValueError("give either samples or load, a file with a field: not both")
        source: Source = Path(load)
        samples, loaded = _load(Path(load))
    else:
        source, names = as_table(data, x, y, value, z, sigma)
        samples = read_samples(
            source,
            **names,
            lonlat=lonlat,
            strict=strict,
            missing=missing,
            decimal=decimal,
            crs=crs,
            progress=stages("reading"),
        )
        samples = samples if units is None else _with_units(samples, units)
        refuse_flat(samples)
    wanted = _as_anisotropy(anisotropy, samples, loaded)
    targets = _targets(samples, grid, at, mesh, strict, decimal)
    sites, queries = on_globe(samples, samples.points), on_globe(samples, targets.points)
    stages("choosing the folds")
    asked = _asked_for(sites, queries, targets, samples.lonlat)
    scale = _scale(samples)
    validator = CrossValidator.of(sites, samples.values / scale, asked, variances=samples.variances)
    if loaded is None:
        scores = _compare(validator, method, samples.lonlat, wanted, stages)
        scores, found = _with_anisotropy(scores, validator, wanted, stages)
        chosen, (field, values) = best(
            scores, lambda t: _fit_and_evaluate(t, samples, targets, stages)
        )
    else:
        field, scores, chosen, found = loaded, [], None, ""
        values = field(targets.points, progress=stages("evaluating"))
    validations = _validate(validator, chosen, field, asked, samples, scale, stages)
    result = values_with_error(samples, validations, targets, values, stages)
    seconds, memory = perf_counter() - began, peak_memory()
    return SurveyResult(
        source.name, samples, scores, validations, chosen, field, result, seconds, memory, found
    )


def _with_units(samples: Samples, units: str | Sequence[str]) -> Samples:
    """The samples with the units of their values."""
    given = (units,) if isinstance(units, str) else tuple(units)
    count, d = len(samples.value_names), samples.points.shape[1]
    if len(given) != count:
        raise ValueError(f"units must be {count}, one for each value; got {', '.join(given)}")
    return replace(samples, units=(samples.units[:d] or ("",) * d) + given)


def _targets(
    samples: Samples,
    grid: Sequence[int] | None,
    at: Any,
    mesh: str | Path | None,
    strict: bool,
    decimal: str | None,
) -> Targets:
    """Read the targets, or lay a grid over the samples."""
    d = samples.points.shape[1]
    if sum(one is not None for one in (grid, at, mesh)) > 1:
        raise ValueError("give one of grid, at and mesh: the targets are of one kind")
    if mesh is not None:
        return targets_of_mesh(Path(mesh), d)
    if at is None:
        return grid_over(samples.points, grid or _DEFAULT_GRIDS[d], samples.lonlat)
    names = samples.names[:d]
    if is_table(at):
        return targets_of_table(as_source(at), names, samples.lonlat, strict, decimal)
    return Targets(valid.as_points(valid.as_queries(at, d, "at"), "at"))


def _asked_for(
    sites: np.ndarray, queries: np.ndarray, targets: Targets, on_globe: bool
) -> np.ndarray:
    """Queries whose distances the held-out samples match: all, of a grid those in the hull.

    The corners of a grid beside the samples are there because a grid is a rectangle.
    """
    some = queries[np.random.default_rng(0).permutation(len(queries))[:_MATCHED]]
    if not targets.axes:
        return some
    inside = some[extrapolated(sites, some, on_globe) != OUTSIDE]
    return inside if len(inside) else some


def _load(path: Path) -> tuple[Samples, Field]:
    """Return the field of a file, and the samples it was fitted to."""
    field, names = load_with_names(path)
    points, values = field.method.points, field.values
    d = points.shape[1]
    if values.ndim > 2 or values.dtype.kind == "c" or d not in _DEFAULT_GRIDS:
        raise ValueError(
            f"{path} must hold real values (n,) or (n, k) at points of the plane or of space; got "
            f"values of the shape {values.shape} in {d} variables"
        )
    several = [f"value_{k}" for k in range(1, values.shape[1] + 1)] if values.ndim == 2 else []
    default_names = (*"xyz"[:d], *(several or ["value"]))
    own_names = tuple(names) if len(names) == len(default_names) else default_names
    return Samples(own_names, points, values, isinstance(field.method, OnGlobe)), field


def _compare(
    validator: CrossValidator,
    method: str,
    on_globe: bool,
    anisotropy: Anisotropy | Literal["auto"] | None,
    stages: Stages,
) -> list[ModelScore]:
    """Compare all methods, or evaluate the requested one; in a region of the globe, in a plane."""
    requested = method in MODELS
    models = [MODELS[method]] if requested else [*MODELS.values()]
    if on_globe:
        pole = mean_direction(validator.points)
        if (validator.points @ pole).min() > _REGION:
            models = [model.on_tangent_plane(pole) for model in models]
    if isinstance(anisotropy, Anisotropy):
        models = [anisotropy.of_model(model) for model in models]
    return validator.compare(models, requested, stages("choosing a method"))


def _as_anisotropy(
    given: str | Anisotropy | None, samples: Samples, loaded: Field | None
) -> Anisotropy | Literal["auto"] | None:
    """Read the anisotropy, which samples of a plane may have."""
    if given is None:
        return None
    if loaded is not None:
        raise ValueError("give either anisotropy or load: a field has its distances")
    if samples.lonlat or samples.points.shape[1] != 2:
        raise ValueError(
            "anisotropy is a direction of the plane; project degrees to lengths, and divide the "
            "coordinates of points in space by scales"
        )
    if given == "auto":
        return "auto"
    return given if isinstance(given, Anisotropy) else Anisotropy.of(given)


def _with_anisotropy(
    scores: list[ModelScore],
    validator: CrossValidator,
    anisotropy: Anisotropy | Literal["auto"] | None,
    stages: Stages,
) -> tuple[list[ModelScore], str]:
    """The scores, with that of the best method with an anisotropy if one is found; in words."""
    if anisotropy is None:
        return scores, ""
    if isinstance(anisotropy, Anisotropy):
        return scores, f"Distances have {anisotropy}, as given."
    chosen = min(scores, key=lambda score: score.rank)
    progress = stages("choosing an anisotropy")
    better, found = find_anisotropy(validator, chosen, progress)
    if found is None:
        return scores, (
            "No anisotropy was found: at the held-out samples none has an error that is clearly "
            "smaller."
        )
    return [*scores, better], (
        f"Distances have {found}: at the held-out samples the rms error is {better.rms:.4g} "
        f"instead of {chosen.rms:.4g}."
    )


def _fit_and_evaluate(
    score: ModelScore, samples: Samples, targets: Targets, stages: Stages
) -> tuple[Field, np.ndarray]:
    """Fit a compared method to all samples, and evaluate it."""
    if score.maker is None:
        raise ValueError(score.reason)
    patches = score.model.family == "PU"
    progress = stages("making patches" if patches else "fitting")
    maker: Callable[..., Reconstruction] = with_variances(score.maker, samples.variances)
    if patches:
        maker = partial(maker, progress=progress)
    method = OnGlobe(samples.points, maker) if samples.lonlat else maker(samples.points)
    how: dict[str, Any] = {"progress": stages("fitting")} if patches else {}
    field = method.field(samples.values, **how)
    return field, field(targets.points, progress=stages("evaluating"))


def _scale(samples: Samples) -> np.ndarray:
    """The standard deviation of each of several values; one value keeps its unit."""
    if samples.values.ndim == 1:
        return np.ones(())
    spread = samples.values.std(axis=0)
    return np.where(spread > 0, spread, 1.0)


def _validate(
    validator: CrossValidator,
    chosen: ModelScore | None,
    field: Field,
    asked: np.ndarray,
    samples: Samples,
    scale: np.ndarray,
    stages: Stages,
) -> list[Validation] | str:
    """For each value the residuals of the method at the held-out samples, or why there are none."""
    progress = stages("leaving out each sample")
    method = field.method.method if isinstance(field.method, OnGlobe) else field.method
    try:
        maker = chosen.maker if chosen else None
        residuals = validator.residuals(maker or _maker_like(method))
    except NO_FIELD as error:
        return str(error)
    try:
        own: np.ndarray | None = leave_one_out(method, field.values, progress=progress)
    except NO_FIELD:
        own = None  # without the roughness, the error depends on the distance only
    validations = []
    for k, values in enumerate(samples.columns.T):
        of_value = replace(validator, values=values)
        residual = (residuals * scale).reshape(len(residuals), -1)[:, k]
        own_residual = None if own is None else own.reshape(len(own), -1)[:, k]
        band = ErrorBand(validator.points, validator.folds, residual, own_residual)
        validations.append(Validation.of(of_value, residual, band, asked, samples.lonlat))
    return validations


def _maker_like(method: Reconstruction) -> Maker:
    """Make the same method on other points."""
    if isinstance(method, OnTangentPlane):
        return partial(OnTangentPlane, method=_maker_like(method.method), pole=method.pole)
    if isinstance(method, Mean):
        return partial(Mean, methods=tuple(map(_maker_like, method.methods)))
    arguments = method._arguments()
    if any(np.ndim(arguments[name]) for name in method._each_site):
        raise ValueError("the method has a parameter of each sample, and is not made on others")
    return partial(method._made, **arguments)
