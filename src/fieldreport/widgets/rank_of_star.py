"""A vertex of triangles and the conic through its ring: the outer vertices at the start."""

from __future__ import annotations

from typing import Any

STARS = {
    4: [[0.9, 0.15], [0.1, 0.8], [-0.8, 0.3], [-0.3, -0.75]],
    5: [[0.85, -0.1], [-0.15, 0.85], [-0.95, -0.35], [-0.7, -0.7], [-0.4, -0.8]],
    6: [[0.85, -0.1], [-0.15, 0.85], [-1.0, -0.3], [-0.8, -0.6], [-0.6, -0.8], [-0.3, -1.0]],
}
"""The outer vertices around the origin, counter-clockwise, for each number of triangles."""


def data() -> dict[str, Any]:
    """Return the stars; none but the first has its vertices on a conic."""
    return {"stars": {str(n): points for n, points in STARS.items()}}
