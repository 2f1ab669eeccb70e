"""Calls with zeros where an answer may divide, ask for a sign, or take a number as absent."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fieldcheck.calls import Call

Inputs = Callable[[int], tuple[Call, ...]]
Changed = tuple[dict[int, np.ndarray], str]


def also_at_zero(
    inputs: Inputs,
    points: Sequence[int] = (),
    numbers: Sequence[int] = (),
    values: Sequence[int] = (),
) -> Inputs:
    """Return inputs with further calls: the first one with zeros at special places.

    The largest coordinate, the first point, the largest value, every other value, or the sum of all
    values is zero.

    Parameters
    ----------
    inputs : callable
        ``inputs(seed) -> calls``.
    points : sequence of int
        Positions of arguments that are points, of shape (n, D) or (D,): they are moved together.
    numbers : sequence of int
        Positions of arguments that are points of a line, of shape (n,), moved together.
    values : sequence of int
        Positions of arguments that may have any values, of shape (n,) or (n, k).

    Examples
    --------
    >>> def inputs(seed):
    ...     return (Call("total", (np.array([3.0, 1.0, 7.0]),), "three values"),)
    >>> for call in also_at_zero(inputs, values=(0,))(0):
    ...     print(call.case, *call.arguments)
    three values [3. 1. 7.]
    three values, the largest number zero [-4. -6.  0.]
    three values, some numbers zero [0. 1. 0.]
    three values, numbers whose sum is zero [-4.  0.  4.]
    """

    def more(seed: int) -> tuple[Call, ...]:
        calls = inputs(seed)
        plain, *_ = calls
        changes = (
            *_moved(plain, points, np.atleast_2d),
            *_moved(plain, numbers, lambda p: p[:, np.newaxis]),
            *_changed(plain, values),
        )
        return (*calls, *(_with(plain, arguments, words) for arguments, words in changes))

    return more


def _with(call: Call, arguments: dict[int, np.ndarray], words: str) -> Call:
    every = tuple(arguments.get(k, old) for k, old in enumerate(call.arguments))
    return replace(call, arguments=every, case=f"{call.case}, {words}")


def _moved(
    call: Call, positions: Sequence[int], in_rows: Callable[[Any], np.ndarray]
) -> Iterator[Changed]:
    """Yield the points, moved so that no coordinate is positive, or the first one is zero."""
    if not positions:
        return
    shapes = {k: call.arguments[k].shape for k in positions}
    rows = {k: in_rows(call.arguments[k]) for k in positions}
    every = np.concatenate(list(rows.values()))
    for zero, words in (
        (every.max(axis=0), "all coordinates at most zero"),
        (every[0], "moved to the origin"),
    ):
        yield {k: (rows[k] - zero).reshape(shapes[k]) for k in positions}, words


def _changed(call: Call, positions: Sequence[int]) -> Iterator[Changed]:
    """Yield other values instead of the values at each of the positions."""
    for k in positions:
        v = call.arguments[k]
        odd = np.arange(len(v)) % 2 == 1
        yield {k: v - v.max(axis=0)}, "the largest number zero"
        yield {k: np.where(odd.reshape(-1, *(1 for _ in v.shape[1:])), v, 0)}, "some numbers zero"
        yield {k: v - v[::-1]}, "numbers whose sum is zero"
