"""Terrain from isolines in a window of the mountains: heights, points and the thin plate."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from fieldrecon.datasets.elevation import terrain
from fieldrecon.kernels.conditionally_positive_definite import thin_plate_spline
from fieldrecon.methods.rbf import RBF
from fieldreport.experiments.datasets.terrain import Params
from fieldreport.experiments.datasets.terrain_errors import windowed
from fieldreport.experiments.datasets.terrain_methods import coefficients, local_weights

WINDOW = (8500.0, 4500.0, 7000.0)
"""Western edge, southern edge and side, in metres."""
METRES = 1000.0
DIGITS = 4
"""Of coordinates in kilometres."""


def data() -> dict[str, Any]:
    """Return the terrain with its south-west corner at the origin, in kilometres."""
    params = Params()
    land = windowed(terrain(), WINDOW)
    points, heights = land.isolines(params.spacing, params.apart)
    corner = np.array([land.x[0], land.y[0]])
    points = np.round((points - corner) / METRES, DIGITS)
    steps = [round(float(np.diff(axis).mean()) / METRES, DIGITS + 2) for axis in (land.x, land.y)]
    lam, affine = RBF(points, thin_plate_spline()).coefficients(heights)
    return {
        "steps": steps,
        "columns": len(land.x),
        "heights": base64.b64encode(np.round(land.height).astype("<u2").tobytes()).decode(),
        "points": points.tolist(),
        "values": heights.tolist(),
        "spacing": params.spacing,
        "neighbors": {
            degree: _neighbors(points, land.height.shape, steps, degree) for degree in (1, 2)
        },
        "thinPlate": {"lambda": lam.tolist(), "affine": affine.tolist()},
    }


def cells(shape: tuple[int, int], steps: list[float]) -> np.ndarray:
    """Return the centres of all cells, row by row from the south."""
    y, x = (np.arange(count) for count in shape)
    return np.stack(np.meshgrid(x * steps[0], y * steps[1]), axis=-1).reshape(-1, 2)


def _neighbors(points: np.ndarray, shape: tuple[int, int], steps: list[float], degree: int) -> int:
    """Return the number of nearest points that determines the polynomial at every cell."""
    least = Params().per_coefficient * coefficients(degree)
    weights = local_weights(degree, least, points, cells(shape, steps))
    return int(np.diff(weights.indptr).max())
