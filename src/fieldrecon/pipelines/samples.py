"""Samples of a field from a table with up to millions of rows; columns are chosen by name."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from fieldrecon._core.chunks import Progress
from fieldrecon._core.duplicates import coincidence_labels
from fieldrecon.io.tables import BadRow, ColumnSpec, bare_name, chosen_columns, read_table
from fieldrecon.methods.globe import principal

_IN_METRES = ("east", "north")
_ROUNDED = 9  # decimals of degrees to which points are compared: a tenth of a millimetre
_SHOWN = 5


@dataclass(frozen=True)
class Samples:
    """Values at scattered points.

    Parameters
    ----------
    names : tuple of str
        Names of the columns of the coordinates and of the value.
    points : ndarray of shape (n, d)
    values : ndarray of shape (n,)
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

    @property
    def warnings(self) -> list[str]:
        """What a reader of the field has to know of its samples, in sentences."""
        return [*self._row_warnings(), *self._column_warnings()]

    def _row_warnings(self) -> Iterator[str]:
        if self.bad:
            shown = "; ".join(f"{row.line}: {row.reason}" for row in self.bad[:_SHOWN])
            more = f"; and {len(self.bad) - _SHOWN} more" if len(self.bad) > _SHOWN else ""
            yield f"{_count(len(self.bad), 'row')} skipped, by line: {shown}{more}."
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
        bare = [bare_name(name) for name in self.names[:-1]]
        if self.lonlat or len(bare) != 2:
            pass
        elif any(name.startswith(("lon", "lat")) for name in bare):
            yield (
                f"The columns {self.names[0]} and {self.names[1]} look like degrees but are taken "
                "as lengths of one unit: add --lonlat, or project them."
            )
        elif (
            (sizes <= (180, 90)).all()
            and (high - low).max() > 5
            and not (any(name.startswith(_IN_METRES) for name in bare))
        ):
            yield "If the coordinates, all within ±180 and ±90, are degrees, add --lonlat."
        if unread := [name for name in self.unread if bare_name(name) == "z"]:
            yield (
                f"The column {unread[0]} was not read: the points lie in a plane. "
                f"--z {unread[0]} makes them points in space."
            )


def read_samples(
    path: Path,
    x: str | None = None,
    y: str | None = None,
    value: str | None = None,
    z: str | None = None,
    lonlat: bool = False,
    strict: bool = False,
    *,
    progress: Progress | None = None,
) -> Samples:
    """Read samples from a table: text, NPZ or Parquet, see `fieldrecon.io.tables.read_table`.

    Parameters
    ----------
    path : Path
    x, y, value : str, optional
        Names of the columns. If they are not given, columns with usual names are taken; the value
        may also be the only column that remains.
    z : str, optional
        Name of the third coordinate, of points in space.
    lonlat : bool
        Whether x and y are degrees; longitudes are converted to [-180, 180).
    strict : bool
        Refuse a table with a bad row, instead of skipping the row.
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
        raise ValueError("--lonlat is for points on the globe, --z for points in space: not both")
    names = {"x": x, "y": y} | ({} if z is None else {"z": z}) | {"value": value}
    columns: list[str] = []

    def choose(found: list[str]) -> list[int]:
        columns[:] = found
        return chosen_columns(path, found, names)

    table = read_table(
        path, ColumnSpec(choose, (360.0, 90.0, np.inf) if lonlat else None), progress
    )
    if table.bad and (strict or not len(table.numbers)):
        row = table.bad[0]
        raise ValueError(f"{path}, line {row.line}: {row.reason}")
    if lonlat and len(table.bad) > len(table.numbers):
        row = table.bad[0]
        raise ValueError(
            f"most rows of {path} are not degrees of longitude and latitude, such as line "
            f"{row.line}: {row.reason}; are they lengths, or the other way round?"
        )
    points = table.numbers[:, :-1]
    coordinates = np.round(principal(points), _ROUNDED) if lonlat else points
    return _merged(
        partial(
            Samples,
            tuple(table.names),
            lonlat=lonlat,
            bad=tuple(table.bad),
            unread=tuple(name for name in columns if name not in table.names),
        ),
        coordinates,
        table.numbers[:, -1],
    )


def refuse_flat(samples: Samples) -> None:
    """Refuse samples that all lie on a line, or in space in a plane.

    Raises
    ------
    numpy.linalg.LinAlgError
        If they do: the samples do not determine the field beside it.
    """
    points = samples.points
    n, d = points.shape
    size = np.ptp(points, axis=0).max()
    rounding = 16 * np.finfo(float).eps * np.abs(points).max()
    moments = (points - points.mean(axis=0)) / (size or 1.0)
    stretch = np.sqrt(np.maximum(np.linalg.eigvalsh(moments.T @ moments / n), 0.0))
    rank = int((stretch > max(1e-7, rounding / (size or 1.0))).sum())
    if samples.lonlat or rank == d:
        return
    where = ("at one point", "on one straight line", "in one plane")[rank]
    remedy = (
        "; take the distance along it as the only coordinate of fieldrecon.RBF" if rank == 1 else ""
    )
    raise np.linalg.LinAlgError(
        f"all {n} points lie {where}: they do not determine the field beside it{remedy}"
    )


def _count(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def _merged(samples: partial[Samples], points: np.ndarray, values: np.ndarray) -> Samples:
    """Merge repeated points, with the mean of their values, in the order of the file."""
    label = coincidence_labels(points)
    order = np.argsort(label, kind="stable")
    start = np.searchsorted(label[order], np.arange(label.max() + 1))
    if len(start) == len(points):
        return samples(points=points, values=values)
    own, count = values[order], np.diff(np.append(start, len(points)))
    with np.errstate(over="ignore"):  # the difference of two large values
        spread = np.maximum.reduceat(own, start) - np.minimum.reduceat(own, start)
    # divided before they are added, so that the sum of large values does not overflow
    means = np.add.reduceat(own / np.repeat(count, count), start)
    return samples(
        points=points[order[start]],
        values=np.where(spread > 0, means, own[start]),
        merged=len(points) - len(start),
        conflicts=int((spread > 0).sum()),
        spread=float(spread.max()),
    )
