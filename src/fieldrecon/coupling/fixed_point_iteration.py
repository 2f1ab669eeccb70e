"""Fixed-point iteration with relaxation, as for the alternation of two coupled solvers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid

DIVERGED = 1e8
"""Growth of the residual at which the iteration stops."""


@dataclass(frozen=True)
class FixedPoint:
    """The result of a fixed-point iteration.

    Attributes
    ----------
    value : (...) ndarray
        The last value.
    residuals : (k,) ndarray
        Norms of func(x) - x, the first at the start.
    converged : bool
        Whether the last residual is below the tolerance.
    """

    value: np.ndarray
    residuals: np.ndarray
    converged: bool

    @property
    def contraction(self) -> float:
        """Ratio of the last two residuals; zero if there is only one."""
        before, last = self.residuals[-2:] if len(self.residuals) > 1 else (1.0, 0.0)
        return float(last / before)


def fixed_point(
    func: Callable[[np.ndarray], np.ndarray],
    x0: ArrayLike,
    relaxation: float | None = None,
    *,
    initial_relaxation: float = 0.5,
    tol: float = 1e-10,
    maxiter: int = 100,
) -> FixedPoint:
    """Iterate x + ω (func(x) - x) to a fixed point of a function.

    The relaxation factor ω is fixed, or Aitken's, from the last two residuals r = func(x) - x,

        ω_k = -ω_{k-1} r_{k-1} · (r_k - r_{k-1}) / |r_k - r_{k-1}|²,

    which is the secant method in one variable. It finds the fixed point of an affine function of
    one variable in two steps, whether or not the plain iteration converges. For complex values
    a · b is Σ a conj(b), and ω is complex.

    Parameters
    ----------
    func : callable
        Takes an array and returns an array of the same shape.
    x0 : (...) array_like
        The first value, real or complex.
    relaxation : float, optional
        A fixed ω; 1 is the plain iteration. Without it, ω is Aitken's.
    initial_relaxation : float
        The first of Aitken's ω.
    tol : float
        Tolerance of the norm of the residual, relative to the first.
    maxiter : int
        Largest number of steps. The iteration also stops if it diverges.

    Returns
    -------
    FixedPoint

    Raises
    ------
    ValueError
        If x0 or a value of func is not finite, or func changes the shape.

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
    x = valid.as_numbers(x0, "x0").copy()
    omega: complex = initial_relaxation if relaxation is None else float(relaxation)
    residuals: list[float] = []
    before: np.ndarray | None = None
    while True:
        r = _residual(func, x)
        residuals.append(float(np.linalg.norm(r)))
        small = residuals[-1] <= tol * residuals[0]
        if small or len(residuals) > maxiter or residuals[-1] > DIVERGED * residuals[0]:
            return FixedPoint(x, np.array(residuals), small)
        if relaxation is None and before is not None:
            change = r - before
            squares = float((np.abs(change) ** 2).sum())
            if squares > 0:  # a residual that stays as it is does not show another factor
                omega *= -(before * change.conj()).sum() / squares
        x, before = x + omega * r, r


def _residual(func: Callable[[np.ndarray], np.ndarray], x: np.ndarray) -> np.ndarray:
    """Residual func(x) - x, of the shape of x."""
    value = valid.as_numbers(func(x), "func(x)")
    if value.shape != x.shape:
        raise ValueError(f"func(x) must have the shape {x.shape} of x; got {value.shape}")
    return value - x
