"""Queries far from the sites, where rounding may decide the values.

Outside the sites, and between distant groups of them, errors of the data and rounding are
multiplied by the sum of the absolute weights, which grows like a power of the distance: for
polynomials of degree k like the k-th. Where nothing is left of the values, the constants are lost,
too: with a constant C added to the data, the value must increase by C.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from fieldrecon._core.validation import format_point
from fieldrecon.polynomials import EPS

if TYPE_CHECKING:
    from fieldrecon.reconstruction import Reconstruction

REACH = 10.0
"""Distance from the box of the sites beyond which a query is far, in units of its longest side."""
CONSTANTS = np.array([1.0, -0.7, 0.4, -1.3])
"""Constants added to data of size one; two fields may by chance be rounded alike."""
LOST = 1e-4
"""Relative error beyond which a constant is lost."""
MULTIPLIED = 100.0
"""Factor from the error at the sites to that at a query, beyond which distance is the cause."""
_SAMPLED = 64


def near_box(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner (d,) of the box outside of which queries are far from the sites."""
    low, high = points.min(axis=0), points.max(axis=0)
    reach = REACH * np.max(high - low)
    return low - reach, high + reach


def are_far(box: tuple[np.ndarray, np.ndarray], x: np.ndarray) -> np.ndarray:
    """Which queries (m, d) are outside the `near_box`."""
    low, high = box
    outside: np.ndarray = (x < low) | (x > high)
    return np.logical_or.reduce(outside, axis=1)


def refuse_lost_constants(x: np.ndarray, error: np.ndarray, at_sites: float = 0.0) -> None:
    """Refuse queries (m, d) at which constants have errors (m, v) of more than LOST.

    A field is trusted at no query more than at its sites: if the largest error there is more than
    LOST, all queries are refused, and rounding at single queries does not decide.
    """
    worst = np.maximum(np.max(error, axis=1, initial=0.0), at_sites)
    # values that are not finite are reported elsewhere
    lost = np.flatnonzero((worst > LOST) & np.isfinite(worst))
    if len(lost):
        where, loss = format_point(x[lost[0]]), worst[lost[0]]
        raise np.linalg.LinAlgError(
            f"rounding decides the value at ({where}): {_cause(loss, at_sites)}"
        )


def _cause(loss: float, at_sites: float) -> str:
    """Why constants have this error at a query, and what to do."""
    if loss > MULTIPLIED * at_sites:
        return (
            "so far from the points and their clusters it is multiplied so much that constants "
            f"have an error of {loss:.0e}; evaluate nearer to the points, or choose a lower degree"
        )
    return (
        f"constants have an error of {loss:.0e}, and of {at_sites:.0e} at the points; the kernel "
        "is too flat for points this close and data this rough, or a polynomial of the degree "
        "nearly vanishes at the points; choose a smaller scale, a rougher kernel, some smoothing "
        "or a lower degree"
    )


def error_of_increase(value: np.ndarray, more: np.ndarray, constants: np.ndarray) -> np.ndarray:
    """Largest relative error (m, v) of constants (k, v), added to the data of `more` (m, k v).

    It is not relative to the values (m, v), which may be rounding.
    """
    increase = more.reshape(len(value), *constants.shape) - value[:, None]
    return (np.abs(increase - constants) / np.abs(constants)).max(axis=1)


def loses_constants(method: Reconstruction, solve: Callable[[np.ndarray], Any]) -> bool:
    """Whether constants have errors of more than LOST / 100 in the box of the sites.

    These are found at some points of the box, for data of random signs: as `solve` gives their
    coefficients, also where rough data would be refused.
    """
    rng, points = np.random.default_rng(0), method.points
    signs = rng.choice([-1.0, 1.0], (len(points), 1))
    more = signs + method._data_of_one()[:, None] * CONSTANTS
    x = rng.uniform(points.min(axis=0), points.max(axis=0), (_SAMPLED, points.shape[1]))
    value, raised = (method._value_rows(x, solve(data)) for data in (signs, more))
    return bool(error_of_increase(value, raised, CONSTANTS[:, None]).max() > LOST / 100)


def error_of_weights(total: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Error of the sums of weights, which must be 1; the weights of the size are rounded, too."""
    return np.abs(total - 1.0) + EPS * size
