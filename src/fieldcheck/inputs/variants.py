"""Calls that differ in one argument only."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from fieldcheck.calls import Call


def one_changed(call: Call, *others: tuple[str, Any]) -> tuple[Call, ...]:
    """Return the call with its first argument replaced, then with its second one, and so on.

    An answer that stores its results, and identifies them by some of the arguments only, returns a
    result of an earlier call.

    Parameters
    ----------
    call : Call
        The call.
    *others : tuple of str and object
        For each argument, in order: what is other, in words that can follow "with", and the value.

    Examples
    --------
    >>> room = Call("area", (2, 3), "a room")
    >>> for other in one_changed(room, ("another width", 4), ("another length", 5)):
    ...     print(other.case, other.arguments)
    a room, with another width (4, 3)
    a room, with another length (2, 5)
    """
    return tuple(
        replace(
            call,
            arguments=(*call.arguments[:k], other, *call.arguments[k + 1 :]),
            case=f"{call.case}, with {words}",
        )
        for k, (words, other) in enumerate(others)
    )
