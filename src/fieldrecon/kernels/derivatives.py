"""Higher derivatives of radial kernels: phi_j(r) = ((1/r) d/dr)^j phi(r).

The gradient of phi(|x|) is phi_1 x, its Hessian phi_1 I + phi_2 x x^T, and so on. At r = 0, where
phi_j may be infinite, it is taken as zero: it is multiplied by factors x that vanish faster.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import gamma

from fieldrecon._numerics.jets import upper_pairs
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import (
    multiquadric,
    polyharmonic,
    thin_plate_spline,
)
from fieldrecon.kernels.positive_definite import gaussian, inverse_multiquadric, matern, wendland
from fieldrecon.kernels.weights import inverse_square


def smoothness(kernel: Radial) -> float:
    """Number of continuous derivatives of phi(|x|) at the origin."""
    match kernel:
        case thin_plate_spline():
            return 1
        case polyharmonic():
            return kernel.k - 1
        case matern():
            return math.ceil(2 * kernel.nu) - 1
        case wendland():
            return 2 * kernel.k
        case gaussian() | multiquadric() | inverse_multiquadric() | inverse_square():
            return math.inf
    raise ValueError(f"the higher derivatives of {kernel!r} are not known")


def radial_derivative(kernel: Radial, s: np.ndarray, times: int) -> np.ndarray:
    """Values of phi_j at s = r^2, j = `times`."""
    match kernel:
        case _ if times == 0:
            return kernel.of_squared(s)
        case gaussian():
            return (-2.0 / kernel.scale**2) ** times * kernel.of_squared(s)
        case multiquadric():
            return -_of_power(0.5, 1 + s / kernel.scale**2, times) / kernel.scale ** (2 * times)
        case inverse_multiquadric():
            return _of_power(-0.5, 1 + s / kernel.scale**2, times) / kernel.scale ** (2 * times)
        case inverse_square():
            return _of_power(-1.0, s + kernel.epsilon**2, times)
        case matern():
            return _of_bessel(kernel, s, times)
        case wendland():
            return _of_wendland(kernel, s, times)
        case thin_plate_spline():
            return 2 * radial_derivative(polyharmonic(2), s, times)
        case polyharmonic():
            return _of_half_powers(kernel, s, times)
    raise ValueError(f"the higher derivatives of {kernel!r} are not known")


def second_derivatives(kernel: Radial, offsets: list[np.ndarray]) -> tuple[np.ndarray, ...]:
    """Second derivatives of phi(|z|), phi_1 delta_kl + phi_2 z_k z_l, for k, l of `upper_pairs`.

    Parameters
    ----------
    kernel : Radial
        The function phi.
    offsets : list of d ndarrays
        The components of z.

    Returns
    -------
    tuple of d (d + 1)/2 ndarrays
        Of the shape of a component.
    """
    s = sum(z * z for z in offsets)
    first, second = (radial_derivative(kernel, s, times) for times in (1, 2))
    return tuple(
        second * offsets[k] * offsets[m] + (first if k == m else 0.0)
        for k, m in upper_pairs(len(offsets))
    )


def laplacian(kernel: Radial, s: np.ndarray, d: int) -> np.ndarray:
    """Laplacian d phi_1 + s phi_2 of phi(|x|) in d variables, at s = |x|^2."""
    return d * radial_derivative(kernel, s, 1) + s * radial_derivative(kernel, s, 2)


def log_square_bend(weight: Radial, r: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Factor psi_2 (m, k) in the second derivatives psi_1 I + psi_2 x x^T of log w(|x|)^2.

    psi_1 is `log_square_slope`, and psi_2 = 2 (phi_2/phi - (phi_1/phi)^2). It is zero where the
    relative weight w (m, k) is, and at a site of infinite weight, where x = 0.
    """
    with np.errstate(all="ignore"):
        value = weight(r)
        first, second = (radial_derivative(weight, r * r, times) / value for times in (1, 2))
        bend = 2 * (second - first**2)
    return np.where((w > 0) & np.isfinite(bend), bend, 0.0)


def _of_power(beta: float, base: np.ndarray, times: int) -> np.ndarray:
    """Of base^beta, where base is s and a constant: 2 beta (2 beta - 2) ... base^(beta - j)."""
    return math.prod(2 * (beta - i) for i in range(times)) * base ** (beta - times)


def _of_half_powers(kernel: polyharmonic, s: np.ndarray, times: int) -> np.ndarray:
    """Of r^k (a log r + b): r^(k-2) (k a log r + k b + a)."""
    logarithmic = kernel.k % 2 == 0
    one = float(kernel(1.0 if not logarithmic else math.e)) / (math.e**kernel.k) ** logarithmic
    a, b = (one, 0.0) if logarithmic else (0.0, one)
    for i in range(times):
        power = kernel.k - 2 * i
        a, b = power * a, power * b + a
    r = np.sqrt(np.where(s > 0, s, 1.0))
    return np.where(s > 0, r ** (kernel.k - 2.0 * times) * (a * np.log(r) + b), 0.0)


def _of_bessel(kernel: matern, s: np.ndarray, times: int) -> np.ndarray:
    """Of z^nu K_nu(z): (-1)^j z^(nu - j) K_(nu - j)(z)."""
    left = kernel.nu - times
    limit = 2.0**-times * gamma(left) / gamma(kernel.nu) if left > 0 else 0.0
    z = np.sqrt(s) / kernel.scale
    return (-1.0 / kernel.scale**2) ** times * kernel._bessel(left, z, at_zero=limit)


def _of_wendland(kernel: wendland, s: np.ndarray, times: int) -> np.ndarray:
    """Of phi_(d,k): a multiple of phi_(d+2,k-1); of phi_(d,0) = (1 - z)^l by the quotient rule."""
    if kernel.k > 0:
        lower = wendland(kernel.d + 2, kernel.k - 1, kernel.radius)
        return float(kernel.slope(0.0)) * radial_derivative(lower, s, times - 1)
    z = np.sqrt(s) / kernel.radius
    inside, power = (z > 0) & (z < 1), kernel.d // 2 + 1
    z = np.where(inside, z, 0.5)
    # (1 - z)^p z^-q descends to -p (1 - z)^(p-1) z^(-q-1) - q (1 - z)^p z^(-q-2)
    terms = {(power, 0): 1.0}
    for _ in range(times):
        below: dict[tuple[int, int], float] = {}
        for (p, q), c in terms.items():
            below[p - 1, q + 1] = below.get((p - 1, q + 1), 0.0) - p * c
            below[p, q + 2] = below.get((p, q + 2), 0.0) - q * c
        terms = {key: c for key, c in below.items() if c}
    total = sum(c * (1 - z) ** p / z**q for (p, q), c in terms.items())
    return np.where(inside, total, 0.0) / kernel.radius ** (2 * times)
