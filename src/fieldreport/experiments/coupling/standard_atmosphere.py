"""The standard atmosphere: temperature, pressure and density of the air at an altitude."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid

GRAVITY = 9.80665  # m/s²
GAS_CONSTANT = 287.05287  # of dry air, J/(kg K)
HEAT_RATIO = 1.4
SEA_LEVEL = (288.15, 101325.0)  # K, Pa
LAPSE = 0.0065  # of the troposphere, K/m
TROPOPAUSE, TOP = 11_000.0, 20_000.0  # m


@dataclass(frozen=True)
class Air:
    """Dry air at rest, an ideal gas.

    Attributes
    ----------
    temperature, pressure : float or ndarray
        In K and in Pa.

    Examples
    --------
    >>> air = Air(288.15, 101325.0)
    >>> round(air.density, 4), float(round(air.sound_speed, 2)), round(air.dynamic_pressure(0.5))
    (1.225, 340.29, 17732)
    """

    temperature: float | np.ndarray
    pressure: float | np.ndarray

    @property
    def density(self) -> float | np.ndarray:
        """Density p / (R T), in kg/m³."""
        return self.pressure / (GAS_CONSTANT * self.temperature)

    @property
    def sound_speed(self) -> float | np.ndarray:
        """Speed of sound √(γ R T), in m/s."""
        return np.sqrt(HEAT_RATIO * GAS_CONSTANT * self.temperature)

    def dynamic_pressure(self, mach: float) -> float | np.ndarray:
        """Dynamic pressure ρ U² / 2 = γ p M² / 2 at the Mach number M, in Pa."""
        return HEAT_RATIO / 2 * self.pressure * mach**2


def standard_atmosphere(height: ArrayLike) -> Air:
    """Air at a height, or at each of several, in the standard atmosphere.

    Up to 11 km the temperature falls by 6.5 K per km, and p = p_0 (T / T_0)^(g / (R L)); above it
    stays, and p falls exponentially.

    Parameters
    ----------
    height : (...) array_like
        Geopotential height above the sea, in m, up to 20 km.

    Returns
    -------
    Air
        Its temperature and pressure have the shape of the heights.

    Raises
    ------
    ValueError
        If the height is below the sea or above 20 km.

    References
    ----------
    ISO 2533:1975, Standard Atmosphere.

    Examples
    --------
    >>> air = standard_atmosphere([0, 11_000])
    >>> air.temperature.round(2), air.pressure.round()
    (array([288.15, 216.65]), array([101325.,  22632.]))
    """
    h = valid.as_numbers(height, "height", complex_allowed=False)
    outside = h[(h < 0) | (h > TOP)]
    if outside.size:
        raise ValueError(f"height must lie between 0 and {TOP:g} m; got {outside[0]:g}")
    ground, pressure = SEA_LEVEL
    low = np.minimum(h, TROPOPAUSE)
    temperature = ground - LAPSE * low
    pressure *= (temperature / ground) ** (GRAVITY / (GAS_CONSTANT * LAPSE))
    return Air(
        temperature,
        pressure * np.exp(-GRAVITY * (h - low) / (GAS_CONSTANT * temperature)),
    )
