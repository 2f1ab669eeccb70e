"""Units of data near the ends of the range of numbers, where sums of data would overflow.

A linear method has the same digits in every unit that is a power of two.
"""

from __future__ import annotations

import numpy as np

ORDINARY = 2.0**500
"""Data of this size and its inverse are added and multiplied by coefficients as they are."""
UNIT = 2.0**750
"""In this unit larger data have ordinary sizes, and smaller data in its inverse."""


def in_units_of_data(columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Columns (n, v) with ordinary sizes, and the units (v,) by which they were divided.

    Ordinary columns have the unit one, so that nested fields have no further units.
    """
    size = np.maximum(*(np.abs(p).max(axis=0, initial=0.0) for p in (columns.real, columns.imag)))
    units = np.ones_like(size)
    units[size > ORDINARY] = UNIT
    units[(size > 0) & (size < 1 / ORDINARY)] = 1 / UNIT
    return (columns if (units == 1).all() else columns / units), units
