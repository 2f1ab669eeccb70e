"""Radial functions of conditionally positive definite kernels, and the weight of the slides.

Each knows its order, its slope and its support; `positive_definite` has those of order zero.

A kernel has the sign that makes its quadratic form positive: for distinct sites and every nonzero
lambda orthogonal to the polynomials of degree < `order`,
sum_jk lambda_j lambda_k phi(|x_j - x_k|) > 0.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import xlogy

from fieldrecon._core.validation import as_length


class Radial(ABC):
    """A function phi(r) of the distance alone.

    Attributes
    ----------
    order : int
        Order m of conditional positive definiteness: with polynomials of degree m - 1 the
        interpolant is unique. Zero for a positive definite kernel.
    support : float
        Distance beyond which the function vanishes; infinity for none.
    homogeneity : int
        k if phi(h r) = h^k phi(r), all lengths changed alike, up to polynomials that the side
        conditions annihilate.
    differentiable : bool
        Whether x -> phi(|x|) has a gradient at the origin.
    dimensions : float
        Number of variables up to which it has this order; infinity for all.
    """

    order: int = 0
    homogeneity: ClassVar[int] = 0

    @property
    def support(self) -> float:
        """Distance beyond which the function vanishes."""
        return math.inf

    @property
    def differentiable(self) -> bool:
        """Whether x -> phi(|x|) has a gradient at the origin."""
        return True

    @property
    def dimensions(self) -> float:
        """Number of variables up to which it has this order; infinity for all."""
        return math.inf

    def __call__(self, r: ArrayLike) -> np.ndarray:
        """Values phi(r), elementwise."""
        r = np.asarray(r, dtype=np.float64)
        return self.of_squared(r * r)

    @abstractmethod
    def of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values phi(r) for s = r^2: what evaluation calls, since r^2 needs no square root."""

    def slope(self, r: ArrayLike) -> np.ndarray:
        """Values phi'(r)/r, so that the gradient of phi(|x|) is slope(|x|) x.

        At r = 0, where the gradient is zero but phi'(r)/r may have no limit, the value is finite.
        """
        r = np.asarray(r, dtype=np.float64)
        return self.slope_of_squared(r * r)

    @abstractmethod
    def slope_of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values phi'(r)/r for s = r^2."""

    @abstractmethod
    def in_units(self, h: float) -> Radial:
        """The same function of r/h, lengths divided by h, up to the factor of `homogeneity`."""


def length_in_units(length: float, h: float) -> float:
    """Length / h, kept a number: beyond these bounds a length makes no difference."""
    return min(max(length / h, 1e-300), 1e300)


class Scaled(Radial):
    """A radial function of z = r / scale."""

    scale: float
    order = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "scale", as_length(self.scale, "scale"))

    def in_units(self, h: float) -> Radial:
        """The same function with scale / h."""
        return type(self)(length_in_units(self.scale, h))  # type: ignore[call-arg]


@dataclass(frozen=True)
class thin_plate_spline(Radial):
    """Thin-plate spline r^2 log r^2, of order 2 in every dimension.

    In two variables its interpolant with linear polynomials has the least bending energy
    (Duchon 1977). In three variables it is still conditionally positive definite, but the kernel
    of least energy is `polyharmonic(1)` or `polyharmonic(3)`.

    References
    ----------
    Erleben, Field Reconstruction, p. 11 (there called w).

    Examples
    --------
    >>> thin_plate_spline()([1.0, 2.0]).round(6)
    array([0.      , 5.545177])
    """

    order = 2
    homogeneity = 2

    def of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values s log s."""
        # a shift by the least positive number makes 0 log 0 the limit 0 without a branch
        return s * np.log(s + np.finfo(np.float64).tiny)

    def slope_of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values 2 (1 + log s)."""
        return np.where(s > 0, 2.0 + 2.0 * np.log(np.where(s > 0, s, 1.0)), 0.0)

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
        if isinstance(self.k, bool) or not isinstance(self.k, int | np.integer) or self.k < 1:
            raise ValueError(f"k must be an integer, 1 or more; got {self.k!r}")

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

    def slope_of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values k r^(k-2), with log r + 1/k for even k."""
        if self.k % 2:
            root = np.sqrt(np.where(s > 0, s, 1.0))
            return np.where(s > 0, self._sign * self.k * s ** (self.k // 2) / root, 0.0)
        log = np.log(np.where(s > 0, s, 1.0)) / 2
        return np.where(s > 0, self._sign * s ** (self.k // 2 - 1) * (self.k * log + 1), 0.0)

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

    def of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values -sqrt(1 + s/scale^2)."""
        return -np.hypot(1.0, np.sqrt(s) / self.scale)

    def slope_of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values -1 / (scale^2 sqrt(1 + s/scale^2))."""
        return 1.0 / self.of_squared(s) / self.scale / self.scale


@dataclass(frozen=True)
class inverse_square(Radial):
    """The notes' weight 1/(r^2 + epsilon^2) of moving least squares.

    It enters squared, so a site counts by 1/(r^2 + epsilon^2)^2. With epsilon = 0 the
    reconstruction interpolates: the weight is infinite at a site, and the field has its limit.

    Parameters
    ----------
    epsilon : float
        A length, zero or positive.

    References
    ----------
    Erleben, Field Reconstruction, p. 9; Shen, O'Brien and Shewchuk (2004).

    Examples
    --------
    >>> float(inverse_square(1.0)(3.0))
    0.1
    """

    epsilon: float
    homogeneity: ClassVar[int] = -2

    def __post_init__(self) -> None:
        object.__setattr__(self, "epsilon", as_length(self.epsilon, "epsilon", zero_allowed=True))

    def of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values 1/(s + epsilon^2)."""
        with np.errstate(divide="ignore", over="ignore"):  # infinite at a site if epsilon is zero
            return 1.0 / (s + self.epsilon * self.epsilon)

    def slope_of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values -2/(s + epsilon^2)^2."""
        return -2.0 * self.of_squared(s) ** 2

    def in_units(self, h: float) -> Radial:
        """The same weight, up to the factor h^2, with epsilon / h."""
        # beyond this it is constant on sites of size h; its square must stay a number
        return inverse_square(min(self.epsilon / h, 1e70))
