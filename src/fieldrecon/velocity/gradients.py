"""Gradients at the vertices of a mesh from values at its cells, such as those of a pressure.

Each of the three methods is a callable that takes the sites about many vertices to the weights of
the data in the gradients.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from fieldrecon._core import validation as valid
from fieldrecon._numerics.weighted_least_squares import (
    estimable_weights,
    weights_of_changing_weights,
)
from fieldrecon.kernels.base import Radial
from fieldrecon.kernels.conditionally_positive_definite import thin_plate_spline
from fieldrecon.kernels.weights import as_weight, log_square_slope
from fieldrecon.meshes.simplex_mesh import SimplexMesh
from fieldrecon.polynomials import Frame, monomials, power_of_two_above
from fieldrecon.velocity.stencils import (
    LocalWeights,
    Stencils,
    ValuesOfWeights,
    amplification,
    as_vertices,
    fit_on_rings,
    number_that_count,
    weights_at,
)

# A site farther than this multiple of the median distance is ignored: the circumcentres of flat
# cells on the boundary may be anywhere.
_FAR = 10.0


def vertex_gradients(
    mesh: SimplexMesh,
    values: ArrayLike,
    method: LocalGradient | None = None,
    sites: ArrayLike | None = None,
    vertices: ArrayLike | None = None,
) -> np.ndarray:
    """Gradients at vertices from values at the cells.

    About each vertex a field is fitted to the values of the cells of one, two, ... rings, as many
    as determine an affine function, and differentiated at the vertex. Affine fields are reproduced
    exactly. In general the error falls like the size of the cells, and like its square where they
    lie symmetrically about the vertex.

    Parameters
    ----------
    mesh : SimplexMesh
        The mesh.
    values : (c, ...) array_like
        One value, or several, for each cell.
    method : optional
        `local_least_squares()`, the default, `local_moving_least_squares(weight)` or
        `local_rbf()`.
    sites : (c, d) array_like, optional
        Points to which the values belong; the circumcentres by default. For cell averages give
        `mesh.cell_centers`.
    vertices : (m,) array_like of int, optional
        Vertices; all points by default.

    Returns
    -------
    (m, ..., d) ndarray
        Gradient at each vertex, the derivative by each variable last.

    Raises
    ------
    ValueError
        If there is not a finite value for each cell.
    numpy.linalg.LinAlgError
        If all cells together do not determine an affine function; if a point belongs to no cell.

    References
    ----------
    Erleben, Field Reconstruction, p. 14-16.

    Examples
    --------
    >>> import fieldrecon as fr
    >>> mesh = fr.SimplexMesh.delaunay(fr.datasets.halton(50, 2))
    >>> pressure = mesh.circumcenters @ [3, 4]
    >>> vertex_gradients(mesh, pressure, fr.velocity.local_rbf(), vertices=[7]).round(9)
    array([[3., 4.]])
    """
    values = valid.as_values(values, len(mesh.cells), "values", "cell")
    vertices = as_vertices(mesh, vertices)
    d = mesh.points.shape[1]
    method = local_least_squares() if method is None else method
    if not isinstance(method, LocalGradient):
        raise ValueError(
            "method must be local_least_squares(), local_moving_least_squares(weight) or "
            f"local_rbf(); got {method!r}"
        )
    fit = _LocalGradients(mesh, method, _as_sites(mesh, sites))
    found = ValuesOfWeights(d, len(vertices), values.reshape(len(values), -1))
    fit_on_rings(mesh, None, vertices, fit, found, ("cells", "a gradient at it"))
    return found.values.reshape(len(vertices), *values.shape[1:], d)


@dataclass(frozen=True)
class local_least_squares:
    """Gradient of the affine least-squares fit to the cells about a vertex.

    References
    ----------
    Erleben, Field Reconstruction, p. 3-7 and 16.
    """

    weight: ClassVar[Radial | None] = None

    def __call__(self, stencils: CellStencils) -> np.ndarray:
        """Weights (m, d, k) of the data in the gradient."""
        return stencils.affine[:, 1:]


@dataclass(frozen=True)
class local_moving_least_squares:
    """Gradient of the affine moving least-squares fit to the cells about a vertex.

    The full derivative of that field, the derivative of the weights included.

    Parameters
    ----------
    weight : Radial
        Weight w(r) of a site at the distance r, such as `inverse_square(epsilon)`; it enters
        squared.

    References
    ----------
    Erleben, Field Reconstruction, p. 8-10 and 16.
    """

    weight: Radial

    def __post_init__(self) -> None:
        as_weight(self.weight)

    def __call__(self, stencils: CellStencils) -> np.ndarray:
        """Weights (m, d, k) of the data in the gradient."""
        b = monomials(stencils.y, 1)
        c = estimable_weights(b, stencils.w, b.shape[-1])
        change = weights_of_changing_weights(c, b, stencils.w, self._log_gradient(stencils))
        return c[:, 1:] + change.mT

    def _log_gradient(self, stencils: CellStencils) -> np.ndarray:
        """Gradient (m, k, d) of log w_i^2 by x."""
        length = stencils.length[:, None]
        r = np.linalg.norm(stencils.y, axis=2) * length
        slope = log_square_slope(self.weight.in_units(stencils.unit), r, stencils.w) * length**2
        return -slope[..., None] * stencils.y


@dataclass(frozen=True)
class local_rbf:
    """Gradient of radial functions with an affine part, fitted to the cells about a vertex.

    Circumcentres may be arbitrarily close, and coincide if cells share their circle, as do the
    two triangles of a rectangle. So the fit has a small smoothing, which has an effect only where
    sites are much closer than most: there their mean counts.

    Parameters
    ----------
    kernel : Radial
        A kernel without a length of its own, of order 2 at most: `thin_plate_spline()`, or
        `polyharmonic(3)`, the kernel of least energy in space.
    smoothing : float
        Added to the diagonal, for distances in units of a typical one, rounded up to a power of
        two. Zero interpolates, and refuses coincident sites.

    References
    ----------
    Erleben, Field Reconstruction, p. 11-13 and 16.
    """

    kernel: Radial = field(default_factory=thin_plate_spline)
    smoothing: float = 1e-4
    weight: ClassVar[Radial | None] = None

    def __post_init__(self) -> None:
        kernel = self.kernel
        if not (
            isinstance(kernel, Radial)
            and kernel.order <= 2
            and kernel.differentiable
            and kernel.in_units(2.0) == kernel
        ):
            raise ValueError(
                "kernel must be a smooth radial function without a length, of order 2 at most, "
                f"such as thin_plate_spline(); got {kernel!r}"
            )
        valid.as_length(self.smoothing, "smoothing", zero_allowed=True)

    def __call__(self, stencils: CellStencils) -> np.ndarray:
        """Weights (m, d, k) of the data in the gradient: H (g, mu) = (grad phi, grad b)."""
        y, there = stencils.y, stencils.w > 0
        m, k, d = y.shape
        squared = np.zeros((m, k, k))
        for axis in range(d):
            squared += (y[:, :, None, axis] - y[:, None, :, axis]) ** 2
        pairs = there[:, :, None] & there[:, None, :]
        if self.smoothing == 0 and np.count_nonzero(pairs & (squared == 0)) > there.sum():
            raise np.linalg.LinAlgError(
                "the sites of some cells coincide, so nothing interpolates them; give smoothing > 0"
            )
        h = np.zeros((m, k + d + 1, k + d + 1))
        h[:, :k, :k] = self.kernel.of_squared(squared) * pairs
        h[:, range(k), range(k)] += np.where(there, self.smoothing, 1.0)  # no site: weight zero
        h[:, :k, k:] = monomials(y, 1) * there[..., None]
        h[:, k:, :k] = h[:, :k, k:].mT
        rhs = np.zeros((m, k + d + 1, d))
        slope = self.kernel.slope_of_squared(np.einsum("mkd,mkd->mk", y, y))
        rhs[:, :k] = -(slope * there)[..., None] * y
        rhs[:, range(k + 1, k + d + 1), range(d)] = 1.0
        return np.linalg.solve(h, rhs)[:, :k].mT


LocalGradient = local_least_squares | local_moving_least_squares | local_rbf


@dataclass(frozen=True)
class CellStencils:
    """Sites about a batch of m vertices, in local units; they determine affine functions.

    Attributes
    ----------
    y : (m, k, d) ndarray
        Sites relative to the vertex.
    w : (m, k) ndarray
        Weights, the largest of each vertex one; zero where there is no site.
    affine : (m, d + 1, k) ndarray
        Weights of the data in value and gradient of the affine least-squares fit.
    length : (m,) ndarray
        Unit of y, a typical distance, in units of `unit`.
    unit : float
        Size of the mesh.
    """

    y: np.ndarray
    w: np.ndarray
    affine: np.ndarray
    length: np.ndarray
    unit: float


class _LocalGradients:
    """Fits of a method to the values of the cells about vertices."""

    def __init__(self, mesh: SimplexMesh, method: LocalGradient, sites: np.ndarray) -> None:
        self.mesh, self.method, self.sites = mesh, method, sites
        self.unit = Frame.around(mesh.points).scale

    def __call__(self, stencils: Stencils) -> LocalWeights:
        """Weights of the cells in the gradient at each vertex."""
        offset = self.sites[stencils.index] - self.mesh.points[stencils.vertices][:, None]
        w = weights_at(self.method.weight, self.unit, offset, stencils.there)
        distance, typical = _distances(offset, w > 0)
        counted = number_that_count(w)
        w = np.where(distance <= _FAR * typical[:, None], w, 0.0)
        length = power_of_two_above(np.where(np.isfinite(typical), typical, 1.0))
        y = offset / length[:, None, None] * (w > 0)[..., None]
        affine = estimable_weights(monomials(y, 1), (w > 0).astype(float), y.shape[2] + 1)
        size = amplification(affine[:, 1:])
        weights = np.full(affine[:, 1:].shape, np.nan)
        ok = np.flatnonzero(np.isfinite(size))
        batch = CellStencils(y[ok], w[ok], affine[ok], length[ok] / self.unit, self.unit)
        weights[ok] = self.method(batch) / length[ok, None, None]
        return LocalWeights(weights, size, counted)


def _as_sites(mesh: SimplexMesh, sites: ArrayLike | None) -> np.ndarray:
    if sites is None:
        return mesh.circumcenters
    p = valid.as_points(sites, "sites")
    wanted = (len(mesh.cells), mesh.points.shape[1])
    if p.shape != wanted:
        raise ValueError(f"sites must be one point for each cell, shape {wanted}; got {p.shape}")
    return p


def _distances(offset: np.ndarray, there: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances (m, k) of the sites, infinite for missing ones, and their medians (m,)."""
    distance = np.where(there, np.linalg.norm(offset, axis=2), np.inf)
    middle = np.maximum(np.count_nonzero(there, axis=1) - 1, 0) // 2
    typical = np.take_along_axis(np.sort(distance, axis=1), middle[:, None], axis=1)[:, 0]
    return distance, typical
