"""The experiments: each module here that defines ``Params``, ``run`` and ``plot`` is one.

To add an experiment is to add a file; nothing else lists them.
"""

from __future__ import annotations

import ast
from importlib import import_module
from pathlib import Path

from fieldrecon.experiments.experiment import (
    Experiment,
    Map,
    Result,
    Table,
    order_of_magnitude,
    parameter,
)

__all__ = [
    "Experiment",
    "Map",
    "Result",
    "Table",
    "get",
    "names",
    "order_of_magnitude",
    "parameter",
]

_HERE = Path(__file__).parent
_PARTS = {"Params", "run", "plot"}


def names() -> tuple[str, ...]:
    """Name the experiments, in alphabetical order, without importing any of them."""
    return tuple(path.stem for path in sorted(_HERE.glob("*.py")) if _is_experiment(path))


def get(name: str) -> Experiment:
    """Return the experiment of that name.

    Raises
    ------
    ValueError
        If there is none; the message names those that exist.
    """
    if name not in names():
        raise ValueError(f"there is no experiment {name!r}; there are {', '.join(names())}")
    return Experiment(name, import_module(f"{__name__}.{name}"))


def _is_experiment(path: Path) -> bool:
    """Tell from its source whether a module is one: importing them all would cost seconds."""
    body = ast.parse(path.read_text(encoding="utf-8")).body
    defined = {node.name for node in body if isinstance(node, ast.ClassDef | ast.FunctionDef)}
    return defined >= _PARTS
