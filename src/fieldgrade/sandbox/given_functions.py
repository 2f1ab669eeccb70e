"""Functions of earlier questions whose values come from the grader, not from the submission.

An answer that calls a wrong earlier answer is asked again with these in their place. A call sends
its arguments to the grader, which returns arrays: no code comes into the sandbox.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

Exchange = Callable[[dict[str, Any], tuple[Any, ...]], tuple[dict[str, Any], Sequence[np.ndarray]]]
"""Sends the head and the arrays of a frame, and returns those of the reply."""


def given_function(name: str, exchange: Exchange) -> Callable[..., Any]:
    """Return a function that asks the grader for its values.

    The function raises ValueError if the grader returns none: the arguments are not valid, or there
    are too many calls.
    """

    def ask(*arguments: Any, **named: Any) -> Any:
        return _values(*exchange(*_request(name, arguments, named)))

    ask.__name__ = name
    return ask


def _request(
    name: str, arguments: Sequence[Any], named: Mapping[str, Any]
) -> tuple[dict[str, Any], tuple[Any, ...]]:
    """Return a call as the head and the arrays of a frame."""
    described: list[dict[str, Any]] = []
    arrays: list[np.ndarray] = []
    for argument in (*arguments, *named.values()):
        plain = argument.item() if isinstance(argument, np.generic) else argument
        if plain is None or isinstance(plain, bool | int | float):
            described.append({"number": plain})
        else:
            described.append({"array": len(arrays)})
            arrays.append(np.asarray(plain))
    return {"asks": name, "arguments": described, "named": [*named]}, tuple(arrays)


def _values(reply: dict[str, Any], arrays: Sequence[np.ndarray]) -> Any:
    """Return the values of a reply: an array or a number, or a tuple of them."""
    if not reply.get("given"):
        raise ValueError("this earlier function has no value for these arguments")
    values = tuple(np.array(array)[()] for array in arrays)
    return values[0] if len(values) == 1 else values
