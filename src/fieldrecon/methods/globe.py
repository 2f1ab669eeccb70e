"""Fields on the globe: distances are chords in space, so the date line and the poles are regular.

A site at longitude l and latitude b is the unit vector (cos b cos l, cos b sin l, sin b). A kernel
of the distance in space is a kernel on the sphere, and positive definite if the former is;
its lengths are in radii of the sphere. Methods on such sites need polynomials of degree one at
most, since the squared distance from the centre is constant on the sphere.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress
from fieldrecon.methods.other_coordinates import OtherCoordinates
from fieldrecon.reconstruction import Reconstruction


def to_unit(lonlat: ArrayLike) -> np.ndarray:
    """Unit vectors (cos b cos l, cos b sin l, sin b) of longitudes l and latitudes b.

    Parameters
    ----------
    lonlat : (..., 2) array_like
        Longitude and latitude in degrees; longitudes may exceed a whole turn.

    Returns
    -------
    (..., 3) ndarray

    Raises
    ------
    ValueError
        If a latitude lies beyond a pole.

    Examples
    --------
    >>> to_unit([[0.0, 0.0], [180.0, 0.0], [17.0, 90.0]])
    array([[ 1.,  0.,  0.],
           [-1.,  0.,  0.],
           [ 0.,  0.,  1.]])
    """
    lon, lat = np.moveaxis(_as_lonlat(lonlat), -1, 0)
    cos_lon, sin_lon = _cos_sin(lon)
    cos_lat, sin_lat = _cos_sin(lat)
    return np.stack([cos_lat * cos_lon, cos_lat * sin_lon, sin_lat], axis=-1)


def principal(lonlat: ArrayLike) -> np.ndarray:
    """The same points with longitudes in [-180, 180), which are zero at the poles.

    Examples
    --------
    >>> principal([[190.0, 10.0], [180.0, 0.0], [17.0, -90.0]])
    array([[-170.,   10.],
           [-180.,    0.],
           [   0.,  -90.]])
    """
    lon, lat = np.moveaxis(_as_lonlat(lonlat), -1, 0)
    lon = np.where((lon >= -180) & (lon < 180), lon, (lon + 180) % 360 - 180)
    return np.stack([np.where(abs(lat) == 90, 0.0, lon), lat], axis=-1)


class OnGlobe(OtherCoordinates):
    """A method on the unit vectors of sites on the globe, evaluated at longitudes and latitudes.

    s(l, b) = t(u(l, b)) with u as in `to_unit`. The components of the gradient are the
    derivatives by a degree of longitude and by a degree of latitude, which are not lengths: the
    derivative by the distance to the east is (180 / (pi R cos b)) times the first, to the north
    (180 / (pi R)) times the second, with R the radius. The Hessian holds the second derivatives
    by degrees. The Laplacian is the Laplace-Beltrami operator of the unit sphere; divide it by R^2.

    Parameters
    ----------
    points : (n, 2) array_like
        Longitudes and latitudes of the sites, in degrees.
    method : callable or Reconstruction
        Takes unit vectors (n, 3) to a method on them; or such a method, which is made again.
    executor, progress : optional
        Passed on to `method`.

    Attributes
    ----------
    method : Reconstruction
        The method on the unit vectors.

    References
    ----------
    Wendland, Scattered Data Approximation (2005), chapter 17; Fuselier and Wright, Scattered data
    interpolation on embedded submanifolds with restricted positive definite kernels (2012).

    Examples
    --------
    >>> import fieldrecon as fr
    >>> lonlat = [[0, 0], [120, 10], [-100, 20], [170, -40], [-10, 85], [60, -70]]
    >>> s = OnGlobe(lonlat, lambda u: fr.RBF(u, fr.polyharmonic(3))).field([1, 2, 3, 4, 5, 6])
    >>> s([[-190.0, -40.0], [480.0, 10.0]]).round(9)
    array([4., 2.])
    """

    def __init__(
        self,
        points: ArrayLike,
        method: Callable[..., Reconstruction] | Reconstruction,
        *,
        executor: Executor | None = None,
        progress: Progress | None = None,
    ) -> None:
        self.points = valid.as_points(points)
        self._make(method, executor, progress)

    def _transformed(self, x: np.ndarray) -> np.ndarray:
        return to_unit(x)

    def _slopes(self, x: np.ndarray) -> np.ndarray:
        """Derivatives of the unit vectors by a degree of longitude and of latitude."""
        (cos_lon, sin_lon), (cos_lat, sin_lat) = (_cos_sin(angle) for angle in x.T)
        east = [-cos_lat * sin_lon, cos_lat * cos_lon, np.zeros(len(x))]
        north = [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat]
        return np.radians(np.stack([np.stack(east, 1), np.stack(north, 1)], axis=2))

    def _curvatures(self, x: np.ndarray) -> np.ndarray:
        """Second derivatives of the unit vectors by degrees of longitude and latitude."""
        (cos_lon, sin_lon), (cos_lat, sin_lat) = (_cos_sin(angle) for angle in x.T)
        zero = np.zeros(len(x))
        east = np.stack([-cos_lat * cos_lon, -cos_lat * sin_lon, zero], axis=1)
        mixed = np.stack([sin_lat * sin_lon, -sin_lat * cos_lon, zero], axis=1)
        matrix = np.stack([east, mixed, mixed, -to_unit(x)], axis=2).reshape(-1, 3, 2, 2)
        return np.radians(1.0) ** 2 * matrix

    def _laplacian_rows(self, x: np.ndarray, prepared: object) -> np.ndarray:
        """That in space, less those of the radius: Lap t - u^T H u - 2 u . grad t."""
        u = to_unit(x)
        hessians = self.method._hessian_rows(u, prepared)
        along = np.einsum("mk,mvkl,ml->mv", u, hessians, u)
        slope = np.einsum("mk,mvk->mv", u, self.method._gradient_rows(u, prepared))
        return np.trace(hessians, axis1=2, axis2=3) - along - 2 * slope


def _cos_sin(degrees: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cosine and sine, exact at multiples of 90 degrees and the same after whole turns."""
    quarters = np.round(degrees / 90)
    rest = np.radians(degrees - 90 * quarters)
    cos, sin = np.cos(rest), np.sin(rest)
    turn = (quarters % 4).astype(int)
    return (
        np.choose(turn, [cos, -sin, -cos, sin]) + 0.0,
        np.choose(turn, [sin, cos, -sin, -cos]) + 0.0,
    )


def _as_lonlat(lonlat: ArrayLike) -> np.ndarray:
    lonlat = valid.as_queries(lonlat, 2, "lonlat")
    beyond = np.argwhere(abs(lonlat[..., 1]) > 90)
    if len(beyond):
        lon, lat = lonlat[tuple(beyond[0])]
        raise ValueError(
            f"latitudes must lie within ±90 degrees; got {lat:g} at longitude {lon:g}: are they "
            "swapped?"
        )
    return lonlat
