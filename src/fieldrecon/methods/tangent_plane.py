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
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress
from fieldrecon.reconstruction import Field, Reconstruction, Weights

_NEAREST = 1e-12  # least value of 1 + u . p: the antipode of the pole has no projection


class OnTangentPlane(Reconstruction):
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
    progress : callable, optional
        Passed on to `method`.

    Attributes
    ----------
    method : Reconstruction
        The method in the plane.
    pole : (3,) ndarray

    Raises
    ------
    ValueError
        If the points are not in space.

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
    ) -> None:
        self.points = valid.as_points(points)
        if self.points.shape[1] != 3:
            raise ValueError(f"points must be unit vectors (n, 3); got {self.points.shape}")
        self.pole = (
            mean_direction(self.points) if pole is None else valid.as_queries(pole, 3, "pole")
        )
        if isinstance(method, Reconstruction):
            method = partial(method._made, **method._arguments())
        how = {} if progress is None else {"progress": progress}
        self.method = method(in_tangent_plane(self.points, self.pole), **how)
        self.degree = min(self.method.degree, 0)
        self.interpolates = self.method.interpolates

    def field(self, values: ArrayLike, **how: Any) -> Field:
        """Field of these data, as the method in the plane makes it.

        Parameters
        ----------
        values : (n, ...) array_like
            One real or complex scalar, vector or array for each site.
        **how
            Further arguments of the method's own `field`, such as `executor` and `progress`.
        """
        values = valid.as_values(values, len(self.points))
        return Field(self, values, lambda columns: self.method.field(columns, **how)._prepared)

    def _leave_one_out(self, values: np.ndarray, progress: Progress | None) -> np.ndarray:
        return self.method._leave_one_out(values, progress)

    @property
    def _has_sparse_weights(self) -> bool:
        return self.method._has_sparse_weights

    def _project(self, x: np.ndarray) -> np.ndarray:
        return in_tangent_plane(x, self.pole)

    def _weight_rows(self, x: np.ndarray) -> Weights:
        return self.method._weight_rows(self._project(x))

    def _gradient_weight_rows(self, x: np.ndarray) -> tuple[Weights, ...]:
        first, second = self.method._gradient_weight_rows(self._project(x))
        slopes = _slopes(x, self.pole)
        return tuple(
            sparse.diags_array(slopes[:, 0, k]) @ first
            + sparse.diags_array(slopes[:, 1, k]) @ second
            for k in range(3)
        )

    def _prepare(self, values: np.ndarray) -> object:
        return self.method._prepare(values)

    def _value_rows(self, x: np.ndarray, prepared: object) -> np.ndarray:
        return self.method._value_rows(self._project(x), prepared)

    def _gradient_rows(self, x: np.ndarray, prepared: object) -> np.ndarray:
        gradients = self.method._gradient_rows(self._project(x), prepared)
        return np.einsum("mvi,mik->mvk", gradients, _slopes(x, self.pole))

    def _hessian_rows(self, x: np.ndarray, prepared: object) -> np.ndarray:
        flat, slopes = self._project(x), _slopes(x, self.pole)
        gradients = self.method._gradient_rows(flat, prepared)
        hessians = self.method._hessian_rows(flat, prepared)
        bent = np.einsum("mik,mvij,mjl->mvkl", slopes, hessians, slopes)
        return bent + np.einsum("mvi,mikl->mvkl", gradients, _curvatures(x, self.pole))

    def _adjoint(
        self,
        x: np.ndarray,
        f: np.ndarray,
        executor: Executor | None,
        progress: Progress | None,
    ) -> np.ndarray:
        return self.method._adjoint(self._project(x), f, executor, progress)

    def _order(self, x: np.ndarray) -> np.ndarray | None:
        return self.method._order(self._project(x))

    def _chunk_rows(self, columns: int) -> int:
        return self.method._chunk_rows(columns)

    def _weight_chunk_rows(self) -> int:
        return self.method._weight_chunk_rows()


def mean_direction(points: np.ndarray) -> np.ndarray:
    """Unit vector of the mean of unit vectors (n, 3)."""
    mean = points.mean(axis=0)
    return mean / max(np.linalg.norm(mean), np.finfo(float).tiny)


def in_tangent_plane(points: np.ndarray, pole: np.ndarray) -> np.ndarray:
    """Projections (n, 2) of unit vectors (n, 3)."""
    return _scale(points @ pole)[:, None] * (points @ _basis(pole).T)


def _scale(t: np.ndarray) -> np.ndarray:
    return np.sqrt(2 / np.maximum(1 + t, _NEAREST))


def _basis(pole: np.ndarray) -> np.ndarray:
    """To the east and to the north (2, 3) at the pole; any directions at a pole of the Earth."""
    east = np.array([-pole[1], pole[0], 0.0])
    length = np.linalg.norm(east)
    east = east / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    return np.stack([east, np.cross(pole, east)])


def _slopes(x: np.ndarray, pole: np.ndarray) -> np.ndarray:
    """Derivatives (m, 2, 3) of the projection in space: k' (u . e_i) p + k e_i."""
    basis, t = _basis(pole), x @ pole
    k = _scale(t)
    first = -k / (2 * np.maximum(1 + t, _NEAREST))
    along = np.einsum("m,mi,k->mik", first, x @ basis.T, pole)
    return along + k[:, None, None] * basis


def _curvatures(x: np.ndarray, pole: np.ndarray) -> np.ndarray:
    """Second derivatives (m, 2, 3, 3): k'' (u . e_i) p p^T + k' (p e_i^T + e_i p^T)."""
    basis, t = _basis(pole), x @ pole
    rest = np.maximum(1 + t, _NEAREST)
    first = -_scale(t) / (2 * rest)
    second = -3 * first / (2 * rest)
    pairs = np.einsum("k,il->ikl", pole, basis)
    along = np.einsum("m,mi,k,l->mikl", second, x @ basis.T, pole, pole)
    return along + first[:, None, None, None] * (pairs + pairs.swapaxes(1, 2))
