"""Which earlier questions the solution of a question calls, found in its compiled code."""

from __future__ import annotations

import dis
from collections.abc import Iterator, Mapping
from types import CodeType, FunctionType
from typing import Any

from fieldcheck.earlier_answers import earlier_questions
from fieldcheck.question import Question


def solution_calls(question: Question, functions: Mapping[str, Any]) -> tuple[Question, ...]:
    """Return the earlier questions whose functions a solution calls, directly or through others.

    Parameters
    ----------
    question : Question
        The question.
    functions : mapping
        The functions of the solution of its notebook, helpers included.
    """
    found, todo = set[str](), [question.function]
    while todo:
        function = functions.get(todo.pop())
        if isinstance(function, FunctionType):
            new = {name for name in _global_names(function.__code__) if name in functions} - found
            found |= new
            todo += new
    return tuple(other for other in earlier_questions(question) if other.function in found)


def _global_names(code: CodeType) -> Iterator[str]:
    """Yield the global names that code reads, also in functions that it defines."""
    for step in dis.get_instructions(code):
        if step.opname == "LOAD_GLOBAL":
            yield str(step.argval)
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _global_names(inner)
