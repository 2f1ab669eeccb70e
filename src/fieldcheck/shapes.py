"""Compare returned shapes with the expected ones; harmless differences are removed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fieldcheck.calls import MATRIX, ONE_ROW, Outcome, Values

ORDINALS = ("first", "second", "third", "fourth", "fifth")
"""For the arrays that a function returns: their entries are counted from 0."""


def without_extra_axes(outcome: Outcome, shapes: Sequence[tuple[int, ...]]) -> Outcome:
    """Return an outcome in the expected shapes, if only its type has changed the number of axes.

    An ``np.matrix`` has two axes, also for a vector. A tuple of the rows of an array is an array
    without its first axis, if there is only one row. An array with a superfluous axis is not
    changed: it would stop the arithmetic of the notebook.

    Examples
    --------
    >>> row = Outcome("returned", (np.array([[1.0, 2.0]]),), returned=MATRIX)
    >>> without_extra_axes(row, [(2,)]).values
    (array([1., 2.]),)
    """
    if outcome.values is None or outcome.returned not in (MATRIX, ONE_ROW):
        return outcome
    values = fitted(outcome.values, shapes)
    if [_long_axes(v.shape) for v in values] != [_long_axes(shape) for shape in shapes]:
        return outcome
    pairs = zip(values, shapes, strict=True)
    return replace(outcome, values=tuple(v.reshape(shape) for v, shape in pairs))


def _long_axes(shape: tuple[int, ...]) -> list[int]:
    return [length for length in shape if length != 1]


def fitted(values: Values, shapes: Sequence[tuple[int, ...]]) -> Values:
    """Return the values in the expected shapes, if only the packing differs.

    One array may be a tuple of its rows, several arrays may be stacked, and a number may be an
    array with one entry. Complex numbers with zero imaginary part become real.

    Examples
    --------
    >>> fitted((np.array(1.0), np.array(2.0)), [(2,)])
    (array([1., 2.]),)
    >>> fitted((np.array([[1.0]]),), [()])
    (array(1.),)
    """
    if len(shapes) == 1 and len(values) > 1 and len({v.shape for v in values}) == 1:
        numbers = all(v.size == 1 for v in values) and len(shapes[0]) == 1
        values = (np.concatenate([v.ravel() for v in values]) if numbers else np.stack(values),)
    elif len(shapes) > 1 and len(values) == 1 and values[0].shape[:1] == (len(shapes),):
        values = tuple(values[0])
    if len(values) == len(shapes):
        values = tuple(
            v.reshape(()) if shape == () and v.size == 1 else v
            for v, shape in zip(values, shapes, strict=True)
        )
    return tuple(_real(v) for v in values)


def _real(values: np.ndarray) -> np.ndarray:
    if values.dtype.kind != "c":
        return values.astype(float)
    return values.real if not values.imag.any() else values


def in_words(values: Values) -> str:
    """Return the shapes in words: ``an array of shape (5, 3)``, ``a number and …``."""
    return " and ".join(shape_in_words(v.shape) for v in values)


def shape_in_words(shape: tuple[int, ...]) -> str:
    """Return a shape in words."""
    return f"an array of shape {shape}" if shape else "a number"


LARGEST_WHOLE = 2.0**53
"""All numbers of at least this size are whole."""


def are_whole(values: np.ndarray) -> bool:
    """Return whether all values are whole numbers, and not just so large that decimals are lost."""
    return bool((values == np.round(values)).all() and (np.abs(values) < LARGEST_WHOLE).all())
