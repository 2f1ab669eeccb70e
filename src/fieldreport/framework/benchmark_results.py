"""Measured times and errors: read what ``make bench`` wrote."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from fieldreport.framework.experiment import ResultTable, in_checkout


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
