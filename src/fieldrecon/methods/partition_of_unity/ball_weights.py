"""Weights of patches: smooth functions that vanish outside their balls."""

from __future__ import annotations

import numpy as np

from fieldrecon._numerics.jets import rows_of_jet, upper_pairs

REACH = 0.8
"""A box is covered if all its sites are within this fraction of the radius from the centre."""
COVERED = 5e-3
"""The sum c of the weights of a level from which on the next level has no share.

It is less than the weight at REACH, so that the finest level has all of the share at each site.
"""


def bump(offset: np.ndarray, order: int = 0) -> np.ndarray:
    """Jet (c, p) of the weight (1 - r)^4 (4 r + 1) of Wendland (1995) at offsets (p, d).

    It is twice continuously differentiable, and so are the blended fields: its gradient is
    -20 (1 - r)^3 x, its Hessian -20 (1 - r)^3 I + 60 (1 - r)^2 x x^T / r.
    """
    d = offset.shape[1]
    r = np.sqrt(np.einsum("pd,pd->p", offset, offset))
    rest = 1.0 - r
    cubed = rest**3
    jet = np.empty((rows_of_jet(d, order), len(r)))
    jet[0] = cubed * rest * (4.0 * r + 1.0)
    if order > 0:
        jet[1 : 1 + d] = -20.0 * cubed * offset.T
    if order > 1:
        bend = 60.0 * rest**2 / np.where(r > 0, r, 1.0)
        for row, (k, j) in zip(jet[1 + d :], upper_pairs(d), strict=True):
            row[:] = bend * offset[:, k] * offset[:, j] - (20.0 * cubed if k == j else 0.0)
    return jet


def weights_of_balls(centers: np.ndarray, radii: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Weights (p, s) of balls (p,) at points x (p, s, d), before normalization."""
    away = (x - centers[:, None, :]) / radii[:, None, None]
    inside = np.einsum("psd,psd->ps", away, away) < 1
    weight = np.zeros(inside.shape)
    weight[inside] = bump(away[inside])[0]
    return weight
