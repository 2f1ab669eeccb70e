"""Compare returned shapes with the expected ones; harmless differences are removed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Values


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
        values = (np.stack(values),)
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
