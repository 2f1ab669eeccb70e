"""From samples to a field at targets, with a method that the samples choose.

The steps: read the samples, compare the methods at samples that are held out as far from the others
as the targets are, fit the best one to all samples, evaluate it at the targets, estimate its error,
and mark the extrapolated targets.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np

from fieldrecon._core import validation as valid
from fieldrecon._core.atomic_files import write_atomically
from fieldrecon._core.chunks import Stages, silent
from fieldrecon._core.memory import memory_used, peak_memory
from fieldrecon.io.frames import Source, as_source, as_table, is_labelled, is_table
from fieldrecon.io.labelled import to_dataframe, to_xarray
from fieldrecon.io.saved_fields import load_with_names
from fieldrecon.io.targets import (
    Targets,
    TargetValues,
    grid_over,
    targets_of_mesh,
    targets_of_table,
)
from fieldrecon.io.values import write_values
from fieldrecon.methods.globe import OnGlobe, to_unit
from fieldrecon.methods.tangent_plane import OnTangentPlane, mean_direction
from fieldrecon.pages.reconstruction_page import pictures, summary
from fieldrecon.pipelines.samples import Samples, read_samples, refuse_flat
from fieldrecon.pipelines.validation import Validation
from fieldrecon.reconstruction import Field, Reconstruction
from fieldrecon.selection.cross_validation import NO_FIELD, CrossValidator, ModelScore, best
from fieldrecon.selection.error_bands import COVERAGE, ErrorBand
from fieldrecon.selection.extrapolation import AMONG, OUTSIDE, extrapolated
from fieldrecon.selection.leaving_one_out import leave_one_out
from fieldrecon.selection.models import MODELS, Maker, with_variances

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_DEFAULT_GRIDS = {2: (200, 200), 3: (50, 50, 50)}
_BY_ROUGHNESS = {
    0.0: "",
    0.5: " and of the root of the roughness of the field there",
    1.0: " and of the roughness of the field there",
}
_REGION = np.cos(np.radians(30))
"""Least cosine of the angle between the samples and their mean direction in a region."""
_MATCHED = 5000  # targets whose distances the held-out samples match


class Prediction(NamedTuple):
    """A field at queries of the shape (...,), with its error.

    Parameters
    ----------
    values, error : ndarray of shape (...,)
        The error is the half-width of a band, as `fieldrecon.selection.ErrorBand` describes it.
    extrapolated : ndarray of shape (...,), of small integers
        As `fieldrecon.selection.extrapolated` returns them.
    """

    values: np.ndarray
    error: np.ndarray
    extrapolated: np.ndarray


@dataclass(frozen=True, eq=False)
class SurveyResult:
    """A field that was reconstructed from samples, its values and error at targets, and warnings.

    Parameters
    ----------
    source : str
        Where the samples come from: the name of the file, or "data frame".
    samples : Samples
    scores : sequence of ModelScore
        The methods that were compared; empty for a loaded field.
    validation : Validation or str
        The samples that were held out and the residuals of the method there, or why there are none.
    chosen : ModelScore, optional
        The method that was evaluated; None for a loaded field.
    field : Field
    result : TargetValues
    seconds : float
        Time from the first row to the last value.
    memory : int, optional
        Peak memory of the program in bytes, where the system reports it.
    """

    source: str
    samples: Samples
    scores: Sequence[ModelScore]
    validation: Validation | str
    chosen: ModelScore | None
    field: Field
    result: TargetValues
    seconds: float
    memory: int | None

    def __repr__(self) -> str:
        name, count = self.result.labels[-1], len(self.samples.points)
        known = self.chosen is not None and self.chosen.residuals is not None
        error = f", {self.chosen.errors}" if self.chosen and known else ""
        return (
            f"<SurveyResult: {name} from {count} samples of {self.source}, at "
            f"{len(self.result.values)} {self.result.targets.kind}, by {self.method}{error}>"
        )

    @overload
    def predict(self, points: np.ndarray) -> Prediction: ...

    @overload
    def predict(self, points: Any) -> Any: ...

    def predict(self, points: Any) -> Any:
        """Evaluate the field and its error at further points.

        Parameters
        ----------
        points : (..., d) array_like, pandas.DataFrame, xarray.Dataset or xarray.DataArray
            Queries; a table has columns, or coordinates, of the names that the samples have.

        Returns
        -------
        Prediction, pandas.DataFrame or xarray.Dataset
            For an array `values`, `error` and `extrapolated` of the shape (...,). For a data frame
            these in columns, in its rows and with its index. For xarray a data set on the grid of
            its coordinates, or over the dimension "point".

        Raises
        ------
        ValueError
            If the points have the wrong number of coordinates, or one that is not finite.
        """
        if not is_table(points):
            x = valid.as_queries(points, self.samples.points.shape[1], "points")
            found = self._at(Targets(x.reshape(-1, x.shape[-1])))
            columns = (found.values, found.error, found.extrapolated)
            return Prediction(*(column.reshape(x.shape[:-1]) for column in columns))
        frame = as_source(points)
        names = self.samples.names[:-1]
        found = self._at(targets_of_table(frame, names, self.samples.lonlat, strict=True))
        if is_labelled(points):
            return to_xarray(found)
        return to_dataframe(found, coordinates=False)

    def _at(self, targets: Targets) -> TargetValues:
        values = self.field(targets.points)
        return _with_error(self.samples, self.validation, targets, values, silent)

    def to_dataframe(self) -> Any:
        """Return a `pandas.DataFrame` of the targets, the values, their error and the flags.

        Raises
        ------
        ModuleNotFoundError
            If pandas is not installed: with the extra that provides it.
        """
        return to_dataframe(self.result)

    def to_xarray(self) -> Any:
        """Return an `xarray.Dataset` with the units and the grid mapping of the NetCDF files.

        Raises
        ------
        ModuleNotFoundError
            If xarray is not installed: with the extra that provides it.
        """
        return to_xarray(self.result)

    def write(self, path: str | Path) -> Path:
        """Write the values at the targets; the suffix names the format.

        Parameters
        ----------
        path : str or pathlib.Path
            ``.csv``, ``.npz``, ``.nc`` (NetCDF) or ``.vtk`` (ParaView). An existing file is
            replaced after the new one is complete.

        Raises
        ------
        ValueError
            If there is no such format.
        """
        return write_values(Path(path), self.result)

    def plot(self) -> Figure:
        """Draw the field and the samples, pale where extrapolated.

        Raises
        ------
        ModuleNotFoundError
            If the packages that draw are not installed: with the extra that provides them.
        """
        return pictures(self, "reconstruction")["reconstruction"]

    def plot_error(self) -> Figure:
        """Draw the error of the field."""
        return pictures(self, "error")["error"]

    def report(self, path: str | Path, parameters: Mapping[str, Any] | None = None) -> Path:
        """Write a page of HTML with the pictures, the warnings, the methods and the parameters.

        Parameters
        ----------
        path : str or pathlib.Path
        parameters : mapping, optional
            Further parameters for the table at its end.

        Returns
        -------
        pathlib.Path
        """
        return write_atomically(Path(path), summary(self, parameters or {}).encode())

    @property
    def method(self) -> str:
        """The method that was evaluated."""
        if self.chosen is None:
            return f"the field of {self.source}"
        return f"{self.chosen.model.name}, {self.chosen.model.meaning}"

    @property
    def ranked(self) -> list[ModelScore]:
        """The compared methods by their error, the smallest first."""
        return sorted(self.scores, key=lambda score: score.rank)

    @property
    def warnings(self) -> list[str]:
        """What a reader of the values has to know, in sentences."""
        return [
            *self.samples.warnings,
            *self._noise_warnings(),
            *self._target_warnings(),
            self._error_warning(),
        ]

    def _noise_warnings(self) -> Iterator[str]:
        if self.samples.sigma is None:
            return
        method: Any = self.field.method
        while isinstance(method, OnGlobe | OnTangentPlane):
            method = method.method
        if np.ndim(getattr(method, "smoothing", 0.0)):
            yield "The smoothing is proportional to the variances of the samples."
        else:
            yield (
                "The method takes all samples as equally certain: their standard deviations were "
                "not used."
            )

    def _target_warnings(self) -> Iterator[str]:
        result, kind = self.result, self.result.targets.kind
        hull = "the hull" if result.lonlat else "the convex hull"
        if bad := result.targets.bad:
            rows = "row is not a point" if len(bad) == 1 else "rows are not points"
            first = f"{result.targets.numbered} {bad[0].line}: {bad[0].reason}"
            yield f"{len(bad)} {rows}; the first, {first}."
        flags = result.extrapolated
        if isinstance(self.validation, str):
            return
        yield self.validation.sentence
        far = f"farther than {self.validation.farthest} from the nearest sample"
        if count := np.count_nonzero(flags != AMONG):
            outside = np.count_nonzero(flags == OUTSIDE)
            yield (
                f"{count} of {len(flags)} {kind} are {far}, where no samples were held out, and "
                f"are marked as extrapolated; {outside} of these lie outside {hull} of the samples."
            )
        else:
            yield f"None of the {len(flags)} {kind} is {far}, the range of the validation."

    def _error_warning(self) -> str:
        if isinstance(self.validation, str):
            return f"The error of the field is not known: {self.validation}."
        band, typical = self.validation.band, float(np.median(self.result.error))
        return (
            f"The given error bounds the residuals of {100 * COVERAGE:.0f} of 100 held-out "
            "samples, as a function of the distance from the nearest sample"
            f"{_BY_ROUGHNESS[band.exponent]}. "
            f"Its median over the {self.result.targets.kind} is {typical:.3g}. It is not validated "
            "where extrapolated."
        )

    @property
    def cost(self) -> str:
        """Time and memory."""
        return f"{self.seconds:.1f} s{memory_used(self.memory, ' of memory')}"


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
    method: str = "best",
    grid: Sequence[int] | None = None,
    at: Any = None,
    mesh: str | Path | None = None,
    load: str | Path | None = None,
    crs: Any = None,
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
        space.
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
        refuse_flat(samples)
    targets = _targets(samples, grid, at, mesh, strict, decimal)
    sites, queries = _on_globe(samples, samples.points), _on_globe(samples, targets.points)
    stages("choosing the folds")
    asked = _asked_for(sites, queries, targets, samples.lonlat)
    variances = None if samples.sigma is None else samples.sigma**2
    validator = CrossValidator.of(sites, samples.values, asked, variances=variances)
    if loaded is None:
        scores = _compare(validator, method, samples.lonlat, stages)
        chosen, (field, values) = best(
            scores, lambda t: _fit_and_evaluate(t, samples, targets, stages)
        )
    else:
        field, scores, chosen = loaded, [], None
        values = field(targets.points, progress=stages("evaluating"))
    validation = _validate(validator, chosen, field, asked, samples, stages)
    result = _with_error(samples, validation, targets, values, stages)
    seconds, memory = perf_counter() - began, peak_memory()
    return SurveyResult(
        source.name, samples, scores, validation, chosen, field, result, seconds, memory
    )


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
    names = samples.names[:-1]
    if is_table(at):
        return targets_of_table(as_source(at), names, samples.lonlat, strict, decimal)
    return Targets(valid.as_points(valid.as_queries(at, d, "at"), "at"))


def _on_globe(samples: Samples, points: np.ndarray) -> np.ndarray:
    """Points as unit vectors, if the samples are on the globe."""
    return to_unit(points) if samples.lonlat else points


def _with_error(
    samples: Samples,
    validation: Validation | str,
    targets: Targets,
    values: np.ndarray,
    stages: Stages,
) -> TargetValues:
    """The values at targets with their error, and the flags of extrapolation."""
    sites, queries = _on_globe(samples, samples.points), _on_globe(samples, targets.points)
    if isinstance(validation, str):
        error, farthest = np.full(len(queries), np.nan), None
    else:
        error = validation.band(queries, stages("estimating the error"))
        farthest = validation.band.validated
    stages("marking extrapolated targets")
    flags = extrapolated(sites, queries, samples.lonlat, farthest)
    return TargetValues(
        samples.names,
        targets,
        values,
        error,
        flags,
        samples.lonlat,
        samples.units,
        samples.crs,
    )


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
    if values.ndim != 1 or values.dtype.kind == "c" or d not in _DEFAULT_GRIDS:
        raise ValueError(
            f"{path} must hold one real value at each point of the plane or of space; got "
            f"values of the shape {values.shape} in {d} variables"
        )
    default_names = (*"xyz"[:d], "value")
    own_names = tuple(names) if len(names) == d + 1 else default_names
    return Samples(own_names, points, values, isinstance(field.method, OnGlobe)), field


def _compare(
    validator: CrossValidator, method: str, on_globe: bool, stages: Stages
) -> list[ModelScore]:
    """Compare all methods, or evaluate the requested one; in a region of the globe, in a plane."""
    requested = method in MODELS
    models = [MODELS[method]] if requested else [*MODELS.values()]
    if on_globe:
        pole = mean_direction(validator.points)
        if (validator.points @ pole).min() > _REGION:
            models = [model.on_tangent_plane(pole) for model in models]
    return validator.compare(models, requested, stages("choosing a method"))


def _fit_and_evaluate(
    score: ModelScore, samples: Samples, targets: Targets, stages: Stages
) -> tuple[Field, np.ndarray]:
    """Fit a compared method to all samples, and evaluate it."""
    if score.maker is None:
        raise ValueError(score.reason)
    patches = score.model.family == "PU"
    progress = stages("making patches" if patches else "fitting")
    variances = None if samples.sigma is None else samples.sigma**2
    maker: Callable[..., Reconstruction] = with_variances(score.maker, variances)
    if patches:
        maker = partial(maker, progress=progress)
    method = OnGlobe(samples.points, maker) if samples.lonlat else maker(samples.points)
    how: dict[str, Any] = {"progress": stages("fitting")} if patches else {}
    field = method.field(samples.values, **how)
    return field, field(targets.points, progress=stages("evaluating"))


def _validate(
    validator: CrossValidator,
    chosen: ModelScore | None,
    field: Field,
    asked: np.ndarray,
    samples: Samples,
    stages: Stages,
) -> Validation | str:
    """Residuals of the method at the held-out samples, or why there are none."""
    progress = stages("leaving out each sample")
    method = field.method.method if isinstance(field.method, OnGlobe) else field.method
    try:
        residuals = chosen.residuals if chosen else None
        if residuals is None or len(residuals) < validator.n_held_out:
            maker = chosen.maker if chosen else None
            residuals = validator.residuals(maker or _maker_like(method))
    except NO_FIELD as error:
        return str(error)
    try:
        own: np.ndarray | None = leave_one_out(method, field.values, progress=progress)
    except NO_FIELD:
        own = None  # without the roughness, the error depends on the distance only
    band = ErrorBand(validator.points, validator.folds, residuals, own)
    return Validation.of(validator, residuals, band, asked, samples.lonlat)


def _maker_like(method: Reconstruction) -> Maker:
    """Make the same method on other points."""
    if isinstance(method, OnTangentPlane):
        return partial(OnTangentPlane, method=_maker_like(method.method), pole=method.pole)
    arguments = method._arguments()
    if any(np.ndim(arguments[name]) for name in method._each_site):
        raise ValueError("the method has a parameter of each sample, and is not made on others")
    return partial(method._made, **arguments)
