"""Experiments by topic: each module that defines ``Params``, ``run`` and ``plot`` is an experiment.

An experiment is added as a file; there is no other list.
"""

from __future__ import annotations

import ast
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from fieldreport.framework.names import no_such

if TYPE_CHECKING:
    from fieldreport.framework.experiment import Experiment

_HERE = Path(__file__).parent
_PARTS = {"Params", "run", "plot"}


def names() -> tuple[str, ...]:
    """Return the names of the experiments in alphabetical order, without importing any of them."""
    return tuple(titles())


def titles() -> dict[str, str]:
    """Return the title of each experiment by its name, in alphabetical order, from the sources."""
    sources = {name: _source(path) for name, path in sorted(_modules().items())}
    return {
        name: (ast.get_docstring(s) or name).splitlines()[0].rstrip(".")
        for name, s in sources.items()
        if s
    }


def module_of(name: str) -> str:
    """Return the full name of the module of an experiment.

    Raises
    ------
    ValueError
        If there is no experiment of that name; the message names those that exist.
    """
    path = _modules().get(name)
    if path is None or _source(path) is None:
        raise ValueError(f"there is {no_such('experiment', name, names())}")
    return f"{__name__}.{path.parent.name}.{name}"


def get(name: str) -> Experiment:
    """Return the experiment of that name.

    Raises
    ------
    ValueError
        If there is no experiment of that name; the message names those that exist.
    """
    from fieldreport.framework.experiment import Experiment

    return Experiment(name, import_module(module_of(name)))


def _modules() -> dict[str, Path]:
    """Return the module files in the folders of the topics, by name."""
    return {path.stem: path for path in _HERE.glob("*/*.py") if path.stem != "__init__"}


def _source(path: Path) -> ast.Module | None:
    """Return the source of an experiment, or None: importing every module would cost seconds."""
    return _parsed(path.read_text(encoding="utf-8"))


@cache
def _parsed(text: str) -> ast.Module | None:
    if not all(part in text for part in _PARTS):  # avoids parsing modules that are no experiments
        return None
    tree = ast.parse(text)
    defined = {node.name for node in tree.body if isinstance(node, ast.ClassDef | ast.FunctionDef)}
    return tree if defined >= _PARTS else None
