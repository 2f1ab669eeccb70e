"""Weights of patches: smooth functions that vanish outside their balls."""

from __future__ import annotations

import numpy as np

REACH = 0.8
"""A box is covered if all its sites are within this fraction of the radius from the centre."""
COVERED = 5e-3
"""The sum c of the weights of a level from which on the next level has no share.

It is less than the weight at REACH, so that the finest level has all of the share at each site.
"""


def bump(offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weight (1 - r)^4 (4 r + 1) of Wendland (1995) at offsets (p, d), and its gradient by them.

    It is twice continuously differentiable, and so are the blended fields.
    """
    r = np.sqrt(np.einsum("pd,pd->p", offset, offset))
    rest = 1.0 - r
    cubed = rest**3
    return cubed * rest * (4.0 * r + 1.0), -20.0 * cubed[:, None] * offset


def weights_of_balls(centers: np.ndarray, radii: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Weights (p, s) of balls (p,) at points x (p, s, d), before normalisation."""
    away = (x - centers[:, None, :]) / radii[:, None, None]
    inside = np.einsum("psd,psd->ps", away, away) < 1
    weight = np.zeros(inside.shape)
    weight[inside] = bump(away[inside])[0]
    return weight
