"""Columns of numbers from a table of millions of rows: text, NPZ or Parquet.

A row that is not what the header promises is left out, and told with its line and the reason; the
others stay.
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fieldrecon._chunks import Progress
from fieldrecon._extras import optional
from fieldrecon._text_tables import AXES, text_parts
from fieldrecon._wanted_columns import BadRow, Part, Wanted

PARQUET_ROWS = 2**18


@dataclass(frozen=True, eq=False)
class Table:
    """Wanted columns of a table.

    Parameters
    ----------
    names : list of str
    numbers : ndarray of shape (n, columns)
        Of the good rows, in their order.
    bad : list of BadRow
    """

    names: list[str]
    numbers: np.ndarray
    bad: list[BadRow]


def read_table(path: Path, wanted: Wanted, progress: Progress | None = None) -> Table:
    """Read columns from ``.npz`` (arrays by name), ``.parquet``, or from text of any other suffix.

    Cells of a text are separated by commas, semicolons, tabs or white space, whichever the first
    line has most of. Blank lines and lines that begin with ``#`` are passed over. Without a header
    (the first line is all numbers) the columns are x, y, z, column 4 and so on.

    Raises
    ------
    ValueError
        If the file is not such a table, or `wanted` does not find its columns.
    ImportError
        If it is Parquet and pyarrow is not installed.
    """
    routes = {".npz": _npz, ".parquet": _parquet, ".pq": _parquet}
    parts = list(routes.get(path.suffix.lower(), text_parts)(path, wanted, progress))
    if not any(len(numbers) + len(bad) for _, numbers, bad in parts):
        raise ValueError(f"{path} has no rows below its header")
    names, numbers, bad = zip(*parts, strict=True)
    return Table(names[0], np.concatenate(numbers), [row for rows in bad for row in rows])


def _npz(path: Path, wanted: Wanted, progress: Progress | None) -> Iterator[Part]:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
    except (ValueError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path} cannot be read as arrays: {error}") from None
    columns = dict(_columns_of(path, arrays))
    everything = [*columns]
    chosen = wanted.choose(everything)
    names = [everything[k] for k in chosen]
    lengths = {len(columns[name]) for name in names}
    if len(lengths) > 1:
        sizes = ", ".join(f"{name} {len(columns[name])}" for name in names)
        raise ValueError(f"{path}: the columns must be equally long; got {sizes}")
    yield _checked(wanted, names, np.column_stack([columns[name] for name in names]), 1)
    if progress:
        progress(1, 1)


def _columns_of(path: Path, arrays: dict[str, np.ndarray]) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the arrays of numbers as columns: `points` as x, y and z, `values` as value."""
    for name, array in arrays.items():
        if array.dtype.kind not in "biuf" or array.ndim not in (1, 2):
            continue
        if array.ndim == 1:
            yield ("value" if name == "values" else name), array
        elif name == "points" and array.shape[1] <= len(AXES):
            yield from zip(AXES, array.T, strict=False)
        else:
            raise ValueError(f"{path}: a column must be one number for each row; {name} is not")


def _parquet(path: Path, wanted: Wanted, progress: Progress | None) -> Iterator[Part]:
    parquet = optional("pyarrow.parquet")
    with path.open("rb") as stream:
        try:
            file = parquet.ParquetFile(stream)
        except ValueError as error:
            raise ValueError(f"{path} cannot be read as Parquet: {error}") from None
        everything = list(file.schema_arrow.names)
        names = [everything[k] for k in wanted.choose(everything)]
        done = 0
        for batch in file.iter_batches(PARQUET_ROWS, columns=names):
            try:
                columns = [batch[name].cast("float64").to_numpy(False) for name in names]
            except (ValueError, NotImplementedError) as error:
                raise ValueError(f"{path} must hold numbers in {names}: {error}") from None
            yield _checked(wanted, names, np.column_stack(columns), done + 1)
            done += len(columns[0])
            if progress:
                progress(done, file.metadata.num_rows)


def _checked(wanted: Wanted, names: list[str], numbers: np.ndarray, first: int) -> Part:
    """The good rows, and what is wrong with the others, counted from the first."""
    good = wanted.good(numbers)
    faults = [
        BadRow(first + int(i), wanted.fault(names, numbers[i].tolist()))
        for i in np.flatnonzero(~good)
    ]
    return names, numbers[good].astype(float, copy=False), faults
