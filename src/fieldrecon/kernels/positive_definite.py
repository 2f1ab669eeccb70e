"""Positive definite radial functions, of order zero: kernels without polynomials, and weights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from scipy.special import gamma, kv

from fieldrecon._core.validation import as_count, as_length
from fieldrecon.kernels.base import OfDistance, Radial, Scaled, length_in_units


@dataclass(frozen=True)
class gaussian(Scaled):
    """Gaussian exp(-(r/scale)^2), positive definite in every dimension; also a weight.

    Parameters
    ----------
    scale : float
        A length.

    Examples
    --------
    >>> float(gaussian(0.5)(0.5).round(6))
    0.367879
    """

    scale: float

    def of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values exp(-(r / scale)^2)."""
        with np.errstate(over="ignore"):  # exp(-inf) is the limit
            return np.exp(-((r / self.scale) ** 2))

    def slope_of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values -2 phi / scale^2."""
        return -2.0 * self.of_distance(r) / self.scale / self.scale


@dataclass(frozen=True)
class inverse_multiquadric(Scaled):
    """Inverse multiquadric 1/sqrt(1 + (r/scale)^2), positive definite in every dimension.

    Parameters
    ----------
    scale : float
        A length.
    """

    scale: float

    def of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values 1 / sqrt(1 + (r/scale)^2)."""
        return 1.0 / np.hypot(1.0, r / self.scale)

    def slope_of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values -phi^3 / scale^2."""
        return -(self.of_distance(r) ** 3) / self.scale / self.scale


@dataclass(frozen=True)
class matern(OfDistance):
    """Matern kernel 2^(1-nu)/Gamma(nu) z^nu K_nu(z), z = r/scale, positive definite.

    nu = 1/2: exp(-z); 3/2: (1 + z) exp(-z); 5/2: (1 + z + z^2/3) exp(-z). From z = 697 on, where
    K_nu underflows, the value is zero instead of less than 1e-248.

    Parameters
    ----------
    nu : float
        Smoothness, positive, at most 40; the kernel has a gradient at a site if nu > 1/2.
    scale : float
        A length.

    References
    ----------
    Wendland (2005), theorem 6.13.

    Examples
    --------
    >>> bool(np.isclose(matern(1.5, 2.0)(2.0), 2 * np.exp(-1)))
    True
    """

    nu: float
    scale: float
    order = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "nu", as_length(self.nu, "nu"))
        if self.nu > 40:
            raise ValueError(f"nu must be at most 40; got {self.nu}: it is all but a gaussian")
        object.__setattr__(self, "scale", as_length(self.scale, "scale"))

    @property
    def differentiable(self) -> bool:
        """Smoother than exp(-r)."""
        return self.nu > 0.5

    def of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values by the modified Bessel function K_nu."""
        return self._bessel(self.nu, r / self.scale, at_zero=1.0)

    def slope_of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values from (z^nu K_nu)' = -z^nu K_(nu-1)."""
        limit = 1.0 / (2.0 * (self.nu - 1.0)) if self.nu > 1 else 0.0
        z = r / self.scale
        return -self._bessel(self.nu - 1.0, z, at_zero=limit) / self.scale / self.scale

    def _bessel(self, power: float, z: np.ndarray, at_zero: float) -> np.ndarray:
        # far out K_nu underflows before z^nu overflows, since z stays below this bound
        inside = np.where(z > 0, np.minimum(z, 800.0), 1.0)
        with np.errstate(over="ignore", invalid="ignore"):
            value = 2.0 ** (1.0 - self.nu) / gamma(self.nu) * inside**power * kv(power, inside)
        # where K_nu overflows, so near to zero, the limit is exact
        near = np.where(np.isnan(z), z, at_zero)
        return np.where((z > 0) & np.isfinite(value), value, near)

    def in_units(self, h: float) -> Radial:
        """The same kernel with scale / h."""
        return matern(self.nu, length_in_units(self.scale, h))


@dataclass(frozen=True)
class wendland(OfDistance):
    """Wendland's function phi_(d,k)(r/radius): compact support, C^(2k), order 0 up to R^d.

    (1 - z)^(l+k) p_k(z) for z = r/radius < 1, with l = floor(d/2) + k + 1 and phi(0) = 1. Positive
    definite in d and fewer variables; also a weight.

    Parameters
    ----------
    d : int
        Number of variables up to which the function is positive definite.
    k : int
        Smoothness: 0, 1, 2 or 3; k = 0 has no gradient at a site.
    radius : float
        Radius of the support, a length.

    References
    ----------
    Wendland (2005), theorem 9.13 and table 9.1.

    Examples
    --------
    >>> wendland(3, 1, 2.0)([0.0, 1.0, 2.0])  # (1 - z)^4 (4 z + 1)
    array([1.    , 0.1875, 0.    ])
    """

    d: int
    k: int
    radius: float = 1.0
    order = 0

    def __post_init__(self) -> None:
        as_count(self.d, "d")
        as_count(self.k, "k", 0, 3, "0, 1, 2 or 3")
        object.__setattr__(self, "radius", as_length(self.radius, "radius"))

    @property
    def support(self) -> float:
        """Radius."""
        return self.radius

    @property
    def differentiable(self) -> bool:
        """All but k = 0."""
        return self.k > 0

    @property
    def dimensions(self) -> int:
        """The odd number not below d: phi_(2,k) is phi_(3,k)."""
        return self.d // 2 * 2 + 1

    def of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values (1 - z)^(l+k) p(z)."""
        power, p = self._parts()
        z = np.minimum(r / self.radius, 1.0)
        return (1.0 - z) ** power * p(z)

    def slope_of_distance(self, r: np.ndarray) -> np.ndarray:
        """Values of phi'(r)/r, in which the factor z has been divided out."""
        power, p = self._parts()
        z = np.minimum(r / self.radius, 1.0)
        inside = np.where(z == 1.0, 0.0, (1.0 - z) ** (power - 1))
        derivative = Polynomial([1, -1]) * p.deriv() - power * p
        if self.k > 0:
            slope = inside * Polynomial(derivative.coef[1:])(z)
        else:
            slope = np.where(z != 0, inside * derivative(z) / np.where(z != 0, z, 1.0), 0.0)
        return slope / self.radius / self.radius

    def _parts(self) -> tuple[int, Polynomial]:
        a = self.d // 2 + self.k + 1
        p = (
            [1],
            [1, a + 1],
            [1, a + 2, (a * a + 4 * a + 3) / 3],
            [1, a + 3, (6 * a * a + 36 * a + 45) / 15, (a**3 + 9 * a * a + 23 * a + 15) / 15],
        )[self.k]
        return a + self.k, Polynomial(p)

    def in_units(self, h: float) -> Radial:
        """The same function with radius / h."""
        return wendland(self.d, self.k, length_in_units(self.radius, h))
