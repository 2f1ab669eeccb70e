"""The result of a reconstruction: the field, its values and error at targets, and warnings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np

from fieldrecon._core import validation as valid
from fieldrecon._core.atomic_files import write_atomically
from fieldrecon._core.chunks import Stages, silent
from fieldrecon._core.extras import PICTURES, absent
from fieldrecon._core.memory import memory_used
from fieldrecon.fields import Field
from fieldrecon.io.frames import as_source, is_labelled, is_table
from fieldrecon.io.labelled import to_dataframe, to_xarray
from fieldrecon.io.targets import Targets, TargetValues, targets_of_table
from fieldrecon.io.values import write_values
from fieldrecon.methods.globe import OnGlobe, to_unit
from fieldrecon.methods.mean import Mean
from fieldrecon.methods.tangent_plane import OnTangentPlane
from fieldrecon.pages.reconstruction_page import COLORS, as_png, picture, pictures, summary
from fieldrecon.pipelines.samples import Samples
from fieldrecon.pipelines.validation import Validation
from fieldrecon.pipelines.variograms import FEWEST, Variogram, variogram
from fieldrecon.reconstruction import Reconstruction
from fieldrecon.selection.error_bands import COVERAGE
from fieldrecon.selection.extrapolation import AMONG, OUTSIDE, extrapolated
from fieldrecon.selection.model_scores import ModelScore

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BY_ROUGHNESS = {
    0.0: "",
    0.5: " and of the root of the roughness of the field there",
    1.0: " and of the roughness of the field there",
}


class Prediction(NamedTuple):
    """A field at queries of the shape (...,), with its error.

    Parameters
    ----------
    values, error : ndarray of shape (...,), or (..., k) of k values
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
    validations : sequence of Validation, or str
        For each value the samples that were held out and the residuals of the method there, or why
        there are none.
    chosen : ModelScore, optional
        The method that was evaluated; None for a loaded field.
    field : Field
    result : TargetValues
    seconds : float
        Time from the first row to the last value.
    memory : int, optional
        Peak memory of the program in bytes, where the system reports it.
    anisotropy : str
        The anisotropy in a sentence, if one was given or searched for.
    """

    source: str
    samples: Samples
    scores: Sequence[ModelScore]
    validations: Sequence[Validation] | str
    chosen: ModelScore | None
    field: Field
    result: TargetValues
    seconds: float
    memory: int | None
    anisotropy: str = ""

    def __repr__(self) -> str:
        name, count = self.title, len(self.samples.points)
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
            For an array `values`, `error` and `extrapolated` of the shape (...,), the first two of
            the shape (..., k) for k values. For a data frame
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
            shape = x.shape[:-1]
            return Prediction(*(column.reshape(shape + column.shape[1:]) for column in columns))
        frame = as_source(points)
        names = self.samples.names[: self.result.d]
        found = self._at(targets_of_table(frame, names, self.samples.lonlat, strict=True))
        if is_labelled(points):
            return to_xarray(found)
        return to_dataframe(found, coordinates=False)

    def _at(self, targets: Targets) -> TargetValues:
        values = self.field(targets.points)
        return values_with_error(self.samples, self.validations, targets, values, silent)

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

    def plot(self, value: str | None = None, *, colors: str = COLORS) -> Figure:
        """Draw the field and the samples, pale where extrapolated.

        Parameters
        ----------
        value : str, optional
            One of several values, by its name; by default the first.
        colors : str
            A colour map of Matplotlib.

        Raises
        ------
        ModuleNotFoundError
            If the packages that draw are not installed: with the extra that provides them.
        ValueError
            If there is no such value, or no such colour map.
        """
        return picture(self, "reconstruction", self._index(value), colors)

    def plot_error(self, value: str | None = None, *, colors: str = COLORS) -> Figure:
        """Draw the error of the field, or of one of several values."""
        return picture(self, "error", self._index(value), colors)

    @property
    def has_variogram(self) -> bool:
        """Whether there are enough samples for a variogram."""
        return len(self.samples.points) >= FEWEST

    def variogram(self, k: int = 0) -> Variogram:
        """The variogram of the samples of the value of index k, on the globe in degrees."""
        return self._variograms[k]

    @cached_property
    def _variograms(self) -> list[Variogram]:
        samples = self.samples
        points, unit = samples.points, " degrees" if samples.lonlat else ""
        if samples.lonlat:
            points = np.degrees(to_unit(points))  # chords, near to arcs at the distances used
        return [variogram(points, column, unit) for column in samples.columns.T]

    def _index(self, value: str | None) -> int:
        names = self.samples.value_names
        if value is not None and value not in names:
            raise ValueError(f"there is no value {value!r}; there are {', '.join(names)}")
        return 0 if value is None else names.index(value)

    def report(
        self,
        path: str | Path,
        parameters: Mapping[str, Any] | None = None,
        *,
        title: str | None = None,
        colors: str = COLORS,
    ) -> Path:
        """Write a page of HTML with the pictures, the warnings, the methods and the parameters.

        Parameters
        ----------
        path : str or pathlib.Path
        parameters : mapping, optional
            Further parameters for the table at its end.
        title : str, optional
            Of the page; by default the names of the values.
        colors : str
            A colour map of Matplotlib.

        Returns
        -------
        pathlib.Path
        """
        drawn = {} if absent(*PICTURES) else pictures(self, colors)
        content = summary(self, parameters or {}, as_png(drawn), title=title)
        return write_atomically(Path(path), content.encode())

    @property
    def title(self) -> str:
        """Names of the values, with their units."""
        return ", ".join(self.result.labels[self.result.d :])

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
            *filter(None, [self.anisotropy]),
            *self._score_warnings(),
            *self._target_warnings(),
            *self._error_warnings(),
        ]

    def _noise_warnings(self) -> Iterator[str]:
        if self.samples.sigma is None:
            return
        parts = _innermost(self.field.method)
        if any(np.ndim(getattr(method, "smoothing", 0.0)) for method in parts):
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
        if isinstance(self.validations, str):
            return
        yield self.validations[0].sentence
        far = f"farther than {self.validations[0].farthest} from the nearest sample"
        if count := np.count_nonzero(flags != AMONG):
            outside = np.count_nonzero(flags == OUTSIDE)
            yield (
                f"{count} of {len(flags)} {kind} are {far}, where no samples were held out, and "
                f"are marked as extrapolated; {outside} of these lie outside {hull} of the samples."
            )
        else:
            yield f"None of the {len(flags)} {kind} is {far}, the range of the validation."

    def _error_warnings(self) -> Iterator[str]:
        if isinstance(self.validations, str):
            yield f"The error of the field is not known: {self.validations}."
            return
        for k, validation in enumerate(self.validations):
            of_value = f" of {self.samples.value_names[k]}" if len(self.validations) > 1 else ""
            typical = float(np.median(self.result.single(k).error))
            yield (
                f"The given error{of_value} bounds the residuals of {100 * COVERAGE:.0f} of 100 "
                "held-out samples, as a function of the distance from the nearest sample"
                f"{_BY_ROUGHNESS[validation.band.exponent]}. "
                f"Its median over the {self.result.targets.kind} is {typical:.3g}. It is not "
                "validated where extrapolated."
            )

    def _score_warnings(self) -> Iterator[str]:
        if self.samples.values.ndim == 2 and self.scores:
            yield (
                "One method was chosen for all values: the one with the least mean square of the "
                "residuals, each divided by the standard deviation of its value."
            )

    @property
    def cost(self) -> str:
        """Time and memory."""
        return f"{self.seconds:.1f} s{memory_used(self.memory, ' of memory')}"


def on_globe(samples: Samples, points: np.ndarray) -> np.ndarray:
    """Points as unit vectors, if the samples are on the globe."""
    return to_unit(points) if samples.lonlat else points


def _innermost(method: Reconstruction) -> list[Reconstruction]:
    """The methods that fit the values, in whatever coordinates and mean."""
    if isinstance(method, OnGlobe | OnTangentPlane):
        return _innermost(method.method)
    if isinstance(method, Mean):
        return [one for part in method.methods for one in _innermost(part)]
    return [method]


def values_with_error(
    samples: Samples,
    validations: Sequence[Validation] | str,
    targets: Targets,
    values: np.ndarray,
    stages: Stages,
) -> TargetValues:
    """The values at targets with their errors, and the flags of extrapolation."""
    sites, queries = on_globe(samples, samples.points), on_globe(samples, targets.points)
    error, farthest = np.full(values.shape, np.nan), None
    if not isinstance(validations, str):
        progress = stages("estimating the error")
        bands = [validation.band(queries, progress) for validation in validations]
        error = np.stack(bands, axis=-1).reshape(values.shape)
        farthest = validations[0].band.validated
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
