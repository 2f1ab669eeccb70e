"""Radial functions as weights of local least-squares fits, and the weight of the slides."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fieldrecon._core.validation import as_length
from fieldrecon.kernels.base import Radial

# A weight this much above those at the size of the cloud stands for infinity: the difference is far
# below rounding, and its square and the inverse of that are still numbers.
_INFINITE = 1e120


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

    def of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values 1/(r^2 + epsilon^2), also those below 5e-309, where r^2 overflows."""
        try:
            with np.errstate(over="raise"):
                s = r * r
        except FloatingPointError:
            h = np.hypot(r, self.epsilon)
            with np.errstate(divide="ignore", over="ignore"):
                return 1.0 / h / h
        return self.of_squared(s)

    def slope_of_squared(self, s: np.ndarray) -> np.ndarray:
        """Values -2/(s + epsilon^2)^2."""
        return -2.0 * self.of_squared(s) ** 2

    def slope_of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values -2/(r^2 + epsilon^2)^2, zero where r^2 overflows."""
        with np.errstate(over="ignore"):
            s = r * r
        return self.slope_of_squared(s)

    def in_units(self, h: float) -> Radial:
        """The same weight, up to the factor h^2, with epsilon / h."""
        # beyond this it is constant on sites of size h; its square must stay a number
        return inverse_square(min(self.epsilon / h, 1e70))


def as_weight(weight: Radial) -> Radial:
    """Require a weight function, which is positive and falls with the distance."""
    if not isinstance(weight, Radial):
        raise ValueError(
            f"weight must be a radial function such as inverse_square(0.1); got {weight!r}"
        )
    if weight.order > 0 or weight.homogeneity > 0:
        raise ValueError(f"weight must be positive and fall with the distance; {weight!r} does not")
    return weight


def relative_weights(weight: Radial, r: np.ndarray, there: np.ndarray) -> np.ndarray:
    """Weights (m, k) of sites at distances r, the largest of each row one; zero where none is."""
    with np.errstate(all="ignore"):  # a weight may vanish, or be infinite at a distance of zero
        w = np.minimum(weight(r), _INFINITE)
    w[~there] = 0.0
    top = w.max(axis=1, initial=0.0)
    w /= np.where(top > 0, top, 1.0)[:, None]
    return w


def log_square_slope(weight: Radial, r: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Slope 2 w'(r) / (r w(r)) (m, k), by which x is multiplied in the gradient of log w(|x|)^2.

    It is zero where the relative weight w (m, k) is, and at a site of infinite weight, where x = 0.
    """
    with np.errstate(all="ignore"):
        slope = 2 * weight.slope(r) / weight(r)
    return np.where((w > 0) & np.isfinite(slope), slope, 0.0)
