"""Fixed points by repetition, plain or relaxed, as two solvers that take turns need them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid

HOPELESS = 1e8
"""A residual that has grown by this is given up."""


@dataclass(frozen=True)
class FixedPoint:
    """Where a repetition came to, and how.

    Attributes
    ----------
    value : (...) ndarray
        The last value.
    residuals : (k,) ndarray
        Norms of step(x) - x, the first at the start.
    converged : bool
        Whether the last is below the tolerance.
    """

    value: np.ndarray
    residuals: np.ndarray
    converged: bool

    @property
    def contraction(self) -> float:
        """Factor by which the last step changed the residual; zero if there was none."""
        before, last = self.residuals[-2:] if len(self.residuals) > 1 else (1.0, 0.0)
        return float(last / before)


def fixed_point(
    step: Callable[[np.ndarray], np.ndarray],
    start: ArrayLike,
    relaxation: float | None = None,
    first: float = 0.5,
    tolerance: float = 1e-10,
    most: int = 100,
) -> FixedPoint:
    """Repeat x + ω (step(x) - x) until nothing changes.

    With ω fixed; or after Aitken, from the last two residuals r = step(x) - x,

        ω_k = -ω_{k-1} r_{k-1} · (r_k - r_{k-1}) / |r_k - r_{k-1}|²,

    which is the secant method on a line, and finds the fixed point of an affine step on one at the
    second attempt, whether or not repetition alone would converge.

    Parameters
    ----------
    step : callable
        Takes and gives arrays of one shape.
    start : (...) array_like
        The first value.
    relaxation : float, optional
        A fixed ω; 1 repeats plainly. Without one, ω is Aitken's.
    first : float
        The first of Aitken's ω.
    tolerance : float
        Of the norm of the residual, relative to the first.
    most : int
        Steps after which it is given up, as it is when residuals have grown beyond hope.

    Returns
    -------
    FixedPoint

    References
    ----------
    Irons and Tuck (1969); Küttler and Wall (2008), for fluids and structures.

    Examples
    --------
    >>> fixed_point(lambda x: 3 - 2 * x, 0.0, relaxation=1.0).converged
    False
    >>> found = fixed_point(lambda x: 3 - 2 * x, 0.0)
    >>> round(float(found.value), 12), len(found.residuals)
    (1.0, 3)
    """
    x = np.array(start, dtype=float)
    omega = first if relaxation is None else float(relaxation)
    residuals: list[float] = []
    before: np.ndarray | None = None
    while True:
        r = valid.as_values([step(x)], 1, "step(x)")[0] - x
        residuals.append(float(np.linalg.norm(r)))
        small = residuals[-1] <= tolerance * residuals[0]
        if small or len(residuals) > most or residuals[-1] > HOPELESS * residuals[0]:
            return FixedPoint(x, np.array(residuals), small)
        if relaxation is None and before is not None:
            change = r - before
            omega *= -float((before * change).sum() / (change**2).sum())
        x, before = x + omega * r, r
