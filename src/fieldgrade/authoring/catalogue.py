"""Other answers than the solution: mistakes, each with its sentence, and right ones in other ways.

They lie beside the sources, in ``misconceptions/`` and ``alternatives/``, a file for each
notebook. An answer is a function under a name of its own that stands in for the one asked for::

    @answers("02.3")
    def weights_not_squared(points, values, x, epsilon):
        '''What the student is told: what is wrong, why it matters, where to look.'''

Each stands for itself: it imports what it needs, and calls nothing of the notebook.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

from fieldcheck.questions import get
from fieldgrade.authoring.sources import Source

Function = Callable[..., Any]


@dataclass(frozen=True)
class Entry:
    """An answer of the catalogue.

    Parameters
    ----------
    question : str
        What it answers.
    name : str
        The name of the function, in words.
    sentence : str
        Its docstring: for a mistake, what the student is told.
    function : callable
        The answer.
    named : bool
        Whether a mistake can be recognised. It cannot if what it gives are rounding errors, which
        are others on another processor.
    """

    question: str
    name: str
    sentence: str
    function: Function
    named: bool = True

    def namespace(self, functions: dict[str, Any]) -> dict[str, Any]:
        """Return the functions of a notebook with this one in the place of the solution."""
        return functions | {get(self.question).function: self.function}


def answers(question: str, *, named: bool = True) -> Callable[[Function], Function]:
    """Mark a function as an answer to a question, or as a mistake that cannot be `named`."""

    def mark(function: Function) -> Function:
        function.__dict__.update(question=question, named=named)
        return function

    return mark


def entries(source: Source, folder: str) -> list[Entry]:
    """Return the answers in ``misconceptions`` or ``alternatives`` beside a source."""
    path = source.path.parent / folder / source.path.name
    if not path.is_file():
        return []
    found = (f for f in vars(load(path)).values() if hasattr(f, "question"))
    return [
        Entry(f.question, f.__name__.replace("_", " "), _sentence(f), f, f.named) for f in found
    ]


def _sentence(function: Function) -> str:
    return " ".join((inspect.getdoc(function) or "").split())


def load(path: Path) -> Any:
    """Return the module in a file beside the sources."""
    name = f"_course_{path.parent.name}_{path.stem}"
    spec = spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} is no Python file")
    module = module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
