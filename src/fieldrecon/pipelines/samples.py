"""Samples of a field from a table of a few or of millions of rows, its columns chosen by name."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from fieldrecon._core.chunks import Progress
from fieldrecon._core.duplicates import coincidence_labels
from fieldrecon.io.tables import BadRow, Wanted, bare_name, chosen_columns, read_table
from fieldrecon.methods.globe import principal

_IN_METRES = ("east", "north")
_ROUNDED = 9  # decimals of degrees within which places are one: a tenth of a millimetre
_SHOWN = 5


@dataclass(frozen=True)
class Samples:
    """Values at scattered points.

    Parameters
    ----------
    names : tuple of str
        Of the columns that hold the coordinates and the value.
    points : ndarray of shape (n, d)
    values : ndarray of shape (n,)
    lonlat : bool
        Whether the coordinates are degrees of longitude and latitude.
    merged : int
        How many rows were left out because they repeat a point, which bears the mean of the values
        given there.
    conflicts : int
        At how many points these values differ.
    spread : float
        By how much, at the most.
    bad : tuple of BadRow
        Rows that were left out because they are not numbers.
    left : tuple of str
        The columns that were not read.
    """

    names: tuple[str, ...]
    points: np.ndarray
    values: np.ndarray
    lonlat: bool = False
    merged: int = 0
    conflicts: int = 0
    spread: float = 0.0
    bad: tuple[BadRow, ...] = ()
    left: tuple[str, ...] = ()

    @property
    def remarks(self) -> list[str]:
        """What a reader of the field should know of its samples, in sentences."""
        return [*self._of_rows(), *self._of_columns()]

    def _of_rows(self) -> Iterator[str]:
        if self.bad:
            shown = "; ".join(f"{row.line}: {row.reason}" for row in self.bad[:_SHOWN])
            more = f"; and {len(self.bad) - _SHOWN} more" if len(self.bad) > _SHOWN else ""
            yield f"{_count(len(self.bad), 'row')} left out, by line: {shown}{more}."
        if self.merged:
            yield (
                f"{_count(self.merged, 'row')} repeat{'s' * (self.merged == 1)} a point; it bears "
                "the mean of its values, which "
                + (
                    f"differ at {_count(self.conflicts, 'point')}, by up to {self.spread:.4g}."
                    if self.conflicts
                    else "are the same."
                )
            )

    def _of_columns(self) -> Iterator[str]:
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
        if unread := [name for name in self.left if bare_name(name) == "z"]:
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
    progress: Progress | None = None,
) -> Samples:
    """Read samples from a table: text, NPZ or Parquet, see `read_table`.

    Parameters
    ----------
    path : Path
    x, y, value : str, optional
        Names of the columns. Where not given, usual names are looked for, and the value may be
        the only column left.
    z : str, optional
        Name of the third coordinate, of points in space.
    lonlat : bool
        Whether x and y are degrees; longitudes become those in [-180, 180).
    strict : bool
        Refuse the table for a bad row, instead of leaving the row out.
    progress : callable, optional
        Called as progress(done, total), in bytes or rows.

    Raises
    ------
    ValueError
        If a column cannot be found, no row is good, or, if strict, one is not: with its line.
    ImportError
        If it is Parquet and pyarrow is not installed.
    """
    if lonlat and z is not None:
        raise ValueError("--lonlat is for places on the globe, --z for points in space: not both")
    names = {"x": x, "y": y} | ({} if z is None else {"z": z}) | {"value": value}
    columns: list[str] = []
    limits = (360.0, 90.0, np.inf) if lonlat else (np.inf,) * len(names)

    def choose(found: list[str]) -> list[int]:
        columns[:] = found
        return chosen_columns(path, found, names)

    table = read_table(path, Wanted(choose, limits), progress)
    if table.bad and (strict or not len(table.numbers)):
        row = table.bad[0]
        raise ValueError(f"{path}, line {row.line}: {row.reason}")
    if lonlat and len(table.bad) > len(table.numbers):
        row = table.bad[0]
        raise ValueError(
            f"most rows of {path} are no degrees of longitude and latitude, such as line "
            f"{row.line}: {row.reason}; are they lengths, or the other way round?"
        )
    points = table.numbers[:, :-1]
    places = np.round(principal(points), _ROUNDED) if lonlat else points
    return _merged(
        partial(
            Samples,
            tuple(table.names),
            lonlat=lonlat,
            bad=tuple(table.bad),
            left=tuple(name for name in columns if name not in table.names),
        ),
        places,
        table.numbers[:, -1],
    )


def refuse_flat(samples: Samples) -> None:
    """Refuse samples all on a line, or in a plane of space, in words.

    Raises
    ------
    numpy.linalg.LinAlgError
        If they are: beside it, any field would do.
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
    where = ("at one place", "on one straight line", "in one plane")[rank]
    remedy = (
        "; take the distance along it as the only coordinate of fieldrecon.RBF" if rank == 1 else ""
    )
    raise np.linalg.LinAlgError(
        f"all {n} points lie {where}: they do not say what the field is beside it{remedy}"
    )


def _count(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def _merged(samples: partial[Samples], points: np.ndarray, values: np.ndarray) -> Samples:
    """Give each point once, in the order of the file, with the mean of its values."""
    label = coincidence_labels(points)
    order = np.argsort(label, kind="stable")
    start = np.searchsorted(label[order], np.arange(label.max() + 1))
    if len(start) == len(points):
        return samples(points=points, values=values)
    own, count = values[order], np.diff(np.append(start, len(points)))
    with np.errstate(over="ignore"):  # numbers that lie too far apart to be subtracted
        spread = np.maximum.reduceat(own, start) - np.minimum.reduceat(own, start)
    # divided before they are added, so that the sum of large values is a number too
    means = np.add.reduceat(own / np.repeat(count, count), start)
    return samples(
        points=points[order[start]],
        values=np.where(spread > 0, means, own[start]),
        merged=len(points) - len(start),
        conflicts=int((spread > 0).sum()),
        spread=float(spread.max()),
    )
