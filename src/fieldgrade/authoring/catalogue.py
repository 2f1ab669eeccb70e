"""The catalogue of answers: known mistakes with their sentences, and alternative right answers.

They are beside the sources, in ``misconceptions/`` and ``alternatives/``, with a file for each
notebook. An answer is a function with its own name that replaces the requested one::

    @answers("02.3")
    def weights_not_squared(points, values, x, epsilon):
        '''The sentence for the student: what is wrong, why it matters, where to look.'''

Each answer is self-contained: it imports what it needs, and calls no function of the notebook.
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
        The name of the question.
    name : str
        The name of the function, in words.
    sentence : str
        Its docstring: for a mistake, the sentence for the student.
    function : callable
        The answer.
    named : bool
        Whether a mistake can be recognized. It cannot if it returns rounding errors, which differ
        between processors.
    """

    question: str
    name: str
    sentence: str
    function: Function
    named: bool = True

    def namespace(self, functions: dict[str, Any]) -> dict[str, Any]:
        """Return the functions of a notebook, with the solution replaced by this answer."""
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
        raise ImportError(f"{path} is not a Python file")
    module = module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
