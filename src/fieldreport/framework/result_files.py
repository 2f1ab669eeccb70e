"""The files of a run: written whole or not at all, the same bytes for the same result."""

from __future__ import annotations

import csv
import io
import json
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from fieldrecon._core.atomic_files import write_atomically
from fieldreport.experiments import get
from fieldreport.framework.experiment import Experiment, Result, Table, cell_from_text
from fieldreport.framework.settings import with_settings

FIGURE_FORMATS = ("svg", "pdf", "png")

_ZIP_EPOCH = (1980, 1, 1, 0, 0, 0)


def write_result(result: Result, folder: Path) -> list[Path]:
    """Write parameters, facts, tables and arrays into a folder; return the files.

    ``params.json``, ``facts.json`` (flat), ``TABLE.csv`` for each table and ``arrays.npz``.
    A table that an earlier run left there and this one lacks is removed, as it would be read back.
    """
    contents = {
        "params.json": _json(asdict(result.params)),
        "facts.json": _json(dict(result.facts)),
        "arrays.npz": npz_bytes(result.arrays),
    } | {f"{name}.csv": csv_bytes(t.columns, t.rows) for name, t in result.tables.items()}
    for stale in set(folder.glob("*.csv")) - {folder / name for name in contents}:
        stale.unlink()
    return [write_atomically(folder / name, content) for name, content in contents.items()]


def read_result(folder: Path) -> Result:
    """Read back what ``write_result`` wrote; the folder bears the experiment's name."""
    with np.load(folder / "arrays.npz") as stored:
        arrays = dict(stored)
    return Result(
        params=with_settings(get(folder.name).defaults, _read_json(folder / "params.json")),
        tables={path.stem: _read_table(path) for path in sorted(folder.glob("*.csv"))},
        facts=_read_json(folder / "facts.json"),
        arrays=arrays,
    )


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


def write_figure(figure: Any, stem: Path, formats: Iterable[str] = FIGURE_FORMATS) -> list[Path]:
    """Write one figure as ``STEM.svg``, ``STEM.pdf`` and ``STEM.png``, the same bytes each time."""
    return [
        write_atomically(stem.with_name(f"{stem.name}.{kind}"), figure_bytes(figure, kind))
        for kind in formats
    ]


def figure_bytes(figure: Any, kind: str) -> bytes:
    """Return the figure as SVG, PDF or PNG; figures of the report's style carry no date."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format=kind)
    return buffer.getvalue()


def npz_bytes(arrays: Mapping[str, np.ndarray]) -> bytes:
    """Return the arrays as an npz file whose members carry no time."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for name, array in arrays.items():
            member = io.BytesIO()
            np.lib.format.write_array(member, np.asarray(array), allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{name}.npy", _ZIP_EPOCH), member.getvalue())
    return buffer.getvalue()


def csv_bytes(columns: Iterable[str], rows: Iterable[Iterable[Any]]) -> bytes:
    """Return header and rows as CSV, each float in the shortest form that reads back the same."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue().encode()


def _json(x: Any) -> bytes:
    return (json.dumps(x, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode()


def _read_json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def _read_table(path: Path) -> Table:
    with path.open(encoding="utf-8", newline="") as file:
        columns, *rows = csv.reader(file)
    return Table(tuple(columns), tuple(tuple(map(cell_from_text, row)) for row in rows))
