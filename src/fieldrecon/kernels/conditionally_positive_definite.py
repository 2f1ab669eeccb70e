"""Conditionally positive definite kernels: thin-plate and polyharmonic splines, the multiquadric.

A kernel of order m determines a unique interpolant together with polynomials of degree m - 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import xlogy

from fieldrecon._core.validation import as_count
from fieldrecon.kernels.base import Radial, Scaled


@dataclass(frozen=True)
class thin_plate_spline(Radial):
    """Thin-plate spline r^2 log r^2, of order 2 in every dimension.

    In two variables its interpolant with linear polynomials has the least bending energy
    (Duchon 1977). In three variables it is still conditionally positive definite, but the kernel
    of least energy is `polyharmonic(1)` or `polyharmonic(3)`.

    References
    ----------
    Erleben, Field Reconstruction, p. 11 (called w there).

    Examples
    --------
    >>> thin_plate_spline()([1.0, 2.0]).round(6)
    array([0.      , 5.545177])
    """

    order = 2
    homogeneity = 2

    def of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values s log s."""
        # the least number with all digits makes 0 log 0 the limit 0 without a branch
        return s * np.log(np.maximum(s, np.finfo(np.float64).tiny))

    def of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values 2 r^2 log r, with all digits also where r^2 is too small for them."""
        return 2.0 * r * xlogy(r, r)

    def slope_of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values 2 (1 + log s)."""
        return np.where(s != 0, 2.0 + 2.0 * np.log(np.where(s != 0, s, 1.0)), 0.0)

    def slope_of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values 2 (1 + 2 log r)."""
        return np.where(r != 0, 2.0 + 4.0 * np.log(np.where(r != 0, r, 1.0)), 0.0)

    def in_units(self, h: float) -> Radial:  # noqa: ARG002 - it has no length
        """The same function: it has no length parameter."""
        return self


@dataclass(frozen=True)
class polyharmonic(Radial):
    """Polyharmonic spline of power k, of order floor(k/2) + 1.

    (-1)^ceil(k/2) r^k for odd k, (-1)^(k/2+1) r^k log r for even k.

    Parameters
    ----------
    k : int
        Power, 1 or more. k = 1 has no gradient at a site.

    References
    ----------
    Wendland, Scattered Data Approximation (2005), theorems 8.16 and 8.17.

    Examples
    --------
    >>> polyharmonic(3).order, float(polyharmonic(3)(2.0)), float(polyharmonic(1)(2.0))
    (2, 8.0, -2.0)
    """

    k: int

    def __post_init__(self) -> None:
        as_count(self.k, "k")

    @property
    def order(self) -> int:  # type: ignore[override]
        """Order floor(k/2) + 1."""
        return self.k // 2 + 1

    @property
    def homogeneity(self) -> int:  # type: ignore[override]
        """Power k."""
        return self.k

    @property
    def differentiable(self) -> bool:
        """All but k = 1."""
        return self.k > 1

    @property
    def _sign(self) -> int:
        return -1 if ((self.k + 1) // 2 + (self.k % 2 == 0)) % 2 else 1

    def of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values by half powers of s."""
        if self.k % 2:
            value = np.sqrt(s)
            for _ in range(self.k // 2):
                value *= s
            return value if self._sign > 0 else -value
        return self._sign * s ** (self.k // 2 - 1) * xlogy(s, s) / 2

    def of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values r^k or r^k log r."""
        return self._sign * (r**self.k if self.k % 2 else r ** (self.k - 1) * xlogy(r, r))

    def slope_of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values k r^(k-2), with log r + 1/k for even k."""
        if self.k % 2:
            root = np.sqrt(np.where(s != 0, s, 1.0))
            return np.where(s != 0, self._sign * self.k * s ** (self.k // 2) / root, 0.0)
        log = np.log(np.where(s != 0, s, 1.0)) / 2
        return np.where(s != 0, self._sign * s ** (self.k // 2 - 1) * (self.k * log + 1), 0.0)

    def slope_of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values k r^(k-2), with log r + 1/k for even k."""
        r, there = np.where(r != 0, r, 1.0), r != 0
        factor = self.k if self.k % 2 else self.k * np.log(r) + 1
        return np.where(there, self._sign * r ** (self.k - 2.0) * factor, 0.0)

    def in_units(self, h: float) -> Radial:  # noqa: ARG002 - it has no length
        """The same function: it has no length parameter."""
        return self


@dataclass(frozen=True)
class multiquadric(Scaled):
    """Hardy's multiquadric -sqrt(1 + (r/scale)^2), of order 1.

    Parameters
    ----------
    scale : float
        A length.

    References
    ----------
    Wendland (2005), theorem 8.15; Micchelli (1986).
    """

    scale: float
    order = 1

    def of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values -sqrt(1 + (r/scale)^2)."""
        return -np.hypot(1.0, r / self.scale)

    def slope_of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values -1 / (scale^2 sqrt(1 + (r/scale)^2))."""
        return 1.0 / self.of_distance(r) / self.scale / self.scale
