"""A picture of a mesh from two sides, with its errors marked."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fieldrecon.plotting.mesh_pictures import COLORS, MARKERS, draw, marks
from fieldrecon.plotting.style import figure
from fieldrecon.triangles.audit import CONCERNS, MeshAudit

_PIXELS = 800
_VIEWS = {
    "from the front, right and above": (0.8, -0.7, 0.6),
    "from behind, left and below": (-0.8, 0.7, -0.6),
}


def plot(audit: MeshAudit, points: np.ndarray, triangles: np.ndarray) -> Figure:
    """Draw the mesh from two sides with each error marked; hidden errors are faint."""
    found = marks(audit, triangles)
    with figure(height=3.6, columns=2) as (page, axes):
        for panel, (title, toward) in zip(axes, _VIEWS.items(), strict=True):
            draw(panel, points, triangles, found, np.array(toward), pixels=_PIXELS)
            panel.set_title(title, loc="center")
        handles = [
            Line2D(
                [],
                [],
                color=COLORS[concern],
                marker=MARKERS[concern],
                label=f"{concern}: {sum(audit.counts[concern].values())}",
            )
            for concern in CONCERNS
            if any(audit.counts[concern].values())
        ]
        if handles:
            page.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return page
