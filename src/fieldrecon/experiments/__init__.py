"""The experiments: each module here that defines ``Params``, ``run`` and ``plot`` is one.

To add an experiment is to add a file; nothing else lists them.
"""

from __future__ import annotations

import ast
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fieldrecon.experiments.experiment import Experiment

_HERE = Path(__file__).parent
_PARTS = {"Params", "run", "plot"}


def names() -> tuple[str, ...]:
    """Name the experiments, in alphabetical order, without importing any of them."""
    return tuple(titles())


def titles() -> dict[str, str]:
    """Return the title of each experiment by its name, in alphabetical order, from the sources."""
    sources = {path.stem: _source(path.stem) for path in sorted(_HERE.glob("*.py"))}
    return {
        name: (ast.get_docstring(s) or name).splitlines()[0].rstrip(".")
        for name, s in sources.items()
        if s
    }


def get(name: str) -> Experiment:
    """Return the experiment of that name.

    Raises
    ------
    ValueError
        If there is none; the message names those that exist.
    """
    from fieldrecon.experiments.experiment import Experiment

    if not name.isidentifier() or _source(name) is None:
        raise ValueError(f"there is no experiment {name!r}; there are {', '.join(names())}")
    return Experiment(name, import_module(f"{__name__}.{name}"))


def _source(name: str) -> ast.Module | None:
    """Return the source of an experiment, or None: importing every module would cost seconds."""
    path = _HERE / f"{name}.py"
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    if not all(part in text for part in _PARTS):  # saves parsing what cannot be one
        return None
    tree = ast.parse(text)
    defined = {node.name for node in tree.body if isinstance(node, ast.ClassDef | ast.FunctionDef)}
    return tree if defined >= _PARTS else None
