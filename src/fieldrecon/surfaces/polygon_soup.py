"""Implicit function of a polygon soup: moving least squares with weights integrated over polygons.

`PolygonSoup` is the function, `PolygonSoupSolid` the body that loose triangles of a file bound.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.spatial.distance import cdist

from fieldrecon._core import validation as valid
from fieldrecon._core.chunks import Progress, chunked, rows_of
from fieldrecon._core.geometry import triangle_normals
from fieldrecon.polynomials import power_of_two_above
from fieldrecon.reconstruction import DENSE_LIMIT_BYTES
from fieldrecon.solids.constructive import Solid
from fieldrecon.surfaces.triangle_integrals import over_segments, over_triangles

CELLS = 80
"""Default number of cells of the mesh along the longest side."""
_TOLERANCE = 1e-4
_MARGIN = 4.0  # of the box around the triangles, in edges or epsilons
LEAST_EPSILON = 1e-9
"""Smallest epsilon, relative to the size of the soup, that is distinguished from zero."""
_RULE_ERROR = 0.02
"""Relative error of the rules below, times the sixth power of the distance in diameters."""
_MAX_SWEEPS = 200
_SETTLED = 1e-3  # in epsilons
_MAX_IDLE, _PROGRESS = 5, 0.99  # sweeps without progress, and the ratio that is progress

_A, _B = (6 - 15**0.5) / 21, (6 + 15**0.5) / 21
_CORNERWISE = [*([c] * i + [1 - 2 * c] + [c] * (2 - i) for c in (_A, _B) for i in range(3))]
_LINE, _LINE_WEIGHTS = np.polynomial.legendre.leggauss(4)
_RULES = {
    2: (np.stack([1 - _LINE, 1 + _LINE], axis=1) / 2, _LINE_WEIGHTS / 2),
    3: (
        np.array([[1 / 3] * 3, *_CORNERWISE]),
        np.array([9 / 40, *[(155 - 15**0.5) / 1200] * 3, *[(155 + 15**0.5) / 1200] * 3]),
    ),
}
"""Barycentric nodes (q, d) and weights (q,): Gauss's rule for segments, Radon's for triangles."""


class PolygonSoup:
    """Implicit function of loose oriented segments (d = 2) or triangles (d = 3), positive inside.

        F(x) = sum_k A_k(x) S_k(x) / sum_k A_k(x),    A_k(x) = int_k dp / (|x - p|^2 + epsilon^2)^2,

    with the signed distance S_k(x) = o_k - n_k . (x - q_k) from the plane of polygon k. This is
    moving least squares of degree 0 with the points of all polygons as sites. A function for each
    polygon, in place of the value zero, keeps F from vanishing everywhere. The polygons need not
    share corners, may leave gaps, and may cross or repeat each other. Only their orientation must
    be right.

    With epsilon = 0 the zeros of F contain the polygons, and the gradient there is -n_k. A larger
    epsilon smooths away smaller details; `enclosing` moves the zeros outside the polygons.

    Parameters
    ----------
    points : (n, d) array_like
        Corners, in the plane or in space.
    polygons : (m, d) array_like of int
        Segments with the outside on the right, or triangles counter-clockwise when seen from
        outside. Degenerate ones are ignored. A convex polygon is a fan of triangles.
    epsilon : float
        Length below which details are smoothed.
    offsets : (m,) array_like, optional
        The outward displacement o_k of each polygon; zero by default.
    tol : float
        Relative error of each A_k. The integral is evaluated in closed form near a polygon, and by
        quadrature beyond a distance that depends on the tolerance.

    Raises
    ------
    ValueError
        If an argument has the wrong form, or all polygons are degenerate.

    References
    ----------
    Shen, O'Brien and Shewchuk, Interpolating and approximating implicit surfaces from polygon soup
    (2004); Erleben, Field Reconstruction, p. 8-10.

    Examples
    --------
    >>> square = PolygonSoup([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1], [1, 2], [2, 3], [3, 0]])
    >>> bool(square([0.5, 0.5]) > 0), bool(abs(square([0.3, 0.0])) < 1e-12)
    (True, True)
    >>> square.gradient([1.0, 0.4]).round(6) + 0.0
    array([-1.,  0.])
    """

    def __init__(
        self,
        points: ArrayLike,
        polygons: ArrayLike,
        epsilon: float = 0.0,
        offsets: ArrayLike | None = None,
        tol: float = 1e-6,
    ) -> None:
        self.points = valid.as_points(points)
        self.polygons = _as_polygons(polygons, self.points)
        self.epsilon = valid.as_length(epsilon, "epsilon", zero_allowed=True)
        self.tol = valid.as_length(tol, "tol")
        m, d = self.polygons.shape
        offsets = np.zeros(m) if offsets is None else offsets
        self.offsets = np.asarray(valid.as_values(offsets, m, "offsets", "polygon"), dtype=float)
        # in a unit of the soup's size no power of a distance leaves the range of numbers
        self._scale = float(power_of_two_above(np.ptp(self.points / 2, axis=0).max()))
        points = self.points / self._scale
        corners = points[self.polygons]
        normals = _normals(corners)
        extent = np.linalg.norm(normals, axis=1)
        kept = extent > 0
        if not kept.any():
            raise ValueError("polygons must not all be degenerate: none has a length or an area")
        self._kept, self._middle = kept, points.mean(axis=0)
        self._corners = corners[kept] - self._middle
        self._normals = normals[kept] / extent[kept, None]
        sides = self._corners - np.roll(self._corners, 1, axis=1)
        self._diameters = np.linalg.norm(sides, axis=2).max(axis=1)
        self._centers = self._corners.mean(axis=1)
        self._heights = np.einsum("md,md->m", self._normals, self._centers)
        self._heights += self.offsets[kept] / self._scale
        shape, weights = _RULES[d]
        self._nodes = np.einsum("qc,mcd->mqd", shape, self._corners)
        self._shares = (extent[kept] / (d - 1))[:, None] * weights
        self._reach = (_RULE_ERROR / self.tol) ** (1 / 6) * self._diameters
        self._epsilon = max(
            self.epsilon / self._scale, LEAST_EPSILON * np.ptp(points, axis=0).max()
        )

    def __call__(self, x: ArrayLike, *, progress: Progress | None = None) -> np.ndarray:
        """Values of F.

        Parameters
        ----------
        x : (..., d) array_like
        progress : callable, optional
            Called as progress(done, total) with numbers of points.

        Returns
        -------
        (...) ndarray
        """
        return self._scale * self._in_chunks(self._values, x, (), progress)

    def gradient(self, x: ArrayLike, *, progress: Progress | None = None) -> np.ndarray:
        """Gradients (..., d) of F."""
        d = self.points.shape[1]
        return self._in_chunks(self._gradients, x, (d,), progress)

    def weights(self, x: ArrayLike) -> np.ndarray:
        """Weights A_k / sum_j A_j of the polygons that are not degenerate at points, (m, k).

        Raises
        ------
        MemoryError
            If the matrix would exceed DENSE_LIMIT_BYTES.
        """
        k = len(self._normals)
        if 8 * k * (np.size(x) // self.points.shape[1]) > DENSE_LIMIT_BYTES:
            raise MemoryError(
                f"the weights of {k:,} polygons at {np.size(x) // self.points.shape[1]:,} points "
                f"would take more than {DENSE_LIMIT_BYTES / 2**30:.0f} GiB; take fewer polygons"
            )
        return self._in_chunks(self._weights, x, (k,), None).reshape(-1, k)

    def enclosing(self) -> PolygonSoup:
        """Return the soup with offsets such that F >= 0 at all corners, and near 0.

        In each sweep every polygon is displaced by the smallest F at its corners, and then all
        together by the smallest F that remains. The result is the sweep with the smallest mean F at
        the corners, since more sweeps make it worse if polygons contradict each other.
        """
        used = self.polygons[self._kept]
        own, index = np.unique(used, return_inverse=True)
        index = index.reshape(used.shape)
        weights = self.weights(self.points[own])
        x = self.points[own] / self._scale - self._middle
        offsets = self.offsets[self._kept] / self._scale
        base = np.einsum("vm,vm->v", weights, self._heights - offsets - x @ self._normals.T)
        best, least, idle = offsets, np.inf, 0
        for _ in range(_MAX_SWEEPS):
            values = base + weights @ offsets
            shifted, slack = offsets - values.min(), float((values - values.min()).mean())
            idle = 0 if slack < _PROGRESS * least else idle + 1
            if slack < least:
                best, least = shifted, slack
            if idle == _MAX_IDLE or least <= _SETTLED * self._epsilon:
                break
            offsets = offsets - values[index].min(axis=1)
        every = self.offsets.copy()
        every[self._kept] = self._scale * best
        return PolygonSoup(self.points, self.polygons, self.epsilon, every, self.tol)

    def _in_chunks(
        self,
        work: Callable[[np.ndarray], np.ndarray],
        x: ArrayLike,
        of: tuple[int, ...],
        progress: Progress | None,
    ) -> np.ndarray:
        d = self.points.shape[1]
        queries = valid.as_queries(x, d)
        flat = queries.reshape(-1, d) / self._scale - self._middle
        result = np.empty((len(flat), *of))
        rows = rows_of(8 * 4 * self._shares.size)
        for part, values in chunked(work, flat, rows, progress=progress):
            result[part] = values
        return result.reshape((*queries.shape[:-1], *of))[()]

    def _values(self, x: np.ndarray) -> np.ndarray:
        a, _ = self._integrals(x)
        return np.einsum("qm,qm->q", a, self._planes(x)) / a.sum(axis=1)

    def _weights(self, x: np.ndarray) -> np.ndarray:
        a, _ = self._integrals(x)
        return a / a.sum(axis=1, keepdims=True)

    def _gradients(self, x: np.ndarray) -> np.ndarray:
        a, near = self._integrals(x)
        total = a.sum(axis=1, keepdims=True)
        planes = self._planes(x)
        rest = planes - np.einsum("qm,qm->q", a, planes)[:, None] / total
        slope = self._far_slopes(x, rest, near) - a @ self._normals
        pairs = rest[near][:, None] * self._near_integrals(x, near)[1]
        rows = np.nonzero(near)[0]
        slope += (
            sparse.csr_array(
                (np.ones(len(rows)), (rows, np.arange(len(rows)))), shape=(len(x), len(rows))
            )
            @ pairs
        )
        return slope / total

    def _planes(self, x: np.ndarray) -> np.ndarray:
        """S_k (q, m)."""
        return self._heights - x @ self._normals.T

    def _integrals(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A_k (q, m), and a mask of those in closed form."""
        near = cdist(x, self._centers, "sqeuclidean") < self._reach**2
        squared = cdist(x, self._nodes.reshape(-1, x.shape[1]), "sqeuclidean") + self._epsilon**2
        weight = (self._shares.ravel() / squared**2).reshape(len(x), *self._shares.shape)
        a = weight.sum(axis=2)
        a[near] = self._near_integrals(x, near, slopes=False)[0]
        return a, near

    def _near_integrals(
        self, x: np.ndarray, near: np.ndarray, slopes: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        query, k = np.nonzero(near)
        closed = over_segments if x.shape[1] == 2 else over_triangles
        return closed(x[query], self._corners[k], self._normals[k], self._epsilon, slopes)

    def _far_slopes(self, x: np.ndarray, rest: np.ndarray, near: np.ndarray) -> np.ndarray:
        """Sum over the far polygons of the gradients of A_k, times the factors `rest` (q, m)."""
        nodes = self._nodes.reshape(-1, x.shape[1])
        squared = cdist(x, nodes, "sqeuclidean") + self._epsilon**2
        weight = (self._shares.ravel() / squared**3).reshape(len(x), *self._shares.shape)
        weight *= np.where(near, 0, -4 * rest)[..., None]
        weight = weight.reshape(len(x), -1)
        return weight.sum(axis=1, keepdims=True) * x - weight @ nodes


def _normals(corners: np.ndarray) -> np.ndarray:
    """Normals (m, d), as long as the segment, or twice the area of the triangle."""
    if corners.shape[2] == 2:
        along = corners[:, 1] - corners[:, 0]
        return np.stack([along[:, 1], -along[:, 0]], axis=1)
    return triangle_normals(*corners.swapaxes(0, 1))


def _as_polygons(polygons: ArrayLike, points: np.ndarray) -> np.ndarray:
    """Validate the indices (m, d) of corners."""
    n, d = points.shape
    if d not in _RULES:
        raise ValueError(f"points must lie in the plane or in space; got the shape {points.shape}")
    array = np.asarray(valid.unmasked(polygons, "polygons"))
    if array.ndim != 2 or array.shape[1] != d or array.dtype.kind not in "iu" or not len(array):
        raise ValueError(
            f"polygons must be indices of the shape (m, {d}), m at least 1; got {array.dtype} of "
            f"the shape {array.shape}"
        )
    if array.min() < 0 or array.max() >= n:
        raise ValueError(f"polygons must be indices of the {n} points")
    return array


class PolygonSoupSolid(Solid):
    """The body of a `PolygonSoup` of triangles; it encloses them if epsilon is positive.

    Parameters
    ----------
    points : (n, 3) ndarray
    triangles : (m, 3) ndarray of int
    epsilon : float
    spacing : float, optional
        Resolution of the surface, a length.

    Attributes
    ----------
    points : (k, 3) ndarray
        Points on the triangles, at most `spacing` apart.
    warnings : tuple of str
        Warnings about the triangles, in sentences.
    """

    spacing: float

    def __init__(
        self,
        points: np.ndarray,
        triangles: np.ndarray,
        epsilon: float,
        spacing: float | None = None,
    ) -> None:
        soup = PolygonSoup(points, triangles, epsilon, tol=_TOLERANCE)
        self.soup = soup.enclosing() if epsilon else soup
        corners = points[triangles]
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        self.spacing = float((high - low).max() / CELLS) if spacing is None else spacing
        self.points = self.near = points_on_triangles(corners, self.spacing)
        margin = _MARGIN * max(self.spacing, epsilon)
        self.box = np.array([low - margin, high + margin])
        where = f"around them, smoothed below {epsilon:.3g}" if epsilon else "through them"
        self.warnings = (f"The {len(triangles):,} triangles are loose; the surface goes {where}.",)

    def _values(self, x: np.ndarray) -> np.ndarray:
        return self.soup(x)

    def _gradients(self, x: np.ndarray) -> np.ndarray:
        return self.soup.gradient(x)


def points_on_triangles(corners: np.ndarray, spacing: float) -> np.ndarray:
    """Points (k, 3) on triangles (m, 3, 3), corners included, at most `spacing` apart.

    Examples
    --------
    >>> len(points_on_triangles(np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]]), 0.5))
    10
    """
    sides = corners - np.roll(corners, 1, axis=1)
    cuts = np.ceil(np.linalg.norm(sides, axis=2).max(axis=1) / spacing).astype(int)
    parts = []
    for n in np.unique(np.maximum(cuts, 1)):
        i, j = np.nonzero(np.add.outer(np.arange(n + 1), np.arange(n + 1)) <= n)
        shares = np.stack([n - i - j, i, j], axis=1) / n
        own = corners[np.maximum(cuts, 1) == n]
        parts.append(np.einsum("sc,mcd->msd", shares, own).reshape(-1, 3))
    return np.unique(np.concatenate(parts), axis=0)
