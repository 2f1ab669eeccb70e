"""The velocity of one triangle from the normal velocities of its sides: its corners at first."""

from __future__ import annotations

from typing import Any


def data() -> dict[str, Any]:
    """Return the corners in counter-clockwise order, with coordinates between -1 and 1."""
    return {"corners": [[-0.8, -0.65], [1.0, -0.4], [-0.65, 0.6]]}
