"""Voronoi coordinates in a star of six triangles: a regular hexagon, rotated."""

from __future__ import annotations

from typing import Any

import numpy as np

from fieldreport.experiments.barycentric.hexagon_spiral import hexagon

DIGITS = 6
TURN = 20.0
"""Degrees; with an edge along an axis the quotient would not lose its digits."""


def data() -> dict[str, Any]:
    """Return the outer vertices, counter-clockwise."""
    spokes = hexagon(TURN).spokes
    around = np.argsort(np.arctan2(*spokes.T[::-1]))
    return {"corners": (np.round(spokes[around], DIGITS) + 0.0).tolist()}
