"""Projection of values onto bounds and a total mass."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq


def project_to_bounds_and_mass(
    values: np.ndarray, low: np.ndarray, high: np.ndarray, masses: np.ndarray, total: np.ndarray
) -> np.ndarray:
    """Return the nearest values (n, v) within bounds (n, v) that have the total masses (v,).

    The minimum of sum m (u - values)^2 is u = clip(values + λ, low, high) with one λ for each
    column. Its mass increases with λ, which is found by bracketing.
    """
    columns = [
        _project_column(u, least, most, masses, float(wanted))
        for u, least, most, wanted in zip(values.T, low.T, high.T, total, strict=True)
    ]
    return np.stack(columns, axis=1) if columns else values


def _project_column(
    u: np.ndarray, low: np.ndarray, high: np.ndarray, masses: np.ndarray, total: float
) -> np.ndarray:
    if not np.isfinite(low).any():  # no bounds
        return u + (total - masses @ u) / masses.sum()

    def excess(shift: float) -> float:
        return float(masses @ np.clip(u + shift, low, high)) - total

    least, most = float((low - u).min()), float((high - u).max())
    rounding = 1e-12 * float(masses @ np.maximum(np.abs(low), np.abs(high)))
    if excess(least) > rounding or excess(most) < -rounding:
        raise ValueError(
            f"masses times values cannot be {total:.6g} within the bounds of neighbouring values, "
            f"which allow {masses @ low:.6g} to {masses @ high:.6g}"
        )
    if excess(least) >= 0 or excess(most) <= 0:
        return low if excess(least) >= 0 else high
    shift = brentq(excess, least, most, xtol=1e-15 * max(abs(least), abs(most)))
    return np.clip(u + shift, low, high)
