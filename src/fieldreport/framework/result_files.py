"""The files of a run: written atomically, with equal bytes for equal results."""

from __future__ import annotations

import csv
import io
import json
import zipfile
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from fieldrecon._core.atomic_files import write_atomically
from fieldrecon.io.tables import csv_bytes
from fieldrecon.plotting.figure_files import FIGURE_FORMATS, write_figure
from fieldreport.framework.experiment import (
    Cell,
    Experiment,
    Result,
    ResultTable,
    cell_from_text,
    in_checkout,
)
from fieldreport.framework.orders_of_magnitude import OrderOfMagnitude, mark_orders
from fieldreport.framework.parameters import replace_parameters

TABLES = "tables.json"
_ZIP_EPOCH = (1980, 1, 1, 0, 0, 0)


def write_result(result: Result, folder: Path) -> list[Path]:
    """Write parameters, facts, tables and arrays into a folder; return the files.

    ``params.json``, ``facts.json`` (flat), ``arrays.npz``, ``TABLE.csv`` for each table, and
    ``tables.json``, the list of their names. A table of an earlier run that this result lacks is
    removed; no other file is removed, not even a table.
    """
    contents = {
        "params.json": _json(asdict(result.params)),
        "facts.json": _json(mark_orders(dict(result.facts))),
        "arrays.npz": npz_bytes(result.arrays),
        TABLES: _json(sorted(result.tables)),
    } | {f"{name}.csv": csv_bytes(t.columns, t.rows) for name, t in result.tables.items()}
    with suppress(OSError, TypeError, ValueError):  # no earlier run, or a damaged list
        for name in {*_read_json(folder / TABLES)} - {*result.tables}:
            (folder / f"{name}.csv").unlink(missing_ok=True)
    return [write_atomically(folder / name, content) for name, content in contents.items()]


def table_files(folder: Path) -> list[Path]:
    """List the files of the tables of a result, in the order of their names."""
    return [folder / f"{name}.csv" for name in _read_json(folder / TABLES)]


def result_files(folder: Path) -> list[Path]:
    """List the files of a result; there may be others in the folder."""
    own = ("params.json", "facts.json", "arrays.npz", TABLES)
    return sorted([*(folder / name for name in own), *table_files(folder)])


def read_result(folder: Path, experiment: Experiment) -> Result:
    """Read the result of an experiment that ``write_result`` wrote."""
    with np.load(folder / "arrays.npz") as stored:
        arrays = dict(stored)
    return Result(
        params=replace_parameters(experiment.defaults, _read_json(folder / "params.json")),
        tables={path.stem: _read_table(path) for path in table_files(folder)},
        facts={name: _fact(x) for name, x in _read_json(folder / "facts.json").items()},
        arrays=arrays,
    )


def fact_names(folder: Path) -> set[str]:
    """Read the names of the facts of a result."""
    return set(_read_json(folder / "facts.json"))


def table_columns(folder: Path) -> dict[str, tuple[str, ...]]:
    """Read the columns of the tables of a result, by the name of the table."""
    return {path.stem: _columns(path) for path in table_files(folder)}


def write_figures(
    experiment: Experiment,
    result: Result,
    folder: Path,
    formats: Iterable[str] = FIGURE_FORMATS,
) -> list[Path]:
    """Draw every figure of an experiment into a folder; return the files."""
    formats = tuple(formats)
    return [
        path
        for name, plot in experiment.plots.items()
        for path in write_figure(plot(result), folder / name, formats)
    ]


def npz_bytes(arrays: Mapping[str, np.ndarray]) -> bytes:
    """Return the arrays as an npz file whose members have no time stamp."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for name, array in arrays.items():
            member = io.BytesIO()
            np.lib.format.write_array(member, np.asarray(array), allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{name}.npy", _ZIP_EPOCH), member.getvalue())
    return buffer.getvalue()


def _fact(x: Cell) -> Cell:
    return OrderOfMagnitude.parse(x) if isinstance(x, str) and x.startswith("~1e") else x


def _json(x: Any) -> bytes:
    return (json.dumps(x, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode()


def _read_json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def _columns(path: Path) -> tuple[str, ...]:
    with path.open(encoding="utf-8", newline="") as file:
        return tuple(next(csv.reader(file)))


def _read_table(path: Path) -> ResultTable:
    with path.open(encoding="utf-8", newline="") as file:
        columns, *rows = csv.reader(file)
    return ResultTable(tuple(columns), tuple(tuple(map(cell_from_text, row)) for row in rows))


def read_benchmark(file: str) -> dict[str, Any]:
    """Return the result of a benchmark from a file, named relative to the root of the checkout.

    Raises
    ------
    FileNotFoundError
        If the file does not exist, as outside of a checkout.
    """
    path = in_checkout(file)
    if not path.is_file():
        raise FileNotFoundError(
            f"the measurements in {path} are missing: they are part of a checkout of fieldrecon, "
            "not of the installed package; run this in a checkout, or name the file with "
            "--set results=FILE"
        )
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def tables(result: Mapping[str, Any]) -> list[ResultTable]:
    """Return the tables of a benchmark's result."""
    return [
        ResultTable(tuple(t["columns"]), tuple(map(tuple, t["rows"]))) for t in result["tables"]
    ]


def select_columns(table: ResultTable, columns: tuple[str, ...]) -> ResultTable:
    """Return some columns of a table, in the given order."""
    wanted = [table.columns.index(name) for name in columns]
    return ResultTable(columns, tuple(tuple(row[k] for k in wanted) for row in table.rows))
