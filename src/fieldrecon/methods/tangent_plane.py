"""Methods in the plane for a region of the globe: an equal-area projection about its middle.

The unit vectors of a region lie nearly in a plane of space, in which polynomials of degree two or
more are not determined, and patches in space are nearly flat. So such sites are projected to the
plane that touches the sphere at a pole p, by Lambert's azimuthal equal-area projection

    g_i(u) = sqrt(2 / (1 + u . p)) u . e_i

with an orthonormal basis e_1, e_2 of the plane. The distance from the pole is the chord in space.
At an angle c from the pole, lengths change by the factors cos(c/2) and 1 / cos(c/2): at 30 degrees,
by 3.5 %.
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

_OFF = 1e-6  # of the length of a unit vector: the digits of a file
_NEAREST = 1e-12  # least value of 1 + u . p: the antipode of the pole has no projection


class OnTangentPlane(OtherCoordinates):
    """A method in the plane, on projected unit vectors of a region: s(u) = t(g(u)).

    It is the method within `OnGlobe` for sites of one region; `fieldrecon.OnGlobe` evaluates it at
    longitudes and latitudes, with derivatives. Lengths are in radii of the globe.

    Parameters
    ----------
    points : (n, 3) array_like
        Unit vectors of the sites, as of `to_unit`.
    method : callable or Reconstruction
        Takes points (n, 2) of the plane to a method on them; or such a method, which is made again.
    pole : (3,) array_like, optional
        Unit vector of the middle of the region; the mean direction of the sites by default.
    executor, progress : optional
        Passed on to `method`.

    Attributes
    ----------
    method : Reconstruction
        The method in the plane.
    pole : (3,) ndarray

    Raises
    ------
    ValueError
        If the points or the pole are not unit vectors of space.

    References
    ----------
    Snyder, Map Projections: A Working Manual (1987), chapter 24.

    Examples
    --------
    >>> import fieldrecon as fr
    >>> lonlat = [[10, 50], [12, 50], [10, 52], [12, 52], [11, 51], [11.5, 50.2]]
    >>> quadratic = lambda p: fr.LeastSquares(p, degree=2)
    >>> s = fr.OnGlobe(lonlat, lambda u: OnTangentPlane(u, quadratic)).field([1, 2, 3, 4, 5, 6])
    >>> s([[12.0, 52.0], [371.0, 51.0]]).round(9)
    array([4., 5.])
    """

    def __init__(
        self,
        points: ArrayLike,
        method: Callable[..., Reconstruction] | Reconstruction,
        pole: ArrayLike | None = None,
        progress: Progress | None = None,
        *,
        executor: Executor | None = None,
    ) -> None:
        self.points = valid.as_points(points)
        if self.points.shape[1] != 3:
            raise ValueError(f"points must be unit vectors (n, 3); got {self.points.shape}")
        _require_units(self.points, "points")
        self.pole = mean_direction(self.points) if pole is None else _as_pole(pole)
        self._make(method, executor, progress)

    def _transformed(self, x: np.ndarray) -> np.ndarray:
        return in_tangent_plane(x, self.pole)

    def _slopes(self, x: np.ndarray) -> np.ndarray:
        """Derivatives of the projection in space: k' (u . e_i) p + k e_i."""
        basis, (k, first, _) = _basis(self.pole), _scale(x @ self.pole)
        along = np.einsum("m,mi,k->mik", first, x @ basis.T, self.pole)
        return along + k[:, None, None] * basis

    def _curvatures(self, x: np.ndarray) -> np.ndarray:
        """Second derivatives: k'' (u . e_i) p p^T + k' (p e_i^T + e_i p^T)."""
        pole, basis, (_, first, second) = self.pole, _basis(self.pole), _scale(x @ self.pole)
        pairs = np.einsum("k,il->ikl", pole, basis)
        along = np.einsum("m,mi,k,l->mikl", second, x @ basis.T, pole, pole)
        return along + first[:, None, None, None] * (pairs + pairs.swapaxes(1, 2))


def _as_pole(pole: ArrayLike) -> np.ndarray:
    """Validate the unit vector of a pole."""
    p = valid.as_queries(pole, 3, "pole")
    if p.shape != (3,):
        raise ValueError(f"pole must be one unit vector (3,); got the shape {p.shape}")
    _require_units(p[None], "pole")
    return p


def _require_units(u: np.ndarray, name: str) -> None:
    """Refuse vectors (n, 3) that are not of length one: their projections mean nothing."""
    length = np.linalg.norm(u, axis=1)
    worst = int(np.argmax(np.abs(length - 1)))
    if not abs(length[worst] - 1) <= _OFF:
        raise ValueError(
            f"{name} must be of length one, as by to_unit; ({valid.format_point(u[worst])}) is of "
            f"length {length[worst]:.6g}"
        )


def mean_direction(points: np.ndarray) -> np.ndarray:
    """Unit vector of the mean of unit vectors (n, 3)."""
    mean = points.mean(axis=0)
    return mean / max(np.linalg.norm(mean), np.finfo(float).tiny)


def in_tangent_plane(points: np.ndarray, pole: np.ndarray) -> np.ndarray:
    """Projections (n, 2) of unit vectors (n, 3)."""
    k, _, _ = _scale(points @ pole)
    return k[:, None] * (points @ _basis(pole).T)


def _scale(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The factor k = sqrt(2 / (1 + t)) of t = u . p, and its first two derivatives."""
    rest = np.maximum(1 + t, _NEAREST)
    k = np.sqrt(2 / rest)
    return k, -k / (2 * rest), 3 * k / (4 * rest**2)


def _basis(pole: np.ndarray) -> np.ndarray:
    """To the east and to the north (2, 3) at the pole; any directions at a pole of the Earth."""
    east = np.array([-pole[1], pole[0], 0.0])
    length = np.linalg.norm(east)
    east = east / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    return np.stack([east, np.cross(pole, east)])
