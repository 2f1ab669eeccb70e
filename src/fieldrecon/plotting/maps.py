"""Maps: shaded relief, equal scales, a scale bar."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LightSource
from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar

SHADE = "Greys_r"
"""Colour map of a shaded relief."""

SUN_AZIMUTH = 315.0
SUN_ALTITUDE = 45.0
"""Degrees, clockwise from north and above the horizon: light from the upper left, as on maps."""


def hillshade(
    heights: np.ndarray, cell_x: float, cell_y: float, exaggeration: float = 1.0
) -> np.ndarray:
    """Brightness of a surface lit from the upper left (Lambert), stretched to fill [0, 1].

    Parameters
    ----------
    heights : ndarray, shape (rows, columns)
        ``heights[i, j]`` lies at ``(j * cell_x, i * cell_y)``: x to the east, y to the north.
    cell_x, cell_y : float
        Size of a cell in the unit of the heights.
    exaggeration : float
        Factor on the heights.

    Returns
    -------
    ndarray, shape (rows, columns)

    Examples
    --------
    >>> flat = hillshade(np.zeros((3, 3)), 1.0, 1.0)
    >>> bool(np.ptp(flat) == 0)
    True
    """
    sun = LightSource(azdeg=SUN_AZIMUTH, altdeg=SUN_ALTITUDE)
    # Matplotlib counts rows downward; here they run north
    return sun.hillshade(heights, vert_exag=exaggeration, dx=cell_x, dy=-cell_y, fraction=1.0)


def map_axes(axes: Axes, title: str = "") -> None:
    """Make axes in metres a map: equal scales, no ticks, a frame and a scale bar."""
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[:].set_visible(True)
    if title:
        axes.set_title(title)
    scale_bar(axes)


def scale_bar(axes: Axes, location: str = "lower right") -> None:
    """Add a bar of a round length, about a quarter of the width, to axes in metres."""
    left, right = sorted(axes.get_xlim())
    metres = round_length((right - left) / 4)
    label = f"{metres / 1000:g} km" if metres >= 1000 else f"{metres:g} m"
    bar = AnchoredSizeBar(
        axes.transData,
        metres,
        label,
        location,
        pad=0.3,
        borderpad=0.4,
        sep=2,
        size_vertical=(right - left) / 150,
        fill_bar=True,
        color="black",
    )
    bar.patch.set(facecolor="white", edgecolor="none", alpha=0.8)
    axes.add_artist(bar)


def round_length(length: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is not above `length`.

    Examples
    --------
    >>> [round_length(x) for x in (0.3, 7.0, 10.0, 2400.0)]
    [0.2, 5.0, 10.0, 2000.0]
    """
    power = np.floor(np.log10(length))
    steps = [float(f"{step}e{power:.0f}") for step in (1, 2, 5)]
    return max(step for step in steps if step <= length * (1 + 1e-9))
