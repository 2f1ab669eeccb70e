"""A picture of the surface of a scan, from two sides."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from fieldrecon.plotting.style import FULL_WIDTH, figure
from fieldrecon.solids.rasterization import rasterized
from fieldrecon.solids.ray_casting import OUTSIDE, View

if TYPE_CHECKING:
    from fieldrecon.pipelines.scans import ScanResult

_PIXELS = 340
_MARGIN = 0.5
"""Inches for titles and legend."""
_INVENTED = "#d98a3d"
_VIEWS = {"from the front": (0.35, -0.9, 0.25), "from behind": (-0.6, 0.75, 0.3)}
"""Directions to the viewer: to the right, backward and up, if z is up."""


def plot(scan: ScanResult, up: Sequence[float]) -> Figure:
    """Draw the mesh from two sides; it is coloured where it is far from all points."""
    mesh = scan.mesh
    margin = 2 * mesh.spacing
    box = [mesh.points.min(axis=0) - margin, mesh.points.max(axis=0) + margin]
    color = np.where(scan.gaps[:, None], to_rgb(_INVENTED), OUTSIDE)
    images = {
        title: rasterized(
            mesh.points,
            mesh.triangles,
            View.of_box(box, _rotated(toward, up), _PIXELS, up),
            color,
        )
        for title, toward in _VIEWS.items()
    }
    tallest = max(image.shape[0] / image.shape[1] for image in images.values())
    with figure(height=FULL_WIDTH / 2 * tallest + _MARGIN, columns=2) as (drawn, axes):
        for panel, (title, image) in zip(axes, images.items(), strict=True):
            panel.imshow(image, origin="lower", interpolation="antialiased")
            panel.set_title(title, loc="center")
            panel.set_axis_off()
            panel.set_anchor("N")
        if scan.gaps.any():
            handle = Patch(color=_INVENTED, label="far from all points: invented")
            drawn.legend(handles=[handle], loc="outside lower center")
    return drawn


def _rotated(toward: Sequence[float], up: Sequence[float]) -> np.ndarray:
    """Permute the components of a direction that is given for z up."""
    axis = int(np.argmax(up))
    return np.roll(toward, axis - 2)
