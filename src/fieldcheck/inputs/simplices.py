"""One simplex, a triangle or a tetrahedron: its size, and its circumcentre near and far away.

The corners are the rows of one argument, or one argument each.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fieldcheck.calls import Call, Values, calls_of
from fieldcheck.question import LEAST_TOLERANCE, law_of_each, relative

FAR = 1e7
"""At this distance from the origin, squared coordinates have no digits left for a simplex."""
DIGITS_FAR_AWAY = 1e-6
"""Tolerance for rounded corners at this distance; squared coordinates have far larger errors."""
STORED_DIGITS_FAR_AWAY = 1e-4
"""Tolerance for right values at this distance, which are stored with twelve digits."""


def corners(call: Call) -> np.ndarray:
    """Return the corners of a simplex, one in each row."""
    return np.concatenate([np.atleast_2d(argument) for argument in call.arguments])


def moved_far_away(calls: Sequence[Call], cases: Sequence[str]) -> tuple[Call, ...]:
    """Return calls with the same simplices far from the origin, and new words for each case."""
    moved = (tuple(argument + FAR for argument in call.arguments) for call in calls)
    return calls_of(calls[0].function, *zip(moved, cases, strict=True))


def tolerance_far_away(call: Call) -> float:
    """Return the tolerance of a circumcentre relative to its simplex, which may be small."""
    return STORED_DIGITS_FAR_AWAY if _is_far(call) else LEAST_TOLERANCE


def relative_to_a_corner(call: Call, values: Values) -> Values:
    """Return the position relative to the first corner, so that errors far away are visible."""
    return (values[0] - corners(call)[0],)


def _difference_of_distances(call: Call, values: Values) -> float:
    """Return the largest difference between the distances to the corners."""
    (p,) = values
    distances = np.sqrt(np.square(corners(call) - p).sum(axis=1))
    return relative(distances - distances.mean(), distances)


def _is_far(call: Call) -> bool:
    """Return whether squared coordinates have no digits left for the simplex."""
    q = corners(call)
    return bool(np.abs(q).max() > FAR / 2 * min(1.0, np.ptp(q, axis=0).max()))


@law_of_each("A circumcentre must be equally far from all corners.", DIGITS_FAR_AWAY)
def is_equally_far(call: Call, values: Values) -> float:
    """Return the largest difference between the distances to the corners, near the origin."""
    return 0.0 if _is_far(call) else _difference_of_distances(call, values)


@law_of_each(
    "A circumcentre must be equally far from all corners, also far from the origin, where squares "
    "of coordinates lose digits.",
    DIGITS_FAR_AWAY,
)
def is_equally_far_from_afar(call: Call, values: Values) -> float:
    """Return the largest difference between the distances to the corners, far from the origin."""
    return _difference_of_distances(call, values) if _is_far(call) else 0.0


def is_halved(_: Sequence[Call], values: Sequence[Values]) -> float:
    """Return the deviation of a size from positive, from independent of the order, and from half.

    The first three calls have a simplex, the same in another order, and half of it.
    """
    each = [float(v) for (v,) in values]
    whole, reordered, half = each[:3]
    return max(
        relative(reordered - whole, whole), relative(2 * half - whole, whole), max(0.0, -min(each))
    )
