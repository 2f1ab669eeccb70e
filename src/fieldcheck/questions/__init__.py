"""The questions of the course: up to four modules for each notebook.

A module defines ``QUESTIONS``: inputs, shapes, and laws that a right answer satisfies. It contains
no solution, and no code close to one.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from fieldcheck.question import Question


@cache
def questions() -> Mapping[str, Question]:
    """Return all questions by name, in the order of the notebooks."""
    modules = [import_module(f"{__name__}.{found.name}") for found in iter_modules(__path__)]
    found = [question for module in modules for question in module.QUESTIONS]
    return {question.name: question for question in sorted(found, key=_order)}


def _order(question: Question) -> tuple[int, ...]:
    return tuple(map(int, question.name.split(".")))


def get(name: str) -> Question:
    """Return a question.

    Raises
    ------
    ValueError
        There is no such question; the message lists those of the notebook.
    """
    known = questions()
    if name not in known:
        notebook = str(name).partition(".")[0].zfill(2)
        there = [other for other in known if other.startswith(f"{notebook}.")] or list(known)
        raise ValueError(
            f"there is no function to write in question {name!r}; there are {', '.join(there)}"
        )
    return known[name]
