"""A real terrain: heights on a regular grid, and isolines as on a map."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from fieldrecon._core.extras import remedy
from fieldrecon._core.validation import as_count

_SAMPLE = "jacksboro_fault_dem.npz"

# The ellipsoid of WGS 84, in metres.
_EQUATORIAL_RADIUS = 6378137.0
_FLATTENING = 1 / 298.257223563


@dataclass(frozen=True)
class Terrain:
    """Heights at the nodes of a grid, in metres.

    Parameters
    ----------
    x, y : ndarray of shape (columns,) and (rows,)
        Metres to the east and to the north of the south-western node, increasing.
    height : ndarray of shape (rows, columns)
        ``height[i, j]`` is the height above the sea at ``(x[j], y[i])``: whole metres.
    """

    x: np.ndarray
    y: np.ndarray
    height: np.ndarray

    @property
    def points(self) -> np.ndarray:
        """The nodes (rows * columns, 2), in the order of ``height.ravel()``."""
        return np.stack(np.meshgrid(self.x, self.y), axis=-1).reshape(-1, 2)

    def isolines(self, spacing: int, apart: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Return points on the isolines of the heights k·spacing + ½ m, k an integer.

        The points are where an isoline crosses the edges of the grid, the height being linear
        along an edge. Heights are whole metres and levels lie half a metre off them, so that
        every crossing is a single point inside its edge: at a whole metre, an isoline would be
        the area of each flat piece of land, and would meet the same node along several edges.

        Parameters
        ----------
        spacing : int
            Difference of height between neighbouring isolines, whole metres.
        apart : float
            Least distance in metres of points on isolines of the same height: of two that are
            closer, the one found first is kept.

        Returns
        -------
        points : ndarray of shape (m, 2)
        heights : ndarray of shape (m,)
            The level on which each point lies.
        """
        as_count(spacing, "spacing", wanted="a whole number of metres, 1 or more")
        if not (np.isfinite(apart) and apart >= 0):
            raise ValueError(f"apart must be zero or a positive number of metres; got {apart!r}")
        nodes = self.points.reshape(*self.height.shape, 2)
        along_x = _crossings(nodes, self.height, spacing)
        along_y = _crossings(nodes.swapaxes(0, 1), self.height.T, spacing)
        points, levels = (np.concatenate(pair) for pair in zip(along_x, along_y, strict=True))
        stay = _thinned(points, levels, apart) if apart > 0 else slice(None)
        return points[stay], levels[stay]


def terrain() -> Terrain:
    """Read the elevation model of the Jacksboro fault, Tennessee, that comes with matplotlib.

    344 × 403 heights of the Shuttle Radar Topography Mission, three seconds of arc apart, about
    75 m × 92 m. Degrees are converted to metres by the radii of curvature of the ellipsoid at
    the middle latitude; over this map the scale along the parallels varies by ±0.2 %.

    The first row of the file is its northernmost and begins at the latitude that the file calls
    ``ymax``. Its ``ymin`` lies north of that, since the height of the map was added instead of
    subtracted, and is not used. So the highest cell falls on the summit of Cross
    Mountain (36.1983° N, 84.2306° W, 1077 m), and the map holds the town of Jacksboro.

    Raises
    ------
    ModuleNotFoundError
        If matplotlib is not installed.

    References
    ----------
    Farr et al., The Shuttle Radar Topography Mission, Reviews of Geophysics 45 (2007).
    """
    with np.load(_sample_path()) as file:
        height, dx, dy = file["elevation"], float(file["dx"]), float(file["dy"])
        north = float(file["ymax"])
    rows, columns = height.shape
    metres_east, metres_north = _metres_per_degree(north - dy * rows / 2)
    return Terrain(
        x=np.arange(columns) * dx * metres_east,
        y=np.arange(rows) * dy * metres_north,
        height=height[::-1].astype(np.float64),
    )


def _sample_path() -> Path:
    package = find_spec("matplotlib")
    if package is None or not package.submodule_search_locations:
        raise ModuleNotFoundError(
            f"the terrain is a file of matplotlib, and {remedy('matplotlib')}"
        )
    path = Path(package.submodule_search_locations[0], "mpl-data", "sample_data", _SAMPLE)
    if not path.is_file():
        raise FileNotFoundError(f"this matplotlib comes without the terrain: no file {path}")
    return path


def _metres_per_degree(latitude: float) -> tuple[float, float]:
    """Length of a degree in metres along the parallel and along the meridian."""
    e2 = _FLATTENING * (2 - _FLATTENING)
    phi = np.radians(latitude)
    w = np.sqrt(1 - e2 * np.sin(phi) ** 2)
    across_meridian, along_meridian = _EQUATORIAL_RADIUS / w, _EQUATORIAL_RADIUS * (1 - e2) / w**3
    return np.radians(across_meridian * np.cos(phi)), np.radians(along_meridian)


def _crossings(nodes: np.ndarray, height: np.ndarray, spacing: int) -> tuple[np.ndarray, ...]:
    """Points and levels at which the edges along the second axis cross the isolines."""
    a, b = height[:, :-1].ravel(), height[:, 1:].ravel()
    below_a, below_b = np.floor((a - 0.5) / spacing), np.floor((b - 0.5) / spacing)
    crossed = np.abs(below_b - below_a).astype(int)
    edge = np.repeat(np.arange(len(a)), crossed)
    rank = np.arange(len(edge)) - np.repeat(np.cumsum(crossed) - crossed, crossed)
    level = (np.minimum(below_a, below_b)[edge] + 1 + rank) * spacing + 0.5
    t = ((level - a[edge]) / (b[edge] - a[edge]))[:, None]
    p, q = nodes[:, :-1].reshape(-1, 2)[edge], nodes[:, 1:].reshape(-1, 2)[edge]
    return p + t * (q - p), level


def _thinned(points: np.ndarray, levels: np.ndarray, apart: float) -> np.ndarray:
    """Indices of the points that are kept; each precedes the closer points that it removes."""
    # As a third coordinate, the level separates the points of different isolines.
    ranks = np.unique(levels, return_inverse=True)[1]
    tree = cKDTree(np.column_stack([points, 2 * apart * ranks]))
    pairs = tree.query_pairs(apart, output_type="ndarray")
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    first = np.searchsorted(pairs[:, 0], np.arange(len(points) + 1))
    stays = np.ones(len(points), dtype=bool)
    for i in range(len(points)):
        if stays[i]:
            stays[pairs[first[i] : first[i + 1], 1]] = False
    return np.flatnonzero(stays)
