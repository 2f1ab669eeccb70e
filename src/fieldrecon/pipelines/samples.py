"""Samples of a field from a table, in a file or in memory; columns are chosen by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from fieldrecon._core.chunks import Progress
from fieldrecon._core.duplicates import coincidence_labels
from fieldrecon.io.column_names import bare_name, chosen_columns
from fieldrecon.io.crs import grid_mapping
from fieldrecon.io.frames import Frame, Source, bad_row_message, numbered, read_source
from fieldrecon.io.tables import BadRow, ColumnSpec
from fieldrecon.methods.globe import principal
from fieldrecon.pipelines.missing_values import as_missing, suspects

_IN_METRES = ("east", "north")
_ROUNDED = 9  # decimals of degrees to which points are compared: a tenth of a millimetre
_SHOWN = 5
_OTHER_UNITS = 200.0
"""Ratio of the extents in x and y beyond which they are probably not in one unit."""


@dataclass(frozen=True)
class Samples:
    """Values at scattered points.

    Parameters
    ----------
    names : tuple of str
        Names of the columns of the coordinates and of the values.
    points : ndarray of shape (n, d)
    values : ndarray of shape (n,) or (n, k)
        Of one column, or of k columns that were asked for as a sequence.
    sigma : ndarray of shape (n,), optional
        Standard deviation of the noise of each value.
    lonlat : bool
        Whether the coordinates are degrees of longitude and latitude.
    merged : int
        Number of rows that repeat a point. The value of a repeated point is the mean of its rows.
    conflicts : int
        Number of points whose rows have different values.
    spread : float
        The largest difference between such values.
    bad : tuple of BadRow
        Skipped rows.
    unread : tuple of str
        Columns that were not read.
    numbered : str
        What the numbers of the skipped rows are: "line" of a file, or "row" in memory, from 0.
    units : tuple of str
        Units of the coordinates and of the values, empty where unknown; none if all are unknown.
    crs : mapping, optional
        Attributes of the grid mapping of the coordinates.
    absent : int
        Number of rows that were left out, since a number in them marks a missing value.
    """

    names: tuple[str, ...]
    points: np.ndarray
    values: np.ndarray
    lonlat: bool = False
    merged: int = 0
    conflicts: int = 0
    spread: float = 0.0
    bad: tuple[BadRow, ...] = ()
    unread: tuple[str, ...] = ()
    numbered: str = "line"
    units: tuple[str, ...] = ()
    crs: Mapping[str, Any] | None = None
    sigma: np.ndarray | None = None
    absent: int = 0

    @property
    def variances(self) -> np.ndarray | None:
        """Squares of the standard deviations, if they are known."""
        return None if self.sigma is None else self.sigma**2

    @property
    def value_names(self) -> tuple[str, ...]:
        """Names of the columns of the values."""
        return self.names[self.points.shape[1] :]

    @property
    def columns(self) -> np.ndarray:
        """The values, in a column (n, k) for each name."""
        return self.values.reshape(len(self.values), -1)

    @property
    def warnings(self) -> list[str]:
        """What a reader of the field has to know of its samples, in sentences."""
        return [
            *self._row_warnings(),
            *self._column_warnings(),
            *self._unit_warnings(),
            *self._value_warnings(),
        ]

    def _row_warnings(self) -> Iterator[str]:
        if self.bad:
            shown = "; ".join(f"{row.line}: {row.reason}" for row in self.bad[:_SHOWN])
            more = f"; and {len(self.bad) - _SHOWN} more" if len(self.bad) > _SHOWN else ""
            yield f"{_count(len(self.bad), 'row')} skipped, by {self.numbered}: {shown}{more}."
        if self.absent:
            yield f"{_count(self.absent, 'row')} with missing values left out."
        if self.merged:
            yield (
                f"{_count(self.merged, 'row')} repeat{'s' * (self.merged == 1)} a point; its value "
                "is the mean of the values given there, which "
                + (
                    f"differ at {_count(self.conflicts, 'point')}, by up to {self.spread:.4g}."
                    if self.conflicts
                    else "are the same."
                )
            )

    def _column_warnings(self) -> Iterator[str]:
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        sizes = np.maximum(abs(low), abs(high))
        bare = [bare_name(name) for name in self.names[: self.points.shape[1]]]
        if self.lonlat or len(bare) != 2:
            pass
        elif any(name.startswith(("lon", "lat")) for name in bare):
            yield (
                f"The columns {self.names[0]} and {self.names[1]} look like degrees but are taken "
                "as lengths of one unit: add the option lonlat, or project them."
            )
        elif (
            (sizes <= (180, 90)).all()
            and (high - low).max() > 5
            and not (any(name.startswith(_IN_METRES) for name in bare))
        ):
            yield (
                "If the coordinates, all within ±180 and ±90, are degrees, add the option lonlat."
            )
        if unread := [name for name in self.unread if bare_name(name) == "z"]:
            yield (
                f"The column {unread[0]} was not read: the points lie in a plane. "
                f"The option z, with {unread[0]}, makes them points in space."
            )

    def _unit_warnings(self) -> Iterator[str]:
        extents = np.ptp(self.points[:, :2], axis=0)
        if self.lonlat or not 0 < extents.min() * _OTHER_UNITS < extents.max():
            return
        (x, y), names = extents, self.names
        factor = 10.0 ** abs(np.round(np.log10(x) - np.log10(y)))
        yield (
            f"{names[0]} extends over {x:.3g} and {names[1]} over {y:.3g}. Distances take both as "
            "lengths of one unit: if they are not, convert one of them, or divide "
            f"{names[int(extents.argmax())]} by {factor:.0e}."
        )

    def _value_warnings(self) -> Iterator[str]:
        columns = [*self.points.T, *self.columns.T]
        named = [*zip(self.names, columns, strict=True)]
        if self.sigma is not None:
            named.append(("The standard deviation", self.sigma))
        for name, column in named:
            for value, count, (low, high) in suspects(column):
                times = "once" if count == 1 else f"{count} times"
                yield (
                    f"{name} is {value:g} {times}, far from all other values, {low:.4g} to "
                    f"{high:.4g}. If {value:g} marks missing values, leave these rows out by the "
                    f"option missing, with {value:g}."
                )


def read_samples(
    table: Source,
    x: str | None = None,
    y: str | None = None,
    value: str | Sequence[str] | None = None,
    z: str | None = None,
    lonlat: bool | None = None,
    strict: bool = False,
    crs: Any = None,
    sigma: str | None = None,
    missing: Any = None,
    decimal: str | None = None,
    in_space: bool = False,
    *,
    progress: Progress | None = None,
) -> Samples:
    """Read samples from a table: text, NPZ or Parquet, or in memory.

    Parameters
    ----------
    table : Path or Frame
        See `fieldrecon.io.tables.read_table` and `fieldrecon.io.frames.as_source`.
    x, y, value : str, optional
        Names of the columns. If they are not given, columns with usual names are taken; the value
        may also be the only column that remains. Several values, as a sequence, give values of
        shape (n, k).
    z : str, optional
        Name of the third coordinate, of points in space.
    lonlat : bool, optional
        Whether x and y are degrees; longitudes are converted to [-180, 180). By default they are
        if the units of the table are ``degrees_east`` and ``degrees_north``.
    strict : bool
        Refuse a table with a bad row, instead of skipping the row.
    sigma : str, optional
        Name of the column of the standard deviations of the values.
    missing : float or sequence of float, optional
        Numbers that mark missing values: rows with one of them are left out.
    decimal : str, optional
        The decimal sign of a text, "." or ","; by default that of its numbers.
    in_space : bool
        Whether the points are in space although `z` is not given: its column has a usual name.
    crs : object, optional
        As for `fieldrecon.io.crs.grid_mapping`; by default that of the table, if it has one.
    progress : callable, optional
        Called as progress(done, total), in bytes or rows.

    Raises
    ------
    ValueError
        If a column cannot be found, no row is valid, or, if strict, one is not: with its line.
    ImportError
        If the table is Parquet and pyarrow is not installed.
    """
    if lonlat and z is not None:
        raise ValueError("lonlat is for points on the globe, z for points in space: not both")
    if value is None and isinstance(table, Frame):
        value = table.only_value
    several = not (value is None or isinstance(value, str))
    own = [value] if value is None or isinstance(value, str) else list(value)
    if not own:
        raise ValueError("value must name at least one column")
    names: dict[str, str | None] = {"x": x, "y": y}
    names |= {"z": z} if in_space or z is not None else {}
    d, k = len(names), len(own)
    names |= {"value" if i == 0 else f"value {i + 1}": name for i, name in enumerate(own)}
    names |= {} if sigma is None else {"sigma": sigma}
    columns: list[str] = []
    on_globe = bool(lonlat)

    def choose(found: list[str]) -> list[int]:
        columns[:] = found
        return chosen_columns(table, found, names)

    units = _units(table, choose) if isinstance(table, Frame) else ()
    if lonlat is None and z is None:
        on_globe = units[:2] == ("degrees_east", "degrees_north")
    marks = as_missing(missing)
    limits = (360.0, 90.0, *(np.inf,) * (len(names) - 2)) if on_globe else None
    spec = ColumnSpec(choose, limits, decimal, marks)
    found = read_source(table, spec, progress)
    numbers = found.numbers
    if found.bad and (strict or not len(numbers)):
        raise ValueError(bad_row_message(table, found.bad[0]))
    absent = spec.missing_rows(numbers)
    if absent.all():
        raise ValueError(f"every row of {table} has a missing value, {missing}")
    numbers = numbers[~absent]
    deviations = numbers[:, -1] if sigma is not None else None
    if deviations is not None and (deviations < 0).any():
        raise ValueError(f"{sigma} must not be negative: it is a standard deviation")
    if on_globe and len(found.bad) > len(numbers):
        row = found.bad[0]
        raise ValueError(
            f"most rows of {table} are not degrees of longitude and latitude, such as "
            f"{numbered(table)} {row.line}: {row.reason}; are they lengths, or the other way round?"
        )
    points = numbers[:, :d]
    coordinates = np.round(principal(points), _ROUNDED) if on_globe else points
    known = table.crs if crs is None and isinstance(table, Frame) else crs
    return _merged(
        partial(
            Samples,
            tuple(found.names[: d + k]),
            lonlat=on_globe,
            bad=tuple(found.bad),
            unread=tuple(name for name in columns if name not in found.names),
            numbered=numbered(table),
            units=units[: d + k],
            crs=grid_mapping(known),
            absent=int(absent.sum()),
        ),
        coordinates,
        numbers[:, d : d + k] if several else numbers[:, d],
        deviations,
    )


def _units(table: Frame, choose: Callable[[list[str]], list[int]]) -> tuple[str, ...]:
    """Units of the chosen columns; none if all are unknown."""
    units = tuple(table.units.get(table.names[k], "") for k in choose(table.names))
    return units if any(units) else ()


def refuse_flat(samples: Samples) -> None:
    """Refuse samples that all lie on a line, or in space in a plane.

    Raises
    ------
    numpy.linalg.LinAlgError
        If they do: the samples do not determine the field beside it.
    """
    points = samples.points
    n, d = points.shape
    rank = _rank(points)
    if samples.lonlat or rank == d:
        return
    where = ("at one point", "on one straight line", "in one plane")[rank]
    remedy = (
        "; take the distance along it as the only coordinate of fieldrecon.RBF" if rank == 1 else ""
    )
    raise np.linalg.LinAlgError(
        f"all {n} points lie {where}: they do not determine the field beside it"
        f"{remedy}{_unit_remedy(samples)}"
    )


def _rank(points: np.ndarray) -> int:
    """Dimension of the point, line, plane or space in which the points lie, up to a ten-millionth.

    Rounding of the coordinates is no extent.
    """
    size = np.ptp(points, axis=0).max()
    rounding = 16 * np.finfo(float).eps * np.abs(points).max()
    moments = (points - points.mean(axis=0)) / (size or 1.0)
    variances = np.linalg.eigvalsh(moments.T @ moments / len(points))
    stretch = np.sqrt(np.maximum(variances, 0.0))
    return int((stretch > max(1e-7, rounding / (size or 1.0))).sum())


def _unit_remedy(samples: Samples) -> str:
    """How to convert coordinates of different units, if that makes the points a plane or space."""
    points = samples.points
    extents, rounding = np.ptp(points, axis=0), 16 * np.finfo(float).eps * abs(points).max(axis=0)
    if (extents <= rounding).any() or _rank(points / extents) < len(extents):
        return ""
    wide, narrow = int(extents.argmax()), int(extents.argmin())
    names = samples.names
    factor = 10.0 ** np.round(np.log10(extents[wide]) - np.log10(extents[narrow]))
    return (
        f". {names[wide]} extends over {extents[wide]:.3g} and {names[narrow]} over "
        f"{extents[narrow]:.3g}: if their units differ, convert one of them, or divide "
        f"{names[wide]} by {factor:.0e}"
    )


def _count(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def _merged(
    samples: partial[Samples],
    points: np.ndarray,
    values: np.ndarray,
    sigma: np.ndarray | None = None,
) -> Samples:
    """Merge repeated points, with the mean of their values, in the order of the file.

    The standard deviation of a mean of m values is (1/m) sqrt(sum_i sigma_i^2).
    """
    label = coincidence_labels(points)
    order = np.argsort(label, kind="stable")
    start = np.searchsorted(label[order], np.arange(label.max() + 1))
    if len(start) == len(points):
        return samples(points=points, values=values, sigma=sigma)
    own, count = values[order], np.diff(np.append(start, len(points)))
    least, most = np.minimum.reduceat(own, start), np.maximum.reduceat(own, start)
    # Values may be close to the largest number. Divided before they are added they overflow in
    # the last digit at most, and a mean lies between the values.
    with np.errstate(over="ignore"):
        spread = most - least
        shares = (own.T / np.repeat(count, count)).T
        means = np.clip(np.add.reduceat(shares, start), least, most)
    if sigma is not None:
        sigma = np.hypot.reduceat(sigma[order], start) / count
    return samples(
        points=points[order[start]],
        values=means,
        merged=len(points) - len(start),
        conflicts=int((spread.reshape(len(start), -1) > 0).any(axis=1).sum()),
        spread=float(spread.max()),
        sigma=sigma,
    )
