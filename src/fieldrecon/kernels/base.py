"""Radial functions: what every kernel and every weight provides.

A kernel has the sign that makes its quadratic form positive: for distinct sites and every nonzero
lambda orthogonal to the polynomials of degree < `order`,
sum_jk lambda_j lambda_k phi(|x_j - x_k|) > 0.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core.validation import as_length, unmasked


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
        """Whether phi, as a function of the point, has a gradient at the origin."""
        return True

    @property
    def dimensions(self) -> float:
        """Number of variables up to which it has this order; infinity for all."""
        return math.inf

    def __call__(self, r: ArrayLike) -> np.ndarray:
        """Values phi(r), elementwise.

        They are right to rounding from r = 1e-300 to 1e300. Values beyond the range of numbers are
        infinite, and values below it are zero.
        """
        return self.of_distance(_as_distances(r))

    @abstractmethod
    def of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values phi(r) for s = r^2; evaluation calls it, since r^2 needs no square root."""

    def of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values phi(r) for r >= 0, overridden where r^2 has no place in the range of numbers."""
        return self.of_squared(r * r)

    def slope(self, r: ArrayLike) -> np.ndarray:
        """Values phi'(r)/r, so that the gradient of phi(|x|) is slope(|x|) x.

        At r = 0, where the gradient is zero but phi'(r)/r may have no limit, the value is finite.
        """
        return self.slope_of_distance(_as_distances(r))

    @abstractmethod
    def slope_of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values phi'(r)/r for s = r^2."""

    def slope_of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values phi'(r)/r for r >= 0."""
        return self.slope_of_squared(r * r)

    @abstractmethod
    def in_units(self, h: float) -> Radial:
        """The same function of r/h, lengths divided by h, up to the factor of `homogeneity`."""


def _as_distances(r: ArrayLike) -> np.ndarray:
    return np.abs(np.asarray(unmasked(r, "r"), dtype=np.float64))


def length_in_units(length: float, h: float) -> float:
    """Length / h, within bounds beyond which a length makes no difference."""
    return min(max(length / h, 1e-300), 1e300)


class OfDistance(Radial):
    """A radial function with a formula in r, not in r^2, whose square could overflow."""

    @abstractmethod
    def of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values phi(r) for r >= 0."""

    @abstractmethod
    def slope_of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values phi'(r)/r for r >= 0."""

    def of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values phi(r) for s = r^2."""
        return self.of_distance(np.sqrt(s))

    def slope_of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values phi'(r)/r for s = r^2."""
        return self.slope_of_distance(np.sqrt(s))


class Scaled(OfDistance):
    """A radial function of z = r / scale."""

    scale: float
    order = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "scale", as_length(self.scale, "scale"))

    def in_units(self, h: float) -> Radial:
        """The same function with scale / h."""
        return type(self)(length_in_units(self.scale, h))  # type: ignore[call-arg]
