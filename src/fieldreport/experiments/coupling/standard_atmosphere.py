"""The standard atmosphere: temperature, pressure and density of the air at an altitude."""

from __future__ import annotations

import math
from dataclasses import dataclass

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
    temperature, pressure : float
        In K and in Pa.

    Examples
    --------
    >>> air = Air(288.15, 101325.0)
    >>> round(air.density, 4), round(air.sound_speed, 2), round(air.dynamic_pressure(0.5))
    (1.225, 340.29, 17732)
    """

    temperature: float
    pressure: float

    @property
    def density(self) -> float:
        """Density p / (R T), in kg/m³."""
        return self.pressure / (GAS_CONSTANT * self.temperature)

    @property
    def sound_speed(self) -> float:
        """Speed of sound √(γ R T), in m/s."""
        return math.sqrt(HEAT_RATIO * GAS_CONSTANT * self.temperature)

    def dynamic_pressure(self, mach: float) -> float:
        """Dynamic pressure ρ U² / 2 = γ p M² / 2 at the Mach number M, in Pa."""
        return HEAT_RATIO / 2 * self.pressure * mach**2


def standard_atmosphere(height: float) -> Air:
    """Air at a height in the standard atmosphere.

    Up to 11 km the temperature falls by 6.5 K per km, and p = p_0 (T / T_0)^(g / (R L)); above it
    stays, and p falls exponentially.

    Parameters
    ----------
    height : float
        Geopotential height above the sea, in m, up to 20 km.

    Raises
    ------
    ValueError
        If the height is below the sea or above 20 km.

    References
    ----------
    ISO 2533:1975, Standard Atmosphere.

    Examples
    --------
    >>> air = standard_atmosphere(11_000)
    >>> round(air.temperature, 2), round(air.pressure)
    (216.65, 22632)
    """
    if not 0 <= height <= TOP:
        raise ValueError(f"height must lie between 0 and {TOP:g} m; got {height!r}")
    ground, pressure = SEA_LEVEL
    low = min(height, TROPOPAUSE)
    temperature = ground - LAPSE * low
    pressure *= (temperature / ground) ** (GRAVITY / (GAS_CONSTANT * LAPSE))
    return Air(
        temperature,
        pressure * math.exp(-GRAVITY * (height - low) / (GAS_CONSTANT * temperature)),
    )
